// The driver: one run in arrays that are made once, gone on with piece by piece.
// `functions`, `variations`, `quantities` and the kernels' names come from the translated text before.

function makeSolver(data) {
  const PIECE = 32; // attempts between two looks at the clock
  const [STEPS, REJECTED, FAILED, , , , SAMPLES, LOGGED, , FRESH, SMOOTH, , PASSED, STARTED] = data.places_of.count;
  const { H, LEVEL } = data.places_of.real;
  const { OK, FULL, STEP_LIMIT } = data.codes;
  const INTEGERS = ["modes", "flags", "fired", "group", "count", "alive"];

  const filled = (name, given) => {
    const kind = INTEGERS.includes(name) ? Int32Array : Float64Array;
    return typeof given === "number" ? new kind(given) : kind.from(given, Number); // a length, or values
  };
  const arrays = (table) => Object.fromEntries(Object.entries(table).map(([name, given]) => [name, filled(name, given)]));
  const rows = (count, width) => {
    const whole = new Float64Array(count * width);
    return Array.from({ length: count }, (_, i) => whole.subarray(i * width, (i + 1) * width));
  };
  const numbers = (table) => Object.fromEntries(Object.entries(table).map(([name, value]) => [name, Number(value)]));

  const o = numbers(data.options);
  const k = arrays(data.work);
  const start = arrays(data.trajectory);
  const x = arrays(data.trajectory);
  const y = arrays(data.tangents);
  const width = 1 + o.n_q + o.n + x.modes.length;
  x.samples = [];
  x.log = rows(data.log_rows, 3 + width);
  y.rows = [new Float64Array(y.logs.length + x.absolute.length + 4)];
  const firstTangents = arrays(data.tangents);
  const values = new Float64Array(data.quantities.length);
  let period = data.period;
  let began = 0; // turns until the tangents' sum began
  let turns = 0;
  let sum = 0;

  function refill(from, into) {
    Object.entries(from).forEach(([name, array]) => into[name].set(array));
  }

  function reset() {
    const kept = {};
    Object.entries(start).forEach(([name, array]) => {
      if (name !== "at") kept[name] = array;
    });
    refill(kept, x);
    refill(firstTangents, y);
    turns = 0;
    sum = 0;
  }

  // Begin anew at the state there is: contact modes are found again, steps begin small.
  function restart() {
    x.count[STARTED] = x.count[FRESH] = x.count[SMOOTH] = 0;
    x.fired.fill(0);
    x.modes.fill(0);
    x.real[H] = data.first_step * period;
  }

  function setState(state) {
    x.s.set(state, 1);
    restart();
    if (data.crank !== null && o.period > 0) {
      const beyond = ((x.s[1 + data.crank] - x.real[LEVEL]) * o.direction) / o.period;
      x.count[PASSED] = Math.max(0, Math.floor(beyond) + 1);
    }
    sum = y.logs[y.logs.length - 1];
    began = turns;
  }

  function drained(found) {
    for (let i = 0; i < x.count[LOGGED]; i += 1) {
      const row = x.log[i];
      if (row[0] === data.rows.event) {
        const joint = data.joints[row[1]];
        found.events.push({ time: row[3], joint: joint === undefined ? "" : joint, kind: data.events[row[2]] });
      } else if (row[0] === data.rows.section) found.section.push(row.slice(3));
      else if (row[0] === data.rows.doubt) found.doubts += 1;
    }
    x.count[LOGGED] = 0;
  }

  // Quantities of rows (time, state, modes): {name: {label: Float64Array}}.
  function measured(taken) {
    const found = { time: Float64Array.from(taken, (row) => row[0]) };
    const into = data.quantities.map(({ name, label }) => {
      found[name] = found[name] || {};
      found[name][label] = new Float64Array(taken.length);
      return found[name][label];
    });
    taken.forEach((row, i) => {
      quantities(row, x.p, values);
      into.forEach((array, at) => {
        array[i] = values[at];
      });
    });
    return found;
  }

  function run(length, { samples = 0, tangent = false, budget_ms = Infinity } = {}) {
    const found = { events: [], section: [], doubts: 0 };
    const from = x.s[0];
    if (x.samples.length !== samples) {
      x.samples = rows(samples, width);
      x.at = new Float64Array(samples);
    }
    for (let i = 0; i < samples; i += 1) x.at[i] = i + 1 < samples ? from + ((i + 1) / samples) * length * period : from + length * period;
    x.count[SAMPLES] = 0;
    o.t_end = from + length * period;
    const until = performance.now() + budget_ms;
    let code = STEP_LIMIT;
    while (code === STEP_LIMIT || code === FULL) {
      if (performance.now() > until) break;
      o.max_steps = x.count[STEPS] + x.count[REJECTED] + x.count[FAILED] + PIECE;
      code = tangent ? flow$run(functions, k, x, o, variations, y) : flow$run(functions, k, x, o, null, null);
      drained(found);
    }
    const done = (x.s[0] - from) / period;
    turns += done;
    const status = data.statuses[code === STEP_LIMIT || code === FULL ? OK : code];
    const exponent = { sum: y.logs[y.logs.length - 1] - sum, turns: turns - began };
    const taken = x.samples.slice(0, x.count[SAMPLES]);
    return { status: status.word, meaning: status.meaning, turns_done: done, ...measured(taken), ...found, exponent };
  }

  const state = () => x.s.slice(1, 1 + x.absolute.length);
  reset();
  return { run, reset, restart, state, setState, measured, time: () => x.s[0], period: () => period };
}

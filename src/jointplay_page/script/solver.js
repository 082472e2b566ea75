// The driver: one run in arrays that are made once, gone on with piece by piece.
// `functions`, `variations`, `tangentRows`, `quantities`, `closing` and the kernels' names come from the translated text before.

function makeSolver(data) {
  const FAR = 2; // clearances: further out, a motion begins at its start
  const LANES = 8;
  const PIECE = 32; // attempts between two looks at the clock
  const WITHIN = 8; // samples of a step, where a motion is looked at closely
  const [STEPS, REJECTED, FAILED, , , , SAMPLES, LOGGED, , BASE_SET, SMOOTH, , LEVELS_PASSED, STARTED] = data.places_of.count;
  const { H, LEVEL, GROWTH } = data.places_of.real;
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
  const asNumbers = (table) => Object.fromEntries(Object.entries(table).map(([name, value]) => [name, Number(value)]));

  const options = asNumbers(data.options);
  const work = arrays(data.work);
  const start = arrays(data.trajectory);
  const motion = arrays(data.trajectory);
  const begun = { ...data.tangents, w: LANES * tangentRows };
  const tangents = arrays(begun);
  const width = 1 + options.n_q + options.n + motion.modes.length;
  motion.samples = [];
  motion.log = rows(data.log_rows, 3 + width);
  tangents.rows = [new Float64Array(tangents.logs.length + motion.absolute.length + 4)];
  const firstTangents = arrays(begun);
  const values = new Float64Array(data.quantities.length);
  const loops = {}; // of the ideal mechanism: its start, its numbers, and what follows from them
  if (closing) {
    Object.assign(loops, arrays({ ideal_s: data.closing.ideal_s, ideal_p: data.closing.ideal_p, found: data.closing.outputs }));
  }
  let period = data.period;
  let turns = 0; // since the last change, from which the tangent's growth counts

  const parameters = data.parameters.map((each) => ({ ...each }));
  const set_to = parameters.map((each) => each.value);
  let last = null; // all that the last run's samples give

  // A number where parameter `number` alone has its present value; forms are those of script/sliders.py.
  function form(first, [number, kind, numbers]) {
    const ratio = set_to[number] / parameters[number].value;
    if (kind === "power") return first * ratio ** numbers[0];
    return numbers.reduceRight((total, c) => total * (ratio - 1) + c, 0);
  }

  function follow() {
    data.followed.forEach(({ array, at, value, rule, forms }) => {
      const first = Number(value);
      const added = parameters.map(() => 0);
      forms.forEach((each) => { added[each[0]] = form(first, each) - first; });
      const times = () => first * added.reduce((product, each) => product * (1 + each / first), 1);
      const plus = () => rule.reduce((sum, [factor, ...of]) => sum + of.reduce((product, i) => product * added[i], factor), added.reduce((a, b) => a + b, first));
      const now = rule === "times" ? times() : plus();
      if (array === "span") period = now;
      else if (array === "weight") tangents.weight[at] = firstTangents.weight[at] = now;
      else if (array in options) options[array] = now;
      else if (array in loops) loops[array][at] = now;
      else {
        start[array][at] = now;
        if (array !== "s") motion[array][at] = now;
      }
    });
    start.real[H] = data.first_step * period;
    if (start.real[GROWTH] > 0) start.real[GROWTH] = motion.real[GROWTH] = 1 / period;
    return !closing || closes();
  }

  // Where the motion begins, by the ideal mechanism's outputs; false where its loops do not close over the turn.
  function closes() {
    const { swept, step, turn } = data.closing;
    const row = Float64Array.from(loops.ideal_s);
    for (let i = 0; i < turn; i += 1, row[swept] += step) {
      closing(row, loops.ideal_p, loops.found);
      if (i === 0) data.closing.places.forEach(([at, whole], n) => { start.s[at] = loops.found[n] + whole; });
      if (!loops.found.every(Number.isFinite)) return false;
    }
    return true;
  }

  // Empty, or why a value is refused. The motion goes on from where it is, if no journal is far out then.
  function set(key, value) {
    const number = parameters.findIndex((each) => each.key === key);
    if (number < 0) return `there is no slider ${key}`;
    const { min, max, label, unit, factor } = parameters[number];
    if (!(value >= min && value <= max)) {
      const told = (each) => Number((each * factor).toPrecision(4));
      return `${label}: from ${told(min)} to ${told(max)}${unit && ` ${unit}`} is accepted`;
    }
    const before = set_to[number];
    set_to[number] = value;
    if (!follow()) {
      set_to[number] = before;
      follow();
      return `${label}: with the other lengths as they are, the links do not close over the whole turn`;
    }
    if (outside()) reset();
    else restart();
    return "";
  }

  // A place along a link: where it was, unless it is the end of a link whose length has changed.
  function along(link, at) {
    const number = parameters.findIndex((each) => each.key === `length.${link}`);
    return number >= 0 && at === parameters[number].value ? set_to[number] : at;
  }

  // Whether a journal is so far out that a force on it would be absurd.
  function outside() {
    quantities(Float64Array.of(...motion.s.subarray(0, 1 + motion.absolute.length), ...motion.modes), motion.p, values);
    return data.quantities.some(({ name }, i) => name === "eccentricity_ratio" && !(values[i] < FAR));
  }

  // Least squares: the x for which A x comes nearest to b (the normal equations, by Gauss and Jordan).
  function solved(A, b, n) {
    const M = Array.from({ length: n }, (_, i) => {
      const row = new Float64Array(n + 1);
      A.forEach((each, r) => {
        for (let j = 0; j < n; j += 1) row[j] += each[i] * each[j];
        row[n] += each[i] * b[r];
      });
      return row;
    });
    for (let i = 0; i < n; i += 1) {
      const top = M.reduce((best, row, r) => (r > i && Math.abs(row[i]) > Math.abs(M[best][i]) ? r : best), i);
      [M[i], M[top]] = [M[top], M[i]];
      const pivot = M[i].map((each) => each / M[i][i]);
      M[i] = pivot;
      M.forEach((row, r) => {
        if (r !== i) M[r] = row.map((each, j) => each - row[i] * pivot[j]);
      });
    }
    return M.map((row) => row[n]);
  }

  // Where links are at a sample of the last run: {link: [x, y, angle]}, as mechanism/positions.py has it.
  function places(sample) {
    const angle = (pin) => (pin.link in last.angle ? last.angle[pin.link][sample] : 0);
    const n = 2 * data.links.length;
    const [A, b] = [[], []];
    data.linkage.forEach((joint) => {
      const lines = [new Float64Array(n), new Float64Array(n)];
      const known = [0, 0];
      [[joint.journal, 1], [joint.bearing, -1]].forEach(([pin, sign]) => {
        const at = data.links.indexOf(pin.link);
        known[0] += sign * (at < 0 ? pin.point[0] : along(pin.link, pin.at) * Math.cos(angle(pin)));
        known[1] += sign * (at < 0 ? pin.point[1] : along(pin.link, pin.at) * Math.sin(angle(pin)));
        if (at >= 0) [0, 1].forEach((axis) => { lines[axis][2 * at + axis] += sign; });
      });
      const of = (name, label) => (last[name] && last[name][label] ? last[name][label][sample] : undefined);
      if (!joint.prismatic) {
        ["journal_x", "journal_y"].forEach((name, axis) => {
          A.push(lines[axis]);
          b.push((of(name, joint.name) || 0) - known[axis]);
        });
        return;
      }
      const turned = joint.bearing.direction + angle(joint.bearing);
      const [c, s] = [Math.cos(turned), Math.sin(turned)];
      const slide = of("slide_position", joint.label) ?? of("slide_position", joint.name);
      const put = (a, d, wanted) => {
        A.push(lines[0].map((each, j) => a * each + d * lines[1][j]));
        b.push(wanted - a * known[0] - d * known[1]);
      };
      if (slide !== undefined) put(c, s, slide);
      if (slide === undefined || joint.ideal) put(-s, c, 0);
    });
    const found = solved(A, b, n);
    return Object.fromEntries(data.links.map((name, i) => [name, [found[2 * i], found[2 * i + 1], last.angle[name][sample]]]));
  }

  function refill(from, into) {
    Object.entries(from).forEach(([name, array]) => into[name].set(array));
  }

  function reset() {
    const kept = {};
    Object.entries(start).forEach(([name, array]) => {
      if (name !== "sample_times") kept[name] = array;
    });
    refill(kept, motion);
    refill(firstTangents, tangents);
    turns = 0;
  }

  // Begin anew at the state there is: contact modes are found again, steps begin small.
  function restart() {
    motion.count[STARTED] = motion.count[BASE_SET] = motion.count[SMOOTH] = 0;
    motion.fired.fill(0);
    motion.modes.fill(0);
    motion.real[H] = data.first_step * period;
    refill(firstTangents, tangents);
    turns = 0;
  }

  function setState(state) {
    motion.s.set(state, 1);
    restart();
    if (data.crank !== null && options.period > 0) {
      const beyond = ((motion.s[1 + data.crank] - motion.real[LEVEL]) * options.direction) / options.period;
      motion.count[LEVELS_PASSED] = Math.max(0, Math.floor(beyond) + 1);
    }
  }

  function drained(found) {
    for (let i = 0; i < motion.count[LOGGED]; i += 1) {
      const row = motion.log[i];
      if (row[0] === data.rows.step) found.steps.push(row.slice(3));
      else if (row[0] === data.rows.event) {
        const joint = data.joints[row[1]];
        found.events.push({ time: row[3], joint: joint === undefined ? "" : joint, kind: data.events[row[2]] });
        if (options.log_steps) found.before.push(row.slice(3));
      } else if (row[0] === data.rows.section) found.section.push(row.slice(3));
      else if (row[0] === data.rows.coarse) found.doubts += 1;
    }
    motion.count[LOGGED] = 0;
  }

  // Quantities of rows (time, state, modes): {name: {label: Float64Array}}.
  function evaluated(taken) {
    const found = { time: Float64Array.from(taken, (row) => row[0]) };
    const into = data.quantities.map(({ name, label }) => {
      found[name] = found[name] || {};
      found[name][label] = new Float64Array(taken.length);
      return found[name][label];
    });
    taken.forEach((row, i) => {
      quantities(row, motion.p, values);
      into.forEach((array, at) => {
        array[i] = values[at];
      });
    });
    return found;
  }

  const shown = new Set(["time", ...data.quantities.filter((each) => each.shown).map((each) => each.name)]);
  const onlyShown = (found) => Object.fromEntries(Object.entries(found).filter(([name]) => shown.has(name)));
  const measured = (taken) => onlyShown(evaluated(taken));

  // Largest force of each joint, and largest speed with which contact begins there, over the points of a run. Between
  // samples without an event among them a parabola goes on.
  function largest({ steps, before, events }, taken) {
    const [among, own] = [taken, [...steps, ...before]].map(evaluated);
    const sizes = (all, label) => (all.reaction && label in all.reaction ? all.reaction[label] : all.normal_force[label].map((each, i) => Math.hypot(each, across(all, label)[i] || 0)));
    const across = (all, label) => (all.tangential_force && all.tangential_force[label]) || [];
    const between = (i) => events.some(({ time }) => time >= among.time[i - 1] && time <= among.time[i + 1]);
    const top = (y) => y.reduce((most, here, i) => {
      const [rise, fall] = [i - 1, i + 1].map((k) => (y[k] - here) / (among.time[k] - among.time[i])); // slopes
      const bend = (rise - fall) / (among.time[i + 1] - among.time[i - 1]);
      const slope = rise + bend * (among.time[i - 1] - among.time[i]);
      const risen = bend > 0 && rise >= 0 && fall <= 0 ? here + slope ** 2 / (4 * bend) : here;
      return risen > most ? Math.max(most, risen === here || between(i) ? here : risen) : most;
    }, 0);
    const most = (series) => series.reduce((found, each) => Math.max(found, Math.abs(each) || 0), 0);
    const labels = [among.normal_force, among.reaction].flatMap((table) => Object.keys(table || {}));
    const force = labels.map((label) => [label, Math.max(top(sizes(among, label)), most(sizes(own, label)))]);
    const hits = events.map(({ joint, kind }) => (kind === "contact" || kind === "impact" ? joint : ""));
    const speeds = Object.entries(evaluated(before).normal_velocity || {});
    const speed = speeds.map(([label, series]) => [label, most(series.filter((_, i) => hits[i] === label))]);
    return { largest: { force: Object.fromEntries(force), speed: Object.fromEntries(speed) } };
  }

  // Sample the step that comes, and as much more as the next ones may be shorter; where it is in fact short, as the one
  // before was, more finely.
  function ahead(before) {
    const apart = Math.min(motion.real[H], Math.max(2 * before, motion.real[H] / WITHIN)) / WITHIN;
    motion.sample_times.forEach((_, i, times) => { times[i] = motion.s[0] + (i + 1) * apart; });
    motion.count[SAMPLES] = 0;
  }

  // `samples` are even ones; without any, `closely` takes some within each step.
  function run(length, { samples = 0, closely = false, tangent = false, extremes = false, budget_ms = Infinity } = {}) {
    const found = { events: [], section: [], steps: [], before: [], doubts: 0 };
    options.log_steps = Number(extremes);
    const from = motion.s[0];
    const count = closely ? WITHIN * WITHIN : samples;
    if (motion.samples.length !== count) {
      motion.samples = rows(count, width);
      motion.sample_times = new Float64Array(count);
    }
    for (let i = 0; i < samples; i += 1) motion.sample_times[i] = i + 1 < samples ? from + ((i + 1) / samples) * length * period : from + length * period;
    motion.count[SAMPLES] = 0;
    options.t_end = from + length * period;
    const until = performance.now() + budget_ms;
    const taken = [];
    let code = STEP_LIMIT;
    let passed = Infinity; // in the last step
    while (code === STEP_LIMIT || code === FULL) {
      if (performance.now() > until) break;
      const at = motion.s[0];
      if (closely) ahead(passed);
      options.max_steps = motion.count[STEPS] + motion.count[REJECTED] + motion.count[FAILED] + (closely ? 1 : PIECE);
      code = flow$run(functions, work, motion, options, variations, tangent ? tangents : null);
      drained(found);
      if (closely) taken.push(...motion.samples.slice(0, motion.count[SAMPLES]).map((row) => row.slice()));
      passed = motion.s[0] - at || passed;
    }
    const done = (motion.s[0] - from) / period;
    turns += done;
    const status = data.statuses[code === STEP_LIMIT || code === FULL ? OK : code];
    const exponent = { sum: tangents.logs[tangents.logs.length - 1], turns }; // -Infinity where sticking took the direction away
    if (!closely) taken.push(...motion.samples.slice(0, motion.count[SAMPLES]));
    last = evaluated(taken);
    const { events, section, doubts } = found;
    const rest = { events, section, doubts, exponent, ...(extremes && largest(found, taken)) };
    return { status: status.word, meaning: status.meaning, turns_done: done, ...onlyShown(last), ...rest };
  }

  const state = () => motion.s.slice(1, 1 + motion.absolute.length);
  reset();
  return { parameters, set, along, run, reset, state, setState, measured, places, time: () => motion.s[0], period: () => period };
}

"use strict";
// A solver of a known motion: an ideal four-bar that turns evenly, its journal on a ray whose length follows the
// logistic map s -> a s (1 - s) from turn to turn, a being "gear_ratio". Exponent ln|a (1 - 2 s)| a turn. Its largest
// force is 200 s N, or 100 N without clearance, and contact begins at 100 s times the clearance a second.

function makeSolver(data) {
  const values = {};
  const [crank, coupler, rocker, base] = data.lengths;
  let [time, s, sum, lost] = [0, data.start, 0, false];

  function places(theta) {
    const [ax, ay] = [crank * Math.cos(theta), crank * Math.sin(theta)];
    const [dx, dy] = [base - ax, -ay];
    const gap = Math.hypot(dx, dy);
    const along = (gap * gap + coupler * coupler - rocker * rocker) / (2 * gap);
    const across = Math.sqrt(coupler * coupler - along * along);
    const [bx, by] = [ax + (along * dx - across * dy) / gap, ay + (along * dy + across * dx) / gap];
    return { crank: [0, 0, theta], coupler: [ax, ay, Math.atan2(by - ay, bx - ax)], rocker: [base, 0, Math.atan2(by, bx - base)] };
  }

  const solver = {
    parameters: data.parameters.map((each) => ({ ...each })),
    set(key, value) {
      const known = solver.parameters.find((each) => each.key === key);
      if (!known) return `there is no ${key}`;
      if (!(value >= known.min && value <= known.max)) return `a value from ${known.min} to ${known.max} is accepted`;
      values[key] = value;
      return "";
    },
    along: (link, at) => at,
    reset() { [time, s, sum, lost] = [0, data.start, 0, false]; },
    period: () => data.period,
    time: () => time,
    measured: (rows) => ({ journal_x: { B: rows.map((row) => row[1]) }, journal_y: { B: rows.map((row) => row[2]) } }),
    state: () => Float64Array.of(s),
    setState([given]) { s = given; },
    run(turns, { samples }) {
      const count = samples || 0;
      lost = lost || values["damping.B"] > 500; // and stays so until it begins anew
      const found = { status: lost ? "not_converged" : "ok", turns_done: turns, section: [], events: [] };
      found.time = Float64Array.from({ length: count }, (_, i) => time + (turns * data.period * (i + 1)) / samples);
      const e = values["clearance.B"];
      const of = (f) => ({ B: found.time.map((t) => f((2 * Math.PI * t) / data.period)) });
      found.journal_x = of((theta) => e * s * Math.cos(theta));
      found.journal_y = of((theta) => e * s * Math.sin(theta));
      found.normal_force = of((theta) => 100 * s * (1 + Math.cos(theta)));
      found.reaction = of((theta) => 50 * (1 + Math.cos(theta)));
      const shown = Array.from(found.time, (t) => places(((2 * Math.PI * t) / data.period) % (2 * Math.PI)));
      solver.places = (at) => shown[at];
      for (let turn = 0; turn < turns; turn += 1) {
        found.events.push({ time: time + data.period * (turn + 0.25), joint: "B", kind: "separation" });
        sum += Math.log(Math.abs(values.gear_ratio * (1 - 2 * s)));
        s = values.gear_ratio * s * (1 - s);
        found.section.push([time + data.period * (turn + 1), e * s, 0]);
      }
      time += turns * data.period;
      found.largest = e === undefined ? { force: { B: 100 }, speed: {} } : { force: { B: 200 * s }, speed: { B: 100 * e * s } };
      found.exponent = { sum, turns: time / data.period };
      return found;
    },
  };
  solver.parameters.forEach((each) => { values[each.key] = each.value; });
  return solver;
}

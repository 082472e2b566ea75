"use strict";
// The motion of the selected point of a sweep, computed here: of each bearing the force and the journal's path.

if (jointplay.data.live && jointplay.data.cells) {
  const { data, element, numbers } = jointplay;
  const { live, cells } = data;
  const TURNS = 4; // that are drawn
  const SAMPLES = 720; // of each
  const TRANSIENT = 100; // turns dropped where the result has no state to begin in
  const ends = cells.ends ? numbers(cells.ends) : [];
  const order = cells.ends ? live.solver.state.map((name) => cells.ends.names.indexOf(name)) : [];
  const known = order.length > 0 && order.every((at) => at >= 0);
  let worker = null;
  let busy = false;
  let waiting = null; // what is to be computed next
  let shown = null;

  // The state in which a motion ended, in the solver's order; null where the result has none.
  function state(flat) {
    const found = order.map((at) => ends[flat * order.length + at]);
    return known && found.every(Number.isFinite) ? found : null;
  }

  // `values` by the names of parameters; `flats`, the places of the ways of this point; their colours.
  function show(values, flats, colours) {
    const missing = Object.keys(values).filter((name) => !live.varied[name]);
    if (missing.length) {
      say(`The motion is not computed here: there is no slider for ${missing.join(", ")}.`);
      return;
    }
    const asked = Object.fromEntries(Object.entries(values).map(([name, value]) => [live.varied[name], value]));
    waiting = { values: asked, states: flats.map(state), colours };
    next();
  }

  function next() {
    if (busy || !waiting) return;
    worker = worker || jointplay.worker(answered);
    [shown, waiting, busy] = [waiting, null, true];
    say("The motion is being computed.");
    const wanted = live.views.flatMap((view) => [...view.orbit, view.force]);
    const size = { turns: TURNS, samples: SAMPLES * TURNS, transient: TRANSIENT };
    worker.postMessage({ what: "point", values: shown.values, states: shown.states, wanted, ...size });
  }

  function answered(answer) {
    if (answer.what === "begin") return;
    busy = false;
    if (answer.what === "trouble") say(`The solver in this page cannot go on: ${answer.words}`);
    else if (answer.why) say(`The motion is not computed here. ${answer.why}.`);
    else {
      shown.motions = answer.motions;
      draw();
      const troubles = answer.motions.map((each) => each.status).filter(Boolean);
      const begun = shown.states.every(Boolean) ? "from the state in which the stored motion ended" : `from the mechanism's start, after ${TRANSIENT} turns`;
      say(troubles.length ? `It ended early: ${troubles.join("; ")}.` : `${TURNS} turns, computed here, ${begun}.`);
    }
    next();
  }

  function say(words) {
    element("point-said").textContent = words;
  }

  function draw() {
    if (!shown || !shown.motions) return;
    live.views.forEach((view, number) => {
      const of = (part) => shown.motions.map((each) => each.values[3 * number + part]);
      history(element(`point-force${number}`), view, of(2));
      path(element(`point-orbit${number}`), view, of(0), of(1));
    });
  }

  function history(canvas, view, forces) {
    const y = plots.span(forces.flatMap((each) => [...each]));
    const chart = plots.chart(canvas, { x: [0, TURNS], y, xLabel: "Turns", yLabel: view.words[2] });
    forces.forEach((each, way) => plots.line(chart, shown.motions[way].time, each, shown.colours[way]));
  }

  // In a bearing both ways to one scale, with the clearance circle.
  function path(canvas, view, xs, ys) {
    const clearance = view.circle ? shown.values[view.clearance] || view.circle : 1;
    const scaled = (all) => all.map((each) => each.map((value) => value / clearance));
    const [x, y] = [scaled(xs), scaled(ys)];
    const flat = (all) => all.flatMap((each) => [...each]);
    const [xLabel, yLabel] = view.section.words;
    if (!view.circle) {
      const chart = plots.chart(canvas, { x: plots.span(flat(x)), y: plots.span(flat(y)), xLabel, yLabel });
      x.forEach((each, way) => plots.line(chart, each, y[way], shown.colours[way]));
      return;
    }
    const reach = 1.08 * [...flat(x), ...flat(y)].reduce((most, each) => Math.max(most, Math.abs(each)), 1);
    const chart = plots.chart(canvas, { x: [-reach, reach], y: [-reach, reach], xLabel, yLabel, aspect: plots.square(canvas) });
    const round = Array.from({ length: 181 }, (_, i) => (i * Math.PI) / 90);
    plots.line(chart, round.map(Math.cos), round.map(Math.sin), "--faint", 1);
    x.forEach((each, way) => plots.line(chart, each, y[way], shown.colours[way]));
  }

  addEventListener("resize", draw);
  jointplay.point = { show, motions: () => shown && shown.motions };
  jointplay.parts.push({ show: draw });
}

"use strict";
// Pictures of the turn that is shown, beside those of stage.js, and the pace at which it is played.

const pictures = (() => {
  const SECONDS = 3; // a turn takes, as it is played
  const SLOW = 40; // times slower near an impact
  const HITS = ["contact", "impact", "separation"];
  const NEAR = 0.004; // turns before and after an impact that count as near

  function plane(now, view, at) {
    const [x, y] = now.values;
    const chart = plots.chart(document.getElementById("live-orbit"), { x: plots.span(x), y: plots.span(y), xLabel: view.words[0], yLabel: view.words[1] });
    plots.line(chart, x, y, "--accent");
    plots.dots(chart, [x[at]], [y[at]], 1, "--warm", 8);
  }

  function force(now, view, at, ideal) {
    const beside = ideal && ideal.values && ideal.view === view && ideal.values[0]; // without clearance
    const y = plots.span([...now.force, ...(beside || [])]);
    const chart = plots.chart(document.getElementById("live-force"), { x: [0, 1], y, xLabel: "Turns", yLabel: view.words[2] });
    if (beside) plots.line(chart, ideal.time, beside, "--warm");
    plots.line(chart, now.time, now.force, "--accent");
    plots.upright(chart, now.time[at], "--ink");
  }

  function section(points, view, least) {
    const [x, y] = [0, 1].map((k) => points.map((each) => each[k]));
    const [xLabel, yLabel] = view.section.words;
    const chart = plots.chart(document.getElementById("live-section"), { x: plots.span(x, least), y: plots.span(y, least), xLabel, yLabel });
    plots.dots(chart, x, y, x.length, "--accent", x.length > 500 ? 1.5 : 3);
  }

  // Where in the turn it is after some seconds: slower near its impacts, if that is asked for.
  function after(phase, seconds, events, slowly) {
    const hits = slowly ? events.filter((each) => HITS.includes(each.kind)) : [];
    const near = hits.map((each) => [each.turn - NEAR, each.turn + NEAR]);
    let [at, left] = [phase, seconds / SECONDS];
    while (left > 0 && at < 1) {
      const inside = near.find(([from, to]) => at >= from && at < to);
      const end = inside ? inside[1] : Math.min(1, ...near.map(([from]) => from).filter((from) => from > at));
      const rate = inside ? 1 / SLOW : 1;
      const step = Math.min(left * rate, end - at);
      left = step < end - at ? 0 : left - step / rate;
      at = step < end - at ? at + step : end;
    }
    return at + left;
  }

  return { after, force, plane, section };
})();

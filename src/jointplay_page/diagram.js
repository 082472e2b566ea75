"use strict";
// What the page computes over one slider, its section points, or over two, a map of periods: in workers. A click
// leads the sliders there, what a drag encloses is computed finer.

if (jointplay.data.live) {
  const { element, store } = jointplay;
  const KEPT = 64; // turns of each value that are drawn
  const MOST = 40000; // cells of a map
  const STRETCHES = 8; // of a diagram, each begun anew: however many workers there are, the points are the same
  const PACE = 250; // ms between two pictures of what is being computed
  const PERIODS = ["#7f7f7f", "#0072b2", "#56b4e9", "#f0d84a", "#5b0f4f"]; // those beyond 4 have the last colour
  const LOST = "#000000";
  const GRADES = ["#2ca02c26", "#f0d84a40", "#e6790040", "#c0202040"]; // of the ground behind curves, over any theme
  const SAMPLES = 1024; // of a turn in which largest forces are looked for
  const AXES = ["", "-second"]; // ends of the fields' names
  let tools = null; // of the live page: its parameters, values and solvers
  let parameters = [];
  let running = [];
  let rows = [];
  let asked = null; // what is drawn: axes with key and ends, numbers of values and turns
  let chart = null;
  let drag = null;
  let waiting = false;

  const field = (name, end = "") => element(`scan-${name}${end}`);
  const known = (key) => parameters.find((each) => each.key === key);
  const isMap = () => asked.axes.length > 1;

  function values({ key, from, to }, count) {
    return Array.from({ length: count }, (_, i) => {
      const share = count > 1 ? i / (count - 1) : 0;
      return known(key).scale === "log" ? from * (to / from) ** share : from + (to - from) * share;
    });
  }

  function axisOf(end) {
    const chosen = known(field("key", end).value);
    if (!chosen) return null;
    const typed = ["from", "to"].map((name) => Number(field(name, end).value) / chosen.factor);
    const [from, to] = typed.sort((a, b) => a - b).map((each) => Math.min(chosen.max, Math.max(chosen.min, each)));
    return { key: chosen.key, from, to };
  }

  function read() {
    const axes = AXES.map(axisOf).filter(Boolean);
    const [count, transient] = ["count", "transient"].map((name) => Math.round(Number(field(name).value)) || 0);
    const most = axes.length > 1 ? Math.sqrt(MOST) : 1000;
    return { axes, count: Math.max(2, Math.min(most, count)), transient: Math.max(0, Math.min(5000, transient)) };
  }

  function write({ axes, count, transient }) {
    AXES.forEach((end, i) => {
      const given = axes[i];
      const chosen = given && known(given.key);
      field("key", end).value = given ? given.key : "";
      ["from", "to"].forEach((name) => {
        field(name, end).value = given ? Number((given[name] * chosen.factor).toPrecision(6)) : "";
        field(name, end).disabled = !given;
      });
      field("unit", end).textContent = given ? chosen.unit : "";
    });
    field("count").value = count;
    field("transient").value = transient;
  }

  // ---- workers

  function stop(words) {
    running.forEach((worker) => worker.terminate());
    running = [];
    field("stop").disabled = true;
    field("said").textContent = words;
  }

  function run() {
    stop("");
    const wanted = read();
    if (wanted.axes.some(({ from, to }) => !(to > from)) || (wanted.axes[1] && wanted.axes[0].key === wanted.axes[1].key)) {
      stop("Ranges of different sliders from a smaller to a larger value, within their bounds, are accepted.");
      return;
    }
    asked = wanted;
    write(asked);
    store("scan", [asked.count, asked.transient, ...asked.axes.flatMap(({ key, from, to }) => [key, from, to])].join(" "));
    rows = [];
    const began = performance.now();
    const left = shares();
    const all = left.reduce((sum, { list }) => sum + list.length, 0);
    const [key, across] = [asked.axes[0].key, isMap() ? asked.axes[1].key : null];
    const task = { what: "scan", values: { ...tools.held }, key, across, transient: asked.transient, kept: KEPT, samples: SAMPLES };
    const next = (worker) => { if (left.length) worker.postMessage({ ...task, ...left.shift() }); };
    running = Array.from({ length: Math.min(4, navigator.hardwareConcurrency || 2, left.length) }, () => {
      const worker = tools.solver((answer) => (answer.what === "scan" ? next(worker) : answered(answer, all, began)));
      return worker;
    });
    running.forEach(next);
    field("stop").disabled = false;
    draw();
  }

  // What a worker takes at a time: a line of a map, a stretch of a diagram.
  function shares() {
    const list = values(asked.axes[0], asked.count);
    if (isMap()) return values(asked.axes[1], asked.count).map((line) => ({ list, line }));
    const size = Math.ceil(list.length / STRETCHES);
    return Array.from({ length: Math.ceil(list.length / size) }, (_, i) => ({ list: list.slice(i * size, (i + 1) * size), line: null }));
  }

  function answered(answer, all, began) {
    if (answer.what === "trouble") stop(`Stopped: ${answer.words}`);
    if (answer.what !== "row") return;
    rows.push(answer.row);
    field("progress").value = rows.length / all;
    const lost = rows.filter((each) => each.status);
    const words = [...new Set(lost.map((each) => each.status))].slice(0, 3).join("; ");
    const said = `${rows.length} of ${all} values, ${((performance.now() - began) / 1000).toFixed(1)} s${lost.length ? `; ${lost.length} ended early (${words})` : ""}`;
    field("said").textContent = said;
    if (rows.length === all) {
      stop(said);
      draw();
      return;
    }
    if (!waiting) setTimeout(draw, PACE);
    waiting = true;
  }

  // ---- pictures

  function axis(k) {
    const { key, from, to } = asked.axes[k];
    const { factor, label, unit, scale } = known(key);
    return { ends: [from * factor, to * factor], label: unit ? `${label} (${unit})` : label, log: scale === "log", factor };
  }

  function draw() {
    waiting = false;
    field("figure").hidden = !asked;
    if (!asked) return;
    legend();
    const x = axis(0);
    if (isMap()) drawMap(x, axis(1));
    else drawPoints(x);
    plots.upright(chart, tools.held[asked.axes[0].key] * x.factor, "--warm");
    if (drag) {
      chart.pen.strokeStyle = stage.colour("--ink");
      const [top, bottom] = isMap() ? [drag.from[1], drag.to[1]] : [chart.top, chart.bottom];
      chart.pen.strokeRect(drag.from[0], top, drag.to[0] - drag.from[0], bottom - top);
    }
  }

  function drawPoints(x) {
    const [xs, ys] = [[], []];
    rows.forEach((row) => tools.placed(row).forEach((point) => {
      xs.push(row.value * x.factor);
      ys.push(point[0]);
    }));
    chart = plots.chart(field("canvas"), { x: x.ends, y: plots.span(ys), log: x.log, aspect: Math.max(0.45, 220 / field("canvas").clientWidth), xLabel: x.label, yLabel: tools.view().section.words[0] });
    plots.dots(chart, xs, ys, xs.length, "--accent", 1.5);
    drawHardness(x);
  }

  // What a row says of the joint that is looked at, or of all; and its grade.
  function hardness(row) {
    const joint = tools.view().circle && tools.view().name;
    const of = (table) => (table ? table[joint] ?? Math.max(...Object.values(table)) : NaN);
    const merged = (name) => row.largest.reduce((found, each) => {
      Object.entries(each[name]).forEach(([key, value]) => { found[key] = Math.max(found[key] || 0, value); });
      return found;
    }, {});
    const [force, speed] = [merged("force"), merged("speed")];
    const separations = Object.fromEntries(row.apart.map((each) => [each, 1]));
    const { grade } = verdict.graded({ separations, force, speed, ideal: row.ideal }, tools.limits);
    return { force: of(force), ideal: of(row.ideal), speed: 1e3 * of(speed), grade };
  }

  // Largest force and impact speed over the slider, the grade behind them.
  function drawHardness(x) {
    const done = rows.filter((row) => row.largest).sort((a, b) => a.value - b.value);
    const found = done.map(hardness);
    field("hardness").hidden = !found.some((each) => Number.isFinite(each.force));
    if (field("hardness").hidden) return;
    const xs = done.map((row) => row.value * x.factor);
    const joint = tools.view().circle ? ` at ${tools.view().name}` : "";
    [["force", [["ideal", "--warm"], ["force", "--accent"]], `Largest force${joint} (N)`], ["speed", [["speed", "--accent"]], `Impact speed${joint} (mm/s)`]].forEach(([name, curves, yLabel]) => {
      const all = curves.flatMap(([key]) => found.map((each) => each[key])).filter(Number.isFinite);
      const drawn = plots.chart(field(name), { x: x.ends, y: plots.span([0, ...all]), log: x.log, xLabel: x.label, yLabel });
      grounds(drawn, xs, found.map((each) => each.grade));
      curves.forEach(([key, colour]) => {
        plots.line(drawn, xs, found.map((each) => each[key]), colour, 1);
        plots.dots(drawn, xs, found.map((each) => each[key]), xs.length, colour, 3);
      });
      plots.upright(drawn, tools.held[asked.axes[0].key] * x.factor, "--warm");
    });
  }

  // The grade of each value, as the colour of the ground up to halfway to its neighbours, which are known.
  function grounds(drawn, xs, grades) {
    plots.clipped(drawn, (pen) => grades.forEach((grade, i) => {
      const [before, here, after] = [i - 1, i, i + 1].map((k) => drawn.px(xs[Math.max(0, Math.min(xs.length - 1, k))]));
      const half = (drawn.right - drawn.left) / (asked.count - 1) / 2 + 0.5;
      const [left, right] = [Math.max((before + here) / 2, here - half), Math.min((here + after) / 2, here + half)];
      pen.fillStyle = GRADES[tools.limits.names.indexOf(grade)] || "transparent";
      pen.fillRect(left, drawn.top, right - left, drawn.bottom - drawn.top);
    }));
  }

  function legend() {
    field("legend").hidden = !isMap();
    field("hardness").hidden = isMap() || field("hardness").hidden;
    [...field("hardness").querySelectorAll("b")].forEach((mark, i) => { mark.style.color = GRADES[i].slice(0, 7); });
    [...PERIODS.slice(1), PERIODS[0], LOST].forEach((colour, i) => { field("legend").children[i].style.color = colour; });
  }

  function drawMap(x, y) {
    chart = plots.chart(field("canvas"), { x: x.ends, y: y.ends, log: x.log, logY: y.log, aspect: 0.66, xLabel: x.label, yLabel: y.label });
    const width = (chart.right - chart.left) / (asked.count - 1);
    const height = (chart.bottom - chart.top) / (asked.count - 1);
    plots.clipped(chart, (pen) => rows.forEach((row) => {
      if (row.period === undefined) row.period = row.status ? -1 : verdict.period(tools.placed(row), tools.tolerance(row));
      pen.fillStyle = row.period < 0 ? LOST : PERIODS[Math.min(row.period, PERIODS.length - 1)];
      pen.fillRect(chart.px(row.value * x.factor) - width / 2, chart.py(row.across * y.factor) - height / 2, width + 0.5, height + 0.5);
    }));
  }

  // ---- clicks and drags

  // Values at a place of the picture, by key.
  function at([px, py]) {
    const inside = (low, value, high) => Math.min(high, Math.max(low, value));
    const found = [chart.x(inside(chart.left, px, chart.right)), isMap() ? chart.y(inside(chart.top, py, chart.bottom)) : 0];
    return asked.axes.map(({ key }, k) => [key, Number((found[k] / known(key).factor).toPrecision(7))]);
  }

  function dropped({ from, to }) {
    const far = [0, 1].map((k) => Math.abs(to[k] - from[k]) >= 4);
    if (!far[0] && !far[1]) at(to).forEach(([key, value]) => tools.wish(key, value));
    else if (far[0] && (far[1] || !isMap())) {
      const ends = at(to).map(([, value]) => value);
      const axes = at(from).map(([key, value], k) => ({ key, from: Math.min(value, ends[k]), to: Math.max(value, ends[k]) }));
      write({ ...asked, axes });
      run();
    } else draw();
  }

  const canvas = field("canvas");
  canvas.addEventListener("pointerdown", (event) => {
    if (!chart) return;
    canvas.setPointerCapture(event.pointerId);
    drag = { from: [event.offsetX, event.offsetY], to: [event.offsetX, event.offsetY] };
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!drag) return;
    drag.to = [event.offsetX, event.offsetY];
    draw();
  });
  canvas.addEventListener("pointerup", () => {
    const done = drag;
    drag = null;
    if (done) dropped(done);
  });
  canvas.addEventListener("pointercancel", () => { drag = null; });
  field("run").addEventListener("click", run);
  field("stop").addEventListener("click", () => stop(`Stopped after ${rows.length} values.`));
  AXES.forEach((end, i) => field("key", end).addEventListener("change", () => {
    const axes = AXES.map((other, k) => (k === i ? whole(known(field("key", end).value)) : axisOf(other))).filter(Boolean);
    write({ ...usual(), axes });
  }));
  addEventListener("resize", draw);

  function whole(chosen) {
    return chosen ? { key: chosen.key, from: chosen.min, to: chosen.max } : null;
  }

  // More turns are needed for a diagram than for each of the many cells of a map.
  function usual() {
    return field("key", AXES[1]).value ? { count: 24, transient: 50 } : { count: 120, transient: 100 };
  }

  function restored([count, transient, ...ends]) {
    const axes = [0, 3].filter((i) => i < ends.length).map((i) => ({ key: ends[i], from: Number(ends[i + 1]), to: Number(ends[i + 2]) }));
    const fine = axes.length && axes.every(({ key, from, to }) => known(key) && Number.isFinite(from) && Number.isFinite(to));
    if (!fine || !(count > 1) || !(transient >= 0)) return;
    write({ axes, count, transient });
    run();
  }

  jointplay.diagram = {
    asked: () => asked,
    computes: () => running.length > 0,
    draw,
    begin(found, given) {
      [parameters, tools] = [found, given];
      if (!parameters.length) return;
      const options = () => parameters.map((each) => Object.assign(document.createElement("option"), { value: each.key, textContent: each.label }));
      field("key").replaceChildren(...options());
      field("key", AXES[1]).append(...options());
      write({ ...usual(), axes: [whole(parameters[0])] });
      restored((jointplay.view.get("scan") || "").split(" "));
    },
  };

  jointplay.parts.push({
    // What is zoomed in on in a stored diagram or map can be computed finer.
    zoomed(panel, ends) {
      const { varied } = jointplay.data.live;
      const axes = panel.over.map((name, k) => [varied[name], k]).filter(([key]) => tools && known(key)).map(([key, k]) => {
        const [from, to] = [ends[2 * k], ends[2 * k + 1]].map((each) => each / panel.factors[k]);
        return { key, from, to };
      });
      if (axes.length) write({ ...read(), axes });
    },
    show() {},
  });
}

"use strict";
// A diagram that the page computes: for each value of a parameter its section points, in workers; a click leads
// the sliders there, a dragged stretch is computed finer.

if (jointplay.data.live) {
  const { element, store } = jointplay;
  const KEPT = 60; // turns of each value that are drawn
  const fields = Object.fromEntries(["key", "from", "to", "count", "transient"].map((name) => [name, element("scan-" + name)]));
  let tools = null; // of the live page: its parameters and solvers
  let parameters = [];
  let running = [];
  let rows = [];
  let asked = null; // parameter and ends of the diagram that is drawn
  let chart = null;
  let drag = null;
  let waiting = false;

  function parameter() {
    return parameters.find((each) => each.key === fields.key.value);
  }

  function values() {
    const { from, to, count, scale } = asked;
    return Array.from({ length: count }, (_, i) => {
      const share = count > 1 ? i / (count - 1) : 0;
      return scale === "log" ? from * (to / from) ** share : from + (to - from) * share;
    });
  }

  function read() {
    const chosen = parameter();
    const [from, to] = ["from", "to"].map((name) => Number(fields[name].value) / chosen.factor);
    const ends = [Math.min(from, to), Math.max(from, to)].map((each) => Math.min(chosen.max, Math.max(chosen.min, each)));
    const [count, transient] = ["count", "transient"].map((name) => Math.round(Number(fields[name].value)));
    const whole = { count: Math.max(2, Math.min(1000, count || 0)), transient: Math.max(0, Math.min(5000, transient || 0)) };
    return { key: chosen.key, from: ends[0], to: ends[1], scale: chosen.scale, ...whole };
  }

  function write(request) {
    const chosen = parameters.find((each) => each.key === request.key);
    fields.key.value = request.key;
    fields.from.value = Number((request.from * chosen.factor).toPrecision(6));
    fields.to.value = Number((request.to * chosen.factor).toPrecision(6));
    fields.count.value = request.count;
    fields.transient.value = request.transient;
    element("scan-unit").textContent = chosen.unit;
  }

  function stop(words) {
    running.forEach((worker) => worker.terminate());
    running = [];
    element("scan-stop").disabled = true;
    element("scan-said").textContent = words;
  }

  function run() {
    stop("");
    asked = read();
    if (!(asked.to > asked.from)) {
      stop("A range from a smaller to a larger value, within the slider's bounds, is accepted.");
      return;
    }
    write(asked);
    store("scan", ["key", "from", "to", "count", "transient"].map((name) => asked[name]).join(" "));
    rows = [];
    const began = performance.now();
    const every = values();
    const many = Math.max(1, Math.min(4, (navigator.hardwareConcurrency || 2) - 1, every.length));
    const size = Math.ceil(every.length / many);
    element("scan-stop").disabled = false;
    running = Array.from({ length: many }, (_, k) => {
      const worker = tools.solver((answer) => answered(answer, every.length, began));
      const list = every.slice(k * size, (k + 1) * size);
      worker.postMessage({ what: "scan", values: { ...tools.held }, key: asked.key, list, transient: asked.transient, kept: KEPT });
      return worker;
    });
    draw();
  }

  function answered(answer, all, began) {
    if (answer.what === "trouble") stop(`Stopped: ${answer.words}`);
    if (answer.what !== "row") return;
    rows.push(answer.row);
    element("scan-progress").value = rows.length / all;
    const lost = rows.filter((each) => each.status);
    const said = `${rows.length} of ${all} values, ${((performance.now() - began) / 1000).toFixed(1)} s`;
    const trouble = lost.length ? `; ${lost.length} ended early (${[...new Set(lost.map((each) => each.status))].join("; ")})` : "";
    element("scan-said").textContent = said + trouble;
    if (rows.length === all) stop(said + trouble);
    if (!waiting) requestAnimationFrame(draw);
    waiting = true;
  }

  function draw() {
    waiting = false;
    element("scan-figure").hidden = !asked;
    if (!asked) return;
    const chosen = parameters.find((each) => each.key === asked.key);
    const [x, y] = [[], []];
    rows.forEach((row) => row.section.forEach((point) => {
      x.push(row.value * chosen.factor);
      y.push(tools.place(point)[0]);
    }));
    const ends = [asked.from, asked.to].map((each) => each * chosen.factor);
    const labels = { xLabel: `${chosen.label}${chosen.unit ? ` (${chosen.unit})` : ""}`, yLabel: tools.section().words[0] };
    chart = plots.chart(element("scan-canvas"), { x: ends, y: plots.span(y), log: asked.scale === "log", aspect: 0.45, ...labels });
    plots.dots(chart, x, y, x.length, "--accent", 1.5);
    plots.upright(chart, tools.held[asked.key] * chosen.factor, "--warm");
    if (drag) {
      chart.pen.strokeStyle = stage.colour("--ink");
      chart.pen.strokeRect(drag.from, chart.top, drag.to - drag.from, chart.bottom - chart.top);
    }
  }

  function valueAt(at) {
    const chosen = parameters.find((each) => each.key === asked.key);
    return Number((chart.x(Math.min(chart.right, Math.max(chart.left, at))) / chosen.factor).toPrecision(7));
  }

  const canvas = element("scan-canvas");
  canvas.addEventListener("pointerdown", (event) => {
    if (!chart) return;
    canvas.setPointerCapture(event.pointerId);
    drag = { from: event.offsetX, to: event.offsetX };
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!drag) return;
    drag.to = event.offsetX;
    draw();
  });
  canvas.addEventListener("pointerup", () => {
    if (!drag) return;
    const { from, to } = drag;
    drag = null;
    if (Math.abs(to - from) < 4) {
      tools.wish(asked.key, valueAt(to));
      return;
    }
    write({ ...asked, from: Math.min(valueAt(from), valueAt(to)), to: Math.max(valueAt(from), valueAt(to)) });
    run();
  });
  canvas.addEventListener("pointercancel", () => { drag = null; });
  element("scan-run").addEventListener("click", run);
  element("scan-stop").addEventListener("click", () => stop(`Stopped after ${rows.length} values.`));
  fields.key.addEventListener("change", () => usual(parameter()));
  addEventListener("resize", draw);

  function usual(chosen) {
    write({ key: chosen.key, from: chosen.min, to: chosen.max, count: 120, transient: 100 });
  }

  jointplay.diagram = {
    draw,
    begin(found, given) {
      [parameters, tools] = [found, given];
      fields.key.replaceChildren(...parameters.map((each) => Object.assign(document.createElement("option"), { value: each.key, textContent: each.label })));
      const [key, ...rest] = (jointplay.view.get("scan") || "").split(" ");
      const known = parameters.find((each) => each.key === key);
      usual(known || parameters[0]);
      if (known && rest.length === 4 && rest.every((each) => Number.isFinite(Number(each)))) {
        write({ key, ...Object.fromEntries(["from", "to", "count", "transient"].map((name, i) => [name, Number(rest[i])])) });
        run();
      }
    },
  };

  jointplay.parts.push({
    // A stretch of a stored diagram that is zoomed in on can be computed finer.
    zoomed(panel, [from, to]) {
      const key = jointplay.data.live.varied[panel.over[0]];
      if (tools && key && parameters.some((each) => each.key === key)) {
        write({ ...read(), key, from: from / panel.factors[0], to: to / panel.factors[0] });
      }
    },
    show() {},
  });
}

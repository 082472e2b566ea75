"use strict";
// The cell of a sweep that is selected: a click or the arrow keys choose it, its numbers and points are shown.

if (jointplay.data.cells) {
  const { data, element, numbers, store } = jointplay;
  const { parameters, ways, rows, charts } = data.cells;
  const shape = parameters.map((each) => each.values.length);
  const colours = ["#0072b2", "#e69f00", "#7f7f7f", "#cc79a7", "#009e73", "#56b4e9"];
  const values = rows.map(numbers);
  const curves = charts.map((each) => ({ x: numbers(each.x), y: numbers(each.y), size: each.x.shape.at(-1) }));
  let place = null; // an index along each parameter

  function nearest(parameter, value) {
    const scale = parameter.log ? Math.log : Number;
    let best = 0;
    parameter.values.forEach((each, i) => {
      if (Math.abs(scale(each) - scale(value)) < Math.abs(scale(parameter.values[best]) - scale(value))) best = i;
    });
    return best;
  }

  function flat(way) {
    return place.reduce((total, i, k) => total * shape[k] + i, 0) * ways.length + way;
  }

  function written(row, value, code) {
    if (row.texts) return row.texts[code];
    if (row.flags[code] !== undefined) return row.flags[code];
    if (!Number.isFinite(value)) return "–";
    return Number(value.toPrecision(5)) + (row.unit && row.unit !== "–" ? " " + row.unit : "");
  }

  function line(name, cells, tag) {
    const tr = document.createElement("tr");
    [name, ...cells].forEach((text, i) => {
      const td = document.createElement(i === 0 ? "th" : tag);
      td.textContent = text;
      tr.append(td);
    });
    return tr;
  }

  function showNumbers() {
    const table = element("cell-numbers");
    const each = ways.map((_, way) => flat(way));
    table.replaceChildren(line("", ways, "th"));
    rows.forEach((row, r) => {
      const texts = each.map((at) => written(row, values[r][at], values[r][at]));
      if (texts.some((text) => text !== "–" && text !== "")) table.append(line(row.label, texts, "td"));
    });
    const at = place.map((i, k) => `${parameters[k].title} ${Number(parameters[k].values[i].toPrecision(6))} ${parameters[k].unit}`.trim());
    element("cell-title").textContent = at.join(", ");
    jointplay.say(at.join(", "));
  }

  function showCurves() {
    curves.forEach((curve, c) => {
      const parts = ways.map((_, way) => [curve.x, curve.y].map((all) => all.subarray(flat(way) * curve.size, (flat(way) + 1) * curve.size)));
      const [xs, ys] = [0, 1].map((axis) => parts.flatMap((part) => [...part[axis]]));
      const drawn = plots.chart(element("cell-chart" + c), { x: plots.span(xs), y: plots.span(ys), xLabel: charts[c].x_label, yLabel: charts[c].y_label });
      parts.forEach(([x, y], way) => {
        const colour = colours[way % colours.length];
        if (charts[c].joined) plots.line(drawn, x, y, colour);
        else plots.dots(drawn, x, y, x.length, colour, 3);
      });
    });
  }

  function showMarks() {
    data.panels.forEach((panel, number) => {
      panel.over.forEach((name, axis) => {
        const k = parameters.findIndex((each) => each.name === name);
        if (k >= 0) jointplay.charts.mark(number, axis, parameters[k].values[place[k]]);
      });
    });
  }

  function showMotion() {
    const chosen = Object.fromEntries(place.map((i, k) => [parameters[k].name, parameters[k].stored[i]]));
    jointplay.point.show(chosen, ways.map((_, way) => flat(way)), ways.map((_, way) => colours[way % colours.length]));
  }

  function showCommand() {
    const changes = place.map((i, k) => ` --set 'vary.${parameters[k].key}=[${parameters[k].stored[i]}]'`);
    element("cell-command").textContent = `jointplay run ${data.cells.file}${changes.join("")} --out one_cell`;
  }

  function select(wanted) {
    place = wanted.map((i, k) => Math.max(0, Math.min(shape[k] - 1, i)));
    element("cell").hidden = false;
    place.forEach((i, k) => { element("slider" + k).value = i; });
    showNumbers();
    showCurves();
    showMarks();
    if (element("cell-command")) showCommand();
    if (jointplay.point) showMotion();
  }

  function choose(wanted) {
    select(wanted);
    store("cell", place.join(" "));
  }

  parameters.forEach((_, k) => {
    const slider = element("slider" + k);
    slider.addEventListener("input", () => choose((place || shape.map(() => 0)).map((i, j) => (j === k ? Number(slider.value) : i))));
  });
  const clickable = data.panels.some((panel) => panel.over.some((name) => parameters.some((each) => each.name === name)));

  jointplay.parts.push({
    tapped(panel, x, y) {
      const asked = (place || shape.map(() => 0)).slice();
      const along = [x, y].filter((at, axis) => {
        const k = parameters.findIndex((each) => each.name === panel.over[axis]);
        if (k >= 0) asked[k] = nearest(parameters[k], at);
        return k >= 0;
      });
      if (along.length) choose(asked);
    },
    pressed(key) {
      const steps = { ArrowLeft: [shape.length - 1, -1], ArrowRight: [shape.length - 1, 1], ArrowDown: [shape.length - 2, -1], ArrowUp: [shape.length - 2, 1] };
      const [k, step] = steps[key] || [-1, 0];
      if (k < 0) return false;
      choose((place || shape.map(() => 0)).map((i, j) => i + (j === k ? step : 0)));
      return true;
    },
    show(view) {
      const asked = (view.get("cell") || "").split(" ").map(Number);
      if (view.get("cell") && asked.length === shape.length && asked.every(Number.isInteger)) select(asked);
      else if (!place && !clickable) select(shape.map(() => 0));
    },
  });
}

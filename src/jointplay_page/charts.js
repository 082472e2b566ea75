"use strict";
// Pictures that answer: what a pointer is at, what is clicked, which part is looked at, where the selected point is.

jointplay.charts = (() => {
  const { data, element, store, parts, view } = jointplay;
  const SHORT = 4; // px: a drag that is shorter is a click
  const svgs = [...document.querySelectorAll(".picture > svg")];
  const whole = svgs.map((svg) => svg.getAttribute("viewBox"));
  const scales = data.panels.map(({ box, stops, log }) => [scaled(stops[0], log[0], box[0], box[0] + box[2]), scaled(stops[1], log[1], box[1] + box[3], box[1])]);

  // From values to places and back, along values at even distances.
  function scaled(stops, log, begin, end) {
    if (stops.length === 2) return plots.scaled(stops, log, begin, end);
    const between = (i) => plots.scaled(stops.slice(i, i + 2), false, ...[i, i + 1].map((k) => begin + (k / (stops.length - 1)) * (end - begin)));
    const held = (i) => Math.min(stops.length - 2, Math.max(0, i));
    const place = (given) => between(held(stops.findLastIndex((stop) => stop <= given)))[0](given);
    const value = (where) => between(held(Math.floor(((where - begin) / (end - begin)) * (stops.length - 1))))[1](where);
    return [place, value];
  }

  function made(svg, name, kind) {
    const found = document.createElementNS("http://www.w3.org/2000/svg", name);
    found.setAttribute("class", kind);
    svg.append(found);
    return found;
  }

  function placed(shape, places) {
    Object.entries(places).forEach(([key, value]) => shape.setAttribute(key, value));
  }

  // Where a pointer is on a picture, in the picture's units.
  function at(svg, event) {
    const { x, y } = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    return [x, y];
  }

  function panelAt(picture, [x, y]) {
    return data.panels.findIndex(({ picture: its, box }) => its === picture && x >= box[0] && x <= box[0] + box[2] && y >= box[1] && y <= box[1] + box[3]);
  }

  function valuesAt(number, point) {
    return scales[number].map(([, value], axis) => value(point[axis]));
  }

  // A line at a value along an axis of a panel.
  const marks = new Map();

  function mark(number, axis, value) {
    const { box, picture } = data.panels[number];
    const key = `${number} ${axis}`;
    if (!marks.has(key)) marks.set(key, made(svgs[picture], "line", "selected"));
    const place = scales[number][axis][0](value);
    const [first, length] = [box[axis], box[axis + 2]];
    const seen = place >= first - 0.01 && place <= first + length + 0.01;
    marks.get(key).style.display = seen ? "" : "none";
    if (axis === 0) placed(marks.get(key), { x1: place, x2: place, y1: box[1], y2: box[1] + box[3] });
    else placed(marks.get(key), { y1: place, y2: place, x1: box[0], x2: box[0] + box[2] });
  }

  // ---- the part that is looked at: ends along x and y of a panel in the address

  function clamped(box, [x, y]) {
    return [Math.min(box[0] + box[2], Math.max(box[0], x)), Math.min(box[1] + box[3], Math.max(box[1], y))];
  }

  function look(number, ends) {
    const { picture } = data.panels[number];
    const [left, right] = [ends[0], ends[1]].map(scales[number][0][0]);
    const [below, above] = [ends[2], ends[3]].map(scales[number][1][0]);
    svgs[picture].setAttribute("viewBox", `${left} ${above} ${right - left} ${below - above}`);
    element("whole" + picture).hidden = false;
    parts.forEach((part) => part.zoomed && part.zoomed(data.panels[number], ends));
  }

  function forget(picture) {
    data.panels.forEach((panel, number) => panel.picture === picture && store("zoom" + number, null));
  }

  function showZoom() {
    svgs.forEach((svg, picture) => {
      svg.setAttribute("viewBox", whole[picture]);
      element("whole" + picture).hidden = true;
    });
    data.panels.forEach((_, number) => {
      const given = (view.get("zoom" + number) || "").split(" ").map(Number);
      if (given.length === 4 && given.every(Number.isFinite) && given[0] < given[1] && given[2] < given[3]) look(number, given);
    });
  }

  // ---- pointers

  svgs.forEach((svg, picture) => {
    let begun = null; // panel and place where a drag began, and the frame drawn since

    function say(number, point) {
      const { labels } = data.panels[number] || {};
      const words = number < 0 ? "" : valuesAt(number, point).map((value, axis) => `${labels[axis]}: ${plots.text(value, 5)}`.replace(/^: /, ""));
      element("at" + picture).textContent = words ? words.join(", ") : "\u00a0";
    }

    svg.addEventListener("pointerdown", (event) => {
      const point = at(svg, event);
      const number = panelAt(picture, point);
      if (number < 0 || event.button) return;
      svg.setPointerCapture(event.pointerId);
      begun = { number, point, x: event.clientX, y: event.clientY, frame: null };
    });
    svg.addEventListener("pointermove", (event) => {
      const point = at(svg, event);
      if (!begun) {
        say(panelAt(picture, point), point);
        return;
      }
      const { box } = data.panels[begun.number];
      const to = clamped(box, point);
      say(begun.number, to);
      if (Math.hypot(event.clientX - begun.x, event.clientY - begun.y) < SHORT) return;
      begun.frame = begun.frame || made(svg, "rect", "frame");
      const [x, y] = [0, 1].map((axis) => Math.min(begun.point[axis], to[axis]));
      placed(begun.frame, { x, y, width: Math.abs(to[0] - begun.point[0]), height: Math.abs(to[1] - begun.point[1]) });
    });
    svg.addEventListener("pointerup", (event) => {
      if (!begun) return;
      const { number, point, frame } = begun;
      const { box } = data.panels[number];
      begun = null;
      if (!frame) {
        parts.forEach((part) => part.tapped && part.tapped(data.panels[number], ...valuesAt(number, point)));
        return;
      }
      frame.remove();
      const [from, to] = [point, clamped(box, at(svg, event))].map((place) => valuesAt(number, place));
      const sorted = [0, 1].flatMap((axis) => [from[axis], to[axis]].sort((a, b) => a - b)).map((end) => Number(end.toPrecision(8)));
      if (sorted[0] === sorted[1] || sorted[2] === sorted[3]) return;
      forget(picture);
      store("zoom" + number, sorted.join(" "));
      showZoom();
    });
    svg.addEventListener("pointercancel", () => {
      if (begun && begun.frame) begun.frame.remove();
      begun = null;
    });
    element("whole" + picture).addEventListener("click", () => {
      forget(picture);
      showZoom();
    });
  });

  parts.push({ show: showZoom });
  return { mark, scales, svgs };
})();

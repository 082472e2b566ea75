"use strict";
// Small charts on a canvas: axes with round ticks, curves, points; where on them a pointer is.

const plots = (() => {
  const LEFT = 52;
  const BELOW = 34;
  const EDGE = 14;

  function ticks(low, high, count = 5) {
    const raw = (high - low) / count;
    const unit = 10 ** Math.floor(Math.log10(raw));
    const step = unit * [1, 2, 5, 10].find((each) => each * unit >= raw);
    const found = [];
    for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i += 1) found.push(i * step);
    return found;
  }

  function decades(low, high) {
    const found = [];
    for (let e = Math.floor(Math.log10(low)); e <= Math.log10(high); e += 1) [1, 2, 5].forEach((each) => found.push(each * 10 ** e));
    return found.filter((each) => each >= low && each <= high);
  }

  function text(value, digits = 4) {
    const short = Number(value.toPrecision(digits));
    const size = Math.abs(short);
    if (size === 0 || (size >= 1e-4 && size < 1e6)) return String(short).replace("-", "−");
    const [mantissa, power] = short.toExponential().split("e");
    const raised = [...power.replace("+", "")].map((each) => (each === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[each])).join("");
    return `${mantissa}·10${raised}`.replace("-", "−");
  }

  // Ends of an axis that holds all values, with a little room; never empty.
  function span(values, least = 0) {
    let [low, high] = [Infinity, -Infinity];
    for (const each of values) {
      if (each < low) low = each;
      if (each > high) high = each;
    }
    if (!(low <= high)) return [0, 1];
    const room = Math.max(0.05 * (high - low), least, 1e-9 * Math.abs(high), 1e-300);
    return [low - room, high + room];
  }

  // From values to pixels, and back.
  function scaled(ends, log, begin, end) {
    const [first, last] = log ? ends.map(Math.log) : ends;
    const to = (value) => begin + (((log ? Math.log(value) : value) - first) / (last - first)) * (end - begin);
    const at = (pixel) => {
      const value = first + ((pixel - begin) / (end - begin)) * (last - first);
      return log ? Math.exp(value) : value;
    };
    return [to, at];
  }

  // Begin a chart; `x` and `y` are ends of the axes, `log` and `logY` that they are logarithmic. Returns how to draw.
  function chart(canvas, { x, y, xLabel, yLabel, log = false, logY = false, aspect = 0.66 }) {
    const [pen, width, height] = stage.clear(canvas, aspect);
    const marks = logY ? decades(...y) : ticks(...y, 4);
    const widest = marks.reduce((most, each) => Math.max(most, pen.measureText(text(each)).width), 0);
    const [left, right, bottom, top] = [Math.max(LEFT, widest + 23), width - EDGE, height - BELOW, EDGE]; // 18 px for the label
    const [toX, atX] = scaled(x, log, left, right);
    const [toY, atY] = scaled(y, logY, bottom, top);
    const view = { pen, px: toX, py: toY, x: atX, y: atY, left, right, bottom, top };
    pen.strokeStyle = stage.colour("--line");
    pen.fillStyle = stage.colour("--faint");
    pen.lineWidth = 1;
    pen.textAlign = "center";
    let free = -Infinity;
    (log ? decades(...x) : ticks(...x)).forEach((value) => {
      const at = toX(value);
      pen.strokeRect(at, top, 0, bottom - top);
      if (at - pen.measureText(text(value)).width / 2 > free + 4) {
        pen.fillText(text(value), at, bottom + 14);
        free = at + pen.measureText(text(value)).width / 2;
      }
    });
    pen.fillText(xLabel, (left + right) / 2, height - 4);
    pen.textAlign = "right";
    marks.forEach((value) => {
      pen.strokeRect(left, toY(value), right - left, 0);
      pen.fillText(text(value), left - 5, toY(value) + 4);
    });
    pen.save();
    pen.translate(11, (top + bottom) / 2);
    pen.rotate(-Math.PI / 2);
    pen.textAlign = "center";
    pen.fillText(yLabel, 0, 0);
    pen.restore();
    return view;
  }

  // The aspect at which a canvas gives both axes of a chart the same length.
  function square(canvas) {
    return 1 - (LEFT - BELOW) / canvas.clientWidth;
  }

  function clipped({ pen, left, right, bottom, top }, draw) {
    pen.save();
    pen.beginPath();
    pen.rect(left, top, right - left, bottom - top);
    pen.clip();
    draw(pen);
    pen.restore();
  }

  function line(view, xs, ys, colour, width = 1.5) {
    clipped(view, (pen) => {
      pen.strokeStyle = stage.colour(colour);
      pen.lineWidth = width;
      pen.beginPath();
      let begun = false; // what is not finite is a gap
      for (let i = 0; i < xs.length; i += 1) {
        const there = Number.isFinite(xs[i]) && Number.isFinite(ys[i]);
        if (there && begun) pen.lineTo(view.px(xs[i]), view.py(ys[i]));
        else if (there) pen.moveTo(view.px(xs[i]), view.py(ys[i]));
        begun = there;
      }
      pen.stroke();
    });
  }

  function dots(view, xs, ys, count, colour, size = 2) {
    clipped(view, (pen) => {
      pen.fillStyle = stage.colour(colour);
      for (let i = 0; i < count; i += 1) pen.fillRect(view.px(xs[i]) - size / 2, view.py(ys[i]) - size / 2, size, size);
    });
  }

  function upright({ pen, px, bottom, top, left, right }, x, colour) {
    const at = Math.min(right, Math.max(left, px(x)));
    pen.strokeStyle = stage.colour(colour);
    pen.lineWidth = 1;
    pen.strokeRect(at, top, 0, bottom - top);
  }

  return { chart, clipped, dots, line, scaled, span, square, text, upright };
})();

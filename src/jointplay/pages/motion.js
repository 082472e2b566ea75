"use strict";
// The mechanism in motion: links, the journal in its bearing (the clearance enlarged), the force on it.

if (jointplay.data.motion) {
  const { data, element, numbers, store } = jointplay;
  const motion = data.motion;
  const time = numbers(motion.time);
  const links = motion.links.map((link) => ({ ...link, frames: numbers(link.frames) }));
  const bearings = motion.bearings.map((each) => ({ ...each, journal: numbers(each.journal), force: each.force && numbers(each.force) }));
  const slider = element("frame");
  const period = Number.isFinite(motion.period) && motion.period > 0 ? motion.period : time.at(-1) - time[0];
  const SECONDS = 3; // a turn takes, as it is played
  const TRAIL = 60; // frames of the journal's path that are drawn
  let frame = 0;
  let playing = null; // where and when it began

  function pointAt(link, along, at) {
    const [x, y, angle] = link.frames.subarray(3 * at, 3 * at + 3);
    return [x + along * Math.cos(angle), y + along * Math.sin(angle)];
  }

  function pinAt(pin, at) {
    return pin.point || pointAt(links.find((link) => link.name === pin.link), pin.at, at);
  }

  function bounds() {
    const box = [Infinity, -Infinity, Infinity, -Infinity];
    const include = ([x, y]) => {
      box[0] = Math.min(box[0], x);
      box[1] = Math.max(box[1], x);
      box[2] = Math.min(box[2], y);
      box[3] = Math.max(box[3], y);
    };
    for (let at = 0; at < time.length; at += 1) links.forEach((link) => link.along.forEach((s) => include(pointAt(link, s, at))));
    motion.pins.filter((pin) => pin.point).forEach((pin) => include(pin.point));
    return box;
  }

  const box = bounds();
  const strongest = bearings.map((each) => (each.force ? each.force.reduce((most, f) => Math.max(most, Math.abs(f) || 0), 0) : 0));

  function clear(canvas) {
    const ratio = window.devicePixelRatio || 1;
    const width = canvas.clientWidth;
    const height = Math.round(0.66 * width);
    canvas.style.height = height + "px";
    canvas.width = width * ratio;
    canvas.height = height * ratio;
    const pen = canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    pen.font = "12px system-ui, sans-serif";
    return [pen, width, height];
  }

  function colour(name) {
    return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  }

  function circle(pen, x, y, radius, fill) {
    pen.beginPath();
    pen.arc(x, y, radius, 0, 2 * Math.PI);
    if (fill) pen.fill();
    pen.stroke();
  }

  function drawLinkage() {
    const [pen, width, height] = clear(element("linkage"));
    const scale = 0.86 * Math.min(width / (box[1] - box[0] || 1), height / (box[3] - box[2] || 1));
    const put = ([x, y]) => [width / 2 + scale * (x - (box[0] + box[1]) / 2), height / 2 - scale * (y - (box[2] + box[3]) / 2)];
    pen.lineCap = "round";
    motion.pins.filter((pin) => pin.direction !== undefined && pin.point).forEach((pin) => {
      const [x, y] = put(pin.point);
      const [dx, dy] = [width * Math.cos(pin.direction), -width * Math.sin(pin.direction)];
      pen.strokeStyle = colour("--line");
      pen.lineWidth = 2;
      pen.beginPath();
      pen.moveTo(x - dx, y - dy);
      pen.lineTo(x + dx, y + dy);
      pen.stroke();
    });
    links.forEach((link) => {
      pen.strokeStyle = colour("--accent");
      pen.lineWidth = 6;
      pen.beginPath();
      link.along.forEach((s, i) => pen[i ? "lineTo" : "moveTo"](...put(pointAt(link, s, frame))));
      pen.stroke();
    });
    motion.pins.forEach((pin) => {
      const [x, y] = put(pinAt(pin, frame));
      pen.strokeStyle = colour("--ink");
      pen.fillStyle = colour(pin.clearance > 0 ? "--warm" : "--paper");
      pen.lineWidth = 1.5;
      circle(pen, x, y, 5, true);
      if (pin.point) pen.strokeRect(x - 9, y - 9, 18, 18);
      pen.fillStyle = colour("--ink");
      pen.fillText(pin.name, x + 9, y - 9);
    });
  }

  function drawBearing(bearing, number) {
    const [pen, width, height] = clear(element("bearing" + number));
    const radius = 0.4 * Math.min(width, height);
    const put = (at) => [width / 2 + radius * bearing.journal[2 * at], height / 2 - radius * bearing.journal[2 * at + 1]];
    pen.fillStyle = colour("--field");
    pen.strokeStyle = colour("--faint");
    pen.lineWidth = 1;
    circle(pen, width / 2, height / 2, radius, true);
    pen.strokeStyle = colour("--accent");
    pen.beginPath();
    for (let at = Math.max(0, frame - TRAIL); at <= frame; at += 1) pen.lineTo(...put(at));
    pen.stroke();
    const [x, y] = put(frame);
    pen.strokeStyle = colour("--ink");
    pen.fillStyle = colour("--warm");
    circle(pen, x, y, 5, true);
    if (bearing.force && strongest[number] > 0) drawForce(pen, bearing, number, [x, y], radius);
  }

  function drawForce(pen, bearing, number, [x, y], radius) {
    const [rx, ry] = bearing.journal.subarray(2 * frame, 2 * frame + 2);
    const length = (0.6 * radius * bearing.force[frame]) / strongest[number] / (Math.hypot(rx, ry) || 1);
    pen.strokeStyle = colour("--warm");
    pen.lineWidth = 3;
    pen.beginPath();
    pen.moveTo(x, y);
    pen.lineTo(x - length * rx, y + length * ry); // the bearing presses the journal towards its middle
    pen.stroke();
    pen.fillStyle = colour("--ink");
    pen.fillText(`${bearing.force[frame].toPrecision(3)} N`, 6, 16);
  }

  function draw() {
    drawLinkage();
    bearings.forEach(drawBearing);
    slider.value = frame;
    element("moment").textContent = `${(1e3 * time[frame]).toFixed(2)} ms, ${(time[frame] / period).toFixed(3)} turns`;
    data.panels.forEach((panel, number) => {
      if (panel.over[0] === "time") jointplay.model("mark" + number + "x").setv({ location: time[frame] * panel.factors[0], visible: true });
    });
  }

  function seek(at) {
    frame = Math.max(0, Math.min(time.length - 1, Math.round(at)));
    draw();
  }

  function nearest(moment) {
    let best = 0;
    time.forEach((each, i) => {
      if (Math.abs(each - moment) < Math.abs(time[best] - moment)) best = i;
    });
    return best;
  }

  function step(now) {
    if (!playing) return;
    const moment = playing.moment + ((now - playing.began) / 1000 / SECONDS) * period;
    const past = time.findIndex((each) => each >= moment);
    if (past < 0) begin(0);
    seek(past < 0 ? 0 : past);
    requestAnimationFrame(step);
  }

  function begin(at) {
    playing = { moment: time[at], began: performance.now() };
  }

  function play() {
    if (playing) {
      playing = null;
      store("frame", frame);
    } else {
      begin(frame === time.length - 1 ? 0 : frame);
      requestAnimationFrame(step);
    }
    element("play").textContent = playing ? "Pause" : "Play";
  }

  function stopAt(at) {
    if (playing) play();
    seek(at);
    store("frame", frame);
  }

  slider.max = time.length - 1;
  slider.addEventListener("input", () => stopAt(Number(slider.value)));
  element("play").addEventListener("click", play);
  addEventListener("resize", draw);
  jointplay.parts.push({
    tapped(panel, x) {
      if (panel.over[0] === "time") stopAt(nearest(x / panel.factors[0]));
    },
    pressed(key) {
      if (key === " ") play();
      else if (key === "," || key === ".") stopAt(frame + (key === "." ? 1 : -1));
      else return false;
      return true;
    },
    show(view) {
      if (!playing) seek(Number(view.get("frame")) || 0);
    },
  });
}

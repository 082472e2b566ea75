"use strict";
// How a mechanism is drawn: links, pins and guides; the journal in its bearing, the clearance enlarged; its force.
// A scene has `links`, each with its places `along` it and its `frames` (x, y, angle of every sample), and `pins`.

const stage = (() => {
  function clear(canvas, aspect = 0.66) {
    const ratio = window.devicePixelRatio || 1;
    const width = canvas.clientWidth;
    const height = Math.round(aspect * width);
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.style.height = height + "px";
      canvas.width = width * ratio;
      canvas.height = height * ratio;
    }
    const pen = canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    pen.font = "12px system-ui, sans-serif";
    [pen.textAlign, pen.textBaseline] = ["start", "alphabetic"];
    return [pen, width, height];
  }

  function colour(name) {
    return name.startsWith("--") ? getComputedStyle(document.documentElement).getPropertyValue(name).trim() : name;
  }

  function circle(pen, x, y, radius, fill) {
    pen.beginPath();
    pen.arc(x, y, radius, 0, 2 * Math.PI);
    if (fill) pen.fill();
    pen.stroke();
  }

  function pointAt(link, along, at) {
    const [x, y, angle] = link.frames.subarray(3 * at, 3 * at + 3);
    return [x + along * Math.cos(angle), y + along * Math.sin(angle)];
  }

  function pinAt(scene, pin, at) {
    return pin.point || pointAt(scene.links.find((link) => link.name === pin.link), pin.at, at);
  }

  // The rectangle that holds every place of every link: left, right, bottom, top; a given one is widened.
  function bounds(scene, box = [Infinity, -Infinity, Infinity, -Infinity]) {
    const include = ([x, y]) => {
      box[0] = Math.min(box[0], x);
      box[1] = Math.max(box[1], x);
      box[2] = Math.min(box[2], y);
      box[3] = Math.max(box[3], y);
    };
    scene.links.forEach((link) => {
      for (let at = 0; 3 * at < link.frames.length; at += 1) link.along.forEach((s) => include(pointAt(link, s, at)));
    });
    scene.pins.filter((pin) => pin.point).forEach((pin) => include(pin.point));
    scene.pins.filter((pin) => pin.sizes).forEach((pin) => {
      for (let at = 0; 3 * at < scene.links[0].frames.length; at += 1) {
        const [[x, y], angle] = [pinAt(scene, pin.block, at), turned(scene, pin.block, at)];
        const [c, s] = [Math.abs(Math.cos(angle)), Math.abs(Math.sin(angle))];
        const [wide, high] = [[c, s], [s, c]].map(([a, b]) => a * pin.sizes[0] + b * pin.sizes[1]);
        [-1, 1].forEach((sign) => include([x + sign * wide, y + sign * high]));
      }
    });
    return box;
  }

  const AROUND = [1, 3, 7, 5, 2, 0, 6, 4].map((i) => [Math.cos((i * Math.PI) / 4), -Math.sin((i * Math.PI) / 4)]); // of labels
  const APART = 18; // px of a name from its pin
  const NEEDED = 10; // px around it

  function distance([px, py], [[ax, ay], [bx, by]]) {
    const [dx, dy] = [bx - ax, by - ay];
    const share = Math.max(0, Math.min(1, ((px - ax) * dx + (py - ay) * dy) / (dx * dx + dy * dy || 1)));
    return Math.hypot(px - ax - share * dx, py - ay - share * dy);
  }

  // The place of each pin's name beside it: where it was, unless a link, a pin, another name or an edge is in its way.
  function names(canvas, scene, put, at, [width, height]) {
    const links = scene.links.flatMap((link) => link.along.slice(1).map((s, i) => [link.along[i], s].map((each) => put(pointAt(link, each, at)))));
    const pins = scene.pins.map((pin) => put(pinAt(scene, pin.block || pin, at)));
    const places = [];
    canvas.names = scene.pins.map((pin, k) => {
      const far = APART + (pin.point ? 3 : 0) + (pin.block && pin.sizes ? scene.scale * pin.sizes[1] : 0);
      const spot = (way) => pins[k].map((each, axis) => each + far * AROUND[way][axis]);
      const room = (way) => {
        const [x, y] = spot(way);
        const others = [...places, ...pins.filter((_, j) => j !== k)].map((other) => Math.hypot(other[0] - x, other[1] - y) - 5);
        return Math.min(...links.map((each) => distance([x, y], each)), ...others, x, width - x, y, height - y);
      };
      const before = canvas.names ? canvas.names[k] : 0;
      const rooms = AROUND.map((_, way) => Math.min(NEEDED, room(way)));
      const way = rooms[before] < NEEDED ? rooms.indexOf(Math.max(...rooms)) : before;
      places.push(spot(way));
      return way;
    });
    return places;
  }

  function linkage(canvas, scene, box, at) {
    const [pen, width, height] = clear(canvas);
    const scale = 0.86 * Math.min(width / (box[1] - box[0] || 1), height / (box[3] - box[2] || 1));
    const put = ([x, y]) => [width / 2 + scale * (x - (box[0] + box[1]) / 2), height / 2 - scale * (y - (box[2] + box[3]) / 2)];
    pen.lineCap = "round";
    const sliding = scene.pins.filter((pin) => pin.block);
    sliding.forEach((pin) => faces(pen, scene, pin, at, put, scale));
    scene.links.forEach((link) => {
      pen.strokeStyle = colour("--accent");
      pen.lineWidth = 6;
      pen.beginPath();
      link.along.forEach((s, i) => pen[i ? "lineTo" : "moveTo"](...put(pointAt(link, s, at))));
      pen.stroke();
    });
    sliding.forEach((pin) => block(pen, scene, pin, at, put, scale));
    scene.pins.filter((pin) => !pin.block).forEach((pin) => {
      const [x, y] = put(pinAt(scene, pin, at));
      pen.strokeStyle = colour("--ink");
      pen.fillStyle = colour(pin.clearance > 0 ? "--warm" : "--paper");
      pen.lineWidth = 1.5;
      circle(pen, x, y, 5, true);
      if (pin.point) pen.strokeRect(x - 9, y - 9, 18, 18);
    });
    pen.fillStyle = colour("--ink");
    [pen.textAlign, pen.textBaseline] = ["center", "middle"];
    names(canvas, { ...scene, scale }, put, at, [width, height]).forEach((place, k) => pen.fillText(scene.pins[k].name, ...place));
  }

  // Direction of a guide, or of the line of its block.
  function turned(scene, pin, at) {
    const link = scene.links.find((each) => each.name === pin.link);
    return pin.direction + (link ? link.frames[3 * at + 2] : 0);
  }

  // How far from a guide's place its block comes along it, backwards and forwards, over all samples of a motion; its
  // pin keeps it, as it is the same in every frame.
  function stroke(scene, pin) {
    const ways = Array.from({ length: scene.links[0].frames.length / 3 }, (_, i) => {
      const [[x, y], [bx, by], angle] = [pinAt(scene, pin, i), pinAt(scene, pin.block, i), turned(scene, pin, i)];
      return (bx - x) * Math.cos(angle) + (by - y) * Math.sin(angle);
    });
    return [Math.min(...ways), Math.max(...ways)];
  }

  // A guide's line, or with clearance its two faces to scale: on the ground as far as the picture goes, on a link as
  // far as the block slides and the link reaches along it.
  function faces(pen, scene, pin, at, put, scale) {
    const [x, y] = put(pinAt(scene, pin, at));
    const angle = turned(scene, pin, at);
    const link = scene.links.find((each) => each.name === pin.link);
    const along = link ? [...link.along.map((s) => (s - pin.at) * Math.cos(pin.direction)), ...(pin.stroke ??= stroke(scene, pin))] : [-1e4, 1e4];
    const [near, far] = [Math.min(...along), Math.max(...along)].map((each) => scale * each);
    const [dx, dy] = [Math.cos(angle), -Math.sin(angle)];
    const away = pin.sizes ? scale * (pin.sizes[1] + pin.clearance) : 0;
    pen.strokeStyle = colour(pin.sizes ? "--ink" : "--line");
    pen.lineWidth = pin.sizes ? 1.5 : 2;
    (away ? [away, -away] : [0]).forEach((off) => {
      const [sx, sy] = [x + off * dy, y - off * dx];
      pen.beginPath();
      pen.moveTo(sx + near * dx, sy + near * dy);
      pen.lineTo(sx + far * dx, sy + far * dy);
      pen.stroke();
    });
  }

  // The block of a slider: to scale where it has sizes.
  function block(pen, scene, pin, at, put, scale) {
    const [x, y] = put(pinAt(scene, pin.block, at));
    const [long, high] = pin.sizes ? pin.sizes.map((each) => scale * each) : [14, 8];
    pen.save();
    pen.translate(x, y);
    pen.rotate(-turned(scene, pin.block, at));
    pen.strokeStyle = colour("--ink");
    pen.fillStyle = colour(pin.clearance > 0 ? "--warm" : "--paper");
    pen.globalAlpha = 0.85;
    pen.lineWidth = 1.5;
    pen.fillRect(-long, -high, 2 * long, 2 * high);
    pen.globalAlpha = 1;
    pen.strokeRect(-long, -high, 2 * long, 2 * high);
    pen.restore();
  }

  // A bearing has the `journal` in it (x, y of every sample, in clearances) and, where known, its `force` and `reach`;
  // its path is drawn from one sample to another.
  function bearing(canvas, shown, [from, until], at, strongest) {
    const [pen, width, height] = clear(canvas);
    const radius = (0.46 * Math.min(width, height)) / Math.max(1.15, shown.reach || 0);
    const put = (i) => [width / 2 + radius * shown.journal[2 * i], height / 2 - radius * shown.journal[2 * i + 1]];
    pen.fillStyle = colour("--field");
    pen.strokeStyle = colour("--faint");
    pen.lineWidth = 1;
    circle(pen, width / 2, height / 2, radius, true);
    pen.strokeStyle = colour("--accent");
    pen.beginPath();
    for (let i = Math.max(0, from); i <= until; i += 1) pen.lineTo(...put(i));
    pen.stroke();
    const [x, y] = put(at);
    pen.strokeStyle = colour("--ink");
    pen.fillStyle = colour("--warm");
    circle(pen, x, y, 5, true);
    if (shown.force && strongest > 0) force(pen, shown, at, [x, y], radius / strongest);
  }

  // A guide has the `ways` of its slider's corners to their faces (upper front and rear, lower front and rear), in
  // clearances, and whether they `touch` where that is known. Only the gap is to scale across the guide.
  function guide(canvas, shown, at, strongest) {
    const [pen, width, height] = clear(canvas);
    const unit = Math.min(width / 6.4, height / 5.8);
    const corners = [[1, 1], [-1, 1], [1, -1], [-1, -1]].map(([along, side], k) => [
      width / 2 + 2.6 * unit * along, height / 2 - unit * side * (1.4 + shown.ways[4 * at + k])]);
    pen.strokeStyle = colour("--ink");
    pen.lineWidth = 1.5;
    [-2.4, 2.4].forEach((face) => pen.strokeRect(0, height / 2 + unit * face, width, 0));
    pen.fillStyle = colour("--field");
    pen.beginPath();
    [0, 1, 3, 2].forEach((k) => pen.lineTo(...corners[k]));
    pen.closePath();
    pen.fill();
    pen.stroke();
    corners.forEach(([x, y], k) => {
      pen.fillStyle = colour(shown.touch && shown.touch[4 * at + k] ? "--ink" : "--paper");
      circle(pen, x, y, 5, true);
      if (!shown.force || !(strongest > 0)) return;
      pen.strokeStyle = colour("--warm");
      pen.lineWidth = 3;
      pen.strokeRect(x, y, 0, (k < 2 ? 1 : -1) * unit * shown.force[4 * at + k] / strongest); // on the slider
      pen.strokeStyle = colour("--ink");
      pen.lineWidth = 1.5;
    });
  }

  function force(pen, shown, at, [x, y], scale) {
    const [rx, ry] = shown.journal.subarray(2 * at, 2 * at + 2);
    const length = (0.6 * scale * shown.force[at]) / (Math.hypot(rx, ry) || 1);
    pen.strokeStyle = colour("--warm");
    pen.lineWidth = 3;
    pen.beginPath();
    pen.moveTo(x, y);
    pen.lineTo(x - length * rx, y + length * ry); // the bearing presses the journal towards its middle
    pen.stroke();
    pen.fillStyle = colour("--ink");
    pen.fillText(`${shown.force[at].toPrecision(3)} N`, 6, 16);
  }

  return { bearing, bounds, clear, colour, guide, linkage, names };
})();

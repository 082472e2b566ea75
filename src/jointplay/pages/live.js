"use strict";
// The page that computes: sliders lead a solver in a worker; what it answers is drawn and put into words.

if (jointplay.data.live) {
  const { data, element, store } = jointplay;
  const live = data.live;
  const SAMPLES = 720; // of the watched turn
  const BUDGET = 10; // ms of a frame, for the motion that runs ahead
  const POINTS = 4096; // of the section: the last ones
  const MOST = 4000; // turns after which the motion that runs ahead rests

  const nominal = {};
  const held = {}; // values as the solver has them
  const pending = {}; // values that it is to have
  const section = { rows: new Array(POINTS), count: 0 };
  const growth = new Float64Array(MOST);
  let parameters = [];
  let view = live.views[0];
  let now = null; // the turn that is shown
  let next = null;
  let ideal = null;
  let box = null;
  let phase = 0; // of the shown turn
  let playing = true;
  let last = 0; // time of the last frame
  let busy = true;
  let joined = true; // the watched motion is where the settled one is
  let stamp = 0;
  let seen = fresh();
  let written = null; // timer of the address

  // ---- the worker

  const source = URL.createObjectURL(new Blob([live.text], { type: "text/javascript" }));
  const setup = { solver: live.solver, ideal: live.ideal, scene: live.scene, section: live.columns };

  function solver(answered) {
    const worker = new Worker(source);
    worker.onmessage = (event) => answered(event.data);
    worker.onerror = (event) => answered({ what: "trouble", words: event.message });
    worker.postMessage({ what: "begin", data: setup });
    return worker;
  }

  jointplay.worker = solver; // for others that compute
  element("live").hidden = false; // without scripts it stays hidden
  const worker = solver(answered);

  function ask(what, more) {
    busy = true;
    worker.postMessage({ what, stamp, ...more });
  }

  function answered(answer) {
    busy = false;
    if (answer.what === "trouble") say(`The solver in this page cannot go on: ${answer.words}`);
    else if (answer.what === "begin") begin(answer.parameters);
    else if (answer.what === "set") refused(answer.refused);
    else if (answer.stamp === stamp) ANSWERS[answer.what](answer);
  }

  const ANSWERS = {
    turn(answer) {
      seen.status = answer.status || seen.status;
      tell();
      if (answer.turn.time.length === 0) return;
      if (now && now.stamp === stamp) next = { ...answer.turn, stamp };
      else show({ ...answer.turn, stamp });
    },
    without(answer) {
      ideal = { ...answer, stamp, view };
      draw();
    },
    on(answer) {
      answer.growth.forEach((each, i) => {
        if (seen.turns === verdict.SETTLE) [section.count, joined] = [0, false];
        answer.section[i].forEach((row) => { section.rows[section.count++ % POINTS] = row; });
        seen.turns += 1;
        if (seen.turns <= verdict.SETTLE) return;
        growth[seen.counted++] = each;
        answer.apart[i].forEach((joint) => { seen.separations[joint] = (seen.separations[joint] || 0) + 1; });
      });
      seen.status = answer.status || seen.status;
      drawSection();
      tell();
    },
    reset() {},
    scan() {},
  };

  function fresh() {
    const none = Object.fromEntries((live.contacts || []).map((name) => [name, 0]));
    return { turns: 0, counted: 0, status: "", growth, separations: none, points: [], tolerance: 1, told: "" };
  }

  // Everything that was found belongs to other values now.
  function renew() {
    stamp += 1;
    seen = fresh();
    section.count = 0;
    next = null;
    joined = true;
    tell();
  }

  // ---- the verdict

  function lately() {
    const count = Math.min(section.count, verdict.LOOKED_AT, POINTS);
    return Array.from({ length: count }, (_, i) => place(section.rows[(section.count - count + i) % POINTS]));
  }

  function place(row) {
    return view.section.columns.map((column, k) => row[column] * view.section.factors[k]);
  }

  function tell() {
    seen.points = section.count ? lately() : [];
    seen.tolerance = 1e-4 * extent();
    const words = verdict.words(seen);
    if (words === seen.told) return;
    if (words.split(/[:;.]/)[0] !== seen.told.split(/[:;.]/)[0]) jointplay.say(words); // numbers alone are not read aloud
    seen.told = words;
    element("live-verdict").textContent = words;
    element("live-verdict").dataset.turns = seen.turns;
  }

  // A size of the section by which points are told apart: of a bearing its clearance, else what they span.
  function extent() {
    if (view.circle) return clearance() * view.section.factors[0];
    const ends = plots.span(seen.points.map((each) => each[0]));
    return Math.max(ends[1] - ends[0], 1e-3);
  }

  // The same of points of a map, whose clearance may be another.
  function tolerance({ value, across, section: rows }) {
    const { axes } = jointplay.diagram.asked();
    const own = [value, across][axes.findIndex(({ key }) => key === view.clearance)];
    if (view.circle) return 1e-4 * view.section.factors[0] * (own || clearance());
    const ends = plots.span(rows.map((row) => place(row)[0]));
    return 1e-4 * Math.max(ends[1] - ends[0], 1e-3);
  }

  function say(words) {
    element("live-verdict").textContent = words;
  }

  // ---- sliders

  function begin(found) {
    parameters = found;
    const main = parameters.filter((each) => live.first.includes(each.key));
    const rest = parameters.filter((each) => !main.includes(each));
    element("live-sliders").replaceChildren(...main.map((each) => sliders.made(each, held, wish)));
    element("live-more").replaceChildren(...rest.map((each) => sliders.made(each, held, wish)));
    element("live-more").parentElement.hidden = rest.length === 0;
    parameters.forEach((each) => { nominal[each.key] = held[each.key] = each.value; });
    parameters.forEach((each) => sliders.show(each, held));
    read(jointplay.view);
    if (jointplay.diagram) jointplay.diagram.begin(parameters, { solver, held, wish, place: (row) => place(row), tolerance, words: () => view.section.words });
    element("live").dataset.ready = "yes";
    requestAnimationFrame(frame);
  }

  function wish(key, value) {
    pending[key] = value;
    element(`live-${key}-refused`).textContent = "";
  }

  function send() {
    Object.entries(pending).forEach(([key, value]) => {
      held[key] = value;
      delete pending[key];
      sent[key] = value;
      sliders.show(parameters.find((each) => each.key === key), held);
    });
    renew();
    ask("set", { values: { ...sent } });
  }

  const sent = {}; // values on the way
  const good = {}; // values that were accepted, beside the nominal ones

  function refused(words) {
    Object.keys(sent).forEach((key) => {
      if (words[key]) {
        held[key] = key in good ? good[key] : nominal[key];
        element(`live-${key}-refused`).textContent = words[key];
        if (!(key in pending)) sliders.show(parameters.find((each) => each.key === key), held);
      } else {
        good[key] = sent[key];
      }
      delete sent[key];
    });
    command();
    clearTimeout(written);
    written = setTimeout(write, 300); // an address that changes with every pixel is refused by browsers
    if (jointplay.diagram) jointplay.diagram.draw();
  }

  // ---- address, study and command

  function changed() {
    return parameters.filter((each) => held[each.key] !== nominal[each.key]);
  }

  function write() {
    store("live", changed().map((each) => `${each.key}:${held[each.key]}`).join(" ") || null);
    store("bearing", view === live.views[0] ? null : view.name);
  }

  function read(address) {
    const given = Object.fromEntries((address.get("live") || "").split(" ").filter(Boolean).map((each) => each.split(":")));
    parameters.forEach(({ key }) => {
      const value = key in given ? Number(given[key]) : nominal[key];
      if (value !== held[key]) wish(key, value);
    });
    choose(live.views.find((each) => each.name === address.get("bearing")) || live.views[0]);
    command();
  }

  function command() {
    const sets = changed().map((each) => `'${live.paths[each.key]}=${held[each.key]}'`);
    element("live-command").textContent = `jointplay run ${live.file}${sets.length ? " --set " + sets.join(" ") : ""}`;
  }

  function choose(wanted) {
    view = wanted;
    ideal = now = next = null;
    if (element("live-view")) element("live-view").value = view.name;
    drawSection();
  }

  // ---- pictures

  function show(turn) {
    now = turn;
    if (live.scene) {
      now.scene = { links: live.scene.links.map((link, k) => ({ ...link, frames: now.frames[k] })), pins: live.scene.pins };
      box = stage.bounds(now.scene, box || undefined);
    }
    const [x, y, force] = now.values;
    const size = view.circle ? clearance() : 1;
    now.journal = new Float64Array(2 * x.length);
    for (let i = 0; i < x.length; i += 1) now.journal.set([x[i] / size, y[i] / size], 2 * i);
    now.reach = now.journal.reduce((most, each) => Math.max(most, Math.abs(each)), 0);
    now.force = force;
    now.strongest = force.reduce((most, each) => Math.max(most, Math.abs(each) || 0), 0);
    draw();
  }

  function clearance() {
    return held[view.clearance] || view.circle;
  }

  function sample() {
    const index = Math.round(phase * (now.time.length - 1));
    return Math.max(0, Math.min(now.time.length - 1, index));
  }

  function draw() {
    if (!now) return;
    const at = sample();
    if (live.scene) stage.linkage(element("live-linkage"), now.scene, box, at);
    if (view.circle) stage.bearing(element("live-orbit"), now, [0, now.time.length - 1], at, now.strongest);
    else pictures.plane(now, view, at);
    pictures.force(now, view, at, ideal);
    element("live-phase").value = Math.round(1000 * phase);
  }

  function drawSection() {
    pictures.section(section.rows.slice(0, Math.min(section.count, POINTS)).map(place), view, 0.01 * extent());
    element("live-points").textContent = `${section.count} section points${section.count > POINTS ? `, the last ${POINTS} drawn` : ""}`;
  }

  // ---- frames

  function frame(moment) {
    const passed = Math.min(0.1, (moment - last) / 1000);
    last = moment;
    if (playing && now) {
      phase = pictures.after(phase, passed, now.events, element("live-slow").checked);
      if (phase >= 1 && next) {
        phase -= 1;
        show(next);
        next = null;
      }
      phase = Math.min(phase, 1);
      draw();
    }
    if (!busy) work();
    requestAnimationFrame(frame);
  }

  // One thing a frame: what a person waits for first.
  function work() {
    const wanted = [...view.orbit, view.force];
    if (Object.keys(pending).length) send();
    else if (seen.status) return;
    else if (!now || now.stamp !== stamp || (!next && playing)) {
      ask("turn", { wanted, samples: SAMPLES, join: !joined });
      joined = true;
    } else if (view.ideal && live.ideal && (!ideal || ideal.stamp !== stamp || ideal.view !== view)) ask("without", { wanted: [view.ideal], samples: SAMPLES });
    else if (seen.turns < MOST) ask("on", { budget: BUDGET, most: MOST - seen.turns });
  }

  function play() {
    playing = !playing;
    element("live-play").textContent = playing ? "Pause" : "Play";
  }

  function restart() {
    parameters.forEach((each) => wish(each.key, nominal[each.key]));
    worker.postMessage({ what: "reset", stamp });
  }

  element("live-play").addEventListener("click", play);
  element("live-reset").addEventListener("click", restart);
  element("live-phase").addEventListener("input", () => {
    if (playing) play();
    phase = Number(element("live-phase").value) / 1000;
    draw();
  });
  if (element("live-view")) {
    element("live-view").addEventListener("change", () => {
      choose(live.views.find((each) => each.name === element("live-view").value));
      write();
    });
  }
  addEventListener("resize", () => { draw(); drawSection(); });

  jointplay.parts.push({
    tapped(panel, x, y) {
      panel.over.forEach((name, axis) => {
        const key = live.varied[name];
        const factor = panel.factors[axis];
        if (key && key in held) wish(key, [x, y][axis] / factor);
      });
    },
    pressed(key) {
      if (key !== " " || data.motion) return false;
      play();
      return true;
    },
    show(address) {
      if (parameters.length) read(address);
      draw();
      drawSection();
    },
  });
}

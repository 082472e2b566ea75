"use strict";
// The page that computes: sliders lead a solver in a worker; what it answers is drawn and put into words.

if (jointplay.data.live) {
  const { data, element, store } = jointplay;
  const live = data.live;
  const SAMPLES = 720; // of the watched turn
  const BUDGET = 10; // ms of a frame, for the motion that runs ahead
  const REST = 80; // ms between two frames while a diagram needs the processor

  const nominal = {};
  const held = {}; // values as the solver has them
  const pending = {}; // values that it is to have
  const sent = {}; // values on the way
  const good = {}; // values that were accepted, beside the nominal ones
  let parameters = [];
  let view = live.views[0];
  let next = null; // the turn after the one that is watched
  let playing = true;
  let last = 0; // time of the last frame
  let open = 1; // questions to the solver that it has not answered
  let joined = true; // the watched motion is where the settled one is
  let stamp = 0;
  let written = null; // timer of the address

  live.views.forEach((each, number) => { each.section.columns = [2 * number, 2 * number + 1]; }); // of a section's rows
  const clearance = () => held[view.clearance] || view.circle;
  const ahead = followed.made({ view: () => view, clearance, contacts: live.solver.joints, limits: live.limits });
  const turn = watched.made({ scene: live.scene, view: () => view, clearance });

  // ---- the worker

  const source = URL.createObjectURL(new Blob([live.text], { type: "text/javascript" }));
  const setup = { solver: live.solver, ideal: live.ideal, scene: live.scene, section: live.views.flatMap((each) => each.section.of) };

  function solver(told) {
    const made = new Worker(source);
    made.onmessage = (event) => told(event.data);
    made.onerror = (event) => told({ what: "trouble", words: event.message });
    made.postMessage({ what: "begin", data: setup });
    return made;
  }

  jointplay.worker = solver; // for others that compute
  element("live").hidden = false; // without scripts it stays hidden
  const worker = solver(answered);

  function ask(what, more) {
    open += 1;
    worker.postMessage({ what, stamp, ...more });
  }

  function answered(answer) {
    open -= 1;
    if (answer.what === "trouble") say(`The solver in this page cannot go on: ${answer.words}`);
    else if (answer.what === "begin") begin(answer.parameters);
    else if (answer.what === "set") refused(answer.refused);
    else if (answer.stamp === stamp) ANSWERS[answer.what](answer);
  }

  const ANSWERS = {
    turn(answer) {
      ahead.ended(answer.status);
      if (answer.turn.time.length === 0) return;
      if (turn.holds(stamp)) next = { ...answer.turn, stamp };
      else turn.show({ ...answer.turn, stamp });
    },
    without(answer) {
      turn.beside({ ...answer, stamp, view });
      ahead.beside(answer.force);
    },
    on(answer) {
      if (ahead.add(answer)) joined = false;
    },
    reset() {},
  };

  function renew() {
    stamp += 1;
    ahead.renew();
    next = null;
    joined = true;
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
    element("live-more").replaceChildren(...rest.map((each) => sliders.made(each, held, wish)), ...live.solver.fixed.map(sliders.fixed));
    element("live-more").parentElement.hidden = element("live-more").childElementCount === 0;
    parameters.forEach((each) => { nominal[each.key] = held[each.key] = each.value; });
    parameters.forEach((each) => sliders.show(each, held));
    read(jointplay.view);
    jointplay.diagram.begin(parameters, { solver, held, wish, placed: ahead.placed, tolerance: ahead.tolerance, view: () => view, limits: live.limits });
    element("live").dataset.ready = "yes";
    requestAnimationFrame(frame);
  }

  function wish(key, value) {
    pending[key] = value;
    element(`live-${key}-refused`).textContent = "";
  }

  // The values that are asked for, and at once what follows from them, so that a verdict moves with the slider.
  function send() {
    Object.entries(pending).forEach(([key, value]) => {
      held[key] = value;
      delete pending[key];
      sent[key] = value;
      sliders.show(parameters.find((each) => each.key === key), held);
    });
    renew();
    ask("set", { values: { ...sent } });
    askIdeal();
    askTurn();
    askOn();
  }

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
    jointplay.diagram.draw();
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
    const sets = changed().flatMap(({ key }) => live.paths[key].map((path) => `'${path}=${held[key]}'`));
    element("live-command").textContent = `jointplay run ${live.file}${sets.length ? " --set " + sets.join(" ") : ""}`;
  }

  function choose(wanted) {
    view = wanted;
    next = null;
    turn.forget();
    if (element("live-view")) element("live-view").value = view.name;
    ahead.draw();
    jointplay.diagram.draw();
  }

  // ---- frames

  function frame(moment) {
    requestAnimationFrame(frame);
    if (jointplay.diagram.computes() && !Object.keys(pending).length && moment - last < REST) return;
    const passed = Math.min(0.1, (moment - last) / 1000);
    last = moment;
    if (playing && turn.shows() && turn.passed(passed, next)) next = null;
    if (!open) work();
  }

  // One thing a frame: what a person waits for first.
  function work() {
    if (Object.keys(pending).length) send();
    else if (ahead.status()) return;
    else if (live.ideal && !turn.hasBeside(stamp)) askIdeal();
    else if (!turn.holds(stamp) || (!next && playing)) askTurn();
    else if (ahead.turns() < followed.MOST && !jointplay.diagram.computes()) askOn();
  }

  function askTurn() {
    ask("turn", { wanted: [...view.orbit, view.force], samples: SAMPLES, join: !joined });
    joined = true;
  }

  function askIdeal() {
    if (live.ideal) ask("without", { wanted: view.ideal ? [view.ideal] : [], samples: SAMPLES });
  }

  function askOn() {
    ask("on", { budget: BUDGET, most: followed.MOST - ahead.turns(), closely: ahead.closely() });
  }

  function play() {
    playing = !playing;
    element("live-play").textContent = playing ? "Pause" : "Play";
  }

  function restart() {
    parameters.forEach((each) => wish(each.key, nominal[each.key]));
    ask("reset");
  }

  element("live-play").addEventListener("click", play);
  element("live-reset").addEventListener("click", restart);
  element("live-phase").addEventListener("input", () => {
    if (playing) play();
    turn.seek(Number(element("live-phase").value) / 1000);
  });
  if (element("live-view")) {
    element("live-view").addEventListener("change", () => {
      choose(live.views.find((each) => each.name === element("live-view").value));
      write();
    });
  }
  addEventListener("resize", () => { turn.draw(); ahead.draw(); });

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
      turn.draw();
      ahead.draw();
    },
  });
}

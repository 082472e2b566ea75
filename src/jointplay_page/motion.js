"use strict";
// The mechanism in motion as it was recorded: played, stepped through, led to a moment.

if (jointplay.data.motion) {
  const { data, element, numbers, store } = jointplay;
  const motion = data.motion;
  const time = numbers(motion.time);
  const links = motion.links.map((link) => ({ ...link, frames: numbers(link.frames) }));
  const bearings = motion.bearings.map((each) => ({ ...each, journal: numbers(each.journal), force: each.force && numbers(each.force) }));
  const guides = motion.guides.map((each) => ({ ...each, ways: numbers(each.ways), touch: each.touch && numbers(each.touch), force: each.force && numbers(each.force) }));
  const slider = element("frame");
  const period = Number.isFinite(motion.period) && motion.period > 0 ? motion.period : time.at(-1) - time[0];
  const SECONDS = 3; // a turn takes, as it is played
  const TRAIL = 60; // frames of the journal's path that are drawn
  let frame = 0;
  let playing = null; // where and when it began

  const box = stage.bounds({ links, pins: motion.pins });
  const peak = (each) => (each.force ? each.force.reduce((most, f) => Math.max(most, Math.abs(f) || 0), 0) : 0);
  const [strongest, strongestAt] = [bearings.map(peak), guides.map(peak)];

  function draw() {
    stage.linkage(element("linkage"), { links, pins: motion.pins }, box, frame);
    bearings.forEach((each, number) => stage.bearing(element("bearing" + number), each, [frame - TRAIL, frame], frame, strongest[number]));
    guides.forEach((each, number) => stage.guide(element("guide" + number), each, frame, strongestAt[number]));
    slider.value = frame;
    element("moment").textContent = `${(1e3 * time[frame]).toFixed(2)} ms, ${(time[frame] / period).toFixed(3)} turns`;
    data.panels.forEach((panel, number) => {
      if (panel.over[0] === "time") jointplay.charts.mark(number, 0, time[frame] * panel.factors[0]);
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

"use strict";
// The turn that is watched: the mechanism and its bearing at a moment of it, the force over it.

const watched = (() => {
  const { element } = jointplay;

  function made({ scene, view, clearance }) {
    let now = null;
    let ideal = null; // the same mechanism without clearance
    let box = null;
    let phase = 0;

    function show(turn) {
      now = turn;
      if (scene) {
        now.scene = {
          links: scene.links.map((link, k) => ({ ...link, along: now.along[k], frames: now.frames[k] })),
          pins: scene.pins.map((pin, k) => ({
            ...pin, at: now.at[2 * k], block: pin.block && { ...pin.block, at: now.at[2 * k + 1] },
          })),
        };
        box = stage.bounds(now.scene, box || undefined);
      }
      const [x, y, force] = now.values;
      const size = view().circle ? clearance() : 1;
      now.journal = new Float64Array(2 * x.length);
      for (let i = 0; i < x.length; i += 1) now.journal.set([x[i] / size, y[i] / size], 2 * i);
      now.reach = now.journal.reduce((most, each) => Math.max(most, Math.abs(each)), 0);
      now.force = force;
      now.strongest = force.reduce((most, each) => Math.max(most, Math.abs(each) || 0), 0);
      draw();
    }

    function sample() {
      const index = Math.round(phase * (now.time.length - 1));
      return Math.max(0, Math.min(now.time.length - 1, index));
    }

    function draw() {
      if (!now) return;
      const at = sample();
      if (scene) stage.linkage(element("live-linkage"), now.scene, box, at);
      if (view().circle) stage.bearing(element("live-orbit"), now, [0, now.time.length - 1], at, now.strongest);
      else pictures.plane(now, view(), at);
      pictures.force(now, view(), at, ideal);
      element("live-phase").value = Math.round(1000 * phase);
      element("live-phase").setAttribute("aria-valuetext", `${Math.round(100 * phase)} % of a turn`);
    }

    function beside(turn) {
      ideal = turn;
      draw();
    }

    // Some seconds later, and on into the next turn where there is one; whether that was begun.
    function passed(seconds, next) {
      phase = pictures.after(phase, seconds, now.events, element("live-slow").checked);
      const begun = phase >= 1 && next !== null;
      if (begun) {
        phase -= 1;
        show(next);
      }
      phase = Math.min(phase, 1);
      draw();
      return begun;
    }

    function seek(share) {
      phase = share;
      draw();
    }

    function forget() {
      now = ideal = null;
    }

    // Whether it belongs to these values, and to what is looked at.
    const holds = (stamp) => now !== null && now.stamp === stamp;
    const hasBeside = (stamp) => ideal !== null && ideal.stamp === stamp && ideal.view === view();

    return { beside, draw, forget, hasBeside, holds, passed, seek, show, shows: () => now !== null };
  }

  return { made };
})();

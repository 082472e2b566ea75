"use strict";
// The motion that runs ahead, as far as it was followed: its section, what its tangent grew by, the verdict in words.

const followed = (() => {
  const POINTS = 4096; // of the section: the last ones
  const MOST = 4000; // turns after which it rests

  // `view` and `clearance` give what is looked at, and the clearance there as it is.
  function made({ view, clearance, contacts }) {
    const rows = [];
    const growth = new Float64Array(MOST);
    let count = 0;
    let seen = fresh();

    function fresh() {
      const none = Object.fromEntries(contacts.map((name) => [name, 0]));
      return { turns: 0, counted: 0, status: "", growth, separations: none, points: [], tolerance: 1, told: "" };
    }

    // Everything that was found belongs to other values now.
    function renew() {
      seen = fresh();
      count = 0;
      tell();
    }

    // Turns that were followed; whether the motion has settled with them, from where the section begins anew.
    function add(answer) {
      let settled = false;
      answer.growth.forEach((each, i) => {
        if (seen.turns === verdict.SETTLE) [count, settled] = [0, true];
        answer.section[i].forEach((row) => { rows[count++ % POINTS] = row; });
        seen.turns += 1;
        if (seen.turns <= verdict.SETTLE) return;
        growth[seen.counted++] = each;
        answer.apart[i].forEach((joint) => { seen.separations[joint] = (seen.separations[joint] || 0) + 1; });
      });
      ended(answer.status);
      draw();
      return settled;
    }

    function ended(status) {
      seen.status = status || seen.status;
      tell();
    }

    function place(row) {
      return view().section.columns.map((column, k) => row[column] * view().section.factors[k]);
    }

    function lately() {
      const last = Math.min(count, verdict.LOOKED_AT, POINTS);
      return Array.from({ length: last }, (_, i) => place(rows[(count - last + i) % POINTS]));
    }

    function tell() {
      seen.points = count ? lately() : [];
      seen.tolerance = 1e-4 * extent();
      const words = verdict.words(seen);
      if (words === seen.told) return;
      if (words.split(/[:;.]/)[0] !== seen.told.split(/[:;.]/)[0]) jointplay.say(words); // numbers alone are not read aloud
      seen.told = words;
      jointplay.element("live-verdict").textContent = words;
      jointplay.element("live-verdict").dataset.turns = seen.turns;
    }

    function spanned(points) {
      const ends = plots.span(points.map((each) => each[0]));
      return Math.max(ends[1] - ends[0], 1e-3);
    }

    // A size of the section by which points are told apart: of a bearing its clearance, else what they span.
    function extent() {
      return view().circle ? clearance() * view().section.factors[0] : spanned(seen.points);
    }

    // The same of points of a map, whose clearance may be another.
    function tolerance({ value, across, section }) {
      const { axes } = jointplay.diagram.asked();
      const own = [value, across][axes.findIndex(({ key }) => key === view().clearance)];
      if (view().circle) return 1e-4 * view().section.factors[0] * (own || clearance());
      return 1e-4 * spanned(section.map(place));
    }

    function draw() {
      pictures.section(rows.slice(0, Math.min(count, POINTS)).map(place), view(), 0.01 * extent());
      const drawn = count > POINTS ? `, the last ${POINTS} drawn` : "";
      jointplay.element("live-points").textContent = `${count} section points${drawn}`;
    }

    return { add, draw, ended, place, renew, tolerance, turns: () => seen.turns, status: () => seen.status };
  }

  return { MOST, made };
})();

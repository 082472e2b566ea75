"use strict";
// The motion that runs ahead, as far as it was followed: its section, what its tangent grew by, the verdict in words.

const followed = (() => {
  const POINTS = 4096; // of the section: the last ones
  const MOST = 4000; // turns after which it rests

  // `view` and `clearance` give what is looked at, and the clearance there as it is.
  function made({ view, clearance, contacts, limits }) {
    const rows = [];
    const growth = new Float64Array(MOST);
    let count = 0;
    let seen = fresh();
    let ideal = null; // largest forces without clearance

    function fresh() {
      const none = Object.fromEntries(contacts.map((name) => [name, 0]));
      return { turns: 0, counted: 0, status: "", growth, separations: none, force: {}, speed: {}, points: [], tolerance: 1, told: "" };
    }

    // Begin to count anew: what was before had not settled.
    function recount() {
      Object.assign(seen, { ...fresh(), turns: seen.turns, told: seen.told });
    }

    // Everything that was found belongs to other values now.
    function renew() {
      seen = fresh();
      count = 0;
      jointplay.element("live-verdict").dataset.turns = 0;
    }

    // Turns that were followed; whether the motion has settled with them, from where the section begins anew.
    function add(answer) {
      let settled = false;
      answer.growth.forEach((each, i) => {
        if (seen.turns === verdict.BEGUN || seen.turns === verdict.SETTLE) recount();
        if (seen.turns === verdict.SETTLE) [count, settled] = [0, true];
        answer.section[i].forEach((row) => { rows[count++ % POINTS] = row; });
        seen.turns += 1;
        growth[seen.counted++] = each;
        answer.apart[i].forEach((joint) => { seen.separations[joint] = (seen.separations[joint] || 0) + 1; });
        raise(answer.largest[i]);
      });
      ended(answer.status);
      draw();
      return settled;
    }

    function raise(largest) {
      ["force", "speed"].forEach((name) => Object.entries(largest[name]).forEach(([joint, value]) => {
        seen[name][joint] = Math.max(seen[name][joint] || 0, value);
      }));
    }

    // Largest forces of the same mechanism without clearance, where they are known.
    function beside(force) {
      ideal = force;
      tell();
    }

    function ended(status) {
      seen.status = status || seen.status;
      tell();
    }

    // A point of the section in the units of its picture: in a bearing of clearances, by default the present one.
    function place(row, size = view().circle ? clearance() : 1) {
      return view().section.columns.map((column) => row[column] / size);
    }

    function lately() {
      const last = Math.min(count, verdict.LOOKED_AT, POINTS);
      return Array.from({ length: last }, (_, i) => place(rows[(count - last + i) % POINTS]));
    }

    function tell() {
      if (!seen.turns && !seen.status) return; // what was said before stands until there is more to say
      seen.points = count ? lately() : [];
      seen.tolerance = 1e-4 * extent();
      const judged = { ...seen, ideal };
      const words = verdict.words(judged, limits);
      const { grade, strained, fastest } = verdict.graded(judged, limits);
      jointplay.element("live-verdict").dataset.grade = grade;
      if (words === seen.told) return;
      const unlike = (told) => told.replace(/[\d.]+/g, ""); // numbers alone are not read aloud
      if (unlike(words) !== unlike(jointplay.element("live-verdict").textContent)) jointplay.say(words);
      seen.told = words;
      jointplay.element("live-verdict").textContent = words;
      jointplay.element("live-verdict").dataset.turns = seen.turns;
      const short = [grade || "no grade yet", strained && `${verdict.number(seen.force[strained])} N`, fastest > 0 && verdict.speedText(fastest)];
      jointplay.element("live-short").textContent = short.filter(Boolean).join(", ");
    }

    function spanned(points) {
      const ends = plots.span(points.map((each) => each[0]));
      return Math.max(ends[1] - ends[0], 1e-3);
    }

    // A size of the section by which points are told apart: of a bearing its clearance, else what they span.
    function extent(points = seen.points) {
      return view().circle ? 1 : spanned(points);
    }

    // The value of the bearing's clearance in a row of a diagram or map.
    function sizeOf({ value, across }) {
      const { axes } = jointplay.diagram.asked();
      const own = [value, across][axes.findIndex(({ key }) => key === view().clearance)];
      return view().circle ? own || clearance() : 1;
    }

    const placed = (row) => row.section.map((point) => place(point, sizeOf(row)));
    const tolerance = (row) => 1e-4 * extent(placed(row));

    function draw() {
      pictures.section(rows.slice(0, Math.min(count, POINTS)).map((row) => place(row)), view(), 0.01 * extent());
      const drawn = count > POINTS ? `, the last ${POINTS} drawn` : "";
      jointplay.element("live-points").textContent = `${count} section points${drawn}`;
    }

    // Whether largest forces are looked for within steps too: in all turns that decide a verdict.
    const closely = () => seen.turns < verdict.SETTLE + verdict.LOOKED_AT;
    return { add, beside, closely, draw, ended, placed, renew, tolerance, turns: () => seen.turns, status: () => seen.status };
  }

  return { MOST, made };
})();

"use strict";
// In a worker, behind the solver's text: motions that are followed as far as the time of a frame affords.
// `shown` is the motion that is watched, turn by turn; `ahead` runs on, for section, period and exponent;
// `ideal` is the same mechanism without clearance. A scan follows one motion for each value of a parameter.

const APART = ["separation", "impact"]; // kinds of event by which a journal leaves its bearing
const BUDGET = 4000; // ms after which a turn is given up
const SEEN = 4; // turns of a value in which largest forces are looked for between the solver's own points
const PACE = 200; // ms a turn of many, by which they are

let given, shown, ahead, ideal;
let turns = 0; // that `ahead` has followed since the last change
let grown = 0; // logarithm of its tangent so far
let lost = false; // whether it, or the watched one, could not go on

function begin({ data }) {
  given = data;
  shown = makeSolver(given.solver);
  ahead = makeSolver(given.solver);
  ideal = typeof makeIdeal === "function" && given.ideal ? makeIdeal(given.ideal) : null;
  return { parameters: shown.parameters };
}

// Values that are refused are told; the others hold from now on, and the motion goes on from where it is.
// After trouble, and in another period, whose phase is another, the motion begins at its start again.
function set({ values }) {
  const period = ahead.period();
  const tried = (keys) => keys.filter((key) => {
    refused[key] = shown.set(key, values[key]) || ahead.set(key, values[key]);
    if (!refused[key] && ideal && ideal.parameters.some((each) => each.key === key)) ideal.set(key, values[key]);
    return refused[key];
  });
  const refused = {};
  tried(tried(Object.keys(values))); // lengths may close together only: once more when the others hold
  if (lost || ahead.period() !== period) reset();
  turns = 0;
  return { refused: Object.fromEntries(Object.entries(refused).filter(([, why]) => why)) };
}

function reset() {
  [shown, ahead].forEach((each) => each.reset());
  turns = grown = 0;
  lost = false;
  return {};
}

// Quantities over time; of several labels their sum.
function picked(out, wanted) {
  return wanted.map(([quantity, ...labels]) => Float64Array.from(out.time, (_, i) => labels.reduce((sum, label) => sum + out[quantity][label][i], 0)));
}

// Why a run ended before its turns were done; empty where it did not.
function ended(out, wanted) {
  if (out.status !== "ok") return out.meaning || out.status.replaceAll("_", " ");
  return out.turns_done > wanted - 1e-6 ? "" : "a turn takes too long here";
}

// What a section is drawn by: the wanted quantities of its points, a row each.
function points(solver, rows) {
  const measured = rows.length ? solver.measured(rows) : null;
  return rows.map((_, i) => given.section.map(([quantity, label]) => measured[quantity][label][i]));
}

// A turn of the watched motion, sampled finely; it joins the one that has settled where both begin a turn.
function turn({ wanted, samples, join }) {
  if (join && Number.isInteger(turns)) shown.setState(ahead.state());
  const begun = shown.time();
  const out = shown.run(1, { samples, tangent: false, budget_ms: BUDGET });
  const count = out.time.length;
  const frames = given.scene ? given.scene.links.map(() => new Float64Array(3 * count)) : [];
  for (let at = 0; frames.length && at < count; at += 1) {
    const places = shown.places(at);
    given.scene.links.forEach((link, k) => frames[k].set(places[link.name], 3 * at));
  }
  const along = frames.map((_, k) => given.scene.links[k].along.map((at) => shown.along(given.scene.links[k].name, at)));
  const pins = (given.scene ? given.scene.pins : []).flatMap((pin) => [pin, pin.block || pin]);
  const at = pins.map((pin) => shown.along(pin.link, pin.at));
  const events = out.events.map((each) => ({ ...each, turn: (each.time - begun) / shown.period() }));
  const time = Float64Array.from(out.time, (each) => (each - begun) / shown.period());
  const status = ended(out, 1);
  lost = lost || status !== "";
  return { status, turn: { time, values: picked(out, wanted), frames, along, at, events } };
}

// The ideal mechanism's last of three turns: its start is not quite its steady motion.
function without({ wanted, samples }) {
  if (!ideal) return { values: null, force: null };
  ideal.reset();
  const before = ideal.run(2, { budget_ms: BUDGET });
  const begun = ideal.time();
  const out = ideal.run(1, { samples, extremes: true, budget_ms: BUDGET });
  if (ended(before, 2) || ended(out, 1)) return { values: null, force: null };
  const time = Float64Array.from(out.time, (each) => (each - begun) / ideal.period());
  return { time, values: picked(out, wanted), force: out.largest.force };
}

const apart = (events) => events.filter((each) => APART.includes(each.kind)).map((each) => each.joint);

// As many turns as the budget affords, whole ones: the section points of each, what its tangent grew by, separations,
// largest forces and impact speeds.
function on({ budget, most, closely }) {
  const end = performance.now() + budget;
  const found = { section: [], growth: [], apart: [], largest: [], status: "" };
  while (!found.status && found.growth.length < most && performance.now() < end) {
    const out = ahead.run(1, { closely, tangent: true, extremes: true, budget_ms: BUDGET });
    found.status = ended(out, 1);
    lost = lost || found.status !== "";
    if (lost) break;
    turns += 1;
    found.section.push(points(ahead, out.section));
    found.growth.push(out.exponent.sum - grown);
    grown = out.exponent.sum;
    found.apart.push(apart(out.events));
    found.largest.push(out.largest);
  }
  return found;
}

// For each value, its section points after a transient, its separations, largest forces and impact speeds, and the
// largest forces without clearance; the next value goes on from there. In a map, `line` is the value of the other slider.
function scan({ values, key, across, list, line, transient, kept, samples }) {
  set({ values });
  const why = across === null ? "" : set({ values: { [across]: line } }).refused[across] || "";
  reset();
  for (const value of list) {
    const row = { value, across: line, section: [], apart: [], status: why || set({ values: { [key]: value } }).refused[key] || "" };
    const followed = (length, more) => {
      const out = row.status ? null : ahead.run(length, { ...more, budget_ms: BUDGET + PACE * length });
      row.status = out ? ended(out, length) : row.status;
      return out;
    };
    if (transient) followed(transient);
    const parts = [followed(kept - SEEN, { extremes: true }), followed(SEEN, { extremes: true, closely: true })];
    if (row.status) reset();
    else {
      row.section = points(ahead, parts.flatMap((each) => each.section));
      row.apart = parts.flatMap((each) => apart(each.events));
      row.largest = parts.map((each) => each.largest);
      row.ideal = without({ wanted: [], samples }).force;
    }
    postMessage({ what: "row", row });
  }
  return {};
}

// Some turns of motions that begin in given states, or, where there is none, at the start and after a transient.
function point({ values, states, transient, turns: drawn, samples, wanted }) {
  reset();
  const why = Object.values(set({ values }).refused).join("; ");
  if (why) return { why };
  const motions = states.map((state) => {
    shown.reset();
    if (state) shown.setState(state);
    let status = "";
    const settling = state ? 0 : transient;
    for (let done = 0; !status && done < settling; done += 1) status = ended(shown.run(1, { budget_ms: BUDGET }), 1);
    const begun = shown.time();
    const out = shown.run(drawn, { samples, budget_ms: BUDGET });
    const time = Float64Array.from(out.time, (each) => (each - begun) / shown.period());
    return { status: status || ended(out, drawn), time, values: picked(out, wanted) };
  });
  return { motions };
}

const WHAT = { begin, set, reset, turn, without, on, scan, point };

onmessage = ({ data }) => {
  try {
    postMessage({ what: data.what, stamp: data.stamp, ...WHAT[data.what](data) });
  } catch (error) {
    postMessage({ what: "trouble", words: String(error.message || error) });
  }
};

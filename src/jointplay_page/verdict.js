"use strict";
// What a motion is, in words, by rules that the page states: its grade, as an assessment gives it, its period, its
// largest exponent.

const verdict = (() => {
  const SETTLE = 50; // turns after a change that count for nothing
  const LOOKED_AT = 64; // last turns in which a motion must repeat
  const REPEATS = 4; // a period is believed where they hold it this often
  const BATCHES = 40;
  const BEGUN = 10; // turns after a change that a first verdict leaves out, where there are more
  const ERRORS = 3; // standard errors by which an exponent must differ from 0
  const VANISHED = "largest exponent −∞: where the joint sticks, every small difference vanishes";
  const FOLLOWING = 2 / Math.sqrt(BATCHES); // correlation of batch means from which their error is too small, and widened

  // Smallest period of points, rows of coordinates, that all lie within `tolerance`; 0 if there is none.
  function period(points, tolerance) {
    for (let p = 1; p <= points.length / REPEATS; p += 1) {
      if (points.every((point, i) => i < p || point.every((each, k) => Math.abs(each - points[i % p][k]) <= tolerance))) return p;
    }
    return 0;
  }

  // Mean and standard error of what a tangent grew by each turn, by batch means; null where it is too short.
  function exponent(growth, count = growth.length) {
    const size = Math.floor(count / BATCHES);
    if (size < 1) return null;
    const means = Array.from({ length: BATCHES }, (_, b) => {
      let sum = 0;
      for (let i = count - (b + 1) * size; i < count - b * size; i += 1) sum += growth[i];
      return sum / size;
    });
    const mean = means.reduce((a, b) => a + b) / BATCHES;
    if (!Number.isFinite(mean)) return { mean: -Infinity, error: 0, wide: 0 }; // it vanished: what is left has no direction
    const off = means.map((each) => each - mean);
    const square = off.reduce((sum, each) => sum + each * each, 0);
    const follows = off.slice(1).reduce((sum, each, i) => sum + each * off[i], 0) / (square || 1);
    const error = Math.sqrt(square / (BATCHES - 1) / BATCHES);
    return { mean, error, wide: follows > FOLLOWING ? error * Math.sqrt((1 + follows) / (1 - follows)) : error };
  }

  function number(value, digits = 3) {
    return Number.isFinite(value) ? String(Number(value.toPrecision(digits))).replace("-", "−") : "–";
  }

  function signed({ mean, error }) {
    const least = Math.max(error, 1e-4);
    const places = Math.max(0, Math.min(4, 1 - Math.floor(Math.log10(least))));
    return `${mean < 0 ? "−" : "+"}${Math.abs(mean).toFixed(places)} ± ${least.toFixed(places)}`;
  }

  // Of a table of numbers, the key and value of the largest.
  function most(table) {
    return Object.entries(table).reduce((found, each) => (each[1] > found[1] ? each : found), ["", -Infinity]);
  }

  // How hard the mechanism is worked, by the limits of an assessment: the grade, the joint that hits hardest, and the
  // one whose largest force is the largest over that without clearance. No grade where those forces are not known.
  function graded({ separations, force, speed, ideal }, limits) {
    const least = limits.negligible * Math.max(0, ...Object.values(ideal || {}));
    const over = Object.fromEntries(Object.keys(force).filter((joint) => ideal && ideal[joint] > least).map((joint) => [joint, force[joint] / ideal[joint]]));
    const [[strained, ratio], [hit, fastest]] = [most(over), most(speed)];
    const lost = Object.values(separations).some((count) => count > 0);
    const hard = fastest >= limits.hard || ratio >= limits.heavy;
    const gentle = !(fastest >= limits.gentle) && ratio < limits.light;
    const known = strained === "" ? -1 : (lost ? (hard ? 3 : (gentle ? 1 : 2)) : 0);
    return { grade: limits.names[known] || "", lost, strained, ratio, hit: fastest > 0 ? hit : most(separations)[0], fastest: Math.max(0, fastest) };
  }

  function often(count) {
    return { 1: "once a turn", 2: "twice a turn" }[number(count)] || `${number(count)} times a turn`;
  }

  const speedText = (speed) => (speed < 0.2 ? `${number(1e3 * speed)} mm/s` : `${number(speed)} m/s`);

  const capital = (text) => text[0].toUpperCase() + text.slice(1);

  // The sentence of an assessment on a motion that has been followed for so many turns.
  function worked(seen, limits) {
    const { grade, lost, strained, ratio, hit, fastest } = graded(seen, limits);
    const times = often(seen.separations[hit] / seen.counted);
    const others = Object.keys(seen.separations).filter((label) => label !== hit && seen.separations[label] > 0);
    const at = (label) => (seen.speed[label] > 0 ? ` and at ${speedText(seen.speed[label])}` : "");
    const called = (label) => (label in limits.corners ? `the ${limits.corners[label]}` : `${limits.body} ${label}`);
    if (!grade) return lost ? `${hit ? `${capital(called(hit))} loses contact` : "Contact is lost"} ${times}${fastest > 0 ? ` and hits at ${speedText(fastest)}; forces of ideal joints are not known, and there is no grade without them` : ""}.` : "";
    const force = ratio < limits.alike && ratio > 1 / limits.alike ? `forces are those of ideal joints, within ${number(100 * (limits.alike - 1))} %`
      : `${called(strained)} carries up to ${number(seen.force[strained])} N, ${number(ratio)} times as much as with ideal joints`;
    const also = others.map((label) => `, ${called(label)} ${often(seen.separations[label] / seen.counted)}${at(label)}`).join("");
    const contact = lost ? `${called(hit)} loses contact ${times} and hits at ${speedText(fastest)}${also}` : "contact is never lost";
    return `${capital(grade)}: ${contact}; ${force}.`;
  }

  function kind(repeats, found) {
    if (repeats) return repeats === 1 ? "The motion repeats every turn" : `The motion repeats every ${repeats} turns`;
    if (found && found.mean > ERRORS * found.wide) return "The motion is chaotic";
    if (found && found.mean < -ERRORS * found.wide) return "The motion is still settling";
    return "Whether the motion repeats is undecided: follow more turns";
  }

  // seen: turns since the change, how many of them count, status, points of the last turns, growth of each counted turn
  // of a motion that has settled, and of the counted turns separations, largest forces and impact speeds by joint.
  function words(seen, limits) {
    if (seen.status) return `Stopped: ${seen.status}.`;
    const said = seen.counted ? worked(seen, limits) : "";
    if (seen.turns <= SETTLE) return `Settling, ${seen.turns} of ${SETTLE} turns. ${said}`.trim();
    const enough = seen.points.length >= LOOKED_AT;
    const repeats = enough ? period(seen.points.slice(-LOOKED_AT), seen.tolerance) : 0;
    const found = exponent(seen.growth, seen.counted);
    const early = !enough && seen.counted <= LOOKED_AT; // later, there is no section
    const motion = early ? "Too few turns yet to tell whether the motion repeats" : kind(repeats, found);
    const grows = !found ? "" : (found.mean === -Infinity ? `; ${VANISHED}` : `; largest exponent ${signed(found)} per turn`);
    return `${said && `${said} `}${motion}${grows}. ${seen.counted} turns, after ${SETTLE} dropped.`;
  }

  return { BEGUN, SETTLE, LOOKED_AT, exponent, graded, number, period, speedText, words };
})();

if (typeof module !== "undefined") module.exports = verdict;

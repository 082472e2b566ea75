"use strict";
// What a motion is, in words, by rules that the page states: period, separations per turn, largest exponent.

const verdict = (() => {
  const SETTLE = 50; // turns after a change that count for nothing
  const LOOKED_AT = 64; // last turns in which a motion must repeat
  const REPEATS = 4; // a period is believed where they hold it this often
  const BATCHES = 40;
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

  function kind(repeats, found) {
    if (repeats) return repeats === 1 ? "repeats every turn" : `repeats every ${repeats} turns`;
    if (found && found.mean > ERRORS * found.wide) return "chaotic";
    if (found && found.mean < -ERRORS * found.wide) return "still settling";
    return "undecided: follow more turns";
  }

  // seen: turns since the change, status, points of the last turns, growth of each counted turn, separations.
  function words(seen) {
    if (seen.status) return `Stopped: ${seen.status}.`;
    if (!seen.counted) return `Settling: ${seen.turns} of ${SETTLE} turns.`;
    const enough = seen.points.length >= LOOKED_AT;
    const repeats = enough ? period(seen.points.slice(-LOOKED_AT), seen.tolerance) : 0;
    const found = exponent(seen.growth, seen.counted);
    const early = !enough && seen.counted <= LOOKED_AT; // later, there is no section
    const said = [early ? "too few turns yet to tell its period" : kind(repeats, found)];
    Object.entries(seen.separations).forEach(([joint, count]) => {
      said.push(`separations per turn${joint ? " at " + joint : ""}: ${number(count / seen.counted)}`);
    });
    if (found) said.push(found.mean === -Infinity ? VANISHED : `largest exponent ${signed(found)} per turn`);
    said[0] = said[0][0].toUpperCase() + said[0].slice(1);
    return `${said.join("; ")}. ${seen.counted} turns, after ${SETTLE} dropped.`;
  }

  return { SETTLE, LOOKED_AT, exponent, number, period, words };
})();

if (typeof module !== "undefined") module.exports = verdict;

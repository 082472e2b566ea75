"use strict";
// Sliders, each with its range and a number beside it that can be typed.

const sliders = (() => {
  const STEPS = 1000;

  function along(parameter, value) {
    const scale = parameter.scale === "log" ? Math.log : Number;
    return (STEPS * (scale(value) - scale(parameter.min))) / (scale(parameter.max) - scale(parameter.min));
  }

  function valueAt(parameter, step) {
    const { min, max } = parameter;
    const value = parameter.scale === "log" ? min * (max / min) ** (step / STEPS) : min + ((max - min) * step) / STEPS;
    return Number(value.toPrecision(6));
  }

  // A number as a narrow field shows it and takes it: with a power of ten where it is long.
  function typed(value) {
    const [whole, short] = [6, 4].map((digits) => Number(value.toPrecision(digits)));
    const size = Math.abs(whole);
    if (size >= 1e6 || (size > 0 && size < 1e-3)) return short.toExponential().replace("+", "");
    return String(String(whole).length > 8 ? short : whole);
  }

  function node(tag, properties, ...inside) {
    const found = Object.assign(document.createElement(tag), properties);
    found.append(...inside);
    return found;
  }

  // A slider with its number beside it: `wish` is told what is asked for, `held` are the values that hold.
  function made(parameter, held, wish) {
    const { key, label, unit } = parameter;
    const name = "live-" + key;
    const range = node("input", { type: "range", id: name, min: 0, max: STEPS, step: "any" });
    const exact = node("input", { type: "number", id: name + "-exact", step: "any" });
    exact.setAttribute("aria-label", `${label}, ${unit || "number"}`);
    range.addEventListener("input", () => wish(key, valueAt(parameter, Number(range.value))));
    range.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -10, ArrowDown: -10, ArrowRight: 10, ArrowUp: 10 }[event.key];
      if (!step) return;
      event.preventDefault();
      wish(key, valueAt(parameter, Math.max(0, Math.min(STEPS, along(parameter, held[key]) + step))));
    });
    exact.addEventListener("change", () => wish(key, Number((Number(exact.value) / parameter.factor).toPrecision(12))));
    const refusal = node("span", { className: "refused", id: name + "-refused" });
    const end = node("span", { className: "note", id: name + "-end" });
    const ends = [parameter.min, parameter.max].map((each) => plots.text(each * parameter.factor)).join(" to ");
    const text = node("label", { htmlFor: name }, `${label} `, node("small", {}, `(${ends}${unit ? " " + unit : ""})`));
    return node("div", { className: "slider" }, text, node("span", {}, range, exact, ` ${unit}`), refusal, end);
  }

  function show(parameter, held) {
    const { key, factor } = parameter;
    const range = document.getElementById("live-" + key);
    const shown = Number((held[key] * factor).toPrecision(6));
    range.value = along(parameter, held[key]);
    range.setAttribute("aria-valuetext", `${shown} ${parameter.unit}`.trim());
    document.getElementById(`live-${key}-exact`).value = typed(held[key] * factor);
    document.getElementById(`live-${key}-end`).textContent = atEnd(parameter, held[key]);
  }

  // Why a slider goes no further, where it stands at an end beyond which values are refused.
  function atEnd({ key, min, max, refused }, value) {
    const end = [min, max].indexOf(value);
    if (end < 0 || !refused[end]) return "";
    const why = key.startsWith("length") ? "the links do not close over the whole turn" : "the mechanism's own checks refuse it";
    return `No ${end ? "more" : "less"}: beyond this, ${why}.`;
  }

  // A number that cannot be moved, and why.
  function fixed({ label, value, factor, unit, why }) {
    return node("p", { className: "note" }, `${label}, ${plots.text(value * factor)}${unit && ` ${unit}`}, cannot be moved: ${why}.`);
  }

  return { fixed, made, show, typed };
})();

if (typeof module !== "undefined") module.exports = sliders;

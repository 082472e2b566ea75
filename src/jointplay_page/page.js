"use strict";
// The page of a result: its charts follow the selected cell, the motion and the address, and lead them.

const jointplay = (() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const view = new URLSearchParams(location.hash.slice(1)); // what the address says
  const parts = []; // each with show(view), called when the address is another one
  const initial = new Map(); // ranges of the charts as they were made
  let models = null;
  let written = location.hash;

  function element(id) {
    return document.getElementById(id);
  }

  function numbers(packed) {
    const bytes = Uint8Array.from(atob(packed.bytes), (character) => character.charCodeAt(0));
    const kinds = { "<f8": Float64Array, "<f4": Float32Array, "<i4": Int32Array, "<i2": Int16Array, "<i1": Int8Array };
    return new kinds[packed.type](bytes.buffer);
  }

  function say(text) {
    element("said").textContent = text;
  }

  function store(key, value) {
    if (value === null || value === "") view.delete(key);
    else view.set(key, value);
    written = "#" + view.toString();
    history.replaceState(null, "", written);
  }

  function chart(number) {
    return models.get_model_by_name("chart" + number);
  }

  // ---- zoom

  function ends(model) {
    return [model.x_range.start, model.x_range.end, model.y_range.start, model.y_range.end];
  }

  function zoomed() {
    data.panels.forEach((_, number) => {
      const now = ends(chart(number));
      const same = now.every((end, i) => end === initial.get(number)[i]);
      store("zoom" + number, same ? null : now.map((end) => Number(end.toPrecision(8))).join(" "));
      if (!same) parts.forEach((part) => part.zoomed && part.zoomed(data.panels[number], now));
    });
  }

  function showZoom() {
    data.panels.forEach((_, number) => {
      const given = (view.get("zoom" + number) || "").split(" ").map(Number);
      const asked = given.length === 4 && given.every(Number.isFinite) ? given : initial.get(number);
      chart(number).x_range.setv({ start: asked[0], end: asked[1] });
      chart(number).y_range.setv({ start: asked[2], end: asked[3] });
    });
  }

  // ---- dark and light

  function isDark() {
    return (view.get("theme") || (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light")) === "dark";
  }

  function flipped(colour) {
    // dark marks would not be seen on a dark page: what is nearly black there becomes nearly white
    const found = /^#(..)(..)(..)$/.exec(colour);
    if (!found) return colour;
    const levels = found.slice(1).map((each) => parseInt(each, 16));
    const [red, green, blue] = levels;
    if (0.3 * red + 0.59 * green + 0.11 * blue > 70) return colour;
    return "#" + levels.map((each) => (235 - Math.round(0.5 * each)).toString(16).padStart(2, "0")).join("");
  }

  const lightColours = new Map();

  function recolour(model, names, dark) {
    for (const name of names) {
      const property = model[name];
      const value = property && typeof property === "object" ? property.value : property;
      if (typeof value !== "string") continue;
      const key = model.id + name;
      if (!lightColours.has(key)) lightColours.set(key, value);
      const wanted = dark ? flipped(lightColours.get(key)) : lightColours.get(key);
      if (wanted !== value) model[name] = property && typeof property === "object" ? { value: wanted } : wanted;
    }
  }

  function showTheme() {
    const dark = isDark();
    document.documentElement.dataset.theme = dark ? "dark" : "light";
    const paper = dark ? "#16181b" : "#ffffff";
    const ink = dark ? "#d8d8d8" : "#333333";
    const rule = dark ? "#33363b" : "#e5e5e5";
    const looks = {
      Figure: { background_fill_color: paper, border_fill_color: paper, outline_line_color: rule },
      Grid: { grid_line_color: rule },
      Title: { text_color: ink },
      Legend: { background_fill_color: paper, label_text_color: ink, border_line_color: rule },
      ColorBar: { background_fill_color: paper, title_text_color: ink, major_label_text_color: ink },
    };
    const axis = { axis_label_text_color: ink, major_label_text_color: ink };
    ["axis", "major_tick", "minor_tick"].forEach((part) => { axis[part + "_line_color"] = ink; });
    for (const model of models._all_models.values()) {
      const look = looks[model.type] || (model.type.endsWith("Axis") ? axis : null);
      if (look) model.setv(look);
      else recolour(model, ["line_color", "fill_color", "text_color", "hatch_color"], dark);
    }
  }

  // ---- beginning, and a changed address

  function show() {
    if (models) {
      showTheme();
      showZoom();
    }
    parts.forEach((part) => part.show(view));
  }

  function changed() {
    if (location.hash === written) return;
    written = location.hash;
    [...view.keys()].forEach((key) => view.delete(key));
    new URLSearchParams(location.hash.slice(1)).forEach((value, key) => view.set(key, value));
    show();
  }

  function copy(text) {
    const field = document.createElement("textarea"); // works in a page opened from a file too
    field.value = text;
    document.body.append(field);
    field.select();
    const done = document.execCommand("copy");
    field.remove();
    say(done ? "Copied" : "The browser does not let a page copy: select the text instead");
  }

  function start() {
    models = window.Bokeh ? Bokeh.documents[0] : null; // without charts there is no library
    data.panels.forEach((_, number) => initial.set(number, ends(chart(number))));
    show();
    document.documentElement.dataset.ready = "yes";
  }

  function tapped(number, x, y) {
    parts.forEach((part) => part.tapped && part.tapped(data.panels[number], x, y));
  }

  addEventListener("hashchange", changed);
  element("theme").addEventListener("click", () => {
    store("theme", isDark() ? "light" : "dark");
    show();
  });
  document.addEventListener("click", (event) => {
    const source = event.target.dataset && event.target.dataset.copies;
    if (source) copy(element(source).textContent);
  });
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || /^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName)) return;
    if (parts.some((part) => part.pressed && part.pressed(event.key))) event.preventDefault();
  });

  document.documentElement.dataset.theme = isDark() ? "dark" : "light";
  return { data, view, parts, chart, copy, element, numbers, say, start, store, tapped, zoomed, model: (name) => models.get_model_by_name(name) };
})();

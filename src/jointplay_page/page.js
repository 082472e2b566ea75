"use strict";
// The page of a result: its parts follow the selected cell, the motion and the address, and lead them.

const jointplay = (() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const view = new URLSearchParams(location.hash.slice(1)); // what the address says
  const parts = []; // each with show(view), called when the address is another one
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

  // ---- dark and light

  function isDark() {
    return (view.get("theme") || (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light")) === "dark";
  }

  // ---- beginning, and a changed address

  function show() {
    document.documentElement.dataset.theme = isDark() ? "dark" : "light";
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
    show();
    document.documentElement.dataset.ready = "yes";
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
  return { data, view, parts, copy, element, numbers, say, start, store };
})();

"use strict";
// Controls beside the machine. Texts of the machine are set as text, never as markup.

function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else if (value === true) made.setAttribute(key, "");
    else if (value !== false) made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}

function section(title, ...children) {
  return element("section", {}, element("h2", {}, title), ...children);
}

function figures(x, digits = 4) {
  return Math.abs(x) < 1e-12 ? "0" : String(Number(x.toPrecision(digits)));
}

function percent(x) {
  return `${x >= 0.995 || x < 0.0995 ? Math.round(1000 * x) / 10 : Math.round(100 * x)} %`;
}

// A number with its unit, as angles and lengths are read.
function quantity(x, unit, digits = 4) {
  if (unit === "rad") return `${figures(x * 180 / Math.PI, digits)}°`;
  return unit === "m" ? `${figures(1000 * x, digits)} mm` : `${figures(x, digits)} ${unit}`;
}

// A slider with a name and its value; `moved(x)` says whether x was reached, `text(x)` how it is written.
function slider({ name, value, low, high, unit, role = "", text = (x) => quantity(x, unit) }, moved) {
  const shown = element("output", {});
  const input = element("input", {
    type: "range", min: low, max: high, step: (high - low) / 400, "aria-label": unit ? `${name}, ${unit}` : name,
    oninput: () => { if (!moved(Number(input.value))) input.value = last; show(Number(input.value)); },
  });
  let last = value;
  const show = (x) => {
    last = x;
    input.value = x;
    shown.textContent = text(x);
    input.setAttribute("aria-valuetext", shown.textContent);
  };
  const made = element("label", { class: "slider" }, element("span", { class: `name ${role}` }, name), shown, input);
  show(value);
  return Object.assign(made, { show });
}

function button(text, pressed, attributes = {}) {
  return element("button", { type: "button", onclick: pressed, ...attributes }, text);
}

function check(text, on, changed) {
  const box = element("input", { type: "checkbox", checked: on, onchange: () => changed(box.checked) });
  return element("label", { class: "check" }, box, text);
}

// Names with shares of energy as bars.
function shares(title, found) {
  const rows = found.slice(0, 6).map(([name, share]) => {
    const bar = element("i", {});
    bar.style.width = `${Math.max(1, Math.min(100, 100 * Math.abs(share)))}%`;
    return element("tr", {}, element("th", { scope: "row" }, name), element("td", { class: "bar" }, bar), element("td", {}, percent(share)));
  });
  if (!rows.length) return "";
  return element("table", { class: "shares" }, element("caption", {}, title), element("tbody", {}, ...rows));
}

function hertz(mode) {
  if (mode.growth) return `grows ${figures(mode.growth, 3)} /s`;
  return mode.hertz ? `${figures(mode.hertz)} Hz` : "0 Hz";
}

// The modes of a set as buttons; `chosen(mode or null)` is told which one moves.
function modeList(set, chosen) {
  if (set.refused) return element("p", { class: "remark" }, set.refused);
  const list = element("ol", { class: "modes" }), still = element("ol", { class: "modes" });
  const detail = element("div", { class: "detail" });
  set.modes.forEach((mode, k) => {
    const most = mode.strain[0] ?? mode.kinetic[0];
    const said = mode.hertz ? (most ? `${most[0]} ${percent(most[1])}` : "") : "moves without springs";
    const one = element("button", { type: "button", "aria-pressed": "false" },
      element("span", { class: "number" }, String(k + 1)), element("b", {}, hertz(mode)), element("span", { class: "most" }, said));
    one.addEventListener("click", () => {
      const on = one.getAttribute("aria-pressed") !== "true";
      whole.querySelectorAll("ol button").forEach((other) => other.setAttribute("aria-pressed", "false"));
      one.setAttribute("aria-pressed", String(on));
      detail.replaceChildren(...(on ? [
        mode.damping === null ? "" : element("p", {}, `damping ${percent(mode.damping)}`),
        shares("strain energy", mode.strain), shares("kinetic energy", mode.kinetic)] : []));
      one.after(detail);
      chosen(on ? mode : null);
    });
    (mode.hertz || mode.growth ? list : still).append(element("li", {}, one));
  });
  const more = set.count > set.modes.length ? element("p", { class: "remark" }, `the lowest ${set.modes.length} of ${set.count}`) : "";
  const free = still.children.length;
  const zero = free ? element("details", { open: !list.children.length }, element("summary", {}, `${free} at 0 Hz: without springs`), still) : "";
  const whole = element("div", {}, list, more, zero);
  return whole;
}

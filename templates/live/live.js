"use strict";
// What the server tells of the file is shown as it comes. Texts of the machine are set as text, never as markup.

const $ = (id) => document.getElementById(id);

function message(kind, { place, what, line, text }) {
  const where = [line ? `line ${line}` : "", line && /^line \d/.test(place) ? "" : place].filter(Boolean).join(", ");
  const shown = line && text ? element("code", {}, element("span", { class: "number" }, String(line)), text) : "";
  return element("p", { class: `said ${kind}` }, element("b", {}, where ? `${where}: ` : ""), what, shown);
}

function table(head, rows) {
  const body = rows.map(([name, ...cells]) => element("tr", {}, element("th", { scope: "row" }, name),
    ...cells.map((x) => element("td", { class: typeof x === "number" ? "count" : "" }, String(x)))));
  return element("div", { class: "sideways" }, element("table", { class: "figures" },
    element("thead", {}, element("tr", {}, ...head.map((name) => element("th", { scope: "col" }, name)))), element("tbody", {}, ...body)));
}

const cells = new Cells(post);
const base = element("div", {}), cost = element("div", {});
const equations = {
  model: element("select", { id: "model", "aria-label": "Model", onchange: () => equations.load() }),
  frame: element("iframe", { id: "equations", title: "Equations of the model" }),
  version: "",
  stale: true,
  // Equations are computed when they are looked at.
  load() {
    this.stale = $("panel-equations").hidden;
    if (!this.stale && this.model.value) this.frame.src = `equations?model=${this.model.value}&${this.version}`;
  },
};

const SHOWN = {
  file: ({ name, ...steps }) => { $("name").textContent = document.title = name; cells.reach(steps); },
  cells: (part) => cells.show(part),
  checked: ({ error, warnings, version }) => {
    $("said").replaceChildren(...(error ? [message("error", error)] : []), ...warnings.map((one) => message("warning", one)));
    for (const one of ["picture", "panel-base", "panel-cost", "panel-equations"]) $(one).classList.toggle("stale", Boolean(error));
    document.body.dataset.checked = version;
    if (error) return;
    equations.version = version;
    equations.load();
  },
  picture: (part) => picture.show(part),
  base: ({ refused, rows }) => base.replaceChildren(
    element("p", { class: "remark" }, refused || `${rows.length} groups of inertial parameters that motions and torques determine.`),
    ...(rows.length ? [table(["parameter", "formula"], rows)] : [])),
  cost: ({ refused, rows }) => cost.replaceChildren(refused ? element("p", { class: "remark" }, refused)
    : table(["model", "products and divisions", "sums", "sines and cosines"], rows)),
  models: ({ titles }) => {
    if (equations.model.options.length) return;
    equations.model.append(...Object.entries(titles).map(([name, title]) => element("option", { value: name, title, selected: name === "inverse_dynamics" }, name)));
  },
};

const PANELS = {
  file: ["File", cells.place], base: ["Base parameters", base], cost: ["Operations", cost],
  equations: ["Equations", equations.model, equations.frame],
};

function choose(name) {
  for (const one of Object.keys(PANELS)) {
    $(`panel-${one}`).hidden = one !== name;
    const tab = $(`tab-${one}`);
    tab.setAttribute("aria-selected", String(one === name));
    tab.tabIndex = one === name ? 0 : -1;
  }
  if (name === "equations" && equations.stale) equations.load();
}

function tabs() {
  const names = Object.keys(PANELS);
  for (const [name, [title, ...content]] of Object.entries(PANELS)) {
    const tab = button(title, () => choose(name), { role: "tab", id: `tab-${name}`, "aria-controls": `panel-${name}` });
    tab.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (!step) return;
      const next = names[(names.indexOf(name) + step + names.length) % names.length];
      choose(next);
      $(`tab-${next}`).focus();
    });
    $("tabs").append(tab);
    $("panels").append(element("div", { role: "tabpanel", id: `panel-${name}`, "aria-labelledby": `tab-${name}`, hidden: true }, ...content));
  }
  choose(names[0]);
}

async function post(where, data) {
  try {
    const answer = await fetch(where, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(data) });
    return answer.ok ? null : await answer.text();
  } catch {
    return "The server does not answer: nothing is written.";
  }
}

// A page that nobody sees needs no news: a browser opens few connections to one server.
let stream = null;
function listen() {
  stream?.close();
  stream = null;
  if (document.hidden) return;
  stream = new EventSource("events");
  stream.onopen = () => { $("connection").textContent = ""; };
  stream.onerror = () => { $("connection").textContent = "not connected: what is shown may be old"; };
  stream.onmessage = ({ data }) => { for (const [name, part] of Object.entries(JSON.parse(data))) SHOWN[name]?.(part); };
}

$("connection").after(element("div", { class: "steps" }, ...Object.values(cells.steps)));
$("said").before(cells.refused);
tabs();
document.addEventListener("visibilitychange", listen);
document.addEventListener("keydown", (event) => {
  if (!(event.ctrlKey || event.metaKey) || event.target.tagName === "INPUT") return;
  const name = { z: "undo", Z: "redo", y: "redo" }[event.key];
  if (name) cells.step(name);
});
listen();

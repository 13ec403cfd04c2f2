"use strict";
// What the server tells of the file is shown as it comes. Texts of the machine are set as text, never as markup.

const $ = (id) => document.getElementById(id);

// The picture: a page of its own, replaced once the new one stands, and seen as the one before was.
const picture = {
  frame: null,
  show({ version, modes }) {
    const made = element("iframe", { class: "arriving", title: "The machine, its joints and modes", src: `picture?${version}${modes ? "-modes" : ""}` });
    this.arriving?.remove();
    this.arriving = made;
    made.addEventListener("load", () => {
      if (this.arriving !== made) return;
      const old = this.frame, focused = old !== null && document.activeElement === old;
      made.begin = seen(made.contentWindow);
      if (old) resume(made, old);
      made.classList.remove("arriving");
      old?.remove();
      $("waiting").hidden = true;
      if (focused) made.focus();
      Object.assign(this, { frame: made, arriving: null });
      document.body.dataset.shown = version;
      document.body.dataset.modes = modes;
    });
    $("picture").append(made);
  },
};

// How a machine is seen: its camera, its joints by name, the mode that moves.
function seen(window) {
  const { player } = window, eye = player?.stage?.eye;
  if (!eye) return null;
  const buttons = [...window.document.querySelectorAll(".modes button")];
  return {
    camera: JSON.stringify([eye.camera.position, eye.camera.zoom, eye.controls.target, eye.across, eye.upward, eye.radius]),
    q: Object.fromEntries(player.data.joints.map((joint, k) => [joint.name, player.q[k]])),
    start: Object.fromEntries(player.data.joints.map((joint, k) => [joint.name, player.data.q[k]])),
    tab: [...window.document.querySelectorAll(".tabs button")].findIndex((one) => one.getAttribute("aria-pressed") === "true"),
    mode: buttons.findIndex((one) => one.getAttribute("aria-pressed") === "true"),
    scrolled: [window.document.getElementById("panel").scrollTop, window.scrollY],
  };
}

function resume(made, old) {
  const window = made.contentWindow, { player } = window, was = old.contentWindow && seen(old.contentWindow);
  if (!was || !player?.stage) return;
  if (old.turned || (old.begin && was.camera !== old.begin.camera)) {
    const { eye } = player.stage, [position, zoom, target, across, upward, radius] = JSON.parse(was.camera);
    eye.camera.position.copy(position);
    eye.controls.target.copy(target);
    eye.camera.zoom = zoom;
    Object.assign(eye, { across, upward, radius });
    eye.shape(eye.width, eye.height);
    eye.controls.update();
    made.turned = true;
  }
  const moved = (name) => was.q[name] !== undefined && was.q[name] !== was.start[name];
  if (was.mode < 0) player.place(player.q.map((x, k) => (moved(player.data.joints[k].name) ? was.q[player.data.joints[k].name] : x)));
  else made.mode = [was.tab, was.mode];
  const [tab, mode] = made.mode ?? old.mode ?? [-1, -1], press = (one) => one?.click();
  if (mode >= 0 && player.data.modes.length) {
    press(window.document.querySelectorAll(".tabs button")[tab]);
    press(window.document.querySelectorAll(".modes button")[mode]);
  } else if (mode >= 0) made.mode = [tab, mode];
  window.document.getElementById("panel").scrollTop = was.scrolled[0];
  window.scrollTo(0, was.scrolled[1]);
}

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
  file: ({ name, undo }) => { $("name").textContent = document.title = name; cells.undoable(undo); },
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

$("connection").after(cells.undo);
$("said").before(cells.refused);
tabs();
document.addEventListener("visibilitychange", listen);
document.addEventListener("keydown", (event) => {
  if (event.key === "z" && (event.ctrlKey || event.metaKey) && event.target.tagName !== "INPUT") cells.back();
});
listen();

"use strict";
// The tables of the file. A cell is sent when it is left; what is being typed stays while the file changes elsewhere.

const KINDS = ["motor", "elastic", "passive", "fixed", "coupled", "cut"];
const LEAST = 3, MOST = 18;  // characters that a cell is wide

class Cells {
  // `post(where, data)` returns null, or a sentence about why nothing is written.
  constructor(post) {
    this.post = post;
    this.version = "";
    this.inputs = new Map();
    this.refused = element("p", { id: "refused", role: "alert" });
    this.steps = { undo: button("Undo", () => this.step("undo")), redo: button("Redo", () => this.step("redo")) };
    this.place = element("div", {});
  }

  // Show tables of a version; null leaves those before, of a file that cannot be read.
  show({ version, tables, refused }) {
    this.version = version;
    if (tables === null) return;
    const typing = this.inputs.get(document.activeElement?.dataset?.path);
    const draft = typing && { value: typing.value, changed: typing.value !== typing.dataset.text, ...typing.dataset };
    this.inputs.clear();  // so that what is removed is not sent as what is left
    this.place.replaceChildren(...(refused ? [element("p", { class: "remark" }, refused)] : []), ...tables.map((one) => this._table(one)));
    const again = draft && this.inputs.get(draft.path);
    if (!again) return;
    again.focus();
    if (!draft.changed || again.dataset.text === draft.value) return;
    again.value = draft.value;
    for (const key of ["seen", "refused", "sent"]) if (draft[key]) again.dataset[key] = draft[key];
  }

  // How many steps back and forward there are.
  reach(counts) {
    for (const [name, step] of Object.entries(this.steps)) {
      step.disabled = !counts[name];
      step.textContent = (name === "undo" ? "Undo" : "Redo") + (counts[name] ? ` (${counts[name]})` : "");
    }
  }

  _table({ heading, columns, heads, rows, keys, names }) {
    const title = (name, k) => (heads[k].unit ? `${name}, ${heads[k].unit}` : name);
    const head = element("tr", {}, element("th", { scope: "col" }, "name"),
      ...columns.map((name, k) => element("th", { scope: "col", title: heads[k].meaning }, title(name, k))), element("td", {}));
    const textsOf = (cell) => (cell.parts ? cell.parts.flatMap(textsOf) : [cell.text ?? ""]);
    const width = (k) => Math.max(...rows.flatMap(({ cells }) => textsOf(cells[k]).map((text) => text.length)));
    const sizes = columns.map((_, k) => Math.min(Math.max(width(k), LEAST), MOST));
    const body = rows.map(({ name, path, cells }) => element("tr", {}, element("th", { scope: "row", title: name }, name),
      ...cells.map((cell, k) => element("td", {}, ...this._cell(cell, `${heading}, ${name}, ${columns[k]}`, sizes[k], heads[k].choices))),
      element("td", {}, path.length ? button("−", () => this._edit("remove", path), { class: "remove", "aria-label": `Remove ${name} of ${heading}` }) : "")));
    const table = element("table", { class: "cells" }, element("thead", {}, head), element("tbody", {}, ...body));
    return section(heading, rows.length ? element("div", { class: "sideways" }, table) : "", this._adding(heading, rows, keys, names));
  }

  // Fields for a row that is new, or for a key of a row.
  _adding(heading, rows, keys, names) {
    const choice = (label, options) => element("select", { "aria-label": `${label} of ${heading}` }, ...options.map((x) => element("option", {}, x)));
    if (heading === "gravity") return rows.length ? "" : button("Add gravity", () => this._edit("add", [heading]));
    const name = names.length ? choice("row", names) : element("input", { type: "text", "aria-label": `row of ${heading}`, placeholder: "name", size: 10 });
    const key = heading === "joints" ? choice("kind", KINDS) : choice("key", keys);
    const add = button("Add", () => name.value && this._edit("add", [heading, name.value, heading === "joints" ? "kind" : key.value], heading === "joints" ? key.value : ""),
      { "aria-label": `Add to ${heading}` });
    return element("p", { class: "adding" }, name, key, add);
  }

  _edit(how, path, text = "") {
    return this._change(how, { version: this.version, path, text });
  }

  async _change(how, data) {
    this.refused.textContent = (await this.post(how, data)) ?? "";
  }

  _cell(cell, name, size, choices = []) {
    if (cell.parts) return cell.parts.flatMap((part, k) => this._part(part, part.label ?? String(k + 1), name, size));
    if (!cell.path) return [];
    const path = JSON.stringify(cell.path);
    const keep = (field) => {
      Object.assign(field.dataset, { path, text: cell.text });
      this.inputs.set(path, field);
      return field;
    };
    if (choices.length) {
      const options = [...new Set([cell.text, ...choices])].map((x) => element("option", { selected: x === cell.text }, x));
      const select = element("select", { "aria-label": name, onchange: () => this._send(select) }, ...options);
      return [keep(select)];
    }
    const input = element("input", {
      type: "text", value: cell.text, "aria-label": name, autocomplete: "off", spellcheck: "false",
      onblur: () => { if (this.inputs.get(path) === input && input.value !== input.dataset.refused) this._send(input); },
      onfocus: () => { if (input.value === input.dataset.text) input.dataset.seen = this.version; },
      onkeydown: (event) => this._key(input, event),
    });
    input.style.width = `calc(${size}ch + .9rem)`;
    keep(input);
    return cell.unit ? [input, element("span", { class: "unit" }, cell.unit)] : [input];
  }

  _part(part, label, name, size) {
    const cells = this._cell(part, `${name} ${label}`, size);
    return part.label && cells.length ? [element("span", { class: "label" }, label), ...cells] : cells;
  }

  _key(input, event) {
    if (event.key === "Enter") this._send(input);
    if (event.key !== "Escape") return;
    input.value = input.dataset.text;
    input.removeAttribute("aria-invalid");
    this.refused.textContent = "";
  }

  async _send(input) {
    const { path, seen, sent } = input.dataset, text = input.value;
    if (text.trim() === input.dataset.text || sent === text) return;
    input.dataset.sent = text;
    const said = await this.post("cell", { version: seen || this.version, path: JSON.parse(path), text });
    this.refused.textContent = said ?? "";
    const now = this.inputs.get(path) ?? input;
    delete now.dataset.sent;
    now.dataset.seen = this.version;
    if (!said) return now.removeAttribute("aria-invalid");
    if (now.tagName === "SELECT") now.value = now.dataset.text;
    else now.setAttribute("aria-invalid", "true");
    now.dataset.refused = text;
  }

  step(name) {
    return this._change(name, {});
  }
}

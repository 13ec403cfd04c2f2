"use strict";
// Definitions of symbols: shown where one is pointed at, gone to by a click.
(() => {
  const note = document.body.appendChild(document.createElement("div"));
  note.className = "definition";
  note.setAttribute("role", "tooltip");
  note.hidden = true;
  const definition = (event) => {
    const symbol = event.target instanceof Element ? event.target.closest("[data-of]") : null;
    return symbol && [symbol, document.getElementById(symbol.getAttribute("data-of"))];
  };
  document.addEventListener("pointerover", (event) => {
    const [symbol, row] = definition(event) ?? [];
    note.hidden = !row;
    if (!row) return;
    const copy = row.cloneNode(true);
    copy.removeAttribute("id");
    if (row.tagName === "TR") {
      const table = document.createElement("table");
      table.append(copy);
      note.replaceChildren(table);
    } else note.replaceChildren(copy);
    const at = symbol.getBoundingClientRect();
    const left = Math.max(8, Math.min(at.left, innerWidth - note.offsetWidth - 8));
    const below = at.bottom + note.offsetHeight + 8 < innerHeight;
    note.style.left = `${left + scrollX}px`;
    note.style.top = `${(below ? at.bottom + 4 : at.top - note.offsetHeight - 4) + scrollY}px`;
  });
  document.addEventListener("click", (event) => {
    const [, row] = definition(event) ?? [];
    if (!row) return;
    for (let part = row.parentElement; part; part = part.parentElement) if (part.tagName === "DETAILS") part.open = true;
    row.scrollIntoView({ block: "center" });
    row.classList.add("found");
    setTimeout(() => row.classList.remove("found"), 1500);
  });
  document.addEventListener("keydown", (event) => { if (event.key === "Escape") note.hidden = true; });
})();

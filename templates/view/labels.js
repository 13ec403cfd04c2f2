"use strict";
// Names beside their frames: none on another, near, and where they were before as far as there is room.

const TEXT = { height: 15, gap: 4, font: "12px Helvetica, Arial, sans-serif" };
const RINGS = [8, 16, 27, 42, 62, 88, 120], DIRECTIONS = 16, KEPT = 14, CROSSED = 22;
const COVERED = 30, MOST_COVERED = 6;  // px that it costs to cover a shape, up to so many of them

function boxOf(name, place) {
  const x = name.x + place.distance * Math.cos(place.angle), y = name.y - place.distance * Math.sin(place.angle);
  const across = Math.cos(place.angle);
  const left = x - (across > 0.35 ? 0 : across < -0.35 ? name.width : name.width / 2);
  return { left, right: left + name.width, top: y - TEXT.height / 2, bottom: y + TEXT.height / 2, y };
}

function touch(a, b) {
  const g = TEXT.gap;
  return a.left < b.right + g && b.left < a.right + g && a.top < b.bottom + g / 2 && b.top < a.bottom + g / 2;
}

function covers(box, p) {
  return box.left - 3 < p.x && p.x < box.right + 3 && box.top - 1 < p.y && p.y < box.bottom + 1;
}

function lineTo(name, box) {
  return name.x <= (box.left + box.right) / 2 ? box.left - TEXT.gap : box.right + TEXT.gap;
}

function cross(a, b) {
  const side = (p, q, r) => (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
  return side(a.from, a.to, b.from) * side(a.from, a.to, b.to) < 0 && side(b.from, b.to, a.from) * side(b.from, b.to, a.to) < 0;
}

// Boxes of the texts of names {x, y, width, place}, in their order, off a joint and off `shapes`; null where there is no room.
function placeLabels(names, width, height, joint, shapes = []) {
  const found = [];
  for (const name of names) {
    let best = null;
    for (const ring of RINGS)
      for (let k = 0; k < DIRECTIONS; k++) {
        const distance = joint + ring, place = { ring, distance, angle: 2 * Math.PI * k / DIRECTIONS }, box = boxOf(name, place);
        if (best && distance - KEPT >= best.cost) break;
        if (box.left < 4 || box.right > width - 4 || box.top < 4 || box.bottom > height - 4) continue;
        if (found.some((one) => one && touch(one.box, box)) || names.some((other) => covers(box, other))) continue;
        const line = { from: { x: name.x, y: name.y }, to: { x: lineTo(name, box), y: box.y } };
        const same = name.place && name.place.ring === ring && name.place.angle === place.angle;
        const crossed = found.filter((one) => one && cross(one.line, line)).length;
        const covered = Math.min(MOST_COVERED, shapes.filter((shape) => touch(shape, box)).length);
        const cost = distance + CROSSED * crossed + COVERED * covered - (same ? KEPT : 0);
        if (!best || cost < best.cost - 1e-6) best = { cost, place, box, line };
      }
    name.place = best && best.place;
    found.push(best);
  }
  return found;
}

class Labels {
  constructor(svg, marks) {
    this.svg = svg;
    const ruler = document.createElement("canvas").getContext("2d");
    ruler.font = TEXT.font;
    this.names = marks.map((mark) => ({ ...mark, width: ruler.measureText(mark.name).width, ...this._drawn(mark) }));
  }

  _drawn(mark) {
    const make = (tag, parent) => parent.appendChild(document.createElementNS("http://www.w3.org/2000/svg", tag));
    const group = make("g", this.svg), [line, dot, text] = ["line", "circle", "text"].map((tag) => make(tag, group));
    group.dataset.frame = mark.frame;
    dot.setAttribute("r", 2);
    text.textContent = mark.name;
    return { group, line, dot, text };
  }

  // Put every name beside the point of its frame, px.
  place(pointOf, width, height, joint, shapes) {
    this.svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    for (const name of this.names) Object.assign(name, pointOf(name.frame));
    const set = (element, numbers) => Object.entries(numbers).forEach(([key, x]) => element.setAttribute(key, x.toFixed(2)));
    placeLabels(this.names, width, height, joint, shapes).forEach((one, k) => {
      const name = this.names[k];
      set(name.dot, { cx: name.x, cy: name.y });
      name.group.classList.toggle("hidden", !one);
      if (!one) return;
      set(name.line, { x1: name.x, y1: name.y, x2: one.line.to.x, y2: one.line.to.y });
      set(name.text, { x: one.box.left, y: one.box.y + 4 });
    });
  }
}

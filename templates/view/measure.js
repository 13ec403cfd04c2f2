"use strict";
// The distance between the origins of two frames, as the machine stands or moves.

class Ruler {
  constructor(figure, painted) {
    this.figure = figure;
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(6), 3));
    this.line = Object.assign(new THREE.LineSegments(geometry, painted.measure()), { visible: false, frustumCulled: false, renderOrder: 3 });
  }

  // Measure from a frame to another, and tell `changed({ distance, along })` m, axes of frame 0; none without them.
  between(frames, changed = null) {
    Object.assign(this, { frames, changed });
    this.line.visible = Boolean(frames);
    this.place();
  }

  place() {
    if (!this.frames) return;
    const [a, b] = this.frames.map((frame) => [3, 7, 11].map((k) => this.figure.T[frame][k]));
    const target = this.line.geometry.attributes.position;
    target.setXYZ(0, ...a);
    target.setXYZ(1, ...b);
    target.needsUpdate = true;
    const along = b.map((x, k) => x - a[k]);
    this.changed?.({ distance: Math.hypot(...along), along });
  }
}

function measureSection(stage, data) {
  const shown = element("p", { class: "measured" });
  const choice = (label) => element("select", { "aria-label": label, onchange: () => update() },
    element("option", { value: "" }, "–"), ...data.marks.map((mark) => element("option", { value: mark.frame }, mark.name)));
  const [from, to] = [choice("Measure from frame"), choice("Measure to frame")];
  const update = () => {
    const chosen = from.value !== "" && to.value !== "" && from.value !== to.value;
    shown.textContent = "";
    stage.ruler.between(chosen ? [Number(from.value), Number(to.value)] : null, ({ distance, along }) => {
      const parts = along.map((x, k) => `${"xyz"[k]} ${figures(1000 * x)}`).join(", ");
      shown.replaceChildren(element("b", {}, quantity(distance, "m")), ` (${parts})`);
    });
    stage.request();
  };
  return section("Measure", element("div", { class: "row" }, from, "to", to), shown);
}

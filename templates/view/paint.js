"use strict";
// Materials of shapes by their role, in the colours of light or dark paper.

class Painted {
  constructor(data) {
    this.materials = new Map();
    this.palettes = data.palettes;
    this.dark = window.matchMedia("(prefers-color-scheme: dark)");
  }

  get palette() {
    return this.dark.matches ? this.palettes.dark : this.palettes.light;
  }

  fill(role, look = "") {
    const opacity = role === "beam" ? 0.7 : role === "mesh" || (role === "body" && look === "ball") ? 0.45 : role === "body" ? 0.12 : 1;
    return this._kept(`fill ${role} ${look}`, () => new THREE.MeshLambertMaterial(
      { transparent: true, opacity, depthWrite: opacity === 1, visible: look !== "outlined" }));
  }

  edge(role) {
    return this._kept(`edge ${role}`, () => new THREE.LineBasicMaterial(
      { transparent: true, ...(role === "body" ? { opacity: 0.32, depthWrite: false } : { opacity: 0.65 }) }));
  }

  shadow() {
    return this._kept("none shadow", () => new THREE.LineBasicMaterial({ color: 0x000000, transparent: true, opacity: SHADE, depthWrite: false }));
  }

  grid() {
    return this._kept("faint grid", () => new THREE.LineBasicMaterial({ transparent: true, opacity: 0.28, depthWrite: false }));
  }

  ghost() {
    return this._kept("fill ghost", () => new THREE.LineBasicMaterial({ transparent: true, depthWrite: false }));
  }

  measure() {
    return this._kept("ink measure", () => new THREE.LineBasicMaterial({ transparent: true, depthTest: false }));
  }

  _kept(name, make) {
    if (!this.materials.has(name)) this.materials.set(name, make());
    return this.materials.get(name);
  }

  repaint() {
    for (const [name, material] of this.materials) {
      const [part, role] = name.split(" ");
      const colour = part === "none" ? null : this.palette[part][role] ?? this.palette[role] ?? this.palette[part];
      if (colour) material.color.set(colour);
    }
  }
}

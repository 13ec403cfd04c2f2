"use strict";
// Wires as tubes.

const SIDES = 7;
const IN_FRONT = 1;  // joints are seen through bodies, which are drawn before them

// A tube around a line of points; its normals turn with the points around z of the frame.
class Tube {
  constructor(wire, radius, material) {
    this.wire = wire;
    this.radius = radius;
    const count = wire.behind.length, index = [];
    for (let k = 0; k + 1 < count; k++)
      for (let s = 0; s < SIDES; s++) {
        const [a, b] = [k * SIDES + s, k * SIDES + (s + 1) % SIDES];
        index.push(a, b, a + SIDES, b, b + SIDES, a + SIDES);
      }
    this.geometry = new THREE.BufferGeometry();
    this.geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(3 * SIDES * count), 3));
    this.geometry.setIndex(index);
    this.mesh = new THREE.Mesh(this.geometry, material);
    this.mesh.frustumCulled = false;
  }

  bend(moved, slides) {
    const points = bent(this.wire.points, this.wire.behind, moved, slides);
    const at = (k) => new THREE.Vector3(points[3 * k], points[3 * k + 1], points[3 * k + 2]);
    const count = this.wire.behind.length, target = this.geometry.attributes.position;
    for (let k = 0; k < count; k++) {
      const along = at(Math.min(k + 1, count - 1)).sub(at(Math.max(k - 1, 0))).normalize();
      const out = new THREE.Vector3(points[3 * k], points[3 * k + 1], 0);
      if (out.clone().cross(along).length() < 1e-3 * out.length() || !out.length()) out.set(along.y, along.z, along.x);
      out.addScaledVector(along, -out.dot(along)).normalize();
      const aside = along.clone().cross(out);
      for (let s = 0; s < SIDES; s++) {
        const angle = 2 * Math.PI * s / SIDES;
        const p = at(k).addScaledVector(out, this.radius * Math.cos(angle)).addScaledVector(aside, this.radius * Math.sin(angle));
        target.setXYZ(k * SIDES + s, p.x, p.y, p.z);
      }
    }
    target.needsUpdate = true;
    this.geometry.computeVertexNormals();
  }
}

// A tube along a path of points in frame 0.
function pathTube(points, radius, material) {
  const tube = new Tube({ points: points.flat(), behind: points.map(() => 0) }, radius, material);
  tube.bend(0, true);
  tube.mesh.renderOrder = IN_FRONT + 1;
  return tube.mesh;
}

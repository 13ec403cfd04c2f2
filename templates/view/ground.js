"use strict";
// The ground on which a machine stands: a grid of round lengths, and the shadow of a light straight above.

const LINES = 8, SHADE = 0.16;  // lines across the machine; opacity of a shadow

// The largest of 1, 2, 5, 10 ... that is at most x.
function roundBelow(x) {
  const decade = 10 ** Math.floor(Math.log10(x));
  return decade * [1, 2, 5].filter((k) => k * decade <= x * (1 + 1e-9)).at(-1);
}

// The placement that lets points fall along `up` to the height h.
function falling(up, h) {
  const [x, y, z] = up, row = (k) => [x, y, z].map((u, i) => (i === k ? 1 : 0) - up[k] * u);
  return Float64Array.of(...row(0), h * x, ...row(1), h * y, ...row(2), h * z, 0, 0, 0, 1);
}

class Ground {
  constructor(data, figure, painted) {
    this.group = new THREE.Group();
    this.up = data.up;
    const [low, high] = data.room, height = (p) => p.reduce((sum, x, k) => sum + x * data.up[k], 0);
    this.height = this._lowest(figure, height);
    this.falls = falling(data.up, this.height - 1e-4 * data.extent);
    this.pitch = roundBelow(data.extent / LINES);
    this.label = `ground, ${quantity(this.pitch, "m")} squares`;
    this.shadows = data.solids.filter((solid) => solid.role !== "body").map((solid) => this._shadow(solid, painted));
    for (const { geometry } of figure.bars) this._fallen(geometry, painted);
    this._grid(low.map((x, k) => (x + high[k]) / 2), data.extent, painted);
    this.place(figure.T);
  }

  _lowest(figure, height) {
    const shapes = [...cornersOf(figure.groups)].filter(([, mesh]) => !figure.layers.bodies.includes(mesh));
    return Math.min(...shapes.map(([corner]) => height(corner.toArray())));
  }

  _fallen(geometry, painted) {
    const mesh = Object.assign(new THREE.Mesh(geometry, painted.shadow()), { matrixAutoUpdate: false, frustumCulled: false, renderOrder: -1 });
    mesh.matrix.set(...this.falls);
    this.group.add(mesh);
    return mesh;
  }

  _shadow(solid, painted) {
    return { mesh: this._fallen(geometryOf(solid), painted), frame: solid.frame, at: Float64Array.from(solid.at) };
  }

  _grid(middle, extent, painted) {
    const up = new THREE.Vector3(...this.up), across = new THREE.Vector3(...(Math.abs(this.up[0]) > 0.9 ? [0, 1, 0] : [1, 0, 0]));
    across.addScaledVector(up, -across.dot(up)).normalize();
    const away = up.clone().cross(across), count = Math.ceil(0.75 * extent / this.pitch), points = [];
    const centre = new THREE.Vector3(...middle), near = (axis) => this.pitch * Math.round(centre.dot(axis) / this.pitch);
    const at = (a, b) => across.clone().multiplyScalar(near(across) + a * this.pitch).addScaledVector(away, near(away) + b * this.pitch).addScaledVector(up, this.height);
    for (let k = -count; k <= count; k++) points.push(at(k, -count), at(k, count), at(-count, k), at(count, k));
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(points.flatMap((p) => p.toArray())), 3));
    this.group.add(Object.assign(new THREE.LineSegments(geometry, painted.grid()), { renderOrder: -2 }));
  }

  place(T) {
    for (const { mesh, frame, at } of this.shadows) {
      mesh.matrix.set(...product(this.falls, product(T[frame], at)));
      mesh.matrixWorldNeedsUpdate = true;
    }
  }
}

"use strict";
// Beams as bars: their section along a cubic curve through the frames of their pieces.

// Points, and directions of y and z, along the curve from placement a to b, without a itself unless it is the first.
function* between(a, b, steps, first) {
  const column = (T, k) => new THREE.Vector3(T[k], T[4 + k], T[8 + k]);
  const start = column(a, 3), way = column(b, 3).sub(start), far = way.length();
  const out = column(a, 0).multiplyScalar(far), into = column(b, 0).multiplyScalar(far);
  const square = way.clone().multiplyScalar(3).addScaledVector(out, -2).sub(into);
  const cube = out.clone().add(into).addScaledVector(way, -2);
  for (let k = first ? 0 : 1; k <= steps; k++) {
    const t = k / steps;
    const point = start.clone().addScaledVector(out, t).addScaledVector(square, t * t).addScaledVector(cube, t ** 3);
    const x = out.clone().addScaledVector(square, 2 * t).addScaledVector(cube, 3 * t * t).normalize();
    const y = column(a, 1).lerp(column(b, 1), t);
    y.addScaledVector(x, -x.dot(y)).normalize();
    yield { point, y, z: x.clone().cross(y) };
  }
}

// Corners of the section along a bar, a list for each ring, with the frames at placements T.
function ringsOf(bar, T) {
  const at = bar.stations.map(({ frame, at }) => product(T[frame], at));
  const along = at.slice(1).flatMap((b, k) => [...between(at[k], b, bar.steps, k === 0)]);
  return along.map(({ point, y, z }) => bar.outline.map(([a, b]) => point.clone().addScaledVector(y, a).addScaledVector(z, b)));
}

// A bar as a skin with both ends; the sides of a box have corners of their own, so that they are flat.
class Bar {
  constructor(bar, painted, T) {
    this.bar = bar;
    const rings = ringsOf(bar, T).length, corners = bar.outline.length, flat = corners === 4;
    const next = (k) => (k + 1) % corners, sides = bar.outline.map((_, k) => k);
    this.around = flat ? sides.flatMap((k) => [k, next(k)]) : sides;
    const wide = this.around.length, ends = wide * rings, index = [];
    for (let r = 0; r + 1 < rings; r++)
      for (const side of sides) {
        const [a, b] = (flat ? [2 * side, 2 * side + 1] : [side, next(side)]).map((k) => r * wide + k);
        index.push(a, b, a + wide, b, b + wide, a + wide);
      }
    for (let k = 1; k + 1 < corners; k++)
      index.push(ends, ends + k + 1, ends + k, ends + corners, ends + corners + k, ends + corners + k + 1);
    this.geometry = this._geometry(ends + 2 * corners, index);
    this.mesh = new THREE.Mesh(this.geometry, painted.fill("beam"));
    const lines = [0, rings - 1].flatMap((r) => sides.flatMap((k) => [[r, k], [r, next(k)]]));
    if (flat) for (let r = 0; r + 1 < rings; r++) lines.push(...sides.flatMap((k) => [[r, k], [r + 1, k]]));
    this.lines = lines;
    this.edges = new THREE.LineSegments(this._geometry(lines.length), painted.edge("beam"));
    this.mesh.add(this.edges);
    this.mesh.frustumCulled = this.edges.frustumCulled = false;
    this.place(T);
  }

  _geometry(count, index) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(3 * count), 3));
    if (index) geometry.setIndex(index);
    return geometry;
  }

  place(T) {
    const rings = ringsOf(this.bar, T);
    const fill = ({ attributes: { position } }, points) => {
      points.forEach(({ x, y, z }, k) => position.setXYZ(k, x, y, z));
      position.needsUpdate = true;
    };
    fill(this.geometry, [...rings.flatMap((ring) => this.around.map((k) => ring[k])), ...rings[0], ...rings.at(-1)]);
    fill(this.edges.geometry, this.lines.map(([r, k]) => rings[r][k]));
    this.geometry.computeVertexNormals();
  }

  // The strain energy of its springs as a share, of [name, share] for each spring.
  energy(strain) {
    return strain.reduce((sum, [name, share]) => sum + (this.bar.springs.includes(name) ? share : 0), 0);
  }
}

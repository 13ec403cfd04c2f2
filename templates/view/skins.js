"use strict";
// Bodies by modes as the surface of their mesh; the frame of a mode slides along z of the body by its deflection.

// Numbers in base64.
function bytesOf(text) {
  return Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
}

// A skin with flat triangles and their edges, moved as a bar is.
class Skin {
  constructor(skin, painted, T) {
    this.skin = skin;
    this.points = new Float32Array(bytesOf(skin.points));
    this.modes = new Float32Array(bytesOf(skin.modes));
    this.corners = new Uint32Array(bytesOf(skin.triangles));
    const position = new THREE.BufferAttribute(new Float32Array(3 * this.corners.length), 3);
    const [skins, lines] = [0, 1].map(() => new THREE.BufferGeometry().setAttribute("position", position));
    const edges = [], drawn = new Set();
    this.corners.forEach((a, k) => {
      const after = k % 3 === 2 ? k - 2 : k + 1, name = [a, this.corners[after]].sort().join();
      if (!drawn.has(name)) edges.push(k, after);
      drawn.add(name);
    });
    lines.setIndex(edges);
    this.geometry = skins;
    this.mesh = new THREE.Mesh(skins, painted.fill("beam"));
    this.edges = new THREE.LineSegments(lines, painted.edge("body"));
    this.mesh.add(this.edges);
    this.mesh.frustumCulled = this.edges.frustumCulled = false;
    this.place(T);
  }

  place(T) {
    const { frame, rows } = this.skin, body = T[frame], n = this.points.length, moved = Float32Array.from(this.points);
    rows.forEach((row, k) => {
      const e = [3, 7, 11].reduce((sum, at) => sum + (T[row][at] - body[at]) * body[at - 1], 0);
      if (e) for (let i = 0; i < n; i++) moved[i] += e * this.modes[k * n + i];
    });
    const { position } = this.geometry.attributes, at = (x, y, z, k) => body[k] * x + body[k + 1] * y + body[k + 2] * z + body[k + 3];
    this.corners.forEach((corner, k) => {
      const point = moved.subarray(3 * corner, 3 * corner + 3);
      position.setXYZ(k, at(...point, 0), at(...point, 4), at(...point, 8));
    });
    position.needsUpdate = true;
    this.geometry.computeVertexNormals();
  }

  // The strain energy of its modes as a share, of [name, share] for each spring.
  energy(strain) {
    return strain.reduce((sum, [name, share]) => sum + (this.skin.springs.includes(name) ? share : 0), 0);
  }
}

"use strict";
// The shapes of the figure as meshes, each in the group of its frame.

const ROUND = 28, THICK = 0.085;  // sides of a cylinder; radius of a wire in units
const WEAK = 0.05;  // share of a spring in the energy of a mode

function geometryOf(solid) {
  const [a, b, c] = solid.size;
  if (solid.shape === "box") return new THREE.BoxGeometry(a, b, c);
  if (solid.shape === "ball") return ballGeometry(a / 2);
  return new THREE.CylinderGeometry(a / 2, a / 2, c, a < 0.01 * c ? 10 : ROUND).rotateX(Math.PI / 2);
}

// A cylinder of height pi whose points at an angle from the equator are moved to a ball.
function ballGeometry(radius) {
  const ball = new THREE.CylinderGeometry(1, 1, Math.PI, ROUND, ROUND / 2, true), points = ball.attributes.position;
  for (let k = 0; k < points.count; k++) {
    const angle = points.getY(k), across = radius * Math.cos(angle);
    points.setXYZ(k, across * points.getX(k), radius * Math.sin(angle), across * points.getZ(k));
  }
  ball.computeVertexNormals();
  return ball;
}

// Corners, in frame 0, of the boxes around the meshes of groups, each with its mesh.
function* cornersOf(groups) {
  const meshes = [];
  for (const group of groups) {
    group.updateMatrixWorld(true);
    group.traverse((one) => { if (one.isMesh) meshes.push(one); });
  }
  for (const mesh of meshes) {
    mesh.geometry.computeBoundingBox();
    const { min, max } = mesh.geometry.boundingBox;
    for (const x of [min.x, max.x]) for (const y of [min.y, max.y]) for (const z of [min.z, max.z])
      yield [new THREE.Vector3(x, y, z).applyMatrix4(mesh.matrixWorld), mesh];
  }
}

class MachineFigure {
  constructor(data, frames, painted) {
    this.frames = frames;
    this.painted = painted;
    this.groups = frames.reference.map(() => Object.assign(new THREE.Group(), { matrixAutoUpdate: false }));
    this.names = new Map(data.marks.map((mark) => [mark.frame, mark.name]));
    this.layers = { bodies: [], axes: [], meshes: [] };
    this.tubes = [];
    this.joints = new Set();
    this.solids = data.solids.filter((solid) => solid.role !== "base");
    for (const solid of data.solids) this._add(solid);
    for (const mesh of data.meshes) this._cover(mesh);
    for (const wire of data.wires) this._thread(wire, data.unit);
    this.bars = [...(data.bars ?? []).map((bar) => new Bar(bar, painted, frames.reference)),
      ...(data.skins ?? []).map((skin) => new Skin(skin, painted, frames.reference))];
    for (const { mesh } of this.bars) this.groups[0].add(mesh);
    this.place(frames.reference);
  }

  _add(solid) {
    const mesh = new THREE.Mesh(geometryOf(solid), this.painted.fill(solid.role, solid.outlined ? "outlined" : solid.shape));
    const lines = new THREE.LineSegments(new THREE.EdgesGeometry(mesh.geometry, 30), this.painted.edge(solid.role));
    mesh.add(lines);
    mesh.matrixAutoUpdate = false;
    mesh.matrix.set(...solid.at);
    if (solid.role === "body") {
      this.layers.bodies.push(mesh);
    } else {
      mesh.renderOrder = lines.renderOrder = IN_FRONT;
      if (solid.role !== "base") this.joints.add(mesh);
    }
    this.groups[solid.frame].add(mesh);
  }

  // The mesh of a body; with meshes, boxes of equal inertia wait until they are asked for.
  _cover({ frame, points, triangles }) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(bytesOf(points)), 3));
    geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(bytesOf(triangles)), 1));
    geometry.computeVertexNormals();
    const mesh = new THREE.Mesh(geometry, this.painted.fill("mesh"));
    this.layers.meshes.push(mesh);
    this.groups[frame].add(mesh);
    for (const box of this.layers.bodies) box.visible = false;
  }

  _thread(wire, unit) {
    const axis = "xyz".includes(wire.role);
    const tube = new Tube(wire, (axis ? 0.5 : 1) * THICK * unit, this.painted.fill(wire.role));
    tube.bend(0, true);
    this.groups[wire.frame].add(tube.mesh);
    tube.mesh.renderOrder = IN_FRONT;
    if (axis) this.layers.axes.push(tube.mesh);
    else this.joints.add(tube.mesh) && this.tubes.push(tube);
  }

  // Outlines of the solids at the placements of the reference.
  ghost() {
    const group = new THREE.Group();
    for (const solid of this.solids) {
      const lines = new THREE.LineSegments(new THREE.EdgesGeometry(geometryOf(solid), 30), this.painted.ghost());
      lines.matrixAutoUpdate = false;
      lines.matrix.set(...product(this.frames.reference[solid.frame], solid.at));
      group.add(lines);
    }
    for (const { edges } of this.bars) group.add(new THREE.LineSegments(edges.geometry.clone(), this.painted.ghost()));
    return group;
  }

  // Grey the springs that store little of the strain energy [name, share] of a mode; none without one.
  emphasize(strain) {
    for (const tube of this.tubes) {
      const own = strain.find(([name]) => name === this.names.get(tube.wire.frame));
      const weak = strain.length > 0 && !(own && own[1] >= WEAK);
      tube.mesh.material = this.painted.fill(weak ? "passive" : tube.wire.role);
    }
    for (const bar of this.bars) bar.mesh.material = this.painted.fill(strain.length && bar.energy(strain) < WEAK ? "mesh" : "beam");
  }

  // Move all shapes to placements of the frames.
  place(T) {
    this.T = T;
    this.groups.forEach((group, j) => group.matrix.set(...T[j]));
    for (const tube of this.tubes) {
      const j = tube.wire.frame;
      tube.bend(this.frames.moved(T, j), this.frames.slides[j]);
    }
    for (const bar of this.bars) bar.place(T);
  }
}

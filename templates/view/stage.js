"use strict";
// The space in which the machine stands: light, paths, and the names in front of it.

const PATH = 0.1;  // radius of a path, units
const MOST_OF_A_JOINT = 60;  // px from a frame to its name

class Stage {
  constructor(data, frames, canvas, labels) {
    this.data = data;
    this.canvas = canvas;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.space = new THREE.Scene();
    this.painted = new Painted(data);
    this.figure = new MachineFigure(data, frames, this.painted);
    this.paths = new THREE.Group();
    this.ghost = Object.assign(this.figure.ghost(), { visible: false });
    this.eye = new Eye(data, canvas, () => this._corners(), () => this.request());
    const light = new THREE.DirectionalLight(0xffffff, 1.5);
    light.position.set(-0.5, 1, 1.2);
    this.eye.camera.add(light);
    this.ground = data.stands ? new Ground(data, this.figure, this.painted) : null;
    this.ruler = new Ruler(this.figure, this.painted);
    this.space.add(...this.figure.groups, this.paths, this.ghost, this.ruler.line, ...(this.ground ? [this.ground.group] : []), this.eye.camera, new THREE.HemisphereLight(0xffffff, 0x9aa4b4, 2.5));
    this.labels = new Labels(labels, data.marks);
    this.named = !data.crowded;
    this.painted.dark.addEventListener("change", () => this.repaint());
    Object.assign(this.eye, this._window());
    this.eye.look("Home");
    new ResizeObserver(() => this._resized()).observe(canvas.parentElement);
    this._resized();
    this.repaint();
  }

  repaint() {
    this.painted.repaint();
    this.request();
  }

  request() {
    if (!this.asked) this.asked = requestAnimationFrame(() => this.render());
  }

  // Corners of the boxes around all shapes.
  _corners() {
    return [...cornersOf(this.figure.groups)].map(([corner]) => corner);
  }

  _window() {
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    return { width: Math.max(1, clientWidth), height: Math.max(1, clientHeight) };
  }

  _resized() {
    const { width, height } = Object.assign(this, this._window());
    this.eye.shape(width, height);
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.render();
  }

  render() {
    this.asked = 0;
    const { camera } = this.eye;
    this.renderer.render(this.space, camera);
    if (this.named) this._name();
    const seen = camera.projectionMatrix.clone().multiply(camera.matrixWorldInverse);
    this.rendered?.();
    this.canvas.dataset.camera = seen.transpose().elements.map((x) => x.toPrecision(9)).join(" ");
  }

  _name() {
    const joint = Math.min(1.4 * this.data.unit * this.eye.scale, MOST_OF_A_JOINT);
    const at = (frame) => [3, 7, 11].map((k) => this.figure.T[frame][k]);
    this.labels.place((frame) => this._pixelOf(new THREE.Vector3(...at(frame))), this.width, this.height, joint, this._covered());
  }

  _pixelOf(point) {
    const p = point.project(this.eye.camera);
    return { x: (1 + p.x) * this.width / 2, y: (1 - p.y) * this.height / 2 };
  }

  // Boxes, px, around joints, springs and rods.
  _covered() {
    const boxes = new Map();
    for (const [corner, mesh] of cornersOf(this.figure.groups)) {
      if (!this.figure.joints.has(mesh)) continue;
      const { x, y } = this._pixelOf(corner), box = boxes.get(mesh) ?? { left: x, right: x, top: y, bottom: y };
      boxes.set(mesh, { left: Math.min(box.left, x), right: Math.max(box.right, x), top: Math.min(box.top, y), bottom: Math.max(box.bottom, y) });
    }
    return [...boxes.values()];
  }

  place(T) {
    this.figure.place(T);
    this.ground?.place(T);
    this.ruler.place();
    if (!this.eye.chosen) this.eye.keep(this._corners());
    this.request();
  }

  emphasize(strain) {
    this.figure.emphasize(strain);
    this.repaint();
  }

  // Keep the machine in the window at all of these placements.
  keep(placements) {
    this.eye.keep(placements.flatMap((T) => {
      this.figure.place(T);
      return this._corners();
    }));
  }

  // Draw lines through points in frame 0, each of a role; `owner` is whose they are.
  trace(lines, owner = null) {
    this.traced = owner;
    this.ghost.visible = lines.some(({ role }) => role === "arrow");
    for (const old of this.paths.children) old.geometry.dispose();
    this.paths.clear();
    const radius = PATH * this.data.unit;
    for (const { points, role } of lines) this.paths.add(pathTube(points, radius, this.painted.fill(role)));
    this.repaint();
  }
}

"use strict";
// The space in which the machine stands: camera, light, paths, and the names in front of it.

const STEP = 0.09, CLOSER = 1.15;  // rad of a key, ratio of a zoom
const AZIMUTH = 35 * Math.PI / 180, ROOM = 1.22;  // of the view of the picture; around the machine, for names
const PATH = 0.07;  // radius of a path, units
const DIRECTIONS_OF_VIEWS = { Home: null, Front: [0, 0, 1], Right: [1, 0, 0], Top: [0, 1, 0] };

class Stage {
  constructor(data, frames, canvas, labels) {
    this.data = data;
    this.canvas = canvas;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.space = new THREE.Scene();
    this.painted = new Painted(data);
    this.figure = new MachineFigure(data, frames, this.painted);
    this.space.add(...this.figure.groups);
    this.paths = this.space.add(new THREE.Group()).children.at(-1);
    this.up = new THREE.Vector3(...data.up);
    this.camera = new THREE.OrthographicCamera();
    this.camera.up.copy(this.up);
    this.space.add(this.camera, new THREE.HemisphereLight(0xffffff, 0x9aa4b4, 2.5));
    this.light = new THREE.DirectionalLight(0xffffff, 1.5);
    this.light.position.set(-0.5, 1, 1.2);
    this.camera.add(this.light);
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.request());
    this.labels = new Labels(labels, data.marks);
    this.named = true;
    this.painted.dark.addEventListener("change", () => this.repaint());
    canvas.addEventListener("keydown", (event) => this._key(event));
    new ResizeObserver(() => this._resized()).observe(canvas.parentElement);
    this.look("Home");
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
    const found = [];
    this.space.updateMatrixWorld(true);
    for (const group of this.figure.groups)
      group.traverse((one) => {
        if (!one.isMesh) return;
        one.geometry.computeBoundingBox();
        const { min, max } = one.geometry.boundingBox;
        for (const x of [min.x, max.x]) for (const y of [min.y, max.y]) for (const z of [min.z, max.z])
          found.push(new THREE.Vector3(x, y, z).applyMatrix4(one.matrixWorld));
      });
    return found;
  }

  // Look from a side that has a name; `Home` is the view of the picture.
  look(name) {
    const seen = new THREE.Vector3(...this.data.view[2]);
    const front = seen.clone().addScaledVector(this.up, -seen.dot(this.up)).normalize().applyAxisAngle(this.up, -AZIMUTH);
    const right = this.up.clone().cross(front), way = DIRECTIONS_OF_VIEWS[name];
    if (way) seen.set(0, 0, 0).addScaledVector(right, way[0]).addScaledVector(this.up, way[1]).addScaledVector(front, way[2] + 1e-4);
    this._fit(seen.normalize());
    this.camera.zoom = 1;
    this._resized();
    this.controls.update();
    this.request();
  }

  // Put the camera where all shapes are in the middle, looking against `eye`.
  _fit(eye) {
    const right = this.up.clone().cross(eye).normalize(), axes = [right, eye.clone().cross(right), eye];
    const corners = this._corners(), middle = new THREE.Vector3();
    const halves = axes.map((axis) => {
      const along = corners.map((p) => p.dot(axis)), [low, high] = [Math.min(...along), Math.max(...along)];
      middle.addScaledVector(axis, (low + high) / 2);
      return Math.max((high - low) / 2, this.data.unit);
    });
    [this.across, this.upward] = halves;
    this.radius = Math.hypot(...halves);
    this.controls.target.copy(middle);
    this.camera.position.copy(middle).addScaledVector(eye, 4 * this.radius);
  }

  turn(aside, upward) {
    const way = this.camera.position.clone().sub(this.controls.target);
    const across = this.up.clone().cross(way).normalize(), angle = way.angleTo(this.up);
    const tilt = Math.min(Math.max(angle - upward, 0.01), Math.PI - 0.01) - angle;
    way.applyAxisAngle(across, tilt).applyAxisAngle(this.up, aside);
    this.camera.position.copy(this.controls.target).add(way);
    this.controls.update();
    this.request();
  }

  zoom(ratio) {
    this.camera.zoom = Math.min(Math.max(this.camera.zoom * ratio, 0.1), 100);
    this.camera.updateProjectionMatrix();
    this.request();
  }

  _key(event) {
    const keys = {
      ArrowLeft: () => this.turn(-STEP, 0), ArrowRight: () => this.turn(STEP, 0),
      ArrowUp: () => this.turn(0, STEP), ArrowDown: () => this.turn(0, -STEP),
      "+": () => this.zoom(CLOSER), "=": () => this.zoom(CLOSER), "-": () => this.zoom(1 / CLOSER), Home: () => this.look("Home"),
    };
    if (!keys[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    keys[event.key]();
  }

  _resized() {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    if (!width || !height) return;
    Object.assign(this, { width, height });
    const across = ROOM * Math.max(this.across, this.upward * width / height), upward = across * height / width;
    Object.assign(this.camera, { left: -across, right: across, top: upward, bottom: -upward, near: 0.01 * this.radius, far: 9 * this.radius });
    this.camera.updateProjectionMatrix();
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.render();
  }

  render() {
    this.asked = 0;
    this.renderer.render(this.space, this.camera);
    if (this.named) this._name();
    const seen = this.camera.projectionMatrix.clone().multiply(this.camera.matrixWorldInverse);
    this.canvas.dataset.camera = seen.transpose().elements.map((x) => x.toPrecision(9)).join(" ");
  }

  _name() {
    const pixels = this.camera.zoom * this.width / (this.camera.right - this.camera.left);
    const joint = Math.min(1.1 * this.data.unit * pixels, 60);
    this.labels.place((frame) => this._pointOf(frame), this.width, this.height, joint);
  }

  _pointOf(frame) {
    const T = this.figure.T[frame], p = new THREE.Vector3(T[3], T[7], T[11]).project(this.camera);
    return { x: (1 + p.x) * this.width / 2, y: (1 - p.y) * this.height / 2 };
  }

  place(T) {
    this.figure.place(T);
    this.request();
  }

  // Draw lines through points in frame 0, each of a role; none where there are none.
  trace(lines) {
    for (const old of this.paths.children) old.geometry.dispose();
    this.paths.clear();
    const radius = PATH * this.data.unit;
    for (const { points, role } of lines) this.paths.add(pathTube(points, radius, this.painted.fill(role)));
    this.repaint();
  }
}

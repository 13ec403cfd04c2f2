"use strict";
// From where the machine is seen: turned, zoomed and fitted by pointer, touch, keys or the name of a side.

const STEP = 0.09, CLOSER = 1.15;  // rad of a key, ratio of a zoom
const AZIMUTH = 35 * Math.PI / 180, ROOM = 1.22;  // of the view of the picture; around the machine, for names
const SIDES_SEEN = { Home: null, Front: [0, 0, 1], Right: [1, 0, 0], Top: [0, 1, 0] };

class Eye {
  // `corners()` are points around all shapes; `changed()` is called where the view is another one. `chosen` is a view that
  // the reader has turned, moved or zoomed: it stays.
  constructor(data, canvas, corners, changed) {
    Object.assign(this, { corners, changed, chosen: false, least: data.unit, home: new THREE.Vector3(...data.view[2]) });
    this.up = new THREE.Vector3(...data.up);
    this.camera = new THREE.OrthographicCamera();
    this.camera.up.copy(this.up);
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", changed);
    this.controls.addEventListener("start", () => { this.chosen = true; });
    canvas.addEventListener("keydown", (event) => this._key(event));
  }

  // Look from a side that has a name; `Home` is the view of the picture.
  look(name) {
    Object.assign(this, { side: name, chosen: false });
    const seen = this.home.clone();
    const front = seen.clone().addScaledVector(this.up, -seen.dot(this.up)).normalize().applyAxisAngle(this.up, -AZIMUTH);
    const right = this.up.clone().cross(front), way = SIDES_SEEN[name];
    if (way) seen.set(0, 0, 0).addScaledVector(right, way[0]).addScaledVector(this.up, way[1]).addScaledVector(front, way[2] + 1e-4);
    this._fit(seen.normalize(), this.corners());
  }

  // Where a point is outside of the window, look from farther away, so that all are in it.
  keep(corners) {
    const outside = (p) => Math.max(Math.abs(p.x), Math.abs(p.y)) > 1;
    this.camera.updateMatrixWorld(true);
    if (!corners.some((p) => outside(p.clone().project(this.camera)))) return;
    this._fit(this.camera.position.clone().sub(this.controls.target).normalize(), corners);
  }

  // Put the camera where all corners are around the middle, looking against `eye`.
  _fit(eye, corners) {
    const right = this.up.clone().cross(eye).normalize(), axes = [right, eye.clone().cross(right), eye];
    const middle = new THREE.Vector3();
    const halves = axes.map((axis) => {
      const along = corners.map((p) => p.dot(axis)), [low, high] = [Math.min(...along), Math.max(...along)];
      middle.addScaledVector(axis, (low + high) / 2);
      return Math.max((high - low) / 2, this.least);
    });
    [this.across, this.upward] = halves;
    this.radius = Math.hypot(...halves);
    this.controls.target.copy(middle);
    this.camera.position.copy(middle).addScaledVector(eye, 4 * this.radius);
    this.camera.zoom = 1;
    this.shape(this.width, this.height);
    this.controls.update();
    this.changed();
  }

  // Fill a window of so many pixels.
  shape(width, height) {
    Object.assign(this, { width, height });
    const across = ROOM * Math.max(this.across, this.upward * width / height), upward = across * height / width;
    const { radius } = this;
    Object.assign(this.camera, { left: -across, right: across, top: upward, bottom: -upward, near: 0.01 * radius, far: 9 * radius });
    this.camera.updateProjectionMatrix();
  }

  // Pixels of a metre.
  get scale() {
    return this.camera.zoom * this.width / (this.camera.right - this.camera.left);
  }

  turn(aside, upward) {
    const way = this.camera.position.clone().sub(this.controls.target);
    const across = this.up.clone().cross(way).normalize(), angle = way.angleTo(this.up);
    const tilt = Math.min(Math.max(angle - upward, 0.01), Math.PI - 0.01) - angle;
    way.applyAxisAngle(across, tilt).applyAxisAngle(this.up, aside);
    this.camera.position.copy(this.controls.target).add(way);
    this.controls.update();
    this.changed();
  }

  zoom(ratio) {
    this.camera.zoom = Math.min(Math.max(this.camera.zoom * ratio, 0.1), 100);
    this.camera.updateProjectionMatrix();
    this.changed();
  }

  _key(event) {
    const keys = {
      ArrowLeft: () => this.turn(-STEP, 0), ArrowRight: () => this.turn(STEP, 0),
      ArrowUp: () => this.turn(0, STEP), ArrowDown: () => this.turn(0, -STEP),
      "+": () => this.zoom(CLOSER), "=": () => this.zoom(CLOSER), "-": () => this.zoom(1 / CLOSER), Home: () => this.look("Home"),
    };
    if (!keys[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    this.chosen = true;
    keys[event.key]();
  }
}

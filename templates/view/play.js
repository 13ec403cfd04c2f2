"use strict";
// What moves the machine: sliders, a mode, or a motion over time; one of them at a time.

const SLOW = 0.8;  // Hz at which a mode is shown
const MOST = 8, FEW = 6;  // motors whose sliders are shown at once; with more of them, the first

class Player {
  constructor(data, frames, stage) {
    Object.assign(this, { data, frames, stage, q: [...data.q], running: null, mode: null, amplitude: 1 });
    this.status = document.getElementById("status");
    this.standing = stage ? "" : "This browser shows no WebGL: the picture stands still.";
    this.listeners = [];
  }

  // Move to q; where a loop does not close stay, and say so. Sliders show where it stands, not a mode drawn larger.
  place(q, standing = true) {
    const T = this.frames.at(q);
    this.status.textContent = T ? this.standing : "A loop does not close there.";
    if (T) {
      if (standing) this.q = [...q];
      this.stage?.place(T);
      this.stage && (this.stage.canvas.dataset.q = q.map((x) => x.toPrecision(12)).join(" "));
      if (standing) for (const listener of this.listeners) listener(this.q);
    }
    return Boolean(T);
  }

  set(k, x) {
    this.stop();
    return this.place(this.q.map((old, i) => (i === k ? x : old)));
  }

  home() {
    this.stop();
    this.stage?.trace([]);
    this.stage?.emphasize([]);
    this.frames.follower?.restart();
    this.place(this.data.q);
  }

  stop() {
    const stopped = this.running;
    this.running = null;
    this.mode = null;
    this.enlarged?.();
    stopped?.ended?.();
  }

  // Call `shown(seconds)` for every picture until something else moves the machine.
  run(shown, ended) {
    this.stop();
    const running = { ended }, begin = performance.now();
    this.running = running;
    const next = (now) => {
      if (this.running !== running) return;
      shown(Math.max(0, now - begin) / 1000);
      requestAnimationFrame(next);
    };
    requestAnimationFrame(next);
  }

  swing(mode) {
    this.home();
    if (!mode) return;
    const at = (by) => this.data.q.map((x, k) => x + by * this.amplitude * mode.shape[k]);
    this.stage?.emphasize(mode.strain);
    this.stage?.trace(mode.arrows.map((points) => ({ points, role: "arrow" })));
    if (!this.stage?.eye.chosen) this.stage?.keep([1, -1].map((by) => this.frames.at(at(by))).filter((T) => T));
    this.run((t) => this.place(at(Math.sin(2 * Math.PI * SLOW * t)), false));
    this.mode = mode;
    this.enlarged();
  }
}

function positionSection(player, data) {
  const sliders = data.joints.map((joint, k) => slider(
    { name: joint.name, unit: joint.unit, role: joint.role, value: data.q[k], low: joint.low, high: joint.high },
    (x) => player.set(k, x)));
  player.listeners.push((q) => sliders.forEach((one, k) => one.show(q[k])));
  const driven = data.joints.some((joint) => joint.motor);
  const of = (motor) => sliders.filter((_, k) => data.joints[k].motor === motor);
  const [first, more] = of(true).length > MOST ? [of(true).slice(0, FEW), of(true).slice(FEW)] : [of(true), []];
  const hidden = more.length ? element("details", {}, element("summary", {}, `${more.length} more motors`), ...more) : "";
  const others = of(false).length ? element("details", { open: !driven }, element("summary", {}, !driven ? "joints" : data.joints.some((joint) => joint.role === "elastic") ? "springs and other joints" : "other joints"), ...of(false)) : "";
  return section("Position", ...first, hidden, others, button("Back to the start", () => player.home()));
}

const VIBRATION = { m: 1e-4, rad: 1e-4 };  // a motion that modes are compared with, m or rad

function howFar(mode, amplitude) {
  return mode?.most.far ? `${mode.most.frame} ± ${quantity(amplitude * mode.most.far, mode.most.unit, 3)}` : `× ${figures(amplitude, 3)}`;
}

// How many times larger a mode is drawn than where the frame that moves most vibrates by 0.1 mm, or 0.1 mrad.
function howLarge(mode, amplitude) {
  if (!mode?.most.far) return "";
  const { frame, far, unit } = mode.most;
  return `× ${figures(amplitude * far / VIBRATION[unit], 3)} of a vibration of ${frame} by ± ${unit === "m" ? "0.1 mm" : "0.1 mrad"}`;
}

function modesSection(player, data) {
  const place = element("div", {});
  const choose = (set, pressed) => {
    player.home();
    place.replaceChildren(modeList(set, (mode) => player.swing(mode)));
    tabs.querySelectorAll("button").forEach((one) => one.setAttribute("aria-pressed", String(one === pressed)));
  };
  const tabs = element("div", { class: "tabs", role: "group", "aria-label": "Which modes" });
  for (const set of data.modes) tabs.append(button(set.title, (event) => choose(set, event.currentTarget), { "aria-pressed": "false" }));
  const first = data.modes.findIndex((set) => !set.refused);
  const amplitude = slider({ name: "amplitude", value: 1, low: 0, high: 3, unit: "", text: (x) => howFar(player.mode, x) },
    (x) => { player.amplitude = x; player.enlarged(); return true; });
  const scale = element("p", { class: "remark" });
  player.enlarged = () => { amplitude.show(player.amplitude); scale.textContent = howLarge(player.mode, player.amplitude); };
  const made = section("Modes", data.modes.length > 1 ? tabs : "", place, amplitude, scale);
  choose(data.modes[Math.max(0, first)], tabs.children[Math.max(0, first)]);
  return made;
}

function showSection(stage, data) {
  const layer = (name) => (on) => { stage.figure.layers[name].forEach((mesh) => (mesh.visible = on)); stage.request(); };
  const names = (on) => { stage.named = on; stage.labels.svg.classList.toggle("hidden", !on); stage.request(); };
  return section("Show", element("div", { class: "checks" },
    check("bodies of equal inertia", !data.meshes.length, layer("bodies")),
    ...(data.meshes.length ? [check("meshes", true, layer("meshes"))] : []), check("axes x y z", true, layer("axes")), check("names", stage.named, names),
    ...(stage.ground ? [check(stage.ground.label, true, (on) => { stage.ground.group.visible = on; stage.request(); })] : [])),
    element("p", { class: "legend" }, ...data.legend.map(([role, text]) => element("span", { class: `key ${role}` }, text))));
}

"use strict";
// The picture: a page of its own, replaced once the new one stands, and seen as the one before was.
const picture = {
  frame: null,
  show({ version, modes }) {
    const made = element("iframe", { class: "arriving", title: "The machine, its joints and modes", src: `picture?${version}${modes ? "-modes" : ""}` });
    this.arriving?.remove();
    this.arriving = made;
    made.addEventListener("load", () => {
      if (this.arriving !== made) return;
      const old = this.frame, focused = old !== null && document.activeElement === old;
      if (old) resume(made, old);
      made.classList.remove("arriving");
      old?.remove();
      document.getElementById("waiting").hidden = true;
      if (focused) made.focus();
      Object.assign(this, { frame: made, arriving: null });
      document.body.dataset.shown = version;
      document.body.dataset.modes = modes;
    });
    document.getElementById("picture").append(made);
  },
};

// How a machine is seen: its camera, its joints by name, the mode that moves.
function seen(window) {
  const { player } = window, eye = player?.stage?.eye;
  if (!eye) return null;
  const buttons = [...window.document.querySelectorAll(".modes button")];
  return {
    chosen: eye.chosen,
    side: eye.side,
    camera: JSON.stringify([eye.camera.position, eye.camera.zoom, eye.controls.target, eye.across, eye.upward, eye.radius]),
    q: Object.fromEntries(player.data.joints.map((joint, k) => [joint.name, player.q[k]])),
    start: Object.fromEntries(player.data.joints.map((joint, k) => [joint.name, player.data.q[k]])),
    tab: [...window.document.querySelectorAll(".tabs button")].findIndex((one) => one.getAttribute("aria-pressed") === "true"),
    mode: buttons.findIndex((one) => one.getAttribute("aria-pressed") === "true"),
    scrolled: [window.document.getElementById("panel").scrollTop, window.scrollY],
  };
}

function resume(made, old) {
  const window = made.contentWindow, { player } = window, was = old.contentWindow && seen(old.contentWindow);
  if (!was || !player?.stage) return;
  if (was.chosen || was.side !== "Home") {
    const { eye } = player.stage, [position, zoom, target, across, upward, radius] = JSON.parse(was.camera);
    eye.camera.position.copy(position);
    eye.controls.target.copy(target);
    eye.camera.zoom = zoom;
    Object.assign(eye, { across, upward, radius });
    eye.shape(eye.width, eye.height);
    eye.controls.update();
    Object.assign(eye, { side: was.side, chosen: was.chosen });
  }
  const moved = (name) => was.q[name] !== undefined && was.q[name] !== was.start[name];
  if (was.mode < 0) player.place(player.q.map((x, k) => (moved(player.data.joints[k].name) ? was.q[player.data.joints[k].name] : x)));
  else made.mode = [was.tab, was.mode];
  const [tab, mode] = made.mode ?? old.mode ?? [-1, -1], press = (one) => one?.click();
  if (mode >= 0 && player.data.modes.length) {
    press(window.document.querySelectorAll(".tabs button")[tab]);
    press(window.document.querySelectorAll(".modes button")[mode]);
  } else if (mode >= 0) made.mode = [tab, mode];
  window.document.getElementById("panel").scrollTop = was.scrolled[0];
  window.scrollTo(0, was.scrolled[1]);
}

"use strict";
// Where the machine stands and from where it is seen, in the part of the address after #: numbers only.

const WAIT = 300;  // ms without a change before the address is written

function numbersOf(text, count) {
  const found = (text ?? "").split(",").map(Number);
  return found.length === count && found.every(Number.isFinite) ? found : null;
}

function keepAddress(stage, player, data) {
  const { eye } = stage, { camera, controls } = eye, written = (x) => String(Number(x.toPrecision(6)));
  const told = new URLSearchParams(location.hash.slice(1));
  const q = numbersOf(told.get("q"), data.q.length), seen = numbersOf(told.get("eye"), 10);
  if (q) player.place(q);
  if (seen && seen.slice(6).every((x) => x > 0)) {
    camera.position.set(...seen.slice(0, 3));
    controls.target.set(...seen.slice(3, 6));
    [camera.zoom, eye.across, eye.upward, eye.radius] = seen.slice(6);
    eye.shape(eye.width, eye.height);
    controls.update();
    eye.chosen = true;
    stage.request();
  }
  let waiting = 0;
  const write = () => {
    const now = [...camera.position.toArray(), ...controls.target.toArray(), camera.zoom, eye.across, eye.upward, eye.radius];
    const hash = `#q=${player.q.map(written).join(",")}&eye=${now.map(written).join(",")}`;
    try { history.replaceState(null, "", hash); } catch { /* a page inside another has no address of its own */ }
  };
  const later = () => { clearTimeout(waiting); waiting = setTimeout(write, WAIT); };
  controls.addEventListener("change", later);
  player.listeners.push(later);
}

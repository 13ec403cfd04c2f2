"use strict";
// The picture is there without a script; with one the machine itself takes its place.
function start() {
  const data = JSON.parse(document.getElementById("data").textContent);
  const frames = new Frames(programs, data), canvas = document.getElementById("space");
  document.getElementById("title").textContent = data.title;
  document.getElementById("summary").textContent = data.summary;
  canvas.setAttribute("aria-label", `Machine ${data.title}: ${data.summary}`);
  document.title = data.title;
  const lines = [...data.remarks, ...data.notes].map((line) => element("p", {}, line));
  document.getElementById("notes").append(...lines);
  const stage = stageOf(data, frames, canvas);
  const player = new Player(data, frames, stage);
  player.place(data.q);
  if (!stage) return player;
  const sections = document.getElementById("sections");
  if (data.joints.length) sections.append(positionSection(player, data));
  if (data.modes.length) sections.append(modesSection(player, data));
  data.motions.forEach((motion) => sections.append(motionSection(player, data, motion)));
  if (data.marks.length > 1) sections.append(measureSection(stage, data));
  sections.append(showSection(stage, data));
  sections.append(recordSection(stage, player, data));
  document.getElementById("views").append(...Object.keys(SIDES_SEEN).map((name) => button(name, () => stage.eye.look(name))));
  const hint = document.getElementById("hint");
  canvas.addEventListener("pointerup", () => { hint.hidden = true; }, { once: true });
  keepAddress(stage, player, data);
  return player;
}

// The machine in space in the place of its picture; null, and the picture stays, where there is no WebGL.
function stageOf(data, frames, canvas) {
  try {
    const stage = new Stage(data, frames, canvas, document.getElementById("labels"));
    document.getElementById("still").hidden = true;
    return stage;
  } catch {
    canvas.hidden = true;
    return null;
  }
}

window.player = start();

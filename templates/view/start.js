"use strict";
// The picture is there without a script; with one the machine itself takes its place.
function start() {
  const data = JSON.parse(document.getElementById("data").textContent);
  const frames = new Frames(programs, data), canvas = document.getElementById("space");
  document.getElementById("title").textContent = data.title;
  document.getElementById("summary").textContent = data.summary;
  canvas.setAttribute("aria-label", `Machine ${data.title}: ${data.summary}`);
  let stage = null;
  try {
    stage = new Stage(data, frames, canvas, document.getElementById("labels"));
    document.getElementById("still").hidden = true;
  } catch (error) {
    canvas.hidden = true;
    document.getElementById("status").textContent = "This browser shows no WebGL: the picture stands still.";
  }
  const player = new Player(data, frames, stage);
  const sections = document.getElementById("sections");
  if (data.joints.length) sections.append(positionSection(player, data));
  if (data.modes.length) sections.append(modesSection(player, data));
  data.motions.forEach((motion) => sections.append(motionSection(player, data, motion)));
  if (stage) sections.append(showSection(stage));
  if (stage) document.getElementById("views").append(...Object.keys(SIDES_SEEN).map((name) => button(name, () => stage.eye.look(name))));
  const lines = [...data.remarks, ...data.notes].map((line) => element("p", {}, line));
  document.getElementById("notes").append(...lines);
  player.place(data.q);
}

start();

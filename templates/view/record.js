"use strict";
// What is seen, with names, as a film: a file of the browser's own recorder.

const FORMATS = ["video/mp4;codecs=avc1", "video/webm;codecs=vp9", "video/webm"], PICTURES = 30;  // a second

// Draw the space and the names in front of it on a canvas.
function photograph(stage, context) {
  const { width, height } = context.canvas, ratio = width / stage.width;
  context.fillStyle = stage.painted.palette.paper;
  context.fillRect(0, 0, width, height);
  context.drawImage(stage.canvas, 0, 0, width, height);
  if (!stage.named) return;
  context.save();
  context.scale(ratio, ratio);
  Object.assign(context, { font: TEXT.font, lineWidth: 3.5, lineJoin: "round", strokeStyle: stage.painted.palette.paper, fillStyle: stage.painted.palette.ink });
  for (const text of stage.labels.svg.querySelectorAll("g:not(.hidden) text")) {
    const [x, y] = ["x", "y"].map((key) => Number(text.getAttribute(key)));
    context.strokeText(text.textContent, x, y);
    context.fillText(text.textContent, x, y);
  }
  context.restore();
}

function save(chunks, type, title) {
  const address = URL.createObjectURL(new Blob(chunks, { type }));
  const name = `${title.replace(/[^\p{L}\p{N}._-]+/gu, "_") || "machine"}.${type.includes("mp4") ? "mp4" : "webm"}`;
  element("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 1000);
}

// Record what the stage shows; the returned function ends it and saves the file.
function recording(stage, type, title) {
  const film = element("canvas", { width: 2 * Math.round(stage.canvas.width / 2), height: 2 * Math.round(stage.canvas.height / 2) });
  const context = film.getContext("2d"), chunks = [], recorder = new MediaRecorder(film.captureStream(PICTURES), { mimeType: type, videoBitsPerSecond: 8e6 });
  recorder.addEventListener("dataavailable", (event) => chunks.push(event.data));
  recorder.addEventListener("stop", () => save(chunks, type, title));
  stage.rendered = () => photograph(stage, context);
  stage.render();
  recorder.start();
  return () => { stage.rendered = null; recorder.stop(); };
}

function recordSection(stage, player, data) {
  const type = typeof MediaRecorder === "undefined" ? undefined : FORMATS.find((one) => MediaRecorder.isTypeSupported(one));
  if (!type) return section("Record", element("p", { class: "remark" }, "This browser records no video."));
  let end = null;
  const pressed = () => {
    if (end) end();
    end = end ? null : recording(stage, type, data.title);
    one.textContent = end ? "End, and save the video" : "Record what moves";
    one.setAttribute("aria-pressed", String(Boolean(end)));
  };
  const one = button("Record what moves", pressed, { "aria-pressed": "false" });
  return section("Record", one);
}

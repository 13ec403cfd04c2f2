"use strict";
// A motion over time: its path, a slider of time, and deviations from the reference made large enough to be seen.

const STEPS = [1, 2, 5];

// The deviation at each time between two samples, q of the reference, and both together.
function positionAt(motion, t, times) {
  let k = motion.t.findIndex((x) => x > t);
  k = k < 1 ? (k < 0 ? motion.t.length - 1 : 1) : k;
  const [a, b] = [motion.t[k - 1], motion.t[k]], share = Math.min(1, Math.max(0, (t - a) / (b - a)));
  const between = (rows) => rows[k].map((x, i) => rows[k - 1][i] + share * (x - rows[k - 1][i]));
  const [reference, deviation] = [between(motion.reference), between(motion.deviation)];
  return reference.map((x, i) => x + times * deviation[i]);
}

function pathsOf(frames, data, motion, times) {
  const at = (row, k, by) => row.map((x, i) => x + by * motion.deviation[k][i]);
  const through = (by) => motion.reference.map((row, k) => frames.at(at(row, k, by))).filter((T) => T);
  const [wanted, found] = [through(0), through(times)];
  const line = (all, leaf, role) => ({ role, points: all.map((T) => [T[leaf][3], T[leaf][7], T[leaf][11]]) });
  return data.leaves.flatMap((leaf) => [line(wanted, leaf, "passive"), line(found, leaf, "z")]);
}

// How many times larger deviations are shown at first: 1, 2, 5, 10 ..., so that the largest is some of the machine.
function firstScale(frames, data, motion) {
  const lines = pathsOf(frames, data, motion, 1), [wanted, found] = [0, 1].map((half) => lines.filter((_, k) => k % 2 === half));
  let far = 0;
  wanted.forEach((line, k) => line.points.forEach((p, i) => {
    far = Math.max(far, Math.hypot(...p.map((x, axis) => x - found[k].points[i]?.[axis])) || 0);
  }));
  if (!(far > 0)) return 1;
  const wish = 0.02 * data.extent / far, decade = 10 ** Math.floor(Math.log10(wish));
  return Math.max(1, decade * STEPS.filter((x) => x * decade <= wish).at(-1));
}

function motionSection(player, data, motion) {
  const last = motion.t.at(-1), scale = firstScale(player.frames, data, motion);
  const state = { t: 0, times: scale };
  const go = (t) => { state.t = t; return player.place(positionAt(motion, t, state.times)); };
  const paths = () => {
    if (!player.stage || player.stage.traced === motion) return;
    player.stage.trace(pathsOf(player.frames, data, motion, state.times), motion);
    const times = [0, 0.25, 0.5, 0.75, 1].map((share) => share * last);
    player.stage.keep(times.map((t) => player.frames.at(positionAt(motion, t, state.times))).filter((T) => T));
  };
  const time = slider({ name: "time", value: 0, low: 0, high: last, unit: "s" }, (t) => { player.stop(); paths(); return go(t); });
  const play = button("Play", () => {
    if (play.textContent === "Pause") return player.stop();
    const from = state.t >= last ? 0 : state.t, slow = Math.max(1, 3 / last);
    paths();
    player.run((seconds) => {
      const t = Math.min(last, from + seconds / slow);
      go(t);
      time.show(t);
      if (t >= last) player.stop();
    }, () => { play.textContent = "Play"; });
    play.textContent = "Pause";
  });
  const larger = [...new Set([1, scale / 10, scale, scale * 10].filter((x) => x >= 1))];
  const choice = element("select", { "aria-label": "Deviations from the reference", onchange: () => { state.times = Number(choice.value); player.stage?.trace([]); paths(); go(state.t); } },
    ...larger.map((x) => element("option", { value: x, selected: x === scale }, `× ${figures(x)}`)));
  const rows = motion.remark
    ? [element("p", { class: "remark" }, motion.remark)]
    : [element("label", { class: "row" }, "deviations from the reference", choice),
      element("p", { class: "legend" }, ...[["passive", "reference"], ["z", "simulated"]].map(([role, text]) =>
        element("span", { class: `key ${role}` }, text)))];
  return section(motion.title, element("div", { class: "row" }, play, time), ...rows);
}

"use strict";
// Where the frames of the machine are, by the same program as in every other language.

const LONGEST = 0.05;  // of a step, rad or m, along which loops without a closed form are followed
const CLOSED = 1e-9;   // gap of a loop, m and rad
const MOST_STEPS = 400;

// Loops without a closed form: their joints are followed from where they were last.
class Follower {
  constructor(assemble, q, dependent) {
    this.assemble = assemble;
    this.start = { q: [...q], dependent: [...dependent] };
    this.restart();
  }

  restart() {
    this.q = this.start.q;
    this.dependent = this.start.dependent;
  }

  at(q) {
    const far = Math.max(0, ...q.map((x, k) => Math.abs(x - this.q[k])));
    const steps = Math.min(MOST_STEPS, Math.max(1, Math.ceil(far / LONGEST)));
    let guess = this.dependent;
    for (let k = 1; k <= steps + 1; k++) {
      const share = Math.min(1, k / steps);
      const { q_dep, residual } = this.assemble(q.map((x, i) => this.q[i] + share * (x - this.q[i])), guess);
      if (!(residual[0] < CLOSED)) return null;
      guess = q_dep;
    }
    this.q = [...q];
    this.dependent = guess;
    return guess;
  }
}

class Frames {
  constructor(programs, data) {
    this.program = programs.geometric_model;
    this.follower = programs.assemble ? new Follower(programs.assemble, data.q, data.dependent) : null;
    this.antecedents = data.antecedents;
    this.slides = data.slides;
    this.reference = this.at(data.q);
  }

  // Placements of frame 0 and of all rows; null where a loop does not close.
  at(q) {
    const dependent = this.follower ? this.follower.at(q) : undefined;
    if (dependent === null) return null;
    const { T } = this.program(q, dependent);
    if (!T.every(Number.isFinite)) return null;
    const found = [Float64Array.of(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1)];
    for (let k = 0; k < T.length; k += 16) found.push(Float64Array.from(T.slice(k, k + 16)));
    return found;
  }

  // How far the joint of a frame has moved since the figure was made.
  moved(T, j) {
    const seen = (all) => product(inverse(all[this.antecedents[j]]), all[j]);
    return slip(seen(T), seen(this.reference), this.slides[j]);
  }
}

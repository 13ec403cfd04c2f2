"use strict";
// Placements: 4 x 4 matrices as 16 numbers, row by row. Only rigid ones occur.

function product(a, b) {
  const c = new Float64Array(16);
  for (let i = 0; i < 4; i++)
    for (let j = 0; j < 4; j++)
      for (let k = 0; k < 4; k++) c[4 * i + j] += a[4 * i + k] * b[4 * k + j];
  return c;
}

function inverse(a) {
  const c = new Float64Array(16);
  for (let i = 0; i < 3; i++) {
    for (let j = 0; j < 3; j++) c[4 * i + j] = a[4 * j + i];
    c[4 * i + 3] = -(a[i] * a[3] + a[4 + i] * a[7] + a[8 + i] * a[11]);
  }
  c[15] = 1;
  return c;
}

// How far a joint has moved, m or rad, from the placements in its antecedent now and before.
function slip(now, before, slides) {
  const moved = product(inverse(before), now);
  return slides ? moved[11] : Math.atan2(moved[4], moved[0]);
}

// The points of a wire in its frame once the joint has moved: each stays behind by its share.
function bent(points, behind, moved, slides) {
  const found = new Float64Array(points.length);
  for (let k = 0; k < behind.length; k++) {
    const [x, y, z] = [points[3 * k], points[3 * k + 1], points[3 * k + 2]];
    const by = -moved * behind[k];
    const [c, s] = slides ? [1, 0] : [Math.cos(by), Math.sin(by)];
    found.set([x * c - y * s, x * s + y * c, slides ? z + by : z], 3 * k);
  }
  return found;
}

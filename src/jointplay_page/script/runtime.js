"use strict";
// What translated kernels call beside Math: arithmetic where the two languages differ, and operations on rows.
// The rows' operations are those of method/lanes/lanes.py, which stand there as vector instructions.

const runtime = {
  min: (a, b) => (b < a ? b : a), // the first of two that cannot be compared, as there
  max: (a, b) => (b > a ? b : a),
  square: (x) => x * x,
  quotient: (a, b) => Math.floor(a / b),
  remainder: (a, b) => a - b * Math.floor(a / b),
  copysign: (a, b) => (b < 0 || Object.is(b, -0) ? -Math.abs(a) : Math.abs(a)),

  matvec(w, to, source, at, table) {
    const a = source[at], b = source[at + 1], c = source[at + 2], d = source[at + 3];
    const e = source[at + 4], f = source[at + 5], g = source[at + 6], h = source[at + 7];
    for (let i = 0; i < 8; i += 1) {
      const low = a * table[i] + b * table[8 + i] + c * table[16 + i] + d * table[24 + i];
      w[to + i] = low + e * table[32 + i] + f * table[40 + i] + g * table[48 + i] + h * table[56 + i];
    }
  },

  position_row(w, to, h, speed, at, table, nodes) {
    runtime.matvec(w, to, w, at, table);
    for (let i = 0; i < 8; i += 1) w[to + i] = h * (speed * nodes[i] + w[to + i]);
  },

  add_matvec(w, to, squares, factor, at, table) {
    const z = runtime.row;
    runtime.matvec(z, 0, w, at, table);
    for (let i = 0; i < 8; i += 1) {
      w[to + i] += z[i];
      w[squares + i] += factor * z[i] * (factor * z[i]);
    }
  },

  axpy(w, to, factor, at) {
    for (let i = 0; i < 8; i += 1) w[to + i] += factor * w[at + i];
  },

  sparse_dot(w, to, numbers, pairs, begin, end) {
    for (let i = 0; i < 8; i += 2) {
      let one = 0;
      let other = 0;
      for (let o = begin; o < end; o += 2) {
        const number = numbers[pairs[o]];
        const at = pairs[o + 1] + i;
        one += number * w[at];
        other += number * w[at + 1];
      }
      w[to + i] = one;
      w[to + i + 1] = other;
    }
  },

  subtract_products(w, to, pairs, begin, end) {
    for (let i = 0; i < 4; i += 1) {
      let real = w[to + i];
      let imaginary = w[to + 4 + i];
      for (let o = begin; o < end; o += 2) {
        const a = pairs[o] + i;
        const b = pairs[o + 1] + i;
        real -= w[a] * w[b] - w[a + 4] * w[b + 4];
        imaginary -= w[a] * w[b + 4] + w[a + 4] * w[b];
      }
      w[to + i] = real;
      w[to + 4 + i] = imaginary;
    }
  },

  complex_multiply(w, to, a) {
    for (let i = to; i < to + 4; i += 1, a += 1) {
      const real = w[i] * w[a] - w[i + 4] * w[a + 4];
      w[i + 4] = w[i] * w[a + 4] + w[i + 4] * w[a];
      w[i] = real;
    }
  },

  complex_fma(w, to, a, b) {
    for (let i = 0; i < 4; i += 1) {
      const real = w[a + i] * w[b + i] - w[a + 4 + i] * w[b + 4 + i];
      w[to + 4 + i] += w[a + i] * w[b + 4 + i] + w[a + 4 + i] * w[b + i];
      w[to + i] += real;
    }
  },

  complex_sum(w, to, x, a, y, b, z) {
    for (let i = 0; i < 8; i += 1) w[to + i] = x * w[a + i] + y * w[b + i] + (i < 4 ? z : 0);
  },

  row: new Float64Array(8),
};

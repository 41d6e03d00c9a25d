// What the page holds of the curves: a ring of bins of every series it shows.
"use strict";

// The bins of one choice of series. A bin has a time and for each series one value, or its least and its largest.
class Curves {
  constructor(series, values, capacity) {
    this.series = series;
    this.values = values;
    this.capacity = capacity;
    this.room = 1024;
    this.length = 0;
    this.time = new Float64Array(this.room);
    this.bins = Array.from({ length: series * values }, () => new Float32Array(this.room));
  }

  // Takes a frame's bins in: `time` and for every series its values, one series after the other.
  append(count, time, floats) {
    this.makeRoom(count);
    this.time.set(time, this.length);
    for (let i = 0; i < this.bins.length; i++) this.bins[i].set(floats.subarray(i * count, (i + 1) * count), this.length);
    this.length += count;
  }

  makeRoom(count) {
    if (this.length + count <= this.room) return;
    // the oldest go once there are twice as many as are kept, so that moving the rest costs next to nothing
    if (this.room >= 2 * this.capacity && count <= this.capacity) {
      const from = Math.max(0, this.length + count - this.capacity);
      for (const of of [this.time, ...this.bins]) of.copyWithin(0, from, this.length);
      this.length -= from;
      return;
    }
    while (this.room < this.length + count) this.room *= 2;
    const grown = (of) => { const wide = new of.constructor(this.room); wide.set(of.subarray(0, this.length)); return wide; };
    this.time = grown(this.time);
    this.bins = this.bins.map(grown);
  }

  get first() { return this.length ? this.time[0] : NaN; }
  get last() { return this.length ? this.time[this.length - 1] : NaN; }

  // The first bin not before `at`.
  indexOf(at) {
    let low = 0, high = this.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.time[middle] < at) low = middle + 1; else high = middle;
    }
    return low;
  }

  // The least and the largest value of series `i` at the bin nearest before `at`.
  at(i, at) {
    const bin = Math.max(0, this.indexOf(at + 1e-12) - 1);
    if (!this.length || this.time[bin] > at) return null;
    const value = this.middle(i, bin);
    return Number.isNaN(value) ? null : value;
  }

  // The value of series `i` in a bin: its own, or the middle of its least and its largest.
  middle(i, bin) {
    return (this.bins[i * this.values][bin] + this.bins[(i + 1) * this.values - 1][bin]) / 2;
  }

  // The least, the largest, the mean and the standard deviation of series `i` from `from` to `to`.
  summary(i, from, to) {
    let count = 0, sum = 0, squares = 0, first = NaN;
    const [low, high] = this.extent([i], from, to);
    for (let bin = this.indexOf(from), end = Math.min(this.length, this.indexOf(to) + 1); bin < end; bin++) {
      const value = this.middle(i, bin);
      if (Number.isNaN(value)) continue;
      // from the first value on, or a small motion of a large number would be lost in its square
      if (count === 0) first = value;
      count += 1;
      sum += value - first;
      squares += (value - first) ** 2;
    }
    const mean = sum / count, variance = Math.max(0, squares / count - mean * mean);
    return { count, low, high, mean: first + mean, deviation: Math.sqrt(variance) };
  }

  // The least and the largest value of `series` from `from` to `to`.
  extent(series, from, to) {
    const begin = this.indexOf(from), end = Math.min(this.length, this.indexOf(to) + 1);
    let low = Infinity, high = -Infinity;
    for (const i of series) {
      const lows = this.bins[i * this.values], highs = this.bins[(i + 1) * this.values - 1];
      for (let k = begin; k < end; k++) {
        if (lows[k] < low) low = lows[k];
        if (highs[k] > high) high = highs[k];
      }
    }
    return [low, high];
  }

  // Series `i` from `from` to `to`, and a bin more at either end, for the painter.
  curve(i, from, to) {
    return {
      time: this.time, low: this.bins[i * this.values], high: this.bins[(i + 1) * this.values - 1],
      begin: Math.max(0, this.indexOf(from) - 1), end: Math.min(this.length, this.indexOf(to) + 1),
    };
  }
}

// A frame as it comes: what it belongs to, and its bins.
function readFrame(buffer) {
  const words = new Uint32Array(buffer, 0, 6);
  const [generation, number, series, bins, values, more] = words;
  return {
    generation, number, series, bins, values, more,
    lost: new Float64Array(buffer, 24, 1)[0],
    time: new Float64Array(buffer, 32, bins),
    floats: new Float32Array(buffer, 32 + 8 * bins, bins * series * values),
  };
}

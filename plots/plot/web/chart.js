// Curves on a page: uPlot with this project's inks, axes in SI prefixes, zoom by dragging and by the wheel.
//
// Times and values are in SI; what is not a number leaves a gap. Colours come from the page's custom properties (--s0…),
// so that a page that turns dark only has to make its charts anew.
"use strict";

const Chart = (() => {
  // The dashes of the inks: those of printed plots, px. A reader without colours tells curves by them.
  const DASHES = [
    [], [6.5, 3.5], [10, 3, 2, 3], [1, 3], [4, 2.5], [15, 3.5], [6.5, 2.5, 1, 2.5, 1, 2.5], [2.5, 1.5], [1, 5], [10, 2.5, 1, 2.5],
  ];
  const FONT = '12px system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", sans-serif';
  const PREFIXED = { m: [-3, 0], s: [-3, 0], V: [-3, 2], A: [-3, 2], N: [-3, 2], W: [-3, 2], "Ω": [-3, 2], J: [-3, 2], Pa: [-3, 2],
    "m/s": [-3, 0], "m/s²": [-3, 0], Hz: [0, 2] };
  const LETTERS = ["n", "µ", "m", "", "k", "M"];

  // The prefix in which a value has one to three digits before the point: { factor, unit }.
  function prefixed(magnitude, unit) {
    const [least, most] = PREFIXED[unit] ?? [0, 0];
    const power = magnitude > 0 && isFinite(magnitude) ? Math.floor(Math.log10(magnitude) / 3 + 1e-4) : 0;
    const exponent = Math.max(least, Math.min(most, power));
    return { factor: 1000 ** exponent, unit: unit === "1" ? "" : LETTERS[exponent + 3] + unit };
  }

  const minus = (text) => text.replace("-", "−");

  // A value with its unit: 0.000015 m is 15.0 µm.
  function quantity(value, unit, digits = 4) {
    if (value === null || value === undefined || !isFinite(value)) return "–";
    const { factor, unit: shown } = prefixed(Math.abs(value), unit);
    const scaled = value / factor;
    const magnitude = Math.abs(scaled);
    const decimals = magnitude === 0 ? 0 : Math.max(0, Math.min(6, digits - 1 - Math.floor(Math.log10(magnitude))));
    return minus(scaled.toFixed(decimals)) + (shown ? " " + shown : "");
  }

  function inks() {
    const style = getComputedStyle(document.documentElement);
    const of = (name) => style.getPropertyValue(name).trim();
    return {
      series: DASHES.map((_, i) => of("--s" + i)),
      grid: of("--grid"), axis: of("--axis"), pale: of("--measured"), accent: of("--accent"),
    };
  }

  // A range with a little air around it that holds still while the values wander inside it.
  function steady(range, low, high) {
    if (!(low <= high)) return range ?? [0, 1];
    const span = Math.max(high - low, 1e-9 * Math.max(Math.abs(low), Math.abs(high)), 1e-12);
    const roomy = range && low >= range[0] && high <= range[1] && span > 0.5 * (range[1] - range[0]);
    return roomy ? range : [low - 0.08 * span, high + 0.08 * span];
  }

  // Axes, zoom and cursor in `host`; what is between the axes is drawn by `paint(u)`. `hands`: what the reader's hands do —
  //   zoom(from, to, low, high): a stretch was dragged over; wheel(factor, at): the wheel was turned over `at`;
  //   reset(): double click; cursor(at, value): the cursor stands there, or null.
  // `logarithmic`: both coordinates are decimal logarithms, and shown as what they are of.
  function make(host, { width, height, unit, xUnit = "s", xPrefixed = false, xTitle, sync, both = false, logarithmic = false, hands, heading, paint }) {
    const ink = inks();
    let last = "";
    const prefix = (u, scale, of) => prefixed(Math.max(Math.abs(u.scales[scale].min), Math.abs(u.scales[scale].max)), of);
    const ticks = (factor, splits, step) => {
      // as many as the step has, so that every number shown is the one the line stands at: two for 0.25
      let decimals = 0;
      const off = (scaled) => Math.abs(scaled - Math.round(scaled)) > 1e-6 * scaled;
      while (decimals < 8 && off(step / factor * 10 ** decimals)) decimals++;
      return splits.map((v) => (v === null ? "" : minus((v / factor + 0).toFixed(decimals))));
    };
    const decades = (splits, of) => splits.map((v) => (v === null || Math.abs(v - Math.round(v)) > 1e-6 ? "" : quantity(10 ** v, of, 1)));
    const whole = logarithmic ? { incrs: [1] } : {};
    // zoomed in far, a time is shown as the seconds it has
    const across = (u) => (xPrefixed ? prefix(u, "x", xUnit) : { factor: 1, unit: xUnit });
    const axis = { stroke: ink.axis, font: FONT, ticks: { stroke: ink.axis, width: 1, size: 4 }, grid: { stroke: ink.grid, width: 1 } };
    const options = {
      width, height,
      padding: [8, 14, 0, 0],
      legend: { show: false },
      scales: { x: { time: false, auto: false }, y: { auto: false } },
      axes: [
        { ...axis, size: xTitle ? 30 : 28, space: 70, label: xTitle && ((u) => (across(u).unit && !logarithmic ? `${xTitle}, ${across(u).unit}` : xTitle)), stroke: ink.axis, labelSize: 18, labelFont: FONT, labelGap: 0,
          ...whole, values: (u, splits, i, space, step) => (logarithmic ? decades(splits, xUnit) : ticks(across(u).factor, splits, step)) },
        { ...axis, size: 58, space: 28, ...whole,
          values: (u, splits, i, space, step) => (logarithmic ? decades(splits, unit) : ticks(prefix(u, "y", unit).factor, splits, step)) },
      ],
      series: [{}],
      cursor: {
        sync: sync ? { key: sync, setSeries: false, scales: ["x", null] } : undefined,
        drag: { x: true, y: both, setScale: false, dist: 6, uni: both ? 20 : undefined },
        points: { show: false },
        bind: { dblclick: () => () => { hands.reset(); return null; } },
      },
      hooks: {
        setSelect: [(u) => {
          const { left, top, width, height } = u.select;
          if (width < 4 && height < 4) return;
          u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
          const whole = height >= u.over.clientHeight - 1;
          hands.zoom(u.posToVal(left, "x"), u.posToVal(left + width, "x"),
            whole ? null : u.posToVal(top + height, "y"), whole ? null : u.posToVal(top, "y"));
        }],
        setCursor: [(u) => {
          const inside = u.cursor.left >= 0 && u.cursor.left <= u.over.clientWidth;
          hands.cursor(inside ? u.posToVal(u.cursor.left, "x") : null, inside ? u.posToVal(u.cursor.top, "y") : null);
        }],
        draw: [(u) => {
          paint(u);
          const shown = logarithmic ? "" : prefix(u, "y", unit).unit;
          if (heading && shown !== last) heading(last = shown);
        }],
      },
    };
    const chart = new uPlot(options, [[0, 1]], host);
    chart.over.addEventListener("wheel", (event) => {
      event.preventDefault();
      const box = chart.over.getBoundingClientRect();
      hands.wheel(Math.exp(Math.max(-1, Math.min(1, event.deltaY / 300))), chart.posToVal(event.clientX - box.left, "x"),
        chart.posToVal(event.clientY - box.top, "y"));
    }, { passive: false });
    return chart;
  }

  // Shows this stretch and this range.
  function look(chart, from, to, low, high) {
    chart.batch(() => {
      chart.setScale("x", { min: from, max: to });
      chart.setScale("y", { min: low, max: high });
    });
  }

  // Curves over time as pixels. A canvas strokes a noisy curve slowly; here every column of pixels gets the stretch from
  // the least to the largest value in it, which is what a stroke of so many points amounts to, in a hundredth of the
  // time. Columns stand on a fixed grid of time: a curve that moves is shifted, and only what is new is painted.
  class Raster {
    constructor() { this.canvas = document.createElement("canvas"); this.key = ""; }

    // Brings the picture up to date. `view`: { width, height, from (s), column (s a column), low, high }; `curves`:
    // [{ time, low, high, begin, end, ink: [r, g, b], width, dash }] with bins begin..end; `key`: what they depend on besides.
    paint(view, curves, key) {
      const { width, height, column } = view, first = Math.round(view.from / column);
      const all = `${key} ${width} ${height} ${column} ${view.low} ${view.high}`;
      let clean = 0;
      if (this.canvas.width !== width || this.canvas.height !== height) {
        this.canvas.width = width; this.canvas.height = height;
        this.image = new ImageData(width, height);
        this.pixels = new Uint32Array(this.image.data.buffer);
        this.key = "";
      }
      const shift = first - this.first;
      if (this.key === all && shift >= 0 && shift < width) {
        if (shift) for (let row = 0; row < height; row++) this.pixels.copyWithin(row * width, row * width + shift, (row + 1) * width);
        // what was at the right end may not have been complete
        clean = Math.max(0, Math.min(width, this.until - first));
        for (let row = 0; row < height; row++) this.pixels.fill(0, row * width + clean, (row + 1) * width);
      } else this.pixels.fill(0);
      this.key = all;
      this.first = first;
      let newest = -Infinity;
      for (const curve of curves) {
        this.curve(view, curve, first, clean);
        if (curve.end > curve.begin) newest = Math.max(newest, curve.time[curve.end - 1]);
      }
      this.until = Math.floor(newest / column) - 1;
      this.canvas.getContext("2d").putImageData(this.image, 0, 0);
    }

    // Paints the columns from `clean` on.
    curve({ width, height, column, low, high }, { time, low: lows, high: highs, begin, end, ink, width: stroke, dash }, first, clean) {
      const up = height / (high - low), half = stroke / 2;
      // the bin before the first column that is painted, from which the curve comes into it
      let k = begin, to = end;
      const start = (first + clean) * column;
      while (k < to) { const middle = (k + to) >> 1; if (time[middle] < start) k = middle + 1; else to = middle; }
      k = Math.max(begin, k - 1);
      let at = NaN, y = NaN, top = Infinity, bottom = -Infinity, here = -1;
      const flush = () => { if (top <= bottom) this.span(here, clean, width, height, top - half, bottom + half, ink, dash, first); top = Infinity; bottom = -Infinity; };
      const meet = (value) => { if (value < top) top = value; if (value > bottom) bottom = value; };
      for (; k < end; k++) {
        const a = height - (highs[k] - low) * up, b = height - (lows[k] - low) * up;
        if (a !== a) { flush(); at = NaN; here = -1; continue; }
        const x = time[k] / column - first, next = Math.floor(x), middle = (a + b) / 2;
        if (at !== at) { here = next; }
        else if (next !== here) {
          // along the line from the bin before to this one, border by border
          const slope = (middle - y) / (x - at);
          let edge = here + 1;
          // what is left of the painted part is passed over at once
          if (edge < clean - 1) { flush(); edge = Math.min(next, clean - 1); here = edge - 1; }
          for (; edge <= next && here < width; edge++) {
            const value = y + slope * (edge - at);
            meet(value);
            flush();
            here = edge;
            meet(value);
          }
        }
        meet(a); meet(b);
        at = x; y = middle;
        if (here >= width) break;
      }
      flush();
    }

    // A column from `top` to `bottom`, with soft ends.
    span(x, clean, width, height, top, bottom, [r, g, b], dash, first) {
      if (x < clean || x >= width || bottom <= 0 || top >= height) return;
      if (dash && dash.length) {
        let place = ((first + x) % dash.period + dash.period) % dash.period, i = 0;
        while (place >= dash[i]) place -= dash[i++];
        if (i % 2) return;
      }
      const pixels = this.pixels, from = Math.max(0, Math.floor(top)), to = Math.min(height - 1, Math.ceil(bottom) - 1);
      const solid = 0xff000000 | b << 16 | g << 8 | r;
      for (let row = from; row <= to; row++) {
        const cover = Math.min(bottom, row + 1) - Math.max(top, row), i = row * width + x;
        if (cover > 0.99) { pixels[i] = solid; continue; }
        const under = pixels[i], alpha = under >>> 24;
        const share = cover + alpha / 255 * (1 - cover);
        const mix = (mine, shift) => Math.round((mine * cover + (under >>> shift & 255) * (alpha / 255) * (1 - cover)) / share);
        pixels[i] = Math.round(share * 255) << 24 | mix(b, 16) << 16 | mix(g, 8) << 8 | mix(r, 0);
      }
    }
  }

  // A colour of the style sheet as [red, green, blue].
  function rgb(colour) {
    const number = parseInt(colour.slice(1), 16);
    return [number >> 16 & 255, number >> 8 & 255, number & 255];
  }

  // An ink's dashes in columns.
  function dash(ink) {
    const dashes = DASHES[ink % DASHES.length].map((n) => Math.max(1, Math.round(1.6 * n * devicePixelRatio)));
    dashes.period = dashes.reduce((sum, n) => sum + n, 0);
    return dashes;
  }

  // A sample of a curve for a legend: an SVG line in its ink and dash; −1 is what was asked for, −2 plain.
  function sample(ink, dashed, width = 28) {
    const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    svg.setAttribute("viewBox", `0 0 ${width} 10`);
    svg.setAttribute("class", "sample");
    const line = document.createElementNS("http://www.w3.org/2000/svg", "line");
    for (const [key, value] of Object.entries({ x1: 0, x2: width, y1: 5, y2: 5, "stroke-width": 2.5 })) line.setAttribute(key, value);
    line.style.stroke = `var(${ink >= 0 ? "--s" + ink % DASHES.length : ink === -1 ? "--measured" : "--axis"})`;
    if (ink === -1) line.setAttribute("stroke-width", 4);
    if (dashed && ink >= 0 && DASHES[ink % DASHES.length].length) line.setAttribute("stroke-dasharray", DASHES[ink % DASHES.length].join(" "));
    svg.append(line);
    return svg;
  }

  return { make, look, Raster, sample, steady, quantity, prefixed, inks, rgb, dash, DASHES };
})();

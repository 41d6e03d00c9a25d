// The page of `sinew plot`: curves of recordings to zoom into.
"use strict";

const figure = JSON.parse(document.getElementById("data").textContent);
const ASKED = -1, PLAIN = -2;
const hidden = new Set();
let panels = [], time = null, whole = null;

// Points as they are packed: all of one coordinate, then all of the other.
function points(packed) {
  const bytes = Uint8Array.from(atob(packed), (letter) => letter.charCodeAt(0));
  const floats = new Float32Array(bytes.buffer), count = floats.length / 2;
  return { x: floats.subarray(0, count), y: floats.subarray(count) };
}

function extent(of) {
  let low = Infinity, high = -Infinity;
  for (const values of of) for (const v of values) { if (v < low) low = v; if (v > high) high = v; }
  return low <= high ? [low, high] : [0, 1];
}

for (const panel of figure.panels) {
  for (const curve of panel.curves) {
    Object.assign(curve, points(curve.points));
    delete curve.points;
  }
  panel.logarithmic = panel.kind === "lateness";
  if (panel.logarithmic) {
    for (const curve of panel.curves) { curve.x = curve.x.map((v) => Math.log10(v)); curve.y = curve.y.map((v) => Math.log10(v)); }
  }
}
const timely = figure.panels.filter((panel) => panel.kind === "time");
if (timely.length) time = whole = extent(timely.flatMap((panel) => panel.curves.map((curve) => curve.x)));

const shown = (panel) => panel.curves.filter((curve) => !hidden.has(curve.ink));

// The vertical range of what can be seen of a panel over time.
function visible(panel, [from, to]) {
  let low = Infinity, high = -Infinity;
  for (const { x, y } of shown(panel)) {
    for (let k = first(x, from); k < x.length && !(x[k] > to); k++) { if (y[k] < low) low = y[k]; if (y[k] > high) high = y[k]; }
  }
  return low <= high ? Chart.steady(null, low, high) : [0, 1];
}

// The first point not before `at`; a break in the curve (NaN) counts as the point behind it.
function first(x, at) {
  let low = 0, high = x.length;
  while (low < high) {
    let middle = (low + high) >> 1, real = middle;
    while (real < high && Number.isNaN(x[real])) real++;
    if (real < high && x[real] < at) low = real + 1; else high = middle;
  }
  return low;
}

function build() {
  for (const { chart } of panels) chart.destroy();
  const host = document.getElementById("panels"), colours = Chart.inks();
  const css = (ink) => (ink === ASKED ? colours.pale : ink === PLAIN ? colours.axis : colours.series[ink % colours.series.length]);
  host.replaceChildren();
  panels = figure.panels.map((panel) => {
    const section = document.createElement("section"), title = document.createElement("h2"), unit = document.createElement("span");
    section.className = panel.kind === "time" ? "panel wide" : "panel";
    title.append(panel.caption + " ", unit);
    section.append(title);
    host.append(section);
    const over = panel.kind === "time", ratio = devicePixelRatio, raster = over ? new Chart.Raster() : null;
    const home = () => (over ? null : { x: pad(extent(shown(panel).map((c) => c.x)), panel), y: pad(extent(shown(panel).map((c) => c.y)), panel) });
    const state = { panel, raster, range: home() };
    const hands = {
      zoom: (from, to, low, high) => {
        if (over) { if (to - from > 1e-6) time = [from, to]; }
        else state.range = { x: to - from > 1e-12 ? [from, to] : state.range.x, y: low === null ? state.range.y : [low, high] };
        draw();
      },
      wheel: (factor, x, y) => {
        const scaled = ([from, to], at) => [at - (at - from) * factor, at + (to - at) * factor];
        if (over) {
          const wide = scaled(time, x);
          time = wide[1] - wide[0] > whole[1] - whole[0] ? whole : wide;
        } else state.range = { x: scaled(state.range.x, x), y: scaled(state.range.y, y) };
        draw();
      },
      reset: () => { if (over) time = whole; else state.range = home(); draw(); },
      cursor: (x, y) => {
        const at = (value, unit) => (panel.logarithmic ? Chart.quantity(10 ** value, unit, 3) : Chart.quantity(value, unit, 4));
        document.getElementById("cursor").textContent = x === null ? ""
          : over ? `Cursor at ${x.toFixed(4)} s, ${at(y, panel.y_unit)}` : `Cursor at ${at(x, panel.x_unit)}, ${at(y, panel.y_unit)}`;
      },
    };
    state.chart = Chart.make(section, {
      width: section.clientWidth, height: over ? (panel === timely.at(-1) ? 228 : 210) : 380, unit: panel.y_unit, xUnit: panel.x_unit, xPrefixed: !over, hands,
      logarithmic: panel.logarithmic, both: !over, sync: over ? "time" : undefined,
      xTitle: over && panel !== timely.at(-1) ? undefined : panel.x_title, heading: (text) => { unit.textContent = text; },
      paint: (u) => {
        if (over) { u.ctx.drawImage(raster.canvas, u.bbox.left, u.bbox.top); return; }
        const { ctx, bbox } = u;
        ctx.save();
        ctx.beginPath();
        ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
        ctx.clip();
        ctx.lineJoin = "round";
        for (const curve of shown(panel)) {
          ctx.strokeStyle = css(curve.ink);
          ctx.lineWidth = (curve.ink === ASKED ? 3 : 1.4) * ratio;
          ctx.setLineDash(curve.ink >= 0 ? Chart.DASHES[curve.ink % Chart.DASHES.length].map((n) => n * ratio) : []);
          ctx.beginPath();
          let down = false;
          for (let k = 0; k < curve.x.length; k++) {
            const x = u.valToPos(curve.x[k], "x", true), y = u.valToPos(curve.y[k], "y", true);
            if (!(isFinite(x) && isFinite(y))) { down = false; continue; }
            if (down) ctx.lineTo(x, y); else ctx.moveTo(x, y);
            down = true;
          }
          ctx.stroke();
        }
        ctx.restore();
      },
    });
    state.curves = (() => panel.curves.map((curve) => ({
      curve, time: curve.x, low: curve.y, high: curve.y, begin: 0, end: curve.x.length,
      ink: Chart.rgb(css(curve.ink)), width: (curve.ink === ASKED ? 3 : 1.5) * ratio,
      dash: curve.ink >= 0 ? Chart.dash(curve.ink) : null,
    })))();
    return state;
  });
  draw();
}

function pad([low, high], panel) {
  const span = high - low || 1;
  return panel.logarithmic ? [low, high] : [low - 0.05 * span, high + 0.05 * span];
}

function draw() {
  for (const { panel, chart, raster, range, curves } of panels) {
    if (!raster) { Chart.look(chart, ...range.x, ...range.y); continue; }
    const { width, height } = chart.bbox, column = (time[1] - time[0]) / width;
    const [low, high] = visible(panel, time), from = Math.floor(time[0] / column) * column;
    raster.paint({ width, height, column, from, low, high }, curves.filter(({ curve }) => !hidden.has(curve.ink)), [...hidden].join());
    Chart.look(chart, from, from + width * column, low, high);
  }
}

for (const { name, ink } of figure.legend) {
  const button = document.createElement("button");
  button.type = "button";
  button.setAttribute("aria-pressed", "true");
  button.append(Chart.sample(ink, true), name);
  button.onclick = () => {
    if (!hidden.delete(ink)) hidden.add(ink);
    button.setAttribute("aria-pressed", String(!hidden.has(ink)));
    draw();
  };
  document.getElementById("legend").append(button);
}
let built = 0;
new ResizeObserver(() => { const width = document.getElementById("panels").clientWidth; if (width !== built) { built = width; build(); } })
  .observe(document.getElementById("panels"));
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", build);

// Draws the sheets of board.net as pictures of docs/board.md:
//
//   npm install netlistsvg && node firmware/rp2040/board/draw.mjs docs/pictures
//
// netlistsvg (MIT) places parts and wires; its symbols are its own but for the two MOSFETs, contacts and fuses below.
import fs from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";

const [folder] = process.argv.slice(2);
if (!folder) {
  console.error("usage: node draw.mjs FOLDER");
  process.exit(2);
}
// from where it was installed, which need not be here
const require = createRequire(path.join(process.cwd(), "package.json"));
const netlistsvg = require("netlistsvg");
const here = path.dirname(new URL(import.meta.url).pathname);

// A symbol: its type, size, lines, and pins as [name, x, y, side].
const symbol = (type, width, height, lines, pins, at) => `<g s:type="${type}" s:width="${width}" s:height="${height}">
  <s:alias val="${type}"/>
  ${lines.map((d) => `<path d="${d}" class="symbol $cell_id"/>`).join("")}
  <text x="${at[0]}" y="${at[1]}" class="$cell_id" s:attribute="ref">Q</text>
  <text x="${at[0]}" y="${at[1] + 12}" class="$cell_id" s:attribute="value">x</text>
  ${pins.map(([name, x, y, side]) => `<g s:x="${x}" s:y="${y}" s:pid="${name}" s:position="${side}"/>`).join("")}
</g>`;
const channel = "M0,20 H9 M9,8 V32 M14,6 V14 M14,16 V24 M14,26 V34";
const SYMBOLS = [
  // S above where the current comes in; the arrow of a P-channel points out of the channel
  symbol("pmos", 32, 40, [channel, "M14,10 H24 V0 M14,30 H24 V40 M14,20 H24 V10", "M20,17 L24,20 L20,23"], [["G", 0, 20, "left"], ["S", 24, 0, "top"], ["D", 24, 40, "bottom"]], [30, 18]),
  symbol("nmos", 32, 40, [channel, "M14,10 H24 V0 M14,30 H24 V40 M14,20 H24 V30", "M18,17 L14,20 L18,23"], [["G", 0, 20, "left"], ["D", 24, 0, "top"], ["S", 24, 40, "bottom"]], [30, 18]),
  symbol("fuse", 10, 40, ["M5,0 V40", "M0,8 H10 V32 H0 Z"], [["1", 5, 0, "top"], ["2", 5, 40, "bottom"]], [16, 18]),
  symbol("nc", 12, 40, ["M5,0 V10 M5,30 V40", "M5,30 L10,8 M5,10 H12"], [["1", 5, 0, "top"], ["2", 5, 40, "bottom"]], [18, 18]),
  symbol("no", 14, 40, ["M5,0 V12 M5,30 V40", "M5,30 L14,12"], [["1", 5, 0, "top"], ["2", 5, 40, "bottom"]], [18, 18]),
  symbol("ferrite", 10, 40, ["M5,0 V8 M5,32 V40", "M0,8 H10 V32 H0 Z M0,14 L10,8 M0,20 L10,14 M0,26 L10,20 M0,32 L10,26"], [["1", 5, 0, "top"], ["2", 5, 40, "bottom"]], [16, 18]),
];
const STYLE = "svg { background: #fff; } text { font-weight: normal; font-family: sans-serif; }";
const skin = fs.readFileSync(require.resolve("netlistsvg/lib/analog.svg"), "utf8")
  .replace("</style>", `${STYLE}</style>`)
  .replace("</svg>", `${SYMBOLS.join("\n")}</svg>`);

// Upright two-pin parts of netlistsvg's own.
const OWN = { r: "r_v", c: "c_v" };
// The pins above or left of a part; those of a box left of it.
const INPUTS = { pmos: /^[SG]$/, nmos: /^[DG]$/, wire: /^(moving|tap\d)$/, pico: /^$/, ad7616: /^(?!BUSY|SDOA|V\d)/ };
const FIRST = /^[1+]$/;

function sheets(text) {
  const found = [];
  for (const line of text.split("\n").map((line) => line.trim()).filter((line) => line && !line.startsWith("#"))) {
    const [first, second, ...rest] = line.split(/\s+/);
    if (first === "sheet") { found.push({ name: second, parts: [] }); continue; }
    const [value, ...pins] = rest;
    found.at(-1).parts.push({ ref: plain(first), part: second, value, pins: pins.map((pin) => pin.split("=").map(plain)) });
  }
  return found;
}

// {k} as it is read: F{k} is Fk, B{2k+1} is B(2k+1).
function plain(text) {
  return text.replace(/\{(\w)\}/, "$1").replace(/\{(.*?)\}/, "($1)");
}

// A sheet as netlistsvg takes it; what is on others too, `elsewhere`, goes to a port.
function module({ parts }, elsewhere) {
  const nets = new Map(), cells = {}, ports = {};
  const number = (net) => nets.get(net) ?? nets.set(net, nets.size + 2).get(net);
  const count = new Map();
  for (const { pins } of parts) for (const [, net] of pins) count.set(net, (count.get(net) ?? 0) + 1);
  let grounds = 0;
  for (const { ref, part, value, pins } of parts) {
    const type = OWN[part] ?? part;
    const connections = {}, port_directions = {};
    for (const [pin, net] of pins) {
      const name = OWN[part] ? (pin === "1" ? "A" : "B") : pin;
      port_directions[name] = (INPUTS[part] ?? FIRST).test(pin) ? "input" : "output";
      if (net === "gnd") {
        // each to a symbol of its own, as one draws it
        const own = number(`gnd ${grounds}`);
        cells[`gnd${grounds++}`] = { type: "gnd", port_directions: { A: "input" }, connections: { A: [own] }, attributes: { name: "" } };
        connections[name] = [own];
      } else connections[name] = [number(net)];
    }
    cells[ref] = { type, port_directions, connections, attributes: { value, ref } };
  }
  for (const [net, times] of count) {
    if (net !== "gnd" && (times === 1 || elsewhere(net))) {
      ports[net] = { direction: /^GP/.test(net) ? "input" : "output", bits: [number(net)] };
    }
  }
  return { modules: { board: { ports, cells } } };
}

const all = sheets(fs.readFileSync(path.join(here, "board.net"), "utf8"));
const isOn = (sheet, net) => sheet.parts.some(({ pins }) => pins.some(([, other]) => other === net));
for (const sheet of all) {
  // one wire's GP(k+2) is one of the Pico's
  const elsewhere = (net) => /^GP\(/.test(net) || all.some((other) => other !== sheet && isOn(other, net));
  const file = path.join(folder, `board-${sheet.name}.svg`);
  const svg = await netlistsvg.render(skin, module(sheet, elsewhere));
  // it does not count the words beside the last part
  fs.writeFileSync(file, svg.replace(/width="([\d.]+)"/, (_, width) => `width="${Number(width) + 40}"`));
  console.log(file);
}

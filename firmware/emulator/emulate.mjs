// node emulate.mjs FIRMWARE.elf LINK: the firmware on an emulated board, its serial line as a pseudo-terminal LINK. Orders by stdin, a line
// each, are below; what the outputs do is told by stdout, a line of JSON a second and one a change.

import { spawn } from 'node:child_process';
import { createInterface } from 'node:readline';
import { Board, firmwareOf } from './board.mjs';

const SLICE_MS = 10;
const MOST_BEHIND_MS = 50;

const [elf, link] = process.argv.slice(2);
if (link === undefined) {
  console.error('usage: node emulate.mjs FIRMWARE.elf LINK');
  process.exit(2);
}

const tell = (what) => console.log(JSON.stringify({ ms: Math.round(board.machine.clock.nanos / 1e6), ...what }));
const line = spawn('python3', [new URL('line.py', import.meta.url).pathname, link], { stdio: ['pipe', 'pipe', 'inherit'] });
line.on('error', (error) => fail(`python3 with its module pty is needed for the pseudo-terminal: ${error.message}`));
line.on('exit', (code) => fail(`the pseudo-terminal has ended (${code})`));
line.stdout.on('data', (bytes) => board.machine.send(bytes));

const firmware = await firmwareOf(elf).catch((error) => fail(error.message, 2));
const { enable } = firmware.kind;
let board = start(0, 0);

/** A board from its reset. */
function start(reason, startNs, inputs) {
  const send = (bytes) => line.stdin.write(bytes);
  const board = new Board(firmware, send, { reason, startNs, onReset: (why) => (resets = why) }, inputs);
  board.machine.cdc.onDeviceConnected = () => tell({ event: 'line' });
  board.machine.pin(enable).addListener(() => tell({ event: 'enable', on: board.machine.isHigh(enable) }));
  return board;
}

let resets = null;
let epoch = performance.now();
let told = 0;

function turn() {
  const { machine, wires, converter } = board;
  const begun = performance.now();
  const behind = begun - epoch - machine.clock.nanos / 1e6;
  if (behind > MOST_BEHIND_MS) epoch += behind - MOST_BEHIND_MS;
  machine.run((begun - epoch) * 1e6, begun + SLICE_MS);
  if (resets !== null) {
    tell({ event: 'reset', by: resets === 1 ? 'watchdog' : 'software' });
    machine.end();
    board = start(resets, machine.clock.nanos, board.inputs);
    resets = null;
  }
  const second = Math.floor(machine.clock.nanos / 1e9);
  if (second > told) {
    told = second;
    wires.heat(machine.clock.nanos);
    tell({
      pulses: wires.wires.map((wire) => wire.pulses),
      on_us: wires.wires.map((wire) => (wire.pulses > 0 ? Math.round(wire.onNs / wire.pulses / 10) / 100 : 0)),
      celsius: wires.wires.map((wire) => Math.round(wire.celsius)),
      length_mm: wires.wires.map((wire) => Math.round(wires.ofWire(wire).length * 1e6) / 1e3),
      sweeps: converter.sweeps,
      busy_us: Math.round(machine.busyNs / 1000),
      behind_ms: Math.round(behind),
    });
    for (const wire of wires.wires) [wire.pulses, wire.onNs] = [0, 0];
    [converter.sweeps, machine.busyNs] = [0, 0];
  }
  setTimeout(turn, machine.clock.nanos / 1e6 < performance.now() - epoch - 1 ? 0 : 1);
}

const ORDERS = {
  /** Presses the emergency stop, and lets go of it; its reset button. */
  'estop open': () => board.stop(true),
  'estop closed': () => board.stop(false),
  'reset press': () => board.reset(true),
  'reset release': () => board.reset(false),
  /** The processor stands still: what is on has to go off by itself, and the watchdog to reset. */
  hang: () => (board.machine.hangs = true),
  /** The converter is not there. */
  'adc gone': () => (board.converter.isThere = false),
  'adc back': () => (board.converter.isThere = true),
  /** The first wire's stage conducts by itself, or its wire is open. */
  'stage stuck': () => change((wire) => (wire.isStuck = true)),
  'stage whole': () => change((wire) => (wire.isStuck = false)),
  'wire open': () => change((wire) => (wire.isOpen = true)),
  'wire whole': () => change((wire) => (wire.isOpen = false)),
  quit: () => fail('', 0),
};

function change(how) {
  how(board.wires.wires[0]);
  board.wires.switch(board.wires.wires[0]);
}

createInterface({ input: process.stdin }).on('line', (order) => {
  const obey = ORDERS[order.trim()];
  if (obey) obey();
  else console.error(`no order ${JSON.stringify(order)}; there are: ${Object.keys(ORDERS).join(', ')}`);
});

function fail(why, code = 1) {
  if (why !== '') console.error(why);
  line.removeAllListeners('exit');
  line.kill();
  process.exit(code);
}

turn();

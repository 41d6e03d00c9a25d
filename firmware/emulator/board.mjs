// The whole board: the microcontroller with its firmware, the converter, four wires, and the switches somebody presses.

import { Converter } from './converter.mjs';
import { flashOf } from './elf.mjs';
import { Wires } from './wires.mjs';

/** Boards by the firmware's name: where its flash is, which pin is what, and how long a byte of the line and a word of the converter's take. */
const KINDS = [
  {
    name: 'sinew-rp2040',
    serial: 'e661000000000001',
    machine: './rp2040.mjs',
    flash: 0x10000000,
    gates: [2, 3, 4, 5],
    enable: 6,
    stop: [7],
    stopReset: 8,
    byteNs: 0, // USB has no frames here
    converter: { convst: 10, busy: 11, reset: 12, wordNs: 1088 }, // 17 clocks of 15.6 MHz
  },
  {
    name: 'sinew-stm32g4',
    serial: '38102077767c683f',
    machine: './stm32g4.mjs',
    flash: 0x08000000,
    // Port × 16 + number.
    gates: [32, 33, 34, 35],
    enable: 38,
    stop: [26, 23],
    stopReset: 36,
    byteNs: 5000, // 2 Mbaud
    converter: { convst: 27, busy: 17, reset: 18, wordNs: 1200 }, // 18 clocks of 15 MHz
    /** Its timers' break inputs: the emergency stop needs no processor. */
    breaks: true,
  },
];

/** The firmware of an ELF file, and the board it is of. */
export async function firmwareOf(path) {
  const parts = flashOf(path);
  const kind = KINDS.find(({ flash }) => parts.some(({ address }) => address === flash));
  if (kind === undefined) throw new Error(`${path} is of none of the boards: ${KINDS.map(({ name }) => name).join(', ')}`);
  const { Machine } = await import(kind.machine);
  return { parts, kind, Machine };
}

export class Board {
  /** `send(bytes)` is given what the firmware sends; `options` are the machine's. */
  constructor({ parts, kind, Machine }, send, options, inputs = { stop: false, reset: true }) {
    this.kind = kind;
    this.machine = new Machine(parts, options);
    this.wires = new Wires(this.machine, kind);
    this.converter = new Converter(this.machine, kind.converter, (side, number, now) => this.wires.input(side, number, now));
    this.machine.supply = Math.round((this.wires.supplyV / 4 / 3.3) * 4095);
    this.machine.cdc.onSerialData = send;
    this.inputs = inputs;
    this.stop(inputs.stop);
    this.reset(!inputs.reset);
  }

  /** Opens the emergency stop, or closes it: low is closed. */
  stop(open) {
    this.inputs.stop = open;
    for (const pin of this.kind.stop) this.machine.pin(pin).setInputValue(open);
  }

  /** Its reset button: low is pressed. */
  reset(pressed) {
    this.inputs.reset = !pressed;
    this.machine.pin(this.kind.stopReset).setInputValue(!pressed);
  }
}

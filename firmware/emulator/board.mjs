// The whole board: the RP2040 with its firmware, the converter, four wires, and the switches somebody presses.

import { Converter } from './converter.mjs';
import { Machine } from './machine.mjs';
import { Wires } from './wires.mjs';

export const ENABLE = 6;
const [STOP, STOP_RESET, SUPPLY_CHANNEL] = [7, 8, 0];

export class Board {
  /** `send(bytes)` is given what the firmware sends; `options` are the machine's. */
  constructor(parts, send, options, inputs = { stop: false, reset: true }) {
    this.machine = new Machine(parts, options);
    this.wires = new Wires(this.machine);
    this.converter = new Converter(this.machine, (side, number, now) => this.wires.input(side, number, now));
    this.machine.chip.adc.channelValues[SUPPLY_CHANNEL] = Math.round((this.wires.supplyV / 4 / 3.3) * 4095);
    this.machine.cdc.onSerialData = send;
    this.inputs = inputs;
    // Low: the contact closed, the button pressed.
    this.machine.pin(STOP).setInputValue(inputs.stop);
    this.machine.pin(STOP_RESET).setInputValue(inputs.reset);
  }

  /** Opens the emergency stop, or closes it. */
  stop(open) {
    this.inputs.stop = open;
    this.machine.pin(STOP).setInputValue(open);
  }

  /** Its reset button. */
  reset(pressed) {
    this.inputs.reset = !pressed;
    this.machine.pin(STOP_RESET).setInputValue(!pressed);
  }
}

// The RP2040: rp2040js with what it lacks here. Its PIO runs beside the processor at whatever speed Node has; here both count the same
// cycles, so that a pulse is as long as the firmware made it. Times are ns of the emulated clock.

import { BasePeripheral, GPIOPinState, RP2040, USBCDC } from 'rp2040js';

const CYCLE_NS = 8;
const FLASH = 0x10000000;
const VECTORS = 0x10000100;
const SSI = 0x18000;
const DATA = 0x60;
const UNIQUE_ID = 0x4b;
const EP0_OUT = 0x84;
const AVAILABLE = 1 << 10;
const XIP = 0x14000;
const CHIP_RESET = 0x40064;
const POWER_ON = 1 << 8;
const SUPPLY_CHANNEL = 0;

/** A peripheral of which only some registers are read. */
class Registers extends BasePeripheral {
  constructor(chip, name, values) {
    super(chip, name);
    this.values = values;
  }
  readUint32(offset) {
    return this.values[offset] ?? 0;
  }
  writeUint32() {}
}

export class Machine {
  /** `reason`: the watchdog's register of reset causes; `id`: the flash's unique number, 8 bytes. */
  constructor(parts, { reason = 0, id = [0xe6, 0x61, 0, 0, 0, 0, 0, 1], startNs = 0, onReset }) {
    this.chip = new RP2040();
    this.clock = this.chip.clock;
    this.clock.nanosCounter = startNs;
    this.chip.logger = { debug() {}, info() {}, warn() {}, error: (name, text) => console.error(`rp2040js: ${name}: ${text}`) };
    for (const { address, bytes } of parts) this.chip.flash.set(bytes, address - FLASH);
    this.chip.peripherals[XIP] = new Registers(this.chip, 'XIP_CTRL', {});
    this.chip.peripherals[CHIP_RESET] = new Registers(this.chip, 'CHIP_RESET', { 8: POWER_ON });
    this.rom();
    this.flashChip(id);
    for (const pio of this.chip.pio) pio.run = () => {};
    const watchdog = this.chip.peripherals[0x40058];
    watchdog.reason = reason;
    watchdog.onWatchdogTrigger = () => {
      // Once: its timer stands at zero from here on.
      watchdog.alarm.enable = false;
      onReset(watchdog.reason);
    };
    this.chip.core.VTOR = VECTORS;
    this.chip.core.reset();
    this.hangs = false;
    /** For how long the processor worked, ns. */
    this.busyNs = 0;
    this.usb();
  }

  /** The boot ROM is not free to be shipped: this one finds the few functions by which the flash's number is read, which do nothing but for
   *  memcpy44. */
  rom() {
    const halves = new Uint16Array(8 * 1024);
    const put = (at, words) => words.forEach((word, index) => (halves[at / 2 + index] = word));
    put(0x14, [0x40, 0x40, 0x41]);
    put(0x40, [0x4a03, 0x4291, 0xd001, 0x2081, 0x4770, 0x2091, 0x4770, 0, 0x3443, 0]); // 'C4' ? 0x91 : 0x81
    put(0x80, [0x4770]);
    put(0x90, [0x3a04, 0x588b, 0x5083, 0xd1fb, 0x4770]);
    this.chip.bootrom.set(new Uint32Array(halves.buffer));
  }

  flashChip(id) {
    const ssi = this.chip.peripherals[SSI];
    const [read, write] = [ssi.readUint32.bind(ssi), ssi.writeUint32.bind(ssi)];
    let answer = [];
    ssi.readUint32 = (offset) => (offset === DATA && answer.length > 0 ? answer.shift() : read(offset));
    ssi.writeUint32 = (offset, value) => {
      if (offset === DATA && (value & 0xff) === UNIQUE_ID) answer = [0, 0, 0, 0, ...id];
      else write(offset, value);
    };
  }

  usb() {
    const { usbCtrl } = this.chip;
    const cdc = new USBCDC(usbCtrl);
    const waiting = [];
    let asked = null;
    const give = () => {
      if (asked === null || waiting.length === 0) return;
      const bytes = Uint8Array.from(waiting.splice(0, Math.min(asked, waiting.length)));
      asked = null;
      usbCtrl.endpointReadDone(cdc.outEndpoint, bytes);
    };
    // A buffer that the firmware has made available stays so until a packet has come; rp2040js takes it back at once, and its own CDC fills it
    // with an empty packet where there is nothing.
    const buffer = () => EP0_OUT + 8 * cdc.outEndpoint;
    usbCtrl.onEndpointRead = (endpoint, size) => {
      if (endpoint !== cdc.outEndpoint) return;
      const dpram = this.chip.usbDPRAMView;
      dpram.setUint32(buffer(), dpram.getUint32(buffer(), true) | AVAILABLE, true);
      asked = size;
      give();
    };
    const finish = usbCtrl.finishRead.bind(usbCtrl);
    usbCtrl.finishRead = (endpoint, bytes) => {
      finish(endpoint, bytes);
      if (endpoint !== cdc.outEndpoint) return;
      const dpram = this.chip.usbDPRAMView;
      dpram.setUint32(buffer(), dpram.getUint32(buffer(), true) & ~AVAILABLE, true);
    };
    this.send = (bytes) => {
      waiting.push(...bytes);
      give();
    };
    this.cdc = cdc;
  }

  /** The code of its own converter for the supply. */
  set supply(code) {
    this.chip.adc.channelValues[SUPPLY_CHANNEL] = code;
  }

  pin(number) {
    return this.chip.gpio[number];
  }

  /** Whether a pin is driven high. */
  isHigh(number) {
    return this.pin(number).value === GPIOPinState.High;
  }

  /** Runs until a time, or until `deadline` of the host's clock, ms. */
  run(untilNs, deadline) {
    const { core } = this.chip;
    for (let step = 0; this.clock.nanos < untilNs; step++) {
      if ((step & 0xfff) === 0 && performance.now() > deadline) return;
      let cycles;
      if (core.waiting || this.hangs) {
        const left = Math.ceil((untilNs - this.clock.nanos) / CYCLE_NS);
        const alarm = this.clock.nextAlarm ? Math.ceil(this.clock.nanosToNextAlarm / CYCLE_NS) : Infinity;
        cycles = Math.max(1, Math.min(left, alarm, this.pioIdle()));
        if (!this.hangs && core.checkForInterrupts()) core.waiting = false;
      } else {
        cycles = core.executeInstruction();
        this.busyNs += cycles * CYCLE_NS;
      }
      for (const pio of this.chip.pio) this.pioRun(pio, cycles);
      this.clock.tick(cycles * CYCLE_NS);
      if (core.eventRegistered && core.waiting) [core.eventRegistered, core.waiting] = [false, false];
    }
  }

  end() {}

  /** Cycles in which no state machine does anything but count. */
  pioIdle() {
    let idle = Infinity;
    for (const pio of this.chip.pio) {
      for (const machine of pio.machines) {
        if (!machine.enabled || machine.waiting) continue;
        idle = Math.min(idle, counts(pio, machine) ? Math.max(1, machine.x) : 1);
      }
    }
    return idle;
  }

  pioRun(pio, cycles) {
    for (const machine of pio.machines) {
      if (!machine.enabled) continue;
      let left = cycles + (machine.owed ?? 0);
      while (left > 0) {
        if (machine.waiting) {
          machine.checkWait();
          if (machine.waiting) {
            left = 0;
            break;
          }
        }
        if (counts(pio, machine) && machine.x > 0) {
          const passed = Math.min(left, machine.x);
          machine.x -= passed;
          left -= passed;
          continue;
        }
        const instruction = pio.instructions[machine.pc];
        machine.step();
        // Side-set is not used: the field is all delay.
        left -= 1 + (machine.waiting ? 0 : (instruction >> 8) & 0x1f);
      }
      machine.owed = left;
      pio.checkChangedPins();
    }
  }
}

/** Whether a state machine is at `jmp x-- itself`. */
function counts(pio, machine) {
  return pio.instructions[machine.pc] === (0x0040 | machine.pc);
}

// The STM32G474: a Cortex-M4 in a process of its own (cortex.py), and here its peripherals, by the registers of the reference manual (RM0440) as far
// as the firmware uses them. An instruction counts as a cycle; times are ns of the emulated clock.

import { execFileSync, spawn, spawnSync } from 'node:child_process';
import { closeSync, existsSync, mkdtempSync, openSync, readSync, rmSync, writeSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

const CYCLE_NS = 1000 / 120;
const [FLASH, FLASH_BYTES] = [0x08000000, 512 * 1024];
const [RAM, RAM_BYTES] = [0x20000000, 128 * 1024];
const [SYSTEM, UNIQUE_ID] = [0x1fff7000, 0x590];
const LONGEST = 100_000;
/** While an interrupt waits for a critical section to be over. */
const MASKED = 16;
const [COUNT_OVER, WFE, RETURNED, FAULT] = [0, 1, 2, 3];
const IRQ = { EXTI1: 7, TIM1_BREAK: 24, TIM3: 29, LPUART1: 91 };

const bit = (value, number) => ((value >>> number) & 1) === 1;
const field = (value, at, bits) => (value >>> at) & (2 ** bits - 1);

/** Time in cycles, and who is to be called when. */
class Clock {
  cycles = 0;
  alarms = [];
  get nanos() {
    return this.cycles * CYCLE_NS;
  }
  createAlarm(call) {
    const alarm = { call, at: Infinity };
    this.alarms.push(alarm);
    alarm.schedule = (ns) => (alarm.at = this.cycles + Math.max(1, Math.round(ns / CYCLE_NS)));
    alarm.cancel = () => (alarm.at = Infinity);
    return alarm;
  }
  get next() {
    return this.alarms.reduce((next, { at }) => Math.min(next, at), Infinity);
  }
  advance(to) {
    for (;;) {
      const due = this.alarms.reduce((first, alarm) => (alarm.at < first.at ? alarm : first));
      if (due.at > to) break;
      this.cycles = Math.max(this.cycles, due.at);
      due.at = Infinity;
      due.call();
    }
    this.cycles = Math.max(this.cycles, to);
  }
}

/** The processor's other end, by two pipes that are waited at. */
class Cortex {
  static python = process.env.SINEW_EMULATOR_PYTHON ?? [new URL('venv/bin/python', import.meta.url).pathname].find(existsSync) ?? 'python3';
  static isThere = false;

  constructor() {
    if (!Cortex.isThere) {
      const { status } = spawnSync(Cortex.python, ['-c', 'import unicorn']);
      if (status !== 0) throw new Error(`${Cortex.python} has no unicorn: python3 -m venv venv && venv/bin/pip install -r requirements.txt`);
      Cortex.isThere = true;
    }
    this.folder = mkdtempSync(join(tmpdir(), 'sinew-cortex-'));
    const [down, up] = ['down', 'up'].map((name) => join(this.folder, name));
    execFileSync('mkfifo', [down, up]);
    this.child = spawn(Cortex.python, [new URL('cortex.py', import.meta.url).pathname, down, up], { stdio: ['ignore', 'inherit', 'inherit'] });
    this.child.unref();
    [this.down, this.up] = [openSync(down, 'w'), openSync(up, 'r')];
    this.buffer = Buffer.alloc(16);
    rmSync(this.folder, { recursive: true });
  }
  order(letter, one = 0, two = 0) {
    const order = Buffer.alloc(9);
    order.write(letter, 'latin1');
    order.writeUInt32LE(one >>> 0, 1);
    order.writeUInt32LE(two >>> 0, 5);
    writeSync(this.down, order);
  }
  memory(address, bytes) {
    this.order('M', address, bytes.length);
    for (let at = 0; at < bytes.length; ) at += writeSync(this.down, bytes, at);
  }
  answer(word) {
    const answer = Buffer.alloc(4);
    answer.writeUInt32LE(word >>> 0);
    writeSync(this.down, answer);
  }
  hear() {
    for (let at = 0; at < 16; ) {
      const count = readSync(this.up, this.buffer, at, 16 - at);
      if (count === 0) throw new Error('the processor is gone');
      at += count;
    }
    return [0, 4, 8, 12].map((at) => this.buffer.readUInt32LE(at));
  }
  end() {
    closeSync(this.down);
    closeSync(this.up);
  }
}

/** Interrupts: levels of lines, priorities, what is active. */
class Nvic {
  level = new Map();
  pending = new Set();
  enabled = new Set();
  priority = new Uint8Array(240);
  active = [];

  line(number, level) {
    if (level && !this.level.get(number)) this.pending.add(number);
    this.level.set(number, level);
  }
  /** The one that is to be taken now. */
  get due() {
    let due = null;
    for (const number of this.pending) {
      if (this.enabled.has(number) && (due === null || this.priority[number] < this.priority[due])) due = number;
    }
    const above = this.active.length === 0 ? 256 : this.priority[this.active.at(-1)];
    return due !== null && this.priority[due] < above ? due : null;
  }
  enter(number) {
    this.pending.delete(number);
    this.active.push(number);
  }
  leave() {
    const number = this.active.pop();
    if (this.level.get(number)) this.pending.add(number);
  }
  read(offset) {
    const first = ((offset & 0x7f) / 4) * 32;
    const bits = (set) => Array.from({ length: 32 }, (_, index) => (set.has(first + index) ? 2 ** index : 0)).reduce((sum, one) => sum + one);
    if (offset >= 0x100 && offset < 0x200) return bits(this.enabled);
    if (offset >= 0x200 && offset < 0x300) return bits(this.pending);
    if (offset >= 0x400 && offset < 0x4f0) return this.priority[offset - 0x400];
    return 0;
  }
  write(offset, value, vtor) {
    const first = ((offset & 0x7f) / 4) * 32;
    const all = (call) => [...Array(32).keys()].filter((index) => bit(value, index)).forEach((index) => call(first + index));
    if (offset >= 0x100 && offset < 0x180) all((number) => this.enabled.add(number));
    else if (offset >= 0x180 && offset < 0x200) all((number) => this.enabled.delete(number));
    else if (offset >= 0x200 && offset < 0x280) all((number) => this.pending.add(number));
    else if (offset >= 0x280 && offset < 0x300) all((number) => this.pending.delete(number));
    else if (offset >= 0x400 && offset < 0x4f0) this.priority[offset - 0x400] = value;
    else if (offset === 0xd08) vtor(value);
  }
}

/** A peripheral that only remembers, but for what it is told to. */
class Registers {
  values = new Map();
  constructor(rules = {}) {
    this.rules = rules;
  }
  read(offset) {
    const value = this.values.get(offset) ?? 0;
    return this.rules.read?.(offset, value, this.values) ?? value;
  }
  write(offset, value) {
    this.values.set(offset, this.rules.write?.(offset, value, this.values) ?? value);
  }
}

const [CR1, CR2, DIER, SR, EGR, CCMR1, CCMR2, CCER, CNT, PSC, ARR, CCR1, CCR4, BDTR] = [
  0x00, 0x04, 0x0c, 0x10, 0x14, 0x18, 0x1c, 0x20, 0x24, 0x28, 0x2c, 0x34, 0x40, 0x44,
];
const MOE = 15;
const BIF = 1 << 7;

/** A timer that counts up: compare values with and without preload, one pulse, outputs with break and lock. */
class Timer {
  constructor(machine, { top = 0xffff, isAdvanced = false, line = null, breakLine = null }) {
    Object.assign(this, { machine, top, isAdvanced, line, breakLine, values: new Map([[ARR, top]]), count: 0, since: 0, flags: 0 });
    [this.prescaler, this.reload, this.compare, this.matched] = [0, top, [0, 0, 0, 0], [false, false, false, false]];
    this.isBreaking = false;
    this.isLocked = false;
    this.alarm = machine.clock.createAlarm(() => this.settle());
    /** The timer that this one's start starts. */
    this.slave = null;
  }
  get(offset) {
    return this.values.get(offset) ?? 0;
  }
  get runs() {
    return bit(this.get(CR1), 0);
  }
  mode(channel) {
    const register = this.get(channel < 2 ? CCMR1 : CCMR2) >>> (channel & 1 ? 8 : 0);
    return field(register, 4, 3) | (field(register, 16, 1) << 3);
  }
  /** Whether an output is high at its pin. */
  output(channel) {
    if (!bit(this.get(CCER), 4 * channel)) return false;
    if (this.isAdvanced && !bit(this.get(BDTR), MOE)) return false;
    const mode = this.mode(channel);
    if (mode === 5) return true;
    if (mode === 1) return this.matched[channel];
    if (mode === 6) return this.count < this.compare[channel];
    return false;
  }
  /** Counts up to now. */
  settle() {
    const tick = this.prescaler + 1;
    while (this.runs) {
      const ticks = Math.floor((this.machine.clock.cycles - this.since) / tick);
      if (ticks === 0) break;
      const step = Math.min(ticks, this.toNext());
      this.since += step * tick;
      this.count += step;
      if (this.count > this.reload) {
        this.update();
        this.flags |= 1;
        if (bit(this.get(CR1), 3)) this.values.set(CR1, this.get(CR1) & ~1);
      }
      this.match();
    }
    if (!this.runs) this.since = this.machine.clock.cycles;
    this.plan();
  }
  match() {
    this.compare.forEach((value, channel) => {
      if (this.count !== value) return;
      this.flags |= 2 << channel;
      if (this.mode(channel) === 1) this.matched[channel] = true;
    });
  }
  /** Counts until something happens. */
  toNext() {
    const at = [this.reload + 1, ...this.compare.filter((value) => value > this.count && value <= this.reload)];
    return Math.min(...at) - this.count;
  }
  update() {
    this.count = 0;
    this.prescaler = this.get(PSC);
    this.reload = this.get(ARR);
    this.compare = this.compare.map((_, channel) => this.get(CCR1 + 4 * channel));
  }
  plan() {
    this.alarm.at = this.runs ? this.since + this.toNext() * (this.prescaler + 1) : Infinity;
    const asked = this.flags & this.get(DIER);
    if (this.line !== null) this.machine.nvic.line(this.line, (asked & 0x1f) !== 0);
    if (this.breakLine !== null) this.machine.nvic.line(this.breakLine, (asked & BIF) !== 0);
    this.machine.drive();
  }
  start() {
    this.since = this.machine.clock.cycles;
    this.slave?.triggered();
  }
  triggered() {
    this.settle();
    this.update();
    this.values.set(CR1, this.get(CR1) | 1);
    this.since = this.machine.clock.cycles;
    this.plan();
  }
  /** The level of the break input: off at once, without the processor. */
  breaks(level) {
    this.isBreaking = level;
    if (!level || !bit(this.get(BDTR), 12)) return;
    this.values.set(BDTR, this.get(BDTR) & ~(1 << MOE));
    this.flags |= BIF;
    this.plan();
  }
  read(offset) {
    this.settle();
    if (offset === CNT) return this.count;
    if (offset === SR) return this.flags;
    return this.get(offset);
  }
  write(offset, value) {
    this.settle();
    const ran = this.runs;
    if (offset === SR) this.flags &= value | (this.isBreaking && bit(this.get(BDTR), 12) ? BIF : 0);
    else if (offset === CNT) this.count = value;
    else if (offset === EGR) {
      if (bit(value, 0)) {
        this.update();
        this.since = this.machine.clock.cycles;
        if (!bit(this.get(CR1), 2)) this.flags |= 1;
      }
    } else if (offset === BDTR) {
      const breaks = this.isBreaking && bit(value, 12);
      const open = this.isLocked ? (this.get(BDTR) & ~(1 << MOE)) | (value & (1 << MOE)) : value;
      this.values.set(BDTR, breaks ? open & ~(1 << MOE) : open);
      if (breaks) this.flags |= BIF;
      this.isLocked ||= field(value, 8, 2) === 3;
    } else if (this.isLocked && [CCMR1, CCMR2].includes(offset)) {
      // Modes of outputs are locked.
    } else {
      this.values.set(offset, value);
      const channel = (offset - CCR1) / 4;
      if (offset >= CCR1 && offset <= CCR4) {
        const isPreloaded = bit(this.get(channel < 2 ? CCMR1 : CCMR2), channel & 1 ? 11 : 3);
        if (!isPreloaded) this.compare[channel] = value;
      }
      if (offset === ARR && !bit(this.get(CR1), 7)) this.reload = value;
      for (const index of [0, 1, 2, 3]) if (this.mode(index) === 4) this.matched[index] = false;
    }
    if (!ran && this.runs) this.start();
    this.plan();
  }
}

const PINS = 7 * 16;
const [MODER, IDR, ODR, BSRR, AFRL, BRR] = [0x00, 0x10, 0x14, 0x18, 0x20, 0x28];

/** A pin: what drives it, what is put to it from outside, and who listens. */
class Pin {
  listeners = [];
  driven = false;
  input = null;
  constructor(changed) {
    this.changed = changed;
  }
  addListener(call) {
    this.listeners.push(call);
  }
  setInputValue(level) {
    const fell = this.input && !level;
    this.input = level;
    this.changed(fell);
  }
}

export class Machine {
  /** `reason`: 1 after the watchdog; `id`: the chip's unique number, three words. */
  constructor(parts, { reason = 0, id = [0x00210043, 0x5648500e, 0x20343831], startNs = 0, onReset }) {
    Object.assign(this, { hangs: false, busyNs: 0, onReset });
    this.clock = new Clock();
    this.clock.cycles = Math.round(startNs / CYCLE_NS);
    this.nvic = new Nvic();
    this.vtor = FLASH;
    this.isMasked = false;
    this.sleeps = false;
    this.pins = Array.from({ length: PINS }, (_, number) => new Pin((fell) => this.changed(number, fell)));
    /** Registers that nothing stands behind. */
    this.plain = new Map();
    this.supply = 0;
    this.cdc = { onSerialData() {}, onDeviceConnected: null };
    this.peripherals(reason);
    this.cpu = new Cortex();
    const flash = Buffer.alloc(FLASH_BYTES, 0xff);
    for (const { address, bytes } of parts) if (address >= FLASH && address < FLASH + FLASH_BYTES) bytes.copy(flash, address - FLASH);
    this.cpu.memory(FLASH, flash);
    this.cpu.memory(RAM, Buffer.alloc(RAM_BYTES));
    const system = Buffer.alloc(0x1000, 0xff);
    id.forEach((word, index) => system.writeUInt32LE(word, UNIQUE_ID + 4 * index));
    this.cpu.memory(SYSTEM, system);
    this.cpu.order('G', FLASH);
  }

  peripherals(reason) {
    const [READY_OF_ON, POWER_ON, WATCHDOG, BY_PIN] = [[[8, 10], [16, 17], [24, 25]], 1 << 27, 1 << 29, 1 << 26];
    let causes = (reason === 1 ? WATCHDOG : POWER_ON) | BY_PIN;
    const rcc = new Registers({
      read: (offset, value) => {
        if (offset === 0x00) return READY_OF_ON.reduce((all, [on, ready]) => (bit(all, on) ? all | (1 << ready) : all & ~(1 << ready)), value);
        if (offset === 0x08) return (value & ~0xc) | ((value & 3) << 2);
        if (offset === 0x94) return causes | (value & 1) | ((value & 1) << 1);
        return value;
      },
      write: (offset, value) => {
        if (offset === 0x94 && bit(value, 23)) causes = 0;
        return value;
      },
    });
    this.timers = {
      1: new Timer(this, { isAdvanced: true, breakLine: IRQ.TIM1_BREAK }),
      2: new Timer(this, { top: 0xffffffff }),
      3: new Timer(this, { line: IRQ.TIM3 }),
      8: new Timer(this, { isAdvanced: true }),
    };
    this.timers[1].slave = this.timers[2];
    /** What a pin's alternate function is: its output, and its break input. */
    this.outputs = new Map();
    const output = (port, number, af, timer, channel) => this.outputs.set(`${16 * port + number}:${af}`, () => this.timers[timer].output(channel));
    [0, 1, 2, 3].forEach((channel) => output(2, channel, 2, 1, channel));
    output(2, 6, 4, 8, 0);
    output(1, 11, 1, 2, 3);
    this.breakPins = new Map([['26:12', this.timers[1]], ['23:5', this.timers[8]]]);
    this.gpio = Array.from({ length: 7 }, () => new Map([[MODER, 0xffffffff]]));
    const adc = new Registers({
      read: (offset, value, all) => {
        const control = all.get(0x08) ?? 0;
        if (offset === 0x00) return (bit(control, 0) ? 1 : 0) | (all.get('over') ? 0xc : 0);
        if (offset === 0x40) return this.supply;
        return value;
      },
      write: (offset, value, all) => {
        if (offset === 0x00 && value & 0xc) all.set('over', false);
        if (offset !== 0x08) return value;
        if (bit(value, 2)) all.set('over', true);
        return value & ~0x80000004;
      },
    });
    this.map = new Map(
      Object.entries({
        0x40000000: this.timers[2],
        0x40000400: this.timers[3],
        0x40012c00: this.timers[1],
        0x40013400: this.timers[8],
        0x40003000: this.watchdog(),
        0x40003800: this.spi(),
        0x40008000: this.uart(),
        0x40010400: this.exti(),
        0x40021000: rcc,
        0x50000000: adc,
      }).map(([address, peripheral]) => [Number(address), peripheral]),
    );
    this.chip = { spi: [this.map.get(0x40003800)] };
  }

  watchdog() {
    const over = this.clock.createAlarm(() => this.onReset(1));
    const registers = new Registers({
      read: (offset, value) => (offset === 0x0c ? 0 : value),
      write: (offset, value, all) => {
        if (offset === 0x00 && value === 0xcccc) all.set('runs', true);
        // 32 kHz, divided by 4 and more.
        const ns = (((all.get(0x08) ?? 0xfff) + 1) * 4 * 2 ** (all.get(0x04) ?? 0) * 1e9) / 32000;
        if (offset === 0x00 && all.get('runs') && [0xcccc, 0xaaaa].includes(value)) over.schedule(ns);
        return value;
      },
    });
    return registers;
  }

  /** SPI 2: two words wait each way. */
  spi() {
    const [send, came] = [[], []];
    let isBusy = false;
    const spi = {
      onTransmit: null,
      next() {
        if (isBusy || send.length === 0) return;
        isBusy = true;
        spi.onTransmit(send.shift());
      },
      completeTransmit(word) {
        isBusy = false;
        if (came.length < 2) came.push(word);
        spi.next();
      },
      values: new Map(),
      read(offset) {
        if (offset === 0x08) return (came.length > 0 ? 1 : 0) | (send.length < 2 ? 2 : 0) | (isBusy ? 0x80 : 0);
        if (offset === 0x0c) return came.shift() ?? 0;
        return spi.values.get(offset) ?? 0;
      },
      write(offset, value) {
        if (offset !== 0x0c) spi.values.set(offset, value);
        else if (send.length < 2) send.push(value & 0xffff);
        spi.next();
      },
    };
    return spi;
  }

  /** LPUART1: queues of eight, thresholds of four, and a line of ten bits a byte. */
  uart() {
    const [UE, RXFT, TXFT] = [0, 26, 27];
    const values = new Map();
    const [waiting, came, go] = [[], [], []];
    let [isIdle, sends] = [false, false];
    const get = (offset) => values.get(offset) ?? 0;
    const byteNs = () => (10 * get(0x0c) * CYCLE_NS) / 256;
    const flags = () =>
      (isIdle ? 1 << 4 : 0) | (came.length > 0 ? 1 << 5 : 0) | (go.length < 8 ? 1 << 7 : 0) | (came.length >= 4 ? 1 << RXFT : 0) | (go.length <= 4 ? 1 << TXFT : 0);
    const asks = () => {
      const [cr1, cr3, now] = [get(0x00), get(0x08), flags()];
      const does = (isr, on) => bit(now, isr) && on;
      return does(4, bit(cr1, 4)) || does(5, bit(cr1, 5)) || does(7, bit(cr1, 7)) || does(RXFT, bit(cr3, 28)) || does(TXFT, bit(cr3, 23));
    };
    const look = () => this.nvic.line(IRQ.LPUART1, asks());
    const arrives = this.clock.createAlarm(() => {
      if (waiting.length === 0) {
        isIdle = true;
      } else {
        const byte = waiting.shift();
        // One too many is lost.
        if (came.length < 8) came.push(byte);
        arrives.schedule(byteNs());
      }
      look();
    });
    const sent = this.clock.createAlarm(() => {
      const byte = go.shift();
      this.cdc.onSerialData(Uint8Array.of(byte));
      sends = go.length > 0;
      if (sends) sent.schedule(byteNs());
      look();
    });
    this.send = (bytes) => {
      if (!bit(get(0x00), UE)) return;
      waiting.push(...bytes);
      if (arrives.at === Infinity) arrives.schedule(byteNs());
    };
    return {
      read: (offset) => {
        if (offset === 0x1c) return flags();
        if (offset !== 0x24) return get(offset);
        const byte = came.shift() ?? 0;
        look();
        return byte;
      },
      write: (offset, value) => {
        if (offset === 0x20) isIdle &&= !bit(value, 4);
        else if (offset === 0x28) {
          if (go.length < 8) go.push(value & 0xff);
          if (!sends) sent.schedule(byteNs());
          sends = true;
        } else values.set(offset, value);
        if (offset === 0x00 && bit(value, UE)) this.cdc.onDeviceConnected?.();
        look();
      },
    };
  }

  /** EXTI: line 1 falling is BUSY on port B. */
  exti() {
    const [IMR, FTSR, PR] = [0x00, 0x0c, 0x14];
    const values = new Map();
    const get = (offset) => values.get(offset) ?? 0;
    this.fell = (pin) => {
      if (pin !== 17 || field(this.syscfg ?? 0, 4, 4) !== 1 || !bit(get(FTSR), 1)) return;
      values.set(PR, get(PR) | 2);
      this.nvic.line(IRQ.EXTI1, bit(get(PR) & get(IMR), 1));
    };
    return {
      read: get,
      write: (offset, value) => {
        values.set(offset, offset === PR ? get(PR) & ~value : value);
        this.nvic.line(IRQ.EXTI1, bit(get(PR) & get(IMR), 1));
      },
    };
  }

  pin(number) {
    return this.pins[number];
  }

  changed(number, fell) {
    if (fell) this.fell(number);
    this.sense();
  }

  isHigh(number) {
    return this.pins[number].driven;
  }

  /** What a pin is set to: 0 input, 1 output, 2 a peripheral's, 3 nothing. */
  kind(number) {
    return field(this.gpio[number >> 4].get(MODER) ?? 0, 2 * (number & 15), 2);
  }
  functionOf(number) {
    return field(this.gpio[number >> 4].get(AFRL + ((number & 8) >> 1)) ?? 0, 4 * (number & 7), 4);
  }

  /** Break inputs follow their pins. */
  sense() {
    for (const [key, timer] of this.breakPins) {
      const [number, af] = key.split(':').map(Number);
      const level = this.kind(number) === 2 && this.functionOf(number) === af && this.pins[number].input !== false;
      if (level !== timer.isBreaking) timer.breaks(level);
    }
  }

  /** Pins follow what drives them; one that nothing drives is pulled low by its resistor. */
  drive() {
    if (!this.gpio) return;
    this.pins.forEach((pin, number) => {
      const kind = this.kind(number);
      const high = kind === 1 ? bit(this.gpio[number >> 4].get(ODR) ?? 0, number & 15) : kind === 2 && (this.outputs.get(`${number}:${this.functionOf(number)}`)?.() ?? false);
      if (high === pin.driven) return;
      pin.driven = high;
      for (const call of pin.listeners) call();
    });
  }

  load(address) {
    if (address >= 0xe000e000) return this.nvic.read(address - 0xe000e000);
    const port = this.port(address);
    if (port) {
      if (port.offset === IDR) return this.levels(port.index);
      return port.values.get(port.offset) ?? 0;
    }
    const peripheral = this.map.get(address & ~0x3ff);
    return peripheral ? peripheral.read(address & 0x3ff) : (this.plain.get(address) ?? 0);
  }

  store(address, value) {
    if (address >= 0xe000e000) return this.nvic.write(address - 0xe000e000, value, (vtor) => (this.vtor = vtor));
    const port = this.port(address);
    if (port) {
      const { values, offset } = port;
      const odr = values.get(ODR) ?? 0;
      if (offset === BSRR) values.set(ODR, (odr & ~(value >>> 16)) | (value & 0xffff));
      else if (offset === BRR) values.set(ODR, odr & ~value);
      else values.set(offset, value);
      this.sense();
      return this.drive();
    }
    if (address === 0x40010008) this.syscfg = value;
    const peripheral = this.map.get(address & ~0x3ff);
    if (peripheral) peripheral.write(address & 0x3ff, value);
    else this.plain.set(address, value);
  }

  /** Lets the processor stand still after so many stores to a peripheral, from now on. */
  hangAfter(address, stores) {
    this.hang = { address, stores };
  }

  port(address) {
    if (address < 0x48000000 || address >= 0x48001c00) return null;
    const index = (address - 0x48000000) >> 10;
    return { index, values: this.gpio[index], offset: address & 0x3ff };
  }

  levels(port) {
    let levels = 0;
    for (let number = 0; number < 16; number++) {
      const pin = this.pins[16 * port + number];
      if (pin.input ?? pin.driven) levels |= 1 << number;
    }
    return levels;
  }

  /** Runs until a time, or until `deadline` of the host's clock, ms. */
  run(untilNs, deadline) {
    const until = Math.round(untilNs / CYCLE_NS);
    while (this.clock.cycles < until) {
      if (performance.now() > deadline) return;
      this.clock.advance(this.clock.cycles);
      const due = this.nvic.due;
      if (due !== null && !this.isMasked && !this.hangs) {
        this.nvic.enter(due);
        this.cpu.order('E', this.vtor + 4 * (16 + due));
        this.sleeps = false;
      }
      const next = Math.min(until, this.clock.next);
      if (this.sleeps || this.hangs) {
        this.clock.advance(next);
        continue;
      }
      const most = due !== null && this.isMasked ? MASKED : LONGEST;
      this.slice(Math.max(1, Math.min(most, next - this.clock.cycles)));
    }
  }

  slice(count) {
    const begun = this.clock.cycles;
    const planned = this.clock.next;
    this.cpu.order('R', count);
    for (;;) {
      const [what, one, two, three] = this.cpu.hear();
      if (what === 0x4c) {
        this.clock.advance(Math.max(this.clock.cycles, begun + three));
        this.cpu.answer(this.load(one));
      } else if (what === 0x57) {
        this.clock.advance(Math.max(this.clock.cycles, begun + three));
        // One that stands still does not come to the end of its block.
        if (!this.hangs) this.store(one, two);
        if (this.hang && (one & ~0x3ff) === this.hang.address && --this.hang.stores === 0) this.hangs = true;
        this.cpu.answer(this.hangs || this.clock.next < planned || this.nvic.due !== null ? 1 : 0);
      } else {
        this.clock.advance(Math.max(this.clock.cycles, begun + two));
        this.busyNs += (this.clock.cycles - begun) * CYCLE_NS;
        this.isMasked = three === 1;
        if (one === WFE) this.sleeps = true;
        else if (one === RETURNED) {
          this.nvic.leave();
          this.cpu.order('X');
        } else if (one === FAULT) throw new Error('the processor has stopped');
        else if (one !== COUNT_OVER) throw new Error(`the processor ended for ${one}`);
        return;
      }
    }
  }

  end() {
    this.cpu.end();
  }
}

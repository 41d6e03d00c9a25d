// node check.mjs FIRMWARE.elf [PERIODS]: what the firmware does with four channels at 500 Hz, in the emulator's own time. Every figure is told; ends
// with 1 where one is not as it should be.

import { Board, firmwareOf } from './board.mjs';
import { Reader, clear, configure, duty, hello, identification, samples } from './frames.mjs';

const PERIOD_NS = 2e6;
const PERIODS = Number(process.argv[3] ?? 200);
const FULL_DUTY = 65535;
const NOT_SAMPLED = 65535;
const WATCHDOG_PERIODS = 5;
const LIMITS = { maxDuty: FULL_DUTY, maxCurrentMa: 1500, heatMa2S: 1_000_000, drainMa2: 1_000_000 };
const [READY, RUNNING, TRIPPED, STOPPED] = [1, 2, 3, 4];
/** TIM1. */
const GATES_TIMER = 0x40012c00;

const elf = process.argv[2];
if (elf === undefined) {
  console.error('usage: node check.mjs FIRMWARE.elf [PERIODS]');
  process.exit(2);
}
const firmware = await firmwareOf(elf);
const { name, serial, gates: GATES, enable: ENABLE, byteNs, breaks } = firmware.kind;
let [failed, checked] = [0, 0];

function check(what, isGood, figure = '') {
  checked += 1;
  failed += isGood ? 0 : 1;
  console.log(`${isGood ? 'ok  ' : 'BAD '} ${what}${figure === '' ? '' : `: ${figure}`}`);
}

/** A board whose frames are kept, with the times they came, and every edge of its gates. */
function board(reason = 0) {
  const reader = new Reader();
  const kept = { frames: [], edges: GATES.map(() => []), resets: null, reader };
  const send = (bytes) => kept.frames.push(...reader.push(bytes).map((frame) => ({ ...frame, ns: kept.board.machine.clock.nanos })));
  kept.board = new Board(firmware, send, { reason, onReset: (why) => (kept.resets = why) });
  const { machine } = kept.board;
  GATES.forEach((pin, channel) => machine.pin(pin).addListener(() => kept.edges[channel].push({ ns: machine.clock.nanos, on: machine.isHigh(pin) })));
  kept.run = (ns) => machine.run(machine.clock.nanos + ns, Infinity);
  kept.send = (bytes) => machine.send(bytes);
  kept.last = (kind) => kept.frames.filter((frame) => frame.kind === kind).at(-1);
  kept.areOff = () => GATES.every((pin) => !machine.isHigh(pin)) && !machine.isHigh(ENABLE);
  let sequence = 0;
  kept.duty = (duties) => kept.send(duty(++sequence, (WATCHDOG_PERIODS * PERIOD_NS) / 1000, duties));
  kept.start = (limits = LIMITS, usesStop = true) => {
    kept.run(100e6);
    kept.send(configure({ session: 7, periodNs: PERIOD_NS, watchdogPeriods: WATCHDOG_PERIODS, enable: 1, usesStop, channels: 4, limits }));
    kept.run(2e6);
    for (let frame = 0; frame < 3; frame++) {
      kept.duty([0, 0, 0, 0]);
      kept.run(PERIOD_NS);
    }
  };
  return kept;
}

const rms = (values) => Math.sqrt(values.reduce((sum, value) => sum + value ** 2, 0) / values.length);
const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;
const us = (ns) => `${(ns / 1000).toFixed(1)} µs`;

// Who it is.
{
  const it = board();
  it.run(100e6);
  it.send(hello(99));
  it.run(5e6);
  const who = identification(it.last(0x81));
  check('identification', who.nonce === 99 && who.name === name && who.channels === 4 && who.features === 3, JSON.stringify(who));
  check('started after power-on', who.reset === 1);
  check('its serial number is its own', who.serial === serial, who.serial);
}

// Four wires at duties of their own, the sensing pulse of 2 % among them.
{
  const it = board();
  it.start();
  const DUTIES = [0.02, 0.1, 0.13, 0.3].map((share) => Math.round(share * FULL_DUTY));
  // Wires that stay as long as they are: σ is the measurement's.
  it.board.wires.heats = false;
  it.edges.forEach((edges) => (edges.length = 0));
  const begun = it.frames.length;
  it.board.machine.busyNs = 0;
  const sent = [];
  for (let period = 0; period < PERIODS; period++) {
    sent.push(it.board.machine.clock.nanos);
    it.duty(DUTIES);
    it.run(PERIOD_NS);
  }
  const busy = it.board.machine.busyNs / (PERIODS * PERIOD_NS);
  const frames = it.frames.slice(begun).filter((frame) => frame.kind === 0x83).map((frame) => ({ ...samples(frame), ns: frame.ns }));
  check('a samples frame a period, none damaged', frames.length === PERIODS && it.reader.damaged === 0, `${frames.length} of ${PERIODS}`);
  const last = frames.at(-1);
  check('state is running, nothing lost or refused', last.state === RUNNING && last.lost === 0 && last.refused === 0);
  const rises = it.edges[3].filter(({ on }) => on).map(({ ns }) => ns);
  const lags = sent.map((ns, index) => (rises[index] ?? Infinity) - ns);
  check('from the frame to its pulses', Math.max(...lags) < 400e3, `${us(Math.min(...lags))} to ${us(Math.max(...lags))}`);
  const answers = frames.map(({ ns }, index) => ns - sent[index]);
  const onLine = (duty(0, 0, DUTIES).length + it.last(0x83).bytes) * byteNs;
  const parts = `the longest on-phase is 600 µs of it, the line ${us(onLine)}`;
  check('from the frame to its samples', Math.max(...answers) - onLine < PERIOD_NS * 0.6, `${us(Math.min(...answers))} to ${us(Math.max(...answers))}, ${parts}`);
  check('processor busy, of two milliseconds', busy < 0.7, us(busy * PERIOD_NS));

  DUTIES.forEach((duty, channel) => {
    const wanted = (duty / FULL_DUTY) * PERIOD_NS;
    const edges = it.edges[channel];
    const lengths = edges.flatMap((edge, index) => (!edge.on && index > 0 ? [edge.ns - edges[index - 1].ns] : []));
    const worst = Math.max(...lengths.map((length) => Math.abs(length - wanted)));
    // The last period ends with the run.
    check(`channel ${channel}: ${PERIODS} pulses of ${us(wanted)}`, Math.abs(lengths.length - PERIODS) <= 1 && worst < 100, `worst ${us(worst)} beside it`);
  });

  const who = { full: 65534, volts: 10, amperes: 5, supply: 13.2 };
  const wires = it.board.wires;
  DUTIES.forEach((_, channel) => {
    const values = frames.map(({ codes }) => codes[channel]);
    check(`channel ${channel}: every period sampled`, values.every((codes) => codes.every((code) => code !== NOT_SAMPLED)));
    const scaled = values.map(([v1, v2, v3, current, supply]) => ({
      v1: (v1 * who.volts) / who.full,
      v2: (v2 * who.volts) / who.full,
      v3: (v3 * who.volts) / who.full,
      amperes: (current * who.amperes) / who.full,
      supply: (supply * who.supply) / who.full,
    }));
    const { length, ohm } = wires.ofWire(wires.wires[channel]);
    const lengths = scaled.map(({ v1, v2, v3 }) => (0.15 * (v3 - v1)) / (v2 - v1));
    const [found, sigma] = [mean(lengths), rms(lengths.map((length) => length - mean(lengths)))];
    check(`channel ${channel}: σ of a length at most 0.1 mm`, sigma < 1e-4 && sigma > 1e-6, `${(sigma * 1e6).toFixed(1)} µm`);
    check(`channel ${channel}: its mean is the wire’s`, Math.abs(found - length) < 2e-5, `${(found * 1e3).toFixed(3)} of ${(length * 1e3).toFixed(3)} mm`);
    const resistance = mean(scaled.map(({ v3, amperes }) => v3 / amperes));
    check(`channel ${channel}: resistance`, Math.abs(resistance / ohm - 1) < 0.005, `${resistance.toFixed(3)} of ${ohm.toFixed(3)} Ω`);
    check(`channel ${channel}: supply`, Math.abs(mean(scaled.map(({ supply }) => supply)) - wires.supplyV) < 0.02);
  });
  const after = frames.map(({ afterUs }) => afterUs);
  check('samples go up at the longest on-phase’s end', Math.max(...after) < 800, `${Math.min(...after)} to ${Math.max(...after)} µs after the period began`);

  // Nobody speaks any more.
  const silent = it.board.machine.clock.nanos;
  it.run(100e6);
  const off = Math.max(...it.edges.map((edges) => edges.at(-1).ns)) - silent;
  check('silence: all off', it.areOff() && samples(it.last(0x83)).state === TRIPPED, `last edge ${us(off)} after the last period; ${WATCHDOG_PERIODS} of 2 ms allowed`);
  check('silence: within the watchdog’s periods', off < WATCHDOG_PERIODS * PERIOD_NS);
}

// The emergency stop, in the middle of an on-phase.
{
  const it = board();
  it.start();
  for (let period = 0; period < 5; period++) {
    it.duty([32768, 32768, 32768, 32768]);
    it.run(PERIOD_NS);
  }
  it.duty([32768, 32768, 32768, 32768]);
  it.run(500e3);
  check('emergency stop: all were on', GATES.every((pin) => it.board.machine.isHigh(pin)) && it.board.machine.isHigh(ENABLE));
  const pressed = it.board.machine.clock.nanos;
  it.board.stop(true);
  while (!it.areOff() && it.board.machine.clock.nanos < pressed + 10e6) it.run(1e3);
  check('emergency stop: all off, enable pin too', it.areOff() && it.board.machine.clock.nanos - pressed < 200e3, us(it.board.machine.clock.nanos - pressed));
  it.run(2e6);
  const told = samples(it.last(0x83));
  check('emergency stop: told', told.state === STOPPED && (told.inputs & 1) === 1);
}

// The processor stands still while everything is on.
{
  const it = board();
  it.start();
  for (let period = 0; period < 5; period++) {
    it.duty([65535, 32768, 32768, 32768]);
    it.run(PERIOD_NS);
  }
  it.duty([65535, 32768, 32768, 32768]);
  it.run(300e3);
  it.board.machine.hangs = true;
  const hung = it.board.machine.clock.nanos;
  it.run(2 * PERIOD_NS);
  const off = Math.max(...it.edges.map((edges) => edges.at(-1).ns)) - hung;
  check('hang: every pulse ends by itself', GATES.every((pin) => !it.board.machine.isHigh(pin)) && off < PERIOD_NS, `the longest, full on, after ${us(off)}`);
  while (it.resets === null && it.board.machine.clock.nanos < hung + 1e9) it.run(1e6);
  check('hang: the watchdog resets', it.resets === 1, `${((it.board.machine.clock.nanos - hung) / 1e6).toFixed(0)} ms`);
  const again = board(it.resets);
  again.run(100e6);
  check('hang: after which all is off', again.areOff() && again.edges.every((edges) => edges.length === 0));
  again.send(hello(1));
  again.run(5e6);
  check('hang: and the next start says so', identification(again.last(0x81)).reset === 3);
  // Nobody knows how hot the wires are.
  again.start({ ...LIMITS, drainMa2: 10_000 });
  again.duty([FULL_DUTY, FULL_DUTY, FULL_DUTY, FULL_DUTY]);
  again.run(PERIOD_NS * 1.5);
  const { limited } = samples(again.last(0x83));
  check('hang: and takes its wires for hot', limited === 0b1111n && !again.areOff(), `limited: ${limited}`);
}

// A board that needs no processor for its emergency stop.
if (breaks) {
  const on = (it, periods = 5) => {
    for (let period = 0; period < periods; period++) {
      it.duty([FULL_DUTY, 32768, 32768, 32768]);
      it.run(PERIOD_NS);
    }
    it.duty([FULL_DUTY, 32768, 32768, 32768]);
    it.run(500e3);
  };
  const lit = (it) => GATES.map((pin) => it.board.machine.isHigh(pin));
  {
    const it = board();
    const { timers } = it.board.machine;
    it.start();
    const [enabled, high, idle, again, level] = [12, 13, 10, 14, 8];
    const set = [timers[1], timers[8]].map((timer) => timer.read(0x44));
    const isSet = (value) => [enabled, high, idle].every((bit) => (value >> bit) & 1) && !((value >> again) & 1) && ((value >> level) & 3) === 3;
    check('break: on both timers, active high, idle low, not automatic, locked', set.every(isSet), set.map((value) => value.toString(16)).join(' '));
    on(it);
    check('break: all were on', lit(it).every(Boolean) && it.board.machine.isHigh(ENABLE));
    const { machine } = it.board;
    machine.hangs = true;
    it.board.stop(true);
    check('break: gates and master switch are off at once, the processor stands still', it.areOff());
    it.board.stop(false);
    it.run(50e6);
    check('break: and stay off when the contact closes', it.areOff());
  }
  {
    const it = board();
    it.start();
    on(it);
    const before = it.frames.length;
    it.board.stop(true);
    it.run(1e3);
    it.board.stop(false);
    check('break: a microsecond is enough', it.areOff());
    it.run(1e6);
    const told = it.frames.slice(before).filter(({ kind }) => kind === 0x83).map(samples);
    check('break: and is told', told.some(({ state, inputs }) => state === STOPPED && (inputs & 1) === 1));
    it.edges.forEach((edges) => (edges.length = 0));
    on(it);
    check('break: frames alone switch nothing on', it.areOff() && it.edges.every((edges) => edges.length === 0));
    for (let frame = 0; frame < 3; frame++) {
      it.duty([0, 0, 0, 0]);
      it.run(PERIOD_NS);
    }
    on(it);
    check('break: frames of zeros do', lit(it).every(Boolean) && it.board.machine.isHigh(ENABLE));
    it.board.stop(true);
    it.edges.forEach((edges) => (edges.length = 0));
    for (let period = 0; period < 10; period++) {
      it.duty([0, 0, 0, 0].fill(period < 5 ? 0 : FULL_DUTY));
      it.run(PERIOD_NS);
    }
    check('break: nothing goes on while the contact is open', it.areOff() && it.edges.every((edges) => edges.length === 0));
  }
  {
    const it = board();
    it.start(LIMITS, false);
    on(it);
    it.board.stop(true);
    check('break: off also where nobody looks at the emergency stop', it.areOff());
    it.run(2 * PERIOD_NS);
    it.board.stop(false);
    it.edges.forEach((edges) => (edges.length = 0));
    on(it);
    const { faults } = samples(it.last(0x83));
    check('break: which is a fault of every stage', it.edges.every((edges) => edges.length === 0) && faults.every((fault) => fault === 5), faults.join(' '));
    it.start(LIMITS, false);
    for (let channel = 0; channel < GATES.length; channel++) it.send(clear(channel));
    on(it);
    check('break: until it is configured again and cleared', lit(it).every(Boolean));
  }
  // The processor stands still after each store to the gates' timer by which a period begins.
  const worst = [];
  for (let store = 1; store <= 20; store++) {
    const it = board();
    it.start();
    on(it);
    it.run(PERIOD_NS * 0.75);
    it.edges.forEach((edges) => (edges.length = 0));
    it.board.machine.hangAfter(GATES_TIMER, store);
    it.duty([FULL_DUTY, FULL_DUTY, FULL_DUTY, FULL_DUTY]);
    it.run(PERIOD_NS * 3);
    const lengths = it.edges.flatMap((edges) => edges.flatMap((edge, index) => (!edge.on && index > 0 ? [edge.ns - edges[index - 1].ns] : [])));
    if (it.board.machine.hangs) worst.push(lit(it).some(Boolean) ? Infinity : Math.max(0, ...lengths));
    it.board.machine.end();
  }
  check('hang: wherever a period begins', worst.length >= 10 && Math.max(...worst) <= PERIOD_NS, `after each of ${worst.length} stores; on for ${us(Math.max(...worst))} at the most`);
}

// A converter that is not there, and a stage that conducts by itself.
{
  const it = board();
  it.board.converter.isThere = false;
  it.start();
  for (let period = 0; period < 5; period++) {
    it.duty([32768, 0, 0, 0]);
    it.run(PERIOD_NS);
  }
  check('no converter: the channel is off for it', samples(it.last(0x83)).faults[0] === 3 && !it.board.machine.isHigh(GATES[0]));
}
{
  const it = board();
  it.start();
  for (let period = 0; period < 20; period++) {
    if (period === 10) it.board.wires.wires[1].isStuck = true;
    if (period === 10) it.board.wires.switch(it.board.wires.wires[1]);
    it.duty([3277, 0, 0, 0]);
    it.run(PERIOD_NS);
  }
  check('a stage conducts: found, and the enable pin is off', samples(it.last(0x83)).faults[1] === 5 && !it.board.machine.isHigh(ENABLE));
}

console.log(`${checked - failed} passed, ${failed} failed`);
process.exit(failed > 0 ? 1 : 0);

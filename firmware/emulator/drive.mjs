// node drive.mjs FIRMWARE.elf SINEW: the real driver, `sinew run` as a process of its own, on the emulated board at 10 Hz. It identifies and measures, moves a
// wire, hears the emergency stop, and is killed; ends with 1 where something is not as it should be.

import { execFileSync, spawn } from 'node:child_process';
import { existsSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { setTimeout as sleep } from 'node:timers/promises';
import { firmwareOf } from './board.mjs';

const [elf, sinew] = process.argv.slice(2);
if (sinew === undefined) {
  console.error('usage: node drive.mjs FIRMWARE.elf SINEW');
  process.exit(2);
}
const { kind } = await firmwareOf(elf);
const folder = mkdtempSync(join(tmpdir(), 'sinew-board-'));
const [link, rig] = [join(folder, 'front-end'), join(folder, 'rig.toml')];
const name = `emulated-board-${process.pid}`;
const CHANNELS = ['a', 'b', 'c', 'd'];
const OHM = 10.4;
const channel = (wire) => `
[[channel]]
name = "${wire}"
wire = { diameter_mm = 0.125, length_mm = 160.0 }
taps = { l0_mm = 0.0, ls_mm = 150.0 }
drive = { supply_v = 6.5, shunt_ohm = 0.5, switch_ohm = 0.05 }
adc = { voltage_range_v = 10.0, current_range_a = 5.0, voltage_noise_v = 0.00025, current_noise_a = 0.0005 }
load = { mass_kg = 0.08, damping_n_s_per_m = 30.0, spring_n_per_m = 150.0, preload_n = 2.4 }
`;
writeFileSync(
  rig,
  `[rig]
name = "${name}"
rate_hz = 10

[backend]
kind = "serial"
serial.port = "${link}"

[backend.enable]
signal = "level"

[backend.estop]
fitted = true
${CHANNELS.map(channel).join('')}`,
);

let [failed, checked] = [0, 0];
function check(what, isGood, figure = '') {
  checked += 1;
  failed += isGood ? 0 : 1;
  console.log(`${isGood ? 'ok  ' : 'BAD '} ${what}${figure === '' ? '' : `: ${figure}`}`);
}

/** A process whose lines are kept. */
function start(program, args) {
  const child = spawn(program, args, { stdio: ['pipe', 'pipe', 'pipe'] });
  const lines = [];
  for (const stream of [child.stdout, child.stderr]) stream.on('data', (text) => lines.push(...text.toString().split('\n')));
  child.on('exit', (code, signal) => lines.push(`ended: ${code ?? signal}`));
  return { child, lines, order: (text) => child.stdin.write(`${text}\n`) };
}

async function until(what, is, seconds = 20) {
  for (const end = performance.now() + seconds * 1000; performance.now() < end; await sleep(300)) {
    const found = is();
    // What the others have said meanwhile is read while nothing is asked.
    if (found) return sleep(300, found);
  }
  check(what, false, `not within ${seconds} s`);
  throw new Error([what, ...(driver?.lines.slice(-20) ?? []), ...board.lines.slice(-5)].join('\n'));
}

const tell = (...args) => {
  try {
    return execFileSync(sinew, [...args, '--rig', name], { stdio: ['ignore', 'pipe', 'pipe'] }).toString();
  } catch (error) {
    return String(error.stdout ?? error);
  }
};
const status = () => {
  try {
    return JSON.parse(tell('status', '--json')).channel;
  } catch {
    return null;
  }
};
const told = (board, key) => board.lines.filter((line) => line.includes(key)).map((line) => JSON.parse(line)).at(-1);

const board = start(process.execPath, [new URL('emulate.mjs', import.meta.url).pathname, elf, link]);
let driver = null;
try {
  await until('the board has its line', () => existsSync(link) && told(board, '"line"'));
  driver = start(sinew, ['run', rig, '--no-monitor']);
  const who = await until('the driver knows the board', () => driver.lines.find((line) => line.includes(kind.name)));
  check('identified', who !== null && who.includes('started after power-on'), who ?? driver.lines.join('\n'));
  await until('the emergency stop stands', () => status()?.every(({ fault }) => fault !== null));

  board.order('reset press');
  await sleep(500);
  board.order('reset release');
  await sleep(500);
  tell('reset', '--all');
  const rest = await until('all wires are measured', () => {
    const now = status();
    return now?.every(({ fault, resistance_ohm: ohm }) => fault === null && ohm !== null) ? now : null;
  });
  const worst = Math.max(...(rest ?? []).map(({ resistance_ohm: ohm }) => Math.abs(ohm / OHM - 1)));
  check('resistances are the wires’', worst < 0.005, rest?.map(({ resistance_ohm: ohm }) => ohm.toFixed(3)).join(' '));
  check('and so are lengths', rest?.every(({ measured_length_m: m }) => Math.abs(m - 0.1667) < 1e-4), rest?.map(({ measured_length_m: m }) => (m * 1e3).toFixed(3)).join(' '));
  check('the enable pin is on', told(board, '"enable"')?.on === true, JSON.stringify(told(board, '"enable"')));

  tell('set', 'a', 'stroke=40%', '--hold', '8');
  const moved = await until('wire a shortens', () => board.lines.filter((line) => line.includes('length_mm')).map((line) => JSON.parse(line)).find(({ length_mm: mm }) => mm[0] < 165.5));
  check('and it alone', moved?.length_mm.slice(1).every((mm) => mm === 166.7), JSON.stringify(moved?.length_mm));

  board.order('estop open');
  await until('the driver hears the emergency stop', () => status()?.every(({ fault }) => fault === 'emergency_stop'));
  check('emergency stop: the enable pin is off', told(board, '"enable"')?.on === false);
  board.order('estop closed');
  await sleep(500);
  board.order('reset press');
  await sleep(500);
  board.order('reset release');
  await sleep(500);
  tell('reset', '--all');
  await until('it goes on', () => told(board, '"enable"')?.on === true && status()?.every(({ fault }) => fault === null));

  driver.child.kill('SIGKILL');
  await until('the driver is gone, and the enable pin off', () => told(board, '"enable"')?.on === false, 3);
  const before = told(board, 'pulses').ms;
  const after = await until('no pulse any more', () => {
    const last = told(board, 'pulses');
    return last.ms > before + 1500 ? last : null;
  });
  check('silence: no pulse any more', after?.pulses.every((count) => count === 0), JSON.stringify(after?.pulses));
} catch (error) {
  console.error(error.message);
} finally {
  driver?.child.kill('SIGKILL');
  board.order('quit');
  rmSync(folder, { recursive: true, force: true });
}
console.log(`${checked - failed} passed, ${failed} failed`);
process.exit(failed > 0 ? 1 : 0);

// Frames of docs/front-end.md, as a driver writes and reads them: only what check.mjs needs.

import { crc32 } from 'node:zlib';

const VERSION = 2;

/** A body as it goes over the line. */
function stuffed(body) {
  const sum = Buffer.alloc(4);
  sum.writeUInt32LE(crc32(body));
  const bytes = Buffer.concat([body, sum]);
  const line = [0];
  let run = [];
  const close = () => {
    line.push(run.length + 1, ...run);
    run = [];
  };
  for (const byte of bytes) {
    if (byte !== 0) run.push(byte);
    if (byte === 0 || run.length === 254) close();
  }
  close();
  return Buffer.from([...line, 0]);
}

const u = (size) => (value) => {
  const bytes = Buffer.alloc(size);
  bytes.writeUIntLE(value, 0, size);
  return bytes;
};
const [u8, u16, u32] = [u(1), u(2), u(4)];
const body = (kind, ...fields) => stuffed(Buffer.concat([u8(VERSION), u8(kind), ...fields]));

export const hello = (nonce) => body(0x01, u32(nonce));
export const configure = ({ session, periodNs, watchdogPeriods, enable, usesStop, channels, limits: l }) => {
  const limits = [u16(l.maxDuty), u16(l.maxCurrentMa), u32(l.heatMa2S), u32(l.drainMa2)];
  const head = [u32(session), u32(periodNs), u16(watchdogPeriods), u8(enable), u8(usesStop ? 1 : 0), u8(channels)];
  return body(0x02, ...head, ...Array(channels).fill(limits).flat());
};
export const duty = (sequence, validUs, duties) =>
  body(0x03, u32(sequence), u32(validUs), u8(1), u8(duties.length), ...duties.map((duty) => u16(duty)));
export const clear = (channel) => body(0x05, u8(channel));

/** Takes bytes, gives frames. */
export class Reader {
  line = [];
  damaged = 0;

  push(bytes) {
    const frames = [];
    for (const byte of bytes) {
      if (byte !== 0) this.line.push(byte);
      else if (this.line.length > 0) {
        const frame = this.frame(this.line);
        this.line = [];
        if (frame) frames.push(frame);
        else this.damaged += 1;
      }
    }
    return frames;
  }

  frame(line) {
    const bytes = [];
    for (let at = 0; at < line.length; at += line[at]) {
      bytes.push(...line.slice(at + 1, at + line[at]));
      if (line[at] < 255 && at + line[at] < line.length) bytes.push(0);
    }
    const all = Buffer.from(bytes);
    const body = all.subarray(0, -4);
    if (all.length < 6 || crc32(body) !== all.readUInt32LE(all.length - 4)) return null;
    return { version: body[0], kind: body[1], body, bytes: line.length + 2 };
  }
}

export function identification({ body }) {
  return {
    nonce: body.readUInt32LE(2),
    name: body.subarray(6, 22).toString().replace(/\0+$/, ''),
    version: [...body.subarray(22, 25)].join('.'),
    serial: body.readBigUInt64LE(25).toString(16),
    minPeriodNs: body.readUInt32LE(33),
    fullCode: body.readUInt16LE(45),
    features: body[47],
    reset: body[48],
    channels: body[57],
    voltageUv: body.readUInt32LE(58),
    currentUa: body.readUInt32LE(62),
    supplyUv: body.readUInt32LE(66),
  };
}

export function samples({ body }) {
  const channels = body[18];
  const codes = (at) => [0, 2, 4, 6, 8].map((offset) => body.readUInt16LE(at + offset));
  return {
    sequence: body.readUInt32LE(2),
    state: body[6],
    inputs: body[7],
    afterUs: body.readUInt16LE(8),
    lost: body.readUInt16LE(14),
    refused: body.readUInt16LE(16),
    codes: Array.from({ length: channels }, (_, channel) => codes(20 + 10 * channel)),
    faults: body[19] ? [...body.subarray(28 + 10 * channels, 28 + 11 * channels)] : Array(channels).fill(0),
    limited: body[19] ? body.readBigUInt64LE(20 + 10 * channels) : 0n,
  };
}

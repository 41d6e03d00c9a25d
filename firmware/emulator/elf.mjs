// ELF files, as far as a flasher reads them.

import { readFileSync } from 'node:fs';

/** The parts of an ELF file that lie in flash: `[{ address, bytes }]`. */
export function flashOf(path) {
  const file = readFileSync(path);
  if (file.readUInt32BE(0) !== 0x7f454c46 || file[4] !== 1) {
    throw new Error(`${path} is no ELF file of 32 bits: give the one that cargo built, not the UF2`);
  }
  const [headers, size, count] = [file.readUInt32LE(28), file.readUInt16LE(42), file.readUInt16LE(44)];
  const parts = [];
  for (let index = 0; index < count; index++) {
    const at = headers + index * size;
    const [type, offset, , address, length] = [0, 4, 8, 12, 16].map((field) => file.readUInt32LE(at + field));
    if (type === 1 && length > 0) parts.push({ address, bytes: file.subarray(offset, offset + length) });
  }
  return parts;
}

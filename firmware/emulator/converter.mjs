// The AD7616 on SPI 0: registers, ranges, sequencer and burst as its data sheet has them, one pair of inputs a microsecond.

const [CONVST, BUSY, RESET] = [10, 11, 12];
const PAIR_NS = 1000;
const WORD_NS = 1088; // 17 clocks of 15.6 MHz
const FULL = { 0: 10, 1: 2.5, 2: 5, 3: 10 };

export class Converter {
  /** `input(side, number, nowNs)`: the voltage at an input. */
  constructor(machine, input) {
    Object.assign(this, { machine, input, registers: new Map(), results: [], asked: null, isThere: true, sweeps: 0 });
    machine.pin(CONVST).addListener(() => machine.isHigh(CONVST) && this.convert());
    machine.pin(RESET).addListener(() => machine.isHigh(RESET) || this.registers.clear());
    const spi = machine.chip.spi[0];
    let word = 0;
    const over = machine.clock.createAlarm(() => spi.completeTransmit(this.exchange(word)));
    spi.onTransmit = (value) => {
      word = value;
      over.schedule(WORD_NS);
    };
    this.next = machine.clock.createAlarm(() => this.pair());
    machine.pin(BUSY).setInputValue(false);
  }

  exchange(word) {
    if (!this.isThere) return 0xffff;
    const address = (word >> 9) & 0x3f;
    const answer = this.asked !== null ? (this.registers.get(this.asked) ?? 0) : address === 0 ? (this.results.shift() ?? 0) : 0;
    this.asked = null;
    if (word & 0x8000) this.registers.set(address, word & 0x1ff);
    else if (address !== 0) this.asked = address;
    return answer;
  }

  convert() {
    if (!this.isThere || !this.machine.isHigh(RESET)) return;
    const configuration = this.registers.get(2) ?? 0;
    const isSequence = (configuration & 0x60) === 0x60;
    this.pairs = [];
    for (let index = 0; index < 32; index++) {
      const layer = isSequence ? (this.registers.get(0x20 + index) ?? 0) : (this.registers.get(3) ?? 0);
      this.pairs.push([layer & 0xf, (layer >> 4) & 0xf]);
      if (!isSequence || layer & 0x100) break;
    }
    [this.results, this.converted] = [[], []];
    this.machine.pin(BUSY).setInputValue(true);
    this.pair();
  }

  pair() {
    if (this.converted.length === 2 * this.pairs.length) {
      this.results = this.converted;
      this.sweeps += 1;
      this.machine.pin(BUSY).setInputValue(false);
      return;
    }
    const [a, b] = this.pairs[this.converted.length / 2];
    this.converted.push(this.code('a', a), this.code('b', b));
    this.next.schedule(PAIR_NS);
  }

  code(side, number) {
    const register = (side === 'a' ? 4 : 6) + (number >> 2);
    const full = FULL[((this.registers.get(register) ?? 0xff) >> (2 * (number & 3))) & 3];
    // 90.5 dB below a full sine.
    const noise = (full / Math.SQRT2) * 10 ** (-90.5 / 20) * gaussian();
    const code = Math.round(((this.input(side, number, this.machine.clock.nanos) + noise) / full) * 32768);
    return Math.max(-32768, Math.min(32767, code)) & 0xffff;
  }
}

function gaussian() {
  return Math.sqrt(-2 * Math.log(1 - Math.random())) * Math.cos(2 * Math.PI * Math.random());
}

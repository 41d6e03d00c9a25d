// The AD7616 on the machine's first SPI: registers, ranges, sequencer and burst as its data sheet has them, one pair of inputs a microsecond.

const PAIR_NS = 1000;
const FULL = { 0: 10, 1: 2.5, 2: 5, 3: 10 };

export class Converter {
  /** At these pins, a word in so many ns; `input(side, number, nowNs)`: the voltage at an input. */
  constructor(machine, { convst, busy, reset, wordNs }, input) {
    Object.assign(this, { machine, busy, reset, input, registers: new Map(), results: [], asked: null, isThere: true, sweeps: 0 });
    machine.pin(convst).addListener(() => machine.isHigh(convst) && this.convert());
    machine.pin(reset).addListener(() => machine.isHigh(reset) || this.registers.clear());
    const spi = machine.chip.spi[0];
    let word = 0;
    const over = machine.clock.createAlarm(() => spi.completeTransmit(this.exchange(word)));
    spi.onTransmit = (value) => {
      word = value;
      over.schedule(wordNs);
    };
    this.next = machine.clock.createAlarm(() => this.pair());
    machine.pin(busy).setInputValue(false);
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
    if (!this.isThere || !this.machine.isHigh(this.reset)) return;
    const configuration = this.registers.get(2) ?? 0;
    const isSequence = (configuration & 0x60) === 0x60;
    this.pairs = [];
    for (let index = 0; index < 32; index++) {
      const layer = isSequence ? (this.registers.get(0x20 + index) ?? 0) : (this.registers.get(3) ?? 0);
      this.pairs.push([layer & 0xf, (layer >> 4) & 0xf]);
      if (!isSequence || layer & 0x100) break;
    }
    [this.results, this.converted] = [[], []];
    this.machine.pin(this.busy).setInputValue(true);
    this.pair();
  }

  pair() {
    if (this.converted.length === 2 * this.pairs.length) {
      this.results = this.converted;
      this.sweeps += 1;
      this.machine.pin(this.busy).setInputValue(false);
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

// Four wires at the outputs: resistance, taps, shunt, the supply by the enable pin, the converter's filter, and heat that shortens them.

const SHUNT_OHM = 0.5;
const SWITCH_OHM = 0.05;
const TAU_NS = 1e9 / (2 * Math.PI * 39000);
const AMBIENT_C = 22;
const HEAT_J_PER_K = 0.02;
const LOSS_W_PER_K = 0.012;

/** A wire of 0.125 mm × 160 mm: its cold and its hot end. */
const COLD = { length: 0.1667, ohm: 10.4 };
const HOT = { length: 0.1603, ohm: 11.9 };

export class Wires {
  constructor(machine, { gates, enable }, { supplyV = 6.5, tapsM = [0, 0.15] } = {}) {
    Object.assign(this, { machine, enable, supplyV, tapsM, heats: true });
    this.wires = gates.map((pin) => ({ pin, celsius: AMBIENT_C, isOn: false, since: 0, level: 0, onNs: 0, pulses: 0, isStuck: false, isOpen: false }));
    this.steppedNs = machine.clock.nanos;
    for (const wire of this.wires) machine.pin(wire.pin).addListener(() => this.switch(wire));
    machine.pin(enable).addListener(() => this.wires.forEach((wire) => this.switch(wire)));
  }

  /** Whatever gates and the master switch are now. */
  switch(wire) {
    const now = this.machine.clock.nanos;
    const gate = this.machine.isHigh(wire.pin);
    if (gate && !wire.gate) wire.gateSince = now;
    if (!gate && wire.gate) [wire.onNs, wire.pulses] = [wire.onNs + now - wire.gateSince, wire.pulses + 1];
    wire.gate = gate;
    const isOn = (gate || wire.isStuck) && this.machine.isHigh(this.enable);
    if (isOn === wire.isOn) return;
    this.heat(now);
    wire.level = this.levelOf(wire, now);
    [wire.isOn, wire.since] = [isOn, now];
  }

  /** What the filter has let through of the on-phase's voltages. */
  levelOf(wire, now) {
    const target = wire.isOn ? 1 : 0;
    return target + (wire.level - target) * Math.exp(-(now - wire.since) / TAU_NS);
  }

  ofWire(wire) {
    // Shortens between 70 and 90 °C.
    const share = Math.max(0, Math.min(1, (wire.celsius - 70) / 20));
    const length = COLD.length + share * (HOT.length - COLD.length);
    const ohm = COLD.ohm + share * (HOT.ohm - COLD.ohm);
    return { length, ohm, amperes: wire.isOpen ? 0 : this.supplyV / (ohm + SHUNT_OHM + SWITCH_OHM) };
  }

  heat(now) {
    const seconds = (now - this.steppedNs) * 1e-9;
    this.steppedNs = now;
    for (const wire of this.heats ? this.wires : []) {
      const { ohm, amperes } = this.ofWire(wire);
      const watts = wire.isOn ? amperes ** 2 * ohm : 0;
      const end = AMBIENT_C + watts / LOSS_W_PER_K;
      wire.celsius = end + (wire.celsius - end) * Math.exp((-seconds * LOSS_W_PER_K) / HEAT_J_PER_K);
    }
  }

  /** The voltage at an input of the converter: of wire k, A2k = V2, B2k = V3, A2k+1 = V1, B2k+1 = shunt. */
  input(side, number, now) {
    const wire = this.wires[number >> 1];
    const { length, ohm, amperes } = this.ofWire(wire);
    const at = amperes * this.levelOf(wire, now);
    const tap = (metres) => at * (SHUNT_OHM + (ohm * metres) / length);
    if (side === 'b') return number & 1 ? at * SHUNT_OHM : at * (SHUNT_OHM + ohm);
    return number & 1 ? tap(this.tapsM[0]) : tap(this.tapsM[0] + this.tapsM[1]);
  }
}

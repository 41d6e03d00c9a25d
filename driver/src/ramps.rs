//! Setpoints that are approached in a time.
//!
//! What is to be reached in a straight line is asked of the engine anew in every cycle, a step further each time. So the engine, what is
//! recorded of it, and a replay know of single setpoints only.
//!
//! A ramp goes on for as long as its channel does what the last step asked of it. Whatever else takes the channel over ends the ramp: another
//! command, the other wire of its joint, a fault, the end of its lease.

use sinew_ipc::MAX_CHANNELS;

use crate::engine::Engine;
use crate::orders::{Ask, Order};

/// The way of one channel.
#[derive(Debug, Clone, Copy)]
struct Ramp {
    /// What is asked for in the end.
    order: Order,
    /// Where it began: in the unit of what is asked.
    from: f64,
    begun_ns: u64,
    over_ns: u64,
    /// The end of the lease; steps do not prolong it.
    until_ns: u64,
    /// What the last step asked for.
    last: Ask,
}

impl Ramp {
    /// What is asked for at this time.
    fn at(&self, now_ns: u64) -> Ask {
        let share = now_ns.saturating_sub(self.begun_ns) as f64 / self.over_ns as f64;
        let between = |to: f64| if share < 1.0 { self.from + share * (to - self.from) } else { to };
        match self.order.ask {
            Ask::Length(to) => Ask::Length(between(to)),
            Ask::Force(to) => Ask::Force(between(to)),
            Ask::Duty(to) => Ask::Duty(between(to)),
            // not a way, but a change
            ask @ (Ask::Tension(_) | Ask::Off | Ask::Reset) => ask,
        }
    }

    /// Asks for the next step; whether there is one after it.
    fn step(&mut self, engine: &mut Engine, now_ns: u64) -> bool {
        if now_ns == self.begun_ns && engine.has_order(self.order.channel) {
            // The first one has just been asked for.
            return true;
        }
        if !engine.obeys(self.order.channel, self.last, self.until_ns) {
            return false;
        }
        self.last = self.at(now_ns);
        engine.take(&Order { ask: self.last, hold_ns: self.until_ns.saturating_sub(now_ns), ..self.order }, now_ns);
        now_ns.saturating_sub(self.begun_ns) < self.over_ns
    }
}

/// The ways of all channels.
#[derive(Debug)]
pub(crate) struct Ramps {
    ways: Box<[Option<Ramp>; MAX_CHANNELS]>,
    /// A bit for each channel that is on its way, so that a cycle without any looks at nothing else.
    under_way: u64,
}

const _: () = assert!(MAX_CHANNELS <= u64::BITS as usize);

impl Default for Ramps {
    fn default() -> Ramps {
        Ramps { ways: Box::new([None; MAX_CHANNELS]), under_way: 0 }
    }
}

impl Ramps {
    /// Begins the way to what these orders ask for, each for another channel; what they ask for becomes the first step. For the loop:
    /// constant time, no allocation.
    #[inline]
    pub fn begin(&mut self, orders: &mut [Order], over_ns: u64, engine: &Engine, now_ns: u64) {
        for order in orders {
            let Some(from) = engine.wanted_or_present(order.channel, order.ask).filter(|from| from.is_finite()) else {
                continue;
            };
            let until_ns = now_ns.saturating_add(order.hold_ns);
            let mut ramp = Ramp { order: *order, from, begun_ns: now_ns, over_ns, until_ns, last: order.ask };
            ramp.last = ramp.at(now_ns);
            order.ask = ramp.last;
            if let Some(way) = self.ways.get_mut(order.channel) {
                *way = Some(ramp);
                self.under_way |= 1 << order.channel;
            }
        }
    }

    /// A step of each, before a cycle at `now_ns`. For the loop: constant time, no allocation.
    #[inline]
    pub fn step(&mut self, engine: &mut Engine, now_ns: u64) {
        let mut left = self.under_way;
        while left != 0 {
            let channel = left.trailing_zeros() as usize;
            left &= left - 1;
            let goes_on = self.ways[channel].as_mut().is_some_and(|ramp| ramp.step(engine, now_ns));
            if !goes_on {
                self.under_way &= !(1 << channel);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::channel::Target;
    use crate::orders::Beat;
    use sinew_rig::Rig;
    use sinew_sensing::Sample;

    const PERIOD_NS: u64 = 10_000_000;
    /// Ten periods.
    const OVER_NS: u64 = 10 * PERIOD_NS;

    /// Two wires at rest whose sensors have proved themselves.
    struct Bench {
        ramps: Ramps,
        engine: Engine,
        /// What the last cycle decided on, and what was out in the period whose samples come now.
        duty: [f64; 2],
        out: [f64; 2],
        now_ns: u64,
    }

    impl Bench {
        fn ready() -> Bench {
            let wire = |name: &str| {
                format!(
                    "[[channel]]\nname = \"{name}\"\nwire = {{ diameter_mm = 0.125, length_mm = 160.0 }}\n\
                     taps = {{ l0_mm = 0.0, ls_mm = 150.0 }}\ndrive = {{ supply_v = 6.5, shunt_ohm = 0.1 }}\n\
                     load = {{ mass_kg = 0.1, spring_n_per_m = 150.0, preload_n = 2.4 }}\n"
                )
            };
            let text = ["[rig]\nname = \"bench\"\nrate_hz = 100.0\n".to_string(), wire("left"), wire("right")].concat();
            let rig = Rig::parse(&text, "bench.toml").unwrap_or_else(|e| panic!("{e}"));
            let engine = Engine::at_rest(&rig, None).unwrap();
            let mut bench = Bench { ramps: Ramps::default(), engine, duty: [0.0; 2], out: [0.0; 2], now_ns: 0 };
            (0..100).for_each(|_| _ = bench.cycle());
            let faults = [0, 1].map(|channel: usize| bench.engine.channels()[channel].guard.fault());
            assert_eq!(faults, [None; 2], "they are well");
            bench
        }

        /// One cycle, and what each channel is to do.
        fn cycle(&mut self) -> [Target; 2] {
            self.ramps.step(&mut self.engine, self.now_ns);
            let wire_ohm = 82e-8 * 0.16 / 1.2272e-8;
            // no converter gives the same twice
            let noise = 1.0 + 1e-3 * ((self.now_ns / PERIOD_NS * 7919) % 13) as f64 / 13.0;
            let current_a = 6.5 / (wire_ohm + 0.12) * noise;
            let v3_v = current_a * wire_ohm;
            let sample = Sample { v1_v: 0.0, v2_v: v3_v * 150.0 / 160.0, v3_v, current_a, supply_v: 6.5 };
            let beat = Beat { now_ns: self.now_ns, missed: 0 };
            // what is off shows nothing
            let samples = self.out.map(|duty| if duty > 0.0 { sample } else { Sample::NONE });
            self.out = self.duty;
            self.engine.cycle(beat, Ok(()), &samples, &mut self.duty, |_| {});
            self.now_ns += PERIOD_NS;
            [0, 1].map(|channel: usize| self.engine.channels()[channel].target)
        }

        fn duties(&mut self) -> [f64; 2] {
            self.cycle().map(|target| if let Target::Duty(duty) = target { duty } else { panic!("{target:?}") })
        }

        fn order(&self, channel: usize, ask: Ask, hold_ns: u64) -> Order {
            Order { ticket: self.now_ns, channel, ask, hold_ns }
        }

        fn begin(&mut self, asks: &[(usize, Ask)], hold_ns: u64) {
            let mut orders: Vec<Order> =
                asks.iter().map(|(channel, ask)| self.order(*channel, *ask, hold_ns)).collect();
            self.ramps.begin(&mut orders, OVER_NS, &self.engine, self.now_ns);
            self.engine.take_together(&orders, self.now_ns, |_, answer| assert_eq!(answer, crate::Answer::Done));
        }
    }

    #[test]
    fn a_setpoint_is_approached_in_equal_steps_and_then_holds_until_its_lease_ends() {
        let mut bench = Bench::ready();
        let [left_from, right_from] = [0, 1].map(|channel: usize| bench.engine.channels()[channel].duty);
        bench.begin(&[(0, Ask::Duty(0.5)), (1, Ask::Duty(0.1))], 2 * OVER_NS);
        for step in 0..20 {
            let [left, right] = bench.duties();
            let share = (f64::from(step) / 10.0).min(1.0);
            let (wanted_left, wanted_right) =
                (left_from + share * (0.5 - left_from), right_from + share * (0.1 - right_from));
            assert!(
                (left - wanted_left).abs() < 1e-12 && (right - wanted_right).abs() < 1e-12,
                "{step}: {left} {right}"
            );
        }
        assert_eq!(bench.cycle(), [Target::Idle; 2], "steps do not prolong the lease");
    }

    #[test]
    fn the_next_setpoint_is_approached_from_where_the_last_one_had_come_to() {
        let mut bench = Bench::ready();
        bench.engine.take(&bench.order(0, Ask::Duty(0.1), u64::MAX), bench.now_ns);
        bench.cycle();
        bench.begin(&[(0, Ask::Duty(0.3))], 3 * OVER_NS);
        (0..6).for_each(|_| _ = bench.cycle());
        // half of the way
        bench.begin(&[(0, Ask::Duty(0.0))], 3 * OVER_NS);
        let way: Vec<f64> =
            (0..=10).map(|_| if let Target::Duty(duty) = bench.cycle()[0] { duty } else { panic!("a duty") }).collect();
        for (step, duty) in way.iter().enumerate() {
            assert!((duty - 0.2 * (1.0 - step as f64 / 10.0)).abs() < 1e-12, "{way:?}");
        }
    }

    #[test]
    fn whatever_else_takes_the_channel_over_ends_the_ramp() {
        let mut bench = Bench::ready();
        bench.begin(&[(0, Ask::Duty(0.4)), (1, Ask::Duty(0.4))], 3 * OVER_NS);
        (0..2).for_each(|_| _ = bench.duties());
        bench.engine.take(&bench.order(0, Ask::Off, u64::MAX), bench.now_ns);
        bench.engine.take(&bench.order(1, Ask::Duty(0.01), u64::MAX), bench.now_ns);
        for step in 0..20 {
            assert_eq!(bench.cycle(), [Target::Idle, Target::Duty(0.01)], "at step {step}");
        }
        assert_eq!(bench.ramps.under_way, 0);
    }

    #[test]
    fn a_length_is_approached_from_where_the_wire_is() {
        let mut bench = Bench::ready();
        let present_m = bench.engine.wanted_or_present(0, Ask::Length(0.0)).unwrap();
        assert!((present_m - 0.16).abs() < 1e-3, "{present_m}");
        bench.begin(&[(0, Ask::Length(present_m - 0.002))], 3 * OVER_NS);
        for step in 0..=10 {
            let Target::Length(length_m) = bench.cycle()[0] else { panic!("a length") };
            assert!((length_m - (present_m - 0.0002 * f64::from(step))).abs() < 1e-9, "{step}: {length_m}");
        }
    }
}

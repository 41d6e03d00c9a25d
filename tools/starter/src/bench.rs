//! What lies on a bench, and the rig file of it.

use std::fmt::{self, Write as _};

use sinew_physics::formulas::STANDARD_GRAVITY_M_S2;
use sinew_rig::{WireKind, rounded};

/// Share of the wire's hot length that the fixed piece of the dual measurement takes: that of the built-in rig.
const FIXED_PIECE: f64 = 0.94;
/// Share of the largest pull that a spring of ours has at the hot end; the cold end has the sheet's stretch, 0.4 of it.
const HOT_SHARE: f64 = 0.6;
/// What a wire shortens by, of its length, where it is reckoned with.
const STROKE: f64 = 0.04;
/// What moves beside a spring, and what damps it: those of the built-in rig for each newton of its wire's pull, and for each of its lengths a second.
const MASS_KG_PER_N: f64 = 0.036;
const DAMPING_LENGTHS_PER_S: f64 = 2.2;
/// The supply heats with so many times the power of the sheet's current, so that the duty has something to regulate with.
const POWER_RESERVE: f64 = 2.5;
/// What is in series with the wire besides, Ω.
const SHUNT_OHM: f64 = 0.1;
const SWITCH_OHM: f64 = 0.02;

/// What a wire pulls against.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Against {
    /// A spring that is chosen for the wire.
    ChosenSpring,
    /// A spring of this stiffness, N/m, that pulls with the sheet's stretch when the wire is cold.
    Spring {
        /// N/m.
        stiffness_n_per_m: f64,
    },
    /// Something that hangs on it.
    Weight {
        /// Its weight, N.
        force_n: f64,
    },
}

/// A bench of equal wires.
#[derive(Debug, Clone, PartialEq)]
pub struct Bench {
    /// Name of the rig.
    pub name: String,
    /// Names of the wires.
    pub channels: Vec<String>,
    /// What they are.
    pub wire: &'static WireKind,
    /// How long they are when hot, m.
    pub length_m: f64,
    /// What each pulls against.
    pub against: Against,
    /// Voltage of the supply; `None`: one is chosen.
    pub supply_v: Option<f64>,
}

/// Something about a bench that its owner should know.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Doubt {
    /// It pulls more than the data sheet's pull, in N.
    TooHeavy {
        /// What it has to pull.
        asked_n: f64,
        /// What it should.
        most_n: f64,
    },
    /// What stretches it is less than half of the data sheet's, in N.
    TooLight {
        /// What stretches it.
        asked_n: f64,
        /// What should.
        least_n: f64,
    },
    /// The supply cannot give the current that shortens the wire in about a second, in A.
    TooWeak {
        /// What it gives.
        gives_a: f64,
        /// The sheet's.
        needs_a: f64,
    },
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Doubt::TooHeavy { asked_n, most_n } => write!(
                f,
                "the wire pulls up to {} N, its data sheet has {} N for a long life: it will wear out sooner; take a lighter load, a thicker wire or several",
                rounded(asked_n),
                rounded(most_n)
            ),
            Doubt::TooLight { asked_n, least_n } => write!(
                f,
                "only {} N stretch the wire again as it cools, its data sheet has {} N: it will not come back whole; add weight or a spring",
                rounded(asked_n),
                rounded(least_n)
            ),
            Doubt::TooWeak { gives_a, needs_a } => write!(
                f,
                "the supply drives {} A through the wire, its data sheet has {} A to shorten in about a second: it will be slow or stay cold; raise the voltage or take a shorter wire",
                rounded(gives_a),
                rounded(needs_a)
            ),
        }
    }
}

/// Mass, stiffness and the pull at the hot length of what a wire works against.
struct Load {
    mass_kg: f64,
    stiffness_n_per_m: f64,
    hot_n: f64,
    cold_n: f64,
}

impl Bench {
    /// A bench of one wire, as it is where nothing more is known.
    pub fn of(name: &str, wire: &'static WireKind) -> Bench {
        Bench {
            name: name.into(),
            channels: vec!["wire".into()],
            wire,
            length_m: 0.16,
            against: Against::ChosenSpring,
            supply_v: None,
        }
    }

    /// Resistance of one wire, cold, with what is in series, Ω.
    fn path_ohm(&self) -> f64 {
        self.wire.ohm_per_m * self.length_m + SHUNT_OHM + SWITCH_OHM
    }

    /// The supply, V.
    pub fn supply_v(&self) -> f64 {
        let chosen_v = POWER_RESERVE.sqrt() * self.wire.current_a * self.path_ohm();
        self.supply_v.unwrap_or((2.0 * chosen_v).ceil() / 2.0)
    }

    fn load(&self) -> Load {
        let stroke_m = STROKE * self.length_m;
        let sprung = |stiffness_n_per_m: f64| Load {
            mass_kg: MASS_KG_PER_N * self.wire.pull_n,
            stiffness_n_per_m,
            hot_n: self.wire.stretch_n + stiffness_n_per_m * stroke_m,
            cold_n: self.wire.stretch_n,
        };
        match self.against {
            Against::ChosenSpring => sprung((HOT_SHARE * self.wire.pull_n - self.wire.stretch_n) / stroke_m),
            Against::Spring { stiffness_n_per_m } => sprung(stiffness_n_per_m),
            Against::Weight { force_n } => {
                let mass_kg = force_n / STANDARD_GRAVITY_M_S2;
                Load { mass_kg, stiffness_n_per_m: 0.0, hot_n: force_n, cold_n: force_n }
            }
        }
    }

    /// What its owner should know of it.
    pub fn doubts(&self) -> Vec<Doubt> {
        let (load, wire) = (self.load(), self.wire);
        let gives_a = self.supply_v() / self.path_ohm();
        let mut doubts = Vec::new();
        if load.hot_n > wire.pull_n {
            doubts.push(Doubt::TooHeavy { asked_n: load.hot_n, most_n: wire.pull_n });
        }
        if load.cold_n < 0.5 * wire.stretch_n {
            doubts.push(Doubt::TooLight { asked_n: load.cold_n, least_n: wire.stretch_n });
        }
        if gives_a < wire.current_a {
            doubts.push(Doubt::TooWeak { gives_a, needs_a: wire.current_a });
        }
        doubts
    }

    /// The rig file.
    pub fn rig_file(&self) -> String {
        let Bench { name, wire, .. } = self;
        let (load, length_mm) = (self.load(), self.length_m * 1e3);
        let damping = DAMPING_LENGTHS_PER_S * wire.pull_n / self.length_m;
        let mut text = format!(
            "# {name}: {count} of {product}, {diameter:.3} mm thick.\n\
             # `sinew check {name}.toml` reads this file, `sinew run {name}.toml` runs it; every key is in docs/rig.md.\n\n\
             [rig]\n\
             name = \"{name}\"\n\
             rate_hz = 1000.0           # measured and switched so many times a second\n\
             ambient_c = 25.0           # the air around the wires\n\
             program = \"steps\"          # what they do while nobody commands them; \"none\": nothing\n",
            count = if self.channels.len() == 1 { "a wire".into() } else { format!("{} wires", self.channels.len()) },
            product = wire.product,
            diameter = wire.diameter_m * 1e3,
        );
        for channel in &self.channels {
            let _ = write!(
                text,
                "\n[[channel]]\n\
                 name = \"{channel}\"\n\
                 # from its data sheet; what you measure goes before it, such as diameter_mm here, or in material = {{ … }}\n\
                 wire = {{ kind = \"{kind}\", length_mm = {length} }} # hot and unloaded\n\
                 # the dual measurement: two taps so far apart, the sliding end has the rest to travel. Leave it out where there are none\n\
                 taps = {{ l0_mm = 0.0, ls_mm = {fixed_piece} }}\n\
                 # {ohm} ohms when cold; the sheet has {current} A to shorten in about a second\n\
                 drive = {{ supply_v = {supply}, shunt_ohm = {SHUNT_OHM}, switch_ohm = {SWITCH_OHM} }}\n\
                 # {against}; {cold} N when cold, {hot} N when hot, where the sheet has at most {pull}\n\
                 load = {{ mass_kg = {mass}, damping_n_s_per_m = {damping}, spring_n_per_m = {spring}, preload_n = {hot} }}\n",
                kind = wire.name,
                length = rounded(length_mm),
                fixed_piece = rounded(FIXED_PIECE * length_mm),
                ohm = rounded(wire.ohm_per_m * self.length_m),
                current = rounded(wire.current_a),
                supply = rounded(self.supply_v()),
                against = match self.against {
                    Against::Weight { .. } => "what hangs on it",
                    _ => "what moves, and the spring that stretches it again as it cools",
                },
                cold = rounded(load.cold_n),
                hot = rounded(load.hot_n),
                pull = rounded(wire.pull_n),
                mass = rounded(load.mass_kg),
                damping = rounded(damping),
                spring = rounded(load.stiffness_n_per_m),
            );
        }
        text.push_str(
            "\n# Until there is hardware, a simulation stands in for it. Then: kind = \"serial\" (docs/front-end.md) or \"linux\" (docs/linux-backend.md)\n\
             [backend]\nkind = \"simulated\"\n",
        );
        text
    }
}

//! What a rig file may well mean, and hardly does: loads that wear a wire out, supplies that its sensing pulse alone heats it with.

use sinew_physics::Load;
use sinew_physics::formulas::LASTING_STRESS_PA;

use crate::derive::{self, Reach};
use crate::drivable::line_of;
use crate::tables::{Channel, Rig};

/// What wires are loaded with for a life of 10⁵ cycles, Pa (thesis, table 3, eq. 2); data sheets recommend 172 MPa.
pub const LASTING_PULL_PA: f64 = LASTING_STRESS_PA;
/// Recommended is not allowed: a wire that pulls half as much again at the end of its stroke lives shorter, and is built. Only
/// what is beyond that is worth a word.
pub(crate) const WORTH_A_WORD: f64 = 1.5;

/// A number that is allowed, and probably not meant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Doubt {
    /// Line of the rig file.
    pub line: usize,
    /// The channel.
    pub channel: String,
    /// Dotted key within the channel.
    pub key: &'static str,
    /// What follows from it, and what to do.
    pub says: String,
}

impl Rig {
    /// What is allowed and hardly meant, by channel: everything of it can be simulated, and driven where
    /// [`Rig::check_drivable`] says so.
    pub fn doubts(&self) -> Vec<Doubt> {
        let of = |(index, channel): (usize, &Channel)| {
            let reach = Reach::of(channel, self.joint_of(index).map(|(joint, _)| joint));
            let says = [
                pulls_too_much(channel, &reach),
                goes_slack(channel, &reach),
                senses_too_hot(channel, &reach),
                stays_cold(channel, &reach),
            ];
            let doubt = |(key, says)| {
                let line = line_of(&self.source, Some(index), key);
                Doubt { line, channel: channel.name.clone(), key, says }
            };
            says.into_iter().flatten().map(doubt).collect::<Vec<_>>()
        };
        self.channels.iter().enumerate().flat_map(of).collect()
    }
}

/// What a wire may pull for a long life by its sheet, or by its diameter, N.
pub(crate) fn lasting_pull_n(channel: &Channel) -> f64 {
    channel.wire_kind.map_or(LASTING_PULL_PA * channel.model.geometry.area_m2(), |kind| kind.pull_n)
}

/// The load pulls more than the wire's sheet recommends, or than wires last under.
fn pulls_too_much(channel: &Channel, reach: &Reach) -> Option<(&'static str, String)> {
    let Load::SpringMassDamper { spring_n_per_m, .. } = channel.model.load else { return None };
    let most_n = lasting_pull_n(channel);
    let by = match channel.wire_kind {
        Some(kind) => format!("the sheet of {} recommends", kind.name),
        None => "a wire of this diameter lasts under".into(),
    };
    let pull_n = reach.largest_pull_n();
    let says = || {
        format!(
            "the load pulls {} N, {:.1} times the {} N that {by}: it will stretch and tire soon; take a thicker wire, several side by side, \
             or less of a load",
            short(pull_n),
            pull_n / most_n,
            short(most_n)
        )
    };
    let key = if spring_n_per_m > 0.0 { "load.spring_n_per_m" } else { "load.mass_kg" };
    (pull_n > WORTH_A_WORD * most_n).then(|| (key, says()))
}

/// The spring is relaxed before the cold wire is as long as its martensite goes: from there on it hangs, and does not move what it should.
fn goes_slack(channel: &Channel, reach: &Reach) -> Option<(&'static str, String)> {
    let Load::SpringMassDamper { spring_n_per_m, preload_n, .. } = channel.model.load else { return None };
    let needed_n = spring_n_per_m * reach.stretched_m();
    (spring_n_per_m > 0.0 && reach.cold_pull_n() == 0.0).then(|| {
        let says = format!(
            "the spring pulls with {} N where the wire is short and loses {} N until the cold wire is as long as it gets: it relaxes before, and the \
             wire hangs slack; take a preload of {} N or more, or a softer spring",
            short(preload_n),
            short(needed_n),
            // a third more than what just stretches it
            short(4.0 / 3.0 * needed_n)
        );
        ("load.preload_n", says)
    })
}

/// The sensing pulse alone holds the wire where it has not become martensite yet: it never lengthens.
fn senses_too_hot(channel: &Channel, reach: &Reach) -> Option<(&'static str, String)> {
    let on = derive::full_on(channel, channel.limits.max_temperature_c)?;
    let sensing_w = channel.control.minimum_duty * on.largest_power_w;
    let held_w = reach.relaxed_w();
    let supply_v = channel.model.drive.supply_v;
    (sensing_w > held_w).then(|| {
        let says = format!(
            "the sensing pulse alone, {} W at duty {}, holds this wire above the {:.0} °C at which half of it has lengthened again: take at \
             most {} V, a longer wire, or several in series",
            short(sensing_w),
            short(channel.control.minimum_duty),
            reach.relaxed_c(),
            // power goes with the square of the voltage; half of what just does
            short(supply_v * (0.5 * held_w / sensing_w).sqrt())
        );
        ("drive.supply_v", says)
    })
}

/// Full duty does not heat the wire to where it shortens.
fn stays_cold(channel: &Channel, reach: &Reach) -> Option<(&'static str, String)> {
    let on = derive::full_on(channel, channel.limits.max_temperature_c)?;
    let most_w = channel.limits.max_duty * on.largest_power_w;
    let needed_w = reach.shortens_w();
    (most_w < needed_w).then(|| {
        let says = format!(
            "full power, {} W, does not heat this wire to the {:.0} °C at which half of it has shortened, which takes {} W: take {} V \
             or more, or several wires in parallel",
            short(most_w),
            reach.shortened_c(),
            short(needed_w),
            short(channel.model.drive.supply_v * (1.5 * needed_w / most_w).sqrt())
        );
        ("drive.supply_v", says)
    })
}

/// Two digits: more would be more than is known.
fn short(number: f64) -> f64 {
    format!("{number:.1e}").parse().unwrap_or(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Vec<(&'static str, usize)> {
        let rig = Rig::parse(text, "bench.toml").expect("a rig file");
        rig.doubts().into_iter().map(|doubt| (doubt.key, doubt.line)).collect()
    }

    fn wire(supply_v: f64, mass_kg: f64) -> String {
        format!(
            "[rig]\nname = \"bench\"\n\n[[channel]]\nname = \"wire\"\nwire = {{ kind = \"flexinol-150-lt\", length_mm = 160.0 }}\n\
             drive = {{ supply_v = {supply_v:?} }}\nload = {{ mass_kg = {mass_kg:?} }}\n"
        )
    }

    #[test]
    fn an_ordinary_rig_leaves_no_doubt() {
        assert!(Rig::hexapod().doubts().is_empty(), "{:?}", Rig::hexapod().doubts());
        // the pull that the sheet recommends, and from its current to six times that heat
        for supply_v in [3.6, 6.0, 9.0] {
            assert!(of(&wire(supply_v, 0.321)).is_empty());
        }
    }

    #[test]
    fn a_load_and_a_supply_for_another_wire_are_doubted_on_their_lines() {
        assert_eq!(of(&wire(7.0, 5.0)), [("load.mass_kg", 8)]);
        assert_eq!(of(&wire(80.0, 0.3)), [("drive.supply_v", 7)]);
        assert_eq!(of(&wire(0.5, 0.3)), [("drive.supply_v", 7)]);
    }

    #[test]
    fn a_spring_that_relaxes_before_the_wire_is_long_is_doubted_and_its_remedy_is_one() {
        let rig = |preload_n: f64| {
            let load = format!("load = {{ mass_kg = 0.05, spring_n_per_m = 100.0, preload_n = {preload_n:?} }}");
            wire(6.0, 0.3).replace("load = { mass_kg = 0.3 }", &load)
        };
        let doubts = Rig::parse(&rig(0.5), "bench.toml").expect("a rig file").doubts();
        let [doubt] = doubts.as_slice() else { panic!("{doubts:?}") };
        assert_eq!((doubt.key, doubt.line), ("load.preload_n", 8));
        let (_, after) = doubt.says.split_once("a preload of ").expect("one is advised");
        let advised: f64 = after.split(' ').next().and_then(|word| word.parse().ok()).expect("a number");
        assert_eq!(of(&rig(advised)), [], "{}", doubt.says);
    }

    /// The remedy that is named is one.
    #[test]
    fn the_supply_that_is_advised_is_not_doubted() {
        for supply_v in [0.5, 24.0, 80.0] {
            let rig = Rig::parse(&wire(supply_v, 0.3), "bench.toml").expect("a rig file");
            let says = rig.doubts().swap_remove(0).says;
            let (before, _) = says.rsplit_once(" V").expect("a voltage is advised");
            let advised: f64 = before.rsplit(' ').next().and_then(|word| word.parse().ok()).expect("a number");
            assert!(of(&wire(advised, 0.3)).is_empty(), "{says}");
        }
    }
}

//! The tables of the rig file, a module each: what a table is read into, its keys, and what these need of each other. No
//! table knows another; what one needs of others is in [`crate::complete`].
//!
//! - Another key is a row in its table's file: parser, writer, checks, error messages and `docs/rig.md` follow from it.
//! - Another table is a file here, a field of [`Rig`] or [`Channel`] and a line in one of the two lists below.
//! - Another backend is a file in `backend/` and a row of [`backend`]; another law or estimator is a row of [`control`].

mod access;
mod adc;
pub(crate) mod backend;
mod black_box;
pub(crate) mod channel;
mod control;
mod demonstrator;
mod drive;
mod initial;
pub(crate) mod joint;
mod limits;
mod load;
mod machine;
mod material;
pub(crate) mod recording;
pub(crate) mod rig;
pub(crate) mod sensors;
pub(crate) mod simulation;
mod taps;
mod wire;

// What a table is read into is for everybody; its keys and its reading are the crate's own.
pub use access::*;
pub use adc::*;
pub use backend::*;
pub use black_box::*;
pub use channel::*;
pub use control::*;
pub use demonstrator::*;
pub use joint::*;
pub use limits::*;
pub use machine::*;
pub use recording::*;
pub use rig::*;
pub use sensors::*;
pub use simulation::*;

use std::slice;
use std::sync::LazyLock;

use crate::declare::part;
use crate::key::{Key, Section};

/// What a rig file is made of, by the names that stand in it without a dot.
pub(crate) const TOP: [&str; 10] =
    ["rig", "access", "channel", "joint", "recording", "backend", "black_box", "simulation", "demonstrator", "machine"];

/// Tables of the rig that are more than a plain list of keys and stand in one that is.
pub(crate) const OTHER_TABLES: [&str; 1] = ["simulation.fault"];

/// `[rig]` itself.
pub(crate) static RIG: LazyLock<Section<Rig>> = LazyLock::new(rig::section);

/// `[[joint]]`.
pub(crate) static JOINT: LazyLock<Section<Joint>> = LazyLock::new(joint::section);

static OF_RIG: LazyLock<Vec<Section<Rig>>> = LazyLock::new(|| {
    let mut tables = vec![part!(access::section(), Rig.access)];
    tables.extend(backend::of_rig().into_iter().map(|table| part!(table, Rig.backend)));
    tables.extend([
        part!(black_box::section(), Rig.black_box),
        part!(simulation::section(), Rig.simulation),
        part!(demonstrator::section(), Rig.demonstrator),
        part!(machine::section(), Rig.machine),
    ]);
    tables
});

static OF_CHANNEL: LazyLock<Vec<Section<Channel>>> = LazyLock::new(|| {
    let mut tables = vec![
        channel::section(),
        wire::section(),
        part!(taps::section(), Channel.model),
        part!(drive::section(), Channel.model),
        part!(load::section(), Channel.model),
        part!(sensors::sensors(), Channel.position_zero),
        part!(sensors::noise(), Channel.noise),
        part!(initial::section(), Channel.model),
        part!(material::section(), Channel.model),
        part!(adc::section(), Channel.adc),
    ];
    tables.extend(backend::of_channel().into_iter().map(|table| part!(table, Channel.backend)));
    tables.extend([part!(limits::section(), Channel.limits), part!(control::section(), Channel.control)]);
    tables
});

/// The plain tables of the rig as a whole, but for `[rig]` itself, in the order of the reference.
pub(crate) fn of_rig() -> slice::Iter<'static, Section<Rig>> {
    OF_RIG.iter()
}

/// The plain tables of a channel, in the order of the reference.
pub(crate) fn of_channel() -> slice::Iter<'static, Section<Channel>> {
    OF_CHANNEL.iter()
}

/// A key of a channel, by its table's header.
pub(crate) fn key_of_channel(table: &str, key: &str) -> Option<&'static Key<Channel>> {
    of_channel().find(|of| of.table == table)?.key(key)
}

/// Every table in which a key of this name lives, as in its header; not the noise of a column of that name.
pub(crate) fn tables_with(name: &str) -> Vec<&'static str> {
    let of_rig = [&*RIG].into_iter().chain(of_rig()).filter(|s| s.key(name).is_some()).map(|s| s.table);
    let of_channel = of_channel().filter(|s| s.table != sensors::NOISE && s.key(name).is_some());
    let of_joint = JOINT.key(name).map(|_| JOINT.table);
    of_rig.chain(of_channel.map(|s| s.table)).chain(of_joint).collect()
}

#[cfg(test)]
mod tests {
    use sinew_physics::{Amplifier, DriveKind, Kinetics};

    use super::*;
    use crate::key::{Default, Kind, Value};

    #[test]
    fn defaults_of_the_alloy_are_those_of_the_physics() {
        let rig = crate::Rig::hexapod();
        assert_eq!(rig.channels[0].model.material, sinew_physics::Material::default());
    }

    #[test]
    fn every_table_starts_with_what_selects_its_kind() {
        for table in of_channel() {
            let place = table.keys().position(|k| k.name == "kind");
            assert!(place.is_none_or(|p| p == 0), "{}", table.table);
        }
    }

    #[test]
    fn defaults_are_within_their_ranges() {
        fn check<T: 'static>(table: &Section<T>) {
            for key in table.keys() {
                match (&key.default, &key.takes) {
                    (Default::Number(n), Kind::Number { low, high, .. }) => {
                        assert!((low..=high).contains(&n), "{}", key.name);
                    }
                    (Default::Integer(i), Kind::Integer { low, high, .. }) => {
                        assert!((low..=high).contains(&i), "{}", key.name);
                    }
                    (Default::Text(t), Kind::Choice(words)) => assert!(words.contains(t), "{}", key.name),
                    (Default::Text(t), Kind::Text { longest, .. }) => assert!(t.len() <= *longest, "{}", key.name),
                    (Default::Boolean(_), Kind::Boolean) | (Default::Required(_) | Default::Computed(_), _) => {}
                    _ => panic!("{}: the default is of another kind than the key", key.name),
                }
            }
        }
        check(&RIG);
        of_rig().for_each(check);
        check(&JOINT);
        of_channel().for_each(check);
    }

    #[test]
    fn every_choice_can_be_set_and_read() {
        let mut channel = crate::Rig::hexapod().channels.swap_remove(0);
        for key in of_channel().flat_map(Section::keys) {
            if let Kind::Choice(words) = key.takes {
                for word in words {
                    key.set(&mut channel, Value::Text((*word).into()));
                    assert_eq!(key.get(&channel), Some(Value::Text((*word).into())), "{}", key.name);
                }
            }
        }
    }

    #[test]
    fn ranges_are_those_of_the_physics() {
        // Keys whose range depends on another key are left to the physics alone.
        let apart = ["l0_mm", "ls_mm", "martensite_temperature_c", "detwinning_start_mpa", "detwinning_finish_mpa"];
        for parameter in crate::parameters().filter(|p| !apart.contains(&p.key)) {
            for bound in [parameter.low, parameter.high] {
                let mut rig = crate::Rig::hexapod();
                rig.channels[0].model.taps = None;
                rig.channels[0].model.material.kinetics = Kinetics::Richards { heating_skew: 1.0, cooling_skew: 1.0 };
                let amplifier = Amplifier { full_current_a: 0.5, filter_hz: 40.0 };
                rig.channels[0].model.drive.kind = DriveKind::Amplifier(amplifier);
                rig.channels[0].model.material.martensite_temperature_c = -200.0;
                // A hair inside: the way to SI and back may end a last digit outside.
                let inside =
                    if bound == parameter.low { bound + 1e-12 * bound.abs() } else { bound - 1e-12 * bound.abs() };
                rig.set_parameter(0, parameter.key, inside).unwrap();
                let found = rig.channels[0].model.validate();
                assert_eq!(found, Ok(()), "{} at its bound {bound}", parameter.key);

                let outside = if bound == parameter.low { bound - 1e-7 } else { bound + 1e-3 * bound.abs().max(1.0) };
                assert!(rig.set_parameter(0, parameter.key, outside).is_err());
                let mut model = rig.channels[0].model.clone();
                for key in of_channel().flat_map(Section::keys).filter(|k| k.name == parameter.key) {
                    if let Kind::Number { unit, .. } = key.takes {
                        key.set(&mut rig.channels[0], Value::Number(unit.to_si(outside)));
                        model = rig.channels[0].model.clone();
                    }
                }
                if parameter.key == "ambient_c" {
                    model.ambient_c = outside;
                }
                match model.validate() {
                    Err(sinew_physics::Error::OutOfRange { key, low, high, .. }) => {
                        assert_eq!((key, low, high), (parameter.key, parameter.low, parameter.high));
                    }
                    Ok(()) => panic!("the physics takes {} = {outside}", parameter.key),
                }
            }
        }
    }
}

//! The macros that tables of the rig file are written with, and how a field of the rig holds a key's value.
//!
//! A row says everything about a key. Its doc comment says what it is, on the field and in `docs/rig.md` alike:
//!
//! ```text
//! /// How far the cross-head travels.
//! travel_m: f64 = "travel_mm", number(milli("mm"), 1.0, 2000.0), Number(250.0);
//! ```
//!
//! The field (in SI) and its type, the key, what it takes and its default (both in the key's unit). `, only …` follows
//! where it means something only beside certain others, `, prior …` where a fit moves it without being asked.

use crate::key::{Default, Kind, Value};

/// What a key's value can be kept in.
pub(crate) trait Field: Sized {
    /// Before anything is read. Numbers that only the file or a computed default can give are NaN.
    const UNREAD: Self;

    /// Its value, where there is one.
    fn value(&self) -> Option<Value>;

    /// Sets it to a value that was checked.
    fn assign(&mut self, value: Value);
}

macro_rules! field {
    ($type:ty, $unread:expr, $kind:ident, |$of:ident| $value:expr, |$new:ident| $field:expr) => {
        impl Field for $type {
            const UNREAD: Self = $unread;

            fn value(&self) -> Option<Value> {
                let $of = self;
                Some(Value::$kind($value))
            }

            fn assign(&mut self, value: Value) {
                if let Value::$kind($new) = value {
                    *self = $field;
                }
            }
        }
    };
}

field!(f64, f64::NAN, Number, |n| *n, |n| n);
field!(bool, false, Boolean, |on| *on, |on| on);
field!(String, String::new(), Text, |text| text.clone(), |text| text);
field!(u32, 0, Integer, |i| (*i).into(), |i| i as u32);
field!(u64, 0, Integer, |i| i64::try_from(*i).unwrap_or(i64::MAX), |i| i as u64);

impl<F: Field> Field for Option<F> {
    const UNREAD: Self = None;

    fn value(&self) -> Option<Value> {
        self.as_ref().and_then(F::value)
    }

    fn assign(&mut self, value: Value) {
        self.insert(F::UNREAD).assign(value);
    }
}

/// A choice of words.
pub(crate) trait Words: Copy + PartialEq + 'static {
    /// Every choice with its word in the rig file.
    const CHOICES: &'static [(&'static str, Self)];
    /// What a key takes that is such a choice.
    const KIND: Kind;
    /// The one where nothing is said.
    const USUAL: Self;
    /// That one as the default of a key.
    const DEFAULT: Default;
}

impl<W: Words> Field for W {
    const UNREAD: W = W::USUAL;

    fn value(&self) -> Option<Value> {
        W::CHOICES.iter().find(|(_, choice)| choice == self).map(|(word, _)| Value::Text((*word).into()))
    }

    fn assign(&mut self, value: Value) {
        let Value::Text(text) = value else { return };
        if let Some((_, choice)) = W::CHOICES.iter().find(|(word, _)| *word == text) {
            *self = *choice;
        }
    }
}

/// The words of a choice that another crate defines, and which is meant where nothing is said.
macro_rules! key_words {
    ($name:ty, default $usual:ident = $default:expr; { $( $variant:ident = $word:literal, )+ }) => {
        impl $crate::declare::Words for $name {
            const CHOICES: &'static [(&'static str, Self)] = &[$(($word, <$name>::$variant)),+];
            const KIND: $crate::key::Kind = $crate::key::Kind::Choice(&[$($word),+]);
            const USUAL: Self = <$name>::$usual;
            const DEFAULT: $crate::key::Default = $crate::key::Default::Text($default);
        }
    };
}

/// A choice with its words, and which is meant where nothing is said.
macro_rules! words {
    (
        $(#[$attribute:meta])*
        pub enum $name:ident, default $usual:ident {
            $( $(#[doc = $doc:literal])+ $variant:ident = $word:literal, )+
        }
    ) => {
        $(#[$attribute])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum $name {
            $( $(#[doc = $doc])+ $variant, )+
        }

        impl $name {
            /// Every one of them with its word in the rig file.
            pub const ALL: [(&'static str, $name); [$($word),+].len()] = [$(($word, $name::$variant)),+];

            /// Its word in the rig file.
            pub const fn word(self) -> &'static str {
                match self {
                    $( $name::$variant => $word, )+
                }
            }
        }

        $crate::declare::key_words!($name, default $usual = $name::$usual.word(); { $( $variant = $word, )+ });
    };
}

/// A key's place: a path of fields from what its table is read into, such as `at(geometry.length_m)`.
macro_rules! at {
    ($($field:ident).+) => {
        $crate::key::Accessor::new(
            |of| $crate::declare::Field::value(&of.$($field).+),
            |of, value| $crate::declare::Field::assign(&mut of.$($field).+, value),
        )
    };
}

/// The place of a key that is all there is in its table: `itself()`.
macro_rules! itself {
    () => {
        $crate::key::Accessor::new($crate::declare::Field::value, $crate::declare::Field::assign)
    };
}

/// Keys that live in fields declared elsewhere: `"key" = place, what it takes, its default;`. The place is
/// `at(path.of.fields)`, or any other macro that makes an [`Accessor`](crate::key::Accessor). A number of the model may have
/// its `prior`.
macro_rules! keys {
    (
        $of:ty;
        $(
            $(#[doc = $doc:literal])+
            $key:literal = $place:ident($($where:tt)*), $takes:expr, $default:expr
                $(, only $only:expr)? $(, prior $prior:expr)?;
        )+
    ) => {
        vec![$(
            $crate::key::Key::<$of> {
                name: $key,
                takes: $takes,
                default: $default,
                doc: concat!($($doc),+),
                access: $place!($($where)*),
                only: None$(.or(Some($only)))?,
                prior: [$(Some($prior),)? None][0],
            }
        ),+]
    };
}

/// A table whose keys are the fields of a struct of its own: declares both. `check` finds what else there is to be found
/// wrong with it.
macro_rules! table {
    (
        $table:literal $(, check $check:ident)?: $about:literal;

        $(#[$attribute:meta])*
        pub struct $name:ident {
            $(
                $(#[doc = $doc:literal])+
                $field:ident: $type:ty = $key:literal, $takes:expr, $default:expr $(, only $only:expr)?;
            )+
        }
    ) => {
        $(#[$attribute])*
        pub struct $name {
            $(
                $(#[doc = $doc])+
                #[doc = ""]
                #[doc = concat!("`", $key, "` in `[", $table, "]`.")]
                pub $field: $type,
            )+
        }

        impl $crate::declare::Unread for $name {
            const UNREAD: Self = $name { $( $field: <$type as $crate::declare::Field>::UNREAD, )+ };
        }

        /// The table.
        pub(crate) fn section() -> $crate::key::Section<$name> {
            $crate::key::Section {
                table: $table,
                about: $about,
                optional: false,
                keys: $crate::declare::keys! {
                    $name;
                    $( $(#[doc = $doc])+ $key = at($field), $takes, $default $(, only $only)?; )+
                },
                check: None$(.or(Some(Box::new($check) as $crate::key::Check<$name>)))?,
            }
        }
    };
}

/// A table whose keys live in a part of something, as one of the whole: `part!(adc::section(), Channel.adc)`.
macro_rules! part {
    ($section:expr, $whole:ident.$field:ident) => {
        $section.of(|whole: &$whole| &whole.$field, |whole: &mut $whole| &mut whole.$field)
    };
}

/// A struct of which nothing is read yet.
pub(crate) trait Unread {
    /// Every field as [`Field::UNREAD`].
    const UNREAD: Self;
}

pub(crate) use {at, itself, key_words, keys, part, table, words};

/// What the rows of a table are written with.
pub(crate) mod rows {
    pub(crate) use crate::key::Default::{Boolean, Computed, Integer, Number, Required, Text};
    pub(crate) use crate::key::Prior::{Absolute, Relative};
    pub(crate) use crate::key::{Accessor, Kind, Only, Section, Unit, Value};

    pub(crate) use super::{Field, Unread, Words, at, itself, key_words, keys, table, words};

    /// A unit that is SI's own, or kept as it is.
    pub(crate) const fn si(name: &'static str) -> Unit {
        Unit::new(name, 1.0, 1.0)
    }

    /// A thousandth of SI's; so the others, each by its name.
    pub(crate) const fn milli(name: &'static str) -> Unit {
        Unit::new(name, 1.0, 1e3)
    }

    pub(crate) const fn micro(name: &'static str) -> Unit {
        Unit::new(name, 1.0, 1e6)
    }

    pub(crate) const fn kilo(name: &'static str) -> Unit {
        Unit::new(name, 1e3, 1.0)
    }

    pub(crate) const fn mega(name: &'static str) -> Unit {
        Unit::new(name, 1e6, 1.0)
    }

    pub(crate) const fn giga(name: &'static str) -> Unit {
        Unit::new(name, 1e9, 1.0)
    }

    /// Of resistivities: 1 µΩ cm = 1e-8 Ω m.
    pub(crate) const fn uohm_cm(name: &'static str) -> Unit {
        Unit::new(name, 1.0, 1e8)
    }

    pub(crate) const BOOLEAN: Kind = Kind::Boolean;

    pub(crate) const fn number(unit: Unit, low: f64, high: f64) -> Kind {
        Kind::Number { unit, low, high }
    }

    pub(crate) const fn integer(low: i64, high: i64) -> Kind {
        Kind::Integer { low, high, times: 1 }
    }

    pub(crate) const fn name(longest: usize) -> Kind {
        Kind::Name { longest }
    }

    pub(crate) const fn text(what: &'static str, longest: usize) -> Kind {
        Kind::Text { what, longest }
    }
}

#[cfg(test)]
mod tests {
    use super::rows::*;

    #[test]
    fn units_convert_there_and_back() {
        assert_eq!(milli("mm").to_si(160.0), 0.16);
        assert_eq!(uohm_cm("µΩ cm").to_si(86.5), 86.5e-8);
        for unit in [si, milli, giga, mega, micro, uohm_cm, kilo].map(|of| of("")) {
            for n in [0.0, 0.1, 0.125, 1.0 / 3.0, 1.96133, 86.5, 160.0, 24_200.0, -0.05, 1e-200, 1e200] {
                assert_eq!(unit.to_file(unit.to_si(n)), n, "{unit:?} {n}");
            }
        }
    }
}

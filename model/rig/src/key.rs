//! What a key of the rig file is: its name, what it takes, its default, its meaning, and where it lives in the rig.
//!
//! The tables themselves stand in [`crate::tables`], a file each, written with the macros of [`crate::declare`]. The
//! reader, the writer, the fits' parameters and the reference in `docs/rig.md` (a test compares them) go through them
//! by what is said here and know no key of their own, so that none of the four can say something else.

use std::fmt::Display;
use std::slice;
use std::sync::Arc;

use crate::notes::{Reader, Stated};

/// A table of the rig file whose keys live in `T`: the rig, a channel, a joint or a part of one.
pub(crate) struct Section<T> {
    /// As in the header, such as `channel.wire`.
    pub table: &'static str,
    /// What it is for.
    pub about: &'static str,
    /// Where the table is left out, its defaults do not apply either.
    pub optional: bool,
    pub keys: Vec<Key<T>>,
    /// What its keys need of each other, once they are read.
    pub check: Option<Check<T>>,
}

/// Finds what keys of a table need of each other, in what was read.
pub(crate) type Check<T> = Box<dyn Fn(&mut Reader<'_>, &T, &Stated<'_>) + Send + Sync>;

impl<T: 'static> Section<T> {
    /// Its keys in the order of the reference.
    pub fn keys(&self) -> slice::Iter<'_, Key<T>> {
        self.keys.iter()
    }

    /// The key of this name.
    pub fn key(&self, name: &str) -> Option<&Key<T>> {
        self.keys().find(|key| key.name == name)
    }

    /// The table without the `channel.` before it; empty for the channel itself.
    pub fn local(&self) -> &'static str {
        local(self.table)
    }

    /// The same table as one of the whole that its `T` is a part of.
    pub fn of<W: 'static>(self, part: fn(&W) -> &T, part_mut: fn(&mut W) -> &mut T) -> Section<W> {
        let Section { table, about, optional, keys, check } = self;
        let keys = keys.into_iter().map(|key| key.of(part, part_mut)).collect();
        let check = check
            .map(|check| -> Check<W> { Box::new(move |reader, whole, stated| check(reader, part(whole), stated)) });
        Section { table, about, optional, keys, check }
    }
}

/// A channel's table without the `channel.` before it; empty for the channel itself.
pub(crate) fn local(table: &'static str) -> &'static str {
    table.strip_prefix("channel").map_or(table, |t| t.strip_prefix('.').unwrap_or(t))
}

/// One key.
pub(crate) struct Key<T> {
    pub name: &'static str,
    pub takes: Kind,
    pub default: Default,
    /// What it is, as its doc comment says it.
    pub doc: &'static str,
    pub access: Accessor<T>,
    /// Where it means something only beside certain others.
    pub only: Option<Only<T>>,
    /// How sure one is of it beforehand, where a fit moves it without being asked.
    pub prior: Option<Prior>,
}

/// The way from a rig, a channel, a joint or a part of one to a value and back, in SI.
pub(crate) struct Accessor<T> {
    get: Box<Get<T>>,
    set: Box<Set<T>>,
}

type Get<T> = dyn Fn(&T) -> Option<Value> + Send + Sync;
type Set<T> = dyn Fn(&mut T, Value) + Send + Sync;

impl<T: 'static> Accessor<T> {
    pub fn new(get: fn(&T) -> Option<Value>, set: fn(&mut T, Value)) -> Accessor<T> {
        Accessor { get: Box::new(get), set: Box::new(set) }
    }
}

/// When a key means something.
#[derive(Clone)]
pub(crate) struct Only<T> {
    with: Arc<With<T>>,
    otherwise: Arc<Otherwise<T>>,
}

type With<T> = dyn Fn(&T, &str) -> bool + Send + Sync;
type Otherwise<T> = dyn Fn(&T, &str) -> String + Send + Sync;

impl<T: 'static> Only<T> {
    /// `with` says whether the key of a name means something, `otherwise` what is reported of one that does not, with the remedy.
    pub fn new(with: fn(&T, &str) -> bool, otherwise: fn(&T, &str) -> String) -> Only<T> {
        Only { with: Arc::new(with), otherwise: Arc::new(otherwise) }
    }
}

impl<T: 'static> Key<T> {
    /// What it is, for the reference.
    pub fn about(&self) -> &'static str {
        let doc = self.doc.trim_start();
        doc.strip_suffix('.').unwrap_or(doc)
    }

    /// Its value in SI; `None` where there is none or it means nothing here.
    pub fn get(&self, of: &T) -> Option<Value> {
        if self.belongs(of) { (self.access.get)(of) } else { None }
    }

    /// Sets it, in SI.
    pub fn set(&self, of: &mut T, value: Value) {
        (self.access.set)(of, value);
    }

    /// Whether it means something here.
    pub fn belongs(&self, of: &T) -> bool {
        self.only.as_ref().is_none_or(|only| (only.with)(of, self.name))
    }

    /// What is reported of it where it means nothing.
    pub fn out_of_place(&self, of: &T) -> Option<String> {
        self.only.as_ref().filter(|only| !(only.with)(of, self.name)).map(|only| (only.otherwise)(of, self.name))
    }

    /// The same key of the whole that its `T` is a part of.
    fn of<W: 'static>(self, part: fn(&W) -> &T, part_mut: fn(&mut W) -> &mut T) -> Key<W> {
        let Key { name, takes, default, doc, access: Accessor { get, set }, only, prior } = self;
        let access = Accessor {
            get: Box::new(move |whole| get(part(whole))),
            set: Box::new(move |whole, value| set(part_mut(whole), value)),
        };
        let only = only.map(|Only { with, otherwise }| Only {
            with: Arc::new(move |whole: &W, key: &str| with(part(whole), key)),
            otherwise: Arc::new(move |whole: &W, key: &str| otherwise(part(whole), key)),
        });
        Key { name, takes, default, doc, access, only, prior }
    }

    /// The default in SI where it is always the same.
    pub fn fixed_default(&self) -> Option<Value> {
        match self.default {
            Default::Number(in_file) => Some(Value::Number(match self.takes {
                Kind::Number { unit, .. } => unit.to_si(in_file),
                _ => in_file,
            })),
            Default::Integer(in_file) => Some(Value::Integer(match self.takes {
                Kind::Integer { times, .. } => in_file * times,
                _ => in_file,
            })),
            Default::Boolean(on) => Some(Value::Boolean(on)),
            Default::Text(text) => Some(Value::Text(text.into())),
            Default::Required(_) | Default::Computed(_) => None,
        }
    }
}

/// What a key takes; ranges are inclusive and in the key's own unit.
pub(crate) enum Kind {
    Number {
        unit: Unit,
        low: f64,
        high: f64,
    },
    Integer {
        low: i64,
        high: i64,
        /// What one of it stands for in the rig.
        times: i64,
    },
    Boolean,
    Choice(&'static [&'static str]),
    Name {
        longest: usize,
    },
    /// Any text without control characters; the words say what it names.
    Text {
        what: &'static str,
        longest: usize,
    },
}

/// What holds where a key is not given.
pub(crate) enum Default {
    /// It must be given; the words say what.
    Required(&'static str),
    /// In the key's own unit.
    Number(f64),
    Integer(i64),
    Boolean(bool),
    Text(&'static str),
    /// Computed from other keys as the words say.
    Computed(&'static str),
}

/// How far a parameter may be off, as 1 σ around the rig file's value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Prior {
    /// As a fraction of the value; 0.2 is "20 %".
    Relative(f64),
    /// In the unit of the key.
    Absolute(f64),
}

impl Prior {
    /// 1 σ in the unit of the key, for a parameter whose value is `value` in the same unit. 0 = held fixed.
    pub fn sigma(&self, value: f64) -> f64 {
        match self {
            Prior::Relative(fraction) => fraction * value.abs(),
            Prior::Absolute(sigma) => *sigma,
        }
    }
}

/// A value in SI on its way between text and rig.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Value {
    Number(f64),
    Integer(i64),
    Boolean(bool),
    Text(String),
}

/// The unit of a key and the way from it to SI: times `mul`, divided by `div`. One of the two is always 1,
/// and dividing by a power of ten (rather than multiplying by its inexact inverse) gives the
/// double nearest to the decimal that was written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Unit {
    pub name: &'static str,
    mul: f64,
    div: f64,
}

impl Unit {
    pub(crate) const fn new(name: &'static str, mul: f64, div: f64) -> Unit {
        Unit { name, mul, div }
    }

    pub(crate) fn to_si(self, in_file: f64) -> f64 {
        in_file * self.mul / self.div
    }

    /// The shortest decimal that reads back as exactly `si`, or the nearest double where there is none.
    pub(crate) fn to_file(self, si: f64) -> f64 {
        let guess = si / self.mul * self.div;
        shortest(guess, |in_file| self.to_si(in_file) == si)
    }
}

/// The shortest decimal near `guess` that is right, or `guess` where none is.
pub(crate) fn shortest(guess: f64, mut right: impl FnMut(f64) -> bool) -> f64 {
    (0..17)
        .filter_map(|digits| format!("{guess:.digits$e}").parse::<f64>().ok())
        .find(|decimal| right(*decimal))
        .unwrap_or(guess)
}

/// Words one of which is meant: `"a", "b" or "c"`.
pub(crate) fn choices(words: &[impl Display]) -> String {
    let quoted: Vec<String> = words.iter().map(|w| format!("\"{w}\"")).collect();
    match quoted.as_slice() {
        [one] => one.clone(),
        [rest @ .., last] => format!("{} or {last}", rest.join(", ")),
        [] => "nothing".into(),
    }
}

//! What the table of laws is turned into: the words to choose from with their descriptions, and one `enum` that holds any law by
//! value and passes each call on without indirection.

macro_rules! laws {
    ($($file:ident::$Type:ident { $(
        $(#[doc = $says:literal])+
        $Kind:ident {
            word: $word:literal,
            takes: [$($key:literal),* $(,)?],
            needs_estimate: $needs_estimate:literal,
            law: $law:literal,
            defaults: $defaults:literal,
            new: $new:expr $(,)?
        }
    )+ })+) => {
        $(use $file::$Type;)+

        /// The laws to choose from.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum AlgorithmKind {
            $($($(#[doc = $says])+ $Kind,)+)+
        }

        impl AlgorithmKind {
            /// Every law.
            pub const ALL: [AlgorithmKind; [$($($word),+),+].len()] = [$($(AlgorithmKind::$Kind),+),+];

            /// What the table of laws says of it.
            pub const fn row(self) -> &'static LawRow {
                match self {
                    $($(AlgorithmKind::$Kind => &LawRow {
                        variant: stringify!($Kind),
                        word: $word,
                        says: &[$($says),+],
                        takes: &[$($key),*],
                        needs_estimate: $needs_estimate,
                        law: $law,
                        defaults: $defaults,
                    },)+)+
                }
            }

            /// Its word in the rig file.
            pub const fn word(self) -> &'static str {
                self.row().word
            }

            /// The law of this word.
            pub fn named(word: &str) -> Option<AlgorithmKind> {
                AlgorithmKind::ALL.into_iter().find(|kind| kind.word() == word)
            }

            /// Whether it is blind without an estimate of the wire's state; the others make do with the length.
            pub const fn needs_estimate(self) -> bool {
                self.row().needs_estimate
            }
        }

        /// A law of any kind.
        // Lies by value in the channel's struct, where the loop touches it: a box would cost more than the bytes.
        #[allow(clippy::large_enum_variant)]
        #[derive(Debug, Clone)]
        pub(crate) enum AnyLaw {
            $($Type($Type),)+
        }

        impl AnyLaw {
            pub fn new(kind: AlgorithmKind, setup: &Setup<'_>) -> AnyLaw {
                match kind {
                    $($(AlgorithmKind::$Kind => {
                        let new: fn(&Setup<'_>) -> $Type = $new;
                        AnyLaw::$Type(new(setup))
                    })+)+
                }
            }
        }

        impl Law for AnyLaw {
            #[inline]
            fn duty(&mut self, demand: &Demand) -> Option<f64> {
                match self {
                    $(AnyLaw::$Type(law) => law.duty(demand),)+
                }
            }

            fn reset(&mut self) {
                match self {
                    $(AnyLaw::$Type(law) => law.reset(),)+
                }
            }

            fn surface(&self) -> f64 {
                match self {
                    $(AnyLaw::$Type(law) => law.surface(),)+
                }
            }
        }
    };
}

/// A row of the table of laws.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LawRow {
    /// Its name as a variant of an `enum`.
    pub variant: &'static str,
    /// Its word in the rig file.
    pub word: &'static str,
    /// What it is, line by line.
    pub says: &'static [&'static str],
    /// Which of [`KEYS_OF_LAWS`](super::KEYS_OF_LAWS) mean something with it.
    pub takes: &'static [&'static str],
    /// Whether it gives the least duty without an estimate of the wire's state.
    pub needs_estimate: bool,
    /// Its equation, as docs/control-laws.md has it.
    pub law: &'static str,
    /// What its numbers are by default.
    pub defaults: &'static str,
}

//! What the table of joint laws is turned into: the words to choose from with their descriptions, and one `enum` that holds any law by
//! value and passes each call on without indirection.

macro_rules! joint_laws {
    ($($file:ident::$Type:ident { $(
        $(#[doc = $says:literal])+
        $Kind:ident {
            word: $word:literal,
            takes: [$($key:literal),* $(,)?],
            tension: $tension:ident,
            law: $law:literal,
            defaults: $defaults:literal,
            new: $new:expr $(,)?
        }
    )+ })+) => {
        $(use $file::$Type;)+

        /// The laws of a joint to choose from.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum JointAlgorithmKind {
            $($($(#[doc = $says])+ $Kind,)+)+
        }

        impl JointAlgorithmKind {
            /// Every law.
            pub const ALL: [JointAlgorithmKind; [$($($word),+),+].len()] = [$($(JointAlgorithmKind::$Kind),+),+];

            /// What the table of joint laws says of it.
            pub const fn row(self) -> &'static JointLawRow {
                match self {
                    $($(JointAlgorithmKind::$Kind => &JointLawRow {
                        variant: stringify!($Kind),
                        word: $word,
                        says: &[$($says),+],
                        takes: &[$($key),*],
                        tension: TensionKept::$tension,
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
            pub fn named(word: &str) -> Option<JointAlgorithmKind> {
                JointAlgorithmKind::ALL.into_iter().find(|kind| kind.word() == word)
            }

            /// Whether a tension can be asked of it.
            pub fn takes_tension(self) -> bool {
                self.row().tension != TensionKept::Around
            }
        }

        /// A law of any kind.
        // Lies by value in the joint's struct, where the loop touches it: a box would cost more than the bytes.
        #[allow(clippy::large_enum_variant)]
        #[derive(Debug, Clone)]
        pub(crate) enum AnyJointLaw {
            $($Type($Type),)+
        }

        impl AnyJointLaw {
            pub fn new(kind: JointAlgorithmKind, setup: &PairSetup<'_>) -> AnyJointLaw {
                match kind {
                    $($(JointAlgorithmKind::$Kind => {
                        let new: fn(&PairSetup<'_>) -> $Type = $new;
                        AnyJointLaw::$Type(new(setup))
                    })+)+
                }
            }
        }

        impl PairLaw for AnyJointLaw {
            #[inline]
            fn duties(&mut self, demand: &JointDemand) -> Option<[f64; 2]> {
                match self {
                    $(AnyJointLaw::$Type(law) => law.duties(demand),)+
                }
            }

            fn reset(&mut self) {
                match self {
                    $(AnyJointLaw::$Type(law) => law.reset(),)+
                }
            }

            fn is_limited(&self) -> bool {
                match self {
                    $(AnyJointLaw::$Type(law) => law.is_limited(),)+
                }
            }
        }
    };
}

/// Who sees to the tension of the pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TensionKept {
    /// The law brings it to what is asked for, and keeps its limits.
    Within,
    /// The law keeps it from falling below what is asked for; its limits are kept around the law.
    Above,
    /// The law knows nothing of it; its limits are kept around the law.
    Around,
}

/// A row of the table of joint laws.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct JointLawRow {
    /// Its name as a variant of an `enum`.
    pub variant: &'static str,
    /// Its word in the rig file.
    pub word: &'static str,
    /// What it is, line by line.
    pub says: &'static [&'static str],
    /// Which of [`KEYS_OF_JOINT_LAWS`](super::KEYS_OF_JOINT_LAWS) mean something with it.
    pub takes: &'static [&'static str],
    /// Who sees to the tension.
    pub tension: TensionKept,
    /// Its equation, as docs/control-laws.md has it.
    pub law: &'static str,
    /// What its numbers are by default.
    pub defaults: &'static str,
}

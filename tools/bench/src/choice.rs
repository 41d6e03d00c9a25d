//! The choices on a channel: every value of the rig file's keys for controller, estimator and sensing; and on a joint.

use sinew_rig::{JointAlgorithm, words};

/// The rig file's table the three words stand in.
const TABLE: &str = "channel.control";

/// A controller, an estimator and a way of sensing, as the rig file calls them.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Choice {
    /// `algorithm`.
    pub controller: String,
    /// `estimator`.
    pub estimator: String,
    /// `sensing`.
    pub sensing: String,
}

impl Choice {
    /// Every one there is, in the rig file's order.
    pub fn all() -> Vec<Choice> {
        let mut all = Vec::new();
        for sensing in words(TABLE, "sensing") {
            for controller in words(TABLE, "algorithm") {
                for estimator in words(TABLE, "estimator") {
                    all.push(Choice {
                        controller: (*controller).into(),
                        estimator: (*estimator).into(),
                        sensing: (*sensing).into(),
                    });
                }
            }
        }
        all
    }

    /// Every one of a joint: a law of its own and its one observer, whatever its channels' words say; see docs/control-laws.md.
    pub fn of_joint() -> Vec<Choice> {
        let of = |(word, _): (&str, JointAlgorithm)| Choice {
            controller: word.into(),
            estimator: "joint".into(),
            sensing: "dual".into(),
        };
        JointAlgorithm::ALL.into_iter().map(of).collect()
    }

    /// The same with other words; `None` leaves one as it is.
    #[must_use]
    pub fn with(&self, controller: Option<&str>, estimator: Option<&str>, sensing: Option<&str>) -> Choice {
        let or = |word: Option<&str>, own: &String| word.map_or_else(|| own.clone(), Into::into);
        Choice {
            controller: or(controller, &self.controller),
            estimator: or(estimator, &self.estimator),
            sensing: or(sensing, &self.sensing),
        }
    }

    /// The rig file's `[channel.control]` that says so.
    pub(crate) fn table(&self) -> String {
        let Choice { controller, estimator, sensing } = self;
        format!("algorithm = \"{controller}\"\nestimator = \"{estimator}\"\nsensing = \"{sensing}\"\n")
    }
}

/// What a rig file chooses that says nothing of it.
impl Default for Choice {
    fn default() -> Choice {
        let rig = sinew_rig::Rig::hexapod();
        let word = |key: &str| rig.channels.first().and_then(|channel| sinew_rig::word(channel, TABLE, key));
        Choice {
            controller: word("algorithm").unwrap_or_default(),
            estimator: word("estimator").unwrap_or_default(),
            sensing: word("sensing").unwrap_or_default(),
        }
    }
}

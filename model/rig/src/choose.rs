//! Which channel of a rig is meant.

use std::fmt;

use crate::suggest::nearest;
use crate::tables::Rig;

/// Why no channel is meant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NotChosen {
    file: String,
    /// The name that none has; `None`: one of several has to be named.
    name: Option<String>,
    there: Vec<String>,
}

impl Rig {
    /// The index of the channel that is meant: the named one, or the only one.
    ///
    /// # Errors
    /// [`NotChosen`] for a name that none has, and for none where there are several.
    pub fn chosen(&self, name: Option<&str>) -> Result<usize, NotChosen> {
        let found = match name {
            None => (self.channels.len() == 1).then_some(0),
            Some(name) => self.channel(name).map(|(index, _)| index),
        };
        found.ok_or_else(|| NotChosen {
            file: self.file().into(),
            name: name.map(str::to_owned),
            there: self.channels.iter().map(|channel| channel.name.clone()).collect(),
        })
    }
}

impl NotChosen {
    /// What to do about it; `option` is what a channel is named by, such as `--channel`.
    pub fn remedy(&self, option: &str) -> String {
        let there = self.there.join(", ");
        match &self.name {
            None => format!("choose one with {option}: {there}"),
            Some(name) => match nearest(name, self.there.iter().map(String::as_str)) {
                Some(near) => format!("did you mean {near:?}?"),
                None => format!("its channels are {there}"),
            },
        }
    }
}

impl fmt::Display for NotChosen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.name {
            None => write!(f, "{}: has {} channels", self.file, self.there.len()),
            Some(name) => write!(f, "{}: has no channel {name:?}", self.file),
        }
    }
}

impl std::error::Error for NotChosen {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_is_meant_or_it_is_said_which_there_are() {
        let mut rig = Rig::hexapod();
        assert_eq!(rig.chosen(Some("front_left_femur")), Ok(1));
        let remedy = |name| {
            let error = rig.chosen(name).unwrap_err();
            (error.to_string(), error.remedy("--channel"))
        };
        let (what, how) = remedy(None);
        assert!(
            what.ends_with(": has 18 channels") && how.starts_with("choose one with --channel: front_left"),
            "{how}"
        );
        assert_eq!(remedy(Some("front_left_femor")).1, "did you mean \"front_left_femur\"?");
        let (what, how) = remedy(Some("knee"));
        assert!(what.ends_with(": has no channel \"knee\"") && how.starts_with("its channels are front_left"), "{how}");
        rig.channels.truncate(1);
        assert_eq!(rig.chosen(None), Ok(0));
    }
}

//! The key expressions of a rig: what is where in Zenoh's world.

/// Those of one rig.
#[derive(Debug, Clone)]
pub struct Keys {
    rig: String,
}

impl Keys {
    /// Of the rig of this name, which is a chunk of a key expression as it is: letters, digits, `-`, `_` and `.`.
    pub fn new(rig: &str) -> Keys {
        Keys { rig: rig.into() }
    }

    /// What does not change while a driver runs, and whether one does.
    pub fn info(&self) -> String {
        self.at("info")
    }

    /// How the bridge does.
    pub fn bridge(&self) -> String {
        self.at("bridge")
    }

    /// A topic of recordings, `/cycles`.
    pub fn topic(&self, topic: &str) -> String {
        format!("sinew/{}{topic}", self.rig)
    }

    /// The state of a channel; of all of them: `*`.
    pub fn channel(&self, name: &str) -> String {
        self.at(&format!("channel/{name}"))
    }

    /// Where a commander asks; he alone can.
    pub fn command(&self, commander: &str) -> String {
        self.at(&format!("commander/{commander}/command"))
    }

    /// What says that a commander is there: his liveliness token. Of all of them: `*`.
    pub fn alive(&self, commander: &str) -> String {
        self.at(&format!("commander/{commander}/alive"))
    }

    /// The commander whose token this is.
    pub fn commander_of<'a>(&self, alive: &'a str) -> Option<&'a str> {
        alive.strip_prefix(&self.at("commander/"))?.strip_suffix("/alive")
    }

    fn at(&self, place: &str) -> String {
        format!("sinew/{}/{place}", self.rig)
    }
}

/// Whether this may be the name of a commander: the common name of a certificate, a chunk of a key expression, the name of a file.
pub fn is_name(name: &str) -> bool {
    (1..=64).contains(&name.len())
        && name.starts_with(|c: char| c.is_ascii_alphanumeric())
        && name.bytes().all(|b| b.is_ascii_alphanumeric() || matches!(b, b'-' | b'_' | b'.'))
}

#[cfg(test)]
mod tests {
    use super::*;
    use zenoh::key_expr::KeyExpr;

    #[test]
    fn every_key_is_one_and_a_token_says_whose_it_is() {
        let keys = Keys::new("my-rig.2");
        for key in [
            keys.info(),
            keys.bridge(),
            keys.topic("/cycles"),
            keys.channel("a_b"),
            keys.command("anna"),
            keys.alive("*"),
        ] {
            assert!(KeyExpr::try_from(key.clone()).is_ok(), "{key}");
        }
        assert_eq!(keys.topic("/cycles"), "sinew/my-rig.2/cycles");
        assert_eq!(keys.commander_of(&keys.alive("anna")), Some("anna"));
        assert_eq!(keys.commander_of(&Keys::new("other").alive("anna")), None);
    }

    #[test]
    fn names_are_chunks_of_keys_and_nothing_else() {
        assert!(["anna", "a", "robot-7.local", "A_1"].iter().all(|name| is_name(name)));
        let long = "x".repeat(65);
        for bad in ["", "*", "**", "a/b", "a*", "$x", ".hidden", "../up", "a b", "ä", "a?", long.as_str()] {
            assert!(!is_name(bad), "{bad:?}");
        }
    }
}

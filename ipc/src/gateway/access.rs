//! Who may look and who may command.

use super::peer::{self, Peer};
use crate::{Error, Name};

/// A Unix group that may do something.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Group {
    pub name: String,
    pub id: u32,
}

/// Who may look besides those who may command.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Readers {
    /// Nobody.
    Nobody,
    /// Members of this group: its name or number.
    Group(String),
    /// Every user of this machine.
    Everyone,
}

/// What the rig file says about access by other users, with its groups looked up.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Access {
    commanders: Option<Group>,
    stoppers: Option<Group>,
    readers: Option<Group>,
    everyone_reads: bool,
}

/// What a client may do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Nothing.
    Stranger,
    /// Look.
    Reader,
    /// Look, and stop the driver.
    Stopper,
    /// Look and command.
    Commander,
}

impl Access {
    /// Commands from members of `command_group` (`None`: from nobody but the driver's own user and root), nothing but a stop from those
    /// of `stop_group`, looks from them all and from `readers`. Groups by name or number.
    ///
    /// # Errors
    /// [`Error::UnknownGroup`].
    pub fn new(command_group: Option<&str>, stop_group: Option<&str>, readers: &Readers) -> Result<Access, Error> {
        Ok(Access {
            commanders: command_group.map(group).transpose()?,
            stoppers: stop_group.map(group).transpose()?,
            readers: match readers {
                Readers::Group(name) => Some(group(name)?),
                Readers::Nobody | Readers::Everyone => None,
            },
            everyone_reads: *readers == Readers::Everyone,
        })
    }

    /// What this client may do. His groups are those his process has, as the kernel knows them.
    pub(crate) fn role(&self, peer: &Peer, own_user: u32) -> Role {
        let member = |group: &Option<Group>| group.as_ref().is_some_and(|group| peer.is_in(group.id));
        if peer.user == own_user || peer.user == 0 || member(&self.commanders) {
            Role::Commander
        } else if member(&self.stoppers) {
            Role::Stopper
        } else if self.everyone_reads || member(&self.readers) {
            Role::Reader
        } else {
            Role::Stranger
        }
    }

    /// What this process might do at a driver of another user.
    pub fn role_of_this_process(&self) -> Role {
        self.role(&Peer::this_process(), Self::NOBODY)
    }

    /// No user has this number.
    const NOBODY: u32 = u32::MAX;

    /// The group whose members may command, to be told to who may not.
    pub(crate) fn command_group(&self) -> Name {
        told(&self.commanders)
    }

    /// The group whose members may stop the driver.
    pub(crate) fn stop_group(&self) -> Name {
        told(&self.stoppers)
    }

    /// The group whose members may look.
    pub(crate) fn read_group(&self) -> Name {
        told(&self.readers)
    }
}

fn told(group: &Option<Group>) -> Name {
    group.as_ref().and_then(|group| Name::new(&group.name).ok()).unwrap_or(Name::EMPTY)
}

fn group(name: &str) -> Result<Group, Error> {
    let id = match peer::group_id(name) {
        Some(id) => id,
        None => name.parse().map_err(|_| Error::UnknownGroup { name: name.into() })?,
    };
    Ok(Group { name: name.into(), id })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roles_follow_from_user_and_groups() {
        let peer = |user, group, groups: &[u32]| Peer { pid: 1, user, group, groups: groups.to_vec() };
        let of = |commanders, readers: &Readers, peer: &Peer| {
            Access::new(commanders, Some("4545"), readers).unwrap().role(peer, 1000)
        };
        let group = Readers::Group("4242".into());
        for (readers, else_) in
            [(&Readers::Nobody, Role::Stranger), (&group, Role::Stranger), (&Readers::Everyone, Role::Reader)]
        {
            let of = |peer: &Peer| of(Some("4343"), readers, peer);
            assert_eq!(of(&peer(1000, 5, &[])), Role::Commander, "the driver's own user");
            assert_eq!(of(&peer(0, 5, &[])), Role::Commander, "root");
            assert_eq!(of(&peer(7, 4343, &[])), Role::Commander, "by his own group");
            assert_eq!(of(&peer(7, 5, &[1, 4343])), Role::Commander, "by one of his groups");
            assert_eq!(of(&peer(7, 5, &[1, 4545])), Role::Stopper);
            assert_eq!(of(&peer(7, 5, &[4545, 4343])), Role::Commander, "the more of both");
            assert_eq!(of(&peer(7, 5, &[1, 2])), else_);
            assert_eq!(of(&peer(1001, 1000, &[1000])), else_, "a group is no user");
        }
        assert_eq!(of(Some("4343"), &group, &peer(7, 5, &[4242])), Role::Reader);
        assert_eq!(of(None, &group, &peer(7, 4242, &[])), Role::Reader);
        assert_eq!(of(None, &Readers::Everyone, &peer(7, 5, &[])), Role::Reader);
    }

    #[test]
    fn this_process_is_judged_like_a_visitor() {
        let (a, _b) = std::os::unix::net::UnixStream::pair().unwrap();
        let peer = Peer::of(&a).unwrap();
        for group in [peer.group, 4_000_123] {
            let access = Access::new(Some(&group.to_string()), None, &Readers::Everyone).unwrap();
            assert_eq!(access.role_of_this_process(), access.role(&peer, Access::NOBODY), "{group}");
        }
    }

    #[test]
    fn a_group_there_is_not_is_an_error_and_not_nobody() {
        let unknown = Err(Error::UnknownGroup { name: "no-such-group-here".into() });
        assert_eq!(Access::new(Some("no-such-group-here"), None, &Readers::Nobody), unknown);
        assert_eq!(Access::new(None, Some("no-such-group-here"), &Readers::Nobody), unknown);
        assert_eq!(Access::new(None, None, &Readers::Group("no-such-group-here".into())), unknown);
        let root = Access::new(Some("root"), None, &Readers::Nobody).unwrap();
        assert_eq!(root.commanders, Some(Group { name: "root".into(), id: 0 }));
        assert_eq!(root.command_group().as_str(), "root");
    }
}

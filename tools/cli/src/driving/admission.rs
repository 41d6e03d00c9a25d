//! `sinew doctor`'s checks for clients: whether the limits allow as many as a driver serves, and whether the gateway for other users
//! can be opened as configured.

use sinew_driver::access_of;
use sinew_ipc::descriptors;
use sinew_ipc::gateway::{self, EndpointState, Role};
use sinew_rig::Rig;

use super::check::{Check, Verdict, check};

/// Everything about who comes in.
pub(super) fn admission(rig: &Rig) -> Vec<Check> {
    let mut checks = vec![open_files(descriptors::allowed())];
    if rig.access.is_open() {
        checks.extend([groups(rig), endpoint(rig)]);
    }
    checks
}

/// The hard limit: `sinew run` raises its soft one by itself.
fn open_files(allowed: u64) -> Check {
    let needed = descriptors::ALL_CLIENTS;
    let trouble = (allowed < needed).then(|| {
        let cost = "clients are refused before all places are taken";
        let remedy = format!(
            "`ulimit -n {0}` as root before the start, LimitNOFILE={0} in its systemd unit, or `USER hard nofile {0}` in \
             /etc/security/limits.d/sinew.conf",
            needed.next_power_of_two()
        );
        (Verdict::Advice, cost, remedy)
    });
    let wanted = format!("{needed} open files, for as many clients as a driver serves");
    check("open_files", &wanted, format!("{allowed} allowed"), trouble)
}

/// Whether the groups are there, and what this user may do by them.
fn groups(rig: &Rig) -> Check {
    let or_nobody = |group: &Option<String>, nobody: &'static str| group.clone().unwrap_or_else(|| nobody.into());
    let wanted = format!(
        "other users come in: group {} to command, {} to stop the driver, {} to look",
        or_nobody(&rig.access.command_group, "(none)"),
        or_nobody(&rig.access.stop_group, "(none)"),
        match rig.access.read_group.as_deref() {
            Some(sinew_rig::Access::EVERYONE) => "everyone".into(),
            _ => or_nobody(&rig.access.read_group, "nobody else"),
        }
    );
    let access = match access_of(rig) {
        Ok(access) => access,
        Err(error) => {
            let trouble = Some((Verdict::Lacking, "the driver does not start", error.remedy()));
            return check("groups", &wanted, error.message(), trouble);
        }
    };
    let joining = |group: &Option<String>| match group {
        Some(group) => format!("sudo usermod -aG {group} $USER   (then log in again)"),
        None => "name a command_group in [access] of the rig file".into(),
    };
    let (found, trouble) = match access.role_of_this_process() {
        Role::Commander => ("this user may command and look", None),
        Role::Stopper => {
            let cost = "from this account one can only look at a driver that another one runs, and stop it";
            (
                "this user may look and stop the driver",
                Some((Verdict::Advice, cost, joining(&rig.access.command_group))),
            )
        }
        Role::Reader => {
            let cost = "from this account one cannot command a driver that another one runs";
            ("this user may look", Some((Verdict::Advice, cost, joining(&rig.access.command_group))))
        }
        Role::Stranger => {
            let cost = "from this account one can neither command nor see a driver that another one runs";
            let sinew_rig::Access { command_group, stop_group, read_group } = &rig.access;
            let group = command_group.as_ref().or(stop_group.as_ref()).or(read_group.as_ref()).cloned();
            ("this user is in none of them", Some((Verdict::Advice, cost, joining(&group))))
        }
    };
    check("groups", &wanted, found.into(), trouble)
}

/// Whether this user's driver could open the socket.
fn endpoint(rig: &Rig) -> Check {
    let wanted = "a place for the door of the gate, kept from others";
    match gateway::survey(&rig.name) {
        Ok((path, found)) => {
            let found = match found {
                EndpointState::Free => "free".to_string(),
                EndpointState::ToBeMade => "its folder would be made".into(),
                EndpointState::Taken(pid) => format!("process {pid} stands there: a driver of this rig"),
            };
            check("door", wanted, format!("{}: {found}", path.display()), None)
        }
        Err(error) => {
            let trouble = Some((Verdict::Lacking, "the driver does not start under this user", error.remedy()));
            check("door", wanted, error.message(), trouble)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rig(access: &str) -> Rig {
        let text = sinew_rig::HEXAPOD_TOML.to_string() + "\n[access]\n" + access;
        Rig::parse(&text, "access.toml").expect("a rig")
    }

    #[test]
    fn without_access_there_is_nothing_to_be_said_about_other_users() {
        let ids: Vec<&str> = admission(&Rig::hexapod()).iter().map(|check| check.id).collect();
        assert_eq!(ids, ["open_files"]);
        let ids: Vec<&str> = admission(&rig("read_group = \"everyone\"")).iter().map(|check| check.id).collect();
        assert_eq!(ids, ["open_files", "groups", "door"]);
    }

    #[test]
    fn a_group_there_is_not_is_lacking_with_what_to_type() {
        let check = groups(&rig("command_group = \"no-such-group\""));
        assert_eq!((check.verdict, check.found.as_str()), (Verdict::Lacking, "there is no group \"no-such-group\""));
        assert!(check.remedy.contains("sudo groupadd no-such-group"), "{}", check.remedy);
        assert!(
            check.wanted.contains("group no-such-group to command, (none) to stop the driver, nobody else to look"),
            "{}",
            check.wanted
        );
    }

    #[test]
    fn too_few_open_files_are_advice() {
        assert_eq!(open_files(u64::MAX).verdict, Verdict::Good);
        let few = open_files(1024);
        assert_eq!(few.verdict, Verdict::Advice);
        assert!(few.remedy.contains("LimitNOFILE=2048"), "{}", few.remedy);
    }
}

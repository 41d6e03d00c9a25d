//! Whether anybody but this user (and root) may write to a file: the only thing by which it can be known that nobody else has used an output.
//!
//! The kernel keeps no note of who wrote to a file of sysfs last. So a file that a group may write to is only this user's where he is its
//! only member, as `/etc/passwd` and `/etc/group` have it; a group that is not in there may be anybody's.

use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

use rustix::process::geteuid;

/// Root, and its group.
const ROOT: u32 = 0;

/// Who else may write to a file, in words; `None` where nobody may.
pub(crate) fn others(path: &Path) -> Option<String> {
    let found = match fs::metadata(path) {
        Ok(found) => found,
        Err(error) => return Some(format!("it cannot be told who ({error})")),
    };
    let text = |path: &str| fs::read_to_string(path).unwrap_or_default();
    let own = geteuid().as_raw();
    others_of(found.mode(), found.uid(), found.gid(), own, &text("/etc/passwd"), &text("/etc/group"))
}

fn others_of(mode: u32, owner: u32, group: u32, own: u32, accounts: &str, groups: &str) -> Option<String> {
    if owner != own && owner != ROOT {
        return Some(format!("user {owner}"));
    }
    if mode & 0o002 != 0 {
        return Some("everybody".into());
    }
    if mode & 0o020 == 0 {
        return None;
    }
    // NAME:PASSWORD:UID:GID:…
    let account = |line: &'_ str| {
        let mut fields = line.split(':');
        let (name, user, group) = (fields.next()?, fields.nth(1)?, fields.next()?);
        Some((name.to_string(), user.parse::<u32>().ok()?, group.parse::<u32>().ok()?))
    };
    let accounts: Vec<(String, u32, u32)> = accounts.lines().filter_map(account).collect();
    let is_ours = |user: u32| user == own || user == ROOT;
    // NAME:PASSWORD:GID:MEMBER,MEMBER
    let line = groups.lines().find(|line| line.split(':').nth(2) == Some(&group.to_string()));
    let Some(line) = line else { return Some(format!("group {group}")) };
    let name = line.split(':').next().unwrap_or_default();
    let members = line.split(':').nth(3).unwrap_or_default().split(',').map(str::trim).filter(|name| !name.is_empty());
    let user = |name: &str| accounts.iter().find(|(known, ..)| known == name).map(|(_, user, _)| *user);
    let is_alone = members.map(user).all(|user| user.is_some_and(is_ours))
        && accounts.iter().filter(|(.., first)| *first == group).all(|(_, user, _)| is_ours(*user));
    (!is_alone).then(|| format!("group {name}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ACCOUNTS: &str =
        "root:x:0:0:root:/root:/bin/sh\nrobot:x:1001:1001::/:\nanna:x:1002:1002::/:\nben:x:1003:50::/:\n";
    const GROUPS: &str =
        "root:x:0:\npwm:x:40:robot\nshared:x:41:robot,anna\nfirst:x:50:robot\nempty:x:51:\nrobot:x:1001:\n";

    #[test]
    fn a_file_is_ours_where_nobody_else_may_write_to_it() {
        let who = |mode, owner, group| others_of(mode, owner, group, 1001, ACCOUNTS, GROUPS);
        for (mode, owner, group) in
            [(0o644, 0, 0), (0o644, 1001, 41), (0o664, 0, 40), (0o664, 0, 51), (0o660, 1001, 1001), (0o664, 0, 0)]
        {
            assert_eq!(who(mode, owner, group), None, "{mode:o} {owner} {group}");
        }
        for (mode, owner, group, says) in [
            (0o646, 0, 0, "everybody"),
            (0o644, 1002, 0, "user 1002"),
            (0o664, 0, 41, "group shared"),
            (0o664, 0, 50, "group first"),
            (0o664, 0, 77, "group 77"),
        ] {
            assert_eq!(who(mode, owner, group).as_deref(), Some(says), "{mode:o} {owner} {group}");
        }
        let stranger = GROUPS.replace("robot", "robot,nobody_known");
        assert!(others_of(0o664, 0, 40, 1001, ACCOUNTS, &stranger).is_some());
    }
}

//! What others on the network call this machine: its addresses and names.

use std::io;
use std::net::IpAddr;

/// The addresses at which others reach a server of this machine that listens at `listen`: that one, or all there are for it, loopback
/// and those that lead no further than one cable (`fe80::`) left out.
///
/// # Errors
/// The system's, where it does not say.
pub fn addresses(listen: IpAddr) -> io::Result<Vec<IpAddr>> {
    if !listen.is_unspecified() {
        return Ok(vec![listen]);
    }
    let all = if_addrs::get_if_addrs()?.into_iter().map(|interface| interface.ip());
    Ok(all.filter(|address| is_reached(listen, *address)).collect())
}

fn is_reached(listen: IpAddr, address: IpAddr) -> bool {
    match address {
        _ if address.is_loopback() => false,
        IpAddr::V4(_) => true,
        // on Linux, who listens at [::] is reached by IPv4, too, but not the other way round
        IpAddr::V6(address) => listen.is_ipv6() && !address.is_unicast_link_local(),
    }
}

/// The names by which others may find this machine: its host name, and that as multicast DNS has it (`bench.local`). None is `localhost`, which
/// is a name of every machine.
pub fn names() -> Vec<String> {
    named(std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default().trim())
}

fn named(host: &str) -> Vec<String> {
    let host = host.to_lowercase();
    let is_name = host.split('.').all(|part| {
        !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'-') && part.len() < 64
    });
    match host.split('.').next() {
        Some(first) if is_name && first != "localhost" && host.parse::<IpAddr>().is_err() => {
            let local = format!("{first}.local");
            if host == local { vec![local] } else { vec![host, local] }
        }
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use std::net::{Ipv4Addr, Ipv6Addr};

    use super::*;

    #[test]
    fn a_machine_has_the_names_that_a_browser_may_send() {
        for (host, names) in [
            ("Bench", &["bench", "bench.local"][..]),
            ("bench.lab.example", &["bench.lab.example", "bench.local"]),
            ("bench.local", &["bench.local"]),
            ("localhost", &[]),
            ("localhost.localdomain", &[]),
            ("192.0.2.1", &[]),
            ("(none)", &[]),
            ("", &[]),
        ] {
            assert_eq!(named(host), names, "{host}");
        }
    }

    #[test]
    fn an_address_is_one_that_others_reach() {
        let (all_4, all_6) = (IpAddr::from(Ipv4Addr::UNSPECIFIED), IpAddr::from(Ipv6Addr::UNSPECIFIED));
        for (address, by_4, by_6) in [
            ("192.0.2.7", true, true),
            ("169.254.1.2", true, true),
            ("127.0.0.1", false, false),
            ("::1", false, false),
            ("2001:db8::7", false, true),
            ("fd00::7", false, true),
            ("fe80::7", false, false),
        ] {
            let reached = [all_4, all_6].map(|listen| is_reached(listen, address.parse().unwrap()));
            assert_eq!(reached, [by_4, by_6], "{address}");
        }
        let one = IpAddr::from([127, 0, 0, 2]);
        assert_eq!(addresses(one).unwrap(), [one], "whatever it is, if it was asked for");
        assert!(addresses(all_4).unwrap().iter().all(|address| address.is_ipv4() && !address.is_loopback()));
    }
}

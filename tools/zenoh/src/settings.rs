//! How Zenoh is told to behave: it looks for nobody, listens at one place, and lets nobody do more than he may.
//!
//! A session of Zenoh's own choosing scouts by multicast, listens on all addresses and passes on whatever anybody publishes. This one
//! does not scout, and its access control refuses what is not allowed by name:
//!
//! | who | may |
//! |---|---|
//! | everybody who may connect | subscribe; query [`Keys::info`], [`Keys::bridge`], the topics and the channels |
//! | a commander, by the common name of the certificate at the other end of *this* link | query his own [`Keys::command`], declare his own [`Keys::alive`] |
//! | anybody | nothing else: no publication, no queryable, so nobody passes for the driver by way of this bridge |

use std::net::SocketAddr;

use serde_json::{Value, json};
use sinew_recording::session::{CYCLES, LOOP};
use zenoh::Config;

use crate::certificates::Certificates;
use crate::failure::Failure;
use crate::keys::Keys;

/// Links at once.
const MOST_LINKS: u32 = 64;
/// Longest message that is taken, bytes: a pose of 64 channels has some 5000.
const LONGEST_MESSAGE: u32 = 64 << 10;
/// After so long without a word the other end may take the bridge for dead, ms.
const LEASE_MS: u32 = 2000;
/// An answer that a link takes no part of for so long ends that link, µs: nobody else is to wait for it.
const LONGEST_ANSWER_US: u32 = 500_000;

/// The endpoint as Zenoh writes it: with certificates QUIC, which is TLS 1.3. Not Zenoh's TLS over TCP, which reads and writes one
/// connection of rustls at the same time (zenoh-link-tls 1.10) and breaks off under load.
pub fn endpoint(listen: SocketAddr, certificates: Option<&Certificates>) -> String {
    format!("{}/{listen}", if certificates.is_some() { "quic" } else { "tcp" })
}

/// The settings of a bridge that listens there.
///
/// # Errors
/// A path that is not text, and what Zenoh itself refuses.
pub fn settings(
    keys: &Keys,
    listen: SocketAddr,
    certificates: Option<&Certificates>,
    commanders: &[String],
) -> Result<Config, Failure> {
    let mut config = Config::default();
    let mut set = |key: &str, value: Value| {
        config.insert_json5(key, &value.to_string()).map_err(|error| Failure::own(format_args!("{key}: {error}")))
    };
    set("mode", json!("peer"))?;
    set("listen/endpoints", json!([endpoint(listen, certificates)]))?;
    set("scouting/multicast/enabled", json!(false))?;
    set("scouting/gossip/enabled", json!(false))?;
    set("transport/unicast/max_sessions", json!(MOST_LINKS))?;
    set("transport/link/rx/max_message_size", json!(LONGEST_MESSAGE))?;
    set("transport/link/tx/lease", json!(LEASE_MS))?;
    // room for some periods of a large rig: what finds none is lost, and nobody waits
    set("transport/link/tx/queue/size/data_low", json!(16))?;
    set("transport/link/tx/queue/congestion_control/block/wait_before_close", json!(LONGEST_ANSWER_US))?;
    set("access_control", access(keys, commanders))?;
    if let Some(certificates) = certificates {
        let path = |path: std::path::PathBuf| match path.to_str() {
            Some(text) => Ok(json!(text)),
            None => Err(Failure::input(format_args!("{}: not text", path.display())).hint("move the folder")),
        };
        set("transport/link/tls/root_ca_certificate", path(certificates.authority())?)?;
        set("transport/link/tls/listen_certificate", path(certificates.certificate())?)?;
        set("transport/link/tls/listen_private_key", path(certificates.key())?)?;
        set("transport/link/tls/enable_mtls", json!(true))?;
        set("transport/link/tls/close_link_on_expiration", json!(true))?;
    }
    Ok(config)
}

/// Who may do what.
fn access(keys: &Keys, commanders: &[String]) -> Value {
    let all = [
        "put",
        "delete",
        "declare_subscriber",
        "query",
        "reply",
        "declare_queryable",
        "liveliness_token",
        "liveliness_query",
        "declare_liveliness_subscriber",
    ];
    let rule = |id: &str, flow: &str, messages: &[&str], keys: &[String]| json!({ "id": id, "permission": "allow", "flows": [flow], "messages": messages, "key_exprs": keys });
    let shown = [keys.info(), keys.bridge(), keys.topic(CYCLES), keys.topic(LOOP), keys.channel("*")];
    let mut rules = vec![
        rule("out", "egress", &all, &["**".into()]),
        rule("subscribe", "ingress", &["declare_subscriber"], &["**".into()]),
        rule("look", "ingress", &["query"], &shown),
    ];
    let mut subjects = vec![json!({ "id": "everybody" })];
    let mut policies = vec![json!({ "rules": ["out", "subscribe", "look"], "subjects": ["everybody"] })];
    for name in commanders {
        let (command, alive) = (format!("command {name}"), format!("alive {name}"));
        rules.push(rule(&command, "ingress", &["query"], &[keys.command(name)]));
        rules.push(rule(&alive, "ingress", &["liveliness_token"], &[keys.alive(name)]));
        // a link without a certificate has no name, so this is nobody's there
        subjects.push(json!({ "id": name, "cert_common_names": [name], "link_protocols": ["quic"] }));
        policies.push(json!({ "rules": [command, alive], "subjects": [name] }));
    }
    json!({ "enabled": true, "default_permission": "deny", "rules": rules, "subjects": subjects, "policies": policies })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zenoh_takes_the_settings_and_they_say_what_they_are_to() {
        let keys = Keys::new("bench");
        let listen = "127.0.0.1:7447".parse().unwrap();
        let config = settings(&keys, listen, None, &[]).unwrap();
        let read = |key: &str| config.get_json(key).unwrap();
        assert_eq!(read("listen/endpoints"), "[\"tcp/127.0.0.1:7447\"]");
        assert_eq!(
            (read("scouting/multicast/enabled"), read("scouting/gossip/enabled")),
            ("false".into(), "false".into())
        );

        let folder = tempfile::tempdir().unwrap();
        crate::certificates::make(folder.path(), &[], &[]).unwrap();
        let certificates = Certificates::open(folder.path()).unwrap();
        let config = settings(&keys, listen, Some(&certificates), &["anna".into()]).unwrap();
        assert_eq!(config.get_json("transport/link/tls/enable_mtls").unwrap(), "true");
        assert!(config.get_json("listen/endpoints").unwrap().contains("quic/127.0.0.1:7447"));
        let access: Value = serde_json::from_str(&config.get_json("access_control").unwrap()).unwrap();
        assert_eq!(access["default_permission"], "deny");
        let ingress = access["rules"].as_array().unwrap().iter().filter(|rule| rule["flows"] == json!(["ingress"]));
        for rule in ingress {
            for message in ["put", "delete", "declare_queryable", "reply"] {
                assert!(!rule["messages"].as_array().unwrap().contains(&json!(message)), "{rule}");
            }
        }
    }
}

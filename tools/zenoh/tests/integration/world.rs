//! Bridges and Zenoh sessions of a test's own.

use std::collections::BTreeMap;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use serde_json::{Value, json};
use sinew_ipc::{ChannelState, Client};
use sinew_tests::{Finished, PATIENCE, Process, Rig, wait_for};
use zenoh::handlers::FifoChannelHandler;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::Subscriber;
use zenoh::sample::Sample;
use zenoh::{Config, Session, Wait};

/// The bridge's program.
pub fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_sinew-zenoh"))
}

/// Runs it to its end.
#[track_caller]
pub fn run(args: &[&str]) -> Finished {
    Process::start(program().args(args)).finish()
}

/// A port nobody has.
pub fn free_port() -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    listener.local_addr().expect("it is bound").port()
}

/// Starts a bridge of this rig; the endpoint it has said.
#[track_caller]
pub fn bridge(rig: &Rig, more: &[&str]) -> (Process, String) {
    bridge_by(&mut program(), rig, more)
}

/// The same, by this command.
#[track_caller]
pub fn bridge_by(command: &mut Command, rig: &Rig, more: &[&str]) -> (Process, String) {
    let listen = format!("127.0.0.1:{}", free_port());
    let mut bridge = Process::start(command.args(["--rig", &rig.name, "--listen", &listen]).args(more));
    bridge.wait_for_word("\n");
    let endpoint = bridge.stdout().trim().to_string();
    assert!(endpoint.ends_with(&listen), "{endpoint}");
    (bridge, endpoint)
}

/// Makes certificates of these clients in a folder of the rig's.
#[track_caller]
pub fn certificates(rig: &Rig, folder: &str, names: &[&str]) -> PathBuf {
    let folder = rig.file(folder);
    let path = folder.to_str().expect("a plain path");
    run(&[&["certificates", path], names].concat()).expect(0);
    folder
}

/// Settings of a client of this endpoint.
pub fn config(endpoint: &str, certificate: Option<(&Path, &str)>) -> Config {
    let mut config = Config::default();
    let mut set = |key: &str, value: Value| config.insert_json5(key, &value.to_string()).expect("a setting");
    set("mode", json!("client"));
    set("connect/endpoints", json!([endpoint]));
    set("connect/timeout_ms", json!(10_000));
    set("scouting/multicast/enabled", json!(false));
    if let Some((folder, name)) = certificate {
        let file = |name: String| json!(folder.join(name).to_str().expect("a plain path"));
        set("transport/link/tls/root_ca_certificate", file("authority.pem".into()));
        if !name.is_empty() {
            set("transport/link/tls/connect_certificate", file(format!("{name}.pem")));
            set("transport/link/tls/connect_private_key", file(format!("{name}.key")));
            set("transport/link/tls/enable_mtls", json!(true));
        }
    }
    config
}

/// A client of this endpoint, in the clear.
#[track_caller]
pub fn session(endpoint: &str) -> Session {
    zenoh::open(config(endpoint, None)).wait().unwrap_or_else(|e| panic!("{e}"))
}

/// A client with a certificate.
#[track_caller]
pub fn session_of(endpoint: &str, folder: &Path, name: &str) -> Session {
    zenoh::open(config(endpoint, Some((folder, name)))).wait().unwrap_or_else(|e| panic!("{e}"))
}

/// What an answer says, or the refusal; nothing where nobody answers within this time.
pub fn query(
    session: &Session,
    key: &str,
    payload: Option<Value>,
    within: Duration,
) -> Option<Result<Vec<u8>, String>> {
    let mut get = session.get(key).timeout(within);
    if let Some(payload) = payload {
        get = get.payload(payload.to_string());
    }
    let replies = get.wait().expect("it can be asked");
    let reply = replies.recv().ok()?;
    Some(match reply.into_result() {
        Ok(sample) => Ok(sample.payload().to_bytes().into_owned()),
        Err(error) => Err(error.payload().try_to_string().expect("text").into_owned()),
    })
    // Zenoh's own word
    .filter(|answer| *answer != Err("Timeout".into()))
}

/// An answer in JSON.
#[track_caller]
pub fn json_of(session: &Session, key: &str) -> Value {
    let answer = query(session, key, None, PATIENCE).expect("somebody answers").expect("no refusal");
    serde_json::from_slice(&answer).expect("JSON")
}

/// Commander `anna` of a rig.
pub struct Anna {
    pub session: Session,
    pub alive: Option<LivelinessToken>,
    rig: String,
}

impl Anna {
    /// With her certificate of this folder, not declared alive.
    #[track_caller]
    pub fn connect(rig: &Rig, endpoint: &str, folder: &Path) -> Anna {
        Anna { session: session_of(endpoint, folder, "anna"), alive: None, rig: rig.name.clone() }
    }

    /// Declares herself alive, and is seen.
    #[track_caller]
    pub fn come(&mut self) {
        let key = format!("sinew/{}/commander/anna/alive", self.rig);
        self.alive = Some(self.session.liveliness().declare_token(key).wait().expect("a token"));
        let figures = format!("sinew/{}/bridge", self.rig);
        sinew_tests::wait_until("anna to be seen", || {
            json_of(&self.session, &figures)["commanders"] == json!(["anna"])
        });
    }

    /// Asks, and is answered; again where nothing is amiss but a busy machine.
    #[track_caller]
    pub fn ask(&self, request: Value) -> Result<Value, Value> {
        let key = format!("sinew/{}/commander/anna/command", self.rig);
        wait_for("an answer", || {
            let answer = query(&self.session, &key, Some(request.clone()), PATIENCE).expect("somebody answers");
            let json = |text: &[u8]| serde_json::from_slice::<Value>(text).expect("JSON");
            let answer = answer.map(|done| json(&done)).map_err(|refused| json(refused.as_bytes()));
            let is_busy = answer.as_ref().is_err_and(|refused| {
                let message = refused["message"].as_str().expect("text");
                ["waited for too long", "has not answered", "too many"].iter().any(|word| message.contains(word))
            });
            (!is_busy).then_some(answer)
        })
    }

    /// Gives a duty.
    #[track_caller]
    pub fn duty(&self, channel: &str, value: f64, hold_s: f64) -> Result<Value, Value> {
        self.ask(json!({ "call": "set", "channel": channel, "kind": "duty", "value": value, "hold_s": hold_s }))
    }
}

/// A subscriber that keeps all that comes.
pub fn subscribe(session: &Session, key: &str) -> Subscriber<FifoChannelHandler<Sample>> {
    session
        .declare_subscriber(key.to_string())
        .with(zenoh::handlers::FifoChannel::new(100_000))
        .wait()
        .expect("a subscription")
}

/// The next message.
#[track_caller]
pub fn next(subscriber: &Subscriber<FifoChannelHandler<Sample>>) -> Sample {
    subscriber.recv_timeout(PATIENCE).expect("the session lives").expect("a message comes")
}

/// A message's number among those of its key, and its time of day, ns.
#[track_caller]
pub fn number(sample: &Sample) -> (u64, u64) {
    let attachment = sample.attachment().expect("a number").to_bytes();
    let of = |at: usize| u64::from_le_bytes(attachment[at..at + 8].try_into().expect("eight bytes"));
    assert_eq!(attachment.len(), 16);
    (of(0), of(8))
}

/// A cycle: its number, the channels' bytes.
#[track_caller]
pub fn cycle(sample: &Sample) -> (u64, Vec<u8>) {
    let message = sample.payload().to_bytes();
    assert_eq!(message[..4], [0, 1, 0, 0], "CDR, little endian");
    (u64::from_le_bytes(message[4..12].try_into().expect("eight bytes")), message[28..].to_vec())
}

/// Cycles as the client has them, by their numbers.
pub fn as_the_client_has_them(client: &Client, count: usize) -> BTreeMap<u64, Vec<u8>> {
    let mut stream = client.stream().expect("a stream");
    let mut cycles = BTreeMap::new();
    while cycles.len() < count {
        if let Some(cycle) = stream.next_within(PATIENCE).expect("the driver runs") {
            cycles.insert(cycle.header.cycle, ChannelState::bytes_of(cycle.channels).to_vec());
        }
    }
    cycles
}

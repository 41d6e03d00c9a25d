//! A commander: holds a wire at a stroke over Zenoh until it is ended, by a lease that it renews ten times in its length.
//!
//! ```text
//! sinew run                                                        # a driver
//! sinew-zenoh certificates keys anna
//! sinew-zenoh --rig hexapod --certificates keys --commander anna
//! cargo run --example commander -- hexapod quic/127.0.0.1:7447 keys anna front_left_coxa 0.4
//! ```

use std::time::Duration;

use serde_json::{Value, json};
use zenoh::{Config, Wait};

const LEASE_S: f64 = 3.0;

fn main() -> Result<(), zenoh::Error> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [rig, endpoint, folder, name, channel, stroke] = arguments.as_slice() else {
        return Err("give RIG ENDPOINT FOLDER NAME CHANNEL STROKE".into());
    };
    let mut config = Config::default();
    let mut set = |key: &str, value: Value| config.insert_json5(key, &value.to_string());
    set("mode", json!("client"))?;
    set("connect/endpoints", json!([endpoint]))?;
    set("scouting/multicast/enabled", json!(false))?;
    // the bridge takes this end for dead after a second without a word, not after ten
    set("transport/link/tx/lease", json!(1000))?;
    set("transport/link/tls/root_ca_certificate", json!(format!("{folder}/authority.pem")))?;
    set("transport/link/tls/connect_certificate", json!(format!("{folder}/{name}.pem")))?;
    set("transport/link/tls/connect_private_key", json!(format!("{folder}/{name}.key")))?;
    set("transport/link/tls/enable_mtls", json!(true))?;
    let session = zenoh::open(config).wait()?;

    // as long as this lives the commander is there
    let _alive = session.liveliness().declare_token(format!("sinew/{rig}/commander/{name}/alive")).wait()?;
    let command = format!("sinew/{rig}/commander/{name}/command");
    let stroke: f64 = stroke.parse()?;
    let request = json!({ "call": "set", "channel": channel, "kind": "stroke", "value": stroke, "hold_s": LEASE_S });
    loop {
        let replies = session.get(&command).payload(request.to_string()).wait()?;
        match replies.recv()?.into_result() {
            Ok(done) => println!("{}", done.payload().try_to_string()?),
            Err(refused) => println!("{}", refused.payload().try_to_string()?),
        }
        std::thread::sleep(Duration::from_secs_f64(LEASE_S / 10.0));
    }
}

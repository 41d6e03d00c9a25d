//! `sinew bridge`: metrics for Prometheus and cycles for Foxglove, of real drivers; by readers of these tests' own, and by the
//! programs they are for where these are installed.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use sinew_ipc::{ChannelState, Client, CommandKind};
use sinew_tests::{Driver, PATIENCE, Process, Rig, checkout, sinew, wait_for, wait_until};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

const LONG: Duration = Duration::from_secs(120);

/// A bridge of this rig, and the address it has said.
fn bridge(rig: &Rig, to: &str, more: &[&str]) -> (Process, SocketAddr) {
    let mut command = Command::new(sinew());
    command.args(["bridge", to, "--listen", "127.0.0.1:0", "--rig", &rig.name]).args(more);
    let mut bridge = Process::start(&mut command);
    bridge.wait_for_word("\n");
    let url = bridge.stdout();
    let address = url.trim().trim_start_matches("http://").trim_start_matches("ws://").trim_end_matches("/metrics");
    (bridge, address.parse().unwrap_or_else(|e| panic!("{e}: {url}")))
}

/// The whole answer to a request.
fn get(address: SocketAddr, path: &str, accept: &str) -> (String, String) {
    let mut stream = TcpStream::connect(address).expect("somebody listens");
    stream.set_read_timeout(Some(PATIENCE)).expect("a socket takes a timeout");
    write!(stream, "GET {path} HTTP/1.1\r\nHost: elsewhere.example\r\nAccept: {accept}\r\nConnection: close\r\n\r\n")
        .expect("it is read");
    let mut answer = String::new();
    stream.read_to_string(&mut answer).expect("text");
    let (head, body) = answer.split_once("\r\n\r\n").unwrap_or_else(|| panic!("no body: {answer}"));
    (head.into(), body.into())
}

const OPEN_METRICS: &str = "application/openmetrics-text;version=1.0.0,text/plain;version=0.0.4;q=0.5";

/// A page of metrics: each sample by its name with its labels.
#[derive(Debug)]
struct Page(BTreeMap<String, f64>);

impl Page {
    fn of(address: SocketAddr) -> Page {
        let (head, body) = get(address, "/metrics", OPEN_METRICS);
        assert!(
            head.starts_with("HTTP/1.1 200") && head.contains("application/openmetrics-text; version=1.0.0"),
            "{head}"
        );
        assert!(body.ends_with("# EOF\n"), "{body}");
        let lines = body.lines().filter(|line| !line.starts_with('#'));
        let sample = |line: &str| {
            let (name, value) = line.rsplit_once(' ').unwrap_or_else(|| panic!("no value: {line}"));
            (name.to_string(), value.parse().unwrap_or_else(|e| panic!("{e}: {line}")))
        };
        Page(lines.map(sample).collect())
    }

    #[track_caller]
    fn value(&self, rig: &Rig, name: &str, labels: &str) -> f64 {
        let comma = if labels.is_empty() { "" } else { "," };
        let sample = format!("sinew_{name}{{rig=\"{}\"{comma}{labels}}}", rig.name);
        *self.0.get(&sample).unwrap_or_else(|| panic!("no {sample} among {:?}", self.0.keys()))
    }
}

/// The strict parsers of Python's prometheus_client and promtool take a page in both its forms, where they are installed.
fn parses_strictly(rig: &Rig, address: SocketAddr) {
    let (_, open) = get(address, "/metrics", OPEN_METRICS);
    let (_, plain) = get(address, "/metrics", "*/*");
    let (open_file, plain_file) = (rig.file("open.txt"), rig.file("plain.txt"));
    fs::write(&open_file, &open).and_then(|()| fs::write(&plain_file, &plain)).expect("the folder is writable");
    let python = |code: &str, args: &[&Path]| Command::new("python3").args(["-c", code]).args(args).output();
    if python("import prometheus_client.openmetrics.parser", &[]).is_ok_and(|ran| ran.status.success()) {
        let code = "import sys, prometheus_client.openmetrics.parser as strict, prometheus_client.parser as plain\n\
                    count = lambda families: sum(len(family.samples) for family in families)\n\
                    print(count(strict.text_string_to_metric_families(open(sys.argv[1]).read())))\n\
                    print(count(plain.text_string_to_metric_families(open(sys.argv[2]).read())))";
        let ran = python(code, &[&open_file, &plain_file]).expect("it ran a moment ago");
        assert!(ran.status.success(), "{}\n{open}", String::from_utf8_lossy(&ran.stderr));
        let samples = |page: &str| page.lines().filter(|line| !line.starts_with('#')).count();
        let expected = format!("{}\n{}\n", samples(&open), samples(&plain));
        assert_eq!(String::from_utf8_lossy(&ran.stdout), expected, "every sample is understood");
    } else {
        eprintln!("skipped: Python has no prometheus_client here");
    }
    let mut promtool = Command::new("promtool");
    promtool.args(["check", "metrics"]).stdin(fs::File::open(&plain_file).expect("it was written"));
    match promtool.output() {
        Ok(ran) => assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr)),
        Err(_) => eprintln!("skipped: there is no promtool here"),
    }
}

#[test]
fn metrics_are_what_the_driver_says_and_that_it_is_gone_when_it_is() {
    let rig = Rig::bench(&["left", "right"], "");
    let (driver, client) = Driver::ready(&rig);
    let (bridge, address) = bridge(&rig, "prometheus", &[]);
    client.set_duty("left", 0.1, LONG).expect("it may be powered");
    wait_until("the duty", || client.latest().channels()[0].duty == 0.1);

    let before = client.latest();
    let page = Page::of(address);
    let after = client.latest();
    let left = |name: &str| page.value(&rig, &format!("channel_{name}"), "channel=\"left\"");
    assert_eq!(page.value(&rig, "up", ""), 1.0);
    assert_eq!(page.value(&rig, "driver_state", "state=\"running\""), 1.0);
    assert_eq!((left("duty_ratio"), left("max_temperature_celsius")), (0.1, client.channels()[0].max_temperature_c));
    let (low, high) = (before.channels()[0].temperature_c, after.channels()[0].temperature_c);
    assert!((low - 5.0..high + 5.0).contains(&left("temperature_celsius")), "{low} to {high} °C: {page:?}");
    assert!((left("length_meters") - after.channels()[0].length_m).abs() < 1e-3);
    for mode in ["duty", "off"] {
        assert_eq!(
            page.value(&rig, "channel_mode", &format!("channel=\"left\",mode=\"{mode}\"")),
            f64::from(mode == "duty")
        );
        assert_eq!(
            page.value(&rig, "channel_mode", &format!("channel=\"right\",mode=\"{mode}\"")),
            f64::from(mode == "off")
        );
    }
    assert!(page.0.keys().filter(|name| name.starts_with("sinew_channel_fault")).count() > 40);
    assert_eq!(page.value(&rig, "loop_allocations_total", ""), 0.0);
    assert_eq!(
        page.value(&rig, "lateness_seconds_count", ""),
        page.value(&rig, "lateness_seconds_bucket", "le=\"+Inf\"")
    );
    wait_until("the counters to go on", || Page::of(address).value(&rig, "cycles_total", "") > before.cycle as f64);
    parses_strictly(&rig, address);
    assert!(get(address, "/metrics", "*/*").1.contains("# TYPE sinew_cycles_total counter\n"));
    assert!(
        get(address, "/", "*/*").1.contains("/metrics")
            && get(address, "/figures", "*/*").0.starts_with("HTTP/1.1 404")
    );

    driver.stop();
    let page = Page::of(address);
    assert_eq!((page.value(&rig, "up", ""), page.value(&rig, "driver_state", "state=\"gone\"")), (0.0, 1.0));
    assert!(!page.0.keys().any(|name| name.contains("channel")), "nothing is said of wires nobody drives");
    parses_strictly(&rig, address);
    let driver = Driver::start(&rig);
    assert_eq!(Page::of(address).value(&rig, "up", ""), 1.0, "found again");
    bridge.signal(libc::SIGTERM);
    let finished = bridge.finish().expect(0);
    assert!(finished.stderr.contains("nothing refused"), "{finished:?}");
    driver.stop();
}

#[test]
fn a_bridge_waits_for_its_driver_and_says_what_is_amiss() {
    let rig = Rig::bench(&["left"], "");
    let (waiting, address) = bridge(&rig, "prometheus", &[]);
    assert_eq!(Page::of(address).value(&rig, "up", ""), 0.0);
    let listen = address.to_string();
    rig.ask(&["bridge", "foxglove", "--listen", &listen]).refused(&["cannot be listened at", "--listen"]);
    rig.ask(&["bridge", "foxglove", "--listen", "nowhere"]).refused(&["--listen"]);
    sinew_tests::run(["bridge", "prometheus", "--rig", "no such rig"]).refused(&["no such rig"]);
    // a program of its own, which these tests do not build
    let mut zenoh = Command::new(sinew());
    zenoh.args(["bridge", "zenoh", "--rig", &rig.name]).env("PATH", "");
    Process::start(&mut zenoh).finish().refused(&["sinew-zenoh", "tools/zenoh/Cargo.toml"]);
    let driver = Driver::start(&rig);
    assert_eq!(Page::of(address).value(&rig, "up", ""), 1.0);
    // one who can reach the network of this machine is told that others can
    let open = rig.ask(&["bridge", "prometheus", "--listen", "0.0.0.0:0", "--for", "0.2"]).expect(0);
    assert!(open.stderr.contains("whoever reaches 0.0.0.0:"), "{open:?}");
    waiting.kill();
    driver.stop();
}

/// The expressions of the dashboard, and those of its lists.
fn dashboard() -> Vec<String> {
    let text = fs::read_to_string(checkout().join("examples/grafana/sinew.json")).expect("it is in the checkout");
    let dashboard: Value = serde_json::from_str(&text).expect("JSON");
    let panels = dashboard["panels"].as_array().expect("panels").iter();
    let shown = panels.flat_map(|panel| panel["targets"].as_array().expect("targets")).map(|target| &target["expr"]);
    let listed = dashboard["templating"]["list"].as_array().expect("lists").iter().map(|list| &list["query"]);
    shown.chain(listed).filter_map(|expression| expression.as_str()).map(str::to_owned).collect()
}

#[test]
fn the_dashboard_shows_metrics_there_are() {
    let rig = Rig::bench(&["left"], "");
    let driver = Driver::start(&rig);
    let (bridge, address) = bridge(&rig, "prometheus", &[]);
    let page = Page::of(address);
    let names: BTreeSet<&str> = page.0.keys().filter_map(|sample| sample.split('{').next()).collect();
    let mut found = BTreeSet::new();
    for expression in dashboard() {
        for word in expression
            .split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'))
            .filter(|word| word.starts_with("sinew_"))
        {
            assert!(names.contains(word), "{word} in {expression} is no metric");
            found.insert(word.to_string());
        }
    }
    assert!(found.len() > 15, "{found:?}");
    bridge.kill();
    driver.stop();
}

#[test]
fn prometheus_itself_scrapes_it_and_every_panel_of_the_dashboard_has_an_answer() {
    if Command::new("prometheus").arg("--version").output().is_err() {
        return eprintln!("skipped: there is no prometheus here (apt-get install prometheus)");
    }
    let rig = Rig::bench(&["left"], "");
    let (driver, client) = Driver::ready(&rig);
    client.set_stroke("left", 0.3, LONG).expect("it may move");
    let (bridge, address) = bridge(&rig, "prometheus", &[]);
    let config = fs::read_to_string(checkout().join("examples/grafana/prometheus.yml")).expect("it is in the checkout");
    assert!(config.contains("127.0.0.1:9464"));
    fs::write(rig.file("prometheus.yml"), config.replace("127.0.0.1:9464", &address.to_string())).expect("writable");
    let free = TcpListener::bind("127.0.0.1:0").and_then(|taken| taken.local_addr()).expect("a port");
    let mut command = Command::new("prometheus");
    command
        .arg(format!("--config.file={}", rig.file("prometheus.yml").display()))
        .arg(format!("--storage.tsdb.path={}", rig.file("tsdb").display()))
        .arg(format!("--web.listen-address={free}"));
    let prometheus = Process::start(&mut command);
    let query = |expression: &str| -> Option<Value> {
        let bytes = expression.bytes().map(|b| format!("%{b:02x}")).collect::<String>();
        TcpStream::connect(free).ok()?;
        let (_, body) = get(free, &format!("/api/v1/query?query={bytes}"), "*/*");
        // its answers may come in chunks, each with its length before it
        let json = body.get(body.find('{')?..=body.rfind('}')?)?;
        let answer: Value = serde_json::from_str(json).ok()?;
        assert_ne!(answer["status"], "error", "{expression}: {answer}");
        Some(answer["data"]["result"].clone())
    };
    let one = |expression: &str| query(expression)?.get(0)?["value"][1].as_str()?.parse::<f64>().ok();
    wait_until("a scrape", || one("sinew_up") == Some(1.0));
    wait_until("the target's health", || one("up{job=\"sinew\"}") == Some(1.0));
    assert_eq!(one("sinew_channel_max_duty_ratio{channel=\"left\"}"), Some(client.channels()[0].max_duty));
    wait_until("a rate", || one("rate(sinew_cycles_total[30s])").is_some_and(|hz| hz > 1.0));
    for expression in dashboard().into_iter().filter(|expression| expression.contains("sinew_")) {
        let Some(expression) = (!expression.starts_with("label_values")).then_some(&expression) else { continue };
        let asked = expression.replace("$rig", ".*").replace("$channel", ".*");
        // of faults and of being held back there may be nothing
        let may_be_empty = ["fault", "flag"].iter().any(|word| asked.contains(word));
        wait_until(&asked, || query(&asked).is_some_and(|found| may_be_empty || found.get(0).is_some()));
    }
    driver.stop();
    wait_until("the driver's end to be scraped", || one("sinew_up") == Some(0.0));
    prometheus.kill();
    bridge.kill();
}

/// A viewer of these tests' own.
struct Viewer {
    socket: WebSocket<TcpStream>,
    /// Number of each topic.
    topics: BTreeMap<String, u64>,
}

impl Viewer {
    fn connect(address: SocketAddr) -> Viewer {
        let mut viewer = Viewer { socket: Viewer::upgrade(address), topics: BTreeMap::new() };
        let info = viewer.says("serverInfo");
        assert_eq!(info["capabilities"], json!([]), "it only shows");
        viewer
    }

    fn upgrade(address: SocketAddr) -> WebSocket<TcpStream> {
        let mut request = format!("ws://{address}/").into_client_request().expect("an address");
        request.headers_mut().insert("Sec-WebSocket-Protocol", "foxglove.websocket.v1".parse().expect("a header"));
        let stream = TcpStream::connect(address).expect("somebody listens");
        stream.set_read_timeout(Some(PATIENCE)).expect("a socket takes a timeout");
        let (socket, answer) = tungstenite::client(request, stream).expect("an upgrade");
        assert_eq!(answer.headers()["Sec-WebSocket-Protocol"], "foxglove.websocket.v1");
        socket
    }

    fn tell(&mut self, said: &Value) {
        self.socket.send(Message::text(said.to_string())).expect("it listens");
    }

    /// The next message. A machine that was paused is no reason to give up.
    #[track_caller]
    fn read(&mut self) -> Message {
        loop {
            match self.socket.read() {
                Err(tungstenite::Error::Io(error)) if error.kind() == std::io::ErrorKind::Interrupted => {}
                read => return read.expect("it says something"),
            }
        }
    }

    /// The next message in JSON of this kind.
    #[track_caller]
    fn says(&mut self, op: &str) -> Value {
        let end = Instant::now() + PATIENCE;
        loop {
            assert!(Instant::now() < end, "no {op} comes among the data");
            let Message::Text(text) = self.read() else { continue };
            let said: Value = serde_json::from_str(&text).expect("JSON");
            if said["op"] == "advertise" {
                let channels = said["channels"].as_array().expect("topics").iter();
                self.topics = channels
                    .map(|c| (c["topic"].as_str().expect("a name").into(), c["id"].as_u64().expect("a number")))
                    .collect();
            }
            if said["op"] == op {
                return said;
            }
        }
    }

    fn subscribe(&mut self, id: u32, topic: &str) {
        let said = json!({ "op": "subscribe", "subscriptions": [{ "id": id, "channelId": self.topics[topic] }] });
        self.tell(&said);
    }

    /// The next message of a subscription: its id, its time, and what it is.
    #[track_caller]
    fn data(&mut self) -> (u32, u64, Vec<u8>) {
        let end = Instant::now() + PATIENCE;
        loop {
            assert!(Instant::now() < end, "no data come");
            if let Message::Binary(frame) = self.read() {
                assert_eq!(frame[0], 1, "data of a topic");
                let id = u32::from_le_bytes(frame[1..5].try_into().expect("four bytes"));
                return (id, u64::from_le_bytes(frame[5..13].try_into().expect("eight bytes")), frame[13..].to_vec());
            }
        }
    }

    /// The next cycle: its number, the channels' bytes.
    #[track_caller]
    fn cycle(&mut self) -> (u64, Vec<u8>) {
        let (_, _, message) = self.data();
        assert_eq!(message[..4], [0, 1, 0, 0], "CDR, little endian");
        (u64::from_le_bytes(message[4..12].try_into().expect("eight bytes")), message[28..].to_vec())
    }
}

/// Cycles as the client has them, by their numbers.
fn as_the_client_has_them(client: &Client, count: usize) -> BTreeMap<u64, Vec<u8>> {
    let mut stream = client.stream().expect("a stream");
    let mut cycles = BTreeMap::new();
    while cycles.len() < count {
        if let Some(cycle) = stream.next_within(PATIENCE).expect("the driver runs") {
            cycles.insert(cycle.header.cycle, ChannelState::bytes_of(cycle.channels).to_vec());
        }
    }
    cycles
}

#[test]
fn a_viewer_gets_every_cycle_bit_by_bit_and_follows_the_driver_through_a_restart() {
    let rig = Rig::bench(&["left", "right"], "");
    let (driver, client) = Driver::ready(&rig);
    let (bridge, address) = bridge(&rig, "foxglove", &[]);
    let mut viewer = Viewer::connect(address);
    let advertised =
        wait_for("topics", || Some(viewer.says("advertise")).filter(|said| !said["channels"][0].is_null()));
    let channels = advertised["channels"].as_array().expect("topics");
    let names: Vec<&str> = channels.iter().filter_map(|channel| channel["topic"].as_str()).collect();
    assert_eq!(names, ["/cycles", "/events", "/loop"]);
    for channel in channels {
        assert_eq!((&channel["encoding"], &channel["schemaEncoding"]), (&json!("cdr"), &json!("ros2msg")));
    }
    assert!(
        channels[0]["schema"]
            .as_str()
            .is_some_and(|text| text.contains("sinew_msgs/Channel right") && text.contains("float64 temperature_c"))
    );

    viewer.subscribe(7, "/cycles");
    let first = viewer.cycle().0;
    let theirs = as_the_client_has_them(&client, 200);
    let mut compared = 0;
    let mut expected = first + 1;
    while compared < 150 {
        let (number, bytes) = viewer.cycle();
        assert_eq!(number, expected, "none is left out");
        expected += 1;
        if let Some(known) = theirs.get(&number) {
            assert_eq!(&bytes, known, "cycle {number}");
            compared += 1;
        }
    }
    // the time of day, as of now
    let now_ns =
        std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).expect("after 1970").as_nanos() as u64;
    let (id, unix_ns, _) = viewer.data();
    assert!(id == 7 && now_ns.abs_diff(unix_ns) < PATIENCE.as_nanos() as u64);

    // a viewer can ask for nothing but to look
    viewer.tell(
        &json!({ "op": "advertise", "channels": [{ "id": 1, "topic": "/set", "encoding": "cdr", "schemaName": "x" }] }),
    );
    assert_eq!(viewer.says("status")["id"], "only_shows");
    viewer.socket.send(Message::binary(vec![1, 0, 0, 0, 0, 9])).expect("it listens");
    assert_eq!(viewer.says("status")["id"], "only_shows");

    // the loop's figures; and no cycle any more
    viewer.tell(&json!({ "op": "unsubscribe", "subscriptionIds": [7] }));
    viewer.subscribe(8, "/loop");
    viewer.subscribe(9, "/events");
    let (_, _, figures) = wait_for("the loop's figures", || Some(viewer.data()).filter(|(id, ..)| *id == 8));
    assert!(u64::from_le_bytes(figures[20..28].try_into().expect("eight bytes")) >= first, "cycles that ran");

    driver.stop();
    assert_eq!(viewer.says("status")["id"], "driver");
    let driver = Driver::start(&rig);
    viewer.says("removeStatus");
    viewer.subscribe(7, "/cycles");
    let (id, ..) = wait_for("cycles of the next driver", || Some(viewer.data()).filter(|(id, ..)| *id == 7));
    assert_eq!(id, 7);
    driver.stop();

    // one with other channels has other topics
    let mut other = rig;
    other.add(&Rig::wire("third"));
    let before = viewer.topics["/cycles"];
    let driver = Driver::start(&other);
    viewer.says("unadvertise");
    viewer.says("advertise");
    assert_ne!(viewer.topics["/cycles"], before);
    viewer.subscribe(1, "/cycles");
    let (_, bytes) = viewer.cycle();
    assert_eq!(bytes.len(), 3 * size_of::<ChannelState>());
    bridge.signal(libc::SIGTERM);
    let finished = bridge.finish().expect(0);
    assert!(finished.stderr.contains("messages lost by viewers that were too slow: 0"), "{finished:?}");
    driver.stop();
}

#[test]
fn a_slow_viewer_loses_messages_which_are_counted_and_nobody_waits_for_it() {
    let rig = Rig::bench(&["left", "right"], "");
    let (driver, client) = Driver::ready(&rig);
    let (bridge, address) = bridge(&rig, "foxglove", &[]);
    let mut viewers = [(); 2].map(|()| Viewer::connect(address));
    for viewer in &mut viewers {
        viewer.says("advertise");
    }
    let [slow, fast] = &mut viewers;
    // as often as it may, so that what the system keeps for it is full sooner
    (0..16).for_each(|id| slow.subscribe(id, "/cycles"));
    fast.subscribe(0, "/cycles");
    let first = fast.cycle().0;
    let mut expected = first + 1;
    // 16 copies of 400 bytes 500 times a second: what sockets keep is full after two seconds, and the ring two later
    while expected < first + 6000 {
        assert_eq!(fast.cycle().0, expected, "one that keeps up gets every cycle");
        expected += 1;
    }
    let lost = wait_for("a word of what was lost", || Some(slow.says("status")).filter(|said| said["id"] == "lost"));
    assert_eq!(lost["level"], 1, "{lost}");
    let count: u64 = lost["message"].as_str().and_then(|text| text.split(' ').next()?.parse().ok()).expect("a number");
    assert!(count > 0, "{lost}");
    assert!(client.is_alive());
    bridge.signal(libc::SIGTERM);
    let finished = bridge.finish().expect(0);
    let (_, said) = finished.stderr.split_once("too slow: ").unwrap_or_else(|| panic!("{finished:?}"));
    let all: u64 = said.split_whitespace().next().and_then(|count| count.parse().ok()).expect("a number");
    assert!(all >= count, "{finished:?}");
    driver.stop();
}

#[test]
fn viewers_are_bounded_and_what_is_none_is_refused() {
    let rig = Rig::bench(&["left"], "");
    let driver = Driver::start(&rig);
    let (bridge, address) = bridge(&rig, "foxglove", &["--rate", "50"]);
    let mut viewers: Vec<Viewer> = (0..16).map(|_| Viewer::connect(address)).collect();
    let mut one_more = Viewer::upgrade(address);
    let Ok(Message::Close(Some(closed))) = one_more.read() else { panic!("seventeen viewers") };
    assert_eq!((u16::from(closed.code), closed.reason.as_str()), (1013, "too many clients are connected"));
    let (head, body) = get(address, "/", "*/*");
    assert!(head.starts_with("HTTP/1.1 4"), "a plain request: {head} {body}");
    // nonsense costs the sender its connection
    viewers[1].socket.send(Message::text("nonsense")).expect("it listens");
    let end = Instant::now() + PATIENCE;
    while !matches!(viewers[1].socket.read(), Ok(Message::Close(_)) | Err(_)) {
        assert!(Instant::now() < end, "nonsense is put up with");
    }
    // as many cycles as were asked for
    let viewer = &mut viewers[0];
    viewer.says("advertise");
    viewer.subscribe(0, "/cycles");
    let (_, from_ns, _) = viewer.data();
    let to_ns = (0..50).map(|_| viewer.data().1).last().expect("fifty");
    let hz = 50.0 / ((to_ns - from_ns) as f64 * 1e-9);
    assert!((40.0..=51.0).contains(&hz), "{hz} cycles a second");
    bridge.kill();
    driver.stop();
}

/// The folder of npm's packages, where node and these are: `SINEW_NODE_MODULES`, or where node looks by itself.
fn node_has(packages: &[&str]) -> bool {
    let code = packages.iter().map(|package| format!("require('{package}');")).collect::<String>();
    let mut node = Command::new("node");
    node.args(["-e", &code]);
    set_node_path(&mut node);
    let there = node.output().is_ok_and(|ran| ran.status.success());
    if !there {
        eprintln!(
            "skipped: node with {} is needed (npm install, then SINEW_NODE_MODULES=…/node_modules)",
            packages.join(", ")
        );
    }
    there
}

fn set_node_path(node: &mut Command) {
    if let Some(folder) = std::env::var_os("SINEW_NODE_MODULES") {
        node.env("NODE_PATH", folder);
    }
}

#[test]
fn foxgloves_own_client_shows_what_the_driver_publishes() {
    if !node_has(&["@foxglove/ws-protocol", "@foxglove/rosmsg", "@foxglove/rosmsg2-serialization", "ws"]) {
        return;
    }
    let rig = Rig::bench(&["left", "right"], "");
    let (driver, client) = Driver::ready(&rig);
    client.command(1, CommandKind::Duty, 0.05, LONG).expect("it may be powered");
    let (bridge, address) = bridge(&rig, "foxglove", &[]);
    let script = rig.file("viewer.js");
    fs::write(&script, VIEWER).expect("the folder is writable");
    let mut node = Command::new("node");
    node.arg(&script).arg(format!("ws://{address}"));
    set_node_path(&mut node);
    let node = Process::start(&mut node);
    let theirs = as_the_client_has_them(&client, 3000);
    let finished = node.finish().expect(0);
    let mut compared = 0;
    for line in finished.stdout.lines() {
        let cycle: Value = serde_json::from_str(line).expect("JSON");
        let Some(known) = theirs.get(&cycle["cycle"].as_str().expect("a number").parse().expect("a number")) else {
            continue;
        };
        for (channel, bytes) in ["left", "right"].iter().zip(known.chunks(size_of::<ChannelState>())) {
            let shown = &cycle[channel];
            for (place, field) in ChannelState::FIELDS.iter().enumerate() {
                let seen: f64 = shown[field.name].as_str().and_then(|text| text.parse().ok()).expect("a number");
                let value = match place.checked_sub(ChannelState::FLOATS) {
                    None => f64::from_le_bytes(bytes[8 * place..][..8].try_into().expect("eight bytes")),
                    Some(code) => {
                        let at = 8 * ChannelState::FLOATS + 4 * code;
                        f64::from(u32::from_le_bytes(bytes[at..][..4].try_into().expect("four bytes")))
                    }
                };
                assert!(
                    seen == value || (seen.is_nan() && value.is_nan()),
                    "{channel} {}: {seen} for {value}",
                    field.name
                );
            }
        }
        compared += 1;
    }
    assert!(compared >= 50, "{compared} cycles compared, of {}", finished.stdout.lines().count());
    bridge.kill();
    driver.stop();
}

/// A viewer by the packages that Foxglove itself is made of: prints a hundred cycles as JSON, every number as text: no digit is
/// lost, and there are NaN and Infinity.
const VIEWER: &str = r#"
const { FoxgloveClient } = require("@foxglove/ws-protocol");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");
const WebSocket = require("ws");
const client = new FoxgloveClient({ ws: new WebSocket(process.argv[2], [FoxgloveClient.SUPPORTED_SUBPROTOCOL]) });
const readers = new Map();
let count = 0;
client.on("error", (error) => { console.error(error); process.exit(1); });
client.on("advertise", (channels) => {
  for (const channel of channels.filter((channel) => channel.topic === "/cycles")) {
    if (channel.encoding !== "cdr" || channel.schemaEncoding !== "ros2msg") throw new Error("no ROS 2 message");
    readers.set(client.subscribe(channel.id), new MessageReader(parse(channel.schema, { ros2: true })));
  }
});
client.on("message", ({ subscriptionId, data }) => {
  const message = readers.get(subscriptionId).readMessage(data);
  console.log(JSON.stringify(message, (_, value) => (typeof value === "object" ? value : String(value))));
  if (++count === 100) { client.close(); process.exit(0); }
});
"#;

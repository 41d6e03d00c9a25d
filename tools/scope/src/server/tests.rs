//! The server's bounds, from outside: connections and pages of the tests' own, written byte by byte since no library sends
//! what they send. No driver is needed: what a page sees of one is put there.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use axum::extract::ws::close_code;
use rustls::pki_types::{CertificateDer, ServerName};
use rustls::{ClientConfig, ClientConnection, RootCertStore, StreamOwned};
use serde_json::{Value, json};
use sinew_server::{Flow, answer};
use tempfile::TempDir;
use tokio::sync::oneshot;
use tokio::task::JoinSet;

use super::*;
use crate::history::Shape;

mod network;

/// How long a test waits for what has to come.
const PATIENCE: Duration = Duration::from_secs(60);
/// None come back once they are spent.
const NEVER: f64 = 1e-9;

/// A server within these limits, until it is dropped.
struct Server {
    shared: Arc<Shared>,
    port: u16,
    secured: Option<Secured>,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

/// Its port on what stands for the network: another address of loopback.
struct Secured {
    address: SocketAddr,
    trusting: Arc<ClientConfig>,
    events: Arc<Mutex<Vec<String>>>,
    _folder: TempDir,
}

impl Server {
    fn new(limits: Limits) -> Server {
        let (shared, listener) = Server::shared(limits);
        Server::of(shared, listener, None)
    }

    /// One that is on the network as well, each way in with these limits.
    fn on_the_network(limits: Limits, commands: bool) -> Server {
        let (mut shared, loopback) = Server::shared(limits.clone());
        let listener = listen(([127, 0, 0, 2], 0).into()).unwrap();
        let address = listener.local_addr().unwrap();
        let folder = tempfile::tempdir().unwrap();
        let certificate = Certificate::kept(&folder.path().join("scope.pem"), &[address.ip().to_string()]).unwrap();
        shared.network = Some(Arc::new(Entrance {
            access: AccessControl::network(&["bench".into()], address.port()),
            lock: Some(Lock::new(limits.pins, commands).unwrap()),
            traffic: Arc::new(Traffic::new(limits)),
        }));
        let events = Arc::new(Mutex::new(Vec::new()));
        let heard = events.clone();
        shared.events = Some(Box::new(move |event| heard.lock().unwrap().push(format!("{event:?}"))));
        let trusting = network::trusting(certificate.der());
        let mut server = Server::of(shared, loopback, Some((listener, certificate)));
        server.secured = Some(Secured { address, trusting, events, _folder: folder });
        server
    }

    fn shared(limits: Limits) -> (Shared, TcpListener) {
        let listener = listen((Ipv4Addr::LOCALHOST, 0).into()).unwrap();
        let port = listener.local_addr().unwrap().port();
        let options = Options { port, record_dir: ".".into(), commands: true, network: None };
        let mut view = View::of(Shape { channels: 1, quantities: 2, rate_hz: 1000.0, longest_s: 60.0 });
        [view.hello, view.status] = ["hello", "status"].map(|kind| json!({ "kind": kind }).to_string());
        view.epoch = 1;
        let shared = Shared {
            name: "none".into(),
            token: Token::new().unwrap(),
            loopback: Arc::new(Entrance {
                access: AccessControl::loopback(port),
                traffic: Arc::new(Traffic::new(limits)),
                lock: None,
            }),
            network: None,
            stop: AtomicBool::new(false),
            recorder: Mutex::new(Button::of_driver(&options.record_dir, "none")),
            picture: None,
            events: None,
            view: Mutex::new(view),
            origin_ns: 0,
            options,
        };
        (shared, listener)
    }

    /// What this scope shows to its pages.
    fn showing(scope: Scope) -> Server {
        Server::of(scope.shared, scope.listener, None)
    }

    fn of(shared: Shared, listener: TcpListener, network: Option<(TcpListener, Certificate)>) -> Server {
        let (shared, port) = (Arc::new(shared), listener.local_addr().unwrap().port());
        let (stop, stopped) = oneshot::channel::<()>();
        let ports = ports(&shared, listener, network);
        let thread = std::thread::spawn(move || {
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
            runtime.block_on(async {
                let mut answering: JoinSet<_> = ports.into_iter().map(answer).collect();
                tokio::select! { Some(ended) = answering.join_next() => ended.unwrap().unwrap(), _ = stopped => {} }
            });
        });
        Server { shared, port, secured: None, stop: Some(stop), thread: Some(thread) }
    }

    fn connect(&self) -> TcpStream {
        let line = TcpStream::connect((Ipv4Addr::LOCALHOST, self.port)).unwrap();
        line.set_read_timeout(Some(PATIENCE)).unwrap();
        line
    }

    /// The whole answer to a request for this path; nothing where the connection was closed instead.
    fn get(&self, path: &str) -> String {
        self.ask(path, &format!("127.0.0.1:{}", self.port))
    }

    fn ask(&self, path: &str, host: &str) -> String {
        let mut line = self.connect();
        let _ = write!(line, "GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n");
        rest(&mut line)
    }

    /// A live page of this origin, and the first line of the answer.
    fn upgrade(&self, origin: &str) -> (Page, String) {
        upgrade(self.connect(), &format!("127.0.0.1:{}", self.port), origin)
    }

    fn page(&self) -> Page {
        let (page, answer) = self.upgrade(&format!("http://127.0.0.1:{}", self.port));
        assert!(answer.starts_with("HTTP/1.1 101"), "{answer}");
        page
    }

    fn figures(&self) -> Figures {
        self.shared.figures()
    }

    fn refused(&self, what: &str) -> u64 {
        self.figures().refused[what]
    }

    /// Waits until the figures are as they should be.
    #[track_caller]
    fn wait(&self, what: &str, is: impl Fn(&Figures) -> bool) {
        self.meanwhile(what, is, || std::thread::sleep(Duration::from_millis(2)));
    }

    /// Does this until the figures are as they should be.
    #[track_caller]
    fn meanwhile(&self, what: &str, is: impl Fn(&Figures) -> bool, mut act: impl FnMut()) {
        let end = Instant::now() + PATIENCE;
        while !is(&self.figures()) {
            assert!(Instant::now() < end, "{what} has not come: {:?}", self.figures());
            act();
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        drop(self.stop.take());
        let served = self.thread.take().map(JoinHandle::join);
        assert!(std::thread::panicking() || matches!(served, Some(Ok(()))), "the server has panicked");
    }
}

/// Asks for a live page of this host, from one of this origin; and the first line of the answer.
fn upgrade<S: Read + Write>(mut line: S, host: &str, origin: &str) -> (Page<S>, String) {
    write!(
        line,
        "GET /live HTTP/1.1\r\nHost: {host}\r\nOrigin: {origin}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
         Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n",
    )
    .unwrap();
    let mut head = Vec::new();
    while !head.ends_with(b"\r\n\r\n") {
        let mut byte = [0];
        line.read_exact(&mut byte).expect("an answer");
        head.extend(byte);
    }
    (Page(line), String::from_utf8_lossy(&head).lines().next().unwrap_or_default().into())
}

/// All that comes until the connection is closed, in whatever way.
fn rest(line: &mut impl Read) -> String {
    let mut said = Vec::new();
    if let Err(error) = line.read_to_end(&mut said) {
        let closed = [std::io::ErrorKind::ConnectionReset, std::io::ErrorKind::UnexpectedEof];
        assert!(closed.contains(&error.kind()), "still open: {error}");
    }
    String::from_utf8_lossy(&said).into_owned()
}

const CONTINUED: u8 = 0;
const TEXT: u8 = 1;
const BINARY: u8 = 2;
const CLOSE: u8 = 8;
const LAST: u8 = 0x80;

/// The other end of a live page.
struct Page<S = TcpStream>(S);

impl<S: Read + Write> Page<S> {
    /// A frame with this first byte. Its mask is all zeros, which leaves the content as it is.
    fn send(&mut self, first: u8, content: &[u8]) {
        let mut frame = vec![first];
        match content.len() {
            short @ ..126 => frame.push(0x80 | short as u8),
            long => {
                frame.push(0x80 | 126);
                frame.extend(u16::try_from(long).unwrap().to_be_bytes());
            }
        }
        frame.extend([0; 4]);
        frame.extend(content);
        // whoever was turned away may no longer be listened to
        let _ = self.0.write_all(&frame);
    }

    fn say(&mut self, message: &Value) {
        self.send(LAST | TEXT, message.to_string().as_bytes());
    }

    /// The next frame: its kind and content; none once the connection is closed.
    fn receive(&mut self) -> Option<(u8, Vec<u8>)> {
        let mut head = [0; 2];
        if let Err(error) = self.0.read_exact(&mut head) {
            assert_ne!(error.kind(), std::io::ErrorKind::WouldBlock, "nothing comes");
            return None;
        }
        let mut read = |length: usize| {
            let mut bytes = vec![0; length];
            self.0.read_exact(&mut bytes).ok().map(|()| bytes)
        };
        let length = match head[1] {
            126 => read(2)?.iter().fold(0, |sum, byte| sum << 8 | usize::from(*byte)),
            127 => read(8)?.iter().fold(0, |sum, byte| sum << 8 | usize::from(*byte)),
            short => usize::from(short),
        };
        Some((head[0] & 0xf, read(length)?))
    }

    /// The next message of this kind.
    fn told(&mut self, kind: &str) -> Value {
        let end = Instant::now() + PATIENCE;
        loop {
            assert!(Instant::now() < end, "no {kind} has come");
            let (what, content) = self.receive().expect("a page that is served");
            let message = if what == TEXT { serde_json::from_slice(&content).unwrap() } else { Value::Null };
            if message["kind"] == kind {
                return message;
            }
        }
    }

    /// Acknowledges what came under this number.
    fn saw(&mut self, number: &Value) {
        self.say(&json!({ "do": "seen", "frame": number }));
    }

    /// How many messages of this kind come before so many looks at the state, ten a second.
    fn counts(&mut self, kind: &str, looks: usize) -> usize {
        let (mut count, mut looked) = (0, 0);
        while looked < looks {
            let (what, content) = self.receive().expect("a page that is served");
            let message: Value = if what == TEXT { serde_json::from_slice(&content).unwrap() } else { Value::Null };
            count += usize::from(message["kind"] == kind);
            looked += usize::from(message["kind"] == "status");
        }
        count
    }

    /// The code and reason for which it is closed.
    fn closed(&mut self) -> Option<(u16, String)> {
        let end = Instant::now() + PATIENCE;
        loop {
            assert!(Instant::now() < end, "it stays open");
            if let (CLOSE, content) = self.receive()? {
                let (code, reason) = content.split_first_chunk().unwrap();
                return Some((u16::from_be_bytes(*code), String::from_utf8_lossy(reason).into_owned()));
            }
        }
    }
}

fn told_off(why: Refusal) -> Option<(u16, String)> {
    Some((close_code::POLICY, why.words().into()))
}

#[test]
fn a_connection_that_sends_nothing_holds_nobody_up() {
    let server = Server::new(Limits::default());
    let silent: Vec<TcpStream> = (0..40).map(|_| server.connect()).collect();
    let mut half = server.connect();
    half.write_all(b"GET / HTTP/1.1\r\nHost: 127").unwrap();
    assert!(server.get("/").starts_with("HTTP/1.1 200"));
    server.page().told("status");
    assert_eq!((server.figures().connections, server.figures().refused_in_all), (43, 0));
    drop((silent, half));
    server.wait("an end of all", |now| now.connections_open == 0 && now.refused_in_all == 0);
}

#[test]
fn a_connection_that_does_not_get_on_with_its_request_ends() {
    let server = Server::new(Limits { request: Duration::from_millis(200), ..Limits::default() });
    let mut silent = server.connect();
    let mut slow = server.connect();
    slow.write_all(b"GET / HTTP/1.1\r\n").unwrap();
    // a byte now and then is no progress
    let both = |now: &Figures| now.refused["stalled_connections"] == 2;
    server.meanwhile("an end of both", both, || {
        let _ = slow.write_all(b"a");
        std::thread::sleep(Duration::from_millis(5));
    });
    assert_eq!([rest(&mut silent), rest(&mut slow)], ["", ""]);
    server.wait("an end of both", |now| now.connections_open == 0);
    assert_eq!((server.refused("stalled_connections"), server.figures().refused_in_all), (2, 2));
}

#[test]
fn a_live_page_lasts_longer_than_a_request_may() {
    let server = Server::new(Limits { request: Duration::from_millis(200), ..Limits::default() });
    let mut page = server.page();
    let mut silent = server.connect();
    rest(&mut silent);
    page.told("status");
    page.told("status");
    assert_eq!((server.figures().clients_open, server.refused("stalled_connections")), (1, 1));
}

#[test]
fn connections_are_bounded_at_once() {
    let server = Server::new(Limits { connections: 3, ..Limits::default() });
    let held = [(); 3].map(|()| server.connect());
    server.wait("three connections", |now| now.connections_open == 3);
    assert_eq!(server.get("/"), "");
    assert_eq!((server.refused("connections_at_once"), server.figures().connections), (1, 3));
    drop(held);
    server.wait("room", |now| now.connections_open == 0);
    assert!(server.get("/").starts_with("HTTP/1.1 200"));
}

#[test]
fn connections_are_bounded_a_second_and_carry_one_request() {
    let server = Server::new(Limits { connecting: Flow { at_once: 3.0, a_second: NEVER }, ..Limits::default() });
    for _ in 0..3 {
        let answer = server.get("/");
        assert!(answer.starts_with("HTTP/1.1 200") && answer.contains("\r\nconnection: close\r\n"), "{answer}");
    }
    assert_eq!([server.get("/"), server.get("/figures")], ["", ""]);
    assert_eq!((server.refused("connections_a_second"), server.figures().connections), (2, 3));
    // so that the bound is one of requests too
    let server = Server::new(Limits::default());
    let request = format!("GET /figures HTTP/1.1\r\nHost: 127.0.0.1:{}\r\n\r\n", server.port);
    let mut line = server.connect();
    line.write_all(request.repeat(2).as_bytes()).unwrap();
    assert_eq!(rest(&mut line).matches("HTTP/1.1 ").count(), 1);
}

#[test]
fn foreign_hosts_and_origins_are_counted() {
    let server = Server::new(Limits::default());
    for host in ["evil.example", "localhost", "[::1]"] {
        assert!(server.ask("/figures", &format!("{host}:{}", server.port)).starts_with("HTTP/1.1 421"), "{host}");
        let (_, answer) = server.upgrade(&format!("http://{host}:{}", server.port));
        assert!(answer.starts_with("HTTP/1.1 403"), "{answer}");
    }
    let answer = server.get("/figures");
    let said: Value = serde_json::from_str(answer.split("\r\n\r\n").nth(1).expect("a body")).unwrap();
    assert_eq!(said["refused"]["foreign_hosts"], 3);
    assert_eq!(said["refused"]["foreign_origins"], 3);
    assert_eq!((&said["refused_in_all"], &said["connections"], &said["clients"]), (&json!(6), &json!(7), &json!(0)));
}

#[test]
fn pages_are_bounded_at_once_and_told_so() {
    let server = Server::new(Limits { clients: 1, ..Limits::default() });
    let mut first = server.page();
    let mut second = server.page();
    second.say(&json!({ "do": "token", "token": "0" }));
    assert_eq!(second.closed(), Some((close_code::AGAIN, Refusal::ClientsAtOnce.words().into())));
    first.told("status");
    let figures = server.figures();
    assert_eq!((figures.clients, figures.clients_open, figures.refused["clients_at_once"]), (1, 1, 1));
    assert_eq!(figures.refused_in_all, 1, "what one that was turned away says is not heard");
    drop(first);
    server.wait("room", |now| now.clients_open == 0);
    server.page().told("status");
}

#[test]
fn messages_of_a_page_are_bounded_a_second() {
    let server = Server::new(Limits { messages: Flow { at_once: 5.0, a_second: NEVER }, ..Limits::default() });
    let (mut other, mut page) = (server.page(), server.page());
    (0..5).for_each(|frame| page.say(&json!({ "do": "seen", "frame": frame })));
    other.say(&json!({ "do": "seen", "frame": 0 }));
    page.told("status");
    assert_eq!(server.figures().refused_in_all, 0);
    // pings are messages too
    page.send(LAST | 9, b"");
    assert_eq!(page.closed(), told_off(Refusal::MessagesASecond));
    server.wait("its end", |now| now.clients_open == 1);
    other.told("status");
    assert_eq!((server.refused("messages_a_second"), server.figures().refused_in_all), (1, 1));
}

#[test]
fn who_was_turned_away_is_counted_once() {
    let messages = Flow { at_once: 1.0, a_second: NEVER };
    let bytes = Flow { at_once: 2000.0, a_second: NEVER };
    let server = Server::new(Limits { messages, bytes, ..Limits::default() });
    let mut page = server.page();
    (0..2).for_each(|frame| page.say(&json!({ "do": "seen", "frame": frame })));
    assert_eq!(page.closed(), told_off(Refusal::MessagesASecond));
    (0..1000).for_each(|_| page.send(LAST | TEXT, b"{}"));
    server.wait("its end", |now| now.connections_open == 0);
    assert_eq!((server.refused("messages_a_second"), server.figures().refused_in_all), (1, 1));
}

#[test]
fn messages_that_no_page_sends_are_refused() {
    let server = Server::new(Limits { message: 1000, ..Limits::default() });
    let fits = json!({ "do": "seen", "frame": 1 }).to_string();
    let odd: [(u8, Vec<u8>); 5] = [
        (LAST | TEXT, format!("{fits:1001}").into()),
        (LAST | TEXT, b"{}".to_vec()),
        (LAST | TEXT, vec![0xff, 0xfe]),
        (LAST | BINARY, fits.clone().into()),
        // no frame of this kind is known
        (LAST | 3, fits.clone().into()),
    ];
    for (count, (first, content)) in odd.iter().enumerate() {
        let mut page = server.page();
        page.send(LAST | TEXT, format!("{fits:1000}").as_bytes());
        page.told("status");
        page.send(*first, content);
        page.closed();
        server.wait("its end", |now| now.clients_open == 0);
        assert_eq!(server.refused("odd_messages"), count as u64 + 1, "{content:?}");
    }
    // a MiB that is claimed is not waited for
    let mut page = server.page();
    page.0.write_all(&[LAST | TEXT, 0x80 | 127, 0, 0, 0, 0, 0, 0x10, 0, 0, 0, 0, 0, 0]).unwrap();
    page.closed();
    // one that just leaves has done nothing
    drop(server.page());
    server.wait("an end of both", |now| now.clients == 7 && now.clients_open == 0);
    assert_eq!((server.refused("odd_messages"), server.figures().refused_in_all), (6, 6));
}

#[test]
fn bytes_of_a_connection_are_bounded_whatever_they_are() {
    let server = Server::new(Limits { bytes: Flow { at_once: 2000.0, a_second: NEVER }, ..Limits::default() });
    // pieces of a message that never ends, each of nothing: neither long nor a message
    let mut page = server.page();
    page.send(TEXT, b"");
    (0..1000).for_each(|_| page.send(CONTINUED, b""));
    page.closed();
    server.wait("its end", |now| now.connections_open == 0);
    assert_eq!((server.refused("bytes_a_second"), server.figures().refused_in_all), (1, 1));
    let mut line = server.connect();
    let _ = write!(line, "GET / HTTP/1.1\r\nX: {}\r\n", "x".repeat(3000));
    assert!(!rest(&mut line).starts_with("HTTP/1.1 200"));
    server.wait("its end", |now| now.connections_open == 0);
    assert_eq!((server.refused("bytes_a_second"), server.figures().refused_in_all), (2, 2));
}

#[test]
fn a_page_that_fetches_nothing_is_dropped_and_holds_nobody_up() {
    let server = Server::new(Limits { patience: Duration::from_secs(1), ..Limits::default() });
    // more than the system takes in for it, in little time
    server.shared.view().status = json!({ "kind": "status", "much": "x".repeat(2 << 20) }).to_string();
    let (slow, mut other) = (server.page(), server.page());
    server.meanwhile("a refusal", |now| now.refused["slow_clients"] == 1, || drop(other.told("status")));
    other.told("status");
    server.wait("its end", |now| now.clients_open == 1);
    assert_eq!(server.figures().refused_in_all, 1, "{}", server.figures());
    drop(slow);
}

#[test]
fn requests_without_an_answer_yet_are_bounded() {
    let server = Server::new(Limits { unanswered: 2, ..Limits::default() });
    let mut page = server.page();
    let ask = |id| json!({ "do": "ask", "id": id, "what": { "record": { "on": false } } });
    page.say(&json!({ "do": "token", "token": server.shared.token.as_str() }));
    assert_eq!(page.told("may")["command"], true);
    let recorder = server.shared.recorder.lock().unwrap();
    (1..=3).for_each(|id| page.say(&ask(id)));
    let answer = page.told("answer");
    assert_eq!((&answer["id"], &answer["ok"]), (&json!(3), &json!(false)), "{answer}");
    assert_eq!(answer["message"], Refusal::RequestsUnanswered.words());
    drop(recorder);
    let mut answered = [(); 2].map(|()| page.told("answer")["id"].as_u64());
    answered.sort_unstable();
    assert_eq!(answered, [Some(1), Some(2)]);
    page.say(&ask(4));
    assert_eq!(page.told("answer")["message"], "nothing is being recorded");
    assert_eq!((server.refused("requests_unanswered"), server.figures().refused_in_all), (1, 1));
}

#[test]
fn wrong_tokens_and_commands_without_one_are_counted() {
    let server = Server::new(Limits::default());
    let mut page = server.page();
    page.say(&json!({ "do": "token", "token": "0".repeat(32) }));
    assert_eq!(page.told("may")["command"], false);
    page.say(&json!({ "do": "ask", "id": 7, "what": "all_off" }));
    assert_eq!(page.told("answer")["ok"], false);
    assert_eq!((server.refused("wrong_tokens"), server.refused("commands_without_token")), (1, 1));
    assert_eq!(server.figures().refused_in_all, 2);
}

#[test]
fn a_long_history_comes_in_frames_of_bounded_length() {
    let server = Server::new(Limits { frame: 4000, ..Limits::default() });
    for i in 0..1000 {
        server.shared.view().history.push(f64::from(i), [1.0, 2.0]);
    }
    let mut page = server.page();
    page.say(&json!({ "do": "show", "generation": 1, "series": [[0, 0]] }));
    let (mut bins, mut frames) = (0, 0);
    loop {
        let (what, content) = page.receive().expect("a page that is served");
        if what != BINARY {
            continue;
        }
        assert!(content.len() <= 32 + 4000, "{} bytes", content.len());
        let word = |at: usize| u32::from_le_bytes(content[4 * at..][..4].try_into().unwrap());
        assert_eq!(content.len() as u32, 32 + 12 * word(3));
        frames += 1;
        bins += word(3);
        page.say(&json!({ "do": "seen", "frame": word(1) }));
        if word(5) == 0 {
            break;
        }
    }
    assert_eq!((bins, frames), (1000, 4), "333 bins of 12 bytes fit into one");
}

/// A scope of a stream that nothing is written into.
fn quiet() -> Scope {
    let (line, _) = std::io::pipe().unwrap();
    let scope = Scope::plot(
        Stream::of_pipe("quiet", line.into()),
        Options { port: 0, record_dir: ".".into(), commands: false, network: None },
    );
    let scope = scope.unwrap();
    scope.shared.view().status = json!({ "kind": "status" }).to_string();
    scope
}

/// A picture of a ball here, m.
fn ball_at(x: f64) -> Value {
    json!({
        "shapes": [{ "line": [-0.1, 0.0, 0.1, 0.0], "width": 0.004, "ink": "body" }, { "disc": [x, 0.01], "radius": 0.01, "ink": "load" }],
        "half_size": [0.15, 0.05],
        "says": format!("ball {x:+.3} m"),
    })
}

/// The machine, of which a test moves the ball.
fn machine() -> (Arc<Mutex<f64>>, Server) {
    let place = Arc::new(Mutex::new(0.0));
    let seen = place.clone();
    (place, Server::showing(quiet().with_picture(move || ball_at(*seen.lock().unwrap()).to_string())))
}

#[test]
fn a_page_is_told_of_the_machine_and_shown_it_as_it_moves() {
    let (place, server) = machine();
    let mut page = server.page();
    let hello = page.told("hello");
    assert_eq!((&hello["picture"], &hello["rig"], &hello["of"]), (&json!(true), &json!("quiet"), &json!("stream")));
    for x in [0.0, 0.012, -0.03, 0.0] {
        *place.lock().unwrap() = x;
        let told = page.told("picture");
        assert_eq!(told["picture"], ball_at(x));
        page.saw(&told["frame"]);
    }
    // a page that is opened later does not wait for it to move
    assert_eq!(server.page().told("picture")["picture"], ball_at(0.0));
}

#[test]
fn a_machine_that_stands_still_is_sent_once() {
    let (place, server) = machine();
    let mut page = server.page();
    let told = page.told("picture");
    page.saw(&told["frame"]);
    assert_eq!(page.counts("picture", 5), 0);
    *place.lock().unwrap() = 0.02;
    assert_eq!(page.counts("picture", 5), 1);
}

#[test]
fn a_page_that_acknowledges_no_picture_gets_the_last_one_once_it_does() {
    let place = Arc::new(Mutex::new(0.0));
    let seen = place.clone();
    // one that is nowhere twice
    let moves = move || {
        let mut x = seen.lock().unwrap();
        *x += 0.001;
        ball_at(*x).to_string()
    };
    let server = Server::showing(quiet().with_picture(moves));
    let mut page = server.page();
    let mut last = Value::Null;
    for _ in 0..4 {
        last = page.told("picture");
    }
    assert_eq!(page.counts("picture", 5), 0, "four wait for it already");
    let before = *place.lock().unwrap();
    page.saw(&last["frame"]);
    let says = page.told("picture")["picture"]["says"].as_str().expect("words").to_owned();
    let at: f64 = says.split(' ').nth(1).expect("a place").parse().expect("a number");
    assert!(at > before - 5e-4, "{says}, but it was at {before} m already");
}

#[test]
fn a_scope_without_a_picture_says_and_sends_none() {
    let server = Server::showing(quiet());
    let mut page = server.page();
    let hello = page.told("hello");
    assert_eq!((&hello["rig"], hello.get("picture")), (&json!("quiet"), None));
    assert_eq!(page.counts("picture", 5), 0);
    let view = server.shared.view();
    assert_eq!(view.hello(false), view.hello, "as it was");
}

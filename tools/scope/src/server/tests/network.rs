//! What comes from the network: through TLS, with the PIN, or not at all.

use super::*;

/// A connection through TLS.
type Secure = StreamOwned<ClientConnection, TcpStream>;

/// Trusts this certificate and no other.
pub fn trusting(der: &[u8]) -> Arc<ClientConfig> {
    let mut roots = RootCertStore::empty();
    roots.add(CertificateDer::from(der)).unwrap();
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let config = ClientConfig::builder_with_provider(provider).with_safe_default_protocol_versions().unwrap();
    Arc::new(config.with_root_certificates(roots).with_no_client_auth())
}

impl Server {
    fn secured(&self) -> &Secured {
        self.secured.as_ref().expect("one on the network")
    }

    /// What it is called there.
    fn authority(&self) -> String {
        self.secured().address.to_string()
    }

    fn lock(&self) -> &Lock {
        self.shared.network.as_ref().and_then(|entrance| entrance.lock.as_ref()).expect("one on the network")
    }

    /// A connection to its port on the network, as it is.
    fn bare(&self) -> TcpStream {
        let line = TcpStream::connect(self.secured().address).unwrap();
        line.set_read_timeout(Some(PATIENCE)).unwrap();
        line
    }

    /// The same with TLS.
    fn secure(&self) -> Secure {
        let name = ServerName::from(self.secured().address.ip());
        StreamOwned::new(ClientConnection::new(self.secured().trusting.clone(), name).unwrap(), self.bare())
    }

    /// The whole answer to a request there.
    fn demand(&self, mut line: impl Read + Write, path: &str, host: &str) -> String {
        let _ = write!(line, "GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n");
        rest(&mut line)
    }

    /// A page there that has said this first.
    fn knock(&self, message: &Value) -> Page<Secure> {
        let (mut page, answer) = upgrade(self.secure(), &self.authority(), &format!("https://{}", self.authority()));
        assert!(answer.starts_with("HTTP/1.1 101"), "{answer}");
        page.say(message);
        page
    }

    fn type_pin(&self, pin: &str) -> Page<Secure> {
        self.knock(&json!({ "do": "pin", "pin": pin }))
    }

    /// A PIN that is wrong.
    fn wrong(&self) -> String {
        self.lock()
            .pin()
            .spaced()
            .chars()
            .map(|c| {
                if c == '0' {
                    '1'
                } else if c == ' ' {
                    c
                } else {
                    '0'
                }
            })
            .collect()
    }
}

/// All its messages until it is closed, but for the answer to the PIN: of each, its kind.
fn shown(page: &mut Page<Secure>) -> Vec<String> {
    let mut kinds = Vec::new();
    while let Some((what, content)) = page.receive() {
        match what {
            TEXT => kinds.push(serde_json::from_slice::<Value>(&content).unwrap()["kind"].to_string()),
            CLOSE => {}
            what => kinds.push(format!("frame {what}")),
        }
    }
    kinds
}

#[test]
fn nothing_is_shown_before_the_pin_and_all_of_it_after() {
    let server = Server::on_the_network(Limits { request: Duration::from_secs(2), ..Limits::default() }, false);
    server.shared.view().history.push(0.0, [1.0, 2.0]);
    let host = server.authority();
    // the page itself knows nothing
    let page = server.demand(server.secure(), "/", &host);
    assert!(page.starts_with("HTTP/1.1 200") && page.contains(&format!("connect-src 'self' wss://{host};")), "{page}");
    assert!(server.demand(server.secure(), "/figures", &host).starts_with("HTTP/1.1 404"));
    // one that says nothing: it ends, without a word
    let (mut silent, _) = upgrade(server.secure(), &host, &format!("https://{host}"));
    assert_eq!(shown(&mut silent), [""; 0]);
    server.wait("its end", |now| now.refused["stalled_connections"] == 1);
    for odd in [
        json!({ "do": "show", "generation": 1, "series": [[0, 0]] }),
        json!({ "do": "ask", "id": 1, "what": "all_off" }),
        json!({ "do": "pin" }),
    ] {
        assert_eq!(shown(&mut server.knock(&odd)), [""; 0], "{odd}");
    }
    for token in ["", &"0".repeat(32), server.shared.token.as_str()] {
        let mut page = server.knock(&json!({ "do": "token", "token": token }));
        let told = page.told("entry");
        assert!(told["ok"] == false && told["message"].as_str().unwrap().contains("started anew"), "{told}");
        assert_eq!(page.closed(), told_off(Refusal::WrongTokens));
    }
    assert_eq!((server.refused("odd_messages"), server.refused("wrong_tokens"), server.figures().clients), (3, 3, 0));

    let mut page = server.type_pin(&server.lock().pin().spaced());
    let entry = page.told("entry");
    assert_eq!((&entry["ok"], &entry["wait_s"]), (&json!(true), &json!(0.0)));
    assert_eq!(page.told("may")["command"], false);
    page.told("hello");
    page.say(&json!({ "do": "show", "generation": 1, "series": [[0, 0]] }));
    while page.receive().expect("a page that is served").0 != BINARY {}
    // with what it was given, and longer than a request may last
    let mut again = server.knock(&json!({ "do": "token", "token": entry["token"] }));
    (0..25).for_each(|_| drop(again.told("status")));
    assert_eq!((server.figures().clients_open, server.refused("stalled_connections")), (2, 1));
    assert_eq!(*server.secured().events.lock().unwrap(), ["Entered { from: Some(127.0.0.1) }"]);
}

#[test]
fn who_has_the_pin_watches_and_commands_only_where_that_is_allowed() {
    for allowed in [false, true] {
        let server = Server::on_the_network(Limits::default(), allowed);
        let mut page = server.type_pin(&server.lock().pin().spaced());
        assert_eq!(page.told("may")["command"], allowed);
        page.say(&json!({ "do": "ask", "id": 3, "what": { "record": { "on": false } } }));
        let answer = page.told("answer");
        let said = if allowed { "nothing is being recorded" } else { "--lan-commands" };
        assert!(answer["message"].as_str().is_some_and(|words| words.contains(said)), "{answer}");
        assert_eq!(server.refused("commands_without_token"), u64::from(!allowed));
        // the token of loopback is none here
        page.say(&json!({ "do": "token", "token": server.shared.token.as_str() }));
        assert_eq!(page.closed(), told_off(Refusal::OddMessages));
    }
}

#[test]
fn wrong_pins_are_few_counted_and_told_how_long_to_wait() {
    let server = Server::on_the_network(Limits::default(), false);
    let first = server.lock().pin().spaced();
    for count in 1..=10 {
        let mut page = server.type_pin(&server.wrong());
        let told = page.told("entry");
        let wait_s = told["wait_s"].as_f64().unwrap();
        assert!(told["ok"] == false && told.get("token").is_none(), "{told}");
        assert!(if count < 10 { wait_s == 0.0 } else { (50.0..60.0).contains(&wait_s) }, "{told}");
        assert_eq!(page.closed(), told_off(Refusal::WrongPins));
        assert_eq!(server.refused("wrong_pins"), count);
    }
    let now = server.lock().pin().spaced();
    assert_ne!(now, first);
    assert_eq!(
        *server.secured().events.lock().unwrap(),
        [format!("Renewed {{ pin: \"{now}\", from: Some(127.0.0.1) }}")]
    );
    // not even the right one
    let mut page = server.type_pin(&now);
    let told = page.told("entry");
    assert!(told["ok"] == false && told["wait_s"].as_f64().unwrap() > 50.0, "{told}");
    assert_eq!(shown(&mut page), [""; 0]);
    assert_eq!((server.refused("pins_a_second"), server.refused("wrong_pins"), server.figures().clients), (1, 10, 0));
    // whoever has been in stays in, and so does loopback
    server.knock(&json!({ "do": "token", "token": server.lock().session().as_str() })).told("hello");
    server.page().told("hello");
}

#[test]
fn who_speaks_no_tls_is_told_where_to_go_and_nothing_else() {
    let server = Server::on_the_network(Limits::default(), false);
    let host = server.authority();
    for path in ["/", "/figures", "/scope.js", "/live"] {
        let answer = server.demand(server.bare(), path, &host);
        assert!(
            answer.starts_with("HTTP/1.1 307") && answer.contains(&format!("location: https://{host}/\r\n")),
            "{answer}"
        );
    }
    let (_, answer) = upgrade(server.bare(), &host, &format!("http://{host}"));
    assert!(answer.starts_with("HTTP/1.1 307"), "{answer}");
    let answer = server.demand(server.bare(), "/", "evil.example");
    assert!(answer.starts_with("HTTP/1.1 421") && !answer.contains("location"), "{answer}");
    // neither HTTP nor TLS
    let mut line = server.bare();
    line.write_all(&[0x16, 0x03, 0x01, 0, 4, b'h', b'o', b'h', b'o']).unwrap();
    assert!(!rest(&mut line).contains("HTTP"));
    server.wait("its end", |now| now.connections_open == 0);
}

#[test]
fn foreign_hosts_and_origins_do_not_come_in_from_the_network() {
    let server = Server::on_the_network(Limits::default(), false);
    let (host, port) = (server.authority(), server.secured().address.port());
    assert!(server.demand(server.secure(), "/", &format!("bench:{port}")).starts_with("HTTP/1.1 200"));
    for foreign in ["evil.example", "localhost", "127.0.0.1", "[::1]", "bench.evil.example"] {
        let foreign = format!("{foreign}:{port}");
        assert!(server.demand(server.secure(), "/", &foreign).starts_with("HTTP/1.1 421"), "{foreign}");
        let (_, answer) = upgrade(server.secure(), &host, &format!("https://{foreign}"));
        assert!(answer.starts_with("HTTP/1.1 403"), "{answer}");
    }
    let (_, answer) = upgrade(server.secure(), &host, &format!("http://{host}"));
    assert!(answer.starts_with("HTTP/1.1 403"), "{answer}");
    assert_eq!((server.refused("foreign_hosts"), server.refused("foreign_origins")), (5, 6));
    assert!(server.get("/").starts_with("HTTP/1.1 200"), "loopback is as it was");
    assert!(server.ask("/", &host).starts_with("HTTP/1.1 421"), "and has no other name for it");
}

#[test]
fn a_handshake_that_does_not_get_on_ends_in_time() {
    let server = Server::on_the_network(Limits { request: Duration::from_millis(200), ..Limits::default() }, false);
    let mut silent = server.bare();
    let mut slow = server.bare();
    // a greeting of 512 bytes that is never whole
    slow.write_all(&[0x16, 0x03, 0x01, 0x02, 0x00, 0x01, 0x00, 0x01, 0xfc]).unwrap();
    // one that has shaken hands, and then nothing
    let mut shaken = server.secure();
    let _ = shaken.conn.complete_io(&mut shaken.sock);
    let all = |now: &Figures| now.refused["stalled_connections"] == 3;
    server.meanwhile("an end of all", all, || {
        let _ = slow.write_all(&[0]);
        std::thread::sleep(Duration::from_millis(5));
    });
    [rest(&mut silent), rest(&mut shaken)].iter().for_each(|said| assert_eq!(said, ""));
    assert!(!rest(&mut slow).contains("HTTP"));
    server.wait("an end of all", |now| now.connections_open == 0);
    assert_eq!(server.figures().refused_in_all, 3);
}

#[test]
fn the_network_takes_no_place_of_loopback() {
    let server = Server::on_the_network(Limits { connections: 2, clients: 1, ..Limits::default() }, false);
    let held = [(); 2].map(|()| server.bare());
    server.wait("two connections", |now| now.connections_open == 2);
    assert_eq!(rest(&mut server.bare()), "");
    server.page().told("status");
    drop(held);
    server.wait("room", |now| now.connections_open == 0);
    let mut first = server.type_pin(&server.lock().pin().spaced());
    first.told("status");
    let mut second = server.knock(&json!({ "do": "token", "token": server.lock().session().as_str() }));
    assert_eq!(second.closed(), Some((close_code::AGAIN, Refusal::ClientsAtOnce.words().into())));
    server.page().told("status");
    first.told("status");
    assert_eq!((server.refused("connections_at_once"), server.refused("clients_at_once")), (1, 1));
}

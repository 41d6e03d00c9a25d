//! `sinew scope` in a real browser: a page that shows a running driver, commands it with the token and not without.

use std::fs::File;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use sinew_ipc::{Client, Mode};
use sinew_tests::browser::Browser;
use sinew_tests::{Driver, Process, Rig, checkout, entries, run, sinew, wait_for, wait_until};

/// The built-in hexapod's eighteen wires under a name of the test's own.
fn hexapod() -> Rig {
    Rig::named(|name| {
        let text = std::fs::read_to_string(checkout().join("examples/hexapod.toml")).expect("it is in the checkout");
        text.replacen("name = \"hexapod\"", &format!("name = \"{name}\""), 1).replacen("1000.0", "500.0", 1)
    })
}

/// A scope of this rig, and its address with the token.
fn scope(rig: &Rig, more: &[&str]) -> (Process, String) {
    let mut scope = Process::start(Command::new(sinew()).args(["scope", "--rig", &rig.name]).args(more));
    scope.wait_for_word("http://");
    let url = wait_for("the address", || scope.stdout().lines().next().map(str::to_owned));
    (scope, url)
}

#[test]
fn a_page_shows_eighteen_channels_and_commands_with_the_token_alone() {
    let Some(mut browser) = Browser::start(1400, 900) else { return };
    let rig = hexapod();
    let (driver, client) = Driver::ready(&rig);
    let folder = rig.file("recordings");
    std::fs::create_dir(&folder).expect("the folder is writable");
    let (scope, url) = scope(&rig, &["--record-dir", folder.to_str().expect("a plain path")]);

    browser.open(&url);
    shows_what_is_running(&mut browser);
    selects_channels_and_quantities(&mut browser);
    finds_orders_and_pins(&mut browser);
    pauses_and_zooms(&mut browser);
    holds_a_setpoint(&mut browser, &client);
    records(&mut browser, &folder, &rig.file("all.svg"), &client.channels()[2].name.to_string());

    browser.open("about:blank");
    wait_until("the lease to run out", || client.latest().channels()[2].mode() != Mode::Length);

    let bare = url.split('#').next().expect("an address");
    is_refused_without_the_token(&mut browser, bare, &client);

    // the driver goes and comes back: the page says so and goes on by itself
    let stopped = driver.stop();
    assert_eq!(stopped["faults_not_listed"], 0);
    browser.wait("page.status?.driver === 'gone' && !$('banner').hidden");
    let last = browser.eval("page.curves.last").as_f64().expect("a time");
    let (_driver, _client) = Driver::ready(&rig);
    browser
        .wait(&format!("page.status?.driver === 'running' && page.curves.last > {last} + 0.1 && $('banner').hidden"));
    scope.signal(libc::SIGTERM);
    scope.finish().expect(0);
    browser.wait("$('driver').textContent === 'no scope'");
}

/// Data flow, on a page whose policy let everything it needs through.
fn shows_what_is_running(browser: &mut Browser) {
    browser.wait("page.curves && page.curves.length > 200 && page.status?.driver === 'running'");
    assert_eq!(browser.eval("document.querySelectorAll('#channels li').length"), 18);
    let before = browser.eval("page.curves.last").as_f64().expect("a time");
    browser.wait(&format!("page.curves.last > {before} + 0.2"));
    let drawn = "(() => { const c = page.panels[0].raster.canvas; \
                 return c.getContext('2d').getImageData(0, 0, c.width, c.height).data.some((v) => v > 0); })()";
    browser.wait(drawn);
}

/// The ones chosen are drawn, with what was before they were.
fn selects_channels_and_quantities(browser: &mut Browser) {
    browser.eval("$('all').click()");
    browser.wait("page.curves.series >= 36 && page.curves.length > 200 && page.shown.size === 18");
    browser.eval("page.rows[4].shows.click()");
    browser.wait("page.panels[1].lines.length === 17 && page.curves.series === 51");
    browser.eval("[...document.querySelectorAll('#quantities button')].find((b) => b.textContent === 'Wire temperature').click()");
    browser.wait("page.panels.length === 3 && page.panels[2].name === 'temperature_c' && page.panels[2].range");
}

/// Eighteen names are found by a part of them, put in order, pinned, and shown leg by leg; all of it by keys, too.
fn finds_orders_and_pins(browser: &mut Browser) {
    let seen = "[...document.querySelectorAll('#channels li:not(.away) .name')].map((b) => b.textContent)";
    let press = |key: &str| {
        format!(
            "document.body.dispatchEvent(new KeyboardEvent('keydown', {{ key: '{key}', bubbles: true, cancelable: true }}))"
        )
    };
    browser.eval(&press("/"));
    assert_eq!(browser.eval("document.activeElement.id"), "find");
    browser.eval("$('find').value = 'FEMUR'; $('find').oninput()");
    assert_eq!(browser.eval(&format!("{seen}.length")), 6);
    assert_eq!(browser.eval(&format!("{seen}.every((name) => name.endsWith('femur'))")), true);
    browser.eval("$('find').value = ''; $('find').oninput(); $('find').blur()");
    browser.eval("$('order').value = 'hottest'; $('order').onchange()");
    let heats = "page.arranged.map((i) => page.status.channels[i].temperature_c)";
    browser.wait(&format!(
        "{heats}.every((c, at, all) => at === 0 || c < all[at - 1] + 6) && {heats}[0] > {heats}[17] + 6"
    ));
    browser.eval("page.selected = 7");
    browser.eval(&press("p"));
    assert_eq!(browser.eval(&format!("{seen}[0]")), browser.eval("page.names[7]"));
    browser.eval("$('order').value = 'rig'; $('order').onchange()");
    browser.eval(&press("ArrowDown"));
    assert_eq!(browser.eval("page.selected"), 0, "the one below the pinned one");
    browser.eval(&press("p"));
    browser.eval("page.selected = 7");
    browser.eval(&press("p"));
    // the first is still pinned, which is where it stands anyway
    assert_eq!(browser.eval("page.arranged.join() === page.names.map((_, i) => i).join()"), true);
    let before = browser.eval("JSON.stringify([...page.shown])");
    browser.eval("$('groups').children[1].click()");
    browser.wait("page.panels[0].lines.length === 6 && page.shown.size === 3");
    browser.eval(&format!("page.shown = new Set({}); mark(); show()", before.as_str().expect("a list")));
    browser.wait("page.curves.series === 68");
    browser.eval(&press("?"));
    assert_eq!(browser.eval("$('help').open"), true);
    browser.eval("$('help').close()");
}

/// Paused, the time stands still while data go on coming; a drag over a curve zooms; and back.
fn pauses_and_zooms(browser: &mut Browser) {
    browser.eval("$('pause').click()");
    let paused = browser.eval("JSON.stringify(span())");
    let came = browser.eval("page.curves.last").as_f64().expect("a time");
    browser.wait(&format!("page.curves.last > {came} + 0.1"));
    assert_eq!(browser.eval("JSON.stringify(span())"), paused);
    let place = |browser: &mut Browser, key: &str| {
        browser.eval(&format!("page.panels[0].chart.over.getBoundingClientRect().{key}")).as_f64().expect("px")
    };
    let [left, top, width] = ["left", "top", "width"].map(|key| place(browser, key));
    let width_before = browser.eval("span().to - span().from").as_f64().expect("s");
    browser.drag((left + 0.25 * width, top + 40.0), (left + 0.5 * width, top + 45.0));
    browser.wait(&format!("Math.abs((span().to - span().from) / {width_before} - 0.25) < 0.02"));
    browser.eval("$('live').click()");
    browser.wait("!page.frozen");
}

/// A setpoint is held by a lease that the page renews.
fn holds_a_setpoint(browser: &mut Browser, client: &Client) {
    browser.eval("page.selected = 2; entry.kind = 'stroke'; entry.value = 0.4; card(); $('hold').click()");
    let state = || client.latest().channels()[2];
    wait_until("the setpoint", || state().mode() == Mode::Length);
    let info = client.channels()[2];
    assert!((state().target_m - info.length_at_stroke(0.4)).abs() < 1e-6, "{:?}", state());
    let (mut left_s, mut renewals) = (state().lease_s, 0);
    wait_until("its lease to be renewed for longer than it is long", || {
        let now_s = state().lease_s;
        renewals += u32::from(now_s > left_s);
        left_s = now_s;
        renewals >= 6
    });
    assert_eq!(state().mode(), Mode::Length, "renewed beyond its first lease");
}

/// The record button: a session of all channels, which `plot` can draw.
fn records(browser: &mut Browser, folder: &Path, drawn: &Path, channel: &str) {
    browser.eval("$('record').click()");
    browser.wait("page.status?.recording?.seconds > 1");
    browser.eval("$('record').click()");
    browser.wait("page.status && !page.status.recording");
    let files = entries(folder);
    assert_eq!(files.len(), 1, "{files:?}");
    let file = folder.join(&files[0]);
    let [file, out] = [file.as_path(), drawn].map(|path| path.to_str().expect("a plain path"));
    run(["plot", file, "-o", out, "--kind", "all", "--channel", channel]).expect(0);
    let svg = std::fs::read_to_string(drawn).expect("it was drawn");
    for what in ["Wire length, mm", "against wire temperature", "surface: ė = −λe", "share of cycles"] {
        assert!(svg.contains(what), "{what}");
    }
}

/// Without the token, or with another one, a page shows the same and is refused.
fn is_refused_without_the_token(browser: &mut Browser, bare: &str, client: &Client) {
    browser.open(bare);
    browser.wait("page.curves && page.curves.length > 20");
    assert_eq!(browser.eval("page.may"), false);
    assert_eq!(browser.eval("!!$('hold')"), false);
    let answer = browser.eval("set(2, 'duty', 0.1)");
    assert_eq!(answer["ok"], false);
    assert!(answer["message"].as_str().is_some_and(|said| said.contains("token")), "{answer}");
    assert_ne!(client.latest().channels()[2].mode(), Mode::Duty);
    browser.open("about:blank");
    browser.open(&format!("{bare}#{}", "0".repeat(32)));
    browser.wait("page.curves && page.curves.length > 20");
    assert_eq!(browser.eval("set(2, 'duty', 0.1)")["ok"], false, "another token is none");
}

/// The first line of the answer to a request with these headers.
fn answer(port: &str, headers: &str) -> String {
    let mut line = TcpStream::connect(format!("127.0.0.1:{port}")).expect("the scope listens");
    write!(line, "{headers}\r\nConnection: close\r\n\r\n").expect("it takes a request");
    let mut said = Vec::new();
    line.read_to_end(&mut said).expect("it answers");
    String::from_utf8_lossy(&said).into_owned()
}

#[test]
fn foreign_pages_do_not_come_in() {
    let rig = Rig::bench(&["wire"], "");
    let (_driver, _client) = Driver::ready(&rig);
    let (scope, url) = scope(&rig, &["--no-commands"]);
    assert!(!url.contains('#'), "nothing to command with: {url}");
    let port = url.trim_end_matches('/').rsplit(':').next().expect("a port");
    let own = format!("127.0.0.1:{port}");
    let page = answer(port, &format!("GET / HTTP/1.1\r\nHost: {own}"));
    assert!(page.starts_with("HTTP/1.1 200"), "{page}");
    assert!(page.contains("content-security-policy: default-src 'none'; script-src 'self'"), "{page}");
    assert!(page.contains("frame-ancestors 'none'"));
    assert!(answer(port, "GET / HTTP/1.1\r\nHost: evil.example").starts_with("HTTP/1.1 421"));
    let socket = |host: &str, origin: &str| {
        let upgrade = "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==";
        let request = format!("GET /live HTTP/1.1\r\nHost: {host}\r\n{origin}{upgrade}\r\nConnection: Upgrade\r\n\r\n");
        let mut line = TcpStream::connect(&own).expect("the scope listens");
        line.write_all(request.as_bytes()).expect("it takes a request");
        let mut said = [0; 12];
        line.read_exact(&mut said).expect("it answers");
        String::from_utf8_lossy(&said).into_owned()
    };
    assert_eq!(socket(&own, &format!("Origin: http://{own}\r\n")), "HTTP/1.1 101");
    assert_eq!(socket(&own, "Origin: http://evil.example\r\n"), "HTTP/1.1 403");
    assert_eq!(socket(&own, ""), "HTTP/1.1 403");
    assert_eq!(socket("evil.example", "Origin: http://evil.example\r\n"), "HTTP/1.1 421");
    let taken = run(["scope", "--rig", &rig.name, "--port", port]);
    taken.refused(&[&format!("port {port} of 127.0.0.1"), "--port"]);
    scope.signal(libc::SIGTERM);
    let ended = scope.finish().expect(0);
    assert!(ended.stderr.contains("2 × a request for another host, 2 × a page of another origin"), "{}", ended.stderr);
}

/// A scope of this rig that is on what stands for the network, and what its terminal shows.
fn on_the_network(rig: &Rig, address: &str, more: &[&str]) -> (Process, Shown) {
    let mut command = Command::new(sinew());
    command.args(["scope", "--rig", &rig.name, "--lan", address]).args(more);
    let mut scope = Process::start(command.env("SINEW_STATE_DIR", rig.file("state")));
    scope.wait_for_word("\ncertificate ");
    let lines = wait_for("what it shows", || {
        let shown = scope.stdout();
        (shown.contains("\ncertificate ") && shown.ends_with('\n'))
            .then(|| shown.lines().map(str::to_owned).collect::<Vec<_>>())
    });
    let after = |word: &str| {
        lines.iter().find_map(|line| line.strip_prefix(word)).unwrap_or_else(|| panic!("{word}: {lines:?}")).to_owned()
    };
    let url = format!("https://{}", after("https://"));
    (scope, Shown { url, pin: after("PIN "), fingerprint: after("certificate ") })
}

struct Shown {
    url: String,
    pin: String,
    fingerprint: String,
}

/// The SHA-256 of the certificate in a file, as browsers write it.
fn fingerprint(pem: &Path) -> String {
    use base64::Engine;
    use sha2::{Digest, Sha256};
    let text = std::fs::read_to_string(pem).expect("it was written");
    let body = text.split("-----BEGIN CERTIFICATE-----").nth(1).and_then(|rest| rest.split("-----END").next());
    let base64: String = body.expect("a certificate").split_whitespace().collect();
    let der = base64::engine::general_purpose::STANDARD.decode(base64).expect("it is PEM");
    let pairs: Vec<String> = Sha256::digest(der).iter().map(|byte| format!("{byte:02X}")).collect();
    pairs.join(":")
}

/// Types a PIN and sends it.
fn type_pin(browser: &mut Browser, pin: &str) {
    browser.wait("!$('entry').hidden && !$('entry').querySelector('button').disabled");
    browser.eval(&format!("$('pin').value = '{pin}'; $('entry').requestSubmit()"));
}

#[test]
fn on_the_network_a_page_shows_nothing_before_the_pin() {
    let Some(mut browser) = Browser::start(390, 844) else { return };
    let picture = |browser: &mut Browser, name: &str| {
        if let Some(folder) = std::env::var_os("SINEW_PICTURES") {
            std::thread::sleep(Duration::from_millis(300));
            browser.picture(&PathBuf::from(folder).join(name));
        }
    };
    let rig = Rig::bench(&["left", "right"], "");
    let (_driver, client) = Driver::ready(&rig);
    let (scope, shown) = on_the_network(&rig, "127.0.0.2:0", &[]);
    assert_eq!(shown.fingerprint, fingerprint(&rig.file("state").join("scope.pem")));
    wait_until("a word of the certificate", || scope.stderr().contains("the certificate is new"));

    // nobody vouches for the certificate, which is what a user makes an exception for
    browser.call("Security.setIgnoreCertificateErrors", serde_json::json!({ "ignore": true }));
    browser.open(&shown.url);
    browser.wait("!$('entry').hidden && document.activeElement.id === 'pin'");
    assert_eq!(browser.eval("page.rig === null && page.socket === null"), true, "it does not even connect");
    assert_eq!(browser.eval("getComputedStyle(document.querySelector('main')).display"), "none");
    picture(&mut browser, "pin.png");
    let wrong: String = shown.pin.chars().map(|c| if c == '0' { '1' } else { '0' }).collect();
    type_pin(&mut browser, &wrong);
    browser.wait("$('entry-words').textContent === 'That is not the PIN.' && page.rig === null");
    picture(&mut browser, "pin-wrong.png");
    type_pin(&mut browser, &shown.pin);
    browser.wait("page.curves && page.curves.length > 200 && page.status?.driver === 'running' && $('entry').hidden");
    wait_until("who has come", || scope.stderr().contains("127.0.0.1 has come in by the PIN"));
    assert_eq!(browser.eval("page.may"), false);
    browser.wait("$('card').textContent.includes('--lan-commands')");
    let answer = browser.eval("set(0, 'duty', 0.1)");
    assert!(answer["message"].as_str().is_some_and(|said| said.contains("--lan-commands")), "{answer}");
    assert_ne!(client.latest().channels()[0].mode(), Mode::Duty);
    picture(&mut browser, "pin-right.png");
    // its tab may come again
    browser.open("about:blank");
    browser.open(&shown.url);
    browser.wait("page.curves && page.curves.length > 200 && $('entry').hidden");

    // another scope has another PIN, and the same certificate
    scope.signal(libc::SIGTERM);
    let ended = scope.finish().expect(0);
    assert!(ended.stderr.contains("1 × a wrong PIN"), "{}", ended.stderr);
    browser.wait("$('driver').textContent === 'no scope'");
    let address = shown.url.trim_start_matches("https://").trim_end_matches('/');
    let (scope, again) = on_the_network(&rig, address, &["--lan-commands"]);
    assert_eq!((&again.url, &again.fingerprint), (&shown.url, &shown.fingerprint));
    assert_ne!(again.pin, shown.pin);
    wait_until("a word of the certificate", || {
        scope.stderr().contains("a browser that knows this certificate does not warn")
    });
    browser.wait("!$('entry').hidden && $('entry-words').textContent.includes('started anew')");
    type_pin(&mut browser, &again.pin);
    browser.wait("page.may && page.curves.length > 20 && $('entry').hidden && $('hold')");
    assert_eq!(browser.eval("set(0, 'duty', 0.1)")["ok"], true);
    wait_until("the setpoint", || client.latest().channels()[0].mode() == Mode::Duty);

    // ten wrong ones: a pause, and another PIN in the terminal
    browser.eval("sessionStorage.clear()");
    browser.open("about:blank");
    browser.open(&again.url);
    for count in 1..=10 {
        type_pin(&mut browser, "1");
        browser.wait(&format!(
            "$('entry-words').textContent.includes('{}')",
            if count < 10 { "not the PIN." } else { "another one" }
        ));
        browser.eval("$('entry-words').textContent = ''");
    }
    browser.wait("/^Watch in [45]. s$/.test($('entry').querySelector('button').textContent)");
    picture(&mut browser, "pin-pause.png");
    wait_until("another PIN", || scope.stderr().contains("ten wrong PINs, the last one from 127.0.0.1; the PIN is "));
    assert!(!scope.stderr().contains(&format!("is {}", again.pin)));
    scope.signal(libc::SIGTERM);
    scope.finish().expect(0);
}

#[test]
fn what_is_no_address_of_this_machine_is_said() {
    let rig = Rig::bench(&["wire"], "");
    let (_driver, _client) = Driver::ready(&rig);
    let lan = |more: &[&str]| {
        let mut command = Command::new(sinew());
        command.args(["scope", "--rig", &rig.name]).args(more).env("SINEW_STATE_DIR", rig.file("state"));
        Process::start(&mut command).finish()
    };
    lan(&["--lan", "bench"]).refused(&["--lan", "192.168.1.20:8751"]);
    lan(&["--lan", "203.0.113.7:0"]).refused(&["203.0.113.7:0 cannot be had", "--lan ADDRESS:PORT"]);
    lan(&["--lan-commands"]).refused(&["--lan"]);
    lan(&["--lan", "--lan-commands", "--no-commands"]).refused(&["--no-commands"]);
    std::fs::write(rig.file("state"), "no folder").expect("the folder is writable");
    lan(&["--lan", "127.0.0.2:0"]).refused(&["scope.pem: the certificate: ", "SINEW_STATE_DIR"]);
}

/// Somebody who prints rows of this function of their number, two hundred a second, until dropped.
struct Board {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Board {
    fn printing(mut line: impl Write + Send + 'static, head: &'static str, row: fn(f64) -> String) -> Board {
        let stop = Arc::new(AtomicBool::new(false));
        let stopping = stop.clone();
        let thread = std::thread::spawn(move || {
            let mut said = write!(line, "{head}");
            for count in 0.. {
                if said.is_err() || stopping.load(Ordering::Relaxed) {
                    return;
                }
                std::thread::sleep(Duration::from_millis(5));
                said = writeln!(line, "{}", row(f64::from(count)));
            }
        });
        Board { stop, thread: Some(thread) }
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        self.thread.take().map(JoinHandle::join);
    }
}

/// A scope of a stream, and its address with the token.
fn plotter(more: &[&str], stdin: impl Into<Stdio>) -> (Process, String) {
    let mut scope = Process::start_reading(Command::new(sinew()).arg("scope").args(more), stdin);
    scope.wait_for_word("http://");
    let url = wait_for("the address", || scope.stdout().lines().next().map(str::to_owned));
    (scope, url)
}

#[test]
fn a_stream_of_numbers_is_drawn_recorded_and_saved() {
    let Some(mut browser) = Browser::start(1400, 900) else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let (reader, writer) = std::io::pipe().expect("a pipe");
    let board = Board::printing(writer, "booting\nt_ms;force [N];pull [N];temp [°C]\n", |n| {
        // as a laboratory in Germany prints it
        format!("{};{};{};{}", 5.0 * n, 2.0 + (n / 50.0).sin(), 1.0, 20.0 + n / 100.0).replace('.', ",")
    });
    let record_dir = folder.path().to_str().expect("a plain path");
    let (scope, url) = plotter(&["--stdin", "--record-dir", record_dir], reader);

    browser.open(&url);
    browser.wait("page.curves && page.curves.length > 300 && page.status?.driver === 'running'");
    assert_eq!(browser.eval("page.rig.channels.map((c) => c.name).join()"), "t,force,pull,temp");
    assert_eq!(browser.eval("page.panels.map((p) => p.name).join()"), "N,°C", "a clock is not drawn");
    assert_eq!(browser.eval("page.panels[0].lines.length"), 2, "of one unit, in one panel");
    // by the board's own clock, however it came
    let apart = "(() => { const t = page.curves.time, n = page.curves.length; return t[n - 1] - t[n - 101]; })()";
    let apart = browser.eval(apart).as_f64().expect("s");
    assert!((apart - 0.5).abs() < 1e-3, "{apart}");
    browser.eval("page.selected = 2");
    browser.wait("$('card').textContent.includes('mean1.000 N') && $('card').textContent.includes('deviation0')");
    if let Some(picture) = std::env::var_os("SINEW_PICTURES") {
        browser.wait("page.curves.length > 1500");
        browser.eval("page.selected = 1; mark()");
        std::thread::sleep(Duration::from_millis(300));
        browser.picture(&PathBuf::from(picture).join("stream.png"));
    }

    browser.eval("$('record').click()");
    browser.wait("page.status?.recording?.seconds > 0.5");
    browser.eval("$('record').click()");
    browser.wait("page.status && !page.status.recording");
    let files = entries(folder.path());
    assert_eq!(files.len(), 1, "{files:?}");
    let text = std::fs::read_to_string(folder.path().join(&files[0])).expect("it was written");
    assert!(text.starts_with("time_s,t [ms],force [N],pull [N],temp [°C]\n0.000000,"), "{text}");
    assert!(text.lines().count() > 50);
    // what is shown, as a file of the page's own
    browser.eval("HTMLAnchorElement.prototype.click = function () { fetchBlob(this); }; \
                  window.fetchBlob = () => {}; URL.createObjectURL = (blob) => { blob.text().then((t) => { window.saved = t; }); return 'blob:'; }; save()");
    browser.wait("window.saved?.startsWith('time_s,force [N],pull [N],temp [°C]\\n0.000000,')");

    drop(board);
    browser.wait("page.status?.driver === 'ended' && !$('banner').hidden");
    browser.wait("page.curves.length > 300");
    scope.signal(libc::SIGTERM);
    scope.finish().expect(0);
}

/// A serial line: the end that a board writes to, and the device.
fn line() -> (File, PathBuf) {
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
    let board = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).expect("a pseudo terminal");
    grantpt(&board).expect("its other end");
    unlockpt(&board).expect("its other end");
    let name = ptsname(&board, Vec::new()).expect("its name").into_string().expect("a plain path");
    (File::from(board), PathBuf::from(name))
}

#[test]
fn a_board_that_is_unplugged_goes_on_when_it_is_back() {
    let Some(mut browser) = Browser::start(1000, 700) else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let device = folder.path().join("ttyBOARD");
    let plug = || {
        let (board, at) = line();
        let _ = std::fs::remove_file(&device);
        std::os::unix::fs::symlink(at, &device).expect("a link");
        board
    };
    let row: fn(f64) -> String = |n| format!("temp: {} °C, pull: {} N", 20.0 + n / 100.0, (n / 40.0).cos());
    let board = plug();
    let path = device.to_str().expect("a plain path");
    let (scope, url) = plotter(&["--no-commands", "--serial", path], Stdio::null());
    let board = Board::printing(board, "garbage", row);
    browser.open(&url);
    browser.wait("page.curves && page.curves.length > 100 && page.status?.driver === 'running'");
    assert_eq!(browser.eval("page.rig.rig + ' ' + page.rig.channels.map((c) => c.name).join()"), "ttyBOARD temp,pull");
    assert_eq!(browser.eval("page.rig.quantities.map((q) => q.unit).join()"), "°C,N");
    assert_eq!(browser.eval("$('record').hidden"), true);

    drop(board);
    browser.wait("page.status?.driver === 'broken'");
    let last = browser.eval("page.curves.last").as_f64().expect("a time");
    let _board = Board::printing(plug(), "", row);
    browser.wait(&format!("page.status?.driver === 'running' && page.curves.last > {last} + 0.2"));
    scope.signal(libc::SIGTERM);
    scope.finish().expect(0);
}

#[test]
fn what_is_no_stream_is_said() {
    run(["scope", "--serial", "/dev/null"]).refused(&["--serial", "/dev/ttyACM0"]);
    run(["scope", "--serial", "/nowhere"]).refused(&["/nowhere", "/dev/serial/by-id"]);
    run(["scope", "--stdin", "--serial", "/dev/null"]).refused(&["--stdin", "--serial"]);
    run(["scope", "--names", "a,b"]).refused(&["--names", "--stdin"]);
}

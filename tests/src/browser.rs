//! A real browser for tests: headless Chromium, driven through its DevTools protocol.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tempfile::TempDir;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

use crate::{PATIENCE, Process, wait_for, wait_until};

/// Names the browser goes by.
const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];

/// A browser with one page. Ends when it goes out of scope.
pub struct Browser {
    page: WebSocket<MaybeTlsStream<TcpStream>>,
    calls: u64,
    _process: Process,
    _profile: TempDir,
}

impl Browser {
    /// Starts one with a page of this size, px; none, saying so, where no Chromium is installed.
    ///
    /// # Panics
    /// When there is one that does not start.
    pub fn start(width: u32, height: u32) -> Option<Browser> {
        let program = NAMES.into_iter().find(|name| {
            let path = std::env::var_os("PATH").unwrap_or_default();
            std::env::split_paths(&path).any(|folder| folder.join(name).is_file())
        });
        let Some(program) = program else {
            eprintln!("skipped: there is no Chromium here (apt-get install chromium)");
            return None;
        };
        let profile = tempfile::Builder::new().prefix("sinew-browser-").tempdir().expect("a temporary folder");
        let process = Process::start(
            Command::new(program)
                .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"])
                .args(["--disable-background-networking", "--disable-component-update", "--disable-sync"])
                .arg("--remote-debugging-port=0")
                .arg(format!("--window-size={width},{height}"))
                .arg(format!("--user-data-dir={}", profile.path().display()))
                .arg("about:blank"),
        );
        let port = wait_for("the browser's debugging port", || port(profile.path()));
        let socket = wait_for("the browser's page", || {
            let pages: Value = serde_json::from_str(&get(port, "/json/list")?).ok()?;
            let page = pages.as_array()?.iter().find(|page| page["type"] == "page")?;
            page["webSocketDebuggerUrl"].as_str().map(str::to_owned)
        });
        let (page, _) = tungstenite::connect(&socket).expect("the browser takes a connection");
        if let MaybeTlsStream::Plain(stream) = page.get_ref() {
            stream.set_read_timeout(Some(PATIENCE)).expect("a socket takes a timeout");
        }
        let mut browser = Browser { page, calls: 0, _process: process, _profile: profile };
        let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        browser.call("Emulation.setDeviceMetricsOverride", size);
        Some(browser)
    }

    /// A command of the DevTools protocol, and its result.
    #[track_caller]
    pub fn call(&mut self, method: &str, params: Value) -> Value {
        self.calls += 1;
        let call = json!({ "id": self.calls, "method": method, "params": params }).to_string();
        self.page.send(Message::text(call)).expect("the browser listens");
        loop {
            let Message::Text(text) = self.page.read().expect("the browser answers") else { continue };
            let answer: Value = serde_json::from_str(&text).expect("it answers in JSON");
            if answer["id"] == self.calls {
                assert!(answer["error"].is_null(), "{method}: {answer:#}");
                return answer["result"].clone();
            }
        }
    }

    /// Opens an address.
    #[track_caller]
    pub fn open(&mut self, url: &str) {
        self.call("Page.navigate", json!({ "url": url }));
        wait_until("the page", || self.eval("document.readyState") == "complete");
    }

    /// What an expression of the page is worth; a promise is waited for.
    #[track_caller]
    pub fn eval(&mut self, expression: &str) -> Value {
        let params = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let result = self.call("Runtime.evaluate", params);
        assert!(result["exceptionDetails"].is_null(), "{expression}: {result:#}");
        result["result"]["value"].clone()
    }

    /// Waits until an expression of the page is true.
    #[track_caller]
    pub fn wait(&mut self, expression: &str) {
        let started = Instant::now();
        while self.eval(&format!("!!({expression})")) != true {
            if started.elapsed() > PATIENCE {
                let text = self.eval("document.body.innerText");
                panic!(
                    "waited {PATIENCE:?} in vain for: {expression}; the page says:\n{}",
                    text.as_str().unwrap_or("")
                );
            }
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// A mouse event at a place of the page, px; `kind` as in `mousePressed`.
    #[track_caller]
    pub fn mouse(&mut self, kind: &str, x: f64, y: f64, more: Value) {
        let mut params = json!({ "type": kind, "x": x, "y": y });
        if let (Value::Object(params), Value::Object(more)) = (&mut params, more) {
            params.extend(more);
        }
        self.call("Input.dispatchMouseEvent", params);
    }

    /// Drags with the left button.
    #[track_caller]
    pub fn drag(&mut self, from: (f64, f64), to: (f64, f64)) {
        let left = |buttons: u8| json!({ "button": "left", "buttons": buttons, "clickCount": 1 });
        self.mouse("mouseMoved", from.0, from.1, json!({}));
        self.mouse("mousePressed", from.0, from.1, left(1));
        for step in 1..=5 {
            let share = f64::from(step) / 5.0;
            let at = (from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1));
            self.mouse("mouseMoved", at.0, at.1, json!({ "buttons": 1 }));
        }
        self.mouse("mouseReleased", to.0, to.1, left(0));
    }

    /// A picture of the page, PNG.
    #[track_caller]
    pub fn picture(&mut self, path: &Path) {
        use base64::Engine;
        let shot = self.call("Page.captureScreenshot", json!({ "format": "png" }));
        let text = shot["data"].as_str().expect("a picture");
        let bytes = base64::engine::general_purpose::STANDARD.decode(text).expect("it is base64");
        fs::write(path, bytes).expect("the picture can be written");
    }
}

/// The port the browser says it listens at.
fn port(profile: &Path) -> Option<u16> {
    let said = fs::read_to_string(profile.join("DevToolsActivePort")).ok()?;
    said.lines().next()?.parse().ok()
}

fn get(port: u16, path: &str) -> Option<String> {
    let mut stream = TcpStream::connect(("127.0.0.1", port)).ok()?;
    stream.set_read_timeout(Some(Duration::from_secs(2))).ok()?;
    write!(stream, "GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nConnection: close\r\n\r\n").ok()?;
    let mut answer = BufReader::new(stream);
    let mut length = 0;
    loop {
        let mut line = String::new();
        answer.read_line(&mut line).ok()?;
        let line = line.trim().to_lowercase();
        if line.is_empty() {
            break;
        }
        if let Some(said) = line.strip_prefix("content-length:") {
            length = said.trim().parse().ok()?;
        }
    }
    let mut body = vec![0; length];
    answer.read_exact(&mut body).ok()?;
    String::from_utf8(body).ok()
}

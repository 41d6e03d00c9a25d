//! Access control of the HTTP server: hosts of this machine only, WebSockets of our own pages only, commands only with the token.
//!
//! A browser runs the scripts of any page it has open, and any of them may send requests to a port of this machine. So a
//! request must name a host that DNS cannot point here (against DNS rebinding), and a WebSocket must come from a page of this
//! origin (against cross-site WebSocket hijacking). On loopback that suffices to watch: other users of this machine may.
//! Commanding and recording require the token, which only the terminal that started the scope has printed: it is in the
//! fragment (`#`) of the address, which browsers do not send to servers. On the network nothing is shown before the
//! [lock](crate::lock) is open.

use std::net::SocketAddr;

use axum::http::{HeaderMap, HeaderName, HeaderValue, header};
use subtle::ConstantTimeEq;

use crate::Error;

/// The Content-Security-Policy: a page may load from this server only, connect to this server only, and not be framed.
fn policy(live: &str) -> String {
    format!(
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; \
         connect-src 'self' {live}; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    )
}

/// The token that permits commands: 128 random bits, in hexadecimal.
#[derive(Clone)]
pub struct Token(String);

impl Token {
    /// A new one.
    ///
    /// # Errors
    /// [`Error::Random`] when the system gives no random bits.
    pub fn new() -> Result<Token, Error> {
        let mut bits = [0; 16];
        getrandom::fill(&mut bits).map_err(|e| Error::Random { reason: e.to_string() })?;
        Ok(Token(bits.iter().map(|byte| format!("{byte:02x}")).collect()))
    }

    /// As it is written in the address.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Whether `offered` is this token, compared in constant time.
    pub fn matches(&self, offered: &str) -> bool {
        self.0.as_bytes().ct_eq(offered.as_bytes()).into()
    }
}

/// Checks requests to a server at this port.
#[derive(Clone)]
pub struct AccessControl {
    /// `http` or `https`, and the same of its WebSockets.
    schemes: [&'static str; 2],
    /// What it is called, with the port.
    authorities: Vec<String>,
    /// Whether it is called by each of this machine's addresses besides: by the one that a connection has reached.
    by_address: bool,
}

impl AccessControl {
    /// At `port` of 127.0.0.1. Not `localhost`: that may be another address with another server, whose pages would have our name.
    pub fn loopback(port: u16) -> AccessControl {
        AccessControl { schemes: ["http", "ws"], authorities: vec![format!("127.0.0.1:{port}")], by_address: false }
    }

    /// At `port` of this machine's addresses, with TLS. A name is one that DNS may point elsewhere, but no page of that name has our
    /// certificate.
    pub fn network(names: &[String], port: u16) -> AccessControl {
        let authorities = names.iter().map(|name| authority(name, port)).collect();
        AccessControl { schemes: ["https", "wss"], authorities, by_address: true }
    }

    /// The addresses of its page by name.
    pub fn urls(&self) -> impl Iterator<Item = String> {
        self.authorities.iter().map(|authority| format!("{}://{authority}/", self.schemes[0]))
    }

    /// What this server was called by the `Host` of a request that came in at the address `reached`; nothing where it meant another.
    pub fn host(&self, headers: &HeaderMap, reached: Option<SocketAddr>) -> Option<String> {
        let host = text(headers, header::HOST)?;
        let is_own = self.authorities.iter().any(|own| own == host)
            || self.by_address && reached.is_some_and(|reached| host == numbered(reached));
        is_own.then(|| host.to_string())
    }

    /// Whether a WebSocket is opened by one of this server's own pages: browsers always send the `Origin`.
    pub fn accepts_websocket(&self, headers: &HeaderMap, reached: Option<SocketAddr>) -> bool {
        let origin = text(headers, header::ORIGIN).and_then(|origin| origin.strip_prefix(self.schemes[0]));
        let origin = origin.and_then(|origin| origin.strip_prefix("://"));
        self.host(headers, reached).is_some_and(|host| origin == Some(host.as_str()))
    }

    /// The security headers of every response to whoever called this server so.
    pub fn headers(&self, host: Option<&str>) -> Vec<(HeaderName, HeaderValue)> {
        let policy =
            host.and_then(|host| HeaderValue::from_str(&policy(&format!("{}://{host}", self.schemes[1]))).ok());
        let policy = policy.unwrap_or(HeaderValue::from_static("default-src 'none'"));
        vec![
            (header::CONTENT_SECURITY_POLICY, policy),
            (header::X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff")),
            (header::REFERRER_POLICY, HeaderValue::from_static("no-referrer")),
            (header::CACHE_CONTROL, HeaderValue::from_static("no-store")),
            (HeaderName::from_static("cross-origin-opener-policy"), HeaderValue::from_static("same-origin")),
            (HeaderName::from_static("cross-origin-resource-policy"), HeaderValue::from_static("same-origin")),
        ]
    }
}

/// A host and its port as browsers send them: without the port of HTTPS.
fn authority(host: &str, port: u16) -> String {
    if port == 443 { host.to_string() } else { format!("{host}:{port}") }
}

/// An address as browsers send it.
pub fn numbered(address: SocketAddr) -> String {
    match address {
        SocketAddr::V4(v4) => authority(&v4.ip().to_string(), v4.port()),
        SocketAddr::V6(v6) => authority(&format!("[{}]", v6.ip()), v6.port()),
    }
}

fn text(headers: &HeaderMap, name: HeaderName) -> Option<&str> {
    let mut all = headers.get_all(name).iter();
    // a duplicated header is ambiguous and therefore rejected
    match (all.next(), all.next()) {
        (Some(only), None) => only.to_str().ok(),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(host: &str, origin: Option<&str>) -> HeaderMap {
        let mut headers = HeaderMap::new();
        headers.insert(header::HOST, host.parse().unwrap());
        origin.into_iter().for_each(|o| drop(headers.insert(header::ORIGIN, o.parse().unwrap())));
        headers
    }

    #[test]
    fn only_our_own_pages_are_accepted() {
        let access = AccessControl::loopback(8750);
        for (host, origin, request, websocket) in [
            ("127.0.0.1:8750", Some("http://127.0.0.1:8750"), true, true),
            ("localhost:8750", Some("http://localhost:8750"), false, false),
            ("127.0.0.1:8750", Some("http://localhost:8750"), true, false),
            ("127.0.0.1:8750", Some("http://[::1]:8750"), true, false),
            ("127.0.0.1:8750", None, true, false),
            ("127.0.0.1:8750", Some("null"), true, false),
            ("127.0.0.1:8750", Some("https://127.0.0.1:8750"), true, false),
            ("127.0.0.1:8750", Some("http://evil.example"), true, false),
            ("127.0.0.1:8750", Some("http://evil.example:8750"), true, false),
            ("127.0.0.1:8750", Some("http://127.0.0.1:8751"), true, false),
            ("127.0.0.1:8750", Some("http://127.0.0.1:8750.evil.example"), true, false),
            ("evil.example:8750", Some("http://evil.example:8750"), false, false),
            ("[::1]:8750", Some("http://[::1]:8750"), false, false),
            ("127.0.0.1:8750", Some("http://127.0.0.1:8750/"), true, false),
            ("127.0.0.1:+8750", None, false, false),
            ("127.0.0.1:08750", None, false, false),
            ("127.1:8750", None, false, false),
            ("user@127.0.0.1:8750", None, false, false),
            ("127.0.0.1", Some("http://127.0.0.1"), false, false),
            ("127.0.0.1.evil.example:8750", None, false, false),
            ("", None, false, false),
        ] {
            let sent = headers(host, origin);
            // that it came in at another address of this machine makes that no name of this server
            let reached = "[::1]:8750".parse().ok();
            let accepted = (access.host(&sent, reached).is_some(), access.accepts_websocket(&sent, reached));
            assert_eq!(accepted, (request, websocket), "{host} {origin:?}");
        }
        let mut twice = headers("127.0.0.1:8750", None);
        twice.append(header::HOST, "evil.example".parse().unwrap());
        assert_eq!(access.host(&twice, None), None);
        assert_eq!(access.host(&HeaderMap::new(), None), None);
    }

    #[test]
    fn on_the_network_a_page_has_the_name_or_address_it_was_reached_by() {
        let access = AccessControl::network(&["bench".into(), "bench.local".into()], 8751);
        for (reached, host, origin, request, websocket) in [
            ("192.0.2.7:8751", "192.0.2.7:8751", Some("https://192.0.2.7:8751"), true, true),
            ("192.0.2.7:8751", "bench:8751", Some("https://bench:8751"), true, true),
            ("192.0.2.7:8751", "bench.local:8751", Some("https://bench.local:8751"), true, true),
            ("[2001:db8::7]:8751", "[2001:db8::7]:8751", Some("https://[2001:db8::7]:8751"), true, true),
            // in the clear, of another name of ours, of nobody
            ("192.0.2.7:8751", "192.0.2.7:8751", Some("http://192.0.2.7:8751"), true, false),
            ("192.0.2.7:8751", "bench:8751", Some("https://bench.local:8751"), true, false),
            ("192.0.2.7:8751", "192.0.2.7:8751", None, true, false),
            ("192.0.2.7:8751", "192.0.2.7:8751", Some("https://evil.example:8751"), true, false),
            ("192.0.2.7:8751", "192.0.2.7:8751", Some("https192.0.2.7:8751"), true, false),
            // another address, another port, another name
            ("192.0.2.7:8751", "192.0.2.8:8751", Some("https://192.0.2.8:8751"), false, false),
            ("192.0.2.7:8751", "192.0.2.7", Some("https://192.0.2.7"), false, false),
            ("192.0.2.7:8751", "bench.evil.example:8751", Some("https://bench.evil.example:8751"), false, false),
            ("192.0.2.7:8751", "evil.example:8751", Some("https://evil.example:8751"), false, false),
            ("127.0.0.1:8751", "localhost:8751", Some("https://localhost:8751"), false, false),
            ("192.0.2.7:8751", "", None, false, false),
        ] {
            let (sent, reached) = (headers(host, origin), reached.parse().ok());
            let accepted = (access.host(&sent, reached).is_some(), access.accepts_websocket(&sent, reached));
            assert_eq!(accepted, (request, websocket), "{host} {origin:?}");
        }
        assert_eq!(access.host(&headers("192.0.2.7:8751", None), None), None, "who does not know where it came in");
        let usual = AccessControl::network(&[], 443);
        assert!(
            usual.host(&headers("192.0.2.7", None), "192.0.2.7:443".parse().ok()).is_some(),
            "without the usual port"
        );
        let sent = access.headers(Some("bench:8751"));
        assert!(sent.iter().any(|(_, value)| value.to_str().unwrap().contains("connect-src 'self' wss://bench:8751;")));
    }

    #[test]
    fn a_token_matches_itself_only() {
        let (one, other) = (Token::new().unwrap(), Token::new().unwrap());
        assert!(one.matches(one.as_str()) && !one.matches(other.as_str()) && !one.matches(""));
        assert!(!one.matches(&one.as_str()[..31]) && one.as_str().len() == 32);
    }
}

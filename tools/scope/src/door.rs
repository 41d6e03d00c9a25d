//! Who may come in, and who may touch: loopback only, our own pages only, commands only with the token.
//!
//! A browser runs the scripts of any page it has open, and any of them may knock at a port of this machine. So a request
//! must name this server as a host no name server could have pointed here (DNS rebinding), and a WebSocket must come from
//! a page of this very origin (cross-site WebSocket hijacking). To look, that is all it takes: another user of this machine
//! may. To command or record takes the token, which only the terminal that started the scope has seen: it stands behind
//! the `#` of the address, which browsers send nowhere.

use axum::http::{HeaderMap, HeaderName, HeaderValue, header};
use subtle::ConstantTimeEq;

use crate::Error;

/// A page may load what this server serves and nothing else, and talk to nobody else; nobody may frame it.
fn policy(port: u16) -> String {
    format!(
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; \
         connect-src 'self' ws://127.0.0.1:{port} ws://localhost:{port}; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    )
}

/// What opens the commands: 128 random bits, in hexadecimal.
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

    /// For the address.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Whether this is it, in a time that does not tell how much of it is right.
    pub fn opens(&self, offered: &str) -> bool {
        self.0.as_bytes().ct_eq(offered.as_bytes()).into()
    }
}

/// The door of a server at this port.
#[derive(Clone)]
pub struct Door {
    port: u16,
}

impl Door {
    /// At `port` of 127.0.0.1.
    pub fn new(port: u16) -> Door {
        Door { port }
    }

    /// Whether a host is this server: a loopback address or `localhost`, and the port.
    fn is_us(&self, host: &str) -> bool {
        host.rsplit_once(':')
            .is_some_and(|(name, port)| matches!(name, "127.0.0.1" | "localhost") && port.parse() == Ok(self.port))
    }

    /// Whether a request was meant for this server.
    pub fn lets_in(&self, headers: &HeaderMap) -> bool {
        text(headers, header::HOST).is_some_and(|host| self.is_us(host))
    }

    /// Whether a WebSocket is opened by one of this server's own pages. Every browser says where it comes from.
    pub fn lets_connect(&self, headers: &HeaderMap) -> bool {
        let origin = text(headers, header::ORIGIN).and_then(|origin| origin.strip_prefix("http://"));
        self.lets_in(headers) && origin.is_some_and(|host| self.is_us(host))
    }

    /// What every answer carries.
    pub fn headers(&self) -> Vec<(HeaderName, HeaderValue)> {
        let policy =
            HeaderValue::from_str(&policy(self.port)).unwrap_or(HeaderValue::from_static("default-src 'none'"));
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

fn text(headers: &HeaderMap, name: HeaderName) -> Option<&str> {
    let mut all = headers.get_all(name).iter();
    // two of them is one too many to know which is meant
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
    fn only_our_own_pages_come_in() {
        let door = Door::new(8750);
        for (host, origin, looks, connects) in [
            ("127.0.0.1:8750", Some("http://127.0.0.1:8750"), true, true),
            ("localhost:8750", Some("http://localhost:8750"), true, true),
            ("127.0.0.1:8750", None, true, false),
            ("127.0.0.1:8750", Some("null"), true, false),
            ("127.0.0.1:8750", Some("https://127.0.0.1:8750"), true, false),
            ("127.0.0.1:8750", Some("http://evil.example"), true, false),
            ("127.0.0.1:8750", Some("http://evil.example:8750"), true, false),
            ("127.0.0.1:8750", Some("http://127.0.0.1:8751"), true, false),
            ("127.0.0.1:8750", Some("http://127.0.0.1:8750.evil.example"), true, false),
            ("evil.example:8750", Some("http://evil.example:8750"), false, false),
            ("127.0.0.1", Some("http://127.0.0.1"), false, false),
            ("127.0.0.1.evil.example:8750", None, false, false),
            ("", None, false, false),
        ] {
            let asked = headers(host, origin);
            assert_eq!((door.lets_in(&asked), door.lets_connect(&asked)), (looks, connects), "{host} {origin:?}");
        }
        let mut twice = headers("127.0.0.1:8750", None);
        twice.append(header::HOST, "evil.example".parse().unwrap());
        assert!(!door.lets_in(&twice));
        assert!(!door.lets_in(&HeaderMap::new()));
    }

    #[test]
    fn a_token_opens_for_itself_alone() {
        let (one, other) = (Token::new().unwrap(), Token::new().unwrap());
        assert!(one.opens(one.as_str()) && !one.opens(other.as_str()) && !one.opens(""));
        assert!(!one.opens(&one.as_str()[..31]) && one.as_str().len() == 32);
    }
}

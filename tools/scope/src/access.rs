//! Access control of the HTTP server: loopback hosts only, WebSockets of our own pages only, commands only with the token.
//!
//! A browser runs the scripts of any page it has open, and any of them may send requests to a port of this machine. So a
//! request must name a host that DNS cannot point here (against DNS rebinding), and a WebSocket must come from a page of this
//! origin (against cross-site WebSocket hijacking). That suffices to watch: other users of this machine may. Commanding and
//! recording require the token, which only the terminal that started the scope has printed: it is in the fragment (`#`) of
//! the address, which browsers do not send to servers.

use axum::http::{HeaderMap, HeaderName, HeaderValue, header};
use subtle::ConstantTimeEq;

use crate::Error;

/// The Content-Security-Policy: a page may load from this server only, connect to this server only, and not be framed.
fn policy(authority: &str) -> String {
    format!(
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; \
         connect-src 'self' ws://{authority}; \
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
    /// The loopback address it listens on, and the port. Not `localhost`: that may be another address with another server,
    /// whose pages would have our name.
    authority: String,
}

impl AccessControl {
    /// At `port` of 127.0.0.1.
    pub fn new(port: u16) -> AccessControl {
        AccessControl { authority: format!("127.0.0.1:{port}") }
    }

    /// Whether a request's `Host` is this server.
    pub fn accepts_request(&self, headers: &HeaderMap) -> bool {
        text(headers, header::HOST).is_some_and(|host| host == self.authority)
    }

    /// Whether a WebSocket is opened by one of this server's own pages: browsers always send the `Origin`.
    pub fn accepts_websocket(&self, headers: &HeaderMap) -> bool {
        let origin = text(headers, header::ORIGIN).and_then(|origin| origin.strip_prefix("http://"));
        self.accepts_request(headers) && origin.is_some_and(|host| host == self.authority)
    }

    /// The security headers of every response.
    pub fn headers(&self) -> Vec<(HeaderName, HeaderValue)> {
        let policy =
            HeaderValue::from_str(&policy(&self.authority)).unwrap_or(HeaderValue::from_static("default-src 'none'"));
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
        let access = AccessControl::new(8750);
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
            let accepted = (access.accepts_request(&sent), access.accepts_websocket(&sent));
            assert_eq!(accepted, (request, websocket), "{host} {origin:?}");
        }
        let mut twice = headers("127.0.0.1:8750", None);
        twice.append(header::HOST, "evil.example".parse().unwrap());
        assert!(!access.accepts_request(&twice));
        assert!(!access.accepts_request(&HeaderMap::new()));
    }

    #[test]
    fn a_token_matches_itself_only() {
        let (one, other) = (Token::new().unwrap(), Token::new().unwrap());
        assert!(one.matches(one.as_str()) && !one.matches(other.as_str()) && !one.matches(""));
        assert!(!one.matches(&one.as_str()[..31]) && one.as_str().len() == 32);
    }
}

//! A small server for HTTP and WebSockets, with bounds: what the scope and the bridges share.
//!
//! Clients, bytes and rates are bounded (`limits`): connections as they come in (`door`), and those that stall or send too
//! much (`connection`). Every refusal is counted (`traffic`). A connection carries one request, or becomes a live client by a
//! WebSocket ([`Line::is_live`], [`Traffic::open_client`], [`receive`], [`send`], [`part`]); what such a client may do is up to whoever serves it.
//!
//! On the network a port speaks TLS (`channel`), with a certificate of the user's own that is kept (`certificate`), at the addresses and
//! names of this machine (`machine`).
//!
//! ```
//! use std::net::Ipv4Addr;
//! use std::sync::Arc;
//! use sinew_server::{Limits, Port, Traffic, listen, serve};
//!
//! let traffic = Arc::new(Traffic::new(Limits::default()));
//! let router = axum::Router::new().route("/", axum::routing::get(|| async { "good day\n" }));
//! let listener = listen((Ipv4Addr::LOCALHOST, 0).into())?;
//! let port = Port { listener, router, traffic: traffic.clone(), certificate: None };
//! serve([port], || true)?; // until the closure says that it is time
//! assert_eq!(traffic.figures().refused_in_all, 0);
//! # Ok::<(), std::io::Error>(())
//! ```
#![forbid(unsafe_code)]

mod certificate;
mod channel;
mod connection;
mod door;
mod limits;
mod live;
mod machine;
mod serve;
mod traffic;

pub use certificate::Certificate;
pub use connection::Line;
pub use limits::{Allowance, Flow, Limits};
pub use live::{End, part, receive, send, turn_away};
pub use machine::{addresses, names};
pub use serve::{Port, answer, listen, serve};
pub use traffic::{Figures, Refusal, Traffic};

//! A small server for HTTP and WebSockets, with bounds: what the scope and the bridges share.
//!
//! Clients, bytes and rates are bounded (`limits`): connections as they come in, and those that stall or send too much
//! (`door`). Every refusal is counted (`traffic`). A connection carries one request, or becomes a live client by a
//! WebSocket ([`Line::is_live`], [`Traffic::open_client`], [`receive`], [`send`], [`part`]); what such a client may do is up to whoever serves it.
//!
//! ```
//! use std::net::Ipv4Addr;
//! use std::sync::Arc;
//! use sinew_server::{Limits, Traffic, listen, serve};
//!
//! let traffic = Arc::new(Traffic::new(Limits::default()));
//! let router = axum::Router::new().route("/", axum::routing::get(|| async { "good day\n" }));
//! let listener = listen((Ipv4Addr::LOCALHOST, 0).into())?;
//! serve(listener, router, traffic.clone(), || true)?; // until the closure says that it is time
//! assert_eq!(traffic.figures().refused_in_all, 0);
//! # Ok::<(), std::io::Error>(())
//! ```
#![forbid(unsafe_code)]

mod door;
mod limits;
mod live;
mod serve;
mod traffic;

pub use door::{Connection, Door, Line};
pub use limits::{Allowance, Flow, Limits};
pub use live::{End, part, receive, send, turn_away};
pub use serve::{answer, listen, serve};
pub use traffic::{Figures, Refusal, Traffic};

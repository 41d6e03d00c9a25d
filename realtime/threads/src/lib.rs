//! The threads of sinew's programs: how they are started, and what comes of the death of each.
//!
//! A thread dies when it panics, or when it ends though nobody has asked for its end and its work is not done. What comes of that
//! is said once, in the [table](TABLE): a driver whose commands nobody takes any more must not go on heating, one that keeps no
//! black box may. [`Thread::start`] is how every thread of a program is started that is there for as long as it runs: it sees that
//! the thread has died, does at once what has to be done ([`Start::on_death`]), keeps in mind that it is dead ([`dead`]), and then says so.
//!
//! ```
//! use std::sync::Arc;
//! use std::sync::atomic::{AtomicBool, Ordering};
//! use sinew_threads::{Thread, dead, rows};
//!
//! let stop = Arc::new(AtomicBool::new(false));
//! let stopping = stop.clone();
//! let desk = Thread::Desk.start().on_death(move || stopping.store(true, Ordering::Relaxed));
//! let desk = desk.spawn(|| panic!("a mistake"))?;
//! assert!(desk.join().is_ok_and(|worked| worked.is_none()), "it died, and nobody else with it");
//! assert!(stop.load(Ordering::Relaxed));
//! assert!(rows(dead()).any(|row| row.thread == Thread::Desk));
//! # Ok::<(), std::io::Error>(())
//! ```
#![forbid(unsafe_code)]

mod notice;
mod start;
mod strike;
mod table;

pub use notice::caught;
pub use start::{Start, dead};
pub use strike::{STRIKE_FILE, is_struck};
pub use table::{Comes, Row, TABLE, Thread, rows, table_markdown};

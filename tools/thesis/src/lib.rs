//! The thesis page by page: a row for each numbered and each displayed equation, each table and each simulated or measured figure,
//! with what is stated there, in our words, and what the project's own code computes.
//!
//! A row declares how it is judged before it is run: numbers with their tolerances, or why it differs with numbers that prove it,
//! or what is not given, or what is not yet built. [`run`] runs chapters, [`page`] makes a page of them, [`markdown`] the table
//! of docs/thesis.md, [`summary`] and [`list`] text for a terminal. A row that does not come out as it declares is
//! [`Verdict::Unexplained`]; a test of each chapter finds it.
//!
//! # Example
//! ```
//! use sinew_thesis::{Chapter, Verdict, rows};
//!
//! let chapter = Chapter::named("3").ok_or("no such chapter")?;
//! assert!(rows(chapter).iter().any(|row| row.place.to_string() == "eq. 20"));
//! assert_eq!(Verdict::WORDS[0], "agrees");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod axes;
mod book;
mod chapter;
mod chapters;
mod found;
mod lab;
mod markdown;
mod page;
mod row;
mod text;
mod wires;

pub use book::{Apart, Book, apart, rows, run};
pub use chapter::{Chapter, Place};
pub use found::{Check, Found, Picture, Tried, Wanted};
pub use lab::Lab;
pub use markdown::markdown;
pub use page::page;
pub use row::{Code, Compute, Computed, Done, How, Row, Verdict};
pub use text::{list, summary};

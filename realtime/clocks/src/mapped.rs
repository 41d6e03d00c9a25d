//! A time on another clock with its error, and times for people.

use std::fmt;

/// A time on another clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mapped<T> {
    /// The time, ns.
    pub ns: T,
    /// What it is off by at the most, ns.
    pub error_ns: u64,
}

impl<T: fmt::Display> fmt::Display for Mapped<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ns ± {}", self.ns, Span(self.error_ns))
    }
}

/// A time for people, ns.
pub(crate) struct Span(pub(crate) u64);

impl fmt::Display for Span {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            ns @ 0..10_000 => write!(f, "{ns} ns"),
            ns @ 10_000..10_000_000 => write!(f, "{:.1} µs", ns as f64 * 1e-3),
            ns @ 10_000_000..1_000_000_000 => write!(f, "{:.1} ms", ns as f64 * 1e-6),
            ns => write!(f, "{:.3} s", ns as f64 * 1e-9),
        }
    }
}

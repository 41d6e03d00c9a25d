//! The bridge to Prometheus: what a driver does, as metrics that are looked up when they are asked for.
//!
//! Nothing runs between two scrapes: each takes one look at the driver's latest state and figures, which waits for nobody.

mod metrics;
mod server;

pub use metrics::metric_table_markdown;
pub use server::Prometheus;

//! The driver: the real-time loop, the safety supervisor, the contract of backends, publishing and commands.

mod backend;

pub use backend::{Backend, BackendError, ChannelFault, Sample, Truth};

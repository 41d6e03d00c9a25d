//! Recordings as a backend, and the driver on them: the suite of backends needs recordings that the engine made.

mod common;
mod contract;
mod driver;
mod replay;
mod rows;

#[global_allocator]
static ALLOCATOR: sinew_backend::allocations::CountingAllocator = sinew_backend::allocations::CountingAllocator;

//! Recordings as a backend, and the driver on them.

mod common;
mod contract;
mod driver;
mod replay;
mod rows;

#[global_allocator]
static ALLOCATOR: sinew_driver::CountingAllocator = sinew_driver::CountingAllocator;

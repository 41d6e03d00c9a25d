//! The backend on a simulated kernel.

mod bench;
mod contract;
mod guard;
mod lines;
mod sim;

#[global_allocator]
static ALLOCATOR: sinew_backend::allocations::CountingAllocator = sinew_backend::allocations::CountingAllocator;

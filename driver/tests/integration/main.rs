//! The driver on a scripted backend.

mod clearing;
mod common;
mod driver;
mod safety;

#[global_allocator]
static ALLOCATOR: sinew_backend::allocations::CountingAllocator = sinew_backend::allocations::CountingAllocator;

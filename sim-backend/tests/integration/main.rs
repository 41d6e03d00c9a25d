//! The simulated rig.

mod contract;
mod health;
mod joint;
mod rig;

#[global_allocator]
static ALLOCATOR: sinew_backend::allocations::CountingAllocator = sinew_backend::allocations::CountingAllocator;

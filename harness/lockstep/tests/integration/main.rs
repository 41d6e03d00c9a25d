//! The driver's engine on simulated wires.

mod detection;
mod guard;
mod joint_control;
mod laws;

#[global_allocator]
static ALLOCATOR: sinew_backend::allocations::CountingAllocator = sinew_backend::allocations::CountingAllocator;

//! The simulated rig, alone and under the driver's engine.

mod contract;
mod detection;
mod guard;
mod health;
mod joint;
mod joint_control;
mod laws;
mod rig;

#[global_allocator]
static ALLOCATOR: sinew_driver::CountingAllocator = sinew_driver::CountingAllocator;

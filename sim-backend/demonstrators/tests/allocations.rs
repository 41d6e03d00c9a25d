//! The loop that calls a demonstrator allocates nothing: held to it for longer than any of its clocks.

use sinew_backend::allocations::{CountingAllocator, calls_of_this_thread};
use sinew_backend::{Backend, Sample};
use sinew_demonstrators::{ARM, BALL_ON_BEAM, Demonstrator, DemonstratorBackend, SERVO, TORSO, WALKER};
use sinew_rig::Rig;
use sinew_sim_backend::SimulatedRig;

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

#[test]
fn no_period_allocates() {
    for text in [BALL_ON_BEAM, SERVO, ARM, WALKER, TORSO] {
        let rig = Rig::parse(text, "demonstrator.toml").unwrap();
        let wires = SimulatedRig::new(&rig).unwrap();
        let mut backend = DemonstratorBackend::new(wires, Demonstrator::of(&rig).unwrap().unwrap());
        let mut samples = vec![Sample::NONE; rig.channels.len()];
        backend.start().unwrap();
        for period in 0..120_000_u32 {
            // up and down, so that a ball is put down and falls
            let duties = [if period % 4000 < 2000 { 0.3 } else { 0.05 }; 18];
            let before = calls_of_this_thread();
            if period % 1000 == 999 {
                backend.missed(5);
            }
            backend.exchange(&duties[..samples.len()], &mut samples).unwrap();
            assert_eq!(calls_of_this_thread(), before, "period {period} of {}", rig.name);
        }
    }
}

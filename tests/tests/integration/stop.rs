//! The emergency stop and the enable line, as who stands by the rig sees them.

use sinew_ipc::{ChannelState, Client};
use sinew_tests::{Driver, Rig, wait_until};

/// A rig whose emergency stop is reset by its button between these times, and pressed between those, s of simulated time.
fn rig(reset_s: [f64; 2], pressed_s: [f64; 2]) -> Rig {
    let event = |kind: &str, [start_s, end_s]: [f64; 2]| {
        format!("\n[[simulation.fault]]\nkind = \"{kind}\"\nstart_s = {start_s:?}\nend_s = {end_s:?}\n")
    };
    let more = [
        "\n[backend.enable]\nsignal = \"pulses\"\n\n[backend.estop]\nfitted = true\n".to_string(),
        event("estop_reset", reset_s),
        event("estop_open", pressed_s),
    ];
    Rig::bench(&["left", "right"], &more.concat())
}

fn all_are_stopped(client: &Client) -> bool {
    let state = client.latest();
    let is_stopped =
        |c: &ChannelState| c.duty == 0.0 && c.fault().is_some() && c.flags & ChannelState::FLAG_STOPPED != 0;
    state.cycle > 0 && state.channels().iter().all(is_stopped)
}

#[test]
fn a_rig_with_an_emergency_stop_starts_with_it_latched_and_no_client_resets_it() {
    let never = [1e6, 2e6];
    let rig = rig(never, never);
    let driver = Driver::start(&rig);
    let client = rig.client();
    wait_until("the latch", || all_are_stopped(&client));
    for command in [&["reset", "left"][..], &["set", "left", "stroke=30%"]] {
        let refused = rig.ask(command).expect(1);
        assert!(
            refused.stderr.contains("emergency_stop") && refused.stderr.contains("reset button"),
            "{}",
            refused.stderr
        );
    }
    assert!(all_are_stopped(&client));
    let status = rig.ask(&["status"]).expect(0).stdout;
    assert!(status.contains("emergency_stop"), "{status}");
    driver.stop();
}

#[test]
fn its_button_permits_the_channels_reset_and_pressing_it_again_takes_everything() {
    let rig = rig([1.0, 4.0], [30.0, 30.1]);
    let driver = Driver::start(&rig);
    let client = rig.client();
    wait_until("the latch", || all_are_stopped(&client));
    wait_until("the channels' reset", || client.reset("left").is_ok() && client.reset("right").is_ok());
    for channel in ["left", "right"] {
        client.set_duty(channel, 0.05, std::time::Duration::from_secs(100)).expect("it may be powered again");
    }
    wait_until("power", || client.latest().channels().iter().all(|channel| channel.duty == 0.05));
    // Open for a moment only: it stays.
    wait_until("the stop", || all_are_stopped(&client));
    assert!(client.reset("left").is_err());
    driver.stop();
}

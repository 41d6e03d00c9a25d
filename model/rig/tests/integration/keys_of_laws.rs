//! Keys that only some control laws take: with another law they are refused, and the laws that do take them are named.

use sinew_rig::Algorithm;

use crate::mistakes::with;

#[test]
fn keys_that_the_law_does_not_take() {
    // The laws that take a key are whichever there are; those of the thesis are among them.
    let takers = |key: &str, least: &[&str]| {
        let laws = Algorithm::ALL.iter().filter(|(_, law)| law.takes(key));
        let words: Vec<String> = laws.map(|(word, _)| format!("\"{word}\"")).collect();
        assert!(least.iter().all(|word| words.contains(&format!("\"{word}\""))), "{key}: {words:?}");
        match words.split_last().unwrap() {
            (last, []) => last.clone(),
            (last, others) => format!("{} or {last}", others.join(", ")),
        }
    };
    let with_lambda = [
        "time_optimal",
        "sliding_mode",
        "sliding_mode_plain",
        "sliding_mode_first_order",
        "sliding_mode_first_order_equivalent",
        "input_output_linearised",
        "input_output_linearised_constant",
        "velocity_servo",
        "velocity_servo_scheduled",
    ];
    with(
        "[channel.control]\nalgorithm = \"pi\"\nlambda_per_s = 10\n",
        &format!(
            "rig.toml:25: channel \"wire\": control.lambda_per_s makes no sense with algorithm = \"pi\"; \
             take it out or choose {}",
            takers("lambda_per_s", &with_lambda)
        ),
    );
    with(
        "[channel.control]\npi_integral_per_mm_s = 1\n",
        &format!(
            "rig.toml:24: channel \"wire\": control.pi_integral_per_mm_s makes no sense with algorithm = \"time_optimal\"; \
             take it out or choose {}",
            takers("pi_integral_per_mm_s", &["pi", "pid"])
        ),
    );
    with(
        "[channel.control]\nalgorithm = \"pi\"\npid_derivative_s_per_mm = 0.1\n",
        &format!(
            "rig.toml:25: channel \"wire\": control.pid_derivative_s_per_mm makes no sense with algorithm = \"pi\"; \
             take it out or choose {}",
            takers("pid_derivative_s_per_mm", &["pid"])
        ),
    );
    with(
        "[channel.control]\nalgorithm = \"pid\"\nrelay_band_mm = 0.1\n",
        &format!(
            "rig.toml:25: channel \"wire\": control.relay_band_mm makes no sense with algorithm = \"pid\"; \
             take it out or choose {}",
            takers("relay_band_mm", &["relay"])
        ),
    );
    with(
        "[channel.control]\nalgorithm = \"relay\"\nheat_loss_feedforward = true\n",
        &format!(
            "rig.toml:25: channel \"wire\": control.heat_loss_feedforward makes no sense with algorithm = \"relay\"; \
             take it out or choose {}",
            takers(
                "heat_loss_feedforward",
                &["pi", "pid", "input_output_linearised", "input_output_linearised_constant"]
            )
        ),
    );
    with(
        "[channel.control]\nalgorithm = \"pid\"\nheat_loss_feedforward = \"on\"\n",
        "rig.toml:25: channel \"wire\": control.heat_loss_feedforward is the text \"on\", expected true or false",
    );
}

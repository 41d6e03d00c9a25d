//! Linux's own PWM outputs and converters: what a channel needs there.

use crate::error::What;
use crate::notes::{Reader, Stated};
use crate::tables::{BackendKind, Channel, EnableSignal, LinuxChannel, Rig, SamplingCircuit, Sensing};

/// Lines that switch the supply, or stop everything, have to be somewhere.
pub(crate) fn lines_are_given(reader: &mut Reader<'_>, rig: &Rig, stated: &Stated<'_>) {
    if rig.backend.kind != BackendKind::Linux {
        return;
    }
    let (enable, stop) = (&rig.backend.enable, &rig.backend.estop);
    let needed = [
        (enable.signal != EnableSignal::None, &enable.line, "enable", "the line that switches the supply", 17),
        (stop.fitted, &stop.line, "estop", "the line of the emergency stop's contact", 27),
    ];
    for (_, _, table, which, example) in needed.into_iter().filter(|(wanted, line, ..)| *wanted && line.is_none()) {
        let expected = format!(
            "{which}, such as \"gpiochip0/{example}\" or \"/sys/class/gpio/gpio{example}/value\"; `sinew doctor` lists \
             the chips"
        );
        let what = What::Missing { expected };
        reader.problem(stated.line_at(&["backend", table]), None, format!("backend.{table}.line"), what);
    }
}

/// What a channel on Linux's own interfaces cannot do without, and what these cannot do.
pub(super) fn channels(reader: &mut Reader<'_>, rig: &Rig, stated: &[Stated<'_>]) {
    for (channel, stated) in rig.channels.iter().zip(stated) {
        gains_measure(reader, channel, stated);
        if rig.backend.kind == BackendKind::Linux {
            channel_has_its_place(reader, channel, stated);
        }
    }
}

fn gains_measure(reader: &mut Reader<'_>, channel: &Channel, stated: &Stated<'_>) {
    let LinuxChannel { v1, v2, v3, current, supply, .. } = &channel.backend.linux;
    for (key, input) in
        [("v1_gain", v1), ("v2_gain", v2), ("v3_gain", v3), ("current_gain", current), ("supply_gain", supply)]
    {
        if input.gain == 0.0 {
            let message = "is 0: nothing could be measured; expected what one volt at the converter stands for".into();
            let line = stated.line_at(&["linux", key]);
            reader.problem(line, Some(&channel.name), format!("linux.{key}"), What::Contradiction { message });
        }
    }
}

fn channel_has_its_place(reader: &mut Reader<'_>, channel: &Channel, stated: &Stated<'_>) {
    let LinuxChannel { pwm, v1, v2, v3, current, .. } = &channel.backend.linux;
    let mut needed = vec![
        ("pwm", pwm, "the output, such as \"pwmchip0/1\""),
        ("v3", &v3.name, "the moving end's input, such as \"1-0048:in_voltage2\""),
        ("current", &current.name, "the current's input, such as \"1-0048:in_current0\""),
    ];
    if channel.control.sensing == Sensing::Dual && channel.model.taps.is_some() {
        needed.push(("v1", &v1.name, "the first tap's input, such as \"1-0048:in_voltage0\""));
        needed.push(("v2", &v2.name, "the second tap's input, such as \"1-0048:in_voltage1\""));
    }
    let line = stated.line_at(&["linux"]);
    for (key, _, expected) in needed.into_iter().filter(|(_, value, _)| value.is_none()) {
        let what = What::Missing { expected: expected.into() };
        reader.problem(line, Some(&channel.name), format!("linux.{key}"), what);
    }
    if channel.adc.circuit == SamplingCircuit::Shared {
        let message =
            "cannot be sampled by backend \"linux\", which knows no off-phase; expected \"separate_taps\"".into();
        let line = stated.line_at(&["adc", "circuit"]);
        reader.problem(line, Some(&channel.name), "adc.circuit", What::Contradiction { message });
    }
}

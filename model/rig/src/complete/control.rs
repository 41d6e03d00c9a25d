//! The controller: its computed defaults, and what it needs of taps and limits.

use sinew_physics::DriveKind;

use crate::notes::{Reader, Stated, tidy};
use crate::tables::{Channel, Sensing};

pub(super) fn dual_has_taps(reader: &mut Reader<'_>, channel: &Channel, stated: &Stated<'_>) {
    if channel.model.taps.is_none() && !stated.has_table("taps") && channel.control.sensing == Sensing::Dual {
        let message = "is \"dual\" but there is no [channel.taps]; add the taps or use \"resistance\"";
        reader.out_of_place(stated, ("control", "sensing"), message);
    }
}

/// Fills in what is measured by, where the file does not say it.
pub(super) fn fill_sensing(channel: &mut Channel, stated: &Stated<'_>) {
    if !stated.gives("control", "sensing") {
        channel.control.sensing = if channel.model.taps.is_some() { Sensing::Dual } else { Sensing::Resistance };
    }
}

/// Fills in the gains that follow from the wire's stroke, in m.
pub(super) fn fill_gains(channel: &mut Channel, stroke_m: f64, stated: &Stated<'_>) {
    let control = &mut channel.control;
    let stroke_m = stroke_m.max(0.001 * channel.model.geometry.length_m);
    if !stated.gives("control", "pi_proportional_per_mm") {
        control.pi_proportional_per_m = 1.0 / (0.3 * stroke_m);
    }
    if !stated.gives("control", "pi_integral_per_mm_s") {
        control.pi_integral_per_m_s = 1.0 / (0.3 * stroke_m);
    }
    if !stated.gives("control", "pid_derivative_s_per_mm") {
        control.pid_derivative_s_per_m = 0.05 / (0.3 * stroke_m);
    }
}

/// The duty that is always on against the largest one, of a complete channel.
pub(super) fn relations(reader: &mut Reader<'_>, channel: &Channel, stated: &Stated<'_>) {
    let Channel { limits, control, model, .. } = channel;
    if control.segment > control.segments {
        let message =
            format!("is {} of {} pieces: segments says how many there are", control.segment, control.segments);
        reader.contradiction(stated, &[("control", "segment"), ("control", "segments")], message);
    }
    if model.drive.kind == DriveKind::Pwm && control.minimum_duty >= limits.max_duty {
        reader.contradiction(
            stated,
            &[("control", "sensing_duty"), ("limits", "maximum_duty"), ("limits", "maximum_power_w")],
            format!(
                "leaves nothing to control with: sensing_duty {} is not below the largest duty, {}",
                control.minimum_duty,
                tidy(limits.max_duty)
            ),
        );
    }
}

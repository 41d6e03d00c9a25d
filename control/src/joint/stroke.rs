//! How far a joint turns.

use crate::stroke::StrokeRange;
use sinew_physics::{Error, Joint, WireModel};

/// The whole way of a joint, in rad: the mean stroke of its wires in their nominal loads, over the lever.
pub(crate) fn stroke_rad(joint: &Joint, models: [&WireModel; 2]) -> Result<f64, Error> {
    let stroke_m = 0.5 * (StrokeRange::of(models[0])?.stroke_m() + StrokeRange::of(models[1])?.stroke_m());
    Ok((stroke_m / joint.radius_m).max(1e-9))
}

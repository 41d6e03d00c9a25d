//! What of a driver's channel can be shown: every published field that is a float.

use sinew_ipc::ChannelState;

/// How many quantities a channel has.
pub const COUNT: usize = ChannelState::FLOATS;

/// Their names, as in recordings: unit included.
pub fn names() -> impl Iterator<Item = &'static str> {
    ChannelState::FIELDS[..COUNT].iter().map(|field| field.name)
}

/// Their values. What is not known, or of no end such as the lease of a channel that the driver moves by itself, is NaN.
pub fn values(state: &ChannelState) -> [f32; COUNT] {
    state.parts().0.map(|value| if value.is_finite() { value as f32 } else { f32::NAN })
}

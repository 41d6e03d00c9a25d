//! The layout of a driver's recording: a channel's state as the driver publishes it, byte for byte.

use sinew_ipc::{ChannelState, FieldKind};
use sinew_recording::session::{Field, Layout, Trouble};

/// Channels of these names, each with all fields of [`ChannelState`] in the order of their bytes.
///
/// # Errors
/// [`Trouble::Layout`] when two channels have one name.
pub fn layout(channels: Vec<String>) -> Result<Layout, Trouble> {
    let fields = ChannelState::FIELDS.iter().map(|field| match field.kind {
        FieldKind::Float => Field::f64(field.name, field.unit),
        FieldKind::Code => Field::u32(field.name),
    });
    Layout::new(channels, fields.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_channel_is_its_state_byte_for_byte() {
        let layout = layout(vec!["wire".into()]).unwrap();
        assert_eq!(layout.stride(), size_of::<ChannelState>());
        let state =
            ChannelState::from_parts(&std::array::from_fn(|i| i as f64 - 0.5), &std::array::from_fn(|i| i as u32 + 7));
        let (floats, codes) = state.parts();
        let numbers = floats.iter().flat_map(|v| v.to_le_bytes()).chain(codes.iter().flat_map(|v| v.to_le_bytes()));
        assert_eq!(ChannelState::bytes_of(&[state]), numbers.collect::<Vec<u8>>());
    }
}

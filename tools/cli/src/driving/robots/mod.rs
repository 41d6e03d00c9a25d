//! The robot programs of `sinew demo`, as they stand in `examples/`: each whole by itself, to be copied.

pub mod arm;
pub mod ball_on_beam;
pub mod servo;
pub mod torso;
pub mod walker;

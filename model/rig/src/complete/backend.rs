//! What each kind of backend cannot do without, and what it cannot do, once all channels are read.

pub(super) mod linux;
pub(super) mod serial;

use crate::notes::{Reader, Stated};
use crate::tables::Rig;

/// What each kind finds wrong with the channels it is to power and measure.
pub(super) static CHECKS: [fn(&mut Reader<'_>, &Rig, &[Stated<'_>]); 2] = [serial::channels, linux::channels];

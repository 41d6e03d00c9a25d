//! What is on the axes of more than one chapter's pictures: name and unit.

pub(crate) const TIME: (&str, &str) = ("Time", "s");
pub(crate) const STRAIN: (&str, &str) = ("Strain", "1");
pub(crate) const STRESS: (&str, &str) = ("Stress, MPa", "1");
pub(crate) const TEMPERATURE: (&str, &str) = ("Temperature", "°C");

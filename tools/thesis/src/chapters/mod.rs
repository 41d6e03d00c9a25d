//! The rows, a file for each chapter.

mod amplifier;
pub(crate) mod apart;
pub(crate) mod appendix;
pub(crate) mod eight;
pub(crate) mod eleven;
pub(crate) mod five;
pub(crate) mod four;
pub(crate) mod nine;
mod segments;
pub(crate) mod seven;
pub(crate) mod six;
pub(crate) mod ten;
pub(crate) mod three;
pub(crate) mod twelve;
pub(crate) mod two;

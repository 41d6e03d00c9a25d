//! The header is that of the code.

mod header;

//! Makes concealed cases with a simulator of its own and scores the diagnosis on them.
fn main() {}

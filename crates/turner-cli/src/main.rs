//! turner.
fn main() {}

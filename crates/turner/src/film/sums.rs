//! Stub.
/// p
pub struct Film;
/// r
pub struct NonFinite;

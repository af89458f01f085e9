//! Stub.
/// p
pub struct Picture;
/// r
pub struct PixelRect;

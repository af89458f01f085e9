//! Vectors and masks of eight lanes in memory.

use turner_bvh::lanes::{Block, LANES};

use super::DVec3;

/// Stores a vector in a lane.
#[inline]
pub fn set_vector([x, y, z]: &mut [Block; 3], lane: usize, v: DVec3) {
    (x.0[lane], y.0[lane], z.0[lane]) = (v.x, v.y, v.z);
}

/// The vector in a lane.
#[inline]
pub fn vector([x, y, z]: &[Block; 3], lane: usize) -> DVec3 {
    DVec3::new(x.0[lane], y.0[lane], z.0[lane])
}

/// Sets or clears the bit of a lane.
#[inline]
pub fn set_bit(mask: &mut u8, lane: usize, on: bool) {
    *mask = *mask & !(1 << lane) | u8::from(on) << lane;
}

/// Indices of the set bits.
#[inline]
pub fn bits(mut mask: u8) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = mask.trailing_zeros() as usize;
        mask &= mask.wrapping_sub(1);
        (lane < LANES).then_some(lane)
    })
}

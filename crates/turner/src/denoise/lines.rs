//! Vectors in rows of numbers, at any column.

use turner_bvh::lanes::{Block32, F32x8, LANES, Simd};

/// A vector of a row.
#[inline(always)]
pub(super) fn block(row: &[f32], from: usize) -> Block32 {
    Block32(*row[from..].first_chunk().expect("rows are long enough"))
}

/// Adds a vector to a row.
#[inline(always)]
pub(super) fn add<S: Simd>(simd: S, row: &mut [f32], from: usize, more: F32x8<S>) {
    let mut sum = Block32::default();
    (F32x8::load(simd, &block(row, from)) + more).store(&mut sum);
    row[from..from + LANES].copy_from_slice(&sum.0);
}

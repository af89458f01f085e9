//! Vectors of numbers, and the choice of instructions at run time.
//!
//! A search is written once, against [`Simd`], and compiled for each set of instructions. [`dispatch`] picks one
//! when a search starts, not within it. A value of a `Simd` type is the proof that the machine has those
//! instructions: it is made by [`dispatch`] alone, and every vector is made through it.
//!
//! What decides a hit uses exactly rounded operations only (`add sub mul div`, comparisons; never a fused product),
//! the same in the same order on every machine. Box tests may fuse: they are padded and decide nothing.

mod instruction_set;
#[cfg(target_arch = "aarch64")]
mod neon;
mod portable;
#[cfg(target_arch = "x86_64")]
mod x86;

pub use instruction_set::InstructionSet;
pub(crate) use instruction_set::{Kind, WithSimd, dispatch};
#[cfg(any(test, target_arch = "aarch64"))]
pub(crate) use portable::Portable;

/// A vector of `f32`. Masks have one bit per lane, the first lane lowest.
pub(crate) trait Lanes: Copy {
    fn add(self, other: Self) -> Self;
    fn sub(self, other: Self) -> Self;
    fn mul(self, other: Self) -> Self;
    fn div(self, other: Self) -> Self;
    /// The smaller one; `other` if one is NaN, or either.
    fn min(self, other: Self) -> Self;
    fn max(self, other: Self) -> Self;
    fn abs(self) -> Self;
    /// The size of `self`, the sign of `other`.
    fn with_sign(self, other: Self) -> Self;
    /// `self * a + b`, with one rounding or two: for box tests only.
    fn mul_add(self, a: Self, b: Self) -> Self;
    /// `1 / self` but for an error of at most 2^-11 of it, where that is a normal number: for what decides nothing.
    fn near_inverse(self) -> Self;
    fn le(self, other: Self) -> u32;
    fn lt(self, other: Self) -> u32;
    /// The smallest and the largest lane; not called with NaN.
    fn range(self) -> [f32; 2];
    /// The lanes of `self` in `mask`, of `other` elsewhere, bit for bit.
    fn choose(self, mask: u32, other: Self) -> Self;
    /// Writes all lanes.
    fn store(self, to: &mut [f32]);
}

/// A set of instructions.
pub(crate) trait Simd: Copy {
    /// Four numbers: the set-up of a ray.
    type F4: Lanes;
    type F8: Lanes;
    /// As many rays as are tested against one triangle at once.
    type Packet: Lanes;
    /// How many: at most 16.
    const PACKET: usize;

    fn splat4(self, x: f32) -> Self::F4;
    fn load4(self, from: &[f32; 4]) -> Self::F4;
    fn splat8(self, x: f32) -> Self::F8;
    fn load8(self, from: &[f32; 8]) -> Self::F8;
    /// Rows become columns.
    fn transpose8(self, rows: [Self::F8; 8]) -> [Self::F8; 8];
    fn splat_packet(self, x: f32) -> Self::Packet;
    /// From the first `PACKET` numbers.
    fn load_packet(self, from: &[f32; 16]) -> Self::Packet;

    /// Writes those lanes of `near` that are at most `far`, and their `children`, in the order of eight lane numbers of
    /// three bits, lowest first, without gaps; returns how many. What is written behind them is arbitrary.
    fn push_ordered(
        self,
        near: Self::F8,
        far: Self::F8,
        children: &[u32; 8],
        order: u32,
        stack: (&mut [u32; 8], &mut [f32; 8]),
    ) -> usize;

    /// Writes the children in `hit`, without gaps; returns how many.
    fn push_any(self, hit: u32, children: &[u32; 8], stack: &mut [u32; 8]) -> usize;

    /// Writes the children in `kept` and their `near`, without gaps; returns how many.
    fn push_kept(
        self,
        kept: u32,
        children: &[u32; 8],
        near: &[f32; 8],
        to_child: &mut [u32; 8],
        to_near: &mut [f32; 8],
    ) -> usize;

    /// Asks for four cache lines ahead of time, wherever they may be.
    fn prefetch(self, from: *const u8);
}

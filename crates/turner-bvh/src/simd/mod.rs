//! SIMD vectors of f32, and the choice of the instruction set at run time.
//!
//! Traversal is written once against [`Simd`] and compiled for each instruction set. [`dispatch`] selects one when a
//! query starts. A value of a `Simd` type proves that the machine supports the instructions: only [`dispatch`] makes
//! one, and every vector is made through it.
//!
//! Operations that decide a hit are exactly rounded (`add sub mul div`, comparisons; never fused), in the same order on
//! every machine. Box tests may use fused operations, because padding covers their error.

mod instruction_set;
#[cfg(target_arch = "aarch64")]
mod neon;
mod portable;
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
mod simd128;
#[cfg(target_arch = "x86_64")]
mod x86;

pub use instruction_set::InstructionSet;
pub(crate) use instruction_set::{Kind, WithSimd, dispatch};
#[cfg(any(test, target_arch = "aarch64", all(target_arch = "wasm32", target_feature = "simd128")))]
pub(crate) use portable::Portable;

/// A vector of `f32`. Masks have one bit per lane, the first lane lowest.
pub(crate) trait Lanes: Copy {
    fn add(self, other: Self) -> Self;
    fn sub(self, other: Self) -> Self;
    fn mul(self, other: Self) -> Self;
    fn div(self, other: Self) -> Self;
    /// The smaller one; `other` if either is NaN.
    fn min(self, other: Self) -> Self;
    fn max(self, other: Self) -> Self;
    fn abs(self) -> Self;
    /// The magnitude of `self` with the sign of `other`.
    fn with_sign(self, other: Self) -> Self;
    /// `self * a + b`, with one rounding or two: for box tests only.
    fn mul_add(self, a: Self, b: Self) -> Self;
    /// `1 / self` with a relative error of at most 2^-11, if the result is a normal number. Must not decide hits.
    fn near_inverse(self) -> Self;
    fn le(self, other: Self) -> u32;
    fn lt(self, other: Self) -> u32;
    /// The smallest and the largest lane; must not be called with NaN.
    fn range(self) -> [f32; 2];
    /// The lanes of `self` in `mask`, of `other` elsewhere, bit for bit.
    fn choose(self, mask: u32, other: Self) -> Self;
    /// Writes all lanes.
    fn store(self, to: &mut [f32]);
}

/// An instruction set.
pub(crate) trait Simd: Copy {
    /// Four lanes, for the setup of a ray.
    type F4: Lanes;
    type F8: Lanes;
    /// A packet: one lane per ray that is tested against a triangle.
    type Packet: Lanes;
    /// Lanes of a packet, at most 16.
    const PACKET: usize;

    fn splat4(self, x: f32) -> Self::F4;
    fn load4(self, from: &[f32; 4]) -> Self::F4;
    fn splat8(self, x: f32) -> Self::F8;
    fn load8(self, from: &[f32; 8]) -> Self::F8;
    /// Transposes an 8 x 8 matrix.
    fn transpose8(self, rows: [Self::F8; 8]) -> [Self::F8; 8];
    fn splat_packet(self, x: f32) -> Self::Packet;
    /// Loads the first `PACKET` numbers.
    fn load_packet(self, from: &[f32; 16]) -> Self::Packet;

    /// Compacts the lanes with `near <= far` and their `children` to the front, in the order of eight three-bit lane
    /// indices, lowest bits first. Returns their count; what follows them is arbitrary.
    fn push_ordered(
        self,
        near: Self::F8,
        far: Self::F8,
        children: &[u32; 8],
        order: u32,
        stack: (&mut [u32; 8], &mut [f32; 8]),
    ) -> usize;

    /// Compacts the children in `hit` to the front; returns their count.
    fn push_any(self, hit: u32, children: &[u32; 8], stack: &mut [u32; 8]) -> usize;

    /// Compacts the children in `kept` and their `near` to the front; returns their count.
    fn push_kept(
        self,
        kept: u32,
        children: &[u32; 8],
        near: &[f32; 8],
        to_child: &mut [u32; 8],
        to_near: &mut [f32; 8],
    ) -> usize;

    /// Prefetches four cache lines at any address.
    fn prefetch(self, from: *const u8);
}

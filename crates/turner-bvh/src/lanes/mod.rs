//! Eight f64 lanes, with the same bits on every machine.
//!
//! Code that is generic over [`Simd`] is compiled once per instruction set; [`dispatch`] runs the version for a given
//! set. Every operation is the IEEE 754 operation on each of the eight lanes, without fusing or approximation. So a
//! lane has the result of scalar code, and all versions agree to the last bit.
//!
//! ```
//! use turner_bvh::InstructionSet;
//! use turner_bvh::lanes::{Block, F64x8, Simd, Work, dispatch};
//!
//! struct Halve<'a>(&'a mut Block);
//!
//! impl Work for Halve<'_> {
//!     type Output = ();
//!     #[inline(always)]
//!     fn run<S: Simd>(self, simd: S) {
//!         (F64x8::load(simd, self.0) * F64x8::splat(simd, 0.5)).store(self.0);
//!     }
//! }
//!
//! let mut block = Block([3.0; 8]);
//! dispatch(InstructionSet::best(), Halve(&mut block));
//! assert_eq!(block.0, [1.5; 8]);
//! ```

mod portable;
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
mod simd128;
mod vectors;
#[cfg(target_arch = "x86_64")]
mod x86;

use crate::InstructionSet;
use crate::simd::Kind;

pub use portable::Portable;
pub use vectors::{F32x8, F64x8, Mask8, Vec3x8};

/// Numbers in a block.
pub const LANES: usize = 8;

/// Eight f64, aligned to a cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(64))]
pub struct Block(pub [f64; LANES]);

/// Eight f32.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub struct Block32(pub [f32; LANES]);

/// An instruction set. A value of the type proves that the machine supports it.
///
/// # Safety
///
/// Values exist only where the functions may be called. Each function applies the IEEE 754 operation of its name to
/// every lane, rounding to nearest. Comparisons with NaN are false.
#[allow(missing_docs, clippy::missing_safety_doc)]
pub unsafe trait Simd: Copy + Send + Sync + 'static {
    /// Eight f64.
    type F: Copy;
    /// Eight f32.
    type H: Copy;
    /// Eight truth values.
    type M: Copy;

    unsafe fn splat(v: f64) -> Self::F;
    unsafe fn load(v: &Block) -> Self::F;
    unsafe fn store(v: Self::F, to: &mut Block);
    unsafe fn add(a: Self::F, b: Self::F) -> Self::F;
    unsafe fn sub(a: Self::F, b: Self::F) -> Self::F;
    unsafe fn mul(a: Self::F, b: Self::F) -> Self::F;
    unsafe fn div(a: Self::F, b: Self::F) -> Self::F;
    unsafe fn sqrt(a: Self::F) -> Self::F;
    /// Bitwise `a & b`.
    unsafe fn bits_and(a: Self::F, b: Self::F) -> Self::F;
    unsafe fn bits_or(a: Self::F, b: Self::F) -> Self::F;
    unsafe fn bits_xor(a: Self::F, b: Self::F) -> Self::F;
    /// The bits moved up by 52 places: the lowest twelve become sign and exponent.
    unsafe fn shl52(a: Self::F) -> Self::F;
    /// The bits moved down by 52 places: sign and exponent become the lowest twelve, the others 0.
    unsafe fn shr52(a: Self::F) -> Self::F;
    unsafe fn lt(a: Self::F, b: Self::F) -> Self::M;
    unsafe fn le(a: Self::F, b: Self::F) -> Self::M;
    unsafe fn eq(a: Self::F, b: Self::F) -> Self::M;
    /// Whether any bit is set in both, taken as integers.
    unsafe fn test(a: Self::F, b: Self::F) -> Self::M;
    /// `a` where the mask is set, `b` elsewhere.
    unsafe fn select(m: Self::M, a: Self::F, b: Self::F) -> Self::F;

    unsafe fn mask(bits: u8) -> Self::M;
    unsafe fn bits(m: Self::M) -> u8;
    unsafe fn and(a: Self::M, b: Self::M) -> Self::M;
    unsafe fn or(a: Self::M, b: Self::M) -> Self::M;
    /// `a & !b`.
    unsafe fn and_not(a: Self::M, b: Self::M) -> Self::M;

    unsafe fn splat32(v: f32) -> Self::H;
    unsafe fn load32(v: &Block32) -> Self::H;
    unsafe fn store32(v: Self::H, to: &mut Block32);
    unsafe fn add32(a: Self::H, b: Self::H) -> Self::H;
    unsafe fn sub32(a: Self::H, b: Self::H) -> Self::H;
    unsafe fn mul32(a: Self::H, b: Self::H) -> Self::H;
    unsafe fn div32(a: Self::H, b: Self::H) -> Self::H;
    unsafe fn sqrt32(a: Self::H) -> Self::H;
    /// `a` if it is larger, else `b`.
    unsafe fn max32(a: Self::H, b: Self::H) -> Self::H;
    /// `a` if it is smaller, else `b`.
    unsafe fn min32(a: Self::H, b: Self::H) -> Self::H;
    unsafe fn lt32(a: Self::H, b: Self::H) -> Self::M;
    unsafe fn eq32(a: Self::H, b: Self::H) -> Self::M;
    unsafe fn select32(m: Self::M, a: Self::H, b: Self::H) -> Self::H;
    /// Rounds to single precision.
    unsafe fn narrow(a: Self::F) -> Self::H;
    /// Converts to double precision, exactly.
    unsafe fn widen(a: Self::H) -> Self::F;
}

/// Work that is compiled for each instruction set.
pub trait Work {
    /// The result.
    type Output;
    /// Does the work. This method and everything it calls with lanes as arguments must be `#[inline(always)]`:
    /// otherwise the compiler does not use the instructions of `S`.
    fn run<S: Simd>(self, simd: S) -> Self::Output;
}

/// Runs the work with an instruction set.
#[inline]
pub fn dispatch<W: Work>(set: InstructionSet, work: W) -> W::Output {
    match set.kind() {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: an `InstructionSet` exists only for sets that this machine supports.
        Kind::Avx512 => unsafe { x86::Avx512::new() }.run(work),
        #[cfg(target_arch = "x86_64")]
        // SAFETY: as above.
        Kind::Avx2 => unsafe { x86::Avx2::new() }.run(work),
        #[cfg(target_arch = "aarch64")]
        // NEON is the baseline on aarch64: the compiler uses it for the portable code.
        Kind::Neon => work.run(Portable),
        #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
        // A second copy of the portable code would make a page's download larger.
        Kind::Simd128 | Kind::Scalar => work.run(simd128::Simd128),
        #[cfg(not(all(target_arch = "wasm32", target_feature = "simd128")))]
        Kind::Scalar => work.run(Portable),
    }
}

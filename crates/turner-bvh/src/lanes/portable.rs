//! Arrays of eight, for machines without SIMD registers of that width.

use super::{Block, Block32, LANES, Simd};

/// The baseline that every machine supports.
#[derive(Clone, Copy, Debug)]
pub struct Portable;

#[inline(always)]
fn each<T: Copy, U: Copy, V>(a: [T; LANES], b: [U; LANES], f: impl Fn(T, U) -> V) -> [V; LANES] {
    std::array::from_fn(|i| f(a[i], b[i]))
}

#[inline(always)]
fn all_ones(set: bool) -> u64 {
    0u64.wrapping_sub(u64::from(set))
}

// SAFETY: needs no special instructions.
unsafe impl Simd for Portable {
    type F = [f64; LANES];
    type H = [f32; LANES];
    /// A lane has all bits set or none.
    type M = [u64; LANES];

    #[inline(always)]
    unsafe fn splat(v: f64) -> Self::F {
        [v; LANES]
    }
    #[inline(always)]
    unsafe fn load(v: &Block) -> Self::F {
        v.0
    }
    #[inline(always)]
    unsafe fn store(v: Self::F, to: &mut Block) {
        to.0 = v;
    }
    #[inline(always)]
    unsafe fn add(a: Self::F, b: Self::F) -> Self::F {
        each(a, b, |a, b| a + b)
    }
    #[inline(always)]
    unsafe fn sub(a: Self::F, b: Self::F) -> Self::F {
        each(a, b, |a, b| a - b)
    }
    #[inline(always)]
    unsafe fn mul(a: Self::F, b: Self::F) -> Self::F {
        each(a, b, |a, b| a * b)
    }
    #[inline(always)]
    unsafe fn div(a: Self::F, b: Self::F) -> Self::F {
        each(a, b, |a, b| a / b)
    }
    #[inline(always)]
    unsafe fn sqrt(a: Self::F) -> Self::F {
        a.map(f64::sqrt)
    }
    #[inline(always)]
    unsafe fn bits_and(a: Self::F, b: Self::F) -> Self::F {
        each(a, b, |a, b| f64::from_bits(a.to_bits() & b.to_bits()))
    }
    #[inline(always)]
    unsafe fn bits_or(a: Self::F, b: Self::F) -> Self::F {
        each(a, b, |a, b| f64::from_bits(a.to_bits() | b.to_bits()))
    }
    #[inline(always)]
    unsafe fn bits_xor(a: Self::F, b: Self::F) -> Self::F {
        each(a, b, |a, b| f64::from_bits(a.to_bits() ^ b.to_bits()))
    }
    #[inline(always)]
    unsafe fn shl52(a: Self::F) -> Self::F {
        a.map(|v| f64::from_bits(v.to_bits() << 52))
    }
    #[inline(always)]
    unsafe fn shr52(a: Self::F) -> Self::F {
        a.map(|v| f64::from_bits(v.to_bits() >> 52))
    }
    #[inline(always)]
    unsafe fn lt(a: Self::F, b: Self::F) -> Self::M {
        each(a, b, |a, b| all_ones(a < b))
    }
    #[inline(always)]
    unsafe fn le(a: Self::F, b: Self::F) -> Self::M {
        each(a, b, |a, b| all_ones(a <= b))
    }
    #[inline(always)]
    unsafe fn eq(a: Self::F, b: Self::F) -> Self::M {
        each(a, b, |a, b| all_ones(a == b))
    }
    #[inline(always)]
    unsafe fn test(a: Self::F, b: Self::F) -> Self::M {
        each(a, b, |a, b| all_ones(a.to_bits() & b.to_bits() != 0))
    }
    #[inline(always)]
    unsafe fn select(m: Self::M, a: Self::F, b: Self::F) -> Self::F {
        std::array::from_fn(|i| f64::from_bits((a[i].to_bits() & m[i]) | (b[i].to_bits() & !m[i])))
    }

    #[inline(always)]
    unsafe fn mask(bits: u8) -> Self::M {
        std::array::from_fn(|i| all_ones(bits >> i & 1 == 1))
    }
    #[inline(always)]
    unsafe fn bits(m: Self::M) -> u8 {
        (0..LANES).fold(0, |bits, i| bits | ((m[i] & 1) as u8) << i)
    }
    #[inline(always)]
    unsafe fn and(a: Self::M, b: Self::M) -> Self::M {
        each(a, b, |a, b| a & b)
    }
    #[inline(always)]
    unsafe fn or(a: Self::M, b: Self::M) -> Self::M {
        each(a, b, |a, b| a | b)
    }
    #[inline(always)]
    unsafe fn and_not(a: Self::M, b: Self::M) -> Self::M {
        each(a, b, |a, b| a & !b)
    }

    #[inline(always)]
    unsafe fn splat32(v: f32) -> Self::H {
        [v; LANES]
    }
    #[inline(always)]
    unsafe fn load32(v: &Block32) -> Self::H {
        v.0
    }
    #[inline(always)]
    unsafe fn store32(v: Self::H, to: &mut Block32) {
        to.0 = v;
    }
    #[inline(always)]
    unsafe fn add32(a: Self::H, b: Self::H) -> Self::H {
        each(a, b, |a, b| a + b)
    }
    #[inline(always)]
    unsafe fn sub32(a: Self::H, b: Self::H) -> Self::H {
        each(a, b, |a, b| a - b)
    }
    #[inline(always)]
    unsafe fn mul32(a: Self::H, b: Self::H) -> Self::H {
        each(a, b, |a, b| a * b)
    }
    #[inline(always)]
    unsafe fn div32(a: Self::H, b: Self::H) -> Self::H {
        each(a, b, |a, b| a / b)
    }
    #[inline(always)]
    unsafe fn sqrt32(a: Self::H) -> Self::H {
        a.map(f32::sqrt)
    }
    #[inline(always)]
    unsafe fn max32(a: Self::H, b: Self::H) -> Self::H {
        each(a, b, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    unsafe fn min32(a: Self::H, b: Self::H) -> Self::H {
        each(a, b, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    unsafe fn lt32(a: Self::H, b: Self::H) -> Self::M {
        each(a, b, |a, b| all_ones(a < b))
    }
    #[inline(always)]
    unsafe fn eq32(a: Self::H, b: Self::H) -> Self::M {
        each(a, b, |a, b| all_ones(a == b))
    }
    #[inline(always)]
    unsafe fn select32(m: Self::M, a: Self::H, b: Self::H) -> Self::H {
        std::array::from_fn(|i| if m[i] != 0 { a[i] } else { b[i] })
    }
    #[inline(always)]
    unsafe fn narrow(a: Self::F) -> Self::H {
        a.map(|v| v as f32)
    }
    #[inline(always)]
    unsafe fn widen(a: Self::H) -> Self::F {
        a.map(f64::from)
    }
}

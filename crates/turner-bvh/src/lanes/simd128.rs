//! Eight f64 lanes with the 128-bit SIMD of WebAssembly: four registers.
//!
//! SAFETY, for every block in this file: loads and stores stay within their blocks.

use std::arch::wasm32::*;

use super::{Block, Block32, Simd};

/// 128-bit SIMD, in modules that are compiled with it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Simd128;

/// Four registers: eight f64, or eight masks of 64 bits.
type Four = [v128; 4];
/// Two registers: eight f32.
type Two = [v128; 2];

/// Functions of the trait: one of the four registers' after the other.
macro_rules! each {
    ($($name:ident $op:ident)*) => { $(
        #[inline(always)]
        unsafe fn $name(a: Four, b: Four) -> Four {
            std::array::from_fn(|i| $op(a[i], b[i]))
        }
    )* };
}

/// Loads the register `i` of a block.
#[inline(always)]
fn register<T>(from: &[T; 8], i: usize) -> v128 {
    let each = 16 / size_of::<T>();
    assert!((i + 1) * each <= 8);
    // SAFETY: within the block, as asserted.
    unsafe { v128_load(from.as_ptr().add(i * each).cast()) }
}

/// Stores the register `i` of a block.
#[inline(always)]
fn set_register<T>(to: &mut [T; 8], i: usize, v: v128) {
    let each = 16 / size_of::<T>();
    assert!((i + 1) * each <= 8);
    // SAFETY: within the block, as asserted.
    unsafe { v128_store(to.as_mut_ptr().add(i * each).cast(), v) }
}

/// Converts a mask of eight floats to a mask of eight doubles.
#[inline(always)]
fn wide_mask([low, high]: Two) -> Four {
    [
        i64x2_extend_low_i32x4(low),
        i64x2_extend_high_i32x4(low),
        i64x2_extend_low_i32x4(high),
        i64x2_extend_high_i32x4(high),
    ]
}

// SAFETY: the module is compiled with these instructions; lanes are independent IEEE 754 operations.
unsafe impl Simd for Simd128 {
    type F = Four;
    type H = Two;
    /// A lane has all bits set or none.
    type M = Four;

    each! {
        add f64x2_add
        sub f64x2_sub
        mul f64x2_mul
        div f64x2_div
        bits_and v128_and
        bits_or v128_or
        bits_xor v128_xor
        lt f64x2_lt
        le f64x2_le
        eq f64x2_eq
        and v128_and
        or v128_or
        and_not v128_andnot
    }

    #[inline(always)]
    unsafe fn splat(v: f64) -> Four {
        [f64x2_splat(v); 4]
    }
    #[inline(always)]
    unsafe fn load(v: &Block) -> Four {
        std::array::from_fn(|i| register(&v.0, i))
    }
    #[inline(always)]
    unsafe fn store(v: Four, to: &mut Block) {
        (0..4).for_each(|i| set_register(&mut to.0, i, v[i]));
    }
    #[inline(always)]
    unsafe fn sqrt(a: Four) -> Four {
        a.map(|v| f64x2_sqrt(v))
    }
    #[inline(always)]
    unsafe fn shl52(a: Four) -> Four {
        a.map(|v| i64x2_shl(v, 52))
    }
    #[inline(always)]
    unsafe fn shr52(a: Four) -> Four {
        a.map(|v| u64x2_shr(v, 52))
    }
    #[inline(always)]
    unsafe fn test(a: Four, b: Four) -> Four {
        std::array::from_fn(|i| i64x2_ne(v128_and(a[i], b[i]), i64x2_splat(0)))
    }
    #[inline(always)]
    unsafe fn select(m: Four, a: Four, b: Four) -> Four {
        std::array::from_fn(|i| v128_bitselect(a[i], b[i], m[i]))
    }

    #[inline(always)]
    unsafe fn mask(bits: u8) -> Four {
        let all = i64x2_splat(i64::from(bits));
        [i64x2(1, 2), i64x2(4, 8), i64x2(16, 32), i64x2(64, 128)].map(|own| i64x2_eq(v128_and(all, own), own))
    }
    #[inline(always)]
    unsafe fn bits(m: Four) -> u8 {
        let [a, b, c, d] = m.map(|v| i64x2_bitmask(v));
        a | b << 2 | c << 4 | d << 6
    }

    #[inline(always)]
    unsafe fn splat32(v: f32) -> Two {
        [f32x4_splat(v); 2]
    }
    #[inline(always)]
    unsafe fn load32(v: &Block32) -> Two {
        [register(&v.0, 0), register(&v.0, 1)]
    }
    #[inline(always)]
    unsafe fn store32(v: Two, to: &mut Block32) {
        (0..2).for_each(|i| set_register(&mut to.0, i, v[i]));
    }
    #[inline(always)]
    unsafe fn add32(a: Two, b: Two) -> Two {
        [f32x4_add(a[0], b[0]), f32x4_add(a[1], b[1])]
    }
    #[inline(always)]
    unsafe fn sub32(a: Two, b: Two) -> Two {
        [f32x4_sub(a[0], b[0]), f32x4_sub(a[1], b[1])]
    }
    #[inline(always)]
    unsafe fn mul32(a: Two, b: Two) -> Two {
        [f32x4_mul(a[0], b[0]), f32x4_mul(a[1], b[1])]
    }
    #[inline(always)]
    unsafe fn div32(a: Two, b: Two) -> Two {
        [f32x4_div(a[0], b[0]), f32x4_div(a[1], b[1])]
    }
    #[inline(always)]
    unsafe fn sqrt32(a: Two) -> Two {
        a.map(|v| f32x4_sqrt(v))
    }
    // The instructions return their first operand unless the second is larger, or smaller.
    #[inline(always)]
    unsafe fn max32(a: Two, b: Two) -> Two {
        [f32x4_pmax(b[0], a[0]), f32x4_pmax(b[1], a[1])]
    }
    #[inline(always)]
    unsafe fn min32(a: Two, b: Two) -> Two {
        [f32x4_pmin(b[0], a[0]), f32x4_pmin(b[1], a[1])]
    }
    #[inline(always)]
    unsafe fn lt32(a: Two, b: Two) -> Four {
        wide_mask([f32x4_lt(a[0], b[0]), f32x4_lt(a[1], b[1])])
    }
    #[inline(always)]
    unsafe fn eq32(a: Two, b: Two) -> Four {
        wide_mask([f32x4_eq(a[0], b[0]), f32x4_eq(a[1], b[1])])
    }
    #[inline(always)]
    unsafe fn select32(m: Four, a: Two, b: Two) -> Two {
        let [low, high] = [i32x4_shuffle::<0, 2, 4, 6>(m[0], m[1]), i32x4_shuffle::<0, 2, 4, 6>(m[2], m[3])];
        [v128_bitselect(a[0], b[0], low), v128_bitselect(a[1], b[1], high)]
    }
    #[inline(always)]
    unsafe fn narrow(a: Four) -> Two {
        let [a, b, c, d] = a.map(|v| f32x4_demote_f64x2_zero(v));
        [i64x2_shuffle::<0, 2>(a, b), i64x2_shuffle::<0, 2>(c, d)]
    }
    #[inline(always)]
    unsafe fn widen(a: Two) -> Four {
        let high = |v| f64x2_promote_low_f32x4(i64x2_shuffle::<1, 1>(v, v));
        [f64x2_promote_low_f32x4(a[0]), high(a[0]), f64x2_promote_low_f32x4(a[1]), high(a[1])]
    }
}

//! The 128-bit SIMD of WebAssembly, in modules that are compiled with it.
//!
//! SAFETY, for every block in this file: loads and stores stay within the arrays that they are given.

use std::arch::wasm32::*;

use super::{Lanes, Portable, Simd};

/// 128-bit SIMD.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Simd128(());

impl Simd128 {
    #[inline(always)]
    pub(super) fn new() -> Simd128 {
        Simd128(())
    }
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct N4(v128);

/// Eight numbers in two registers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct N8(N4, N4);

/// A comparison as bits: lane i is bit i.
#[inline(always)]
fn bits(compared: v128) -> u32 {
    u32::from(i32x4_bitmask(compared))
}

macro_rules! two {
    ($name:ident, $op:ident) => {
        #[inline(always)]
        fn $name(self, other: Self) -> Self {
            N4($op(self.0, other.0))
        }
    };
}

impl Lanes for N4 {
    two!(add, f32x4_add);
    two!(sub, f32x4_sub);
    two!(mul, f32x4_mul);
    two!(div, f32x4_div);

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // `self` where it is less, otherwise `other`, also for NaN.
        N4(f32x4_pmin(other.0, self.0))
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        N4(f32x4_pmax(other.0, self.0))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        N4(f32x4_abs(self.0))
    }

    #[inline(always)]
    fn with_sign(self, other: Self) -> Self {
        N4(v128_bitselect(other.0, self.0, i32x4_splat(i32::MIN)))
    }

    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        // There is no fused one whose result is the same on every machine.
        N4(f32x4_add(f32x4_mul(self.0, a.0), b.0))
    }

    #[inline(always)]
    fn near_inverse(self) -> Self {
        N4(f32x4_div(f32x4_splat(1.0), self.0))
    }

    #[inline(always)]
    fn le(self, other: Self) -> u32 {
        bits(f32x4_le(self.0, other.0))
    }

    #[inline(always)]
    fn lt(self, other: Self) -> u32 {
        bits(f32x4_lt(self.0, other.0))
    }

    #[inline(always)]
    fn range(self) -> [f32; 2] {
        let mut lanes = [0.0; 4];
        self.store(&mut lanes);
        lanes.range()
    }

    #[inline(always)]
    fn choose(self, mask: u32, other: Self) -> Self {
        let set = v128_and(u32x4_splat(mask), u32x4(1, 2, 4, 8));
        N4(v128_bitselect(other.0, self.0, i32x4_eq(set, i32x4_splat(0))))
    }

    #[inline(always)]
    fn store(self, to: &mut [f32]) {
        assert!(to.len() >= 4);
        // SAFETY: there is room for four.
        unsafe { v128_store(to.as_mut_ptr().cast(), self.0) }
    }
}

macro_rules! halves {
    ($($name:ident)*) => {$(
        #[inline(always)]
        fn $name(self, other: Self) -> Self {
            N8(self.0.$name(other.0), self.1.$name(other.1))
        }
    )*};
}

impl Lanes for N8 {
    halves!(add sub mul div min max with_sign);

    #[inline(always)]
    fn abs(self) -> Self {
        N8(self.0.abs(), self.1.abs())
    }

    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        N8(self.0.mul_add(a.0, b.0), self.1.mul_add(a.1, b.1))
    }

    #[inline(always)]
    fn near_inverse(self) -> Self {
        N8(self.0.near_inverse(), self.1.near_inverse())
    }

    #[inline(always)]
    fn le(self, other: Self) -> u32 {
        self.0.le(other.0) | self.1.le(other.1) << 4
    }

    #[inline(always)]
    fn lt(self, other: Self) -> u32 {
        self.0.lt(other.0) | self.1.lt(other.1) << 4
    }

    #[inline(always)]
    fn range(self) -> [f32; 2] {
        [self.0.min(self.1).range()[0], self.0.max(self.1).range()[1]]
    }

    #[inline(always)]
    fn choose(self, mask: u32, other: Self) -> Self {
        N8(self.0.choose(mask, other.0), self.1.choose(mask >> 4, other.1))
    }

    #[inline(always)]
    fn store(self, to: &mut [f32]) {
        let (low, high) = to.split_at_mut(4);
        self.0.store(low);
        self.1.store(high);
    }
}

impl Simd for Simd128 {
    type F4 = N4;
    type F8 = N8;
    type Packet = N8;
    const PACKET: usize = 8;

    #[inline(always)]
    fn splat4(self, x: f32) -> N4 {
        N4(f32x4_splat(x))
    }

    #[inline(always)]
    fn load4(self, from: &[f32; 4]) -> N4 {
        // SAFETY: four are read.
        N4(unsafe { v128_load(from.as_ptr().cast()) })
    }

    #[inline(always)]
    fn splat8(self, x: f32) -> N8 {
        N8(self.splat4(x), self.splat4(x))
    }

    #[inline(always)]
    fn load8(self, from: &[f32; 8]) -> N8 {
        // SAFETY: eight are read.
        unsafe { N8(N4(v128_load(from.as_ptr().cast())), N4(v128_load(from.as_ptr().add(4).cast()))) }
    }

    #[inline(always)]
    fn transpose8(self, rows: [N8; 8]) -> [N8; 8] {
        let rows = rows.map(|row| {
            let mut lanes = [0.0; 8];
            row.store(&mut lanes);
            lanes
        });
        Portable.transpose8(rows).map(|row| self.load8(&row))
    }

    #[inline(always)]
    fn splat_packet(self, x: f32) -> N8 {
        self.splat8(x)
    }

    #[inline(always)]
    fn load_packet(self, from: &[f32; 16]) -> N8 {
        // SAFETY: eight of the sixteen are read.
        unsafe { N8(N4(v128_load(from.as_ptr().cast())), N4(v128_load(from.as_ptr().add(4).cast()))) }
    }

    #[inline(always)]
    fn push_ordered(
        self,
        near: N8,
        far: N8,
        children: &[u32; 8],
        order: u32,
        stack: (&mut [u32; 8], &mut [f32; 8]),
    ) -> usize {
        let [mut near_lanes, mut far_lanes] = [[0.0; 8]; 2];
        near.store(&mut near_lanes);
        far.store(&mut far_lanes);
        Portable.push_ordered(near_lanes, far_lanes, children, order, stack)
    }

    #[inline(always)]
    fn push_any(self, hit: u32, children: &[u32; 8], stack: &mut [u32; 8]) -> usize {
        Portable.push_any(hit, children, stack)
    }

    #[inline(always)]
    fn push_kept(
        self,
        mut kept: u32,
        children: &[u32; 8],
        near: &[f32; 8],
        to_child: &mut [u32; 8],
        to_near: &mut [f32; 8],
    ) -> usize {
        let mut count = 0;
        while kept != 0 {
            let lane = kept.trailing_zeros() as usize & 7;
            to_child[count & 7] = children[lane];
            to_near[count & 7] = near[lane];
            kept &= kept - 1;
            count += 1;
        }
        count
    }

    #[inline(always)]
    fn prefetch(self, _from: *const u8) {}
}

//! NEON on 64-bit Arm, where it is part of the baseline.
//!
//! SAFETY, for every block in this file: the instructions are part of every aarch64 target.

use std::arch::aarch64::*;

use super::{Lanes, Portable, Simd};

/// NEON.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Neon(());

impl Neon {
    #[inline(always)]
    pub(super) fn new() -> Neon {
        Neon(())
    }
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct N4(float32x4_t);

/// Eight numbers in two registers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct N8(N4, N4);

/// A comparison as bits: lane i is bit i.
#[inline(always)]
fn bits(compared: uint32x4_t) -> u32 {
    const WEIGHTS: [u32; 4] = [1, 2, 4, 8];
    // SAFETY: see the head of the file.
    unsafe { vaddvq_u32(vandq_u32(compared, vld1q_u32(WEIGHTS.as_ptr()))) }
}

macro_rules! two {
    ($name:ident, $op:ident) => {
        #[inline(always)]
        fn $name(self, other: Self) -> Self {
            // SAFETY: see the head of the file.
            N4(unsafe { $op(self.0, other.0) })
        }
    };
}

impl Lanes for N4 {
    two!(add, vaddq_f32);
    two!(sub, vsubq_f32);
    two!(mul, vmulq_f32);
    two!(div, vdivq_f32);

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // By comparison: the minimum instruction returns NaN where other machines return `other`.
        // SAFETY: see the head of the file.
        N4(unsafe { vbslq_f32(vcltq_f32(self.0, other.0), self.0, other.0) })
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: see the head of the file.
        N4(unsafe { vbslq_f32(vcgtq_f32(self.0, other.0), self.0, other.0) })
    }

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: see the head of the file.
        N4(unsafe { vabsq_f32(self.0) })
    }

    #[inline(always)]
    fn with_sign(self, other: Self) -> Self {
        // SAFETY: see the head of the file.
        N4(unsafe { vbslq_f32(vdupq_n_u32(1 << 31), other.0, self.0) })
    }

    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        // SAFETY: see the head of the file.
        N4(unsafe { vfmaq_f32(b.0, self.0, a.0) })
    }

    #[inline(always)]
    fn near_inverse(self) -> Self {
        // SAFETY: see the head of the file.
        N4(unsafe { vdivq_f32(vdupq_n_f32(1.0), self.0) })
    }

    #[inline(always)]
    fn le(self, other: Self) -> u32 {
        // SAFETY: see the head of the file.
        bits(unsafe { vcleq_f32(self.0, other.0) })
    }

    #[inline(always)]
    fn lt(self, other: Self) -> u32 {
        // SAFETY: see the head of the file.
        bits(unsafe { vcltq_f32(self.0, other.0) })
    }

    #[inline(always)]
    fn range(self) -> [f32; 2] {
        // SAFETY: see the head of the file.
        unsafe { [vminvq_f32(self.0), vmaxvq_f32(self.0)] }
    }

    #[inline(always)]
    fn choose(self, mask: u32, other: Self) -> Self {
        const BITS: [u32; 4] = [1, 2, 4, 8];
        // SAFETY: see the head of the file.
        N4(unsafe { vbslq_f32(vtstq_u32(vdupq_n_u32(mask), vld1q_u32(BITS.as_ptr())), self.0, other.0) })
    }

    #[inline(always)]
    fn store(self, to: &mut [f32]) {
        assert!(to.len() >= 4);
        // SAFETY: see the head of the file; there is room for four.
        unsafe { vst1q_f32(to.as_mut_ptr(), self.0) }
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

impl Simd for Neon {
    type F4 = N4;
    type F8 = N8;
    type Packet = N8;
    const PACKET: usize = 8;

    #[inline(always)]
    fn splat4(self, x: f32) -> N4 {
        // SAFETY: see the head of the file.
        N4(unsafe { vdupq_n_f32(x) })
    }

    #[inline(always)]
    fn load4(self, from: &[f32; 4]) -> N4 {
        // SAFETY: see the head of the file; four are read.
        N4(unsafe { vld1q_f32(from.as_ptr()) })
    }

    #[inline(always)]
    fn splat8(self, x: f32) -> N8 {
        N8(self.splat4(x), self.splat4(x))
    }

    #[inline(always)]
    fn load8(self, from: &[f32; 8]) -> N8 {
        // SAFETY: see the head of the file; eight are read.
        unsafe { N8(N4(vld1q_f32(from.as_ptr())), N4(vld1q_f32(from.as_ptr().add(4)))) }
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
        // SAFETY: see the head of the file; eight of the sixteen are read.
        unsafe { N8(N4(vld1q_f32(from.as_ptr())), N4(vld1q_f32(from.as_ptr().add(4)))) }
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

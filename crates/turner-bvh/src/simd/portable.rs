//! Vectors as arrays: runs on any machine, and is the reference for the other sets.

use super::{Lanes, Simd};

/// Baseline instructions of the target.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Portable;

macro_rules! each {
    ($a:expr, $b:expr, $op:expr) => {
        std::array::from_fn(|i| $op($a[i], $b[i]))
    };
}

impl<const N: usize> Lanes for [f32; N] {
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        each!(self, other, |a, b| a + b)
    }

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        each!(self, other, |a, b| a - b)
    }

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        each!(self, other, |a, b| a * b)
    }

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        each!(self, other, |a, b| a / b)
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        each!(self, other, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        each!(self, other, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.map(f32::abs)
    }

    #[inline(always)]
    fn with_sign(self, other: Self) -> Self {
        each!(self, other, f32::copysign)
    }

    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        std::array::from_fn(|i| self[i] * a[i] + b[i])
    }

    #[inline(always)]
    fn near_inverse(self) -> Self {
        self.map(|x| 1.0 / x)
    }

    #[inline(always)]
    fn le(self, other: Self) -> u32 {
        (0..N).fold(0, |mask, i| mask | u32::from(self[i] <= other[i]) << i)
    }

    #[inline(always)]
    fn lt(self, other: Self) -> u32 {
        (0..N).fold(0, |mask, i| mask | u32::from(self[i] < other[i]) << i)
    }

    #[inline(always)]
    fn range(self) -> [f32; 2] {
        let (mut low, mut high) = (self[0], self[0]);
        for x in self {
            low = if x < low { x } else { low };
            high = if x > high { x } else { high };
        }
        [low, high]
    }

    #[inline(always)]
    fn choose(self, mask: u32, other: Self) -> Self {
        std::array::from_fn(|i| if mask >> i & 1 != 0 { self[i] } else { other[i] })
    }

    #[inline(always)]
    fn store(self, to: &mut [f32]) {
        to[..N].copy_from_slice(&self);
    }
}

impl Simd for Portable {
    type F4 = [f32; 4];
    type F8 = [f32; 8];
    type Packet = [f32; 4];
    const PACKET: usize = 4;

    #[inline(always)]
    fn splat4(self, x: f32) -> [f32; 4] {
        [x; 4]
    }

    #[inline(always)]
    fn load4(self, from: &[f32; 4]) -> [f32; 4] {
        *from
    }

    #[inline(always)]
    fn splat8(self, x: f32) -> [f32; 8] {
        [x; 8]
    }

    #[inline(always)]
    fn load8(self, from: &[f32; 8]) -> [f32; 8] {
        *from
    }

    #[inline(always)]
    fn transpose8(self, rows: [[f32; 8]; 8]) -> [[f32; 8]; 8] {
        std::array::from_fn(|i| rows.map(|row| row[i]))
    }

    #[inline(always)]
    fn splat_packet(self, x: f32) -> [f32; 4] {
        [x; 4]
    }

    #[inline(always)]
    fn load_packet(self, from: &[f32; 16]) -> [f32; 4] {
        std::array::from_fn(|i| from[i])
    }

    #[inline(always)]
    fn push_ordered(
        self,
        near: [f32; 8],
        far: [f32; 8],
        children: &[u32; 8],
        order: u32,
        (to_child, to_near): (&mut [u32; 8], &mut [f32; 8]),
    ) -> usize {
        let mut count = 0;
        for i in 0..8 {
            let lane = (order >> (3 * i) & 7) as usize;
            if near[lane] <= far[lane] {
                to_child[count] = children[lane];
                to_near[count] = near[lane];
                count += 1;
            }
        }
        count
    }

    #[inline(always)]
    fn push_any(self, mut hit: u32, children: &[u32; 8], stack: &mut [u32; 8]) -> usize {
        let mut count = 0;
        while hit != 0 {
            stack[count & 7] = children[hit.trailing_zeros() as usize & 7];
            hit &= hit - 1;
            count += 1;
        }
        count
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

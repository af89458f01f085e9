//! Primitives, bounds and costs as the builders store them.

use super::lanes::F4;
use crate::Aabb;

/// A box as its lower corner and its negated upper corner, so that minima alone give a union. The fourth lanes are
/// unused here.
///
/// Zeros are positive in both corners: then minima do not depend on the order of the operands, to the last bit.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct Bounds {
    pub(super) lo: F4,
    pub(super) hi: F4,
}

impl Bounds {
    #[inline(always)]
    pub(super) fn empty() -> Bounds {
        Bounds { lo: F4::splat(f32::INFINITY), hi: F4::splat(f32::INFINITY) }
    }

    #[inline(always)]
    pub(super) fn from_corners(min: [f32; 3], max: [f32; 3]) -> Bounds {
        let zero = F4::splat(0.0);
        Bounds {
            lo: F4::new([min[0], min[1], min[2], 0.0]).add(zero),
            hi: F4::new([-max[0], -max[1], -max[2], 0.0]).add(zero),
        }
    }

    #[inline(always)]
    pub(super) fn union(self, other: Bounds) -> Bounds {
        Bounds { lo: self.lo.min(other.lo), hi: self.hi.min(other.hi) }
    }

    /// Half the surface area of the box, extended by `pad` on each axis so that flat boxes and points also have a cost.
    #[inline(always)]
    pub(super) fn area(self, pad: F4) -> f32 {
        let extent = pad.sub(self.lo.add(self.hi)).max(F4::splat(0.0));
        let [a, b, c, _] = extent.mul(extent.rotated()).array();
        a + b + c
    }

    pub(super) fn aabb(self) -> Aabb {
        let ([a, b, c, _], [d, e, f, _]) = (self.lo.array(), self.hi.array());
        Aabb { min: [a, b, c], max: [-d + 0.0, -e + 0.0, -f + 0.0] }
    }

    pub(super) fn longest_axis(self) -> usize {
        // The extents are negated, so the least is the longest.
        let [x, y, z, _] = self.lo.add(self.hi).array();
        if x <= y && x <= z { 0 } else { if y <= z { 1 } else { 2 } }
    }

    /// Twice the centre.
    #[inline(always)]
    pub(super) fn center(self) -> F4 {
        self.lo.sub(self.hi)
    }

    /// The box of a point.
    #[inline(always)]
    pub(super) fn point(p: F4) -> Bounds {
        Bounds { lo: p, hi: F4::splat(0.0).sub(p) }
    }
}

/// A primitive's box and ID, in half a cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct Prim {
    /// The fourth lane of the lower corner holds the bits of the ID.
    pub(super) bounds: Bounds,
}

const _: () = assert!(size_of::<Prim>() == 32);

impl Prim {
    #[inline(always)]
    pub(super) fn new(min: [f32; 3], max: [f32; 3], id: u32) -> Prim {
        let mut bounds = Bounds::from_corners(min, max);
        let [a, b, c, _] = bounds.lo.array();
        bounds.lo = F4::new([a, b, c, f32::from_bits(id)]);
        Prim { bounds }
    }

    /// The same primitive with other bounds, for a part of it.
    pub(super) fn with_bounds(&self, bounds: Bounds) -> Prim {
        let b = bounds.aabb();
        Prim::new(b.min, b.max, self.id())
    }

    #[inline(always)]
    pub(super) fn id(&self) -> u32 {
        self.bounds.lo.array()[3].to_bits()
    }
}

/// Primitives that become one subtree, their bounds and the bounds of their doubled centres.
#[derive(Debug)]
pub(super) struct Set<'a> {
    pub(super) prims: &'a mut [Prim],
    pub(super) bounds: Bounds,
    pub(super) centers: Bounds,
}

impl<'a> Set<'a> {
    /// Computes both bounds.
    pub(super) fn of(prims: &'a mut [Prim]) -> Set<'a> {
        let (mut bounds, mut centers) = (Bounds::empty(), Bounds::empty());
        for prim in &*prims {
            bounds = bounds.union(prim.bounds);
            centers = centers.union(Bounds::point(prim.bounds.center()));
        }
        Set { prims, bounds, centers }
    }

    pub(super) fn len(&self) -> usize {
        self.prims.len()
    }
}

/// The SAH cost of sets of primitives.
#[derive(Clone, Copy, Debug)]
pub(super) struct Costs {
    /// log2 of the primitives in a block.
    pub(super) block_shift: u32,
    /// Added to the extents of boxes before their areas are compared.
    pub(super) pad: F4,
}

impl Costs {
    pub(super) fn new(block_width: usize, root: Bounds) -> Costs {
        let b = root.aabb();
        let extent = (0..3).map(|i| b.max[i] - b.min[i]).fold(0.0, f32::max);
        // 2^-26 of the largest extent.
        let pad = (extent * 1.490_116_1e-8).max(1e-15);
        Costs { block_shift: block_width.trailing_zeros(), pad: F4::splat(pad) }
    }

    #[inline(always)]
    pub(super) fn blocks(&self, count: usize) -> usize {
        (count + (1 << self.block_shift) - 1) >> self.block_shift
    }

    #[inline(always)]
    pub(super) fn leaf(&self, bounds: Bounds, count: usize) -> f32 {
        bounds.area(self.pad) * self.blocks(count) as f32
    }
}

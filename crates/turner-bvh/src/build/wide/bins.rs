//! Binned SAH (Wald 2007, "On fast construction of SAH-based bounding volume hierarchies").
//!
//! The method is that of `build::binned_sah`: sort the centres into bins of equal width, then evaluate the SAH cost at
//! the planes between bins. Here the cost counts blocks instead of primitives, and four lanes hold x, y and z of
//! a box. Minima, maxima and counts do not depend on the order of the primitives, so neither does the split.

use super::lanes::F4;
use super::prims::{Bounds, Costs, Prim, Set};

pub(super) const MAX_BINS: usize = 32;

/// Sets of at least this size alternate between two sets of bins: neighbours often fall into the same bin, and the
/// second update would wait for the first.
const MIN_TWO_ACCUMULATORS: usize = 512;

/// Maps centres to bins on all axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    min: F4,
    scale: F4,
    last: F4,
    bins: usize,
    /// The axes `first_axis..end_axis` are binned: all three, or one.
    first_axis: usize,
    end_axis: usize,
}

impl Grid {
    /// With `one_axis`, bins only the axis on which the centres extend furthest.
    pub(super) fn new(centers: Bounds, bins: usize, one_axis: bool) -> Grid {
        let bins = bins.clamp(2, MAX_BINS);
        let ([a, b, c, _], extents) = (centers.lo.array(), F4::splat(0.0).sub(centers.lo.add(centers.hi)));
        let [x, y, z, _] = extents.array().map(|e| {
            // Slightly less than `bins`, so that the largest centre is in the last bin. An infinite scale would turn 0
            // into NaN.
            if e > 0.0 { (bins as f32 * 0.999_999 / e).min(f32::MAX) } else { 0.0 }
        });
        let longest = centers.longest_axis();
        Grid {
            first_axis: if one_axis { longest } else { 0 },
            end_axis: if one_axis { longest + 1 } else { 3 },
            min: F4::new([a, b, c, 0.0]),
            scale: F4::new([x, y, z, 0.0]),
            last: F4::splat((bins - 1) as f32),
            bins,
        }
    }

    /// The bin as a real number, not yet clamped.
    #[inline(always)]
    fn scaled(&self, center: F4) -> F4 {
        center.sub(self.min).mul(self.scale)
    }

    #[inline(always)]
    fn bins_of(&self, bounds: Bounds) -> [usize; 3] {
        let [x, y, z, _] = self.scaled(bounds.center()).max(F4::splat(0.0)).min(self.last).truncated();
        [x as usize, y as usize, z as usize]
    }
}

/// For each axis and bin, the union of the primitives' boxes and their count.
#[derive(Clone, Debug)]
pub(super) struct Bins {
    boxes: [[Bounds; MAX_BINS]; 3],
    counts: [[u32; MAX_BINS]; 3],
}

impl Bins {
    pub(super) fn new() -> Bins {
        Bins { boxes: [[Bounds::empty(); MAX_BINS]; 3], counts: [[0; MAX_BINS]; 3] }
    }

    fn clear(&mut self, grid: &Grid) {
        for axis in grid.first_axis..grid.end_axis {
            self.boxes[axis][..grid.bins].fill(Bounds::empty());
            self.counts[axis][..grid.bins].fill(0);
        }
    }

    pub(super) fn merge(&mut self, other: &Bins, grid: &Grid) {
        for axis in grid.first_axis..grid.end_axis {
            for bin in 0..grid.bins {
                let b = &mut self.boxes[axis][bin];
                *b = b.union(other.boxes[axis][bin]);
                self.counts[axis][bin] += other.counts[axis][bin];
            }
        }
    }

    #[inline(always)]
    fn add<const FIRST: usize, const END: usize>(
        &mut self,
        prim: &Prim,
        grid: &Grid,
        unite: impl Fn(&mut Bounds),
    ) {
        let bins = grid.bins_of(prim.bounds);
        for (axis, bin) in bins.into_iter().enumerate().take(END).skip(FIRST) {
            let bin = bin & (MAX_BINS - 1);
            unite(&mut self.boxes[axis][bin]);
            self.counts[axis][bin] += 1;
        }
    }
}

/// Bins to work in, allocated once per thread.
#[derive(Clone, Debug)]
pub(super) struct Scratch {
    bins: Box<[Bins; 2]>,
}

impl Scratch {
    pub(super) fn new() -> Scratch {
        Scratch { bins: Box::new([Bins::new(), Bins::new()]) }
    }

    /// The bins that the last [`fill`](Self::fill) filled.
    pub(super) fn first(&mut self) -> &mut Bins {
        &mut self.bins[0]
    }

    /// Sorts the primitives into bins.
    pub(super) fn fill(&mut self, prims: &[Prim], grid: &Grid) -> &mut Bins {
        match (grid.first_axis, grid.end_axis) {
            (0, 1) => self.fill_axes::<0, 1>(prims, grid),
            (1, 2) => self.fill_axes::<1, 2>(prims, grid),
            (2, 3) => self.fill_axes::<2, 3>(prims, grid),
            _ => self.fill_axes::<0, 3>(prims, grid),
        }
    }

    fn fill_axes<const FIRST: usize, const END: usize>(&mut self, prims: &[Prim], grid: &Grid) -> &mut Bins {
        #[cfg(target_arch = "x86_64")]
        if super::lanes::has_avx2() {
            // SAFETY: the processor has AVX2.
            unsafe { self.fill_avx2::<FIRST, END>(prims, grid) };
            return &mut self.bins[0];
        }
        self.fill_here::<FIRST, END>(prims, grid, |bounds, other| *bounds = bounds.union(other));
        &mut self.bins[0]
    }

    /// The same with 256-bit registers.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn fill_avx2<const FIRST: usize, const END: usize>(&mut self, prims: &[Prim], grid: &Grid) {
        use std::arch::x86_64::{_mm256_load_ps, _mm256_min_ps, _mm256_store_ps};
        const { assert!(align_of::<Bounds>() == 32 && size_of::<Bounds>() == 32) };
        self.fill_here::<FIRST, END>(prims, grid, |bounds, other| {
            let target = (&raw mut *bounds).cast::<f32>();
            // SAFETY: both pointers are to eight floats, aligned to 32 bytes.
            unsafe {
                let other = _mm256_load_ps((&raw const other).cast());
                _mm256_store_ps(target, _mm256_min_ps(other, _mm256_load_ps(target)));
            }
        });
    }

    #[inline(always)]
    fn fill_here<const FIRST: usize, const END: usize>(
        &mut self,
        prims: &[Prim],
        grid: &Grid,
        unite: impl Fn(&mut Bounds, Bounds),
    ) {
        let [first, second] = &mut *self.bins;
        first.clear(grid);
        if prims.len() < MIN_TWO_ACCUMULATORS {
            for prim in prims {
                first.add::<FIRST, END>(prim, grid, |bounds| unite(bounds, prim.bounds));
            }
        } else {
            second.clear(grid);
            let (pairs, rest) = prims.as_chunks::<2>();
            for [a, b] in pairs {
                first.add::<FIRST, END>(a, grid, |bounds| unite(bounds, a.bounds));
                second.add::<FIRST, END>(b, grid, |bounds| unite(bounds, b.bounds));
            }
            for prim in rest {
                first.add::<FIRST, END>(prim, grid, |bounds| unite(bounds, prim.bounds));
            }
            first.merge(second, grid);
        }
    }
}

/// Primitives in bins `0..=last_left` of `axis` go to the left child.
#[derive(Clone, Copy, Debug)]
pub(super) struct Split {
    pub(super) axis: usize,
    pub(super) last_left: usize,
    pub(super) cost: f32,
    pub(super) bounds: [Bounds; 2],
}

/// The cheapest split with primitives on both sides; `None` if all centres fall into one bin.
pub(super) fn best_split(bins: &Bins, grid: &Grid, count: usize, costs: &Costs) -> Option<Split> {
    let mut best: Option<(f32, usize, usize)> = None;
    let mut best_balance = usize::MAX;
    for axis in grid.first_axis..grid.end_axis {
        let (boxes, counts) = (&bins.boxes[axis], &bins.counts[axis]);
        let mut right_areas = [0.0; MAX_BINS];
        let mut right = Bounds::empty();
        for bin in (1..grid.bins).rev() {
            right = right.union(boxes[bin]);
            right_areas[bin] = right.area(costs.pad);
        }
        let mut left = Bounds::empty();
        let mut left_count = 0;
        for bin in 0..grid.bins - 1 {
            left = left.union(boxes[bin]);
            left_count += counts[bin] as usize;
            let right_count = count - left_count;
            if counts[bin] == 0 || right_count == 0 {
                continue;
            }
            let cost = left.area(costs.pad) * costs.blocks(left_count) as f32
                + right_areas[bin + 1] * costs.blocks(right_count) as f32;
            let balance = left_count.abs_diff(right_count);
            if best.is_none_or(|(least, ..)| cost < least || cost == least && balance < best_balance) {
                best = Some((cost, axis, bin));
                best_balance = balance;
            }
        }
    }
    let (cost, axis, last_left) = best?;
    let union_of = |boxes: &[Bounds]| boxes.iter().fold(Bounds::empty(), |a, b| a.union(*b));
    let (left, right) = bins.boxes[axis][..grid.bins].split_at(last_left + 1);
    Some(Split { axis, last_left, cost, bounds: [union_of(left), union_of(right)] })
}

/// Moves the left primitives to the front. Returns their count and the bounds of the centres on both sides.
pub(super) fn partition(prims: &mut [Prim], grid: &Grid, split: &Split) -> (usize, [Bounds; 2]) {
    match split.axis {
        0 => partition_on::<0>(prims, grid, split.last_left),
        1 => partition_on::<1>(prims, grid, split.last_left),
        _ => partition_on::<2>(prims, grid, split.last_left),
    }
}

fn partition_on<const AXIS: usize>(
    prims: &mut [Prim],
    grid: &Grid,
    last_left: usize,
) -> (usize, [Bounds; 2]) {
    #[cfg(target_arch = "x86_64")]
    if super::lanes::has_avx2() {
        // SAFETY: the processor has AVX2.
        return unsafe { partition_avx2::<AXIS>(prims, grid, last_left) };
    }
    partition_here::<AXIS>(prims, grid, last_left)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn partition_avx2<const AXIS: usize>(
    prims: &mut [Prim],
    grid: &Grid,
    last_left: usize,
) -> (usize, [Bounds; 2]) {
    partition_here::<AXIS>(prims, grid, last_left)
}

#[inline(always)]
fn partition_here<const AXIS: usize>(
    prims: &mut [Prim],
    grid: &Grid,
    last_left: usize,
) -> (usize, [Bounds; 2]) {
    let border = F4::splat((last_left + 1) as f32);
    let [mut left, mut right] = [Bounds::empty(); 2];
    let mut front = 0;
    for i in 0..prims.len() {
        // SAFETY: `front <= i < prims.len()`, because `front` grows by at most one per step.
        let (here, there) = unsafe { (*prims.get_unchecked(i), *prims.get_unchecked(front)) };
        let center = here.bounds.center();
        let goes_right = grid.scaled(center).at_least(border).array()[AXIS];
        // All bits set, a NaN, where the primitive is on the other side: the minimum ignores it.
        let mask = F4::splat(goes_right);
        let other = F4::splat(f32::from_bits(!goes_right.to_bits()));
        let point = Bounds::point(center);
        left.lo = point.lo.or(mask).min(left.lo);
        left.hi = point.hi.or(mask).min(left.hi);
        right.lo = point.lo.or(other).min(right.lo);
        right.hi = point.hi.or(other).min(right.hi);
        // SAFETY: as above.
        unsafe {
            *prims.get_unchecked_mut(i) = there;
            *prims.get_unchecked_mut(front) = here;
        }
        front += usize::from(goes_right.to_bits() == 0);
    }
    (front, [left, right])
}

/// Splits at the median: by centre on the axis where the centres extend furthest, then by ID.
pub(super) fn halve<'a>(set: Set<'a>) -> [Set<'a>; 2] {
    let extents = F4::splat(0.0).sub(set.centers.lo.add(set.centers.hi)).array();
    let axis = (1..3).fold(0, |widest, i| if extents[i] > extents[widest] { i } else { widest });
    let middle = set.prims.len() / 2;
    let key = |prim: &Prim| prim.bounds.center().array()[axis];
    set.prims
        .select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)).then_with(|| a.id().cmp(&b.id())));
    let (left, right) = set.prims.split_at_mut(middle);
    [Set::of(left), Set::of(right)]
}

//! Full SAH sweep for small sets: evaluates every split of the sorted order on each axis instead of bins.
//!
//! The set is sorted once per axis. Each split partitions the other two orders stably, so no set is sorted again
//! (Wald and Havran 2006 do the same for kd-trees).

use super::binary::BinaryTree;
use super::prims::{Bounds, Costs, Prim};

/// The largest set that is swept.
pub(super) const MAX_SWEEP: usize = 32;

/// The lowest bits of a sort key are replaced by the primitive's rank by ID, so keys never tie.
const INDEX_MASK: i32 = MAX_SWEEP as i32 - 1;

/// Ranks by ID of the primitives, sorted along each axis.
type Orders = [[u8; MAX_SWEEP]; 3];

/// The set and its sorted orders.
#[derive(Debug)]
pub(super) struct Sweep {
    /// Bounds, sorted by ID.
    prims: [Bounds; MAX_SWEEP],
    ids: [u32; MAX_SWEEP],
    orders: Orders,
    /// Consider splits on the longest axis only.
    one_axis: bool,
}

impl Sweep {
    pub(super) fn new(one_axis: bool) -> Sweep {
        Sweep {
            prims: [Bounds::empty(); MAX_SWEEP],
            ids: [0; MAX_SWEEP],
            orders: [[0; MAX_SWEEP]; 3],
            one_axis,
        }
    }

    /// Appends the tree of 1 to `MAX_SWEEP` primitives.
    pub(super) fn subtree(&mut self, prims: &[Prim], costs: &Costs, tree: &mut BinaryTree) {
        let n = prims.len();
        assert!(0 < n && n <= MAX_SWEEP);
        let mut keys = [i32::MAX; MAX_SWEEP];
        for (key, prim) in keys.iter_mut().zip(prims) {
            *key = prim.id() as i32;
        }
        let ranks = ranks(&keys);
        let mut centers = [[i32::MAX; MAX_SWEEP]; 3];
        for (prim, rank) in prims.iter().zip(ranks) {
            let rank = rank as usize % MAX_SWEEP;
            self.prims[rank] = prim.bounds;
            self.ids[rank] = prim.id();
            let center = prim.bounds.center().array();
            for (centers, center) in centers.iter_mut().zip(center) {
                centers[rank] = ordered(center) & !INDEX_MASK | rank as i32;
            }
        }
        for (order, centers) in self.orders.iter_mut().zip(&centers) {
            for (i, rank) in (0..n as u8).zip(self::ranks(centers)) {
                order[rank as usize % MAX_SWEEP] = i;
            }
        }
        let bounds = prims.iter().fold(Bounds::empty(), |a, p| a.union(p.bounds));
        self.part(0, n, bounds, costs, tree);
    }

    /// Appends the tree of the primitives at `begin..end` of all three orders.
    fn part(&mut self, begin: usize, end: usize, bounds: Bounds, costs: &Costs, tree: &mut BinaryTree) {
        let count = end - begin;
        if costs.blocks(count) == 1 {
            let first = tree.ids.len();
            let members = self.orders[0][begin..end].iter().fold(0_u32, |set, i| set | 1 << i);
            push_members(members, &self.ids, &mut tree.ids);
            tree.push_leaf(bounds, first, costs);
            return;
        }
        let (axis, middle) = self.best_split(begin, end, bounds, costs);
        let left_members = self.orders[axis][begin..middle].iter().fold(0_u32, |set, i| set | 1 << i);
        for other in 0..3 {
            if other != axis {
                partition(&mut self.orders[other][begin..end], left_members);
            }
        }
        let bounds_of = |range: &[u8]| {
            range.iter().fold(Bounds::empty(), |a, &i| a.union(self.prims[usize::from(i) % MAX_SWEEP]))
        };
        let left = bounds_of(&self.orders[axis][begin..middle]);
        let right = bounds_of(&self.orders[axis][middle..end]);
        let index = tree.push_inner(bounds);
        self.part(begin, middle, left, costs, tree);
        let right_index = tree.nodes.len();
        self.part(middle, end, right, costs, tree);
        tree.finish(index, right_index, costs);
    }

    /// The best axis, and the position in its order where the right part begins.
    fn best_split(&self, begin: usize, end: usize, bounds: Bounds, costs: &Costs) -> (usize, usize) {
        let count = end - begin;
        let mut best = (f32::INFINITY, usize::MAX, 0, begin + count / 2);
        let mut left_areas = [0.0_f32; MAX_SWEEP];
        let axes = if self.one_axis { bounds.longest_axis()..bounds.longest_axis() + 1 } else { 0..3 };
        let blocks = costs.blocks(count);
        for axis in axes {
            let order = &self.orders[axis][begin..end];
            let mut swept = Bounds::empty();
            for (area, &i) in left_areas.iter_mut().zip(order) {
                swept = swept.union(self.prims[usize::from(i) % MAX_SWEEP]);
                *area = swept.area(costs.pad);
            }
            let mut swept = Bounds::empty();
            for middle in (1..count).rev() {
                swept = swept.union(self.prims[usize::from(order[middle]) % MAX_SWEEP]);
                if costs.blocks(middle) + costs.blocks(count - middle) > blocks {
                    continue;
                }
                let cost = left_areas[middle - 1] * costs.blocks(middle) as f32
                    + swept.area(costs.pad) * costs.blocks(count - middle) as f32;
                let balance = (2 * middle).abs_diff(count);
                if cost < best.0 || cost == best.0 && balance < best.1 {
                    best = (cost, balance, axis, begin + middle);
                }
            }
        }
        (best.2, best.3)
    }
}

/// The rank of each key in ascending order. Used keys are distinct.
fn ranks(keys: &[i32; MAX_SWEEP]) -> [i32; MAX_SWEEP] {
    #[cfg(target_arch = "x86_64")]
    if super::lanes::has_avx2() {
        // SAFETY: the processor has AVX2.
        return unsafe { ranks_avx2(keys) };
    }
    ranks_here(keys)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn ranks_avx2(keys: &[i32; MAX_SWEEP]) -> [i32; MAX_SWEEP] {
    ranks_here(keys)
}

#[inline(always)]
fn ranks_here(keys: &[i32; MAX_SWEEP]) -> [i32; MAX_SWEEP] {
    let mut ranks = [0; MAX_SWEEP];
    for &key in keys {
        for (rank, other) in ranks.iter_mut().zip(keys) {
            *rank += i32::from(key < *other);
        }
    }
    ranks
}

/// An integer that compares as the float does.
fn ordered(x: f32) -> i32 {
    let bits = x.to_bits() as i32;
    bits ^ ((bits >> 31) as u32 >> 1) as i32
}

/// Stable partition: primitives in `left_members` first.
fn partition(order: &mut [u8], left_members: u32) {
    let mut right = [0; MAX_SWEEP];
    let (mut left_count, mut right_count) = (0, 0);
    for k in 0..order.len() {
        let i = order[k];
        let is_left = left_members >> i & 1;
        order[left_count] = i;
        right[right_count] = i;
        left_count += is_left as usize;
        right_count += 1 - is_left as usize;
    }
    order[left_count..].copy_from_slice(&right[..right_count]);
}

/// Appends the IDs of the members in ascending order.
fn push_members(mut members: u32, ids: &[u32; MAX_SWEEP], to: &mut Vec<u32>) {
    while members != 0 {
        to.push(ids[members.trailing_zeros() as usize]);
        members &= members - 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_are_ordered_as_their_numbers() {
        let numbers = [f32::NEG_INFINITY, -1e30, -2.0, -1e-40, 0.0, 1e-45, 1.0, 1.5, f32::INFINITY];
        assert!(numbers.map(ordered).is_sorted());
    }

    #[test]
    fn parts_keep_their_order() {
        let mut order = [4, 2, 0, 1, 3];
        partition(&mut order, 0b10011);
        assert_eq!(order, [4, 0, 1, 2, 3]);
    }
}

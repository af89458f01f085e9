//! Binned SAH builder for the binary BVH (Wald 2007, "On fast construction of SAH-based bounding volume hierarchies").
//!
//! A random line that hits a convex box hits a convex box inside it with probability `area(inner) / area(outer)`.
//! So a set of `n` primitives costs `area * n` as a leaf and `area + area_l * n_l + area_r * n_r` when it is split
//! once. To find a cheap split, the builder sorts the centres into bins of equal width on each axis and evaluates
//! only the planes between bins:
//!
//! ```text
//!   centres  |  .  . | ..    |   .   |       |  .  : |
//!   bins         0       1       2       3       4
//!                   candidate planes: the inner |
//! ```
//!
//! One pass fills the bins, one sweep from the right accumulates `area_r * n_r`, and one from the left finds the
//! minimum: O(n) per level, O(n log n) in total. A split depends on its set only, so the BVH is the same for any
//! number of threads.

use std::sync::Mutex;
use turner_host::thread;

use super::Bvh2Options;
use crate::bvh2::{Child, Node};
use crate::{Aabb, MAX_DEPTH};

const MAX_BINS: usize = 32;

/// Smaller sets are built on one thread: starting another costs more than it saves.
const MIN_PARALLEL: usize = 8192;

/// A primitive during the build.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    pub(super) bounds: Aabb,
    pub(super) index: u32,
}

impl Item {
    /// Half the centre: differences between two of them cannot overflow.
    #[inline]
    fn half_center(&self) -> [f32; 3] {
        std::array::from_fn(|i| 0.25 * self.bounds.min[i] + 0.25 * self.bounds.max[i])
    }
}

/// A set of primitives that becomes one subtree.
struct Set<'a> {
    items: &'a mut [Item],
    /// Position of the first item in the final primitive order.
    first: u32,
    /// Union of the items' boxes.
    bounds: Aabb,
    /// Number of ancestors.
    depth: usize,
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Aabb,
    count: usize,
}

impl Bin {
    const EMPTY: Bin = Bin { bounds: Aabb::EMPTY, count: 0 };

    fn add(&mut self, other: &Bin) {
        self.bounds = self.bounds.union(other.bounds);
        self.count += other.count;
    }

    fn cost(&self) -> f64 {
        self.bounds.half_area() * self.count as f64
    }
}

/// Items in bins `0..=last_left` of `axis` go to the left child.
struct Split {
    axis: usize,
    last_left: usize,
    cost: f64,
}

/// Maps centres to bins.
struct Binning {
    bins: usize,
    min: [f32; 3],
    scale: [f32; 3],
}

impl Binning {
    fn new(centers: Aabb, bins: usize) -> Binning {
        let scale = std::array::from_fn(|i| bins as f32 / (centers.max[i] - centers.min[i]));
        Binning { bins, min: centers.min, scale }
    }

    /// If all centres are so close that the scale is infinite, centres at the minimum give NaN and go to bin 0, the
    /// rest saturate to the last bin.
    #[inline]
    fn bin(&self, center: f32, axis: usize) -> usize {
        (((center - self.min[axis]) * self.scale[axis]) as usize).min(self.bins - 1)
    }
}

pub(super) struct Builder {
    bins: usize,
    max_leaf: usize,
}

impl Builder {
    pub(super) fn new(options: &Bvh2Options) -> Builder {
        Builder {
            bins: usize::from(options.bins).clamp(2, MAX_BINS),
            max_leaf: usize::from(options.max_leaf).max(1),
        }
    }

    /// Sorts the items into leaf order and returns the nodes in depth-first order, with the root at 0.
    pub(super) fn build(&self, items: &mut [Item], threads: usize) -> Vec<Node> {
        if items.is_empty() {
            return Vec::new();
        }
        let bounds = items.iter().fold(Aabb::EMPTY, |b, item| b.union(item.bounds));
        let mut nodes = Vec::new();
        let root = self.subtree(Set { items, first: 0, bounds, depth: 0 }, threads, &mut nodes);
        if nodes.is_empty() {
            // A single leaf still needs a root node.
            nodes.push(Node::new([(bounds, root), (Aabb::EMPTY, Child::leaf(0, 0))]));
        }
        nodes
    }

    /// Appends the subtree's nodes and returns a reference to it. The recursion depth is at most `MAX_DEPTH`.
    fn subtree(&self, set: Set<'_>, threads: usize, nodes: &mut Vec<Node>) -> Child {
        let (first, bounds, depth) = (set.first, set.bounds, set.depth);
        let Some([left, right]) = self.split(set.items, &bounds, depth) else {
            return Child::leaf(first, set.items.len() as u32);
        };
        let (left_items, right_items) = set.items.split_at_mut(left.count);
        let count = left_items.len() + right_items.len();
        let right_first = first + left_items.len() as u32;
        let index = nodes.len();
        nodes.push(Node::PLACEHOLDER);
        let left_threads = (threads * left_items.len() / count).clamp(1, threads.max(2) - 1);
        let left_set = Set { items: left_items, first, bounds: left.bounds, depth: depth + 1 };
        let right_set =
            Set { items: right_items, first: right_first, bounds: right.bounds, depth: depth + 1 };
        let children = if threads > 1 && count >= MIN_PARALLEL {
            self.both_at_once(left_set, right_set, [left_threads, threads - left_threads], nodes)
        } else {
            [self.subtree(left_set, 1, nodes), self.subtree(right_set, 1, nodes)]
        };
        nodes[index] = Node::new([(left.bounds, children[0]), (right.bounds, children[1])]);
        Child::node(index)
    }

    /// Builds the right subtree on another thread and appends it after the left one.
    fn both_at_once(
        &self,
        left: Set<'_>,
        right: Set<'_>,
        threads: [usize; 2],
        nodes: &mut Vec<Node>,
    ) -> [Child; 2] {
        // The new thread takes the right set, or this thread does if no thread could be started.
        let waiting = Mutex::new(Some(right));
        let build_right = || {
            let right = waiting.lock().ok()?.take()?;
            let mut nodes = Vec::new();
            let root = self.subtree(right, threads[1], &mut nodes);
            Some((root, nodes))
        };
        let (left_root, right) = thread::scope(|scope| {
            let started = thread::Builder::new().spawn_scoped(scope, build_right);
            let left_root = self.subtree(left, threads[0], nodes);
            let right = match started {
                Ok(handle) => handle.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)),
                Err(_) => build_right(),
            };
            (left_root, right)
        });
        let (right_root, right_nodes) = right.expect("taken once, by whoever builds it");
        let offset = nodes.len();
        nodes.extend(right_nodes.iter().map(|node| node.shifted(offset)));
        [left_root, right_root.shifted(offset)]
    }

    /// Partitions the items in place and returns the bounds and size of both sides; `None` makes a leaf.
    fn split(&self, items: &mut [Item], bounds: &Aabb, depth: usize) -> Option<[Bin; 2]> {
        if items.len() == 1 {
            return None;
        }
        // Halving needs log2(n) more levels. When only that many are left, halve.
        let halvings = (items.len() - 1).ilog2() as usize + 1;
        if depth + halvings < MAX_DEPTH {
            let centers = items.iter().fold(Aabb::EMPTY, |b, item| b.grow(item.half_center()));
            let binning = Binning::new(centers, self.bins);
            let best = best_split(items, &binning);
            if items.len() <= self.max_leaf {
                let leaf_cost = bounds.half_area() * items.len() as f64;
                if best.as_ref().is_none_or(|split| bounds.half_area() + split.cost >= leaf_cost) {
                    return None;
                }
            }
            if let Some(split) = best {
                return Some(partition(items, &binning, &split));
            }
        } else if items.len() <= self.max_leaf {
            return None;
        }
        Some(halve(items))
    }
}

/// The cheapest split with items on both sides; `None` if all centres fall into one bin.
fn best_split(items: &[Item], binning: &Binning) -> Option<Split> {
    let mut bins = [[Bin::EMPTY; MAX_BINS]; 3];
    for item in items {
        let center = item.half_center();
        for axis in 0..3 {
            let bin = &mut bins[axis][binning.bin(center[axis], axis)];
            bin.bounds = bin.bounds.union(item.bounds);
            bin.count += 1;
        }
    }
    let mut best: Option<Split> = None;
    for (axis, bins) in bins.iter().enumerate() {
        let mut right_costs = [0.0; MAX_BINS];
        let mut right = Bin::EMPTY;
        for i in (1..binning.bins).rev() {
            right.add(&bins[i]);
            right_costs[i] = right.cost();
        }
        let mut left = Bin::EMPTY;
        for last_left in 0..binning.bins - 1 {
            left.add(&bins[last_left]);
            if left.count == 0 || left.count == items.len() {
                continue;
            }
            let cost = left.cost() + right_costs[last_left + 1];
            if best.as_ref().is_none_or(|best| cost < best.cost) {
                best = Some(Split { axis, last_left, cost });
            }
        }
    }
    best
}

/// Moves the items of the left bins to the front.
fn partition(items: &mut [Item], binning: &Binning, split: &Split) -> [Bin; 2] {
    let mut parts = [Bin::EMPTY; 2];
    let (mut front, mut back) = (0, items.len());
    while front < back {
        let item = items[front];
        let goes_right = binning.bin(item.half_center()[split.axis], split.axis) > split.last_left;
        let part = &mut parts[usize::from(goes_right)];
        part.bounds = part.bounds.union(item.bounds);
        part.count += 1;
        if goes_right {
            back -= 1;
            items.swap(front, back);
        } else {
            front += 1;
        }
    }
    parts
}

/// Splits at the median: by centre on the axis of largest extent, or by area if all centres coincide.
fn halve(items: &mut [Item]) -> [Bin; 2] {
    let centers = items.iter().fold(Aabb::EMPTY, |b, item| b.grow(item.half_center()));
    let extent: [f32; 3] = std::array::from_fn(|i| centers.max[i] - centers.min[i]);
    let axis = (1..3).fold(0, |widest, i| if extent[i] > extent[widest] { i } else { widest });
    let middle = items.len() / 2;
    if extent[axis] > 0.0 {
        items.select_nth_unstable_by(middle, |a, b| {
            let centers = (a.half_center()[axis], b.half_center()[axis]);
            centers.0.total_cmp(&centers.1).then(a.index.cmp(&b.index))
        });
    } else {
        items.select_nth_unstable_by(middle, |a, b| {
            a.bounds.half_area().total_cmp(&b.bounds.half_area()).then(a.index.cmp(&b.index))
        });
    }
    let (left, right) = items.split_at(middle);
    [left, right].map(|part| Bin {
        bounds: part.iter().fold(Aabb::EMPTY, |b, item| b.union(item.bounds)),
        count: part.len(),
    })
}

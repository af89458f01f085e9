//! Builds the upper wide nodes with all threads together and the subtrees below them in parallel.
//!
//! Sets above [`MAX_SUBTREE`] become top nodes: the builder repeatedly splits the child with the largest box until
//! there are eight. Smaller sets become binary trees, which [`collapse`](super::collapse) turns into wide nodes. While
//! there are fewer sets than threads, all threads bin and partition one set together.

use std::collections::BinaryHeap;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use super::super::BuildError;
use super::assembly::{TopChild, TopNode};
use super::binary::{BinaryBuilder, bins_for, divide};
use super::bins::{Grid, Scratch, best_split, halve, partition};
use super::collapse::{Collapse, Subtree, halvings};
use super::parallel::{Progress, at_once, parts};
use super::prims::{Bounds, Costs, Prim, Set};
use crate::node::MAX_WIDE_DEPTH;

/// Sets up to this size become subtrees. The BVH depends on it.
pub(super) const MAX_SUBTREE: usize = 1 << 13;

/// Sets from this size on are split by several threads together.
const MIN_PARALLEL: usize = 1 << 17;

/// A set that waits to become a child of a top node.
struct Work<'a> {
    set: Set<'a>,
    /// Number of ancestors.
    depth: usize,
    /// The top node and the child slot; `None` for the root.
    parent: Option<(usize, usize)>,
}

impl Ord for Work<'_> {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.set.len().cmp(&other.set.len())
    }
}

impl PartialOrd for Work<'_> {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Work<'_> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Work<'_> {}

/// State shared by all threads.
struct State<'a> {
    /// Largest set first.
    waiting: BinaryHeap<Work<'a>>,
    /// Sets that wait or are in progress.
    unfinished: usize,
    top: Vec<TopNode>,
    subtrees: Vec<Subtree>,
    error: Option<BuildError>,
}

pub(super) struct Top<'a> {
    pub(super) costs: Costs,
    pub(super) max_bins: usize,
    /// Consider splits on one axis only.
    pub(super) one_axis: bool,
    pub(super) threads: usize,
    pub(super) progress: &'a Progress<'a>,
}

/// Estimated work for a set, for progress reports.
pub(super) fn work_of(count: usize) -> usize {
    count * (count.max(2).ilog2() as usize + 4)
}

impl Top<'_> {
    /// Builds top nodes and subtrees. Their indices depend on the threads; the BVH they form does not.
    pub(super) fn build(&self, set: Set<'_>) -> Result<(Vec<TopNode>, Vec<Subtree>), BuildError> {
        let count = set.len();
        let root = Work { set, depth: 0, parent: None };
        let state = Mutex::new(State {
            waiting: BinaryHeap::from([root]),
            unfinished: 1,
            top: Vec::new(),
            subtrees: Vec::new(),
            error: None,
        });
        let changed = Condvar::new();
        let builder = BinaryBuilder::new(self.costs, self.max_bins, self.one_axis);
        if self.threads > 1 {
            // Until there are enough sets for all threads.
            let large = MIN_PARALLEL.max(count / (4 * self.threads));
            loop {
                let mut guard = lock(&state);
                if guard.error.is_some() || guard.waiting.peek().is_none_or(|work| work.set.len() < large) {
                    break;
                }
                let work = guard.waiting.pop().expect("the heap was not empty");
                drop(guard);
                let result = self.top_node(work, &mut |set| self.split_together(set), &state);
                self.note(result, &state);
            }
        }
        let threads = if count <= MAX_SUBTREE { 1 } else { self.threads };
        let builders = Mutex::new(Some(builder));
        at_once(threads, |_| {
            let first = builders.lock().unwrap_or_else(PoisonError::into_inner).take();
            let mut builder =
                first.unwrap_or_else(|| BinaryBuilder::new(self.costs, self.max_bins, self.one_axis));
            self.work(&mut builder, &state, &changed);
        });
        let state = state.into_inner().unwrap_or_else(PoisonError::into_inner);
        match state.error {
            Some(error) => Err(error),
            None => Ok((state.top, state.subtrees)),
        }
    }

    /// Processes sets until none is left.
    fn work<'a>(&self, builder: &mut BinaryBuilder, state: &Mutex<State<'a>>, changed: &Condvar) {
        loop {
            let mut guard = lock(state);
            let work = loop {
                if guard.error.is_some() || guard.unfinished == 0 {
                    return;
                }
                if let Some(work) = guard.waiting.pop() {
                    break work;
                }
                guard = changed.wait(guard).unwrap_or_else(PoisonError::into_inner);
            };
            drop(guard);
            let result = if work.set.len() > MAX_SUBTREE {
                self.top_node(work, &mut |set| builder.split(set), state)
            } else {
                self.subtree(work, builder, state)
            };
            self.note(result, state);
            changed.notify_all();
        }
    }

    fn note(&self, result: Result<(), BuildError>, state: &Mutex<State<'_>>) {
        if let Err(error) = result {
            lock(state).error.get_or_insert(error);
        }
    }

    /// Splits a set into up to eight children, each time the one with the largest box, and queues them.
    fn top_node<'a>(
        &self,
        work: Work<'a>,
        split: &mut dyn FnMut(Set<'a>) -> [Set<'a>; 2],
        state: &Mutex<State<'a>>,
    ) -> Result<(), BuildError> {
        let depth = work.depth + 1;
        let evenly = depth + halvings(work.set.len()) + 1 >= MAX_WIDE_DEPTH;
        let count = work.set.len();
        let mut sets = vec![work.set];
        while sets.len() < 8 {
            self.progress.check()?;
            let size = |set: &Set<'_>| match evenly {
                true => set.len() as f32,
                false => set.bounds.area(self.costs.pad),
            };
            let splittable = (0..sets.len()).filter(|&i| sets[i].len() > 1 << self.costs.block_shift);
            let larger = |a: &usize, b: &usize| {
                let (a, b) = (&sets[*a], &sets[*b]);
                size(a).total_cmp(&size(b)).then(a.len().cmp(&b.len()))
            };
            let Some(largest) = splittable.max_by(larger) else {
                break;
            };
            let set = std::mem::replace(&mut sets[largest], Set::of(&mut []));
            let [left, right] = if evenly { halve(set) } else { split(set) };
            sets[largest] = left;
            sets.insert(largest + 1, right);
        }
        self.progress.advance(3 * count)?;
        let mut state = lock(state);
        let index = state.top.len();
        state.top.push(TopNode {
            children: sets.iter().map(|set| (set.bounds.aabb(), TopChild::Node(0))).collect(),
        });
        self.link(&mut state, work.parent, TopChild::Node(index));
        state.unfinished += sets.len() - 1;
        for (i, set) in sets.into_iter().enumerate() {
            state.waiting.push(Work { set, depth, parent: Some((index, i)) });
        }
        Ok(())
    }

    fn subtree<'a>(
        &self,
        work: Work<'a>,
        builder: &mut BinaryBuilder,
        state: &Mutex<State<'a>>,
    ) -> Result<(), BuildError> {
        self.progress.check()?;
        let count = work.set.len();
        builder.tree.clear();
        builder.subtree(work.set, 0);
        let collapse = Collapse { tree: &builder.tree, costs: &self.costs, out: Subtree::default() };
        let subtree = collapse.run(work.depth, work.parent.is_none());
        {
            let mut state = lock(state);
            let index = state.subtrees.len();
            state.subtrees.push(subtree);
            self.link(&mut state, work.parent, TopChild::Subtree(index));
            state.unfinished -= 1;
        }
        self.progress.advance(work_of(count))
    }

    fn link(&self, state: &mut State<'_>, parent: Option<(usize, usize)>, child: TopChild) {
        if let Some((parent, slot)) = parent {
            state.top[parent].children[slot].1 = child;
        }
    }

    /// Splits a large set with all threads.
    fn split_together<'a>(&self, set: Set<'a>) -> [Set<'a>; 2] {
        let threads = self.threads.min(set.len() / (MIN_PARALLEL / 4)).max(1);
        let grid = Grid::new(set.centers, bins_for(set.len(), self.max_bins), self.one_axis);
        let chunks: Vec<Mutex<&mut [Prim]>> = parts(set.prims, threads).into_iter().map(Mutex::new).collect();
        let mut all = at_once(threads, |i| {
            let chunk = chunks[i].lock().unwrap_or_else(PoisonError::into_inner);
            let mut scratch = Scratch::new();
            scratch.fill(&chunk, &grid);
            scratch
        });
        let (first, others) = all.split_first_mut().expect("at least one thread");
        for other in others {
            first.first().merge(other.first(), &grid);
        }
        let Some(split) =
            best_split(first.first(), &grid, chunks.iter().map(|s| lock(s).len()).sum(), &self.costs)
        else {
            drop(chunks);
            return halve(set);
        };
        let parted = at_once(threads, |i| {
            let mut chunk = chunks[i].lock().unwrap_or_else(PoisonError::into_inner);
            partition(&mut chunk, &grid, &split)
        });
        drop(chunks);
        let centers =
            parted.iter().fold([Bounds::empty(); 2], |[a, b], (_, [c, d])| [a.union(*c), b.union(*d)]);
        let lefts: Vec<usize> = parted.iter().map(|(left, _)| *left).collect();
        exchange(set.prims, &lefts);
        divide(set, lefts.iter().sum(), &split, centers)
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Gathers the left primitives at the front of the slice. Each of the equal parts of the slice is partitioned: its
/// first `lefts[i]` primitives go left.
fn exchange(prims: &mut [Prim], lefts: &[usize]) {
    let (count, len) = (lefts.len(), prims.len());
    let middle: usize = lefts.iter().sum();
    let starts: Vec<usize> = (0..=count).map(|i| len * i / count).collect();
    // Right primitives before the middle swap with left primitives after it.
    let before = (0..count).map(|i| starts[i] + lefts[i]..starts[i + 1].min(middle));
    let behind = (0..count).map(|i| starts[i].max(middle)..starts[i] + lefts[i]);
    let (low, high) = prims.split_at_mut(middle);
    let mut high_positions = behind.flatten();
    for slot in before.flatten() {
        let other = high_positions.next().expect("as many misplaced on one side as on the other");
        std::mem::swap(&mut low[slot], &mut high[other - middle]);
    }
}

//! Many rays: which of them go together, and which way.
//!
//! - In trees of few blocks, all triangles are tested against a ray per lane for the nearest hit.
//! - Neighbours that run together go as packets, and no longer when packets keep falling apart.
//! - In large trees, the others go in turns; in small ones, one after the other.

use super::{Leaves, PacketLeaves, Tree, few, interleaved, packet, single};
use crate::simd::Simd;
use crate::{Hit, Ray};

/// Bytes of nodes from which rays are searched for in turns: trees of about 300,000 triangles. What is
/// smaller stays in nearby caches, there is little to wait for, and one ray after the other is faster: 1.1 to 1.2 times with
/// 66,000 triangles of architecture; with a scan of 1.3 million, turns are 1.25 times as fast.
const INTERLEAVE_FROM: usize = 2 << 20;

/// Groups of rays that do not try to go as a packet after one has fallen apart: first, and at most.
const PAUSES: [u32; 2] = [15, 63];

/// Finds the nearest hit of each ray; the first has number `first`.
#[inline(always)]
pub(crate) fn closest_batch<S: Simd, L: Leaves>(
    simd: S,
    tree: &Tree<'_, L>,
    rays: &[Ray],
    first: usize,
    hits: &mut [Hit],
) {
    if size_of_val(tree.nodes) >= INTERLEAVE_FROM {
        interleaved::closest(simd, tree, rays, first, hits);
    } else {
        single::closest_each(simd, tree, rays, first, hits);
    }
}

/// Finds whether each ray hits anything; the first has number `first`.
#[inline(always)]
pub(crate) fn any_batch<S: Simd, L: Leaves>(
    simd: S,
    tree: &Tree<'_, L>,
    rays: &[Ray],
    first: usize,
    hits: &mut [bool],
) {
    if size_of_val(tree.nodes) >= INTERLEAVE_FROM {
        interleaved::any(simd, tree, rays, first, hits);
    } else {
        single::any_each(simd, tree, rays, first, hits);
    }
}

/// Finds the nearest hit of each ray, among triangles.
#[inline(always)]
pub(crate) fn closest_triangles<S: Simd, L: PacketLeaves>(
    simd: S,
    tree: &Tree<'_, L>,
    rays: &[Ray],
    hits: &mut [Hit],
) {
    let mut groups = Groups::new::<S>();
    while let Some(group) = groups.next::<S>(rays) {
        let found = if groups.may_run_together {
            packet::closest(simd, tree, &rays[group..group + S::PACKET], group, &mut hits[group..])
        } else {
            None
        };
        let (from, to) = groups.went::<S>(found, rays.len());
        if from < to {
            if few::are_few::<S, L>(tree) {
                few::closest(simd, tree, &rays[from..to], from, &mut hits[from..to]);
            } else {
                closest_batch(simd, tree, &rays[from..to], from, &mut hits[from..to]);
            }
        }
    }
}

/// Finds whether each ray hits anything, among triangles.
#[inline(always)]
pub(crate) fn any_triangles<S: Simd, L: PacketLeaves>(
    simd: S,
    tree: &Tree<'_, L>,
    rays: &[Ray],
    hits: &mut [bool],
) {
    let mut groups = Groups::new::<S>();
    while let Some(group) = groups.next::<S>(rays) {
        let found = if groups.may_run_together {
            packet::any(simd, tree, &rays[group..group + S::PACKET], group, &mut hits[group..])
        } else {
            None
        };
        let (from, to) = groups.went::<S>(found, rays.len());
        if from < to {
            any_batch(simd, tree, &rays[from..to], from, &mut hits[from..to]);
        }
    }
}

/// Rays in groups of as many as there are lanes.
struct Groups {
    /// Where the next group begins.
    next: usize,
    /// Where those begin that have been left to go alone.
    alone: usize,
    /// Whether the group just handed out may be a packet.
    may_run_together: bool,
    /// Groups that do not try.
    pause: u32,
    last_pause: u32,
}

impl Groups {
    fn new<S: Simd>() -> Groups {
        // Without vectors of eight there are no packets.
        let pause = if S::PACKET >= 8 { 0 } else { u32::MAX };
        Groups { next: 0, alone: 0, may_run_together: false, pause, last_pause: 0 }
    }

    /// The first ray of the next group; the last group may be smaller.
    #[inline(always)]
    fn next<S: Simd>(&mut self, rays: &[Ray]) -> Option<usize> {
        let group = self.next;
        let left = rays.get(group..).filter(|left| !left.is_empty())?;
        self.next = group + S::PACKET.min(left.len());
        self.may_run_together =
            self.pause == 0 && left.len() >= S::PACKET && run_together(&left[..S::PACKET]);
        self.pause = self.pause.saturating_sub(1);
        Some(group)
    }

    /// Notes what became of the group: `None` if it was no packet, otherwise whether it held together. Returns the rays
    /// that are to go alone now.
    #[inline(always)]
    fn went<S: Simd>(&mut self, found: Option<bool>, len: usize) -> (usize, usize) {
        let from = self.alone;
        let Some(held) = found else {
            let to = if self.next == len { len } else { from };
            return (from, to);
        };
        if held {
            self.last_pause = 0;
        } else {
            self.last_pause = (2 * self.last_pause + 1).clamp(PAUSES[0], PAUSES[1]);
            self.pause = self.last_pause;
        }
        self.alone = self.next;
        (from, self.next - S::PACKET)
    }
}

/// Whether a packet is worth a try: by the signs of three directions.
#[inline(always)]
fn run_together(rays: &[Ray]) -> bool {
    let [a, b, c] = [&rays[0], &rays[rays.len() / 2], &rays[rays.len() - 1]].map(|ray| ray.direction);
    let differ = |i: usize| (a[i].to_bits() ^ b[i].to_bits()) | (a[i].to_bits() ^ c[i].to_bits());
    (differ(0) | differ(1) | differ(2)) >> 31 == 0
}

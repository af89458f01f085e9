//! Many rays: chooses how to trace them.
//!
//! - Coherent neighbours form packets; after a packet falls apart, the next groups do not try.
//! - Other rays in a BVH of few blocks: all triangles against one ray per lane, for nearest hits only.
//! - Other rays in a large BVH: interleaved. In a small BVH: one after the other.

use super::{Leaves, PacketLeaves, Tree, few, interleaved, packet, single};
use crate::simd::Simd;
use crate::{Hit, Ray};

/// Rays are interleaved in BVHs with at least this many bytes of nodes: about 300,000 triangles. Smaller BVHs stay in
/// nearby caches, and single rays are faster: 1.1 to 1.2 times for 66,000 triangles of architecture. For a scan of
/// 1.3 million triangles, interleaving is 1.25 times as fast.
const INTERLEAVE_FROM: usize = 2 << 20;

/// Groups that do not try to form a packet after one has fallen apart: at first, and at most.
const PAUSES: [u32; 2] = [15, 63];

/// Finds the nearest hit of each ray; the first ray has index `first`.
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

/// Finds whether each ray hits anything; the first ray has index `first`.
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

/// Finds the nearest hit of each ray among triangles.
#[inline(always)]
pub(crate) fn closest_triangles<S: Simd, L: PacketLeaves>(
    simd: S,
    tree: &Tree<'_, L>,
    rays: &[Ray],
    hits: &mut [Hit],
) {
    let mut groups = Groups::new::<S>();
    while let Some(group) = groups.next::<S>(rays) {
        let found = if groups.may_be_packet {
            packet::closest(simd, tree, &rays[group..group + S::PACKET], group, &mut hits[group..])
        } else {
            None
        };
        let (from, to) = groups.record::<S>(found, rays.len());
        if from < to {
            if few::applies::<S, L>(tree) {
                few::closest(simd, tree, &rays[from..to], from, &mut hits[from..to]);
            } else {
                closest_batch(simd, tree, &rays[from..to], from, &mut hits[from..to]);
            }
        }
    }
}

/// Finds whether each ray hits any triangle.
#[inline(always)]
pub(crate) fn any_triangles<S: Simd, L: PacketLeaves>(
    simd: S,
    tree: &Tree<'_, L>,
    rays: &[Ray],
    hits: &mut [bool],
) {
    let mut groups = Groups::new::<S>();
    while let Some(group) = groups.next::<S>(rays) {
        let found = if groups.may_be_packet {
            packet::any(simd, tree, &rays[group..group + S::PACKET], group, &mut hits[group..])
        } else {
            None
        };
        let (from, to) = groups.record::<S>(found, rays.len());
        if from < to {
            any_batch(simd, tree, &rays[from..to], from, &mut hits[from..to]);
        }
    }
}

/// Divides rays into groups of one per lane.
struct Groups {
    /// First ray of the next group.
    next: usize,
    /// First ray that is not yet traced and not in a packet.
    first_single: usize,
    /// Whether the current group may be a packet.
    may_be_packet: bool,
    /// Groups left that do not try to form a packet.
    pause: u32,
    last_pause: u32,
}

impl Groups {
    fn new<S: Simd>() -> Groups {
        // Packets need vectors of eight lanes.
        let pause = if S::PACKET >= 8 { 0 } else { u32::MAX };
        Groups { next: 0, first_single: 0, may_be_packet: false, pause, last_pause: 0 }
    }

    /// The first ray of the next group; the last group may be smaller.
    #[inline(always)]
    fn next<S: Simd>(&mut self, rays: &[Ray]) -> Option<usize> {
        let group = self.next;
        let left = rays.get(group..).filter(|left| !left.is_empty())?;
        self.next = group + S::PACKET.min(left.len());
        self.may_be_packet = self.pause == 0 && left.len() >= S::PACKET && are_coherent(&left[..S::PACKET]);
        self.pause = self.pause.saturating_sub(1);
        Some(group)
    }

    /// Records the result of the group: `None` if it was not a packet, otherwise whether the packet stayed together.
    /// Returns the rays that are now to be traced without packets.
    #[inline(always)]
    fn record<S: Simd>(&mut self, found: Option<bool>, len: usize) -> (usize, usize) {
        let from = self.first_single;
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
        self.first_single = self.next;
        (from, self.next - S::PACKET)
    }
}

/// Whether a packet is worth a try: compares the signs of three directions.
#[inline(always)]
fn are_coherent(rays: &[Ray]) -> bool {
    let [a, b, c] = [&rays[0], &rays[rays.len() / 2], &rays[rays.len() - 1]].map(|ray| ray.direction);
    let differ = |i: usize| (a[i].to_bits() ^ b[i].to_bits()) | (a[i].to_bits() ^ c[i].to_bits());
    (differ(0) | differ(1) | differ(2)) >> 31 == 0
}

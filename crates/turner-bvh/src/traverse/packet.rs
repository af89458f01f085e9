//! Packets of coherent rays: camera rays of neighbouring pixels, shadow rays of neighbouring points to one light.
//!
//! A packet visits a node once for all its rays. Interval arithmetic over origins and reciprocal directions bounds
//! their entry and exit distances (Boulos et al. 2006, "Interactive distribution ray tracing"):
//!
//! ```text
//!   entry  = max over axes of  min over the packet of  (near plane - o) / d
//!   exit   = min over axes of  max over the packet of  (far plane - o) / d
//!   the packet skips a box if entry > exit: then no ray hits it
//! ```
//!
//! In a leaf the same test culls triangles by their bounds; each remaining triangle is tested against all rays at
//! once, one ray per lane. Rays are traced singly instead if they are incoherent (signs or longest axes of their
//! directions differ), or after their packet has taken too many steps.
//!
//! Hits equal those of single rays bit for bit, because triangles are tested by the same arithmetic.

use super::stack::Stack;
use super::{PacketLeaves, SearchRay, Tree, single};
use crate::node::{ChildRef, WideNode};
use crate::simd::{Lanes, Simd};
use crate::triangle::{Axes, BLOCK, Block};
use crate::{Hit, Ray};

use super::ray::{MAX_COORDINATE, MAX_DIRECTION, MIN_COMPONENT, PADDING};
use super::rows::{MAX_RAYS, Rows};

/// Steps (nodes, leaves and tested triangles) of a packet before its rays continue singly.
const MAX_STEPS: u32 = 100;

/// A packet in traversal.
struct Packet {
    rows: Rows,
    /// Per axis: the interval of reciprocal directions, and what is subtracted from near and far planes.
    inv: [[f32; 2]; 3],
    near_offset: [f32; 3],
    far_offset: [f32; 3],
    near_side: [u32; 3],
    octant: u32,
    /// The least `t_min` and the largest `t` of all rays.
    start: f32,
    end: f32,
}

/// Finds the nearest hits of one ray per lane, with indices from `first`. Returns `None` without doing anything if the
/// rays are incoherent; otherwise whether they stayed in the packet to the end.
#[inline(always)]
pub(super) fn closest<S: Simd, L: PacketLeaves>(
    simd: S,
    tree: &Tree<'_, L>,
    rays: &[Ray],
    first: usize,
    hits: &mut [Hit],
) -> Option<bool> {
    let mut packet = Packet::new(simd, tree, rays, first)?;
    Some(packet.run::<S, L, false>(simd, tree, rays, first, |i, hit| hits[i] = hit))
}

/// Finds whether each ray of a packet hits anything. Returns as [`closest`] does.
#[inline(always)]
pub(super) fn any<S: Simd, L: PacketLeaves>(
    simd: S,
    tree: &Tree<'_, L>,
    rays: &[Ray],
    first: usize,
    hits: &mut [bool],
) -> Option<bool> {
    let mut packet = Packet::new(simd, tree, rays, first)?;
    Some(packet.run::<S, L, true>(simd, tree, rays, first, |i, hit| hits[i] = hit.is_hit()))
}

/// Consecutive indices from `first`.
#[inline(always)]
fn numbered(first: usize) -> [u32; MAX_RAYS] {
    let mut index = [0; MAX_RAYS];
    let mut i = 0;
    while i < MAX_RAYS {
        index[i] = (first + i) as u32;
        i += 1;
    }
    index
}

impl Packet {
    /// `None` if the rays are incoherent or need the rescaling of [`SearchRay`].
    #[inline(always)]
    fn new<S: Simd, L>(simd: S, tree: &Tree<'_, L>, rays: &[Ray], first: usize) -> Option<Packet> {
        let all: u32 = (1 << S::PACKET) - 1;
        if tree.space.scale != 1.0 || tree.nodes.is_empty() || rays.len() < S::PACKET || S::PACKET < 8 {
            return None;
        }
        let mut o = [[0.0; MAX_RAYS]; 3];
        let mut d = [[0.0; MAX_RAYS]; 3];
        let (mut t_min, mut t_max) = ([0.0; MAX_RAYS], [0.0; MAX_RAYS]);
        let mut i = 0;
        while i < S::PACKET {
            let ray = &rays[i];
            let mut axis = 0;
            while axis < 3 {
                o[axis][i] = ray.origin[axis];
                d[axis][i] = ray.direction[axis];
                axis += 1;
            }
            t_min[i] = if ray.t_min > 0.0 { ray.t_min } else { 0.0 };
            t_max[i] = ray.t_max;
            // A NaN in the interval, which the comparisons above do not detect.
            if !(ray.t_min <= ray.t_max && ray.t_max >= 0.0) {
                return None;
            }
            i += 1;
        }
        let [ox, oy, oz] = [simd.load_packet(&o[0]), simd.load_packet(&o[1]), simd.load_packet(&o[2])];
        let [dx, dy, dz] = [simd.load_packet(&d[0]), simd.load_packet(&d[1]), simd.load_packet(&d[2])];
        let far = ox.abs().max(oy.abs()).max(oz.abs());
        let longest = dx.abs().max(dy.abs()).max(dz.abs());
        let reachable = simd.splat_packet(MAX_COORDINATE);
        let finite = ox.abs().le(reachable) & oy.abs().le(reachable) & oz.abs().le(reachable);
        let size_limit = simd.splat_packet(MAX_DIRECTION);
        let ordinary = dx.abs().le(size_limit) & dy.abs().le(size_limit) & dz.abs().le(size_limit);
        if finite & ordinary & simd.splat_packet(1.0 / MAX_DIRECTION).le(longest) != all {
            return None;
        }
        let (axes, [kx, ky, kz]) = Self::axes::<S>([dx.abs(), dy.abs(), dz.abs()])?;
        let size = far.add(simd.splat_packet(tree.space.reach));
        let flattest = simd.splat_packet(MIN_COMPONENT).mul(longest);
        let zero = simd.splat_packet(0.0);
        let one = simd.splat_packet(1.0);
        let padding = PADDING * f32::EPSILON * size.range()[1];
        let [mut near_offset, mut far_offset] = [[0.0; 3]; 2];
        let mut inv = [[0.0; 2]; 3];
        let mut near_side = [0; 3];
        let mut octant = 0;
        let (os, ds) = ([ox, oy, oz], [dx, dy, dz]);
        let mut axis = 0;
        while axis < 3 {
            let clamped = ds[axis].abs().max(flattest).with_sign(ds[axis]);
            let down = clamped.lt(zero);
            if down != 0 && down != all {
                return None;
            }
            inv[axis] = one.div(clamped).range();
            let [low, high] = os[axis].range();
            let (low, high) = (low - padding, high + padding);
            (near_offset[axis], far_offset[axis]) = if down == 0 { (high, low) } else { (low, high) };
            near_side[axis] = if down == 0 { 0 } else { WideNode::UPPER };
            octant |= u32::from(down != 0) << axis;
            axis += 1;
        }
        let scale = [ds[kx].div(ds[kz]), ds[ky].div(ds[kz]), one.div(ds[kz])];
        let [mut shear, mut origin] = [[[0.0; MAX_RAYS]; 3]; 2];
        scale[0].store(&mut shear[0]);
        scale[1].store(&mut shear[1]);
        scale[2].store(&mut shear[2]);
        os[kx].sub(scale[0].mul(os[kz])).store(&mut origin[0]);
        os[ky].sub(scale[1].mul(os[kz])).store(&mut origin[1]);
        os[kz].store(&mut origin[2]);
        let mut tolerance = [0.0; MAX_RAYS];
        simd.splat_packet(2.0 * f32::EPSILON).mul(size).store(&mut tolerance);
        let largest = simd.splat_packet(f32::MAX);
        let ends = simd.load_packet(&t_max).min(largest);
        let mut t = [0.0; MAX_RAYS];
        ends.store(&mut t);
        let rows = Rows {
            axes,
            shear,
            origin,
            tolerance,
            t_min,
            t,
            u: [0.0; MAX_RAYS],
            v: [0.0; MAX_RAYS],
            primitive: [f32::from_bits(Hit::NONE); MAX_RAYS],
            t_scale: [1.0; MAX_RAYS],
            index: numbered(first),
        };
        Some(Packet {
            rows,
            inv,
            near_offset,
            far_offset,
            near_side,
            octant,
            start: simd.load_packet(&t_min).range()[0],
            end: ends.range()[1],
        })
    }

    /// The axis order with the longest axis last, by the same comparisons as for single rays; `None` if it differs
    /// among the rays.
    #[inline(always)]
    fn axes<S: Simd>([x, y, z]: [S::Packet; 3]) -> Option<(Axes, [usize; 3])> {
        let all: u32 = (1 << S::PACKET) - 1;
        let y_over_x = x.lt(y);
        let z_longest = x.max(y).le(z);
        if z_longest == all {
            Some((Axes::XYZ, [0, 1, 2]))
        } else if z_longest != 0 {
            None
        } else if y_over_x == all {
            Some((Axes::ZXY, [2, 0, 1]))
        } else if y_over_x == 0 {
            Some((Axes::YZX, [1, 2, 0]))
        } else {
            None
        }
    }

    /// For eight boxes, lower bounds of the entry t and upper bounds of the exit t over all rays.
    #[inline(always)]
    fn intersect<S: Simd>(&self, simd: S, near: [S::F8; 3], far: [S::F8; 3]) -> (S::F8, S::F8) {
        let entry = self.entry(simd, near[0], 0).max(self.entry(simd, near[1], 1));
        let entry = entry.max(self.entry(simd, near[2], 2).max(simd.splat8(self.start)));
        let exit = self.exit(simd, far[0], 0).min(self.exit(simd, far[1], 1));
        (entry, exit.min(self.exit(simd, far[2], 2).min(simd.splat8(self.end))))
    }

    #[inline(always)]
    fn entry<S: Simd>(&self, simd: S, plane: S::F8, axis: usize) -> S::F8 {
        let d = plane.sub(simd.splat8(self.near_offset[axis]));
        d.mul(simd.splat8(self.inv[axis][0])).min(d.mul(simd.splat8(self.inv[axis][1])))
    }

    #[inline(always)]
    fn exit<S: Simd>(&self, simd: S, plane: S::F8, axis: usize) -> S::F8 {
        let d = plane.sub(simd.splat8(self.far_offset[axis]));
        d.mul(simd.splat8(self.inv[axis][0])).max(d.mul(simd.splat8(self.inv[axis][1])))
    }

    #[inline(always)]
    fn node<S: Simd>(&self, simd: S, node: &WideNode) -> (S::F8, S::F8) {
        let [x, y, z] = self.near_side;
        let near = [simd.load8(node.side(0, x)), simd.load8(node.side(1, y)), simd.load8(node.side(2, z))];
        let (x, y, z) = (x ^ WideNode::UPPER, y ^ WideNode::UPPER, z ^ WideNode::UPPER);
        let far = [simd.load8(node.side(0, x)), simd.load8(node.side(1, y)), simd.load8(node.side(2, z))];
        self.intersect(simd, near, far)
    }

    /// Traverses the BVH and passes each ray's hit to `found`. Returns whether the rays stayed together.
    #[inline(always)]
    fn run<S: Simd, L: PacketLeaves, const ANY: bool>(
        &mut self,
        simd: S,
        tree: &Tree<'_, L>,
        rays: &[Ray],
        first: usize,
        mut found: impl FnMut(usize, Hit),
    ) -> bool {
        let mut stack = Stack::new();
        let mut child = ChildRef::node(0);
        let mut steps_left = MAX_STEPS;
        'search: loop {
            steps_left = steps_left.saturating_sub(1);
            if steps_left == 0 {
                stack.push(child.0, f32::NEG_INFINITY);
                break;
            }
            if child.is_leaf() {
                for block in tree.leaves.blocks(child) {
                    let tested = self.block::<S, L, ANY>(simd, tree.leaves, block);
                    steps_left = steps_left.saturating_sub(tested);
                }
                self.end = simd.load_packet(&self.rows.t).range()[1];
                if ANY && self.end < 0.0 {
                    break;
                }
            } else {
                let node = tree.node(child);
                let (near, far) = self.node(simd, node);
                let order = node.order[self.octant as usize & 7];
                let count = simd.push_ordered(near, far, node.child_words(), order, stack.room());
                stack.grow(count);
            }
            loop {
                let Some((word, near)) = stack.pop() else { break 'search };
                if near <= self.end {
                    child = ChildRef(word);
                    break;
                }
            }
        }
        let mut i = 0;
        while i < S::PACKET {
            let mut hit = self.rows.hit(i);
            if steps_left == 0
                && !(ANY && hit.is_hit())
                && let Some(ray) = SearchRay::new(simd, &rays[i], &tree.space)
            {
                let index = (first + i) as u32;
                if !ANY {
                    single::continue_closest(simd, tree, &ray, index, &mut stack.clone(), &mut hit);
                } else if single::continue_any(simd, tree, &ray, index, &mut stack.clone()) {
                    hit.primitive = 0;
                }
            }
            found(i, if hit.is_hit() { hit } else { Hit::MISS });
            i += 1;
        }
        steps_left > 0
    }

    /// Tests all rays against the triangles of a block that the packet may hit; returns their count.
    #[inline(always)]
    fn block<S: Simd, L: PacketLeaves, const ANY: bool>(
        &mut self,
        simd: S,
        leaves: &L,
        block: &Block,
    ) -> u32 {
        let [mut low, mut high] = [[simd.splat8(0.0); 3]; 2];
        let mut axis = 0;
        while axis < 3 {
            let [a, b, c] = [
                simd.load8(&block.corners[0][axis]),
                simd.load8(&block.corners[1][axis]),
                simd.load8(&block.corners[2][axis]),
            ];
            let (least, most) = (a.min(b).min(c), a.max(b).max(c));
            let down = self.near_side[axis] != 0;
            (low[axis], high[axis]) = if down { (most, least) } else { (least, most) };
            axis += 1;
        }
        let (near, far) = self.intersect(simd, low, high);
        let mut candidates = near.le(far);
        let tested = candidates.count_ones();
        while candidates != 0 {
            let lane = candidates.trailing_zeros() as usize % BLOCK;
            candidates &= candidates - 1;
            self.rows.triangle::<S, L, ANY>(simd, leaves, block, lane);
        }
        tested
    }
}

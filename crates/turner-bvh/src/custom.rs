//! BVH over the boxes of arbitrary primitives.

use std::cell::RefCell;
use std::ops::Range;

use crate::build::wide::{self, Source};
use crate::bvh::scale_of;
use crate::node::{ChildRef, WideNode};
use crate::simd::Simd;
use crate::traverse::{Leaves, MAX_COORDINATE, SearchRay, Space, Tree};
use crate::{Aabb, BuildError, BuildOptions, BuildStats, Hit, InstructionSet, Ray, search};

/// A BVH over boxes of any primitives: traversal yields ranges of primitives, and the caller intersects them.
///
/// ```
/// use turner_bvh::{Aabb, BoxBvh, BuildOptions, Ray};
///
/// // Ten flat squares across the z axis.
/// let z: Vec<f32> = (0..10).map(|i| 10.0 - i as f32).collect();
/// let boxes: Vec<Aabb> = z.iter().map(|&z| Aabb::new([-1.0, -1.0, z], [1.0, 1.0, z])).collect();
/// let bvh = BoxBvh::build(&boxes, &BuildOptions::default())?;
///
/// // In leaf order, each leaf is a slice.
/// let in_order: Vec<f32> = bvh.order().iter().map(|&i| z[i as usize]).collect();
/// let ray = Ray::new([0.0, 0.0, 3.5], [0.0, 0.0, 1.0]);
/// let t = bvh.closest(&ray, |range, t_max| {
///     in_order[range.start as usize..range.end as usize]
///         .iter()
///         .map(|z| (z - ray.origin[2]) / ray.direction[2])
///         .filter(|&t| t >= ray.t_min)
///         .fold(t_max, f32::min)
/// });
/// assert_eq!(t, 0.5);
/// # Ok::<(), turner_bvh::BuildError>(())
/// ```
#[derive(Clone, Debug)]
pub struct BoxBvh {
    pub(crate) nodes: Vec<WideNode>,
    pub(crate) order: Vec<u32>,
    pub(crate) dropped: Vec<u32>,
    bounds: Aabb,
    pub(crate) space: Space,
    stats: BuildStats,
    instruction_set: InstructionSet,
    /// Number of boxes given, including omitted ones.
    pub(crate) count: usize,
}

/// Rays of a batch traced at a time.
const CHUNK: usize = 256;

impl BoxBvh {
    /// Builds the BVH. Boxes that are not [valid](Aabb::is_valid) are omitted.
    pub fn build(boxes: &[Aabb], options: &BuildOptions<'_>) -> Result<BoxBvh, BuildError> {
        let scale = BoxBvh::scale(boxes);
        let tree = wide::build(&Source::Boxes { boxes, scale, width: 1 }, options)?;
        let dropped = if tree.stats.non_finite == 0 { Vec::new() } else { omitted(&tree.slots, boxes.len()) };
        let space = Space::of(scale, &tree.nodes);
        let mut bvh = BoxBvh {
            nodes: tree.nodes,
            order: tree.slots,
            dropped,
            bounds: Aabb::EMPTY,
            space,
            stats: tree.stats,
            instruction_set: options.instruction_set,
            count: boxes.len(),
        };
        bvh.measure(scale);
        Ok(bvh)
    }

    /// The scale of a BVH over these boxes.
    pub(crate) fn scale(boxes: &[Aabb]) -> f32 {
        let valid = boxes.iter().filter(|b| b.is_valid());
        scale_of(valid.flat_map(|b| b.min.into_iter().chain(b.max)).fold(0.0, |reach, x| reach.max(x.abs())))
    }

    /// Updates the bounds and the coordinate system from the root.
    pub(crate) fn measure(&mut self, scale: f32) {
        self.space = Space::of(scale, &self.nodes);
        let boxes = self.nodes.first().into_iter().flat_map(|root| (0..8).map(|i| root.bounds(i)));
        let all = boxes.fold(Aabb::EMPTY, Aabb::union);
        let unscale = self.space.unscale;
        self.bounds = Aabb::new(all.min.map(|x| x * unscale), all.max.map(|x| x * unscale));
    }

    /// For each position in leaf order, the index of its primitive. A caller that stores primitives in this order reads
    /// each leaf from consecutive memory.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// Indices of primitives that are not in the BVH because their boxes are not [valid](Aabb::is_valid).
    pub fn dropped(&self) -> &[u32] {
        &self.dropped
    }

    /// The bounds of all primitives in the BVH.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Size and quality of the BVH.
    pub fn stats(&self) -> &BuildStats {
        &self.stats
    }

    /// Memory in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.order[..]) + size_of_val(&self.dropped[..])
    }

    fn tree<'a, L>(&'a self, leaves: &'a L) -> Tree<'a, L> {
        Tree { nodes: &self.nodes, leaves, space: self.space, instruction_set: self.instruction_set }
    }

    fn all(&self) -> Range<u32> {
        0..self.order.len() as u32
    }

    /// Visits the leaves that the ray may hit at `t_min <= t <= t_max`, nearer boxes first, and returns the final
    /// `t_max`.
    ///
    /// `leaf` gets a range of positions in [`order`](Self::order) and the current `t_max`. It returns the new `t_max`:
    /// the minimum of the current one and its nearest hit. Larger values are ignored; NaN ends the traversal.
    ///
    /// No primitive is missed if the ray intersects its box, in exact arithmetic, at `t_min <= t <= t_max`. Primitives
    /// as near as the nearest so far are still visited, so that the caller can break ties. Rays for which box tests in
    /// single precision are meaningless (no direction, or an origin beyond 2^40 times the coordinates of the BVH) get
    /// all primitives in one range.
    #[inline]
    pub fn closest(&self, ray: &Ray, mut leaf: impl FnMut(Range<u32>, f32) -> f32) -> f32 {
        if !reaches(&self.space, ray) {
            let t = if ray.is_valid() && !self.order.is_empty() {
                leaf(self.all(), ray.t_max)
            } else {
                ray.t_max
            };
            return if t > ray.t_max { ray.t_max } else { t };
        }
        let leaves = Nearest {
            rays: std::slice::from_ref(ray),
            visit: RefCell::new(|_, range, t| leaf(range, t)),
            order: &self.order,
        };
        let hit = search::closest(self.tree(&leaves), ray);
        if hit.is_hit() { hit.u } else { ray.t_max }
    }

    /// Whether `leaf` returns true for any leaf that the ray may hit at `t_min <= t <= t_max`. Stops at the first.
    ///
    /// As with [`closest`](Self::closest), no primitive is missed if the ray intersects its box.
    #[inline]
    pub fn any(&self, ray: &Ray, mut leaf: impl FnMut(Range<u32>) -> bool) -> bool {
        if !reaches(&self.space, ray) {
            return ray.is_valid() && !self.order.is_empty() && leaf(self.all());
        }
        let leaves = Any { visit: RefCell::new(|_, range| leaf(range)), order: &self.order };
        search::any(self.tree(&leaves), ray)
    }

    /// [`closest`](Self::closest) for many rays. `leaf` also gets the index of the ray, in no particular order, and
    /// must store what it finds.
    #[inline]
    pub fn closest_batch(&self, rays: &[Ray], mut leaf: impl FnMut(usize, Range<u32>, f32) -> f32) {
        let mut hits = [Hit::MISS; CHUNK];
        for (chunk, rays) in rays.chunks(CHUNK).enumerate() {
            let first = chunk * CHUNK;
            let leaves = Nearest {
                rays,
                visit: RefCell::new(|i, range, t| leaf(first + i, range, t)),
                order: &self.order,
            };
            search::closest_batch(self.tree(&leaves), rays, &mut hits[..rays.len()]);
            for (i, ray) in rays.iter().enumerate().filter(|(_, ray)| !reaches(&self.space, ray)) {
                if ray.is_valid() && !self.order.is_empty() {
                    leaf(first + i, self.all(), ray.t_max);
                }
            }
        }
    }

    /// [`any`](Self::any) for many rays. `leaf` also gets the index of the ray.
    #[inline]
    pub fn any_batch(
        &self,
        rays: &[Ray],
        hits: &mut [bool],
        mut leaf: impl FnMut(usize, Range<u32>) -> bool,
    ) {
        assert_eq!(rays.len(), hits.len());
        {
            let leaves = Any { visit: RefCell::new(&mut leaf), order: &self.order };
            search::any_batch(self.tree(&leaves), rays, hits);
        }
        for (i, ray) in rays.iter().enumerate().filter(|(_, ray)| !reaches(&self.space, ray)) {
            hits[i] = ray.is_valid() && !self.order.is_empty() && leaf(i, self.all());
        }
    }
}

/// Whether traversal supports this ray and scales its t exactly.
#[inline(always)]
pub(crate) fn reaches(space: &Space, ray: &Ray) -> bool {
    let [x, y, z] = ray.origin.map(f32::abs);
    let [u, v, w] = ray.direction.map(f32::abs);
    let (far, longest) = (x.max(y).max(z), u.max(v).max(w));
    let scale = space.scale;
    // The scale is 1 unless the BVH is very large or small.
    let t_scale = longest * scale;
    far * scale <= MAX_COORDINATE
        && (1e-36..1e36).contains(&longest)
        && (1e-36..1e36).contains(&t_scale)
        && ray.is_valid()
}

/// The primitives that are in no leaf.
fn omitted(slots: &[u32], count: usize) -> Vec<u32> {
    let mut present = vec![false; count];
    for &id in slots {
        present[id as usize] = true;
    }
    (0..count as u32).filter(|&id| !present[id as usize]).collect()
}

/// Positions in a leaf.
#[inline(always)]
fn positions(leaf: ChildRef) -> Range<u32> {
    let first = leaf.first_block() as u32;
    first..first + leaf.blocks() as u32
}

/// Leaves for nearest hits. `visit` gets the ray index, the positions and t, and returns the new t, kept in `hit.u`.
pub(crate) struct Nearest<'a, F> {
    pub(crate) rays: &'a [Ray],
    pub(crate) visit: RefCell<F>,
    pub(crate) order: &'a [u32],
}

impl<F: FnMut(usize, Range<u32>, f32) -> f32> Leaves for Nearest<'_, F> {
    #[inline(always)]
    fn closest<S: Simd>(&self, _: S, leaf: ChildRef, ray: &SearchRay, ray_index: u32, hit: &mut Hit) {
        let index = ray_index as usize;
        let before = if hit.is_hit() { hit.u } else { self.rays[index].t_max };
        let t = (self.visit.borrow_mut())(index, positions(leaf), before);
        if t < before {
            // Exact: t_scale is a power of two.
            *hit = Hit { t: (t / ray.t_scale).min(hit.t), u: t, primitive: 0, ..*hit };
        } else if t.is_nan() {
            *hit = Hit { t: f32::NEG_INFINITY, u: t, primitive: 0, ..*hit };
        }
    }

    #[inline(always)]
    fn any<S: Simd>(&self, _: S, _: ChildRef, _: &SearchRay, _: u32) -> bool {
        false
    }

    #[inline(always)]
    fn address(&self, leaf: ChildRef) -> *const u8 {
        self.order.as_ptr().wrapping_add(leaf.first_block()).cast()
    }
}

/// Leaves for any hit. `visit` gets the ray index and the positions, and returns true to stop.
pub(crate) struct Any<'a, F> {
    pub(crate) visit: RefCell<F>,
    pub(crate) order: &'a [u32],
}

impl<F: FnMut(usize, Range<u32>) -> bool> Leaves for Any<'_, F> {
    #[inline(always)]
    fn closest<S: Simd>(&self, _: S, _: ChildRef, _: &SearchRay, _: u32, _: &mut Hit) {}

    #[inline(always)]
    fn any<S: Simd>(&self, _: S, leaf: ChildRef, _: &SearchRay, ray_index: u32) -> bool {
        (self.visit.borrow_mut())(ray_index as usize, positions(leaf))
    }

    #[inline(always)]
    fn address(&self, leaf: ChildRef) -> *const u8 {
        self.order.as_ptr().wrapping_add(leaf.first_block()).cast()
    }
}

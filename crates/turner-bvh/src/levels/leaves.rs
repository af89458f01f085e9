//! What a group's leaves hold, and how a ray meets it.

use super::group::{Group, Object};
use super::matrix::{Affine, between, inverse64, rounded, scaled};
use super::search::Visit;
use crate::motion::{MovingBlocks, clamped};
use crate::node::ChildRef;
use crate::simd::{Lanes, Simd, WithSimd, dispatch};
use crate::traverse::{self, Blocks, Leaves, SearchRay, Tree};
use crate::{Hit, Ray};

/// One instance, or a primitive of the group's own: a cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Record {
    /// The columns of the inverse, from the units of the group's tree to those of the object; then 0.
    pub(super) columns: [f32; 13],
    /// Its position among the objects; or [`OWN`](Self::OWN), or [`NOTHING`](Self::NOTHING).
    pub(super) object: u32,
    /// The first of the numbers that its hits get; of an own primitive the number.
    pub(super) id: u32,
    /// Where its transforms are, if it moves; if not, [`STILL`](Self::STILL).
    pub(super) motion: u32,
}

const _: () = assert!(size_of::<Record>() == 64);

impl Record {
    pub(super) const OWN: u32 = u32::MAX;
    pub(super) const NOTHING: u32 = u32::MAX - 1;
    pub(super) const STILL: u32 = u32::MAX;

    pub(super) const EMPTY: Record =
        Record { columns: [0.0; 13], object: Record::NOTHING, id: 0, motion: Record::STILL };

    pub(super) fn set_inverse(&mut self, inverse: &Affine) {
        self.columns = columns(inverse);
    }
}

fn columns(inverse: &Affine) -> [f32; 13] {
    let mut columns = [0.0; 13];
    for (row, values) in inverse.iter().enumerate() {
        for (column, &x) in values.iter().enumerate() {
            columns[3 * column + row] = x;
        }
    }
    columns
}

/// Three numbers from a place on; the fourth lane is not used.
#[inline(always)]
fn column<S: Simd>(simd: S, columns: &[f32; 13], at: usize) -> S::F4 {
    simd.load4(&[columns[at], columns[at + 1], columns[at + 2], columns[at + 3]])
}

/// The ray as the object sees it; t stays what it is.
#[inline(always)]
pub(super) fn into<S: Simd>(simd: S, columns: &[f32; 13], ray: &SearchRay, t_max: f32) -> Ray {
    let [c0, c1, c2, c3] = [
        column(simd, columns, 0),
        column(simd, columns, 3),
        column(simd, columns, 6),
        column(simd, columns, 9),
    ];
    let ([x, y, z], [u, v, w]) = (ray.origin, ray.direction);
    let (x, y, z) = (simd.splat4(x), simd.splat4(y), simd.splat4(z));
    let (u, v, w) = (simd.splat4(u), simd.splat4(v), simd.splat4(w));
    let mut origin = [0.0; 4];
    let mut direction = [0.0; 4];
    c0.mul(x).add(c1.mul(y)).add(c2.mul(z)).add(c3).store(&mut origin);
    c0.mul(u).add(c1.mul(v)).add(c2.mul(w)).store(&mut direction);
    Ray {
        origin: [origin[0], origin[1], origin[2]],
        direction: [direction[0], direction[1], direction[2]],
        t_min: ray.t_min,
        t_max,
        time: ray.time,
    }
}

/// The leaves of a group within a search.
#[derive(Clone, Copy)]
pub(super) struct GroupLeaves<'a, V> {
    pub(super) group: &'a Group,
    pub(super) visit: &'a V,
    /// What is added to the numbers of instances.
    pub(super) base: u32,
    /// In place of an instance's number for the group's own primitives.
    pub(super) own: u32,
    /// The caller's t per t of the group outside its tree.
    pub(super) outer: f32,
}

/// Leaves that end a search for the nearest hit at the first one: a search for any hit that goes from near to far. Where
/// leaves are whole trees that is worth more than it costs, as what is near is hit most often.
pub(super) struct FirstHit<'a, L>(pub(super) &'a L);

impl<L: Leaves> Leaves for FirstHit<'_, L> {
    #[inline(always)]
    fn closest<S: Simd>(&self, simd: S, leaf: ChildRef, ray: &SearchRay, ray_index: u32, hit: &mut Hit) {
        if self.0.any(simd, leaf, ray, ray_index) {
            *hit = Hit { t: f32::NEG_INFINITY, primitive: 0, ..*hit };
        }
    }

    #[inline(always)]
    fn any<S: Simd>(&self, simd: S, leaf: ChildRef, ray: &SearchRay, ray_index: u32) -> bool {
        self.0.any(simd, leaf, ray, ray_index)
    }

    #[inline(always)]
    fn address(&self, leaf: ChildRef) -> *const u8 {
        self.0.address(leaf)
    }
}

/// Whether `a` comes before `b`.
#[inline(always)]
pub(super) fn nearer(a: &Hit, b: &Hit) -> bool {
    a.t < b.t || (a.t == b.t && (a.instance, a.primitive) < (b.instance, b.primitive))
}

impl<'a, V: Visit> GroupLeaves<'a, V> {
    #[inline(always)]
    fn of(&self, leaf: ChildRef) -> &'a [Record] {
        let (first, count) = (leaf.first_block(), leaf.blocks());
        debug_assert!(first + count <= self.group.records.len());
        // SAFETY: builders make leaves of primitives that are there, and each has a record.
        unsafe { self.group.records.get_unchecked(first..first + count) }
    }

    /// The ray as an instance sees it; none where a moving one cannot be seen.
    #[inline(always)]
    pub(super) fn inside<S: Simd>(
        &self,
        simd: S,
        record: &Record,
        ray: &SearchRay,
        t_max: f32,
    ) -> Option<Ray> {
        if record.motion == Record::STILL {
            return Some(into(simd, &record.columns, ray, t_max));
        }
        let columns = self.moved(record, ray.time)?;
        Some(into(simd, &columns, ray, t_max))
    }

    /// The inverse at a time.
    #[inline(never)]
    fn moved(&self, record: &Record, time: f32) -> Option<[f32; 13]> {
        let [start, end] = &self.group.motions[record.motion as usize];
        at_time(start, end, time, self.group.space.scale)
    }

    /// A group within this one, without its own recursion in sight of the inliner.
    #[inline(always)]
    fn nested(&self, group: &'a Group, id: u32, outer: f32) -> GroupLeaves<'a, V> {
        let base = self.base.wrapping_add(id);
        GroupLeaves { group, visit: self.visit, base, own: base.wrapping_add(group.placed), outer }
    }

    /// Whether hits of a mesh count. `to_group` makes t of the mesh one of the group.
    #[inline(always)]
    fn accept(&self, to_group: f32, instance: u32) -> impl Fn(u32, &Hit) -> bool + '_ {
        let to_caller = to_group * self.outer;
        move |i, hit| self.visit.accept(i, &Hit { t: hit.t * to_caller, instance, ..*hit })
    }

    /// An own primitive; t is that of the tree.
    #[inline(always)]
    fn own_hit(&self, record: &Record, ray: &SearchRay, t_max: f32, ray_index: u32) -> Option<Hit> {
        let (unscale, to_caller) = (self.group.space.unscale, ray.t_scale * self.outer);
        let back = unscale / to_caller;
        let outside = Ray {
            origin: ray.origin.map(|x| x * unscale),
            direction: ray.direction.map(|x| x * back),
            t_min: ray.t_min * to_caller,
            t_max: t_max * to_caller,
            time: ray.time,
        };
        let [t, u, v] = self.visit.primitive(ray_index, &outside, self.own, record.id)?;
        let hit = Hit { t, u, v, primitive: record.id, instance: self.own };
        let within = outside.t_min <= t && t <= outside.t_max && t < f32::INFINITY;
        (within && self.visit.accept(ray_index, &hit)).then(|| Hit { t: t / to_caller, ..hit })
    }
}

/// The inverse of a moving transform at a time, in columns.
pub(super) fn at_time(start: &Affine, end: &Affine, time: f32, scale: f32) -> Option<[f32; 13]> {
    let matrix = scaled(&between(start, end, clamped(time)), f64::from(scale));
    Some(columns(&rounded(&inverse64(&matrix)?)?))
}

impl<V: Visit> Leaves for GroupLeaves<'_, V> {
    #[inline(always)]
    fn closest<S: Simd>(&self, simd: S, leaf: ChildRef, ray: &SearchRay, ray_index: u32, hit: &mut Hit) {
        for record in self.of(leaf) {
            let Some(object) = self.group.objects.get(record.object as usize) else {
                if record.object == Record::OWN
                    && let Some(found) = self.own_hit(record, ray, hit.t, ray_index)
                    && nearer(&found, hit)
                {
                    *hit = found;
                }
                continue;
            };
            let Some(inside) = self.inside(simd, record, ray, hit.t) else { continue };
            let instance = self.base.wrapping_add(record.id);
            let found = match object {
                Object::Mesh(mesh) => {
                    let Some(search) = SearchRay::new(simd, &inside, &mesh.space) else { continue };
                    let accept = self.accept(search.t_scale * ray.t_scale, instance);
                    let leaves = Blocks { blocks: &mesh.blocks, filter: accept, filtered: true };
                    let tree = Tree { nodes: &mesh.nodes, leaves: &leaves, space: mesh.space };
                    let found = traverse::closest(simd, &tree, &search, ray_index);
                    Hit { t: found.t * search.t_scale, instance, ..found }
                }
                Object::Moving(mesh) => {
                    let Some(search) = SearchRay::new(simd, &inside, &mesh.space) else { continue };
                    let accept = self.accept(search.t_scale * ray.t_scale, instance);
                    let leaves = MovingBlocks { blocks: &mesh.blocks, filter: accept };
                    let tree = Tree { nodes: &mesh.nodes, leaves: &leaves, space: mesh.space };
                    let found = traverse::closest(simd, &tree, &search, ray_index);
                    Hit { t: found.t * search.t_scale, instance, ..found }
                }
                Object::Group(group) => {
                    let leaves = self.nested(group, record.id, ray.t_scale * self.outer);
                    dispatch(Closest { leaves, ray: &inside, ray_index })
                }
            };
            if found.is_hit() && nearer(&found, hit) {
                *hit = found;
            }
        }
    }

    #[inline(always)]
    fn any<S: Simd>(&self, simd: S, leaf: ChildRef, ray: &SearchRay, ray_index: u32) -> bool {
        for record in self.of(leaf) {
            let Some(object) = self.group.objects.get(record.object as usize) else {
                if record.object == Record::OWN && self.own_hit(record, ray, ray.t_max, ray_index).is_some() {
                    return true;
                }
                continue;
            };
            let Some(inside) = self.inside(simd, record, ray, ray.t_max) else { continue };
            let instance = self.base.wrapping_add(record.id);
            let found = match object {
                Object::Mesh(mesh) => {
                    let Some(search) = SearchRay::new(simd, &inside, &mesh.space) else { continue };
                    let accept = self.accept(search.t_scale * ray.t_scale, instance);
                    let leaves = Blocks { blocks: &mesh.blocks, filter: accept, filtered: true };
                    let tree = Tree { nodes: &mesh.nodes, leaves: &leaves, space: mesh.space };
                    traverse::any(simd, &tree, &search, ray_index)
                }
                Object::Moving(mesh) => {
                    let Some(search) = SearchRay::new(simd, &inside, &mesh.space) else { continue };
                    let accept = self.accept(search.t_scale * ray.t_scale, instance);
                    let leaves = MovingBlocks { blocks: &mesh.blocks, filter: accept };
                    let tree = Tree { nodes: &mesh.nodes, leaves: &leaves, space: mesh.space };
                    traverse::any(simd, &tree, &search, ray_index)
                }
                Object::Group(group) => {
                    let leaves = self.nested(group, record.id, ray.t_scale * self.outer);
                    dispatch(Any { leaves, ray: &inside, ray_index })
                }
            };
            if found {
                return true;
            }
        }
        false
    }

    #[inline(always)]
    fn address(&self, leaf: ChildRef) -> *const u8 {
        self.group.records.as_ptr().wrapping_add(leaf.first_block()).cast()
    }
}

/// A search in a group within a group. It recurses: once for each level.
struct Closest<'a, V> {
    leaves: GroupLeaves<'a, V>,
    ray: &'a Ray,
    ray_index: u32,
}

impl<V: Visit> WithSimd for Closest<'_, V> {
    type Output = Hit;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Hit {
        let group = self.leaves.group;
        let Some(ray) = SearchRay::new(simd, self.ray, &group.space) else { return Hit::MISS };
        let tree = Tree { nodes: &group.nodes, leaves: &self.leaves, space: group.space };
        ray.finish(traverse::closest(simd, &tree, &ray, self.ray_index))
    }
}

/// The same for any hit.
struct Any<'a, V> {
    leaves: GroupLeaves<'a, V>,
    ray: &'a Ray,
    ray_index: u32,
}

impl<V: Visit> WithSimd for Any<'_, V> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> bool {
        let group = self.leaves.group;
        let Some(ray) = SearchRay::new(simd, self.ray, &group.space) else { return false };
        let leaves = FirstHit(&self.leaves);
        let tree = Tree { nodes: &group.nodes, leaves: &leaves, space: group.space };
        traverse::closest(simd, &tree, &ray, self.ray_index).is_hit()
    }
}

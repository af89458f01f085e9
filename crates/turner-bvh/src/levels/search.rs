//! What a group is asked.

use super::group::Group;
use super::leaves::{FirstHit, GroupLeaves};
use crate::simd::{Simd, WithSimd, dispatch};
use crate::traverse::{self, SearchRay, Tree};
use crate::{Hit, Ray, search};

/// What a caller has to say while a ray is searched: which hits count, and how a group's own primitives are met.
/// `()` has nothing to say.
pub trait Visit {
    /// Whether a hit counts. It is as [`Group::intersect`] would give it; `ray` is the number of the ray in a batch, 0 for a
    /// single one. Called in any order, for any hits until the nearest that counts.
    #[inline(always)]
    fn accept(&self, ray: u32, hit: &Hit) -> bool {
        let _ = (ray, hit);
        true
    }

    /// The nearest hit at `t_min <= t <= t_max` of a primitive that the group has a box for: t, u and v. `within` is the
    /// ray in the coordinates of that group, `instance` what [`Hit::instance`] will be. Every point where it reports
    /// a hit has to lie in the primitive's box.
    #[inline(always)]
    fn primitive(&self, ray: u32, within: &Ray, instance: u32, primitive: u32) -> Option<[f32; 3]> {
        let _ = (ray, within, instance, primitive);
        None
    }
}

impl Visit for () {}

impl<V: Visit> Visit for &V {
    #[inline(always)]
    fn accept(&self, ray: u32, hit: &Hit) -> bool {
        (**self).accept(ray, hit)
    }

    #[inline(always)]
    fn primitive(&self, ray: u32, within: &Ray, instance: u32, primitive: u32) -> Option<[f32; 3]> {
        (**self).primitive(ray, within, instance, primitive)
    }
}

impl Group {
    #[inline(always)]
    fn leaves<'a, V: Visit>(&'a self, visit: &'a V) -> GroupLeaves<'a, V> {
        GroupLeaves { group: self, visit, base: 0, own: Hit::NONE, outer: 1.0 }
    }

    #[inline(always)]
    fn tree<'a, L>(&'a self, leaves: &'a L) -> Tree<'a, L> {
        Tree { nodes: &self.nodes, leaves, space: self.space }
    }

    /// The nearest hit. Own primitives of groups are not met: see [`intersect_with`](Self::intersect_with).
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        self.intersect_with(ray, &())
    }

    /// Whether anything is hit.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.occluded_with(ray, &())
    }

    /// The nearest hits of many rays; [`Hit::MISS`] where there is none.
    pub fn intersect_batch(&self, rays: &[Ray], hits: &mut [Hit]) {
        self.intersect_batch_with(rays, hits, &());
    }

    /// Whether each of many rays hits anything.
    pub fn occluded_batch(&self, rays: &[Ray], hits: &mut [bool]) {
        self.occluded_batch_with(rays, hits, &());
    }

    /// The nearest hit that counts, own primitives included.
    #[inline]
    pub fn intersect_with<V: Visit>(&self, ray: &Ray, visit: &V) -> Option<Hit> {
        search::closest(self.tree(&self.leaves(visit)), ray).some()
    }

    /// Whether there is a hit that counts, own primitives included.
    #[inline]
    pub fn occluded_with<V: Visit>(&self, ray: &Ray, visit: &V) -> bool {
        let leaves = self.leaves(visit);
        search::closest(self.tree(&FirstHit(&leaves)), ray).is_hit()
    }

    /// The nearest hits that count, own primitives included.
    ///
    /// One ray after the other. Tried: four at a time in turn, through the group's tree and the meshes' as in a single tree.
    /// In 1,000,000 instances of a small mesh that was 0.75 (camera) to 0.83 (diffuse) times as fast.
    #[inline]
    pub fn intersect_batch_with<V: Visit>(&self, rays: &[Ray], hits: &mut [Hit], visit: &V) {
        assert_eq!(rays.len(), hits.len());
        dispatch(Batch { leaves: self.leaves(visit), rays, found: Found::Hits(hits) });
    }

    /// Whether there are hits that count, own primitives included.
    #[inline]
    pub fn occluded_batch_with<V: Visit>(&self, rays: &[Ray], hits: &mut [bool], visit: &V) {
        assert_eq!(rays.len(), hits.len());
        dispatch(Batch { leaves: self.leaves(visit), rays, found: Found::Any(hits) });
    }
}

/// Where the answers of a batch go.
enum Found<'a> {
    Hits(&'a mut [Hit]),
    Any(&'a mut [bool]),
}

struct Batch<'a, V> {
    leaves: GroupLeaves<'a, V>,
    rays: &'a [Ray],
    found: Found<'a>,
}

impl<V: Visit> WithSimd for Batch<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let group = self.leaves.group;
        match self.found {
            Found::Hits(hits) => {
                let tree = group.tree(&self.leaves);
                for (i, (ray, hit)) in self.rays.iter().zip(hits).enumerate() {
                    *hit = match SearchRay::new(simd, ray, &group.space) {
                        Some(ray) => ray.finish(traverse::closest(simd, &tree, &ray, i as u32)),
                        None => Hit::MISS,
                    };
                }
            }
            Found::Any(hits) => {
                let leaves = FirstHit(&self.leaves);
                let tree = group.tree(&leaves);
                for (i, (ray, hit)) in self.rays.iter().zip(hits).enumerate() {
                    *hit = match SearchRay::new(simd, ray, &group.space) {
                        Some(ray) => traverse::closest(simd, &tree, &ray, i as u32).is_hit(),
                        None => false,
                    };
                }
            }
        }
    }
}

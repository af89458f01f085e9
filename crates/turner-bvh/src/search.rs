//! Entry points of traversal: dispatch to the instruction set of the BVH.

use crate::simd::{Simd, WithSimd, dispatch};
use crate::traverse::{self, Leaves, PacketLeaves, SearchRay, Tree};
use crate::{Hit, Ray};

/// The nearest hit, in the caller's units.
#[inline(always)]
pub(crate) fn closest<L: Leaves>(tree: Tree<'_, L>, ray: &Ray) -> Hit {
    struct Work<'a, L>(Tree<'a, L>, &'a Ray);
    impl<L: Leaves> WithSimd for Work<'_, L> {
        type Output = Hit;
        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> Hit {
            let Some(ray) = SearchRay::new(simd, self.1, &self.0.space) else { return Hit::MISS };
            ray.finish(traverse::closest(simd, &self.0, &ray, 0))
        }
    }
    dispatch(tree.instruction_set, Work(tree, ray))
}

/// Whether there is any hit.
#[inline(always)]
pub(crate) fn any<L: Leaves>(tree: Tree<'_, L>, ray: &Ray) -> bool {
    struct Work<'a, L>(Tree<'a, L>, &'a Ray);
    impl<L: Leaves> WithSimd for Work<'_, L> {
        type Output = bool;
        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> bool {
            let Some(ray) = SearchRay::new(simd, self.1, &self.0.space) else { return false };
            traverse::any(simd, &self.0, &ray, 0)
        }
    }
    dispatch(tree.instruction_set, Work(tree, ray))
}

/// The nearest hit of each ray.
#[inline(always)]
pub(crate) fn closest_batch<L: Leaves>(tree: Tree<'_, L>, rays: &[Ray], hits: &mut [Hit]) {
    struct Work<'a, L>(Tree<'a, L>, &'a [Ray], &'a mut [Hit]);
    impl<L: Leaves> WithSimd for Work<'_, L> {
        type Output = ();
        #[inline(always)]
        fn run<S: Simd>(self, simd: S) {
            traverse::closest_batch(simd, &self.0, self.1, 0, self.2);
        }
    }
    assert_eq!(rays.len(), hits.len());
    dispatch(tree.instruction_set, Work(tree, rays, hits));
}

/// Whether each ray hits anything.
#[inline(always)]
pub(crate) fn any_batch<L: Leaves>(tree: Tree<'_, L>, rays: &[Ray], hits: &mut [bool]) {
    struct Work<'a, L>(Tree<'a, L>, &'a [Ray], &'a mut [bool]);
    impl<L: Leaves> WithSimd for Work<'_, L> {
        type Output = ();
        #[inline(always)]
        fn run<S: Simd>(self, simd: S) {
            traverse::any_batch(simd, &self.0, self.1, 0, self.2);
        }
    }
    assert_eq!(rays.len(), hits.len());
    dispatch(tree.instruction_set, Work(tree, rays, hits));
}

/// The nearest hit of each ray, among triangles.
#[inline(always)]
pub(crate) fn closest_triangles<L: PacketLeaves>(tree: Tree<'_, L>, rays: &[Ray], hits: &mut [Hit]) {
    struct Work<'a, L>(Tree<'a, L>, &'a [Ray], &'a mut [Hit]);
    impl<L: PacketLeaves> WithSimd for Work<'_, L> {
        type Output = ();
        #[inline(always)]
        fn run<S: Simd>(self, simd: S) {
            traverse::closest_triangles(simd, &self.0, self.1, self.2);
        }
    }
    assert_eq!(rays.len(), hits.len());
    dispatch(tree.instruction_set, Work(tree, rays, hits));
}

/// Whether each ray hits any triangle.
#[inline(always)]
pub(crate) fn any_triangles<L: PacketLeaves>(tree: Tree<'_, L>, rays: &[Ray], hits: &mut [bool]) {
    struct Work<'a, L>(Tree<'a, L>, &'a [Ray], &'a mut [bool]);
    impl<L: PacketLeaves> WithSimd for Work<'_, L> {
        type Output = ();
        #[inline(always)]
        fn run<S: Simd>(self, simd: S) {
            traverse::any_triangles(simd, &self.0, self.1, self.2);
        }
    }
    assert_eq!(rays.len(), hits.len());
    dispatch(tree.instruction_set, Work(tree, rays, hits));
}

#[cfg(test)]
/// Interleaved traversal, even for small BVHs.
#[inline(always)]
pub(crate) fn interleaved<L: Leaves>(tree: Tree<'_, L>, rays: &[Ray], hits: &mut [Hit]) {
    struct Work<'a, L>(Tree<'a, L>, &'a [Ray], &'a mut [Hit]);
    impl<L: Leaves> WithSimd for Work<'_, L> {
        type Output = ();
        #[inline(always)]
        fn run<S: Simd>(self, simd: S) {
            traverse::closest_interleaved(simd, &self.0, self.1, 0, self.2);
        }
    }
    assert_eq!(rays.len(), hits.len());
    dispatch(tree.instruction_set, Work(tree, rays, hits));
}

#[cfg(test)]
/// Interleaved any-hit traversal, even for small BVHs.
#[inline(always)]
pub(crate) fn any_interleaved<L: Leaves>(tree: Tree<'_, L>, rays: &[Ray], hits: &mut [bool]) {
    struct Work<'a, L>(Tree<'a, L>, &'a [Ray], &'a mut [bool]);
    impl<L: Leaves> WithSimd for Work<'_, L> {
        type Output = ();
        #[inline(always)]
        fn run<S: Simd>(self, simd: S) {
            traverse::any_interleaved(simd, &self.0, self.1, 0, self.2);
        }
    }
    assert_eq!(rays.len(), hits.len());
    dispatch(tree.instruction_set, Work(tree, rays, hits));
}

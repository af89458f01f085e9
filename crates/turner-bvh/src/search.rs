//! The searches, in any tree, with the instructions of the current kernel.

use crate::simd::{Simd, WithSimd, dispatch};
use crate::traverse::{self, Leaves, PacketLeaves, SearchRay, Tree};
use crate::{Hit, Ray};

/// Bytes of nodes from which rays of a batch are searched for in turns: trees of about 300,000 triangles. What is
/// smaller stays in nearby caches, there is little to wait for, and one ray after the other is faster: 1.0 to 1.15 times with
/// 66,000 triangles of architecture; with a scan of 1.3 million, turns are 1.25 times as fast.
static INTERLEAVE_FROM: std::sync::LazyLock<usize> = std::sync::LazyLock::new(|| std::env::var("IL").map_or(2 << 20, |s| s.parse().unwrap()));

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
    dispatch(Work(tree, ray))
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
    dispatch(Work(tree, ray))
}

/// The nearest hit of each ray.
#[inline(always)]
pub(crate) fn closest_batch<L: Leaves>(tree: Tree<'_, L>, rays: &[Ray], hits: &mut [Hit]) {
    struct Work<'a, L>(Tree<'a, L>, &'a [Ray], &'a mut [Hit]);
    impl<L: Leaves> WithSimd for Work<'_, L> {
        type Output = ();
        #[inline(always)]
        fn run<S: Simd>(self, simd: S) {
            if size_of_val(self.0.nodes) >= *INTERLEAVE_FROM {
                traverse::closest_batch(simd, &self.0, self.1, self.2);
            } else {
                traverse::closest_each(simd, &self.0, self.1, self.2);
            }
        }
    }
    assert_eq!(rays.len(), hits.len());
    dispatch(Work(tree, rays, hits));
}

/// Whether there is any hit, for each ray.
#[inline(always)]
pub(crate) fn any_batch<L: Leaves>(tree: Tree<'_, L>, rays: &[Ray], hits: &mut [bool]) {
    struct Work<'a, L>(Tree<'a, L>, &'a [Ray], &'a mut [bool]);
    impl<L: Leaves> WithSimd for Work<'_, L> {
        type Output = ();
        #[inline(always)]
        fn run<S: Simd>(self, simd: S) {
            if size_of_val(self.0.nodes) >= *INTERLEAVE_FROM {
                traverse::any_batch(simd, &self.0, self.1, self.2);
            } else {
                traverse::any_each(simd, &self.0, self.1, self.2);
            }
        }
    }
    assert_eq!(rays.len(), hits.len());
    dispatch(Work(tree, rays, hits));
}

/// The nearest hit of each ray, among triangles.
#[inline(always)]
pub(crate) fn closest_triangles<L: PacketLeaves>(tree: Tree<'_, L>, rays: &[Ray], hits: &mut [Hit]) {
    struct Work<'a, L>(Tree<'a, L>, &'a [Ray], &'a mut [Hit]);
    impl<L: PacketLeaves> WithSimd for Work<'_, L> {
        type Output = ();
        #[inline(always)]
        fn run<S: Simd>(self, simd: S) {
            if traverse::are_few::<S, L>(&self.0) {
                traverse::closest_few(simd, &self.0, self.1, self.2);
            } else if size_of_val(self.0.nodes) >= *INTERLEAVE_FROM {
                traverse::closest_batch(simd, &self.0, self.1, self.2);
            } else {
                traverse::closest_each(simd, &self.0, self.1, self.2);
            }
        }
    }
    assert_eq!(rays.len(), hits.len());
    dispatch(Work(tree, rays, hits));
}

/// Whether there is any hit, for each ray, among triangles.
#[inline(always)]
pub(crate) fn any_triangles<L: PacketLeaves>(tree: Tree<'_, L>, rays: &[Ray], hits: &mut [bool]) {
    struct Work<'a, L>(Tree<'a, L>, &'a [Ray], &'a mut [bool]);
    impl<L: PacketLeaves> WithSimd for Work<'_, L> {
        type Output = ();
        #[inline(always)]
        fn run<S: Simd>(self, simd: S) {
            if traverse::are_few::<S, L>(&self.0) {
                traverse::any_few(simd, &self.0, self.1, self.2);
            } else if size_of_val(self.0.nodes) >= *INTERLEAVE_FROM {
                traverse::any_batch(simd, &self.0, self.1, self.2);
            } else {
                traverse::any_each(simd, &self.0, self.1, self.2);
            }
        }
    }
    assert_eq!(rays.len(), hits.len());
    dispatch(Work(tree, rays, hits));
}

/// The nearest hit of each ray, in packets.
#[inline(always)]
pub(crate) fn closest_packets<L: PacketLeaves>(tree: Tree<'_, L>, rays: &[Ray], hits: &mut [Hit]) {
    struct Work<'a, L>(Tree<'a, L>, &'a [Ray], &'a mut [Hit]);
    impl<L: PacketLeaves> WithSimd for Work<'_, L> {
        type Output = ();
        #[inline(always)]
        fn run<S: Simd>(self, simd: S) {
            traverse::closest_packets(simd, &self.0, self.1, self.2);
        }
    }
    assert_eq!(rays.len(), hits.len());
    dispatch(Work(tree, rays, hits));
}

/// Whether there is any hit, for each ray, in packets.
#[inline(always)]
pub(crate) fn any_packets<L: PacketLeaves>(tree: Tree<'_, L>, rays: &[Ray], hits: &mut [bool]) {
    struct Work<'a, L>(Tree<'a, L>, &'a [Ray], &'a mut [bool]);
    impl<L: PacketLeaves> WithSimd for Work<'_, L> {
        type Output = ();
        #[inline(always)]
        fn run<S: Simd>(self, simd: S) {
            traverse::any_packets(simd, &self.0, self.1, self.2);
        }
    }
    assert_eq!(rays.len(), hits.len());
    dispatch(Work(tree, rays, hits));
}

/// Rays in turns, however small the tree.
#[cfg(test)]
pub(crate) fn interleaved<L: Leaves>(tree: Tree<'_, L>, rays: &[Ray], hits: &mut [Hit]) {
    struct Work<'a, L>(Tree<'a, L>, &'a [Ray], &'a mut [Hit]);
    impl<L: Leaves> WithSimd for Work<'_, L> {
        type Output = ();
        #[inline(always)]
        fn run<S: Simd>(self, simd: S) {
            traverse::closest_batch(simd, &self.0, self.1, self.2);
        }
    }
    dispatch(Work(tree, rays, hits));
}

/// The same for any hit.
#[cfg(test)]
pub(crate) fn any_interleaved<L: Leaves>(tree: Tree<'_, L>, rays: &[Ray], hits: &mut [bool]) {
    struct Work<'a, L>(Tree<'a, L>, &'a [Ray], &'a mut [bool]);
    impl<L: Leaves> WithSimd for Work<'_, L> {
        type Output = ();
        #[inline(always)]
        fn run<S: Simd>(self, simd: S) {
            traverse::any_batch(simd, &self.0, self.1, self.2);
        }
    }
    dispatch(Work(tree, rays, hits));
}

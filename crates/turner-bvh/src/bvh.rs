//! The tree over triangles.

use crate::build::wide::{self, NO_PRIMITIVE, Source, WideTree};
use crate::node::WideNode;
use crate::simd::{Simd, WithSimd, dispatch};
use crate::traverse::{self, Blocks, FARTHEST, SearchRay, Space, Tree};
use crate::triangle::{BLOCK, Block};
use crate::{BuildError, BuildOptions, BuildStats, Hit, Ray};

/// Triangles as a mesh has them: corners by number.
#[derive(Clone, Copy, Debug, Default)]
pub struct Triangles<'a> {
    /// Positions of the vertices.
    pub positions: &'a [[f32; 3]],
    /// For each triangle the numbers of its corners.
    pub triangles: &'a [[u32; 3]],
}

/// A tree over triangles.
#[derive(Clone, Debug)]
pub struct Bvh {
    nodes: Vec<WideNode>,
    blocks: Vec<Block>,
    space: Space,
    stats: BuildStats,
}

impl Bvh {
    /// Builds the tree.
    pub fn build(mesh: &Triangles<'_>, options: &BuildOptions<'_>) -> Result<Bvh, BuildError> {
        let (positions, triangles) = (mesh.positions, mesh.triangles);
        let scale = scale(positions);
        let tree = wide::build(&Source::Triangles { positions, triangles, scale }, options)?;
        let WideTree { nodes, slots, mut stats } = tree;
        let blocks: Vec<Block> = slots
            .chunks_exact(BLOCK)
            .map(|ids| {
                let mut block = Block::EMPTY;
                for (lane, &id) in ids.iter().enumerate().filter(|(_, id)| **id != NO_PRIMITIVE) {
                    let corners = triangles[id as usize].map(|i| positions[i as usize].map(|x| x * scale));
                    block.set(lane, id, corners);
                }
                block
            })
            .collect();
        stats.bytes = size_of_val(&nodes[..]) + size_of_val(&blocks[..]);
        let reach = nodes.first().map_or(0.0, |root| {
            (0..8)
                .map(|i| root.bounds(i))
                .filter(|b| b.is_valid())
                .flat_map(|b| b.min.into_iter().chain(b.max))
                .fold(0.0_f32, |reach, x| reach.max(x.abs()))
        });
        Ok(Bvh { nodes, blocks, space: Space { scale, unscale: 1.0 / scale, reach }, stats })
    }

    /// The size of the tree.
    pub fn stats(&self) -> &BuildStats {
        &self.stats
    }

    fn tree<'a, F>(&'a self, leaves: &'a Blocks<'a, F>) -> Tree<'a, Blocks<'a, F>> {
        Tree { nodes: &self.nodes, leaves, space: self.space }
    }

    fn leaves<F: Fn(u32, &Hit) -> bool>(&self, filter: F) -> Blocks<'_, F> {
        Blocks { blocks: &self.blocks, filter }
    }

    /// The nearest hit.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        self.intersect_filtered(ray, |_| true)
    }

    /// The nearest of the hits that `filter` takes. It is asked about hits in any order, not only about the nearest.
    pub fn intersect_filtered(&self, ray: &Ray, filter: impl Fn(&Hit) -> bool) -> Option<Hit> {
        struct Work<'a, F>(Tree<'a, Blocks<'a, F>>, &'a Ray);
        impl<F: Fn(u32, &Hit) -> bool> WithSimd for Work<'_, F> {
            type Output = Option<Hit>;
            #[inline(always)]
            fn run<S: Simd>(self, simd: S) -> Option<Hit> {
                let ray = SearchRay::new(simd, self.1, &self.0.space)?;
                ray.finish(traverse::closest(simd, &self.0, &ray, 0)).some()
            }
        }
        dispatch(Work(self.tree(&self.leaves(|_, hit: &Hit| filter(hit))), ray))
    }

    /// Whether anything is hit.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.occluded_filtered(ray, |_| true)
    }

    /// Whether there is a hit that `filter` takes.
    pub fn occluded_filtered(&self, ray: &Ray, filter: impl Fn(&Hit) -> bool) -> bool {
        struct Work<'a, F>(Tree<'a, Blocks<'a, F>>, &'a Ray);
        impl<F: Fn(u32, &Hit) -> bool> WithSimd for Work<'_, F> {
            type Output = bool;
            #[inline(always)]
            fn run<S: Simd>(self, simd: S) -> bool {
                SearchRay::new(simd, self.1, &self.0.space)
                    .is_some_and(|ray| traverse::any(simd, &self.0, &ray, 0))
            }
        }
        dispatch(Work(self.tree(&self.leaves(|_, hit: &Hit| filter(hit))), ray))
    }

    /// The nearest hits of many rays.
    pub fn intersect_batch(&self, rays: &[Ray], hits: &mut [Hit]) {
        self.intersect_batch_filtered(rays, hits, |_, _| true);
    }

    /// The nearest hits of many rays of those that `filter` takes; it is told the number of the ray.
    pub fn intersect_batch_filtered(
        &self,
        rays: &[Ray],
        hits: &mut [Hit],
        filter: impl Fn(u32, &Hit) -> bool,
    ) {
        struct Work<'a, F>(Tree<'a, Blocks<'a, F>>, &'a [Ray], &'a mut [Hit]);
        impl<F: Fn(u32, &Hit) -> bool> WithSimd for Work<'_, F> {
            type Output = ();
            #[inline(always)]
            fn run<S: Simd>(self, simd: S) {
                traverse::closest_batch(simd, &self.0, self.1, self.2);
            }
        }
        assert_eq!(rays.len(), hits.len());
        dispatch(Work(self.tree(&self.leaves(filter)), rays, hits))
    }

    /// Whether each of many rays hits anything.
    pub fn occluded_batch(&self, rays: &[Ray], hits: &mut [bool]) {
        self.occluded_batch_filtered(rays, hits, |_, _| true);
    }

    /// Whether each of many rays has a hit that `filter` takes; it is told the number of the ray.
    pub fn occluded_batch_filtered(
        &self,
        rays: &[Ray],
        hits: &mut [bool],
        filter: impl Fn(u32, &Hit) -> bool,
    ) {
        struct Work<'a, F>(Tree<'a, Blocks<'a, F>>, &'a [Ray], &'a mut [bool]);
        impl<F: Fn(u32, &Hit) -> bool> WithSimd for Work<'_, F> {
            type Output = ();
            #[inline(always)]
            fn run<S: Simd>(self, simd: S) {
                traverse::any_batch(simd, &self.0, self.1, self.2);
            }
        }
        assert_eq!(rays.len(), hits.len());
        dispatch(Work(self.tree(&self.leaves(filter)), rays, hits))
    }
}

/// The power of two that brings all positions within reach: 1 for ordinary sizes.
fn scale(positions: &[[f32; 3]]) -> f32 {
    let reach = positions.iter().flatten().map(|x| x.abs()).filter(|x| x.is_finite()).fold(0.0, f32::max);
    if (1.0 / FARTHEST..=FARTHEST).contains(&reach) || reach < f32::MIN_POSITIVE {
        return 1.0;
    }
    // Up to 1 from below; down to FARTHEST from above.
    let exponent = (reach.to_bits() >> 23) as i32 - 127;
    let target = if exponent > 0 { 39 } else { 0 };
    f32::from_bits(((target - exponent).clamp(-126, 127) + 127) as u32 * (1 << 23))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::{SceneKind, rays};
    use crate::oracle;

    #[test]
    fn scenes_equal_brute_force() {
        for kind in [SceneKind::Cornell, SceneKind::Architecture, SceneKind::Scan] {
            let scene = kind.generate(30_000);
            let mesh = &scene.meshes[0];
            let triangles = Triangles { positions: &mesh.positions, triangles: &mesh.triangles };
            let bvh = Bvh::build(&triangles, &BuildOptions::default()).unwrap();
            let all: Vec<_> = (0..mesh.triangles.len()).map(|i| (i as u32, mesh.triangle(i))).collect();
            let primary = rays::primary(&scene.camera, 16);
            for ray in &primary {
                let expected = oracle::closest(&all, ray, &bvh.space);
                let found = bvh.intersect(ray).unwrap_or(Hit::MISS);
                assert_eq!(expected, found, "{kind:?} {ray:?}");
            }
        }
    }
}

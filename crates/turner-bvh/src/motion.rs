//! The tree over triangles that move.
//!
//! Corners move in straight lines from where they are at time 0 to where they are at time 1. A box holds both places of all
//! its corners, and so every place between.

use crate::build::wide::{self, NO_PRIMITIVE, Source, WideTree};
use crate::bvh::scale_of;
use crate::node::{ChildRef, WideNode};
use crate::refit::{finite, left_out, refit};
use crate::simd::{Lanes, Simd};
use crate::traverse::{Leaves, SearchRay, Space, Tree};
use crate::triangle::{BLOCK, Block};
use crate::{Aabb, BuildError, BuildOptions, BuildStats, Hit, Ray, RefitError, search};

/// Triangles as a mesh has them, with two places for each vertex.
#[derive(Clone, Copy, Debug, Default)]
pub struct MovingTriangles<'a> {
    /// Positions of the vertices at time 0.
    pub start: &'a [[f32; 3]],
    /// Positions of the same vertices at time 1.
    pub end: &'a [[f32; 3]],
    /// For each triangle the numbers of its corners.
    pub triangles: &'a [[u32; 3]],
}

/// A tree over triangles whose corners move in straight lines. A ray meets them where they are at its
/// [`time`](Ray::time), which is taken as 0 or 1 when it lies outside (and 0 when it is NaN).
#[derive(Clone, Debug)]
pub struct MovingBvh {
    pub(crate) nodes: Vec<WideNode>,
    pub(crate) blocks: Vec<MovingBlock>,
    pub(crate) space: Space,
    stats: BuildStats,
    count: usize,
}

/// Eight triangles at time 0, and the corners at time 1.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct MovingBlock {
    start: Block,
    end: [[[f32; BLOCK]; 3]; 3],
}

/// A time within the motion.
#[inline(always)]
pub(crate) fn clamped(time: f32) -> f32 {
    // NaN is not above 0.
    if time > 0.0 { if time < 1.0 { time } else { 1.0 } } else { 0.0 }
}

impl MovingBlock {
    /// Where the triangles are. `a * (1 - time) + b * time`, each operation rounded: at times 0 and 1 exactly the
    /// given places, and between off by 1.25 `f32::EPSILON` of the larger coordinate at most, which padded boxes
    /// have room for.
    #[inline(always)]
    fn at<S: Simd>(&self, simd: S, time: f32) -> Block {
        let (late, early) = (simd.splat8(time), simd.splat8(1.0 - time));
        let mut block = Block { corners: [[[0.0; BLOCK]; 3]; 3], ids: self.start.ids };
        let mut corner = 0;
        while corner < 3 {
            let mut axis = 0;
            while axis < 3 {
                let a = simd.load8(&self.start.corners[corner][axis]);
                let b = simd.load8(&self.end[corner][axis]);
                a.mul(early).add(b.mul(late)).store(&mut block.corners[corner][axis]);
                axis += 1;
            }
            corner += 1;
        }
        block
    }
}

impl MovingBvh {
    /// Builds the tree.
    ///
    /// # Panics
    ///
    /// When there are not as many positions at the end as at the start.
    pub fn build(mesh: &MovingTriangles<'_>, options: &BuildOptions<'_>) -> Result<MovingBvh, BuildError> {
        assert_eq!(mesh.start.len(), mesh.end.len());
        if let Some((triangle, vertex)) = mesh.missing() {
            return Err(BuildError::VertexOutOfRange { triangle, vertex, vertices: mesh.start.len() });
        }
        let scale = mesh.scale();
        let boxes: Vec<Aabb> = (0..mesh.triangles.len()).map(|id| mesh.bounds(id, scale)).collect();
        let source = Source::Boxes { boxes: &boxes, scale: 1.0, width: BLOCK };
        let WideTree { nodes, slots, mut stats } = wide::build(&source, options)?;
        let blocks: Vec<MovingBlock> = slots
            .chunks_exact(BLOCK)
            .map(|ids| {
                let mut block = MovingBlock { start: Block::EMPTY, end: Block::EMPTY.corners };
                for (lane, &id) in ids.iter().enumerate().filter(|(_, id)| **id != NO_PRIMITIVE) {
                    block.start.ids[lane] = id;
                    block.set(lane, mesh.keys(id as usize, scale));
                }
                block
            })
            .collect();
        stats.bytes = size_of_val(&nodes[..]) + size_of_val(&blocks[..]);
        let space = Space::of(scale, &nodes);
        Ok(MovingBvh { nodes, blocks, space, stats, count: mesh.triangles.len() })
    }

    /// Takes on other places of the vertices, for the same triangles, as [`Bvh::refit`](crate::Bvh::refit) does.
    ///
    /// # Panics
    ///
    /// When there are not as many positions at the end as at the start.
    pub fn refit(&mut self, mesh: &MovingTriangles<'_>) -> Result<(), RefitError> {
        assert_eq!(mesh.start.len(), mesh.end.len());
        if mesh.triangles.len() != self.count {
            return Err(RefitError::Count { built: self.count, given: mesh.triangles.len() });
        }
        if let Some((triangle, vertex)) = mesh.missing() {
            return Err(RefitError::VertexOutOfRange { triangle, vertex });
        }
        let scale = mesh.scale();
        if self.stats.non_finite > 0 {
            let ids = left_out(self.blocks.iter().flat_map(|b| b.start.ids), self.count);
            if let Some(&id) = ids.iter().find(|&&id| mesh.bounds(id as usize, scale).is_valid()) {
                return Err(RefitError::LeftOut { primitive: id as usize });
            }
        }
        for block in &mut self.blocks {
            for lane in 0..BLOCK {
                let id = block.start.ids[lane];
                if id != NO_PRIMITIVE {
                    block.set(lane, mesh.keys(id as usize, scale));
                }
            }
        }
        let blocks = &self.blocks;
        refit(&mut self.nodes, |leaf| {
            let blocks = &blocks[leaf.first_block()..leaf.first_block() + leaf.blocks()];
            let ids = blocks.iter().flat_map(|b| b.start.ids).filter(|&id| id != NO_PRIMITIVE);
            let boxes = ids.map(|id| mesh.bounds(id as usize, scale)).filter(|b| b.is_valid());
            boxes.fold(Aabb::EMPTY, Aabb::union)
        });
        self.space = Space::of(scale, &self.nodes);
        Ok(())
    }

    /// The size and the quality of the tree.
    pub fn stats(&self) -> &BuildStats {
        &self.stats
    }

    pub(crate) fn tree<'a, F>(&'a self, leaves: &'a MovingBlocks<'a, F>) -> Tree<'a, MovingBlocks<'a, F>> {
        Tree { nodes: &self.nodes, leaves, space: self.space }
    }

    /// The nearest hit.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        search::closest(self.tree(&MovingBlocks { blocks: &self.blocks, filter: every }), ray).some()
    }

    /// Whether anything is hit.
    pub fn occluded(&self, ray: &Ray) -> bool {
        search::any(self.tree(&MovingBlocks { blocks: &self.blocks, filter: every }), ray)
    }

    /// The nearest hits of many rays.
    pub fn intersect_batch(&self, rays: &[Ray], hits: &mut [Hit]) {
        search::closest_batch(self.tree(&MovingBlocks { blocks: &self.blocks, filter: every }), rays, hits);
    }

    /// Whether each of many rays hits anything.
    pub fn occluded_batch(&self, rays: &[Ray], hits: &mut [bool]) {
        search::any_batch(self.tree(&MovingBlocks { blocks: &self.blocks, filter: every }), rays, hits);
    }
}

#[inline(always)]
fn every(_: u32, _: &Hit) -> bool {
    true
}

impl MovingBlock {
    /// A triangle's corners at both times; one whose numbers are not finite is never hit.
    fn set(&mut self, lane: usize, keys: [[[f32; 3]; 3]; 2]) {
        let usable = finite(&keys[0]) && finite(&keys[1]);
        let [start, end] = if usable { keys } else { [[[f32::NAN; 3]; 3]; 2] };
        for corner in 0..3 {
            for axis in 0..3 {
                self.start.corners[corner][axis][lane] = start[corner][axis];
                self.end[corner][axis][lane] = end[corner][axis];
            }
        }
    }
}

impl MovingTriangles<'_> {
    fn missing(&self) -> Option<(usize, u32)> {
        let missing = |t: &[u32; 3]| t.iter().copied().find(|&vertex| vertex as usize >= self.start.len());
        self.triangles.iter().enumerate().find_map(|(i, t)| Some((i, missing(t)?)))
    }

    fn scale(&self) -> f32 {
        let all = self.start.iter().chain(self.end).flatten().map(|x| x.abs());
        scale_of(all.filter(|x| x.is_finite()).fold(0.0, f32::max))
    }

    /// The corners at both times, in the units of the tree.
    pub(crate) fn keys(&self, id: usize, scale: f32) -> [[[f32; 3]; 3]; 2] {
        [self.start, self.end].map(|p| self.triangles[id].map(|i| p[i as usize].map(|x| x * scale)))
    }

    /// The box around both.
    fn bounds(&self, id: usize, scale: f32) -> Aabb {
        let keys = self.keys(id, scale);
        if !(finite(&keys[0]) && finite(&keys[1])) {
            return Aabb::EMPTY;
        }
        keys.into_iter().flatten().fold(Aabb::EMPTY, Aabb::grow)
    }
}

/// Leaves of moving triangles.
pub(crate) struct MovingBlocks<'a, F> {
    pub(crate) blocks: &'a [MovingBlock],
    pub(crate) filter: F,
}

impl<F> MovingBlocks<'_, F> {
    #[inline(always)]
    fn of(&self, leaf: ChildRef) -> &[MovingBlock] {
        let (first, count) = (leaf.first_block(), leaf.blocks());
        debug_assert!(first + count <= self.blocks.len());
        // SAFETY: builders make leaves of blocks that are there.
        unsafe { self.blocks.get_unchecked(first..first + count) }
    }
}

impl<F: Fn(u32, &Hit) -> bool> Leaves for MovingBlocks<'_, F> {
    #[inline(always)]
    fn closest<S: Simd>(&self, simd: S, leaf: ChildRef, ray: &SearchRay, ray_index: u32, hit: &mut Hit) {
        let time = clamped(ray.time);
        for block in self.of(leaf) {
            let block = block.at(simd, time);
            block.closest(simd, &ray.shear, ray.t_min, hit, |h| (self.filter)(ray_index, h));
        }
    }

    #[inline(always)]
    fn any<S: Simd>(&self, simd: S, leaf: ChildRef, ray: &SearchRay, ray_index: u32) -> bool {
        let time = clamped(ray.time);
        for block in self.of(leaf) {
            let block = block.at(simd, time);
            if block.any(simd, &ray.shear, ray.t_min, ray.t_max, |h| (self.filter)(ray_index, h)) {
                return true;
            }
        }
        false
    }

    #[inline(always)]
    fn address(&self, leaf: ChildRef) -> *const u8 {
        self.blocks.as_ptr().wrapping_add(leaf.first_block()).cast()
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::Kernel;
    use crate::generate::Random;
    use crate::levels::tests::kernels;
    use crate::oracle;

    /// What every tree must find, at the ray's time.
    pub(crate) fn brute(mesh: &MovingTriangles<'_>, bvh: &MovingBvh, ray: &Ray) -> Hit {
        let time = clamped(ray.time);
        let all: Vec<_> = (0..mesh.triangles.len())
            .filter(|&id| mesh.keys(id, 1.0).iter().all(|key| finite(key)))
            .map(|id| {
                let [a, b] = mesh.keys(id, bvh.space.scale);
                let at = |i: usize, j: usize| a[i][j] * (1.0 - time) + b[i][j] * time;
                (id as u32, std::array::from_fn(|i| std::array::from_fn(|j| at(i, j))))
            })
            .collect();
        oracle::closest(&all, ray, &bvh.space)
    }

    #[test]
    fn moving_triangles_equal_brute_force() {
        let mut random = Random::new(3);
        for (size, motion) in [(0.1, 0.5), (1.0, 0.0), (0.01, 3.0)] {
            let mut start = Vec::new();
            let mut end = Vec::new();
            for _ in 0..300 {
                let (c, d) = (random.in_cube(), random.in_cube());
                for _ in 0..3 {
                    let (p, q) = (random.in_cube(), random.in_cube());
                    start.push([0, 1, 2].map(|i| c[i] + size * p[i]));
                    end.push([0, 1, 2].map(|i| c[i] + motion * d[i] + size * q[i]));
                }
            }
            end[17][1] = f32::NAN;
            let triangles: Vec<[u32; 3]> = (0..300).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
            let mesh = MovingTriangles { start: &start, end: &end, triangles: &triangles };
            let mut bvh = MovingBvh::build(&mesh, &BuildOptions::default()).unwrap();
            assert_eq!(bvh.stats().non_finite, 1);
            check(&mesh, &bvh, &mut random);
            let moved: Vec<[f32; 3]> = start.iter().map(|p| p.map(|x| 1e13 * (x + 3.0))).collect();
            let mut other = end.clone();
            other[30][2] = f32::INFINITY;
            let mesh = MovingTriangles { start: &moved, end: &other, triangles: &triangles };
            bvh.refit(&mesh).unwrap();
            check(&mesh, &bvh, &mut random);
            let mesh = MovingTriangles { end: &moved, ..mesh };
            assert_eq!(bvh.refit(&mesh), Err(RefitError::LeftOut { primitive: 5 }));
        }
    }

    fn check(mesh: &MovingTriangles<'_>, bvh: &MovingBvh, random: &mut Random) {
        let rays: Vec<Ray> = (0..400)
            .map(|i| {
                // Through a place that a triangle has at the time.
                let time = [0.0, 1.0, 0.5, random.unit(), -1.0, 7.0, f32::NAN][i % 7];
                let [a, b] = mesh.keys(i % mesh.triangles.len(), 1.0);
                let w = [random.unit(), random.unit(), random.unit()];
                let target: [f32; 3] = std::array::from_fn(|axis| {
                    let at = |k: usize| a[k][axis] * (1.0 - clamped(time)) + b[k][axis] * clamped(time);
                    (w[0] * at(0) + w[1] * at(1) + w[2] * at(2)) / (w[0] + w[1] + w[2])
                });
                let origin = random.in_cube().map(|x| 3.0 * x);
                let direction = std::array::from_fn(|i| target[i] - origin[i]);
                Ray { time, ..Ray::new(origin, direction) }
            })
            .collect();
        let expected: Vec<Hit> = rays.iter().map(|ray| brute(mesh, bvh, ray)).collect();
        assert!(expected.iter().filter(|h| h.is_hit()).count() > 100);
        kernels(|kernel: Kernel| {
            let mut hits = vec![Hit::MISS; rays.len()];
            let mut any = vec![false; rays.len()];
            bvh.intersect_batch(&rays, &mut hits);
            bvh.occluded_batch(&rays, &mut any);
            for (i, ray) in rays.iter().enumerate() {
                assert_eq!(bvh.intersect(ray).unwrap_or(Hit::MISS), expected[i], "{kernel} {ray:?}");
                assert_eq!(hits[i], expected[i], "{kernel} {ray:?}");
                assert_eq!(bvh.occluded(ray), expected[i].is_hit(), "{kernel} {ray:?}");
                assert_eq!(any[i], expected[i].is_hit(), "{kernel} {ray:?}");
            }
        });
    }
}

//! BVH over triangles.

use std::sync::Arc;

use crate::build::wide::{self, Source, WideTree};
use crate::changed::Changed;
use crate::node::WideNode;
use crate::traverse::{Blocks, MAX_COORDINATE, Space, Tree};
use crate::triangle::{Block, fill_blocks};
use crate::{BuildError, BuildOptions, BuildStats, Hit, InstructionSet, Ray, search};

/// An indexed triangle mesh.
#[derive(Clone, Copy, Debug, Default)]
pub struct Triangles<'a> {
    /// Positions of the vertices.
    pub positions: &'a [[f32; 3]],
    /// Vertex indices of each triangle.
    pub triangles: &'a [[u32; 3]],
}

/// A BVH over triangles, with copies of them in its leaves: 46 to 54 bytes per triangle in total.
///
/// ```
/// use turner_bvh::{BuildOptions, Bvh, Hit, Ray, Triangles};
///
/// let positions = [[0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]];
/// let bvh = Bvh::build(&Triangles { positions: &positions, triangles: &[[0, 1, 2]] }, &BuildOptions::default())?;
/// let ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]);
/// let hit = bvh.intersect(&ray).unwrap();
/// assert_eq!((hit.t, hit.u, hit.v, hit.primitive), (5.0, 0.25, 0.25, 0));
///
/// let mut hits = [Hit::MISS; 2];
/// bvh.intersect_batch(&[ray, Ray { t_max: 4.0, ..ray }], &mut hits);
/// assert_eq!(hits.map(|hit| hit.is_hit()), [true, false]);
/// # Ok::<(), turner_bvh::BuildError>(())
/// ```
///
/// All queries find the nearest hit with `t_min <= t <= t_max`; among equally near hits, the one with the lowest
/// triangle index. The result is the same bit for bit for single rays, batches and packets, for any
/// [`InstructionSet`](crate::InstructionSet) and any build quality. Triangles are two-sided. Meshes are watertight: no
/// ray passes between triangles that share an edge or a vertex.
///
/// Rays that are not [valid](Ray::is_valid) hit nothing, nor do rays without a direction and rays that start beyond
/// 2^40 units. For a BVH larger than 2^40 or smaller than 2^-40, that limit scales with its size.
#[derive(Clone, Debug)]
pub struct Bvh {
    pub(crate) nodes: Vec<WideNode>,
    /// Shared with changed copies of the BVH.
    pub(crate) blocks: Arc<Vec<Block>>,
    pub(crate) space: Space,
    pub(crate) stats: BuildStats,
    pub(crate) instruction_set: InstructionSet,
    /// Number of triangles in the mesh.
    pub(crate) triangles: u32,
    /// Triangles that changed since the build.
    pub(crate) changed: Option<Box<Changed>>,
}

impl Bvh {
    /// Builds the BVH. Omits and counts triangles with a NaN or infinite coordinate and those with two equal vertices.
    pub fn build(mesh: &Triangles<'_>, options: &BuildOptions<'_>) -> Result<Bvh, BuildError> {
        Bvh::of(mesh, options, wide::build_best)
    }

    fn of(mesh: &Triangles<'_>, options: &BuildOptions<'_>, build: Builder) -> Result<Bvh, BuildError> {
        let (WideTree { nodes, slots, mut stats }, space) = scaled(mesh, options, build)?;
        let blocks = Arc::new(fill_blocks(mesh, space.scale, &slots, options.threads)?);
        stats.bytes = size_of_val(&nodes[..]) + size_of_val(&blocks[..]);
        let triangles = mesh.triangles.len() as u32;
        let instruction_set = options.instruction_set;
        Ok(Bvh { nodes, blocks, space, stats, instruction_set, triangles, changed: None })
    }

    /// Size and quality of the BVH.
    pub fn stats(&self) -> &BuildStats {
        &self.stats
    }

    /// The instruction set that traversal uses.
    pub fn instruction_set(&self) -> InstructionSet {
        self.instruction_set
    }

    fn tree<'a, F>(&'a self, leaves: &'a Blocks<'a, F>) -> Tree<'a, Blocks<'a, F>> {
        Tree { nodes: &self.nodes, leaves, space: self.space, instruction_set: self.instruction_set }
    }

    fn all(&self) -> Blocks<'_, impl Fn(u32, &Hit) -> bool> {
        Blocks { blocks: &self.blocks, filter: |_, _: &Hit| true, filtered: false }
    }

    fn some<F: Fn(u32, &Hit) -> bool>(&self, filter: F) -> Blocks<'_, F> {
        Blocks { blocks: &self.blocks, filter, filtered: true }
    }

    /// The nearest hit.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        match &self.changed {
            None => search::closest(self.tree(&self.all()), ray).some(),
            Some(changed) => self.one_closest_changed(changed, ray, &|_| true).some(),
        }
    }

    /// The nearest hit that `filter` accepts (alpha test). The filter sees hits in any order, including farther ones,
    /// and may see one twice: its answer must depend only on the hit.
    pub fn intersect_filtered(&self, ray: &Ray, filter: impl Fn(&Hit) -> bool) -> Option<Hit> {
        match &self.changed {
            None => search::closest(self.tree(&self.some(|_, hit| filter(hit))), ray).some(),
            Some(changed) => self.one_closest_changed(changed, ray, &filter).some(),
        }
    }

    /// Whether the ray hits anything.
    pub fn occluded(&self, ray: &Ray) -> bool {
        match &self.changed {
            None => search::any(self.tree(&self.all()), ray),
            Some(changed) => self.one_any_changed(changed, ray, &|_| true),
        }
    }

    /// Whether the ray has a hit that `filter` accepts.
    pub fn occluded_filtered(&self, ray: &Ray, filter: impl Fn(&Hit) -> bool) -> bool {
        match &self.changed {
            None => search::any(self.tree(&self.some(|_, hit| filter(hit))), ray),
            Some(changed) => self.one_any_changed(changed, ray, &filter),
        }
    }

    /// The nearest hits of many rays; [`Hit::MISS`] for rays that hit nothing. The rays may be arbitrary. Coherent
    /// neighbours, such as camera rays of blocks of 4 x 4 pixels or rays towards one light, are traced as packets,
    /// several times as fast. In large BVHs incoherent rays are traced interleaved, which hides memory latency.
    ///
    /// # Panics
    ///
    /// All batch queries panic if `hits` and `rays` differ in length.
    pub fn intersect_batch(&self, rays: &[Ray], hits: &mut [Hit]) {
        match &self.changed {
            None => search::closest_triangles(self.tree(&self.all()), rays, hits),
            Some(changed) => self.closest_changed(changed, rays, hits, &|_, _| true),
        }
    }

    /// As [`intersect_batch`](Self::intersect_batch), for hits that `filter` accepts. The filter also gets the ray's
    /// index.
    pub fn intersect_batch_filtered(
        &self,
        rays: &[Ray],
        hits: &mut [Hit],
        filter: impl Fn(u32, &Hit) -> bool,
    ) {
        match &self.changed {
            None => search::closest_triangles(self.tree(&self.some(filter)), rays, hits),
            Some(changed) => self.closest_changed(changed, rays, hits, &filter),
        }
    }

    /// Whether each of many rays hits anything.
    pub fn occluded_batch(&self, rays: &[Ray], hits: &mut [bool]) {
        match &self.changed {
            None => search::any_triangles(self.tree(&self.all()), rays, hits),
            Some(changed) => self.any_changed(changed, rays, hits, &|_, _| true),
        }
    }

    /// As [`occluded_batch`](Self::occluded_batch), for hits that `filter` accepts. The filter also gets the ray's
    /// index.
    pub fn occluded_batch_filtered(
        &self,
        rays: &[Ray],
        hits: &mut [bool],
        filter: impl Fn(u32, &Hit) -> bool,
    ) {
        match &self.changed {
            None => search::any_triangles(self.tree(&self.some(filter)), rays, hits),
            Some(changed) => self.any_changed(changed, rays, hits, &filter),
        }
    }
}

/// A builder function.
pub(crate) type Builder = fn(&Source<'_>, &BuildOptions<'_>) -> Result<WideTree, BuildError>;

/// Builds a BVH over triangles with coordinates scaled to a safe range, and returns it with its scale.
pub(crate) fn scaled(
    mesh: &Triangles<'_>,
    options: &BuildOptions<'_>,
    build: Builder,
) -> Result<(WideTree, Space), BuildError> {
    let (positions, triangles) = (mesh.positions, mesh.triangles);
    let build = |scale| build(&Source::Triangles { positions, triangles, scale }, options);
    let scale = scale(positions);
    let tree = build(scale)?;
    let space = Space::of(scale, &tree.nodes);
    if scale >= 1.0 || space.reach >= MIN_REACH {
        return Ok((tree, space));
    }
    // The farthest vertices are unused or belong to omitted triangles: scale by what the BVH contains.
    let scale = scale_of(space.reach * space.unscale);
    let tree = build(scale)?;
    let space = Space::of(scale, &tree.nodes);
    Ok((tree, space))
}

/// The least extent of a BVH from the origin, after scaling.
pub(crate) const MIN_REACH: f32 = 1.0 / 1024.0;

/// The scale for a mesh, from its finite vertices.
pub(crate) fn scale(positions: &[[f32; 3]]) -> f32 {
    let finite = positions.iter().filter(|p| p.iter().all(|x| x.is_finite()));
    scale_of(finite.flatten().fold(0.0_f32, |reach, x| reach.max(x.abs())))
}

/// The power of two that brings coordinates up to `reach` into the range of traversal; 1 for ordinary sizes.
pub(crate) fn scale_of(reach: f32) -> f32 {
    if (MIN_REACH..=MAX_COORDINATE).contains(&reach) || reach < f32::MIN_POSITIVE {
        return 1.0;
    }
    // Small meshes are scaled up to about 1. Large ones are scaled down to 2^30, which leaves room for distant ray
    // origins.
    let exponent = (reach.to_bits() >> 23) as i32 - 127;
    let target = if exponent > 0 { 30 } else { 0 };
    f32::from_bits(((target - exponent).clamp(-126, 127) + 127) as u32 * (1 << 23))
}

#[cfg(test)]
#[path = "bvh_tests.rs"]
mod tests;

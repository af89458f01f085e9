//! The tree over triangles.

use std::sync::Arc;

use crate::build::wide::{self, Source, WideTree};
use crate::changed::Changed;
use crate::node::WideNode;
use crate::traverse::{Blocks, FARTHEST, Space, Tree};
use crate::triangle::{Block, fill_blocks};
use crate::{BuildError, BuildOptions, BuildStats, Hit, InstructionSet, Ray, search};

/// Triangles as a mesh has them: corners by number.
#[derive(Clone, Copy, Debug, Default)]
pub struct Triangles<'a> {
    /// Positions of the vertices.
    pub positions: &'a [[f32; 3]],
    /// For each triangle the numbers of its corners.
    pub triangles: &'a [[u32; 3]],
}

/// A tree over triangles, with copies of them in its leaves: 46 to 54 bytes per triangle, all in all.
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
/// All searches find the nearest hit with `t_min <= t <= t_max`, of equally near ones that of the lowest number, bit for
/// bit the same one by one, in batches, coherent or not, with any [`InstructionSet`](crate::InstructionSet) and any quality of the tree. Both sides of
/// a triangle count. Meshes are watertight: no ray passes through an edge or a vertex that triangles share.
///
/// Rays that are not [valid](Ray::is_valid), that have no direction, or that start beyond 2^40 units (for trees larger
/// than that or smaller than 2^-40: as many units of their size) hit nothing.
#[derive(Clone, Debug)]
pub struct Bvh {
    pub(crate) nodes: Vec<WideNode>,
    /// Shared with trees that were changed.
    pub(crate) blocks: Arc<Vec<Block>>,
    pub(crate) space: Space,
    pub(crate) stats: BuildStats,
    pub(crate) instruction_set: InstructionSet,
    /// Triangles of the mesh.
    pub(crate) triangles: u32,
    /// What else there is to search.
    pub(crate) changed: Option<Box<Changed>>,
}

impl Bvh {
    /// Builds the tree. Triangles with a number that is NaN or infinite, and those with two equal corners, are left out and
    /// counted.
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

    /// The size and the quality of the tree.
    pub fn stats(&self) -> &BuildStats {
        &self.stats
    }

    /// The instruction set that searches use.
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

    /// The nearest hit that `filter` takes. It is asked about hits in any order, farther ones included, and may be
    /// asked about the same one twice: its answer must depend on the hit alone.
    pub fn intersect_filtered(&self, ray: &Ray, filter: impl Fn(&Hit) -> bool) -> Option<Hit> {
        match &self.changed {
            None => search::closest(self.tree(&self.some(|_, hit| filter(hit))), ray).some(),
            Some(changed) => self.one_closest_changed(changed, ray, &filter).some(),
        }
    }

    /// Whether anything is hit.
    pub fn occluded(&self, ray: &Ray) -> bool {
        match &self.changed {
            None => search::any(self.tree(&self.all()), ray),
            Some(changed) => self.one_any_changed(changed, ray, &|_| true),
        }
    }

    /// Whether there is a hit that `filter` takes.
    pub fn occluded_filtered(&self, ray: &Ray, filter: impl Fn(&Hit) -> bool) -> bool {
        match &self.changed {
            None => search::any(self.tree(&self.some(|_, hit| filter(hit))), ray),
            Some(changed) => self.one_any_changed(changed, ray, &filter),
        }
    }

    /// The nearest hits of many rays, [`Hit::MISS`] where there is none. Rays need have nothing in common. Neighbours that
    /// do, as from a camera in squares of 4 by 4 pixels or towards a light, go through the tree together, several times as
    /// fast; in large trees others are searched for in turns, so that one's wait for memory is another's work.
    ///
    /// # Panics
    ///
    /// If there are not as many `hits` as `rays`; so do all batches.
    pub fn intersect_batch(&self, rays: &[Ray], hits: &mut [Hit]) {
        match &self.changed {
            None => search::closest_triangles(self.tree(&self.all()), rays, hits),
            Some(changed) => self.closest_changed(changed, rays, hits, &|_, _| true),
        }
    }

    /// The same for the hits that `filter` takes; it is told the number of the ray.
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

    /// The same for the hits that `filter` takes; it is told the number of the ray.
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

/// What makes trees.
pub(crate) type Builder = fn(&Source<'_>, &BuildOptions<'_>) -> Result<WideTree, BuildError>;

/// Builds a tree over triangles, in coordinates that are neither too large nor too small; returns their scale, too.
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
    if scale >= 1.0 || space.reach >= NEAREST {
        return Ok((tree, space));
    }
    // The farthest vertices belong to no triangle, or to none that counts.
    let scale = scale_of(space.reach * space.unscale);
    let tree = build(scale)?;
    let space = Space::of(scale, &tree.nodes);
    Ok((tree, space))
}

/// Trees reach at least this far, after scaling.
pub(crate) const NEAREST: f32 = 1.0 / 1024.0;

/// The scale for vertices, those left aside that are not finite.
pub(crate) fn scale(positions: &[[f32; 3]]) -> f32 {
    let finite = positions.iter().filter(|p| p.iter().all(|x| x.is_finite()));
    scale_of(finite.flatten().fold(0.0_f32, |reach, x| reach.max(x.abs())))
}

/// The power of two that brings what lies at `reach` into the range of trees: 1 for ordinary sizes.
pub(crate) fn scale_of(reach: f32) -> f32 {
    if (NEAREST..=FARTHEST).contains(&reach) || reach < f32::MIN_POSITIVE {
        return 1.0;
    }
    // Up to 1 from below; down to what leaves room for rays that start far away from above.
    let exponent = (reach.to_bits() >> 23) as i32 - 127;
    let target = if exponent > 0 { 30 } else { 0 };
    f32::from_bits(((target - exponent).clamp(-126, 127) + 127) as u32 * (1 << 23))
}

#[cfg(test)]
#[path = "bvh_tests.rs"]
mod tests;

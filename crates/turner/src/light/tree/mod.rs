//! Light tree: chooses one of thousands of lights by its estimated contribution to a point.
//!
//! With many lights, next-event estimation can sample only one of them per vertex. The estimator is contribution /
//! P(light). It is unbiased if each contributing light has P > 0, and its variance is low if P is nearly proportional
//! to the contribution.
//!
//! Method: Conty Estevez and Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting", without
//! the splitting. A BVH is built over the lights. Each node bounds the positions of its lights (sphere), the
//! directions in which they emit (cone) and their power. These bounds and the point, normal and glossy lobe
//! of the receiver give an importance: approximately the most that the node can contribute, and 0 only where no light
//! can arrive ([`node`]). A sample descends from the root, chooses among the children of each node in proportion to
//! their importance, and rescales its one random number at each step.
//!
//! ```text
//!              root                 P(light) = product over the levels of
//!        /    /    \    \           importance(child) / Σ importance(children)
//!      0.6  0.2    0.2   0
//!     / | \ \
//!    .. .. .. light 7               P(light 7) = 0.6 · its fraction in that node
//! ```
//!
//! For MIS the tree also gives P of a light that a BSDF sample hit: each light stores its path from the root, so the
//! same product is computed without a search. If all children of a chosen node have importance 0 (its own bounds are
//! looser), no light is chosen; the estimate is then 0 and remains unbiased.
//!
//! Nodes have eight children, whose bounds are evaluated together in the lanes of one register. Cost: O(log n) nodes
//! per choice. Memory: 384 bytes per node, with about one node for four lights, and 8 bytes per light.

mod build;
mod node;
#[cfg(test)]
mod tests;

use std::f64::consts::PI;

pub(crate) use crate::material::GlossyLobe;
use node::{LEAF, LitPoint, Node, WIDTH};
use turner_bvh::InstructionSet;
use turner_bvh::lanes::{Block, Block32, F32x8, F64x8, Simd, Work, dispatch};

use crate::math::DVec3;

/// Bits of a path per level.
const BITS: u32 = WIDTH.trailing_zeros();

/// A point to be lit, with the orientation and gloss of its surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receiver {
    /// The point.
    pub p: DVec3,
    /// The unit normal, if only light on its side counts; 0 if light from all directions counts.
    pub n: [f32; 3],
    /// The glossy lobe of the surface.
    pub lobe: GlossyLobe,
    /// Number of candidate lights beyond the first that are sampled here; resampling keeps one of all candidates.
    pub extra_candidates: u32,
    /// The cell of an [`AdaptiveEnvironment`](super::AdaptiveEnvironment) that the environment is sampled for;
    /// [`NO_CELL`] where it is sampled by luminance, another mark where directions are cosine-weighted about `n`.
    pub cell: u32,
    /// Time within the shutter, 0..=1, for lights that move.
    pub time: f32,
}

/// No cell.
pub const NO_CELL: u32 = u32::MAX;

/// In place of a cell: directions to the environment are cosine-weighted.
pub(crate) const BY_COSINE: u32 = u32::MAX - 1;

impl Default for Receiver {
    fn default() -> Receiver {
        Receiver::from(DVec3::ZERO)
    }
}

impl Receiver {
    /// The same point at a time of the shutter, 0..=1.
    #[inline]
    pub fn at_time(self, time: f32) -> Receiver {
        Receiver { time, ..self }
    }

    /// The same point with a glossy lobe.
    #[inline]
    pub fn with_lobe(self, lobe: GlossyLobe) -> Receiver {
        Receiver { lobe, ..self }
    }

    /// A point of a surface that only light on the side of the unit normal `n` reaches.
    #[inline]
    pub fn facing(p: DVec3, n: DVec3) -> Receiver {
        Receiver { n: n.as_vec3().to_array(), ..Receiver::from(p) }
    }

    /// The same point with this many extra candidates.
    #[inline]
    pub fn with_candidates(self, extra_candidates: u32) -> Receiver {
        Receiver { extra_candidates, ..self }
    }

    /// The same point in the cell of an adaptive environment.
    #[inline]
    pub fn in_cell(self, cell: u32) -> Receiver {
        Receiver { cell, ..self }
    }

    /// The same point, where directions to a uniform environment are cosine-weighted about the unit normal `n`.
    #[inline]
    pub fn by_cosine(self, n: DVec3) -> Receiver {
        Receiver { n: n.as_vec3().to_array(), cell: BY_COSINE, ..self }
    }

    /// The normal, if directions are cosine-weighted.
    #[inline]
    pub fn cosine_normal(&self) -> Option<DVec3> {
        (self.cell == BY_COSINE).then(|| DVec3::from(self.n.map(f64::from)).normalize())
    }

    /// The pdf of a unit direction, per solid angle, with cosine-weighted sampling; 0 without it.
    #[inline]
    pub fn cosine_pdf(&self, direction: DVec3) -> f64 {
        self.cosine_normal().map_or(0.0, |n| n.dot(direction).max(0.0) / PI)
    }

    /// The number of candidate lights.
    #[inline]
    pub fn candidates(&self) -> f64 {
        f64::from(self.extra_candidates) + 1.0
    }
}

impl From<DVec3> for Receiver {
    /// Light counts from all directions.
    #[inline]
    fn from(p: DVec3) -> Receiver {
        Receiver {
            p,
            n: [0.0; 3],
            lobe: GlossyLobe::default(),
            extra_candidates: 0,
            cell: NO_CELL,
            time: 0.0,
        }
    }
}

/// A light tree. Lights are identified by their index.
#[derive(Clone, Debug)]
pub struct LightTree {
    /// The root is first; children come after their parents.
    nodes: Vec<Node>,
    /// For each light, its path from the root: three bits per level, the root's in the lowest bits.
    paths: Vec<u64>,
    /// Nodes are in tree space: (x − origin) · scale.
    origin: DVec3,
    scale: f64,
}

/// A light that was chosen, its probability, and the random number of the choice, rescaled to 0..1.
pub(crate) type ChosenLight = (u32, f64, f64);

impl LightTree {
    /// The largest number of lights; such a tree takes about 500 MB.
    pub const MOST: u32 = 1 << 22;

    #[inline(always)]
    fn local(&self, p: DVec3) -> [f32; 3] {
        ((p - self.origin) * self.scale).as_vec3().to_array()
    }

    /// The light that `u` in 0..1 chooses, its probability, and the rescaled `u`, again in 0..1; `None` where no
    /// light can contribute.
    pub fn sample(&self, at: &Receiver, u: f64) -> Option<(u32, f64, f64)> {
        let mut chosen = None;
        let request = std::iter::once((at, false, u));
        self.sample_batch(InstructionSet::best(), request, |found| chosen = found);
        chosen
    }

    /// The same for many receivers and numbers `u`; the bool says that the receiver is that of the request before.
    /// Calls `found` for each in order.
    #[inline]
    pub(crate) fn sample_batch<'a>(
        &self,
        set: InstructionSet,
        requests: impl Iterator<Item = (&'a Receiver, bool, f64)>,
        found: impl FnMut(Option<ChosenLight>),
    ) {
        dispatch(set, SampleBatch { tree: self, requests, found });
    }

    /// The probability with which `sample` chooses a light; 0 for an index out of range.
    pub fn probability(&self, at: &Receiver, light: u32) -> f64 {
        match self.paths.get(light as usize) {
            Some(path) => dispatch(InstructionSet::best(), Probability { tree: self, at, path: *path }),
            None => 0.0,
        }
    }

    /// Memory in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.paths[..])
    }
}

struct SampleBatch<'a, I, F> {
    tree: &'a LightTree,
    requests: I,
    found: F,
}

impl<'a, I: Iterator<Item = (&'a Receiver, bool, f64)>, F: FnMut(Option<ChosenLight>)> Work
    for SampleBatch<'_, I, F>
{
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let SampleBatch { tree, requests, mut found } = self;
        let mut root = Weights::default();
        for (at, again, u) in requests {
            let point = LitPoint::new(simd, tree.local(at.p), at);
            if !again && let Some(node) = tree.nodes.first() {
                root = Weights::new(node.importance(&point));
            }
            found(tree.descend(simd, &point, &root, u));
        }
    }
}

struct Probability<'a> {
    tree: &'a LightTree,
    at: &'a Receiver,
    path: u64,
}

impl Work for Probability<'_> {
    type Output = f64;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> f64 {
        let Probability { tree, at, mut path } = self;
        let point = LitPoint::new(simd, tree.local(at.p), at);
        let (mut child, mut probability) = (0, 1.0);
        while child & LEAF == 0 {
            let Some(node) = tree.nodes.get(child as usize) else { return 0.0 };
            let weights = Weights::new(node.importance(&point));
            let Some(sum) = weights.sum() else { return 0.0 };
            let lane = (path % WIDTH as u64) as usize;
            path >>= BITS;
            probability *= f64::from(weights.each.0[lane]) / sum;
            child = node.child[lane];
        }
        probability
    }
}

impl LightTree {
    /// Chooses a light for a point from the root down; `root` has the weights of the root's children.
    #[inline(always)]
    fn descend<S: Simd>(
        &self,
        simd: S,
        point: &LitPoint<S>,
        root: &Weights,
        mut u: f64,
    ) -> Option<ChosenLight> {
        let (mut weights, mut node, mut probability) = (*root, self.nodes.first()?, 1.0);
        loop {
            let sum = weights.sum()?;
            let target = u * sum;
            // Children without weight add nothing to the sums, so the first sum beyond the target has a weight. Rounding
            // may move the target to the end: then it is the last child with a weight.
            let passed = F64x8::load(simd, &weights.sums).le(F64x8::splat(simd, target)).bits();
            let lane = match passed.count_ones() as usize {
                WIDTH => weights.each.0.iter().rposition(|w| *w > 0.0)?,
                lane => lane,
            };
            let before = if lane == 0 { 0.0 } else { weights.sums.0[lane - 1] };
            let weight = f64::from(weights.each.0[lane]);
            probability *= weight / sum;
            u = ((target - before) / weight).clamp(0.0, 1.0 - f64::EPSILON);
            let child = node.child[lane];
            if child & LEAF != 0 {
                return Some((child & !LEAF, probability, u));
            }
            node = self.nodes.get(child as usize)?;
            weights = Weights::new(node.importance(point));
        }
    }
}

/// The weights of a node's children, and for each the sum of those up to it.
#[derive(Clone, Copy, Default)]
struct Weights {
    each: Block32,
    sums: Block,
}

impl Weights {
    #[inline(always)]
    fn new<S: Simd>(weights: F32x8<S>) -> Weights {
        let mut out = Weights::default();
        weights.store(&mut out.each);
        let mut sum = 0.0;
        for (to, weight) in out.sums.0.iter_mut().zip(out.each.0) {
            sum += f64::from(weight);
            *to = sum;
        }
        out
    }

    /// Their sum; `None` where no child can contribute.
    #[inline(always)]
    fn sum(&self) -> Option<f64> {
        let sum = self.sums.0[WIDTH - 1];
        (sum > 0.0 && sum < f64::INFINITY).then_some(sum)
    }
}

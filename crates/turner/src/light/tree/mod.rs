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
//! Nodes have four children, whose bounds are evaluated together. Cost: O(log n) nodes per choice. Memory: 192 bytes
//! per node, with about one node for two to three lights, and 8 bytes per light.

mod build;
mod node;
#[cfg(test)]
mod tests;

pub(crate) use crate::material::GlossyLobe;
pub(crate) use node::WIDTH;
use node::{LEAF, Node};

use crate::math::DVec3;

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
    /// [`NO_CELL`] where it is sampled by luminance.
    pub cell: u32,
    /// Time within the shutter, 0..=1, for lights that move.
    pub time: f32,
}

/// No cell.
pub const NO_CELL: u32 = u32::MAX;

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
    /// For each light, its path from the root: two bits per level, the root's in the lowest bits.
    paths: Vec<u64>,
    /// Nodes are in tree space: (x − origin) · scale.
    origin: DVec3,
    scale: f64,
}

impl LightTree {
    /// The largest number of lights; such a tree takes about 400 MB.
    pub const MOST: u32 = 1 << 22;

    fn local(&self, p: DVec3) -> [f32; 3] {
        ((p - self.origin) * self.scale).as_vec3().to_array()
    }

    /// The light that `u` in 0..1 chooses, its probability, and the rescaled `u`, again in 0..1; `None` where no
    /// light can contribute.
    #[inline]
    pub fn sample(&self, at: &Receiver, u: f64) -> Option<(u32, f64, f64)> {
        self.sample_again(at, u, &mut None)
    }

    /// The same for several values of `u` at one point: `root` keeps the importances of the root's children between
    /// calls.
    #[inline]
    pub(crate) fn sample_again(
        &self,
        at: &Receiver,
        u: f64,
        root: &mut Option<[f32; WIDTH]>,
    ) -> Option<(u32, f64, f64)> {
        let p = self.local(at.p);
        let (mut child, mut probability, mut u) = (0, 1.0, u);
        while child & LEAF == 0 {
            let node = self.nodes.get(child as usize)?;
            let weights = match child {
                0 => *root.get_or_insert_with(|| node.importance(p, at)),
                _ => node.importance(p, at),
            };
            let weights = weights.map(f64::from);
            let sum = weights.iter().sum::<f64>();
            if !(sum > 0.0 && sum < f64::INFINITY) {
                return None;
            }
            let target = u * sum;
            // If rounding moves the target past the end, the last child with a weight above 0 is taken. Which it is no
            // processor can predict: there are no branches.
            let (mut lane, mut before, mut passed) = (0, 0.0, 0.0);
            for (i, w) in weights.into_iter().enumerate() {
                let takes = w > 0.0 && (target >= passed || passed == 0.0);
                lane = std::hint::select_unpredictable(takes, i, lane);
                before = std::hint::select_unpredictable(takes, passed, before);
                passed += w;
            }
            let weight = weights[lane];
            probability *= weight / sum;
            u = ((target - before) / weight).clamp(0.0, 1.0 - f64::EPSILON);
            child = node.child[lane];
        }
        Some((child & !LEAF, probability, u))
    }

    /// The probability with which `sample` chooses a light; 0 for an index out of range.
    #[inline]
    pub fn probability(&self, at: &Receiver, light: u32) -> f64 {
        let Some(&(mut path)) = self.paths.get(light as usize) else { return 0.0 };
        let p = self.local(at.p);
        let (mut child, mut probability) = (0, 1.0);
        while child & LEAF == 0 {
            let Some(node) = self.nodes.get(child as usize) else { return 0.0 };
            let weights = node.importance(p, at).map(f64::from);
            let sum = weights.iter().sum::<f64>();
            if !(sum > 0.0 && sum < f64::INFINITY) {
                return 0.0;
            }
            let lane = (path & 3) as usize;
            path >>= 2;
            probability *= weights[lane] / sum;
            child = node.child[lane];
        }
        probability
    }

    /// Memory in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.paths[..])
    }
}

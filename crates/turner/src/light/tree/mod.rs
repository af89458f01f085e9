//! A choice among thousands of lights by what they bring to a point: a tree of bounds, descended with one random number.
//!
//! After Conty Estevez and Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting", without the splitting:
//! each node bounds where its lights are, where they shine to and how strongly, and the way down is chosen in proportion to the most that
//! each child may bring to the point, for the surface that it lies on. Here nodes have four children, whose bounds are
//! looked at together.
//!
//! Memory: 192 bytes a node, of which there is about one for two to three lights, and 8 bytes a light.

mod build;
mod node;
#[cfg(test)]
mod tests;

pub(crate) use crate::material::GlossyLobe;
pub(crate) use node::WIDTH;
use node::{LEAF, Node};

use crate::math::DVec3;

/// A point that is lit, and what its surface faces.
#[derive(Default, Clone, Copy, Debug, PartialEq)]
pub struct Receiver {
    /// The point.
    pub p: DVec3,
    /// The unit normal, on the only side from which light counts; 0 if it counts from everywhere.
    pub n: [f32; 3],
    /// Where the surface reflects more than elsewhere.
    pub lobe: GlossyLobe,
    /// How many more lights than one are looked at here, of which one is taken.
    pub extra_candidates: u32,
}

impl Receiver {
    /// The same point, of a surface that reflects more around an axis.
    #[inline]
    pub fn with_lobe(self, lobe: GlossyLobe) -> Receiver {
        Receiver { lobe, ..self }
    }

    /// A point of a surface that only light on the side of the unit normal `n` reaches.
    #[inline]
    pub fn facing(p: DVec3, n: DVec3) -> Receiver {
        Receiver { n: n.as_vec3().to_array(), ..Receiver::from(p) }
    }

    /// The same point, where so many more lights than one are looked at.
    #[inline]
    pub fn with_more(self, extra_candidates: u32) -> Receiver {
        Receiver { extra_candidates, ..self }
    }

    /// How many lights are looked at.
    #[inline]
    pub fn candidates(&self) -> f64 {
        f64::from(self.extra_candidates) + 1.0
    }
}

impl From<DVec3> for Receiver {
    /// Light counts from everywhere.
    #[inline]
    fn from(p: DVec3) -> Receiver {
        Receiver { p, n: [0.0; 3], lobe: GlossyLobe::default(), extra_candidates: 0 }
    }
}

/// The tree over lights, which are called by their numbers.
#[derive(Clone, Debug)]
pub struct LightTree {
    /// The first is the root; children stand behind their parents.
    nodes: Vec<Node>,
    /// For each light the way to it from the root: two bits a level, the lowest first.
    paths: Vec<u64>,
    /// Nodes hold (x − origin) · scale.
    origin: DVec3,
    scale: f64,
}

impl LightTree {
    /// The most lights that a tree may have: it then takes some 400 MB.
    pub const MOST: u32 = 1 << 22;

    fn local(&self, p: DVec3) -> [f32; 3] {
        ((p - self.origin) * self.scale).as_vec3().to_array()
    }

    /// The light that `u` in 0..1 chooses, the probability of that, and what is left of `u`, again in 0..1; `None` where none
    /// brings any light.
    #[inline]
    pub fn sample(&self, at: &Receiver, u: f64) -> Option<(u32, f64, f64)> {
        self.sample_again(at, u, &mut None)
    }

    /// The same, for one of several numbers at a point: what is known from the one before is kept in `root`.
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
            let (mut lane, mut before, mut passed) = (0, 0.0, 0.0);
            for (i, w) in weights.into_iter().enumerate() {
                // The last that is not 0, should rounding leave the target beyond them.
                if w > 0.0 && (target >= passed || passed == 0.0) {
                    (lane, before) = (i, passed);
                }
                passed += w;
            }
            let weight = weights[lane];
            probability *= weight / sum;
            u = ((target - before) / weight).clamp(0.0, 1.0 - f64::EPSILON);
            child = node.child[lane];
        }
        Some((child & !LEAF, probability, u))
    }

    /// The probability with which `sample` chooses a light; 0 for a number beyond the last.
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

    /// Bytes of memory.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.paths[..])
    }
}

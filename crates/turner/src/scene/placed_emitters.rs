//! Emitters at finite positions in a light tree: lights, shapes, and single triangles of meshes and points of clouds.

use crate::light::{LightBound, LightTree, Receiver};
use crate::scene::Scene;
use crate::scene::emitters::{Emitter, NONE};

/// The tree is used for at least this many emitters, or this many parts of one emitter: a mesh of few triangles is
/// sampled better by its own table.
const FEWEST: usize = 2;
const FEWEST_PARTS: u32 = 64;

/// How a light is chosen for a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightChoice {
    /// With the tree if several emitters have positions, else with the table.
    Auto,
    /// With one table for all points of the scene.
    Table,
    /// With the tree, however few emitters have positions.
    Tree,
}

/// The tree, and the emitters of its leaves.
#[derive(Clone, Debug)]
pub(crate) struct PlacedEmitters {
    tree: LightTree,
    /// For each leaf its emitter and, for meshes and clouds, the triangle or point; else [`NONE`].
    parts: Vec<(u32, u32)>,
    /// For each emitter its first leaf; [`NONE`] for emitters outside the tree.
    first: Vec<u32>,
}

/// Whether the parts of a mesh or cloud are separate leaves, rather than one.
fn has_leaf_per_part(count: u32, part_limit: u32) -> bool {
    count <= part_limit
}

impl PlacedEmitters {
    /// `None` if the tree does not pay or memory is short. `powers` has the power of each emissive shape, by emitter.
    /// Shapes whose parts are leaves lose their own table.
    pub(crate) fn new(
        scene: &Scene,
        emitters: &mut [Emitter],
        powers: &[f64],
        how: LightChoice,
    ) -> Option<PlacedEmitters> {
        let counts: Vec<u32> = emitters.iter().map(|e| e.parts(scene)).collect();
        // With too many parts, the largest meshes become single leaves with their own table.
        let mut part_limit = LightTree::MOST;
        let total = |part_limit: u32| {
            let part = |count: &u32| if has_leaf_per_part(*count, part_limit) { *count } else { 1 };
            counts.iter().map(|count| u64::from(part(count))).sum::<u64>()
        };
        while part_limit > 1 && total(part_limit) > u64::from(LightTree::MOST) {
            part_limit /= 2;
        }
        let count = u32::try_from(total(part_limit)).ok().filter(|n| *n <= LightTree::MOST)?;
        let emitting = counts.iter().filter(|count| **count > 0).count();
        let use_tree = match how {
            LightChoice::Auto => emitting >= FEWEST || count >= FEWEST_PARTS,
            LightChoice::Tree => emitting > 0,
            LightChoice::Table => false,
        };
        if !use_tree {
            return None;
        }
        let mut parts = Vec::new();
        parts.try_reserve_exact(count as usize).ok()?;
        let mut first = Vec::new();
        first.try_reserve_exact(emitters.len()).ok()?;
        for (i, (emitter, &count)) in emitters.iter().zip(&counts).enumerate() {
            first.push(if count == 0 { NONE } else { parts.len() as u32 });
            match (emitter, count) {
                (_, 0) => {}
                (Emitter::Shape(shape), count)
                    if shape.has_parts() && has_leaf_per_part(count, part_limit) =>
                {
                    parts.extend((0..count).map(|position| (i as u32, shape.part_at(position))));
                }
                _ => parts.push((i as u32, NONE)),
            }
        }
        let tree = {
            let bound = |light: u32| {
                let (i, part) = parts[light as usize];
                let position = light - first[i as usize];
                emitters[i as usize].bound(scene, powers[i as usize], part, position)
            };
            LightTree::new(count, bound)?
        };
        for (emitter, &count) in emitters.iter_mut().zip(&counts) {
            if let Emitter::Shape(shape) = emitter
                && has_leaf_per_part(count, part_limit)
            {
                shape.drop_part_table();
            }
        }
        Some(PlacedEmitters { tree, parts, first })
    }

    /// Whether an emitter is in the tree.
    pub(crate) fn holds(&self, emitter: u32) -> bool {
        self.first.get(emitter as usize).is_some_and(|first| *first != NONE)
    }

    /// The tree, whose lights are the leaves.
    pub(crate) fn tree(&self) -> &LightTree {
        &self.tree
    }

    /// The emitter of a leaf, and its part or [`NONE`].
    #[inline]
    pub(crate) fn leaf(&self, light: u32) -> Option<(u32, u32)> {
        self.parts.get(light as usize).copied()
    }

    /// The probability with which the tree gives an emitter and the part at this position; and whether a part was
    /// chosen.
    #[inline]
    pub(crate) fn probability(&self, at: &Receiver, emitter: u32, position: u32) -> (f64, bool) {
        let Some(&first) = self.first.get(emitter as usize).filter(|first| **first != NONE) else {
            return (0.0, false);
        };
        let single_leaf = self.parts.get(first as usize).is_some_and(|(_, part)| *part == NONE);
        let light = if single_leaf { first } else { first.saturating_add(position) };
        match self.parts.get(light as usize) {
            Some((of, _)) if *of == emitter => (self.tree.probability(at, light), !single_leaf),
            _ => (0.0, false),
        }
    }

    /// Memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.tree.bytes() + size_of_val(&self.parts[..]) + size_of_val(&self.first[..])
    }
}

impl Emitter {
    /// How many leaves it has in a tree; 0 if it has no finite position.
    fn parts(&self, scene: &Scene) -> u32 {
        match self {
            Emitter::Light(i) => {
                scene.lights.get(*i as usize).and_then(|light| light.bound()).is_some().into()
            }
            Emitter::Shape(shape) => shape.parts(),
        }
    }

    /// The bounds of a part, which has this position among all, or of the complete emitter if `part` is [`NONE`].
    fn bound(&self, scene: &Scene, power: f64, part: u32, position: u32) -> LightBound {
        let bound = match self {
            Emitter::Light(i) => scene.light_bound(*i),
            Emitter::Shape(shape) => shape.bound(scene, power, part, position),
        };
        // Non-finite bounds count as being anywhere.
        bound.unwrap_or(LightBound::everywhere(crate::math::DVec3::NAN, 0.0, power))
    }
}

//! Emitters with a place, gathered in a light tree: lights, shapes, and each triangle of a mesh and point of a cloud by itself.

use crate::light::{LightBound, LightTree, Receiver, TREE_WIDTH};
use crate::scene::Scene;
use crate::scene::emitters::{Emitter, NONE};

/// So many emitters with a place must there be to be chosen from, or so many parts of one: a mesh of few triangles is sampled better as a whole.
const FEWEST: usize = 2;
const FEWEST_PARTS: u32 = 64;

/// How a light is chosen for a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightChoice {
    /// By the tree where there are several with a place, else by the table.
    Auto,
    /// By one table for all points of the scene.
    Table,
    /// Those with a place by the tree, however few.
    Tree,
}

/// The tree, and what its lights stand for.
#[derive(Clone, Debug)]
pub(crate) struct PlacedEmitters {
    tree: LightTree,
    /// For each light of the tree its emitter and, of a mesh or a cloud, the triangle or point, else [`NONE`].
    parts: Vec<(u32, u32)>,
    /// For each emitter its first light of the tree; [`NONE`] for those that are not in it.
    first: Vec<u32>,
}

/// Of a mesh or a cloud in the tree: whether its parts are, or it is as a whole.
fn stands_in_parts(count: u32, most: u32) -> bool {
    count <= most
}

impl PlacedEmitters {
    /// Of emitters with a place there are many, and memory for them; with the power of each shape, by emitter. What stands in the tree by its parts needs
    /// no choice among them any more.
    pub(crate) fn new(
        scene: &Scene,
        emitters: &mut [Emitter],
        powers: &[f64],
        how: LightChoice,
    ) -> Option<PlacedEmitters> {
        let counts: Vec<u32> = emitters.iter().map(|e| e.parts(scene)).collect();
        // Where they are too many, the largest meshes stand in the tree as a whole, and choose by themselves.
        let mut most = LightTree::MOST;
        let total = |most: u32| {
            let part = |count: &u32| if stands_in_parts(*count, most) { *count } else { 1 };
            counts.iter().map(|count| u64::from(part(count))).sum::<u64>()
        };
        while most > 1 && total(most) > u64::from(LightTree::MOST) {
            most /= 2;
        }
        let count = u32::try_from(total(most)).ok().filter(|n| *n <= LightTree::MOST)?;
        let emitting = counts.iter().filter(|count| **count > 0).count();
        let pays = match how {
            LightChoice::Auto => emitting >= FEWEST || count >= FEWEST_PARTS,
            LightChoice::Tree => emitting > 0,
            LightChoice::Table => false,
        };
        if !pays {
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
                (Emitter::Shape(shape), count) if shape.has_parts() && stands_in_parts(count, most) => {
                    parts.extend((0..count).map(|place| (i as u32, shape.part_at(place))));
                }
                _ => parts.push((i as u32, NONE)),
            }
        }
        let tree = {
            let bound = |light: u32| {
                let (i, part) = parts[light as usize];
                let place = light - first[i as usize];
                emitters[i as usize].bound(scene, powers[i as usize], part, place)
            };
            LightTree::new(count, bound)?
        };
        for (emitter, &count) in emitters.iter_mut().zip(&counts) {
            if let Emitter::Shape(shape) = emitter
                && stands_in_parts(count, most)
            {
                shape.forget_choice();
            }
        }
        Some(PlacedEmitters { tree, parts, first })
    }

    /// Whether an emitter is in the tree.
    pub(crate) fn holds(&self, emitter: u32) -> bool {
        self.first.get(emitter as usize).is_some_and(|first| *first != NONE)
    }

    /// The emitter that `u` chooses for a point, its part or [`NONE`], the probability of that, and what is left of `u`; for the next choice at the point
    /// what is known of its root.
    #[inline]
    pub(crate) fn choose(
        &self,
        at: &Receiver,
        u: f64,
        root: &mut Option<[f32; TREE_WIDTH]>,
    ) -> Option<(u32, u32, f64, f64)> {
        let (light, probability, left) = self.tree.sample_again(at, u, root)?;
        let &(emitter, part) = self.parts.get(light as usize)?;
        Some((emitter, part, probability, left))
    }

    /// The probability with which that chooses an emitter, of which this is the place of the part; and whether it has chosen a part.
    #[inline]
    pub(crate) fn probability(&self, at: &Receiver, emitter: u32, place: u32) -> (f64, bool) {
        let Some(&first) = self.first.get(emitter as usize).filter(|first| **first != NONE) else {
            return (0.0, false);
        };
        let whole = self.parts.get(first as usize).is_some_and(|(_, part)| *part == NONE);
        let light = if whole { first } else { first.saturating_add(place) };
        match self.parts.get(light as usize) {
            Some((of, _)) if *of == emitter => (self.tree.probability(at, light), !whole),
            _ => (0.0, false),
        }
    }

    /// Bytes of memory.
    pub(crate) fn bytes(&self) -> usize {
        self.tree.bytes() + size_of_val(&self.parts[..]) + size_of_val(&self.first[..])
    }
}

impl Emitter {
    /// For how many lights of a tree it stands; 0 if it has no place.
    fn parts(&self, scene: &Scene) -> u32 {
        match self {
            Emitter::Light(i) => {
                scene.lights.get(*i as usize).and_then(|light| light.bound()).is_some().into()
            }
            Emitter::Shape(shape) => shape.parts(),
        }
    }

    /// The bounds of one of them: a part, at its place among all, or [`NONE`].
    fn bound(&self, scene: &Scene, power: f64, part: u32, place: u32) -> LightBound {
        let bound = match self {
            Emitter::Light(i) => scene.lights.get(*i as usize).and_then(|light| light.bound()),
            Emitter::Shape(shape) => shape.bound(scene, power, part, place),
        };
        // Anywhere.
        bound.unwrap_or(LightBound::everywhere(crate::math::DVec3::NAN, 0.0, power))
    }
}

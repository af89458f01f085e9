//! Skins (glTF 2.0 §3.7.3): linear blend skinning.
//!
//! A skin lists joints, which are nodes. Each joint has an inverse bind matrix B⁻¹, from the mesh's space to that of
//! the joint in the bind pose. With W the joint's current world matrix, a vertex p with joints j and weights w moves
//! to
//!
//! p' = Σ wⱼ Wⱼ Bⱼ⁻¹ p / Σ wⱼ.
//!
//! The result is in world space; the transform of the mesh's own node is ignored. Weights need not sum to 1.

use super::accessors::Elements;
use super::budget::Budget;
use super::buffers::Buffers;
use super::fault::{Fault, Outcome};
use super::json::{Document, Index, Primitive};
use turner::math::{DAffine3, DMat3, DVec3};

/// The joint matrices W B⁻¹ of a skin, from the mesh's bind space to world space.
pub(super) fn joint_matrices(
    document: &Document,
    buffers: &Buffers,
    skin: Index,
    world: &[DAffine3],
    budget: &Budget,
    pointer: &str,
) -> Outcome<Vec<DAffine3>> {
    let Some(json) = document.skins.get(skin.index()) else {
        return Err(Fault::dangling(pointer, "skin", skin.0, document.skins.len()));
    };
    let pointer = format!("/skins/{}", skin.0);
    let bind = match json.inverse_bind_matrices {
        Some(accessor) => {
            let elements = Elements::open(document, buffers, accessor, &pointer)?;
            let elements = elements.with_width(&[16], "inverse bind matrices")?;
            if elements.count < json.joints.len() {
                // Surplus matrices are harmless.
                elements.with_count(json.joints.len(), "one inverse bind matrix per joint")?;
            }
            Some(elements)
        }
        None => None,
    };
    let mut matrices = budget.list(json.joints.len(), &pointer)?;
    for (i, joint) in json.joints.iter().enumerate() {
        let Some(world) = world.get(joint.index()) else {
            return Err(Fault::dangling(format!("{pointer}/joints/{i}"), "node", joint.0, world.len()));
        };
        let bind = bind.as_ref().map_or(DAffine3::IDENTITY, |bind| {
            let m = bind.get::<16>(i).map(f64::from);
            let column = |c: usize| DVec3::new(m[4 * c], m[4 * c + 1], m[4 * c + 2]);
            let matrix3 = DMat3::from_cols(column(0), column(1), column(2));
            DAffine3 { matrix3, translation: column(3) }
        });
        matrices.push(*world * bind);
    }
    Ok(matrices)
}

/// Joints and weights of a primitive's vertices, in any number of sets of four.
pub(super) struct Influences<'a> {
    sets: Vec<(Elements<'a>, Elements<'a>)>,
}

impl<'a> Influences<'a> {
    /// Reads those of a primitive with `count` vertices. `open(name, accessor, pointer)` opens an attribute.
    pub(super) fn open(
        primitive: &Primitive,
        count: usize,
        pointer: &str,
        open: impl Fn(&str, Index, &str) -> Outcome<Elements<'a>>,
    ) -> Outcome<Influences<'a>> {
        let mut sets = Vec::new();
        loop {
            let [joints, weights] = ["JOINTS", "WEIGHTS"].map(|name| format!("{name}_{}", sets.len()));
            let Some(at_joints) = primitive.attributes.get(&joints) else { break };
            let pointer = format!("{pointer}/attributes/{weights}");
            let Some(at_weights) = primitive.attributes.get(&weights) else {
                return Err(Fault::at(pointer, "is missing, but the joints of this set exist"));
            };
            let open = |name: &str, accessor: &Index, what: &str| {
                open(name, *accessor, &pointer)?.with_width(&[4], what)?.with_count(count, what)
            };
            let joints = open(&joints, at_joints, "the joints of vertices")?;
            if !joints.is_unsigned() {
                let at = format!("/accessors/{}/componentType", joints.accessor.0);
                return Err(Fault::at(at, "is signed or floating-point; expected unsigned joints"));
            }
            sets.push((joints, open(&weights, at_weights, "the weights of vertices")?));
        }
        Ok(Influences { sets })
    }

    /// Whether the primitive has none.
    pub(super) fn is_empty(&self) -> bool {
        self.sets.is_empty()
    }

    /// The weighted mean of the vertex's joint matrices. A vertex whose weights sum to 0 follows its first joint.
    /// `Err` is the index of a joint that does not exist.
    pub(super) fn matrix(&self, vertex: usize, joints: &[DAffine3]) -> Result<DAffine3, u32> {
        let mut sum = 0.0;
        let mut matrix3 = DMat3::ZERO;
        let mut translation = DVec3::ZERO;
        for (numbers, weights) in &self.sets {
            let weights = weights.get::<4>(vertex);
            for (joint, weight) in numbers.indices(vertex).into_iter().zip(weights) {
                let weight = f64::from(weight);
                // Unused slots have weight 0 and an arbitrary joint index.
                if !(weight > 0.0 && weight < f64::INFINITY) {
                    continue;
                }
                let m = joints.get(joint as usize).ok_or(joint)?;
                matrix3 += m.matrix3 * weight;
                translation += m.translation * weight;
                sum += weight;
            }
        }
        if sum > 0.0 {
            return Ok(DAffine3 { matrix3: matrix3 * (1.0 / sum), translation: translation / sum });
        }
        let first = self.sets.first().map_or(0, |(numbers, _)| numbers.indices(vertex)[0]);
        joints.get(first as usize).copied().ok_or(first)
    }
}

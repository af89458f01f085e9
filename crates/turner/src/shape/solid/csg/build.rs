//! From the description of constructive solid geometry to its leaves and expression.

use super::closed::{open_edges, open_edges_bytes};
use super::expression::Expression;
use super::leaf::Leaf;
use super::{Csg, CsgPart, MAX_LEAVES, Operation, PART_BITS};
use crate::math::{Bounds, DAffine3};
use crate::schema::{ErrorCode, MaterialId, SceneError};
use crate::shape::{MeshCache, Shape, ShapeDesc};

/// What nested parts inherit.
#[derive(Clone, Copy)]
struct Inherited {
    node: u16,
    material: Option<MaterialId>,
    to_object: DAffine3,
    /// Whether they are inverted an odd number of times.
    flipped: bool,
}

/// The operation and parts of a nested operation, which becomes a part of the same expression.
fn nested(shape: &ShapeDesc) -> Option<(Operation, &[CsgPart])> {
    match shape {
        ShapeDesc::Union(d) => Some((Operation::Union, &d.parts)),
        ShapeDesc::Intersection(d) => Some((Operation::Intersection, &d.parts)),
        ShapeDesc::Difference(d) => Some((Operation::Difference, &d.parts)),
        _ => None,
    }
}

/// The bounds of an operation from those of its parts, `None` where they are unbounded.
fn combined(operation: Operation, parts: &[Option<Bounds>]) -> Option<Bounds> {
    let known = parts.iter().flatten();
    match operation {
        Operation::Union if parts.contains(&None) => None,
        Operation::Union => Some(known.fold(Bounds::EMPTY, |all, b| all.union(b))),
        Operation::Intersection | Operation::Difference | Operation::Clipped => {
            known.copied().reduce(|a, b| {
                let both = Bounds::new(a.min.max(b.min), a.max.min(b.max));
                if both.is_empty() { Bounds::EMPTY } else { both }
            })
        }
    }
}

impl Csg {
    /// Prepares an operation and its parts.
    ///
    /// Errors: no parts; a part that is not closed; more than [`MAX_LEAVES`] shapes or operations; a transform that is
    /// not invertible; those of the parts.
    pub(super) fn new(
        operation: Operation,
        parts: &[CsgPart],
        meshes: &mut MeshCache<'_>,
    ) -> Result<Csg, SceneError> {
        let mut csg = Csg {
            operation,
            leaves: Vec::new(),
            expression: Expression::default(),
            surface_leaves: 0,
            bounds: None,
            materials: Vec::new(),
        };
        let node = csg.expression.add(None, operation, false);
        let top = Inherited { node, material: None, to_object: DAffine3::IDENTITY, flipped: false };
        csg.bounds = csg.add_parts(operation, parts, &top, meshes)?;
        csg.expression.finish(csg.leaves.iter().map(|leaf| (leaf.node, leaf.inverted)));
        if csg.materials.iter().all(Option::is_none) {
            csg.materials = Vec::new();
        }
        Ok(csg)
    }

    /// Adds the parts of an operation; returns its bounds, `None` if unbounded.
    fn add_parts(
        &mut self,
        operation: Operation,
        parts: &[CsgPart],
        of: &Inherited,
        meshes: &mut MeshCache<'_>,
    ) -> Result<Option<Bounds>, SceneError> {
        if parts.is_empty() {
            let message = format!("the shape \"{}\" needs at least one part", operation.word());
            return Err(SceneError::new(ErrorCode::MissingKey, message)
                .help("add a table `[[object.parts]]` with the `type` of a shape"));
        }
        let mut bounds = Vec::with_capacity(parts.len());
        for (i, part) in parts.iter().enumerate() {
            let inverted = part.inverse != (operation == Operation::Difference && i > 0);
            let mut own = Inherited {
                node: of.node,
                material: part.material.or(of.material),
                to_object: of.to_object * part.transform.0,
                flipped: of.flipped != inverted,
            };
            if !(own.to_object.is_finite() && own.to_object.inverse().is_finite()) {
                let message = format!("the transform of a part of a {} is not invertible", operation.word());
                return Err(SceneError::new(ErrorCode::Transform, message));
            }
            let inner = match nested(&part.shape) {
                Some((inner, parts)) => {
                    own.node = self.expression.add(Some(of.node), inner, inverted);
                    self.add_parts(inner, parts, &own, meshes)?
                }
                None => {
                    let may_be_open = operation == Operation::Clipped && i == 0 && of.node == 0;
                    self.add_leaf(&part.shape, operation, inverted, may_be_open, &own, meshes)?
                }
            };
            if self.leaves.len().max(self.expression.nodes()) > MAX_LEAVES {
                let message = format!(
                    "a {} has more than {MAX_LEAVES} shapes or nested operations",
                    self.operation.word()
                );
                return Err(SceneError::new(ErrorCode::TooLarge, message)
                    .help("split it into several objects, or combine the shapes in a mesh"));
            }
            bounds.push(inner.filter(|_| !inverted));
            if of.node == 0 && (i == 0 || operation != Operation::Clipped) {
                self.surface_leaves = self.leaves.len();
            }
        }
        Ok(combined(operation, &bounds))
    }

    /// Adds a shape; returns its bounds.
    fn add_leaf(
        &mut self,
        desc: &ShapeDesc,
        operation: Operation,
        inverted: bool,
        may_be_open: bool,
        of: &Inherited,
        meshes: &mut MeshCache<'_>,
    ) -> Result<Option<Bounds>, SceneError> {
        let shape = desc.prepare(meshes)?;
        let word = desc.type_name();
        if matches!(desc, ShapeDesc::Clipped(_)) {
            let message = format!("a {} cannot have a clipped shape as a part", operation.word());
            return Err(SceneError::new(ErrorCode::Conflict, message)
                .help("clip the result: make the operation the first part of a `clipped` shape"));
        }
        if !may_be_open && !shape.is_closed() {
            let message =
                format!("a {word} encloses no volume and cannot be a part of a {}", operation.word());
            return Err(SceneError::new(ErrorCode::Conflict, message).help(match desc {
                ShapeDesc::Cylinder(_) | ShapeDesc::Cone(_) => "write `capped = true`",
                ShapeDesc::Points(_) => "use spheres, or a closed mesh",
                _ => "use a closed shape such as a box, a sphere or a closed mesh",
            }));
        }
        let slots = self.materials.len();
        match (desc, &shape) {
            (desc, Shape::Mesh(mesh)) => {
                meshes.build_tree(mesh)?;
                if mesh.data().triangles.len() >> PART_BITS > 0 {
                    let message = "a mesh that is a part of another shape has more than 16,777,216 triangles";
                    return Err(SceneError::new(ErrorCode::TooLarge, message));
                }
                let open = if may_be_open {
                    0
                } else {
                    meshes.need(open_edges_bytes(mesh.data()), || {
                        "testing whether a mesh is closed".to_owned()
                    })?;
                    open_edges(mesh.data())
                };
                if open > 0 {
                    meshes.warn(format!(
                        "a {word} that is a part of a {} has {open} open edges: it does not enclose a volume, so \
                         surfaces may be missing",
                        operation.word()
                    ));
                }
                let faces = if let ShapeDesc::Mesh(desc) = desc { desc.materials.as_slice() } else { &[] };
                let own = |i: usize| faces.get(i).copied().flatten().or(of.material);
                self.materials.extend((0..mesh.data().material_count().max(1)).map(own));
            }
            _ => self.materials.push(of.material),
        }
        self.expression.add_leaf(of.node);
        let leaf = Leaf::new(shape, &of.to_object, (of.node, inverted, of.flipped), slots);
        let bounds = leaf.bounds();
        self.leaves.push(leaf);
        Ok(bounds)
    }
}

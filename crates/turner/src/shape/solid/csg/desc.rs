//! The descriptions of constructive solid geometry: `union`, `intersection`, `difference` and `clipped`, and their
//! parts.

use super::{Csg, Operation};
use crate::math::DVec3;
use crate::schema::value::{Data, Value};
use crate::schema::{
    self, MaterialId, ParamType, ReadContext, Renumber, SceneError, TableReader, Transform, WriteContext,
    params,
};
use crate::shape::solid::{PrepareSolid, Solid};
use crate::shape::{BoxDesc, CylinderDesc, MeshCache, PlaneDesc, ShapeDesc, SphereDesc};

/// A part of constructive solid geometry: a shape with a transform and a material of its own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CsgPart {
    /// The shape.
    pub shape: ShapeDesc,
    /// Its material; that of the object if there is none.
    pub material: Option<MaterialId>,
    /// From the space of the part to that of the object.
    pub transform: Transform,
    /// Whether the part is everything outside the shape.
    pub inverse: bool,
}

impl ParamType for CsgPart {
    fn kind() -> String {
        "{ type = shape, transform, material, inverse }".into()
    }

    fn read(value: &Value, cx: &mut dyn ReadContext) -> Result<CsgPart, SceneError> {
        let mut table = TableReader::of(value, "a part")?;
        let transform = table.optional::<Transform>("transform", None, cx)?.unwrap_or(Transform::IDENTITY);
        let inverse = table.optional::<bool>("inverse", None, cx)?.unwrap_or(false);
        let material = table.optional::<MaterialId>("material", None, cx)?;
        let shape =
            schema::read_kind(&mut table, ("shape", &[]), None, cx, &ShapeDesc::DOC, ShapeDesc::read)?;
        Ok(CsgPart { shape, material, transform, inverse })
    }

    fn show(&self) -> String {
        format!("a {}", self.shape.type_name())
    }

    fn write(&self, cx: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
        let mut table = self.shape.write(cx)?;
        if let Some(material) = self.material {
            table.push("material", cx.material(material)?);
        }
        if self.transform != Transform::IDENTITY {
            table.push("transform", self.transform.write(cx)?);
        }
        if self.inverse {
            table.push("inverse", Data::Bool(true));
        }
        Ok(Some(Data::Table(table)))
    }

    fn renumber(&mut self, by: &Renumber) {
        self.shape.renumber(by);
        self.material.renumber(by);
    }
}

/// The parts that a new object begins with.
fn parts_of(shapes: [ShapeDesc; 2]) -> Vec<CsgPart> {
    shapes.map(|shape| CsgPart { shape, ..CsgPart::default() }).into()
}

fn sphere(radius: f64) -> ShapeDesc {
    ShapeDesc::Sphere(SphereDesc { radius, ..SphereDesc::default() })
}

fn cube() -> ShapeDesc {
    ShapeDesc::Box(BoxDesc::default())
}

fn cylinder() -> ShapeDesc {
    ShapeDesc::Cylinder(CylinderDesc {
        to: DVec3::new(0.0, 1.5, 0.0),
        radius: 0.4,
        ..CylinderDesc::default()
    })
}

fn half_space() -> ShapeDesc {
    ShapeDesc::Plane(PlaneDesc { point: DVec3::new(0.0, 0.3, 0.0), ..PlaneDesc::default() })
}

params! {
    /// The union of closed shapes: everything that is inside at least one part. Surfaces inside other parts are
    /// removed, so that glass has no inner walls. A part may have its own `material`; parts without one have that of
    /// the object. (u, v) are those of the part. Faces of two parts that coincide are crossed at once: two boxes side
    /// by side have no wall between them, and where two parts share a face it has the material of the first.
    pub struct UnionDesc as "union" {
        /// The parts: tables `[[object.parts]]` with the `type` and the keys of a shape, and optionally `transform`,
        /// `material` and `inverse` (everything outside the shape). Parts must be closed: spheres, boxes, capped
        /// cylinders and cones, tori, closed meshes, other solids, and planes, whose inside is the half-space that
        /// the normal points away from.
        parts: Vec<CsgPart>, required, default parts_of([sphere(1.0), cylinder()]);
    }
    example r#"[[object]]
type = "union"
material = { color = "steelblue" }

[[object.parts]]
type = "sphere"
radius = 1

[[object.parts]]
type = "cylinder"
from = [0, 0, 0]
to = [0, 2, 0]
radius = 0.4
"#
}

params! {
    /// The intersection of closed shapes: everything that is inside all parts. For materials, (u, v) and faces that
    /// coincide, see `union`.
    pub struct IntersectionDesc as "intersection" {
        /// The parts, as for `union`.
        parts: Vec<CsgPart>, required, default parts_of([cube(), sphere(1.3)]);
    }
    example r#"[[object]]
type = "intersection"
material = { color = "gold" }

[[object.parts]]
type = "sphere"
center = [-0.5, 0, 0]

[[object.parts]]
type = "sphere"
center = [0.5, 0, 0]
"#
}

params! {
    /// A closed shape without others: everything that is inside the first part and outside all other parts. Cut faces
    /// have the material of the part that cuts, or that of the object if it has none. A part that ends exactly at a
    /// face of the first part leaves no skin there. For (u, v), see `union`.
    pub struct DifferenceDesc as "difference" {
        /// The parts, as for `union`: first the shape, then those that are taken away from it.
        parts: Vec<CsgPart>, required, default parts_of([cube(), sphere(1.3)]);
    }
    example r#"[[object]]
type = "difference"
material = { color = "peru" }

[[object.parts]]
type = "box"
size = [2, 2, 2]

[[object.parts]]
type = "sphere"
radius = 1.3
material = { color = "white" }
"#
}

params! {
    /// A shape of which only what is inside other shapes is left. Unlike an intersection it stays open: there are no
    /// cut faces. The first part may be any shape, the others must be closed.
    pub struct ClippedDesc as "clipped" {
        /// The parts, as for `union`: first the shape, then those that clip it. `inverse = true` keeps what is outside
        /// a part.
        parts: Vec<CsgPart>, required, default parts_of([sphere(1.0), half_space()]);
    }
    example r#"[[object]]
type = "clipped"
material = { color = "crimson" }

[[object.parts]]
type = "sphere"

[[object.parts]]
type = "plane"
point = [0, 0.3, 0]
normal = [0, 1, 0]
"#
}

macro_rules! prepare_parts {
    ($($ty:ident => $operation:expr,)+) => {$(
        impl PrepareSolid for $ty {
            fn prepare_solid(&self, meshes: &mut MeshCache<'_>) -> Result<Solid, SceneError> {
                Csg::new($operation, &self.parts, meshes).map(Solid::Csg)
            }
        }
    )+};
}

prepare_parts! {
    UnionDesc => Operation::Union,
    IntersectionDesc => Operation::Intersection,
    DifferenceDesc => Operation::Difference,
    ClippedDesc => Operation::Clipped,
}

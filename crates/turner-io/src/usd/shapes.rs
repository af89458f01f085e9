//! Shapes with a formula: spheres, boxes, cylinders, cones, capsules and rectangles (UsdGeomGprim).

use turner::description::ObjectContent;
use turner::math::{DAffine3, DVec3};
use turner::schema::WarningKind;
use turner::shape::solid::{SphereSweepDesc, SweepPath};
use turner::shape::{BoxDesc, ConeDesc, CylinderDesc, RectangleDesc, ShapeDesc, SphereDesc};

use super::primvars::{Per, read};
use super::scene::{Scene, State};
use super::stage::Prim;
use super::value::{Read, Value};
use crate::scene_import::report::Fault;

/// The axis of a shape, and the two after it.
pub(super) fn axes(scene: &Scene<'_>, prim: &Prim, otherwise: &str) -> Read<[DVec3; 3]> {
    let word = scene.stage.value(prim, "axis")?;
    Ok(match word.as_ref().and_then(Value::text).unwrap_or(otherwise) {
        "X" => [DVec3::X, DVec3::Y, DVec3::Z],
        "Y" => [DVec3::Y, DVec3::Z, DVec3::X],
        _ => [DVec3::Z, DVec3::X, DVec3::Y],
    })
}

/// A number of a prim that is greater than 0.
fn size(scene: &Scene<'_>, prim: &Prim, name: &str, otherwise: f64) -> Read<Option<f64>> {
    let v = scene.stage.value(prim, name)?.as_ref().and_then(Value::real).unwrap_or(otherwise);
    Ok((v > 0.0 && v.is_finite()).then_some(v))
}

/// The shape of a prim; `None` if it has no size.
fn shape(scene: &Scene<'_>, prim: &Prim, kind: &str) -> Read<Option<ShapeDesc>> {
    let number = |name, otherwise| size(scene, prim, name, otherwise);
    let [axis, ..] = axes(scene, prim, "Z")?;
    Ok(match kind {
        "Sphere" => {
            number("radius", 1.0)?.map(|radius| ShapeDesc::Sphere(SphereDesc { center: DVec3::ZERO, radius }))
        }
        "Cube" => number("size", 2.0)?.map(|size| {
            let desc =
                BoxDesc { center: Some(DVec3::ZERO), size: Some(DVec3::splat(size)), min: None, max: None };
            ShapeDesc::Box(desc)
        }),
        "Cylinder" => match (number("height", 2.0)?, number("radius", 1.0)?) {
            (Some(height), Some(radius)) => {
                let end = axis * (0.5 * height);
                Some(ShapeDesc::Cylinder(CylinderDesc { from: -end, to: end, radius, capped: true }))
            }
            _ => None,
        },
        "Cylinder_1" => {
            let ends = number("radiusBottom", 1.0)?.zip(number("radiusTop", 1.0)?);
            ends.zip(number("height", 2.0)?).map(|((radius, tip_radius), height)| {
                let end = axis * (0.5 * height);
                ShapeDesc::Cone(ConeDesc { from: -end, to: end, radius, tip_radius, capped: true })
            })
        }
        "Cone" => match (number("height", 2.0)?, number("radius", 1.0)?) {
            (Some(height), Some(radius)) => {
                let end = axis * (0.5 * height);
                Some(ShapeDesc::Cone(ConeDesc { from: -end, to: end, radius, tip_radius: 0.0, capped: true }))
            }
            _ => None,
        },
        "Capsule" | "Capsule_1" => {
            let names = if kind == "Capsule" { ["radius"; 2] } else { ["radiusBottom", "radiusTop"] };
            let ends = number(names[0], 0.5)?.zip(number(names[1], 0.5)?);
            ends.zip(number("height", 1.0)?).map(|((bottom, top), height)| {
                let end = axis * (0.5 * height);
                let sphere = |c: DVec3, radius| [c.x, c.y, c.z, radius];
                let spheres = vec![sphere(-end, bottom), sphere(end, top)];
                ShapeDesc::SphereSweep(SphereSweepDesc { spheres, path: SweepPath::Linear })
            })
        }
        _ => {
            let [_, u, v] = axes(scene, prim, "Z")?;
            let (width, length) = (number("width", 2.0)?, number("length", 2.0)?);
            // The normal is the axis: the width lies along x, or z for the axis X; the length along y, or z for Y.
            let (edge_u, edge_v) = match axis {
                axis if axis == DVec3::Z => (u, v),
                _ => (v, -u),
            };
            width.zip(length).map(|(width, length)| {
                let desc =
                    RectangleDesc { center: DVec3::ZERO, edge_u: edge_u * width, edge_v: edge_v * length };
                ShapeDesc::Rectangle(desc)
            })
        }
    })
}

/// Adds a shape.
pub(super) fn add(scene: &mut Scene<'_>, prim: &Prim, kind: &str, state: &State) -> Result<(), Fault> {
    let Some(shape) = shape(scene, prim, kind)? else {
        scene.warn(WarningKind::Doubtful, format!("a {kind} whose size is not greater than 0: omitted"));
        return Ok(());
    };
    let color = read::<3>(scene.stage, prim, "primvars:displayColor", Per::Mesh)?;
    let color = color.and_then(|c| c.values.first().copied());
    let material = scene.material_or_color(state.material.as_deref(), color)?;
    // u of Turner's round shapes begins at −z, for an upright axis; USD does not give them (u, v).
    let transform: DAffine3 = state.transform;
    scene.place(ObjectContent::Shape(shape), Some(material), prim, transform)
}

//! Spheres, disks and cylinders. Full ones that face outwards keep their type; others become triangles with
//! exact normals.

use super::super::assembly::Assembly;
use super::super::params::Params;
use super::super::report::Fault;
use super::super::state::State;
use super::{Made, orient};
use crate::scene_import::{ALONG, AROUND, Surface, upright};
use std::f64::consts::{PI, TAU};
use turner::math::elementary::acos;
use turner::math::{DAffine3, DMat3, DVec3, radians};
use turner::shape::{CylinderDesc, DiskDesc, ShapeDesc, SphereDesc};

/// `sphere`, `disk`, `cylinder`.
pub(super) fn quadric(
    scene: &mut Assembly<'_>,
    state: &State,
    name: &str,
    params: &Params,
) -> Result<Made, Fault> {
    let positive = |v: f64| v.is_finite() && v > 0.0;
    let radius = params.float("radius").unwrap_or(1.0);
    let phi = params.float("phimax").unwrap_or(360.0).clamp(0.0, 360.0);
    let place = params.place;
    if !positive(radius) {
        scene.report.doubtful(place, "a shape whose radius is not greater than 0: omitted");
        params.pass(&["zmin", "zmax", "height", "innerradius"]);
        return Ok(Made::Nothing);
    }
    let whole = phi >= 360.0 && !state.reverse;
    let surface = match name {
        "sphere" => {
            let (zmin, zmax) =
                (params.float("zmin").unwrap_or(-radius), params.float("zmax").unwrap_or(radius));
            let (zmin, zmax) = (zmin.min(zmax).max(-radius), zmax.max(zmin).min(radius));
            if whole && zmin <= -radius && zmax >= radius {
                let sphere = SphereDesc { center: DVec3::ZERO, radius };
                return Ok(Made::Shape(ShapeDesc::Sphere(sphere), upright()));
            }
            Surface::Sphere {
                radius,
                from: acos((zmin / radius).clamp(-1.0, 1.0)),
                to: acos((zmax / radius).clamp(-1.0, 1.0)),
            }
        }
        "disk" => {
            let height = params.float("height").unwrap_or(0.0);
            let inner = params.float("innerradius").unwrap_or(0.0).clamp(0.0, radius);
            if phi >= 360.0 && inner < radius {
                let normal = if state.reverse { DVec3::NEG_Z } else { DVec3::Z };
                let disk = DiskDesc { center: DVec3::Z * height, normal, radius, inner_radius: inner };
                return Ok(Made::Shape(ShapeDesc::Disk(disk), DAffine3::IDENTITY));
            }
            Surface::Disk { radius, inner, height }
        }
        _ => {
            let (zmin, zmax) = (params.float("zmin").unwrap_or(-1.0), params.float("zmax").unwrap_or(1.0));
            if whole && zmin < zmax {
                let cylinder =
                    CylinderDesc { from: DVec3::Y * zmin, to: DVec3::Y * zmax, radius, capped: false };
                return Ok(Made::Shape(ShapeDesc::Cylinder(cylinder), upright()));
            }
            Surface::Cylinder { radius, from: zmin, to: zmax }
        }
    };
    let message = "a partial or reversed sphere, disk or cylinder: rendered as triangles";
    scene.report.approximated(place, message);
    // Equal shapes share a mesh. The key is no file name.
    let key = (format!("\0{surface:?} {phi}"), state.reverse);
    if let Some(&Some(known)) = scene.mesh_ids.get(&key) {
        return Ok(Made::Shared(known));
    }
    scene.divide(u64::from(AROUND + 1) * u64::from(ALONG + 1), place)?;
    let mut data = surface.cut(radians(phi));
    orient(&mut data, state.reverse);
    let id = scene.mesh(String::new(), data);
    scene.mesh_ids.insert(key, Some(id));
    Ok(Made::Shared(id))
}

/// The area of a shape under a transform; approximate for an ellipsoid.
pub(super) fn area(shape: &ShapeDesc, m: &DMat3) -> f64 {
    let scale = m.determinant().abs();
    let even = turner::math::elementary::cbrt(scale);
    match shape {
        ShapeDesc::Sphere(s) => 4.0 * PI * s.radius * s.radius * even * even,
        ShapeDesc::Disk(d) => {
            let own = PI * (d.radius * d.radius - d.inner_radius * d.inner_radius);
            own * (*m * DVec3::X).cross(*m * DVec3::Y).length()
        }
        ShapeDesc::Cylinder(c) => TAU * c.radius * (c.to - c.from).length() * even * even,
        _ => 1.0,
    }
}

//! Spheres, disks, cylinders, and the quadrics of pbrt-v3: cones, paraboloids, hyperboloids. Full spheres, disks and
//! cylinders that face outwards keep their type; all others become triangles with exact normals.

use super::super::assembly::Assembly;
use super::super::params::Params;
use super::super::report::Fault;
use super::super::state::State;
use super::default_uvs;
use super::light_parts::LightParts;
use super::{Made, orient};
use crate::scene_import::{ALONG, AROUND, Surface, upright};
use turner::math::elementary::acos;
use turner::math::{DAffine3, DVec3, radians};
use turner::shape::{CylinderDesc, DiskDesc, ShapeDesc, SphereDesc};

/// `sphere`, `disk`, `cylinder`, `cone`, `paraboloid`, `hyperboloid`.
pub(super) fn quadric(
    scene: &mut Assembly<'_>,
    state: &State,
    name: &str,
    params: &Params,
) -> Result<Made, Fault> {
    if name == "hyperboloid" {
        return hyperboloid(scene, state, params);
    }
    let positive = |v: f64| v.is_finite() && v > 0.0;
    let radius = params.float("radius").unwrap_or(1.0);
    let phi = params.float("phimax").unwrap_or(360.0).clamp(0.0, 360.0);
    let place = params.place;
    if !positive(radius) {
        scene.report.doubtful(place, "a shape whose radius is not greater than 0: omitted");
        params.pass(&["zmin", "zmax", "height", "innerradius", "phimax"]);
        return Ok(Made::Nothing);
    }
    let whole = phi >= 360.0 && !state.reverse;
    let around = radians(phi) * radius;
    let (surface, area) = match name {
        "sphere" => {
            let (zmin, zmax) =
                (params.float("zmin").unwrap_or(-radius), params.float("zmax").unwrap_or(radius));
            let (zmin, zmax) = (zmin.min(zmax).max(-radius), zmax.max(zmin).min(radius));
            let area = around * (zmax - zmin);
            if whole && zmin <= -radius && zmax >= radius {
                let sphere = SphereDesc { center: DVec3::ZERO, radius };
                return Ok(Made::Shape(ShapeDesc::Sphere(sphere), upright(), area));
            }
            let [from, to] = [zmin, zmax].map(|z| acos((z / radius).clamp(-1.0, 1.0)));
            (Surface::Sphere { radius, from, to }, area)
        }
        "disk" => {
            let height = params.float("height").unwrap_or(0.0);
            let inner = params.float("innerradius").unwrap_or(0.0).clamp(0.0, radius);
            let area = 0.5 * radians(phi) * (radius * radius - inner * inner);
            // Turner's azimuth is counter-clockwise around the normal.
            let is_mirrored = state.reverse && default_uvs::are_used(scene, state, None);
            if phi >= 360.0 && inner < radius && !is_mirrored {
                let normal = if state.reverse { DVec3::NEG_Z } else { DVec3::Z };
                let center = DVec3::Z * height;
                let disk = DiskDesc { center, normal, radius, inner_radius: inner, polar: true };
                return Ok(Made::Shape(ShapeDesc::Disk(disk), DAffine3::IDENTITY, area));
            }
            (Surface::Disk { radius, inner, height }, area)
        }
        "cone" => {
            let height = params.float("height").unwrap_or(1.0);
            let area = 0.5 * around * (height * height + radius * radius).sqrt();
            (Surface::Cone { radius, height }, area)
        }
        "paraboloid" => {
            let (zmin, zmax) = (params.float("zmin").unwrap_or(0.0), params.float("zmax").unwrap_or(1.0));
            let (from, to) = (zmin.min(zmax).max(0.0), zmin.max(zmax).max(1e-9));
            // The area of a surface of revolution between two heights.
            let k = 4.0 * to / (radius * radius);
            let power = |z: f64| (k * z + 1.0) * (k * z + 1.0).sqrt();
            let area = radians(phi) * radius * radius * radius * radius / (12.0 * to * to)
                * (power(to) - power(from));
            (Surface::Paraboloid { radius, from, to }, area)
        }
        _ => {
            let (zmin, zmax) = (params.float("zmin").unwrap_or(-1.0), params.float("zmax").unwrap_or(1.0));
            let area = around * (zmax - zmin).abs();
            if whole && zmin < zmax {
                let cylinder =
                    CylinderDesc { from: DVec3::Y * zmin, to: DVec3::Y * zmax, radius, capped: false };
                return Ok(Made::Shape(ShapeDesc::Cylinder(cylinder), upright(), area));
            }
            (Surface::Cylinder { radius, from: zmin, to: zmax }, area)
        }
    };
    cut(scene, state, params, surface, [phi, area])
}

/// `hyperboloid`: the surface that the line from `p1` to `p2` sweeps as it rotates about the z axis.
fn hyperboloid(scene: &mut Assembly<'_>, state: &State, params: &Params) -> Result<Made, Fault> {
    let from = params.vector("p1").unwrap_or(DVec3::ZERO);
    let to = params.vector("p2").unwrap_or(DVec3::ONE);
    let phi = params.float("phimax").unwrap_or(360.0).clamp(0.0, 360.0);
    // By the trapezoidal rule; it counts only for lights with a power.
    let around = |v: f64| (from + (to - from) * v).truncate().length();
    let area = radians(phi) * 0.5 * (around(0.0) + around(1.0)) * (to - from).length();
    cut(scene, state, params, Surface::Hyperboloid { from, to }, [phi, area])
}

/// A surface as triangles over azimuths from 0 to `phi` degrees.
fn cut(
    scene: &mut Assembly<'_>,
    state: &State,
    params: &Params,
    surface: Surface,
    [phi, area]: [f64; 2],
) -> Result<Made, Fault> {
    let place = params.place;
    let message = "a quadric that is partial, reversed, or of pbrt-v3 alone: rendered as triangles";
    scene.report.approximated(place, message);
    // Equal shapes share a mesh. The key is no file name.
    let key = (format!("\0{surface:?} {phi}"), state.reverse);
    if let Some(&Some(known)) = scene.mesh_ids.get(&key) {
        return Ok(Made::Shared(known, LightParts::Whole(area)));
    }
    scene.divide(u64::from(AROUND + 1) * u64::from(ALONG + 1), place)?;
    let mut data = surface.cut(radians(phi));
    orient(&mut data, state.reverse);
    let id = scene.mesh(String::new(), data);
    scene.mesh_ids.insert(key, Some(id));
    Ok(Made::Shared(id, LightParts::Whole(area)))
}

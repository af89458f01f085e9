//! Normal maps and bump maps.
//!
//! Red of a normal map is along the tangent (growing u), green along the bitangent (growing v, up in the image), blue
//! along the normal (glTF 2.0 §3.9.3).

use super::{Bump, BumpUnit, MaterialEvalContext};
use crate::color::Spectrum;
use crate::interaction::SurfaceInteraction;
use crate::math::DVec3;
use crate::schema::{ColorSource, TextureId};
use crate::texture::{Footprint, Projection};

/// Applies a normal map to the shading normal.
pub fn apply_normal_map(
    scene: &impl MaterialEvalContext,
    surface: &mut SurfaceInteraction,
    map: Option<ColorSource>,
    scale: f64,
) {
    let Some(map) = map else { return };
    if let Some(n) = mapped_normal(scene, surface, map, scale) {
        surface.ns = n;
    }
}

/// The unit normal of a normal map, on the outer side of the surface.
pub fn mapped_normal(
    scene: &impl MaterialEvalContext,
    surface: &SurfaceInteraction,
    map: ColorSource,
    scale: f64,
) -> Option<DVec3> {
    let ColorSource::Texture(id) = map else { return None };
    let normal_of = |c: Spectrum, tangent: DVec3, bitangent: DVec3| {
        let [x, y, z] = [c.r, c.g, c.b].map(|v| 2.0 * f64::from(v) - 1.0);
        scale * x * tangent + scale * y * bitangent + z * surface.ns
    };
    let own =
        scene.textures().lies_on_uv(id).then(|| scene.tangent_frame(surface, scene.textures().uv_set(id)));
    let n = match own.flatten() {
        Some((tangent, bitangent)) => {
            normal_of(scene.textures().color(map, &scene.texture_point(surface)), tangent, bitangent)
        }
        None => projected_normal(scene, surface, id, normal_of)?,
    };
    outward(n.try_normalize()?, surface.ng)
}

/// The normal from an image whose projection defines its axes.
fn projected_normal(
    scene: &impl MaterialEvalContext,
    surface: &SurfaceInteraction,
    id: TextureId,
    normal_of: impl Fn(Spectrum, DVec3, DVec3) -> DVec3,
) -> Option<DVec3> {
    let n = surface.ns;
    let x = n.any_orthonormal_vector();
    let y = n.cross(x);
    let at = scene.texture_point(surface);
    // `steps` has unit footprints, from which directions are computed; `at` has the ray's footprint, which filters the
    // colours.
    let mut steps = at;
    steps.footprint = Some(scene.footprint(surface, [x, y]));
    let mut sum = DVec3::ZERO;
    for from in scene.textures().projections(id, &steps).into_iter().flatten() {
        let Projection { weight, axes: [a, b], .. } = from;
        // a and b are the change of the image position along x and y. Tangents are the columns of the inverse matrix.
        let area = a.x * b.y - b.x * a.y;
        let tangent = ((x * b.y - y * a.y) * area.signum()).try_normalize();
        let Some(tangent) = tangent.filter(|_| area != 0.0) else { continue };
        let bitangent = n.cross(tangent) * area.signum();
        sum += weight * normal_of(scene.textures().look(id, &from, &at), tangent, bitangent);
    }
    (sum != DVec3::ZERO).then_some(sum)
}

/// Applies a bump map to the shading normal.
pub fn apply_bump_map(scene: &impl MaterialEvalContext, surface: &mut SurfaceInteraction, bump: Bump) {
    surface.ns = bumped_normal(scene, surface, bump);
}

/// The unit normal of the displaced surface, on its outer side: n − ∂h/∂x x − ∂h/∂y y (Blinn 1978, "Simulation of
/// wrinkled surfaces"). The derivatives are differences across the ray's footprint, or across a texel where that is
/// larger.
pub fn bumped_normal(scene: &impl MaterialEvalContext, surface: &SurfaceInteraction, bump: Bump) -> DVec3 {
    let n = surface.ns;
    let x = n.any_orthonormal_vector();
    let y = n.cross(x);
    let seen = f64::from(surface.seen.1);
    let mut at = scene.texture_point(&surface.sharp());
    let unit = scene.footprint(surface, [x, y]);
    at.footprint = Some(unit);
    let Some(least) = scene.textures().spacing(bump.map, &at) else { return n };
    let step = seen.max(least);
    let scaled = |by: f64| Footprint { p: unit.p.map(|d| by * d), uv: unit.uv.map(|d| by * d), ..unit };
    // Rays without a cone look up points, not filtered means.
    at.footprint = (seen > 0.0).then(|| scaled(step));
    let height = |axis: usize, by: f64| {
        let c = scene.textures().color(bump.map, &at.beside(by * unit.p[axis], by * unit.uv[axis]));
        (f64::from(c.r) + f64::from(c.g) + f64::from(c.b)) / 3.0
    };
    let slope = |axis: usize| (height(axis, 0.5 * step) - height(axis, -0.5 * step)) / step;
    let scale = match bump.unit {
        BumpUnit::Scene => bump.scale,
        BumpUnit::Tile => {
            // The area of a tile, 1 over the (u, v) area per unit of surface area.
            let [a, b] = unit.uv;
            let area = (a.x * b.y - b.x * a.y).abs();
            if area > 0.0 { bump.scale / area.sqrt() } else { 0.0 }
        }
    };
    let bumped = n - scale * (slope(0) * x + slope(1) * y);
    bumped.try_normalize().and_then(|bumped| outward(bumped, surface.ng)).unwrap_or(n)
}

/// A normal that points away from the surface's side would leak light through it: replaced by the nearest that does
/// not.
fn outward(n: DVec3, ng: DVec3) -> Option<DVec3> {
    let outer = n.dot(ng);
    if outer > 0.0 { Some(n) } else { (n - 1.001 * outer * ng).try_normalize() }
}

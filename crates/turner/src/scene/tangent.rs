//! The tangent frame of a surface, normal maps and bump maps.
//!
//! Red of a normal map leads along the tangent (growing u), green along the bitangent (growing v: upwards in the picture),
//! blue along the normal, as glTF 2.0 §3.9.3 has it.

use super::scene::{NO_TRANSFORM, Scene, SurfaceInteraction};
use super::{ColorSource, TextureId};
use crate::color::Spectrum;
use crate::material::{Bump, BumpUnit};
use crate::math::DVec3;
use crate::shape::Shape;
use crate::texture::{Footprint, Projection};

impl Scene {
    /// Unit tangent (along u) and bitangent (along v) of a surface, at right angles to its shading normal; `None` where
    /// (u, v) say nothing about directions. `uv_set` is what directions are taken from where a mesh has no tangents.
    pub fn tangent_frame(&self, surface: &SurfaceInteraction, uv_set: u32) -> Option<(DVec3, DVec3)> {
        let primitive = &self.primitives[surface.hit.primitive as usize];
        let Shape::Mesh(mesh) = &primitive.shape else { return None };
        let hit = &surface.hit.shape;
        let (tangent, bitangent) = match mesh.tangent(hit) {
            Some((tangent, side)) => {
                let bitangent = side * surface.object_normal().cross(tangent);
                (tangent, bitangent)
            }
            None => mesh.uv_directions(hit, uv_set as usize)?,
        };
        let to_world = |v: DVec3| match primitive.transform {
            NO_TRANSFORM => v,
            i => {
                let transform = &self.transforms[i as usize];
                let moved = transform.motion.as_ref().map(|m| m.at(f64::from(surface.time)));
                moved.as_ref().unwrap_or(&transform.to_world).matrix3 * v
            }
        };
        let n = surface.ns;
        let tangent = to_world(tangent);
        let tangent = (tangent - n * tangent.dot(n)).try_normalize()?;
        let side = n.cross(tangent);
        let bitangent = if side.dot(to_world(bitangent)) < 0.0 { -side } else { side };
        Some((tangent, bitangent))
    }

    /// Turns the shading normal as a normal map says.
    pub fn apply_normal_map(&self, surface: &mut SurfaceInteraction, map: Option<ColorSource>, scale: f64) {
        let Some(map) = map else { return };
        if let Some(n) = self.mapped_normal(surface, map, scale) {
            surface.ns = n;
        }
    }

    /// The normal that a normal map asks for, unit, on the outer side of the surface.
    pub fn mapped_normal(&self, surface: &SurfaceInteraction, map: ColorSource, scale: f64) -> Option<DVec3> {
        let ColorSource::Texture(id) = map else { return None };
        let normal_of = |c: Spectrum, tangent: DVec3, bitangent: DVec3| {
            let [x, y, z] = [c.r, c.g, c.b].map(|v| 2.0 * f64::from(v) - 1.0);
            scale * x * tangent + scale * y * bitangent + z * surface.ns
        };
        let own = self.textures.lies_on_uv(id).then(|| self.tangent_frame(surface, self.textures.uv_set(id)));
        let n = match own.flatten() {
            Some((tangent, bitangent)) => {
                normal_of(self.textures.color(map, &self.texture_point(surface)), tangent, bitangent)
            }
            None => self.projected_normal(surface, id, normal_of)?,
        };
        outward(n.try_normalize()?, surface.ng)
    }

    /// The normal by a picture whose mapping says where its right and its top are.
    fn projected_normal(
        &self,
        surface: &SurfaceInteraction,
        id: TextureId,
        normal_of: impl Fn(Spectrum, DVec3, DVec3) -> DVec3,
    ) -> Option<DVec3> {
        let n = surface.ns;
        let x = n.any_orthonormal_vector();
        let y = n.cross(x);
        let at = self.texture_point(surface);
        // Where directions are asked for, footprints are unit steps; where colours are, what the ray covers.
        let mut steps = at;
        steps.footprint = Some(self.footprint(surface, [x, y]));
        let mut sum = DVec3::ZERO;
        for from in self.textures.projections(id, &steps).into_iter().flatten() {
            let Projection { weight, axes: [a, b], .. } = from;
            // Columns: how the place in the picture changes along x and y. Tangents are the columns of the inverse.
            let area = a.x * b.y - b.x * a.y;
            let tangent = ((x * b.y - y * a.y) * area.signum()).try_normalize();
            let Some(tangent) = tangent.filter(|_| area != 0.0) else { continue };
            let bitangent = n.cross(tangent) * area.signum();
            sum += weight * normal_of(self.textures.look(id, &from, &at), tangent, bitangent);
        }
        (sum != DVec3::ZERO).then_some(sum)
    }

    /// Turns the shading normal as a bump map says.
    pub fn apply_bump_map(&self, surface: &mut SurfaceInteraction, bump: Bump) {
        surface.ns = self.bumped_normal(surface, bump);
    }

    /// The normal of the surface raised by heights, unit, on its outer side: n − ∂h/∂x x − ∂h/∂y y, with derivatives by differences between
    /// the edges of the ray's footprint, or of a texel where that is larger (Blinn 1978, "Simulation of wrinkled surfaces").
    pub fn bumped_normal(&self, surface: &SurfaceInteraction, bump: Bump) -> DVec3 {
        let n = surface.ns;
        let x = n.any_orthonormal_vector();
        let y = n.cross(x);
        let seen = f64::from(surface.seen.1);
        let mut at = self.texture_point(&surface.sharp());
        let unit = self.footprint(surface, [x, y]);
        at.footprint = Some(unit);
        let Some(least) = self.textures.spacing(bump.map, &at) else { return n };
        let step = seen.max(least);
        let scaled = |by: f64| Footprint { p: unit.p.map(|d| by * d), uv: unit.uv.map(|d| by * d) };
        // Only where rays have cones are there means to look up.
        at.footprint = (seen > 0.0).then(|| scaled(step));
        let height = |axis: usize, by: f64| {
            let c = self.textures.color(bump.map, &at.beside(by * unit.p[axis], by * unit.uv[axis]));
            (f64::from(c.r) + f64::from(c.g) + f64::from(c.b)) / 3.0
        };
        let slope = |axis: usize| (height(axis, 0.5 * step) - height(axis, -0.5 * step)) / step;
        let scale = match bump.unit {
            BumpUnit::Scene => bump.scale,
            BumpUnit::Tile => {
                // The area of a tile, 1 over that of (u, v) per unit of area.
                let [a, b] = unit.uv;
                let area = (a.x * b.y - b.x * a.y).abs();
                if area > 0.0 { bump.scale / area.sqrt() } else { 0.0 }
            }
        };
        let bumped = n - scale * (slope(0) * x + slope(1) * y);
        bumped.try_normalize().and_then(|bumped| outward(bumped, surface.ng)).unwrap_or(n)
    }
}

/// A normal that turns away from the surface it belongs to would make light leak through it: then the nearest that does not.
fn outward(n: DVec3, ng: DVec3) -> Option<DVec3> {
    let outer = n.dot(ng);
    if outer > 0.0 { Some(n) } else { (n - 1.001 * outer * ng).try_normalize() }
}

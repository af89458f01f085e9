//! The tangent frame of a surface, and normal maps.
//!
//! Red of a normal map leads along the tangent (growing u), green along the bitangent (growing v: upwards in the picture),
//! blue along the normal, as glTF 2.0 §3.9.3 has it.

use super::scene::{NO_TRANSFORM, Scene, SurfaceInteraction};
use super::{ColorSource, TextureId};
use crate::math::DVec3;
use crate::shape::Shape;

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
        let (tangent, bitangent) = self.tangent_frame(surface, self.uv_set(id))?;
        let c = self.textures.color(map, &self.texture_point(surface));
        let [x, y, z] = [c.r, c.g, c.b].map(|v| 2.0 * f64::from(v) - 1.0);
        let n = scale * x * tangent + scale * y * bitangent + z * surface.ns;
        let n = n.try_normalize()?;
        // A normal that turns away from the surface it belongs to would make light leak through it.
        let outer = n.dot(surface.ng);
        if outer > 0.0 { Some(n) } else { (n - 1.001 * outer * surface.ng).try_normalize() }
    }

    fn uv_set(&self, texture: TextureId) -> u32 {
        self.textures.uv_set(texture)
    }
}

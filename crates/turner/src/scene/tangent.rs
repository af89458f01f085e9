//! The tangent frame of a surface, and the scene as [`MaterialEvalContext`].

use crate::material::{Material, MaterialEvalContext};
use crate::math::DVec3;
use crate::scene::scene::NO_TRANSFORM;
use crate::scene::{Scene, SurfaceInteraction};
use crate::shape::Shape;
use crate::texture::{Footprint, TexturePoint, Textures};

impl Scene {
    /// Unit tangent (along u) and bitangent (along v) of a surface, perpendicular to its shading normal; `None` if
    /// (u, v) define no directions. `uv_set` selects the coordinates used for meshes without tangents.
    pub fn tangent_frame(&self, surface: &SurfaceInteraction, uv_set: u32) -> Option<(DVec3, DVec3)> {
        let primitive = &self.primitives[surface.hit.primitive as usize];
        let hit = &surface.hit.shape;
        let (tangent, bitangent) = match &primitive.shape {
            Shape::Sphere(_) => {
                // u grows with the longitude, v towards +y.
                let n = surface.object_normal();
                (DVec3::new(n.z, 0.0, -n.x), DVec3::Y - n * n.y)
            }
            Shape::Mesh(mesh) => match mesh.tangent(hit) {
                Some((tangent, side)) => (tangent, side * surface.object_normal().cross(tangent)),
                None => mesh.uv_directions(hit, uv_set as usize)?,
            },
            Shape::Curves(curves) => {
                let tangent = curves.tangent(hit);
                (tangent, surface.object_normal().cross(tangent))
            }
            _ => return None,
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
}

impl MaterialEvalContext for Scene {
    fn textures(&self) -> &Textures {
        &self.textures
    }

    fn materials(&self) -> &[Material] {
        &self.materials
    }

    #[inline]
    fn texture_point(&self, surface: &SurfaceInteraction) -> TexturePoint<'_> {
        Scene::texture_point(self, surface)
    }

    #[inline]
    fn tangent_frame(&self, surface: &SurfaceInteraction, uv_set: u32) -> Option<(DVec3, DVec3)> {
        Scene::tangent_frame(self, surface, uv_set)
    }

    #[inline]
    fn footprint(&self, surface: &SurfaceInteraction, axes: [DVec3; 2]) -> Footprint {
        Scene::footprint(self, surface, axes)
    }
}

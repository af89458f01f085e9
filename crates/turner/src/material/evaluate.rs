//! The physical material at a place: textures looked up, what the layered BSDF is made of.

use super::{Physical, PrincipledMaterial};
use crate::bsdf::{Bsdf, PrincipledPoint};
use crate::color::Spectrum;
use crate::math::{DVec3, Frame};
use crate::scene::{ColorSource, Scene, SurfaceInteraction};
use crate::texture::TexturePoint;

fn mean(c: Spectrum) -> f64 {
    f64::from((c.r + c.g + c.b) / 3.0)
}

impl PrincipledMaterial {
    /// All numbers, if none depends on the place.
    pub(super) fn constant_point(&self) -> Option<PrincipledPoint> {
        let mut all = true;
        let point = self.point_by(&mut |source| match source {
            ColorSource::Constant(c) => c,
            ColorSource::Texture(_) => {
                all = false;
                Spectrum::BLACK
            }
        });
        all.then_some(point)
    }

    /// All numbers by the colours that `at` gives for their sources.
    fn point_by(&self, at: &mut dyn FnMut(ColorSource) -> Spectrum) -> PrincipledPoint {
        PrincipledPoint {
            base_color: at(self.base_color) * mean(at(self.base_weight)) as f32,
            base_metalness: mean(at(self.base_metalness)),
            transmission_weight: mean(at(self.transmission_weight)),
            specular_ior: self.specular_ior,
        }
    }
}

impl Physical {
    /// The scattering at a surface; `outside` is the index of refraction of what surrounds it.
    pub fn bsdf(&self, scene: &Scene, surface: &SurfaceInteraction, outside: f64) -> Bsdf {
        if let (Some(bsdf), true) = (self.constant_bsdf(), outside == 1.0) {
            return *bsdf;
        }
        let at = scene.texture_point(surface);
        let mut point = self.desc.point_by(&mut |source| scene.textures.color(source, &at));
        point.specular_ior /= outside;
        Bsdf::new(&point)
    }

    /// The shading frame: normal as the normal map says, x along the direction of anisotropy.
    pub fn frame(&self, scene: &Scene, surface: &SurfaceInteraction) -> Frame {
        let d = &self.desc;
        let mut n = surface.ns;
        if let Some(map) = d.normal_map
            && let Some(mapped) = scene.mapped_normal(surface, map, d.normal_scale)
        {
            n = mapped;
        }
        if let Some(x) = self.anisotropy_direction(scene, surface, n) {
            return Frame { x, y: n.cross(x), z: n };
        }
        Frame::from_z(n)
    }

    fn anisotropy_direction(&self, scene: &Scene, surface: &SurfaceInteraction, n: DVec3) -> Option<DVec3> {
        let d = &self.desc;
        if d.specular_roughness_anisotropy == ColorSource::Constant(Spectrum::BLACK) {
            return None;
        }
        let (tangent, bitangent) = scene.tangent_frame(surface, 0)?;
        let (mut s, mut c) = crate::math::elementary::sin_cos(d.anisotropy_rotation);
        if let Some(map) = d.anisotropy_map {
            let m = scene.textures.color(map, &scene.texture_point(surface));
            let (x, y) = (2.0 * f64::from(m.r) - 1.0, 2.0 * f64::from(m.g) - 1.0);
            let length = (x * x + y * y).sqrt();
            if length > 1e-6 {
                (s, c) = ((s * x + c * y) / length, (c * x - s * y) / length);
            }
        }
        let along = c * tangent + s * bitangent;
        (along - n * along.dot(n)).try_normalize()
    }

    /// The strength of anisotropy that glTF's picture of it holds; 1 without one.
    fn anisotropy_strength(&self, scene: &Scene, at: &TexturePoint<'_>) -> f64 {
        self.desc.anisotropy_map.map_or(1.0, |map| f64::from(scene.textures.color(map, at).b))
    }
}

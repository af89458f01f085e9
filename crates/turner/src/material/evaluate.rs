//! The OpenPBR material at a point: textures evaluated into the parameters of the layered BSDF.

use super::open_pbr::Unlayered;
use super::{OpenPbr, PrincipledMaterial, SpecularModel};
use crate::bsdf::{Bsdf, PrincipledPoint};
use crate::color::Spectrum;
use crate::interaction::SurfaceInteraction;
use crate::material::{MaterialEvalContext, bumped_normal, mapped_normal};
use crate::math::{DVec3, Frame, radians};
use crate::schema::ColorSource;

fn mean(c: Spectrum) -> f64 {
    f64::from((c.r + c.g + c.b) / 3.0)
}

impl PrincipledMaterial {
    /// All parameters as seen from outside, if none is textured.
    pub(super) fn constant_point(&self) -> Option<PrincipledPoint> {
        let mut all = true;
        let point = self.point_by(|source| match source {
            ColorSource::Constant(c) => c,
            ColorSource::Texture(_) => {
                all = false;
                Spectrum::BLACK
            }
        });
        all.then(|| PrincipledPoint { metal_index: self.metal_index(), ..point })
    }

    /// The parameters as seen from outside (`entering`) or inside.
    pub(super) fn on_side(&self, point: PrincipledPoint, entering: bool) -> PrincipledPoint {
        let point = PrincipledPoint { entering, ..point };
        if entering || !self.front_only || self.thin_walled || self.is_transmissive() {
            return point;
        }
        PrincipledPoint {
            base_weight: 0.0,
            specular_weight: 0.0,
            coat_weight: 0.0,
            fuzz_weight: 0.0,
            ..point
        }
    }

    /// All parameters, with `at` evaluating their sources.
    #[inline(always)]
    fn point_by(&self, mut at: impl FnMut(ColorSource) -> Spectrum) -> PrincipledPoint {
        let strength = self.anisotropy_map.map_or(1.0, |map| f64::from(at(map).b));
        let width = |source: Option<ColorSource>, at: &mut dyn FnMut(ColorSource) -> Spectrum| {
            source.map(|source| mean(at(source)))
        };
        let alpha = match (width(self.specular_alpha_x, &mut at), width(self.specular_alpha_y, &mut at)) {
            (None, None) => None,
            (Some(both), None) | (None, Some(both)) => Some((both, both)),
            (Some(x), Some(y)) => Some((x, y)),
        };
        PrincipledPoint {
            base_weight: mean(at(self.base_weight)),
            base_color: at(self.base_color),
            base_diffuse_roughness: mean(at(self.base_diffuse_roughness)),
            base_metalness: mean(at(self.base_metalness)),
            // Computed once for each material.
            metal_index: None,
            specular_weight: mean(at(self.specular_weight)),
            specular_color: at(self.specular_color),
            gltf_specular: self.specular_model == SpecularModel::Gltf,
            specular_roughness: mean(at(self.specular_roughness)),
            specular_multiple_scattering: self.specular_multiple_scattering,
            specular_distribution: self.specular_distribution,
            specular_masking: self.specular_masking,
            specular_ior: self.specular_ior,
            exterior_ior: 1.0,
            specular_roughness_anisotropy: strength * mean(at(self.specular_roughness_anisotropy)),
            // The shading frame is rotated instead.
            anisotropy_rotation: 0.0,
            alpha,
            transmission_weight: mean(at(self.transmission_weight)),
            transmission_color: at(self.transmission_color),
            transmission_depth: self.transmission_depth,
            transmission_tint: at(self.transmission_tint),
            subsurface_weight: mean(at(self.subsurface_weight)),
            subsurface_color: at(self.subsurface_color),
            subsurface_walk: self.has_subsurface(),
            coat_weight: mean(at(self.coat_weight)),
            coat_color: at(self.coat_color),
            coat_roughness: mean(at(self.coat_roughness)),
            coat_ior: self.coat_ior,
            coat_darkening: self.coat_darkening,
            fuzz_weight: mean(at(self.fuzz_weight)),
            fuzz_color: at(self.fuzz_color),
            fuzz_roughness: mean(at(self.fuzz_roughness)),
            thin_film_weight: mean(at(self.thin_film_weight)),
            thin_film_thickness: mean(at(self.thin_film_thickness)),
            thin_film_ior: self.thin_film_ior,
            thin_walled: self.thin_walled,
            entering: true,
        }
    }
}

impl OpenPbr {
    /// The BSDF at a surface hit on its outer (`entering`) or inner side; `exterior_ior` is the index of refraction
    /// around the solid.
    pub fn bsdf<'m>(
        &'m self,
        scene: &impl MaterialEvalContext,
        surface: &SurfaceInteraction,
        exterior_ior: f64,
        entering: bool,
    ) -> Bsdf<'m> {
        if let Some(base) = self.textured_base.as_ref().filter(|_| exterior_ior == 1.0)
            && let Some(bsdf) = base.bsdf(scene, surface, entering)
        {
            return bsdf;
        }
        self.bsdf_of_index(scene, surface, exterior_ior, entering, self.desc.specular_ior)
    }

    /// The BSDF with another index of refraction, that of one colour band.
    pub fn bsdf_of_index<'m>(
        &'m self,
        scene: &impl MaterialEvalContext,
        surface: &SurfaceInteraction,
        exterior_ior: f64,
        entering: bool,
        ior: f64,
    ) -> Bsdf<'m> {
        match &self.unlayered {
            Some(Unlayered::Hair(hair)) => return hair.bsdf(scene, surface),
            Some(Unlayered::Disney(disney)) => {
                return disney.bsdf(scene, surface, entering, self.desc.is_transmissive());
            }
            Some(Unlayered::Measured { tables, front_only }) => {
                return if entering || !front_only {
                    Bsdf::measured(tables)
                } else {
                    Bsdf::lambert(Spectrum::BLACK)
                };
            }
            None => {}
        }
        let at = scene.texture_point(surface);
        let mut point = self.desc.point_by(|source| scene.textures().color(source, &at));
        point.metal_index = self.metal_index;
        point.specular_ior = ior;
        point.exterior_ior = exterior_ior;
        Bsdf::new(&self.desc.on_side(point, entering))
    }

    /// The shading frame: z by bump map and normal map, x along the direction of anisotropy.
    pub fn frame(&self, scene: &impl MaterialEvalContext, surface: &SurfaceInteraction) -> Frame {
        let d = &self.desc;
        let mut n = surface.ns;
        if let Some(bump) = d.bump() {
            n = bumped_normal(scene, surface, bump);
        }
        if let Some(map) = d.normal_map
            && let Some(mapped) = mapped_normal(scene, &surface.with_normal(n), map, d.normal_scale)
        {
            n = mapped;
        }
        if let Some(x) = self.anisotropy_direction(scene, surface, n) {
            return Frame { x, y: n.cross(x), z: n };
        }
        Frame::from_z(n)
    }

    /// The unit normal of the coat on the outer side, if it may differ from the base's: the coat's own normal map
    /// applies to it, the base's does not (OpenPBR's `geometry_coat_normal`; glTF's clear coat).
    pub fn coat_normal(
        &self,
        scene: &impl MaterialEvalContext,
        surface: &SurfaceInteraction,
    ) -> Option<DVec3> {
        let d = &self.desc;
        if d.coat_weight == ColorSource::Constant(Spectrum::BLACK) {
            return None;
        }
        if d.coat_normal_map.is_none() && d.normal_map.is_none() {
            return None;
        }
        // The bump map applies to the base and to the coat.
        let n = d.bump().map_or(surface.ns, |bump| bumped_normal(scene, surface, bump));
        let mapped = d
            .coat_normal_map
            .and_then(|map| mapped_normal(scene, &surface.with_normal(n), map, d.coat_normal_scale));
        Some(mapped.unwrap_or(n))
    }

    fn anisotropy_direction(
        &self,
        scene: &impl MaterialEvalContext,
        surface: &SurfaceInteraction,
        n: DVec3,
    ) -> Option<DVec3> {
        let d = &self.desc;
        let is_stretched = d.specular_alpha_x.zip(d.specular_alpha_y).is_some_and(|(x, y)| x != y);
        if d.specular_roughness_anisotropy == ColorSource::Constant(Spectrum::BLACK) && !is_stretched {
            return None;
        }
        let (tangent, bitangent) = scene.tangent_frame(surface, 0)?;
        let (mut s, mut c) = crate::math::elementary::sin_cos(radians(d.anisotropy_rotation));
        if let Some(map) = d.anisotropy_map {
            let m = scene.textures().color(map, &scene.texture_point(surface));
            let (x, y) = (2.0 * f64::from(m.r) - 1.0, 2.0 * f64::from(m.g) - 1.0);
            let length = (x * x + y * y).sqrt();
            if length > 1e-6 {
                (s, c) = ((s * x + c * y) / length, (c * x - s * y) / length);
            }
        }
        let along = c * tangent + s * bitangent;
        (along - n * along.dot(n)).try_normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::{ObjectDesc, SceneDesc};
    use crate::math::Ray;
    use crate::schema::MeshData;
    use crate::schema::{Asset, MeshId, PrepareOptions};
    use crate::shape::{MeshDesc, ShapeDesc};
    use std::sync::Arc;

    #[test]
    fn anisotropy_rotates_by_degrees() {
        let mut desc = SceneDesc::default();
        let data = MeshData {
            positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            uvs: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            triangles: vec![[0, 1, 2]],
            ..MeshData::default()
        };
        desc.meshes.push(Asset { uri: String::new(), data: Arc::new(data) });
        let shown = MeshDesc { mesh: MeshId(0), ..MeshDesc::default() };
        desc.objects.push(ObjectDesc::new(ShapeDesc::Mesh(shown)));
        let scene = desc.prepare(&PrepareOptions::default()).unwrap().scene;
        let ray = Ray::new(DVec3::new(0.3, 0.2, 4.0), DVec3::NEG_Z);
        let surface = scene.surface(&ray, &scene.intersect(&ray).unwrap());
        let along = |degrees: f64| {
            let material = OpenPbr::new(PrincipledMaterial {
                specular_roughness_anisotropy: ColorSource::Constant(Spectrum::grey(0.5)),
                anisotropy_rotation: degrees,
                ..Default::default()
            });
            material.anisotropy_direction(&*scene, &surface, surface.ns).unwrap()
        };
        let tangent = along(0.0);
        assert!((tangent - DVec3::X).length() < 1e-9);
        for (degrees, cos) in [(60.0, 0.5), (90.0, 0.0), (180.0, -1.0), (-360.0, 1.0)] {
            assert!((along(degrees).dot(tangent) - cos).abs() < 1e-9, "{degrees}");
        }
        // Counter-clockwise, seen from outside.
        assert!(tangent.cross(along(90.0)).dot(surface.ns) > 0.999_999);
    }
}

//! The BSDF at a surface for any pair of directions, for light paths and for reverse densities.

use std::f64::consts::FRAC_1_PI;

use crate::bsdf::{Bsdf, BsdfSample, Lobe, MIN_COSINE, sample_cosine};
use crate::color::Spectrum;
use crate::material::vertex::{Vertex, coated, prepare};
use crate::material::{BlockBsdf, OpenPbr};
use crate::math::{DVec3, Frame, Ray};
use crate::scene::{Scene, SurfaceInteraction};

/// A surface with its material and the medium outside.
#[derive(Clone, Copy)]
pub(in crate::integrator::path) struct SurfaceBsdf<'a> {
    pub(in crate::integrator::path) scene: &'a Scene,
    pub(in crate::integrator::path) material: &'a OpenPbr,
    pub(in crate::integrator::path) surface: &'a SurfaceInteraction,
    /// Index of refraction outside the solid.
    pub(in crate::integrator::path) exterior_ior: f64,
    /// The colour band that is left after dispersion.
    pub(in crate::integrator::path) band: Option<u8>,
    /// The BSDF of one side, if its textures are evaluated already, and whether that is the outer side.
    pub(in crate::integrator::path) made: Option<(bool, &'a Bsdf<'a>)>,
}

impl<'a> SurfaceBsdf<'a> {
    /// The same surface as a vertex of a camera path sees it, with its BSDF.
    pub(super) fn of_vertex(
        scene: &'a Scene,
        material: &'a OpenPbr,
        v: &Vertex<'a>,
        exterior_ior: f64,
        band: Option<u8>,
    ) -> SurfaceBsdf<'a> {
        let surface = v.surface;
        let outside = v.wo.dot(surface.ng) > 0.0;
        let made = v.bsdf.at_any_wo().filter(|_| material.dispersion.is_none());
        let made = made.map(|bsdf| (outside, bsdf));
        SurfaceBsdf { scene, material, surface, exterior_ior, band, made }
    }

    /// The BSDF of a side, if it does not vary over the surface.
    fn constant(&self, outside: bool) -> Option<&'a Bsdf<'a>> {
        let bands = self.material.dispersion.is_some() && self.band.is_some();
        self.material.constant_bsdf(outside).filter(|_| !bands && self.exterior_ior == 1.0)
    }

    /// The BSDF of a side.
    fn evaluate(&self, outside: bool) -> Bsdf<'a> {
        let SurfaceBsdf { scene, material, surface, exterior_ior, band, .. } = *self;
        let index = material.dispersion.zip(band).map(|(indices, band)| indices[usize::from(band.min(2))]);
        let index = index.unwrap_or(material.desc.specular_ior);
        material.bsdf_of_index(scene, surface, exterior_ior, outside, index)
    }

    /// The BSDF of a side, unless it is constant.
    pub(super) fn make(&self, outside: bool) -> Option<Bsdf<'a>> {
        self.constant(outside).is_none().then(|| self.evaluate(outside))
    }
}

impl SurfaceBsdf<'_> {
    /// Calls `evaluate` with the vertex seen from the direction `toward`, a unit vector that points away from the
    /// surface.
    pub(super) fn with_vertex<T>(&self, toward: DVec3, evaluate: impl FnOnce(&Vertex<'_>) -> T) -> T {
        let SurfaceBsdf { scene, material, surface, made, .. } = *self;
        let outside = toward.dot(surface.ng) > 0.0;
        let ray = Ray::new(surface.p, -toward);
        let owned;
        let bsdf = match (made, self.constant(outside)) {
            (Some((side, bsdf)), _) if side == outside => bsdf,
            (_, Some(bsdf)) => bsdf,
            (_, None) => {
                owned = self.evaluate(outside);
                &owned
            }
        };
        let coated = coated(scene, &ray, material, surface, bsdf, outside);
        let bsdf = coated.as_ref().unwrap_or(bsdf);
        evaluate(&prepare(scene, &ray, material, surface, bsdf, outside))
    }

    /// The BRDF where it is Lambertian around the geometric normal, the most frequent case on light paths.
    #[inline]
    fn lambert(&self) -> Option<Spectrum> {
        match self.material.plain() {
            Some(BlockBsdf::Lambert(f)) if self.surface.ns == self.surface.ng => Some(f),
            _ => None,
        }
    }

    /// A Lambertian BRDF between two directions times the cosine to the first, and the density of the reverse
    /// direction.
    #[inline]
    fn lambert_between(&self, f: Spectrum, light: DVec3, wo: DVec3) -> (Spectrum, f64) {
        let ng = self.surface.ng;
        let (a, b) = (light.dot(ng), wo.dot(ng));
        if (a > 0.0) != (b > 0.0) || !(a.abs() > MIN_COSINE && b.abs() > MIN_COSINE) {
            return (Spectrum::BLACK, 0.0);
        }
        (f * a.abs() as f32, a.abs() * FRAC_1_PI)
    }

    /// Whether light from `light` can scatter by a non-delta lobe.
    pub(super) fn is_smooth(&self, light: DVec3) -> bool {
        self.lambert().is_some() || self.with_vertex(light, |v| v.is_smooth())
    }

    /// Density with which a path that arrives from `from` scatters to `to`.
    pub(super) fn density(&self, from: DVec3, to: DVec3) -> f64 {
        self.with_vertex(from, |v| v.eval_towards(to).1)
    }

    /// The BSDF for light from `light` that leaves towards `wo`, and the density of the reverse direction, `wo` to
    /// `light`. It includes the cosine of the shading normal to the light, as in path tracing.
    pub(super) fn light_to_camera(&self, light: DVec3, wo: DVec3) -> (Spectrum, f64) {
        if let Some(f) = self.lambert() {
            return self.lambert_between(f, light, wo);
        }
        self.with_vertex(wo, |v| {
            let (f, pdf) = v.eval_towards(light);
            (f * v.cosine(light) as f32, pdf)
        })
    }

    /// Samples a direction for light from `light`, with three random numbers.
    pub(super) fn scatter(&self, light: DVec3, u: [f64; 3]) -> Option<Scattered> {
        let ng = self.surface.ng;
        if let Some(f) = self.lambert() {
            let cos = light.dot(ng).abs();
            let local = sample_cosine([u[1], u[2]]);
            if !(cos > MIN_COSINE && local.z > MIN_COSINE) {
                return None;
            }
            let to = Frame::from_z(if light.dot(ng) > 0.0 { ng } else { -ng }).to_world(local);
            let lobe = Lobe { is_delta: false, is_transmission: false, is_diffuse: true };
            let weight = f * std::f32::consts::PI;
            return Some(Scattered {
                to,
                lobe,
                pdf: local.z * FRAC_1_PI,
                weight,
                reverse_pdf: cos * FRAC_1_PI,
            });
        }
        let (s, to, at_light) = self.with_vertex(light, |v| {
            let (s, to) = v.sample_in_scene(u)?;
            Some((s, to, v.cosine(light)))
        })?;
        let (weight, reverse_pdf) = self.weight(light, to, &s, at_light);
        Some(Scattered { to, lobe: s.lobe, pdf: s.pdf, weight, reverse_pdf })
    }

    /// Fraction of the power of light from `light` that is left after scattering to `to`, with the correction for
    /// shading normals (Veach 1997, §5.3), and the density of the reverse direction. `at_light` is the cosine of the
    /// shading normal to the light.
    fn weight(&self, light: DVec3, to: DVec3, s: &BsdfSample, at_light: f64) -> (Spectrum, f64) {
        let (ng, cos_to) = (self.surface.ng, to.dot(self.surface.ng).abs());
        let cos_light = light.dot(ng).abs();
        if s.lobe.is_delta {
            // The sample is for radiance in the reverse direction: undo its factor eta² and replace the shading-normal
            // cosines.
            let weight = s.f * (s.wi.z.abs() * s.eta * s.eta / s.pdf) as f32;
            return (weight * (at_light * cos_to / (s.wi.z.abs() * cos_light)) as f32, 1.0);
        }
        let (f, reverse_pdf) = self.light_to_camera(light, to);
        (f * (cos_to / (cos_light * s.pdf)) as f32, reverse_pdf)
    }
}

/// A sampled direction of a light path.
pub(super) struct Scattered {
    /// The direction, a unit vector.
    pub(super) to: DVec3,
    /// The lobe it was sampled from.
    pub(super) lobe: Lobe,
    /// Density of the direction, per solid angle.
    pub(super) pdf: f64,
    /// Fraction of the power that is left.
    pub(super) weight: Spectrum,
    /// Density of the reverse direction: from `to` back to where the light came from.
    pub(super) reverse_pdf: f64,
}

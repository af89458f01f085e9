//! Reverse densities: the MIS weights of camera paths against light tracing.
//!
//! ```text
//!  camera        x1               x_i           light
//!    o --------> * --- ... ---->  * ----------> *      path tracing:  p_pt = product of p(x_j -> x_j+1)
//!    o <- - - -  * <-- ... -----  * <---------- *      light tracing: p_lt = N p(start) product of p(x_j+1 -> x_j)
//!       joined at x1                last surface: a caustic target
//! ```
//!
//! A path from the camera over x1, x2, … to a light can be made in three ways: by a BSDF-sampled ray that hits the
//! light, by sampling the light from the last surface, and, if that surface is a caustic target, by one of N light
//! paths that is joined to the camera at x1. The power heuristic weights them (Veach and Guibas 1995). It needs the
//! ratio p_lt / p_pt, a product over the vertices that [`ReversePdf`] updates as the path grows (after van Antwerpen
//! 2011 and Georgiev et al. 2012, with these three strategies only), so the cost per vertex is one more BSDF density.
//! Delta lobes have density 1 in both directions: they cancel in the ratio.

use super::CausticsStrategy;
use super::surface_bsdf::SurfaceBsdf;
use crate::bsdf::BsdfSample;
use crate::integrator::Radiance;
use crate::integrator::path::path_batch::PathBatch;
use crate::integrator::path::record::Record;
use crate::integrator::path::shade::clamped_by;
use crate::material::vertex::Vertex;
use crate::material::{BlockBsdf, OpenPbr};
use crate::math::{DVec3, Ray};
use crate::scene::SurfaceInteraction;
use crate::scene::caustic_targets::{CausticTargets, NO_GROUP};
use crate::scene::light_sample::{LightSample, NO_LIGHT};
use crate::view::View;

/// The densities of a path whose last vertex is x_i.
#[derive(Clone, Copy, Debug)]
pub(in crate::integrator::path) struct ReversePdf {
    /// Product over j < i of the densities per area, light path over camera path, of x_j; times the number of light
    /// paths.
    ratio: f64,
    /// Density per area with which the camera path found x_i.
    vertex_pdf: f64,
    /// Density of the current ray's direction per solid angle; for parallel camera rays, per area perpendicular to
    /// them. `angular` tells which.
    direction_pdf: f64,
    angular: bool,
    /// Cosine at x_i to the ray that leaves it.
    cos: f64,
    /// x_i, or the origin of the camera ray.
    p: DVec3,
    /// The caustic target that x_i belongs to, if light paths may find the light that it focuses.
    group: u32,
    /// The caustic target that x_i belongs to, if x_i scatters the path specularly.
    specular_group: u32,
    /// The lobes of the path so far.
    subpath: Subpath,
    /// Index of refraction outside the solid at the current hit.
    pub(in crate::integrator::path) exterior_ior: f64,
}

/// A vertex and the direction sampled there.
pub(in crate::integrator::path) struct NextVertex {
    pub(in crate::integrator::path) p: DVec3,
    /// Geometric normal.
    pub(in crate::integrator::path) ng: DVec3,
    /// The direction and its density.
    pub(in crate::integrator::path) wi: DVec3,
    pub(in crate::integrator::path) pdf: f64,
    /// Whether a delta lobe was sampled.
    pub(in crate::integrator::path) is_delta: bool,
    /// Whether the scattering is specular: a delta lobe, or a near-specular surface.
    pub(in crate::integrator::path) is_specular: bool,
    /// Whether the path comes straight from the camera.
    pub(in crate::integrator::path) from_camera: bool,
}

/// Density of a direction by Lambertian reflection, per solid angle.
fn lambert_pdf(n: DVec3, w: DVec3) -> f64 {
    n.dot(w).abs() * std::f64::consts::FRAC_1_PI
}

/// The lobes of a camera path so far. "Specular" includes near-specular surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Subpath {
    /// None: the camera ray.
    Empty,
    /// Specular lobes only.
    Specular,
    /// Specular lobes, then another lobe: at that vertex photons were gathered.
    SpecularThenOther,
    /// A non-specular lobe first.
    Other,
}

impl ReversePdf {
    /// The state of a camera ray.
    pub(in crate::integrator::path) fn of_camera(
        view: &View,
        strategy: &CausticsStrategy,
        ray: &Ray,
    ) -> ReversePdf {
        let (direction_pdf, angular) = view.camera.ray_density(&view.film, ray.direction);
        let ratio = strategy.paths as f64;
        ReversePdf {
            ratio,
            vertex_pdf: 0.0,
            direction_pdf,
            angular,
            cos: 0.0,
            p: ray.origin,
            group: NO_GROUP,
            specular_group: NO_GROUP,
            subpath: Subpath::Empty,
            exterior_ior: 1.0,
        }
    }

    /// Density per area with which the path finds a point `p` with normal `n` after x_i.
    fn area_pdf(&self, p: DVec3, n: DVec3) -> f64 {
        let offset = p - self.p;
        let d2 = offset.length_squared();
        let cos = offset.dot(n).abs() / d2.sqrt();
        self.direction_pdf * cos / if self.angular { d2 } else { 1.0 }
    }

    /// The ratio including x_i, given the density `reverse` with which a light path scatters at `p` back to x_i.
    fn ratio_including(&self, p: DVec3, reverse: f64) -> f64 {
        let d2 = (p - self.p).length_squared();
        self.ratio * reverse * self.cos / (d2 * self.vertex_pdf)
    }

    /// Appends a vertex. `density` is that with which a light path scatters there back along the last ray. The caustic
    /// targets are set afterwards.
    fn append(&mut self, to: &NextVertex, density: impl FnOnce() -> f64) {
        let ratio = match (to.from_camera, to.is_delta) {
            // Light paths cannot be joined to the camera at a delta lobe.
            (true, true) => 0.0,
            (true, false) => self.ratio,
            _ if self.ratio == 0.0 => 0.0,
            (false, true) => self.ratio_including(to.p, 1.0),
            (false, false) => self.ratio_including(to.p, density()),
        };
        *self = ReversePdf {
            ratio: if ratio > 0.0 && ratio.is_finite() { ratio } else { 0.0 },
            vertex_pdf: self.area_pdf(to.p, to.ng),
            direction_pdf: if to.is_delta { 1.0 } else { to.pdf },
            angular: true,
            cos: to.wi.dot(to.ng).abs(),
            p: to.p,
            group: NO_GROUP,
            specular_group: NO_GROUP,
            subpath: match (self.subpath, to.is_specular) {
                (Subpath::Empty | Subpath::Specular, true) => Subpath::Specular,
                (Subpath::Empty, false) => Subpath::Other,
                (Subpath::Specular, false) => Subpath::SpecularThenOther,
                (subpath, _) => subpath,
            },
            exterior_ior: self.exterior_ior,
        };
    }
}

/// Square of the ratio of densities, light tracing over another strategy; 0 for NaN.
fn squared(ratio: f64) -> f64 {
    if ratio > 0.0 { ratio * ratio } else { 0.0 }
}

impl<R: Record> PathBatch<'_, R> {
    /// Updates the reverse densities when the path continues from a vertex; `from_camera` if it comes straight from the
    /// camera.
    pub(in crate::integrator::path) fn update_reverse_pdf(
        &mut self,
        sample: u32,
        v: &Vertex<'_>,
        material: &OpenPbr,
        s: &BsdfSample,
        wi: DVec3,
        from_camera: bool,
    ) {
        let Some(strategy) = self.strategy else { return };
        let band = self.paths[sample as usize].band;
        let Some(reverse) = self.reverse_pdfs.get_mut(sample as usize) else { return };
        let surface = v.surface();
        let exterior_ior = reverse.exterior_ior;
        let is_delta = s.lobe.is_delta;
        let is_specular = is_delta || material.near_specular;
        let to =
            NextVertex { p: surface.p, ng: surface.ng, wi, pdf: s.pdf, is_delta, is_specular, from_camera };
        reverse.append(&to, || match material.plain() {
            // The same density as in SIMD shading.
            Some(BlockBsdf::Lambert(_)) if surface.ns == surface.ng => lambert_pdf(surface.ng, v.wo()),
            _ => SurfaceBsdf::of_vertex(self.scene, material, v, exterior_ior, band).density(wi, v.wo()),
        });
        if material.casts_caustics {
            let group = strategy.caustic_targets.group(surface);
            reverse.group = if !from_camera && reverse.ratio > 0.0 { group } else { NO_GROUP };
            reverse.specular_group = if is_specular { group } else { NO_GROUP };
        }
    }

    /// The path enters a translucent body. Light paths do not, so that all light found from here on has full weight.
    pub(in crate::integrator::path) fn forget_light_paths(&mut self, sample: u32) {
        if let Some(reverse) = self.reverse_pdfs.get_mut(sample as usize) {
            (reverse.ratio, reverse.group, reverse.specular_group, reverse.subpath) =
                (0.0, NO_GROUP, NO_GROUP, Subpath::Other);
        }
    }

    /// As `update_reverse_pdf`, for Lambertian reflection; `wo` is the direction back along the last ray.
    #[inline]
    pub(in crate::integrator::path) fn update_reverse_pdf_lambert(
        &mut self,
        sample: u32,
        to: &NextVertex,
        wo: DVec3,
    ) {
        if let Some(reverse) = self.reverse_pdfs.get_mut(sample as usize) {
            reverse.append(to, || lambert_pdf(to.ng, wo));
        }
    }

    /// Whether photons are gathered at the next vertex, if that is not specular.
    pub(in crate::integrator::path) fn finds_photons(&self, sample: u32) -> bool {
        self.photons.is_some()
            && self
                .reverse_pdfs
                .get(sample as usize)
                .is_some_and(|reverse| reverse.subpath == Subpath::Specular)
    }

    /// Adds the radiance from photons at a vertex that the path has reached by specular lobes only and that is not
    /// near-specular itself.
    pub(in crate::integrator::path) fn merge(
        &mut self,
        sample: u32,
        v: &Vertex<'_>,
        material: &OpenPbr,
        pixel: &mut Radiance,
    ) {
        let (Some(photons), Some(reverse)) = (&self.photons, self.reverse_pdfs.get(sample as usize)) else {
            return;
        };
        if reverse.subpath != Subpath::Specular || material.near_specular {
            return;
        }
        let path = &self.paths[sample as usize];
        let (surface, left) = (v.surface(), self.settings.max_depth - path.bounces.total - 1);
        let groups = &mut self.groups;
        let gathered = photons.gather(
            surface.p,
            surface.ng,
            left,
            |light| v.eval_towards(light).0 * v.cosine(light) as f32,
            |group, radiance| groups.find(group, radiance),
        );
        let added = self.settings.add(path, path.beta * gathered.radiance, pixel);
        let factor = clamped_by(path.beta * gathered.radiance, added);
        groups.add_found(sample, path, path.beta * factor);
        let luminance = f64::from(added.luminance());
        self.by_photons += luminance;
        self.split.gathered(sample, added);
        self.lobes.gathered(sample, added);
        self.photon_variance += luminance * luminance / f64::from(gathered.count.max(1));
        self.record.note(|r| r.gathered(photons.radius, gathered, added));
    }

    /// Whether photons have already counted a light that a BSDF-sampled ray hits; `density` is that of the light paths'
    /// starts.
    pub(in crate::integrator::path) fn counted_by_photons(
        &self,
        sample: u32,
        density: impl FnOnce(&CausticTargets, u32) -> (f64, f64),
    ) -> bool {
        let (Some(_), Some(strategy), Some(reverse)) =
            (&self.photons, self.strategy, self.reverse_pdfs.get(sample as usize))
        else {
            return false;
        };
        if reverse.subpath != Subpath::SpecularThenOther || reverse.specular_group == NO_GROUP {
            return false;
        }
        let (start, leave) = density(&strategy.caustic_targets, reverse.specular_group);
        start > 0.0 && leave > 0.0
    }

    /// Squared ratio of densities, light tracing over path tracing, for a ray that hits an emitter.
    pub(in crate::integrator::path) fn light_path_ratio_hit(
        &self,
        sample: u32,
        surface: &SurfaceInteraction,
    ) -> f64 {
        let (Some(strategy), Some(reverse)) = (self.strategy, self.reverse_pdfs.get(sample as usize)) else {
            return 0.0;
        };
        if reverse.group == NO_GROUP {
            return 0.0;
        }
        let (start, leave) = strategy.caustic_targets.density_on_shape(self.scene, reverse.group, surface);
        let offset = surface.p - reverse.p;
        let cos = offset.dot(surface.ng).abs() / offset.length();
        squared(
            reverse.ratio * start * leave * reverse.cos / (reverse.vertex_pdf * reverse.direction_pdf * cos),
        )
    }

    /// As above, for a ray that leaves the scene and hits the infinite light `light`.
    pub(in crate::integrator::path) fn light_path_ratio_escaped(
        &self,
        sample: u32,
        light: u32,
        direction: DVec3,
    ) -> f64 {
        let (Some(strategy), Some(reverse)) = (self.strategy, self.reverse_pdfs.get(sample as usize)) else {
            return 0.0;
        };
        if reverse.group == NO_GROUP {
            return 0.0;
        }
        let (start, pass) =
            strategy.caustic_targets.infinite_pdf(self.scene, reverse.group, light, direction);
        squared(reverse.ratio * start * pass * reverse.cos / (reverse.vertex_pdf * reverse.direction_pdf))
    }

    /// As above, for a light sampled from a vertex in the direction `wi`; infinite if photons have already counted its
    /// light.
    pub(in crate::integrator::path) fn light_path_ratio_sampled(
        &self,
        sample: u32,
        v: &Vertex<'_>,
        material: &OpenPbr,
        lit: &LightSample,
        wi: DVec3,
    ) -> f64 {
        let path = &self.paths[sample as usize];
        let (Some(strategy), Some(reverse)) = (self.strategy, self.reverse_pdfs.get(sample as usize)) else {
            return 0.0;
        };
        let (scene, surface) = (self.scene, v.surface());
        let group = strategy.caustic_targets.group(surface);
        // Photons have already counted this light.
        let merged =
            material.near_specular && self.photons.is_some() && reverse.subpath == Subpath::SpecularThenOther;
        if path.bounces.total == 0 || group == NO_GROUP || reverse.ratio == 0.0 && !merged {
            return 0.0;
        }
        let seen = SurfaceBsdf::of_vertex(scene, material, v, reverse.exterior_ior, path.band);
        let ratio = reverse.ratio_including(surface.p, seen.density(wi, v.wo()));
        let vertex_pdf = reverse.area_pdf(surface.p, surface.ng);
        let cos = wi.dot(surface.ng).abs();
        let squared = |starts: f64| match merged && starts > 0.0 {
            true => f64::INFINITY,
            false => squared(ratio * starts * cos / vertex_pdf),
        };
        match (lit.is_delta, lit.light) {
            (true, NO_LIGHT) => 0.0,
            (true, light) => {
                let from = lit.finite.then(|| surface.p + lit.to_light);
                let (start, leave) = strategy.caustic_targets.density_of_delta(group, light, from);
                let d2 = if lit.finite { lit.to_light.length_squared() } else { 1.0 };
                squared(start * leave / (lit.pdf * d2))
            }
            (false, NO_LIGHT) => {
                // The point on the light, as a ray hits it.
                let ray = Ray { time: surface.time(), ..Ray::new(surface.leave(wi), wi) };
                let Some((light, _)) = scene.first_emitter(&ray) else { return 0.0 };
                let (start, leave) = strategy.caustic_targets.density_on_shape(scene, group, &light);
                squared(start * leave / (lit.pdf * wi.dot(light.ng).abs()))
            }
            (false, light) => {
                let (start, pass) = strategy.caustic_targets.infinite_pdf(scene, group, light, wi);
                squared(start * pass / lit.pdf)
            }
        }
    }
}

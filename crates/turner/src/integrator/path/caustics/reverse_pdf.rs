//! What a camera path knows of the light paths that could have made it.
//!
//! A path from the camera over x1, x2, … to a light at xk can be found in three ways: by chance, by sampling the light from the last surface, and, if that surface gathers
//! light, by a light path that begins at the light and is joined to the camera at x1. The power heuristic weighs them (Veach & Guibas 1995). What takes the third way's density
//! over that of the first is a product over the vertices, gathered as the path goes on (after van Antwerpen 2011 and Georgiev et al. 2012, with these three ways alone).
//! Scattering by a mirror's lobe has density 1 in both directions.

use super::CausticsStrategy;
use super::surface_bsdf::SurfaceBsdf;
use crate::bsdf::BsdfSample;
use crate::integrator::Radiance;
use crate::integrator::path::path_batch::PathBatch;
use crate::integrator::path::record::Record;
use crate::material::vertex::Vertex;
use crate::material::{OpenPbr, PlainBsdf};
use crate::math::{DVec3, Ray};
use crate::scene::SurfaceInteraction;
use crate::scene::caustic_targets::{CausticTargets, NO_GROUP};
use crate::scene::emitters::{LightSample, NO_LIGHT};
use crate::view::View;

/// Of a path with a last vertex xi.
#[derive(Clone, Copy, Debug)]
pub(in crate::integrator::path) struct ReversePdf {
    /// Product over j < i of the densities per area with which light paths and camera paths find xj, one over the other, times the number of light paths.
    ratio: f64,
    /// The density per area with which the camera path found xi.
    area: f64,
    /// Density of its ray's direction per solid angle, or per area at right angles to the parallel rays of a camera.
    forward: f64,
    angular: bool,
    /// Cosine at xi to the ray that leaves it.
    cos: f64,
    /// xi, or where the camera ray begins.
    p: DVec3,
    /// The group that xi belongs to, if light that it gathers may be found by light paths.
    group: u32,
    /// The group that xi belongs to, if it scatters the path by a mirror's lobe, or by narrow ones alone.
    mirror: u32,
    /// How the path has come from the camera.
    way: Subpath,
    /// Index of refraction around the solid whose surface is met.
    pub(in crate::integrator::path) around: f64,
}

/// How a path goes on from a vertex.
pub(in crate::integrator::path) struct NextVertex {
    pub(in crate::integrator::path) p: DVec3,
    /// Its geometric normal.
    pub(in crate::integrator::path) ng: DVec3,
    /// The direction, and its density.
    pub(in crate::integrator::path) wi: DVec3,
    pub(in crate::integrator::path) pdf: f64,
    /// Whether by a mirror's lobe.
    pub(in crate::integrator::path) mirror: bool,
    /// Whether by such a lobe, or where all lobes are narrow: light that arrives there is seen farther on.
    pub(in crate::integrator::path) sharp: bool,
    /// Whether it comes straight from the camera.
    pub(in crate::integrator::path) first: bool,
}

/// Density of a direction of Lambert's reflection.
fn lambert_density(n: DVec3, w: DVec3) -> f64 {
    n.dot(w).abs() * std::f64::consts::FRAC_1_PI
}

/// How a path has come from the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Subpath {
    /// Straight.
    Straight,
    /// By mirrors' lobes and narrow ones alone.
    Mirrors,
    /// By these, then by another lobe: there photons were found.
    StaticWorldMesh,
    /// By another lobe first.
    Other,
}

impl ReversePdf {
    /// Of a camera ray.
    pub(in crate::integrator::path) fn of_camera(
        view: &View,
        strategy: &CausticsStrategy,
        ray: &Ray,
    ) -> ReversePdf {
        let (forward, angular) = view.camera.ray_density(&view.film, ray.direction);
        let ratio = strategy.paths as f64;
        ReversePdf {
            ratio,
            area: 0.0,
            forward,
            angular,
            cos: 0.0,
            p: ray.origin,
            group: NO_GROUP,
            mirror: NO_GROUP,
            way: Subpath::Straight,
            around: 1.0,
        }
    }

    /// The density per area with which the path finds a point beyond xi, of a surface with this normal.
    fn finds(&self, p: DVec3, n: DVec3) -> f64 {
        let way = p - self.p;
        let d2 = way.length_squared();
        let cos = way.dot(n).abs() / d2.sqrt();
        self.forward * cos / if self.angular { d2 } else { 1.0 }
    }

    /// The ratio once it is known with which density light that comes the other way is scattered at `p` back along the last ray.
    fn ratio_with(&self, p: DVec3, back: f64) -> f64 {
        let d2 = (p - self.p).length_squared();
        self.ratio * back * self.cos / (d2 * self.area)
    }

    /// The path goes on; `density` is that with which light that comes the other way is scattered back along the last ray. It has gathered no light yet.
    fn go_on(&mut self, to: &NextVertex, density: impl FnOnce() -> f64) {
        let ratio = match (to.first, to.mirror) {
            // Light paths cannot be joined to the camera here.
            (true, true) => 0.0,
            (true, false) => self.ratio,
            _ if self.ratio == 0.0 => 0.0,
            (false, true) => self.ratio_with(to.p, 1.0),
            (false, false) => self.ratio_with(to.p, density()),
        };
        *self = ReversePdf {
            ratio: if ratio > 0.0 && ratio.is_finite() { ratio } else { 0.0 },
            area: self.finds(to.p, to.ng),
            forward: if to.mirror { 1.0 } else { to.pdf },
            angular: true,
            cos: to.wi.dot(to.ng).abs(),
            p: to.p,
            group: NO_GROUP,
            mirror: NO_GROUP,
            way: match (self.way, to.sharp) {
                (Subpath::Straight | Subpath::Mirrors, true) => Subpath::Mirrors,
                (Subpath::Straight, false) => Subpath::Other,
                (Subpath::Mirrors, false) => Subpath::StaticWorldMesh,
                (way, _) => way,
            },
            around: self.around,
        };
    }
}

/// The density of the third way over that of another, squared, from the density of starts over that of the other at the light; 0 where it is no number.
fn squared(ratio: f64) -> f64 {
    if ratio > 0.0 { ratio * ratio } else { 0.0 }
}

impl<R: Record> PathBatch<'_, R> {
    /// The path goes on from a vertex: `first` if it comes straight from the camera.
    pub(in crate::integrator::path) fn note_back(
        &mut self,
        sample: u32,
        v: &Vertex<'_>,
        material: &OpenPbr,
        s: &BsdfSample,
        wi: DVec3,
        first: bool,
    ) {
        let Some(strategy) = self.strategy else { return };
        let band = self.paths[sample as usize].band;
        let Some(back) = self.back.get_mut(sample as usize) else { return };
        let surface = v.surface();
        let around = back.around;
        let mirror = s.lobe.is_delta;
        let sharp = mirror || material.near_specular;
        let to = NextVertex { p: surface.p, ng: surface.ng, wi, pdf: s.pdf, mirror, sharp, first };
        back.go_on(&to, || match material.plain() {
            // As where vertices are shaded eight at a time.
            Some(PlainBsdf::Lambert(_)) if surface.ns == surface.ng => lambert_density(surface.ng, v.wo()),
            _ => SurfaceBsdf { scene: self.scene, material, surface, around, band }.density(wi, v.wo()),
        });
        if material.casts_caustics {
            let group = strategy.caustic_targets.group(surface);
            back.group = if !first && back.ratio > 0.0 { group } else { NO_GROUP };
            back.mirror = if sharp { group } else { NO_GROUP };
        }
    }

    /// The path enters a translucent body: light paths do not come that way, so that all that it finds from here on counts in full.
    pub(in crate::integrator::path) fn forget_light_paths(&mut self, sample: u32) {
        if let Some(back) = self.back.get_mut(sample as usize) {
            (back.ratio, back.group, back.mirror, back.way) = (0.0, NO_GROUP, NO_GROUP, Subpath::Other);
        }
    }

    /// The same where light is reflected by Lambert's law, towards `wo` in the end.
    #[inline]
    pub(in crate::integrator::path) fn note_back_of_lambert(
        &mut self,
        sample: u32,
        to: &NextVertex,
        wo: DVec3,
    ) {
        if let Some(back) = self.back.get_mut(sample as usize) {
            back.go_on(to, || lambert_density(to.ng, wo));
        }
    }

    /// Whether photons are to be found where the path goes on, if it does by other than a mirror's lobe.
    pub(in crate::integrator::path) fn finds_photons(&self, sample: u32) -> bool {
        self.photons.is_some()
            && self.back.get(sample as usize).is_some_and(|back| back.way == Subpath::Mirrors)
    }

    /// Adds what photons bring to a surface that the path has reached by mirrors and narrow lobes alone; not where it is such a one itself.
    pub(in crate::integrator::path) fn merge(
        &mut self,
        sample: u32,
        v: &Vertex<'_>,
        material: &OpenPbr,
        pixel: &mut Radiance,
    ) {
        let (Some(photons), Some(back)) = (&self.photons, self.back.get(sample as usize)) else { return };
        if back.way != Subpath::Mirrors || material.near_specular {
            return;
        }
        let path = &self.paths[sample as usize];
        let (surface, left) = (v.surface(), self.settings.max_depth - path.bounces.total - 1);
        let gathered = photons
            .gather(surface.p, surface.ng, left, |light| v.eval_towards(light).0 * v.cosine(light) as f32);
        let added = self.settings.add(path, path.beta * gathered.radiance, pixel);
        let luminance = f64::from(added.luminance());
        self.by_photons += luminance;
        self.photon_variance += luminance * luminance / f64::from(gathered.count.max(1));
        self.record.note(|r| r.gathered(photons.radius, gathered, added));
    }

    /// Whether light that a path finds by chance was brought by photons before; `density` is that of light paths' starts.
    pub(in crate::integrator::path) fn left_to_photons(
        &self,
        sample: u32,
        density: impl FnOnce(&CausticTargets, u32) -> (f64, f64),
    ) -> bool {
        let (Some(_), Some(strategy), Some(back)) =
            (&self.photons, self.strategy, self.back.get(sample as usize))
        else {
            return false;
        };
        if back.way != Subpath::StaticWorldMesh || back.mirror == NO_GROUP {
            return false;
        }
        let (start, leave) = density(&strategy.caustic_targets, back.mirror);
        start > 0.0 && leave > 0.0
    }

    /// The square of what light paths' density is to that of a path that hits a shape that shines by chance.
    pub(in crate::integrator::path) fn light_paths_to_hit(
        &self,
        sample: u32,
        surface: &SurfaceInteraction,
    ) -> f64 {
        let (Some(strategy), Some(back)) = (self.strategy, self.back.get(sample as usize)) else {
            return 0.0;
        };
        if back.group == NO_GROUP {
            return 0.0;
        }
        let (start, leave) = strategy.caustic_targets.density_on_shape(self.scene, back.group, surface);
        let way = surface.p - back.p;
        let cos = way.dot(surface.ng).abs() / way.length();
        squared(back.ratio * start * leave * back.cos / (back.area * back.forward * cos))
    }

    /// The same for a path that leaves the scene in a direction and finds a light there, by the light's number.
    pub(in crate::integrator::path) fn light_paths_around(
        &self,
        sample: u32,
        light: u32,
        direction: DVec3,
    ) -> f64 {
        let (Some(strategy), Some(back)) = (self.strategy, self.back.get(sample as usize)) else {
            return 0.0;
        };
        if back.group == NO_GROUP {
            return 0.0;
        }
        let (start, pass) = strategy.caustic_targets.density_around(self.scene, back.group, light, direction);
        squared(back.ratio * start * pass * back.cos / (back.area * back.forward))
    }

    /// The same for a path that samples a light from a vertex, infinite if photons have brought its light; `wi` leads to it, `back` is the density with which light from there is scattered back along the last ray.
    pub(in crate::integrator::path) fn light_paths_to_sample(
        &self,
        sample: u32,
        v: &Vertex<'_>,
        material: &OpenPbr,
        lit: &LightSample,
        wi: DVec3,
    ) -> f64 {
        let path = &self.paths[sample as usize];
        let (Some(strategy), Some(back)) = (self.strategy, self.back.get(sample as usize)) else {
            return 0.0;
        };
        let (scene, surface) = (self.scene, v.surface());
        let group = strategy.caustic_targets.group(surface);
        // What photons have brought before.
        let world_mesh =
            material.near_specular && self.photons.is_some() && back.way == Subpath::StaticWorldMesh;
        if path.bounces.total == 0 || group == NO_GROUP || back.ratio == 0.0 && !world_mesh {
            return 0.0;
        }
        let seen = SurfaceBsdf { scene, material, surface, around: back.around, band: path.band };
        let ratio = back.ratio_with(surface.p, seen.density(wi, v.wo()));
        let area = back.finds(surface.p, surface.ng);
        let cos = wi.dot(surface.ng).abs();
        let squared = |starts: f64| match world_mesh && starts > 0.0 {
            true => f64::INFINITY,
            false => squared(ratio * starts * cos / area),
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
                // The place on the light, as a ray finds it.
                let ray = Ray { time: surface.time(), ..Ray::new(surface.leave(wi), wi) };
                let Some((light, _)) = scene.first_shining(&ray) else { return 0.0 };
                let (start, leave) = strategy.caustic_targets.density_on_shape(scene, group, &light);
                squared(start * leave / (lit.pdf * wi.dot(light.ng).abs()))
            }
            (false, light) => {
                let (start, pass) = strategy.caustic_targets.density_around(scene, group, light, wi);
                squared(start * pass / lit.pdf)
            }
        }
    }
}

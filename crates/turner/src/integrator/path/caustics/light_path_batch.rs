//! Light tracing: light paths that start at a light, are aimed at a caustic target, and are joined to the camera at
//! every vertex after it (Dutré, Lafortune and Willems 1993).
//!
//! ```text
//!      * light                          begin:       sample a target, a light, a point and a direction
//!       \                               shade_hit:   the first hit must lie on the chosen target
//!        y1  target (mirror, glass)     connect:     to the camera, with weight 1 / (1 + a² + b²)
//!       /                               scatter:     sample the next direction
//!     y2 - - - - > o camera             join:        trace the rays to the camera, splat what arrives
//! ```
//!
//! A connection adds beta · f · |cos| · W / density to the film, where W is the importance of the camera at that pixel.
//! Any pixel may receive it, so it goes to the film's splats. `a` and `b` are the ratios of densities of path tracing
//! (hitting and sampling the light) over light tracing with all its paths; see `light_path`.
//!
//! The paths of a batch advance together, one bounce per round. A path's contribution depends only on its index.

use std::ops::Range;

use turner_bvh::lanes::LANES;

use super::light_path::LightPath;
use super::photons::Photon;
use super::surface_bsdf::{Scattered, SurfaceBsdf};
use super::{CausticsStrategy, power};
use crate::camera::Projection;
use crate::color::Spectrum;
use crate::film::Splat;
use crate::integrator::path::Context;
use crate::integrator::path::media::{Boundary, Media};
use crate::integrator::path::settings::{Bounces, Settings};
use crate::integrator::path::shade::{FIRST_SET, MAX_VERTICES};
use crate::integrator::{LightTracer, RayStats};
use crate::light::AdaptiveEnvironment;
use crate::material::{AlphaMode, Material};
use crate::math::{DVec2, DVec3, Ray};
use crate::sampler::{OwenSobol, SampleId};
use crate::scene::caustic_targets::{NO_GROUP, Source};
use crate::scene::{Hit, RayBatch, Scene, SpectrumBlock, SurfaceInteraction};
use crate::view::View;

/// Seed of the light paths' random numbers, separate from those of pixels.
const SEED: u64 = 0x9c6e_1d3a_75f1_20b4;

/// Sets of random numbers for the start; then two for each vertex.
const START_SETS: [u32; 2] = [0, 1];

/// The contribution of a connection to the camera if unoccluded.
struct CameraConnection {
    splat: Splat,
    /// MIS weight.
    weight: f64,
    group: u32,
}

/// The light paths traced in one thread.
pub(in crate::integrator::path) struct LightPathBatch<'a> {
    settings: Settings,
    scene: &'a Scene,
    view: &'a View,
    adaptive: Option<&'a AdaptiveEnvironment>,
    strategy: &'a CausticsStrategy,
    paths: Vec<LightPath>,
    rays: RayBatch,
    of_ray: Vec<u32>,
    hits: Vec<Option<Hit>>,
    next: RayBatch,
    of_next: Vec<u32>,
    camera_rays: RayBatch,
    connections: Vec<CameraConnection>,
    through: Vec<SpectrumBlock>,
    /// The photons of the paths; empty unless photons are used.
    pub(super) photons: Vec<Photon>,
    /// Number of scattering events so far.
    pub(super) scatterings: u64,
    /// Number of these on surfaces with a thin film.
    pub(super) films: u64,
}

impl<'a> LightPathBatch<'a> {
    pub(in crate::integrator::path) fn new(
        context: Context<'a>,
        strategy: &'a CausticsStrategy,
    ) -> LightPathBatch<'a> {
        let Context { scene, view, settings, adaptive, .. } = context;
        LightPathBatch {
            settings,
            scene,
            view,
            adaptive,
            strategy,
            paths: Vec::new(),
            rays: RayBatch::default(),
            of_ray: Vec::new(),
            hits: Vec::new(),
            next: RayBatch::default(),
            of_next: Vec::new(),
            camera_rays: RayBatch::default(),
            connections: Vec::new(),
            through: Vec::new(),
            photons: Vec::new(),
            scatterings: 0,
            films: 0,
        }
    }

    /// Traces the paths `first..first + count` and passes each contribution to `contribute`: the splat, its MIS weight,
    /// and the caustic target.
    pub(super) fn advance(
        &mut self,
        first: u64,
        count: u32,
        stats: &mut RayStats,
        mut contribute: impl FnMut(Splat, f64, u32),
    ) {
        self.photons.clear();
        self.begin(first, count);
        while !self.rays.is_empty() {
            self.round(stats, &mut contribute);
        }
    }

    /// Advances all paths by one bounce.
    fn round(&mut self, stats: &mut RayStats, contribute: &mut impl FnMut(Splat, f64, u32)) {
        stats.light += self.rays.len() as u64;
        if self.scene.moves {
            for (i, &path) in self.of_ray.iter().enumerate() {
                self.rays.set_time(i, self.paths[path as usize].time);
            }
        }
        let mut hits = std::mem::take(&mut self.hits);
        self.scene.intersect_batch(&mut self.rays, &mut hits);
        self.scene.prefer_surfaces(&self.rays, &mut hits);
        let of_ray = std::mem::take(&mut self.of_ray);
        for (i, (&path, hit)) in of_ray.iter().zip(&hits).enumerate() {
            if let (Some(ray), Some(hit)) = (self.rays.get(i), hit) {
                self.shade_hit(path, &ray, hit);
            }
        }
        (self.of_ray, self.hits) = (of_ray, hits);
        self.join(stats, contribute);
        std::mem::swap(&mut self.rays, &mut self.next);
        std::mem::swap(&mut self.of_ray, &mut self.of_next);
        self.next.clear();
        self.of_next.clear();
    }

    /// Removes and returns the photons.
    pub(super) fn take_photons(&mut self) -> Vec<Photon> {
        std::mem::take(&mut self.photons)
    }

    /// Samples the starts of paths.
    fn begin(&mut self, first: u64, count: u32) {
        self.paths.clear();
        self.rays.clear();
        self.of_ray.clear();
        for number in first..first + u64::from(count) {
            let x = (number >> 32) as u32;
            let id = SampleId { x, y: 0, index: number as u32, seed: u64::from(self.view.film.seed) ^ SEED };
            let numbers = OwenSobol::new(&id);
            let [a0, a1, c0, c1] = numbers.four(START_SETS[0]);
            let [p0, p1, c2, time] = numbers.four(START_SETS[1]);
            let Some(start) =
                self.strategy.caustic_targets.start(self.scene, [c0, c1, c2], [p0, p1], [a0, a1])
            else {
                continue;
            };
            let [open, close] = self.view.film.shutter;
            let path = LightPath {
                numbers,
                time: if self.scene.moves { (open + (close - open) * time) as f32 } else { 0.0 },
                start,
                light_group: u32::MAX,
                beta: Spectrum::WHITE,
                vertex: 0,
                bounces: Bounces::default(),
                transparent: 0,
                media: Media::NONE,
                band: None,
                specular_first: false,
                by_delta: false,
                has_photon: false,
                scatterings: 0,
                p: start.ray.origin,
                cos: 0.0,
                parallel: false,
                direction_pdf: 0.0,
                vertex_pdf: 0.0,
                hit_ratio: 0.0,
                nee_ratio: 0.0,
            };
            self.rays.push(&start.ray);
            self.of_ray.push(self.paths.len() as u32);
            self.paths.push(path);
        }
    }

    /// Shades a ray that hits a surface.
    fn shade_hit(&mut self, index: u32, ray: &Ray, hit: &Hit) {
        let scene = self.scene;
        let path = &mut self.paths[index as usize];
        if path.scatterings == 0
            && let Material::OpenPbr(m) = scene.material_at(hit)
            && !m.casts_caustics
            && m.plain().is_some()
        {
            // Light that comes by way of a surface that is no caustic target is left to camera paths.
            return;
        }
        let surface = scene.surface(ray, hit);
        path.vertex += 1;
        if path.vertex > MAX_VERTICES {
            return;
        }
        if let Some(left) = path.media.transmittance(hit.shape.t) {
            path.beta = path.beta * left;
        }
        let set = START_SETS[1] + FIRST_SET + 2 * path.vertex;
        let [l0, l1, _, chance] = path.numbers.four(set);
        let outside = ray.direction.dot(surface.ng) < 0.0;
        let hit_material = match scene.material_at(hit) {
            Material::OpenPbr(m) if m.desc.alpha_mode != AlphaMode::Blend => Some(&**m),
            Material::OpenPbr(m) => (chance < f64::from(m.desc.coverage(scene, &surface))).then_some(&**m),
            Material::Mix(m) => m.choose(scene, &surface, outside, chance),
            Material::Classic(_) | Material::Principled(..) => return,
        };
        let Some(material) = hit_material else {
            return self.go_straight(index, &surface, ray.direction, Spectrum::WHITE);
        };
        if material.desc.unlit {
            return;
        }
        if material.pane {
            let (surface, exterior_ior) = (&surface, 1.0);
            let seen = SurfaceBsdf { scene, material, surface, exterior_ior, band: None, made: None };
            let straight = seen.with_vertex(-ray.direction, |v| v.straight());
            return self.go_straight(index, surface, ray.direction, straight);
        }
        let mut exterior_ior = 1.0;
        if material.has_inside() {
            if path.scatterings == 0 && !outside && path.media.is_empty() {
                // The light is inside the solid.
                path.media.cross(scene, &surface, material, true);
                if let Some(left) = path.media.transmittance(hit.shape.t) {
                    path.beta = path.beta * left;
                }
            }
            match path.media.boundary(surface.material, material.desc.specular_ior, outside) {
                Boundary::Between(ior) => exterior_ior = ior,
                Boundary::Hidden => {
                    path.media.cross(scene, &surface, material, outside);
                    return self.go_straight(index, &surface, ray.direction, Spectrum::WHITE);
                }
            }
        }
        if path.scatterings == 0 {
            let group = if material.casts_caustics {
                self.strategy.caustic_targets.group(&surface)
            } else {
                NO_GROUP
            };
            if group == NO_GROUP
                || group != path.start.group
                || !path.emit(scene, self.strategy, &surface, ray)
            {
                return;
            }
        }
        if material.dispersion.is_some() && path.band.is_none() {
            path.choose_band(chance);
        }
        let (surface, band) = (&surface, path.band);
        let seen = SurfaceBsdf { scene, material, surface, exterior_ior, band, made: None };
        let bsdf = seen.make(outside);
        let seen = SurfaceBsdf { made: bsdf.as_ref().map(|bsdf| (outside, bsdf)), ..seen };
        let stays = self.strategy.merges && path.specular_first && !material.near_specular;
        if stays && path.bounces.total < self.settings.max_depth {
            let photon = Photon {
                p: surface.p,
                light: (-ray.direction).as_vec3().to_array(),
                normal: surface.ng.as_vec3().to_array(),
                power: path.beta,
                depth: path.bounces.total,
                group: path.light_group,
                by_delta: path.by_delta,
            };
            if seen.is_smooth(-ray.direction) {
                self.photons.push(photon);
            }
        }
        let path = &self.paths[index as usize];
        // Near-specular reflections of photons are counted by camera paths.
        if path.scatterings > 0 && !(self.strategy.merges && path.has_photon && material.near_specular) {
            self.connect(index, &seen, -ray.direction, DVec2::new(l0, l1));
        }
        self.scatter(index, &seen, -ray.direction, set + 1);
    }

    /// Continues straight through a hole or a pane.
    fn go_straight(&mut self, index: u32, surface: &SurfaceInteraction, direction: DVec3, weight: Spectrum) {
        let path = &mut self.paths[index as usize];
        path.beta = path.beta * weight;
        path.transparent += 1;
        if path.transparent <= self.settings.max_transparent && !path.beta.is_black() {
            self.send(index, surface, direction);
        }
    }

    fn send(&mut self, index: u32, surface: &SurfaceInteraction, direction: DVec3) {
        self.next.push_from(&Ray::new(surface.leave(direction), direction), surface);
        self.of_next.push(index);
    }

    /// Connects a path to the camera at a surface that light from `light` reaches.
    fn connect(&mut self, index: u32, seen: &SurfaceBsdf<'_>, light: DVec3, lens: DVec2) {
        let (scene, path) = (self.scene, &self.paths[index as usize]);
        let surface = seen.surface;
        let is_hidden = scene.is_shadow_catcher(&surface.hit) || scene.is_hidden_from_camera(&surface.hit);
        if path.bounces.total >= self.settings.max_depth || is_hidden {
            return;
        }
        let Some(Projection { place, to_camera, free, density }) =
            self.view.camera.project(&self.view.film, surface.p, lens)
        else {
            return;
        };
        let (width, height) = (f64::from(self.view.film.width), f64::from(self.view.film.height));
        let margin = self.strategy.margin;
        if place.x < -margin || place.y < -margin || place.x >= width + margin || place.y >= height + margin {
            return;
        }
        let wo = to_camera.normalize();
        let (f, reverse_pdf) = seen.light_to_camera(light, wo);
        if f.is_black() {
            return;
        }
        let (cos_light, cos_wo) = (light.dot(surface.ng).abs(), wo.dot(surface.ng).abs());
        let mut color = path.beta * f * (cos_wo * density / cos_light) as f32;
        let mut media = path.media;
        let crosses = (wo.dot(surface.ng) > 0.0) != (light.dot(surface.ng) > 0.0);
        if crosses && seen.material.has_inside() {
            media.cross(scene, surface, seen.material, wo.dot(surface.ng) < 0.0);
        }
        if let Some(left) = media.transmittance(to_camera.length()) {
            color = color * left;
        }
        let origin = surface.leave(wo);
        let direction_to_camera = surface.p + to_camera - origin;
        let view = Ray { t_max: free, ..Ray::new(origin, direction_to_camera) };
        // Ratio of densities of path tracing over this path.
        let others = path.reverse_ratio(surface, reverse_pdf) * (density * cos_wo / path.area_pdf(surface));
        let paths = self.strategy.paths as f64;
        let weight = power(path.hit_ratio * others / paths, path.nee_ratio * others / paths);
        self.camera_rays.push_from(&view, surface);
        if scene.moves {
            self.camera_rays.set_time(self.connections.len(), path.time);
        }
        self.connections.push(CameraConnection {
            splat: Splat { place, color },
            weight,
            group: path.start.group,
        });
    }

    /// Samples the next direction of a path.
    fn scatter(&mut self, index: u32, seen: &SurfaceBsdf<'_>, light: DVec3, set: u32) {
        self.scatterings += 1;
        self.films += u64::from(seen.material.desc.has_thin_film());
        let path = &mut self.paths[index as usize];
        let surface = seen.surface;
        let [u0, u1, u2, u3] = path.numbers.four(set);
        let Some(Scattered { to, lobe, pdf, weight, reverse_pdf }) = seen.scatter(light, [u2, u0, u1]) else {
            return;
        };
        let Some(bounces) = self.settings.count(&path.bounces, &lobe) else { return };
        let before = path.beta.max_component();
        path.beta = path.beta * weight;
        if path.beta.is_black() || !path.beta.is_finite() {
            return;
        }
        // At the first surface: the ratio of densities at the light.
        let vertex_pdf = path.area_pdf(surface);
        if path.scatterings == 0 {
            let nee_ratio =
                if lobe.is_delta { 0.0 } else { path.nee_ratio_at(self.scene, self.adaptive, surface, to) };
            let d2 = (surface.p - path.p).length_squared();
            let found = match path.start.from {
                Source::Delta(..) => 0.0,
                Source::Infinite(_) => reverse_pdf,
                Source::Shape => reverse_pdf * path.cos / d2,
            };
            (path.hit_ratio, path.nee_ratio) = (found / path.hit_ratio, nee_ratio);
        } else {
            let ratio = path.reverse_ratio(surface, reverse_pdf);
            path.hit_ratio *= ratio;
            path.nee_ratio *= ratio;
        }
        if path.scatterings > 1 {
            let survival = (path.beta.max_component() / before).clamp(0.05, 1.0);
            if u3 >= f64::from(survival) {
                return;
            }
            path.beta *= 1.0 / survival;
        }
        path.bounces = bounces;
        let is_specular = lobe.is_delta || seen.material.near_specular;
        path.has_photon |= path.specular_first && !is_specular;
        if path.scatterings == 0 {
            (path.specular_first, path.by_delta) = (is_specular, lobe.is_delta);
        }
        path.scatterings += 1;
        path.p = surface.p;
        path.cos = to.dot(surface.ng).abs();
        path.parallel = false;
        path.direction_pdf = if lobe.is_delta { 1.0 } else { pdf };
        path.vertex_pdf = vertex_pdf;
        let crosses = (to.dot(surface.ng) > 0.0) != (light.dot(surface.ng) > 0.0);
        if crosses && seen.material.has_inside() {
            path.media.cross(self.scene, surface, seen.material, to.dot(surface.ng) < 0.0);
        }
        self.send(index, surface, to);
    }

    /// Traces the rays to the camera and passes on the contributions that arrive.
    fn join(&mut self, stats: &mut RayStats, contribute: &mut impl FnMut(Splat, f64, u32)) {
        if self.connections.is_empty() {
            return;
        }
        stats.light += self.connections.len() as u64;
        self.scene.transmittance_batch(&mut self.camera_rays, &mut self.through);
        for (i, CameraConnection { splat, weight, group }) in self.connections.drain(..).enumerate() {
            let mut through = self.through[i / LANES].get(i % LANES);
            if through.is_black()
                && !self.scene.hidden_from_camera.is_empty()
                && let Some(ray) = self.camera_rays.get(i)
            {
                through = self.scene.transmittance_to_camera(&ray);
            }
            if !through.is_black() {
                contribute(Splat { color: splat.color * through, ..splat }, weight, group);
            }
        }
        self.camera_rays.clear();
    }
}

impl LightTracer for LightPathBatch<'_> {
    fn trace(
        &mut self,
        paths: Range<u64>,
        stop: &dyn Fn() -> bool,
        splats: &mut Vec<Splat>,
        stats: &mut RayStats,
    ) -> bool {
        self.photons.clear();
        self.begin(paths.start, (paths.end - paths.start) as u32);
        while !self.rays.is_empty() {
            if stop() {
                return false;
            }
            self.round(stats, &mut |splat, weight, _| {
                splats.push(Splat { color: splat.color * weight as f32, ..splat });
            });
        }
        true
    }

    fn photons(&mut self) -> &mut Vec<Photon> {
        &mut self.photons
    }
}

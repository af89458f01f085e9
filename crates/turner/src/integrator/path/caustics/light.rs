//! Light paths: from a light by way of what gathers its light, joined to the camera wherever they are scattered after that.
//!
//! Paths of a batch advance together, a bounce at a time; what a path brings depends on nothing but its number.

use std::ops::Range;

use turner_bvh::lanes::LANES;

use super::light_path::LightPath;
use super::photons::Photon;
use super::towards::{Scattered, Seen};
use super::{Plan, power};
use crate::camera::Projection;
use crate::color::Spectrum;
use crate::film::Splat;
use crate::integrator::path::Context;
use crate::integrator::path::media::{Boundary, Media};
use crate::integrator::path::settings::{Bounces, Settings};
use crate::integrator::path::shade::{FIRST_SET, MAX_VERTICES};
use crate::integrator::{LightTracer, RayStats};
use crate::material::{AlphaMode, Material, PrincipledMaterial};
use crate::math::{DVec2, DVec3, Ray};
use crate::sampler::{OwenSobol, SampleId};
use crate::scene::casters::{NO_GROUP, Source};
use crate::scene::{Hit, RayBatch, Scene, SpectrumBlock, SurfaceInteraction};
use crate::schema::ColorSource;
use crate::view::View;

/// Light paths have numbers of their own, whatever the pixels' are.
const SEED: u64 = 0x9c6e_1d3a_75f1_20b4;

/// Dimensions of a start: sets 0 and 1; then two for each surface.
const START_SETS: [u32; 2] = [0, 1];

/// What a path brings to the camera if nothing is in the way.
struct Joined {
    splat: Splat,
    /// Number of the light path.
    weight: f64,
    group: u32,
}

/// Light paths at work in one thread.
pub(in crate::integrator::path) struct LightWave<'a> {
    settings: Settings,
    scene: &'a Scene,
    view: &'a View,
    plan: &'a Plan,
    paths: Vec<LightPath>,
    rays: RayBatch,
    of_ray: Vec<u32>,
    hits: Vec<Option<Hit>>,
    next: RayBatch,
    of_next: Vec<u32>,
    views: RayBatch,
    joined: Vec<Joined>,
    through: Vec<SpectrumBlock>,
    /// Where paths arrive that camera paths may find; only filled where they do.
    pub(super) photons: Vec<Photon>,
    /// How many surfaces have scattered paths so far.
    pub(super) scattered: u64,
    /// How many of these surfaces have a thin film.
    pub(super) films: u64,
}

impl<'a> LightWave<'a> {
    pub(in crate::integrator::path) fn new(context: Context<'a>, plan: &'a Plan) -> LightWave<'a> {
        let Context { scene, view, settings, .. } = context;
        LightWave {
            settings,
            scene,
            view,
            plan,
            paths: Vec::new(),
            rays: RayBatch::default(),
            of_ray: Vec::new(),
            hits: Vec::new(),
            next: RayBatch::default(),
            of_next: Vec::new(),
            views: RayBatch::default(),
            joined: Vec::new(),
            through: Vec::new(),
            photons: Vec::new(),
            scattered: 0,
            films: 0,
        }
    }

    /// Traces paths `first..first + count` of all and gives what each brings to the camera: the splat, its weight beside the other ways, and the group.
    pub(super) fn advance(
        &mut self,
        first: u64,
        count: u32,
        stats: &mut RayStats,
        mut bring: impl FnMut(Splat, f64, u32),
    ) {
        self.photons.clear();
        self.begin(first, count);
        while !self.rays.is_empty() {
            self.round(stats, &mut bring);
        }
    }

    /// Takes all paths one bounce on.
    fn round(&mut self, stats: &mut RayStats, bring: &mut impl FnMut(Splat, f64, u32)) {
        stats.light += self.rays.len() as u64;
        if self.scene.moves {
            for (i, &path) in self.of_ray.iter().enumerate() {
                self.rays.set_time(i, self.paths[path as usize].time);
            }
        }
        let mut hits = std::mem::take(&mut self.hits);
        self.scene.intersect_batch(&mut self.rays, &mut hits);
        let of_ray = std::mem::take(&mut self.of_ray);
        for (i, (&path, hit)) in of_ray.iter().zip(&hits).enumerate() {
            if let (Some(ray), Some(hit)) = (self.rays.get(i), hit) {
                self.meet(path, &ray, hit);
            }
        }
        (self.of_ray, self.hits) = (of_ray, hits);
        self.join(stats, bring);
        std::mem::swap(&mut self.rays, &mut self.next);
        std::mem::swap(&mut self.of_ray, &mut self.of_next);
        self.next.clear();
        self.of_next.clear();
    }

    /// The photons of the last paths.
    pub(super) fn take_photons(&mut self) -> Vec<Photon> {
        std::mem::take(&mut self.photons)
    }

    /// The starts of paths.
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
            let Some(start) = self.plan.casters.start(self.scene, [c0, c1, c2], [p0, p1], [a0, a1]) else {
                continue;
            };
            let [open, close] = self.view.film.shutter;
            let path = LightPath {
                numbers,
                time: if self.scene.moves { (open + (close - open) * time) as f32 } else { 0.0 },
                start,
                beta: Spectrum::WHITE,
                vertex: 0,
                bounces: Bounces::default(),
                transparent: 0,
                media: Media::NONE,
                band: None,
                mirrored: false,
                by_delta: false,
                left: false,
                scattered: 0,
                p: start.ray.origin,
                cos: 0.0,
                far: false,
                forward: 0.0,
                area: 0.0,
                by_chance: 0.0,
                by_light: 0.0,
            };
            self.rays.push(&start.ray);
            self.of_ray.push(self.paths.len() as u32);
            self.paths.push(path);
        }
    }

    /// A path's ray hits a surface.
    fn meet(&mut self, index: u32, ray: &Ray, hit: &Hit) {
        let scene = self.scene;
        let path = &mut self.paths[index as usize];
        if path.scattered == 0
            && let Material::Physical(m) = scene.material_at(hit)
            && !m.focuses
            && m.plain().is_some()
        {
            // Camera paths find the light of what gathers none.
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
        let met = match scene.material_at(hit) {
            Material::Physical(m) if m.desc.alpha_mode != AlphaMode::Blend => Some(&**m),
            Material::Physical(m) => (chance < f64::from(m.desc.coverage(scene, &surface))).then_some(&**m),
            Material::Mix(m) => m.choose(scene, &surface, outside, chance),
            Material::Classic(_) | Material::Principled(..) => return,
        };
        let Some(material) = met else {
            return self.go_straight(index, &surface, ray.direction, Spectrum::WHITE);
        };
        if material.desc.unlit {
            return;
        }
        if material.pane {
            let seen = Seen { scene, material, surface: &surface, around: 1.0, band: None };
            let straight = seen.from(-ray.direction, |v| v.straight());
            return self.go_straight(index, &surface, ray.direction, straight);
        }
        let mut around = 1.0;
        if material.has_inside() {
            if path.scattered == 0 && !outside && path.media.is_empty() {
                // The light is within.
                path.media.cross(scene, &surface, material, true);
                if let Some(left) = path.media.transmittance(hit.shape.t) {
                    path.beta = path.beta * left;
                }
            }
            match path.media.boundary(surface.material, material.desc.specular_ior, outside) {
                Boundary::Between(ior) => around = ior,
                Boundary::Hidden => {
                    path.media.cross(scene, &surface, material, outside);
                    return self.go_straight(index, &surface, ray.direction, Spectrum::WHITE);
                }
            }
        }
        if path.scattered == 0 {
            let group = if material.focuses { self.plan.casters.group(&surface) } else { NO_GROUP };
            if group == NO_GROUP || group != path.start.group || !path.emit(scene, self.plan, &surface, ray) {
                return;
            }
        }
        if material.dispersion.is_some() && path.band.is_none() {
            path.choose_band(chance);
        }
        let seen = Seen { scene, material, surface: &surface, around, band: path.band };
        let stays = self.plan.merges && path.mirrored && !material.narrow;
        if stays && path.bounces.total < self.settings.max_depth {
            let photon = Photon {
                p: surface.p,
                light: (-ray.direction).as_vec3().to_array(),
                normal: surface.ng.as_vec3().to_array(),
                power: path.beta,
                depth: path.bounces.total,
                by_delta: path.by_delta,
            };
            if seen.is_smooth(-ray.direction) {
                self.photons.push(photon);
            }
        }
        let path = &self.paths[index as usize];
        // What a narrow lobe shows of light left before is found there by camera paths.
        if path.scattered > 0 && !(self.plan.merges && path.left && material.narrow) {
            self.join_later(index, &seen, -ray.direction, DVec2::new(l0, l1));
        }
        self.scatter(index, &seen, -ray.direction, set + 1);
    }

    /// Goes on through what is not there, or lets light pass straight.
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

    /// Joins a path to the camera at a surface that light from `light` reaches.
    fn join_later(&mut self, index: u32, seen: &Seen<'_>, light: DVec3, lens: DVec2) {
        let (scene, path) = (self.scene, &self.paths[index as usize]);
        let surface = seen.surface;
        if path.bounces.total >= self.settings.max_depth {
            return;
        }
        let Some(Projection { place, to_camera, free, density }) =
            self.view.camera.project(&self.view.film, surface.p, lens)
        else {
            return;
        };
        let (width, height) = (f64::from(self.view.film.width), f64::from(self.view.film.height));
        let margin = self.plan.margin;
        if place.x < -margin || place.y < -margin || place.x >= width + margin || place.y >= height + margin {
            return;
        }
        let eye = to_camera.normalize();
        let (f, back) = seen.light_to_eye(light, eye);
        if f.is_black() {
            return;
        }
        let (cos_light, cos_eye) = (light.dot(surface.ng).abs(), eye.dot(surface.ng).abs());
        let mut color = path.beta * f * (cos_eye * density / cos_light) as f32;
        let mut media = path.media;
        let crosses = (eye.dot(surface.ng) > 0.0) != (light.dot(surface.ng) > 0.0);
        if crosses && seen.material.has_inside() {
            media.cross(scene, surface, seen.material, eye.dot(surface.ng) < 0.0);
        }
        if let Some(left) = media.transmittance(to_camera.length()) {
            color = color * left;
        }
        let origin = surface.leave(eye);
        let way = surface.p + to_camera - origin;
        let view = Ray { t_max: free, ..Ray::new(origin, way) };
        // The other ways to find this path.
        let others = path.found_back(surface, back) * (density * cos_eye / path.finds(surface));
        let paths = self.plan.paths as f64;
        let weight = power(path.by_chance * others / paths, path.by_light * others / paths);
        self.views.push_from(&view, surface);
        if scene.moves {
            self.views.set_time(self.joined.len(), path.time);
        }
        self.joined.push(Joined { splat: Splat { place, color }, weight, group: path.start.group });
    }

    /// Scatters a path.
    fn scatter(&mut self, index: u32, seen: &Seen<'_>, light: DVec3, set: u32) {
        self.scattered += 1;
        self.films += u64::from(has_film(&seen.material.desc));
        let path = &mut self.paths[index as usize];
        let surface = seen.surface;
        let [u0, u1, u2, u3] = path.numbers.four(set);
        let Some(Scattered { to, lobe, pdf, weight, back }) = seen.scatter(light, [u2, u0, u1]) else {
            return;
        };
        let Some(bounces) = self.settings.count(&path.bounces, &lobe) else { return };
        let before = path.beta.max_component();
        path.beta = path.beta * weight;
        if path.beta.is_black() || !path.beta.is_finite() {
            return;
        }
        // The first surface: how else the light may be found from there.
        let area = path.finds(surface);
        if path.scattered == 0 {
            let by_light = if lobe.is_delta { 0.0 } else { path.by_light(self.scene, surface, to) };
            let d2 = (surface.p - path.p).length_squared();
            let found = match path.start.from {
                Source::Delta(..) => 0.0,
                Source::Around(_) => back,
                Source::Shape => back * path.cos / d2,
            };
            (path.by_chance, path.by_light) = (found / path.by_chance, by_light);
        } else {
            let ratio = path.found_back(surface, back);
            path.by_chance *= ratio;
            path.by_light *= ratio;
        }
        if path.scattered > 1 {
            let lives = (path.beta.max_component() / before).clamp(0.05, 1.0);
            if u3 >= f64::from(lives) {
                return;
            }
            path.beta *= 1.0 / lives;
        }
        path.bounces = bounces;
        let sharp = lobe.is_delta || seen.material.narrow;
        path.left |= path.mirrored && !sharp;
        if path.scattered == 0 {
            (path.mirrored, path.by_delta) = (sharp, lobe.is_delta);
        }
        path.scattered += 1;
        path.p = surface.p;
        path.cos = to.dot(surface.ng).abs();
        path.far = false;
        path.forward = if lobe.is_delta { 1.0 } else { pdf };
        path.area = area;
        let crosses = (to.dot(surface.ng) > 0.0) != (light.dot(surface.ng) > 0.0);
        if crosses && seen.material.has_inside() {
            path.media.cross(self.scene, surface, seen.material, to.dot(surface.ng) < 0.0);
        }
        self.send(index, surface, to);
    }

    /// Brings what is not hidden from the camera.
    fn join(&mut self, stats: &mut RayStats, bring: &mut impl FnMut(Splat, f64, u32)) {
        if self.joined.is_empty() {
            return;
        }
        stats.light += self.joined.len() as u64;
        self.scene.transmittance_batch(&mut self.views, &mut self.through);
        for (i, Joined { splat, weight, group }) in self.joined.drain(..).enumerate() {
            let through = self.through[i / LANES].get(i % LANES);
            if !through.is_black() {
                bring(Splat { color: splat.color * through, ..splat }, weight, group);
            }
        }
        self.views.clear();
    }
}

impl LightTracer for LightWave<'_> {
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

/// Whether a material may have a thin film.
fn has_film(material: &PrincipledMaterial) -> bool {
    material.thin_film_weight != ColorSource::Constant(Spectrum::BLACK)
}

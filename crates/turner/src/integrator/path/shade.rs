//! Shading of one vertex: emission, direct light and the next ray.

use super::LightSampling;
use super::dispersion::DispersiveHit;
use super::light_resampling::{CANDIDATES, resample};
use super::lobe_split::Share;
use super::media::Boundary;
use super::path_batch::{Path, PathBatch, VertexInput};
use super::record::{End, InfiniteLightRecord, Passage, Record, Roulette};
use super::settings::Settings;
use super::shared_paths::{SecondLight, SecondNext};
use crate::bsdf::{Bsdf, BsdfSample};
use crate::color::Spectrum;
use crate::integrator::{Radiance, RayStats, footprint};
use crate::material::vertex::{Met, Vertex, coated, prepare};
use crate::material::{AlphaMode, Material, OpenPbr};
use crate::math::Ray;
use crate::scene::caustic_targets::CausticTargets;
use crate::scene::light_sample::LightSample;
use crate::scene::{Hit, Scene, SurfaceInteraction};

/// Sets of random numbers: one for the position in the pixel, one for the lens, then two for each vertex.
pub(super) const FIRST_SET: u32 = 2;

/// Maximum number of surfaces along one path, including those that it passes straight through.
pub(super) const MAX_VERTICES: u32 = 200_000;

impl Settings {
    /// MIS weight of an emitter that a BSDF-sampled ray hits. `light_pdf` is the density with which light sampling
    /// finds it. `light_path_ratio` is the squared ratio of the light paths' density to the density of BSDF sampling.
    #[inline]
    pub(super) fn weight_found(&self, path: &Path, light_pdf: f64, light_path_ratio: f64) -> f64 {
        let sampling = match self.light_sampling {
            _ if path.specular_bounce || light_pdf <= 0.0 => 0.0,
            LightSampling::Both => light_pdf / path.pdf,
            LightSampling::Bsdf => 0.0,
            LightSampling::Light => return 0.0,
        };
        1.0 / (1.0 + sampling * sampling + light_path_ratio)
    }

    /// MIS weight of a sampled light, and its unshadowed contribution. `light_path_ratio` is the squared ratio of the
    /// light paths' density to the density of light sampling.
    #[inline]
    fn unshadowed(
        &self,
        path: &Path,
        lit: &LightSample,
        met: &Met,
        light_path_ratio: f64,
    ) -> (f64, Spectrum) {
        // Power heuristic, exponent 2 (Veach & Guibas 1995). An infinite ratio correctly gives weight 0.
        let bsdf_ratio = match (lit.is_delta, self.light_sampling) {
            (false, LightSampling::Both) => met.pdf / lit.pdf,
            _ => 0.0,
        };
        let weight = 1.0 / (1.0 + bsdf_ratio * bsdf_ratio + light_path_ratio);
        let k = weight * met.wi_local.z.abs() / lit.pdf;
        (weight, path.beta * met.f * lit.radiance * k as f32)
    }

    /// Adds light to a pixel; returns what was added.
    #[inline]
    pub(super) fn add(&self, path: &Path, light: Spectrum, pixel: &mut Radiance) -> Spectrum {
        let light = self.clamped(light, path.bounces.total > 1);
        pixel.color += light;
        light
    }

    /// Applies `clamp_indirect`. `indirect` is true for light that arrives by way of another surface.
    #[inline]
    pub(super) fn clamped(&self, light: Spectrum, indirect: bool) -> Spectrum {
        match self.clamp_indirect {
            Some(most) if indirect && light.max_component() > most => light * (most / light.max_component()),
            _ => light,
        }
    }
}

/// Whether the camera sees the background instead of environment lights.
#[inline]
fn hides_environment(scene: &Scene) -> bool {
    scene.background.transparent || !scene.background.environment
}

/// The factor by which `clamp_indirect` has scaled light.
#[inline]
pub(super) fn clamped_by(light: Spectrum, added: Spectrum) -> f32 {
    let (whole, left) = (light.max_component(), added.max_component());
    if left < whole && whole.is_finite() { left / whole } else { 1.0 }
}

impl<R: Record> PathBatch<'_, R> {
    /// Shades a ray that leaves the scene: environment, background, ambient light.
    pub(super) fn miss(
        &mut self,
        sample: u32,
        ray: &Ray,
        escaped: impl Iterator<Item = (usize, Spectrum, f64)>,
        pixel: &mut Radiance,
    ) {
        let (scene, path) = (self.scene, &self.paths[sample as usize]);
        self.record.note(|r| r.end = End::Escaped);
        if path.from_camera && scene.background.transparent {
            pixel.alpha = 0.0;
            return;
        }
        if path.from_camera && self.settings.hide_emitters {
            return;
        }
        // Glass in front of a transparent background is transparent as far as light passes it.
        if path.seen_through && scene.background.transparent {
            pixel.alpha = 1.0 - (path.beta.to_array().iter().sum::<f32>() / 3.0).clamp(0.0, 1.0);
            return;
        }
        let mut beta = path.beta;
        let transmittance = path.media.transmittance(f64::INFINITY);
        if let Some(transmittance) = transmittance {
            beta = beta * transmittance;
        }
        self.record.note(|r| r.escaped(path, ray, transmittance, beta));
        if path.seen_through && !scene.background.environment {
            let background = scene.background.color(ray.direction);
            let added = self.settings.add(path, beta * background, pixel);
            self.record.note(|r| r.at_escape(|e| (e.background, e.contribution) = (background, added)));
            return;
        }
        let mut found = Spectrum::BLACK;
        for (index, radiance, light_pdf) in escaped {
            let light_path_ratio = match self.strategy {
                Some(_) => {
                    let light = scene.emitters.infinite_ids()[index];
                    let density = |caustic_targets: &CausticTargets, group| {
                        caustic_targets.infinite_pdf(scene, group, light, ray.direction)
                    };
                    if self.counted_by_photons(sample, density) {
                        continue;
                    }
                    self.light_path_ratio_escaped(sample, light, ray.direction)
                }
                None => 0.0,
            };
            let light_pdf = self.pdf_of_samples(path, ray.direction, light_pdf);
            let weight = self.settings.weight_found(path, light_pdf, light_path_ratio);
            found += radiance * weight as f32;
            let light = scene.emitters.infinite_ids()[index];
            self.groups.find_light(scene, light, radiance * weight as f32);
            self.record.note(|r| {
                r.at_escape(|e| e.lights.push(InfiniteLightRecord { radiance, light_pdf, weight }))
            });
        }
        if !scene.emitters.has_infinite_lights() {
            let background = scene.background.color(ray.direction);
            found += background;
            self.record.note(|r| r.at_escape(|e| e.background = background));
        }
        if !path.from_camera {
            found += scene.ambient;
            self.record.note(|r| r.at_escape(|e| e.ambient = scene.ambient));
        }
        let added = self.settings.add(path, beta * found, pixel);
        self.groups.add_found(sample, path, beta * clamped_by(beta * found, added));
        self.record.note(|r| r.at_escape(|e| e.contribution = added));
    }

    /// Whether to sample a light at a hit. It is also true where only shading can decide that no light is needed.
    #[inline]
    pub(super) fn may_connect(
        &self,
        path: &Path,
        ray: &Ray,
        hit: &Hit,
        surface: &SurfaceInteraction,
    ) -> bool {
        if self.settings.light_sampling == LightSampling::Bsdf
            || self.guides.are_alone()
            || self.is_spent(path)
        {
            return false;
        }
        if path.from_camera && self.scene.is_shadow_catcher(hit) {
            return false;
        }
        match self.scene.material_at(hit) {
            Material::OpenPbr(m) => {
                let bsdf = m.constant_bsdf(ray.direction.dot(surface.ng) < 0.0);
                !m.desc.unlit && !m.boundary && bsdf.is_none_or(Bsdf::has_smooth)
            }
            Material::Mix(_) => true,
            Material::Classic(_) | Material::Principled(..) => false,
        }
    }

    /// Whether the path ends at its next vertex.
    #[inline]
    pub(super) fn is_spent(&self, path: &Path) -> bool {
        path.bounces.total >= self.settings.max_depth
            || self.settings.direct && path.any_nonspecular
            || path.ends
    }

    /// Shades a ray that hits a surface: emission, direct light and the next ray.
    pub(super) fn shade(&mut self, at: &VertexInput<'_>, pixel: &mut Radiance, stats: &mut RayStats) {
        let scene = self.scene;
        let &VertexInput { sample, ref ray, surface, .. } = at;
        let hit = &surface.hit;
        let path = &mut self.paths[sample as usize];
        let transmittance = path.media.transmittance(hit.shape.t);
        if let Some(transmittance) = transmittance {
            path.beta = path.beta * transmittance;
        }
        self.record.note(|r| r.hit_surface(scene, path, ray, hit, surface, transmittance));
        path.vertex += 1;
        if path.vertex > MAX_VERTICES {
            self.record.note(|r| r.end = End::Vertices);
            return;
        }
        if path.from_camera && scene.is_shadow_catcher(hit) {
            return self.catch_shadow(at);
        }
        let outside = ray.direction.dot(surface.ng) < 0.0;
        let met = match scene.material_at(hit) {
            Material::OpenPbr(m) if m.desc.alpha_mode != AlphaMode::Blend => Some(&**m),
            Material::OpenPbr(m) => {
                let opacity = f64::from(m.desc.coverage(scene, surface));
                (opacity >= 1.0 || path.numbers.first()[3] < opacity).then_some(&**m)
            }
            Material::Mix(m) => m.choose(scene, surface, outside, path.numbers.first()[3]),
            Material::Classic(_) | Material::Principled(..) => return,
        };
        let Some(material) = met else {
            return self.pass_hole(sample, surface, ray.direction);
        };
        self.record.note(|r| r.chose_material(scene, material));
        if material.boundary {
            path.media.cross(scene, surface, material, outside);
            self.record.note(|r| r.at(|v| v.passage = Passage::Interface));
            self.next.push(sample, surface, ray.direction);
            return;
        }
        if path.from_camera && self.settings.hide_emitters && material.is_emissive() {
            self.record.note(|r| r.at(|v| v.passage = Passage::Hole));
            self.next.push(sample, surface, ray.direction);
            return;
        }
        if material.desc.unlit {
            return self.add_unlit(sample, material, surface, pixel);
        }
        if material.is_emissive() && (outside || material.emits_backwards()) {
            self.add_emission(sample, material, surface, pixel);
        }
        let path = &self.paths[sample as usize];
        // A path that has spent its bounces still passes through thin panes, as shadow rays do.
        let spent = self.is_spent(path);

        if spent && !material.pane {
            self.record.note(|r| r.end = End::Depth);
            return;
        }
        let mut exterior_ior = 1.0;
        if material.has_inside() {
            let path = &mut self.paths[sample as usize];
            match path.media.boundary(surface.material, material.desc.specular_ior, outside) {
                Boundary::Between(ior) => {
                    exterior_ior = ior;
                    if let Some(reverse) = self.reverse_pdfs.get_mut(sample as usize) {
                        reverse.exterior_ior = ior;
                    }
                    self.record.note(|r| r.at(|v| v.ior_around = Some(ior)));
                }
                Boundary::Hidden => {
                    self.record.note(|r| r.at(|v| v.passage = Passage::Hidden));
                    path.media.cross(scene, surface, material, outside);
                    self.next.push(sample, surface, ray.direction);
                    return;
                }
            }
        }
        if let Some(indices) = material.dispersion {
            let prism = DispersiveHit { material, indices, surface, exterior_ior, outside };
            self.disperse(at, &prism, pixel, stats);
            return;
        }
        let made;
        let bsdf = match material.constant_bsdf(outside) {
            Some(bsdf) if exterior_ior == 1.0 => bsdf,
            _ => {
                made = material.bsdf(scene, surface, exterior_ior, outside);
                &made
            }
        };
        let coated = coated(scene, ray, material, surface, bsdf, outside);
        let bsdf = coated.as_ref().unwrap_or(bsdf);
        let vertex = prepare(scene, ray, material, surface, bsdf, outside);
        self.scatter(at, &vertex, material, bsdf.has_smooth() && !spent, pixel, stats);
    }

    /// Direct light (if `smooth`: the BSDF has a lobe that is not a delta lobe) and the next ray.
    pub(super) fn scatter(
        &mut self,
        at: &VertexInput<'_>,
        vertex: &Vertex<'_>,
        material: &OpenPbr,
        smooth: bool,
        pixel: &mut Radiance,
        stats: &mut RayStats,
    ) {
        if self.shared_paths.is_on() {
            self.note_shared_vertex(at.sample, vertex, material);
        }
        if smooth && self.photons.is_some() {
            self.merge(at.sample, vertex, material, pixel);
        }
        if smooth {
            self.connect(at.sample, vertex, material, at.lit);
        }
        let [u0, u1, u2, u3] = self.paths[at.sample as usize].numbers.second();
        if let Some(entry) = vertex.bsdf.enter([u2, u0, u1]) {
            return self.random_walk(at, material, &entry, u3, pixel, stats);
        }
        if let Some(s) = vertex.bsdf.sample([u2, u0, u1]) {
            self.follow(at.sample, vertex, material, s, u3, stats);
        }
    }

    /// Queues shadow rays to the sampled lights, or to one candidate.
    fn connect(&mut self, sample: u32, v: &Vertex<'_>, material: &OpenPbr, lit: &[Option<LightSample>]) {
        if !self.paths[sample as usize].resamples {
            return lit.iter().flatten().for_each(|lit| self.connect_to(sample, v, material, lit, 1.0));
        }
        let (taken, resampling_weight) = self.choose_light(&self.paths[sample as usize], v, lit);
        if let Some(Some(lit)) = lit.get(taken) {
            self.connect_to(sample, v, material, lit, resampling_weight);
        }
    }

    /// Queues a shadow ray to a light.
    fn connect_to(
        &mut self,
        sample: u32,
        v: &Vertex<'_>,
        material: &OpenPbr,
        lit: &LightSample,
        resampling_weight: f32,
    ) {
        let path = &self.paths[sample as usize];
        let Some(met) = v.met(lit.to_light) else { return };
        let (wi, wi_local, crosses) = (met.wi, met.wi_local, met.crosses);
        let candidates = if path.resamples { path.extra_candidates + 1 } else { 1 };
        self.record.note(|r| {
            r.sampled_light(lit, wi, met.f, met.pdf, wi_local.z.abs(), (candidates, resampling_weight))
        });
        // Behind glass the background is seen instead of the lights of the environment.
        let hides_lights = hides_environment(self.scene);
        let is_behind = hides_lights && path.seen_through && crosses && !lit.finite && !lit.is_delta;
        if met.f.is_black() || is_behind {
            return;
        }
        let light_path_ratio = match self.strategy {
            Some(_) if material.casts_caustics => self.light_path_ratio_sampled(sample, v, material, lit, wi),
            _ => 0.0,
        };
        let (weight, mut light) = self.settings.unshadowed(path, lit, &met, light_path_ratio);
        light *= resampling_weight;
        let length = if lit.finite { met.distance } else { f64::INFINITY };
        let crossed = crosses.then(|| path.media.after(self.scene, v.surface, material, wi));
        let media = crossed.as_ref().unwrap_or(&path.media);
        let transmittance = media.transmittance(length);
        if let Some(transmittance) = transmittance {
            light = light * transmittance;
        }
        if light.is_black() {
            return;
        }
        let light = self.settings.clamped(light, path.bounces.total > 0);
        self.record.note(|r| r.weighted_light(weight, transmittance, light));
        let origin = v.surface.leave(wi);
        let ray = if lit.finite {
            Ray { t_max: 1.0, ..Ray::new(origin, v.surface.p + lit.to_light - origin) }
        } else {
            Ray::new(origin, wi)
        };
        if let Some(second) = self.shared_paths.directional_at(sample) {
            let (k, softening) = (wi_local.z.abs() / lit.pdf, v.bsdf.softening(wi_local));
            let weighed = !lit.is_delta && self.settings.light_sampling == LightSampling::Both;
            let (radiance, pdf, ray) = (lit.radiance, lit.pdf, self.shadows.light.len());
            second.set_light(SecondLight { wi: wi_local, radiance, k, softening, pdf, weighed, ray });
        }
        if self.scene.volumes.is_some() {
            let media = *media;
            self.push_media(sample, media);
        }
        self.groups.push_shadow_ray(self.groups.of_sample(self.scene, lit));
        self.lobes.push_shadow_ray(sample, || Share::of_vertex(v, wi_local, crosses));
        self.shadows.push(&ray, [v.surface.hit.origin(), lit.target()], sample, light);
    }

    /// Chooses one of several candidate lights by resampling; returns its index and its resampling weight.
    fn choose_light(&self, path: &Path, v: &Vertex<'_>, lit: &[Option<LightSample>]) -> (usize, f32) {
        let mut contributions = [0.0; CANDIDATES];
        for (contributions, lit) in contributions.iter_mut().zip(lit) {
            if let Some(lit) = lit
                && let Some(met) = v.met(lit.to_light)
                && !met.f.is_black()
            {
                *contributions = self.settings.unshadowed(path, lit, &met, 0.0).1.luminance();
            }
        }
        let first = || (lit.iter().position(Option::is_some).unwrap_or(0), 1.0);
        resample(&contributions, path.numbers.first()[0]).unwrap_or_else(first)
    }

    /// Continues in the sampled direction; `u` decides Russian roulette.
    pub(super) fn follow(
        &mut self,
        sample: u32,
        v: &Vertex<'_>,
        material: &OpenPbr,
        s: BsdfSample,
        u: f64,
        stats: &mut RayStats,
    ) {
        let wi = v.frame.to_world(s.wi);
        let Some(crosses) = v.crosses(wi, s.wi) else { return };
        if material.pane && crosses && s.lobe.is_delta {
            self.paths[sample as usize].media.pass(self.scene, v.surface, material, wi);
            return self.pass(sample, v.surface, v.wo, &s);
        }
        let path = &mut self.paths[sample as usize];
        if self.settings.direct && path.any_nonspecular {
            self.record.note(|r| r.end = End::Depth);
            return;
        }
        let Some(bounces) = self.settings.count(&path.bounces, &s.lobe) else {
            self.record.note(|r| r.end = End::Depth);
            return;
        };
        if self.strategy.is_some() {
            let first = path.bounces.total == 0;
            self.update_reverse_pdf(sample, v, material, &s, wi, first);
        }
        let number = self.paths[sample as usize].vertex;
        let receiver = self.receiver(sample, number, v.surface, -v.wo);
        let path = &mut self.paths[sample as usize];
        if s.lobe.is_delta
            && let Some(second) = self.shared_paths.directional_at(sample)
        {
            second.take_back(path);
            self.record.note(|r| r.donated_until = Some(r.vertices.len()));
        }
        path.beta = path.beta * s.f * (s.wi.z.abs() / s.pdf) as f32;
        let softening = if crosses || s.lobe.is_delta { 1.0 } else { v.bsdf.softening(s.wi) };
        self.record.note(|r| r.scattered(wi, &s, softening, path.beta));
        self.lobes.leaves(sample, || match s.lobe.is_delta && !crosses {
            true => Share::lobe(false),
            false => Share::of_vertex(v, s.wi, crosses),
        });
        path.bounces = bounces;
        path.from_camera = false;
        path.seen_through &= crosses && !s.lobe.is_diffuse;
        path.specular_bounce = s.lobe.is_delta;
        path.any_nonspecular |= !s.lobe.is_delta;
        path.pdf = s.pdf;
        path.origin = receiver.with_candidates(path.extra_candidates);
        if let Some(pixel) = &self.view.pixel_cone {
            path.cone = footprint::leave(self.scene, pixel, path.cone, v.surface, v.wo, &s, crosses);
        }
        if crosses {
            path.eta2 *= (s.eta * s.eta) as f32;
            path.media.pass(self.scene, v.surface, material, wi);
            stats.refracted += 1;
        } else {
            stats.reflected += 1;
        }
        path.begin_roulette();
        let mut survived = 1.0;
        if let Some(survival) = self.settings.survival(path) {
            let survives = u < f64::from(survival);
            self.record.note(|r| r.roulette(Roulette { survival: f64::from(survival), number: u }));
            if !survives {
                self.record.note(|r| r.end = End::Roulette);
                return;
            }
            path.beta *= 1.0 / survival;
            survived = survival;
            self.record.note(|r| r.set_throughput(path.beta));
        }
        if path.beta.is_black() {
            return;
        }
        if !s.lobe.is_delta
            && let Some(second) = self.shared_paths.directional_at(sample)
        {
            second.set_next(SecondNext { wi: s.wi, k: s.wi.z.abs(), softening, survival: survived });
        }
        self.next.push(sample, v.surface, wi);
    }
}

//! Paths of many samples, a bounce at a time.

use std::sync::Arc;

use turner_bvh::lanes::LANES;

use super::Context;
use super::caustics::{CausticsStrategy, PhotonMap, ReversePdf};
use super::media::Media;
use super::record::{Off, Record};
use super::settings::{Bounces, Settings};
use super::shade::FIRST_SET;
use super::shared_paths::SharedPaths;
use super::simd_shading::VertexBlocks;
use super::volume_light::ShadowRayMedia;
use crate::color::Spectrum;
use crate::integrator::{CameraSamples, Radiance, RayStats, Tracer, footprint};
use crate::light::Receiver;
use crate::math::{DVec3, Ray, RayCone};
use crate::sampler::{OwenSobol, SampleId, VertexNumbers};
use crate::scene::emitters::LightSample;
use crate::scene::{
    EscapedRays, Hit, LightBatch, RayBatch, RayOrigin, Scene, SpectrumBlock, SurfaceInteraction,
};
use crate::view::View;

/// How far the path of one sample has come.
#[derive(Default)]
pub(super) struct Path {
    pub(super) sampler: OwenSobol,
    /// The random numbers of the surface that is met.
    pub(super) numbers: VertexNumbers,
    /// Its moment, for things that move.
    time: f32,
    /// The share of what the next ray finds that reaches the pixel.
    pub(super) beta: Spectrum,
    /// What that is the share of, for the chance to go on: 1, or of a path that is lent the share of its second surface in its own pixel.
    pub(super) importance: f32,
    /// Whether what it finds counts for its neighbours, too.
    pub(super) donates: bool,
    /// Surfaces met so far, each with its own sets of random numbers.
    pub(super) vertex: u32,
    pub(super) bounces: Bounces,
    pub(super) transparent: u32,
    /// Whether the ray still comes straight from the camera.
    pub(super) from_camera: bool,
    /// Whether light sampling could not have found what the ray finds.
    pub(super) specular_bounce: bool,
    /// Whether a lobe other than a mirror's has scattered it.
    pub(super) any_nonspecular: bool,
    /// Density of the ray's direction, and where it was chosen.
    pub(super) pdf: f64,
    pub(super) origin: Receiver,
    /// How many more lights than one were looked at where the ray ends.
    pub(super) extra_candidates: u32,
    /// The square of the index of refraction of the medium it is in: radiance is larger by it there.
    pub(super) eta2: f32,
    /// The one colour band that is left, once dispersion has parted them.
    pub(super) band: Option<u8>,
    pub(super) media: Media,
    /// What the ray stands for, from where it begins or, once it has arrived, from its end on.
    pub(super) cone: RayCone,
}

impl Path {
    /// Makes it that of a sample which is about to leave the camera.
    #[inline]
    fn begin(&mut self, id: &SampleId, time: f32, cone: RayCone) {
        self.sampler = OwenSobol::new(id);
        self.time = time;
        self.beta = Spectrum::WHITE;
        self.importance = 1.0;
        self.donates = false;
        self.vertex = 0;
        self.bounces = Bounces::default();
        self.transparent = 0;
        self.from_camera = true;
        self.specular_bounce = true;
        self.any_nonspecular = false;
        self.pdf = 1.0;
        self.origin = Receiver::from(DVec3::ZERO);
        self.extra_candidates = 0;
        self.eta2 = 1.0;
        self.band = None;
        self.media.clear();
        self.cone = cone;
    }
}

/// A ray where it ends, with the light that was sampled there.
pub(super) struct VertexInput<'a> {
    pub(super) sample: u32,
    pub(super) ray: Ray,
    pub(super) surface: &'a SurfaceInteraction,
    /// One, or several to choose from.
    pub(super) lit: &'a [Option<LightSample>],
}

/// The rays of one bounce, and whose they are.
#[derive(Default)]
pub(super) struct RayQueue {
    rays: RayBatch,
    samples: Vec<u32>,
}

impl RayQueue {
    fn clear(&mut self) {
        self.rays.clear();
        self.samples.clear();
    }

    /// A ray that leaves a surface.
    pub(super) fn push(&mut self, sample: u32, from: &SurfaceInteraction, direction: DVec3) {
        self.rays.push_from(&Ray::new(from.leave(direction), direction), from);
        self.samples.push(sample);
    }

    /// A ray that is ready.
    #[inline]
    pub(super) fn push_ray(&mut self, sample: u32, ray: &Ray, from: RayOrigin) {
        self.rays.push_leaving(ray, from);
        self.samples.push(sample);
    }

    /// A ray that leaves a place in a medium.
    pub(super) fn push_free(&mut self, sample: u32, from: DVec3, direction: DVec3) {
        self.rays.push(&Ray::new(from, direction));
        self.samples.push(sample);
    }

    /// A ray, with its sample.
    pub(super) fn get(&self, i: usize) -> Option<(Ray, u32)> {
        self.rays.get(i).zip(self.samples.get(i).copied())
    }

    /// Takes a ray out.
    pub(super) fn remove(&mut self, i: usize) {
        self.rays.remove(i);
    }
}

/// Shadow rays of one bounce, and what light they bring to which sample.
#[derive(Default)]
pub(super) struct Shadows {
    rays: RayBatch,
    light: Vec<(u32, Spectrum)>,
    through: Vec<SpectrumBlock>,
    /// In scenes with media, what each has with it.
    carried: Vec<ShadowRayMedia>,
}

impl Shadows {
    pub(super) fn push(&mut self, ray: &Ray, from: &SurfaceInteraction, sample: u32, light: Spectrum) {
        self.push_ray(ray, from.hit.origin(), sample, light);
    }

    #[inline]
    pub(super) fn push_ray(&mut self, ray: &Ray, from: RayOrigin, sample: u32, light: Spectrum) {
        self.rays.push_leaving(ray, from);
        self.light.push((sample, light));
    }

    /// A ray from a place in a medium.
    pub(super) fn push_free(&mut self, ray: &Ray, sample: u32, light: Spectrum, carried: ShadowRayMedia) {
        self.rays.push(ray);
        self.light.push((sample, light));
        self.carried.push(carried);
    }

    /// What the next ray has with it.
    pub(super) fn carry(&mut self, carried: ShadowRayMedia) {
        self.carried.push(carried);
    }
}

/// All that is known of a batch of samples while it is traced; its memory serves one batch after the other.
pub(super) struct PathBatch<'a, R = Off> {
    pub(super) settings: Settings,
    pub(super) scene: &'a Scene,
    pub(super) view: &'a View,
    pub(super) paths: Vec<Path>,
    front: RayQueue,
    pub(super) next: RayQueue,
    pub(super) shadows: Shadows,
    hits: Vec<Option<Hit>>,
    surfaces: Vec<(SurfaceInteraction, u32)>,
    /// Vertices that are shaded eight at a time; they have no place among the surfaces.
    pub(super) blocks: VertexBlocks,
    lights: LightBatch,
    around: EscapedRays,
    wanted: Vec<(OwenSobol, u32)>,
    numbers: Vec<VertexNumbers>,
    /// The light paths beside which these are weighed, and what each path knows of them; empty without.
    pub(super) strategy: Option<&'a CausticsStrategy>,
    pub(super) back: Vec<ReversePdf>,
    /// Which paths are used by neighbours.
    pub(super) shared_paths: SharedPaths,
    /// The photons of the samples' number, where samples find them.
    pub(super) photons: Option<Arc<PhotonMap>>,
    /// Luminance that they brought, of all samples together.
    pub(super) by_photons: f64,
    /// About the variance of that: the sum of the squares of what each point got over the number of its photons.
    pub(super) photon_variance: f64,
    /// What takes notes of the path, if there is but one.
    pub(super) record: R,
}

impl<'a, R> PathBatch<'a, R> {
    pub(super) fn new(context: Context<'a>, record: R) -> PathBatch<'a, R> {
        let Context { scene, view, settings, strategy, shares } = context;
        PathBatch {
            settings,
            scene,
            view,
            paths: Vec::new(),
            front: RayQueue::default(),
            next: RayQueue::default(),
            shadows: Shadows::default(),
            hits: Vec::new(),
            surfaces: Vec::new(),
            blocks: VertexBlocks::default(),
            lights: LightBatch::default(),
            around: EscapedRays::default(),
            wanted: Vec::new(),
            numbers: Vec::new(),
            strategy,
            back: Vec::new(),
            shared_paths: SharedPaths::new(shares),
            photons: None,
            by_photons: 0.0,
            photon_variance: 0.0,
            record,
        }
    }
}

impl<R: Record> Tracer for PathBatch<'_, R> {
    fn find_photons(&mut self, photons: Arc<PhotonMap>) {
        self.photons = Some(photons);
    }

    fn radiance(&mut self, samples: &CameraSamples, out: &mut Vec<Radiance>, stats: &mut RayStats) {
        let count = samples.ids.len();
        stats.camera += count as u64;
        out.clear();
        out.resize(count, Radiance { color: Spectrum::BLACK, alpha: 1.0 });
        // Those there are keep their places: lists of media are large, and mostly not read.
        self.paths.resize_with(count, Path::default);
        for (i, (path, id)) in self.paths.iter_mut().zip(&samples.ids).enumerate() {
            path.begin(id, samples.rays.time(i), footprint::of_camera(self.view, samples, i));
        }
        self.back.clear();
        if let Some(strategy) = self.strategy {
            let ray = |i: usize| samples.rays.get(i).unwrap_or(Ray::new(DVec3::ZERO, DVec3::Z));
            self.back.extend((0..count).map(|i| ReversePdf::of_camera(self.view, strategy, &ray(i))));
        }
        if let Some(volumes) = &self.scene.volumes {
            self.begin_within(volumes, samples);
        }
        self.begin_shared_paths(&samples.ids);
        self.front.rays.copy(&samples.rays);
        self.front.samples.clear();
        self.front.samples.extend(0..count as u32);
        while !self.front.samples.is_empty() {
            self.round(out, stats);
        }
        self.share(out);
    }
}

impl<R: Record> PathBatch<'_, R> {
    /// Traces the front, shades what it hits, and collects the next one.
    fn round(&mut self, out: &mut [Radiance], stats: &mut RayStats) {
        let mut hits = std::mem::take(&mut self.hits);
        let mut front = std::mem::take(&mut self.front);
        if self.scene.moves {
            for (i, &sample) in front.samples.iter().enumerate() {
                front.rays.set_time(i, self.paths[sample as usize].time);
            }
        }
        self.scene.intersect_batch(&mut front.rays, &mut hits);
        if let Some(volumes) = &self.scene.volumes {
            self.travel(volumes, &mut front, &mut hits, out, stats);
        }
        self.draw(&front.samples, &hits);
        let mut surfaces = std::mem::take(&mut self.surfaces);
        let mut lights = std::mem::take(&mut self.lights);
        self.prepare(&front, &hits, &mut surfaces, &mut lights);
        let mut around = std::mem::take(&mut self.around);
        around.clear();
        let missing = (0..front.samples.len()).zip(&hits).filter(|(_, hit)| hit.is_none());
        for ray in missing.filter_map(|(i, _)| front.rays.get(i)) {
            around.push(ray.direction);
        }
        self.scene.emitters.escaped_batch(self.scene, &mut around);
        let mut donated = std::mem::take(&mut self.shared_paths.donated);
        let mut met = surfaces.iter();
        let mut missed = 0;
        for (i, (&sample, hit)) in front.samples.iter().zip(&hits).enumerate() {
            let Some(ray) = front.rays.get(i) else { continue };
            let donates = self.paths[sample as usize].donates;
            let pixel = if donates { &mut donated[sample as usize] } else { &mut out[sample as usize] };
            if hit.is_none() {
                self.miss(sample, &ray, around.get(missed), pixel);
                missed += 1;
            } else if self.blocks.holds(i) {
                // Below, with seven others.
            } else if let Some((surface, light)) = met.next() {
                let lit = lights.get(*light as usize);
                self.shade(&VertexInput { sample, ray, surface, lit }, pixel, stats);
            }
        }
        self.shade_blocks(&lights, stats);
        (self.surfaces, self.lights, self.around) = (surfaces, lights, around);
        self.hits = hits;
        self.shared_paths.donated = donated;
        self.weigh_offers(stats);
        self.light(out, stats);
        front.clear();
        self.front = std::mem::replace(&mut self.next, front);
    }

    /// Draws the numbers of the vertices at the hits.
    fn draw(&mut self, samples: &[u32], hits: &[Option<Hit>]) {
        let hit =
            || samples.iter().zip(hits).filter(|(_, hit)| hit.is_some()).map(|(&sample, _)| sample as usize);
        self.wanted.clear();
        self.wanted.extend(hit().map(|i| (self.paths[i].sampler, FIRST_SET + 2 * self.paths[i].vertex)));
        OwenSobol::vertex_numbers(self.scene.instruction_set, &self.wanted, &mut self.numbers);
        for (i, numbers) in hit().zip(&self.numbers) {
            self.paths[i].numbers = *numbers;
        }
    }

    /// The surfaces that were hit, with the number under which each asks for light; and that light.
    fn prepare(
        &mut self,
        front: &RayQueue,
        hits: &[Option<Hit>],
        surfaces: &mut Vec<(SurfaceInteraction, u32)>,
        lights: &mut LightBatch,
    ) {
        surfaces.clear();
        lights.clear();
        self.blocks.clear(hits.len());
        for (i, (&sample, hit)) in front.samples.iter().zip(hits).enumerate() {
            let (Some(hit), Some(ray)) = (hit, front.rays.get(i)) else { continue };
            if self.take_into_block(i, sample, &ray, hit) {
                continue;
            }
            let mut surface = self.scene.surface(&ray, hit);
            if self.view.pixel_cone.is_some() {
                let cone = &mut self.paths[sample as usize].cone;
                footprint::arrive(cone, &mut surface, ray.direction, hit.shape.t);
            }
            let path = &self.paths[sample as usize];
            let (mut number, mut extra_candidates) = (u32::MAX, 0);
            if self.may_connect(path, &ray, hit, &surface) {
                let at = self.scene.receiver(&surface, ray.direction);
                extra_candidates = self.more_lights(path, &at);
                number = self.ask(path, at.with_more(extra_candidates), lights);
            }
            self.paths[sample as usize].extra_candidates = extra_candidates;
            surfaces.push((surface, number));
        }
        self.ask_in_blocks(lights);
        self.scene.emitters.sample_batch(self.scene, lights);
    }

    /// Adds the light of the shadow rays that arrive.
    fn light(&mut self, out: &mut [Radiance], stats: &mut RayStats) {
        let shadows = &mut self.shadows;
        if shadows.light.is_empty() {
            return;
        }
        stats.shadow += shadows.light.len() as u64;
        if self.scene.moves {
            for (i, &(sample, _)) in shadows.light.iter().enumerate() {
                shadows.rays.set_time(i, self.paths[sample as usize].time);
            }
        }
        self.scene.transmittance_batch(&mut shadows.rays, &mut shadows.through);
        for (i, (sample, light)) in shadows.light.iter().enumerate() {
            let mut through = shadows.through[i / LANES].get(i % LANES);
            self.record.note(|r| r.asked(shadows.carried.get(i).is_some_and(|c| c.second)));
            self.record.note(|r| r.in_the_way(self.scene, shadows.rays.get(i), through));
            if let (Some(volumes), Some(carried)) = (&self.scene.volumes, shadows.carried.get_mut(i))
                && !through.is_black()
                && let Some(ray) = shadows.rays.get(i)
            {
                through = through * carried.left(self.scene, volumes, &ray);
            }
            // Not even 0 · infinity of what does not arrive.
            if !through.is_black() {
                let arrives = *light * through;
                let to = if self.paths[*sample as usize].donates {
                    &mut self.shared_paths.donated
                } else {
                    &mut *out
                };
                to[*sample as usize].color += arrives;
                self.record.note(|r| r.arrived(through, arrives));
            } else {
                self.record.note(|r| r.arrived(through, Spectrum::BLACK));
            }
        }
        shadows.rays.clear();
        shadows.light.clear();
        shadows.carried.clear();
    }
}

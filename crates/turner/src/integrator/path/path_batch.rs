//! Wavefront path tracing: the paths of many samples advance together, one bounce per round.
//!
//! A tracer that follows one path after the other traces one ray at a time, shades one vertex at a time and waits for
//! every table lookup. Here each round works on a queue of rays, one for every path that is still alive, in passes that
//! perform one step for all of them:
//!
//! ```text
//!  RayQueue --> intersect_batch --> media        (sample_media: distance sampling; may scatter before the hit)
//!     ^                               |
//!     |                         random numbers   (Sobol, eight vertices at a time)
//!     |                               |
//!     |                     surfaces, light samples (LightBatch), escaped rays (EscapedRays)
//!     |                               |
//!     +--- next rays <-------- shading             (shade: one by one;  simd_shading: eight at a time)
//!                                     |
//!                               ShadowRays --> transmittance_batch --> Radiance of each sample
//! ```
//!
//! Passes are faster because eight rays fill a SIMD register and because reads of large tables overlap. The random
//! numbers of a path depend only on its sample and vertex, and contributions are summed per sample in a fixed order, so
//! a result has the same bits in any batch. The queues follow Laine, Karras and Aila 2013, "Megakernels considered
//! harmful: wavefront path tracing on GPUs".

use std::sync::Arc;

use turner_bvh::lanes::LANES;

use super::Context;
use super::caustics::{CausticsStrategy, PhotonMap, ReversePdf};
use super::group_split::GroupSplit;
use super::guides::Guides;
use super::learn_environment::LitPoint;
use super::light_resampling::{self, NONE};
use super::light_split::LightSplit;
use super::lobe_split::LobeSplit;
use super::media::Media;
use super::ray_queue::RayQueue;
use super::record::{Off, Record};
use super::settings::{Bounces, Settings};
use super::shade::FIRST_SET;
use super::shadow_catcher::ShadowCatcher;
use super::shadow_rays::ShadowRays;
use super::shared_paths::{Destination, SharedPaths};
use super::simd_shading::VertexBlocks;
use crate::color::Spectrum;
use crate::integrator::first_hits::FirstHits;
use crate::integrator::ray_counts::RayCounts;
use crate::integrator::{AskedDetails, CameraSamples, Radiance, RayStats, SampleDetails, Tracer, footprint};
use crate::light::{AdaptiveEnvironment, Receiver};
use crate::math::{DVec3, Ray, RayCone};
use crate::sampler::{OwenSobol, SampleId, VertexNumbers};
use crate::scene::light_sample::LightSample;
use crate::scene::{EscapedRays, Hit, LightBatch, Scene, SurfaceInteraction};
use crate::view::View;

/// The state of the path of one sample.
#[derive(Default)]
pub(super) struct Path {
    pub(super) sampler: OwenSobol,
    /// The random numbers of the current vertex.
    pub(super) numbers: VertexNumbers,
    /// Time within the shutter interval, for motion blur.
    pub(super) time: f32,
    /// Throughput: the fraction of the radiance that arrives along the next ray that reaches the pixel.
    pub(super) beta: Spectrum,
    /// Factor of `beta` for Russian roulette: see [`Path::begin_roulette`]. The `beta` of a donor path restarts at 1 at its
    /// second vertex; then the throughput up to that vertex, in its own pixel, is a further factor.
    pub(super) importance: f32,
    /// Whether the path is a donor: its radiance from the second vertex on is shared with other samples.
    pub(super) donates: bool,
    /// Number of vertices so far. Each has its own sets of random numbers.
    pub(super) vertex: u32,
    pub(super) bounces: Bounces,
    pub(super) transparent: u32,
    /// Whether the ray is still the camera ray, unscattered.
    pub(super) from_camera: bool,
    /// Whether every surface so far let the ray through, so that what it reaches is seen behind them.
    pub(super) seen_through: bool,
    /// Whether it ends at the surface that it has reached, because only the guides of the denoiser are asked for.
    pub(super) ends: bool,
    /// Whether light sampling cannot find an emitter that this ray hits: for camera rays and rays of delta lobes.
    pub(super) specular_bounce: bool,
    /// Whether any vertex so far scattered by a non-delta lobe.
    pub(super) any_nonspecular: bool,
    /// Density of the ray's direction per solid angle, and the receiver it was sampled at.
    pub(super) pdf: f64,
    pub(super) origin: Receiver,
    /// Number of light samples beyond the first at the current vertex.
    pub(super) extra_candidates: u32,
    /// Whether one of them is chosen.
    pub(super) resamples: bool,
    /// Product of eta² over the refractions so far, relative to the camera. `beta` is divided by it, because radiance
    /// is transported; Russian roulette must not depend on that (pbrt's `etaScale`).
    pub(super) eta2: f32,
    /// The colour band (0 red, 1 green, 2 blue) that is left after dispersion.
    pub(super) band: Option<u8>,
    pub(super) media: Media,
    /// Ray cone at the origin of the ray; after the intersection, at the hit.
    pub(super) cone: RayCone,
}

impl Path {
    /// Resets the path for a sample that is about to leave the camera.
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
        self.seen_through = true;
        self.ends = false;
        self.specular_bounce = true;
        self.any_nonspecular = false;
        self.pdf = 1.0;
        self.origin = Receiver::from(DVec3::ZERO);
        (self.extra_candidates, self.resamples) = (0, false);
        self.eta2 = 1.0;
        self.band = None;
        self.media.clear();
        self.cone = cone;
    }

    /// Where the light goes that the path finds.
    #[inline]
    pub(super) fn destination(&self) -> Destination {
        if self.donates { Destination::Donated } else { Destination::Sample }
    }
}

/// A hit to shade, with the lights sampled there.
pub(super) struct VertexInput<'a> {
    pub(super) sample: u32,
    pub(super) ray: Ray,
    pub(super) surface: &'a SurfaceInteraction,
    /// The light samples: all are taken, or one is chosen.
    pub(super) lit: &'a [Option<LightSample>],
}

/// A batch of paths while it is traced. Its buffers are reused from batch to batch.
pub(super) struct PathBatch<'a, R = Off> {
    pub(super) settings: Settings,
    pub(super) scene: &'a Scene,
    pub(super) view: &'a View,
    pub(super) paths: Vec<Path>,
    queue: RayQueue,
    pub(super) next: RayQueue,
    pub(super) shadows: ShadowRays,
    hits: Vec<Option<Hit>>,
    surfaces: Vec<(SurfaceInteraction, u32)>,
    /// Vertices that are shaded eight at a time; these have no entry in `surfaces`.
    pub(super) blocks: VertexBlocks,
    lights: LightBatch,
    escaped: EscapedRays,
    number_requests: Vec<(OwenSobol, u32)>,
    numbers: Vec<VertexNumbers>,
    /// The environment that is sampled adaptively, if any.
    pub(super) adaptive: Option<&'a AdaptiveEnvironment>,
    /// The light paths that MIS weights take into account, and the reverse densities of each path; empty without light
    /// paths.
    pub(super) strategy: Option<&'a CausticsStrategy>,
    pub(super) reverse_pdfs: Vec<ReversePdf>,
    /// State of the paths that are shared between samples.
    pub(super) shared_paths: SharedPaths,
    /// The photons of the current sample index, where photons are used.
    pub(super) photons: Option<Arc<PhotonMap>>,
    /// Luminance contributed by photons, summed over all samples.
    pub(super) by_photons: f64,
    /// Approximate variance of that sum: the sum over vertices of contribution² / number of photons.
    pub(super) photon_variance: f64,
    /// Emission and direct light of each sample, if they are asked for.
    pub(super) split: LightSplit,
    /// The light of each sample by the lobe of its first surface, if it is asked for.
    pub(super) lobes: LobeSplit,
    /// The light of each light group, if it is asked for.
    pub(super) groups: GroupSplit,
    /// The number of rays and of bounces of each sample, if they are asked for.
    pub(super) counts: RayCounts,
    /// The hits of camera rays, if they are asked for.
    first_hits: FirstHits,
    /// The surfaces that the denoiser is guided by, if they are asked for.
    pub(super) guides: Guides,
    /// The light that arrives at shadow catchers.
    pub(super) catcher: ShadowCatcher,
    /// Points where lights are sampled, if they are asked for.
    pub(super) lit_points: Option<Vec<LitPoint>>,
    /// Records the path of a single sample, or nothing.
    pub(super) record: R,
}

impl<'a, R> PathBatch<'a, R> {
    pub(super) fn new(context: Context<'a>, record: R) -> PathBatch<'a, R> {
        let Context { scene, view, settings, strategy, cluster, adaptive, .. } = context;
        PathBatch {
            settings,
            scene,
            view,
            paths: Vec::new(),
            queue: RayQueue::default(),
            next: RayQueue::default(),
            shadows: ShadowRays::default(),
            hits: Vec::new(),
            surfaces: Vec::new(),
            blocks: VertexBlocks::default(),
            lights: LightBatch::default(),
            escaped: EscapedRays::default(),
            number_requests: Vec::new(),
            numbers: Vec::new(),
            adaptive,
            strategy,
            reverse_pdfs: Vec::new(),
            shared_paths: SharedPaths::new(cluster),
            photons: None,
            by_photons: 0.0,
            photon_variance: 0.0,
            split: LightSplit::default(),
            lobes: LobeSplit::default(),
            groups: GroupSplit::default(),
            counts: RayCounts::default(),
            first_hits: FirstHits::default(),
            guides: Guides::default(),
            catcher: ShadowCatcher::new(scene),
            lit_points: None,
            record,
        }
    }
}

impl<R: Record> Tracer for PathBatch<'_, R> {
    fn find_photons(&mut self, photons: Arc<PhotonMap>) {
        self.photons = Some(photons);
    }

    fn ask(&mut self, asked: AskedDetails) {
        if asked.parts {
            self.split.turn_on();
        }
        if asked.groups {
            self.groups.turn_on(self.scene);
        }
        if asked.lobes {
            self.lobes.turn_on();
        }
        self.counts.turn_on(asked.rays, asked.bounces);
        self.first_hits.turn_on(asked.hits);
        self.guides.turn_on(asked.denoising);
    }

    fn details(&self) -> SampleDetails<'_> {
        SampleDetails {
            parts: self.split.parts(),
            groups: self.groups.light(),
            rays: self.counts.rays(),
            bounces: self.counts.bounces(),
            lobes: self.lobes.parts(),
            caught: self.catcher.caught(),
            hits: self.first_hits.hits(),
            denoising: self.guides.samples(),
        }
    }

    fn radiance(&mut self, samples: &CameraSamples, out: &mut Vec<Radiance>, stats: &mut RayStats) {
        let count = samples.ids.len();
        stats.camera += count as u64;
        out.clear();
        out.resize(count, Radiance { color: Spectrum::BLACK, alpha: 1.0 });
        // Existing entries are reused in place: the lists of media are large and mostly unread.
        self.paths.resize_with(count, Path::default);
        for (i, (path, id)) in self.paths.iter_mut().zip(&samples.ids).enumerate() {
            path.begin(id, samples.rays.time(i), footprint::of_camera(self.view, samples, i));
        }
        self.reverse_pdfs.clear();
        if let Some(strategy) = self.strategy {
            let ray = |i: usize| samples.rays.get(i).unwrap_or(Ray::new(DVec3::ZERO, DVec3::Z));
            self.reverse_pdfs.extend((0..count).map(|i| ReversePdf::of_camera(self.view, strategy, &ray(i))));
        }
        if let Some(volumes) = &self.scene.volumes {
            self.begin_in_media(volumes, samples);
        }
        self.split.begin(count);
        self.lobes.begin(count);
        self.groups.begin(count);
        self.counts.begin(count);
        self.first_hits.begin();
        self.guides.begin(count);
        self.catcher.begin(count);
        self.begin_shared_paths(&samples.ids);
        self.queue.rays.copy(&samples.rays);
        self.queue.samples.clear();
        self.queue.samples.extend(0..count as u32);
        while !self.queue.samples.is_empty() {
            self.round(out, stats);
        }
        self.distribute_shared(out);
    }
}

impl<R: Record> PathBatch<'_, R> {
    /// Replaces the hits of rays that come straight from the camera by what it sees.
    fn look_past_hidden(&self, queue: &RayQueue, hits: &mut [Option<Hit>]) {
        for (i, (&sample, hit)) in queue.samples.iter().zip(hits).enumerate() {
            if let Some(ray) = queue.rays.get(i).filter(|_| self.paths[sample as usize].from_camera) {
                *hit = self.scene.seen_by_camera(&ray, *hit);
            }
        }
    }

    /// Traces the rays of the queue, shades their hits and fills the next queue.
    fn round(&mut self, out: &mut [Radiance], stats: &mut RayStats) {
        let mut hits = std::mem::take(&mut self.hits);
        let mut queue = std::mem::take(&mut self.queue);
        if self.scene.moves {
            for (i, &sample) in queue.samples.iter().enumerate() {
                queue.rays.set_time(i, self.paths[sample as usize].time);
            }
        }
        self.scene.intersect_batch(&mut queue.rays, &mut hits);
        self.scene.fetch_triangles(&hits);
        self.scene.prefer_surfaces(&queue.rays, &mut hits);
        if !self.scene.hidden_from_camera.is_empty() {
            self.look_past_hidden(&queue, &mut hits);
        }
        self.first_hits.found(&hits);
        self.split.begin_round(&queue.samples, &self.paths, out);
        self.lobes.begin_round(&queue.samples, &self.paths, out);
        self.guides.begin_round(&queue.samples, out);
        self.counts.begin_round(&queue.samples, |sample| self.paths[sample].bounces.total);
        if let Some(volumes) = &self.scene.volumes {
            self.sample_media(volumes, &mut queue, &mut hits, out, stats);
        }
        self.draw_numbers(&queue.samples, &hits);
        let mut surfaces = std::mem::take(&mut self.surfaces);
        let mut lights = std::mem::take(&mut self.lights);
        self.prepare(&queue, &hits, &mut surfaces, &mut lights);
        self.find_guides(&queue, &hits, &surfaces);
        let mut escaped = std::mem::take(&mut self.escaped);
        escaped.clear(!R::RECORDS && self.settings.needs_no_luminance_pdf());
        let missing = queue.samples.iter().zip(&hits).enumerate().filter(|(_, (_, hit))| hit.is_none());
        for (i, (&sample, _)) in missing {
            let Some(ray) = queue.rays.get(i) else { continue };
            escaped.push(ray.direction, self.paths[sample as usize].origin.cell);
        }
        self.scene.emitters.escaped_batch(self.scene, self.adaptive, &mut escaped);
        let mut donated = std::mem::take(&mut self.shared_paths.donated);
        let mut hit_surfaces = surfaces.iter();
        let mut missed = 0;
        for (i, (&sample, hit)) in queue.samples.iter().zip(&hits).enumerate() {
            // Vertices in blocks are shaded below.
            if self.blocks.contains(i) {
                continue;
            }
            let Some(ray) = queue.rays.get(i) else { continue };
            let donates = self.paths[sample as usize].donates;
            let pixel = if donates { &mut donated[sample as usize] } else { &mut out[sample as usize] };
            if hit.is_none() {
                self.miss(sample, &ray, escaped.get(missed), pixel);
                missed += 1;
            } else if let Some((surface, light)) = hit_surfaces.next() {
                let lit = lights.get(*light as usize);
                self.shade(&VertexInput { sample, ray, surface, lit }, pixel, stats);
            }
        }
        self.shade_blocks(&lights, stats);
        (self.surfaces, self.lights, self.escaped) = (surfaces, lights, escaped);
        self.hits = hits;
        self.shared_paths.donated = donated;
        self.trace_reconnections(stats);
        self.trace_catcher_rays(stats);
        self.guides.shaded(&queue.samples, out, &self.split);
        self.split.shaded(&queue.samples, out);
        self.lobes.shaded(&queue.samples, out);
        self.trace_shadow_rays(out, stats);
        self.end_round_of_shared_paths(&queue.samples);
        self.split.lit(&queue.samples, out);
        queue.clear();
        self.queue = std::mem::replace(&mut self.next, queue);
    }

    /// Draws the random numbers of the vertices at the hits.
    fn draw_numbers(&mut self, samples: &[u32], hits: &[Option<Hit>]) {
        let hit =
            || samples.iter().zip(hits).filter(|(_, hit)| hit.is_some()).map(|(&sample, _)| sample as usize);
        self.number_requests.clear();
        self.number_requests
            .extend(hit().map(|i| (self.paths[i].sampler, FIRST_SET + 2 * self.paths[i].vertex)));
        OwenSobol::vertex_numbers(self.scene.instruction_set, &self.number_requests, &mut self.numbers);
        for (i, numbers) in hit().zip(&self.numbers) {
            self.paths[i].numbers = *numbers;
        }
    }

    /// Computes the surfaces at the hits and samples lights for them. Each surface gets the index of its light sample.
    fn prepare(
        &mut self,
        queue: &RayQueue,
        hits: &[Option<Hit>],
        surfaces: &mut Vec<(SurfaceInteraction, u32)>,
        lights: &mut LightBatch,
    ) {
        surfaces.clear();
        lights.clear();
        self.blocks.clear(hits.len());
        for (i, (&sample, hit)) in queue.samples.iter().zip(hits).enumerate() {
            let (Some(hit), Some(ray)) = (hit, queue.rays.get(i)) else { continue };
            let in_block = self.block_material(sample, hit);
            if let Some(material) = in_block
                && self.take_plain(i, sample, &ray, hit, material)
            {
                continue;
            }
            let mut surface = self.scene.surface(&ray, hit);
            if self.view.pixel_cone.is_some() {
                let Path { cone, any_nonspecular, .. } = &mut self.paths[sample as usize];
                if *any_nonspecular {
                    footprint::arrive_isotropic(cone, &mut surface, ray.direction, hit.shape.t);
                } else {
                    footprint::arrive(cone, &mut surface, ray.direction, hit.shape.t);
                }
            }
            if let Some(material) = in_block
                && self.take_surface(i, sample, &ray, &surface, material)
            {
                continue;
            }
            let path = &self.paths[sample as usize];
            let (mut number, mut extra, mut resamples) = (NONE, 0, false);
            if self.may_connect(path, &ray, hit, &surface) {
                let vertex = path.vertex + 1;
                let at = self.receiver(sample, vertex, &surface, ray.direction);
                if let Some(points) = &mut self.lit_points {
                    points.push(LitPoint::new(&surface, ray.direction));
                }
                extra = self.extra_light_samples(path, &at);
                let at = at.with_candidates(extra);
                resamples = light_resampling::resamples(&at);
                number = self.request_light(path, at, lights);
            }
            let path = &mut self.paths[sample as usize];
            (path.extra_candidates, path.resamples) = (extra, resamples);
            surfaces.push((surface, number));
        }
        self.request_lights_in_blocks(lights);
        self.scene.emitters.sample_batch(self.scene, self.adaptive, lights);
    }

    /// Traces the shadow rays and adds the radiance that arrives.
    fn trace_shadow_rays(&mut self, out: &mut [Radiance], stats: &mut RayStats) {
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
            self.counts.add(*sample);
            self.record.note(|r| r.next_shadow_ray(shadows.media.get(i).is_some_and(|c| c.equiangular)));
            self.record.note(|r| r.shadow_ray(self.scene, shadows.rays.get(i), through));
            if let (Some(volumes), Some(media)) = (&self.scene.volumes, shadows.media.get_mut(i))
                && !through.is_black()
                && let Some(ray) = shadows.rays.get(i)
            {
                through = through * media.transmittance(self.scene, volumes, &ray);
            }
            // Occluded rays add nothing: 0 · infinity would be NaN.
            if !through.is_black() {
                let arrives = *light * through;
                let at = *sample as usize;
                let to = match self.shared_paths.directional_at(*sample) {
                    Some(_) => Destination::Direct,
                    None => self.paths[at].destination(),
                };
                match to {
                    Destination::Sample => out[at].color += arrives,
                    Destination::Donated => self.shared_paths.donated[at].color += arrives,
                    Destination::Direct => self.shared_paths.direct[at] += arrives,
                }
                self.groups.arrived(i, *sample, to, arrives);
                self.lobes.arrived(i, *sample, to, arrives);
                self.record.note(|r| r.light_arrived(through, arrives));
            } else {
                self.record.note(|r| r.light_arrived(through, Spectrum::BLACK));
            }
        }
        shadows.rays.clear();
        shadows.light.clear();
        shadows.media.clear();
        self.groups.end_round();
        self.lobes.end_round();
    }
}

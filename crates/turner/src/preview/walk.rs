//! The samples of a group of pixels: rays advance together, one surface per round.
//!
//! ```text
//!  camera rays ──► mirrors, glass, cut-outs, panes ──► the pixel's surface ──► light   direct, gloss
//!                    (other branches: `seen`)               │        └──────► gloss ray ──► light
//!                                                           └───────────────► bounce ────► light   indirect
//! ```
//!
//! A ray splits where the camera first meets a surface with several delta lobes, or with delta lobes and others. The
//! strongest branch leads to the pixel's surface; what the others bring is `seen`.

use turner_bvh::lanes::LANES;

use crate::camera::PixelCone;
use crate::color::Spectrum;
use crate::light::{NO_CELL, Receiver};
use crate::math::{DVec2, DVec3, Ray, RayCone};
use crate::preview::buffers::Sample;
use crate::preview::looks::Looks;
use crate::preview::pattern::Pattern;
use crate::sampler::{OwenSobol, VertexNumbers};
use crate::scene::{EscapedRays, Hit, LightBatch, RayBatch, Scene, SpectrumBlock, SurfaceInteraction};
use crate::view::{CameraSamples, View, take_points};

/// What a frame is drawn with.
#[derive(Clone, Copy)]
pub(super) struct Frame<'a> {
    pub(super) scene: &'a Scene,
    /// The view at the size of the preview.
    pub(super) view: &'a View,
    pub(super) looks: &'a Looks,
    pub(super) pattern: Pattern,
    /// Position of the samples within their pixels.
    pub(super) within: DVec2,
    /// Direct light only.
    pub(super) is_direct: bool,
    /// Light that arrives at a surface from others, over π, as the mean of the picture.
    pub(super) ambient: Spectrum,
    /// The luminance that is shown as white.
    pub(super) white: f32,
}

/// Rounds in which rays from the camera pass on through mirrors, glass and cut-outs.
pub(super) const MOST_ROUNDS: u32 = 10;

/// What a ray brings light for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// It comes from the camera by way of delta lobes and cut-outs.
    Camera,
    /// It brings indirect light to the diffuse base of the pixel's surface.
    Bounce,
    /// It brings light to other lobes.
    Gloss,
}

/// A ray on its way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Walker {
    /// The pixel's index within the group.
    pub(super) pixel: u32,
    pub(super) role: Role,
    /// Whether it leads to the pixel's surface.
    pub(super) is_main: bool,
    /// Whether only delta lobes scattered it since its beginning at the camera or at the pixel's surface.
    pub(super) is_specular: bool,
    pub(super) from_camera: bool,
    pub(super) seen_through: bool,
    /// Throughput.
    pub(super) beta: Spectrum,
    /// Density of its direction, for MIS.
    pub(super) pdf: f64,
    pub(super) origin: Receiver,
    pub(super) cone: RayCone,
    pub(super) length: f64,
    pub(super) absorption: [f32; 3],
    pub(super) key: u32,
    pub(super) rounds: u32,
}

/// Where light goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Target {
    Seen,
    Surface,
    Indirect,
    Gloss,
    /// Light at a shadow catcher: whether something is in the way decides.
    Catcher,
}

/// A shadow ray's light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sent {
    pub(super) pixel: u32,
    pub(super) target: Target,
    /// For [`Target::Surface`] the light of the diffuse base and that of other lobes.
    pub(super) light: Spectrum,
    pub(super) gloss: Spectrum,
}

/// Rays of a round.
#[derive(Default)]
pub(super) struct Queue {
    pub(super) rays: RayBatch,
    pub(super) walkers: Vec<Walker>,
}

impl Queue {
    fn clear(&mut self) {
        self.rays.clear();
        self.walkers.clear();
    }

    /// Adds a ray that leaves a surface.
    pub(super) fn push(&mut self, walker: Walker, from: &SurfaceInteraction, direction: DVec3) {
        self.rays.push_from(&Ray::new(from.leave(direction), direction), from);
        self.walkers.push(walker);
    }
}

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Group {
    pub(super) left: u32,
    pub(super) top: u32,
    pub(super) columns: u32,
    pub(super) rows: u32,
}

/// The state of one thread; its buffers are reused.
#[derive(Default)]
pub(super) struct Walk {
    samples: CameraSamples,
    pub(super) group: Group,
    /// The samples of the group, in rows.
    pub(super) found: Vec<Sample>,
    /// The pixels to trace, by their index in the group.
    pub(super) traced: Vec<u32>,
    queue: Queue,
    pub(super) next: Queue,
    hits: Vec<Option<Hit>>,
    surfaces: Vec<(SurfaceInteraction, u32)>,
    lights: LightBatch,
    escaped: EscapedRays,
    requests: Vec<(OwenSobol, u32)>,
    numbers: Vec<VertexNumbers>,
    pub(super) shadows: RayBatch,
    pub(super) sent: Vec<Sent>,
    through: Vec<SpectrumBlock>,
}

/// The set of random numbers of the first surface; the first two are for the camera.
const FIRST_SET: u32 = 2;

impl Walk {
    /// The position of a pixel of the group.
    #[inline]
    pub(super) fn place(&self, pixel: u32) -> (u32, u32) {
        (self.group.left + pixel % self.group.columns, self.group.top + pixel / self.group.columns)
    }

    /// Begins a group.
    pub(super) fn begin(&mut self, group: Group) {
        self.group = group;
        self.found.clear();
        self.found.resize((group.columns * group.rows) as usize, Sample::NOTHING);
    }

    /// Samples the pixels in `traced`.
    pub(super) fn trace(&mut self, frame: &Frame<'_>) {
        let mut samples = std::mem::take(&mut self.samples);
        let mut queue = std::mem::take(&mut self.queue);
        let mut hits = std::mem::take(&mut self.hits);
        samples.clear();
        let points = self.traced.iter().map(|&pixel| {
            let (x, y) = self.place(pixel);
            (frame.pattern.id(x, y), DVec2::new(f64::from(x), f64::from(y)) + frame.within)
        });
        take_points(frame.view, &mut samples, points);
        frame.scene.intersect_batch(&mut samples.rays, &mut hits);
        frame.scene.look_past_hidden(&samples.rays, &mut hits);
        queue.clear();
        let mut kept = 0;
        for i in 0..self.traced.len() {
            let (pixel, hit) = (self.traced[i], hits[i]);
            let Some(ray) = samples.rays.get(i) else { continue };
            if let Some(hit) = &hit
                && self.see_unlit(frame, pixel, &ray, hit)
            {
                continue;
            }
            queue.rays.push(&ray);
            queue.walkers.push(Walker {
                pixel,
                role: Role::Camera,
                is_main: true,
                is_specular: true,
                from_camera: true,
                seen_through: true,
                beta: Spectrum::WHITE,
                pdf: 1.0,
                origin: Receiver::default(),
                cone: camera_cone(frame.view.pixel_cone.as_ref(), &samples, i),
                length: 0.0,
                absorption: [0.0; 3],
                key: 0,
                rounds: 0,
            });
            hits[kept] = hit;
            kept += 1;
        }
        hits.truncate(kept);
        (self.samples, self.queue, self.hits) = (samples, queue, hits);
        while !self.queue.walkers.is_empty() {
            self.round(frame);
            let mut hits = std::mem::take(&mut self.hits);
            frame.scene.intersect_batch(&mut self.queue.rays, &mut hits);
            if !frame.scene.hidden_from_camera.is_empty() {
                for (i, (hit, walker)) in hits.iter_mut().zip(&self.queue.walkers).enumerate() {
                    if let Some(ray) = self.queue.rays.get(i).filter(|_| walker.from_camera) {
                        *hit = frame.scene.seen_by_camera(&ray, *hit);
                    }
                }
            }
            self.hits = hits;
        }
    }

    /// Continues from the hits of the queue's rays.
    fn round(&mut self, frame: &Frame<'_>) {
        let scene = frame.scene;
        let mut queue = std::mem::take(&mut self.queue);
        let hits = std::mem::take(&mut self.hits);
        let mut surfaces = std::mem::take(&mut self.surfaces);
        let mut lights = std::mem::take(&mut self.lights);
        let mut escaped = std::mem::take(&mut self.escaped);
        let mut numbers = std::mem::take(&mut self.numbers);
        self.draw_numbers(frame, &queue, &hits, &mut numbers);
        surfaces.clear();
        lights.clear();
        escaped.clear(false);
        let mut drawn = numbers.iter();
        for (i, (walker, hit)) in queue.walkers.iter_mut().zip(&hits).enumerate() {
            let Some(ray) = queue.rays.get(i) else { continue };
            let Some(hit) = hit else {
                escaped.push(ray.direction, NO_CELL);
                continue;
            };
            let Some(numbers) = drawn.next() else { continue };
            let mut surface = scene.surface(&ray, hit);
            if frame.view.pixel_cone.is_some() {
                walker.cone = walker.cone.advanced(hit.shape.t);
                surface.see(ray.direction, walker.cone.width);
            }
            let mut request = u32::MAX;
            if self.may_light(frame, walker, hit) {
                let at = scene.receiver(&surface, ray.direction);
                let [u0, u1, u2, _] = numbers.first();
                request = lights.ask(at, [u0, u1, u2]) as u32;
            }
            surfaces.push((surface, request));
        }
        scene.emitters.sample_batch(scene, None, &mut lights);
        scene.emitters.escaped_batch(scene, None, &mut escaped);
        let (mut arrived, mut missed, mut drawn) = (surfaces.iter(), 0, numbers.iter());
        for (i, (walker, hit)) in queue.walkers.iter().zip(&hits).enumerate() {
            let Some(ray) = queue.rays.get(i) else { continue };
            if hit.is_none() {
                self.escape(frame, walker, &ray, escaped.get(missed));
                missed += 1;
            } else if let (Some((surface, request)), Some(numbers)) = (arrived.next(), drawn.next()) {
                let lit = lights.get(*request as usize).first().copied().flatten();
                self.arrive(frame, walker, &ray, surface, lit, numbers);
            }
        }
        self.send(scene);
        queue.clear();
        self.queue = std::mem::replace(&mut self.next, queue);
        (self.hits, self.surfaces, self.lights) = (hits, surfaces, lights);
        (self.escaped, self.numbers) = (escaped, numbers);
    }

    /// Random numbers for all hits.
    fn draw_numbers(
        &mut self,
        frame: &Frame<'_>,
        queue: &Queue,
        hits: &[Option<Hit>],
        to: &mut Vec<VertexNumbers>,
    ) {
        let mut requests = std::mem::take(&mut self.requests);
        requests.clear();
        for (walker, _) in queue.walkers.iter().zip(hits).filter(|(_, hit)| hit.is_some()) {
            let (x, y) = self.place(walker.pixel);
            let sampler = match walker.role {
                Role::Bounce => frame.pattern.of_cell(x, y),
                _ => OwenSobol::new(&frame.pattern.id(x, y)),
            };
            requests.push((sampler, FIRST_SET + 2 * walker.rounds));
        }
        OwenSobol::vertex_numbers(frame.scene.instruction_set, &requests, to);
        self.requests = requests;
    }

    /// Whether to sample a light at a hit.
    fn may_light(&self, frame: &Frame<'_>, walker: &Walker, hit: &Hit) -> bool {
        let (x, y) = self.place(walker.pixel);
        if walker.role == Role::Camera && walker.is_main && !frame.pattern.lights(x, y) {
            return false;
        }
        if walker.from_camera && frame.scene.is_shadow_catcher(hit) {
            return false;
        }
        match frame.scene.material_at(hit) {
            crate::material::Material::OpenPbr(m) => !m.desc.unlit && !m.boundary,
            crate::material::Material::Mix(_) => true,
            _ => false,
        }
    }

    /// Traces the shadow rays of a round.
    fn send(&mut self, scene: &Scene) {
        if self.sent.is_empty() {
            return;
        }
        scene.transmittance_batch(&mut self.shadows, &mut self.through);
        for (i, sent) in self.sent.iter().enumerate() {
            let through = self.through[i / LANES].get(i % LANES);
            let pixel = &mut self.found[sent.pixel as usize];
            if sent.target == Target::Catcher {
                let light = sent.light.luminance();
                pixel.direct += Spectrum::new((sent.light * through).luminance(), light, 0.0);
            } else if !through.is_black() {
                let light = sent.light * through;
                match sent.target {
                    Target::Seen => pixel.seen += light,
                    Target::Indirect => pixel.indirect += light,
                    Target::Gloss => pixel.gloss += light,
                    _ => {
                        pixel.direct += light;
                        pixel.gloss += sent.gloss * through;
                    }
                }
            }
        }
        self.shadows.clear();
        self.sent.clear();
    }

    /// Adds a shadow ray towards a point relative to a surface, or in a direction.
    pub(super) fn push_shadow(&mut self, from: &SurfaceInteraction, to: DVec3, finite: bool, sent: Sent) {
        let origin = from.leave(to);
        let ray = if finite {
            Ray { t_max: 1.0, ..Ray::new(origin, from.p + to - origin) }
        } else {
            Ray::new(origin, to)
        };
        self.shadows.push_from(&ray, from);
        self.sent.push(sent);
    }
}

/// The cone of a camera ray; its width is 0 where textures are not filtered.
fn camera_cone(pixel: Option<&PixelCone>, samples: &CameraSamples, i: usize) -> RayCone {
    pixel.map_or(RayCone::default(), |pixel| pixel.cone(samples.lengths[i / LANES].0[i % LANES]))
}

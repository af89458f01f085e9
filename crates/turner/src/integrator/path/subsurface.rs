//! Random-walk subsurface scattering (Chiang, Kutz and Burley 2016, "Practical and controllable subsurface scattering
//! for production path tracing").
//!
//! A path that enters a translucent body walks from one scattering event to the next in its medium until it
//! leaves:
//!
//! ```text
//!         wo  x_i (entry)         x_o (exit)  light
//!           \  |                   | /   ./
//!  ----------\-+-------------------+/--./------- surface
//!               \    s2 --- s3    /
//!                \  /         \  /               distances: exponential, directions: phase function
//!                 s1           s4
//! ```
//!
//! At the exit the path continues as if it had hit a diffuse surface that transmits all light: a light is sampled and a
//! direction is sampled, under the layers of the material there. The walk and this exit count as one bounce.
//!
//! Each distance is sampled with the extinction of one colour band, chosen with its fraction of the throughput, and
//! weighted by the density over all three bands (the one-sample balance heuristic over bands, as [`Homogeneous`] does
//! for other media). The sum over bands of the throughput therefore never grows. Walks that have lost most of their
//! throughput end by Russian roulette.
//!
//! Bodies that touch or overlap are one body with the medium of the entry point. Glass surfaces and interfaces inside
//! are crossed straight; any other surface inside absorbs the light that hits it.

use super::media::Media;
use super::path_batch::{PathBatch, VertexInput};
use super::record::{Passage, RandomWalkRecord, Record};
use super::shade::FIRST_SET;
use crate::bsdf::{Bsdf, Entry};
use crate::color::Spectrum;
use crate::integrator::{Radiance, RayStats};
use crate::material::vertex::prepare;
use crate::material::{Material, OpenPbr};
use crate::math::{Frame, Ray};
use crate::medium::Homogeneous;
use crate::sampler::{Stream, VertexNumbers};
use crate::scene::{Hit, Scene, SurfaceInteraction};

/// A walk of more steps exits where it entered. In an infinite white body one walk in 400 has so many steps, in others
/// fewer.
const MAX_STEPS: u32 = 1 << 16;

/// A walk with less than this fraction of its initial throughput plays Russian roulette; survivors are set back to it.
const ROULETTE_BELOW: f64 = 0.25;

/// The mean free path is at least this multiple of the rounding error of the surface point, so that walks can leave the
/// surface.
const MIN_MEAN_FREE_PATH: f64 = 256.0;

/// Maximum number of surfaces crossed on one step; a ray that crosses more is absorbed.
const MAX_CROSSINGS: u32 = 256;

/// A random walk in a body.
struct Walk<'a> {
    scene: &'a Scene,
    body: &'a Homogeneous,
    /// Throughput by band, and its sum at the start.
    throughput: [f64; 3],
    initial: f64,
    ray: Ray,
    /// The primitive it entered through.
    primitive: u32,
    /// Number of nested bodies it is in.
    depth: u32,
    /// Rounding error of positions.
    margin: f64,
    steps: u32,
    length: f64,
    stream: Stream,
}

/// How a walk ends.
enum End {
    /// It leaves the body.
    Exit(Hit),
    /// It leaves where it entered.
    Entry,
    /// It hits another object inside.
    Hit(Hit),
    /// It is absorbed.
    Absorbed,
}

impl Walk<'_> {
    /// The fraction of each band in the throughput, and the sum; `None` if that is 0.
    fn band_fractions(&self) -> Option<([f64; 3], f64)> {
        let [r, g, b] = self.throughput;
        let sum = r + g + b;
        (sum > 0.0 && sum < f64::INFINITY).then(|| ([r / sum, g / sum, b / sum], sum))
    }

    /// Multiplies the throughput by a weight per band over a density.
    fn multiply(&mut self, weight: [f64; 3], pdf: f64) {
        let scale = if pdf > 0.0 { 1.0 / pdf } else { 0.0 };
        for (throughput, w) in self.throughput.iter_mut().zip(weight) {
            let scaled = *throughput * w * scale;
            *throughput = if scaled.is_finite() { scaled } else { 0.0 };
        }
    }

    /// Walks; `u` chooses the first distance.
    fn run(&mut self, u: f64, media: &mut Media) -> End {
        let mut u = u;
        let phase = self.body.phase();
        while self.steps < MAX_STEPS {
            let Some((fractions, _)) = self.band_fractions() else { return End::Absorbed };
            let t = self.body.distance(fractions, [self.stream.unit(), u]);
            self.steps += 1;
            if let Some((hit, end)) = self.trace(t, media) {
                let (transmittance, pdf) = self.body.left(fractions, end);
                self.multiply(transmittance, pdf);
                self.length += end;
                return hit;
            }
            // The sampled distance is not on the surface, except by rounding.
            let (scattered, pdf) = self.body.scattered(fractions, t);
            self.multiply(scattered, pdf);
            self.length += t;
            let Some((_, sum)) = self.band_fractions() else { return End::Absorbed };
            let least = ROULETTE_BELOW * self.initial;
            if sum < least {
                if self.stream.unit() * least >= sum {
                    return End::Absorbed;
                }
                self.throughput = self.throughput.map(|v| v * (least / sum));
            }
            let (direction, _) = phase.sample(self.ray.direction, [self.stream.unit(), self.stream.unit()]);
            self.ray = Ray { origin: self.ray.at(t), direction, t_min: 0.0, ..self.ray };
            u = self.stream.unit();
        }
        End::Entry
    }

    /// What ends the walk within the distance `t`, and how far that is. Other surfaces are crossed.
    fn trace(&mut self, t: f64, media: &mut Media) -> Option<(End, f64)> {
        let mut ray = Ray { t_max: t + self.margin, ..self.ray };
        for _ in 0..MAX_CROSSINGS {
            let hit = self.scene.intersect(&ray)?;
            let surface = self.scene.surface(&ray, &hit);
            let outside = ray.direction.dot(surface.ng) < 0.0;
            let material = self.scene.material_at(&hit);
            let id = self.scene.primitive_id(&hit);
            match material {
                _ if material.has_subsurface(self.scene) => match (outside, self.depth) {
                    // Rounding has left the body, or the body intersects itself.
                    (true, _) if id == self.primitive => {}
                    (true, _) => self.depth += 1,
                    (false, 0..=1) => return Some((End::Exit(hit), hit.shape.t)),
                    (false, _) => self.depth -= 1,
                },
                Material::OpenPbr(m) if m.boundary || m.has_inside() => {
                    media.cross(self.scene, &surface, m, outside);
                }
                _ => return Some((End::Hit(hit), hit.shape.t)),
            }
            ray.t_min = self.scene.beyond(&ray, &hit, &surface);
        }
        Some((End::Absorbed, t))
    }
}

impl<'a, R: Record> PathBatch<'a, R> {
    /// Traces a path that enters the body of `material` to its exit, and shades the exit. `u` chooses the first
    /// distance.
    #[inline(never)]
    pub(super) fn random_walk(
        &mut self,
        at: &VertexInput<'_>,
        material: &OpenPbr,
        entry: &Entry,
        u: f64,
        pixel: &mut Radiance,
        stats: &mut RayStats,
    ) {
        let (scene, sample) = (self.scene, at.sample);
        let surface = at.surface;
        let path = &mut self.paths[sample as usize];
        path.beta = path.beta * entry.weight;
        // Cosine-distributed around the geometric normal: all of it enters.
        let direction = Frame::from_z(surface.ng).to_world(entry.wi);
        self.record.note(|r| r.entered_body(direction, entry, path.beta));
        let body = material.body(scene, surface, MIN_MEAN_FREE_PATH * surface.error);
        let throughput = path.beta.to_array().map(|v| f64::from(v.max(0.0)));
        let mut walk = Walk {
            scene,
            body: &body,
            throughput,
            initial: throughput.iter().sum(),
            ray: Ray { time: surface.time(), ..Ray::new(surface.leave(direction), direction) },
            primitive: scene.primitive_id(&surface.hit),
            depth: 1,
            margin: surface.error,
            steps: 0,
            length: 0.0,
            stream: path.sampler.stream(FIRST_SET + 2 * path.vertex),
        };
        let end = walk.run(u, &mut path.media);
        let (ray, steps, length) = (walk.ray, walk.steps, walk.length);
        stats.reflected += u64::from(steps);
        self.counts.add_many(sample, steps);
        let mut weight = walk.throughput;
        for (weight, before) in weight.iter_mut().zip(throughput) {
            *weight = if before > 0.0 { *weight / before } else { 0.0 };
        }
        let weight = Spectrum::from(weight.map(|v| v as f32));
        path.beta = path.beta * weight;
        path.vertex += 1;
        path.from_camera = false;
        path.seen_through = false;
        self.forget_light_paths(sample);
        let path = &mut self.paths[sample as usize];
        if path.beta.is_black() {
            return;
        }
        let (out, hit) = match end {
            End::Absorbed => return,
            End::Hit(hit) => {
                let surface_hit = scene.surface(&ray, &hit);
                let outside = ray.direction.dot(surface_hit.ng) < 0.0;
                if let Material::OpenPbr(m) = scene.material_at(&hit)
                    && m.is_emissive()
                    && (outside || m.emits_backwards())
                {
                    // Inside the body no light is sampled.
                    path.specular_bounce = true;
                    self.record.note(|r| r.hit_surface(scene, path, &ray, &hit, &surface_hit, None));
                    self.record.note(|r| {
                        r.random_walk(Passage::Surface, RandomWalkRecord { steps, length, weight })
                    });
                    self.add_emission(sample, m, &surface_hit, pixel);
                }
                return;
            }
            End::Exit(hit) => (scene.surface(&ray, &hit), hit),
            End::Entry => (*surface, surface.hit),
        };
        path.numbers = VertexNumbers::of(&path.sampler, FIRST_SET + 2 * (path.vertex - 1));
        self.record.note(|r| r.hit_surface(scene, path, &ray, &hit, &out, None));
        self.record.note(|r| r.random_walk(Passage::Exit, RandomWalkRecord { steps, length, weight }));
        let (bsdf, material) = self.exit_bsdf(sample, material, &out);
        let from_above = Ray { direction: -out.ng, ..Ray::new(out.p, -out.ng) };
        let vertex = prepare(scene, &from_above, material, &out, &bsdf, true);
        let number = self.paths[sample as usize].vertex;
        let at = self.receiver(sample, number, &out, -out.ng);
        let [u0, u1, u2, _] = self.paths[sample as usize].numbers.first();
        let sampled = || scene.emitters.sample_adaptive(scene, self.adaptive, at, [u0, u1, u2]);
        let lit = self.samples_light(&at).then(sampled).flatten();
        let path = &mut self.paths[sample as usize];
        (path.extra_candidates, path.resamples) = (0, false);
        let arrival = VertexInput { sample, ray: from_above, surface: &out, lit: &[lit] };
        self.scatter(&arrival, &vertex, material, true, pixel, stats);
    }

    /// The BSDF at the exit: the layers of the material there if it is translucent, else a surface that transmits
    /// everything.
    fn exit_bsdf<'m>(
        &self,
        sample: u32,
        entered: &'m OpenPbr,
        out: &SurfaceInteraction,
    ) -> (Bsdf<'m>, &'m OpenPbr)
    where
        'a: 'm,
    {
        let scene: &'a Scene = self.scene;
        let u = self.paths[sample as usize].numbers.first()[3];
        let there = match scene.material_at(&out.hit) {
            Material::OpenPbr(m) => Some(&**m),
            Material::Mix(m) => m.choose(scene, out, true, u),
            Material::Classic(_) | Material::Principled(..) => None,
        };
        match there.filter(|m| m.walks) {
            Some(m) => {
                let bsdf = match m.constant_bsdf(true) {
                    Some(bsdf) => bsdf.leaving(),
                    None => m.bsdf(scene, out, 1.0, true).leaving(),
                };
                (bsdf, m)
            }
            None => (Bsdf::lambert(Spectrum::WHITE), entered),
        }
    }
}

//! Paths through participating media.
//!
//! On its way to the next surface a path may scatter in the medium it is in. Single scattering into the ray is an
//! integral over the distance t and the direction to the lights, and three strategies estimate it:
//!
//! ```text
//!              * light L
//!             / \.
//!            /    \.          1. scatter at t_d (distance sampling), sample a light there
//!           /       \.        2. scatter at t_d, follow the phase function, hit a light
//!  o------t_e-------t_d---->| 3. sample t_e by the angle under which L sees the ray, sample a light there
//!  ray origin             end
//! ```
//!
//! Strategies 1 and 2 sample t_d in proportion to the transmittance times the scattering coefficient; this misses the
//! 1/distance² peak next to a light. Strategy 3 follows that peak (equiangular sampling: Kulla and Fajardo 2012,
//! "Importance sampling techniques for path tracing in participating media"). The power heuristic over the densities of
//! distance and direction weights the three: w_i = p_i² / (p_1² + p_2² + p_3²) with p_1 = p_d·p_L, p_2 = p_d·p_phase
//! and p_3 = p_e·p_L. The light that defines the angle is chosen once per segment and is the same for all three, so the
//! weights sum to 1 and the estimate stays unbiased whichever light that is.
//!
//! Strategy 3 needs the density of distance sampling in closed form, so only homogeneous media have it. Heterogeneous
//! media use delta tracking for distances and ratio tracking for shadow rays (`medium::heterogeneous`); 1 and 2 then
//! weigh directions only.

use super::LightSampling;
use super::dispersion::BAND_SET;
use super::lobe_split::Share;
use super::path_batch::{Path, PathBatch};
use super::ray_queue::RayQueue;
use super::record::{End, Record, Roulette};
use super::shade::MAX_VERTICES;
use super::volume_light::Connection;
use crate::integrator::{CameraSamples, Radiance, RayStats};
use crate::light::Receiver;
use crate::math::{DVec3, Ray};
use crate::medium::{Equiangular, Medium, PhaseFunction, RaySegment};
use crate::scene::{Hit, Volumes};

/// Sets of random numbers for segments through media, four per segment, after those of surfaces.
pub(super) const SEGMENT_SET: u32 = BAND_SET + 2;

/// What a set of random numbers is used for.
#[derive(Clone, Copy)]
pub(super) enum Purpose {
    /// Band, distance, equiangular point or offset of the emission points, Russian roulette. As a stream: delta tracking
    /// along the segment.
    Distance = 0,
    /// The light at the scattering event. As a stream: the media along its shadow ray.
    Light = 1,
    /// The direction, and the light of equiangular sampling. As a stream: the media along a shadow ray from a surface.
    Direction = 2,
    /// The light at the equiangular point. As a stream: the media along its shadow ray.
    SecondLight = 3,
}

impl Path {
    /// The set of random numbers of the current segment.
    pub(super) fn segment_set(&self, what: Purpose) -> u32 {
        SEGMENT_SET + 4 * self.vertex + what as u32
    }

    /// The fraction of each band in the throughput.
    fn band_fractions(&self) -> Option<[f64; 3]> {
        let bands = self.beta.to_array().map(|v| f64::from(v.max(0.0)));
        let sum = bands[0] + bands[1] + bands[2];
        (sum > 0.0 && sum < f64::INFINITY).then(|| bands.map(|v| v / sum))
    }
}

/// A point sampled by the angle that a light sees the ray under.
struct EquiangularPoint {
    angle: Equiangular,
    /// Distance along the ray.
    t: f64,
}

impl<R: Record> PathBatch<'_, R> {
    /// Sets the media of paths that start inside one.
    pub(super) fn begin_in_media(&mut self, volumes: &Volumes, samples: &CameraSamples) {
        if !volumes.bounded {
            return;
        }
        let mut last = None;
        for (i, path) in self.paths.iter_mut().enumerate() {
            let Some(ray) = samples.rays.get(i) else { continue };
            let media = match last {
                Some((origin, media)) if origin == ray.origin => media,
                _ => super::media::Media::enclosing(self.scene, ray.origin, samples.rays.time(i)),
            };
            last = Some((ray.origin, media));
            path.media = media;
        }
    }

    /// Traces the rays of the queue through their media. A ray that scatters before its hit is removed from the queue.
    pub(super) fn sample_media(
        &mut self,
        volumes: &Volumes,
        queue: &mut RayQueue,
        hits: &mut [Option<Hit>],
        out: &mut [Radiance],
        stats: &mut RayStats,
    ) {
        for (i, hit) in hits.iter_mut().enumerate() {
            let Some((ray, sample)) = queue.get(i) else { continue };
            let Some(medium) = volumes.within(self.paths[sample as usize].media.top()) else { continue };
            let end = hit.as_ref().map_or(f64::INFINITY, |h| h.shape.t);
            if self.sample_medium(medium, sample, &ray, end, &mut out[sample as usize], stats) {
                queue.remove(i);
                *hit = None;
            }
        }
    }

    /// Samples the medium along one ray; returns whether the path scattered.
    fn sample_medium(
        &mut self,
        medium: &Medium,
        sample: u32,
        ray: &Ray,
        end: f64,
        pixel: &mut Radiance,
        stats: &mut RayStats,
    ) -> bool {
        let path = &self.paths[sample as usize];
        let Some(shares) = path.band_fractions() else { return false };
        let scatters = medium.coefficients().scatters() && !self.is_spent(path);
        let [band, distance, equiangular_u, survival_u] =
            path.sampler.four(path.segment_set(Purpose::Distance));
        let mut stream = path.sampler.stream(path.segment_set(Purpose::Distance));
        let stretch = RaySegment { ray, end, shares, scatters };
        let walk = medium.walk(&stretch, [band, distance, equiangular_u], &mut stream);
        self.record.note(|r| r.medium_segment(path.media.top(), walk.scattered.unwrap_or(end), walk.weight));
        if !walk.emitted.is_black() {
            let added = self.settings.add(path, path.beta * walk.emitted, pixel);
            self.record.note(|r| r.segment_emitted(added));
        }
        let point =
            if scatters { self.sample_equiangular(medium, sample, ray, end, equiangular_u) } else { None };
        if let Some(point) = &point {
            self.connect_equiangular(medium, sample, ray, &stretch, point);
        }
        let path = &mut self.paths[sample as usize];
        path.beta = path.beta * walk.weight;
        let Some(t) = walk.scattered else { return false };
        if let Some(transmittance) = path.media.transmittance(t) {
            path.beta = path.beta * transmittance;
        }
        let p = ray.at(t);
        self.record.note(|r| r.scattered_in_medium(path, ray, t, p));
        if path.beta.is_black() {
            return true;
        }
        // Density of the equiangular point over that of distance sampling at t.
        let equiangular_ratio = point.as_ref().map_or(0.0, |point| point.angle.pdf(t) / walk.pdf);
        self.record.note(|r| r.equiangular_ratio(equiangular_ratio));
        let phase = medium.coefficients().phase;
        self.connect_scattered(sample, ray.direction, p, phase, equiangular_ratio);
        self.follow_phase(sample, ray, t, phase, equiangular_ratio, survival_u, stats);
        true
    }

    /// Samples the equiangular point of a segment for a light chosen at random.
    fn sample_equiangular(
        &self,
        medium: &Medium,
        sample: u32,
        ray: &Ray,
        end: f64,
        u: f64,
    ) -> Option<EquiangularPoint> {
        let Medium::Homogeneous(m) = medium else { return None };
        if self.settings.light_sampling == LightSampling::Bsdf {
            return None;
        }
        let path = &self.paths[sample as usize];
        let [_, _, choice, _] = path.sampler.four(path.segment_set(Purpose::Direction));
        let from = ray.at(0.5 * end.min(m.mean_free_path()));
        let lit = self.scene.emitters.sample(self.scene, from, [0.5, 0.5, choice])?;
        if !lit.finite {
            return None;
        }
        let angle = Equiangular::new(ray.origin, ray.direction, end, from + lit.to_light)?;
        let t = angle.sample(u);
        (t > 0.0 && t < end).then_some(EquiangularPoint { angle, t })
    }

    /// Samples a light at the equiangular point (strategy 3).
    fn connect_equiangular(
        &mut self,
        medium: &Medium,
        sample: u32,
        ray: &Ray,
        stretch: &RaySegment<'_>,
        point: &EquiangularPoint,
    ) {
        let Medium::Homogeneous(m) = medium else { return };
        let (path, t) = (&self.paths[sample as usize], point.t);
        let p = ray.at(t);
        let [u0, u1, u2, _] = path.sampler.four(path.segment_set(Purpose::SecondLight));
        let Some(lit) = self.scene.emitters.sample(self.scene, p, [u0, u1, u2]) else { return };
        let pdf = point.angle.pdf(t);
        let place = m.place(stretch.shares, t);
        let mut beta = path.beta * place.scattered * (1.0 / pdf) as f32;
        if let Some(transmittance) = path.media.transmittance(t) {
            beta = beta * transmittance;
        }
        let first = place.pdf / pdf;
        let phase = medium.coefficients().phase;
        let connection = Connection {
            sample,
            p,
            t,
            forward: ray.direction,
            phase,
            beta,
            // The densities of strategies 1 and 2 over this one's, without the direction.
            pdf_ratios: [first, first],
            stream: path.segment_set(Purpose::SecondLight),
            equiangular: true,
        };
        self.connect_medium(&connection, &lit);
    }

    /// Samples a light where the path scatters (strategy 1).
    fn connect_scattered(
        &mut self,
        sample: u32,
        forward: DVec3,
        p: DVec3,
        phase: PhaseFunction,
        equiangular_ratio: f64,
    ) {
        if self.settings.light_sampling == LightSampling::Bsdf {
            return;
        }
        let path = &self.paths[sample as usize];
        let [u0, u1, u2, _] = path.sampler.four(path.segment_set(Purpose::Light));
        let Some(lit) = self.scene.emitters.sample(self.scene, p, [u0, u1, u2]) else { return };
        let connection = Connection {
            sample,
            p,
            t: 0.0,
            forward,
            phase,
            beta: path.beta,
            pdf_ratios: [equiangular_ratio, 1.0],
            stream: path.segment_set(Purpose::Light),
            equiangular: false,
        };
        self.connect_medium(&connection, &lit);
    }

    /// Continues in a direction of the phase function (strategy 2).
    #[allow(clippy::too_many_arguments)]
    fn follow_phase(
        &mut self,
        sample: u32,
        ray: &Ray,
        t: f64,
        phase: PhaseFunction,
        equiangular_ratio: f64,
        survival_u: f64,
        stats: &mut RayStats,
    ) {
        let path = &mut self.paths[sample as usize];
        let [u0, u1, ..] = path.sampler.four(path.segment_set(Purpose::Direction));
        let (wi, pdf) = phase.sample(ray.direction, [u0, u1]);
        let p = ray.at(t);
        self.lobes.leaves(sample, || Share::Volume);
        path.vertex += 1;
        path.bounces.total += 1;
        path.from_camera = false;
        path.seen_through = false;
        path.specular_bounce = false;
        path.any_nonspecular = true;
        // A light hit from here weighs this density against p_L. The factor accounts for strategies 1 and 3 together.
        path.pdf = pdf / (1.0 + equiangular_ratio * equiangular_ratio).sqrt();
        path.origin = Receiver::from(p);
        if let Some(pixel) = &self.view.pixel_cone {
            path.cone = path.cone.advanced(t).scattered(pdf, pixel.share);
        }
        stats.reflected += 1;
        self.record.note(|r| r.scattered_by_phase(wi, pdf, path.beta));
        if path.vertex > MAX_VERTICES {
            self.record.note(|r| r.end = End::Vertices);
            return;
        }
        if path.bounces.total >= self.settings.rr_start {
            let throughput = path.beta.max_component() * path.eta2;
            let survival = throughput.max(0.0).sqrt().clamp(0.05, 1.0);
            let survives = survival_u < f64::from(survival);
            self.record.note(|r| r.roulette(Roulette { survival: f64::from(survival), number: survival_u }));
            if !survives {
                self.record.note(|r| r.end = End::Roulette);
                return;
            }
            path.beta *= 1.0 / survival;
            self.record.note(|r| r.set_throughput(path.beta));
        }
        self.next.push_from_medium(sample, p, wi);
    }
}

//! Paths through participating media.
//!
//! On its way to the next surface a path may scatter in the medium it is in. Single scattering into the ray is an
//! integral over the distance t and the direction to the lights, and three strategies estimate it:
//!
//! ```text
//!               * light L
//!             ./ \.
//!           ./     \.        1. scatter at t_d (distance sampling), sample a light there
//!         ./         \.      2. scatter at t_d, follow the phase function, hit a light
//!  o----t_e----------t_d----->| 3. sample t_e by the angle that L sees the ray under, sample a light there
//!  ray origin            end
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
use super::path_batch::{Path, PathBatch, RayQueue};
use super::record::{End, Record, Roulette};
use super::shade::MAX_VERTICES;
use super::volume_light::Connection;
use crate::integrator::{CameraSamples, Radiance, RayStats};
use crate::light::Receiver;
use crate::math::{DVec3, Ray};
use crate::medium::{Equiangular, HenyeyGreenstein, Medium, Stretch};
use crate::scene::{Hit, Volumes};

/// Sets of random numbers for segments through media, four per segment, after those of surfaces.
pub(super) const WAY_SET: u32 = BAND_SET + 2;

/// What a set of random numbers is used for.
#[derive(Clone, Copy)]
pub(super) enum Purpose {
    /// Band, distance, equiangular point, Russian roulette. As a stream: delta tracking along the segment.
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
    pub(super) fn way_set(&self, what: Purpose) -> u32 {
        WAY_SET + 4 * self.vertex + what as u32
    }

    /// The fraction of each band in the throughput.
    fn shares(&self) -> Option<[f64; 3]> {
        let bands = self.beta.to_array().map(|v| f64::from(v.max(0.0)));
        let sum = bands[0] + bands[1] + bands[2];
        (sum > 0.0 && sum < f64::INFINITY).then(|| bands.map(|v| v / sum))
    }
}

/// A point sampled by the angle that a light sees the ray under.
struct SecondPlace {
    angle: Equiangular,
    /// Distance along the ray.
    t: f64,
}

impl<R: Record> PathBatch<'_, R> {
    /// Sets the media of paths that start inside one.
    pub(super) fn begin_within(&mut self, volumes: &Volumes, samples: &CameraSamples) {
        if !volumes.bounded {
            return;
        }
        let mut last = None;
        for (i, path) in self.paths.iter_mut().enumerate() {
            let Some(ray) = samples.rays.get(i) else { continue };
            let media = match last {
                Some((origin, media)) if origin == ray.origin => media,
                _ => super::media::Media::around(self.scene, ray.origin, samples.rays.time(i)),
            };
            last = Some((ray.origin, media));
            path.media = media;
        }
    }

    /// Traces the rays of the queue through their media. A ray that scatters before its hit is removed from the queue.
    pub(super) fn travel(
        &mut self,
        volumes: &Volumes,
        front: &mut RayQueue,
        hits: &mut [Option<Hit>],
        out: &mut [Radiance],
        stats: &mut RayStats,
    ) {
        for (i, hit) in hits.iter_mut().enumerate() {
            let Some((ray, sample)) = front.get(i) else { continue };
            let Some(medium) = volumes.within(self.paths[sample as usize].media.top()) else { continue };
            let end = hit.as_ref().map_or(f64::INFINITY, |h| h.shape.t);
            if self.go_through(medium, sample, &ray, end, &mut out[sample as usize], stats) {
                front.remove(i);
                *hit = None;
            }
        }
    }

    /// Samples the medium along one ray; returns whether the path scattered.
    fn go_through(
        &mut self,
        medium: &Medium,
        sample: u32,
        ray: &Ray,
        end: f64,
        pixel: &mut Radiance,
        stats: &mut RayStats,
    ) -> bool {
        let path = &self.paths[sample as usize];
        let Some(shares) = path.shares() else { return false };
        let scatters = medium.coefficients().scatters() && !self.is_spent(path);
        let [band, distance, place, gamble] = path.sampler.four(path.way_set(Purpose::Distance));
        let mut stream = path.sampler.stream(path.way_set(Purpose::Distance));
        let stretch = Stretch { ray, end, shares, scatters };
        let walk = medium.walk(&stretch, [band, distance], &mut stream);
        self.record.note(|r| r.way(path.media.top(), walk.scattered.unwrap_or(end), walk.weight));
        if !walk.emitted.is_black() {
            let added = self.settings.add(path, path.beta * walk.emitted, pixel);
            self.record.note(|r| r.way_shone(added));
        }
        let second = if scatters { self.second_place(medium, sample, ray, end, place) } else { None };
        if let Some(second) = &second {
            self.light_second(medium, sample, ray, &stretch, second);
        }
        let path = &mut self.paths[sample as usize];
        path.beta = path.beta * walk.weight;
        let Some(t) = walk.scattered else { return false };
        if let Some(left) = path.media.transmittance(t) {
            path.beta = path.beta * left;
        }
        let p = ray.at(t);
        self.record.note(|r| r.met_medium(path, ray, t, p));
        if path.beta.is_black() {
            return true;
        }
        // Density of the equiangular point over that of distance sampling at t.
        let beside = second.as_ref().map_or(0.0, |second| second.angle.pdf(t) / walk.pdf);
        self.record.note(|r| r.might_be_second(beside));
        let phase = medium.coefficients().phase;
        self.light_first(sample, ray.direction, p, phase, beside);
        self.go_on(sample, ray, t, phase, beside, gamble, stats);
        true
    }

    /// Samples the equiangular point of a segment for a light chosen at random.
    fn second_place(
        &self,
        medium: &Medium,
        sample: u32,
        ray: &Ray,
        end: f64,
        place: f64,
    ) -> Option<SecondPlace> {
        let Medium::Homogeneous(m) = medium else { return None };
        if self.settings.light_sampling == LightSampling::Bsdf {
            return None;
        }
        let path = &self.paths[sample as usize];
        let [_, _, choice, _] = path.sampler.four(path.way_set(Purpose::Direction));
        let from = ray.at(0.5 * end.min(m.mean_free_path()));
        let lit = self.scene.emitters.sample(self.scene, from, [0.5, 0.5, choice])?;
        if !lit.finite {
            return None;
        }
        let angle = Equiangular::new(ray.origin, ray.direction, end, from + lit.to_light)?;
        let t = angle.sample(place);
        (t > 0.0 && t < end).then_some(SecondPlace { angle, t })
    }

    /// Samples a light at the equiangular point (strategy 3).
    fn light_second(
        &mut self,
        medium: &Medium,
        sample: u32,
        ray: &Ray,
        stretch: &Stretch<'_>,
        second: &SecondPlace,
    ) {
        let Medium::Homogeneous(m) = medium else { return };
        let (path, t) = (&self.paths[sample as usize], second.t);
        let p = ray.at(t);
        let [u0, u1, u2, _] = path.sampler.four(path.way_set(Purpose::SecondLight));
        let Some(lit) = self.scene.emitters.sample(self.scene, p, [u0, u1, u2]) else { return };
        let pdf = second.angle.pdf(t);
        let place = m.place(stretch.shares, t);
        let mut carried = path.beta * place.scattered * (1.0 / pdf) as f32;
        if let Some(left) = path.media.transmittance(t) {
            carried = carried * left;
        }
        let first = place.pdf / pdf;
        let phase = medium.coefficients().phase;
        let connection = Connection {
            sample,
            p,
            t,
            forward: ray.direction,
            phase,
            carried,
            // The densities of strategies 1 and 2 over this one's, without the direction.
            others: [first, first],
            stream: path.way_set(Purpose::SecondLight),
            second: true,
        };
        self.connect_medium(&connection, &lit);
    }

    /// Samples a light where the path scatters (strategy 1).
    fn light_first(&mut self, sample: u32, forward: DVec3, p: DVec3, phase: HenyeyGreenstein, beside: f64) {
        if self.settings.light_sampling == LightSampling::Bsdf {
            return;
        }
        let path = &self.paths[sample as usize];
        let [u0, u1, u2, _] = path.sampler.four(path.way_set(Purpose::Light));
        let Some(lit) = self.scene.emitters.sample(self.scene, p, [u0, u1, u2]) else { return };
        let connection = Connection {
            sample,
            p,
            t: 0.0,
            forward,
            phase,
            carried: path.beta,
            others: [beside, 1.0],
            stream: path.way_set(Purpose::Light),
            second: false,
        };
        self.connect_medium(&connection, &lit);
    }

    /// Continues in a direction of the phase function (strategy 2).
    #[allow(clippy::too_many_arguments)]
    fn go_on(
        &mut self,
        sample: u32,
        ray: &Ray,
        t: f64,
        phase: HenyeyGreenstein,
        beside: f64,
        gamble: f64,
        stats: &mut RayStats,
    ) {
        let path = &mut self.paths[sample as usize];
        let [u0, u1, ..] = path.sampler.four(path.way_set(Purpose::Direction));
        let (wi, pdf) = phase.sample(ray.direction, [u0, u1]);
        let p = ray.at(t);
        path.vertex += 1;
        path.bounces.total += 1;
        path.from_camera = false;
        path.specular_bounce = false;
        path.any_nonspecular = true;
        // A light hit from here weighs this density against p_L. The factor accounts for strategies 1 and 3 together.
        path.pdf = pdf / (1.0 + beside * beside).sqrt();
        path.origin = Receiver::from(p);
        if let Some(pixel) = &self.view.pixel_cone {
            path.cone = path.cone.advanced(t).scattered(pdf, pixel.share);
        }
        stats.reflected += 1;
        self.record.note(|r| r.scattered_by_medium(wi, pdf, path.beta));
        if path.vertex > MAX_VERTICES {
            self.record.note(|r| r.end = End::Vertices);
            return;
        }
        if path.bounces.total >= self.settings.rr_start {
            let carried = path.beta.max_component() * path.eta2;
            let survives = carried.max(0.0).sqrt().clamp(0.05, 1.0);
            let lives = gamble < f64::from(survives);
            self.record.note(|r| r.gambled(Roulette { survival: f64::from(survives), number: gamble }));
            if !lives {
                self.record.note(|r| r.end = End::Roulette);
                return;
            }
            path.beta *= 1.0 / survives;
            self.record.note(|r| r.carries(path.beta));
        }
        self.next.push_free(sample, p, wi);
    }
}

//! Direct light at points in media, and transmittance along shadow rays.
//!
//! A shadow ray may cross several media. Its transmittance is the product over the segments between boundaries:
//!
//! ```text
//!  p ====== medium A ====== | == medium B == | ---- vacuum ---- * light      T = T_A · T_B
//! ```
//!
//! Each factor is exact in homogeneous media (Beer–Lambert law) and an unbiased ratio-tracking estimate in others.

use super::LightSampling;
use super::lobe_split::Share;
use super::media::Media;
use super::path_batch::PathBatch;
use super::record::Record;
use super::volume::Purpose;
use crate::color::Spectrum;
use crate::material::Material;
use crate::math::{DVec3, Ray};
use crate::medium::PhaseFunction;
use crate::sampler::Stream;
use crate::scene::light_sample::LightSample;
use crate::scene::{Scene, Volumes};

/// The media state of a shadow ray.
#[derive(Clone)]
pub(super) struct ShadowRayMedia {
    /// The solids around its origin.
    media: Media,
    stream: Stream,
    /// Whether it starts at the equiangular point of a segment.
    pub(super) equiangular: bool,
}

/// A point in a medium where a light was sampled.
pub(super) struct Connection {
    pub(super) sample: u32,
    pub(super) p: DVec3,
    /// Distance along the segment, for an equiangular point.
    pub(super) t: f64,
    /// Direction of the path.
    pub(super) forward: DVec3,
    pub(super) phase: PhaseFunction,
    /// Throughput to the point, over the density of its distance.
    pub(super) beta: Spectrum,
    /// Density of the distance by the other strategy over that by this one, to weigh against light sampled at the point
    /// and against lights hit from it.
    pub(super) pdf_ratios: [f64; 2],
    /// The set of random numbers for the media along the shadow ray.
    pub(super) stream: u32,
    pub(super) equiangular: bool,
}

impl<R: Record> PathBatch<'_, R> {
    /// Adds a shadow ray to the sampled light.
    pub(super) fn connect_medium(&mut self, c: &Connection, lit: &LightSample) {
        let path = &self.paths[c.sample as usize];
        let distance = lit.to_light.length();
        let wi = lit.to_light / distance;
        let phase = c.phase.value(c.forward.dot(wi));
        self.record.note(|r| r.sampled_light_in_medium(c.equiangular.then_some(c.t), lit, wi, phase));
        let hit_ratio = match (lit.is_delta, self.settings.light_sampling) {
            (false, LightSampling::Both) => c.pdf_ratios[1] * phase / lit.pdf,
            _ => 0.0,
        };
        let weight = 1.0 / (1.0 + c.pdf_ratios[0] * c.pdf_ratios[0] + hit_ratio * hit_ratio);
        let mut light = c.beta * lit.radiance * (phase * weight / lit.pdf) as f32;
        let length = if lit.finite { distance } else { f64::INFINITY };
        let transmittance = path.media.transmittance(length);
        if let Some(transmittance) = transmittance {
            light = light * transmittance;
        }
        if light.is_black() {
            return;
        }
        let light = self.settings.clamped(light, path.bounces.total > 0);
        self.record.note(|r| {
            r.at_light(c.equiangular, |l| {
                (l.weight, l.transmittance, l.unshadowed) = (weight, transmittance, light);
            })
        });
        let ray =
            if lit.finite { Ray { t_max: 1.0, ..Ray::new(c.p, lit.to_light) } } else { Ray::new(c.p, wi) };
        let stream = path.sampler.stream(c.stream);
        let media = ShadowRayMedia { media: path.media, stream, equiangular: c.equiangular };
        self.groups.push_shadow_ray(self.groups.of_sample(self.scene, lit));
        self.lobes.push_shadow_ray(c.sample, || Share::Volume);
        self.shadows.push_from_medium(&ray, c.sample, light, media);
    }

    /// Sets the media state of a shadow ray from a surface; it starts in `media`.
    pub(super) fn push_media(&mut self, sample: u32, media: Media) {
        let path = &self.paths[sample as usize];
        let stream = path.sampler.stream(path.segment_set(Purpose::Direction));
        self.shadows.push_media(ShadowRayMedia { media, stream, equiangular: false });
    }
}

impl ShadowRayMedia {
    /// Transmittance of the media along an unoccluded shadow ray, segment by segment from boundary to boundary.
    pub(super) fn transmittance(&mut self, scene: &Scene, volumes: &Volumes, ray: &Ray) -> Spectrum {
        /// A ray that crosses more boundaries counts as occluded.
        const MAX_CROSSINGS: u32 = 4096;
        let length = ray.direction.length();
        let mut ray = Ray {
            direction: ray.direction / length,
            t_min: ray.t_min * length,
            t_max: ray.t_max * length,
            ..*ray
        };
        let (mut transmittance, mut from) = (Spectrum::WHITE, 0.0);
        let mut crossings = if volumes.bounded { MAX_CROSSINGS } else { 0 };
        let through = |c: &mut ShadowRayMedia, ray: &Ray, from: f64, to: f64| {
            let medium = volumes.within(c.media.top());
            medium.map_or(Spectrum::WHITE, |m| m.transmittance(ray, from, to, &mut c.stream))
        };
        while crossings > 0 {
            let Some(hit) = scene.intersect(&ray) else { break };
            crossings -= 1;
            if crossings == 0 {
                return Spectrum::BLACK;
            }
            let surface = scene.surface(&ray, &hit);
            if let Material::OpenPbr(m) = scene.material_at(&hit)
                && (m.boundary || m.admits_medium())
            {
                transmittance = transmittance * through(self, &ray, from, hit.shape.t);
                if transmittance.is_black() {
                    return transmittance;
                }
                self.media.cross(scene, &surface, m, ray.direction.dot(surface.ng) < 0.0);
                from = hit.shape.t;
            }
            ray.t_min = scene.beyond(&ray, &hit, &surface);
        }
        transmittance * through(self, &ray, from, ray.t_max)
    }
}

impl Media {
    /// The solids with a medium that enclose a point at a time: those whose boundary a ray from it leaves without
    /// having entered.
    pub(super) fn enclosing(scene: &Scene, point: DVec3, time: f32) -> Media {
        const MAX_CROSSINGS: u32 = 4096;
        let mut media = Media::NONE;
        let mut entered = Media::NONE;
        // Any direction, not along an axis of the scene.
        let direction = DVec3::new(0.267_261_2, 0.934_414_3, 0.235_522_6).normalize();
        let mut ray = Ray { time, ..Ray::new(point, direction) };
        for _ in 0..MAX_CROSSINGS {
            let Some(hit) = scene.intersect(&ray) else { break };
            let surface = scene.surface(&ray, &hit);
            if let Material::OpenPbr(m) = scene.material_at(&hit)
                && (m.boundary || m.admits_medium() || m.has_inside() && m.desc.interior.is_some())
            {
                let outside = ray.direction.dot(surface.ng) < 0.0;
                if outside || entered.contains(surface.material) {
                    entered.cross(scene, &surface, m, outside);
                } else {
                    media.cross(scene, &surface, m, true);
                }
            }
            ray.t_min = scene.beyond(&ray, &hit, &surface);
        }
        media
    }
}

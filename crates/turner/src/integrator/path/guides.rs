//! The surfaces that guide the denoiser: the first surface of each path that is not polished.
//!
//! A picture of a room in a mirror has the room's edges and textures. So albedo, normal and distance are not those of the
//! mirror, but of what is seen in it: a path is followed over surfaces all of whose lobes are narrow, to the first other
//! surface. Glass is split by its path: some samples are reflected, others refracted, and the film averages their
//! surfaces.

use std::f64::consts::LOG2_E;

use super::Context;
use super::light_split::LightSplit;
use super::path_batch::PathBatch;
use super::ray_queue::RayQueue;
use super::record::Record;
use crate::color::Spectrum;
use crate::integrator::{DenoisingSample, Radiance, footprint};
use crate::material::Material;
use crate::math::elementary::ln;
use crate::scene::{Hit, SurfaceInteraction};

/// The guiding surfaces of a batch.
#[derive(Default)]
pub(super) struct Guides {
    on: bool,
    /// Whether nothing else is asked for: paths end at these surfaces, and no light is sampled.
    alone: bool,
    /// Whether any path is still followed.
    active: bool,
    samples: Vec<DenoisingSample>,
    trails: Vec<Trail>,
}

/// How far a path was followed.
#[derive(Clone, Copy, Default)]
struct Trail {
    /// Its length.
    length: f64,
    /// Its number of bounces at the last surface.
    bounces: u32,
    /// The most bounces at the next surface: more mean that a medium has scattered it.
    expected: u32,
    /// Whether the last surface is the one sought, unless the path passed straight through it.
    is_found: bool,
    is_over: bool,
    /// The radiance of its sample before the step.
    before: Spectrum,
}

impl Guides {
    /// Finds the surfaces of the following batches.
    pub(super) fn turn_on(&mut self, on: bool) {
        self.on |= on;
    }

    /// Whether nothing but these surfaces is asked for.
    #[inline]
    pub(super) fn are_alone(&self) -> bool {
        self.alone
    }

    /// The surfaces of the last batch.
    pub(super) fn samples(&self) -> &[DenoisingSample] {
        &self.samples
    }

    /// Begins a batch.
    pub(super) fn begin(&mut self, count: usize) {
        self.active = self.on;
        if self.on {
            self.samples.clear();
            self.samples.resize(count, DenoisingSample::default());
            self.trails.clear();
            self.trails.resize(count, Trail::default());
        }
    }

    /// Begins a round of these samples.
    pub(super) fn begin_round(&mut self, samples: &[u32], out: &[Radiance]) {
        if self.active {
            for &sample in samples {
                self.trails[sample as usize].before = out[sample as usize].color;
            }
        }
    }

    /// The vertices of a round are shaded; the light that they sample is not yet added.
    pub(super) fn shaded(&mut self, samples: &[u32], out: &[Radiance], split: &LightSplit) {
        if !self.active {
            return;
        }
        for &sample in samples {
            let i = sample as usize;
            let trail = &self.trails[i];
            if !trail.is_over {
                self.samples[i].emission += out[i].color - trail.before - split.photons(sample);
            }
        }
    }
}

impl<'a, R: Record> PathBatch<'a, R> {
    /// A batch that finds nothing but the surfaces.
    pub(super) fn of_guides(context: Context<'a>, record: R) -> PathBatch<'a, R> {
        let mut batch = PathBatch::new(Context { cluster: 1, ..context }, record);
        (batch.guides.on, batch.guides.alone) = (true, true);
        batch
    }

    /// Follows the paths of a round to the surfaces that they hit. `surfaces` are those that are not shaded in blocks.
    pub(super) fn find_guides(
        &mut self,
        queue: &RayQueue,
        hits: &[Option<Hit>],
        surfaces: &[(SurfaceInteraction, u32)],
    ) {
        if !self.guides.active {
            return;
        }
        self.guides.active = false;
        let mut known = surfaces.iter();
        for (i, hit) in hits.iter().enumerate() {
            let surface = match hit {
                Some(_) if !self.blocks.contains(i) => known.next(),
                _ => None,
            };
            let at = queue.samples[i] as usize;
            let path = &self.paths[at];
            let trail = &mut self.guides.trails[at];
            let ray = queue.rays.get(i);
            // A path that scatters in a medium has no ray in the queue; `bounces` already counts this scattering.
            let now = path.bounces.total.saturating_sub(u32::from(ray.is_none()));
            trail.is_over |= trail.is_found && now > trail.bounces || now > trail.expected;
            if trail.is_over {
                self.paths[at].ends |= self.guides.alone;
                continue;
            }
            self.guides.active = true;
            let Some(ray) = ray else { continue };
            let beta = path.beta.to_array().map(|v| if v < 1.0 { v.max(0.0) } else { 1.0 });
            let beta = Spectrum::from(beta);
            let Some(hit) = hit else {
                let albedo = if path.from_camera { Spectrum::BLACK } else { beta };
                let known = &mut self.guides.samples[at];
                (known.albedo, known.normal, known.is_hit) = (albedo, [0.0; 3], false);
                known.log_distance = 0.0;
                continue;
            };
            let made;
            let surface = match surface {
                Some((surface, _)) => surface,
                None => {
                    let mut surface = self.scene.surface(&ray, hit);
                    if self.view.pixel_cone.is_some() {
                        // The cone of the path is already that at the hit.
                        if path.any_nonspecular {
                            footprint::see_isotropic(&mut surface, ray.direction, path.cone.width);
                        } else {
                            surface.see(ray.direction, path.cone.width);
                        }
                    }
                    made = surface;
                    &made
                }
            };
            let outside = ray.direction.dot(surface.ng) <= 0.0;
            let material = self.scene.material_at(hit);
            let normal = if outside { surface.ns } else { -surface.ns };
            trail.length += hit.shape.t;
            (trail.bounces, trail.expected) = (now, now + u32::from(!material.is_boundary()));
            let log_distance = (ln(trail.length.max(f64::MIN_POSITIVE)) * LOG2_E) as f32;
            let albedo = match material {
                Material::OpenPbr(m) => match m.constant_bsdf(outside) {
                    Some(bsdf) => bsdf.albedo_hint(),
                    None => m.bsdf(self.scene, surface, 1.0, outside).albedo_hint(),
                },
                Material::Mix(_) | Material::Classic(_) | Material::Principled(..) => {
                    material.base_color(self.scene, surface, outside)
                }
            };
            let known = &mut self.guides.samples[at];
            known.albedo = beta * albedo;
            known.normal = normal.to_array().map(|v| v as f32);
            (known.log_distance, known.is_hit) = (log_distance, true);
            trail.is_found = !match material {
                Material::OpenPbr(m) => m.near_specular || m.boundary || m.pane,
                Material::Mix(_) | Material::Classic(_) | Material::Principled(..) => false,
            };
            self.paths[at].ends = self.guides.alone && trail.is_found;
        }
    }
}

//! AOVs: the values of a batch of camera samples, besides their colour.
//!
//! [`SampleAovs`] evaluates the AOVs of the film at the first hits of the camera rays of a batch. For an integrator that
//! does not keep these hits it traces the rays once more, eight at a time; they are not counted in
//! [`RayStats`](crate::integrator::RayStats). It uses the rays, times and texture footprints of the samples, so the values
//! belong to the same surfaces as the colour. Media and materials with partial opacity are not looked through: the first
//! surface counts.
//!
//! A further AOV is a line of [`Aov`], one of [`Aov::layout`], and an arm of `value` or `label` below. The compiler
//! reports what is missing.

mod first_hit;
mod lanes;
mod light;
#[cfg(test)]
mod light_tests;
#[cfg(test)]
mod lobe_tests;
mod surfaces;
#[cfg(test)]
mod tests;

use std::ops::Range;

use turner_bvh::lanes::{Block32, LANES, dispatch};

use crate::camera::CameraFrame;
use crate::film::{Aov, LabelKind, NO_LABEL};
use crate::integrator::{AskedDetails, CameraSamples, Radiance, SampleDetails, Tracer, footprint};
use crate::interaction::SurfaceInteraction;
use crate::math::DVec3;
use crate::scene::{FlatBlock, Hit, RayBatch, Scene, SurfaceBlock};
use crate::shape::SurfacePoint;
use crate::view::View;
use first_hit::AovHit;
use lanes::{Points, is_in_lanes};
use light::{SampleLight, append_caught, finite};
pub(crate) use surfaces::SurfaceAovs;

/// The AOVs of the samples of one worker. It reuses its buffers from batch to batch.
pub struct SampleAovs<'a> {
    scene: &'a Scene,
    view: &'a View,
    frame: CameraFrame,
    aovs: Vec<Aov>,
    /// What the channels of labels number.
    kinds: Vec<LabelKind>,
    rays: RayBatch,
    hits: Vec<Option<Hit>>,
    /// The surfaces of eight samples.
    surfaces: SurfaceBlock,
    /// For each AOV its channels at those samples, where [`Points`] computes them.
    in_lanes: Vec<[Block32; 3]>,
    /// For each sample: 1 if it hit something, then the values of all channels with sums.
    values: Vec<f32>,
    /// For each sample: the labels of all channels of labels.
    labels: Vec<u32>,
    channels: usize,
}

impl<'a> SampleAovs<'a> {
    /// For the AOVs of a view's film; `None` if there are none.
    pub fn new(scene: &'a Scene, view: &'a View) -> Option<SampleAovs<'a>> {
        if !view.film.aovs.has_channels() {
            return None;
        }
        let aovs = view.film.aovs.summed().collect();
        Some(SampleAovs {
            scene,
            view,
            frame: view.camera.frame(),
            aovs,
            kinds: view.film.aovs.iter().filter_map(Aov::labels).collect(),
            rays: RayBatch::default(),
            hits: Vec::new(),
            surfaces: SurfaceBlock::default(),
            in_lanes: Vec::new(),
            values: Vec::new(),
            labels: Vec::new(),
            channels: view.film.channels().len(),
        })
    }

    /// Asks a tracer for the details that they show.
    pub fn ask(&self, tracer: &mut dyn Tracer) {
        tracer.ask(AskedDetails {
            parts: self.aovs.iter().any(|aov| aov.is_light()),
            groups: self.aovs.contains(&Aov::LightGroups),
            rays: self.aovs.contains(&Aov::Cost),
            bounces: self.aovs.contains(&Aov::Bounces),
            lobes: self.aovs.iter().any(|aov| aov.is_lobe()),
            hits: true,
            denoising: self.aovs.contains(&Aov::Denoising),
        });
    }

    /// Replaces the values by those of a batch. `radiance` and `details` are what a tracer knows of the samples, before
    /// `clamp_sample`; what it does not know is 0.
    pub fn take(&mut self, samples: &CameraSamples, radiance: &[Radiance], details: SampleDetails<'_>) {
        let film = &self.view.film;
        let names = self.scene.light_groups.names();
        let is_filtered = self.view.pixel_cone.is_some();
        self.values.clear();
        self.labels.clear();
        if details.hits.len() != samples.ids.len() {
            self.rays.copy(&samples.rays);
            self.scene.intersect_batch(&mut self.rays, &mut self.hits);
            self.scene.look_past_hidden(&self.rays, &mut self.hits);
        }
        let hits = if details.hits.len() == samples.ids.len() { details.hits } else { &self.hits };
        let count = radiance.len().min(samples.ids.len());
        let needs_light = self.aovs.iter().any(|aov| aov.needs_paths());
        let catches_shadows = film.aovs.catches_shadows();
        let camera_moves = self.view.motion.is_some();
        self.in_lanes.resize(self.aovs.len(), Default::default());
        self.values.reserve(count * self.channels);
        self.labels.reserve(count * self.kinds.len());
        for first in (0..count).step_by(LANES) {
            let block = first..(first + LANES).min(count);
            let flat = find_surfaces(self.scene, &samples.rays, hits, block.clone(), &mut self.surfaces);
            dispatch(
                self.scene.instruction_set,
                Points {
                    surfaces: &mut self.surfaces,
                    flat,
                    rays: &samples.rays.blocks()[first / LANES],
                    frame: &self.frame,
                    aovs: &self.aovs,
                    out: &mut self.in_lanes,
                },
            );
            for i in block {
                let lane = i - first;
                // Where the camera has no ray, what the tracer knows is ignored.
                let ray = samples.rays.get(i).filter(|ray| ray.t_max >= 0.0);
                let known = if ray.is_some() { details } else { SampleDetails::default() };
                let weight = samples.weight(i);
                let light =
                    needs_light.then(|| SampleLight::new(film, &radiance[i], &known, (i, weight), names));
                let hit = hits.get(i).copied().flatten();
                let values = &mut self.values;
                if let (Some(hit), Some(ray)) = (hit, ray) {
                    let at = || AovHit {
                        scene: self.scene,
                        view: self.view,
                        frame: &self.frame,
                        ray,
                        hit,
                        p: self.surfaces.point(lane),
                        ng: self.surfaces.normal(lane),
                        ns: self.surfaces.shading_normal(lane),
                        cone: is_filtered.then(|| footprint::of_camera(self.view, samples, i)),
                    };
                    values.push(1.0);
                    for (aov, in_lanes) in self.aovs.iter().zip(&self.in_lanes) {
                        if is_in_lanes(*aov, camera_moves) {
                            let channels = &in_lanes[..aov.layout().channels.len()];
                            values.extend(channels.iter().map(|channel| finite(channel.0[lane])));
                        } else if !light.as_ref().is_some_and(|light| light.append(*aov, values)) {
                            append(values, *aov, value(*aov, &at()));
                        }
                    }
                    self.labels.extend(self.kinds.iter().map(|kind| label(*kind, self.scene, &hit)));
                } else {
                    values.push(0.0);
                    for aov in &self.aovs {
                        if !light.as_ref().is_some_and(|light| light.append(*aov, values)) {
                            append(values, *aov, [0.0; 3]);
                        }
                    }
                    self.labels.extend(self.kinds.iter().map(|_| NO_LABEL));
                }
                if catches_shadows {
                    append_caught(values, film, &radiance[i], weight, known.caught.get(i));
                }
            }
        }
    }

    /// The number of samples.
    pub fn len(&self) -> usize {
        self.values.len() / self.channels.max(1)
    }

    /// Whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The values of a sample, one for each channel of the film.
    pub fn values(&self, sample: usize) -> &[f32] {
        self.values.get(sample * self.channels..(sample + 1) * self.channels).unwrap_or_default()
    }

    /// The labels of a sample, one for each channel of labels of the film.
    pub fn labels(&self, sample: usize) -> &[u32] {
        let count = self.kinds.len();
        self.labels.get(sample * count..(sample + 1) * count).unwrap_or_default()
    }

    /// Moves the samples to the end of `all`, which the caller keeps while it traces others.
    pub fn append_to(&mut self, all: &mut (Vec<f32>, Vec<u32>)) {
        all.0.append(&mut self.values);
        all.1.append(&mut self.labels);
    }

    /// Replaces the samples by those of `all`, which gets the present ones.
    pub fn swap(&mut self, all: &mut (Vec<f32>, Vec<u32>)) {
        std::mem::swap(&mut self.values, &mut all.0);
        std::mem::swap(&mut self.labels, &mut all.1);
    }

    /// Keeps the samples for which `keep` is true; it is called for each in order.
    pub fn retain(&mut self, mut keep: impl FnMut(usize) -> bool) {
        let (channels, count) = (self.channels, self.kinds.len());
        let mut kept = 0;
        for sample in 0..self.len() {
            if keep(sample) {
                self.values.copy_within(sample * channels..(sample + 1) * channels, kept * channels);
                self.labels.copy_within(sample * count..(sample + 1) * count, kept * count);
                kept += 1;
            }
        }
        self.values.truncate(kept * channels);
        self.labels.truncate(kept * count);
    }
}

/// Finds the surfaces at the hits of up to eight rays; [`Points`] computes them. Lanes without a hit keep old values. If
/// all hits are on one flat shape, it is returned instead.
fn find_surfaces(
    scene: &Scene,
    rays: &RayBatch,
    hits: &[Option<Hit>],
    samples: Range<usize>,
    surfaces: &mut SurfaceBlock,
) -> Option<FlatBlock> {
    let flat = hits.get(samples.clone()).and_then(|hits| scene.flat_block(hits));
    if flat.is_some() {
        return flat;
    }
    for (lane, i) in samples.enumerate() {
        let Some(Some(hit)) = hits.get(i) else { continue };
        if surfaces.take_triangle(scene, lane, hit, false) {
            continue;
        }
        let Some(ray) = rays.get(i) else { continue };
        let point = scene.point_in_world(&ray, hit).unwrap_or_else(|| {
            let SurfaceInteraction { p, error, ng, ns, .. } = scene.surface(&ray, hit);
            SurfacePoint { p, error, ng, ns }
        });
        surfaces.set_point(lane, &point);
    }
    None
}

/// Appends as many values as the AOV has channels.
fn append(values: &mut Vec<f32>, aov: Aov, value: [f64; 3]) {
    let count = aov.layout().channels.len();
    values.extend(value.into_iter().take(count).map(|v| finite(v as f32)));
}

/// The value of an AOV at a hit; those of light are known before. Not inlined: what one AOV needs would be computed for
/// all.
#[inline(never)]
fn value(aov: Aov, at: &AovHit<'_>) -> [f64; 3] {
    let along = |v: DVec3| v.to_array();
    let one = |v: f64| [v, 0.0, 0.0];
    match aov {
        Aov::Albedo => at.albedo().to_array().map(f64::from),
        Aov::Normal => along(at.normal()),
        Aov::GeometricNormal => along(at.ng),
        Aov::CameraNormal => along(at.in_camera(at.normal())),
        Aov::Depth => one(at.depth()),
        Aov::Distance => one(at.distance()),
        Aov::Position => along(at.p),
        Aov::Uv => at.uv(),
        Aov::Motion => at.motion(),
        Aov::Emission
        | Aov::Direct
        | Aov::Indirect
        | Aov::LightGroups
        | Aov::Caustics
        | Aov::DirectDiffuse
        | Aov::DirectSpecular
        | Aov::IndirectDiffuse
        | Aov::IndirectSpecular
        | Aov::Transmission
        | Aov::Volume
        | Aov::SampleCount
        | Aov::Cost
        | Aov::Bounces
        | Aov::Shadow
        | Aov::Variance
        | Aov::Denoising
        | Aov::Error
        | Aov::ObjectId
        | Aov::MaterialId
        | Aov::InstanceId
        | Aov::CryptoObject
        | Aov::CryptoMaterial
        | Aov::CryptoAsset => [0.0; 3],
    }
}

/// The label of a hit.
#[inline]
fn label(kind: LabelKind, scene: &Scene, hit: &Hit) -> u32 {
    match kind {
        LabelKind::Object => scene.primitive_id(hit),
        LabelKind::Material => scene.material_id_at(hit).0,
        LabelKind::Instance => scene.entry_of(scene.primitive_id(hit)),
    }
}

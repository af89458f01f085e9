//! AOVs of the first hits alone, eight samples at a time: see [`center_aovs`](crate::render::center_aovs).

use std::ops::Range;

use turner_bvh::lanes::{Block32, LANES, dispatch};

use super::first_hit::AovHit;
use super::lanes::{Points, is_in_lanes};
use super::light::finite;
use super::{find_surfaces, label, value};
use crate::camera::CameraFrame;
use crate::film::{Aov, LabelKind};
use crate::integrator::{CameraSamples, footprint};
use crate::scene::{Hit, Scene, SurfaceBlock};
use crate::view::View;

/// Computes AOVs of the first hits for blocks of eight samples. The values are those of [`SampleAovs`](super::SampleAovs).
pub(crate) struct SurfaceAovs<'a> {
    scene: &'a Scene,
    view: &'a View,
    frame: CameraFrame,
    /// The AOVs other than labels.
    aovs: Vec<Aov>,
    /// Whether all of them are computed in lanes.
    all_in_lanes: bool,
    surfaces: SurfaceBlock,
    /// For each AOV its channels at eight samples; the lanes of samples without a hit have any value.
    values: Vec<[Block32; 3]>,
}

impl<'a> SurfaceAovs<'a> {
    /// For the AOVs of a view's film; all must be properties of the first hit.
    pub(crate) fn new(scene: &'a Scene, view: &'a View) -> SurfaceAovs<'a> {
        let aovs: Vec<Aov> = view.film.aovs.iter().filter(|aov| aov.has_sums()).collect();
        let camera_moves = view.motion.is_some();
        SurfaceAovs {
            scene,
            view,
            frame: view.camera.frame(),
            all_in_lanes: aovs.iter().all(|aov| is_in_lanes(*aov, camera_moves)),
            values: vec![Default::default(); aovs.len()],
            aovs,
            surfaces: SurfaceBlock::default(),
        }
    }

    /// Computes the values of a block of up to eight samples from their first hits.
    pub(crate) fn compute(&mut self, samples: &CameraSamples, hits: &[Option<Hit>], block: Range<usize>) {
        if self.aovs.is_empty() {
            return;
        }
        let rays = &samples.rays;
        let flat = find_surfaces(self.scene, rays, hits, block.clone(), &mut self.surfaces);
        let points = Points {
            surfaces: &mut self.surfaces,
            flat,
            rays: &rays.blocks()[block.start / LANES],
            frame: &self.frame,
            aovs: &self.aovs,
            out: &mut self.values,
        };
        dispatch(self.scene.instruction_set, points);
        if !self.all_in_lanes {
            self.compute_singly(samples, hits, block);
        }
    }

    /// The AOVs that are not computed in lanes.
    fn compute_singly(&mut self, samples: &CameraSamples, hits: &[Option<Hit>], block: Range<usize>) {
        let camera_moves = self.view.motion.is_some();
        for (lane, i) in block.enumerate() {
            let (Some(Some(hit)), Some(ray)) = (hits.get(i), samples.rays.get(i)) else { continue };
            let is_filtered = self.view.pixel_cone.is_some();
            let at = AovHit {
                scene: self.scene,
                view: self.view,
                frame: &self.frame,
                ray,
                hit: *hit,
                p: self.surfaces.point(lane),
                ng: self.surfaces.normal(lane),
                ns: self.surfaces.shading_normal(lane),
                cone: is_filtered.then(|| footprint::of_camera(self.view, samples, i)),
            };
            for (aov, channels) in self.aovs.iter().zip(&mut self.values) {
                if !is_in_lanes(*aov, camera_moves) {
                    for (channel, v) in channels.iter_mut().zip(value(*aov, &at)) {
                        channel.0[lane] = v as f32;
                    }
                }
            }
        }
    }

    /// The channels of an AOV at the samples of the block, without infinities and NaN. AOVs are counted without labels.
    pub(crate) fn channel(&self, aov: usize, channel: usize) -> [f32; LANES] {
        self.values[aov][channel].0.map(finite)
    }

    /// The label of a hit.
    #[inline]
    pub(crate) fn label(&self, kind: LabelKind, hit: &Hit) -> u32 {
        label(kind, self.scene, hit)
    }
}

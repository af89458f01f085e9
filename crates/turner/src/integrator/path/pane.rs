//! Thin clear panes, which shadow rays pass: light behind a window is found by sampling it.
//!
//! What goes straight through a pane keeps its direction, so that a path through it is as before: the density of its direction and the place it was chosen
//! at stay those of the last real scattering, as where it passes a surface that is not wholly there. Both ways of finding a light then
//! see the same light through the same panes.

use super::path_batch::PathBatch;
use super::record::{End, Passage, Record};
use crate::bsdf::BsdfSample;
use crate::math::DVec3;
use crate::scene::SurfaceInteraction;

impl<R: Record> PathBatch<'_, R> {
    /// Goes straight on through a pane; the sample says with what weight.
    pub(super) fn pass(&mut self, sample: u32, surface: &SurfaceInteraction, wo: DVec3, s: &BsdfSample) {
        let path = &mut self.paths[sample as usize];
        path.beta = path.beta * s.f * (s.wi.z.abs() / s.pdf) as f32;
        path.from_camera = false;
        path.transparent += 1;
        self.record.note(|r| {
            r.any_nonspecular(-wo, s, 1.0, path.beta);
            r.at(|v| v.passage = Passage::Pane);
        });
        if path.transparent > self.settings.max_transparent {
            self.record.note(|r| r.end = End::Transparency);
        } else if !path.beta.is_black() {
            self.next.push(sample, surface, -wo);
        }
    }
}

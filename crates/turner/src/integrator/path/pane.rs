//! Thin clear panes. Shadow rays pass them, so light behind a window is found by sampling it.
//!
//! A path that goes straight through a pane keeps its direction, so its MIS state is unchanged: the density of the
//! direction and the receiver it was sampled at stay those of the last scattering event, as at a surface with a hole.
//! NEE and BSDF-sampled rays then see the same light through the same panes.
//!
//! ```text
//!  x (vertex) ---> pane ---> pane ---> light      beta *= transmission of each pane
//!     pdf, receiver of x stay valid
//! ```

use super::path_batch::PathBatch;
use super::record::{End, Passage, Record};
use crate::bsdf::BsdfSample;
use crate::material::Material;
use crate::math::DVec3;
use crate::scene::SurfaceInteraction;

impl<R: Record> PathBatch<'_, R> {
    /// Continues straight through a pane with the weight of the sample `s`.
    pub(super) fn pass(&mut self, sample: u32, surface: &SurfaceInteraction, wo: DVec3, s: &BsdfSample) {
        let path = &mut self.paths[sample as usize];
        path.beta = path.beta * s.f * (s.wi.z.abs() / s.pdf) as f32;
        path.from_camera = false;
        path.transparent += 1;
        self.record.note(|r| {
            r.scattered(-wo, s, 1.0, path.beta);
            r.at(|v| v.passage = Passage::Pane);
        });
        if path.transparent > self.settings.max_transparent {
            self.record.note(|r| r.end = End::Transparency);
        } else if !path.beta.is_black() {
            self.next.push(sample, surface, -wo);
        }
    }

    /// Continues straight through a hole: where a surface is transparent by alpha blending, or a mix has no material.
    pub(super) fn pass_hole(&mut self, sample: u32, surface: &SurfaceInteraction, direction: DVec3) {
        let path = &mut self.paths[sample as usize];
        path.transparent += 1;
        if let Material::OpenPbr(m) = self.scene.material_at(&surface.hit)
            && m.desc.interior.is_some()
        {
            path.media.pass(self.scene, surface, m, direction);
        }
        self.record.note(|r| r.at(|v| v.passage = Passage::Hole));
        if path.transparent <= self.settings.max_transparent {
            self.next.push(sample, surface, direction);
        } else {
            self.record.note(|r| r.end = End::Transparency);
        }
    }
}

//! Thin clear panes, which shadow rays cross without refraction.

use super::vertex::prepare;
use super::{MaterialEvalContext, OpenPbr};
use crate::color::Spectrum;
use crate::interaction::SurfaceInteraction;
use crate::math::{DVec3, Ray};

impl OpenPbr {
    /// Fraction of light that passes a crossing in `direction`: where the surface is transparent, and straight through
    /// a pane.
    pub(crate) fn shadow_tint(
        &self,
        scene: &impl MaterialEvalContext,
        surface: &SurfaceInteraction,
        direction: DVec3,
    ) -> Spectrum {
        let coverage = self.desc.coverage(scene, surface);
        let open = Spectrum::grey(1.0 - coverage);
        if !self.pane || coverage == 0.0 || self.desc.unlit {
            return open;
        }
        let Some(direction) = direction.try_normalize() else { return open };
        let outside = direction.dot(surface.ng) < 0.0;
        let made;
        let bsdf = match self.constant_bsdf(outside) {
            Some(bsdf) => bsdf,
            None => {
                made = self.bsdf(scene, surface, 1.0, outside);
                &made
            }
        };
        let ray = Ray::new(surface.p, direction);
        let vertex = prepare(scene, &ray, self, surface, bsdf, outside);
        open + vertex.straight() * coverage
    }
}

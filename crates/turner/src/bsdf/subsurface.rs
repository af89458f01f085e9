//! The way into a translucent body and out of it again: what the layers above let through, and nothing of what happens inside.
//!
//! Both boundaries are diffuse: light enters by the law of cosines, whatever its direction was, walks inside as if the boundary bent and reflected nothing, and
//! leaves by the law of cosines where it comes out (Chiang, Kutz & Burley 2016, "Practical and controllable subsurface scattering for production path tracing").
//! On both ways the layers take their share, symmetrically, as from any diffuse body: entering T(µo), leaving T(µi) / T̄, so that a body that returns all light
//! returns exactly what a white diffuse one would. The colours of a coat count by half on each way.

use super::albedo::AlbedoDirection;
use super::diffuse::sample_cosine;
use super::mixture::{Above, ENTER, LOBES, MIN_COSINE, REFLECT, Shares, choose};
use super::{Bsdf, BsdfFromWo, BsdfSample, Lobe, Rgb, spectrum};
use crate::color::Spectrum;
use crate::math::DVec3;
use std::f64::consts::PI;

/// A way into the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// The direction in the local frame, into the body: z < 0.
    pub wi: DVec3,
    /// What the path carries on, for what it carried before; without what the inside absorbs.
    pub weight: Spectrum,
    /// Probability that a sample enters.
    pub probability: f64,
}

impl Bsdf {
    /// Whether light that enters is left to a walk inside.
    #[inline]
    pub fn has_walk(&self) -> bool {
        self.diffuse.enter != Rgb::ZERO
    }

    /// What leaves the inside where a walk comes out, towards directions above the surface: diffuse, under the layers that are here. Sampled and evaluated
    /// like reflection from a white body, whatever the direction `wo` above the surface.
    pub fn leaving(&self) -> Bsdf {
        let mut out = *self;
        out.inside = false;
        out.coat_normal = None;
        out.diffuse.reflect = Rgb::ONE;
        out.diffuse.transmit = Rgb::ZERO;
        out.diffuse.enter = Rgb::ZERO;
        out.diffuse.share = 1.0;
        out.diffuse.roughness = 0.0;
        out.diffuse.through = out.diffuse_normalisation();
        out.lambert = out.is_lambert();
        out.leaves = !out.lambert;
        out
    }

    /// The factor of a coat's colour on one way out of two.
    fn tint_of_one_way(&self, above: &Above) -> Rgb {
        match &self.coat {
            Some(c) if above.way > 0.0 => {
                let both = c.tint(2.0 * above.way, true);
                Rgb::new(both.x.sqrt(), both.y.sqrt(), both.z.sqrt())
            }
            _ => Rgb::ONE,
        }
    }

    pub(super) fn seen_from_inside(&self, wo: DVec3) -> (Above, Shares) {
        let mut p = [0.0; LOBES];
        p[REFLECT] = 1.0;
        let w = AlbedoDirection::all(wo.z);
        (Above { w, coat: wo.z, fuzz: 1.0, through: 1.0, way: 0.0, body: 1.0 }, p)
    }

    /// f and density of what leaves.
    pub(super) fn what_leaves(&self, wi: DVec3) -> (Rgb, f64) {
        if wi.z <= MIN_COSINE {
            return (Rgb::ZERO, 0.0);
        }
        let i = self.above_on(AlbedoDirection::of(wi), false);
        let share = i.body / (self.diffuse.through * PI);
        (self.tint_of_one_way(&i) * share, wi.z / PI)
    }

    pub(super) fn sample_leaving(&self, u: [f64; 2]) -> Option<BsdfSample> {
        let wi = sample_cosine(u);
        let (f, pdf) = self.what_leaves(wi);
        let lobe = Lobe { is_delta: false, is_transmission: false, is_diffuse: true };
        (pdf > 0.0).then(|| BsdfSample { wi, f: spectrum(f), pdf, lobe, eta: 1.0 })
    }
}

impl BsdfFromWo<'_> {
    /// The way into the body, if the number that chooses among the lobes falls on it: [`BsdfFromWo::sample`] has no sample then.
    #[inline]
    pub fn enter(&self, u: [f64; 3]) -> Option<Entry> {
        if !self.bsdf.has_walk() { None } else { self.enter_body(u) }
    }

    fn enter_body(&self, u: [f64; 3]) -> Option<Entry> {
        let bsdf = self.bsdf;
        let probability = self.p[ENTER];
        if self.wo.z <= MIN_COSINE || choose(&self.p, u[0])?.0 != ENTER || probability <= 0.0 {
            return None;
        }
        let wi = sample_cosine([u[1], u[2]]);
        // Without its colour, which is that of the walk.
        let share = bsdf.diffuse.enter_share * self.above.body / probability;
        let weight = spectrum(bsdf.tint_of_one_way(&self.above) * share);
        let wi = bsdf.turned_back(DVec3::new(wi.x, wi.y, -wi.z));
        (wi.z < -MIN_COSINE).then_some(Entry { wi, weight, probability })
    }
}

//! Entry into a subsurface medium and exit from it: what the layers above let through. The walk inside is elsewhere.
//!
//! ```text
//!      wo                    wi
//!        \  coat, interface /          T(µo) on entry, T(µi) / T̄ on exit
//!   ------\----------------/------
//!          * cosine       * cosine     both crossings are diffuse
//!           \___ walk ___/
//! ```
//!
//! Light enters with a cosine distribution whatever its direction was, is scattered inside as if the surface neither
//! refracted nor reflected it, and leaves with a cosine distribution (Chiang, Kutz and Burley 2016, "Practical and
//! controllable subsurface scattering for production path tracing"). The layers attenuate both crossings as they do for
//! a diffuse lobe, so a medium that returns all light returns exactly what a white diffuse base would. Each crossing
//! takes the square root of the coat's colour.

use super::albedo::AlbedoDirection;
use super::diffuse::sample_cosine;
use super::mixture::{Above, ENTER, LOBES, LobeProbabilities, MIN_COSINE, REFLECT, choose};
use super::{Bsdf, BsdfFromWo, BsdfSample, Lobe, Rgb, spectrum};
use crate::color::Spectrum;
use crate::math::DVec3;
use std::f64::consts::PI;

/// A sampled entry into the medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// Direction into the medium, local: z < 0.
    pub wi: DVec3,
    /// Factor of the path throughput, without absorption inside.
    pub weight: Spectrum,
    /// Probability that a sample enters.
    pub probability: f64,
}

impl<'m> Bsdf<'m> {
    /// Whether light that enters is scattered by a random walk inside.
    #[inline]
    pub fn has_subsurface(&self) -> bool {
        self.diffuse.enter != Rgb::ZERO
    }

    /// The diffuse lobe where a walk exits, under the layers at that point, for directions above the surface. It is
    /// sampled and evaluated like reflection from a white diffuse base, whatever `wo` above the surface.
    pub fn leaving(&self) -> Bsdf<'m> {
        let mut out = *self;
        out.inside = false;
        out.coat_normal = None;
        out.diffuse.reflect = Rgb::ONE;
        out.diffuse.transmit = Rgb::ZERO;
        out.diffuse.enter = Rgb::ZERO;
        out.diffuse.weight = 1.0;
        out.diffuse.roughness = 0.0;
        out.diffuse.normalisation = out.diffuse_normalisation();
        out.lambert = out.is_lambert();
        out.glass_alone = false;
        out.exits = !out.lambert;
        out
    }

    /// Colour of the coat for one crossing out of two.
    fn one_way_tint(&self, above: &Above) -> Rgb {
        match &self.coat {
            Some(c) if above.path_length > 0.0 => {
                let two_way = c.tint(2.0 * above.path_length, true);
                Rgb::new(two_way.x.sqrt(), two_way.y.sqrt(), two_way.z.sqrt())
            }
            _ => Rgb::ONE,
        }
    }

    pub(super) fn prepare_exit(&self, wo: DVec3) -> (Above, LobeProbabilities) {
        let mut p = [0.0; LOBES];
        p[REFLECT] = 1.0;
        let w = AlbedoDirection::all(wo.z);
        (Above { w, coat: wo.z, fuzz: 1.0, through: 1.0, path_length: 0.0, diffuse: 1.0 }, p)
    }

    /// f and density of light that exits.
    pub(super) fn eval_exit(&self, wi: DVec3) -> (Rgb, f64) {
        if wi.z <= MIN_COSINE {
            return (Rgb::ZERO, 0.0);
        }
        let i = self.above_on(AlbedoDirection::of(wi), false);
        let scale = i.diffuse / (self.diffuse.normalisation * PI);
        (self.one_way_tint(&i) * scale, wi.z / PI)
    }

    pub(super) fn sample_exit(&self, u: [f64; 2]) -> Option<BsdfSample> {
        let wi = sample_cosine(u);
        let (f, pdf) = self.eval_exit(wi);
        let lobe = Lobe { is_delta: false, is_transmission: false, is_diffuse: true };
        (pdf > 0.0).then(|| BsdfSample { wi, f: spectrum(f), pdf, lobe, eta: 1.0 })
    }
}

impl BsdfFromWo<'_> {
    /// The entry, if `u[0]` selects the subsurface lobe; [`BsdfFromWo::sample`] returns no sample then.
    #[inline]
    pub fn enter(&self, u: [f64; 3]) -> Option<Entry> {
        if !self.bsdf.has_subsurface() { None } else { self.sample_entry(u) }
    }

    fn sample_entry(&self, u: [f64; 3]) -> Option<Entry> {
        let bsdf = self.bsdf;
        let probability = self.p[ENTER];
        if self.wo.z <= MIN_COSINE || choose(&self.p, u[0])?.0 != ENTER || probability <= 0.0 {
            return None;
        }
        let wi = sample_cosine([u[1], u[2]]);
        // Without the colour, which comes from the walk.
        let scale = bsdf.diffuse.enter_weight * self.above.diffuse / probability;
        let weight = spectrum(bsdf.one_way_tint(&self.above) * scale);
        let wi = bsdf.out_of_aniso_frame(DVec3::new(wi.x, wi.y, -wi.z));
        (wi.z < -MIN_COSINE).then_some(Entry { wi, weight, probability })
    }
}

//! A BSDF in parts, for renderers that treat diffuse, glossy and delta lobes apart.

use super::mixture::{COAT, ENTER, INTERFACE, PASS, REFLECT, TRANSMIT};
use super::{Bsdf, BsdfFromWo, BsdfSample, Rgb, spectrum};
use crate::color::Spectrum;
use crate::math::DVec3;

impl<'m> Bsdf<'m> {
    /// The BSDF with the light that would enter for a subsurface random walk reflected diffusely instead.
    pub(crate) fn without_walk(mut self) -> Bsdf<'m> {
        self.diffuse.reflect += self.diffuse.enter;
        self.diffuse.enter = Rgb::ZERO;
        self.diffuse.enter_weight = 0.0;
        self
    }

    /// Albedo of the diffuse base under all layers, reflected and transmitted.
    pub(crate) fn diffuse_albedos(&self) -> [Spectrum; 2] {
        [spectrum(self.diffuse.reflect), spectrum(self.diffuse.transmit)]
    }

    /// Whether any lobe is a delta lobe.
    pub(crate) fn has_delta(&self) -> bool {
        self.coat.as_ref().is_some_and(|c| c.smooth)
            || self.interface.as_ref().is_some_and(|i| i.smooth || i.straight)
    }

    /// Whether any lobe is neither diffuse nor a delta lobe.
    pub(crate) fn has_gloss(&self) -> bool {
        self.unlayered.is_some()
            || self.fuzz.is_some()
            || self.coat.as_ref().is_some_and(|c| !c.smooth)
            || self.interface.as_ref().is_some_and(|i| !i.smooth)
    }

    /// Roughness of the sharpest lobe that is neither diffuse nor a delta lobe; 1 without one.
    pub(crate) fn gloss_roughness(&self) -> f64 {
        if let Some(whole) = &self.unlayered {
            return whole.roughness();
        }
        let coat = self.coat.as_ref().filter(|c| !c.smooth).map_or(1.0, |c| c.facets.ax.min(c.facets.ay));
        let interface =
            self.interface.as_ref().filter(|i| !i.smooth).map_or(1.0, |i| i.facets.ax.min(i.facets.ay));
        coat.min(interface).min(1.0).sqrt()
    }
}

/// The most delta lobes of a BSDF: coat, reflection, refraction, straight through.
pub(crate) const MOST_DELTAS: usize = 4;

impl BsdfFromWo<'_> {
    /// The fraction of the BSDF for light from `wi`, on the side of wo, that is the diffuse base, band by band. Delta lobes do
    /// not count; 0 where the BSDF is 0.
    pub(crate) fn diffuse_fraction(&self, wi: DVec3) -> Spectrum {
        let bsdf = self.bsdf;
        if bsdf.lambert || bsdf.exits {
            return Spectrum::WHITE;
        }
        if bsdf.diffuse.reflect == Rgb::ZERO {
            return Spectrum::BLACK;
        }
        let wi = bsdf.in_aniso_frame(wi);
        let (whole, _) = bsdf.mixture(self.wo, wi, &self.above, &self.p, self.terminator.as_ref());
        let mut other = *bsdf;
        (other.diffuse.reflect, other.diffuse.transmit) = (Rgb::ZERO, Rgb::ZERO);
        let (other, _) = other.mixture(self.wo, wi, &self.above, &self.p, self.terminator.as_ref());
        let fraction =
            |c: usize| if whole[c] > 0.0 { (1.0 - other[c] / whole[c]).clamp(0.0, 1.0) } else { 0.0 };
        spectrum(Rgb::new(fraction(0), fraction(1), fraction(2)))
    }

    /// All delta lobes with pdf 1: f·|wi.z| is the fraction of light that each carries.
    pub(crate) fn deltas(&self) -> [Option<BsdfSample>; MOST_DELTAS] {
        let mut found = [None; MOST_DELTAS];
        let coat = self.bsdf.coat.as_ref().is_some_and(|c| c.smooth);
        let interface = self.bsdf.interface.as_ref().is_some_and(|i| i.smooth);
        let chosen =
            [(COAT, 0.0, coat), (INTERFACE, 0.0, interface), (INTERFACE, 1.0, interface), (PASS, 0.0, true)];
        for (found, (lobe, side, applies)) in found.iter_mut().zip(chosen) {
            if !applies || self.p[lobe] <= 0.0 {
                continue;
            }
            let Some(s) = self.sample([self.place(lobe, side), 0.5, 0.5]).filter(|s| s.lobe.is_delta) else {
                continue;
            };
            *found = Some(BsdfSample { pdf: 1.0, ..s });
        }
        // The interface has one lobe if it reflects, or transmits, all light.
        if let [_, Some(a), Some(b), _] = &found
            && a.lobe.is_transmission == b.lobe.is_transmission
        {
            found[2] = None;
        }
        found
    }

    /// The random number with which `sample` chooses a lobe, from its first to its last value.
    fn place(&self, lobe: usize, along: f64) -> f64 {
        let before: f64 = self.p[..lobe].iter().sum();
        before + self.p[lobe] * (1e-6 + (1.0 - 2e-6) * along)
    }

    /// The probability that `sample` chooses a diffuse lobe of the base.
    pub(crate) fn diffuse_probability(&self) -> f64 {
        self.p[REFLECT] + self.p[TRANSMIT] + self.p[ENTER]
    }

    /// Samples a lobe that is neither a delta lobe nor one of the diffuse base; `None` if there is none. The sample's pdf
    /// and f are those of all lobes.
    pub(crate) fn sample_gloss(&self, u: [f64; 3]) -> Option<BsdfSample> {
        if self.bsdf.unlayered.is_some() {
            return self.sample(u);
        }
        let is_gloss = |lobe: usize| match lobe {
            REFLECT | TRANSMIT | ENTER | PASS => false,
            COAT => self.bsdf.coat.as_ref().is_some_and(|c| !c.smooth),
            INTERFACE => self.bsdf.interface.as_ref().is_some_and(|i| !i.smooth),
            _ => true,
        };
        let all: f64 = (0..self.p.len()).filter(|lobe| is_gloss(*lobe)).map(|lobe| self.p[lobe]).sum();
        let mut left = u[0] * all;
        for lobe in (0..self.p.len()).filter(|lobe| is_gloss(*lobe)) {
            if left < self.p[lobe] {
                let along = left / self.p[lobe];
                return self.sample([self.place(lobe, along), u[1], u[2]]);
            }
            left -= self.p[lobe];
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::PrincipledPoint;

    #[test]
    fn the_diffuse_fraction_is_that_of_the_base() {
        let wo = DVec3::new(0.6, 0.0, 0.8);
        let base = PrincipledPoint { specular_roughness: 0.2, ..PrincipledPoint::default() };
        let fraction = |p: &PrincipledPoint, wi: DVec3| Bsdf::new(p).towards(wo).diffuse_fraction(wi).g;
        let (mirrored, aside) = (DVec3::new(-0.6, 0.0, 0.8), DVec3::new(0.8, 0.0, 0.6));
        // Plastic is glossy around the mirrored direction and diffuse aside.
        assert!(fraction(&base, mirrored) < 0.5 && fraction(&base, aside) > 0.9);
        let metal = PrincipledPoint { base_metalness: 1.0, ..base };
        assert_eq!(fraction(&metal, mirrored), 0.0);
        assert_eq!(Bsdf::lambert(Spectrum::WHITE).towards(wo).diffuse_fraction(aside), Spectrum::WHITE);
        // What is not diffuse is the surface with a black base, up to the light that the layers keep from it.
        let black = PrincipledPoint { base_color: Spectrum::BLACK, ..base };
        let (whole, other) = (Bsdf::new(&base).eval(wo, mirrored).g, Bsdf::new(&black).eval(wo, mirrored).g);
        assert!((fraction(&base, mirrored) - (1.0 - other / whole)).abs() < 0.01);
    }

    #[test]
    fn delta_lobes_of_glass_carry_all_light() {
        let p = PrincipledPoint {
            transmission_weight: 1.0,
            specular_roughness: 0.0,
            ..PrincipledPoint::default()
        };
        let bsdf = Bsdf::new(&p);
        let wo = DVec3::new(0.5, 0.0, 0.75f64.sqrt());
        let fraction = |s: BsdfSample| f64::from(s.f.g) * s.wi.z.abs() * s.eta * s.eta;
        let found = bsdf.towards(wo).deltas();
        let [reflected, transmitted] = [false, true].map(|crosses| {
            found
                .iter()
                .flatten()
                .filter(|s| s.lobe.is_transmission == crosses)
                .map(|s| fraction(*s))
                .sum::<f64>()
        });
        assert!((reflected + transmitted - 1.0).abs() < 1e-6, "{reflected} {transmitted}");
        assert!(reflected > 0.03 && reflected < 0.07, "{reflected}");
    }
}

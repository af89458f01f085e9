//! Thin smooth walls: light that passes straight through.

use super::albedo::AlbedoDirection;
use super::{Bsdf, spectrum};
use crate::color::Spectrum;
use crate::math::DVec3;

impl Bsdf<'_> {
    /// Fraction of light from behind that passes straight through a thin smooth wall towards `wo`, given in the
    /// anisotropy frame.
    pub(super) fn straight(&self, wo: DVec3) -> Spectrum {
        match &self.interface {
            Some(i) if self.thin && i.smooth && i.glass > 0.0 && wo.z > 0.0 => {
                let (above, mu) = (self.above_towards(wo, self.inside), wo.z.min(1.0));
                let behind = self.above_on(AlbedoDirection::all(mu), self.inside);
                spectrum(i.split(mu).1 * self.layers(&above, &behind, true))
            }
            _ => Spectrum::BLACK,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::PrincipledPoint;

    #[test]
    fn straight_samples_have_it_as_their_mean() {
        let pane = PrincipledPoint {
            transmission_weight: 1.0,
            specular_roughness: 0.0,
            transmission_color: Spectrum::new(0.9, 0.6, 0.3),
            thin_walled: true,
            ..PrincipledPoint::default()
        };
        let coated = PrincipledPoint {
            transmission_weight: 0.7,
            coat_weight: 0.6,
            coat_color: Spectrum::new(0.5, 0.9, 0.7),
            fuzz_weight: 0.2,
            subsurface_weight: 0.5,
            ..pane
        };
        for point in [pane, coated] {
            let bsdf = Bsdf::new(&point);
            for z in [1.0, 0.7, 0.2, 0.01f64] {
                let wo = DVec3::new((1.0 - z * z).sqrt(), 0.0, z);
                let (mut sum, n) = (Spectrum::BLACK, 20_000);
                for i in 0..n {
                    let u = (f64::from(i) + 0.5) / f64::from(n);
                    if let Some(s) = bsdf.sample(wo, [u, 0.3, 0.6])
                        && s.lobe.is_delta
                        && s.lobe.is_transmission
                    {
                        assert!((s.wi + wo).length() < 1e-12);
                        sum += s.f * (s.wi.z.abs() / s.pdf / f64::from(n)) as f32;
                    }
                }
                let off = (sum - bsdf.straight(wo)).map(f32::abs).max_component();
                assert!(off < 2e-4 && !sum.is_black(), "{z}: {sum:?} and {:?}", bsdf.straight(wo));
            }
        }
        assert!(Bsdf::new(&PrincipledPoint { thin_walled: false, ..pane }).straight(DVec3::Z).is_black());
        assert!(
            Bsdf::new(&PrincipledPoint { specular_roughness: 0.2, ..pane }).straight(DVec3::Z).is_black()
        );
    }
}

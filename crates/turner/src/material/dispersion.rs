//! Dispersion: indices of refraction by colour band.

use super::PrincipledMaterial;

/// Wavelengths in micrometres with the hue of the sRGB primaries: red, green, blue.
const BANDS: [f64; 3] = [0.6114, 0.5491, 0.4643];

/// Fraunhofer lines F, d and C in micrometres, which define the Abbe number V = (n_d − 1)/(n_F − n_C).
const F: f64 = 0.486_13;
const D: f64 = 0.587_56;
const C: f64 = 0.656_27;

/// The index of refraction of each colour band for an index `ior` at the d line and the Abbe number `abbe`, by Cauchy's
/// formula n(λ) = A + B/λ². An index of at least 1 stays at least 1.
fn cauchy(ior: f64, abbe: f64) -> [f64; 3] {
    let inverse2 = |l: f64| 1.0 / (l * l);
    let b = (ior - 1.0) / (abbe * (inverse2(F) - inverse2(C)));
    let (least, most) = if ior >= 1.0 { (1.0, 100.0) } else { (1e-3, 1.0) };
    BANDS.map(|l| (ior + b * (inverse2(l) - inverse2(D))).clamp(least, most))
}

impl PrincipledMaterial {
    /// The index of refraction of each colour band, if they differ and refract light.
    pub(super) fn dispersion(&self) -> Option<[f64; 3]> {
        let abbe = self.transmission_dispersion_abbe_number / self.transmission_dispersion_scale;
        let spreads = abbe > 0.0 && abbe < 1e6 && self.specular_ior > 0.0;
        (spreads && self.is_transmissive() && !self.thin_walled).then(|| cauchy(self.specular_ior, abbe))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flint_and_crown_match_published_indices() {
        // Schott's data: N-BK7 n_d 1.5168, V 64.17; SF11 n_d 1.78472, V 25.68. Indices at 546.07 and 632.8 nm of each.
        for (n, v, green, red) in [(1.5168, 64.17, 1.51872, 1.51509), (1.78472, 25.68, 1.79190, 1.77862)] {
            let [r, g, b] = cauchy(n, v);
            assert!(
                (g - green).abs() < 1e-3 && r - red > 0.0 && r - red < 4e-3 && b > g && g > r,
                "{r} {g} {b}"
            );
        }
        let wild = cauchy(1.5, 0.01);
        assert!(wild.iter().all(|n| (1.0..=100.0).contains(n)), "{wild:?}");
    }

    #[test]
    fn only_refracting_materials_disperse() {
        let glass = PrincipledMaterial {
            transmission_weight: crate::schema::ColorSource::Constant(crate::color::Spectrum::WHITE),
            transmission_dispersion_scale: 1.0,
            ..PrincipledMaterial::default()
        };
        assert!(glass.dispersion().is_some());
        assert!(PrincipledMaterial { thin_walled: true, ..glass.clone() }.dispersion().is_none());
        assert!(
            PrincipledMaterial { transmission_dispersion_scale: 0.0, ..glass.clone() }.dispersion().is_none()
        );
        assert!(
            PrincipledMaterial { transmission_dispersion_scale: f64::NAN, ..glass }.dispersion().is_none()
        );
    }
}

//! Approximation of a material's glossy lobe, for the selection of lights.

use super::{PrincipledMaterial, SpecularModel};
use crate::color::Spectrum;
use crate::math::DVec3;
use crate::schema::ColorSource;

/// The glossy lobe around the mirror direction, falling off like the GGX distribution (Walter et al. 2007, eq. 33).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GlossyLobe {
    /// The mirror direction, of length 1.
    pub axis: [f32; 3],
    /// 1/α².
    pub tightness: f32,
    /// Value of the lobe at its axis, relative to the diffuse reflection; 0 without a glossy lobe.
    pub peak: f32,
}

/// Stronger lobes are clamped to this: the diffuse part is negligible.
const STRONGEST: f32 = 1e4;

/// The glossy lobe of a material that only reflects, with constant roughness. An estimate: it affects the noise only.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Gloss {
    /// 1/α²; 0 without a lobe.
    tightness: f32,
    /// Strength relative to the diffuse reflection: at normal incidence, and what is added towards grazing angles.
    peak: f32,
    grazing: f32,
}

impl Gloss {
    /// The lobe of a material; none if its parameters are textured or it has more than one lobe over a diffuse base.
    pub(super) fn of(d: &PrincipledMaterial) -> Gloss {
        let constant = |source: ColorSource| match source {
            ColorSource::Constant(c) => Some(c.luminance()),
            ColorSource::Texture(_) => None,
        };
        let is_black = |source: ColorSource| source == ColorSource::Constant(Spectrum::BLACK);
        let one_lobe = !d.unlit
            && !d.is_transmissive()
            && is_black(d.coat_weight)
            && is_black(d.specular_roughness_anisotropy)
            && d.bump().is_none()
            && d.normal_map.is_none();
        let found = || {
            let (roughness, metal) = (constant(d.specular_roughness)?, constant(d.base_metalness)?);
            let specular = constant(d.specular_weight)?;
            let alpha = roughness * roughness;
            let alpha2 = alpha * alpha;
            let r = (d.specular_ior as f32 - 1.0) / (d.specular_ior as f32 + 1.0);
            let albedo = constant(d.base_color).unwrap_or(0.5) * constant(d.base_weight).unwrap_or(1.0);
            // f cos θ of the lobe on its axis, F / 4πα², over that of the diffuse base, albedo/π.
            let per_fresnel = 0.25 / (alpha2 * albedo * (1.0 - metal)).max(1e-9);
            let f0 = match d.specular_model {
                SpecularModel::OpenPbr => r * r,
                SpecularModel::Gltf => (r * r * constant(d.specular_color).unwrap_or(1.0)).min(1.0),
            };
            let straight = metal + (1.0 - metal) * specular * f0;
            let grazing = (1.0 - metal) * specular * (1.0 - f0);
            let lobe = Gloss {
                tightness: 1.0 / alpha2.max(1e-9),
                peak: (straight * per_fresnel).min(STRONGEST),
                grazing: (grazing * per_fresnel).min(STRONGEST),
            };
            (lobe.peak.is_finite() && lobe.grazing.is_finite()).then_some(lobe)
        };
        if one_lobe { found().unwrap_or_default() } else { Gloss::default() }
    }

    /// Whether the lobe leaves nothing to the diffuse base, as that of metal.
    #[inline]
    pub(crate) fn hides_base(&self) -> bool {
        self.peak >= STRONGEST
    }

    /// The lobe where a ray of this unit direction hits a surface with the shading normal `n`.
    #[inline]
    pub(crate) fn lobe(&self, direction: DVec3, n: DVec3) -> GlossyLobe {
        if self.tightness == 0.0 {
            return GlossyLobe::default();
        }
        let cosine = direction.dot(n);
        let axis = direction - 2.0 * cosine * n;
        let m = 1.0 - cosine.abs().min(1.0) as f32;
        let m2 = m * m;
        let peak = (self.peak + self.grazing * m2 * m2 * m).min(STRONGEST);
        GlossyLobe { axis: axis.as_vec3().to_array(), tightness: self.tightness, peak }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(v: f32) -> ColorSource {
        ColorSource::Constant(Spectrum::grey(v))
    }

    #[test]
    fn lobe_peaks_follow_the_reflectance() {
        let down = DVec3::NEG_Y;
        let lobe = |d: &PrincipledMaterial| Gloss::of(d).lobe(down, DVec3::Y);
        let metal = PrincipledMaterial {
            base_metalness: grey(1.0),
            specular_roughness: grey(0.5),
            ..PrincipledMaterial::default()
        };
        assert_eq!(lobe(&metal).peak, STRONGEST);
        assert!((lobe(&metal).tightness - 16.0).abs() < 1e-4);
        assert_eq!(lobe(&metal).axis, [0.0, 1.0, 0.0]);
        // F / 4α² over the diffuse albedo.
        let plastic = PrincipledMaterial {
            base_color: grey(0.5),
            specular_roughness: grey(0.5),
            ..PrincipledMaterial::default()
        };
        assert!((lobe(&plastic).peak - 0.04 / (4.0 * 0.0625 * 0.5)).abs() < 1e-3);
        // Stronger at grazing angles.
        let slanted = DVec3::new(1.0, -0.1, 0.0).normalize();
        assert!(Gloss::of(&plastic).lobe(slanted, DVec3::Y).peak > 5.0 * lobe(&plastic).peak);
        let glass = PrincipledMaterial { transmission_weight: grey(1.0), ..plastic.clone() };
        assert_eq!(lobe(&glass), GlossyLobe::default());
        let coated = PrincipledMaterial { coat_weight: grey(1.0), ..plastic };
        assert_eq!(lobe(&coated), GlossyLobe::default());
    }
}

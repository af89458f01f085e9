//! The classic material: one shading rule for five published descriptions of recursive ray tracing.

use super::{Bump, BumpUnit};
use crate::color::Spectrum;
use crate::math::elementary::{Exponent, exp, ln, pow};
use crate::schema::{ColorSource, Range, choice, params};

choice! {
    /// How reflection and refraction depend on the angle.
    pub enum Fresnel {
        /// Not at all: `k_reflect` and `k_refract` are the weights.
        Off = "off",
        /// Schlick's approximation of the Fresnel equations (Schlick 1994).
        Schlick = "schlick",
        /// The Fresnel equations for unpolarised light at an interface between dielectrics.
        Exact = "exact",
    }
}

choice! {
    /// The shadow that an object casts.
    pub enum ShadowKind {
        /// Blocks light.
        Opaque = "opaque",
        /// Each crossing of the surface transmits the fraction k_refract · colour.
        Tinted = "tinted",
        /// Casts no shadow.
        None = "none",
    }
}

params! {
    /// The material of the classic ray tracers. At a point of colour C,
    ///
    /// local = ka·Ia·C + Σ S·I·(kd·C·max(0, N·L) + ks·H·max(0, R·V)^shininess)
    ///
    /// and the ray's colour is k_local · local + k_reflect · reflected + k_refract · refracted. Ia is the ambient
    /// light, I a light's intensity, S the shadow term. H is white, or C with the integrator's `highlight =
    /// "material"`. The integrators "path" and "direct" convert it to an approximate "principled" material.
    pub struct ClassicMaterial as "classic" {
        /// The surface colour C.
        color: ColorSource = ColorSource::Constant(Spectrum::grey(0.8));
        /// Ambient reflection coefficient: 0 none, 1 all. The integrators "path" and "direct" ignore it.
        ka: f64 = 1.0, in Range::NON_NEGATIVE;
        /// Diffuse reflection coefficient: 0 none, 1 all.
        kd: f64 = 1.0, in Range::NON_NEGATIVE;
        /// Strength of the highlight.
        ks: f64 = 0.0, in Range::NON_NEGATIVE;
        /// Exponent of the highlight: larger values give a smaller and sharper highlight.
        shininess: f64 = 50.0, in Range::NON_NEGATIVE;
        /// Alternative to `ks` and `shininess`: strength 1 and exponent 10^(gloss + 1); 0 is no
        /// highlight.
        gloss: Option<f64> = None, in Range::closed(0.0, 8.0);
        /// Weight of the local colour. If not given, 1 − k_reflect − k_refract (or 1 with the integrator's `combine =
        /// "add"`).
        k_local: Option<f64> = None, in Range::NON_NEGATIVE;
        /// Weight of the reflected ray's colour.
        k_reflect: f64 = 0.0, in Range::NON_NEGATIVE;
        /// Weight of the refracted ray's colour.
        k_refract: f64 = 0.0, in Range::NON_NEGATIVE;
        /// Index of refraction inside, relative to outside.
        ior: f64 = 1.5, in Range::POSITIVE;
        /// Whether the angle divides light between reflection (k_reflect · F) and refraction (k_refract · (1 − F)).
        fresnel: Fresnel = Fresnel::Off;
        /// The shadow that the object casts.
        shadow: ShadowKind = ShadowKind::Opaque;
        /// Opacity for the alpha test: a number or a texture. Of a texture, the alpha of an image or vertex colour if
        /// it has one, otherwise the mean of the colour. Rays pass where the opacity is below `alpha_cutoff`.
        opacity: ColorSource = ColorSource::Constant(Spectrum::WHITE);
        /// Least opacity of an opaque point.
        alpha_cutoff: f64 = 0.5, in Range::closed(0.0, 1.0);
        /// Bump map: a texture of heights, white is high. It changes the shading normal, not the shape.
        bump_map: Option<ColorSource> = None;
        /// Height of white above black in scene units; negative inverts.
        bump_scale: f64 = 0.1;
    }
    example r#"[material.glass]
color = "white"
kd = 0
ka = 0
ks = 1
shininess = 400
k_reflect = 1
k_refract = 1
ior = 1.5
fresnel = "exact"
shadow = "tinted"

[[object]]
type = "sphere"
material = "glass"
"#
}

/// The prepared classic material.
#[derive(Clone, Copy, Debug)]
pub struct Classic {
    /// Surface colour.
    pub color: ColorSource,
    /// Ambient reflection coefficient.
    pub ka: f64,
    /// Diffuse reflection coefficient.
    pub kd: f64,
    /// Strength of the highlight, from `ks` or `gloss`.
    pub ks: f64,
    /// Exponent of the highlight.
    pub exponent: Exponent,
    /// Below this cosine the highlight underflows to 0 in single precision.
    pub dark: f64,
    /// Weight of the local colour, if given.
    pub k_local: Option<f64>,
    /// Weight of the reflected ray.
    pub k_reflect: f64,
    /// Weight of the refracted ray.
    pub k_refract: f64,
    /// Index of refraction inside, relative to outside.
    pub ior: f64,
    /// How the angle divides reflection and refraction.
    pub fresnel: Fresnel,
    /// The shadow it casts.
    pub shadow: ShadowKind,
    /// Its bump map.
    pub bump: Option<Bump>,
}

impl ClassicMaterial {
    /// Prepares the material.
    pub fn prepare(&self) -> Classic {
        let (ks, exponent) = self.highlight();
        Classic {
            color: self.color,
            ka: self.ka,
            kd: self.kd,
            ks,
            exponent: Exponent::new(exponent),
            dark: dark_cosine(ks, exponent),
            k_local: self.k_local,
            k_reflect: self.k_reflect,
            k_refract: self.k_refract,
            ior: self.ior,
            fresnel: self.fresnel,
            shadow: self.shadow,
            bump: Bump::new(self.bump_map, self.bump_scale, BumpUnit::Scene),
        }
    }

    /// Strength and exponent of the highlight.
    pub fn highlight(&self) -> (f64, f64) {
        match self.gloss {
            None => (self.ks, self.shininess),
            Some(gloss) if gloss > 0.0 => (1.0, pow(10.0, gloss + 1.0)),
            Some(_) => (0.0, 1.0),
        }
    }
}

/// A cosine c such that ks·x^exponent < 2^-180 for all 0 <= x < c; 0 if there is none. The smallest single-precision
/// number is 2^-149: the difference leaves room for rounding.
fn dark_cosine(ks: f64, exponent: f64) -> f64 {
    if !(ks > 0.0 && ks < f64::INFINITY && exponent > 0.0 && exponent < 1e10) {
        return 0.0;
    }
    const LN_2: f64 = std::f64::consts::LN_2;
    let cosine = exp((-180.0 * LN_2 - ln(ks)) / exponent);
    // Far from the ends of the range, the power of a rounding error stays small.
    if cosine > 1e-300 { cosine.min(1.0) } else { 0.0 }
}

impl Fresnel {
    /// Fraction of light reflected at the interface at `cos_i` (0..=1); `eta` is the index of refraction of the
    /// incident medium over the other. 1 beyond the critical angle.
    pub fn reflectance(self, cos_i: f64, eta: f64) -> f64 {
        let sin2_t = eta * eta * (1.0 - cos_i * cos_i).max(0.0);
        if sin2_t >= 1.0 {
            return 1.0;
        }
        let cos_t = (1.0 - sin2_t).sqrt();
        match self {
            Fresnel::Off => 0.0,
            Fresnel::Schlick => {
                let r0 = ((eta - 1.0) / (eta + 1.0)) * ((eta - 1.0) / (eta + 1.0));
                // On leaving the denser medium, Schlick's formula uses the angle in the thinner one.
                let c = 1.0 - if eta > 1.0 { cos_t } else { cos_i };
                r0 + (1.0 - r0) * c * c * c * c * c
            }
            Fresnel::Exact => {
                let s = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
                let p = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
                0.5 * (s * s + p * p)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fresnel_at_known_angles() {
        for f in [Fresnel::Schlick, Fresnel::Exact] {
            assert!((f.reflectance(1.0, 1.0 / 1.5) - 0.04).abs() < 1e-12);
            assert!((f.reflectance(1.0, 1.5) - 0.04).abs() < 1e-12);
            assert!((f.reflectance(0.0, 1.0 / 1.5) - 1.0).abs() < 1e-12);
            assert_eq!(f.reflectance(0.5, 1.5), 1.0);
        }
        // At Brewster's angle, tan θ = 1.5, parallel polarised light is not reflected: half of the perpendicular
        // reflectance remains.
        let cos_b = 1.0 / (1.0f64 + 2.25).sqrt();
        let s = (1.5 * 1.5 - 1.0) / (1.5 * 1.5 + 1.0);
        assert!((Fresnel::Exact.reflectance(cos_b, 1.0 / 1.5) - 0.5 * s * s).abs() < 1e-12);
    }

    #[test]
    fn gloss_is_the_papers_exponent() {
        let m = ClassicMaterial { gloss: Some(2.0), ..Default::default() };
        assert_eq!(m.highlight(), (1.0, 1000.0));
        assert_eq!(ClassicMaterial { gloss: Some(0.0), ..m }.highlight().0, 0.0);
    }
}

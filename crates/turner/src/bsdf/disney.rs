//! Disney's principled BSDF (Burley 2012, "Physically based shading at Disney"; Burley 2015, "Extending the Disney BRDF to
//! a BSDF with integrated subsurface scattering"), with the choices that Mitsuba 3 made:
//!
//! ```text
//!    wo   n   wi
//!      \  |  /        clearcoat   GTR1 facets of α 0.001 to 0.1, F₀ 0.04, a quarter of its weight
//!       \ | /         specular    GGX facets: metal by Schlick, dielectric by Fresnel or, tinted, by Schlick
//!   =====\|/======    diffuse     Burley's: darker or brighter towards grazing angles, by roughness; flattened; sheen
//!         |\          refraction  by the same facets
//! ```
//!
//! The lobes are added, not layered: grazing light may be reflected more than once. A thin wall has no refraction: what it
//! transmits keeps its direction, spread by narrower facets, or is diffuse.

use std::f64::consts::PI;

use super::diffuse::sample_cosine;
use super::facets::{FacetDistribution, FacetKind, FacetMasking, Facets};
use super::fresnel::{dielectric, refracted_cosine};
use super::mixture::{MIN_COSINE, choose};
use super::unlayered::Unlayered;
use super::{Bsdf, BsdfSample, Lobe, Rgb, color, spectrum, unit};
use crate::color::Spectrum;
use crate::math::elementary::{exp, ln, sin_cos_turns};
use crate::math::{DVec3, reflect};

/// The parameters at one point. Weights, colours and roughnesses are clamped to 0..=1; NaN counts as 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisneyPoint {
    /// Colour of diffuse reflection, of metal, and, as its root, of refraction.
    pub base_color: Spectrum,
    /// 0 is a dielectric, 1 a metal.
    pub metallic: f64,
    /// Roughness of all lobes but the clear coat; α of the facets is its square.
    pub roughness: f64,
    /// Elongation of highlights along the tangent (x).
    pub anisotropic: f64,
    /// Index of refraction inside over that outside.
    pub ior: f64,
    /// Fraction of the dielectric that refracts.
    pub spec_trans: f64,
    /// How much the base colour tints reflection by the dielectric.
    pub spec_tint: f64,
    /// Weight of the sheen.
    pub sheen: f64,
    /// How much the base colour tints the sheen.
    pub sheen_tint: f64,
    /// Weight of the clear coat.
    pub clearcoat: f64,
    /// 0 is a satin clear coat, 1 a glossy one.
    pub clearcoat_gloss: f64,
    /// Fraction of diffuse reflection that looks like subsurface scattering.
    pub flatness: f64,
    /// Fraction of the diffuse light that a thin wall transmits.
    pub diff_trans: f64,
    /// A thin wall.
    pub thin_walled: bool,
    /// Whether wo is inside the solid.
    pub inside: bool,
}

// Lobes, in the order of their probabilities.
/// Facets: reflection, and the refraction of solids.
const FACETS: usize = 0;
/// What a thin wall transmits by facets.
const THROUGH: usize = 1;
const COAT: usize = 2;
const REFLECT: usize = 3;
const TRANSMIT: usize = 4;
const LOBES: usize = 5;

/// Smallest α, as in Mitsuba: the lobes never become delta lobes.
const MIN_ALPHA: f64 = 1e-3;
/// α of the clear coat's masking.
const COAT_MASKING: f64 = 0.25;
const COAT_F0: f64 = 0.04;

/// The BSDF at a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Disney {
    base: Rgb,
    /// The base colour over its luminance.
    tint: Rgb,
    sheen: Rgb,
    metallic: f64,
    roughness: f64,
    spec_trans: f64,
    spec_tint: f64,
    flatness: f64,
    diff_trans: f64,
    clearcoat: f64,
    /// Squared α of the clear coat.
    coat_alpha2: f64,
    ior: f64,
    facets: Facets,
    /// The facets of what a thin wall transmits.
    narrow: Facets,
    thin: bool,
    inside: bool,
}

/// What the facets of a solid do with light at one cosine.
struct Split {
    reflected: Rgb,
    refracted: Rgb,
}

impl Split {
    /// The probability of reflection.
    fn share(&self) -> f64 {
        let (r, t) = (self.reflected.element_sum(), self.refracted.element_sum());
        if r + t > 0.0 { r / (r + t) } else { 1.0 }
    }
}

impl Disney {
    fn new(p: &DisneyPoint) -> Disney {
        let base = color(p.base_color);
        let luminance = f64::from(spectrum(base).luminance());
        let tint = if luminance > 0.0 { base / luminance } else { Rgb::ONE };
        let sheen_color = Rgb::ONE.lerp(tint, unit(p.sheen_tint));
        let ior = if p.ior.is_finite() { p.ior.clamp(1e-3, 100.0) } else { 1.5 };
        // Facets that change nothing have no directions.
        let ior = if (ior - 1.0).abs() < MIN_ALPHA { 1.0 + MIN_ALPHA } else { ior };
        let aspect = (1.0 - 0.9 * unit(p.anisotropic)).sqrt();
        let kind = FacetKind { distribution: FacetDistribution::Ggx, masking: FacetMasking::Separable };
        let facets = |roughness: f64| {
            let alpha = roughness * roughness;
            Facets { ax: (alpha / aspect).max(MIN_ALPHA), ay: (alpha * aspect).max(MIN_ALPHA), kind }
        };
        let roughness = unit(p.roughness);
        let coat_alpha = 0.1 + (0.001 - 0.1) * unit(p.clearcoat_gloss);
        let metallic = if p.thin_walled { 0.0 } else { unit(p.metallic) };
        let spec_trans = unit(p.spec_trans);
        let diff_trans = if p.thin_walled { unit(p.diff_trans) } else { 0.0 };
        let sheen_weight =
            if p.thin_walled { (1.0 - spec_trans) * (1.0 - diff_trans) } else { 1.0 - metallic };
        Disney {
            base,
            tint,
            sheen: sheen_color * (unit(p.sheen) * sheen_weight),
            metallic,
            roughness,
            spec_trans,
            spec_tint: unit(p.spec_tint),
            flatness: unit(p.flatness),
            diff_trans,
            clearcoat: if p.thin_walled { 0.0 } else { 0.25 * unit(p.clearcoat) },
            coat_alpha2: coat_alpha * coat_alpha,
            ior,
            facets: facets(roughness),
            narrow: facets((0.65 * ior - 0.35).max(0.0) * roughness),
            thin: p.thin_walled,
            inside: p.inside && !p.thin_walled,
        }
    }

    /// Index of refraction on the other side over that on wo's.
    fn eta(&self) -> f64 {
        if self.inside { 1.0 / self.ior } else { self.ior }
    }

    /// Fraction of the surface that refracts, of a solid.
    fn glass(&self) -> f64 {
        (1.0 - self.metallic) * self.spec_trans
    }

    /// Fraction that reflects diffusely.
    fn diffuse(&self) -> f64 {
        (1.0 - self.metallic) * (1.0 - self.spec_trans)
    }

    /// Reflectance of a dielectric at a cosine, with its tint.
    fn dielectric(&self, cos: f64) -> Rgb {
        let exact = dielectric(cos, self.eta());
        if self.spec_tint == 0.0 {
            return Rgb::splat(exact);
        }
        let r = (self.ior - 1.0) / (self.ior + 1.0);
        let tinted = schlick(self.tint * (r * r), self.bent(cos));
        Rgb::splat(exact).lerp(tinted, self.spec_tint)
    }

    /// The cosine for Schlick's approximation: that on the side of the lower index.
    fn bent(&self, cos: f64) -> f64 {
        if self.ior > 1.0 { cos } else { refracted_cosine(cos, self.ior).unwrap_or(0.0) }
    }

    /// What the facets of a solid do at the cosine to a facet.
    fn split(&self, cos: f64) -> Split {
        let exact = dielectric(cos, self.eta());
        let refracted = self.base.map(f64::sqrt) * (self.glass() * (1.0 - exact));
        if self.inside {
            return Split { reflected: Rgb::splat(self.glass() * exact), refracted };
        }
        let mut reflected = self.dielectric(cos) * (1.0 - self.metallic);
        if self.metallic > 0.0 {
            reflected += schlick(self.base, self.bent(cos)) * self.metallic;
        }
        Split { reflected, refracted }
    }

    /// Burley's diffuse reflection over albedo / π, and the sheen.
    fn diffuse_and_sheen(&self, wo: DVec3, wi: DVec3, h: DVec3) -> (f64, Rgb) {
        let (fo, fi) = (weight(wo.z), weight(wi.z));
        let across = h.dot(wi);
        let grazing = 2.0 * self.roughness * across * across;
        let base = (1.0 - 0.5 * fi) * (1.0 - 0.5 * fo);
        let retro = grazing * (fo + fi + fo * fi * (grazing - 1.0));
        let mut diffuse = base + retro;
        if self.flatness > 0.0 {
            let edge = 0.5 * grazing;
            let both = (1.0 + (edge - 1.0) * fo) * (1.0 + (edge - 1.0) * fi);
            let flat = 1.25 * (both * (1.0 / (wo.z + wi.z) - 0.5) + 0.5);
            diffuse += (flat - diffuse) * self.flatness;
        }
        (diffuse, self.sheen * weight(across))
    }

    /// GTR1, as the density of facets.
    fn coat_facets(&self, h: DVec3) -> f64 {
        let a2 = self.coat_alpha2;
        (a2 - 1.0) / (PI * ln(a2) * (1.0 + (a2 - 1.0) * h.z * h.z))
    }

    /// Probabilities of the lobes seen from `wo`; all 0 for a black surface.
    fn probabilities(&self, wo: DVec3) -> [f64; LOBES] {
        let mean = |c: Rgb| c.element_sum() / 3.0;
        let mu = wo.z.clamp(0.0, 1.0);
        let mut p = [0.0; LOBES];
        if self.thin {
            let reflected = mean(self.dielectric(mu));
            p[FACETS] = self.spec_trans * reflected;
            p[THROUGH] = self.spec_trans * mean(self.base) * (1.0 - dielectric(mu, self.ior));
            let diffuse = (1.0 - self.spec_trans) * mean(self.base);
            p[REFLECT] = diffuse * (1.0 - self.diff_trans) + 0.1 * mean(self.sheen);
            p[TRANSMIT] = diffuse * self.diff_trans;
        } else {
            let split = self.split(mu);
            p[FACETS] = mean(split.reflected + split.refracted);
            if !self.inside {
                // The lobe lacks the usual divisor of facets, 4 cos θo cos θi.
                p[COAT] = 4.0 * self.clearcoat * schlick(Rgb::splat(COAT_F0), mu).x * mu.max(0.1);
                p[REFLECT] = self.diffuse() * mean(self.base) + 0.1 * mean(self.sheen);
            }
        }
        let sum: f64 = p.iter().sum();
        let scale = if sum > 0.0 { 1.0 / sum } else { 0.0 };
        p.map(|p| p * scale)
    }

    /// f and pdf; `wo` is above the surface.
    pub(super) fn eval(&self, wo: DVec3, wi: DVec3) -> (Rgb, f64) {
        let p = self.probabilities(wo);
        if self.thin { self.eval_thin(wo, wi, &p) } else { self.eval_solid(wo, wi, &p) }
    }

    fn eval_solid(&self, wo: DVec3, wi: DVec3, p: &[f64; LOBES]) -> (Rgb, f64) {
        let eta = self.eta();
        let is_reflected = wi.z > 0.0;
        if !is_reflected && self.glass() == 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        let Some(h) = (if is_reflected { wo + wi } else { wo + wi * eta }).try_normalize() else {
            return (Rgb::ZERO, 0.0);
        };
        let h = if h.z < 0.0 { -h } else { h };
        let (ho, hi) = (wo.dot(h), wi.dot(h));
        if ho <= 0.0 || (hi > 0.0) != is_reflected {
            return (Rgb::ZERO, 0.0);
        }
        let split = self.split(ho);
        let (d, g1) = (self.facets.d(h), self.facets.g1(wo));
        let dg = d * self.facets.g2(wo, wi);
        let visible = p[FACETS] * d * g1 / wo.z;
        if !is_reflected {
            let bend = ho + eta * hi;
            let f = split.refracted * (dg * (ho * hi).abs() / (wo.z * -wi.z * bend * bend));
            return (f, visible * (1.0 - split.share()) * ho * eta * eta * -hi / (bend * bend));
        }
        let mut f = split.reflected * (dg / (4.0 * wo.z * wi.z));
        let mut pdf = visible * split.share() / 4.0;
        if !self.inside {
            let (diffuse, sheen) = self.diffuse_and_sheen(wo, wi, h);
            f += self.base * (self.diffuse() * diffuse / PI) + sheen;
            pdf += p[REFLECT] * wi.z / PI;
            if self.clearcoat > 0.0 {
                let masks = Facets::ggx(COAT_MASKING, COAT_MASKING);
                let d = self.coat_facets(h);
                let fresnel = schlick(Rgb::splat(COAT_F0), self.bent(ho)) * self.clearcoat;
                f += fresnel * (d * masks.g1(wo) * masks.g1(wi));
                pdf += p[COAT] * d * h.z / (4.0 * ho);
            }
        }
        (f, pdf)
    }

    fn eval_thin(&self, wo: DVec3, wi: DVec3, p: &[f64; LOBES]) -> (Rgb, f64) {
        let is_reflected = wi.z > 0.0;
        let mirrored = DVec3::new(wi.x, wi.y, wi.z.abs());
        let h = (wo + mirrored).normalize();
        let ho = wo.dot(h);
        let (mut f, mut pdf) = if is_reflected {
            let (diffuse, sheen) = self.diffuse_and_sheen(wo, wi, h);
            let weight = (1.0 - self.spec_trans) * (1.0 - self.diff_trans);
            (self.base * (weight * diffuse / PI) + sheen, p[REFLECT] * wi.z / PI)
        } else {
            let weight = (1.0 - self.spec_trans) * self.diff_trans;
            (self.base * (weight / PI), p[TRANSMIT] * -wi.z / PI)
        };
        let facets = if is_reflected { self.facets } else { self.narrow };
        // Facets transmit to the other side of theirs.
        if self.spec_trans > 0.0 && (is_reflected || wi.dot(h) < 0.0) {
            let color =
                if is_reflected { self.dielectric(ho) } else { self.base * (1.0 - dielectric(ho, self.ior)) };
            let d = facets.d(h);
            f += color * (self.spec_trans * d * facets.g2(wo, mirrored) / (4.0 * wo.z * mirrored.z));
            pdf += p[if is_reflected { FACETS } else { THROUGH }] * d * facets.g1(wo) / (4.0 * wo.z);
        }
        (f, pdf)
    }

    /// Samples one lobe.
    pub(super) fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        let p = self.probabilities(wo);
        let (lobe, u0) = choose(&p, u[0])?;
        let u12 = [u[1], u[2]];
        let mut eta = 1.0;
        let flipped = |w: DVec3| DVec3::new(w.x, w.y, -w.z);
        let wi = match lobe {
            REFLECT => sample_cosine(u12),
            TRANSMIT => flipped(sample_cosine(u12)),
            COAT => {
                let a2 = self.coat_alpha2;
                let cos2 = ((1.0 - exp((1.0 - u[2]) * ln(a2))) / (1.0 - a2)).clamp(0.0, 1.0);
                let (sin, cos) = sin_cos_turns(u[1]);
                let across = (1.0 - cos2).sqrt();
                reflect(-wo, DVec3::new(across * cos, across * sin, cos2.sqrt()))
            }
            THROUGH => {
                let h = self.narrow.sample_visible(wo, u12);
                let wi = flipped(reflect(-wo, h));
                if wi.z >= 0.0 || wi.dot(h) >= 0.0 {
                    return None;
                }
                wi
            }
            _ => {
                let h = self.facets.sample_visible(wo, u12);
                let ho = wo.dot(h);
                if self.thin || u0 < self.split(ho).share() {
                    let wi = reflect(-wo, h);
                    if wi.z <= 0.0 {
                        return None;
                    }
                    wi
                } else {
                    eta = self.eta();
                    let cos = refracted_cosine(ho, eta)?;
                    let wi = h * (ho / eta - cos) - wo / eta;
                    if wi.z >= 0.0 {
                        return None;
                    }
                    wi
                }
            }
        };
        if wi.z.is_nan() || wi.z.abs() <= MIN_COSINE || (lobe == COAT && wi.z < 0.0) {
            return None;
        }
        let (f, pdf) = if self.thin { self.eval_thin(wo, wi, &p) } else { self.eval_solid(wo, wi, &p) };
        let lobe = Lobe {
            is_delta: false,
            is_transmission: wi.z < 0.0,
            is_diffuse: matches!(lobe, REFLECT | TRANSMIT),
        };
        (pdf > 0.0 && pdf.is_finite()).then(|| BsdfSample { wi, f: spectrum(f), pdf, lobe, eta })
    }

    /// Approximate fraction of light from straight above that is scattered.
    pub(super) fn albedo(&self) -> Rgb {
        let split = self.split(1.0);
        let glass = if self.thin { Rgb::splat(self.spec_trans) } else { split.refracted };
        let diffuse = self.base * self.diffuse();
        if self.inside { split.reflected + glass } else { split.reflected + glass + diffuse }
    }

    /// Mean roughness of the lobes seen from straight above.
    pub(super) fn roughness(&self) -> f64 {
        let p = self.probabilities(DVec3::Z);
        let diffuse = p[REFLECT] + p[TRANSMIT];
        diffuse + (p[FACETS] + p[THROUGH]) * self.roughness + p[COAT] * self.coat_alpha2.sqrt().sqrt()
    }
}

impl Bsdf<'static> {
    /// Disney's principled BSDF.
    pub fn disney(p: &DisneyPoint) -> Bsdf<'static> {
        let mut bsdf = Bsdf::lambert(Spectrum::BLACK);
        bsdf.inside = p.inside && !p.thin_walled;
        bsdf.thin = p.thin_walled;
        bsdf.unlayered = Some(Unlayered::Disney(Disney::new(p)));
        bsdf
    }
}

/// (1 − µ)⁵.
fn weight(cos: f64) -> f64 {
    let c = (1.0 - cos).clamp(0.0, 1.0);
    c * c * c * c * c
}

/// Schlick's approximation of Fresnel reflectance.
fn schlick(f0: Rgb, cos: f64) -> Rgb {
    f0 + (Rgb::ONE - f0) * weight(cos)
}

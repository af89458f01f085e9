//! Single scattering at rough boundaries with microfacets: how much one reflection or refraction passes on.

use turner::bsdf::FacetDistribution;
use turner::color::Spectrum;
use turner::material::PrincipledMaterial;
use turner::math::DVec3;
use turner::math::elementary::{cos, erf, exp, ln, sin};
use turner::schema::ColorSource;

/// Microfacet normals per direction: this number squared. The results for Mitsuba depend on it.
const NORMALS: usize = 32;
/// The same for pbrt, whose results do not depend on it.
const FEW_NORMALS: usize = 16;
/// Boundaries with a smaller α are smooth.
const SMOOTH: f64 = 1e-3;

/// A boundary of microfacets with isotropic α, GGX unless it says otherwise. As in pbrt and Mitsuba, light meets one microfacet per reflection.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Microfacets {
    alpha: f64,
    /// Whether masking and shadowing are height-correlated (pbrt) or separable (Mitsuba), both after Smith.
    correlated: bool,
    distribution: FacetDistribution,
}

impl Microfacets {
    pub(crate) fn new(alpha: f64, correlated: bool) -> Microfacets {
        let distribution = FacetDistribution::Ggx;
        Microfacets { alpha: alpha.clamp(0.0, 1.0), correlated, distribution }
    }

    /// The same with another distribution.
    pub(crate) fn of(self, distribution: FacetDistribution) -> Microfacets {
        Microfacets { distribution, ..self }
    }

    /// The average of `f(wi, m)` over the microfacet normals `m` visible from a direction of cosine `mu` (Heitz
    /// 2018, "Sampling the GGX distribution of visible normals").
    pub(crate) fn mean(self, mu: f64, f: impl Fn(DVec3, DVec3) -> f64) -> f64 {
        let wi = incoming(mu);
        if self.alpha < SMOOTH {
            return f(wi, DVec3::Z);
        }
        let normals = if self.correlated { FEW_NORMALS } else { NORMALS };
        let place = |i: usize| (i as f64 + 0.5) / normals as f64;
        let (mut sum, mut weights) = (0.0, 0.0);
        for i in 0..normals {
            for j in 0..normals {
                let u = [place(i), place(j)];
                let (m, weight) = match self.distribution {
                    FacetDistribution::Ggx => (self.normal(wi, u), 1.0),
                    FacetDistribution::Beckmann => self.of_all_normals(wi, u),
                };
                if weight > 0.0 {
                    sum += weight * f(wi, m);
                    weights += weight;
                }
            }
        }
        if weights > 0.0 { sum / weights } else { 0.0 }
    }

    /// Samples a visible normal for a direction in the xz plane (Heitz 2018).
    pub(crate) fn normal(self, wi: DVec3, u: [f64; 2]) -> DVec3 {
        if self.alpha < SMOOTH {
            return DVec3::Z;
        }
        let vh = DVec3::new(self.alpha * wi.x, 0.0, wi.z).normalize();
        let (t1, t2) = (DVec3::Y, vh.cross(DVec3::Y));
        let (r, angle) = (u[0].sqrt(), std::f64::consts::TAU * u[1]);
        let (a, b) = (r * cos(angle), r * sin(angle));
        let s = 0.5 * (1.0 + vh.z);
        let b = (1.0 - s) * (1.0 - a * a).max(0.0).sqrt() + s * b;
        let n = t1 * a + t2 * b + vh * (1.0 - a * a - b * b).max(0.0).sqrt();
        DVec3::new(self.alpha * n.x, self.alpha * n.y, n.z.max(1e-9)).normalize()
    }

    /// A normal of Beckmann's distribution, whose slopes are normally distributed, and how much of it is seen from `wi`.
    fn of_all_normals(self, wi: DVec3, u: [f64; 2]) -> (DVec3, f64) {
        let slope = self.alpha * (-ln(1.0 - u[0])).sqrt();
        let angle = std::f64::consts::TAU * u[1];
        let m = DVec3::new(slope * cos(angle), slope * sin(angle), 1.0);
        (m.normalize(), wi.dot(m).max(0.0))
    }

    /// Fraction of the light from `wi` to `wo` by the facet `m` that other facets do not shadow; 0 if `wo`
    /// leaves on the wrong side.
    fn free(self, wi: DVec3, wo: DVec3, m: DVec3) -> f64 {
        if self.alpha < SMOOTH {
            return 1.0;
        }
        if wo.dot(m) * wo.z <= 0.0 {
            return 0.0;
        }
        let lambda = |w: DVec3| {
            let c2 = (w.z * w.z).max(1e-12);
            let slope2 = self.alpha * self.alpha * (1.0 - c2).max(0.0) / c2;
            match self.distribution {
                FacetDistribution::Ggx => 0.5 * ((1.0 + slope2).sqrt() - 1.0),
                FacetDistribution::Beckmann if slope2 < 1e-4 => 0.0,
                FacetDistribution::Beckmann => {
                    let a = 1.0 / slope2.sqrt();
                    0.5 * (exp(-a * a) / (a * std::f64::consts::PI.sqrt()) - 1.0 + erf(a)).max(0.0)
                }
            }
        };
        match self.correlated {
            true => (1.0 + lambda(wi)) / (1.0 + lambda(wi) + lambda(wo)),
            false => 1.0 / (1.0 + lambda(wo)),
        }
    }

    /// Fraction of the light from `wi` that a mirroring facet sends back, and the cosine of its direction.
    pub(crate) fn mirrored(self, wi: DVec3, m: DVec3) -> (f64, f64) {
        let wo = 2.0 * wi.dot(m) * m - wi;
        if wo.z > 0.0 { (self.free(wi, wo, m), wo.z) } else { (0.0, 1.0) }
    }

    /// The same for a dielectric facet; `eta` is the relative IOR of the far side.
    pub(crate) fn back(self, wi: DVec3, m: DVec3, eta: f64) -> (f64, f64) {
        let (share, mu) = self.mirrored(wi, m);
        (fresnel(wi.dot(m), eta).0 * share, mu)
    }

    /// Fraction of the light from `wi` that a dielectric facet transmits, and its cosine on the far side.
    pub(crate) fn through(self, wi: DVec3, m: DVec3, eta: f64) -> (f64, f64) {
        let d = wi.dot(m);
        let (f, t) = fresnel(d, eta);
        let wo = m * (d / eta - t) - wi / eta;
        if wo.z < 0.0 { ((1.0 - f) * self.free(wi, -wo, m), -wo.z) } else { (0.0, 1.0) }
    }
}

/// The direction of cosine `mu` in the xz plane.
pub(crate) fn incoming(mu: f64) -> DVec3 {
    DVec3::new((1.0 - mu * mu).max(0.0).sqrt(), 0.0, mu)
}

/// Fresnel reflectance of a dielectric for unpolarized light, and the cosine on the far side; `eta` is the
/// relative IOR of that side.
fn fresnel(c: f64, eta: f64) -> (f64, f64) {
    let c = c.clamp(0.0, 1.0);
    let s2 = (1.0 - c * c) / (eta * eta);
    if s2 >= 1.0 {
        return (1.0, 0.0);
    }
    let t = (1.0 - s2).sqrt();
    let (s, p) = ((c - eta * t) / (c + eta * t), (eta * c - t) / (eta * c + t));
    (0.5 * (s * s + p * p), t)
}

/// Turns multiple scattering off for rough metal and glass: renderers without it show them darker.
pub(crate) fn single_scattering(surface: &mut PrincipledMaterial) {
    let some = |source: ColorSource| source != ColorSource::Constant(Spectrum::BLACK);
    // A rough coat broadens what is below it.
    let rough =
        some(surface.specular_roughness) || (some(surface.coat_weight) && some(surface.coat_roughness));
    if rough && (some(surface.base_metalness) || some(surface.transmission_weight)) {
        surface.specular_multiple_scattering = false;
    }
}

//! Rough boundaries, by their microfacets (GGX): what one reflection or refraction makes of light.

use turner::color::Spectrum;
use turner::material::PrincipledMaterial;
use turner::math::DVec3;
use turner::math::elementary::{cos, sin};
use turner::schema::ColorSource;

/// Microfacet normals per direction are the square of this; Mitsuba's sums depend on it.
const NORMALS: usize = 32;
/// The same where nothing depends on it.
const FEW_NORMALS: usize = 16;
/// Boundaries narrower than this are smooth.
const SMOOTH: f64 = 1e-3;

/// Microfacets of a width, as a renderer counts them that follows light to one of them alone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Microfacets {
    alpha: f64,
    /// Whether heights along both directions go together (Smith's shadowing, as in pbrt); in Mitsuba each direction is shadowed for itself.
    correlated: bool,
}

impl Microfacets {
    pub(crate) fn new(alpha: f64, correlated: bool) -> Microfacets {
        Microfacets { alpha: alpha.clamp(0.0, 1.0), correlated }
    }

    /// The mean over the microfacets that are visible from a direction of cosine `mu` (Heitz, "Sampling the GGX distribution of visible normals", 2018).
    pub(crate) fn mean(self, mu: f64, f: impl Fn(DVec3, DVec3) -> f64) -> f64 {
        let wi = incoming(mu);
        if self.alpha < SMOOTH {
            return f(wi, DVec3::Z);
        }
        let normals = if self.correlated { FEW_NORMALS } else { NORMALS };
        let place = |i: usize| (i as f64 + 0.5) / normals as f64;
        let mut sum = 0.0;
        for i in 0..normals {
            for j in 0..normals {
                sum += f(wi, self.normal(wi, [place(i), place(j)]));
            }
        }
        sum / (normals * normals) as f64
    }

    /// The normal of a facet that is visible from a direction without y.
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

    /// Share of the light that a facet sends from `wi` to the upright side of `wo` which other facets do not catch.
    fn free(self, wi: DVec3, wo: DVec3, m: DVec3) -> f64 {
        if self.alpha < SMOOTH {
            return 1.0;
        }
        if wo.dot(m) * wo.z <= 0.0 {
            return 0.0;
        }
        let lambda = |w: DVec3| {
            let c2 = (w.z * w.z).max(1e-12);
            0.5 * ((1.0 + self.alpha * self.alpha * (1.0 - c2) / c2).sqrt() - 1.0)
        };
        match self.correlated {
            true => (1.0 + lambda(wi)) / (1.0 + lambda(wi) + lambda(wo)),
            false => 1.0 / (1.0 + lambda(wo)),
        }
    }

    /// Share of light from `wi` that a mirror's facet sends back, and the cosine of where it goes.
    pub(crate) fn mirrored(self, wi: DVec3, m: DVec3) -> (f64, f64) {
        let wo = 2.0 * wi.dot(m) * m - wi;
        if wo.z > 0.0 { (self.free(wi, wo, m), wo.z) } else { (0.0, 1.0) }
    }

    /// The same of a dielectric; `eta` is the index beyond over that here.
    pub(crate) fn back(self, wi: DVec3, m: DVec3, eta: f64) -> (f64, f64) {
        let (share, mu) = self.mirrored(wi, m);
        (fresnel(wi.dot(m), eta).0 * share, mu)
    }

    /// Share of light from `wi` that a facet lets through, and the cosine beyond.
    pub(crate) fn through(self, wi: DVec3, m: DVec3, eta: f64) -> (f64, f64) {
        let d = wi.dot(m);
        let (f, t) = fresnel(d, eta);
        let wo = m * (d / eta - t) - wi / eta;
        if wo.z < 0.0 { ((1.0 - f) * self.free(wi, -wo, m), -wo.z) } else { (0.0, 1.0) }
    }
}

/// The direction of a cosine that has no y.
pub(crate) fn incoming(mu: f64) -> DVec3 {
    DVec3::new((1.0 - mu * mu).max(0.0).sqrt(), 0.0, mu)
}

/// Fresnel's reflectance and the cosine beyond the boundary; `eta` is the index there over that here.
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

/// Makes rough metal and glass as dark as renderers show them that follow light to one microfacet alone.
pub(crate) fn single_scattering(surface: &mut PrincipledMaterial) {
    let some = |source: ColorSource| source != ColorSource::Constant(Spectrum::BLACK);
    // A rough coat makes what is below it rough.
    let rough =
        some(surface.specular_roughness) || (some(surface.coat_weight) && some(surface.coat_roughness));
    if rough && (some(surface.base_metalness) || some(surface.transmission_weight)) {
        surface.specular_multiple_scattering = false;
    }
}

//! Microfacets of a rough surface: the distribution of their normals, and how they mask one another.

use super::beckmann::Beckmann;
use super::microfacet::Ggx;
use super::{PrincipledPoint, unit};
use crate::math::DVec3;
use crate::schema::choice;

choice! {
    /// A distribution of microfacet normals.
    pub enum FacetDistribution {
        /// GGX (Trowbridge-Reitz): highlights with a long tail.
        Ggx = "ggx",
        /// Beckmann's: normally distributed slopes, highlights without a tail. α is √2 times their standard deviation.
        Beckmann = "beckmann",
    }
}

choice! {
    /// How masking (of the outgoing light) and shadowing (of the incoming light) of microfacets combine.
    pub enum FacetMasking {
        /// Height-correlated (Heitz 2014): higher facets are less masked and less shadowed.
        Correlated = "correlated",
        /// Independent, as in Walter et al. 2007 and in Mitsuba: a little darker at grazing angles.
        Separable = "separable",
    }
}

/// What microfacets are like, without their widths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FacetKind {
    pub(super) distribution: FacetDistribution,
    pub(super) masking: FacetMasking,
}

impl FacetKind {
    /// The kind whose albedos are tabulated with code for eight lanes.
    pub(super) const PLAIN: FacetKind =
        FacetKind { distribution: FacetDistribution::Ggx, masking: FacetMasking::Correlated };
}

/// Microfacets with widths α along x and y, each greater than 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Facets {
    /// Along the tangent.
    pub(super) ax: f64,
    /// Along the bitangent.
    pub(super) ay: f64,
    pub(super) kind: FacetKind,
}

impl Facets {
    /// GGX with height-correlated masking.
    pub(super) fn ggx(ax: f64, ay: f64) -> Facets {
        Facets { ax, ay, kind: FacetKind::PLAIN }
    }

    fn as_ggx(self) -> Ggx {
        Ggx { ax: self.ax, ay: self.ay }
    }

    fn as_beckmann(self) -> Beckmann {
        Beckmann { ax: self.ax, ay: self.ay }
    }

    /// Facet area per unit of surface area and solid angle around `h` (upper hemisphere): ∫ D cos θ = 1.
    #[inline]
    pub(super) fn d(self, h: DVec3) -> f64 {
        match self.kind.distribution {
            FacetDistribution::Ggx => self.as_ggx().d(h),
            FacetDistribution::Beckmann => self.as_beckmann().d(h),
        }
    }

    /// Smith's Λ of a direction: invisible over visible facet area.
    #[inline]
    pub(super) fn lambda(self, w: DVec3) -> f64 {
        match self.kind.distribution {
            FacetDistribution::Ggx => self.as_ggx().lambda(w),
            FacetDistribution::Beckmann => self.as_beckmann().lambda(w),
        }
    }

    /// Fraction of the facets facing `w` that are visible from there.
    pub(super) fn g1(self, w: DVec3) -> f64 {
        1.0 / (1.0 + self.lambda(w))
    }

    /// The reciprocal of the fraction visible from both directions on one side, by their Λ.
    #[inline]
    pub(super) fn masking(self, lo: f64, li: f64) -> f64 {
        match self.kind.masking {
            FacetMasking::Correlated => 1.0 + lo + li,
            FacetMasking::Separable => (1.0 + lo) * (1.0 + li),
        }
    }

    /// Fraction visible from both directions on one side.
    pub(super) fn g2(self, wo: DVec3, wi: DVec3) -> f64 {
        1.0 / self.masking(self.lambda(wo), self.lambda(wi))
    }

    /// A normal sampled from those visible from `wo` (wo.z > 0). `u` in 0..1.
    #[inline]
    pub(super) fn sample_visible(self, wo: DVec3, u: [f64; 2]) -> DVec3 {
        match self.kind.distribution {
            FacetDistribution::Ggx => self.as_ggx().sample_visible(wo, u),
            FacetDistribution::Beckmann => self.as_beckmann().sample_visible(wo, u),
        }
    }
}

/// α along x and y, increased by a rough coat (OpenPBR).
pub(super) fn widths(p: &PrincipledPoint, coat: f64, coat_alpha: f64) -> (f64, f64) {
    let (x, y) = match p.alpha {
        Some((x, y)) => (unit(x), unit(y)),
        None => {
            let roughness = unit(p.specular_roughness);
            let across = 1.0 - unit(p.specular_roughness_anisotropy);
            let x = roughness * roughness * (2.0 / (1.0 + across * across)).sqrt();
            (x.min(1.0), x * across)
        }
    };
    let roughened = |a: f64| {
        let both = (a * a + 2.0 * coat_alpha * coat_alpha).min(1.0).sqrt();
        let r = a.sqrt();
        let r = r + (both.sqrt() - r) * coat;
        r * r
    };
    if coat > 0.0 && coat_alpha > 0.0 { (roughened(x), roughened(y)) } else { (x, y) }
}

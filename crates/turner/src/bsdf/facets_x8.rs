//! Isotropic microfacets of eight lanes, with the bits of [`Facets`].

use std::f64::consts::PI;

use turner_bvh::lanes::{Block, F64x8, Mask8, Simd, Vec3x8};

use super::beckmann_x8::BeckmannX8;
use super::facets::{FacetDistribution, FacetMasking, Facets};
use crate::math::block::set_bit;
use crate::math::elementary_x8::sin_cos_turns;

/// Microfacets with one width per lane.
#[derive(Clone, Debug, Default)]
pub(super) struct FacetBlock {
    alpha: Block,
    /// Masks: Beckmann's distribution instead of GGX; separable masking and shadowing.
    beckmann: u8,
    separable: u8,
}

impl FacetBlock {
    /// Stores isotropic facets in a lane.
    pub(super) fn set(&mut self, lane: usize, facets: &Facets) {
        self.alpha.0[lane] = facets.ax;
        set_bit(&mut self.beckmann, lane, facets.kind.distribution == FacetDistribution::Beckmann);
        set_bit(&mut self.separable, lane, facets.kind.masking == FacetMasking::Separable);
    }

    /// Applies functions to all numbers and masks.
    #[inline]
    pub(super) fn combine(
        &mut self,
        other: &FacetBlock,
        number: impl Fn(&mut Block, &Block),
        mask: impl Fn(&mut u8, u8),
    ) {
        number(&mut self.alpha, &other.alpha);
        mask(&mut self.beckmann, other.beckmann);
        mask(&mut self.separable, other.separable);
    }

    /// The width α of a lane.
    pub(super) fn alpha(&self, lane: usize) -> f64 {
        self.alpha.0[lane]
    }

    /// See [`Facets::d`].
    #[inline(always)]
    pub(super) fn d<S: Simd>(&self, simd: S, h: Vec3x8<S>) -> F64x8<S> {
        let splat = |v: f64| F64x8::splat(simd, v);
        let (one, pi) = (splat(1.0), splat(PI));
        let a = F64x8::load(simd, &self.alpha);
        let (x, y) = (h.x / a, h.y / a);
        let s = x * x + y * y + h.z * h.z;
        let ggx = one / (pi * a * a * s * s);
        if self.beckmann == 0 {
            return ggx;
        }
        let d = BeckmannX8 { a }.d(simd, h);
        Mask8::new(simd, self.beckmann).select(d, ggx)
    }

    /// See [`Facets::lambda`].
    #[inline(always)]
    pub(super) fn lambda<S: Simd>(&self, simd: S, w: Vec3x8<S>) -> F64x8<S> {
        let splat = |v: f64| F64x8::splat(simd, v);
        let one = splat(1.0);
        let a = F64x8::load(simd, &self.alpha);
        let (x, y) = (a * w.x, a * w.y);
        let t2 = (x * x + y * y) / (w.z * w.z);
        let ggx = splat(0.5) * ((one + t2).sqrt() - one);
        if self.beckmann == 0 {
            return ggx;
        }
        Mask8::new(simd, self.beckmann).select(BeckmannX8 { a }.lambda(simd, w), ggx)
    }

    /// See [`Facets::masking`].
    #[inline(always)]
    pub(super) fn masking<S: Simd>(&self, simd: S, lo: F64x8<S>, li: F64x8<S>) -> F64x8<S> {
        let one = F64x8::splat(simd, 1.0);
        let correlated = one + lo + li;
        Mask8::new(simd, self.separable).select((one + lo) * (one + li), correlated)
    }

    /// Facets of some lanes that are visible from `wo`; see [`Facets::sample_visible`].
    #[inline(always)]
    pub(super) fn sample_visible<S: Simd>(
        &self,
        simd: S,
        lanes: Mask8<S>,
        wo: Vec3x8<S>,
        u: [F64x8<S>; 2],
    ) -> Vec3x8<S> {
        let splat = |v: f64| F64x8::splat(simd, v);
        let (zero, one) = (splat(0.0), splat(1.0));
        let a = F64x8::load(simd, &self.alpha);
        let stretched = Vec3x8 { x: a * wo.x, y: a * wo.y, z: wo.z };
        let stretched = stretched * (one / stretched.dot(stretched).sqrt());
        let z = (one - u[0]) * (one + stretched.z) - stretched.z;
        let r = (one - z * z).or_larger(zero).sqrt();
        let (sin, cos) = sin_cos_turns(simd, u[1]);
        let cap = Vec3x8 { x: r * cos, y: r * sin, z } + stretched;
        let h = Vec3x8 { x: a * cap.x, y: a * cap.y, z: cap.z.or_larger(zero) };
        let length = h.dot(h).sqrt();
        let up = Vec3x8::splat(simd, [0.0, 0.0, 1.0]);
        let unit = Vec3x8 { x: h.x / length, y: h.y / length, z: h.z / length };
        let ggx = Vec3x8::select(length.gt(zero), unit, up);
        let beckmann = lanes & Mask8::new(simd, self.beckmann);
        if !beckmann.any() {
            return ggx;
        }
        Vec3x8::select(beckmann, BeckmannX8 { a }.sample_visible(simd, beckmann, wo, u), ggx)
    }
}

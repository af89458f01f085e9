//! Fresnel reflectance of dielectrics for eight lanes, with the bits of the scalar function.

use turner_bvh::lanes::{F64x8, Simd};

use crate::math::elementary_x8::{clamp, is_finite};

/// As [`dielectric`](super::fresnel::dielectric).
#[inline(always)]
pub(super) fn dielectric<S: Simd>(simd: S, cos: F64x8<S>, eta: F64x8<S>) -> F64x8<S> {
    let splat = |v: f64| F64x8::splat(simd, v);
    let (zero, one) = (splat(0.0), splat(1.0));
    let cos = clamp(cos, zero, one);
    let sin2 = (one - cos * cos).or_larger(zero) / (eta * eta);
    let cos_t = (one - sin2).sqrt();
    let s = (cos - eta * cos_t) / (cos + eta * cos_t);
    let p = (eta * cos - cos_t) / (eta * cos + cos_t);
    let partial = sin2.lt(one) & is_finite(simd, s) & is_finite(simd, p);
    let reflected = partial.select(splat(0.5) * (s * s + p * p), one);
    let reflected = eta.eq(splat(f64::INFINITY)).select(one, reflected);
    eta.eq(one).select(zero, reflected)
}

//! Fresnel reflectance for eight lanes, with the bits of the scalar functions.

use turner_bvh::lanes::{F64x8, Simd, Vec3x8};

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

/// As [`conductor`](super::fresnel::conductor).
#[inline(always)]
fn conductor<S: Simd>(simd: S, cos: F64x8<S>, eta: F64x8<S>, k: F64x8<S>) -> F64x8<S> {
    let splat = |v: f64| F64x8::splat(simd, v);
    let (zero, one, half, two, four) = (splat(0.0), splat(1.0), splat(0.5), splat(2.0), splat(4.0));
    let cos2 = cos * cos;
    let sin2 = one - cos2;
    let real = eta * eta - k * k - sin2;
    let a2b2 = (real * real + four * (eta * eta) * (k * k)).sqrt();
    let a = (half * (a2b2 + real)).or_larger(zero).sqrt();
    let (sum, cross) = (a2b2 + cos2, two * a * cos);
    let s = (sum - cross) / (sum + cross);
    let (sum, cross) = (cos2 * a2b2 + sin2 * sin2, cross * sin2);
    let p = s * (sum - cross) / (sum + cross);
    let f = half * (s + p);
    is_finite(simd, f).select(clamp(f, zero, one), one)
}

/// The reflectance of conductors with η and k in three bands, times a colour.
#[inline(always)]
pub(super) fn conductors<S: Simd>(
    simd: S,
    cos: F64x8<S>,
    [eta, k]: [Vec3x8<S>; 2],
    color: Vec3x8<S>,
) -> Vec3x8<S> {
    Vec3x8 {
        x: conductor(simd, cos, eta.x, k.x) * color.x,
        y: conductor(simd, cos, eta.y, k.y) * color.y,
        z: conductor(simd, cos, eta.z, k.z) * color.z,
    }
}

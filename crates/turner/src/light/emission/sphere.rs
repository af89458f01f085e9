//! Emissive spheres, sampled by solid angle from outside and by area from inside.
//!
//! ```text
//!              ___                 sin θmax = r / d
//!       w   / q   \                cap = 1 − cos θmax
//!   p ---- *       |               solid angle = 2π · cap, pdf = 1 / (2π · cap)
//!       θ   \ ___ /  r             w is uniform in the cone; q is the nearer hit of w with the sphere
//!   |------ d ---|
//! ```

use std::f64::consts::{PI, TAU};

use turner_bvh::InstructionSet;
use turner_bvh::lanes::{F64x8, LANES, Simd, Vec3x8, Work, dispatch};

use super::block::{Eight, EmitterBlock};
use super::{EmitterSample, per_solid_angle};
use crate::math::elementary::sin_cos_turns;
use crate::math::{DVec3, Frame, elementary_x8 as x8};
use crate::sampler::uniform_sphere;

/// A sphere. From outside, its cone of directions is sampled uniformly (Shirley et al. 1996, "Monte Carlo techniques
/// for direct lighting calculations"); from inside, its area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereEmitter {
    /// The centre.
    pub center: DVec3,
    /// The radius.
    pub radius: f64,
}

impl SphereEmitter {
    /// 1 − cos of the cone's half angle; `None` from inside or too close to tell.
    #[inline]
    fn cap(&self, distance2: f64) -> Option<f64> {
        let sin2 = self.radius * self.radius / distance2;
        (sin2 < 1.0 - 1e-9).then(|| sin2 / (1.0 + (1.0 - sin2).sqrt()))
    }

    /// The point that `u` chooses, seen from `p`.
    pub fn sample(&self, p: DVec3, u: [f64; 2]) -> Option<EmitterSample> {
        let to_center = self.center - p;
        let d2 = to_center.length_squared();
        let Some(cap) = self.cap(d2) else {
            let n = uniform_sphere(u.into());
            let q = self.center + self.radius * n;
            let pdf = per_solid_angle(self.per_area(), p, q, n)?;
            return Some(EmitterSample { q, n, u: 0.0, v: 0.0, pdf });
        };
        let d = d2.sqrt();
        let x = u[0] * cap;
        let (cos, sin2) = (1.0 - x, x * (2.0 - x));
        let (s, c) = sin_cos_turns(u[1]);
        let sin = sin2.sqrt();
        let w = Frame::from_z(to_center / d).to_world(DVec3::new(sin * c, sin * s, cos));
        let t = d * cos - (self.radius * self.radius - d2 * sin2).max(0.0).sqrt();
        let n = (p + t * w - self.center).try_normalize()?;
        let pdf = 1.0 / (TAU * cap);
        Some(EmitterSample { q: self.center + self.radius * n, n, u: 0.0, v: 0.0, pdf })
    }

    /// `sample` for the eight lanes of a block; the emitters may all be the same one.
    #[inline]
    pub fn sample_block(set: InstructionSet, emitters: [&SphereEmitter; LANES], block: &mut EmitterBlock) {
        let mut scalar_lanes = dispatch(set, SampleBlock { emitters: Eight::new(emitters), block });
        while scalar_lanes != 0 {
            let lane = scalar_lanes.trailing_zeros() as usize;
            scalar_lanes &= scalar_lanes - 1;
            block.store_one(lane, emitters[lane].sample(block.lit(lane), block.random_pair(lane)));
        }
    }

    /// The pdf of the direction from `p` to the point `q` on it, where the normal is `n`.
    pub fn pdf(&self, p: DVec3, q: DVec3, n: DVec3) -> f64 {
        match self.cap(p.distance_squared(self.center)) {
            Some(cap) => 1.0 / (TAU * cap),
            None => per_solid_angle(self.per_area(), p, q, n).unwrap_or(0.0),
        }
    }

    fn per_area(&self) -> f64 {
        1.0 / self.area()
    }

    /// Its area.
    pub fn area(&self) -> f64 {
        4.0 * PI * self.radius * self.radius
    }
}

struct SampleBlock<'a> {
    emitters: Eight<'a, SphereEmitter>,
    block: &'a mut EmitterBlock,
}

impl Work for SampleBlock<'_> {
    /// The lanes whose points are not outside their spheres.
    type Output = u8;

    /// As [`SphereEmitter::sample`] from outside, operation by operation.
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> u8 {
        let SampleBlock { emitters: e, block } = self;
        let splat = |v: f64| F64x8::splat(simd, v);
        let (zero, one, two) = (splat(0.0), splat(1.0), splat(2.0));
        let (p, [u0, u1]) = block.inputs(simd);
        let (center, radius) = (e.vector(simd, |e| e.center), e.scalar(simd, |e| e.radius));
        let r2 = radius * radius;
        let to_center = center - p;
        let d2 = to_center.dot(to_center);
        let fills2 = r2 / d2;
        let outside = fills2.lt(splat(1.0 - 1e-9));
        let cap = fills2 / (one + (one - fills2).sqrt());
        let d = d2.sqrt();
        let x = u0 * cap;
        let (cos, sin2) = (one - x, x * (two - x));
        let (s, c) = x8::sin_cos_turns(simd, u1);
        let sin = sin2.sqrt();
        let z = Vec3x8 { x: to_center.x / d, y: to_center.y / d, z: to_center.z / d };
        // As `Frame::from_z`.
        let sign = one.copysign(z.z);
        let a = -one / (sign + z.z);
        let b = z.x * z.y * a;
        let x_axis = Vec3x8 { x: one + sign * z.x * z.x * a, y: sign * b, z: -sign * z.x };
        let y_axis = Vec3x8 { x: b, y: sign + z.y * z.y * a, z: -z.y };
        let w = x_axis * (sin * c) + y_axis * (sin * s) + z * cos;
        let t = d * cos - (r2 - d2 * sin2).or_larger(zero).sqrt();
        let from_center = p + w * t - center;
        // As `try_normalize`.
        let inv = one / from_center.dot(from_center).sqrt();
        let n = from_center * inv;
        let known = outside & inv.gt(zero) & inv.lt(splat(f64::INFINITY));
        let pdf = one / (splat(TAU) * cap);
        block.store(known.bits(), center + n * radius, n, [zero, zero], pdf);
        !outside.bits()
    }
}

//! Emissive rectangles and parallelograms, sampled by solid angle or by area.
//!
//! Method: Ureña et al. 2013, "An area-preserving parametrization for spherical rectangles". The rectangle is
//! projected onto the unit sphere around p, and the spherical rectangle is sampled uniformly in two steps that
//! preserve area:
//!
//! ```text
//!         y1 +--------+--------+         1. u[0] chooses xu so that the part of the spherical rectangle
//!            |        |        |            left of it has u[0] of the solid angle;
//!            |        |* yv    |         2. u[1] chooses yv on the line x = xu: the sine of the elevation
//!         y0 +--------+--------+            is linear in u[1].
//!           x0       xu       x1
//!                                        Coordinates are relative to p, the rectangle is at z = z0 < 0.
//!                p (0, 0, 0)             Ω = sum of the corner angles − 2π
//! ```
//!
//! The pdf is the constant 1/Ω. Parallelograms without right angles, and far or nearly edge-on rectangles, are
//! sampled by area.

use std::f64::consts::PI;

use turner_bvh::InstructionSet;
use turner_bvh::lanes::{F64x8, LANES, Simd, Vec3x8, Work, dispatch};

use super::block::{self, Eight, EmitterBlock};
use super::{EmitterSample, MAX_SOLID_ANGLE, NEAR, per_solid_angle};
use crate::light::LightBound;
use crate::math::elementary::{arc_cosine, sin_cos_turns};
use crate::math::{DVec3, elementary_x8 as x8};

/// A parallelogram; near ones with right angles are sampled by solid angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RectangleEmitter {
    corner: DVec3,
    u: DVec3,
    v: DVec3,
    normal: DVec3,
    per_area: f64,
    /// Lengths and directions of the edges, if they are perpendicular.
    right_angled: Option<([f64; 2], [DVec3; 2])>,
}

/// The projection of a rectangle onto the unit sphere around a point; names as in Ureña et al. 2013.
struct Spherical {
    x: DVec3,
    y: DVec3,
    z: DVec3,
    x0: f64,
    x1: f64,
    y0: f64,
    y1: f64,
    z0: f64,
    b0: f64,
    b1: f64,
    k: f64,
    solid_angle: f64,
}

impl RectangleEmitter {
    /// From a corner and the edges that meet there; `None` without area. The normal is `side`, 1 or −1, times u × v.
    pub fn new(corner: DVec3, u: DVec3, v: DVec3, side: f64) -> Option<RectangleEmitter> {
        let across = u.cross(v);
        let per_area = 1.0 / across.length();
        let normal = side * across.try_normalize()?;
        let (lu, lv) = (u.length(), v.length());
        let right_angled = (u.dot(v).abs() <= 1e-9 * lu * lv).then(|| ([lu, lv], [u / lu, v / lv]));
        (per_area > 0.0 && per_area.is_finite()).then_some(RectangleEmitter {
            corner,
            u,
            v,
            normal,
            per_area,
            right_angled,
        })
    }

    /// Its bounds, for a power per steradian along the normal.
    pub fn bound(&self, two_sided: bool, power: f64) -> LightBound {
        let radius = 0.5 * (self.u + self.v).length().max((self.u - self.v).length());
        LightBound::flat(self.corner + 0.5 * (self.u + self.v), radius, self.normal, two_sided, power)
    }

    /// Lengths of the edges; 0, which never counts as near, if they are not perpendicular.
    #[inline(always)]
    fn lengths(&self) -> [f64; 2] {
        self.right_angled.map_or([0.0; 2], |(lengths, _)| lengths)
    }

    #[inline(always)]
    fn axes(&self) -> [DVec3; 2] {
        self.right_angled.map_or([DVec3::ZERO; 2], |(_, axes)| axes)
    }

    fn spherical(&self, p: DVec3) -> Option<Spherical> {
        let ([lu, lv], [x, y]) = self.right_angled?;
        let diagonal2 = lu * lu + lv * lv;
        let center = self.corner + 0.5 * (self.u + self.v);
        if diagonal2 < NEAR * p.distance_squared(center) {
            return None;
        }
        let mut z = self.normal;
        let d = self.corner - p;
        let mut z0 = d.dot(z);
        if z0 > 0.0 {
            z = -z;
            z0 = -z0;
        }
        let (x0, y0) = (d.dot(x), d.dot(y));
        let (x1, y1) = (x0 + lu, y0 + lv);
        // The normals of the planes through p and an edge have two non-zero coordinates; this is the one along z.
        let side = |a: f64| a / (a * a + z0 * z0).sqrt();
        let (n0, n1, n2, n3) = (-side(y0), side(x1), side(y1), -side(x0));
        let g0 = arc_cosine((-n0 * n1).clamp(-1.0, 1.0));
        let g1 = arc_cosine((-n1 * n2).clamp(-1.0, 1.0));
        let g2 = arc_cosine((-n2 * n3).clamp(-1.0, 1.0));
        let g3 = arc_cosine((-n3 * n0).clamp(-1.0, 1.0));
        let k = 2.0 * PI - g2 - g3;
        let solid_angle = g0 + g1 - k;
        (solid_angle > 1e-4 && solid_angle < MAX_SOLID_ANGLE).then_some(Spherical {
            x,
            y,
            z,
            x0,
            x1,
            y0,
            y1,
            z0,
            b0: n0,
            b1: n2,
            k,
            solid_angle,
        })
    }

    /// The point that `u` chooses, seen from `p`.
    pub fn sample(&self, p: DVec3, u: [f64; 2]) -> Option<EmitterSample> {
        let Some(s) = self.spherical(p) else {
            let q = self.corner + u[0] * self.u + u[1] * self.v;
            let pdf = per_solid_angle(self.per_area, p, q, self.normal)?;
            return Some(EmitterSample { q, n: self.normal, u: u[0], v: u[1], pdf });
        };
        let (sin, cos) = sin_cos_turns((u[0] * s.solid_angle + s.k) * (0.5 / PI));
        let fu = (cos * s.b0 - s.b1) / sin;
        let cu = (1.0f64.copysign(fu) / (fu * fu + s.b0 * s.b0).sqrt()).clamp(-1.0, 1.0);
        let xu = (-(cu * s.z0) / (1.0 - cu * cu).max(1e-300).sqrt()).clamp(s.x0, s.x1);
        let d2 = xu * xu + s.z0 * s.z0;
        let h0 = s.y0 / (d2 + s.y0 * s.y0).sqrt();
        let h1 = s.y1 / (d2 + s.y1 * s.y1).sqrt();
        let hv = h0 + u[1] * (h1 - h0);
        let yv = if hv * hv < 1.0 - 1e-12 { hv * (d2 / (1.0 - hv * hv)).sqrt() } else { s.y1 };
        let yv = yv.clamp(s.y0, s.y1);
        let q = p + xu * s.x + yv * s.y + s.z0 * s.z;
        if !q.is_finite() {
            return None;
        }
        let (lu, lv) = (s.x1 - s.x0, s.y1 - s.y0);
        let (u, v) = ((xu - s.x0) / lu, (yv - s.y0) / lv);
        Some(EmitterSample { q, n: self.normal, u, v, pdf: 1.0 / s.solid_angle })
    }

    /// `sample` for the eight lanes of a block; the emitters may all be the same one.
    #[inline]
    pub fn sample_block(set: InstructionSet, emitters: [&RectangleEmitter; LANES], block: &mut EmitterBlock) {
        dispatch(set, SampleBlock { emitters: Eight::new(emitters), block });
    }

    /// The pdf of the direction from `p` to the point `q` on it.
    pub fn pdf(&self, p: DVec3, q: DVec3) -> f64 {
        match self.spherical(p) {
            Some(s) => 1.0 / s.solid_angle,
            None => per_solid_angle(self.per_area, p, q, self.normal).unwrap_or(0.0),
        }
    }

    /// Its area.
    pub fn area(&self) -> f64 {
        1.0 / self.per_area
    }
}

/// The z coordinate of the normal of the plane through an edge.
#[inline(always)]
fn side<S: Simd>(a: F64x8<S>, z0: F64x8<S>) -> F64x8<S> {
    a / (a * a + z0 * z0).sqrt()
}

/// The interior angle at a corner.
#[inline(always)]
fn between<S: Simd>(simd: S, a: F64x8<S>, b: F64x8<S>) -> F64x8<S> {
    let one = F64x8::splat(simd, 1.0);
    x8::arc_cosine(simd, x8::clamp(-a * b, -one, one))
}

struct SampleBlock<'a> {
    emitters: Eight<'a, RectangleEmitter>,
    block: &'a mut EmitterBlock,
}

impl Work for SampleBlock<'_> {
    type Output = ();

    /// As [`RectangleEmitter::sample`], operation by operation.
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let SampleBlock { emitters: e, block } = self;
        let splat = |v: f64| F64x8::splat(simd, v);
        let (zero, one) = (splat(0.0), splat(1.0));
        let (p, [u0, u1]) = block.inputs(simd);
        let (corner, u, v, n) = (
            e.vector(simd, |e| e.corner),
            e.vector(simd, |e| e.u),
            e.vector(simd, |e| e.v),
            e.vector(simd, |e| e.normal),
        );
        let (lu, lv) = (e.scalar(simd, |e| e.lengths()[0]), e.scalar(simd, |e| e.lengths()[1]));
        let (x, y) = (e.vector(simd, |e| e.axes()[0]), e.vector(simd, |e| e.axes()[1]));
        // By solid angle.
        let to_center = p - (corner + (u + v) * splat(0.5));
        let near = (lu * lu + lv * lv).ge(splat(NEAR) * to_center.dot(to_center)) & lu.gt(zero);
        let d = corner - p;
        let z0 = d.dot(n);
        let behind = z0.gt(zero);
        let z = Vec3x8::select(behind, -n, n);
        let z0 = behind.select(-z0, z0);
        let (x0, y0) = (d.dot(x), d.dot(y));
        let (x1, y1) = (x0 + lu, y0 + lv);
        let (n0, n1, n2, n3) = (-side(y0, z0), side(x1, z0), side(y1, z0), -side(x0, z0));
        let (g0, g1) = (between(simd, n0, n1), between(simd, n1, n2));
        let (g2, g3) = (between(simd, n2, n3), between(simd, n3, n0));
        let k = splat(2.0 * PI) - g2 - g3;
        let solid_angle = g0 + g1 - k;
        let spherical = near & solid_angle.gt(splat(1e-4)) & solid_angle.lt(splat(MAX_SOLID_ANGLE));
        let (sin, cos) = x8::sin_cos_turns(simd, (u0 * solid_angle + k) * splat(0.5 / PI));
        let fu = (cos * n0 - n2) / sin;
        let cu = x8::clamp(one.copysign(fu) / (fu * fu + n0 * n0).sqrt(), -one, one);
        let xu = -(cu * z0) / (one - cu * cu).or_larger(splat(1e-300)).sqrt();
        let xu = x8::clamp(xu, x0, x1);
        let d2 = xu * xu + z0 * z0;
        let h0 = y0 / (d2 + y0 * y0).sqrt();
        let h1 = y1 / (d2 + y1 * y1).sqrt();
        let hv = h0 + u1 * (h1 - h0);
        let within = (hv * hv).lt(splat(1.0 - 1e-12));
        let yv = within.select(hv * (d2 / (one - hv * hv)).sqrt(), y1);
        let yv = x8::clamp(yv, y0, y1);
        let q = p + x * xu + y * yv + z * z0;
        let valid =
            spherical & x8::is_finite(simd, q.x) & x8::is_finite(simd, q.y) & x8::is_finite(simd, q.z);
        let mut found = valid.bits();
        let (s, t) = ((xu - x0) / (x1 - x0), (yv - y0) / (y1 - y0));
        let pdf = one / solid_angle;
        if spherical.bits() == u8::MAX {
            block.store(found, q, n, [s, t], pdf);
            return;
        }
        // By area.
        let on = corner + u * u0 + v * u1;
        let (area_valid, area_pdf) = block::per_solid_angle(simd, e.scalar(simd, |e| e.per_area), p, on, n);
        found |= area_valid.and_not(spherical).bits();
        block.store(
            found,
            Vec3x8::select(spherical, q, on),
            n,
            [spherical.select(s, u0), spherical.select(t, u1)],
            spherical.select(pdf, area_pdf),
        );
    }
}

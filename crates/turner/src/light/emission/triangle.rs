//! Emissive triangles, sampled by solid angle or by area.
//!
//! Method: Arvo 1995, "Stratified sampling of spherical triangles". The triangle is projected onto the unit sphere
//! around p, and the spherical triangle is sampled uniformly:
//!
//! ```text
//!           c
//!          / \                1. u[0] chooses c' on the arc a–c so that the triangle a, b, c'
//!      c' *   \                  has u[0] of the solid angle;
//!        / \   \              2. u[1] chooses the direction on the arc b–c': the cosine of the
//!       /    * w\                angle from b is linear in u[1].
//!      a---------b            pdf = 1/Ω
//!
//! tan(Ω/2) = |a · (b × c)| / (1 + a·b + b·c + c·a)
//! ```
//!
//! a, b and c are unit vectors towards the corners; the solid angle Ω is that of Van Oosterom and Strackee 1983.
//!
//! Far, thin and tiny triangles are sampled by area.

use turner_bvh::InstructionSet;
use turner_bvh::lanes::{Block, F64x8, Mask8, Simd, Vec3x8, Work, dispatch};

use super::block::{self, EmitterBlock};
use super::{EmitterSample, MAX_SOLID_ANGLE, NEAR, per_solid_angle};
use crate::light::LightBound;
use crate::math::DVec3;
use crate::math::elementary::{angle, sin_cos_turns};
use crate::math::elementary_x8 as x8;

/// A triangle; near ones are sampled by solid angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleEmitter {
    corners: [DVec3; 3],
    normal: DVec3,
    per_area: f64,
}

/// The spherical triangle around a point.
struct Spherical {
    a: DVec3,
    b: DVec3,
    c: DVec3,
    solid_angle: f64,
}

impl Spherical {
    /// Sine and cosine of the angle at a.
    fn angle_at_a(&self) -> (f64, f64) {
        let (ab, ac) = (self.a.cross(self.b), self.a.cross(self.c));
        let lengths = (ab.length_squared() * ac.length_squared()).sqrt();
        (ab.cross(ac).length() / lengths, ab.dot(ac) / lengths)
    }
}

impl TriangleEmitter {
    /// From its corners; `None` without area. The normal is `side`, 1 or −1, times (b − a) × (c − a).
    pub fn new(corners: [DVec3; 3], side: f64) -> Option<TriangleEmitter> {
        let [a, b, c] = corners;
        let across = (b - a).cross(c - a);
        let per_area = 2.0 / across.length();
        let normal = side * across.try_normalize()?;
        (per_area > 0.0 && per_area.is_finite()).then_some(TriangleEmitter { corners, normal, per_area })
    }

    /// Its normal, unit.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    /// Its area.
    pub fn area(&self) -> f64 {
        1.0 / self.per_area
    }

    /// Its bounds, for a power per steradian along the normal.
    pub fn bound(&self, two_sided: bool, power: f64) -> LightBound {
        let [a, b, c] = self.corners;
        let center = 0.5 * (a.min(b).min(c) + a.max(b).max(c));
        let radius = [a, b, c].map(|p| p.distance(center)).into_iter().fold(0.0, f64::max);
        LightBound::flat(center, radius, self.normal, two_sided, power)
    }

    fn spherical(&self, p: DVec3) -> Option<Spherical> {
        let [a, b, c] = self.corners;
        let size2 = a.distance_squared(b).max(a.distance_squared(c));
        let center = (a + b + c) / 3.0;
        if size2 < NEAR * p.distance_squared(center) {
            return None;
        }
        let [a, b, c] = [a - p, b - p, c - p].map(|v| v.normalize());
        let volume = a.dot(b.cross(c)).abs();
        let solid_angle = 2.0 * angle(volume, 1.0 + a.dot(b) + b.dot(c) + c.dot(a));
        // Thin and tiny triangles lose too many digits.
        (solid_angle > 1e-3 && solid_angle < MAX_SOLID_ANGLE).then_some(Spherical { a, b, c, solid_angle })
    }

    /// The point that `u` chooses, seen from `p`.
    pub fn sample(&self, p: DVec3, u: [f64; 2]) -> Option<EmitterSample> {
        let [a, b, c] = self.corners;
        let Some(s) = self.spherical(p) else {
            let root = u[0].sqrt();
            let (v, w) = (root * (1.0 - u[1]), root * u[1]);
            let q = (1.0 - v - w) * a + v * b + w * c;
            let pdf = per_solid_angle(self.per_area, p, q, self.normal)?;
            return Some(EmitterSample { q, n: self.normal, u: v, v: w, pdf });
        };
        let (sin_alpha, cos_alpha) = s.angle_at_a();
        // c' so that the triangle a, b, c' has the fraction u[0] of the solid angle. Φ = π + u[0] Ω − α.
        let (sin, cos) = sin_cos_turns(u[0] * s.solid_angle * (0.5 * std::f64::consts::FRAC_1_PI));
        let (sin_phi, cos_phi) = (cos * sin_alpha - sin * cos_alpha, -cos * cos_alpha - sin * sin_alpha);
        let k1 = cos_phi + cos_alpha;
        let k2 = sin_phi - sin_alpha * s.a.dot(s.b);
        let denominator = (k2 * sin_phi + k1 * cos_phi) * sin_alpha;
        let cos_b = ((k2 + (k2 * cos_phi - k1 * sin_phi) * cos_alpha) / denominator).clamp(-1.0, 1.0);
        let cos_b = if cos_b.is_nan() { 1.0 } else { cos_b };
        let sin_b = (1.0 - cos_b * cos_b).max(0.0).sqrt();
        let c_moved = cos_b * s.a + sin_b * (s.c - s.c.dot(s.a) * s.a).normalize_or_zero();
        let cos_theta = 1.0 - u[1] * (1.0 - c_moved.dot(s.b));
        let sin_theta = (1.0 - cos_theta * cos_theta).max(0.0).sqrt();
        let w = cos_theta * s.b + sin_theta * (c_moved - c_moved.dot(s.b) * s.b).normalize_or_zero();
        // Intersects that direction with the triangle (Möller & Trumbore 1997).
        let (e1, e2) = (b - a, c - a);
        let across = w.cross(e2);
        let det = e1.dot(across);
        let from = p - a;
        let v = from.dot(across) / det;
        let w = w.dot(from.cross(e1)) / det;
        if !(v.is_finite() && w.is_finite()) {
            return None;
        }
        let v = v.clamp(0.0, 1.0);
        let w = w.clamp(0.0, 1.0 - v);
        let q = (1.0 - v - w) * a + v * b + w * c;
        Some(EmitterSample { q, n: self.normal, u: v, v: w, pdf: 1.0 / s.solid_angle })
    }

    /// The pdf of the direction from `p` to the point `q` on it.
    pub fn pdf(&self, p: DVec3, q: DVec3) -> f64 {
        match self.spherical(p) {
            Some(s) => 1.0 / s.solid_angle,
            None => per_solid_angle(self.per_area, p, q, self.normal).unwrap_or(0.0),
        }
    }
}

/// Eight triangles, each with its lit point.
#[derive(Clone, Debug, Default)]
pub struct TriangleBlock {
    corners: [[Block; 3]; 3],
    side: Block,
    block: EmitterBlock,
}

impl TriangleBlock {
    /// Sets the inputs of a lane: the arguments of [`TriangleEmitter::new`] and of [`TriangleEmitter::sample`].
    #[inline]
    pub fn ask(&mut self, lane: usize, corners: [DVec3; 3], side: f64, p: DVec3, u: [f64; 2]) {
        for (blocks, corner) in self.corners.iter_mut().zip(corners) {
            for (block, v) in blocks.iter_mut().zip(corner.to_array()) {
                block.0[lane] = v;
            }
        }
        self.side.0[lane] = side;
        self.block.ask(lane, p, u);
    }

    /// Samples all lanes.
    #[inline]
    pub fn sample(&mut self, set: InstructionSet) {
        dispatch(set, SampleBlock(self));
    }

    /// The lit points and the samples.
    pub fn block(&self) -> &EmitterBlock {
        &self.block
    }
}

struct SampleBlock<'a>(&'a mut TriangleBlock);

/// Eight spherical triangles: as [`Spherical`], and the lanes that are sampled by solid angle.
struct Spherical8<S: Simd> {
    corners: [Vec3x8<S>; 3],
    solid_angle: F64x8<S>,
    near: Mask8<S>,
}

impl<S: Simd> Spherical8<S> {
    #[inline(always)]
    fn new(simd: S, [a, b, c]: [Vec3x8<S>; 3], p: Vec3x8<S>) -> Self {
        let splat = |v: f64| F64x8::splat(simd, v);
        let (ab, ac) = (a - b, a - c);
        let size2 = ab.dot(ab).or_larger(ac.dot(ac));
        let sum = a + b + c;
        let three = splat(3.0);
        let center = Vec3x8 { x: sum.x / three, y: sum.y / three, z: sum.z / three };
        let away = p - center;
        let near = size2.ge(splat(NEAR) * away.dot(away));
        let [a, b, c] = [a - p, b - p, c - p].map(|v| v * (splat(1.0) / v.dot(v).sqrt()));
        let volume = a.dot(b.cross(c)).abs();
        let angle = x8::angle(simd, volume, splat(1.0) + a.dot(b) + b.dot(c) + c.dot(a));
        let solid_angle = splat(2.0) * angle;
        let near = near & solid_angle.gt(splat(1e-3)) & solid_angle.lt(splat(MAX_SOLID_ANGLE));
        Spherical8 { corners: [a, b, c], solid_angle, near }
    }

    /// The direction that `u` chooses.
    #[inline(always)]
    fn direction(&self, simd: S, [u0, u1]: [F64x8<S>; 2]) -> Vec3x8<S> {
        let splat = |v: f64| F64x8::splat(simd, v);
        let (zero, one) = (splat(0.0), splat(1.0));
        let [a, b, c] = self.corners;
        let (ab, ac) = (a.cross(b), a.cross(c));
        let lengths = (ab.dot(ab) * ac.dot(ac)).sqrt();
        let across = ab.cross(ac);
        let (sin_alpha, cos_alpha) = (across.dot(across).sqrt() / lengths, ab.dot(ac) / lengths);
        let turns = u0 * self.solid_angle * splat(0.5 * std::f64::consts::FRAC_1_PI);
        let (sin, cos) = x8::sin_cos_turns(simd, turns);
        let sin_phi = cos * sin_alpha - sin * cos_alpha;
        let cos_phi = -cos * cos_alpha - sin * sin_alpha;
        let k1 = cos_phi + cos_alpha;
        let k2 = sin_phi - sin_alpha * a.dot(b);
        let denominator = (k2 * sin_phi + k1 * cos_phi) * sin_alpha;
        let cos_b = (k2 + (k2 * cos_phi - k1 * sin_phi) * cos_alpha) / denominator;
        let cos_b = x8::clamp(cos_b, -one, one);
        let cos_b = cos_b.is_nan().select(one, cos_b);
        let sin_b = (one - cos_b * cos_b).or_larger(zero).sqrt();
        let moved = a * cos_b + unit_or_zero(simd, c - a * c.dot(a)) * sin_b;
        let cos_theta = one - u1 * (one - moved.dot(b));
        let sin_theta = (one - cos_theta * cos_theta).or_larger(zero).sqrt();
        b * cos_theta + unit_or_zero(simd, moved - b * moved.dot(b)) * sin_theta
    }
}

/// The reciprocal length, where it is finite and positive.
#[inline(always)]
fn reciprocal_length<S: Simd>(simd: S, v: Vec3x8<S>) -> (Mask8<S>, F64x8<S>) {
    let reciprocal = F64x8::splat(simd, 1.0) / v.dot(v).sqrt();
    (x8::is_finite(simd, reciprocal) & reciprocal.gt(F64x8::splat(simd, 0.0)), reciprocal)
}

#[inline(always)]
fn unit_or_zero<S: Simd>(simd: S, v: Vec3x8<S>) -> Vec3x8<S> {
    let (valid, reciprocal) = reciprocal_length(simd, v);
    Vec3x8::select(valid, v * reciprocal, Vec3x8::splat(simd, [0.0; 3]))
}

impl Work for SampleBlock<'_> {
    type Output = ();

    /// As [`TriangleEmitter::new`] and [`TriangleEmitter::sample`], operation by operation.
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let SampleBlock(TriangleBlock { corners, side, block }) = self;
        let splat = |v: f64| F64x8::splat(simd, v);
        let (zero, one) = (splat(0.0), splat(1.0));
        let [a, b, c] = [0, 1, 2].map(|i| Vec3x8::load(simd, &corners[i]));
        let (p, [u0, u1]) = block.inputs(simd);
        let (e1, e2) = (b - a, c - a);
        let across = e1.cross(e2);
        let per_area = splat(2.0) / across.dot(across).sqrt();
        let (has_normal, reciprocal) = reciprocal_length(simd, across);
        let normal = across * reciprocal * F64x8::load(simd, side);
        let has_area = has_normal & per_area.gt(zero) & x8::is_finite(simd, per_area);
        let s = Spherical8::new(simd, [a, b, c], p);
        let on = |v: F64x8<S>, w: F64x8<S>| a * (one - v - w) + b * v + c * w;
        // By solid angle. Intersects the direction with the triangle.
        let direction = s.direction(simd, [u0, u1]);
        let across = direction.cross(e2);
        let det = e1.dot(across);
        let from = p - a;
        let v = from.dot(across) / det;
        let w = direction.dot(from.cross(e1)) / det;
        let finite = x8::is_finite(simd, v) & x8::is_finite(simd, w);
        let v = x8::clamp(v, zero, one);
        let w = x8::clamp(w, zero, one - v);
        // By area.
        let root = u0.sqrt();
        let v = s.near.select(v, root * (one - u1));
        let w = s.near.select(w, root * u1);
        let q = on(v, w);
        let (area_valid, area_pdf) = block::per_solid_angle(simd, per_area, p, q, normal);
        let found = has_area & ((s.near & finite) | area_valid.and_not(s.near));
        let pdf = s.near.select(one / s.solid_angle, area_pdf);
        block.store(found.bits(), q, normal, [v, w], pdf);
    }
}

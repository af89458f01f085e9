//! Tori.
//!
//! A torus is a tube of radius r around a circle of radius R. A quarter of its cross-section, with ρ² = x² + y²:
//!
//! ```text
//!      z ^
//!        |          , - ,
//!        |        /   r   \
//!        |       |    o────|       inside: (ρ − R)² + z² < r²
//!        |        \       /
//!        +----------` - ´------> ρ
//!                     R
//! ```
//!
//! Along a ray the surface is the quartic F(t) = (|p|² + R² − r²)² − 4 R² (x² + y²) = 0. Closed formulas for
//! quartics lose their digits for thin tubes, so the roots are isolated and bracketed instead:
//!
//! 1. t is measured from the ray's point nearest to the centre, in units of R + r. There, with a = dx² + dy², b
//!    = x dx + y dy and k = |o|² + R² − r², the derivative is F′/4 = t³ + (k − 2 R² a) t − 2 R² b: a cubic
//!    without quadratic term.
//! 2. The roots of the cubic split the ray into at most four pieces on which F is monotone. A change of sign
//!    between the ends of a piece therefore brackets exactly one root.
//! 3. Newton's method with bisection refines it. The sign is not that of F but of the distance to the circle,
//!    which keeps its digits for thin tubes.

use std::f64::consts::TAU;

use super::plane::tangents;
use super::{AreaPoint, ROUNDING, ShapeHit, SurfacePoint, direction, unit_angle};
use crate::math::elementary::sin_cos;
use crate::math::{Bounds, DVec2, DVec3, Frame, Ray};
use crate::schema::{ErrorCode, Range, SceneError, params};

params! {
    /// A torus: a tube around a circle. u runs once around the axis, counter-clockwise as seen from the tip of
    /// the axis; with the axis +y it is the same as on a sphere: 0 at −z, 0.25 at −x, 0.5 at +z, 0.75 at +x. v
    /// runs once around the tube: 0 at the inner side, 0.25 at the bottom (against the axis), 0.5 at the outer
    /// side, 0.75 at the top. Normals point out of the tube.
    pub struct TorusDesc as "torus" {
        /// Centre.
        center: DVec3 = DVec3::ZERO;
        /// Axis of symmetry, of any length.
        axis: DVec3 = DVec3::Y;
        /// Radius of the circle at the centre of the tube.
        radius: f64 = 1.0, in Range::POSITIVE;
        /// Radius of the tube, at most `radius`.
        tube_radius: f64 = 0.25, in Range::POSITIVE;
    }
    example r#"[[object]]
type = "torus"
radius = 1
tube_radius = 0.3
material = { color = "gold" }
"#
}

/// A torus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Torus {
    center: DVec3,
    /// z is the axis.
    frame: Frame,
    radius: f64,
    tube: f64,
    error: f64,
}

impl TorusDesc {
    /// Converts it to the form that rays are intersected with.
    pub fn prepare(&self) -> Result<Torus, SceneError> {
        let (radius, tube) = (self.radius, self.tube_radius);
        if tube > radius {
            let message = format!("`tube_radius` ({tube}) of a torus must not exceed `radius` ({radius})");
            return Err(SceneError::new(ErrorCode::OutOfRange, message)
                .help("make the tube thinner: a torus that intersects itself has no well-defined inside"));
        }
        let axis = direction(self.axis, "torus", "axis")?;
        let (x, y) = tangents(axis);
        let error = ROUNDING * (self.center.abs().max_element() + radius + tube);
        Ok(Torus { center: self.center, frame: Frame { x, y, z: axis }, radius, tube, error })
    }
}

impl Torus {
    /// Centre, unit axes with z along the axis of symmetry, radius of the circle and of the tube.
    pub(super) fn ring(&self) -> (DVec3, [DVec3; 3], f64, f64) {
        (self.center, [self.frame.x, self.frame.y, self.frame.z], self.radius, self.tube)
    }

    /// Radius of the tube.
    pub(super) fn tube_radius(&self) -> f64 {
        self.tube
    }

    /// Bounding box: that of the circle, extended by the tube radius.
    pub fn bounds(&self) -> Bounds {
        let n = self.frame.z;
        let reach = self.radius * (DVec3::ONE - n * n).max(DVec3::ZERO).map(f64::sqrt) + self.tube;
        let reach = reach + 2.0 * self.error;
        Bounds::new(self.center - reach, self.center + reach)
    }

    /// Nearest hit: see the module documentation.
    pub fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        if !ray.is_finite() {
            return None;
        }
        let size = self.radius + self.tube;
        let (major, minor) = (self.radius / size, self.tube / size);
        let d = self.frame.to_local(ray.direction);
        let speed = d.length() / size;
        if !(speed > 0.0 && speed < f64::INFINITY) {
            return None;
        }
        let d = d / (speed * size);
        let o = self.frame.to_local(ray.origin - self.center) / size;
        let nearest = -o.dot(d);
        let o = o + nearest * d;
        let o = o - o.dot(d) * d;
        let distance2 = o.length_squared();
        if !(distance2 <= 1.0 + SLACK) {
            return None;
        }
        // Limits: the bounding sphere, and the planes z = ±r.
        let reach = (1.0 + SLACK - distance2).max(0.0).sqrt() + SLACK;
        let (mut lo, mut hi) = (-reach, reach);
        if d.z != 0.0 {
            let mid = -o.z / d.z;
            let half = (minor + SLACK) / d.z.abs();
            (lo, hi) = (lo.max(mid - half), hi.min(mid + half));
        } else if o.z.abs() > minor {
            return None;
        }
        let line = Line { o, d, major, minor };
        let range = (ray.t_min * speed - nearest - SLACK, ray.t_max * speed - nearest + SLACK);
        let t =
            line.first_root((lo, hi), range, |t| Some((t + nearest) / speed).filter(|&t| ray.contains(t)))?;
        Some(ShapeHit { t, part: 0, u: 0.0, v: 0.0 })
    }

    /// The surface point at a hit.
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        let p = self.frame.to_local(ray.at(hit.t) - self.center);
        let out = DVec3::new(p.x, p.y, 0.0).normalize_or(DVec3::X);
        let circle = self.radius * out;
        let n = (p - circle).normalize_or(DVec3::Z);
        let p = self.center + self.frame.to_world(circle + self.tube * n);
        let n = self.frame.to_world(n);
        SurfacePoint { p, error: self.error, ng: n, ns: n }
    }

    /// Surface area.
    pub fn area(&self) -> f64 {
        TAU * TAU * self.radius * self.tube
    }

    /// Samples a point uniformly by area from two random numbers in [0, 1).
    pub fn point_by_area(&self, u: [f64; 2]) -> AreaPoint {
        let v = tube_angle(u[0], self.tube / self.radius);
        let (sin_v, cos_v) = sin_cos(v);
        let (sin_u, cos_u) = sin_cos(TAU * u[1]);
        let n = DVec3::new(cos_v * cos_u, cos_v * sin_u, sin_v);
        let circle = self.radius * DVec3::new(cos_u, sin_u, 0.0);
        AreaPoint {
            p: self.center + self.frame.to_world(circle + self.tube * n),
            n: self.frame.to_world(n),
            part: 0,
        }
    }

    /// (u, v) at a point of the torus.
    pub fn uv(&self, p: DVec3) -> DVec2 {
        let p = self.frame.to_local(p - self.center);
        let out = (p.x * p.x + p.y * p.y).sqrt() - self.radius;
        DVec2::new(unit_angle(p.x, -p.y), unit_angle(p.z, out))
    }
}

/// The angle around the tube, from the outer side, at which the cumulative area reaches the fraction `u`: the
/// root of v + e sin v = 2πu with `e` in 0..=1 (Kepler's equation). Bisection safeguards Newton's method where
/// the function is flat, at the inner side.
fn tube_angle(u: f64, e: f64) -> f64 {
    let target = TAU * u;
    let (mut lo, mut hi) = (0.0, TAU);
    let mut v = target;
    for _ in 0..64 {
        let (s, c) = sin_cos(v);
        let off = v + e * s - target;
        if off > 0.0 {
            hi = v;
        } else {
            lo = v;
        }
        let step = v - off / (1.0 + e * c);
        let next = if step > lo && step < hi { step } else { 0.5 * (lo + hi) };
        if (next - v).abs() <= 1e-15 * TAU {
            return next;
        }
        v = next;
    }
    v
}

/// Margin of the search limits, in units of R + r.
const SLACK: f64 = 1e-12;

/// A ray in units of R + r, starting at its point nearest to the centre; the direction has unit length.
struct Line {
    o: DVec3,
    d: DVec3,
    major: f64,
    minor: f64,
}

impl Line {
    /// Squared distance to the circle minus r², and its derivative. Negative inside.
    #[inline]
    fn value(&self, t: f64) -> (f64, f64) {
        let p = self.o + t * self.d;
        let rho = (p.x * p.x + p.y * p.y).sqrt();
        let off = rho - self.major;
        let slope = if rho > 0.0 { (p.x * self.d.x + p.y * self.d.y) / rho } else { 0.0 };
        // As a product, not (off² + z²) − r²: near the surface the difference is exact.
        let distance = (off * off + p.z * p.z).sqrt();
        ((distance - self.minor) * (distance + self.minor), 2.0 * (off * slope + p.z * self.d.z))
    }

    /// The first accepted root between the limits. Roots outside `range` may be skipped; `range` does not
    /// affect which roots exist.
    fn first_root(
        &self,
        limits: (f64, f64),
        range: (f64, f64),
        accept: impl Fn(f64) -> Option<f64>,
    ) -> Option<f64> {
        let (lo, hi) = limits;
        if !(lo <= hi && lo <= range.1 && hi >= range.0) {
            return None;
        }
        let (turns, count) = self.turning_points(lo, hi);
        let (mut a, mut outside) = (lo, self.value(lo).0 > 0.0);
        for &b in turns[..count].iter().chain([&hi]) {
            let before = outside;
            outside = self.value(b).0 > 0.0;
            if before != outside && b >= range.0 {
                if a > range.1 {
                    return None;
                }
                let found = accept(bracketed(a, b, !before, |t| self.value(t)));
                if found.is_some() {
                    return found;
                }
            }
            a = b;
        }
        None
    }

    /// The extrema of F between lo and hi, in order.
    fn turning_points(&self, lo: f64, hi: f64) -> ([f64; 3], usize) {
        let (o, d, m2) = (self.o, self.d, self.major * self.major);
        let k = o.length_squared() + m2 - self.minor * self.minor;
        let p = k - 2.0 * m2 * (d.x * d.x + d.y * d.y);
        let q = -2.0 * m2 * (o.x * d.x + o.y * d.y);
        let cubic = |t: f64| ((t * t + p) * t + q, 3.0 * t * t + p);
        let extremum = if p < 0.0 { (p / -3.0).sqrt() } else { f64::INFINITY };
        let mut found = [0.0; 3];
        let mut count = 0;
        let mut a = lo;
        let mut fa = cubic(a).0;
        for b in [-extremum, extremum, hi] {
            if !(b > a) {
                continue;
            }
            let b = b.min(hi);
            let fb = cubic(b).0;
            if (fa < 0.0) != (fb < 0.0) {
                found[count] = bracketed(a, b, fa < 0.0, cubic);
                count += 1;
            }
            (a, fa) = (b, fb);
        }
        (found, count)
    }
}

/// The root of a function that changes sign once between a and b, from value and derivative: Newton's method,
/// with bisection where a step leaves the bracket or converges slowly.
fn bracketed(mut a: f64, mut b: f64, negative_at_a: bool, f: impl Fn(f64) -> (f64, f64)) -> f64 {
    let mut t = 0.5 * (a + b);
    let mut width = b - a;
    for _ in 0..100 {
        let (value, slope) = f(t);
        if value == 0.0 {
            return t;
        }
        if (value < 0.0) == negative_at_a {
            a = t
        } else {
            b = t
        }
        let step = t - value / slope;
        // The bracket must shrink by half at least every second step; otherwise bisect.
        let halved = b - a <= 0.5 * width;
        let next = if step > a && step < b && (halved || (step - t).abs() < 0.25 * width) {
            step
        } else {
            0.5 * (a + b)
        };
        width = if halved { b - a } else { 0.5 * width };
        if (next - t).abs() <= 2e-17 || next <= a || next >= b {
            return next.clamp(a, b);
        }
        if (next - t).abs() <= 1e-15 * t.abs().max(0.01) {
            return next;
        }
        t = next;
    }
    t
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::testing::Random;

    /// Sphere tracing with a least step, bisecting where the distance changes sign. Also returns the least
    /// distance along the ray.
    fn oracle(major: f64, minor: f64, ray: &Ray, end: f64) -> (Option<f64>, f64) {
        let distance = |t: f64| {
            let p = ray.at(t);
            let off = (p.x * p.x + p.z * p.z).sqrt() - major;
            (off * off + p.y * p.y).sqrt() - minor
        };
        let (mut t, mut least) = (0.0, f64::INFINITY);
        let mut value = distance(0.0);
        let outside = value > 0.0;
        while t < end {
            let next = t + value.abs().max(1e-4);
            let after = distance(next);
            if (after > 0.0) != outside {
                let (mut a, mut b) = (t, next);
                for _ in 0..60 {
                    let mid = 0.5 * (a + b);
                    if (distance(mid) > 0.0) == outside { a = mid } else { b = mid }
                }
                return (Some(0.5 * (a + b)), 0.0);
            }
            (t, value) = (next, after);
            least = least.min(value.abs());
        }
        (None, least)
    }

    #[test]
    fn random_rays_agree_with_marching() {
        let mut random = Random::new(3);
        for (radius, tube_radius) in [(1.0, 0.3), (1.0, 1.0), (1.0, 0.9), (1.0, 0.01), (1.0, 1e-3)] {
            let desc = TorusDesc { center: DVec3::ZERO, axis: DVec3::Y, radius, tube_radius };
            let torus = desc.prepare().unwrap();
            let mut hits = 0;
            for i in 0..20_000 {
                // From outside and inside; aimed at the tube, along its tangents, and anywhere.
                let around = random.direction() * DVec3::new(1.0, 0.0, 1.0);
                let around = around.normalize();
                let on_tube = radius * around + tube_radius * random.direction();
                let origin = match i % 4 {
                    0 => radius * around + 0.9 * tube_radius * random.unit() * random.direction(),
                    1 => on_tube + 0.5 * random.direction(),
                    _ => 3.0 * random.direction(),
                };
                let target = radius * random.direction() * DVec3::new(1.0, 0.0, 1.0);
                let target = target.normalize() * radius + tube_radius * 1.2 * random.in_cube();
                let mut direction = if i % 8 == 1 { around.cross(DVec3::Y) } else { target - origin };
                if i % 16 == 3 {
                    direction.y = 0.0;
                }
                let ray = Ray::new(origin, direction.normalize());
                let found = torus.intersect(&ray).map(|h| h.t);
                let (expected, least) = oracle(radius, tube_radius, &ray, 6.0);
                match (found, expected) {
                    (Some(a), Some(b)) if (a - b).abs() < 1e-7 => hits += 1,
                    (None, None) => {}
                    // The oracle steps over chords shorter than its step; there its least distance is small.
                    (Some(a), _) if least < 1e-6 || expected.is_some_and(|b| a < b && b - a < 0.5) => {
                        let p = ray.at(a);
                        let off = (p.x * p.x + p.z * p.z).sqrt() - radius;
                        assert!(((off * off + p.y * p.y).sqrt() - tube_radius).abs() < 1e-12);
                    }
                    _ => panic!("R {radius} r {tube_radius}: {found:?}, expected {expected:?} {ray:?}"),
                }
            }
            assert!(hits > 5_000, "R {radius} r {tube_radius}: {hits}");
        }
    }

    #[test]
    fn closed_forms_and_refusals() {
        let desc = TorusDesc { center: DVec3::ZERO, axis: DVec3::Y, radius: 1.0, tube_radius: 0.25 };
        let torus = desc.prepare().unwrap();
        let hit = |o: [f64; 3], d: [f64; 3]| torus.intersect(&Ray::new(o.into(), d.into())).map(|h| h.t);
        let near = |a: Option<f64>, t: f64| assert!((a.unwrap() - t).abs() < 1e-12, "{a:?} {t}");
        near(hit([-3.0, 0.0, 0.0], [1.0, 0.0, 0.0]), 1.75);
        near(hit([0.0, 0.0, 0.0], [1.0, 0.0, 0.0]), 0.75);
        near(hit([1.0, 0.0, 0.0], [1.0, 0.0, 0.0]), 0.25);
        near(hit([1.0, 3.0, 0.0], [0.0, -2.0, 0.0]), 1.375);
        near(hit([-1e7, 0.0, 0.0], [1e3, 0.0, 0.0]), 1e4 - 1.25e-3);
        assert_eq!(hit([0.0, 3.0, 0.0], [0.0, -1.0, 0.0]), None);
        assert_eq!(hit([-3.0, 0.2501, 0.0], [1.0, 0.0, 0.0]), None);
        for (p, uv) in [
            (DVec3::new(1.25, 0.0, 0.0), DVec2::new(0.75, 0.5)),
            (DVec3::new(0.0, 0.25, 1.0), DVec2::new(0.5, 0.75)),
            (DVec3::new(-1.0, -0.25, 0.0), DVec2::new(0.25, 0.25)),
        ] {
            assert!((torus.uv(p) - uv).length() < 1e-12, "{p}");
        }
        assert!(TorusDesc { tube_radius: 1.1, ..desc.clone() }.prepare().is_err());
        assert!(TorusDesc { axis: DVec3::ZERO, ..desc }.prepare().is_err());
    }
}

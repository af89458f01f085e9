//! Tori.

use super::plane::tangents;
use super::{ROUNDING, ShapeHit, SurfacePoint, direction, turn};
use crate::math::{Bounds, DVec2, DVec3, Frame, Ray};
use crate::scene::schema::{Range, params};
use crate::scene::{ErrorCode, SceneError};

params! {
    /// A torus: a tube around a circle. u runs once around the axis, counter-clockwise seen from the tip of the axis; with the
    /// axis +y it is that of the sphere: 0 at −z, 0.25 at −x, 0.5 at +z, 0.75 at +x. v runs once around the tube: 0 at the inner
    /// side, 0.25 below (against the axis), 0.5 at the outer side, 0.75 above.
    pub struct TorusDesc as "torus" {
        /// The middle.
        center: DVec3 = DVec3::ZERO;
        /// The axis it turns about; its length does not matter.
        axis: DVec3 = DVec3::Y;
        /// The radius of the circle in the middle of the tube.
        radius: f64 = 1.0, in Range::POSITIVE;
        /// The radius of the tube, at most `radius`.
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
    /// Makes it traceable.
    pub fn prepare(&self) -> Result<Torus, SceneError> {
        let (radius, tube) = (self.radius, self.tube_radius);
        if tube > radius {
            let message = format!("`tube_radius` ({tube}) of a torus must not exceed `radius` ({radius})");
            return Err(SceneError::new(ErrorCode::OutOfRange, message)
                .help("make the tube thinner: a torus that overlaps itself has no inside"));
        }
        let axis = direction(self.axis, "torus", "axis")?;
        let (x, y) = tangents(axis);
        let error = ROUNDING * (self.center.abs().max_element() + radius + tube);
        Ok(Torus { center: self.center, frame: Frame { x, y, z: axis }, radius, tube, error })
    }
}

impl Torus {
    /// The box around it: that of its middle circle, grown by the tube.
    pub fn bounds(&self) -> Bounds {
        let n = self.frame.z;
        let reach = self.radius * (DVec3::ONE - n * n).max(DVec3::ZERO).map(f64::sqrt) + self.tube;
        let reach = reach + 2.0 * self.error;
        Bounds::new(self.center - reach, self.center + reach)
    }

    /// The nearest root in range of the quartic F(t) = (|p|² + R² − r²)² − 4 R² (x² + y²).
    ///
    /// t is measured from the point of the ray nearest to the middle, in units of the torus's size. There the
    /// derivative is F′/4 = t³ + (k − 2 R² a) t − 2 R² b, a cubic without square term; its roots cut the ray into at
    /// most four pieces on which F is monotone, so that a change of sign brackets exactly one root. Signs are taken not
    /// from F but from the distance to the middle circle, which keeps its digits for thin tubes.
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
        let miss = o.length_squared();
        if !(miss <= 1.0 + SLACK) {
            return None;
        }
        // Inside the bounding sphere, between the planes that touch it above and below, and in range.
        let reach = (1.0 + SLACK - miss).max(0.0).sqrt() + SLACK;
        let (mut lo, mut hi) = (-reach, reach);
        if d.z != 0.0 {
            let middle = -o.z / d.z;
            let half = (minor + SLACK) / d.z.abs();
            (lo, hi) = (lo.max(middle - half), hi.min(middle + half));
        } else if o.z.abs() > minor {
            return None;
        }
        (lo, hi) = (lo.max(ray.t_min * speed - nearest), hi.min(ray.t_max * speed - nearest));
        if !(lo <= hi) {
            return None;
        }
        let line = Line { o, d, major, minor };
        let t = line.first_root(lo, hi)?;
        let t = (t + nearest) / speed;
        // In range up to the rounding of the two changes of unit.
        let t = if t < ray.t_min { ray.t_min } else { t };
        let t = if t > ray.t_max { ray.t_max } else { t };
        ray.contains(t).then_some(ShapeHit { t, part: 0, u: 0.0, v: 0.0 })
    }

    /// The surface at a hit.
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        let p = self.frame.to_local(ray.at(hit.t) - self.center);
        let out = DVec3::new(p.x, p.y, 0.0).normalize_or(DVec3::X);
        let circle = self.radius * out;
        let n = (p - circle).normalize_or(DVec3::Z);
        let p = self.center + self.frame.to_world(circle + self.tube * n);
        let n = self.frame.to_world(n);
        SurfacePoint { p, error: self.error, ng: n, ns: n }
    }

    /// (u, v) at a point of the torus.
    pub fn uv(&self, p: DVec3) -> DVec2 {
        let p = self.frame.to_local(p - self.center);
        let out = (p.x * p.x + p.y * p.y).sqrt() - self.radius;
        DVec2::new(turn(p.x, -p.y), turn(p.z, out))
    }
}

/// How far beyond the touching planes the search goes, in units of the torus's size.
const SLACK: f64 = 1e-12;

/// A ray in units of the torus's size, from its point nearest to the middle; the direction has unit length.
struct Line {
    o: DVec3,
    d: DVec3,
    major: f64,
    minor: f64,
}

impl Line {
    /// Squared distance to the middle circle less that of the surface, and its derivative. Negative inside.
    #[inline]
    fn value(&self, t: f64) -> (f64, f64) {
        let p = self.o + t * self.d;
        let rho = (p.x * p.x + p.y * p.y).sqrt();
        let off = rho - self.major;
        let slope = if rho > 0.0 { (p.x * self.d.x + p.y * self.d.y) / rho } else { 0.0 };
        // Not (off² + z²) − r²: near the surface the differences are exact.
        let distance = (off * off + p.z * p.z).sqrt();
        ((distance - self.minor) * (distance + self.minor), 2.0 * (off * slope + p.z * self.d.z))
    }

    /// The smallest root in lo..=hi.
    fn first_root(&self, lo: f64, hi: f64) -> Option<f64> {
        let (turns, count) = self.turning_points(lo, hi);
        let mut a = lo;
        let mut fa = self.value(a).0;
        if fa == 0.0 {
            return Some(a);
        }
        for &b in turns[..count].iter().chain([&hi]) {
            let fb = self.value(b).0;
            if fb == 0.0 {
                return Some(b);
            }
            if (fa < 0.0) != (fb < 0.0) {
                return Some(bracketed(a, b, fa < 0.0, |t| self.value(t)));
            }
            (a, fa) = (b, fb);
        }
        None
    }

    /// Where F turns between lo and hi, in order.
    fn turning_points(&self, lo: f64, hi: f64) -> ([f64; 3], usize) {
        let (o, d, m2) = (self.o, self.d, self.major * self.major);
        let k = o.length_squared() + m2 - self.minor * self.minor;
        let p = k - 2.0 * m2 * (d.x * d.x + d.y * d.y);
        let q = -2.0 * m2 * (o.x * d.x + o.y * d.y);
        let cubic = |t: f64| ((t * t + p) * t + q, 3.0 * t * t + p);
        let turn = if p < 0.0 { (p / -3.0).sqrt() } else { f64::INFINITY };
        let mut found = [0.0; 3];
        let mut count = 0;
        let mut a = lo;
        let mut fa = cubic(a).0;
        for b in [-turn, turn, hi] {
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

/// The root of a function that changes sign once between a and b, from its value and derivative: Newton's steps,
/// halving where they leave the bracket or stall.
fn bracketed(mut a: f64, mut b: f64, negative_at_a: bool, f: impl Fn(f64) -> (f64, f64)) -> f64 {
    let mut t = 0.5 * (a + b);
    let mut width = b - a;
    for _ in 0..100 {
        let (value, slope) = f(t);
        if value == 0.0 {
            return t;
        }
        if (value < 0.0) == negative_at_a { a = t } else { b = t }
        let step = t - value / slope;
        // A Newton step stays in the bracket; every second round must halve it, or the middle is taken.
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

//! Where the camera sees a point, and how densely its rays lie: for the ray through the centre of the exit pupil of each
//! point of the film, which stands for all of them.

use super::Realistic;
use super::pupil::direction;
use crate::math::elementary::atan2;
use crate::math::{DVec2, DVec3};

/// A central ray in the plane through the axis and its point of the film: position and unit direction as (away from the
/// axis on the side of that point, forward).
type Central = (DVec2, DVec2);

/// What [`Realistic::place`] finds.
pub(in crate::camera) struct Place {
    /// Position on the screen.
    pub(in crate::camera) at: DVec2,
    /// From the point to the lens.
    pub(in crate::camera) to_camera: DVec3,
    /// Fraction of it beyond `near`.
    pub(in crate::camera) free: f64,
}

impl Realistic {
    fn central(&self, r: f64) -> Option<Central> {
        let pupil = self.optics.pupils.at(r)?;
        let d = direction(pupil.center(), 0.0)?;
        let (p, d) = self.optics.lens.trace(DVec3::new(r, 0.0, 0.0), d, |_| true)?;
        Some((DVec2::new(p.x, p.z), DVec2::new(d.x, d.z)))
    }

    /// The radius on the film whose central ray passes a point beyond the lens on the other side of the axis. `side`
    /// measures how far a ray passes from it: below 0 if the radius is too small.
    fn radius(&self, side: impl Fn(Central) -> f64) -> Option<f64> {
        let side = |r: f64| self.central(r).map(&side);
        let (mut low, mut high, mut found) = ((0.0, side(0.0)?), (0.0, 0.0), false);
        if low.1 >= 0.0 {
            return Some(0.0);
        }
        for r in self.optics.pupils.radii().skip(1) {
            let s = side(r)?;
            if s >= 0.0 {
                (high, found) = ((r, s), true);
                break;
            }
            low = (r, s);
        }
        if !found {
            return None;
        }
        // The chord, then halves: the function is nearly a line between two nodes.
        for i in 0..12 {
            let part = if i % 4 == 3 { 0.5 } else { low.1 / (low.1 - high.1) };
            let r = low.0 + part.clamp(0.0, 1.0) * (high.0 - low.0);
            let s = side(r)?;
            if s >= 0.0 {
                high = (r, s);
            } else {
                low = (r, s);
            }
        }
        Some(low.0 + low.1 / (low.1 - high.1) * (high.0 - low.0))
    }

    /// Where the camera sees a point of the world.
    pub(in crate::camera) fn place(&self, p: DVec3) -> Option<Place> {
        let f = &self.frame;
        let v = (p - f.position) / self.millimetre;
        let across = DVec2::new(v.dot(f.right), v.dot(f.up));
        let (out, depth) = (across.length(), v.dot(f.forward));
        if !(out.is_finite() && depth.is_finite()) {
            return None;
        }
        let point = DVec2::new(-out, depth);
        let r = self.radius(|(from, d)| (point - from).perp_dot(d))?;
        let (from, d) = self.central(r)?;
        let along = (point - from).dot(d);
        if along.is_nan() || along <= 0.0 {
            return None;
        }
        let axis = if out > 0.0 { across / out } else { DVec2::X };
        let seen = axis * -from.x;
        let origin = f.position + self.millimetre * (f.right * seen.x + f.up * seen.y + f.forward * from.y);
        let hidden = self.near / self.millimetre - from.y;
        let free = if hidden > 0.0 && d.y > 0.0 { 1.0 - hidden / d.y / along } else { 1.0 };
        Some(Place { at: axis * r / self.half_film, to_camera: origin - p, free })
    }

    /// The density of central rays, per solid angle around a direction at an angle from the axis, on a screen of area 4.
    pub(in crate::camera) fn screens(&self, direction: DVec3) -> f64 {
        let cos = direction.dot(self.frame.forward);
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let found = self.radius(|(_, d)| DVec2::new(-sin, cos).perp_dot(d));
        let density = || {
            let r = found?;
            let angle = |r: f64| self.central(r).map(|(_, d)| atan2(-d.x, d.y));
            let step = 1e-3 * self.half_film.length();
            let (from, to) = if r > step { (r - step, r) } else { (r, r + step) };
            let growth = (to - from) / (angle(to)? - angle(from)?);
            let around = if sin > 1e-6 { r / sin } else { growth };
            Some(growth * around / (self.half_film.x * self.half_film.y))
        };
        density().filter(|density| density.is_finite()).unwrap_or(0.0)
    }
}

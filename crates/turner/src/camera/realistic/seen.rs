//! Where the camera sees a point, and how densely its rays lie: for the ray through the centre of the exit pupil of each
//! point of the film, which stands for all of them.

use super::Realistic;
use super::lens::Lens;
use super::pupil::{Pupils, direction};
use crate::math::elementary::atan2;
use crate::math::{DVec2, DVec3};

/// A central ray in the plane through the axis and its point of the film: position and unit direction as (away from the
/// axis on the side of that point, forward).
pub(super) type Central = (DVec2, DVec2);

/// The ray of the film's radius `r` through the lens with this direction cosine.
fn central(lens: &Lens, center: f64, r: f64) -> Option<Central> {
    let (p, d) = lens.trace(DVec3::new(r, 0.0, 0.0), direction(center, 0.0)?, |_| true)?;
    Some((DVec2::new(p.x, p.z), DVec2::new(d.x, d.z)))
}

/// The central rays of the radii in the tables, up to the first that the lens blocks.
pub(super) fn central_rays(lens: &Lens, pupils: &Pupils) -> Vec<(f64, Central)> {
    let ray = |r: f64| Some((r, central(lens, pupils.at(r)?.center(), r)?));
    pupils.radii().map_while(ray).collect()
}

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
        central(&self.optics.lens, self.optics.pupils.at(r)?.center(), r)
    }

    /// The radius on the film whose central ray passes a point beyond the lens on the other side of the axis. `side`
    /// measures how far a ray passes from it: below 0 if the radius is too small.
    fn radius(&self, side: impl Fn(Central) -> f64) -> Option<f64> {
        /// Steps of the search in the last interval, where the function is nearly a line.
        const STEPS: i32 = 12;
        let nodes = &self.optics.central;
        let is_below = |(_, ray): &(f64, Central)| side(*ray) < 0.0;
        let above = nodes.partition_point(is_below);
        let &(r, ray) = nodes.get(above)?;
        let mut high = (r, side(ray));
        let Some(&(r, ray)) = above.checked_sub(1).and_then(|below| nodes.get(below)) else {
            return Some(0.0);
        };
        let mut low = (r, side(ray));
        let exact = 1e-13 * (high.1 - low.1);
        for step in 1..=STEPS {
            let part = if step % 4 == 0 { 0.5 } else { low.1 / (low.1 - high.1) };
            let r = low.0 + part.clamp(0.0, 1.0) * (high.0 - low.0);
            let s = side(self.central(r)?);
            if s.abs() <= exact {
                return Some(r);
            }
            *(if s >= 0.0 { &mut high } else { &mut low }) = (r, s);
        }
        Some(low.0 + low.1 / (low.1 - high.1) * (high.0 - low.0))
    }

    /// Where the camera sees a point of the world.
    pub(in crate::camera) fn place(&self, p: DVec3) -> Option<Place> {
        let f = &self.frame;
        let v = (p - f.position) / self.millimetre;
        let across = DVec2::new(v.dot(f.right), v.dot(f.up));
        let (out, depth) = (across.length(), v.dot(f.forward));
        if !(out.is_finite() && depth.is_finite()) || depth * self.millimetre > self.clip.far {
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
        let hidden = self.clip.near / self.millimetre - from.y;
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

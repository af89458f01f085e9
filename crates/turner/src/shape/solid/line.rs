//! The line of a ray across a bounding box, measured from its point nearest to the centre of the box: distant origins
//! cost no digits, and what is found does not depend on the range of the ray.

use crate::math::{Bounds, DVec3, Ray};

/// A line in a box. Positions on it are distances from `origin`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    /// The point of the line nearest to the centre of the box.
    pub(super) origin: DVec3,
    /// Unit direction.
    pub(super) direction: DVec3,
    /// Where the line enters and leaves the box.
    pub(super) enter: f64,
    /// See `enter`.
    pub(super) exit: f64,
    /// The faces where it does: 0 to 5 are −x, +x, −y, +y, −z, +z.
    pub(super) faces: [u32; 2],
    /// The ray's t at `origin`.
    t: f64,
    /// Distance per unit of t.
    speed: f64,
}

impl Line {
    /// The line of a ray in a box; `None` if it misses the box or the ray is invalid.
    pub(super) fn new(ray: &Ray, bounds: &Bounds) -> Option<Line> {
        let speed = ray.direction.length();
        if !(ray.is_finite() && speed > 0.0 && speed < f64::INFINITY) {
            return None;
        }
        let direction = ray.direction / speed;
        let t = (bounds.center() - ray.origin).dot(direction) / speed;
        let origin = ray.origin + t * ray.direction;
        let (mut enter, mut exit, mut faces) = (f64::NEG_INFINITY, f64::INFINITY, [0; 2]);
        for axis in 0..3 {
            let (o, d) = (origin[axis], direction[axis]);
            let (low, high) = (bounds.min[axis], bounds.max[axis]);
            if d == 0.0 {
                if !(o >= low && o <= high) {
                    return None;
                }
                continue;
            }
            let ends = [(low - o) / d, (high - o) / d];
            let (first, last) = if d > 0.0 { (0, 1) } else { (1, 0) };
            if ends[first] > enter {
                (enter, faces[0]) = (ends[first], (2 * axis + first) as u32);
            }
            if ends[last] < exit {
                (exit, faces[1]) = (ends[last], (2 * axis + last) as u32);
            }
        }
        (enter < exit).then_some(Line { origin, direction, enter, exit, faces, t, speed })
    }

    /// The point at a distance.
    pub(super) fn at(&self, s: f64) -> DVec3 {
        self.origin + s * self.direction
    }

    /// The ray's t at a distance.
    pub(super) fn t(&self, s: f64) -> f64 {
        self.t + s / self.speed
    }

    /// A distance just before the ray's t: rounding does not move it behind.
    pub(super) fn before(&self, t: f64) -> f64 {
        (t - self.t) * self.speed - 8.0 * f64::EPSILON * (t.abs() + self.t.abs()) * self.speed
    }
}

/// The outward normal of a face of a box.
pub(super) fn face_normal(face: u32) -> DVec3 {
    let axis = DVec3::AXES[(face / 2 % 3) as usize];
    if face % 2 == 1 { axis } else { -axis }
}

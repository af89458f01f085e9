//! Motion blur: what moves while the shutter is open.
//!
//! Every ray has a time, and is transformed to the object's space at that time. Between two placements, translation
//! and stretch are interpolated linearly and the rotation at constant speed. For that, each matrix is split by polar
//! decomposition, M = R · S, into a rotation and a symmetric stretch (Shoemake & Duff 1992, "Matrix animation and
//! polar decomposition"); rotations are interpolated as quaternions along the shorter arc (slerp, Shoemake 1985):
//!
//! ```text
//!   M(t) = slerp(R0, R1, t) · ((1 − t) S0 + t S1),    p(t) = (1 − t) p0 + t p1
//! ```
//!
//! Interpolating the matrices directly would shrink rotating objects. Bounds over the shutter interval come from 64
//! steps, padded by the distance that corners travel in a step.

use glam::DQuat;

use crate::math::elementary::{acos, sin};
use crate::math::{Bounds, DAffine3, DMat3, DVec3};
use crate::schema::{ErrorCode, SceneError};

/// A motion from one placement, at time 0, to another, at time 1.
#[derive(Clone, Debug)]
pub(crate) struct Motion {
    translation: [DVec3; 2],
    rotation: [DQuat; 2],
    stretch: [DMat3; 2],
    /// The angle between the two quaternions; `None` if it is too small to interpolate by.
    angle: Option<f64>,
}

impl Motion {
    /// Between two invertible transforms.
    pub(crate) fn new(from: &DAffine3, to: &DAffine3) -> Result<Motion, SceneError> {
        let error = |message: &str| Err(SceneError::new(ErrorCode::Transform, message));
        if from.matrix3.determinant() * to.matrix3.determinant() <= 0.0 {
            return error(
                "nothing can move into its mirror image: `transform` mirrors and `motion` does not, or the reverse",
            );
        }
        let [a, b] = [from, to].map(|t| polar(&t.matrix3));
        let (Some((r0, s0)), Some((r1, s1))) = (a, b) else {
            return error("the transforms between which this moves are not both invertible");
        };
        let q0 = DQuat::from_mat3(&r0).normalize();
        let mut q1 = DQuat::from_mat3(&r1).normalize();
        // A rotation has two quaternions: the nearer one gives the shorter arc.
        if q0.dot(q1) < 0.0 {
            q1 = -q1;
        }
        let angle = acos(q0.dot(q1));
        let angle = (angle > 1e-7).then_some(angle);
        let translation = [from.translation, to.translation];
        Ok(Motion { translation, rotation: [q0, q1], stretch: [s0, s1], angle })
    }

    /// The placement at a time in 0..=1.
    pub(crate) fn at(&self, time: f64) -> DAffine3 {
        let before = 1.0 - time;
        let rotation = match self.angle {
            None => self.rotation[0],
            Some(angle) => {
                let sin_angle = sin(angle);
                let rotation_at = self.rotation[0] * (sin(before * angle) / sin_angle)
                    + self.rotation[1] * (sin(time * angle) / sin_angle);
                rotation_at.normalize()
            }
        };
        DAffine3 {
            matrix3: DMat3::from_quat(rotation) * (self.stretch[0] * before + self.stretch[1] * time),
            translation: self.translation[0] * before + self.translation[1] * time,
        }
    }

    /// Bounds of an object from one time to another, given its bounds in object space.
    pub(crate) fn bounds(&self, own: &Bounds, open: f64, close: f64) -> Bounds {
        /// At most 180 / 64 degrees of rotation per step.
        const STEPS: u32 = 64;
        let corners_at = |i: u32| {
            let placed = self.at(open + (close - open) * f64::from(i) / f64::from(STEPS));
            own.corners().map(|corner| placed.transform_point3(corner))
        };
        let mut bounds = Bounds::EMPTY;
        let mut before = corners_at(0);
        for i in 1..=STEPS {
            let corners = corners_at(i);
            // Within a step a corner is at most half of its path from the nearer of its two positions, and the path
            // is little longer than the chord. Points between corners stay between them at all times.
            let distance = corners.iter().zip(&before).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
            for corner in before.into_iter().chain(corners) {
                let reach = DVec3::splat(0.51 * distance);
                bounds = bounds.union(&Bounds { min: corner - reach, max: corner + reach });
            }
            before = corners;
        }
        bounds
    }
}

/// What moves something from where it is at time 0: a camera or a light, whose own description is that of time 0.
#[derive(Clone, Debug)]
pub(crate) struct Displacement {
    motion: Motion,
    /// From the world to the space of what moves, at time 0.
    to_start: DAffine3,
}

impl Displacement {
    /// Of something placed at `start`, to where `by` moves it in the world until time 1. Its own origin moves on a line.
    ///
    /// Errors: a motion that is not invertible, or that mirrors.
    pub(crate) fn new(start: &DAffine3, by: &DAffine3) -> Result<Displacement, SceneError> {
        let motion = Motion::new(start, &(*by * *start))?;
        Ok(Displacement { motion, to_start: start.inverse() })
    }

    /// From the world at time 0 to that at another time in 0..=1.
    pub(crate) fn at(&self, time: f64) -> DAffine3 {
        self.motion.at(time) * self.to_start
    }

    /// Bounds from one time to another of what has these bounds at time 0.
    pub(crate) fn bounds(&self, start: &Bounds, open: f64, close: f64) -> Bounds {
        self.motion.bounds(&start.transformed(&self.to_start), open, close)
    }
}

/// Polar decomposition into a rotation and a symmetric stretch, which also takes a mirroring.
fn polar(m: &DMat3) -> Option<(DMat3, DMat3)> {
    let side = m.determinant().signum();
    // Newton's iteration converges quadratically to the nearest rotation; the scale is removed first.
    let size = m.determinant().abs();
    if !(size > 0.0 && size.is_finite()) {
        return None;
    }
    let mut r = *m * (side / crate::math::elementary::cbrt(size));
    for _ in 0..100 {
        let next = (r + r.inverse().transpose()) * 0.5;
        let change = (next - r).to_cols_array().iter().fold(0.0_f64, |a, v| a.max(v.abs()));
        r = next;
        if change <= 1e-15 || change.is_nan() {
            break;
        }
    }
    r.is_finite().then(|| (r, r.transpose() * *m))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schema::transform::rotation;

    fn placed(m: DMat3, t: DVec3) -> DAffine3 {
        DAffine3 { matrix3: m, translation: t }
    }

    fn difference(a: &DAffine3, b: &DAffine3) -> f64 {
        a.to_cols_array().iter().zip(b.to_cols_array()).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()))
    }

    #[test]
    fn motions_begin_and_end_where_they_should() {
        let shear = DMat3::from_cols(DVec3::new(2.0, 0.1, 0.0), DVec3::new(0.5, 1.0, 0.3), DVec3::Z * 3.0);
        for (from, to) in [
            (DMat3::IDENTITY, rotation(DVec3::Y, 90.0)),
            (rotation(DVec3::X, 20.0) * shear, rotation(DVec3::new(0.6, 0.8, 0.0), 175.0) * 5.0),
            (DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 2.0)), rotation(DVec3::Z, -77.0) * -1e-3),
            (shear * 1e6, shear * 1e6),
        ] {
            let (from, to) = (placed(from, DVec3::new(1.0, 2.0, 3.0)), placed(to, DVec3::NEG_X));
            let motion = Motion::new(&from, &to).unwrap();
            let size = from.matrix3.to_cols_array().iter().fold(5.0_f64, |a, v| a.max(v.abs()));
            assert!(difference(&motion.at(0.0), &from) < 1e-13 * size, "{from}");
            assert!(difference(&motion.at(1.0), &to) < 1e-13 * size, "{to}");
        }
        // Mirrored at one end only.
        let mirror = placed(DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)), DVec3::ZERO);
        assert!(Motion::new(&DAffine3::IDENTITY, &mirror).is_err());
    }

    #[test]
    fn rotations_keep_an_even_pace_and_translations_a_straight_line() {
        let to = placed(rotation(DVec3::Z, 120.0), DVec3::new(4.0, 0.0, 0.0));
        let motion = Motion::new(&DAffine3::IDENTITY, &to).unwrap();
        for i in 0..=12 {
            let time = f64::from(i) / 12.0;
            let expected = placed(rotation(DVec3::Z, 120.0 * time), DVec3::new(4.0 * time, 0.0, 0.0));
            assert!(difference(&motion.at(time), &expected) < 1e-14, "{time}");
        }
        // The shorter arc.
        let to = placed(rotation(DVec3::Z, 200.0), DVec3::ZERO);
        let half = Motion::new(&DAffine3::IDENTITY, &to).unwrap().at(0.5);
        assert!((half.transform_vector3(DVec3::X) - rotation(DVec3::Z, -80.0) * DVec3::X).length() < 1e-14);
    }

    #[test]
    fn bounds_hold_everything_all_the_time() {
        let own = Bounds { min: DVec3::new(1.0, -0.5, -2.0), max: DVec3::new(3.0, 0.5, 2.0) };
        let to = placed(rotation(DVec3::new(0.0, 0.6, 0.8), 170.0) * 2.0, DVec3::new(0.0, 5.0, 0.0));
        let motion = Motion::new(&DAffine3::IDENTITY, &to).unwrap();
        for (open, close) in [(0.0, 1.0), (0.3, 0.35)] {
            let bounds = motion.bounds(&own, open, close);
            for i in 0..=1000 {
                let placed = motion.at(open + (close - open) * f64::from(i) / 1000.0);
                for corner in own.corners() {
                    let p = placed.transform_point3(corner);
                    assert!(p.cmpge(bounds.min).all() && p.cmple(bounds.max).all(), "{i} {p}");
                }
            }
            // And not much larger.
            assert!(bounds.size().max_element() < 16.0);
        }
    }
}

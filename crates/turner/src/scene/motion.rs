//! Objects that move while the shutter is open.
//!
//! Between two placements the translation and what scales and shears go in straight lines, the rotation at an even pace about one
//! axis the shorter way (Shoemake & Duff 1992, "Matrix animation and polar decomposition"; Shoemake 1985 for the rotation).
//! Rays carry their moment, and are taken into the object's space as it lies then.

use glam::DQuat;

use crate::math::elementary::{acos, sin};
use crate::math::{Bounds, DAffine3, DMat3, DVec3};
use crate::schema::{ErrorCode, SceneError};

/// A motion from one placement, at the moment 0, to another, at 1.
#[derive(Clone, Debug)]
pub(crate) struct Motion {
    translation: [DVec3; 2],
    rotation: [DQuat; 2],
    stretch: [DMat3; 2],
    /// The angle between the two quaternions; none if it is too small to turn by.
    angle: Option<f64>,
}

impl Motion {
    /// Between two transforms that can be undone.
    pub(crate) fn new(from: &DAffine3, to: &DAffine3) -> Result<Motion, SceneError> {
        let error = |message: &str| Err(SceneError::new(ErrorCode::Transform, message));
        if from.matrix3.determinant() * to.matrix3.determinant() <= 0.0 {
            return error(
                "an object cannot move into its mirror image: `transform` mirrors and `motion` does not, or the other way",
            );
        }
        let [a, b] = [from, to].map(|t| polar(&t.matrix3));
        let (Some((r0, s0)), Some((r1, s1))) = (a, b) else {
            return error("the transforms between which this object moves cannot be undone");
        };
        let q0 = DQuat::from_mat3(&r0).normalize();
        let mut q1 = DQuat::from_mat3(&r1).normalize();
        // Of two quaternions for one rotation the nearer: the shorter way.
        if q0.dot(q1) < 0.0 {
            q1 = -q1;
        }
        let angle = acos(q0.dot(q1));
        let angle = (angle > 1e-7).then_some(angle);
        let translation = [from.translation, to.translation];
        Ok(Motion { translation, rotation: [q0, q1], stretch: [s0, s1], angle })
    }

    /// The placement at a moment of 0..=1.
    pub(crate) fn at(&self, time: f64) -> DAffine3 {
        let before = 1.0 - time;
        let rotation = match self.angle {
            None => self.rotation[0],
            Some(angle) => {
                let whole = sin(angle);
                let turned = self.rotation[0] * (sin(before * angle) / whole)
                    + self.rotation[1] * (sin(time * angle) / whole);
                turned.normalize()
            }
        };
        DAffine3 {
            matrix3: DMat3::from_quat(rotation) * (self.stretch[0] * before + self.stretch[1] * time),
            translation: self.translation[0] * before + self.translation[1] * time,
        }
    }

    /// Bounds of something from one moment to another, its own bounds given.
    pub(crate) fn bounds(&self, own: &Bounds, open: f64, close: f64) -> Bounds {
        /// At most 180 / 64 degrees between two of them.
        const STEPS: u32 = 64;
        let corners_at = |i: u32| {
            let placed = self.at(open + (close - open) * f64::from(i) / f64::from(STEPS));
            own.corners().map(|corner| placed.transform_point3(corner))
        };
        let mut bounds = Bounds::EMPTY;
        let mut before = corners_at(0);
        for i in 1..=STEPS {
            let corners = corners_at(i);
            // Between two moments a corner is no farther from the nearer of its places than half of its way, and that is little
            // longer than the straight one. What lies between corners lies between them at any moment.
            let way = corners.iter().zip(&before).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
            for corner in before.into_iter().chain(corners) {
                let reach = DVec3::splat(0.51 * way);
                bounds = bounds.union(&Bounds { min: corner - reach, max: corner + reach });
            }
            before = corners;
        }
        bounds
    }
}

/// A matrix as a rotation times a symmetric one that scales and shears; mirrors are left to the latter.
fn polar(m: &DMat3) -> Option<(DMat3, DMat3)> {
    let side = m.determinant().signum();
    // Newton's iteration converges to the nearest rotation, quadratically; the scale is taken out first.
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
        // Mirrored at one end alone.
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
        // Wheels turn the shorter way.
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
            // Not much more than that.
            assert!(bounds.size().max_element() < 16.0);
        }
    }
}

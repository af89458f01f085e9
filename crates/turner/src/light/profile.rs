//! IES profiles: the measured intensity of a light in each direction.
//!
//! Angles are those of type C photometry (IES LM-63). The vertical angle is 0 along the light's axis, where it
//! points, and 180 behind it; the horizontal angle goes around the axis.
//!
//! ```text
//!             light
//!       180°    |
//!        :    __o__  90°
//!               |\
//!               | \ vertical angle
//!               v
//!          axis, 0°
//! ```

use std::f64::consts::PI;
use std::sync::Arc;

use crate::math::DVec3;
use crate::math::elementary::{angle, cos};
use crate::schema::{ErrorCode, LightProfile, ProfileFile, SceneError, choice};

choice! {
    /// How the values of an IES file are used.
    pub enum ProfileUnits {
        /// Relative to the largest value: in that direction the light has its `intensity`.
        Relative = "relative",
        /// Candela: `intensity` multiplies them.
        Candela = "candela",
    }
}

/// An IES profile with its orientation in the world.
#[derive(Clone, Debug)]
pub(super) struct OrientedProfile {
    profile: Arc<LightProfile>,
    /// The axis, and the directions of the horizontal angles 0 and 90.
    axis: DVec3,
    zero: DVec3,
    quarter: DVec3,
    /// Degrees added to horizontal angles.
    turn: f64,
    scale: f32,
}

impl OrientedProfile {
    /// Orients a profile along an axis of any length, rotated about it by `rotation` degrees. The horizontal angle 0
    /// points to +x, projected perpendicular to the axis. Seen along the axis (from above, for a light that points
    /// down), angles run counter-clockwise.
    pub(super) fn new(
        file: &ProfileFile,
        axis: DVec3,
        rotation: f64,
        units: ProfileUnits,
    ) -> Result<OrientedProfile, SceneError> {
        let axis = axis.try_normalize().ok_or_else(|| {
            SceneError::new(ErrorCode::OutOfRange, "the axis of an IES profile must not be zero")
        })?;
        let flat = |v: DVec3| (v - axis * axis.dot(v)).try_normalize();
        // For an axis along x the horizontal angle 0 points to z.
        let along_x = axis.x.abs() > 1.0 - 1e-9;
        let zero = if along_x { None } else { flat(DVec3::X) }.or(flat(DVec3::Z)).unwrap_or(DVec3::X);
        let peak = file.data.peak();
        let scale = match units {
            ProfileUnits::Relative if peak > 0.0 => 1.0 / peak,
            _ => 1.0,
        };
        let turn = -rotation.rem_euclid(360.0);
        Ok(OrientedProfile { profile: file.data.clone(), axis, zero, quarter: zero.cross(axis), turn, scale })
    }

    /// The axis, and the cosine of the angle beyond which the profile is 0.
    pub(super) fn cone(&self) -> (DVec3, f64) {
        // A small margin: rounding must not cut off a direction at the edge.
        let last = self.profile.vertical().last().map_or(180.0, |v| v + 1e-6);
        (self.axis, if last >= 180.0 { -1.0 } else { cos(last * PI / 180.0) })
    }

    /// The largest factor.
    pub(super) fn peak(&self) -> f64 {
        f64::from(self.profile.peak() * self.scale)
    }

    /// The factor for light that travels in a direction of any length.
    #[inline]
    pub(super) fn factor(&self, d: DVec3) -> f32 {
        let (x, y) = (d.dot(self.zero), d.dot(self.quarter));
        let degrees = 180.0 / PI;
        let vertical = angle((x * x + y * y).sqrt(), d.dot(self.axis)) * degrees;
        let horizontal = (angle(y, x) * degrees + self.turn).rem_euclid(360.0);
        self.profile.candela(vertical, horizontal) * self.scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(profile: LightProfile) -> ProfileFile {
        ProfileFile { uri: "lamp.ies".into(), data: Arc::new(profile) }
    }

    #[test]
    fn intensities_are_interpolated() {
        let candela = vec![10.0, 20.0, 0.0, 50.0, 60.0, 40.0, 10.0, 20.0, 0.0];
        let p = LightProfile::new(vec![0.0, 45.0, 90.0], vec![0.0, 180.0, 360.0], candela).unwrap();
        for (vertical, horizontal, expected) in [
            (0.0, 0.0, 10.0),
            (0.0, 180.0, 50.0),
            (45.0, 180.0, 60.0),
            (22.5, 0.0, 15.0),
            (22.5, 90.0, 35.0),
            (67.5, 270.0, 30.0),
            (90.0, 360.0, 0.0),
            (90.0, 180.0, 40.0),
            (90.1, 180.0, 0.0),
            (180.0, 0.0, 0.0),
        ] {
            assert!((p.candela(vertical, horizontal) - expected).abs() < 1e-4, "{vertical} {horizontal}");
        }
        assert_eq!(p.peak(), 60.0);
    }

    #[test]
    fn inconsistent_profiles_are_refused() {
        let one = || vec![1.0];
        assert!(LightProfile::new(vec![0.0], vec![0.0], one()).is_ok());
        for (vertical, horizontal, candela) in [
            (vec![], vec![0.0], vec![]),
            (vec![181.0], vec![0.0], one()),
            (vec![f64::NAN], vec![0.0], one()),
            (vec![5.0, 5.0], vec![0.0], vec![1.0; 2]),
            (vec![0.0], vec![], vec![]),
            (vec![0.0], vec![10.0], one()),
            (vec![0.0], vec![0.0, 90.0], vec![1.0; 2]),
            (vec![0.0], vec![0.0, 200.0, 100.0, 360.0], vec![1.0; 4]),
            (vec![0.0], vec![0.0], vec![1.0; 2]),
            (vec![0.0], vec![0.0], vec![-1.0]),
            (vec![0.0], vec![0.0], vec![f32::INFINITY]),
        ] {
            assert!(LightProfile::new(vertical, horizontal, candela).is_err());
        }
    }

    #[test]
    fn profiles_are_oriented_by_axis_and_rotation() {
        // Values differ only perpendicular to the axis; 8 straight ahead.
        let candela = vec![8.0, 1.0, 8.0, 2.0, 8.0, 3.0, 8.0, 4.0, 8.0, 1.0];
        let horizontal = vec![0.0, 90.0, 180.0, 270.0, 360.0];
        let p = file(LightProfile::new(vec![0.0, 90.0], horizontal, candela).unwrap());
        let profile = OrientedProfile::new(&p, DVec3::NEG_Y, 0.0, ProfileUnits::Candela).unwrap();
        for (d, expected) in [
            (DVec3::NEG_Y, 8.0),
            (DVec3::X, 1.0),
            (DVec3::NEG_Z, 2.0),
            (DVec3::NEG_X, 3.0),
            (DVec3::Z, 4.0),
            (DVec3::new(0.0, 1.0, 0.2), 0.0),
            (DVec3::new(1.0, 0.0, 1.0) * 30.0, 2.5),
        ] {
            assert!((profile.factor(d) - expected).abs() < 1e-5, "{d}: {}", profile.factor(d));
        }
        let turned = OrientedProfile::new(&p, DVec3::NEG_Y, 90.0, ProfileUnits::Relative).unwrap();
        assert!((turned.factor(DVec3::NEG_Z) - 1.0 / 8.0).abs() < 1e-6, "{}", turned.factor(DVec3::NEG_Z));
        for axis in [DVec3::X, DVec3::NEG_X, DVec3::new(1.0, 1e-5, 0.0), DVec3::new(2.0, -3.0, 1.0)] {
            let profile = OrientedProfile::new(&p, axis, -33.0, ProfileUnits::Relative).unwrap();
            assert!((profile.factor(axis) - 1.0).abs() < 1e-6 && profile.factor(-axis) == 0.0);
        }
        assert!(OrientedProfile::new(&p, DVec3::ZERO, 0.0, ProfileUnits::Relative).is_err());
        let dark = file(LightProfile::new(vec![0.0], vec![0.0], vec![0.0]).unwrap());
        let dark = OrientedProfile::new(&dark, DVec3::X, 0.0, ProfileUnits::Relative).unwrap();
        assert_eq!(dark.factor(DVec3::X), 0.0);
    }
}

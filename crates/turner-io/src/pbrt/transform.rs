//! Transforms of directives. A matrix is written by columns; points are column vectors.

pub(super) use crate::scene_import::is_sound;
use turner::math::elementary::tan;
use turner::math::{DAffine3, DMat3, DVec3, radians};
use turner::schema::transform::rotation;

/// The affine map of sixteen numbers, and whether the last row is 0 0 0 1 (otherwise it is ignored). `None` if
/// the last number is 0.
pub(super) fn of_numbers(m: &[f64; 16]) -> Option<(DAffine3, bool)> {
    let column = |i: usize| DVec3::new(m[i], m[i + 1], m[i + 2]) / m[15];
    let is_affine = [m[3], m[7], m[11]].iter().all(|v| v.abs() <= 1e-6 * m[15].abs());
    let matrix = DMat3::from_cols(column(0), column(4), column(8));
    (m[15] != 0.0).then(|| (DAffine3::from_mat3_translation(matrix, column(12)), is_affine))
}

/// Rotation about an axis of any length but 0.
pub(super) fn rotate(degrees: f64, axis: DVec3) -> Option<DAffine3> {
    Some(DAffine3::from_mat3(rotation(axis.try_normalize()?, degrees)))
}

/// World to camera space; the camera looks along +z, y is up, x to the right (left-handed).
pub(super) fn look_at(eye: DVec3, look: DVec3, up: DVec3) -> Option<DAffine3> {
    let forward = (look - eye).try_normalize()?;
    let right = up.cross(forward).try_normalize()?;
    let up = forward.cross(right);
    let camera = DAffine3::from_mat3_translation(DMat3::from_cols(right, up, forward), eye);
    Some(camera.inverse())
}

/// Half the height of the screen at distance 1, for a field of view in degrees.
pub(super) fn half_height(fov: f64) -> f64 {
    tan(radians(fov.clamp(1e-6, 179.999)) / 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrices_are_written_by_columns() {
        let mut m = [0.0; 16];
        (m[0], m[5], m[10], m[15]) = (1.0, 2.0, 3.0, 1.0);
        (m[12], m[13], m[14]) = (7.0, 8.0, 9.0);
        let (t, is_affine) = of_numbers(&m).unwrap();
        assert!(is_affine);
        assert_eq!(t.transform_point3(DVec3::ONE), DVec3::new(8.0, 10.0, 12.0));
        m[3] = 0.5;
        assert_eq!(of_numbers(&m), Some((t, false)));
        m[15] = 0.0;
        assert_eq!(of_numbers(&m), None);
    }

    #[test]
    fn cameras_look_along_z() {
        let t = look_at(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, DVec3::Y).unwrap();
        // The camera looks along −z with y up; left-handed, its x is the world's −x.
        assert!((t.transform_point3(DVec3::ZERO) - DVec3::new(0.0, 0.0, 5.0)).length() < 1e-12);
        assert!((t.transform_vector3(DVec3::X) - DVec3::NEG_X).length() < 1e-12);
        assert_eq!(look_at(DVec3::ZERO, DVec3::ZERO, DVec3::Y), None);
        assert_eq!(look_at(DVec3::ZERO, DVec3::Y, DVec3::Y), None);
    }
}

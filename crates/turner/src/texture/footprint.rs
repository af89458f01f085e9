//! How much of a texture one look-up stands for.
//!
//! The part of a surface that a ray's cone covers is taken for the parallelogram of two axes (full widths, not radii). It goes through the mapping by its derivatives, as
//! in Heckbert 1989, "Fundamentals of texture mapping and image warping": axes in the space of the object become axes in texture coordinates.

use crate::math::{DVec2, DVec3};

/// The part of a surface that a look-up stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// Its axes in the space of the object.
    pub p: [DVec3; 2],
    /// Its axes in the first set of (u, v).
    pub uv: [DVec2; 2],
}

impl Footprint {
    /// The axes, in the world, of what a cone of diameter `width` around a ray of unit `direction` covers of a plane with the unit normal `n`: across
    /// the ray's inclination, and along it, where it is longer.
    pub fn of_cone(direction: DVec3, n: DVec3, width: f64) -> [DVec3; 2] {
        /// Beyond this inclination footprints grow no longer.
        const LEAST_COSINE: f64 = 1e-4;
        let cosine = direction.dot(n);
        match (direction - n * cosine).try_normalize() {
            Some(along) => [width * n.cross(along), width / cosine.abs().max(LEAST_COSINE) * along],
            None => {
                let across = n.any_orthonormal_vector();
                [width * across, width * n.cross(across)]
            }
        }
    }
}

/// A parallelogram in the plane of a picture, texels wide, as the ellipse that it holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ellipse {
    /// Its longer axis, full length.
    pub(super) major: DVec2,
    /// The length of its longer axis.
    pub(super) length: f64,
    /// The length of its shorter axis.
    pub(super) width: f64,
}

impl Ellipse {
    /// Of two sides: the singular values of the matrix with these columns, and the direction of the larger.
    pub(super) fn new([a, b]: [DVec2; 2]) -> Ellipse {
        let (xx, xy, yy) = (a.x * a.x + b.x * b.x, a.x * a.y + b.x * b.y, a.y * a.y + b.y * b.y);
        let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        let apart = (half * half + xy * xy).sqrt();
        let (length, width) = ((mean + apart).sqrt(), (mean - apart).max(0.0).sqrt());
        let direction = if half >= 0.0 { DVec2::new(half + apart, xy) } else { DVec2::new(xy, apart - half) };
        let direction = direction.try_normalize().unwrap_or(DVec2::X);
        Ellipse { major: length * direction, length, width }
    }
}

/// Footprints are clamped to ±this in texture coordinates, so that their squares stay finite.
const LARGEST: f64 = 1e9;

/// A change of texture coordinates as it can be worked with: NaN is none, infinity a large one.
#[inline]
pub(super) fn sound(v: DVec3) -> DVec3 {
    let one = |v: f64| if v.is_nan() { 0.0 } else { v.clamp(-LARGEST, LARGEST) };
    DVec3::new(one(v.x), one(v.y), one(v.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inclined_cones_cover_long_ellipses() {
        let n = DVec3::Y;
        let d = DVec3::new(0.6, -0.8, 0.0);
        let [across, along] = Footprint::of_cone(d, n, 0.5);
        assert!((across.length() - 0.5).abs() < 1e-12 && (along.length() - 0.5 / 0.8).abs() < 1e-12);
        assert!(across.dot(d).abs() < 1e-12 && across.dot(n).abs() < 1e-12 && along.dot(n).abs() < 1e-12);
        let [a, b] = Footprint::of_cone(-n, n, 0.5);
        assert!(
            (a.length() - 0.5).abs() < 1e-12 && (b.length() - 0.5).abs() < 1e-12 && a.dot(b).abs() < 1e-12
        );
        let [_, grazing] = Footprint::of_cone(DVec3::X, n, 1.0);
        assert!(grazing.is_finite());
    }

    #[test]
    fn ellipses_are_those_of_their_parallelograms() {
        let e = Ellipse::new([DVec2::new(3.0, 0.0), DVec2::new(0.0, 1.0)]);
        assert_eq!((e.length, e.width), (3.0, 1.0));
        assert!((e.major.abs() - DVec2::new(3.0, 0.0)).length() < 1e-12);
        let e = Ellipse::new([DVec2::new(0.0, -5.0), DVec2::new(2.0, 0.0)]);
        assert!((e.major.abs() - DVec2::new(0.0, 5.0)).length() < 1e-12 && (e.width - 2.0).abs() < 1e-12);
        // Turned by 45 degrees.
        let e = Ellipse::new([DVec2::new(4.0, 4.0), DVec2::new(-1.0, 1.0)]);
        assert!((e.length - 32f64.sqrt()).abs() < 1e-9 && (e.width - 2f64.sqrt()).abs() < 1e-9);
        assert!((e.major.x.abs() - 4.0).abs() < 1e-9 && e.major.x * e.major.y > 0.0);
        // Sheared: the area is kept.
        let e = Ellipse::new([DVec2::new(2.0, 0.0), DVec2::new(7.0, 1.5)]);
        assert!((e.length * e.width - 3.0).abs() < 1e-9);
        assert_eq!(Ellipse::new([DVec2::ZERO; 2]).length, 0.0);
    }
}

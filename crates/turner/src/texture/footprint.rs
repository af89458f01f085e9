//! Footprints: the area of a texture that one lookup should average.
//!
//! A ray cone covers an ellipse on a surface. It is represented by two axes (full lengths, not radii), one across the
//! inclination of the ray and one along it:
//!
//! ```text
//!            \    |    /
//!             \ θ |n  /     cone of diameter w
//!              \  |  /
//!      _________\_|_/_________
//!                <-->               w across, w / cos θ along
//! ```
//!
//! The derivatives of the mapping take these axes from the space of the object to texture coordinates (Heckbert 1989,
//! "Fundamentals of texture mapping and image warping"). There they span a parallelogram, whose inscribed ellipse is
//! the region that an elliptical weighted average (EWA) filter would cover. Image textures approximate it by several
//! mipmap lookups along its major axis, see `mipmap`; procedural textures integrate or fade out their detail.

use crate::math::{DVec2, DVec3};

/// The part of a surface that a lookup represents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// Axes in the space of the object.
    pub p: [DVec3; 2],
    /// Axes in (u, v) of the first set.
    pub uv: [DVec2; 2],
    /// Whether image textures average it by a single isotropic lookup, as after non-specular scattering.
    pub isotropic: bool,
}

impl Footprint {
    /// The axes, in world space, of the area that a cone of diameter `width` around a ray with unit `direction`
    /// covers on a plane with unit normal `n`: across the inclination, and along it, where the area is longer.
    pub fn of_cone(direction: DVec3, n: DVec3, width: f64) -> [DVec3; 2] {
        /// At more grazing angles footprints do not grow further.
        const MIN_COSINE: f64 = 1e-4;
        let cosine = direction.dot(n);
        match (direction - n * cosine).try_normalize() {
            Some(along) => [width * n.cross(along), width / cosine.abs().max(MIN_COSINE) * along],
            None => {
                let across = n.any_orthonormal_vector();
                [width * across, width * n.cross(across)]
            }
        }
    }
}

/// The ellipse inscribed in a parallelogram of the image plane, in texels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ellipse {
    /// Major axis, full length.
    pub(super) major: DVec2,
    /// Length of the major axis.
    pub(super) length: f64,
    /// Length of the minor axis.
    pub(super) width: f64,
}

impl Ellipse {
    /// From two sides: the singular values of the matrix with these columns, and the direction of the larger.
    pub(super) fn new([a, b]: [DVec2; 2]) -> Ellipse {
        let (xx, xy, yy) = (a.x * a.x + b.x * b.x, a.x * a.y + b.x * b.y, a.y * a.y + b.y * b.y);
        let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        let difference = (half * half + xy * xy).sqrt();
        let (length, width) = ((mean + difference).sqrt(), (mean - difference).max(0.0).sqrt());
        let direction =
            if half >= 0.0 { DVec2::new(half + difference, xy) } else { DVec2::new(xy, difference - half) };
        let direction = direction.try_normalize().unwrap_or(DVec2::X);
        Ellipse { major: length * direction, length, width }
    }
}

/// Footprints are clamped to ± this in texture coordinates, so that their squares stay finite.
const MAX_CHANGE: f64 = 1e9;

/// Makes a derivative finite: NaN becomes 0, infinities become large values.
#[inline]
pub(super) fn finite_change(v: DVec3) -> DVec3 {
    let one = |v: f64| if v.is_nan() { 0.0 } else { v.clamp(-MAX_CHANGE, MAX_CHANGE) };
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
        // Rotated by 45 degrees.
        let e = Ellipse::new([DVec2::new(4.0, 4.0), DVec2::new(-1.0, 1.0)]);
        assert!((e.length - 32f64.sqrt()).abs() < 1e-9 && (e.width - 2f64.sqrt()).abs() < 1e-9);
        assert!((e.major.x.abs() - 4.0).abs() < 1e-9 && e.major.x * e.major.y > 0.0);
        // Sheared: the area is unchanged.
        let e = Ellipse::new([DVec2::new(2.0, 0.0), DVec2::new(7.0, 1.5)]);
        assert!((e.length * e.width - 3.0).abs() < 1e-9);
        assert_eq!(Ellipse::new([DVec2::ZERO; 2]).length, 0.0);
    }
}

//! Mappings from surface points to texture coordinates, and their derivatives.

use super::footprint::finite_change;
use crate::math::elementary::{acos, atan2};
use crate::math::{DVec2, DVec3};
use crate::schema::choice;

choice! {
    /// Where texture coordinates come from.
    pub enum Mapping {
        /// The surface's (u, v), scaled from 0..1 to −1..1.
        Uv = "uv",
        /// The position in object space: the pattern fills the solid.
        Solid = "solid",
        /// The position in world space: all objects share one pattern and move through it.
        World = "world",
        /// The position projected along z: x and y, the same for every z, as from a distant slide projector.
        Planar = "planar",
        /// The direction from the origin as on a sphere: once around y from left to right, and upwards from pole to
        /// pole.
        Spherical = "spherical",
        /// As on the side of a cylinder: once around y from left to right, and upwards along y from −1 to 1.
        Cylindrical = "cylindrical",
        /// As "spherical", with the position in world space: all objects share one pattern.
        WorldSpherical = "world-spherical",
        /// As "cylindrical", with the position in world space: all objects share one pattern.
        WorldCylindrical = "world-cylindrical",
        /// Projections along x, y and z, blended by the surface normal (`blend`): no seams and no stretching on any
        /// shape.
        Triplanar = "triplanar",
    }
}

/// One of the three projections of a triplanar mapping, and the side it projects from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Side {
    /// 0 along x, 1 along y, 2 along z.
    pub(super) axis: usize,
    /// 1 for surfaces that face along the axis, −1 for those that face against it. Text is not mirrored on either side.
    pub(super) sign: f64,
}

impl Side {
    /// The directions of s and t, as on the faces of a box.
    pub(super) fn directions(self) -> [DVec3; 2] {
        match self.axis {
            0 => [DVec3::new(0.0, 0.0, -self.sign), DVec3::Y],
            1 => [DVec3::X, DVec3::new(0.0, 0.0, -self.sign)],
            _ => [DVec3::new(self.sign, 0.0, 0.0), DVec3::Y],
        }
    }

    #[inline]
    fn project(self, q: DVec3) -> DVec3 {
        let [s, t] = self.directions();
        DVec3::new(s.dot(q), t.dot(q), 0.0)
    }
}

impl Mapping {
    /// Whether positions are in world space.
    #[inline]
    pub(super) fn is_in_world(self) -> bool {
        matches!(self, Mapping::World | Mapping::WorldSpherical | Mapping::WorldCylindrical)
    }

    /// Texture coordinates of a point in the mapping's space; `side` is for triplanar mappings.
    #[inline]
    pub(super) fn project(self, q: DVec3, side: Side) -> DVec3 {
        use std::f64::consts::PI;
        match self {
            Mapping::Uv | Mapping::Solid | Mapping::World => q,
            Mapping::Planar => DVec3::new(q.x, q.y, 0.0),
            Mapping::Spherical | Mapping::WorldSpherical => {
                let length = q.length();
                let height = if length > 0.0 { q.y / length } else { 0.0 };
                DVec3::new(atan2(q.x, q.z) / PI, 1.0 - 2.0 * acos(height.clamp(-1.0, 1.0)) / PI, 0.0)
            }
            Mapping::Cylindrical | Mapping::WorldCylindrical => DVec3::new(atan2(q.x, q.z) / PI, q.y, 0.0),
            Mapping::Triplanar => side.project(q),
        }
    }

    /// The derivative of the texture coordinates as the point `q` moves along `d`. It has no jump at seams.
    #[inline]
    pub(super) fn change(self, q: DVec3, d: DVec3, side: Side) -> DVec3 {
        use std::f64::consts::PI;
        let around = || (q.z * d.x - q.x * d.z) / ((q.x * q.x + q.z * q.z) * PI);
        finite_change(match self {
            Mapping::Uv | Mapping::Solid | Mapping::World => d,
            Mapping::Planar => DVec3::new(d.x, d.y, 0.0),
            Mapping::Spherical | Mapping::WorldSpherical => {
                let out = DVec2::new(q.x, q.z).length();
                let rises = (d.y * out * out - q.y * (q.x * d.x + q.z * d.z)) / (out * q.length_squared());
                DVec3::new(around(), 2.0 * rises / PI, 0.0)
            }
            Mapping::Cylindrical | Mapping::WorldCylindrical => DVec3::new(around(), d.y, 0.0),
            Mapping::Triplanar => side.project(d),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRONT: Side = Side { axis: 2, sign: 1.0 };

    #[test]
    fn known_points() {
        let close = |mapping: Mapping, q: [f64; 3], expected: [f64; 2]| {
            let c = mapping.project(DVec3::from(q), FRONT);
            assert!(
                (c - DVec3::new(expected[0], expected[1], 0.0)).length() < 1e-12,
                "{mapping:?} {q:?}: {c}"
            );
        };
        close(Mapping::Planar, [0.3, -0.7, 9.0], [0.3, -0.7]);
        // Front: the centre; right: a quarter turn; up: the upper edge.
        for r in [1.0, 7.0] {
            close(Mapping::Spherical, [0.0, 0.0, r], [0.0, 0.0]);
            close(Mapping::Spherical, [r, 0.0, 0.0], [0.5, 0.0]);
            close(Mapping::Spherical, [-r, 0.0, 0.0], [-0.5, 0.0]);
            close(Mapping::Spherical, [0.0, r, r], [0.0, 0.5]);
            close(Mapping::Cylindrical, [r, 0.25, 0.0], [0.5, 0.25]);
        }
        assert_eq!(Mapping::Spherical.project(DVec3::Y, FRONT).y, 1.0);
        assert_eq!(Mapping::Spherical.project(DVec3::NEG_Y, FRONT).y, -1.0);
        assert!(Mapping::Spherical.project(DVec3::ZERO, FRONT).is_finite());
        for (axis, sign, n) in [
            (0, 1.0, DVec3::X),
            (0, -1.0, DVec3::NEG_X),
            (1, 1.0, DVec3::Y),
            (1, -1.0, DVec3::NEG_Y),
            (2, 1.0, DVec3::Z),
            (2, -1.0, DVec3::NEG_Z),
        ] {
            // Seen from outside, s points to the right and t upwards.
            let [s, t] = (Side { axis, sign }).directions();
            assert_eq!(s.cross(t), n);
        }
    }

    #[test]
    fn changes_are_derivatives() {
        let h = 1e-6;
        for mapping in [Mapping::Planar, Mapping::Spherical, Mapping::Cylindrical, Mapping::Triplanar] {
            for q in [DVec3::new(0.3, 0.4, 0.8), DVec3::new(-1.0, -0.2, 0.1), DVec3::new(2.0, 1.0, -3.0)] {
                for d in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(1.0, -2.0, 0.5)] {
                    let side = Side { axis: 0, sign: -1.0 };
                    let found = mapping.change(q, d, side);
                    let by_differences =
                        (mapping.project(q + h * d, side) - mapping.project(q - h * d, side)) / (2.0 * h);
                    assert!((found - by_differences).length() < 1e-6, "{mapping:?} {q} {d}");
                }
            }
            assert!(mapping.change(DVec3::ZERO, DVec3::X, FRONT).is_finite());
        }
        // Also at the seam.
        let seam = Mapping::Spherical.change(DVec3::new(0.0, 0.0, -1.0), DVec3::X, FRONT);
        assert!((seam.x + 1.0 / std::f64::consts::PI).abs() < 1e-12);
    }
}

//! The panorama: all directions in one picture, as a latitude-longitude map or as a square in which every pixel covers the
//! same solid angle (Clarberg 2008, "Fast equal-area mapping of the (hemi)sphere using SIMD").
//!
//! ```text
//!      .---------.        the square: a diamond around the upper hemisphere, the lower one in the corners
//!      |  / \  |          centre: up
//!      | / up \ |         right edge: right
//!      | \    / |         lower edge: forward
//!      |  \ /  |         corners: down
//!      '---------'
//! ```

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2, FRAC_PI_4, PI};

use super::clip::Clip;
use super::{CameraFrame, Handedness};
use crate::math::elementary::{asin, atan2, sin_cos};
use crate::math::{DVec2, DVec3, Ray};
use crate::schema::{Range, SceneError, Transform, choice, params};

choice! {
    /// How a panorama shows directions.
    pub enum PanoramaMapping {
        /// Columns are longitudes and rows latitudes, evenly spaced.
        LatitudeLongitude = "latitude-longitude",
        /// A square in which every pixel covers the same solid angle. Its centre is straight up, its corners are straight
        /// down, the middle of its right edge is to the right, that of its lower edge in the viewing direction.
        EqualArea = "equal-area",
    }
}

params! {
    /// A panorama of all directions around a point. With the mapping "latitude-longitude" columns are longitudes and rows
    /// latitudes, evenly spaced. The centre of the picture is the viewing direction, the left and right edges are behind
    /// the camera, the upper edge is straight up. Use a picture twice as wide as high; other aspect ratios are stretched.
    /// With the camera looking along −z and y up, the picture can be used unchanged as the environment map of another
    /// scene.
    pub struct EquirectangularDesc as "equirectangular" {
        /// Position of the camera.
        position: DVec3 = DVec3::new(0.0, 0.0, 5.0);
        /// A point in the viewing direction: the centre of the picture, or with "equal-area" the middle of its lower edge.
        look_at: DVec3 = DVec3::ZERO;
        /// Up direction in the picture. The poles are along its component perpendicular to the viewing direction.
        up: DVec3 = DVec3::Y;
        /// Handedness of the axes.
        handedness: Handedness = Handedness::Right;
        /// How the picture shows directions.
        mapping: PanoramaMapping = PanoramaMapping::LatitudeLongitude;
        /// Surfaces nearer to the camera than this, in scene units, are invisible.
        near: f64 = 0.0, in Range::NON_NEGATIVE;
        /// Surfaces farther from the camera than this, in scene units, are invisible. By default there is no limit.
        far: Option<f64> = None, in Range::POSITIVE;
        /// Motion blur: what moves the camera, in the space of the scene, from where it is at time 0 of the shutter to
        /// where it is at time 1.
        motion: Option<Transform> = None;
    }
    example r#"[camera]
type = "equirectangular"
position = [0, 1, 0]
look_at = [0, 1, -1]

[film]
width = 64
height = 32
"#
}

/// A prepared equirectangular camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equirectangular {
    pub(super) frame: CameraFrame,
    pub(super) clip: Clip,
    pub(super) mapping: PanoramaMapping,
}

impl EquirectangularDesc {
    /// Prepares it.
    pub fn prepare(&self) -> Result<Equirectangular, SceneError> {
        let frame = CameraFrame::new(self.position, self.look_at, self.up, self.handedness)?;
        Ok(Equirectangular { frame, clip: Clip::new(self.near, self.far)?, mapping: self.mapping })
    }
}

impl Equirectangular {
    /// The ray through a screen position, of unit direction. Positions beyond the edges of the screen continue across
    /// the pole or the edge.
    #[inline]
    pub(super) fn ray(&self, at: DVec2) -> Ray {
        let f = &self.frame;
        let [right, up, forward] = match self.mapping {
            PanoramaMapping::LatitudeLongitude => {
                let (sin_lon, cos_lon) = sin_cos(PI * at.x);
                let (sin_lat, cos_lat) = sin_cos(FRAC_PI_2 * at.y);
                let d = (f.forward * cos_lon + f.right * sin_lon) * cos_lat + f.up * sin_lat;
                return self.clip.of_ray(Ray::new(f.position, d), 1.0);
            }
            PanoramaMapping::EqualArea => of_square(at),
        };
        let d = f.right * right + f.up * up + f.forward * forward;
        self.clip.of_ray(Ray::new(f.position, d), 1.0)
    }

    /// The screen position of a unit direction along (right, up, forward).
    pub(super) fn place(&self, d: DVec3) -> DVec2 {
        match self.mapping {
            PanoramaMapping::LatitudeLongitude => {
                DVec2::new(atan2(d.x, d.z) / PI, asin(d.y.clamp(-1.0, 1.0)) * FRAC_2_PI)
            }
            PanoramaMapping::EqualArea => to_square(d),
        }
    }

    /// The area of the screen, of four in total, per solid angle around a direction whose part along `up` is given.
    pub(super) fn stretch(&self, up: f64) -> f64 {
        match self.mapping {
            PanoramaMapping::LatitudeLongitude => FRAC_2_PI / (PI * (1.0 - up * up).max(0.0).sqrt()),
            PanoramaMapping::EqualArea => 1.0 / PI,
        }
    }

    /// The angles that the picture covers from left to right and from the upper to the lower edge, as far as the distance
    /// between its pixels is concerned.
    pub(super) fn angles(&self) -> DVec2 {
        match self.mapping {
            PanoramaMapping::LatitudeLongitude => DVec2::new(2.0 * PI, PI),
            PanoramaMapping::EqualArea => DVec2::splat((4.0 * PI).sqrt()),
        }
    }
}

/// The direction along right, up and forward at a place in the square from −1 to 1, y upwards.
fn of_square(at: DVec2) -> [f64; 3] {
    let mut at = DVec2::new(at.x, -at.y);
    // Each edge of the octahedral square continues in its own other half.
    for axis in 0..2 {
        if at[axis].abs() > 1.0 {
            at[axis] = 2.0f64.copysign(at[axis]) - at[axis];
            at[1 - axis] = -at[1 - axis];
        }
    }
    let DVec2 { x, y } = at.abs();
    // Positive in the upper hemisphere.
    let inside = 1.0 - (x + y);
    let r = 1.0 - inside.abs();
    let (sin, cos) = sin_cos(if r == 0.0 { 1.0 } else { (y - x) / r + 1.0 } * FRAC_PI_4);
    let across = r * (2.0 - r * r).max(0.0).sqrt();
    [cos.copysign(at.x) * across, (1.0 - r * r).copysign(inside), sin.copysign(at.y) * across]
}

/// The inverse of [`of_square`].
fn to_square(d: DVec3) -> DVec2 {
    let DVec3 { x, z, .. } = d.abs();
    let r = (1.0 - d.y.abs()).max(0.0).sqrt();
    // The part of the quarter turn, from right to forward.
    let turn = atan2(z, x) * FRAC_2_PI;
    let (mut u, mut v) = (r - turn * r, turn * r);
    if d.y < 0.0 {
        (u, v) = (1.0 - v, 1.0 - u);
    }
    DVec2::new(u.copysign(d.x), -v.copysign(d.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_square_has_known_directions() {
        let is = |at: [f64; 2], expected: [f64; 3]| {
            let found = DVec3::from(of_square(DVec2::from(at)));
            assert!((found - DVec3::from(expected)).length() < 1e-12, "{at:?}: {found}");
        };
        is([0.0, 0.0], [0.0, 1.0, 0.0]);
        is([1.0, 0.0], [1.0, 0.0, 0.0]);
        is([0.0, -1.0], [0.0, 0.0, 1.0]);
        is([0.0, 1.0], [0.0, 0.0, -1.0]);
        for corner in [[1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]] {
            is(corner, [0.0, -1.0, 0.0]);
        }
        // 30° below the horizon, half of the lower hemisphere; at 45° between right and forward.
        let h = 0.75f64.sqrt() * 0.5f64.sqrt();
        let r = 0.5f64.sqrt();
        is([1.0 - r / 2.0, r / 2.0 - 1.0], [h, -0.5, h]);
    }

    /// Every pixel covers the same solid angle, directions are continuous across the edges, and projecting a direction
    /// gives the place that it came from.
    #[test]
    fn the_square_keeps_areas() {
        const N: i32 = 40;
        let step = 1e-4;
        for i in 0..N * N {
            let place = |k: i32| (f64::from(k) + 0.51) / f64::from(N) * 2.0 - 1.0;
            let at = DVec2::new(place(i % N), place(i / N));
            let d = |dx: f64, dy: f64| DVec3::from(of_square(at + DVec2::new(dx, dy)));
            let here = d(0.0, 0.0);
            assert!((here.length() - 1.0).abs() < 1e-12, "{at}");
            assert!((to_square(here) - at).length() < 1e-9, "{at} {here}");
            let across =
                (d(step, 0.0) - d(-step, 0.0)).cross(d(0.0, step) - d(0.0, -step)) / (4.0 * step * step);
            // Seams between the eight triangles have no derivative.
            let DVec2 { x, y } = at.abs();
            if x > 2.0 * step && y > 2.0 * step && (x + y - 1.0).abs() > 4.0 * step {
                assert!((across.length() - PI).abs() < 1e-3, "{at}: {across}");
            }
            let edge = |x: f64, y: f64| DVec3::from(of_square(DVec2::new(x, y)));
            for s in [-1.0, 1.0] {
                assert!((edge(s * (1.0 - step), at.y) - edge(s * (1.0 + step), at.y)).length() < 0.05);
                assert!((edge(at.x, s * (1.0 - step)) - edge(at.x, s * (1.0 + step))).length() < 0.05);
            }
        }
    }
}

//! The mapping from points to pixels, as numbers for other programs: computer vision, tracking, compositing.
//!
//! With a point (x, y, z) relative to the camera, x to the right, y down and z forward as in OpenCV, and the scale s
//! and centre c of a [`CameraModel`], the position in pixels from the picture's top left corner is
//!
//! ```text
//! perspective       u = cx + sx x / z             v = cy + sy y / z
//! orthographic      u = cx + sx x                 v = cy + sy y
//! fisheye           u = cx + sx θ x / r           v = cy + sy θ y / r      r = √(x² + y²), θ = atan2(r, z)
//! equirectangular   u = cx + sx atan2(x, z)       v = cy + sy asin(y / √(x² + y² + z²))
//! equal area        u = cx ± sx (1 − φ) r         v = cy ± sy φ r          r = √(1 − |y|), φ = 2/π atan2(|z|, |x|)
//! ```
//!
//! In the last line x, y, z have length 1, the signs are those of x and z, and y ≤ 0 (above the horizon). Below, the two
//! distances from the centre become 1 − φ r and 1 − (1 − φ) r.
//!
//! The centre of the top left pixel is at (0.5, 0.5).

use super::clip::Clip;
use super::pinhole::Screen;
use super::{Camera, CameraFrame, PanoramaMapping};
use crate::math::DVec2;
use std::f64::consts::{FRAC_2_PI, PI};

/// How directions become positions in the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProjectionKind {
    /// Straight lines stay straight: the pinhole and the thin lens.
    Perspective,
    /// Parallel rays.
    Orthographic,
    /// Equidistant: the distance from the centre is proportional to the angle.
    Fisheye,
    /// Columns are longitudes and rows latitudes.
    Equirectangular,
    /// A square in which every pixel covers the same solid angle.
    EqualArea,
}

/// A camera and the size of its picture, as numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraModel {
    /// The formula.
    pub kind: ProjectionKind,
    /// Pixels to the right and down per unit: of x/z and y/z (perspective), of length (orthographic), of radians
    /// (fisheye, equirectangular), of half the side of the square (equal area).
    pub scale: DVec2,
    /// The position of the viewing direction, in pixels from the top left corner of the complete picture.
    pub center: DVec2,
    /// Position and axes in the world.
    pub frame: CameraFrame,
    /// Radius of the lens and distance of the plane of focus along the viewing direction, in scene units. `None`: all
    /// distances are in focus.
    pub lens: Option<(f64, f64)>,
    /// Largest angle from the viewing direction, in radians, of a fisheye. `None`: the camera has no such limit.
    pub rim: Option<f64>,
    /// Surfaces nearer than this are invisible, in scene units.
    pub near: f64,
    /// Surfaces farther than this are invisible, in scene units; infinite without a limit.
    pub far: f64,
}

impl Camera {
    /// The camera as numbers, for a complete picture of `width` × `height` pixels. A thin lens is described by the
    /// rays through its centre; a lens of many surfaces by the perspective of its plane of focus near the axis, without its
    /// distortion.
    pub fn model(&self, width: u32, height: u32) -> CameraModel {
        let half = 0.5 * DVec2::new(f64::from(width), f64::from(height));
        let frame = self.frame();
        let plain = |kind, scale, clip: Clip| CameraModel {
            kind,
            scale,
            center: half,
            frame,
            lens: None,
            rim: None,
            near: clip.near,
            far: clip.far,
        };
        let flat = |screen: &Screen, clip| CameraModel {
            // The picture's rows run downwards, its shift upwards.
            center: half * DVec2::new(1.0 - screen.shift.x, 1.0 + screen.shift.y),
            ..plain(ProjectionKind::Perspective, half * screen.distance / screen.half, clip)
        };
        match self {
            Camera::Pinhole(c) => flat(&c.screen, c.clip),
            Camera::ThinLens(c) => {
                CameraModel { lens: Some((c.lens_radius(), c.focus_distance)), ..flat(&c.screen, c.clip) }
            }
            Camera::Orthographic(c) => plain(ProjectionKind::Orthographic, half / c.half, c.clip),
            Camera::Fisheye(c) => CameraModel {
                rim: Some(c.rim),
                ..plain(ProjectionKind::Fisheye, half / (c.half * c.rim), c.clip)
            },
            Camera::Realistic(c) => CameraModel {
                lens: Some((c.thin().1, c.focus_distance)),
                ..plain(ProjectionKind::Perspective, half / c.half_tangents(), c.clip)
            },
            Camera::Equirectangular(c) => match c.mapping {
                PanoramaMapping::LatitudeLongitude => {
                    plain(ProjectionKind::Equirectangular, half * DVec2::new(1.0 / PI, FRAC_2_PI), c.clip)
                }
                PanoramaMapping::EqualArea => plain(ProjectionKind::EqualArea, half, c.clip),
            },
        }
    }
}

impl CameraModel {
    /// From world to camera coordinates, as four rows of a matrix for column vectors. The axes are `right`, `up` or
    /// down, and `forward` or backward, each by its sign: `[1, -1, 1]` is OpenCV's x right, y down, z forward;
    /// `[1, 1, -1]` is OpenGL's x right, y up, z backward. Lengths do not change.
    pub fn world_to_camera(&self, signs: [f64; 3]) -> [[f64; 4]; 4] {
        let CameraFrame { position, right, up, forward } = self.frame;
        let [x, y, z] = [right * signs[0], up * signs[1], forward * signs[2]];
        let row = |axis: crate::math::DVec3| [axis.x, axis.y, axis.z, -axis.dot(position)];
        [row(x), row(y), row(z), [0.0, 0.0, 0.0, 1.0]].map(|row| row.map(plain_zero))
    }

    /// From camera to world coordinates: the inverse of [`CameraModel::world_to_camera`].
    pub fn camera_to_world(&self, signs: [f64; 3]) -> [[f64; 4]; 4] {
        let CameraFrame { position, right, up, forward } = self.frame;
        let [x, y, z] = [right * signs[0], up * signs[1], forward * signs[2]];
        let row = |i: usize| [x[i], y[i], z[i], position[i]];
        [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]].map(|row| row.map(plain_zero))
    }

    /// The axes right, down, forward are right-handed. With `handedness = "left"` they are left-handed, and the
    /// matrices contain a reflection.
    pub fn is_mirrored(&self) -> bool {
        let CameraFrame { right, up, forward, .. } = self.frame;
        right.cross(-up).dot(forward) < 0.0
    }
}

/// 0 for −0.
fn plain_zero(v: f64) -> f64 {
    v + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::*;
    use crate::film::FilmDesc;
    use crate::math::elementary::{asin, atan2};
    use crate::math::{DVec3, Ray};

    fn cameras() -> Vec<CameraDesc> {
        let (position, look_at) = (DVec3::new(1.0, 2.0, 5.0), DVec3::new(0.5, -0.5, -1.0));
        let up = DVec3::new(0.2, 1.0, 0.1);
        let handedness = Handedness::Left;
        let shift = DVec2::new(0.3, -0.2);
        let size = Some(Viewport::Size(DVec2::new(3.0, 1.0)));
        vec![
            CameraDesc::Pinhole(PinholeDesc { position, look_at, up, ..PinholeDesc::default() }),
            CameraDesc::Pinhole(PinholeDesc {
                position,
                look_at,
                handedness,
                shift,
                ..PinholeDesc::default()
            }),
            CameraDesc::Pinhole(PinholeDesc { position, look_at, viewport: size, ..PinholeDesc::default() }),
            CameraDesc::ThinLens(ThinLensDesc { position, look_at, up, shift, ..ThinLensDesc::default() }),
            CameraDesc::Orthographic(OrthographicDesc { position, look_at, up, ..Default::default() }),
            CameraDesc::Fisheye(FisheyeDesc { position, look_at, up, fov: 230.0, ..FisheyeDesc::default() }),
            CameraDesc::Equirectangular(EquirectangularDesc { position, look_at, up, ..Default::default() }),
            CameraDesc::Equirectangular(EquirectangularDesc {
                position,
                look_at,
                up,
                mapping: PanoramaMapping::EqualArea,
                ..Default::default()
            }),
        ]
    }

    /// The formulas at the top of this file, for a point of the world.
    fn project(m: &CameraModel, p: DVec3) -> DVec2 {
        let rows = m.world_to_camera([1.0, -1.0, 1.0]);
        let [x, y, z, _] = rows.map(|r| r[0] * p.x + r[1] * p.y + r[2] * p.z + r[3]);
        let across = (x * x + y * y).sqrt();
        let angle = atan2(across, z);
        m.center
            + m.scale
                * match m.kind {
                    ProjectionKind::Perspective => DVec2::new(x / z, y / z),
                    ProjectionKind::Orthographic => DVec2::new(x, y),
                    ProjectionKind::Fisheye => angle / across * DVec2::new(x, y),
                    ProjectionKind::EqualArea => {
                        // Clarberg's square: right and forward along its axes, up at the centre.
                        let [x, y, z] = [x, -y, z].map(|v| v / (x * x + y * y + z * z).sqrt());
                        let r = (1.0 - y.abs()).sqrt();
                        let turn = atan2(z.abs(), x.abs()) / std::f64::consts::FRAC_PI_2;
                        let (u, v) = (r - turn * r, turn * r);
                        let (u, v) = if y < 0.0 { (1.0 - v, 1.0 - u) } else { (u, v) };
                        DVec2::new(u.copysign(x), v.copysign(z))
                    }
                    ProjectionKind::Equirectangular => {
                        DVec2::new(atan2(x, z), asin(y / (x * x + y * y + z * z).sqrt()))
                    }
                }
    }

    #[test]
    fn points_on_camera_rays_land_on_their_pixels() {
        for (width, height) in [(64, 48), (30, 70)] {
            let film = FilmDesc { width, height, ..FilmDesc::default() };
            for desc in cameras() {
                let camera = desc.prepare(film.aspect()).unwrap();
                let model = camera.model(width, height);
                for (x, y) in [(0.31, 0.52), (0.5, 0.5001), (0.7, 0.4), (0.45, 0.6)] {
                    let at = DVec2::new(2.0 * x - 1.0, 1.0 - 2.0 * y);
                    let Ray { origin, direction, .. } = camera.ray(at, DVec2::splat(0.5));
                    let place = DVec2::new(x * f64::from(width), y * f64::from(height));
                    let found = project(&model, origin + 2.5 * direction);
                    // The centre of the lens is (0.5, 0.5) of the unit square.
                    assert!((found - place).length() < 1e-9, "{desc:?}: {found} {place}");
                }
            }
        }
    }

    #[test]
    fn the_matrices_are_inverse_and_state_reflections() {
        for (i, desc) in cameras().iter().enumerate() {
            let model = desc.prepare(1.5).unwrap().model(60, 40);
            assert_eq!(model.is_mirrored(), i == 1, "{desc:?}");
            for signs in [[1.0, -1.0, 1.0], [1.0, 1.0, -1.0]] {
                let (a, b) = (model.world_to_camera(signs), model.camera_to_world(signs));
                for r in 0..4 {
                    for c in 0..4 {
                        let v: f64 = (0..4).map(|k| a[r][k] * b[k][c]).sum();
                        assert!((v - f64::from(u8::from(r == c))).abs() < 1e-12, "{a:?} {b:?}");
                    }
                }
            }
        }
    }
}

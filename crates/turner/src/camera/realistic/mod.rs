//! A camera with a real lens, as pbrt's `realistic` camera: rays are traced from the film through the surfaces of the
//! lens (Kolb, Mitchell and Hanrahan 1995, "A Realistic Camera Model for Computer Graphics"; pbrt § 5.4).
//!
//! - `lens.rs`: the surfaces, the focus by the thick-lens equation, rays by Snell's law.
//! - `pupil.rs`: which directions leave the film through the lens, in tables over the film's radius.
//! - `seen.rs`: the rays through the centres of the pupils, which stand for the picture without blur.

mod lens;
mod pupil;
mod seen;

use std::sync::Arc;

use super::aperture::Aperture;
use super::clip::Clip;
use super::{CameraFrame, Handedness};
use crate::math::{DVec2, DVec3, Ray};
use crate::sampler::mix;
use crate::schema::{ErrorCode, Range, SceneError, Transform, choice, params};
use lens::Lens;
use pupil::{Pupils, direction};
use seen::{Central, central_rays};

choice! {
    /// How bright the picture of a lens is.
    pub enum LensBrightness {
        /// At its centre as bright as that of a pinhole camera; the lens darkens the corners.
        Relative = "relative",
        /// The irradiance of the film, as in pbrt: radiance times the projected solid angle of the exit pupil, at the centre
        /// about π/4 over the square of the f-number.
        Absolute = "absolute",
    }
}

params! {
    /// A camera with a lens made of spherical surfaces, which shows what that lens does: depth of field, distortion,
    /// darker corners, aberrations, bokeh with the shape of its aperture. Rays are traced from the film through the
    /// lens by Snell's law, as by pbrt's camera of this name. Dispersion is left out. Needs many samples per pixel.
    /// Light paths do not reach this camera: `caustics` of the integrator has no effect.
    pub struct RealisticDesc as "realistic" {
        /// Centre of the film, behind the lens.
        position: DVec3 = DVec3::new(0.0, 0.0, 5.0);
        /// The point at the centre of the picture.
        look_at: DVec3 = DVec3::ZERO;
        /// Up direction in the picture.
        up: DVec3 = DVec3::Y;
        /// Handedness of the axes.
        handedness: Handedness = Handedness::Right;
        /// The surfaces of the lens from the front to the film, in millimetres, as in pbrt's lens files: [[radius of
        /// curvature, thickness, eta, diameter], …]. Radii are positive where the surface bulges towards the scene. The
        /// thickness is that to the next surface, eta the refractive index of what is between them; 0 is air, as 1. A row of
        /// radius 0 is plane; between air and air it is the aperture stop. The focus sets the last thickness.
        elements: Vec<[f64; 4]>, required, default double_gauss();
        /// Diameter to which the aperture stop is closed, in millimetres. By default it is open as in `elements`.
        aperture_diameter: Option<f64> = None, in Range::POSITIVE;
        /// Number of aperture blades. Out-of-focus highlights take the shape of the polygon, whose corners are on the
        /// circle of the aperture. 0 is a round aperture; otherwise at least 3.
        blades: u32 = 0, in Range::closed(0.0, 1024.0);
        /// Rotation of the blades in degrees, counter-clockwise as seen by the camera; at 0 a corner is at the top.
        blade_rotation: f64 = 0.0;
        /// Distance of the plane of focus from the film along the viewing direction, in scene units. By default `look_at`
        /// is in focus.
        focus_distance: Option<f64> = None, in Range::POSITIVE;
        /// Diagonal of the film in millimetres. The shape of the film is that of the picture.
        film_diagonal: f64 = 35.0, in Range::POSITIVE;
        /// Scene units in a metre: 1 if the scene is in metres, as pbrt's, 100 if it is in centimetres.
        units_per_metre: f64 = 1.0, in Range::POSITIVE;
        /// How bright the picture is. Blades change the shape of the aperture only: it stays as bright as a round one.
        brightness: LensBrightness = LensBrightness::Relative;
        /// Surfaces nearer than this, in scene units along the viewing direction, are invisible.
        near: f64 = 0.0, in Range::NON_NEGATIVE;
        /// Surfaces farther than this, in scene units along the viewing direction, are invisible. By default there is no limit.
        far: Option<f64> = None, in Range::POSITIVE;
        /// Motion blur: what moves the camera, in the space of the scene, from where it is at time 0 of the shutter to
        /// where it is at time 1.
        motion: Option<Transform> = None;
    }
    example r#"# A single lens of 50 mm at f/8 behind its stop.
[camera]
type = "realistic"
position = [0, 1, 3]
look_at = [0, 1, 0]
elements = [
    [0, 6, 0, 6.2],
    [120, 3, 1.5168, 14],
    [-32.5, 0, 1, 14],
]

[film]
antialias = "monte-carlo"
samples = 16
"#
}

/// A double Gauss lens of 50 mm, f/2: US patent 2,673,491 (Tronnier 1954), scaled.
fn double_gauss() -> Vec<[f64; 4]> {
    vec![
        [29.475, 3.76, 1.67, 25.2],
        [84.83, 0.12, 1.0, 25.2],
        [19.275, 4.025, 1.67, 23.0],
        [40.77, 3.275, 1.699, 23.0],
        [12.75, 5.705, 1.0, 18.0],
        [0.0, 4.5, 0.0, 17.1],
        [-14.495, 1.18, 1.603, 17.0],
        [40.77, 6.065, 1.658, 20.0],
        [-20.385, 0.19, 1.0, 20.0],
        [437.065, 3.22, 1.717, 20.0],
        [-39.73, 0.0, 1.0, 20.0],
    ]
}

/// A prepared camera with a lens; lengths are millimetres.
#[derive(Clone, Debug, PartialEq)]
pub struct Realistic {
    pub(super) frame: CameraFrame,
    /// Half the size of the film.
    pub(super) half_film: DVec2,
    optics: Arc<Optics>,
    aperture: Aperture,
    /// Scene units.
    millimetre: f64,
    /// Magnification of the plane of focus.
    magnification: f64,
    /// Its distance, in scene units.
    pub(super) focus_distance: f64,
    /// Factor from areas of the pupil to weights.
    gain: f64,
    /// In scene units.
    pub(super) clip: Clip,
}

/// The lens and its tables.
#[derive(Debug, PartialEq)]
struct Optics {
    lens: Lens,
    pupils: Pupils,
    /// Radii on the film, ascending, and their central rays.
    central: Vec<(f64, Central)>,
}

/// The tables reach beyond the corners of the film by this factor, for filters.
const BEYOND_FILM: f64 = 1.05;

impl RealisticDesc {
    /// Prepares it for a picture of the given aspect ratio (width over height).
    pub fn prepare(&self, aspect: f64) -> Result<Realistic, SceneError> {
        let frame = CameraFrame::new(self.position, self.look_at, self.up, self.handedness)?;
        let aperture = Aperture::new(self.blades, self.blade_rotation)?;
        let Focused { lens, millimetre, magnification, focus_distance, half_film } = self.focused(aspect)?;
        let Some(pupils) = Pupils::new(&lens, 0.5 * self.film_diagonal * BEYOND_FILM) else {
            let message = "no light passes the lens of the camera to the centre of the film";
            return Err(SceneError::new(ErrorCode::Camera, message)
                .help("check the diameters in `elements` of the camera"));
        };
        let gain = match self.brightness {
            LensBrightness::Relative => 1.0 / pupils.central_area(),
            LensBrightness::Absolute => 1.0,
        };
        let central = central_rays(&lens, &pupils);
        let optics = Arc::new(Optics { lens, pupils, central });
        let clip = Clip::new(self.near, self.far)?;
        Ok(Realistic {
            frame,
            half_film,
            optics,
            aperture,
            millimetre,
            magnification,
            focus_distance,
            gain,
            clip,
        })
    }

    /// Twice the tangent of half the vertical field of view, near the axis and seen from the film; `None` for an invalid
    /// camera.
    pub fn height_at_one(&self, aspect: f64) -> Option<f64> {
        let Focused { millimetre, magnification, focus_distance, half_film, .. } =
            self.focused(aspect).ok()?;
        Some(2.0 * half_film.y * millimetre / (magnification * focus_distance))
    }

    fn focused(&self, aspect: f64) -> Result<Focused, SceneError> {
        let millimetre = 1e-3 * self.units_per_metre;
        let focus_distance = self.focus_distance.unwrap_or((self.look_at - self.position).length());
        let in_range = |v: f64| v > 1e-9 && v < 1e9;
        if !(in_range(millimetre) && in_range(self.film_diagonal) && in_range(aspect)) {
            let message = "`units_per_metre` or `film_diagonal` of the camera is too small or too large";
            return Err(SceneError::new(ErrorCode::OutOfRange, message));
        }
        let mut lens = Lens::new(&self.elements, self.aperture_diameter)?;
        let magnification = lens.focus(focus_distance / millimetre, millimetre)?;
        let half_height = 0.5 * self.film_diagonal / (aspect * aspect + 1.0).sqrt();
        let half_film = DVec2::new(aspect, 1.0) * half_height;
        Ok(Focused { lens, millimetre, magnification, focus_distance, half_film })
    }
}

/// A lens in front of its film.
struct Focused {
    lens: Lens,
    /// Scene units.
    millimetre: f64,
    magnification: f64,
    /// In scene units.
    focus_distance: f64,
    half_film: DVec2,
}

impl Realistic {
    /// Focal length and radius of the entrance pupil by which a thin lens at the film would show the plane of focus with
    /// the same size and blur, in scene units.
    pub(super) fn thin(&self) -> (f64, f64) {
        let length = self.magnification * self.focus_distance;
        let aperture = (self.optics.pupils.central_area() / std::f64::consts::PI).sqrt();
        (length, length * aperture)
    }

    /// Half the size of the film over [`Realistic::thin`]'s focal length.
    pub(super) fn half_tangents(&self) -> DVec2 {
        self.half_film * (self.millimetre / self.thin().0)
    }

    /// The point of the film of a screen position: its distance from the axis, and its direction from there, to the right
    /// and up. The picture on the film is upside down.
    #[inline]
    fn on_film(&self, at: DVec2) -> (f64, DVec2) {
        let point = -at * self.half_film;
        let r = point.length();
        (r, if r > 0.0 { point / r } else { DVec2::X })
    }

    /// The factor of the light of rays at a screen position: 0 where the film is dark.
    pub(super) fn weight(&self, at: DVec2) -> f32 {
        let (r, _) = self.on_film(at);
        self.optics.pupils.at(r).map_or(0.0, |pupil| (self.gain * pupil.area()) as f32)
    }

    /// The ray through a screen position, from where it leaves the lens. Its direction has unit length.
    pub(super) fn ray(&self, at: DVec2, lens: DVec2) -> Ray {
        let ray = self.leaving(at, lens);
        ray.unwrap_or(Ray { t_max: -1.0, ..Ray::new(self.frame.position, self.frame.forward) })
    }

    /// `lens` chooses a point of the region around the pupil. Where the lens blocks it, hashes of `lens` choose others, so
    /// that points are uniform over the pupil.
    fn leaving(&self, at: DVec2, lens: DVec2) -> Option<Ray> {
        /// The region is hardly larger than the pupil of a round aperture; a triangle is 0.41 of its circle.
        const TRIES: u64 = 40;
        let (r, axis) = self.on_film(at);
        let pupil = self.optics.pupils.at(r)?;
        let start = (axis * r).extend(0.0);
        let mut u = lens;
        for attempt in 1..=TRIES {
            let c = pupil.point(u);
            if let Some(d) = direction(c.x, c.y) {
                let d = DVec3::new(axis.x * d.x - axis.y * d.y, axis.y * d.x + axis.x * d.y, d.z);
                let out = self.optics.lens.trace(start, d, |p| self.aperture.contains(p));
                if let Some((p, d)) = out {
                    return Some(self.in_world(p, d));
                }
            }
            let bits = mix(mix(lens.x.to_bits() ^ mix(lens.y.to_bits())).wrapping_add(attempt));
            let scale = 1.0 / 4_294_967_296.0;
            u = DVec2::new(f64::from(bits as u32) * scale, f64::from((bits >> 32) as u32) * scale);
        }
        None
    }

    /// A ray that leaves the lens.
    fn in_world(&self, p: DVec3, d: DVec3) -> Ray {
        let f = &self.frame;
        let world = |v: DVec3| f.right * v.x + f.up * v.y + f.forward * v.z;
        let depth = p.z * self.millimetre;
        // Where the ray crosses a plane in front of it.
        let crossing = |at: f64| if d.z > 0.0 { ((at - depth) / d.z).max(0.0) } else { 0.0 };
        let t_max = if d.z > 0.0 { crossing(self.clip.far) } else { f64::INFINITY };
        Ray {
            t_min: crossing(self.clip.near),
            t_max,
            ..Ray::new(f.position + self.millimetre * world(p), world(d))
        }
    }
}

#[cfg(test)]
mod tests;

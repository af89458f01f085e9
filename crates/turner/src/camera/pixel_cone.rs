//! The ray cone of a camera ray: as wide as the part of a pixel that one sample represents.
//!
//! With n samples per pixel a sample represents 1/n of the pixel's area, so its cone is 1/√n of a pixel wide, but at
//! least 1/64. On a flat screen the corners are farther from the camera than the centre: the same pixel width then is
//! a smaller angle.

use super::Camera;
use crate::film::FilmDesc;
use crate::math::{DVec2, RayCone};

/// The ray cones of a picture's camera rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelCone {
    /// Diameter at the start of the ray, in scene units.
    width: f64,
    /// Growth per unit of length; for a flat screen, multiplied by the length of the vector from camera to screen.
    spread: f64,
    /// Whether the screen is flat.
    flat: bool,
    /// Width of a sample's cone as a fraction of a pixel, 1/64 to 1.
    pub share: f32,
}

/// Least width in pixels for any number of samples: textures keep some filtering.
const MIN_FRACTION: f64 = 1.0 / 64.0;

impl PixelCone {
    /// The ray cones for a camera and a film: one pixel wide with one sample per pixel, narrower by the square root
    /// of the number of samples, at least a 64th.
    pub fn new(camera: &Camera, film: &FilmDesc) -> PixelCone {
        let share = (1.0 / f64::from(film.samples_per_pixel().max(1)).sqrt()).max(MIN_FRACTION);
        let size = DVec2::new(f64::from(film.width.max(1)), f64::from(film.height.max(1)));
        let (width, spread, flat) = camera.pixel(size);
        PixelCone { width: share * width, spread: share * spread, flat, share: share as f32 }
    }

    /// The cone of a ray, given the length of the direction that [`Camera::ray`] returned.
    #[inline]
    pub fn cone(&self, length: f64) -> RayCone {
        let spread = if self.flat { self.spread / length } else { self.spread };
        RayCone { width: self.width as f32, spread: spread as f32 }
    }
}

impl Camera {
    /// The extent of a pixel, for pictures of `size` pixels: diameter at the start of the ray, growth (see
    /// [`PixelCone`]), and whether the screen is flat.
    fn pixel(&self, size: DVec2) -> (f64, f64, bool) {
        match self {
            Camera::Pinhole(c) => (0.0, (2.0 * c.half_screen() / size).max_element(), true),
            Camera::ThinLens(c) => (0.0, (2.0 * c.half_focus() / size).max_element(), true),
            Camera::Orthographic(c) => ((2.0 * c.half_screen() / size).max_element(), 0.0, false),
            Camera::Equirectangular(c) => (0.0, (c.angles() / size).max_element(), false),
            Camera::Fisheye(c) => (0.0, (2.0 * c.half_angles() / size).max_element(), false),
            Camera::Realistic(c) => (0.0, (2.0 * c.half_tangents() / size).max_element(), false),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::CameraDesc;
    use crate::description::read_scene;
    use crate::description::{ModelDesc, SceneAssets, SceneDesc};
    use crate::film::Antialias;
    use crate::schema::value::{Data, Entry, FileId, Span, Table, Value};
    use crate::schema::{ErrorCode, SceneError};

    struct NoFiles;

    impl SceneAssets for NoFiles {
        fn image(&mut self, uri: &str, _: FileId) -> Result<std::sync::Arc<crate::image::Image>, SceneError> {
            Err(SceneError::new(ErrorCode::File, uri))
        }
        fn mesh(
            &mut self,
            uri: &str,
            _: FileId,
        ) -> Result<std::sync::Arc<crate::schema::MeshData>, SceneError> {
            Err(SceneError::new(ErrorCode::File, uri))
        }
        fn model(&mut self, model: &ModelDesc, _: FileId) -> Result<std::sync::Arc<SceneDesc>, SceneError> {
            Err(SceneError::new(ErrorCode::File, model.file.as_str()))
        }
    }

    /// A camera of a type with its example film.
    fn described(camera: &str) -> (CameraDesc, FilmDesc) {
        const NOWHERE: Span = Span { file: FileId(0), start: 0, end: 0 };
        let value = |data| Value { data, span: NOWHERE };
        let table = |key: &str, data| {
            let entry = Entry { key: key.into(), key_span: NOWHERE, value: value(data) };
            Data::Table(Table { entries: vec![entry] })
        };
        let camera = table("camera", table("type", Data::String(camera.into())));
        let scene = read_scene(&value(camera), &mut NoFiles).unwrap();
        (scene.camera.unwrap().value, scene.film)
    }

    #[test]
    fn cones_are_as_wide_as_pixels_are_apart() {
        for name in ["pinhole", "thin-lens", "orthographic", "equirectangular", "fisheye"] {
            let (desc, film) = described(name);
            let film = FilmDesc { width: 200, height: 100, ..film };
            let camera = desc.prepare(2.0).unwrap();
            let cones = PixelCone::new(&camera, &film);
            let ray = |x: f64, y: f64| {
                let screen = DVec2::new(2.0 * x / 200.0 - 1.0, 1.0 - 2.0 * y / 100.0);
                camera.ray(screen, DVec2::splat(0.5))
            };
            // Near the centre of the picture.
            let (a, b) = (ray(100.0, 50.0), ray(101.0, 50.0));
            let cone = cones.cone(a.direction.length());
            for t in [0.0, 1.0, 17.0] {
                let end = |r: &crate::math::Ray| r.origin + r.direction.normalize() * t;
                let apart = (end(&a) - end(&b)).length();
                let width = f64::from(cone.width_at(t));
                assert!((apart - width).abs() <= 1e-2 * width + 1e-12, "{name} at {t}: {apart} {width}");
            }
        }
    }

    #[test]
    fn many_samples_make_narrow_cones() {
        let (desc, film) = described("pinhole");
        let camera = desc.prepare(1.0).unwrap();
        let share = |samples| {
            let film = FilmDesc { samples, antialias: Antialias::MonteCarlo, ..film.clone() };
            PixelCone::new(&camera, &film).share
        };
        assert_eq!([1, 16, 64, 10_000].map(share), [1.0, 0.25, 0.125, 1.0 / 64.0]);
    }
}

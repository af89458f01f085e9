//! Light of the frame before, for a camera that moves: each pixel looks for its surface there.
//!
//! ```text
//!   camera before        camera
//!        o.                 o          the point that a pixel sees, projected to the picture before, gives a pixel
//!          `-.           .-'           there; its light counts if it shows the same point: same normal, same
//!             `-.     .-'              distance
//!   ─────────────`-.-'─────────
//! ```

use crate::camera::Camera;
use crate::film::FilmDesc;
use crate::math::DVec2;
use crate::preview::buffers::{Layers, Sample};
use crate::preview::draw::grid_size;
use crate::view::View;

/// The most frames of a moving camera in a mean, without the new one.
pub(super) const MOST_MOVING: f32 = 15.0;

/// Least cosine of the angle between the normals.
const COSINE: f32 = 0.95;
/// Largest relative difference of the distances.
const DISTANCE: f32 = 0.02;

/// The frame before.
pub(super) struct Past<'a> {
    pub(super) camera: &'a Camera,
    pub(super) film: &'a FilmDesc,
    /// Whether its camera is another one.
    pub(super) is_moved: bool,
    pub(super) layers: &'a Layers,
}

/// A pixel of the frame before, and its cell of the grid.
pub(super) struct PastPixel {
    pub(super) pixel: usize,
    pub(super) cell: usize,
}

impl Past<'_> {
    /// The pixel that showed the surface of a sample. What is seen by way of mirrors and glass has no history.
    pub(super) fn find(&self, view: &View, x: u32, y: u32, sample: &Sample) -> Option<PastPixel> {
        if sample.key != 0 || sample.near <= 0.0 {
            return None;
        }
        let (width, height) = (f64::from(view.film.width), f64::from(view.film.height));
        let place = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let (mut to, mut distance) = (place, 1.0 / sample.near);
        if self.is_moved {
            let screen = DVec2::new(2.0 * place.x / width - 1.0, 1.0 - 2.0 * place.y / height);
            let ray = view.camera.ray(screen, DVec2::splat(0.5));
            let p = ray.origin + ray.direction.normalize() * f64::from(1.0 / sample.near);
            let projection = self.camera.project(self.film, p, DVec2::splat(0.5))?;
            (to, distance) = (projection.place, projection.to_camera.length() as f32);
        }
        if !(to.x >= 0.0 && to.x < width && to.y >= 0.0 && to.y < height) {
            return None;
        }
        let (px, py) = (to.x as usize, to.y as usize);
        let (width, height) = (view.film.width as usize, view.film.height as usize);
        let pixel = py * width + px;
        let guides = &self.layers.guides;
        let cosine: f32 = guides.normal.iter().zip(sample.normal).map(|(plane, v)| plane[pixel] * v).sum();
        let is_same = guides.key[pixel] == sample.key
            && cosine > COSINE
            && (guides.near[pixel] * distance - 1.0).abs() < DISTANCE;
        let [grid_width, _] = grid_size(width, height);
        is_same.then_some(PastPixel { pixel, cell: py / 2 * grid_width + px / 2 })
    }
}

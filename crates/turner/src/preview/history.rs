//! Light of the frame before, for a camera that moves: each cell looks for its surface there.
//!
//! ```text
//!   camera before        camera
//!        o.                 o          the point that a cell's head sees, projected to the picture before, lies
//!          `-.           .-'           between four cells there; the light of one of them counts if it shows the
//!             `-.     .-'              same surface: same normal, same distance
//!   ─────────────`-.-'─────────
//! ```
//!
//! Which of the four it is, is drawn with the weights of bilinear interpolation. The nearest one would let light lag
//! behind a camera that moves by less than half a cell from frame to frame.

use crate::camera::Camera;
use crate::film::FilmDesc;
use crate::math::DVec2;
use crate::preview::buffers::{Grid, Guides, Layers, Sample};
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

impl Past<'_> {
    /// The cell that showed the surface of a cell's head at (x, y). What is seen by way of mirrors and glass has no
    /// history. `random` holds two numbers of 0..1.
    pub(super) fn find(
        &self,
        view: &View,
        [x, y]: [u32; 2],
        sample: &Sample,
        random: [f64; 2],
    ) -> Option<usize> {
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
        let Grid { cell, columns, rows } = self.layers.grid;
        let draw = |at: f64, random: f64, count: usize| {
            let at = ((at - 0.5) / cell as f64 + random).floor().max(0.0) as usize;
            at.min(count - 1)
        };
        let cell = draw(to.y, random[1], rows) * columns + draw(to.x, random[0], columns);
        is_same(&self.layers.heads, cell, sample, distance).then_some(cell)
    }
}

/// Whether a cell showed the surface of a sample, at this distance.
fn is_same(guides: &Guides, cell: usize, sample: &Sample, distance: f32) -> bool {
    let cosine: f32 = guides.normal.iter().zip(sample.normal).map(|(plane, v)| plane[cell] * v).sum();
    guides.key[cell] == sample.key && cosine > COSINE && (guides.near[cell] * distance - 1.0).abs() < DISTANCE
}

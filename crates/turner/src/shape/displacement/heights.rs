//! The values of an image at (u, v).

use super::Displacement;
use crate::image::Image;

/// An image as heights.
pub(super) struct Heights<'a> {
    image: &'a Image,
    by: Displacement,
}

impl<'a> Heights<'a> {
    pub(super) fn new(image: &'a Image, by: Displacement) -> Heights<'a> {
        Heights { image, by }
    }

    /// How far a vertex moves along its normal: bilinear between the centres of pixels, repeated beyond 0..1. v = 1 is at
    /// the top of the image.
    pub(super) fn at(&self, [u, v]: [f32; 2]) -> f64 {
        let (w, h) = (self.image.width.max(1), self.image.height.max(1));
        let (x, fx) = place(f64::from(u), w);
        let (y, fy) = place(1.0 - f64::from(v), h);
        let row = |y: u32| {
            let (a, b) = (self.value(x, y), self.value((x + 1) % w, y));
            a + (b - a) * fx
        };
        let (above, below) = (row(y), row((y + 1) % h));
        let value = above + (below - above) * fy;
        self.by.scale * (value - self.by.midlevel)
    }

    fn value(&self, x: u32, y: u32) -> f64 {
        let [r, g, b] = self.image.rgb(x, y).map(|v| if v.is_finite() { f64::from(v) } else { 0.0 });
        (r + g + b) / 3.0
    }
}

/// The pixel before a coordinate, and the way to the next one, 0..1.
fn place(u: f64, count: u32) -> (u32, f64) {
    let u = if u.is_finite() { u - u.floor() } else { 0.0 };
    let at = u * f64::from(count) - 0.5;
    let at = if at < 0.0 { at + f64::from(count) } else { at };
    let pixel = (at as u32).min(count - 1);
    (pixel, (at - f64::from(pixel)).clamp(0.0, 1.0))
}

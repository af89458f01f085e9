//! The pictures of projection lights.

use std::sync::Arc;

use turner::color::Spectrum;
use turner::image::Image;
use turner::math::elementary::{atan2, tan};
use turner::math::{DVec2, radians};
use turner::schema::ImageId;

use super::assembly::Assembly;
use super::environment::EncodedView;
use super::source::Place;
use crate::scene_import::rearranged;

/// A picture at distance 1.
pub(super) struct Slide {
    image: Arc<Image>,
    /// Half of its sides.
    half: DVec2,
}

impl Slide {
    /// `fov` is the angle of the shorter side, degrees.
    pub(super) fn new(scene: &Assembly<'_>, image: ImageId, fov: f64) -> Option<Slide> {
        let image = scene.images.get(image.index())?.data.clone();
        let aspect = f64::from(image.width) / f64::from(image.height);
        let half = tan(radians(0.5 * fov)) * DVec2::new(aspect.max(1.0), (1.0 / aspect).max(1.0));
        Some(Slide { image, half })
    }

    /// The angle from the left to the right, degrees.
    pub(super) fn fov(&self) -> f64 {
        2.0 * atan2(self.half.x, 1.0).to_degrees()
    }

    /// The angle from the axis to the corners, degrees, with a margin for rounding.
    pub(super) fn angle(&self) -> f64 {
        (atan2(self.half.length(), 1.0).to_degrees() + 1e-3).min(90.0)
    }

    /// The luminous power at intensity 1: the integral of the picture's luminance over the solid angle. At distance 1,
    /// an area at the angle θ from the axis covers cos³ θ of it.
    pub(super) fn power(&self) -> f64 {
        let look = EncodedView::new(&self.image);
        let size = DVec2::new(f64::from(self.image.width), f64::from(self.image.height));
        let mut sum = 0.0;
        for y in 0..self.image.height {
            for x in 0..self.image.width {
                let at = (DVec2::new(f64::from(x), f64::from(y)) + 0.5) / size * 2.0 - 1.0;
                let squared = 1.0 + (at * self.half).length_squared();
                let color = look.pixel(i64::from(x), i64::from(y)).map(|v| v as f32);
                sum += f64::from(Spectrum::from(color).luminance()) / (squared * squared.sqrt());
            }
        }
        4.0 * self.half.x * self.half.y * sum / (size.x * size.y)
    }
}

/// The image with left and right exchanged; `None` if it cannot be read, which is reported.
pub(super) fn mirrored(scene: &mut Assembly<'_>, name: &str, place: Place) -> Option<ImageId> {
    let id = scene.image(name, place)?;
    let reversed = |old: &Image| rearranged(old, [old.width, old.height], |x, y| (old.width - 1 - x, y));
    let made = scene.derived_image((name, id), "mirrored", reversed);
    if made.is_none() {
        scene.report.approximated(place, "the images of projection lights take too much memory: mirrored");
    }
    made.or(Some(id))
}

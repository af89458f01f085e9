//! The pictures of projection lights.

use std::sync::Arc;

use turner::color::Spectrum;
use turner::image::{Image, Pixels};
use turner::math::elementary::{atan2, tan};
use turner::math::{DVec2, radians};
use turner::schema::ImageId;

use super::assembly::Assembly;
use super::environment::EncodedView;
use super::source::Place;

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
    let key = format!("{name}\0mirrored");
    if let Some(known) = scene.image_ids.get(&key) {
        return *known;
    }
    let old = scene.images.get(id.index())?.data.clone();
    let made = if scene.may_copy(old.memory() as u64) { reversed(&old) } else { None };
    let Some(made) = made else {
        scene.report.approximated(place, "the images of projection lights take too much memory: mirrored");
        return Some(id);
    };
    let made = scene.add_image(name, made);
    scene.image_ids.insert(key, Some(made));
    Some(made)
}

/// Every row from right to left; `None` if memory is short.
fn reversed(old: &Image) -> Option<Image> {
    fn rows<T: Copy>(old: &[T], width: usize, channels: usize) -> Option<Vec<T>> {
        let mut out = Vec::new();
        out.try_reserve_exact(old.len()).ok()?;
        for row in old.chunks_exact(width * channels) {
            row.chunks_exact(channels).rev().for_each(|pixel| out.extend_from_slice(pixel));
        }
        Some(out)
    }
    let (width, channels) = (old.width as usize, usize::from(old.channels));
    let pixels = match &old.pixels {
        Pixels::U8(p) => Pixels::U8(rows(p, width, channels)?),
        Pixels::U16(p) => Pixels::U16(rows(p, width, channels)?),
        Pixels::F32(p) => Pixels::F32(rows(p, width, channels)?),
    };
    Some(Image { pixels, ..*old })
}

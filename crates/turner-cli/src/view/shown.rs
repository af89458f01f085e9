//! The display values of the preview.

use turner::image::Image;

use super::contents::Contents;
use crate::header::Shown as Header;
use crate::picture_file::{Linear, PictureFile};
use crate::preview::Shot;

/// The picture to show.
pub(super) struct Shown {
    width: u32,
    height: u32,
    pixels: Vec<[u8; 4]>,
}

impl Shown {
    /// For [`crate::preview::show`].
    pub(super) fn shot(&self) -> Shot<'_> {
        Shot { width: self.width, height: self.height, pixels: &self.pixels }
    }
}

/// The picture, or a layer. `None` if the file has no channels that make up an image.
pub(super) fn of(file: &PictureFile, layer: Option<&str>, contents: &Contents) -> Option<Shown> {
    let (image, associated) = file.image(layer).ok()?;
    let pixels = if image.is_display_encoded() {
        stored(&image)
    } else if layer.is_some() && !is_color(contents) {
        stretched(&image)
    } else {
        let transform = Header::read(&contents.metadata).transform();
        transform.to_8_bits(&Linear::new(&image, associated).pixels, 0)
    };
    Some(Shown { width: image.width, height: image.height, pixels })
}

/// Whether the channels are those of a colour.
fn is_color(contents: &Contents) -> bool {
    let names = contents.parts.iter().flat_map(|p| &p.channels).map(|c| c.name.to_lowercase());
    names.into_iter().any(|n| n == "r" || n.ends_with(".r"))
}

fn each(image: &Image, pixel: impl Fn([f32; 3], f32) -> [f32; 4]) -> Vec<[u8; 4]> {
    let places = (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x, y)));
    // The cast saturates; NaN becomes 0.
    let byte = |v: f32| (v * 255.0 + 0.5) as u8;
    places.map(|(x, y)| pixel(image.rgb(x, y), image.alpha(x, y)).map(byte)).collect()
}

fn stored(image: &Image) -> Vec<[u8; 4]> {
    each(image, |[r, g, b], a| [r, g, b, a])
}

/// From black for the smallest to white for the largest finite value of all channels.
fn stretched(image: &Image) -> Vec<[u8; 4]> {
    let places = (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x, y)));
    let values = places.flat_map(|(x, y)| image.rgb(x, y)).filter(|v| v.is_finite());
    let (least, most) = values.fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    let range = if most > least { most - least } else { 1.0 };
    each(image, |rgb, _| {
        let [r, g, b] = rgb.map(|v| (v.max(least).min(most) - least) / range);
        [r, g, b, 1.0]
    })
}

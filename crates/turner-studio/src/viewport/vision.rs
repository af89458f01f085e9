//! The picture as it is seen with a colour vision deficiency. Only the window shows it so: what is saved stays.

use egui::{Color32, ColorImage};
use turner::color::Vision;

/// Replaces the colours of an image of the window.
pub(super) fn apply(image: &mut ColorImage, vision: Vision) {
    if vision == Vision::Normal {
        return;
    }
    let seen = vision.of_bytes();
    // Neighbours are often equal.
    let mut last = (Color32::BLACK, Color32::BLACK);
    for pixel in &mut image.pixels {
        if *pixel != last.0 || *pixel == Color32::BLACK {
            let [r, g, b, a] = pixel.to_srgba_unmultiplied();
            let [r, g, b] = seen([r, g, b]);
            last = (*pixel, Color32::from_rgba_unmultiplied(r, g, b, a));
        }
        *pixel = last.1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_change_and_transparency_stays() {
        let red = Color32::from_rgb(255, 0, 0);
        let clear = Color32::from_rgba_unmultiplied(0, 200, 0, 100);
        let of = || ColorImage::new([3, 1], vec![red, clear, Color32::BLACK]);
        let mut image = of();
        apply(&mut image, Vision::Normal);
        assert_eq!(image.pixels, of().pixels);
        apply(&mut image, Vision::Deuteranopia);
        let [r, g, ..] = image.pixels[0].to_array();
        assert!(r > 100 && g > 100, "red is seen as a dark yellow: {r} {g}");
        assert_eq!(image.pixels[1].a(), 100);
        assert_eq!(image.pixels[2], Color32::BLACK);
    }
}

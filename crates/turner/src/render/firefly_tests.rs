//! Fireflies in parts of pictures.

use super::resume_tests::{complete_film, scene};
use crate::film::Fireflies;

/// A part of a picture is as it is in the whole, and so is a single pixel.
#[test]
fn crops_and_pixels_equal_the_picture() {
    let mut scene = scene("fireflies");
    scene.view.film.samples = 4;
    let whole = complete_film(&scene).develop(&scene.view.film, 1);
    let kept = {
        let mut scene = scene.clone();
        scene.view.film.fireflies = Fireflies::Keep;
        complete_film(&scene).develop(&scene.view.film, 1)
    };
    assert!(whole.linear != kept.linear);
    let mut part = scene.clone();
    part.view.film.crop = Some([20, 7, 17, 12]);
    let cropped = complete_film(&part).develop(&part.view.film, 1);
    for (y, row) in cropped.linear.chunks(17).enumerate() {
        let from = (7 + y) * 53 + 20;
        assert!(row == &whole.linear[from..from + 17], "{y}");
    }
    let changed = (0..53 * 37).filter(|i| whole.linear[*i] != kept.linear[*i]).take(3);
    for i in changed {
        let pixel = super::pixel(&scene, i as u32 % 53, i as u32 / 53).unwrap();
        assert_eq!(pixel.color, whole.linear[i]);
        assert_eq!((pixel.count, pixel.samples.len()), (4, 4));
        assert!(pixel.fireflies > 0);
        let sum: f64 = pixel.samples.iter().map(|s| s.weight * f64::from(s.radiance.color.r)).sum();
        assert!((sum - f64::from(pixel.color[0])).abs() < 1e-5 * sum.max(1e-3));
    }
}

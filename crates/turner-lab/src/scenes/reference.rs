//! References by Mitsuba, and errors against them.

use std::path::{Path, PathBuf};

use turner::schema::{ErrorCode, SceneError};
use turner_cli::failure::Failure;
use turner_io::scene::hash_with;

use super::files::SceneFile;
use crate::peers::Peer;
use crate::picture::{Picture, save};

/// Samples of one picture of a reference, so that large ones fit into memory.
const AT_ONCE: u32 = 64;
/// The seed of the first picture of a reference; compared pictures have smaller ones.
const FIRST_SEED: u32 = 1 << 16;
/// The pixels with the largest errors do not count: this fraction of them.
const DROPPED: f64 = 0.001;
/// Added to the square of the reference, as in `turner::compare::relative_mse`.
const EPSILON: f64 = 0.01;

/// A picture of many samples in two independent halves.
pub(super) struct Reference {
    halves: [Vec<[f64; 3]>; 2],
    mean: Vec<[f64; 3]>,
}

/// How a picture differs from the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Difference {
    /// relMSE.
    pub(super) error: f64,
    /// Mean brightness over that of the reference.
    pub(super) brightness: f64,
}

impl Reference {
    /// The reference of `samples` samples and `size`: read from `folder`, or rendered and kept there.
    pub(super) fn of(
        peer: &mut Peer,
        file: &SceneFile,
        samples: u32,
        size: (u32, u32),
        folder: &Path,
    ) -> Result<Reference, Failure> {
        let (mut halves, mut seed) = ([Vec::new(), Vec::new()], FIRST_SEED);
        let key = key(&file.path)?;
        for (k, half) in halves.iter_mut().enumerate() {
            let path = folder.join(file_name(&file.name, &key, size, samples, k));
            if !path.is_file() {
                let pixels = render(peer, samples.div_ceil(2), size, seed)?;
                save(&path, size, pixels.iter().map(|v| v.map(|v| v as f32)))?;
            }
            // Also after rendering, so that a reference is the same in each run.
            let picture = Picture::read(&path)?;
            if (picture.width, picture.height) != size {
                let message = format!("{}: it has another size; remove it", path.display());
                return Err(Failure::new(SceneError::new(ErrorCode::Image, message)));
            }
            *half = picture.pixels;
            seed += samples;
        }
        Ok(Reference::new(halves))
    }

    fn new(halves: [Vec<[f64; 3]>; 2]) -> Reference {
        let both = halves[0].iter().zip(&halves[1]);
        let mean = both.map(|(a, b)| std::array::from_fn(|c| 0.5 * (a[c] + b[c]))).collect();
        Reference { halves, mean }
    }

    /// The difference of a picture of the same size, or why it is unknown. With the halves a and b and their mean r, the
    /// error is the mean of (x − a)(x − b) / (r² + 0.01), without the thousandth of the pixels whose (x − r)² / (r² +
    /// 0.01) is largest: the noise of a and b is independent, so that the expected value of the product has none of it.
    pub(super) fn difference(&self, picture: &[[f64; 3]]) -> Result<Difference, String> {
        let [a, b] = &self.halves;
        let weighted = |pixel: usize, product: &dyn Fn(usize) -> f64| -> f64 {
            let r = self.mean[pixel];
            (0..3).map(|c| product(c) / (r[c] * r[c] + EPSILON)).sum::<f64>() / 3.0
        };
        let square = |v: f64| v * v;
        let mut squares: Vec<(f64, usize)> = (0..self.mean.len().min(picture.len()))
            .map(|i| (weighted(i, &|c| square(picture[i][c] - self.mean[i][c])), i))
            // Values that are not numbers are as bad as infinite ones.
            .map(|(value, i)| (if value.is_nan() { f64::INFINITY } else { value }, i))
            .collect();
        squares.sort_by(|x, y| x.0.total_cmp(&y.0));
        let kept = squares.len() - (DROPPED * squares.len() as f64).ceil() as usize;
        let kept = squares.get(..kept).unwrap_or_default();
        if kept.iter().any(|(square, _)| !square.is_finite()) {
            return Err("more than a thousandth of the pixels are not finite".into());
        }
        let mean = |value: &dyn Fn(usize) -> f64| {
            kept.iter().map(|(_, i)| value(*i)).sum::<f64>() / kept.len().max(1) as f64
        };
        let error = mean(&|i| weighted(i, &|c| (picture[i][c] - a[i][c]) * (picture[i][c] - b[i][c])));
        // Of the mean of the halves, whose difference has four times its variance.
        let noise = mean(&|i| weighted(i, &|c| 0.25 * square(a[i][c] - b[i][c])));
        // Also if it is not a number.
        if !(error > 0.25 * noise && error > 0.0) {
            return Err(format!(
                "an error of {error:.1e} is too small for a reference with {noise:.1e}: take more samples with --reference"
            ));
        }
        let finite =
            || (0..squares.len()).filter(|i| picture[*i].iter().chain(&self.mean[*i]).all(|v| v.is_finite()));
        let sum = |pixels: &[[f64; 3]]| finite().map(|i| pixels[i].iter().sum::<f64>()).sum::<f64>();
        let brightness = sum(picture) / sum(&self.mean);
        Ok(Difference { error, brightness })
    }
}

/// Renders `samples` samples in several pictures.
fn render(peer: &mut Peer, samples: u32, size: (u32, u32), mut seed: u32) -> Result<Vec<[f64; 3]>, Failure> {
    let (mut sum, mut taken) = (vec![[0.0; 3]; size.0 as usize * size.1 as usize], 0.0);
    let mut left = samples;
    while left > 0 {
        let picture = peer.render(left.min(AT_ONCE), seed, size)?;
        let count = f64::from(picture.samples);
        for (sum, value) in sum.iter_mut().flatten().zip(picture.pixels.iter().flatten()) {
            *sum += count * value;
        }
        taken += count;
        left = left.saturating_sub(picture.samples.max(1));
        seed += 1;
    }
    sum.iter_mut().flatten().for_each(|v| *v /= taken);
    Ok(sum)
}

/// A short hash of a scene's place and text.
fn key(path: &Path) -> Result<String, Failure> {
    let place = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let text = std::fs::read(path).map_err(|e| {
        let message = format!("{}: the file cannot be read: {e}", path.display());
        Failure::new(SceneError::new(ErrorCode::File, message))
    })?;
    let mut key = hash_with(&place.to_string_lossy(), &text);
    key.truncate(12);
    Ok(key)
}

/// `NAME-KEY-WIDTHxHEIGHT-SAMPLES-HALF.exr`, without characters that a file name cannot have.
fn file_name(name: &str, key: &str, (width, height): (u32, u32), samples: u32, half: usize) -> PathBuf {
    let plain = |c: char| if c.is_alphanumeric() || "._-".contains(c) { c } else { '_' };
    let name: String = name.chars().map(plain).collect();
    format!("{name}-{key}-{width}x{height}-{samples}-{half}.exr").into()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values between -0.5 and 0.5.
    fn noise(count: usize, seed: u64) -> Vec<[f64; 3]> {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        (0..count).map(|_| [next(), next(), next()]).collect()
    }

    /// A grey picture of 1 with noise of an amplitude.
    fn grey(noise: &[[f64; 3]], amplitude: f64) -> Vec<[f64; 3]> {
        noise.iter().map(|v| v.map(|v| 1.0 + amplitude * v)).collect()
    }

    #[test]
    fn the_noise_of_the_reference_does_not_count() {
        let n = 20_000;
        let reference = Reference::new([grey(&noise(n, 1), 0.2), grey(&noise(n, 2), 0.2)]);
        let found = reference.difference(&grey(&noise(n, 3), 0.2)).unwrap();
        // The variance of a uniform distribution is a twelfth of its squared width; dropping a thousandth lessens it.
        let expected = 0.2 * 0.2 / 12.0 / 1.01;
        assert!((found.error / expected - 1.0).abs() < 0.03, "{found:?}, expected {expected}");
        assert!((found.brightness - 1.0).abs() < 0.003, "{found:?}");
        // The error of a picture is unknown if it is below the noise of the reference.
        let better = reference.difference(&grey(&noise(n, 4), 0.01));
        assert!(better.clone().is_err_and(|why| why.contains("--reference")), "{better:?}");
    }

    #[test]
    fn a_thousandth_of_the_pixels_does_not_count() {
        let n = 5_000;
        let reference = Reference::new([grey(&noise(n, 1), 0.01), grey(&noise(n, 2), 0.01)]);
        let mut picture = grey(&noise(n, 3), 0.5);
        let before = reference.difference(&picture).unwrap();
        picture[17] = [f64::NAN; 3];
        picture[99] = [f64::INFINITY, 0.0, 0.0];
        (100..103).for_each(|i| picture[i] = [1e6; 3]);
        let after = reference.difference(&picture).unwrap();
        assert!((after.error / before.error - 1.0).abs() < 0.01, "{before:?} {after:?}");
        assert!(after.brightness > 100.0, "fireflies count for the brightness: {after:?}");
        picture[3] = [f64::NAN; 3];
        (10..16).for_each(|i| picture[i] = [f64::NAN; 3]);
        assert!(reference.difference(&picture).is_err_and(|why| why.contains("not finite")));
    }

    #[test]
    fn brightness_is_relative() {
        let n = 1_000;
        let reference = Reference::new([grey(&noise(n, 1), 0.01), grey(&noise(n, 2), 0.01)]);
        let picture: Vec<[f64; 3]> = reference.mean.iter().map(|v| v.map(|v| 1.25 * v)).collect();
        let found = reference.difference(&picture).unwrap();
        assert!((found.brightness - 1.25).abs() < 1e-12, "{found:?}");
        assert!((found.error - 0.0625 / 1.01).abs() < 1e-4, "{found:?}");
    }

    #[test]
    fn references_have_plain_file_names() {
        let name = file_name("a/b c", "0123", (320, 180), 512, 1);
        assert_eq!(name, PathBuf::from("a_b_c-0123-320x180-512-1.exr"));
    }
}

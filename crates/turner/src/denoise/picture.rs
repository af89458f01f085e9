//! What the denoiser needs, from a film.

use super::light::luminance;
use super::{Buffers, Caught, GUIDES, Part, Rgb, around};
use crate::film::{CAUGHT, DENOISING_CHANNELS, Developed, Film, KEPT_PIXELS, strips};

/// More coverage by shadow catchers than this is all of it.
const WHOLE: f32 = 0.999;

impl Buffers {
    /// Whether a film holds what the denoiser needs, and its picture has at most 16 million pixels.
    pub fn are_held(film: &Film) -> bool {
        film.crop.area() <= KEPT_PIXELS
            && film.identity().estimates_error
            && film.channels().iter().any(|channel| channel.name == DENOISING_CHANNELS[0])
    }

    /// From a film and its picture. `None` if the film does not hold what is needed.
    pub(crate) fn of_film(film: &Film, picture: &Developed<'_>, threads: usize) -> Option<Buffers> {
        let pixels = picture.kept().filter(|_| Buffers::are_held(film))?;
        let source = Source { film, picture, pixels, planes: planes(film, &DENOISING_CHANNELS, threads) };
        let each = strips::map(pixels.len(), threads, |i| source.pixel(i));
        let part = |of: fn(&Pixel) -> (Rgb, f32)| {
            let (mean, variance) = each.iter().map(of).unzip();
            Part { mean, variance }
        };
        let mut buffers = Buffers {
            width: film.crop.width as usize,
            height: film.crop.height as usize,
            emission: part(|pixel| pixel.emission),
            reflected: part(|pixel| pixel.reflected),
            guides: each.iter().map(|pixel| pixel.guides).collect(),
            guide_variances: each.iter().map(|pixel| pixel.guide_variances).collect(),
            caught: Vec::new(),
            uncertain: Vec::new(),
        };
        if film.channels().iter().any(|channel| channel.name == CAUGHT[0]) {
            buffers.take_shadows(&planes(film, &CAUGHT, threads), threads);
        }
        Some(buffers)
    }

    /// Takes what is behind shadow catchers out of the kinds of light. A pixel that shows other objects, too, has few samples
    /// of the shadow, which becomes that of the pixels around.
    fn take_shadows(&mut self, caught: &[Vec<f32>], threads: usize) {
        let (width, height) = (self.width, self.height);
        let [coverage, shadowed, unshadowed, behind @ .., _] = caught else { return };
        let ratio = |shadowed: f32, unshadowed: f32| {
            if unshadowed > 0.0 { (shadowed / unshadowed).clamp(0.0, 1.0) } else { 1.0 }
        };
        let is_whole = |i: usize| coverage[i] > WHOLE;
        let own = |i: usize| ratio(shadowed[i], unshadowed[i]);
        self.caught = strips::map(coverage.len(), threads, |i| {
            let behind: Rgb = std::array::from_fn(|c| behind[c][i]);
            if !is_whole(i) {
                let near = |of: &[f32]| around(width, height, i, 2).map(|j| of[j]).sum::<f32>();
                let lit = if coverage[i] > 0.0 { ratio(near(shadowed), near(unshadowed)) } else { 1.0 };
                return Caught { behind, lit, variance: 0.0, is_whole: false };
            }
            let (mut sum, mut count) = (0.0, 0.0);
            for j in around(width, height, i, 1) {
                // The four neighbours that share an edge.
                if (j % width == i % width) != (j / width == i / width) && is_whole(j) {
                    sum += own(j);
                    count += 1.0;
                }
            }
            // The difference of independent values from the mean of n neighbours has 1 + 1 / n times their variance.
            let lit = own(i);
            let apart = if count > 0.0 { lit - sum / count } else { 0.0 };
            let variance = apart * apart * count / (count + 1.0f32);
            Caught { behind, lit, variance, is_whole: true }
        });
        for i in (0..coverage.len()).filter(|i| coverage[*i] > 0.0) {
            if is_whole(i) {
                for part in [&mut self.emission, &mut self.reflected] {
                    (part.mean[i], part.variance[i]) = ([0.0; 3], 0.0);
                }
                continue;
            }
            let kept_off = 1.0 - own(i);
            for (c, behind) in self.caught[i].behind.into_iter().enumerate() {
                // The picture has the shadow, emission has none.
                self.emission.mean[i][c] -= behind;
                self.reflected.mean[i][c] += behind * kept_off;
            }
        }
    }
}

/// The values of these channels, row by row.
fn planes(film: &Film, names: &[&str], threads: usize) -> Vec<Vec<f32>> {
    names.iter().map(|name| film.channel_values(name, threads)).collect()
}

/// A film, its picture and its channels for the denoiser.
struct Source<'a> {
    film: &'a Film,
    picture: &'a Developed<'a>,
    pixels: &'a [[f32; 4]],
    planes: Vec<Vec<f32>>,
}

/// Means and variances of the means of a pixel.
#[derive(Clone, Default)]
struct Pixel {
    emission: (Rgb, f32),
    reflected: (Rgb, f32),
    guides: [f32; GUIDES],
    guide_variances: [f32; 3],
}

fn sound(v: f32) -> f32 {
    if v.is_finite() { v } else { 0.0 }
}

impl Source<'_> {
    /// The value of a channel.
    fn at(&self, channel: usize, i: usize) -> f32 {
        self.planes.get(channel).and_then(|plane| plane.get(i)).map_or(0.0, |v| sound(*v))
    }

    fn pixel(&self, i: usize) -> Pixel {
        let crop = self.film.crop;
        let (x, y) = (crop.x + i as u32 % crop.width, crop.y + i as u32 / crop.width);
        let (count, of_splats) = self.film.count_and_splats(x, y).unwrap_or((0.0, 0.0));
        // Of the mean of n samples: (E(v²) − E(v)²) / (n − 1).
        let spread = |square: f32, mean_square: f32| {
            (count > 1.5).then(|| sound((square - mean_square).max(0.0) / (count - 1.0) as f32))
        };
        // Where fireflies were removed, all kinds of light are scaled down alike; the moments of light are squares.
        let kept = self.picture.left_of_fireflies(x, y, &self.pixels[i]);
        let of_mean = |mean: &Rgb, moment: usize| {
            let square = self.at(moment, i) * kept * kept;
            let mean = luminance(mean);
            // A single sample may be anything.
            spread(square, mean * mean).unwrap_or(square)
        };
        let emission: Rgb = std::array::from_fn(|c| self.at(8 + c, i) * kept);
        let reflected: Rgb = std::array::from_fn(|c| sound(self.pixels[i][c]) - emission[c]);
        // The moment is that of the samples, without light paths.
        let splats = self.picture.light(x, y);
        let of_samples = std::array::from_fn(|c| reflected[c] - sound(splats[c]));
        let guides: [f32; GUIDES] = std::array::from_fn(|k| self.at(k, i));
        let [r, g, b, nx, ny, nz, distance] = guides;
        let of_guide = |moment: usize, mean: f32| spread(self.at(moment, i), mean).unwrap_or(0.0);
        Pixel {
            emission: (emission, of_mean(&emission, 11)),
            reflected: (reflected, of_mean(&of_samples, 12) + sound(of_splats as f32)),
            guides,
            guide_variances: [
                of_guide(13, r * r + g * g + b * b),
                of_guide(7, nx * nx + ny * ny + nz * nz),
                of_guide(14, distance * distance),
            ],
        }
    }
}

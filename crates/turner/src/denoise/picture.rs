//! What the denoiser needs, from a film.

use super::light::luminance;
use super::{Buffers, Part, Rgb, around};
use crate::film::{CAUGHT, DENOISING_CHANNELS, Developed, Film, FilmDesc, KEPT_PIXELS, strips};

/// More coverage by shadow catchers than this is all of it.
const WHOLE: f32 = 0.999;

impl Buffers {
    /// Whether a film holds what the denoiser needs, and its picture has at most 16 million pixels.
    pub fn are_held(film: &Film) -> bool {
        film.crop.area() <= KEPT_PIXELS
            && film.identity().estimates_error
            && film.channels().iter().any(|channel| channel.name == DENOISING_CHANNELS[0])
    }

    /// From a film and its picture. `None` if the film does not hold what is needed, or the picture has more than 16
    /// million pixels.
    pub(crate) fn of_film(
        film: &Film,
        desc: &FilmDesc,
        picture: &Developed<'_>,
        threads: usize,
    ) -> Option<Buffers> {
        let pixels = picture.kept().filter(|_| Buffers::are_held(film))?;
        let crop = film.crop;
        let planes: Vec<Vec<f32>> =
            DENOISING_CHANNELS.iter().map(|name| film.channel_values(name, threads)).collect();
        // Where fireflies were removed, all kinds of light are scaled down alike.
        let kept: Vec<f32> = strips::map(pixels.len(), threads, |i| {
            let (x, y) = (crop.x + i as u32 % crop.width, crop.y + i as u32 / crop.width);
            let raw = film.sum(x, y).mean().filter(|_| film.identity().removes_fireflies);
            let Some([r, g, b, _]) = raw else { return 1.0 };
            let light = film.light(desc, x, y);
            let clean: Rgb = std::array::from_fn(|c| pixels[i][c] - light[c]);
            let scale = luminance(&clean) / luminance(&[r, g, b]);
            if scale.is_finite() { scale.clamp(0.0, 1.0) } else { 1.0 }
        });
        let sound = |v: f32| if v.is_finite() { v } else { 0.0 };
        let at = |k: usize, i: usize| planes.get(k).and_then(|plane| plane.get(i)).map_or(0.0, |v| sound(*v));
        let three = |k: usize, i: usize| -> Rgb { std::array::from_fn(|c| at(k + c, i)) };
        // The same for light, of which fireflies were removed; the moments of light are squares.
        let light = |k: usize, i: usize| -> Rgb { std::array::from_fn(|c| at(k + c, i) * kept[i]) };
        let moment = |k: usize, i: usize| at(k, i) * kept[i] * kept[i];
        let counts = strips::map(pixels.len(), threads, |i| {
            let (x, y) = (i as u32 % crop.width, i as u32 / crop.width);
            film.count_and_splats(crop.x + x, crop.y + y).unwrap_or((0.0, 0.0))
        });
        // Of the mean of n samples: (E(v²) − E(v)²) / (n − 1).
        let of_mean = |square: f32, mean: f32, i: usize| {
            let spread = (square - mean * mean).max(0.0);
            // A single sample may be anything.
            if counts[i].0 > 1.5 { spread / (counts[i].0 - 1.0) as f32 } else { square }
        };
        let part = |mean: &dyn Fn(usize) -> Rgb, which: usize| Part {
            mean: (0..pixels.len()).map(mean).collect(),
            variance: (0..pixels.len())
                .map(|i| sound(of_mean(moment(which, i), luminance(&mean(i)), i)))
                .collect(),
        };
        let rest = |i: usize| -> Rgb {
            std::array::from_fn(|c| sound(pixels[i][c]) - light(8, i)[c] - light(11, i)[c])
        };
        // The moment of the rest is that of its samples, without light paths.
        let of_samples = |i: usize| {
            let splats = film.light(desc, crop.x + i as u32 % crop.width, crop.y + i as u32 / crop.width);
            let mut mean = rest(i);
            mean.iter_mut().zip(splats).for_each(|(v, l)| *v -= sound(l));
            mean
        };
        let indirect = Part {
            mean: (0..pixels.len()).map(rest).collect(),
            variance: (0..pixels.len())
                .map(|i| {
                    sound(of_mean(moment(16, i), luminance(&of_samples(i)), i)) + sound(counts[i].1 as f32)
                })
                .collect(),
        };
        let guide = |i: usize| std::array::from_fn(|k| at(k, i));
        let guide_variance = |i: usize| {
            let [a, n] = [three(0, i), three(3, i)];
            let square = |v: Rgb| v.iter().map(|v| v * v).sum::<f32>();
            let spread = |all: f32, mean: f32| {
                if counts[i].0 > 1.5 { (all - mean).max(0.0) / (counts[i].0 - 1.0) as f32 } else { 0.0 }
            };
            let distance = at(6, i);
            [
                spread(at(17, i), square(a)),
                spread(at(7, i), square(n)),
                spread(at(18, i), distance * distance),
            ]
        };
        let mut buffers = Buffers {
            width: crop.width as usize,
            height: crop.height as usize,
            emission: part(&|i| light(8, i), 14),
            direct: part(&|i| light(11, i), 15),
            indirect,
            guides: (0..pixels.len()).map(guide).collect(),
            guide_variances: (0..pixels.len()).map(guide_variance).collect(),
        };
        if film.channels().iter().any(|channel| channel.name == CAUGHT[0]) {
            let caught = CAUGHT.map(|name| film.channel_values(name, threads));
            buffers.take_shadows(&caught, pixels);
        }
        Some(buffers)
    }

    /// Where the camera sees nothing but shadow catchers, the picture is what is behind them, darkened by a fraction of the
    /// light: it is filtered as a whole, as direct light. Where it sees other objects as well, few samples say what that
    /// fraction is, so it becomes that of the pixels around.
    fn take_shadows(&mut self, caught: &[Vec<f32>; CAUGHT.len()], pixels: &[[f32; 4]]) {
        let width = self.width;
        let [coverage, shadowed, unshadowed, behind @ .., _] = caught;
        let kept_off = |shadowed: f32, unshadowed: f32| {
            if unshadowed > 0.0 { (1.0 - shadowed / unshadowed).clamp(0.0, 1.0) } else { 0.0 }
        };
        let is_caught = |i: usize| coverage[i] > WHOLE;
        for i in (0..coverage.len()).filter(|i| coverage[*i] > 0.0 && !is_caught(*i)) {
            let own = kept_off(shadowed[i], unshadowed[i]);
            let sum = |of: &[f32]| around(width, self.height, i, 2).map(|j| of[j]).sum::<f32>();
            let near = kept_off(sum(shadowed), sum(unshadowed));
            for (c, behind) in behind.iter().enumerate() {
                self.emission.mean[i][c] -= behind[i] * near;
                self.indirect.mean[i][c] += behind[i] * own;
            }
        }
        let bright = |i: usize| luminance(&[pixels[i][0], pixels[i][1], pixels[i][2]]);
        for i in (0..coverage.len()).filter(|i| is_caught(*i)) {
            let [r, g, b, _] = pixels[i];
            let (mut sum, mut count) = (0.0, 0.0);
            for j in around(width, self.height, i, 1) {
                // The four neighbours that share an edge.
                if (j % width == i % width) != (j / width == i / width) && is_caught(j) {
                    sum += bright(j);
                    count += 1.0;
                }
            }
            // The difference of independent values from their neighbours' mean has 1 + 1/4 times their variance.
            let apart = if count > 0.0 { bright(i) - sum / count } else { 0.0 };
            let variance = apart * apart * count / (count + 1.0f32);
            (self.direct.mean[i], self.direct.variance[i]) = ([r, g, b], variance);
            for part in [&mut self.emission, &mut self.indirect] {
                (part.mean[i], part.variance[i]) = ([0.0; 3], 0.0);
            }
        }
    }
}

//! Changes the size of an image before it is compared.

use super::Canvas;
use crate::color::{srgb_decode, srgb_encode};

impl Canvas {
    /// The image with another size (at least 1 x 1), axis by axis: a shorter side holds means over the pixels that it
    /// covers, a longer side values interpolated linearly between pixel centres. Display values are averaged as light.
    pub fn resized(mut self, width: u32, height: u32) -> Canvas {
        let (width, height) = (width.max(1), height.max(1));
        if (width, height) == (self.width, self.height) {
            return self;
        }
        if !self.is_linear {
            self.pixels.iter_mut().for_each(|p| *p = through(*p, srgb_decode));
        }
        let rows = weights(self.width as usize, width as usize);
        let columns = weights(self.height as usize, height as usize);
        let mut wide = Vec::with_capacity(width as usize * self.height as usize);
        for row in self.pixels.chunks_exact(self.width as usize) {
            wide.extend(rows.iter().map(|w| w.mean(|i| row[i])));
        }
        self.pixels = Vec::with_capacity(width as usize * height as usize);
        for w in &columns {
            let at = |x: usize| w.mean(|y| wide[y * width as usize + x]);
            self.pixels.extend((0..width as usize).map(at));
        }
        if !self.is_linear {
            self.pixels.iter_mut().for_each(|p| *p = through(*p, srgb_encode));
        }
        (self.width, self.height) = (width, height);
        self.has_alpha = self.pixels.iter().any(|p| p[3] != 1.0);
        self
    }
}

/// Applies a curve to the colour without its alpha.
fn through([r, g, b, a]: [f32; 4], curve: fn(f32) -> f32) -> [f32; 4] {
    if a <= 0.0 {
        return [0.0, 0.0, 0.0, a];
    }
    let [r, g, b] = [r, g, b].map(|v| curve(v / a) * a);
    [r, g, b, a]
}

/// The pixels that make up a new one.
struct Weights {
    first: usize,
    /// Weights of `first` and its successors, with the sum 1.
    weights: Vec<f64>,
}

impl Weights {
    fn mean(&self, pixel: impl Fn(usize) -> [f32; 4]) -> [f32; 4] {
        let mut sum = [0.0f64; 4];
        for (i, weight) in self.weights.iter().enumerate() {
            for (s, v) in sum.iter_mut().zip(pixel(self.first + i)) {
                *s += weight * f64::from(v);
            }
        }
        sum.map(|s| s as f32)
    }
}

/// The weights for a side of `from` pixels that becomes `to`.
fn weights(from: usize, to: usize) -> Vec<Weights> {
    let step = from as f64 / to as f64;
    (0..to)
        .map(|i| {
            if to >= from {
                // Between the centres of two pixels.
                let at = ((i as f64 + 0.5) * step - 0.5).clamp(0.0, from as f64 - 1.0);
                let first = (at as usize).min(from - 1);
                let part = at - first as f64;
                let weights = if part > 0.0 { vec![1.0 - part, part] } else { vec![1.0] };
                return Weights { first, weights };
            }
            // In units of 1 / to of a pixel, so that the covered parts are exact.
            let (start, end) = (i * from, (i + 1) * from);
            let (first, last) = (start / to, (end - 1) / to);
            let covered = |j: usize| end.min((j + 1) * to) - start.max(j * to);
            let weights = (first..=last).map(|j| covered(j) as f64 / from as f64).collect();
            Weights { first, weights }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn canvas(width: u32, values: &[f32], is_linear: bool) -> Canvas {
        let pixels: Vec<[f32; 4]> = values.iter().map(|v| [*v, *v, *v, 1.0]).collect();
        Canvas { width, height: values.len() as u32 / width, pixels, has_alpha: false, is_linear }
    }

    fn greys(canvas: &Canvas) -> Vec<f32> {
        canvas.pixels.iter().map(|p| p[0]).collect()
    }

    #[test]
    fn smaller_sides_are_means() {
        let c = canvas(4, &[0.0, 4.0, 8.0, 0.0, 2.0, 2.0, 0.0, 4.0], true);
        assert_eq!(greys(&c.clone().resized(2, 1)), [2.0, 3.0]);
        assert_eq!(greys(&c.clone().resized(1, 2)), [3.0, 2.0]);
        // Three of four pixels: each covers one and a third.
        let thirds = greys(&c.resized(3, 2));
        assert!((thirds[0] - 1.0).abs() < 1e-6 && (thirds[1] - 6.0).abs() < 1e-6, "{thirds:?}");
    }

    #[test]
    fn larger_sides_are_interpolated() {
        let c = canvas(2, &[0.0, 4.0], true);
        assert_eq!(greys(&c.clone().resized(4, 1)), [0.0, 1.0, 3.0, 4.0]);
        let same = c.clone().resized(2, 3);
        assert_eq!(greys(&same), [0.0, 4.0, 0.0, 4.0, 0.0, 4.0]);
        assert_eq!(c.clone().resized(2, 1), c);
    }

    #[test]
    fn display_values_are_averaged_as_light() {
        let c = canvas(2, &[0.0, 1.0], false).resized(1, 1);
        assert!((c.pixels[0][0] - srgb_encode(0.5)).abs() < 1e-6);
    }

    #[test]
    fn transparent_pixels_lend_no_colour() {
        let mut c = canvas(2, &[0.0, 1.0], false);
        c.pixels[0] = [0.0; 4];
        let half = c.resized(1, 1);
        assert!(half.has_alpha && half.pixels[0] == [0.5, 0.5, 0.5, 0.5], "{half:?}");
    }

    #[test]
    fn every_size_keeps_a_constant() {
        for (from, to) in [(7, 3), (3, 7), (64, 65), (65, 64), (1, 5), (5, 1), (100, 37)] {
            let found = greys(&canvas(from, &vec![0.75; from as usize], true).resized(to, 1));
            assert_eq!(found.len(), to as usize);
            assert!(found.iter().all(|v| (v - 0.75).abs() < 1e-6), "{from} to {to}: {found:?}");
        }
    }
}

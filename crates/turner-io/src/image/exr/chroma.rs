//! Pictures of luminance and chroma: the channels Y, RY and BY.
//!
//! `Y` is the luminance, `RY` = (R − Y)/Y and `BY` = (B − Y)/Y. The chroma has usually a quarter of the samples, those
//! of even pixels in even rows. The others are reconstructed as OpenEXR's library does it ("Technical Introduction to
//! OpenEXR", luminance/chroma images): by a symmetric filter of fourteen samples, along rows and then along columns.
//! Where a reconstructed colour is more saturated than its neighbours, it is desaturated at equal luminance.

use exr::meta::attribute::Chromaticities;

use super::primaries;

/// Weights of the samples at the distances 1, 3, … 13.
const FILTER: [f32; 7] = [0.627_123, -0.186_077, 0.087_929, -0.043_159, 0.019_597, -0.007_54, 0.002_128];

/// A picture with `channels` values per pixel, row by row.
pub(super) struct Picture<'a> {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) channels: usize,
    /// RY, Y, BY and perhaps alpha of each pixel; later R, G, B and alpha.
    pub(super) values: &'a mut [f32],
}

impl Picture<'_> {
    /// Reconstructs the chroma of pixels in odd columns and rows.
    pub(super) fn reconstruct(&mut self) {
        for y in (0..self.height).step_by(2) {
            for x in (1..self.width).step_by(2) {
                let at = |x: usize| (x, y);
                self.filter((x, y), x, self.width, at);
            }
        }
        for y in (1..self.height).step_by(2) {
            for x in 0..self.width {
                let at = |y: usize| (x, y);
                self.filter((x, y), y, self.height, at);
            }
        }
    }

    /// Filters the chroma of a pixel at an odd position `i` along an axis with `count` pixels.
    fn filter(&mut self, to: (usize, usize), i: usize, count: usize, at: impl Fn(usize) -> (usize, usize)) {
        // Beyond the ends the outermost sample continues.
        let last = (count - 1) & !1;
        for channel in [0, 2] {
            let mut sum = 0.0;
            for (k, weight) in FILTER.iter().enumerate() {
                let step = 2 * k + 1;
                let (before, after) = (i.saturating_sub(step), (i + step).min(last));
                sum += weight * (self.value(at(before & !1), channel) + self.value(at(after), channel));
            }
            let index = (to.1 * self.width + to.0) * self.channels + channel;
            if let Some(value) = self.values.get_mut(index) {
                *value = sum;
            }
        }
    }

    fn value(&self, (x, y): (usize, usize), channel: usize) -> f32 {
        self.values.get((y * self.width + x) * self.channels + channel).copied().unwrap_or_default()
    }

    /// Converts to R, G and B with the luminance weights `weights`.
    pub(super) fn convert(&mut self, weights: [f32; 3]) {
        let [r, g, b] = weights;
        for pixel in self.values.chunks_exact_mut(self.channels) {
            if let [ry, y, by, ..] = pixel {
                let luminance = *y;
                let (red, blue) = ((*ry + 1.0) * luminance, (*by + 1.0) * luminance);
                let green = (luminance - red * r - blue * b) / g;
                let is_grey = *ry == 0.0 && *by == 0.0;
                [*ry, *y, *by] = if is_grey { [luminance; 3] } else { [red, green, blue] };
            }
        }
    }

    /// Desaturates pixels that are more saturated than the mean of their diagonal neighbours allows.
    pub(super) fn limit_saturation(&mut self, weights: [f32; 3]) {
        let (width, channels) = (self.width, self.channels);
        let row = |values: &[f32], y: usize| -> Vec<f32> {
            let pixels = values.chunks_exact(channels).skip(y * width).take(width);
            pixels.map(|p| if let [r, g, b, ..] = p { saturation([*r, *g, *b]) } else { 0.0 }).collect()
        };
        let last = self.height - 1;
        // A row before the first is the first; one after the last is the last even one. Saturations are those before
        // any pixel is desaturated.
        let mut above = row(self.values, 0);
        let mut own = above.clone();
        let mut last_even = own.clone();
        for y in 0..self.height {
            if y % 2 == 0 {
                last_even.clone_from(&own);
            }
            let below = if y < last { row(self.values, y + 1) } else { last_even.clone() };
            let pixels = self.values.chunks_exact_mut(channels).skip(y * width).take(width);
            for (x, pixel) in pixels.enumerate() {
                let beside = [x.saturating_sub(1), (x + 1).min(width - 1)];
                let mean = beside.iter().map(|x| 0.25 * (above[*x] + below[*x])).sum::<f32>().min(1.0);
                let most = 1.0 - 0.25 * (1.0 - mean);
                if let ([r, g, b, ..], true) = (pixel, own[x] > most) {
                    [*r, *g, *b] = desaturated([*r, *g, *b], most / own[x], weights);
                }
            }
            above = std::mem::replace(&mut own, below);
        }
    }
}

/// 1 − the smallest over the largest component.
fn saturation([r, g, b]: [f32; 3]) -> f32 {
    let (most, least) = (r.max(g).max(b), r.min(g).min(b));
    if most > 0.0 { 1.0 - least / most } else { 0.0 }
}

/// The colour with a fraction of its saturation and the same luminance.
fn desaturated(color: [f32; 3], fraction: f32, weights: [f32; 3]) -> [f32; 3] {
    let most = color.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let out = color.map(|v| (most - (most - v) * fraction).max(0.0));
    let luminance = |c: [f32; 3]| c.iter().zip(weights).map(|(v, w)| v * w).sum::<f32>();
    let (before, after) = (luminance(color), luminance(out));
    if after > 0.0 { out.map(|v| v * before / after) } else { out }
}

/// The luminance of red, green and blue; Rec. 709 without chromaticities.
pub(super) fn weights(chromaticities: Option<&Chromaticities>) -> [f32; 3] {
    let matrix = chromaticities.and_then(primaries::xyz_of_rgb).unwrap_or_else(primaries::rec709);
    let row = matrix.transpose().y_axis;
    (row / (row.x + row.y + row.z)).to_array().map(|v| v as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_even_chroma_stays_even() {
        let mut values: Vec<f32> = (0..6 * 4)
            .flat_map(|i| if i % 2 == 0 && i / 6 % 2 == 0 { [0.5, 1.0, -0.25] } else { [0.0, 1.0, 0.0] })
            .collect();
        let mut picture = Picture { width: 6, height: 4, channels: 3, values: &mut values };
        picture.reconstruct();
        for pixel in picture.values.chunks_exact(3) {
            assert!((pixel[0] - 0.5).abs() < 1e-5 && (pixel[2] + 0.25).abs() < 1e-5, "{pixel:?}");
        }
        let weights = weights(None);
        assert!((weights[1] - 0.7152).abs() < 2e-4 && (weights.iter().sum::<f32>() - 1.0).abs() < 1e-6);
        picture.convert(weights);
        let [r, g, b] = [picture.values[0], picture.values[1], picture.values[2]];
        assert!((r - 1.5).abs() < 1e-4 && (b - 0.75).abs() < 1e-4);
        let luminance = r * weights[0] + g * weights[1] + b * weights[2];
        assert!((luminance - 1.0).abs() < 1e-5);
    }

    #[test]
    fn a_speck_of_colour_is_desaturated_at_equal_luminance() {
        let mut values = [[0.5, 0.5, 0.5]; 9].concat();
        values[12..15].copy_from_slice(&[1.0, 0.0, 0.0]);
        let weights = [0.25, 0.5, 0.25];
        Picture { width: 3, height: 3, channels: 3, values: &mut values }.limit_saturation(weights);
        // The neighbours are grey: the limit is 1 − 1/4.
        let [r, g, b] = [values[12], values[13], values[14]];
        assert!((saturation([r, g, b]) - 0.75).abs() < 1e-6);
        assert!((0.25 * r + 0.5 * g + 0.25 * b - 0.25).abs() < 1e-6);
        assert_eq!(&values[..3], &[0.5; 3]);
    }
}

//! Samples of an image, and what is done to them: swizzle, orientation, straight alpha.

use super::container::Shown;
use super::fault::{Outcome, list};

/// Interleaved samples.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Samples {
    U8(Vec<u8>),
    U16(Vec<u16>),
    F32(Vec<f32>),
}

/// A type of sample.
trait Sample: Copy + Default {
    /// The value of full intensity.
    const ONE: Self;

    /// The colour that alpha was multiplied with, at most full intensity for integers; 0 if alpha is 0.
    fn divided(self, alpha: Self) -> Self;
}

impl Sample for u8 {
    const ONE: u8 = 255;

    fn divided(self, alpha: u8) -> u8 {
        let (value, alpha) = (u32::from(self) * 255, u32::from(alpha));
        (value + alpha / 2).checked_div(alpha).unwrap_or(0).min(255) as u8
    }
}

impl Sample for u16 {
    const ONE: u16 = 65535;

    fn divided(self, alpha: u16) -> u16 {
        let (value, alpha) = (u64::from(self) * 65535, u64::from(alpha));
        (value + alpha / 2).checked_div(alpha).unwrap_or(0).min(65535) as u16
    }
}

impl Sample for f32 {
    const ONE: f32 = 1.0;

    fn divided(self, alpha: f32) -> f32 {
        if alpha > 0.0 { self / alpha } else { 0.0 }
    }
}

/// The channels of a picture, grey or RGB with or without alpha, in terms of stored channels.
pub(super) struct View {
    shown: [Shown; 4],
    /// 1 (grey), 2 (grey, alpha), 3 (RGB) or 4 (RGBA).
    pub(super) channels: usize,
}

impl View {
    /// The view that shows stored channels by `shown`; those from `stored` on do not exist.
    pub(super) fn new(shown: [Shown; 4], stored: usize) -> View {
        let mut shown = shown;
        for (i, channel) in shown.iter_mut().enumerate() {
            if matches!(*channel, Shown::Channel(c) if c >= stored) {
                *channel = if i == 3 { Shown::One } else { Shown::Zero };
            }
        }
        let [red, green, blue, alpha] = shown;
        let colors = if red == green && green == blue { 1 } else { 3 };
        View { shown, channels: colors + usize::from(alpha != Shown::One) }
    }

    /// The channels in the order of the picture.
    fn order(&self) -> [Shown; 4] {
        let [red, green, blue, alpha] = self.shown;
        match self.channels {
            1 | 2 => [red, alpha, alpha, alpha],
            _ => [red, green, blue, alpha],
        }
    }

    /// Replaces pixels of `stored` channels by those of the view.
    fn apply<T: Sample>(&self, samples: Vec<T>, stored: usize) -> Outcome<Vec<T>> {
        let order = self.order();
        if self.channels == stored && (0..stored).all(|i| order[i] == Shown::Channel(i)) {
            return Ok(samples);
        }
        let pixels = samples.len() / stored.max(1);
        let mut out = list(pixels * self.channels)?;
        for (to, from) in out.chunks_exact_mut(self.channels).zip(samples.chunks_exact(stored.max(1))) {
            for (value, shown) in to.iter_mut().zip(order) {
                *value = match shown {
                    Shown::Channel(c) => from.get(c).copied().unwrap_or_default(),
                    Shown::Zero => T::default(),
                    Shown::One => T::ONE,
                };
            }
        }
        Ok(out)
    }
}

/// How stored pixels become a picture.
pub(super) struct Arrangement {
    /// Channels of a stored pixel.
    pub(super) stored: usize,
    pub(super) view: View,
    /// Columns of the picture.
    pub(super) width: usize,
    /// Whether columns and rows are reversed.
    pub(super) is_flipped: (bool, bool),
    /// Whether colours are multiplied by alpha.
    pub(super) is_premultiplied: bool,
}

impl Arrangement {
    /// The samples of the picture.
    pub(super) fn apply(&self, samples: Samples) -> Outcome<Samples> {
        Ok(match samples {
            Samples::U8(samples) => Samples::U8(self.arranged(samples)?),
            Samples::U16(samples) => Samples::U16(self.arranged(samples)?),
            Samples::F32(samples) => Samples::F32(self.arranged(samples)?),
        })
    }

    fn arranged<T: Sample>(&self, samples: Vec<T>) -> Outcome<Vec<T>> {
        let mut samples = self.view.apply(samples, self.stored)?;
        let channels = self.view.channels;
        if self.is_premultiplied && channels.is_multiple_of(2) {
            for pixel in samples.chunks_exact_mut(channels) {
                if let Some((alpha, colors)) = pixel.split_last_mut() {
                    colors.iter_mut().for_each(|color| *color = color.divided(*alpha));
                }
            }
        }
        let stride = (self.width * channels).max(1);
        if self.is_flipped.0 {
            for row in samples.chunks_exact_mut(stride) {
                row.reverse();
                row.chunks_exact_mut(channels).for_each(<[T]>::reverse);
            }
        }
        if self.is_flipped.1 {
            let rows = samples.len() / stride;
            for row in 0..rows / 2 {
                let (above, below) = samples.split_at_mut((rows - 1 - row) * stride);
                if let (Some(one), Some(other)) =
                    (above.get_mut(row * stride..(row + 1) * stride), below.get_mut(..stride))
                {
                    one.swap_with_slice(other);
                }
            }
        }
        Ok(samples)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arrange(
        shown: [Shown; 4],
        stored: usize,
        is_flipped: (bool, bool),
        is_premultiplied: bool,
    ) -> Vec<u8> {
        let view = View::new(shown, stored);
        let arrangement = Arrangement { stored, view, width: 2, is_flipped, is_premultiplied };
        // Two columns, three rows.
        let samples = (0..6 * stored as u8).map(|i| 10 * i).collect();
        match arrangement.apply(Samples::U8(samples)).unwrap() {
            Samples::U8(samples) => samples,
            other => panic!("{other:?}"),
        }
    }

    const RGBA: [Shown; 4] = [Shown::Channel(0), Shown::Channel(1), Shown::Channel(2), Shown::Channel(3)];

    #[test]
    fn channels_that_are_not_stored_are_black_and_opaque() {
        assert_eq!(View::new(RGBA, 4).channels, 4);
        assert_eq!(arrange(RGBA, 2, (false, false), false)[..6], [0, 10, 0, 20, 30, 0]);
        let grey = [Shown::Channel(0), Shown::Channel(0), Shown::Channel(0), Shown::Channel(1)];
        assert_eq!(arrange(grey, 1, (false, false), false), [0, 10, 20, 30, 40, 50]);
        assert_eq!(arrange(grey, 2, (false, false), false)[..4], [0, 10, 20, 30]);
    }

    #[test]
    fn rows_and_columns_are_reversed() {
        let grey = [Shown::Channel(0), Shown::Channel(0), Shown::Channel(0), Shown::One];
        assert_eq!(arrange(grey, 1, (true, false), false), [10, 0, 30, 20, 50, 40]);
        assert_eq!(arrange(grey, 1, (false, true), false), [40, 50, 20, 30, 0, 10]);
        assert_eq!(arrange(RGBA, 3, (true, true), false)[..6], [150, 160, 170, 120, 130, 140]);
    }

    #[test]
    fn colors_are_divided_by_alpha() {
        let alpha = [Shown::Channel(0), Shown::Channel(0), Shown::Channel(0), Shown::Channel(1)];
        assert_eq!(arrange(alpha, 2, (false, false), true)[..6], [0, 10, 170, 30, 204, 50]);
    }
}

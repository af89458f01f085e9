//! Differences between two images, in the usual metrics.
//!
//! ```text
//! Image ── Canvas::new ──┐
//!                        ├─ Pair::new ── Metric::measure ──> Measured: one value, the worst pixel, one value
//!                        per pixel
//! Image ── Canvas::new ──┘  checks size, alpha, non-finite pixels (Canvas::resized changes a size before)
//! ```
//!
//! The first image is the reference. Images hold either linear light (EXR, HDR) or display values (PNG, JPEG).
//! `max`, `mean`, `rmse` and `relmse` compare the stored values; `psnr`, `ssim` and `flip` compare what a
//! display shows.
//!
//! | metric | what | in |
//! |---|---|---|
//! | `max` `mean` | largest and mean absolute difference | [`mod@absolute`] |
//! | `rmse` `psnr` | root mean square difference; the same in decibels, of display values | [`mod@square`] |
//! | `relmse` | mean square difference relative to the reference | [`mod@relative`] |
//! | `ssim` | structural similarity, Wang et al. 2004 | [`mod@ssim`] |
//! | `flip` | visible differences, Andersson et al. 2020, and 2021 for linear light | [`mod@flip`] |
//!
//! ```
//! use turner::compare::{Canvas, Metric, Pair};
//! use turner::image::{Image, Pixels};
//!
//! let grey = |v: f32| Image { width: 2, height: 1, channels: 1, pixels: Pixels::F32(vec![0.5, v]) };
//! let pair = Pair::new(Canvas::new(&grey(0.5), false), Canvas::new(&grey(0.75), false))?;
//! let max = Metric::Max.measure(&pair, 1);
//! assert_eq!(max.value, 0.25);
//! assert_eq!((max.worst.x, max.worst.y), (1, 0));
//! # Ok::<(), turner::compare::Mismatch>(())
//! ```

pub mod absolute;
pub mod flip;
mod kernel;
mod pair;
pub mod relative;
mod resize;
pub mod square;
pub mod ssim;
mod strips;

pub use pair::{Canvas, Mismatch, NonFinite, Pair};
pub use relative::relative_mse;

/// A metric.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Metric {
    /// Largest absolute difference of a channel, in the stored values.
    Max,
    /// Mean absolute difference of all channels.
    Mean,
    /// Root of the mean square difference of all channels.
    Rmse,
    /// Mean square difference relative to the reference's square: see [`relative_mse`].
    RelMse,
    /// Peak signal-to-noise ratio of display values in decibels; infinite for equal images.
    Psnr,
    /// Structural similarity of display values: 1 for equal images, 0 or less for unrelated ones.
    Ssim,
    /// FLIP: 0 for equal images, 1 for the largest visible difference.
    Flip,
}

impl Metric {
    /// All metrics.
    pub const ALL: [Metric; 7] =
        [Metric::Max, Metric::Mean, Metric::Rmse, Metric::RelMse, Metric::Psnr, Metric::Ssim, Metric::Flip];

    /// Its name in commands and JSON.
    pub fn word(self) -> &'static str {
        match self {
            Metric::Max => "max",
            Metric::Mean => "mean",
            Metric::Rmse => "rmse",
            Metric::RelMse => "relmse",
            Metric::Psnr => "psnr",
            Metric::Ssim => "ssim",
            Metric::Flip => "flip",
        }
    }

    /// Its name in text.
    pub fn title(self) -> &'static str {
        match self {
            Metric::Max => "maximum",
            Metric::Mean => "mean",
            Metric::Rmse => "RMSE",
            Metric::RelMse => "relMSE",
            Metric::Psnr => "PSNR",
            Metric::Ssim => "SSIM",
            Metric::Flip => "FLIP",
        }
    }

    /// Whether larger values mean more similar images.
    pub fn is_similarity(self) -> bool {
        matches!(self, Metric::Psnr | Metric::Ssim)
    }

    /// Whether a value is at least as good as `tolerance`: at most that, or at least that for similarities.
    pub fn is_within(self, value: f64, tolerance: f64) -> bool {
        if self.is_similarity() { value >= tolerance } else { value <= tolerance }
    }

    /// Measures a pair on `threads` threads (at least one). The result does not depend on their number.
    pub fn measure(self, pair: &Pair, threads: usize) -> Measured {
        match self {
            Metric::Max => absolute::max(pair),
            Metric::Mean => absolute::mean(pair),
            Metric::Rmse => square::rmse(pair),
            Metric::RelMse => relative::relmse(pair),
            Metric::Psnr => square::psnr(pair),
            Metric::Ssim => ssim::ssim(pair, threads),
            Metric::Flip => flip::flip(pair, threads),
        }
    }
}

/// The pixel that differs most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Worst {
    /// Column.
    pub x: u32,
    /// Row.
    pub y: u32,
    /// Its value in the map; of equal ones the first in reading order.
    pub value: f32,
}

/// The result of a metric.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// For the entire image.
    pub value: f64,
    /// The pixel that differs most.
    pub worst: Worst,
    /// One value of at least 0 per pixel, row by row; larger is worse. For `ssim` it is 1 − SSIM.
    pub map: Vec<f32>,
}

impl Measured {
    fn new(pair: &Pair, value: f64, map: Vec<f32>) -> Measured {
        let (mut at, mut most) = (0, f32::NEG_INFINITY);
        for (i, v) in map.iter().enumerate() {
            if *v > most {
                (at, most) = (i, *v);
            }
        }
        let width = pair.width.max(1) as usize;
        let worst = Worst { x: (at % width) as u32, y: (at / width) as u32, value: most };
        Measured { value, worst, map }
    }
}

/// The mean of a map.
fn mean_of(map: &[f32]) -> f64 {
    map.iter().map(|v| f64::from(*v)).sum::<f64>() / map.len().max(1) as f64
}

#[cfg(test)]
mod testing;

//! The film: what is asked of the picture, and the sums that become it.
//!
//! A [`Film`] has named channels: colour times coverage, coverage, and any further [`Channel`]. A pixel keeps sums of weighted
//! values and of weights, in fixed point, so that samples may come in any order. For each tile the film knows the numbers of its
//! samples, and of the light paths their numbers. So a render may stop at any moment and go on, films of parts of a picture
//! [merge](Film::merge), and no sample counts twice. Bytes of a film ([`Film::to_bytes`]) travel between machines.
//!
//! The contract:
//!
//! - Pixel (0, 0) is at the top left; x counts columns, y rows. A place (x, y) in pixels is within pixel (floor x, floor y).
//! - A sample is radiance in linear Rec. 709 (or the display's numbers, with `transfer = "none"`), already multiplied by its coverage, with that coverage, 0..=1. No exposure and
//!   no curve: these are for [`Film::develop`].
//! - A pixel is the sum of weighted values over the sum of weights. Samples placed by the filter's own density have weight 1 and count in one pixel; [`TileSums::splat`] weights a
//!   sample by the filter in all pixels it reaches.
//! - What light paths bring ([`Splat`]) has no weight: it is added up, and the number of light paths divides the sum.
//! - A sample with a NaN or an infinity is left out and counted, with its pixel and number ([`NonFinite`]).
//! - A sample number counts once in a tile: a pass skips what the tile holds, and merging refuses films that both hold it.
//! - Sums do not depend on the order: any threads, tiles, passes and merges give the same bytes.

mod band;
mod bytes;
#[cfg(test)]
mod bytes_tests;
mod channel;
mod checksum;
mod develop;
mod exposure;
mod fixed;
mod identity;
mod merge;
mod non_finite;
mod pixel_sum;
mod preview;
mod sample_set;
mod shared;
mod splats;
mod sums;
mod tile_sums;
mod tiles;

pub use channel::{COLOR_CHANNELS, Channel, MAX_CHANNELS, MAX_NAME};
pub use checksum::checksum;
pub use develop::{Picture, PixelRect};
pub use fixed::Fixed96;
pub use identity::Identity;
pub use non_finite::NonFinite;
pub use pixel_sum::PixelSum;
pub use preview::{COARSE, Preview};
pub use sample_set::SampleSet;
pub use shared::SharedFilm;
pub use splats::{Splat, Splats};
pub use sums::{Film, MAX_PIXELS};
pub use tile_sums::{SampleValues, TileSums};
pub use tiles::{TILE, TileGrid};

use crate::color::{Spectrum, Tonemap, Transfer};
use crate::filter::{Filter, FilterKind};
use crate::schema::{Range, choice, params};

choice! {
    /// How a pixel's colour comes about.
    pub enum Antialias {
        /// One ray through the middle (or corner) of each pixel.
        None = "none",
        /// The paper's quick filter: one ray per pixel, then the mean of the pixel and its eight neighbours.
        Mean = "mean",
        /// A regular grid of rays per pixel: `samples`, rounded up to a square number.
        Grid = "grid",
        /// Whitted's subdivision: rays through the corners; where they differ by more than `threshold` the square is divided, up to `max_subdivisions` times.
        Adaptive = "adaptive",
        /// `samples` rays at random places of the pixel, one in each of as many parts.
        MonteCarlo = "monte-carlo",
    }
}

choice! {
    /// Where in the pixel its one ray goes.
    pub enum PixelSample {
        /// Through its middle.
        Center = "center",
        /// Through its lower left corner, as the from-scratch book does.
        Corner = "corner",
    }
}

choice! {
    /// Whether textures are averaged over what a ray's cone covers of them.
    pub enum TextureFilter {
        /// Where light is followed ("path", "direct"); not by the other integrators, which show textures as the classic documents do.
        Auto = "auto",
        /// With every integrator that shows colours.
        On = "on",
        /// Never: textures are looked up at points.
        Off = "off",
    }
}

params! {
    /// Size, sampling, exposure and transfer curve of the picture.
    pub struct FilmDesc as "film" {
        /// Columns of pixels.
        width: u32 = 640, in Range::closed(1.0, 65536.0);
        /// Rows of pixels.
        height: u32 = 480, in Range::closed(1.0, 65536.0);
        /// Part of the picture to render: [first column, first row, columns, rows], from the top left.
        crop: Option<[u32; 4]> = None;
        /// How a pixel's colour comes about.
        antialias: Antialias = Antialias::None;
        /// Rays per pixel for "grid" and "monte-carlo".
        samples: u32 = 16, in Range::closed(1.0, 16777216.0);
        /// For "adaptive": the difference between corners, in any colour channel, above which a square is divided.
        threshold: f64 = 0.05, in Range::NON_NEGATIVE;
        /// For "adaptive": how often a square is divided; each time into four.
        max_subdivisions: u32 = 3, in Range::closed(0.0, 6.0);
        /// How "monte-carlo" weights the light around a pixel's middle: its rays are spread accordingly.
        filter: FilterKind = FilterKind::Box;
        /// How far from the pixel's middle the filter reaches, in pixels; without it 0.5 for "box", 1 for "tent", 1.5 for the others.
        filter_radius: Option<f64> = None, in Range { min: 0.0, open_min: true, max: 16.0, open_max: false };
        /// Whether textures are averaged over the part of the surface that a sample stands for, so that distant patterns do not shimmer: "auto" does it with the integrators "path" and "direct".
        texture_filter: TextureFilter = TextureFilter::Auto;
        /// When the shutter opens and closes, as shares of the time in which objects with a `motion` go from their `transform` to it: what moves in between is blurred. OpenPbr
        /// integrators show it; the others show the moment at which it opens.
        shutter: [f64; 2] = [0.0, 1.0], in Range::UNIT;
        /// Where in the pixel the one ray of "none" and "mean" goes.
        pixel_sample: PixelSample = PixelSample::Center;
        /// How scene values become display values, and display colours (#rrggbb, names, 8-bit pictures) scene values.
        transfer: Transfer = Transfer::None;
        /// How light of any strength becomes what a display can show. Applied before the transfer curve, to PNG and JPEG alone: EXR and HDR files hold scene values.
        tonemap: Tonemap = Tonemap::None;
        /// Scene values are multiplied by 2 to this power before they are shown (stops); again for PNG and JPEG alone.
        exposure: f64 = 0.0, in Range::closed(-64.0, 64.0);
        /// Whether the exposure is chosen by the picture: the logarithmic mean of its luminance, without the darkest and the brightest twentieth, becomes a middle grey of 0.18. `exposure` is added.
        auto_exposure: bool = false;
        /// Most that one sample may show in any colour channel; brighter ones are scaled down to it, and 0 is no limit. It takes away fireflies and light: pictures get darker.
        /// What light paths bring (`caustics`) is not cut.
        clamp_sample: f64 = 0.0, in Range::NON_NEGATIVE;
        /// Seed of the random numbers.
        seed: u32 = 0;
    }
    example r#"[film]
width = 320
height = 240
antialias = "adaptive"
threshold = 0.05
"#
}

impl FilmDesc {
    /// Width over height of the picture.
    pub fn aspect(&self) -> f64 {
        f64::from(self.width) / f64::from(self.height)
    }

    /// Samples each pixel gets in all. Adaptive subdivision counts as one, however many rays it takes.
    pub fn samples_per_pixel(&self) -> u32 {
        match self.antialias {
            Antialias::None | Antialias::Mean | Antialias::Adaptive => 1,
            Antialias::Grid => self.grid_side() * self.grid_side(),
            Antialias::MonteCarlo => self.samples,
        }
    }

    /// The filter that places the samples of "monte-carlo".
    pub fn filter(&self) -> Filter {
        Filter::new(self.filter, self.filter_radius)
    }

    /// The share of a sample's light that `clamp_sample` leaves to it.
    #[inline]
    pub(crate) fn clamp_factor(&self, color: Spectrum) -> f32 {
        let (most, max) = (self.clamp_sample as f32, color.max_component());
        if most > 0.0 && max > most { most / max } else { 1.0 }
    }

    /// Whether a filter was asked for that cannot have an effect.
    pub(crate) fn ignores_filter(&self) -> bool {
        let asked = self.filter != FilterKind::Box || self.filter_radius.is_some();
        asked && self.antialias != Antialias::MonteCarlo
    }

    /// Sides of the square grid for at least `samples` rays.
    pub(crate) fn grid_side(&self) -> u32 {
        let side = f64::from(self.samples).sqrt() as u32;
        if side * side < self.samples { side + 1 } else { side.max(1) }
    }
}

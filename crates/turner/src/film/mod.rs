//! The film: its settings, and the sums of samples that become a picture.
//!
//! A [`Film`] has named channels: colour times coverage, coverage, and any additional [`Channel`]. For each pixel
//! it holds
//!
//! ```text
//! pixel = Σ wᵢ·vᵢ / Σ wᵢ  +  Σ splats / number of light paths
//! ```
//!
//! as integer sums in fixed point ([`Fixed96`]: 96 bits, 44 of them fractional). Integer sums are exact and
//! commutative, so any order, split or merge of the same samples gives the same bits. This is why threads, tiles,
//! passes, cancels and machines do not change a picture.
//!
//! For each tile of 16 x 16 pixels the film stores the set of its sample indices ([`SampleSet`]), and for the
//! picture the set of its light paths. With these sets a render can stop at any time and continue later, films of
//! parts of a picture can be [merged](Film::merge), and no sample counts twice. [`Film::to_bytes`] writes a film
//! for other machines.
//!
//! The contract:
//!
//! - Pixel (0, 0) is at the top left; x counts columns, y rows. A position (x, y) in pixels lies in pixel (floor
//!   x, floor y).
//! - A sample is radiance in linear Rec. 709 (with `transfer = "none"`, in display values), premultiplied by its
//!   coverage 0..=1. Exposure and transfer curve are applied by [`Film::develop`].
//! - Samples placed by filter importance sampling have weight 1 and count in one pixel. [`TileSums::splat`]
//!   instead weights a sample by the filter in all pixels that it reaches.
//! - A [`Splat`] of a light path has no weight: splats are summed and divided by the number of light paths.
//! - A sample with NaN or infinity is not added; it is counted, and the first one is reported with pixel and
//!   index ([`NonFinite`]).
//! - A sample index counts once per tile: a pass skips the indices that the tile holds, and merging refuses films
//!   that share one.

mod band;
mod bytes;
#[cfg(test)]
mod bytes_tests;
mod channel;
mod checksum;
mod defaults;
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
    /// How the colour of a pixel is computed.
    pub enum Antialias {
        /// One ray through the centre (or corner) of each pixel.
        None = "none",
        /// The quick filter of document 002: one ray per pixel, then the mean of the pixel and its eight neighbours.
        Mean = "mean",
        /// A regular grid of rays per pixel: `samples`, rounded up to a square number.
        Grid = "grid",
        /// Whitted's adaptive subdivision: rays through the corners of a square; where they differ by more than
        /// `threshold`, the square is divided, up to `max_subdivisions` times.
        Adaptive = "adaptive",
        /// `samples` rays at stratified random positions in the pixel.
        MonteCarlo = "monte-carlo",
    }
}

choice! {
    /// The position of the single ray in the pixel.
    pub enum PixelSample {
        /// The centre.
        Center = "center",
        /// The lower left corner, as in the from-scratch book.
        Corner = "corner",
    }
}

choice! {
    /// Whether texture lookups are filtered over the footprint of the ray cone.
    pub enum TextureFilter {
        /// With the integrators "path" and "direct". The others show textures unfiltered, as the classic
        /// documents do.
        Auto = "auto",
        /// With every integrator that shows colours.
        On = "on",
        /// Never: textures are looked up at points.
        Off = "off",
    }
}

params! {
    /// Size, sampling, exposure and transfer curve of the picture. The defaults of `antialias`, `samples` and
    /// `transfer` depend on the integrator; keys in the file override them.
    pub struct FilmDesc as "film" {
        /// Width of the picture in pixels.
        width: u32 = 640, in Range::closed(1.0, 65536.0);
        /// Height of the picture in pixels.
        height: u32 = 480, in Range::closed(1.0, 65536.0);
        /// The part of the picture to render, in pixels: [first column, first row, columns, rows] from the top
        /// left.
        crop: Option<[u32; 4]> = None;
        /// How the colour of a pixel is computed. With the integrators "path" and "direct" the default is
        /// "monte-carlo". "ids" ignores this key and takes one sample through the centre of each pixel.
        antialias: Antialias = Antialias::None;
        /// Samples per pixel for "grid" and "monte-carlo". With the integrator "path" the default is 64.
        samples: u32 = 16, in Range::closed(1.0, 16777216.0);
        /// For "adaptive": a square is divided if its corners differ by more than this in any colour channel.
        threshold: f64 = 0.05, in Range::NON_NEGATIVE;
        /// For "adaptive": the maximum number of subdivisions; each divides a square into four.
        max_subdivisions: u32 = 3, in Range::closed(0.0, 6.0);
        /// The pixel filter of "monte-carlo": samples are distributed around the pixel centre in proportion to
        /// it.
        filter: FilterKind = FilterKind::Box;
        /// Radius of the pixel filter in pixels. The default is 0.5 for "box", 1 for "tent" and 1.5 for the
        /// others.
        filter_radius: Option<f64> = None, in Range { min: 0.0, open_min: true, max: 16.0, open_max: false };
        /// Whether texture lookups are filtered over the footprint of the sample, so that distant patterns do not
        /// alias: "auto" filters with the integrators "path" and "direct".
        texture_filter: TextureFilter = TextureFilter::Auto;
        /// Shutter opening and closing times, for motion blur: 0 is the object's `transform`, 1 its `motion`. The
        /// integrators "path" and "direct" render motion blur; the others show the moment of opening.
        shutter: [f64; 2] = [0.0, 1.0], in Range::UNIT;
        /// Position of the single ray of "none" and "mean" in the pixel.
        pixel_sample: PixelSample = PixelSample::Center;
        /// The curve from scene values to display values. Its inverse decodes display colours (#rrggbb, names, 8-bit
        /// images). With the integrators "path" and "direct" the default is "srgb".
        transfer: Transfer = Transfer::None;
        /// Tone mapping operator: maps unlimited scene values to the display range before the transfer curve.
        /// Applies only to PNG and JPEG; EXR and HDR files contain scene values.
        tonemap: Tonemap = Tonemap::None;
        /// Exposure in stops: scene values are multiplied by 2 to this power. Applies only to PNG and JPEG.
        exposure: f64 = 0.0, in Range::closed(-64.0, 64.0);
        /// Whether to choose the exposure automatically: the logarithmic mean of the luminance, without the
        /// darkest and brightest 5 % of pixels, becomes middle grey (0.18). `exposure` is added.
        auto_exposure: bool = false;
        /// Maximum value of a sample in any colour channel; brighter samples are scaled down to it. 0 means no
        /// limit. Clamping removes fireflies but also light, so pictures get darker. Splats of light paths
        /// (`caustics`) are not clamped.
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

    /// Samples per pixel of the finished picture. Adaptive subdivision counts as one.
    pub fn samples_per_pixel(&self) -> u32 {
        match self.antialias {
            Antialias::None | Antialias::Mean | Antialias::Adaptive => 1,
            Antialias::Grid => self.grid_side() * self.grid_side(),
            Antialias::MonteCarlo => self.samples,
        }
    }

    /// The pixel filter, which places the samples of "monte-carlo".
    pub fn filter(&self) -> Filter {
        Filter::new(self.filter, self.filter_radius)
    }

    /// The factor by which `clamp_sample` scales a sample: 1 if it is not brighter than the limit.
    #[inline]
    pub(crate) fn clamp_factor(&self, color: Spectrum) -> f32 {
        let (most, max) = (self.clamp_sample as f32, color.max_component());
        if most > 0.0 && max > most { most / max } else { 1.0 }
    }

    /// Whether a filter is set that the anti-aliasing ignores.
    pub(crate) fn ignores_filter(&self) -> bool {
        let asked = self.filter != FilterKind::Box || self.filter_radius.is_some();
        asked && self.antialias != Antialias::MonteCarlo
    }

    /// Side of the square grid with at least `samples` rays.
    pub(crate) fn grid_side(&self) -> u32 {
        let side = f64::from(self.samples).sqrt() as u32;
        if side * side < self.samples { side + 1 } else { side.max(1) }
    }
}

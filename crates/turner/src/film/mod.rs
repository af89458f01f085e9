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
//! parts of a picture can be [merged](Film::merge) or [stitched](Film::stitch), and no sample counts twice. [`Film::to_bytes`] writes a film
//! for other machines.
//!
//! The contract:
//!
//! - Pixel (0, 0) is at the top left; x counts columns, y rows. A position (x, y) in pixels lies in pixel (floor
//!   x, floor y).
//! - A sample is radiance in linear Rec. 709 (with `transfer = "none"`, in display values), premultiplied by its
//!   coverage 0..=1. Exposure and transfer curve are applied by [`Film::develop`].
//! - With [`Reconstruction::Weighted`] a sample counts in every pixel that its filter reaches, weighted by the
//!   filter ([`TileSums::splat`]). Tiles therefore add to a border of the filter's radius, and the region of a crop
//!   includes such a border. No sample lies outside the picture: pixels at its edge are means over the part of the
//!   filter inside. With [`Reconstruction::Importance`] samples have weight 1 and count in one pixel.
//! - A [`Splat`] of a light path is multiplied by the density of the filter; the sum is divided by the number of
//!   light paths.
//! - A sample with NaN or infinity is not added; it is counted, and the first one is reported with pixel and
//!   index ([`NonFinite`]).
//! - A sample index counts once per tile: a pass skips the indices that the tile holds, and merging refuses films
//!   that share one.

mod adaptive;
mod aov;
mod aovs;
mod band;
mod brightest;
mod byte_table;
mod bytes;
#[cfg(test)]
mod bytes_tests;
mod caught;
mod channel;
mod checksum;
mod clamp;
mod defaults;
mod denoise;
mod develop;
mod display;
mod error;
mod exposure;
mod extend;
mod extra_sums;
mod film_labels;
mod fireflies;
#[cfg(test)]
mod fireflies_tests;
mod fixed;
mod identity;
mod label_bytes;
mod labels;
mod merge;
mod non_finite;
mod pixel_sum;
mod preview;
mod sample_set;
mod shared;
mod splats;
mod stitch;
pub(crate) mod strips;
mod sums;
mod tile_pixels;
mod tile_sums;
mod tiles;

pub use aov::{Aov, Average, HITS, LabelKind, Layout};
pub(crate) use aov::{CRYPTO_LAYERS, DENOISING_CHANNELS};
pub use aovs::Aovs;
pub(crate) use aovs::layers;
pub(crate) use caught::CAUGHT;
pub use channel::{COLOR_CHANNELS, Channel, MAX_CHANNELS, MAX_NAME};
pub use checksum::{Checksum, checksum};
pub use clamp::ClampSpace;
pub use denoise::Denoise;
pub(crate) use develop::KEPT as KEPT_PIXELS;
pub use develop::{Developed, Picture, PixelRect};
pub use display::DisplayTransform;
pub use error::{ErrorEstimate, Noise};
pub use exposure::auto_exposure;
pub use fireflies::Fireflies;
pub use fixed::Fixed96;
pub use identity::Identity;
pub use labels::{LabelChannel, LabelRule, NO_LABEL, TileLabels};
pub use non_finite::NonFinite;
pub use pixel_sum::PixelSum;
pub use preview::{COARSE, Preview};
pub use sample_set::SampleSet;
pub use shared::SharedFilm;
pub use splats::{Splat, Splats};
pub use sums::{Film, MAX_PIXELS};
pub use tile_sums::{SampleValues, TileSums};
pub use tiles::{HALF_SQUARE, Half, TILE, TileGrid};

use crate::color::{Tonemap, Transfer};
use crate::filter::{Filter, FilterKind};
use crate::math::DVec2;
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
    /// How the pixel filter turns samples into pixels.
    pub enum Reconstruction {
        /// Samples lie evenly in the pixels. Each counts in every pixel that its filter reaches, weighted by the
        /// filter: least noise.
        Weighted = "weighted",
        /// Filter importance sampling: samples are distributed around the pixel centre in proportion to the filter, and
        /// each counts in one pixel. Pixels are independent of one another, but have about twice the variance.
        Importance = "importance",
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
        /// The pixel filter of "monte-carlo": the weights of samples around the pixel centre.
        filter: FilterKind = FilterKind::Box;
        /// Radius of the pixel filter in pixels. The default is 0.5 for "box", 1 for "tent" and 1.5 for the
        /// others.
        filter_radius: Option<f64> = None, in Range { min: 0.0, open_min: true, max: 16.0, open_max: false };
        /// How the filter turns samples into pixels. It makes no difference to filters that stay within the pixel, such
        /// as the default "box".
        reconstruction: Reconstruction = Reconstruction::Weighted;
        /// Whether texture lookups are filtered over the footprint of the sample, so that distant patterns do not
        /// alias: "auto" filters with the integrators "path" and "direct".
        texture_filter: TextureFilter = TextureFilter::Auto;
        /// Shutter opening and closing times, for motion blur: 0 is the object's `transform`, 1 its `motion`. Lights and cameras can have a `motion` too. The
        /// integrators "path" and "direct" render motion blur; the others show the moment of opening.
        shutter: [f64; 2] = [0.0, 1.0], in Range::UNIT;
        /// Whether animations blur what they move: objects, cameras, and lights other than environments and skies. Shutter
        /// time 0 is the time of the frame, 1 that of the next frame: `shutter = [0, 0.5]` is that of a film camera. What
        /// else changes, such as the pose of a skin, a radius or a colour, is that of the frame.
        motion_blur: bool = false;
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
        /// The channels that `clamp_sample` compares with its limit.
        clamp_space: ClampSpace = ClampSpace::Rgb;
        /// What happens to fireflies: samples of "monte-carlo" that are far brighter than all others of the pixel and its
        /// neighbours. A model file that is rendered on its own has "remove".
        fireflies: Fireflies = Fireflies::Keep;
        /// Whether noisy parts of the picture get more samples than others; `samples` is then their mean. Every
        /// pixel has at least a quarter of it. Needs "monte-carlo" with the integrators "path" or "direct", and a filter
        /// that stays within the pixel, such as the default "box".
        adaptive_sampling: bool = false;
        /// Which denoiser removes the noise of the finished picture. EXR files keep the raw picture as the layer "raw".
        /// Needs "monte-carlo" with the integrators "path" or "direct".
        denoise: Denoise = Denoise::Off;
        /// Whether the denoiser also works on the AOVs "emission", "direct", "indirect" and "light_groups".
        denoise_aovs: bool = false;
        /// Seed of the random numbers.
        seed: u32 = 0;
        /// Further channels next to the colour (AOVs, render passes), from the same samples: `["albedo", "normal"]`. An
        /// EXR file contains them.
        aovs: Aovs = Aovs::default();
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

    /// The screen position of a place in pixels from the picture's top left corner: (−1, −1) is the lower left and (1, 1)
    /// the upper right corner.
    #[inline]
    pub(crate) fn on_screen(&self, place: DVec2) -> DVec2 {
        let size = DVec2::new(f64::from(self.width), f64::from(self.height));
        DVec2::new(2.0 * place.x / size.x - 1.0, 1.0 - 2.0 * place.y / size.y)
    }

    /// Samples per pixel of the finished picture. Adaptive subdivision counts as one.
    pub fn samples_per_pixel(&self) -> u32 {
        match self.antialias {
            Antialias::None | Antialias::Mean | Antialias::Adaptive => 1,
            Antialias::Grid => self.grid_side() * self.grid_side(),
            Antialias::MonteCarlo => self.samples,
        }
    }

    /// The pixel filter of "monte-carlo".
    pub fn filter(&self) -> Filter {
        Filter::new(self.filter, self.filter_radius)
    }

    /// The density of sample positions in and around a pixel: the filter for importance sampling, the pixel's
    /// square where samples are weighted.
    pub fn placement(&self) -> Filter {
        if self.weights_samples() { Filter::new(FilterKind::Box, None) } else { self.filter() }
    }

    /// Whether a sample counts by weight in all pixels that the filter reaches, instead of in one pixel.
    pub fn weights_samples(&self) -> bool {
        let radius = self.filter_radius.unwrap_or(self.filter.default_radius());
        self.reconstruction == Reconstruction::Weighted
            && self.antialias == Antialias::MonteCarlo
            && radius > 0.5
    }

    /// Width in pixels of the border around a region whose samples also count in the region.
    pub fn border(&self) -> u32 {
        // Fireflies are told by their neighbours.
        self.reach() + u32::from(self.looks_for_fireflies())
    }

    /// How far in pixels a sample counts beyond its own pixel.
    pub(crate) fn reach(&self) -> u32 {
        match self.antialias {
            Antialias::Mean => 1,
            _ if self.weights_samples() => TileSums::border(&self.filter()),
            _ => 0,
        }
    }

    /// The pixels that are rendered: the crop, or the full picture, and the border around it inside the picture. An
    /// invalid crop gives the full picture.
    pub fn region(&self) -> PixelRect {
        let full = PixelRect { x: 0, y: 0, width: self.width, height: self.height };
        Film::rects(self).map_or(full, |(region, _)| region)
    }

    /// Whether each pixel is exactly one sample, so that the film needs no sums.
    pub(crate) fn is_one_sample(&self) -> bool {
        self.samples_per_pixel() == 1 && !self.weights_samples() && !self.aovs.has_channels()
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

//! The sums of samples, per pixel.

use super::band::{BAND, Band, WORDS};
use super::{FilmDesc, Fixed96, PixelRect, Splats};
use crate::color::Spectrum;
use crate::scene::error::{ErrorCode, SceneError};

/// One pixel: 52 bytes on the film.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PixelSum {
    rgb: [Fixed96; 3],
    /// Sum of coverage, 2^-32 each.
    alpha: u64,
    count: u32,
    /// Samples left out because they were not finite (saturating).
    bad: u32,
}

impl PixelSum {
    /// Bytes on the film.
    pub const BYTES: usize = 52;

    pub(super) fn to_words(self) -> [u32; WORDS] {
        let [r, g, b] = self.rgb.map(Fixed96::to_words);
        let a = [self.alpha as u32, (self.alpha >> 32) as u32];
        [r[0], r[1], r[2], g[0], g[1], g[2], b[0], b[1], b[2], a[0], a[1], self.count, self.bad]
    }

    pub(super) fn from_words(w: &[u32; WORDS]) -> PixelSum {
        PixelSum {
            rgb: [[w[0], w[1], w[2]], [w[3], w[4], w[5]], [w[6], w[7], w[8]]].map(Fixed96::from_words),
            alpha: u64::from(w[10]) << 32 | u64::from(w[9]),
            count: w[11],
            bad: w[12],
        }
    }

    /// Adds a finite sample: colour times coverage, and coverage 0..=1.
    #[inline]
    pub fn add(&mut self, color: Spectrum, alpha: f32) {
        for (sum, v) in self.rgb.iter_mut().zip(color.to_array()) {
            *sum = sum.plus(Fixed96::from_f32(v));
        }
        self.alpha += (f64::from(alpha) * 4_294_967_296.0) as u64;
        self.count += 1;
    }

    /// Adds a sample, or counts it as left out if it is not finite; says which.
    #[inline]
    pub fn add_or_leave_out(&mut self, color: Spectrum, alpha: f32) -> bool {
        let finite = color.is_finite() && alpha.is_finite();
        if finite {
            self.add(color, alpha);
        } else {
            self.leave_out();
        }
        finite
    }

    /// Adds the samples of another sum.
    #[inline]
    pub fn merge(&mut self, other: &PixelSum) {
        for (a, b) in self.rgb.iter_mut().zip(&other.rgb) {
            *a = a.plus(*b);
        }
        self.alpha += other.alpha;
        self.count += other.count;
        self.bad = self.bad.saturating_add(other.bad);
    }

    /// Counts a sample that is not finite.
    pub fn leave_out(&mut self) {
        self.bad = self.bad.saturating_add(1);
    }

    /// Mean colour times coverage, and mean coverage; NaN if no sample was finite, `None` without samples.
    pub fn mean(&self) -> Option<[f32; 4]> {
        if self.count == 0 {
            return (self.bad > 0).then_some([f32::NAN, f32::NAN, f32::NAN, 1.0]);
        }
        let [r, g, b] = self.rgb.map(|c| c.mean(self.count) as f32);
        Some([r, g, b, (self.alpha as f64 / (4_294_967_296.0 * f64::from(self.count))) as f32])
    }

    /// Samples added.
    pub fn count(&self) -> u32 {
        self.count
    }
}

/// Samples that were not finite numbers: left out of the sums, counted, and the first of them named.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NonFinite {
    /// How many.
    pub count: u64,
    /// (row, column, sample index) of the first in picture order.
    pub first: Option<(u32, u32, u32)>,
}

impl NonFinite {
    /// Counts one.
    pub fn note(&mut self, x: u32, y: u32, index: u32) {
        self.merge(&NonFinite { count: 1, first: Some((y, x, index)) });
    }

    /// Counts those of another part.
    pub fn merge(&mut self, other: &NonFinite) {
        self.count += other.count;
        self.first = match (self.first, other.first) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        };
    }
}

/// The film: sums of samples for a part of the picture. Sums are integers, so the order in which samples, tiles,
/// passes or machines add to it does not matter.
#[derive(Clone, Debug)]
pub struct Film {
    /// The part of the picture that is rendered; for the mean filter one pixel wider than what is shown.
    pub region: PixelRect,
    /// The part that is shown.
    pub crop: PixelRect,
    /// The region in bands of [`BAND`] rows.
    bands: Vec<Band>,
    bytes_per_pixel: usize,
    /// What light paths brought, where there are any.
    splats: Option<Splats>,
    /// What was not finite.
    pub non_finite: NonFinite,
}

/// The most pixels a film may have: 16384 × 16384, 13 GB of sums.
pub const MAX_PIXELS: u64 = 1 << 28;

impl Film {
    /// The region and crop a description asks for, or the reason why there can be no such film.
    fn rects(desc: &FilmDesc) -> Result<(PixelRect, PixelRect), SceneError> {
        let full = PixelRect { x: 0, y: 0, width: desc.width, height: desc.height };
        let crop = match desc.crop {
            None => full,
            Some([x, y, width, height]) => {
                let fits = |from: u32, size: u32, of: u32| {
                    size > 0 && u64::from(from) + u64::from(size) <= u64::from(of)
                };
                if !fits(x, width, desc.width) || !fits(y, height, desc.height) {
                    let message = format!(
                        "the crop of {width}x{height} pixels at ({x}, {y}) is empty or reaches beyond the picture of {}x{}",
                        desc.width, desc.height
                    );
                    return Err(SceneError::new(ErrorCode::OutOfRange, message));
                }
                PixelRect { x, y, width, height }
            }
        };
        let region = if desc.antialias == super::Antialias::Mean { crop.grown(1, &full) } else { crop };
        if region.area() > MAX_PIXELS {
            let message = format!(
                "a picture of {}x{} has more than the {MAX_PIXELS} pixels a film may have",
                region.width, region.height
            );
            return Err(SceneError::new(ErrorCode::TooLarge, message).help("render it in parts with `crop`"));
        }
        Ok((region, crop))
    }

    /// The bytes of the film a description asks for, or the reason why there can be no such film.
    pub fn check(desc: &FilmDesc) -> Result<u64, SceneError> {
        let bytes = Band::bytes_per_pixel(desc.samples_per_pixel() == 1) as u64;
        Film::rects(desc).map(|(region, _)| region.area() * bytes)
    }

    /// Bytes that the film and the picture that it becomes take together: the sums, the picture's values for files and for
    /// displays, and the file before it is written.
    pub fn peak(desc: &FilmDesc) -> Result<u64, SceneError> {
        const PICTURE: u64 = 16 + 4;
        const FILE: u64 = 20;
        let (region, _) = Film::rects(desc)?;
        Ok(Film::check(desc)?.saturating_add(region.area().saturating_mul(PICTURE + FILE)))
    }

    /// An empty film for a description, or the reason why there can be none.
    pub fn new(desc: &FilmDesc) -> Result<Film, SceneError> {
        let (region, crop) = Film::rects(desc)?;
        // Asking first: a failed allocation would end the program.
        let one_sample = desc.samples_per_pixel() == 1;
        let bytes_per_pixel = Band::bytes_per_pixel(one_sample);
        if Vec::<u8>::new().try_reserve_exact(region.area() as usize * bytes_per_pixel).is_err() {
            let message = format!("there is no memory for a film of {}x{}", region.width, region.height);
            return Err(SceneError::new(ErrorCode::TooLarge, message).help("render it in parts with `crop`"));
        }
        let bands = (0..region.height)
            .step_by(BAND as usize)
            .map(|y| {
                let rows = PixelRect { y: region.y + y, height: BAND.min(region.height - y), ..region };
                Band::new(rows, one_sample)
            })
            .collect();
        Ok(Film { region, crop, bands, bytes_per_pixel, splats: None, non_finite: NonFinite::default() })
    }

    /// Makes room for what light paths bring; or gives the reason why there is none.
    pub fn take_light(&mut self) -> Result<(), SceneError> {
        if self.splats.is_none() {
            self.splats = Some(Splats::new(self.region)?);
        }
        Ok(())
    }

    /// What light paths brought, if there is room for it.
    pub fn splats(&self) -> Option<&Splats> {
        self.splats.as_ref()
    }

    /// Counts light of light paths that was not finite with samples that were not.
    pub(crate) fn count_splats(&mut self) {
        if let Some(splats) = &mut self.splats {
            self.non_finite.count += std::mem::take(&mut splats.non_finite);
        }
    }

    /// The bands and what light paths brought.
    pub fn parts_mut(&mut self) -> (&mut [Band], Option<&mut Splats>) {
        (&mut self.bands, self.splats.as_mut())
    }

    /// The bands, from the top; the band of row y is the ((y − region.y) / [`BAND`])th.
    pub fn bands_mut(&mut self) -> &mut [Band] {
        &mut self.bands
    }

    /// The sums of a pixel of the region.
    pub(super) fn sum(&self, x: u32, y: u32) -> PixelSum {
        let row = y - self.region.y;
        let band = &self.bands[(row / BAND) as usize];
        let i = (row % BAND) as usize * self.region.width as usize + (x - self.region.x) as usize;
        band.sum(i)
    }

    /// Samples in all pixels.
    pub fn samples(&self) -> u64 {
        self.bands.iter().map(Band::samples).sum()
    }

    /// Bytes of memory.
    pub fn memory(&self) -> usize {
        self.region.area() as usize * self.bytes_per_pixel + self.splats.as_ref().map_or(0, Splats::memory)
    }
}

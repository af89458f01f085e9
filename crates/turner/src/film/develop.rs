//! Developing: from sums to a picture.
//!
//! A pixel's scene value is its weighted mean plus the light of light paths. Its display value is that of a
//! [`DisplayTransform`] to 8-bit sRGB.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use super::caught::Caught;
use super::exposure::Luminances;
use super::{Antialias, DisplayTransform, Film, FilmDesc, auto_exposure, strips};
use crate::color::{DisplaySpace, Spectrum};
use crate::filter::Filter;

/// A rectangle of pixels; row 0 is at the top.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelRect {
    /// First column.
    pub x: u32,
    /// First row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl PixelRect {
    /// Number of pixels.
    pub fn area(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// The rectangle with a border of `by` pixels, clipped to `limit`.
    pub fn grown(&self, by: u32, limit: &PixelRect) -> PixelRect {
        let x = self.x.saturating_sub(by).max(limit.x);
        let y = self.y.saturating_sub(by).max(limit.y);
        let right = (self.x + self.width + by).min(limit.x + limit.width);
        let bottom = (self.y + self.height + by).min(limit.y + limit.height);
        PixelRect { x, y, width: right - x, height: bottom - y }
    }
}

/// A developed picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Linear scene values, premultiplied: colour times coverage, and coverage, as in EXR and HDR files. NaN
    /// where no sample was finite.
    pub linear: Vec<[f32; 4]>,
    /// Display values with straight alpha, as in PNG and JPEG files. Each is round(255 ·
    /// encode(tonemap(2^exposure · linear / alpha))).
    pub display: Vec<[u8; 4]>,
    /// Whether any pixel has a coverage other than 1.
    pub has_alpha: bool,
    /// Pixels without samples and without a preview, because rendering was stopped. They are transparent black.
    pub missing: u64,
    /// The exposure of the display values in stops: that of the film, plus that of `auto_exposure`.
    pub exposure: f64,
}

impl Picture {
    /// The transform from `linear` to `display`, given the film that it was developed with. Debug views replace
    /// display values by others.
    pub fn transform(&self, desc: &FilmDesc) -> DisplayTransform {
        DisplayTransform {
            exposure: self.exposure,
            tonemap: desc.tonemap,
            transfer: desc.transfer,
            space: DisplaySpace::Srgb,
        }
    }
}

impl Film {
    /// The picture from the samples so far, on `threads` threads; 0 uses all. It does not depend on their number.
    pub fn develop(&self, desc: &FilmDesc, threads: usize) -> Picture {
        let PixelRect { width, height, .. } = self.crop;
        let mut developed = Developed::without_survey(self, desc);
        let (linear, survey) = developed.rows(0..height, threads);
        developed.set(survey, || auto_exposure(&linear));
        let Developed { has_alpha, missing, exposure, .. } = developed;
        let display = developed.transform().to_8_bits(&linear, threads);
        Picture { width, height, linear, display, has_alpha, missing, exposure }
    }

    /// The picture from the samples so far, as rows. Those of a picture of more than 16 million pixels are computed when
    /// they are asked for, so that it needs no memory beside its film.
    pub fn developed<'a>(&'a self, desc: &'a FilmDesc, threads: usize) -> Developed<'a> {
        let mut developed = Developed::without_survey(self, desc);
        if self.crop.area() <= KEPT {
            let (linear, survey) = developed.rows(0..self.crop.height, threads);
            developed.set(survey, || auto_exposure(&linear));
            developed.kept = linear;
            return developed;
        }
        let mut luminances = Luminances::default();
        let mut survey = Survey::default();
        let strip = STRIP_PIXELS.div_ceil(self.crop.width).max(1);
        for y in (0..self.crop.height).step_by(strip as usize) {
            let (linear, part) = developed.rows(y..(y + strip).min(self.crop.height), threads);
            survey = Survey { missing: survey.missing + part.missing, alpha: survey.alpha || part.alpha };
            if desc.auto_exposure {
                linear.iter().for_each(|pixel| luminances.add(*pixel));
            }
        }
        developed.set(survey, || luminances.exposure());
        developed
    }

    /// The light of light paths in a pixel of the region, as it is part of the picture: linear red, green and blue.
    pub fn light(&self, desc: &FilmDesc, x: u32, y: u32) -> [f32; 3] {
        let Some(splats) = self.splats() else { return [0.0; 3] };
        let scale = More::new(self, desc).scale(x, y);
        splats.mean(x, y).map(|v| v * scale)
    }

    /// The mean of the samples of a pixel of the region, with the shadow on shadow catchers.
    #[inline]
    fn mean(&self, x: u32, y: u32, caught: Option<Caught>) -> Option<[f32; 4]> {
        let (band, i) = self.place(x, y)?;
        let mean = band.mean(i)?;
        match caught {
            Some(caught) => Some(caught.apply(band, i, mean)),
            None => Some(mean),
        }
    }

    #[inline]
    fn pixel(&self, x: u32, y: u32, more: &More) -> Option<[f32; 4]> {
        let Some(mut mean) = self.mean(x, y, more.caught) else {
            return self.preview.as_ref()?.pixel(x, y);
        };
        if more.removes_fireflies {
            mean = self.without_fireflies(x, y, mean);
        }
        let [r, g, b, alpha] = mean;
        let Some(splats) = self.splats() else { return Some(mean) };
        let scale = more.scale(x, y);
        let [dr, dg, db] = splats.mean(x, y).map(|v| v * scale);
        Some([r + dr, g + dg, b + db, alpha])
    }

    /// The quick filter of document 002: the mean over the pixel and those of its eight neighbours that lie in the
    /// picture.
    fn mean_of_neighbours(&self, x: u32, y: u32, more: &More) -> Option<[f32; 4]> {
        self.pixel(x, y, more)?;
        let (mut sum, mut count) = ([0.0f64; 4], 0u32);
        for ny in y.saturating_sub(1).max(self.region.y)..=(y + 1).min(self.region.y + self.region.height - 1)
        {
            for nx in
                x.saturating_sub(1).max(self.region.x)..=(x + 1).min(self.region.x + self.region.width - 1)
            {
                if let Some(v) = self.pixel(nx, ny, more) {
                    for (s, v) in sum.iter_mut().zip(v) {
                        *s += f64::from(v);
                    }
                    count += 1;
                }
            }
        }
        Some(sum.map(|s| (s / f64::from(count)) as f32))
    }
}

/// About the number of pixels of a strip of a large picture.
const STRIP_PIXELS: u32 = 1 << 20;

/// The most pixels whose scene values are kept: 256 MiB.
pub(crate) const KEPT: u64 = 1 << 24;

/// A film's picture, developed when its rows are asked for: [`Film::developed`].
pub struct Developed<'a> {
    film: &'a Film,
    desc: &'a FilmDesc,
    more: More,
    /// The scene values of all rows, or none.
    kept: Vec<[f32; 4]>,
    /// Whether any pixel has a coverage other than 1.
    pub has_alpha: bool,
    /// Pixels without samples and without a preview, because rendering was stopped.
    pub missing: u64,
    /// The exposure of the display values in stops, as in [`Picture`].
    pub exposure: f64,
}

/// What rows say of the picture.
#[derive(Clone, Copy, Default)]
struct Survey {
    missing: u64,
    alpha: bool,
}

impl<'a> Developed<'a> {
    fn without_survey(film: &'a Film, desc: &'a FilmDesc) -> Developed<'a> {
        let more = More::new(film, desc);
        Developed {
            film,
            desc,
            more,
            kept: Vec::new(),
            has_alpha: false,
            missing: 0,
            exposure: desc.exposure,
        }
    }

    fn set(&mut self, survey: Survey, auto_exposure: impl FnOnce() -> f64) {
        (self.missing, self.has_alpha) = (survey.missing, survey.alpha);
        if self.desc.auto_exposure {
            self.exposure += auto_exposure();
        }
    }

    /// The whole picture, if its rows are kept.
    pub(crate) fn into_picture(self, threads: usize) -> Picture {
        let PixelRect { width, height, .. } = self.film.crop;
        let linear = self.linear(0..height, threads).into_owned();
        let display = self.transform().to_8_bits(&linear, threads);
        let Developed { has_alpha, missing, exposure, .. } = self;
        Picture { width, height, linear, display, has_alpha, missing, exposure }
    }

    /// The scene values of all rows, if they are kept: those of pictures of at most 16 million pixels are.
    pub(crate) fn kept(&self) -> Option<&[[f32; 4]]> {
        (!self.kept.is_empty()).then_some(&self.kept)
    }

    /// The light of light paths in a pixel of the region, as in [`Film::light`].
    pub(crate) fn light(&self, x: u32, y: u32) -> [f32; 3] {
        self.film.splats().map_or([0.0; 3], |splats| {
            let scale = self.more.scale(x, y);
            splats.mean(x, y).map(|v| v * scale)
        })
    }

    /// The factor by which removing fireflies has scaled the light of a pixel of the region; `pixel` is its value in
    /// the picture.
    pub(crate) fn left_of_fireflies(&self, x: u32, y: u32, pixel: &[f32; 4]) -> f32 {
        if !self.more.removes_fireflies {
            return 1.0;
        }
        let Some([r, g, b, _]) = self.film.mean(x, y, self.more.caught) else { return 1.0 };
        let light = self.light(x, y);
        let clean = Spectrum::from(std::array::from_fn(|c| pixel[c] - light[c]));
        let scale = clean.luminance() / Spectrum::new(r, g, b).luminance();
        if scale.is_finite() { scale.clamp(0.0, 1.0) } else { 1.0 }
    }

    /// Replaces the colours of the rows, which are kept. Coverage stays, as do pixels that cover nothing or are not
    /// finite.
    pub(crate) fn recolor(&mut self, colors: &[[f32; 3]]) {
        for (pixel, color) in self.kept.iter_mut().zip(colors) {
            if pixel[3] != 0.0 && pixel.iter().all(|v| v.is_finite()) {
                pixel[..3].copy_from_slice(color);
            }
        }
        self.exposure = self.desc.exposure;
        if self.desc.auto_exposure {
            self.exposure += auto_exposure(&self.kept);
        }
    }

    /// Columns and rows.
    pub fn size(&self) -> (u32, u32) {
        (self.film.crop.width, self.film.crop.height)
    }

    /// The scene values of these rows, as in [`Picture::linear`]. `threads` of 0 uses all.
    pub fn linear(&self, rows: Range<u32>, threads: usize) -> Cow<'_, [[f32; 4]]> {
        let width = self.film.crop.width as usize;
        match self.kept.get(rows.start as usize * width..rows.end as usize * width) {
            Some(kept) => Cow::Borrowed(kept),
            None => Cow::Owned(self.rows(rows, threads).0),
        }
    }

    /// The transform from scene values to display values.
    pub fn transform(&self) -> DisplayTransform {
        DisplayTransform {
            exposure: self.exposure,
            tonemap: self.desc.tonemap,
            transfer: self.desc.transfer,
            space: DisplaySpace::Srgb,
        }
    }

    fn rows(&self, rows: Range<u32>, threads: usize) -> (Vec<[f32; 4]>, Survey) {
        let (film, crop) = (self.film, self.film.crop);
        let rows = rows.start.min(crop.height)..rows.end.min(crop.height);
        let (missing, has_alpha) = (AtomicU64::new(0), AtomicBool::new(false));
        let linear = strips::rows(crop.width as usize, rows.len(), threads, |y, row: &mut [[f32; 4]]| {
            let (mut without, mut alpha) = (0, false);
            for (x, pixel) in (crop.x..).zip(row) {
                let y = crop.y + rows.start + y as u32;
                let mean = match self.desc.antialias {
                    Antialias::Mean => film.mean_of_neighbours(x, y, &self.more),
                    _ => film.pixel(x, y, &self.more),
                };
                *pixel = mean.unwrap_or_else(|| {
                    without += 1;
                    [0.0; 4]
                });
                alpha |= pixel[3] != 1.0;
            }
            missing.fetch_add(without, Ordering::Relaxed);
            has_alpha.fetch_or(alpha, Ordering::Relaxed);
        });
        (linear, Survey { missing: missing.into_inner(), alpha: has_alpha.into_inner() })
    }
}

/// What pixels consist of besides the means of their samples: the light of splats, near the edge of the picture, and the
/// shadow on shadow catchers. With weighted samples none lies outside the picture, so a pixel there is the
/// mean over the part of its filter inside.
struct More {
    /// The filter and its border in pixels.
    filter: Option<(Filter, u32)>,
    size: [u32; 2],
    /// The shadow catchers, if there are any.
    caught: Option<Caught>,
    removes_fireflies: bool,
}

impl More {
    fn new(film: &Film, desc: &FilmDesc) -> More {
        let filter = desc.weights_samples().then(|| (desc.filter(), desc.reach()));
        let removes_fireflies = film.identity().removes_fireflies;
        More { filter, size: [desc.width, desc.height], caught: Caught::of(film), removes_fireflies }
    }

    /// The factor for the splats of a pixel: 1 over the fraction of its filter that is inside the picture.
    fn scale(&self, x: u32, y: u32) -> f32 {
        let Some((filter, border)) = &self.filter else { return 1.0 };
        let along = |at: u32, size: u32| {
            let is_near = at < *border || at + *border >= size;
            if is_near { filter.fraction_inside(at, size) } else { 1.0 }
        };
        (1.0 / (along(x, self.size[0]) * along(y, self.size[1]))) as f32
    }
}

//! Splats: contributions of light paths, to any pixel in any order.
//!
//! The estimate for a pixel is the sum of splats times the pixel filter, divided by the number of light paths.

use std::ops::Range;

use super::{Fixed96, PixelRect, SampleSet};
use crate::color::Spectrum;
use crate::filter::Filter;
use crate::math::DVec2;
use crate::schema::{ErrorCode, Remedy, SceneError};

/// The contribution of a light path at a position of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Splat {
    /// The position, in pixels from the picture's top left corner.
    pub place: DVec2,
    /// Radiance, before division by the number of light paths.
    pub color: Spectrum,
}

/// The scale of squared luminances. Colours are not divided by the number of light paths, so squares are large.
const SQUARES: f64 = 1.0 / (1u64 << 32) as f64;

/// The sums of splats, 48 bytes per pixel. They are integers, so the order of light paths does not matter.
#[derive(Clone, Debug)]
pub struct Splats {
    region: PixelRect,
    /// Red, green, blue and the squared luminance times [`SQUARES`].
    pub(super) sums: Vec<[Fixed96; 4]>,
    /// The indices of the light paths.
    pub(super) held: SampleSet,
    /// The number of non-finite splats, which are not added.
    pub non_finite: u64,
}

impl Splats {
    /// Bytes per pixel.
    pub const BYTES: usize = size_of::<[Fixed96; 4]>();

    /// Without light paths.
    pub(super) fn new(region: PixelRect) -> Result<Splats, SceneError> {
        let mut sums = Vec::new();
        if sums.try_reserve_exact(region.area() as usize).is_err() {
            let message =
                format!("not enough memory for light paths into {}x{} pixels", region.width, region.height);
            return Err(SceneError::new(ErrorCode::TooLarge, message)
                .help("render it in parts with `crop`, or with `caustics = \"off\"` in [integrator]")
                .remedy(Remedy::set("integrator.caustics", "off")));
        }
        sums.resize(region.area() as usize, [Fixed96::default(); 4]);
        Ok(Splats { region, sums, held: SampleSet::default(), non_finite: 0 })
    }

    /// The indices of the light paths.
    pub fn held(&self) -> &SampleSet {
        &self.held
    }

    /// Adds the splats of these light paths, weighted by the filter. Returns false, and adds nothing, if one of
    /// the paths is already held.
    pub fn add(&mut self, filter: &Filter, paths: Range<u64>, splats: &[Splat]) -> bool {
        if self.held.missing(paths.clone()) != [paths.clone()] {
            return paths.is_empty();
        }
        self.held.insert(paths);
        let (left, top) = (f64::from(self.region.x), f64::from(self.region.y));
        let (width, height) = (f64::from(self.region.width), f64::from(self.region.height));
        let reach = filter.radius();
        for splat in splats {
            if !(splat.color.is_finite() && splat.place.is_finite()) {
                self.non_finite += 1;
                continue;
            }
            // Pixels whose centre is within the filter radius.
            let first = (splat.place - reach - 0.5).ceil().max(DVec2::new(left, top));
            let last = (splat.place + reach - 0.5).floor().min(DVec2::new(left + width, top + height) - 1.0);
            let mut y = first.y;
            while y <= last.y {
                let mut x = first.x;
                while x <= last.x {
                    let weight = filter.density(splat.place - DVec2::new(x + 0.5, y + 0.5));
                    let index = (y - top) as usize * self.region.width as usize + (x - left) as usize;
                    if weight > 0.0
                        && let Some(sum) = self.sums.get_mut(index)
                    {
                        let color = splat.color * weight as f32;
                        for (sum, v) in sum.iter_mut().zip(color.to_array()) {
                            *sum = sum.plus(Fixed96::from_f32(v));
                        }
                        let luminance = f64::from(color.luminance());
                        sum[3] = sum[3].plus(Fixed96::from_f64(SQUARES * luminance * luminance));
                    }
                    x += 1.0;
                }
                y += 1.0;
            }
        }
        true
    }

    /// Adds the light paths of another film, none of which is held.
    pub(super) fn merge(&mut self, other: &Splats) {
        self.held.insert_all(&other.held);
        self.non_finite = self.non_finite.saturating_add(other.non_finite);
        for (own, theirs) in self.sums.iter_mut().zip(&other.sums) {
            for (a, b) in own.iter_mut().zip(theirs) {
                *a = a.plus(*b);
            }
        }
    }

    /// The radiance from light paths at a pixel of the region.
    pub(super) fn mean(&self, x: u32, y: u32) -> [f32; 3] {
        let paths = self.held.len();
        if paths == 0 {
            return [0.0; 3];
        }
        let [red, green, blue, _] = self.sums[self.index(x, y)];
        // The resolution of 2^-44 is far below the contribution of a path, so sums need no scaling by the number
        // of paths.
        [red, green, blue].map(|sum| (sum.mean(1.0) / paths as f64) as f32)
    }

    /// The luminance from light paths at a pixel of the region, and its variance. Few of the paths reach a pixel, so
    /// its variance is the sum of squares.
    pub(super) fn luminance_and_variance(&self, x: u32, y: u32) -> (f64, f64) {
        let paths = self.held.len().max(1) as f64;
        let [red, green, blue] = self.mean(x, y);
        let square = self.sums[self.index(x, y)][3].mean(1.0);
        (f64::from(Spectrum::new(red, green, blue).luminance()), square.max(0.0) / (SQUARES * paths * paths))
    }

    fn index(&self, x: u32, y: u32) -> usize {
        (y - self.region.y) as usize * self.region.width as usize + (x - self.region.x) as usize
    }

    /// Bytes of memory.
    pub fn memory(&self) -> usize {
        self.sums.len() * Splats::BYTES
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::FilterKind;

    #[test]
    fn every_filter_conserves_light() {
        let region = PixelRect { x: 10, y: 20, width: 16, height: 16 };
        for kind in [FilterKind::Box, FilterKind::Tent, FilterKind::Gaussian, FilterKind::BlackmanHarris] {
            let filter = Filter::new(kind, None);
            let mut splats = Splats::new(region).unwrap();
            // Many positions in one pixel: the mean of the filter's sum over pixels is 1.
            let n = 64;
            let places = (0..n * n).map(|i| {
                DVec2::new(f64::from(i % n), f64::from(i / n)) / f64::from(n) + DVec2::new(17.0, 27.0)
            });
            let all: Vec<Splat> = places.map(|place| Splat { place, color: Spectrum::WHITE }).collect();
            assert!(splats.add(&filter, 0..all.len() as u64, &all));
            let sum: f64 = (20..36)
                .flat_map(|y| (10..26).map(move |x| (x, y)))
                .map(|(x, y)| f64::from(splats.mean(x, y)[0]))
                .sum();
            assert!((sum - 1.0).abs() < 2e-3, "{kind:?}: {sum}");
            if kind == FilterKind::Box {
                assert_eq!(splats.mean(17, 27)[0], 1.0);
            }
        }
    }

    #[test]
    fn splats_outside_the_picture_or_non_finite_are_omitted() {
        let mut splats = Splats::new(PixelRect { x: 0, y: 0, width: 2, height: 2 }).unwrap();
        let filter = Filter::new(FilterKind::Box, None);
        let at = |x: f64, y: f64, v: f32| Splat { place: DVec2::new(x, y), color: Spectrum::grey(v) };
        let all = [
            at(-0.1, 0.5, 1.0),
            at(2.0, 0.5, 1.0),
            at(1e300, 0.0, 1.0),
            at(f64::NAN, 0.0, 1.0),
            at(0.5, 0.5, f32::INFINITY),
            at(1.5, 0.0, 3.0),
        ];
        assert!(splats.add(&filter, 0..6, &all));
        assert_eq!((splats.non_finite, splats.mean(1, 0)[1]), (2, 0.5));
        assert_eq!(splats.mean(0, 0), [0.0; 3]);
        // Light paths that are held do not count again.
        assert!(!splats.add(&filter, 5..7, &all));
        assert_eq!((splats.held().len(), splats.non_finite, splats.mean(1, 0)[1]), (6, 2, 0.5));
    }

    /// Colours are not divided by the number of light paths, so that squares of bright ones are large.
    #[test]
    fn the_variance_of_bright_splats_is_their_square() {
        let mut splats = Splats::new(PixelRect { x: 0, y: 0, width: 1, height: 1 }).unwrap();
        let (filter, paths) = (Filter::new(FilterKind::Box, None), 1 << 20);
        for (k, radiance) in [0.01, 1.0, 400.0].into_iter().enumerate() {
            let mut splats = splats.clone();
            let color = Spectrum::grey(radiance * paths as f32);
            let all = [Splat { place: DVec2::splat(0.5), color }];
            assert!(splats.add(&filter, 0..paths, &all), "{k}");
            let (light, variance) = splats.luminance_and_variance(0, 0);
            assert!((light / f64::from(radiance) - 1.0).abs() < 1e-4, "{light}");
            assert!((variance.sqrt() / f64::from(radiance) - 1.0).abs() < 1e-4, "{radiance}: {variance}");
        }
        assert!(splats.add(&filter, 0..1, &[]));
        assert_eq!(splats.luminance_and_variance(0, 0), (0.0, 0.0));
    }
}

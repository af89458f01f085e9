//! One pixel on its own: its samples, and how they become its colour.

use super::tile::TileBuffers;
use super::work::Stop;
use crate::film::{Antialias, Film, FilmDesc};
use crate::filter::Filter;
use crate::integrator::{Prepared, Radiance};
use crate::sampler::SampleId;
use crate::schema::SceneError;
use crate::view::{View, check_pixel, place_of};

/// The maximum number of samples in a [`PixelRecord`].
pub const MAX_LISTED: usize = 1 << 16;

/// A pixel of the picture and its samples.
#[derive(Clone, Debug)]
pub struct PixelRecord {
    /// Column, from 0 at the left.
    pub x: u32,
    /// Row, from 0 at the top.
    pub y: u32,
    /// Its samples, at most [`MAX_LISTED`]. With "mean": those of the pixel and its neighbours, row by row. With
    /// "adaptive": the corners in the order of evaluation. Otherwise: by index; where the filter weights samples, those
    /// that it reaches.
    pub samples: Vec<SampleRecord>,
    /// The number of samples.
    pub count: u64,
    /// With "adaptive": the squares that were not divided further.
    pub squares: Vec<Square>,
    /// The number of samples that `film.fireflies` scales down.
    pub fireflies: usize,
    /// The pixel as rendered: linear scene values times coverage, and coverage. NaN if no sample was finite.
    pub color: [f32; 4],
}

/// A sample of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleRecord {
    /// The id that determines its random numbers.
    pub id: SampleId,
    /// Its position in the picture, in pixels from the top left corner: (column, row).
    pub place: [f64; 2],
    /// Its weight in the pixel. The weights add up to 1 if all samples are finite, and to less if
    /// `film.clamp_sample`, `film.fireflies` or the vignetting of the camera's lens scales some.
    pub weight: f64,
    /// Its radiance, before `film.clamp_sample`.
    pub radiance: Radiance,
}

/// A square of adaptive anti-aliasing. Its value is the mean of its corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Square {
    /// Its top left corner in the picture, in pixels: (column, row).
    pub corner: [f64; 2],
    /// Its side in pixels.
    pub size: f64,
    /// The largest difference of its corners in any channel.
    pub spread: f64,
}

/// The samples that [`TileBuffers`] records.
#[derive(Default)]
pub(super) struct Log {
    /// Where the filter weights samples: what reaches the pixel.
    reach: Option<Reach>,
    /// The pixel, if others are traced only to tell its fireflies.
    only: Option<(u32, u32)>,
    pub(super) samples: Vec<(SampleId, Radiance)>,
    pub(super) count: u64,
    /// On the finest grid: corner, side, spread.
    pub(super) squares: Vec<([u32; 2], u32, f64)>,
}

impl Log {
    pub(super) fn traced(&mut self, view: &View, ids: &[SampleId], radiance: &[Radiance]) {
        for (id, radiance) in ids.iter().zip(radiance) {
            if self.reach.as_ref().is_some_and(|reach| reach.weight(place_of(view, id)) == 0.0) {
                continue;
            }
            if self.only.is_some_and(|only| only != (id.x, id.y)) {
                continue;
            }
            self.count += 1;
            if self.samples.len() < MAX_LISTED {
                self.samples.push((*id, *radiance));
            }
        }
    }
}

/// The filter of one pixel.
#[derive(Clone)]
struct Reach {
    filter: Filter,
    center: [f64; 2],
}

impl Reach {
    /// The weight of a sample at a position of the picture, relative to the pixel's centre.
    fn weight(&self, place: [f64; 2]) -> f64 {
        self.filter.weight(place[0] - self.center[0]) * self.filter.weight(place[1] - self.center[1])
    }
}

/// Renders only the pixel in column `x`, row `y` (from 0, top left). The result equals the picture's pixel bit
/// for bit.
///
/// Errors: a pixel outside the picture ([`crate::schema::ErrorCode::OutOfRange`]).
pub fn pixel(p: &Prepared, x: u32, y: u32) -> Result<PixelRecord, SceneError> {
    p.choose(1);
    let view = &p.view;
    check_pixel(view, x, y)?;
    let desc = FilmDesc { crop: Some([x, y, 1, 1]), auto_exposure: false, ..view.film.clone() };
    let mut film = Film::new(&desc)?;
    let mut buffers = TileBuffers::new(p);
    let reach = desc
        .weights_samples()
        .then(|| Reach { filter: desc.filter(), center: [f64::from(x) + 0.5, f64::from(y) + 0.5] });
    let only = (desc.removes_fireflies() && reach.is_none()).then_some((x, y));
    buffers.log = Some(Box::new(Log { reach: reach.clone(), only, ..Log::default() }));
    buffers.region = film.region;
    let all = 0..u64::from(desc.samples_per_pixel());
    for tile in 0..film.tiles().count() {
        let finished =
            buffers.render(&film.tiles().rect(tile), None, std::slice::from_ref(&all), Stop::NEVER);
        buffers.deposit((tile, None), &finished, &film.share());
    }
    let color = film.develop(&desc, 1).linear.first().copied().unwrap_or([f32::NAN; 4]);
    let log = buffers.log.take().unwrap_or_default();
    let adaptive = desc.antialias == Antialias::Adaptive;
    let cells = f64::from(1u32 << desc.max_subdivisions);
    let finite = |r: &Radiance| r.color.is_finite() && r.alpha.is_finite();
    let counted = log.samples.iter().filter(|(_, r)| finite(r)).count() as f64;
    let counted = counted + (log.count - log.samples.len() as u64) as f64;
    let total = film.weight(x, y);
    let limit = film.firefly_limit(x, y);
    let mut fireflies = 0;
    let samples = log.samples.iter().map(|&(id, radiance)| {
        let (place, weight) = if adaptive {
            let touching = |[left, top]: [u32; 2], size: u32| {
                (id.x == left || id.x == left + size) && (id.y == top || id.y == top + size)
            };
            let squares = log.squares.iter().filter(|(corner, size, _)| touching(*corner, *size));
            let weight = squares
                .map(|(_, size, _)| {
                    let edge = f64::from(*size) / cells;
                    edge * edge / 4.0
                })
                .sum();
            ([f64::from(id.x) / cells, f64::from(id.y) / cells], weight)
        } else {
            let place = place_of(view, &id);
            let weight = reach.as_ref().map_or(1.0 / counted, |reach| reach.weight(place) / total);
            (place, if finite(&radiance) { weight } else { 0.0 })
        };
        let by_lens = view.weight(place.into());
        let clamped = f64::from(by_lens * view.film.clamp_factor(radiance.color * by_lens));
        let contribution = f64::from(radiance.color.luminance()) * clamped * weight * total;
        let kept = match limit {
            Some(limit) if contribution > f64::from(limit) => {
                fireflies += 1;
                f64::from(limit) / contribution
            }
            _ => 1.0,
        };
        SampleRecord { id, place, weight: weight * clamped * kept, radiance }
    });
    let samples = samples.collect();
    let squares = log.squares.iter().map(|&(corner, size, spread)| Square {
        corner: corner.map(|c| f64::from(c) / cells),
        size: f64::from(size) / cells,
        spread,
    });
    Ok(PixelRecord { x, y, samples, count: log.count, squares: squares.collect(), fireflies, color })
}

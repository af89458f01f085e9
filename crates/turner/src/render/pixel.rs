//! One pixel on its own: its samples, and how they become its colour.

use super::tile::TileBuffers;
use super::work::Stop;
use crate::film::{Antialias, Film, FilmDesc};
use crate::integrator::{Prepared, Radiance};
use crate::sampler::SampleId;
use crate::schema::SceneError;
use crate::view::{check_pixel, place_of};

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
    /// "adaptive": the corners in the order of evaluation. Otherwise: by index.
    pub samples: Vec<SampleRecord>,
    /// The number of samples.
    pub count: u64,
    /// With "adaptive": the squares that were not divided further.
    pub squares: Vec<Square>,
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
    /// `film.clamp_sample` scales some.
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
    pub(super) samples: Vec<(SampleId, Radiance)>,
    pub(super) count: u64,
    /// On the finest grid: corner, side, spread.
    pub(super) squares: Vec<([u32; 2], u32, f64)>,
}

impl Log {
    pub(super) fn traced(&mut self, ids: &[SampleId], radiance: &[Radiance]) {
        self.count += ids.len() as u64;
        let room = MAX_LISTED.saturating_sub(self.samples.len());
        self.samples.extend(ids.iter().copied().zip(radiance.iter().copied()).take(room));
    }
}

/// Renders only the pixel in column `x`, row `y` (from 0, top left). The result equals the picture's pixel bit
/// for bit.
///
/// Errors: a pixel outside the picture ([`crate::schema::ErrorCode::OutOfRange`]).
pub fn pixel(p: &Prepared, x: u32, y: u32) -> Result<PixelRecord, SceneError> {
    p.choose();
    let view = &p.view;
    check_pixel(view, x, y)?;
    let desc = FilmDesc { crop: Some([x, y, 1, 1]), auto_exposure: false, ..view.film.clone() };
    let mut film = Film::new(&desc)?;
    let mut buffers = TileBuffers::new(p);
    buffers.log = Some(Box::default());
    let region = film.region;
    let all = 0..u64::from(desc.samples_per_pixel());
    let finished = buffers.render(&region, std::slice::from_ref(&all), Stop::NEVER);
    // The region has at most three columns and rows: one tile.
    buffers.deposit(0, &finished, &film.share());
    let color = film.develop(&desc).linear.first().copied().unwrap_or([f32::NAN; 4]);
    let log = buffers.log.take().unwrap_or_default();
    let adaptive = desc.antialias == Antialias::Adaptive;
    let cells = f64::from(1u32 << desc.max_subdivisions);
    let finite = |r: &Radiance| r.color.is_finite() && r.alpha.is_finite();
    let counted = log.samples.iter().filter(|(_, r)| finite(r)).count() as f64;
    let counted = counted + (log.count - log.samples.len() as u64) as f64;
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
            (place_of(view, &id), if finite(&radiance) { 1.0 / counted } else { 0.0 })
        };
        SampleRecord {
            id,
            place,
            weight: weight * f64::from(view.film.clamp_factor(radiance.color)),
            radiance,
        }
    });
    let squares = log.squares.iter().map(|&(corner, size, spread)| Square {
        corner: corner.map(|c| f64::from(c) / cells),
        size: f64::from(size) / cells,
        spread,
    });
    Ok(PixelRecord { x, y, samples: samples.collect(), count: log.count, squares: squares.collect(), color })
}

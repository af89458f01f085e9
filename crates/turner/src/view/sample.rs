//! Camera samples: positions in the picture and their camera rays.

use turner_bvh::lanes::{Block, LANES};

use super::View;
use crate::camera::camera_rays;
use crate::film::{Antialias, PixelSample};
use crate::filter::Filter;
use crate::math::{DVec2, Ray};
use crate::sampler::{OwenSobol, SampleId, VertexNumbers, stratified};
use crate::scene::RayBatch;
use crate::schema::{ErrorCode, Remedy, SceneError};

/// A batch of camera samples.
#[derive(Default)]
pub struct CameraSamples {
    /// The ids that determine their random numbers.
    pub ids: Vec<SampleId>,
    /// The camera rays, with unit directions.
    pub rays: RayBatch,
    /// The lengths of the direction vectors before normalisation, from the viewpoint to the screen: the classic
    /// documents measure t in them.
    pub lengths: Vec<Block>,
    /// The factors of their light if the view is weighted, else nothing: see [`CameraSamples::weight`]. Tracers ignore
    /// them.
    pub weights: Vec<f32>,
}

impl CameraSamples {
    /// Removes all samples.
    pub fn clear(&mut self) {
        self.ids.clear();
        self.rays.clear();
        self.lengths.clear();
        self.weights.clear();
    }

    /// The factor of a sample's light: 1 for cameras without such factors.
    #[inline]
    pub fn weight(&self, i: usize) -> f32 {
        self.weights.get(i).copied().unwrap_or(1.0)
    }
}

/// Random dimensions of a sample: pixel and lens. Lights start at 16.
const PIXEL_DIMENSION: u64 = 0;
const LENS_DIMENSION: u64 = 1;

/// Sobol sets for physically based integrators. Surfaces start at 2.
const PIXEL_SET: u32 = 0;
const LENS_SET: u32 = 1;

/// Errors: a pixel outside the picture.
pub(crate) fn check_pixel(view: &View, x: u32, y: u32) -> Result<(), SceneError> {
    let film = &view.film;
    if x < film.width && y < film.height {
        return Ok(());
    }
    let message =
        format!("there is no pixel in column {x}, row {y}: the picture has {}x{}", film.width, film.height);
    let help = "columns and rows are counted from 0 at the top left";
    Err(SceneError::new(ErrorCode::OutOfRange, message).help(help))
}

/// The id of a sample.
///
/// Errors: a pixel or sample index outside the picture's; adaptive anti-aliasing.
pub(crate) fn sample_id(view: &View, x: u32, y: u32, index: u32) -> Result<SampleId, SceneError> {
    let film = &view.film;
    let error = |message: String, help: &str, remedy| {
        SceneError::new(ErrorCode::OutOfRange, message).help(help).remedy(remedy)
    };
    check_pixel(view, x, y)?;
    if film.antialias == Antialias::Adaptive {
        return Err(error(
            "adaptive anti-aliasing shares samples between pixels, so a single sample cannot be selected by its index".to_owned(),
            "choose another: `antialias = \"monte-carlo\"` in [film]",
            Remedy::set("film.antialias", "monte-carlo"),
        ));
    }
    let count = film.samples_per_pixel();
    if index >= count {
        let last = match count {
            1 => "pixels of this picture have one sample, index 0".to_owned(),
            n => format!("samples of a pixel are numbered 0 to {}", n - 1),
        };
        let message = format!("there is no sample {index}: {last}");
        let more = Remedy::set("film.samples", index.saturating_add(1)).and("film.antialias", "monte-carlo");
        return Err(error(
            message,
            "`samples` in [film] with `antialias = \"monte-carlo\"` gives more",
            more,
        ));
    }
    Ok(SampleId { x, y, index, seed: u64::from(film.seed) })
}

/// The position of a sample, in pixels from the picture's top left corner; not for adaptive anti-aliasing.
pub(crate) fn place_of(view: &View, id: &SampleId) -> [f64; 2] {
    place(view, &view.film.placement(), id).into()
}

/// Replaces the batch by the sample at one position.
pub(crate) fn camera_point(view: &View, id: SampleId, place: [f64; 2], samples: &mut CameraSamples) {
    samples.clear();
    take_points(view, samples, std::iter::once((id, place.into())));
}

/// The camera ray through a sample's position, with unit direction; `None` where the camera has no ray.
pub fn camera_ray(view: &View, id: SampleId, place: [f64; 2]) -> Option<Ray> {
    let mut samples = CameraSamples::default();
    camera_point(view, id, place, &mut samples);
    samples.rays.get(0).filter(|ray| ray.t_max >= 0.0)
}

/// Appends camera samples at positions in pixels from the picture's top left corner.
pub(crate) fn take_points(
    view: &View,
    samples: &mut CameraSamples,
    mut points: impl Iterator<Item = (SampleId, DVec2)>,
) {
    // Labels of neighbouring pixels must not be mixed by random points on the lens.
    let has_lens = view.camera.has_lens() && !view.labels;
    let sobol = view.sobol;
    loop {
        let first = samples.ids.len();
        let (mut x, mut y) = (Block([f64::NAN; LANES]), Block([f64::NAN; LANES]));
        for (lane, (id, at)) in (&mut points).take(LANES).enumerate() {
            (x.0[lane], y.0[lane]) = (at.x, at.y);
            samples.ids.push(id);
        }
        let ids = &samples.ids[first..];
        if ids.is_empty() {
            return;
        }
        let lens = |lane: usize| match ids.get(lane) {
            Some(id) if has_lens && sobol => OwenSobol::new(id).two(LENS_SET).into(),
            Some(id) if has_lens => id.unit_square(LENS_DIMENSION),
            _ => DVec2::splat(0.5),
        };
        if view.moves {
            // The third value of the lens set; the first two are the position on the lens.
            let [open, close] = view.film.shutter;
            for (i, id) in ids.iter().enumerate() {
                let [.., u, _] = OwenSobol::new(id).four(LENS_SET);
                samples.rays.set_time(first + i, (open + (close - open) * u) as f32);
            }
        }
        let rays = samples.rays.add_block(ids.len());
        let lengths = camera_rays(view.instruction_set, &view.camera, &view.film, &x, &y, lens, rays);
        samples.lengths.push(lengths);
        if view.weighted {
            let weight = |lane: usize| view.weight(DVec2::new(x.0[lane], y.0[lane]));
            samples.weights.extend((0..samples.ids.len() - first).map(weight));
        }
        if let Some(motion) = &view.motion {
            for i in first..samples.ids.len() {
                motion.move_ray(&mut samples.rays, i);
            }
        }
        if ids.len() < LANES {
            return;
        }
    }
}

/// Appends a block of camera rays without ids, through positions in pixels and the centre of the lens: `count` lanes, whose
/// x is not NaN.
#[inline]
pub(crate) fn take_centers(view: &View, samples: &mut CameraSamples, [x, y]: &[Block; 2], count: usize) {
    let rays = samples.rays.add_block(count);
    let center = |_: usize| DVec2::splat(0.5);
    samples.lengths.push(camera_rays(view.instruction_set, &view.camera, &view.film, x, y, center, rays));
}

/// The position of a sample, in pixels from the picture's top left corner.
#[inline]
pub(crate) fn place(view: &View, filter: &Filter, id: &SampleId) -> DVec2 {
    DVec2::new(f64::from(id.x), f64::from(id.y)) + within_pixel(view, filter, id)
}

/// The positions of samples, as [`place`] gives them one by one.
pub(crate) fn places(view: &View, filter: &Filter, ids: &[SampleId], buffer: &mut PlaceBuffer) {
    let PlaceBuffer { requests, numbers, places } = buffer;
    places.clear();
    if view.film.antialias != Antialias::MonteCarlo || !view.sobol {
        places.extend(ids.iter().map(|id| place(view, filter, id)));
        return;
    }
    requests.clear();
    requests.extend(ids.iter().map(|id| (OwenSobol::new(id), PIXEL_SET)));
    OwenSobol::vertex_numbers(view.instruction_set, requests, numbers);
    places.extend(ids.iter().zip(numbers).map(|(id, numbers)| {
        let [x, y, ..] = numbers.first();
        DVec2::new(f64::from(id.x), f64::from(id.y)) + filter.place(DVec2::new(x, y))
    }));
}

/// The positions of a batch of samples; memory is reused.
#[derive(Default)]
pub(crate) struct PlaceBuffer {
    requests: Vec<(OwenSobol, u32)>,
    numbers: Vec<VertexNumbers>,
    pub(crate) places: Vec<DVec2>,
}

/// The position in the pixel: (0, 0) is its top left corner, (1, 1) the bottom right one. Filters may reach
/// beyond.
#[inline]
fn within_pixel(view: &View, filter: &Filter, id: &SampleId) -> DVec2 {
    let film = &view.film;
    match film.antialias {
        Antialias::None | Antialias::Mean | Antialias::Adaptive => match film.pixel_sample {
            PixelSample::Center => DVec2::splat(0.5),
            PixelSample::Corner => DVec2::new(0.0, 1.0),
        },
        Antialias::Grid => {
            let side = film.grid_side();
            let cell = DVec2::new(f64::from(id.index % side), f64::from(id.index / side));
            (cell + 0.5) / f64::from(side)
        }
        Antialias::MonteCarlo if view.sobol => filter.place(OwenSobol::new(id).two(PIXEL_SET).into()),
        Antialias::MonteCarlo => {
            filter.place(stratified(id.index, film.samples, id.unit_square(PIXEL_DIMENSION)))
        }
    }
}

//! AOVs of what the centres of pixels show, without light and without a film: labels for learning, of which thousands are
//! made.
//!
//! One ray is traced through the centre of each pixel and of the lens, at time 0 of the shutter. The values are those of a
//! film with one such sample, but they go straight to their places: no sums, no tiles, no locks.

use std::sync::Mutex;

use super::aovs::AovValues;
use super::work::Work;
use super::{PassOptions, Prepared};
use crate::film::{Aov, Average, FilmDesc, Fixed96, NO_LABEL, PixelRect};
use crate::integrator::aovs::SampleAovs;
use crate::integrator::{Radiance, SampleDetails};
use crate::math::DVec2;
use crate::sampler::SampleId;
use crate::schema::{ErrorCode, SceneError};
use crate::view::{CameraSamples, View, take_points};

/// Rows of a task.
const ROWS: u32 = 4;

/// An AOV at the centres of pixels, row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct CenterAov {
    /// The AOV.
    pub aov: Aov,
    /// For each pixel of the crop as many values as the AOV has channels.
    pub values: AovValues,
}

/// The rows of an AOV that belong to one task.
enum Rows<'a> {
    Float(&'a mut [f32]),
    Uint(&'a mut [u32]),
}

/// The AOVs of the film of a prepared scene at the centres of the pixels of its crop, in the order of
/// [`Aov::all`](crate::film::Aov::all). `None` if it was cancelled.
///
/// Errors: AOVs of light or of several samples ([`ErrorCode::Conflict`]); a panic in a worker.
pub fn center_aovs(
    prepared: &Prepared,
    options: &PassOptions<'_>,
) -> Result<Option<Vec<CenterAov>>, SceneError> {
    let film = &prepared.view.film;
    for aov in film.aovs.iter() {
        let is_first = matches!(aov.layout().average, Average::Samples | Average::Hits(_) | Average::Nearest);
        if !is_first || aov.needs_paths() {
            let message = format!("the AOV \"{}\" is not one of the first surface", aov.word());
            return Err(SceneError::new(ErrorCode::Conflict, message).help("render the picture for it"));
        }
    }
    let view = View { labels: true, moves: false, motion: None, ..prepared.view.clone() };
    let crop = crop_of(film);
    let mut out: Vec<CenterAov> = film.aovs.iter().map(|aov| empty(aov, crop.area() as usize)).collect();
    let tasks = tasks_of(&mut out, &crop);
    let whole = Work::new(options).run(tasks.len(), |numbers| {
        let Some(mut aovs) = SampleAovs::new(&prepared.scene, &view) else { return };
        let (mut samples, mut radiance) = (CameraSamples::default(), Vec::new());
        for number in numbers {
            let first = crop.y + number as u32 * ROWS;
            let rows = first..(first + ROWS).min(crop.y + crop.height);
            let pixels = rows.flat_map(|y| (crop.x..crop.x + crop.width).map(move |x| (x, y)));
            let seed = u64::from(film.seed);
            samples.clear();
            take_points(
                &view,
                &mut samples,
                pixels.map(|(x, y)| {
                    let center = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                    (SampleId { x, y, index: 0, seed }, center)
                }),
            );
            radiance.resize(samples.ids.len(), Radiance::default());
            aovs.take(&samples, &radiance, SampleDetails::default());
            let mut rows = tasks[number].lock().unwrap_or_else(|e| e.into_inner());
            fill(film, &aovs, &mut rows);
        }
    })?;
    drop(tasks);
    Ok(whole.then_some(out))
}

/// The number of channels of an AOV.
fn depth(aov: Aov) -> usize {
    aov.layout().channels.len()
}

/// An AOV of so many pixels, without values.
fn empty(aov: Aov, pixels: usize) -> CenterAov {
    let values = match aov.layout().average {
        Average::Nearest => AovValues::Uint(vec![0; pixels * depth(aov)]),
        _ => AovValues::Float(vec![0.0; pixels * depth(aov)]),
    };
    CenterAov { aov, values }
}

/// For each task the rows of all AOVs that it fills.
fn tasks_of<'a>(out: &'a mut [CenterAov], crop: &PixelRect) -> Vec<Mutex<Vec<Rows<'a>>>> {
    let mut tasks: Vec<Vec<Rows<'a>>> = Vec::new();
    tasks.resize_with(crop.height.div_ceil(ROWS) as usize, Vec::new);
    let pixels = (ROWS * crop.width) as usize;
    for CenterAov { aov, values } in out {
        let length = pixels * depth(*aov);
        match values {
            AovValues::Float(all) => {
                tasks.iter_mut().zip(all.chunks_mut(length)).for_each(|(task, v)| task.push(Rows::Float(v)));
            }
            AovValues::Uint(all) => {
                tasks.iter_mut().zip(all.chunks_mut(length)).for_each(|(task, v)| task.push(Rows::Uint(v)));
            }
        }
    }
    tasks.into_iter().map(Mutex::new).collect()
}

/// Fills the rows of a task.
fn fill(film: &FilmDesc, aovs: &SampleAovs<'_>, rows: &mut [Rows<'_>]) {
    // The first value of a sample says whether it hits something.
    let (mut at, mut label) = (1, 0);
    for (aov, rows) in film.aovs.iter().zip(rows) {
        let depth = depth(aov);
        match rows {
            Rows::Float(rows) => {
                let none = match aov.layout().average {
                    Average::Hits(none) => Some(none),
                    _ => None,
                };
                for (values, pixel) in aovs.all_values().zip(rows.chunks_exact_mut(depth)) {
                    match none {
                        Some(none) if values[0] == 0.0 => pixel.fill(none),
                        // As the sum of one sample in a film.
                        _ => {
                            let own = pixel.iter_mut().zip(&values[at..at + depth]);
                            own.for_each(|(to, v)| *to = Fixed96::mean_of_one(*v));
                        }
                    }
                }
                at += depth;
            }
            Rows::Uint(rows) => {
                for (labels, pixel) in aovs.all_labels().zip(rows.chunks_exact_mut(depth)) {
                    let number = labels[label];
                    pixel.fill(if number == NO_LABEL { 0 } else { number + 1 });
                }
                label += 1;
            }
        }
    }
}

/// The pixels that are shown.
fn crop_of(film: &FilmDesc) -> PixelRect {
    let [x, y, width, height] = film.crop.unwrap_or([0, 0, film.width, film.height]);
    PixelRect { x, y, width, height }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use super::*;
    use crate::Renderer;
    use crate::description::{ObjectDesc, SceneDesc};
    use crate::film::{Antialias, Aov, Aovs};
    use crate::schema::PrepareOptions;
    use crate::shape::{BoxDesc, PlaneDesc, ShapeDesc, SphereDesc};

    fn scene(aovs: &[Aov]) -> SceneDesc {
        let mut desc = SceneDesc::default();
        (desc.film.width, desc.film.height) = (61, 37);
        desc.film.antialias = Antialias::None;
        desc.film.aovs = Aovs::new(aovs);
        desc.objects.push(ObjectDesc::new(ShapeDesc::Sphere(SphereDesc::default())));
        desc.objects.push(ObjectDesc::new(ShapeDesc::Box(BoxDesc::default())));
        desc.objects.push(ObjectDesc::new(ShapeDesc::Plane(PlaneDesc::default())));
        desc
    }

    /// What a film with one sample through each centre has, to the last bit.
    #[test]
    fn values_are_those_of_a_film() {
        let all = [
            Aov::Depth,
            Aov::Normal,
            Aov::ObjectId,
            Aov::Position,
            Aov::MaterialId,
            Aov::Uv,
            Aov::Albedo,
            Aov::InstanceId,
        ];
        for (crop, aovs) in [(None, &all[..]), (Some([7, 5, 30, 21]), &all[..3]), (None, &all[2..3])] {
            let mut desc = scene(aovs);
            desc.film.crop = crop;
            let prepared = desc.prepare(&PrepareOptions::default()).unwrap();
            let never = AtomicBool::new(false);
            let mut renderer = Renderer::new(prepared.clone()).unwrap();
            let options = PassOptions { threads: 2, cancel: &never, progress: None };
            renderer.pass(1, &options).unwrap();
            for threads in [1, 3] {
                let options = PassOptions { threads, ..options };
                let found = center_aovs(&prepared, &options).unwrap().unwrap();
                let mut of_film = renderer.develop_aovs(1).into_iter();
                for own in &found {
                    let depth = own.aov.layout().channels.len();
                    for channel in 0..depth {
                        let film = of_film.next().unwrap();
                        assert_eq!(own.aov, film.aov);
                        let of_channel = channel_of(&own.values, depth, channel);
                        let differs = difference(&of_channel, &film.values);
                        assert!(of_channel == film.values, "{} {crop:?}: {differs}", film.name);
                    }
                }
                assert_eq!(of_film.next(), None);
            }
        }
    }

    /// One channel of the values of all.
    fn channel_of(values: &AovValues, depth: usize, channel: usize) -> AovValues {
        match values {
            AovValues::Float(v) => AovValues::Float(v.iter().copied().skip(channel).step_by(depth).collect()),
            AovValues::Uint(v) => AovValues::Uint(v.iter().copied().skip(channel).step_by(depth).collect()),
        }
    }

    /// The first values that differ.
    fn difference(a: &AovValues, b: &AovValues) -> String {
        match (a, b) {
            (AovValues::Float(a), AovValues::Float(b)) => {
                format!("{:?} of {}, {}", a.iter().zip(b).find(|(a, b)| a != b), a.len(), b.len())
            }
            (a, b) => format!("{} differs", if a == b { "nothing" } else { "a label" }),
        }
    }

    #[test]
    fn light_is_refused_and_cancels_are_heard() {
        for aov in [Aov::Direct, Aov::CryptoObject, Aov::SampleCount, Aov::Cost, Aov::Denoising] {
            let prepared = scene(&[aov]).prepare(&PrepareOptions::default()).unwrap();
            let never = AtomicBool::new(false);
            let options = PassOptions { threads: 1, cancel: &never, progress: None };
            assert_eq!(center_aovs(&prepared, &options).unwrap_err().code, ErrorCode::Conflict, "{aov:?}");
        }
        let prepared = scene(&[Aov::Depth]).prepare(&PrepareOptions::default()).unwrap();
        let options = PassOptions { threads: 1, cancel: &AtomicBool::new(true), progress: None };
        assert_eq!(center_aovs(&prepared, &options).unwrap(), None);
    }
}

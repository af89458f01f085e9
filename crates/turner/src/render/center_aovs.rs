//! AOVs of what the centres of pixels show, without light and without a film: labels for learning, of which thousands are
//! made.
//!
//! One ray is traced through the centre of each pixel and of the lens, at time 0 of the shutter. The values are those of a
//! film with one such sample, but they go straight to their places: no sums, no tiles, no locks.

use std::sync::Mutex;

use super::aovs::{AovChannel, AovValues};
use super::work::Work;
use super::{PassOptions, Prepared};
use crate::film::{Average, FilmDesc, Fixed96, NO_LABEL, PixelRect};
use crate::integrator::aovs::SampleAovs;
use crate::integrator::{Radiance, SampleDetails};
use crate::math::DVec2;
use crate::sampler::SampleId;
use crate::schema::{ErrorCode, SceneError};
use crate::view::{CameraSamples, View, take_points};

/// Rows of a task.
const ROWS: u32 = 4;

/// The values of a strip of rows, pixel by pixel.
struct Strip {
    number: usize,
    values: Vec<f32>,
    labels: Vec<u32>,
}

/// The AOVs of the film of a prepared scene at the centres of the pixels of its crop, in the order of
/// [`Aov::all`](crate::film::Aov::all). `None` if it was cancelled.
///
/// Errors: AOVs of light or of several samples ([`ErrorCode::Conflict`]); a panic in a worker.
pub fn center_aovs(
    prepared: &Prepared,
    options: &PassOptions<'_>,
) -> Result<Option<Vec<AovChannel>>, SceneError> {
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
    let strips = crop.height.div_ceil(ROWS) as usize;
    let done = Mutex::new(Vec::with_capacity(strips));
    let whole = Work::new(options).run(strips, |tasks| {
        let Some(mut aovs) = SampleAovs::new(&prepared.scene, &view) else { return };
        let (mut samples, mut radiance) = (CameraSamples::default(), Vec::new());
        let mut own = Vec::new();
        for number in tasks {
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
            let mut found = (Vec::new(), Vec::new());
            aovs.append_to(&mut found);
            own.push(Strip { number, values: found.0, labels: found.1 });
        }
        done.lock().unwrap_or_else(|e| e.into_inner()).append(&mut own);
    })?;
    if !whole {
        return Ok(None);
    }
    let mut done = done.into_inner().unwrap_or_else(|e| e.into_inner());
    done.sort_unstable_by_key(|strip| strip.number);
    Ok(Some(channels(film, crop.area() as usize, &done)))
}

/// The pixels that are shown.
fn crop_of(film: &FilmDesc) -> PixelRect {
    let [x, y, width, height] = film.crop.unwrap_or([0, 0, film.width, film.height]);
    PixelRect { x, y, width, height }
}

/// The values of pixels as planes.
fn channels(film: &FilmDesc, pixels: usize, strips: &[Strip]) -> Vec<AovChannel> {
    let stride = film.channels().len();
    let kinds = film.aovs.iter().filter(|aov| aov.labels().is_some()).count();
    // The first value of a pixel says whether it hits something.
    let mut at = 1;
    let mut label = 0;
    let mut out = Vec::new();
    for aov in film.aovs.iter() {
        let layout = aov.layout();
        if layout.average == Average::Nearest {
            let number = |v: &u32| if *v == NO_LABEL { 0 } else { v + 1 };
            let mut plane = Vec::with_capacity(pixels);
            for strip in strips {
                plane.extend(strip.labels.iter().skip(label).step_by(kinds).map(number));
            }
            let name = layout.channels.first().copied().unwrap_or_default().to_owned();
            out.push(AovChannel { aov, name, values: AovValues::Uint(plane) });
            label += 1;
            continue;
        }
        for name in layout.channels {
            let mut plane = Vec::with_capacity(pixels);
            for strip in strips {
                plane.extend(strip.values.chunks_exact(stride).map(|pixel| match layout.average {
                    Average::Hits(none) if pixel[0] == 0.0 => none,
                    // As the sum of one sample in a film.
                    _ => Fixed96::from_f32(pixel[at]).mean(1.0) as f32,
                }));
            }
            out.push(AovChannel { aov, name: (*name).to_owned(), values: AovValues::Float(plane) });
            at += 1;
        }
    }
    out
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
                for (own, film) in found.iter().zip(&renderer.develop_aovs(1)) {
                    assert!(own == film, "{} {crop:?}: {}", own.name, difference(own, film));
                }
            }
        }
    }

    /// The first values that differ.
    fn difference(a: &AovChannel, b: &AovChannel) -> String {
        match (&a.values, &b.values) {
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

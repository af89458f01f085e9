//! One picture of a scene: for programs that want pixels and no session.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use serde_json::{Value as Json, json};
use turner::film::FilmDesc;
use turner::schema::{Limits, PrepareOptions};
use turner::{PassOptions, Picture, Renderer};
use turner_host::time::Instant;
use turner_io::assets::MemoryAssets;
use turner_io::image::{ImageFormat, Transfer};
use turner_io::scene::{LoadOptions, Override, load_from};
use turner_io::{SaveOptions, to_bytes};

use crate::session::{CallError, Reply};

/// What is wanted.
#[derive(Clone, Debug, Default)]
pub struct PictureRequest {
    /// The scene or model among the files.
    pub main: String,
    /// Values of the scene by key path, as in `-D film.samples=64`.
    pub overrides: Vec<(String, String)>,
    /// The type of the integrator, instead of the scene's. It also decides on the film of a model.
    pub integrator: Option<String>,
    /// Width and height in pixels. One alone keeps the aspect ratio; none keeps the size.
    pub size: [Option<u32>; 2],
    /// Threads; 0 uses all.
    pub threads: usize,
    /// Limits of memory and size.
    pub limits: Limits,
}

/// A picture while it is rendered, step by step. The steps make no difference to the picture.
pub struct PictureJob {
    pub(crate) renderer: Renderer,
    pub(crate) threads: usize,
    /// What was chosen, approximated or ignored in reading the scene.
    pub warnings: Vec<String>,
}

impl PictureJob {
    /// Reads and prepares a scene.
    ///
    /// Errors: those of reading and preparing it.
    pub fn begin(files: Vec<(String, Vec<u8>)>, wanted: &PictureRequest) -> Result<PictureJob, CallError> {
        let overrides = wanted.overrides.iter();
        let overrides = overrides.map(|(path, value)| Override { path: path.clone(), value: value.clone() });
        let options = LoadOptions {
            threads: wanted.threads,
            overrides: overrides.collect(),
            integrator: wanted.integrator.clone(),
            limits: wanted.limits.clone(),
            ..LoadOptions::default()
        };
        let assets = Arc::new(MemoryAssets { files: files.into_iter().collect() });
        let mut loaded = load_from(&wanted.main, &*assets, &options)?;
        // Textures and meshes are decoded: the files are not needed any more.
        drop(assets);
        resize(&mut loaded.desc.film, wanted.size);
        let prepare =
            PrepareOptions { threads: wanted.threads, limits: wanted.limits.clone(), ..Default::default() };
        let bad = |error| CallError::of_scene(&error, &loaded.sources);
        let prepared = loaded.desc.prepare(&prepare).map_err(bad)?;
        let renderer = Renderer::new(prepared).map_err(bad)?;
        let warnings = loaded.desc.warnings.iter().map(|warning| warning.message.clone()).collect();
        Ok(PictureJob { renderer, threads: wanted.threads, warnings })
    }

    /// Renders for about this time, or until `stop` is set, which it leaves set to false. A sample of a tile, the photons
    /// of a sample and the choices of an integrator are not divided. Returns whether the picture is complete.
    ///
    /// Errors: no memory for light paths.
    pub fn step(&mut self, time: Duration, stop: &AtomicBool) -> Result<bool, CallError> {
        let started = Instant::now();
        stop.store(false, Ordering::SeqCst);
        let integrator = Arc::clone(&self.renderer.prepared().integrator);
        while !self.renderer.is_complete() && !stop.load(Ordering::SeqCst) {
            // The photons of a sample would be lost if the pass ended between them and the sample.
            let divides = integrator.has_chosen() && !integrator.finds_photons();
            let in_time = |_: usize, _: usize| {
                if divides && started.elapsed() >= time {
                    stop.store(true, Ordering::SeqCst);
                }
            };
            let options = PassOptions { threads: self.threads, cancel: stop, progress: Some(&in_time) };
            self.renderer.pass(1, &options)?;
            if started.elapsed() >= time {
                break;
            }
        }
        stop.store(false, Ordering::SeqCst);
        Ok(self.renderer.is_complete())
    }

    /// The finished part of the samples, from 0 to 1.
    pub fn progress(&self) -> f64 {
        if self.renderer.is_complete() {
            return 1.0;
        }
        self.renderer.film.finished(&(0..self.renderer.samples_per_pixel())).clamp(0.0, 1.0)
    }

    /// Width and height of the picture in pixels: those of its crop, if it has one.
    pub fn size(&self) -> [u32; 2] {
        let film = &self.renderer.prepared().view.film;
        film.crop.map_or([film.width, film.height], |[.., width, height]| [width, height])
    }

    /// The picture so far.
    pub fn picture(&self) -> Picture {
        self.renderer.develop_with(self.threads)
    }
}

/// Gives a film another size. One side alone keeps the aspect ratio.
fn resize(film: &mut FilmDesc, [width, height]: [Option<u32>; 2]) {
    let scaled = |side: u32, own: u32, other: u32| {
        ((f64::from(side) * f64::from(other) / f64::from(own.max(1))).round() as u32).max(1)
    };
    (film.width, film.height) = match (width, height) {
        (Some(width), Some(height)) => (width, height),
        (Some(width), None) => (width, scaled(width, film.width, film.height)),
        (None, Some(height)) => (scaled(height, film.height, film.width), height),
        (None, None) => return,
    };
}

/// Renders a picture with all its samples.
///
/// Errors: those of reading and preparing the scene.
pub fn picture(files: Vec<(String, Vec<u8>)>, wanted: &PictureRequest) -> Result<Picture, CallError> {
    let mut job = PictureJob::begin(files, wanted)?;
    let never = AtomicBool::new(false);
    while !job.step(Duration::MAX, &never)? {}
    Ok(job.picture())
}

/// The request of a call: `main`, `overrides` as pairs of texts, `integrator`, `width`, `height`.
pub(crate) fn request(
    limits: Limits,
    threads: usize,
    args: &Json,
    files: &[(String, Vec<u8>)],
) -> Result<PictureRequest, CallError> {
    let text = |json: &Json| json.as_str().map(str::to_owned);
    let main = args.get("main").and_then(text);
    let main = main.or_else(|| files.first().map(|(name, _)| name.clone())).unwrap_or_default();
    let mut overrides = Vec::new();
    for pair in args.get("overrides").and_then(Json::as_array).into_iter().flatten() {
        let pair = pair.get(0).and_then(text).zip(pair.get(1).and_then(text));
        overrides.push(
            pair.ok_or_else(|| CallError::new("an override is a pair of a key path and a value, as text"))?,
        );
    }
    let side = |key: &str| match args.get(key).filter(|value| !value.is_null()) {
        None => Ok(None),
        Some(value) => match value.as_u64() {
            Some(n @ 1..=65_536) => Ok(u32::try_from(n).ok()),
            _ => Err(CallError::new(format!(
                "the {key} is {value}; expected a whole number of pixels from 1 to 65536"
            ))),
        },
    };
    let integrator = args.get("integrator").and_then(text);
    Ok(PictureRequest {
        main,
        overrides,
        integrator,
        size: [side("width")?, side("height")?],
        threads,
        limits,
    })
}

/// A picture as bytes: `rgba`, `linear` (little-endian f32), or a file.
pub(crate) fn encoded(picture: &Picture, format: &str, threads: usize) -> Result<Vec<u8>, CallError> {
    Ok(match format {
        "rgba" => picture.display.as_flattened().to_vec(),
        "linear" => picture.linear.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect(),
        name => {
            let format = ImageFormat::of_path(std::path::Path::new(&format!("picture.{name}")))
                .map_err(|e| CallError::new(e.to_string()))?;
            let options = SaveOptions { threads, transfer: Transfer::Srgb, ..SaveOptions::default() };
            to_bytes(picture, format, &options).map_err(|e| CallError::new(e.to_string()))?
        }
    })
}

/// The call `picture`: a request, and `format` of the bytes: see [`encoded`].
pub(crate) fn of_call(
    limits: Limits,
    threads: usize,
    args: &Json,
    files: Vec<(String, Vec<u8>)>,
) -> Result<Reply, CallError> {
    let format = args.get("format").and_then(Json::as_str).unwrap_or("rgba");
    let wanted = request(limits, threads, args, &files)?;
    let picture = picture(files, &wanted)?;
    let bytes = encoded(&picture, format, threads)?;
    Ok(Reply {
        json: json!({ "width": picture.width, "height": picture.height, "non_finite": picture.missing }),
        bytes,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A lit ball with random samples.
    const BALL: &str = "[film]\nwidth = 24\nheight = 16\nsamples = 8\n[integrator]\ntype = \"path\"\n\
                        [studio]\n[[object]]\ntype = \"sphere\"\n";

    fn files(text: &str) -> Vec<(String, Vec<u8>)> {
        vec![("ball.toml".to_owned(), text.as_bytes().to_vec())]
    }

    fn wanted(size: [Option<u32>; 2], threads: usize) -> PictureRequest {
        PictureRequest { main: "ball.toml".into(), size, threads, ..PictureRequest::default() }
    }

    #[test]
    fn short_steps_stops_and_threads_make_no_difference() {
        let whole = picture(files(BALL), &wanted([None, None], 1)).unwrap();
        let mut job = PictureJob::begin(files(BALL), &wanted([None, None], 2)).unwrap();
        let (stop, mut last, mut steps) = (AtomicBool::new(false), 0.0, 0);
        loop {
            let done = job.step(Duration::ZERO, &stop).unwrap();
            let progress = job.progress();
            assert!(progress >= last && (progress == 1.0) == done, "{last} {progress}");
            (last, steps) = (progress, steps + 1);
            if done {
                break;
            }
        }
        assert!(steps >= 8, "{steps}");
        assert_eq!(job.picture().linear, whole.linear);
        assert_eq!(job.picture().display, whole.display);
    }

    #[test]
    fn one_side_keeps_the_aspect_ratio() {
        let size = |size| PictureJob::begin(files(BALL), &wanted(size, 1)).unwrap().size();
        assert_eq!(size([Some(12), None]), [12, 8]);
        assert_eq!(size([None, Some(4)]), [6, 4]);
        assert_eq!(size([Some(5), Some(7)]), [5, 7]);
        assert_eq!(size([None, None]), [24, 16]);
    }

    #[test]
    fn a_bad_scene_has_its_line() {
        let error = picture(files("[film]\nwidht = 3"), &wanted([None, None], 1)).unwrap_err();
        assert_eq!(error.place.map(|at| at.line), Some(2));
        let args = json!({ "width": 0 });
        assert!(request(Limits::default(), 1, &args, &[]).unwrap_err().message.contains("width"));
    }
}

//! A scene, and the picture that its denoised pictures are compared with.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use turner::compare::{Canvas, Metric, Pair, relative_mse};
use turner::denoise::Rgb;
use turner::film::{Antialias, Denoise};
use turner::filter::FilterKind;
use turner::integrator::Prepared;
use turner::math::elementary::pow;
use turner::render::{PassOptions, Renderer};
use turner::schema::{ErrorCode, PrepareOptions, SceneError};
use turner_cli::failure::{Failure, Labels};
use turner_cli::instructions::instruction_set;
use turner_cli::limits;
use turner_io::scene::{LoadOptions, load};

use crate::picture::{self, Picture};

/// The seeds of the halves of a reference.
const SEEDS: [u32; 2] = [0x5eed, 0x5eee];

/// Less than this is left of an error by the reference's noise alone.
const LEAST: f64 = 1e-9;

/// A scene to denoise.
pub(super) struct Scene {
    pub(super) name: String,
    prepared: Prepared,
    threads: usize,
}

impl Scene {
    /// Loads a scene or model, its picture scaled to a width.
    pub(super) fn load(path: &Path, width: u32, threads: usize) -> Result<Scene, Failure> {
        let labels = Labels::new();
        // The scenes are those that the developer names.
        let options = LoadOptions {
            threads,
            limits: limits::of_machine(),
            allow_outside: true,
            ..LoadOptions::default()
        };
        let mut loaded = load(path, &options).map_err(|e| Failure::load(e, &labels))?;
        let film = &mut loaded.desc.film;
        film.height = (film.height * width).div_ceil(film.width).max(1);
        (film.width, film.antialias, film.denoise) = (width, Antialias::MonteCarlo, Denoise::On);
        // Denoisers expect noise that is independent from pixel to pixel.
        (film.filter, film.filter_radius) = (FilterKind::Box, None);
        film.samples = film.samples.max(2);
        let options =
            PrepareOptions { threads, instruction_set: instruction_set(), ..PrepareOptions::default() };
        let prepared = loaded.desc.prepare(&options);
        let prepared = prepared.map_err(|e| Failure::in_scene(e, &loaded.sources, &labels))?;
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let folder = path.parent().and_then(Path::file_name).unwrap_or_default().to_string_lossy();
        // Many scenes have the name "scene".
        let name = if stem.starts_with("scene") { folder.into_owned() } else { stem.into_owned() };
        Ok(Scene { name, prepared, threads })
    }

    /// An error that names the scene.
    pub(super) fn failure(&self, why: &str) -> Failure {
        Failure::new(SceneError::new(ErrorCode::Conflict, format!("{}: {why}", self.name)))
    }

    /// Renders it.
    pub(super) fn render(&mut self, samples: u32, seed: u32) -> Result<Renderer, Failure> {
        let film = &mut self.prepared.view.film;
        (film.samples, film.seed) = (samples, seed);
        let never = AtomicBool::new(false);
        let mut renderer = Renderer::new(self.prepared.clone()).map_err(Failure::new)?;
        let options = PassOptions { threads: self.threads, cancel: &never, progress: None };
        renderer.pass(u32::MAX, &options).map_err(Failure::new)?;
        Ok(renderer)
    }

    /// Writes a picture.
    pub(super) fn save(&self, path: &Path, pixels: &[Rgb]) -> Result<(), Failure> {
        let film = &self.prepared.view.film;
        picture::save(path, (film.width, film.height), pixels.iter().copied())
    }
}

/// A converged picture.
pub(super) struct Reference {
    pub(super) pixels: Vec<Rgb>,
    /// Its own relMSE.
    noise: f64,
}

impl Reference {
    /// Rendered in two halves, which are kept at this path with "-0.exr" and "-1.exr" behind it.
    pub(super) fn of(scene: &mut Scene, samples: u32, kept: Option<&Path>) -> Result<Reference, Failure> {
        let mut halves: Vec<Vec<Rgb>> = Vec::new();
        for (seed, k) in SEEDS.into_iter().zip(0..) {
            let path = kept.map(|path| path.with_file_name(format!("{}-{k}.exr", scene.name)));
            if let Some(found) = path.as_ref().and_then(|path| read(path).transpose()) {
                halves.push(found?);
                continue;
            }
            let renderer = scene.render(samples, seed)?;
            let picture = renderer.film.develop(&scene.prepared.view.film, scene.threads);
            let pixels: Vec<Rgb> = picture.linear.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect();
            if let Some(path) = path {
                scene.save(&path, &pixels)?;
            }
            halves.push(pixels);
        }
        let film = &scene.prepared.view.film;
        if halves.iter().any(|half| half.len() != (film.width * film.height) as usize) {
            return Err(scene.failure("a reference has another size"));
        }
        let mean = |a: &Rgb, b: &Rgb| std::array::from_fn(|c| 0.5 * (a[c] + b[c]));
        let pixels: Vec<Rgb> = halves[0].iter().zip(&halves[1]).map(|(a, b)| mean(a, b)).collect();
        // A half differs from the mean of both by (a - b) / 2, whose variance is that of the mean.
        let noise = relative_mse(&doubles(&halves[0]), &doubles(&pixels));
        Ok(Reference { pixels, noise })
    }

    /// relMSE without the reference's own noise, and FLIP.
    pub(super) fn errors(&self, scene: &Scene, pixels: &[Rgb], threads: usize) -> [f64; 2] {
        let error = relative_mse(&doubles(pixels), &doubles(&self.pixels)) - self.noise;
        let film = &scene.prepared.view.film;
        let canvas = |pixels: &[Rgb]| {
            let scale = pow(2.0, film.exposure) as f32;
            let shown = |v: &Rgb| [v[0] * scale, v[1] * scale, v[2] * scale, 1.0].map(|v| v.clamp(0.0, 1.0));
            let pixels = pixels.iter().map(shown).collect();
            Canvas { width: film.width, height: film.height, pixels, has_alpha: false, is_linear: true }
        };
        let flip = Pair::new(canvas(&self.pixels), canvas(pixels))
            .map_or(f64::NAN, |pair| Metric::Flip.measure(&pair, threads).value);
        // Not `max`, which would hide a value that is not a number.
        [if error < LEAST { LEAST } else { error }, flip]
    }
}

impl Reference {
    /// The relative error of luminance that 95 % of the pixels do not exceed.
    pub(super) fn exceeded(&self, pixels: &[Rgb]) -> f64 {
        let luminance =
            |v: &Rgb| 0.2126 * f64::from(v[0]) + 0.7152 * f64::from(v[1]) + 0.0722 * f64::from(v[2]);
        let mean = self.pixels.iter().map(luminance).sum::<f64>() / self.pixels.len().max(1) as f64;
        let relative = |(own, truth): (&Rgb, &Rgb)| {
            (luminance(own) - luminance(truth)).abs() / luminance(truth).max(0.01 * mean)
        };
        let mut all: Vec<f64> = pixels.iter().zip(&self.pixels).map(relative).collect();
        all.sort_by(f64::total_cmp);
        all.get(all.len() * 95 / 100).copied().unwrap_or(0.0)
    }
}

/// The pixels of a file, if there is one.
fn read(path: &Path) -> Result<Option<Vec<Rgb>>, Failure> {
    if !path.is_file() {
        return Ok(None);
    }
    let picture = Picture::read(path)?;
    Ok(Some(picture.pixels.iter().map(|v| v.map(|v| v as f32)).collect()))
}

fn doubles(pixels: &[Rgb]) -> Vec<[f64; 3]> {
    pixels.iter().map(|v| v.map(f64::from)).collect()
}

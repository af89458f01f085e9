//! A scene, its converged picture, and previews as they are shown.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use turner::compare::{Canvas, Metric, Pair};
use turner::film::{Denoise, Picture};
use turner::integrator::Prepared;
use turner::preview::PreviewPicture;
use turner::render::{PassOptions, Renderer};
use turner::schema::{ErrorCode, PrepareOptions, SceneError};
use turner_cli::failure::{Failure, Labels};
use turner_cli::instructions::instruction_set;
use turner_cli::limits;
use turner_io::image::{DecodeLimits, decode};
use turner_io::scene::{LoadOptions, load};

/// A scene at the size of its preview.
pub(super) struct Scene {
    pub(super) name: String,
    pub(super) prepared: Prepared,
    threads: usize,
}

impl Scene {
    pub(super) fn load(path: &Path, [width, height]: [u32; 2], threads: usize) -> Result<Scene, Failure> {
        let labels = Labels::new();
        let options = LoadOptions {
            threads,
            limits: limits::of_machine(),
            allow_outside: true,
            ..LoadOptions::default()
        };
        let mut loaded = load(path, &options).map_err(|e| Failure::load(e, &labels))?;
        (loaded.desc.film.width, loaded.desc.film.height) = (width, height);
        let options =
            PrepareOptions { threads, instruction_set: instruction_set(), ..PrepareOptions::default() };
        let prepared = loaded.desc.prepare(&options);
        let prepared = prepared.map_err(|e| Failure::in_scene(e, &loaded.sources, &labels))?;
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let folder = path.parent().and_then(Path::file_name).unwrap_or_default().to_string_lossy();
        Ok(Scene { name: format!("{folder}-{stem}"), prepared, threads })
    }

    fn failure(&self, why: &str) -> Failure {
        Failure::new(SceneError::new(ErrorCode::Conflict, format!("{}: {why}", self.name)))
    }

    /// The converged picture: a file, or else rendered and written there.
    pub(super) fn reference(&self, folder: &Path, samples: u32) -> Result<Canvas, Failure> {
        let film = &self.prepared.view.film;
        let path = folder.join(format!("{}-{}x{}.png", self.name, film.width, film.height));
        if !path.exists() {
            let mut prepared = self.prepared.clone();
            (prepared.view.film.samples, prepared.view.film.denoise) = (samples, Denoise::Off);
            let never = AtomicBool::new(false);
            let mut renderer = Renderer::new(prepared).map_err(Failure::new)?;
            let options = PassOptions { threads: self.threads, cancel: &never, progress: None };
            renderer.pass(u32::MAX, &options).map_err(Failure::new)?;
            std::fs::create_dir_all(folder).map_err(|e| self.failure(&e.to_string()))?;
            turner_io::save(&path, &renderer.develop()).map_err(|e| self.failure(&e.to_string()))?;
        }
        let bytes = std::fs::read(&path).map_err(|e| self.failure(&e.to_string()))?;
        let image = decode(&bytes, &path.display().to_string(), &DecodeLimits::default())
            .map_err(|e| self.failure(&e.to_string()))?;
        Ok(Canvas::new(&image, false))
    }

    /// A preview as it is shown.
    fn developed(&self, of: &PreviewPicture) -> Picture {
        let film = &self.prepared.view.film;
        let pixels = of.color.iter().zip(&of.alpha);
        let linear: Vec<[f32; 4]> = pixels.map(|([r, g, b], a)| [*r, *g, *b, *a]).collect();
        let exposure =
            film.exposure + if film.auto_exposure { turner::film::auto_exposure(&linear) } else { 0.0 };
        let has_alpha = of.alpha.iter().any(|a| *a != 1.0);
        let mut picture = Picture {
            width: of.width,
            height: of.height,
            linear,
            display: Vec::new(),
            has_alpha,
            missing: 0,
            exposure,
        };
        picture.display = picture.transform(film).to_8_bits(&picture.linear, self.threads);
        self.prepared.integrator.show(&mut picture);
        picture
    }

    /// Mean FLIP of a preview.
    pub(super) fn flip(
        &self,
        of: &PreviewPicture,
        reference: &Canvas,
        threads: usize,
    ) -> Result<f64, Failure> {
        let picture = self.developed(of);
        let shown = picture.display.iter().map(|pixel| {
            let [r, g, b, a] = pixel.map(|v| f32::from(v) / 255.0);
            [r * a, g * a, b * a, a]
        });
        let canvas = Canvas {
            width: of.width,
            height: of.height,
            pixels: shown.collect(),
            has_alpha: picture.has_alpha || reference.has_alpha,
            is_linear: false,
        };
        let mut reference = reference.clone();
        reference.has_alpha = canvas.has_alpha;
        let pair = Pair::new(canvas, reference).map_err(|e| self.failure(&e.to_string()))?;
        Ok(Metric::Flip.measure(&pair, threads).value)
    }

    /// Writes a preview.
    pub(super) fn save(&self, path: &Path, of: &PreviewPicture) -> Result<(), Failure> {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(|e| self.failure(&e.to_string()))?;
        }
        turner_io::save(path, &self.developed(of)).map_err(|e| self.failure(&e.to_string()))
    }
}

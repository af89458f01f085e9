//! `turner-lab denoise`: the error that denoisers leave, relative to that of the noisy picture, and their time.
//!
//! ```text
//! mod ─┬─ scene  renders a scene; its reference
//!      └─ table  text, JSON, means
//! ```
//!
//! Each scene is rendered at each number of samples and denoised by Turner's denoiser, by its fast mode and, if its
//! library is found, by Open Image Denoise.

mod scene;
mod table;

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use turner::denoise::{Buffers, DenoiseOptions, Denoiser, Rgb, denoise, denoise_fast, left};
use turner_cli::events::Events;
use turner_cli::failure::{FAILED, Failure};
use turner_cli::instructions::instruction_set;
use turner_cli::report::Reporter;
use turner_oidn::Oidn;

use scene::{Reference, Scene};

/// Compare denoisers: the error they leave, and their time
#[derive(Debug, Args)]
#[command(
    after_help = "relMSE is mean((x - r)^2 / (r^2 + 0.01)), minus the reference's own noise, which the difference of its two halves\n\
                  tells. FLIP is the mean over the picture as it is shown. Both are relative to those of the noisy picture. Seconds\n\
                  are for 1280 x 720 pixels, the least of five runs. Open Image Denoise is looked for as for `turner --denoise oidn`."
)]
pub(crate) struct DenoiseArgs {
    /// Scenes and models
    #[arg(required = true, value_name = "FILE")]
    scenes: Vec<PathBuf>,
    /// Samples per pixel
    #[arg(long, value_name = "N", value_delimiter = ',', default_values_t = [4, 8, 32], value_parser = clap::value_parser!(u32).range(2..=4096))]
    samples: Vec<u32>,
    /// Samples per pixel of each half of the reference
    #[arg(long, value_name = "N", default_value_t = 512, value_parser = clap::value_parser!(u32).range(2..=1 << 20))]
    reference: u32,
    /// Width in pixels; the aspect ratio is kept
    #[arg(long, value_name = "PIXELS", default_value_t = 320, value_parser = clap::value_parser!(u32).range(16..=8192))]
    width: u32,
    /// Threads; 0 uses all
    #[arg(short = 'j', long, value_name = "N", default_value_t = 0)]
    threads: usize,
    /// Keep references in this folder, and use those that are there
    #[arg(long, value_name = "FOLDER")]
    references: Option<PathBuf>,
    /// Write the pictures to this folder, as EXR
    #[arg(long, value_name = "FOLDER")]
    save: Option<PathBuf>,
    /// Write one JSON object per line
    #[arg(long)]
    json: bool,
}

/// What a denoiser left of a picture.
struct Left {
    scene: String,
    samples: u32,
    denoiser: String,
    /// Errors of the noisy picture: relMSE and FLIP.
    noisy: [f64; 2],
    /// Errors of the denoised one.
    errors: [f64; 2],
    /// The relative error that 95 % of the pixels do not exceed: as estimated without the reference, and true.
    left: Option<[f64; 2]>,
    /// Seconds for a pixel.
    seconds: f64,
}

/// The name of Turner's denoiser.
const TURNER: &str = "turner";

/// The denoisers by name.
type Denoisers = Vec<(String, Box<dyn Fn(&Buffers) -> Result<Vec<Rgb>, String>>)>;

fn denoisers(threads: usize) -> Denoisers {
    let options = DenoiseOptions { threads, set: instruction_set(), cancel: None };
    let found = |colors: Option<Vec<Rgb>>| colors.ok_or_else(|| "it was cancelled".to_owned());
    let mut all: Denoisers = vec![
        (TURNER.to_owned(), Box::new(move |buffers| found(denoise(buffers, &options)))),
        ("fast".to_owned(), Box::new(move |buffers| found(denoise_fast(buffers, &options)))),
    ];
    if let Ok(oidn) = Oidn::find() {
        all.push(("oidn".to_owned(), Box::new(move |buffers| oidn.denoise(buffers, threads))));
    }
    all
}

pub(crate) fn run(args: &DenoiseArgs) -> u8 {
    let reporter = Reporter { quiet: false, events: args.json.then_some(Events::Stdout) };
    let denoisers = denoisers(args.threads);
    let (mut all, mut failed) = (Vec::new(), false);
    for path in &args.scenes {
        match measure(args, path, &denoisers) {
            Ok(rows) => {
                table::rows(&rows, args.json);
                all.extend(rows);
            }
            Err(failure) => {
                reporter.failure(&failure);
                failed = true;
            }
        }
    }
    if !args.json {
        table::means(&all);
    }
    if failed { FAILED } else { 0 }
}

/// All numbers of samples of one scene.
fn measure(args: &DenoiseArgs, path: &std::path::Path, denoisers: &Denoisers) -> Result<Vec<Left>, Failure> {
    let mut scene = Scene::load(path, args.width, args.threads)?;
    let kept = args.references.as_ref().map(|folder| folder.join(&scene.name));
    let reference = Reference::of(&mut scene, args.reference, kept.as_deref())?;
    let mut rows = Vec::new();
    for samples in args.samples.iter().copied() {
        let renderer = scene.render(samples, 0)?;
        let developed = renderer.developed_as(turner::film::Denoise::Off, args.threads);
        let timed = |of: &dyn Fn() -> Option<Buffers>| {
            let start = Instant::now();
            (of(), start.elapsed().as_secs_f64())
        };
        let (plain, base) = timed(&|| renderer.denoising_buffers(&developed, args.threads));
        let (refined, more) = timed(&|| renderer.refined_buffers(&developed, args.threads));
        let Some((buffers, refined)) = plain.zip(refined) else {
            return Err(scene.failure("its integrator cannot be denoised: it needs \"path\" or \"direct\""));
        };
        let more = (more - base).max(0.0);
        let noisy = buffers.colors(args.threads);
        let before = reference.errors(&scene, &noisy, args.threads);
        let save = |name: &str, pixels: &[Rgb]| match &args.save {
            Some(folder) => scene.save(&folder.join(format!("{}-{samples}-{name}.exr", scene.name)), pixels),
            None => Ok(()),
        };
        save("noisy", &noisy)?;
        save("reference", &reference.pixels)?;
        for (name, denoise) in denoisers {
            let (mut seconds, mut pixels) = (f64::INFINITY, Vec::new());
            // Turner's denoiser alone traces more camera rays.
            let (buffers, earlier) = if name == TURNER { (&refined, more) } else { (&buffers, 0.0) };
            for _ in 0..5 {
                let start = Instant::now();
                pixels = denoise(buffers).map_err(|why| scene.failure(&why))?;
                seconds = seconds.min(earlier + start.elapsed().as_secs_f64());
            }
            save(name, &pixels)?;
            // The fast denoiser does not estimate what it leaves.
            let estimate = match name.as_str() {
                "fast" => None,
                _ => left(buffers, &pixels, args.threads, &|buffers| denoise(buffers).ok()),
            };
            rows.push(Left {
                scene: scene.name.clone(),
                samples,
                denoiser: name.clone(),
                noisy: before,
                errors: reference.errors(&scene, &pixels, args.threads),
                left: estimate.map(|estimate| [estimate, reference.exceeded(&pixels)]),
                seconds: seconds / pixels.len() as f64,
            });
        }
    }
    Ok(rows)
}

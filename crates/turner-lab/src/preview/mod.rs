//! `turner-lab preview`: time and error of the pictures that a window shows.
//!
//! The first frame of a preview, further frames as if the camera moved, and the picture after a while of frames of the same
//! view are compared with a converged picture.

mod scene;

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use clap::Args;
use turner::preview::{Effort, Preview, PreviewOptions};
use turner_cli::events::Events;
use turner_cli::failure::{FAILED, Failure};
use turner_cli::report::Reporter;

use scene::Scene;

/// Measure previews: the time of a frame, and the error of the first picture and of a still one
#[derive(Debug, Args)]
#[command(
    after_help = "Milliseconds are the least and the median of the frames. FLIP is the mean over the picture as it is shown."
)]
pub(crate) struct PreviewArgs {
    /// Scenes and models
    #[arg(required = true, value_name = "FILE")]
    scenes: Vec<PathBuf>,
    /// Columns and rows of the picture
    #[arg(long, value_name = "PIXELS", num_args = 2, default_values_t = [1280, 720], value_parser = clap::value_parser!(u32).range(1..=8192))]
    size: Vec<u32>,
    /// Frames to measure
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=10000))]
    frames: u32,
    /// Seconds for which the picture then stands still
    #[arg(long, value_name = "SECONDS", default_value_t = 1.5)]
    still: f64,
    /// Threads; 0 uses all
    #[arg(short = 'j', long, value_name = "N", default_value_t = 2)]
    threads: usize,
    /// Compare with the PNG files of the scenes' names in this folder; those that are missing are rendered
    #[arg(long, value_name = "FOLDER")]
    references: Option<PathBuf>,
    /// Samples per pixel of references
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=1 << 20))]
    samples: u32,
    /// Write the pictures to this folder, as PNG
    #[arg(long, value_name = "FOLDER")]
    save: Option<PathBuf>,
}

pub(crate) fn run(args: &PreviewArgs) -> u8 {
    let reporter = Reporter { quiet: false, events: None::<Events> };
    let mut failed = false;
    println!(
        "{:24} {:>8} {:>8} {:>8} {:>8}  {:>6} {:>8}",
        "scene", "first", "least", "median", "FLIP", "still", "FLIP"
    );
    for path in &args.scenes {
        if let Err(failure) = measure(args, path) {
            reporter.failure(&failure);
            failed = true;
        }
    }
    if failed { FAILED } else { 0 }
}

fn measure(args: &PreviewArgs, path: &Path) -> Result<(), Failure> {
    let [width, height] = [args.size[0], args.size[1]];
    let scene = Scene::load(path, [width, height], args.threads)?;
    let reference =
        args.references.as_ref().map(|folder| scene.reference(folder, args.samples)).transpose()?;
    let never = AtomicBool::new(false);
    let options = |effort: Effort, frame: u32| PreviewOptions {
        threads: args.threads,
        cancel: &never,
        effort,
        frame,
        size: [width, height],
    };
    let mut preview = Preview::new();
    let mut times = Vec::new();
    let draw = |preview: &mut Preview, effort, frame| {
        let begin = Instant::now();
        preview.frame(&scene.prepared, &options(effort, frame)).map_err(Failure::new)?;
        Ok::<Duration, Failure>(begin.elapsed())
    };
    let first = draw(&mut preview, Effort::Moving, 0)?;
    let moving = preview.picture().clone();
    for frame in 0..args.frames {
        times.push(draw(&mut preview, Effort::Moving, frame)?);
    }
    times.sort();
    draw(&mut preview, Effort::Moving, 0)?;
    let begin = Instant::now();
    let mut frames = 0;
    while begin.elapsed().as_secs_f64() < args.still {
        frames += 1;
        draw(&mut preview, Effort::Still, frames)?;
    }
    let still = preview.picture();
    let error = |picture| match &reference {
        Some(reference) => scene.flip(picture, reference, args.threads).map(|v| format!("{v:.4}")),
        None => Ok("-".to_owned()),
    };
    let ms = |d: Duration| format!("{:.1}", d.as_secs_f64() * 1e3);
    println!(
        "{:24} {:>8} {:>8} {:>8} {:>8}  {:>6} {:>8}",
        scene.name,
        ms(first),
        ms(times[0]),
        ms(times[times.len() / 2]),
        error(&moving)?,
        frames,
        error(still)?
    );
    if let Some(folder) = &args.save {
        scene.save(&folder.join(format!("{}-moving.png", scene.name)), &moving)?;
        scene.save(&folder.join(format!("{}-still.png", scene.name)), still)?;
    }
    Ok(())
}

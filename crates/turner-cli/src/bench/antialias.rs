//! `turner bench antialias`: time and error of every anti-aliasing mode on a scene.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use clap::Args;
use serde_json::json;
use turner::compare::{Canvas, Metric, Pair};
use turner::film::Antialias;
use turner::image::{Image, Pixels};
use turner::render::{PassOptions, Renderer};
use turner::schema::{ErrorCode, PrepareOptions, SceneError};
use turner_io::image::{Display, ImageFormat, OutputFile, OutputImage, Transfer, encode};
use turner_io::scene::{LoadOptions, Override, load};

use super::median;
use crate::failure::{Failure, Labels, two_lines};
use crate::instructions::instruction_set;
use crate::{limits, text};

/// Measure every anti-aliasing mode on a scene: rays, seconds, error
#[derive(Debug, Args)]
#[command(
    after_help = "The error is the RMSE of display values (0 to 1) against the same scene with many random samples of\n\
                        another seed. Seconds are the median of the render time."
)]
pub struct AntialiasBenchArgs {
    /// Scene file
    #[arg(default_value = "scenes/tutorial/step-7.toml")]
    scene: PathBuf,
    /// Width in pixels
    #[arg(long)]
    width: Option<u32>,
    /// Height in pixels
    #[arg(long)]
    height: Option<u32>,
    /// Samples per pixel for grid and monte-carlo
    #[arg(long, default_value_t = 16)]
    samples: u32,
    /// Samples per pixel of the reference
    #[arg(long, value_name = "SAMPLES", default_value_t = 1024)]
    reference: u32,
    /// How often each mode is rendered
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    repeat: u32,
    /// Number of threads [default: all cores]
    #[arg(long, default_value_t = 0, hide_default_value = true)]
    threads: usize,
    /// Write each picture to this folder
    #[arg(long, value_name = "FOLDER")]
    pictures: Option<PathBuf>,
    /// Print a Markdown table
    #[arg(long)]
    markdown: bool,
    /// Print one JSON object per line
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub(super) fn run(args: &AntialiasBenchArgs) -> u8 {
    let bench = || measure(args).map(|measured| measured.print());
    super::reported(args.json, bench())
}

impl AntialiasBenchArgs {
    /// The scene file.
    pub fn scene(&self) -> &Path {
        &self.scene
    }

    /// How often each mode is rendered.
    pub fn repeat(&self) -> u32 {
        self.repeat
    }

    /// Threads to render with, 1 or more.
    pub fn threads(&self) -> usize {
        crate::render::threads(self.threads)
    }

    /// Whether JSON is written instead of text.
    pub fn json(&self) -> bool {
        self.json
    }
}

/// Results of one mode.
struct Row {
    mode: String,
    samples_per_pixel: Option<f64>,
    rays: Option<u64>,
    seconds: f64,
    rmse: f64,
}

/// Results of all modes.
pub struct Measured<'a> {
    args: &'a AntialiasBenchArgs,
    reference: Rendered,
    rows: Vec<Row>,
}

impl Measured<'_> {
    /// Columns and rows of the pictures.
    pub fn size(&self) -> (u32, u32) {
        (self.reference.width, self.reference.height)
    }

    /// Adds a row for one mode of another renderer: the seconds of each run, and its picture in display-encoded values.
    pub fn add(&mut self, mode: &str, seconds: &[f64], picture: &Image) -> Result<(), Failure> {
        let rmse = rmse(&self.reference.values, &unit_values(picture))?;
        let seconds = median(seconds).unwrap_or(f64::NAN);
        self.rows.push(Row { mode: mode.to_owned(), samples_per_pixel: None, rays: None, seconds, rmse });
        Ok(())
    }

    /// Prints the table or the JSON lines.
    pub fn print(&self) {
        let json = self.args.json;
        text::print(&if json { json_lines(self.args, &self.rows) } else { self.table() });
    }
}

/// A rendered picture.
struct Rendered {
    width: u32,
    height: u32,
    display: Vec<[u8; 4]>,
    /// Display values before rounding to 8 bits.
    values: Image,
    rays: u64,
    samples: f64,
    seconds: f64,
}

/// Measures all modes.
pub fn measure(args: &AntialiasBenchArgs) -> Result<Measured<'_>, Failure> {
    if let Some(folder) = &args.pictures {
        std::fs::create_dir_all(folder).map_err(|e| {
            let message = format!("{}: cannot create the folder: {e}", folder.display());
            Failure::new(SceneError::new(ErrorCode::Output, message).help("name a folder that is writable"))
        })?;
    }
    let reference = render(args, Antialias::MonteCarlo, args.reference, 1)?;
    save(args, "reference", &reference)?;
    let mut rows = Vec::new();
    for mode in
        [Antialias::None, Antialias::Mean, Antialias::Grid, Antialias::Adaptive, Antialias::MonteCarlo]
    {
        let mut seconds = Vec::new();
        let mut last = None;
        for _ in 0..args.repeat {
            let rendered = render(args, mode, args.samples, 0)?;
            seconds.push(rendered.seconds);
            last = Some(rendered);
        }
        let Some(rendered) = last else { continue };
        save(args, mode.word(), &rendered)?;
        rows.push(Row {
            mode: mode.word().to_owned(),
            samples_per_pixel: Some(rendered.samples),
            rays: Some(rendered.rays),
            seconds: median(&seconds).unwrap_or(f64::NAN),
            rmse: rmse(&reference.values, &rendered.values)?,
        });
    }
    Ok(Measured { args, reference, rows })
}

/// A picture as RGB values from 0 to 1, without alpha.
fn unit_values(image: &Image) -> Image {
    let n = usize::from(image.channels);
    let colors = if n < 3 { 1 } else { 3 };
    let at = |i: usize| match &image.pixels {
        Pixels::U8(v) => f32::from(v[i]) / 255.0,
        Pixels::U16(v) => f32::from(v[i]) / 65535.0,
        Pixels::F32(v) => v[i].clamp(0.0, 1.0),
    };
    let pixels = image.width as usize * image.height as usize;
    let samples = (0..pixels)
        .flat_map(|p| (0..3).map(move |c| p * n + if colors == 3 { c } else { 0 }))
        .map(at)
        .collect();
    Image { width: image.width, height: image.height, channels: 3, pixels: Pixels::F32(samples) }
}

fn rmse(reference: &Image, picture: &Image) -> Result<f64, Failure> {
    let pair = Pair::new(Canvas::new(reference, false), Canvas::new(picture, false))
        .map_err(|e| Failure::new(SceneError::new(ErrorCode::Image, e.to_string())))?;
    Ok(Metric::Rmse.measure(&pair, 1).value)
}

fn render(
    args: &AntialiasBenchArgs,
    mode: Antialias,
    samples: u32,
    more_seed: u32,
) -> Result<Rendered, Failure> {
    let mut overrides =
        vec![set("film.antialias", format!("\"{}\"", mode.word())), set("film.samples", samples.to_string())];
    overrides.extend(args.width.map(|n| set("film.width", n.to_string())));
    overrides.extend(args.height.map(|n| set("film.height", n.to_string())));
    let loaded =
        load(&args.scene, &LoadOptions { overrides, limits: limits::of_machine(), ..LoadOptions::default() })
            .map_err(|e| Failure::load(e, &Labels::new()))?;
    let (mut desc, sources) = (loaded.desc, loaded.sources);
    desc.film.seed = desc.film.seed.wrapping_add(more_seed);
    let scene = desc
        .prepare(&PrepareOptions { instruction_set: instruction_set(), ..PrepareOptions::default() })
        .map_err(|e| Failure::in_scene(e, &sources, &Labels::new()))?;
    let mut renderer = Renderer::new(scene).map_err(Failure::new)?;
    let never = AtomicBool::new(false);
    let threads = args.threads();
    let options = PassOptions { threads, cancel: &never, progress: None };
    let start = Instant::now();
    renderer.pass(u32::MAX, &options).map_err(Failure::new)?;
    let seconds = start.elapsed().as_secs_f64();
    let picture = renderer.film.develop(&renderer.prepared().view.film, 1);
    let values = picture
        .linear
        .iter()
        .zip(&picture.display)
        .flat_map(|(linear, display)| match renderer.prepared().view.film.transfer {
            // Values without a transfer function are compared before rounding, so that errors below 1/255 count.
            turner::color::Transfer::None => [linear[0], linear[1], linear[2]].map(|v| v.clamp(0.0, 1.0)),
            _ => [display[0], display[1], display[2]].map(|v| f32::from(v) / 255.0),
        })
        .collect();
    Ok(Rendered {
        width: picture.width,
        height: picture.height,
        values: Image {
            width: picture.width,
            height: picture.height,
            channels: 3,
            pixels: Pixels::F32(values),
        },
        display: picture.display,
        rays: renderer.stats.total(),
        samples: renderer.stats.camera as f64 / (f64::from(picture.width) * f64::from(picture.height)),
        seconds,
    })
}

fn set(path: &str, value: String) -> Override {
    Override { path: path.to_owned(), value }
}

fn save(args: &AntialiasBenchArgs, name: &str, picture: &Rendered) -> Result<(), Failure> {
    let Some(folder) = &args.pictures else { return Ok(()) };
    let failed = |text: String| Failure::new(two_lines(ErrorCode::Output, &text));
    let image = OutputImage {
        width: picture.width,
        height: picture.height,
        alpha: false,
        display: Some(Display::U8(&picture.display)),
        transfer: Transfer::Unstated,
        metadata: &Default::default(),
        threads: 1,
        ..OutputImage::default()
    };
    let bytes = encode(&image, ImageFormat::Png).map_err(|e| failed(e.to_string()))?;
    let path: &Path = &folder.join(format!("{name}.png"));
    OutputFile::create(path).and_then(|file| file.commit(&bytes)).map_err(|e| failed(e.to_string()))
}

fn json_lines(args: &AntialiasBenchArgs, rows: &[Row]) -> String {
    let line = |row: &Row| {
        json!({
            "scene": args.scene.to_string_lossy(),
            "mode": row.mode,
            "samples_per_pixel": row.samples_per_pixel,
            "rays": row.rays,
            "median_seconds": row.seconds,
            "rmse": row.rmse,
            "reference_samples": args.reference,
        })
        .to_string()
    };
    rows.iter().map(|row| line(row) + "\n").collect()
}

impl Measured<'_> {
    fn table(&self) -> String {
        let Measured { args, reference, rows } = self;
        let count = |n: Option<u64>| n.map_or(String::new(), |n| text::count(n as f64));
        let samples = |n: Option<f64>| n.map_or(String::new(), |n| format!("{n:.2}"));
        let mut out = format!(
            "{} {}x{}, reference: {} samples per pixel\n\n",
            args.scene.display(),
            reference.width,
            reference.height,
            args.reference
        );
        if args.markdown {
            out += "| mode | samples per pixel | rays | seconds | RMSE |\n|---|--:|--:|--:|--:|\n";
        } else {
            out +=
                &format!("{:18}  {:>8}  {:>9}  {:>9}  {:>8}\n", "mode", "samples", "rays", "seconds", "RMSE");
        }
        for row in rows {
            let (s, r, t) = (samples(row.samples_per_pixel), count(row.rays), text::seconds(row.seconds));
            out += &if args.markdown {
                format!("| {} | {s} | {r} | {t} | {:.5} |\n", row.mode, row.rmse)
            } else {
                format!("{:18}  {s:>8}  {r:>9}  {t:>9}  {:>8.5}\n", row.mode, row.rmse)
            };
        }
        out
    }
}

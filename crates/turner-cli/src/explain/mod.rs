//! `turner explain`: one sample of a pixel, with every vertex of its path.

mod json;
mod text;

use clap::Args;
use turner::color::Spectrum;
use turner::integrator::path::{PathRecord, replay};
use turner::render::sample;
use turner::scene::MaterialId;
use turner::scene::error::{ErrorCode, SceneError, escape};

use crate::events::Events;
use crate::failure::{FAILED, Failure, USAGE};
use crate::report::Reporter;
use crate::scene::{FilmArgs, Ready, SceneArgs};
use crate::text::print;

/// Show the path of one sample: every surface it met, light sampled and found, densities and weights
#[derive(Debug, Args)]
#[command(
    after_help = "The integrators \"path\" and \"direct\" are explained. Give the options that the picture was rendered with: \
                  the sample depends on them."
)]
pub(crate) struct ExplainArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Column and row of the pixel, from 0 at the top left
    #[arg(long, value_name = "X,Y", value_parser = parse_pixel)]
    pixel: (u32, u32),
    /// Which of the pixel's samples, from 0
    #[arg(long, value_name = "N", default_value_t = 0)]
    sample: u32,
    #[command(flatten)]
    film: FilmArgs,
    /// As JSON
    #[arg(long)]
    json: bool,
}

fn parse_pixel(text: &str) -> Result<(u32, u32), String> {
    let numbers =
        text.split_once(',').and_then(|(x, y)| Some((x.trim().parse().ok()?, y.trim().parse().ok()?)));
    numbers.ok_or_else(|| "expected two whole numbers X,Y".to_owned())
}

/// A path and what is said of it.
struct Explained<'a> {
    ready: &'a Ready,
    /// The scene file, as it was given.
    scene: String,
    path: PathRecord,
    /// What the sample gives to the picture.
    rendered: Spectrum,
}

impl Explained<'_> {
    /// The name of a material in the scene file, if it has one.
    fn name(&self, id: MaterialId) -> Option<String> {
        let material = self.ready.desc.materials.get(id.index())?;
        material.name.as_deref().map(escape)
    }

    /// Whether the parts sum to the sample to the last bit.
    fn is_exact(&self) -> bool {
        let bits = |s: Spectrum| s.to_array().map(f32::to_bits);
        bits(self.path.sum()) == bits(self.rendered)
    }
}

/// Runs the command.
pub(crate) fn run(args: &ExplainArgs) -> u8 {
    let reporter = Reporter { quiet: false, events: args.json.then_some(Events::Stdout) };
    explain(args, &reporter).unwrap_or_else(|failure| {
        reporter.failure(&failure);
        failure.exit
    })
}

fn explain(args: &ExplainArgs, reporter: &Reporter) -> Result<u8, Failure> {
    let ready = args.scene.ready(&args.film, args.scene.stage.models(), 0)?;
    let (scene, (x, y)) = (&ready.scene, args.pixel);
    let usage = |e| Failure { exit: USAGE, ..Failure::in_scene(e, &ready.sources, &ready.labels) };
    let path = replay(scene, x, y, args.sample).map_err(usage)?;
    let rendered = sample(scene, x, y, args.sample).map_err(usage)?.color;
    let name = escape(&args.scene.scene.to_string_lossy());
    let explained = Explained { ready: &ready, scene: name, path, rendered };
    if args.json {
        print(&format!("{}\n", json::of(&explained)));
    } else {
        print(&text::of(&explained));
        reporter.warnings(&scene.warnings, &ready.sources, &ready.labels);
    }
    // What is not finite has no sum to speak of.
    if explained.is_exact() || !explained.rendered.is_finite() {
        return Ok(0);
    }
    let error = SceneError::new(ErrorCode::Internal, "the contributions do not sum to the sample");
    reporter.failure(&Failure::new(error.help("this is a bug in Turner: please report it")));
    Ok(FAILED)
}

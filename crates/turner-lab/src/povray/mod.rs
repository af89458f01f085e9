//! `turner-lab povray` and `antialias`: scenes and anti-aliasing modes, compared with POV-Ray in alternating runs.

mod program;

use std::path::{Path, PathBuf};

use clap::Args;
use program::PovRay;
use turner::film::FilmDesc;
use turner::schema::{ErrorCode, SceneError};
use turner_cli::bench::antialias::{AntialiasBenchArgs, measure};
use turner_cli::bench::{Rival, ScenesArgs, measure_scenes, reported};
use turner_cli::failure::{Failure, two_lines};
use turner_io::image::{DecodeLimits, decode};

/// Measure how fast the scenes of a folder render; compare with POV-Ray where a .pov file has the same name
#[derive(Debug, Args)]
#[command(
    after_help = "Seconds are the median over the repetitions, for tracing without loading and saving.\n\
                        POV-Ray's seconds are its `Trace Time`; its runs alternate with Turner's."
)]
pub(crate) struct PovrayArgs {
    #[command(flatten)]
    scenes: ScenesArgs,
    /// The POV-Ray program
    #[arg(long, value_name = "PROGRAM", default_value = "povray")]
    program: PathBuf,
}

/// Measure every anti-aliasing mode on a scene; compare with POV-Ray on the .pov file of the same name
#[derive(Debug, Args)]
#[command(
    after_help = "The error is the root mean square difference of display values (0 to 1) from the same scene with many\n\
                  random samples and other seeds. Seconds are the median for tracing alone. POV-Ray renders without\n\
                  anti-aliasing, with +A0.3, and with 16 samples per pixel."
)]
pub(crate) struct AntialiasArgs {
    #[command(flatten)]
    modes: AntialiasBenchArgs,
    /// The POV-Ray program
    #[arg(long, value_name = "PROGRAM", default_value = "povray")]
    program: PathBuf,
}

/// POV-Ray's modes: label and arguments.
const MODES: [(&str, &[&str]); 3] = [
    ("POV-Ray", &["-A"]),
    ("POV-Ray +A0.3", &["+A0.3"]),
    ("POV-Ray 16 samples", &["+AM1", "+A0.0", "+R4", "-J"]),
];

/// Runs `povray`.
pub(crate) fn run(args: &PovrayArgs) -> u8 {
    let rival = PovRayRival { program: args.program.clone() };
    reported(args.scenes.json(), measure_scenes(&args.scenes, Some(&rival)))
}

/// POV-Ray on the .pov files next to scenes.
struct PovRayRival {
    program: PathBuf,
}

impl Rival for PovRayRival {
    fn name(&self) -> &'static str {
        "POV-Ray"
    }

    fn key(&self) -> &'static str {
        "povray"
    }

    fn trace(&self, path: &Path, film: &FilmDesc, threads: usize) -> Result<Option<f64>, Failure> {
        let Some(povray) = PovRay::for_scene(&self.program, path) else { return Ok(None) };
        povray.trace(film.width, film.height, threads).map(Some)
    }
}

/// Runs `antialias`.
pub(crate) fn run_antialias(args: &AntialiasArgs) -> u8 {
    reported(args.modes.json(), antialias(args))
}

fn antialias(args: &AntialiasArgs) -> Result<(), Failure> {
    let scene = args.modes.scene();
    let Some(povray) = PovRay::for_scene(&args.program, scene) else {
        let message = format!("{}: there is no .pov file next to it", scene.display());
        let help = "scenes/bench has scenes with a .pov file, such as thirty-spheres.toml, from-scratch.toml";
        return Err(Failure::new(SceneError::new(ErrorCode::File, message).help(help)));
    };
    let mut measured = measure(&args.modes)?;
    let (width, height) = measured.size();
    for (name, flags) in MODES {
        let (mut seconds, mut picture) = (Vec::new(), Vec::new());
        for _ in 0..args.modes.repeat() {
            let (time, png) = povray.render(width, height, args.modes.threads(), flags)?;
            seconds.push(time);
            picture = png;
        }
        let picture = decode(&picture, "POV-Ray's image", &DecodeLimits::default())
            .map_err(|e| Failure::new(two_lines(ErrorCode::Image, &e.to_string())))?;
        measured.add(name, &seconds, &picture)?;
    }
    measured.print();
    Ok(())
}

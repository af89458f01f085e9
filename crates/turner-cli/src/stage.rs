//! Options for models: camera, light, floor, background, moment.

use std::path::PathBuf;

use clap::Args;
use turner::scene::stage::Orbit;
use turner_io::scene::{ModelOverrides, Override};

/// How a model is shown. In scenes that say these things themselves the options win.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Models")]
pub(crate) struct StageArgs {
    /// The camera: one that the model brings, by name or number, or orbit:azimuth,elevation[,distance] in degrees right of the front and above, and radii
    #[arg(long, value_name = "NAME|orbit:A,E[,D]", value_parser = parse_camera)]
    camera: Option<String>,
    /// Put a floor under everything
    #[arg(long, conflicts_with = "no_ground")]
    ground: bool,
    /// Leave the floor out
    #[arg(long)]
    no_ground: bool,
    /// What is seen behind everything: transparent, environment, or a colour (a name or #rrggbb)
    #[arg(long, value_name = "WHAT")]
    background: Option<String>,
    /// Light from a picture all around: .hdr or .exr, equirectangular
    #[arg(long, value_name = "FILE")]
    pub(crate) environment: Option<PathBuf>,
    /// Turn the environment about the vertical, degrees
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true)]
    pub(crate) env_rotation: Option<f64>,
    /// Factor of the environment's light
    #[arg(long, value_name = "FACTOR")]
    pub(crate) env_strength: Option<f64>,
    /// Moment of the model's animation, seconds
    #[arg(long, value_name = "SECONDS", conflicts_with = "frame")]
    time: Option<f64>,
    /// Moment of the model's animation, as the number of a frame from 0
    #[arg(long, value_name = "N")]
    frame: Option<u32>,
    /// Frames per second for --frame and --frames
    #[arg(long, value_name = "N", default_value_t = 24.0)]
    fps: f64,
    /// Which animation of the model, by name or number
    #[arg(long, value_name = "NAME")]
    animation: Option<String>,
    /// Which variant of the model's materials, by name or number
    #[arg(long, value_name = "NAME")]
    variant: Option<String>,
    /// Halve pictures until no side is longer
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) max_texture_size: Option<u32>,
}

fn parse_camera(text: &str) -> Result<String, String> {
    match Orbit::parse(text) {
        Some(Err(message)) => Err(message),
        _ => Ok(text.to_owned()),
    }
}

impl StageArgs {
    /// The overrides and how each was written.
    pub(crate) fn overrides(&self) -> Vec<(Override, String)> {
        let mut out = Vec::new();
        let mut set = |path: &str, value: String, label: String| {
            out.push((Override { path: path.to_owned(), value }, label));
        };
        if let Some(camera) = &self.camera {
            set("stage.camera", quoted(camera), format!("--camera {camera}"));
        }
        if self.ground {
            set("stage.ground", "true".into(), "--ground".into());
        }
        if self.no_ground {
            set("stage.ground", "false".into(), "--no-ground".into());
        }
        if let Some(what) = &self.background {
            let label = format!("--background {what}");
            match what.as_str() {
                "transparent" => set("background.transparent", "true".into(), label),
                "environment" => {
                    set("background.transparent", "false".into(), label.clone());
                    set("background.environment", "true".into(), label);
                }
                color => {
                    set("background.transparent", "false".into(), label.clone());
                    set("background.environment", "false".into(), label.clone());
                    set("background.color", quoted(color), label);
                }
            }
        }
        out
    }

    /// What is asked of the models of a scene.
    pub(crate) fn models(&self) -> ModelOverrides {
        let frame = self.frame.map(|n| f64::from(n) / self.fps);
        ModelOverrides {
            time: self.time.or(frame),
            animation: self.animation.clone(),
            variant: self.variant.clone(),
        }
    }

    /// The same at another frame.
    pub(crate) fn at_frame(&self, frame: u32) -> ModelOverrides {
        ModelOverrides { time: Some(f64::from(frame) / self.fps), ..self.models() }
    }

    /// The orbit that was asked for, if one was.
    pub(crate) fn orbit(&self) -> Option<Orbit> {
        Orbit::parse(self.camera.as_deref()?)?.ok()
    }
}

/// As a string of TOML.
fn quoted(text: &str) -> String {
    let escaped: String = text
        .chars()
        .map(|c| match c {
            '"' | '\\' => format!("\\{c}"),
            c if c.is_control() => format!("\\u{:04X}", u32::from(c)),
            c => c.to_string(),
        })
        .collect();
    format!("\"{escaped}\"")
}

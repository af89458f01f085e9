//! Options for models: camera, light, floor, background, moment.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use turner::description::SceneDesc;
use turner::description::default_studio::Orbit;
use turner::light::{EnvironmentDesc, LightDesc};
use turner::schema::{Asset, ErrorCode, ImageId, SceneError};
use turner_io::assets::{AssetSource, FolderAssets};
use turner_io::image::{DecodeLimits, decode};
use turner_io::scene::{LoadOptions, ModelOverrides, Override, hash_with};

use crate::failure::Failure;

/// Most bytes of a picture of the surroundings: 2 GiB.
const MAX_ENVIRONMENT: u64 = 2 << 30;

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
    /// Light from a picture all around: .hdr, .exr or .pfm, equirectangular
    #[arg(long, value_name = "FILE")]
    pub(crate) environment: Option<PathBuf>,
    /// Turn the environment about the vertical, degrees
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, value_parser = parse_finite)]
    pub(crate) env_rotation: Option<f64>,
    /// Factor of the environment's light
    #[arg(long, value_name = "FACTOR", value_parser = parse_factor)]
    pub(crate) env_strength: Option<f64>,
    /// Moment of the model's animation, seconds
    #[arg(long, value_name = "SECONDS", conflicts_with = "frame", allow_negative_numbers = true, value_parser = parse_finite)]
    time: Option<f64>,
    /// Moment of the model's animation, as the number of a frame from 0
    #[arg(long, value_name = "N")]
    frame: Option<u32>,
    /// Frames per second for --frame and --frames
    #[arg(long, value_name = "N", default_value_t = 24.0, value_parser = parse_rate)]
    fps: f64,
    /// Which animation of the model, by name or number
    #[arg(long, value_name = "NAME")]
    animation: Option<String>,
    /// Which variant of the model's materials, by name or number
    #[arg(long, value_name = "NAME")]
    variant: Option<String>,
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
            set("studio.camera", quoted(camera), format!("--camera {camera}"));
        }
        if self.ground {
            set("studio.ground", "true".into(), "--ground".into());
        }
        if self.no_ground {
            set("studio.ground", "false".into(), "--no-ground".into());
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

impl StageArgs {
    /// Puts the environment that was asked for around the scene.
    pub(crate) fn surround(
        &self,
        desc: &mut SceneDesc,
        hash: &mut String,
        options: &LoadOptions,
    ) -> Result<(), Failure> {
        if let Some(path) = &self.environment {
            let bytes = read(path)?;
            let name = path.to_string_lossy();
            let limits = DecodeLimits::of_scene(&options.limits, options.max_texture_size, 1);
            let image = decode(&bytes, &name, &limits).map_err(|e| Failure::new(e.to_scene_error()))?;
            *hash = hash_with(hash, &bytes);
            desc.images.push(Asset { uri: name.into_owned(), data: Arc::new(image) });
            let file = Some(ImageId(desc.images.len() as u32 - 1));
            let environment = EnvironmentDesc { file, ..EnvironmentDesc::studio() };
            desc.lights.retain(|l| !matches!(l.value, LightDesc::Environment(_) | LightDesc::Sky(_)));
            desc.lights.push(LightDesc::Environment(environment).into());
        }
        let environments = desc.lights.iter_mut().filter_map(|l| match &mut l.value {
            LightDesc::Environment(environment) => {
                Some((&mut environment.rotation, &mut environment.strength))
            }
            _ => None,
        });
        let studio = desc.studio.iter_mut().map(|s| (&mut s.rotation, &mut s.strength));
        for (rotation, strength) in environments.chain(studio) {
            *rotation = self.env_rotation.unwrap_or(*rotation);
            *strength = self.env_strength.unwrap_or(*strength);
        }
        for light in &mut desc.lights {
            if let LightDesc::Sky(sky) = &mut light.value {
                sky.turn(self.env_rotation.unwrap_or(0.0));
                sky.strength = self.env_strength.unwrap_or(sky.strength);
            }
        }
        if self.env_rotation.is_some() || self.env_strength.is_some() {
            *hash = hash_with(hash, format!("{:?} {:?}", self.env_rotation, self.env_strength).as_bytes());
        }
        Ok(())
    }
}

/// A file that the user named, wherever it is.
fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    let failed = |e: turner_io::assets::AssetError| Failure::new(e.to_scene_error());
    let folder = FolderAssets::new(path.parent().unwrap_or(Path::new(""))).map_err(failed)?;
    let Some(file) = path.file_name().and_then(|n| n.to_str()) else {
        let message = format!("{}: expected the name of a file", path.display());
        return Err(Failure::new(SceneError::new(ErrorCode::File, message)));
    };
    folder.allow_outside(true).read(file, MAX_ENVIRONMENT).map_err(failed)
}

/// A factor that light can have.
fn parse_factor(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if v.is_finite() && v >= 0.0 => Ok(v),
        _ => Err("expected a number, 0 or more".to_owned()),
    }
}

/// Degrees or seconds.
fn parse_finite(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if v.is_finite() => Ok(v),
        _ => Err("expected a finite number".to_owned()),
    }
}

/// A rate of frames.
fn parse_rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if v.is_finite() && v > 0.0 => Ok(v),
        _ => Err("expected a number above 0".to_owned()),
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

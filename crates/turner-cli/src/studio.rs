//! Options for camera, environment map, floor, background and animation time.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use turner::description::default_studio::Orbit;
use turner::description::framing::F_STOP;
use turner::description::{SceneDesc, StudioDesc};
use turner::light::{EnvironmentDesc, LightDesc};
use turner::schema::{Asset, ErrorCode, ImageId, SceneError};
use turner_io::assets::{AssetSource, FolderAssets};
use turner_io::image::{DecodeLimits, decode};
use turner_io::scene::{LoadOptions, ModelOverrides, Override};

use crate::failure::Failure;
use crate::scene::Hashes;

/// Largest environment map file: 2 GiB.
const MAX_ENVIRONMENT: u64 = 2 << 30;

/// How a model is shown. Options override the scene file.
#[derive(Debug, Default, Args)]
pub(crate) struct StudioArgs {
    /// Camera of the model by name or index, or orbit:AZIMUTH,ELEVATION[,DISTANCE] in degrees and scene radii
    #[arg(long, value_name = "NAME|orbit:A,E[,D]", value_parser = parse_camera)]
    camera: Option<String>,
    /// Field of view along the shorter side of the picture, degrees; an orbit camera moves to keep the framing
    #[arg(long, value_name = "DEGREES", value_parser = parse_angle)]
    fov: Option<f64>,
    /// Enlarge the picture about its middle: 2 shows everything twice as large
    #[arg(long, value_name = "FACTOR", value_parser = parse_positive)]
    zoom: Option<f64>,
    /// Name of an object that an orbit camera frames
    #[arg(long, value_name = "NAME")]
    look_at: Option<String>,
    /// Depth of field: f-number of the lens, as if the model were 30 cm large
    #[arg(long, value_name = "N", value_parser = parse_positive)]
    fstop: Option<f64>,
    /// Depth of field: distance of the plane of focus, or `object` for the middle of the model
    #[arg(long, value_name = "DISTANCE|object", value_parser = parse_focus)]
    focus: Option<Focus>,
    /// Add a floor below the scene
    #[arg(long, conflicts_with = "no_ground")]
    ground: bool,
    /// Add no floor
    #[arg(long)]
    no_ground: bool,
    /// Background: transparent, environment, or a colour (a name or #rrggbb), which a model in the studio shows exactly
    #[arg(long, value_name = "WHAT")]
    background: Option<String>,
    /// Light the scene with an equirectangular environment map: .hdr, .exr or .pfm
    #[arg(long, value_name = "FILE")]
    pub(crate) environment: Option<PathBuf>,
    /// Rotate the environment map about the vertical axis, degrees
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, value_parser = parse_finite)]
    pub(crate) env_rotation: Option<f64>,
    /// Scale the radiance of the environment map
    #[arg(long, value_name = "FACTOR", value_parser = parse_factor)]
    pub(crate) env_strength: Option<f64>,
    /// Time in the animation, seconds
    #[arg(long, value_name = "SECONDS", conflicts_with = "frame", allow_negative_numbers = true, value_parser = parse_finite)]
    time: Option<f64>,
    /// Time in the animation, as a frame number from 0
    #[arg(long, value_name = "N")]
    frame: Option<u32>,
    /// Frames per second for --frame and --frames, and of animation files
    #[arg(long, value_name = "N", default_value_t = 24.0, value_parser = parse_rate)]
    fps: f64,
    /// Blur what the animation moves while the shutter is open: this part of a frame; 0.5 is that of a film camera
    #[arg(long, value_name = "FRAMES", value_parser = parse_shutter)]
    motion_blur: Option<f64>,
    /// Animation of the model, by name or index; none is the pose without animation
    #[arg(long, value_name = "NAME")]
    animation: Option<String>,
    /// Material variant of the model, by name or index
    #[arg(long, value_name = "NAME")]
    variant: Option<String>,
}

/// The plane of focus.
#[derive(Clone, Copy, Debug)]
enum Focus {
    Object,
    Distance(f64),
}

fn parse_focus(text: &str) -> Result<Focus, String> {
    match text {
        "object" => Ok(Focus::Object),
        _ => parse_positive(text).map(Focus::Distance).map_err(|e| format!("{e}, or `object`")),
    }
}

fn parse_camera(text: &str) -> Result<String, String> {
    match Orbit::parse(text) {
        Some(Err(message)) => Err(message),
        _ => Ok(text.to_owned()),
    }
}

impl StudioArgs {
    /// The overrides, each with the option as given.
    pub(crate) fn overrides(&self) -> Vec<(Override, String)> {
        let mut out = Vec::new();
        let mut set = |path: &str, value: String, label: String| {
            out.push((Override { path: path.to_owned(), value }, label));
        };
        if let Some(camera) = &self.camera {
            set("studio.camera", quoted(camera), format!("--camera {camera}"));
        }
        if let Some(open) = self.motion_blur {
            let label = format!("--motion-blur {open}");
            set("film.motion_blur", "true".into(), label.clone());
            set("film.shutter", format!("[0, {open:?}]"), label);
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

    /// Animation time and variants for the models of the scene.
    pub(crate) fn models(&self) -> ModelOverrides {
        let frame = self.frame.map(|n| f64::from(n) / self.fps);
        ModelOverrides {
            time: self.time.or(frame),
            frame: Some(1.0 / self.fps),
            animation: self.animation.clone(),
            variant: self.variant.clone(),
        }
    }

    /// Frames per second.
    pub(crate) fn rate(&self) -> f64 {
        self.fps
    }

    /// The time of a frame, seconds.
    pub(crate) fn time_of(&self, frame: u32) -> f64 {
        f64::from(frame) / self.fps
    }

    /// The same for a given frame.
    pub(crate) fn at_frame(&self, frame: u32) -> ModelOverrides {
        ModelOverrides { time: Some(self.time_of(frame)), ..self.models() }
    }

    /// The orbit of `--camera`, if it is one.
    pub(crate) fn orbit(&self) -> Option<Orbit> {
        Orbit::parse(self.camera.as_deref()?)?.ok()
    }
}

impl StudioArgs {
    /// Applies `--fov`, `--zoom`, `--look-at`, `--fstop` and `--focus` to the camera of the scene, whichever it is.
    pub(crate) fn apply_camera(&self, desc: &mut SceneDesc, hash: &mut Hashes) {
        let StudioArgs { fov, zoom, look_at, fstop, focus, .. } = self;
        if fov.is_none() && zoom.is_none() && look_at.is_none() && fstop.is_none() && focus.is_none() {
            return;
        }
        hash.add(format!("{fov:?} {zoom:?} {look_at:?} {fstop:?} {focus:?}").as_bytes());
        let nothing = StudioDesc { ground: Some(false), lights: false, ..StudioDesc::default() };
        let studio = desc.studio.get_or_insert(nothing);
        studio.fov = fov.or(studio.fov);
        studio.zoom = zoom.unwrap_or(studio.zoom);
        studio.f_stop = fstop.or(studio.f_stop);
        if look_at.is_some() {
            studio.look_at = look_at.clone();
        }
        match focus {
            Some(Focus::Distance(distance)) => studio.focus = Some(*distance),
            Some(Focus::Object) => {
                studio.focus = None;
                studio.f_stop = studio.f_stop.or(Some(F_STOP));
            }
            None => {}
        }
    }

    /// Sets the backdrop of a scene with `[studio]`: `--background` and `--environment` replace the studio's own.
    pub(crate) fn apply_backdrop(&self, desc: &mut SceneDesc) {
        let Some(studio) = &mut desc.studio else { return };
        match self.background.as_deref() {
            Some("environment") => studio.backdrop = None,
            Some("transparent") => {}
            Some(_) => studio.backdrop = Some(desc.background.color),
            None if self.environment.is_some() => studio.backdrop = None,
            None => {}
        }
    }

    /// Replaces the environment lights of the scene by the environment map of `--environment`, and applies
    /// `--env-rotation` and `--env-strength`.
    pub(crate) fn apply_environment(
        &self,
        desc: &mut SceneDesc,
        hash: &mut Hashes,
        options: &LoadOptions,
    ) -> Result<(), Failure> {
        if let Some(path) = &self.environment {
            let bytes = read(path)?;
            let name = path.to_string_lossy();
            let limits = DecodeLimits::of_scene(&options.limits, options.max_texture_size, 1);
            let image = decode(&bytes, &name, &limits).map_err(|e| Failure::new(e.to_scene_error()))?;
            hash.add(&bytes);
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
            hash.add(format!("{:?} {:?}", self.env_rotation, self.env_strength).as_bytes());
        }
        Ok(())
    }
}

/// Reads a file that the user named; it may lie anywhere.
fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    let failed = |e: turner_io::assets::AssetError| Failure::new(e.to_scene_error());
    let folder = FolderAssets::new(path.parent().unwrap_or(Path::new(""))).map_err(failed)?;
    let Some(file) = path.file_name().and_then(|n| n.to_str()) else {
        let message = format!("{}: expected the name of a file", path.display());
        return Err(Failure::new(SceneError::new(ErrorCode::File, message)));
    };
    folder.allow_outside(true).read(file, MAX_ENVIRONMENT).map_err(failed)
}

/// A finite factor, 0 or more.
fn parse_factor(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if v.is_finite() && v >= 0.0 => Ok(v),
        _ => Err("expected a number, 0 or more".to_owned()),
    }
}

/// A finite number above 0.
fn parse_positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if v.is_finite() && v > 0.0 => Ok(v),
        _ => Err("expected a number above 0".to_owned()),
    }
}

/// A field of view, degrees.
fn parse_angle(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if v > 0.0 && v < 180.0 => Ok(v),
        _ => Err("expected an angle between 0 and 180 degrees".to_owned()),
    }
}

/// A part of a frame.
fn parse_shutter(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if (0.0..=1.0).contains(&v) => Ok(v),
        _ => Err("expected a number from 0 to 1".to_owned()),
    }
}

/// A finite number.
fn parse_finite(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if v.is_finite() => Ok(v),
        _ => Err("expected a finite number".to_owned()),
    }
}

/// Frames per second.
fn parse_rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if v.is_finite() && v > 0.0 => Ok(v),
        _ => Err("expected a number above 0".to_owned()),
    }
}

/// As a TOML string.
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

//! `turner convert`: writes a scene in another format.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use serde_json::json;
use turner::description::default_studio::Orbit;
use turner::description::{SceneDesc, StudioDesc};
use turner::integrator::Prepared;
use turner::light::{EnvironmentDesc, LightDesc};
use turner::schema::error::nearest;
use turner::schema::{ErrorCode, SceneError, WarningKind};
use turner_io::convert::{ConvertOptions, Converted, to_glb, to_toml};
use turner_io::image::KeptPictures;

use crate::control::Control;
use crate::events::Events;
use crate::failure::Failure;
use crate::report::{Reporter, strict};
use crate::scene::{FilmArgs, SceneArgs};
use crate::text;

/// Convert a scene or model to an editable TOML scene or to a glTF model
///
/// A .toml keeps everything and renders to the same picture; meshes become PLY files in NAME-meshes, textures files in
/// NAME-pictures, IES profiles, grids and fonts files in NAME-data. A .glb is one file with what glTF 2.0 can represent;
/// warnings name the rest.
#[derive(Debug, Args)]
pub(crate) struct ConvertArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Output file: .toml or .glb
    #[arg(value_name = "OUT")]
    out: PathBuf,
    /// Overwrite existing files
    #[arg(long)]
    force: bool,
    /// Treat warnings about ignored features as errors
    #[arg(long)]
    strict: bool,
    /// Print events as JSON lines: `turner help json`
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    film: FilmArgs,
}

/// Output formats.
#[derive(Clone, Copy)]
enum Target {
    Toml,
    Glb,
}

/// Runs the command.
pub(crate) fn run(args: &ConvertArgs, control: &Control) -> u8 {
    let reporter = Reporter { quiet: false, events: args.json.then_some(Events::Stdout) };
    control.hear(&reporter);
    match convert(args, &reporter, control) {
        Ok(()) => 0,
        Err(failure) => {
            reporter.failure(&failure);
            failure.exit
        }
    }
}

fn convert(args: &ConvertArgs, reporter: &Reporter, control: &Control) -> Result<(), Failure> {
    let start = Instant::now();
    let target = target(&args.out)?;
    if let (Ok(from), Ok(to)) = (args.scene.scene.canonicalize(), args.out.canonicalize())
        && from == to
    {
        let message = format!("{}: the scene is read from this file", args.out.display());
        return Err(Failure::usage(
            SceneError::new(ErrorCode::Output, message).help("name another output file"),
        ));
    }
    let pictures = KeptPictures::default();
    let limits = args.scene.watched_limits(control);
    let mut described =
        args.scene.described(&args.film, args.scene.studio.models(), 0, Some(pictures.clone()), &limits)?;
    let is_import = args.scene.scene.extension().is_none_or(|e| !e.eq_ignore_ascii_case("toml"));
    if is_import && matches!(target, Target::Toml) {
        let prepared = adds_parts(&described.desc).then(|| described.prepare(&limits)).transpose()?;
        settle(&mut described.desc, prepared.as_ref());
    }
    let (desc, sources, labels) = (&described.desc, &described.sources, &described.labels);
    reporter.imports(&desc.imports);
    reporter.warnings(&desc.warnings, sources, labels);
    if args.strict && desc.warnings.iter().any(|w| w.kind == WarningKind::Ignored) {
        return Err(strict(&desc.warnings, sources, labels));
    }
    let name = args.scene.scene.file_name().unwrap_or(args.scene.scene.as_os_str()).to_string_lossy();
    let source = if name == "-" { "standard input".to_owned() } else { name.into_owned() };
    let options = ConvertOptions { source, overwrite: args.force, strict: args.strict, pictures };
    let converted = match target {
        Target::Toml => to_toml(desc, &args.out, &options),
        Target::Glb => to_glb(desc, &args.out, &options),
    };
    let converted = converted.map_err(|e| Failure::in_scene(e, sources, labels))?;
    reporter.warnings(&converted.warnings, sources, labels);
    done(&converted, &args.out, start.elapsed().as_secs_f64(), reporter);
    Ok(())
}

/// Whether the studio of an imported file adds lights or a floor, so that [`settle`] needs the prepared scene.
pub fn adds_parts(desc: &SceneDesc) -> bool {
    desc.studio.as_ref().is_some_and(|studio| studio.lights || studio.ground != Some(false))
}

/// Makes the description of an imported file one that a person would write. `prepared` is the scene prepared from it; it
/// is needed if [`adds_parts`].
pub fn settle(desc: &mut SceneDesc, prepared: Option<&Prepared>) {
    if let Some(prepared) = prepared {
        write_out(desc, prepared);
    }
    simplify(desc);
}

/// Replaces what the studio would add to a model by what it added: the camera, the light and its exposure, as a person
/// would write them. The floor and the backdrop stay with the studio.
fn write_out(desc: &mut SceneDesc, prepared: &Prepared) {
    let Some(studio) = &mut desc.studio else { return };
    let own = if studio.camera.is_some() { None } else { desc.camera.as_ref().or(desc.cameras.first()) };
    let orbit = match &studio.camera {
        Some(camera) => Orbit::parse(camera).and_then(Result::ok),
        None => own.is_none().then_some(Orbit::DEFAULT),
    };
    if desc.camera.is_none() && desc.cameras.is_empty() || orbit.is_some() {
        studio.ground = studio.ground.or(Some(own.is_none() && !desc.background.transparent));
        desc.camera = Some(prepared.view.camera_desc.clone().into());
    }
    studio.ground = studio.ground.or(Some(false));
    if orbit.is_some() {
        let lens = StudioDesc::default();
        (studio.camera, studio.look_at) = (None, None);
        (studio.fov, studio.zoom) = (lens.fov, lens.zoom);
        (studio.f_stop, studio.focus) = (lens.f_stop, lens.focus);
    }
    let is_studio = |i: usize| prepared.scene.light_sources.get(i).is_some_and(Option::is_none);
    if studio.lights && (0..prepared.scene.lights.len()).any(is_studio) {
        desc.lights.push(
            LightDesc::Environment(EnvironmentDesc {
                strength: studio.strength,
                rotation: studio.rotation + orbit.map_or(0.0, |orbit| orbit.azimuth),
                ..EnvironmentDesc::studio()
            })
            .into(),
        );
        (studio.strength, studio.rotation) = (1.0, 0.0);
    }
    studio.lights = false;
    studio.metering = false;
    desc.film.exposure = prepared.view.film.exposure;
}

/// Omits what an import adds to a description without an effect on the picture: a `[[view]]` that is the camera itself,
/// and a `[studio]` that adds neither camera nor light nor floor.
fn simplify(desc: &mut SceneDesc) {
    let names_camera = desc.studio.as_ref().is_some_and(|s| s.camera.is_some());
    if let ([only], false) = (&desc.cameras[..], names_camera) {
        let is_used = desc.studio.is_some() && desc.camera.is_none();
        if is_used || desc.camera.as_ref().is_some_and(|c| c.value == only.value) {
            desc.camera = desc.cameras.pop();
        }
    }
    let has_light = desc.lights.iter().any(|l| !matches!(l.value, LightDesc::Ambient(_)));
    let adds_nothing = |s: &StudioDesc| {
        let no_floor = s.ground.is_none_or(|ground| !ground);
        let no_lens = s.fov.is_none() && s.zoom == 1.0 && s.f_stop.is_none() && s.focus.is_none();
        let no_backdrop = s.backdrop.is_none() && !s.metering;
        s.camera.is_none()
            && desc.camera.is_some()
            && no_floor
            && (has_light || !s.lights)
            && no_lens
            && no_backdrop
    };
    if desc.studio.as_ref().is_some_and(adds_nothing) {
        desc.studio = None;
    }
}

fn target(out: &Path) -> Result<Target, Failure> {
    let extension = out.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    match extension.as_str() {
        "toml" => Ok(Target::Toml),
        "glb" => Ok(Target::Glb),
        other => {
            let message = format!("{}: expected a .toml or .glb file", out.display());
            let near = nearest(other, &["toml", "glb"]);
            let help =
                near.map_or("use the extension .toml or .glb".into(), |n| format!("did you mean .{n}?"));
            Err(Failure::usage(SceneError::new(ErrorCode::Output, message).help(help)))
        }
    }
}

/// Reports the output files.
fn done(converted: &Converted, out: &Path, seconds: f64, reporter: &Reporter) {
    let bytes: u64 = converted.files.iter().map(|f| f.bytes).sum();
    if let Some(events) = &reporter.events {
        let file = |f: &turner_io::convert::WrittenFile| json!({ "file": f.path, "bytes": f.bytes });
        events.send(json!({
            "event": "converted",
            "output": out,
            "files": converted.files.iter().map(file).collect::<Vec<_>>(),
            "seconds": seconds,
            "version": env!("CARGO_PKG_VERSION"),
        }));
        return;
    }
    let others = converted.files.len() as u64 - 1;
    let more =
        if others == 0 { String::new() } else { format!(" and {}", text::plural(others, "other file")) };
    reporter.line(&format!(
        "{}{more} written: {} in {}",
        out.display(),
        text::bytes(bytes),
        text::seconds(seconds)
    ));
}

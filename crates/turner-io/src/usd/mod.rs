//! Universal Scene Description: text (`.usda`) and binary (`.usdc`, `.usd`) layers and packages (`.usdz`).
//!
//! ```text
//! bytes ── package ──> layers ── text, binary ──> specs ── stage ──> composed prims ┐
//!                                                                                   ├── scene ── meshes, shapes, curves ──> objects
//!                                                                                   ├── instances ──> groups
//!                                                                                   └── network, materials, lights, cameras
//! ```
//!
//! [`stage`] knows paths, arcs and values, but no schemas; the other modules give prims a meaning. The scene has metres
//! as its unit and +y as its vertical axis.
//!
//! The formats are described at openusd.org: "USDA File Format", "UsdGeom", "UsdLux", "UsdPreviewSurface Specification",
//! "USDZ File Format Specification". Hostile files are safe to open: counts are compared with the bytes that are there
//! before anything is allocated, nesting is bounded, and references that multiply end at a limit.

mod binary;
mod cameras;
mod curves;
mod files;
mod instances;
mod layer;
mod lights;
mod materials;
mod meshes;
mod network;
mod package;
mod paths;
mod primvars;
mod scene;
mod shapes;
mod stage;
mod subdivision;
#[cfg(test)]
mod tests;
mod text;
mod transforms;
mod value;

use turner::description::{ImportSummary, SceneDesc};
use turner::math::{DAffine3, DMat3, DVec3};
use turner::schema::{ErrorCode, SceneError, WarningKind};

use files::Files;
use scene::Scene;
use stage::Stage;
use value::{Broken, Read, Value};

use crate::assets::{AssetSource, printable};
use crate::import::ImportOptions;
use crate::scene_import::CommonParts;

/// Whether bytes are a layer, by its first bytes.
pub(crate) fn is_usd(bytes: &[u8]) -> bool {
    bytes.starts_with(binary::MAGIC) || bytes.starts_with(b"#usda ")
}

/// Reads a stage as a scene with exactly what it contains: objects, materials, lights and cameras. `uri` is the file's
/// name relative to the root of `assets`, from which the files that it names are read.
pub(crate) fn import(
    bytes: Vec<u8>,
    uri: &str,
    assets: &dyn AssetSource,
    options: &ImportOptions,
) -> Result<SceneDesc, SceneError> {
    let needed = 2 * bytes.len() as u64;
    options.limits.memory.need(needed, || printable(uri))?;
    let files = Files::new(assets);
    let (name, bytes) = if bytes.starts_with(package::MAGIC) {
        let damaged = |problem| broken(uri, &Broken::new(problem));
        files.add_package(uri, bytes).map_err(damaged)?
    } else {
        (uri.to_owned(), bytes)
    };
    let mut stage = Stage::open(&files, &name, bytes).map_err(|e| broken(&name, &e))?;
    let settings = Settings::of(&stage).map_err(|e| broken(&name, &e))?;
    stage.time = settings.start + options.time * settings.codes_per_second;
    let base = uri.rsplit(['/', '\\']).next().unwrap_or(uri);
    let mut stock = CommonParts::new(&files, base, options);
    stock.files.push(printable(uri));
    let mut scene = Scene::new(&stage, stock, settings.unit);
    let filled = scene.fill(settings.to_scene());
    filled.map_err(|fault| fault.into_error(&[printable(uri)]))?;
    finish(scene, uri, options)
}

/// The error for a layer that cannot be read.
fn broken(name: &str, broken: &Broken) -> SceneError {
    let name = printable(name);
    let message = match broken.line {
        0 => format!("{name}: {}", broken.problem),
        line => format!("{name}:{line}:{}: {}", broken.column, broken.problem),
    };
    SceneError::new(ErrorCode::Model, message)
        .help("check that the file opens in another program, such as usdview, and export it again")
}

/// What the root layer says about the whole stage.
struct Settings {
    is_z_up: bool,
    /// Metres per unit.
    unit: f64,
    start: f64,
    codes_per_second: f64,
}

impl Settings {
    fn of(stage: &Stage<'_>) -> Read<Settings> {
        let number = |name| Ok(stage.metadata(name)?.as_ref().and_then(Value::real));
        let positive = |v: Option<f64>, or: f64| v.filter(|v| *v > 0.0 && v.is_finite()).unwrap_or(or);
        let axis = stage.metadata("upAxis")?;
        let per_second = match number("timeCodesPerSecond")? {
            None => number("framesPerSecond")?,
            some => some,
        };
        Ok(Settings {
            is_z_up: axis.as_ref().and_then(Value::text) == Some("Z"),
            unit: positive(number("metersPerUnit")?, 0.01),
            start: number("startTimeCode")?.filter(|v| v.is_finite()).unwrap_or(0.0),
            codes_per_second: positive(per_second, 24.0),
        })
    }

    /// From the space of the stage to that of the scene.
    fn to_scene(&self) -> DAffine3 {
        let turned = match self.is_z_up {
            true => DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y),
            false => DMat3::IDENTITY,
        };
        DAffine3 { matrix3: turned * self.unit, translation: DVec3::ZERO }
    }
}

fn finish(scene: Scene<'_>, uri: &str, options: &ImportOptions) -> Result<SceneDesc, SceneError> {
    let Scene { stage, mut stock, materials, cameras, counts, .. } = scene;
    for problem in stage.problems() {
        stock.report.ignored_anywhere(problem);
    }
    let count = |n: usize| n as u64;
    let triangles = stock.meshes.iter().map(|m| count(m.data.triangles.len())).sum();
    options.limits.check_triangles(triangles, || printable(uri))?;
    let counts = vec![
        ("layers", count(stage.layer_count())),
        ("prims", counts.prims),
        ("meshes", counts.meshes),
        ("triangles", triangles),
        ("materials", count(materials.len())),
        ("textures", count(stock.texture_list.len())),
        ("images", count(stock.images.len())),
        ("lights", counts.lights),
        ("cameras", count(cameras.len())),
        ("animations", u64::from(stage.is_animated())),
        ("instances", counts.instances),
    ];
    if stock.objects.is_empty() {
        let warning = turner::schema::Warning::new(WarningKind::Doubtful, "the file contains no geometry");
        stock.report.remark(warning);
    }
    let summary = ImportSummary { file: printable(uri), format: "USD", counts, names: Vec::new() };
    Ok(SceneDesc {
        camera: cameras.first().cloned(),
        textures: stock.texture_list,
        materials,
        groups: stock.groups,
        objects: stock.objects,
        lights: stock.lights,
        images: stock.images,
        meshes: stock.meshes,
        cameras,
        imports: vec![summary],
        warnings: stock.report.into_warnings(&stock.files),
        ..SceneDesc::default()
    })
}

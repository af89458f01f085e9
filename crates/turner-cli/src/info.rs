//! `turner info`: contents, names, memory and bounds of a scene.

use std::collections::BTreeMap;

use clap::Args;
use serde_json::{Value, json};
use turner::camera::{CameraDesc, PinholeDesc};
use turner::color::Tonemap;
use turner::description::{ImportSummary, ObjectContent, ObjectDesc, SceneDesc};
use turner::film::FilmDesc;

use crate::control::Control;
use crate::events::Events;
use crate::report::{Reporter, summed};
use crate::scene::{FilmArgs, Ready, SceneArgs};
use crate::text;

/// Show the contents of a scene, its names, memory and bounds, without rendering it
#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub(crate) fn run(args: &InfoArgs, control: &Control) -> u8 {
    let reporter = Reporter { quiet: false, events: args.json.then_some(Events::Stdout) };
    control.hear(&reporter);
    match args.scene.ready(&FilmArgs::default(), args.scene.studio.models(), 0, control) {
        Ok(ready) if args.json => {
            text::print(&format!("{}\n", as_json(&ready)));
            0
        }
        Ok(ready) => {
            text::print(&as_text(&ready));
            reporter.warnings(&ready.prepared.warnings, &ready.sources, &ready.labels);
            0
        }
        Err(failure) => {
            reporter.failure(&failure);
            failure.exit
        }
    }
}

/// Number of entries by name.
type Counts = BTreeMap<&'static str, u64>;

fn count(names: impl Iterator<Item = &'static str>) -> Counts {
    let mut counts = Counts::new();
    names.for_each(|name| *counts.entry(name).or_default() += 1);
    counts
}

fn shapes(desc: &SceneDesc) -> Counts {
    let in_groups = desc.groups.iter().flat_map(|g| &g.value.objects);
    count(desc.objects.iter().chain(in_groups).map(|o: &ObjectDesc| match &o.content {
        ObjectContent::Shape(shape) => shape.type_name(),
        ObjectContent::Instance(_) => "instance",
    }))
}

fn camera(desc: &SceneDesc) -> &'static str {
    desc.camera.as_ref().map_or("none", |c| c.value.type_name())
}

/// Memory by use, bytes.
fn memory(ready: &Ready) -> [(&'static str, u64); 5] {
    let s = &ready.prepared.scene.stats;
    [
        ("tree", s.tree_bytes),
        ("meshes", s.mesh_bytes),
        ("textures", s.texture_bytes),
        ("film", ready.prepared.view.film_bytes()),
        ("lights", ready.prepared.scene.emitters.tree_bytes() as u64),
    ]
}

fn as_json(ready: &Ready) -> Value {
    let (desc, scene, view) = (&ready.desc, &ready.prepared.scene, &ready.prepared.view);
    let warnings: Vec<Value> = summed(&ready.prepared.warnings)
        .iter()
        .map(|w| {
            let at = w.span.and_then(|span| ready.sources.locate(span));
            json!({
                "kind": w.kind.word(),
                "message": crate::flags::message(w),
                "count": w.count,
                "file": at.as_ref().map(|at| at.file),
                "line": at.as_ref().map(|at| at.line),
                "column": at.as_ref().map(|at| at.column),
            })
        })
        .collect();
    let film = &view.film;
    json!({
        "objects": shapes(desc),
        "primitives": scene.stats.primitives,
        "triangles": scene.stats.triangles,
        "materials": count(desc.materials.iter().map(|m| m.value.type_name())),
        "textures": count(desc.textures.iter().map(|t| t.value.type_name())),
        "lights": count(desc.lights.iter().map(|l| l.value.type_name())),
        "groups": desc.groups.len(),
        "light_groups": scene
            .light_group_counts()
            .iter()
            .map(|(name, lights, objects)| json!({ "name": name, "lights": lights, "objects": objects }))
            .collect::<Vec<_>>(),
        "camera": camera(desc),
        "camera_model": crate::camera::json(view),
        "view": self::view(&view.camera_desc),
        "cameras": desc.cameras.iter().map(|c| &c.name).collect::<Vec<_>>(),
        "names": names(ready).into_iter().map(|(what, names)| (what.to_owned(), json!(names))).collect::<serde_json::Map<_, _>>(),
        "imports": desc.imports.iter().map(import).collect::<Vec<_>>(),
        "integrator": desc.integrator.type_name(),
        "film": {
            "width": film.width,
            "height": film.height,
            "crop": film.crop,
            "antialias": film.antialias.word(),
            "samples": film.samples,
            "transfer": film.transfer.word(),
            "tonemap": film.tonemap.word(),
            "exposure": film.exposure,
            "auto_exposure": film.auto_exposure,
            "seed": film.seed,
            "aovs": film.aovs.iter().map(turner::film::Aov::word).collect::<Vec<_>>(),
        },
        "aov_numbers": crate::aovs::numbers(film, scene),
        "bounds": scene.stats.bounds.map(|b| json!({ "min": b.min.to_array(), "max": b.max.to_array() })),
        "memory": memory(ready).into_iter().collect::<BTreeMap<_, _>>(),
        "files": ready.sources.files().iter().filter(|f| !f.is_argument).map(|f| &f.name).collect::<Vec<_>>(),
        "images": desc.images.iter().map(|i| &i.uri).collect::<Vec<_>>(),
        "meshes": desc.meshes.iter().map(|m| &m.uri).collect::<Vec<_>>(),
        "warnings": warnings,
        "scene_hash": ready.hash.whole,
        "seconds": ready.seconds,
    })
}

fn as_text(ready: &Ready) -> String {
    let (desc, scene, view) = (&ready.desc, &ready.prepared.scene, &ready.prepared.view);
    let stats = &scene.stats;
    let bounds = stats.bounds.map_or("none: the scene has no bounded object".to_owned(), |b| {
        format!("{} to {}", point(b.min.to_array()), point(b.max.to_array()))
    });
    let list =
        |names: Vec<&str>| if names.is_empty() { String::new() } else { format!(": {}", names.join(", ")) };
    let mut objects = listed(&shapes(desc));
    if stats.primitives != desc.objects.len() as u64 {
        objects += &format!("; {} primitives with instances", stats.primitives);
    }
    if stats.triangles > 0 {
        objects += &format!("; {} triangles", stats.triangles);
    }
    let groups: Vec<&str> = desc.groups.iter().filter_map(|g| g.name.as_deref()).collect();
    let camera = match desc.camera.as_ref().or(desc.cameras.first()) {
        Some(camera) => camera.value.type_name().to_owned(),
        None if desc.studio.is_some() => {
            "none in the file: the scene is framed from the front right and above".to_owned()
        }
        None => "none: the scene is framed from the front".to_owned(),
    };
    let memory = memory(ready).map(|(what, n)| format!("{what} {}", text::bytes(n))).join(", ");
    let imports = desc.imports.iter().map(|i| ("model", text::import(i)));
    let rows = [
        ("objects", objects),
        ("materials", listed(&count(desc.materials.iter().map(|m| m.value.type_name())))),
        ("textures", listed(&count(desc.textures.iter().map(|t| t.value.type_name())))),
        ("lights", listed(&count(desc.lights.iter().map(|l| l.value.type_name())))),
        ("light groups", light_groups(scene)),
        ("groups", format!("{}{}", groups.len(), list(groups))),
        ("camera", camera),
        ("film", film(&view.film)),
        ("integrator", desc.integrator.type_name().to_owned()),
        ("bounds", bounds),
        ("memory", memory),
        ("hash", ready.hash.whole.clone()),
        ("loaded in", text::seconds(ready.seconds)),
    ];
    // Light groups have a row of their own.
    let named = names(ready).into_iter().filter(|(what, names)| *what != "light_groups" && !names.is_empty());
    let named = named.map(|(what, names)| {
        let title = match what {
            "materials" => "material names",
            "cameras" => "camera names",
            other => other,
        };
        (title, shortened(&names))
    });
    let rows: Vec<(&str, String)> = imports.chain(rows).chain(named).collect();
    text::columns(rows.iter().map(|(name, what)| (*name, what.clone())))
}

/// Most names per row.
const MAX_NAMES: usize = 20;

/// The names that options and keys refer to: `materials` of a model, `--camera`, `--animation`, `--variant`, light
/// groups.
fn names(ready: &Ready) -> Vec<(&'static str, Vec<String>)> {
    let desc = &ready.desc;
    let imported = |what: &str| -> Vec<String> {
        let all = desc.imports.iter().flat_map(|i| &i.names).filter(|(of, _)| *of == what);
        all.flat_map(|(_, names)| names.iter().cloned()).collect()
    };
    let own = |names: &mut dyn Iterator<Item = &Option<String>>| names.flatten().cloned().collect();
    let groups = ready.prepared.scene.light_group_counts();
    let mut all: Vec<(&'static str, Vec<String>)> = vec![
        ("materials", own(&mut desc.materials.iter().map(|m| &m.name))),
        ("cameras", own(&mut desc.cameras.iter().map(|c| &c.name))),
        ("animations", imported("animations")),
        ("variants", imported("variants")),
        ("light_groups", groups.iter().map(|(name, ..)| (*name).to_owned()).collect()),
    ];
    for (_, names) in &mut all {
        let mut seen = std::collections::HashSet::new();
        names.retain(|name| seen.insert(name.clone()));
    }
    all
}

/// `red, green, … and 7 more`: at most [`MAX_NAMES`].
fn shortened(names: &[String]) -> String {
    let shown: Vec<String> = names.iter().take(MAX_NAMES).map(|n| turner::schema::error::escape(n)).collect();
    let more = names.len().saturating_sub(MAX_NAMES);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("{}{more}", shown.join(", "))
}

/// `ceiling: 3 lights, 2 objects`.
fn light_groups(scene: &turner::scene::Scene) -> String {
    let one = |(name, lights, objects): &(&str, u64, u64)| {
        let (lights, objects) = (text::plural(*lights, "light"), text::plural(*objects, "object"));
        format!("{}: {lights}, {objects}", turner::schema::error::escape(name))
    };
    let counts = scene.light_group_counts();
    let all: Vec<String> = counts.iter().take(MAX_NAMES).map(one).collect();
    let more = counts.len().saturating_sub(MAX_NAMES);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    if all.is_empty() { "none".into() } else { all.join("; ") + &more }
}

/// Position, target, up vector and vertical field of view in degrees.
fn view(camera: &CameraDesc) -> Value {
    let [position, look_at, up] = camera.clone().placement_mut().map(|v| v.to_array());
    let mut view = json!({ "position": position, "look_at": look_at, "up": up });
    view["type"] = json!(camera.type_name());
    if let CameraDesc::Pinhole(PinholeDesc { fov: Some(fov), .. }) = camera {
        view["fov"] = json!(fov);
    }
    view
}

fn import(import: &ImportSummary) -> Value {
    let counts: serde_json::Map<_, _> =
        import.counts.iter().map(|(what, n)| ((*what).to_owned(), json!(n))).collect();
    json!({ "file": import.file, "format": import.format, "counts": counts })
}

/// `7: 4 sphere, 3 plane`.
fn listed(counts: &Counts) -> String {
    let total: u64 = counts.values().sum();
    let each = counts.iter().map(|(name, n)| format!("{n} {name}")).collect::<Vec<_>>().join(", ");
    if total == 0 { "none".into() } else { format!("{total}: {each}") }
}

fn film(film: &FilmDesc) -> String {
    let crop = film.crop.map_or(String::new(), |[x, y, w, h]| format!(", crop {w}x{h} at ({x}, {y})"));
    let exposure = match (film.auto_exposure, film.exposure) {
        (false, 0.0) => String::new(),
        (false, stops) => format!(", exposure {stops:+}"),
        (true, 0.0) => ", exposure auto".to_owned(),
        (true, stops) => format!(", exposure auto {stops:+}"),
    };
    let tonemap = match film.tonemap {
        Tonemap::None => String::new(),
        tonemap => format!(", tonemap {}", tonemap.word()),
    };
    format!(
        "{}x{}{crop}, antialias {}{exposure}{tonemap}, transfer {}, seed {}",
        film.width,
        film.height,
        film.antialias.word(),
        film.transfer.word(),
        film.seed
    )
}

/// A point, rounded to three decimals or four significant digits.
fn point(p: [f64; 3]) -> String {
    let p = p.map(|v| {
        let digits = if v.abs() >= 1e6 || (v != 0.0 && v.abs() < 1e-3) {
            format!("{v:.3e}")
        } else {
            format!("{v:.3}")
        };
        if digits.contains(['.']) && !digits.contains('e') {
            digits.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            digits
        }
    });
    format!("({})", p.join(", "))
}

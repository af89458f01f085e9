//! `turner bench edits`: time from an edit of a large scene until it is prepared for rendering.

use std::sync::Arc;
use std::time::Instant;

use clap::Args;
use serde_json::json;
use turner::camera::{CameraDesc, PinholeDesc};
use turner::color::Spectrum;
use turner::description::{ObjectDesc, SceneDesc};
use turner::film::Antialias;
use turner::integrator::{IntegratorDesc, PathDesc};
use turner::light::{LightDesc, PointDesc};
use turner::material::{MaterialDesc, PrincipledMaterial};
use turner::math::{DAffine3, DVec3};
use turner::prepare::{Preparer, Rebuilt, UpdateOptions};
use turner::schema::{
    Asset, ColorSource, MaterialId, MeshData, MeshId, PrepareOptions, SceneError, Transform,
};
use turner::shape::{MeshDesc, ShapeDesc};

use super::{median, reported};
use crate::failure::Failure;
use crate::text;

/// Measure the time from an edit of a large scene until it is prepared for rendering
#[derive(Debug, Args)]
#[command(
    after_help = "The scene has a million triangles in 100 meshes and 1,000 lights. \"placed\" has 10,000 instances of the meshes; \"once\" has one instance\n\
                  of each, all in one BVH. Milliseconds are the median; first is the preparation of the entire scene."
)]
pub(crate) struct EditsBenchArgs {
    /// How often each edit is repeated
    #[arg(long, default_value_t = 9, value_parser = clap::value_parser!(u32).range(1..=1000))]
    repeat: u32,
    /// Number of threads [default: all cores]
    #[arg(long, default_value_t = 0, hide_default_value = true)]
    threads: usize,
    /// Print one JSON object per line
    #[arg(long)]
    json: bool,
}

/// Number of meshes, of rows and columns of squares in each, of materials and of lights.
const MESHES: u32 = 100;
const SIDE: u32 = 71;
const MATERIALS: u32 = 50;
const LIGHTS: u32 = 1000;

/// A hilly terrain of about 10,000 triangles.
fn hills(seed: u32) -> Arc<MeshData> {
    let height = |x: u32, z: u32| ((x * 7 + z * 13 + seed * 31) % 17) as f32 * 2e-3;
    let position = |i: u32| i as f32 / SIDE as f32 - 0.5;
    let points = (0..=SIDE).flat_map(|z| (0..=SIDE).map(move |x| (x, z)));
    let positions = points.map(|(x, z)| [position(x), height(x, z), position(z)]).collect();
    let squares = (0..SIDE).flat_map(|z| (0..SIDE).map(move |x| z * (SIDE + 1) + x));
    let triangles =
        squares.flat_map(|a| [[a, a + 1, a + SIDE + 2], [a, a + SIDE + 2, a + SIDE + 1]]).collect();
    Arc::new(MeshData { positions, triangles, ..MeshData::default() })
}

fn light(number: u32, intensity: f64) -> LightDesc {
    let coordinate = |n: u32| f64::from(number.wrapping_mul(n) % 1009) / 10.09 - 50.0;
    let position = DVec3::new(coordinate(7919), 3.0 + 0.01 * f64::from(number % 100), coordinate(104_729));
    LightDesc::Point(PointDesc { position, intensity, ..PointDesc::default() })
}

fn grey(number: u32) -> MaterialDesc {
    let base_color = ColorSource::Constant(Spectrum::grey(0.2 + 0.01 * number as f32));
    MaterialDesc::Principled(PrincipledMaterial { base_color, ..PrincipledMaterial::default() })
}

/// A scene with `instances` objects for each mesh.
fn scene(instances: u32) -> SceneDesc {
    let mut desc = SceneDesc::default();
    (desc.film.width, desc.film.height, desc.film.samples) = (1280, 720, 16);
    desc.film.antialias = Antialias::MonteCarlo;
    desc.integrator = IntegratorDesc::Path(PathDesc::default());
    let camera = PinholeDesc {
        position: DVec3::new(0.0, 20.0, 60.0),
        look_at: DVec3::ZERO,
        fov: Some(50.0),
        ..PinholeDesc::default()
    };
    desc.camera = Some(CameraDesc::Pinhole(camera).into());
    desc.materials = (0..MATERIALS).map(|i| grey(i).into()).collect();
    desc.meshes = (0..MESHES).map(|i| Asset { uri: format!("{i}"), data: hills(i) }).collect();
    desc.objects = (0..MESHES * instances)
        .map(|i| {
            let mesh = MeshDesc { mesh: MeshId(i % MESHES), ..MeshDesc::default() };
            let at = DVec3::new(f64::from(i % 100) - 50.0, 0.0, f64::from(i / 100) - 50.0);
            ObjectDesc {
                material: Some(MaterialId(i % MATERIALS)),
                transform: Transform(DAffine3::from_translation(at)),
                ..ObjectDesc::new(ShapeDesc::Mesh(mesh))
            }
        })
        .collect();
    desc.lights = (0..LIGHTS).map(|i| light(i, 5.0).into()).collect();
    desc
}

/// An edit; its argument is the index of the repetition.
type Edit = fn(&mut SceneDesc, u32);

/// The edits, with the target in milliseconds on two cores; `None` where the time depends on a BVH build.
const EDITS: &[(&str, Option<f64>, Edit)] = &[
    ("nothing", Some(1.0), |_, _| ()),
    ("camera", Some(1.0), |desc, i| {
        if let Some(camera) = &mut desc.camera {
            camera.value.placement_mut()[0].x += 0.1 + f64::from(i);
        }
    }),
    ("film", Some(1.0), |desc, i| desc.film.samples = 17 + i),
    ("integrator", Some(1.0), |desc, i| {
        desc.integrator = IntegratorDesc::Path(PathDesc { max_depth: 5 + i, ..PathDesc::default() });
    }),
    ("material value", Some(5.0), |desc, i| desc.materials[7] = grey(60 + i).into()),
    ("light colour", Some(5.0), |desc, i| desc.lights[500] = light(500, 6.0 + f64::from(i)).into()),
    ("light moved", Some(20.0), |desc, i| desc.lights[300] = light(2000 + i, 5.0).into()),
    ("light added", Some(20.0), |desc, i| desc.lights.push(light(3000 + i, 5.0).into())),
    ("object moved", Some(30.0), |desc, i| {
        let object = desc.objects.len() / 2;
        desc.objects[object].transform.0.translation.y += 0.1 + f64::from(i);
    }),
    ("mesh replaced", None, |desc, i| desc.meshes[42].data = hills(1000 + i)),
];

/// Runs the command.
pub(crate) fn run(args: &EditsBenchArgs) -> u8 {
    reported(args.json, measure(args).map_err(Failure::new))
}

/// The measured times of one edit, in milliseconds, and what the update rebuilt.
struct Row {
    scene: &'static str,
    edit: &'static str,
    target: Option<f64>,
    milliseconds: Vec<f64>,
    rebuilt: Rebuilt,
}

fn measure(args: &EditsBenchArgs) -> Result<(), SceneError> {
    if !args.json {
        text::print(&format!(
            "{:8}{:18}{:>10}{:>10}{:>10}\n",
            "scene", "edit", "median ms", "max ms", "target"
        ));
    }
    for (name, instances) in [("placed", 100), ("once", 1)] {
        let mut desc = scene(instances);
        let options = PrepareOptions { threads: args.threads, ..PrepareOptions::default() };
        let mut preparer = Preparer::new(options);
        let first = update(&mut preparer, &desc)?;
        print(
            &Row { scene: name, edit: "first", target: None, milliseconds: vec![first.0], rebuilt: first.1 },
            args,
        );
        for &(edit, target, change) in EDITS {
            let mut row =
                Row { scene: name, edit, target, milliseconds: Vec::new(), rebuilt: Rebuilt::default() };
            for i in 0..args.repeat {
                change(&mut desc, i);
                let (milliseconds, rebuilt) = update(&mut preparer, &desc)?;
                row.milliseconds.push(milliseconds);
                row.rebuilt = rebuilt;
            }
            print(&row, args);
        }
    }
    Ok(())
}

fn update(preparer: &mut Preparer, desc: &SceneDesc) -> Result<(f64, Rebuilt), SceneError> {
    let start = Instant::now();
    let update = preparer.update_with(desc, &UpdateOptions::default())?;
    let milliseconds = start.elapsed().as_secs_f64() * 1e3;
    Ok((milliseconds, update.map_or_else(Rebuilt::default, |update| update.rebuilt)))
}

fn print(row: &Row, args: &EditsBenchArgs) {
    let median = median(&row.milliseconds).unwrap_or(f64::NAN);
    let most = row.milliseconds.iter().copied().fold(0.0, f64::max);
    text::print(&match args.json {
        true => {
            let values = json!({
                "scene": row.scene,
                "edit": row.edit,
                "milliseconds": row.milliseconds,
                "median_milliseconds": median,
                "target_milliseconds": row.target,
                "rebuilt_objects": row.rebuilt.objects,
                "rebuilt_merged": row.rebuilt.world_mesh,
                "rebuilt_meshes": row.rebuilt.meshes,
                "version": env!("CARGO_PKG_VERSION"),
            });
            format!("{values}\n")
        }
        false => {
            let target = row.target.map_or(String::new(), |target| format!("{target:.0}"));
            format!("{:8}{:18}{median:>10.2}{most:>10.2}{target:>10}\n", row.scene, row.edit)
        }
    });
}

//! Loads scenes from memory, renders them and saves to memory: no file, clock, environment variable or second thread.

use std::sync::atomic::AtomicBool;

use turner::render::{PassOptions, Renderer};
use turner::schema::PrepareOptions;
use turner_io::assets::MemoryAssets;
use turner_io::image::ImageFormat;
use turner_io::scene::{LoadOptions, load_text};
use turner_io::{Override, SaveOptions, to_bytes};

/// The README's first scene, and one with a path tracer, an external file, a BVH, and several lights.
pub(crate) const SCENES: [&str; 2] = [include_str!("../../scenes/hello.toml"), PATHS];

const PATHS: &str = r#"
film = { antialias = "monte-carlo", samples = 4 }
integrator = { type = "path", max_depth = 5 }
camera = { position = [0, 1.2, 5], look_at = [0, 0.6, 0] }
light = [{ type = "environment", strength = 0.5 }, { type = "point", position = [2, 4, 3], intensity = 9, attenuation = "inverse-square" }]
object = [
  { type = "plane", material = { type = "matte", color = { type = "checkerboard" } } },
  { type = "model", file = "roof.obj", material = { type = "principled", base_color = "tomato", specular_roughness = 0.3 } },
  { type = "sphere", center = [1.2, 0.5, 0.8], radius = 0.5, material = { type = "metal", name = "gold" } },
  { type = "sphere", center = [-1.2, 0.5, 0.8], radius = 0.5, material = { type = "dielectric", roughness = 0.2 } },
]
"#;

/// The external file of the second scene.
const ROOF: &str = "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv 0 1.5 0\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";

/// The checksum of the PNG and EXR files of all scenes.
pub(crate) fn checksum(threads: usize) -> Result<u64, String> {
    // FNV-1a.
    let add = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
    let mut hash = 0xcbf2_9ce4_8422_2325;
    for scene in SCENES {
        for file in files(scene, threads)? {
            hash = file.iter().fold(hash, add);
        }
    }
    Ok(hash)
}

/// A small image of a scene, as PNG and as EXR.
fn files(scene: &str, threads: usize) -> Result<[Vec<u8>; 2], String> {
    let set = |path: &str, value: &str| Override { path: path.to_owned(), value: value.to_owned() };
    let overrides = vec![set("film.width", "96"), set("film.height", "72")];
    let assets = MemoryAssets { files: [("roof.obj".to_owned(), ROOF.as_bytes().to_vec())].into() };
    let options = LoadOptions { threads, overrides, ..LoadOptions::default() };
    let loaded =
        load_text(scene.to_owned(), "scene.toml", &assets, &options).map_err(|e| e.error.to_string())?;
    let prepare = PrepareOptions { threads, ..PrepareOptions::default() };
    let prepared = loaded.desc.prepare(&prepare).map_err(|e| e.to_string())?;
    let mut renderer = Renderer::new(prepared).map_err(|e| e.to_string())?;
    let options = PassOptions { threads, cancel: &AtomicBool::new(false), progress: None };
    renderer.pass(renderer.samples_per_pixel(), &options).map_err(|e| e.to_string())?;
    let (picture, save) = (renderer.develop(), SaveOptions { threads, ..SaveOptions::default() });
    let bytes = |format| to_bytes(&picture, format, &save).map_err(|e| e.to_string());
    Ok([bytes(ImageFormat::Png)?, bytes(ImageFormat::Exr)?])
}

#![forbid(unsafe_code)]
//! File formats: scenes ([`scene`]), glTF models ([`gltf`]), meshes ([`mesh`]), images ([`image`]), IES light
//! profiles ([`ies`]), density grids ([`grid`]), checkpoints ([`checkpoint`]) and the access to files that they name ([`assets`]).
//!
//! [`load`] reads a scene or a model from a file, and [`save`] writes a picture. A scene can also be read from text:
//!
//! ```
//! use turner::schema::PrepareOptions;
//! use turner_io::assets::FolderAssets;
//! use turner_io::scene::{LoadOptions, load_text};
//!
//! let text = "[[object]]\ntype = \"sphere\"\n\n[[light]]\ntype = \"point\"\nposition = [3, 5, 4]\n";
//! let assets = FolderAssets::new("")?; // files that the scene names are read from the current folder
//! let loaded = load_text(text.to_owned(), "scene.toml", &assets, &LoadOptions::default())?;
//! let prepared = loaded.desc.prepare(&PrepareOptions::default())?;
//! assert_eq!(prepared.scene.stats.primitives, 1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod assets;
pub mod checkpoint;
pub mod convert;
pub mod edit;
pub mod font;
pub mod gltf;
pub mod grid;
mod gzip;
pub mod ies;
mod ies_floodlight;
pub mod image;
pub mod import;
mod load;
pub mod measured;
pub mod mesh;
mod mitsuba;
mod pbrt;
mod save;
pub mod scene;
mod scene_import;
mod spectral;
pub mod testing;
mod usd;
mod vdb;
mod words;

pub use load::{load, load_with};
pub use save::{
    DisplayOptions, Rounding, Save, SaveError, SaveOptions, save, save_with, to_bytes, write_file,
};
pub use scene::{LoadError, LoadOptions, Loaded, Override};

/// Runs the README's example. The example has its own file; a test in `load` compares that file with the README.
///
/// ```
/// # let folder = tempfile::tempdir()?;
/// # std::fs::copy("tests/assets/gltf/Box.glb", folder.path().join("room.glb"))?;
/// # std::env::set_current_dir(&folder)?;
#[doc = include_str!("../tests/data/readme_example.rs")]
/// # let png = std::fs::read("room.png")?;
/// # let picture = turner_io::image::decode(&png, "room.png", &turner_io::image::DecodeLimits::default())?;
/// # assert_eq!((picture.width, picture.height), (160, 120));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[cfg(doctest)]
mod readme {}

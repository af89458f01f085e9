#![forbid(unsafe_code)]
//! File formats: bytes for a URI ([`assets`]), glTF models ([`gltf`]), measured lights ([`ies`]), pictures ([`image`]), meshes ([`mesh`]), text scenes ([`scene`]).
//!
//! ```
//! use turner::scene::PrepareOptions;
//! use turner_io::assets::FolderAssets;
//! use turner_io::scene::{LoadOptions, load_text};
//!
//! let text = "[[object]]\ntype = \"sphere\"\n\n[[light]]\ntype = \"point\"\nposition = [3, 5, 4]\n";
//! let assets = FolderAssets::new("")?; // the current folder, for files that a scene names
//! let loaded = load_text(text.to_owned(), "scene.toml", &assets, &LoadOptions::default())?;
//! let scene = loaded.desc.prepare(&PrepareOptions::default())?;
//! assert_eq!(scene.stats.primitives, 1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`scene::load`] reads a file, a scene or a model, in the same way.

pub mod assets;
pub mod convert;
pub mod gltf;
pub mod grid;
mod gzip;
pub mod ies;
mod ies_floodlight;
pub mod image;
pub mod import;
pub mod mesh;
mod mitsuba;
mod pbrt;
pub mod scene;
mod spectral;
pub mod testing;
mod whole;
mod words;

//! The Python module `turner`: this crate is its compiled part, `turner._turner`; the rest is Python in
//! `python/turner`.
//!
//! ```text
//! Python values ── value ──► Value, spans name Python's paths ──► read_scene, SceneDesc::edit ──► Scene
//! NumPy arrays ─── arrays ─► MeshData, Image, GridData ── assets ──┘                               │
//!                                                              Preparer::update ◄──────────────────┤
//! NumPy arrays ◄── picture ── Film ◄── Renderer::pass ◄── renderer ◄── Prepared ◄──────────────────┘
//! ```
//!
//! Descriptions have no classes here: the schema is handed to Python as data (`schema`), which makes its classes of it.
//! All work runs without the GIL. Locks are taken only for moments, or without the GIL, so that no thread waits for a
//! lock while it holds the GIL that the owner of the lock needs.
// Python's functions are found by their names in the module, not by paths in Rust.
#![allow(unreachable_pub, clippy::needless_pass_by_value)]

mod arrays;
mod assets;
mod errors;
mod interpreter;
mod mesh_views;
mod picture;
mod places;
mod plain;
pub mod renderer;
pub mod scene;
mod schema;
mod tools;
mod turns;
mod value;
mod work;

use pyo3::prelude::*;

/// The compiled part of `turner`.
#[pymodule]
mod _turner {
    #[pymodule_export]
    use super::renderer::{Renderer, merge_films};
    #[pymodule_export]
    use super::scene::Scene;
    #[pymodule_export]
    use super::schema::schema;
    #[pymodule_export]
    use super::tools::{compare, run_command, save_picture};
    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");

    #[pymodule_init]
    fn init(module: &super::Bound<'_, super::PyModule>) -> super::PyResult<()> {
        super::interpreter::check(module.py())
    }
}

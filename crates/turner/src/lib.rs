//! The Turner ray tracer: from a scene description to a picture.
//!
//! A scene is described ([`SceneDesc`]), prepared ([`SceneDesc::prepare`]), rendered pass by pass ([`Renderer`])
//! and developed ([`Picture`]):
//!
//! ```
//! use std::sync::atomic::AtomicBool;
//! use turner::light::{AmbientDesc, LightDesc};
//! use turner::math::DVec3;
//! use turner::shape::{ShapeDesc, SphereDesc};
//! use turner::{ObjectDesc, PassOptions, PrepareOptions, Renderer, SceneDesc};
//!
//! let mut desc = SceneDesc::default();
//! (desc.film.width, desc.film.height) = (64, 48);
//! let ball = SphereDesc { center: DVec3::new(0.0, 1.0, 0.0), ..Default::default() };
//! desc.objects.push(ObjectDesc::new(ShapeDesc::Sphere(ball)));
//! let light = AmbientDesc { intensity: 1.0, ..Default::default() };
//! desc.lights.push(LightDesc::Ambient(light).into());
//!
//! let prepared = desc.prepare(&PrepareOptions::default())?;
//! let mut renderer = Renderer::new(prepared)?;
//! let options = PassOptions { threads: 0, cancel: &AtomicBool::new(false), progress: None };
//! renderer.pass(u32::MAX, &options)?;
//! let picture = renderer.develop();
//!
//! assert_eq!(picture.display.len(), 64 * 48);
//! // The centre of the picture shows the sphere; its corner does not.
//! assert!(picture.display[24 * 64 + 32][0] > picture.display[0][0]);
//! # Ok::<(), turner::SceneError>(())
//! ```
//!
//! These types are re-exported here. Everything else is in the modules, one per noun of the field: shapes in
//! [`shape`], materials in [`material`], ….
//!
//! The crate `turner-io` reads scene files and models into descriptions and writes pictures to files. This crate
//! opens no file, window or thread pool of its own choice: see ARCHITECTURE.md.
#![forbid(unsafe_code)]

pub mod animation;
pub mod bsdf;
pub mod camera;
pub mod choice;
pub mod color;
pub mod compare;
pub mod denoise;
pub mod description;
pub mod doctor;
pub mod explain;
pub mod film;
pub mod filter;
pub mod image;
pub mod integrator;
pub mod interaction;
pub mod light;
pub mod lint;
pub mod material;
pub mod math;
pub mod medium;
pub mod prepare;
pub mod preview;
pub mod render;
pub mod sampler;
pub mod scene;
pub mod schema;
pub mod shape;
pub mod testing;
pub mod texture;
pub mod view;

pub use description::{ObjectDesc, SceneDesc};
pub use film::{Film, Picture};
pub use integrator::Prepared;
pub use render::{PassOptions, Renderer};
pub use schema::{PrepareOptions, SceneError};

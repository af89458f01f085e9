//! The Turner ray tracer: from a scene description to a picture.
//!
//! A scene is described ([`scene::SceneDesc`]), prepared ([`scene::SceneDesc::prepare`]), rendered pass by pass ([`render::Renderer`]) and developed
//! ([`film::Picture`]):
//!
//! ```
//! use std::sync::atomic::AtomicBool;
//! use turner::light::{AmbientDesc, LightDesc};
//! use turner::color::Spectrum;
//! use turner::math::DVec3;
//! use turner::render::{PassOptions, Renderer};
//! use turner::scene::{ObjectDesc, PrepareOptions, SceneDesc};
//! use turner::shape::{ShapeDesc, SphereDesc};
//!
//! let mut desc = SceneDesc::default();
//! (desc.film.width, desc.film.height) = (64, 48);
//! let ball = SphereDesc { center: DVec3::new(0.0, 1.0, 0.0), radius: 1.0 };
//! desc.objects.push(ObjectDesc::new(ShapeDesc::Sphere(ball)));
//! let light = AmbientDesc { color: Spectrum::WHITE, intensity: 1.0 };
//! desc.lights.push(LightDesc::Ambient(light).into());
//!
//! let scene = desc.prepare(&PrepareOptions::default())?;
//! let mut renderer = Renderer::new(&scene)?;
//! let options = PassOptions { threads: 0, cancel: &AtomicBool::new(false), progress: None };
//! renderer.pass(u32::MAX, &options)?;
//! let picture = renderer.develop();
//!
//! assert_eq!(picture.display.len(), 64 * 48);
//! // The middle of the picture is the ball, its corner is not.
//! assert!(picture.display[24 * 64 + 32][0] > picture.display[0][0]);
//! # Ok::<(), turner::scene::SceneError>(())
//! ```
//!
//! The crate `turner-io` reads scene files and models into descriptions and writes pictures into files. This crate opens no file, no window and no thread pool of its own
//! choice: see ARCHITECTURE.md.
#![forbid(unsafe_code)]

pub mod bsdf;
pub mod camera;
pub mod color;
pub mod compare;
pub mod doctor;
pub mod film;
pub mod filter;
pub mod image;
pub mod integrator;
pub mod light;
pub mod material;
pub mod math;
pub mod medium;
pub mod render;
pub mod sampler;
pub mod scene;
pub mod shape;
pub mod testing;
pub mod texture;

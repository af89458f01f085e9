#![forbid(unsafe_code)]
//! Turner Studio: a window to see a scene, change it and understand it.
//!
//! ```text
//! main ── app ─┬─ menus, palette ── actions    one table: name, shortcut, what it does
//!              ├─ layout ── panels             one file per panel
//!              ├─ viewport ─┬─ navigate, gizmo
//!              │            └─ overlay         rays, boxes, handles over the picture
//!              ├─ jobs                         renders to files, each a process
//!              └─ studio                       what all of them share: document, engine, selection
//! ```
//!
//! The window never waits for the renderer: it posts orders to the engine (`turner-live`) and shows its newest frame.

pub mod actions;
pub mod app;
pub mod bench;
mod cameras;
mod changes;
pub mod insight;
pub mod jobs;
pub mod layout;
pub mod panels;
mod pixel;
pub mod settings;
pub mod studio;
pub mod task;
pub mod viewport;
mod widgets;

pub use turner_live::node;

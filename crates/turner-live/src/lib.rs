#![forbid(unsafe_code)]
//! Scenes that are edited while they are rendered: what a window, a page or a program needs around the renderer.
//!
//! ```text
//!  Document  description, undo, files ──Arc<SceneDesc>──► Order ──► Engine ──Arc<Frame>──► the front end
//!     ▲                                                                │
//!     └── edits: key paths, camera moves, objects ◄── pick ◄──────────┘
//! ```
//!
//! - [`document`]: a scene with its history, the file it came from, saving and recovery.
//! - [`engine`]: a thread that renders the newest [`Order`](engine::Order): first an approximate picture, then the film
//!   of `turner render`, sample after sample. It never blocks its caller.
//! - [`camera`]: orbit, pan, dolly, fly, frame and focus, as functions of a camera's description.
//! - [`node`]: the parts of a scene that can be selected.
//! - [`pick`]: what lies under a pixel.
//!
//! Nothing here draws a window.

pub mod camera;
pub mod document;
pub mod engine;
pub mod node;
pub mod pick;

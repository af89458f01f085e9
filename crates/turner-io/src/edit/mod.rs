//! What a program that edits scenes needs beside `SceneDesc::edit`: saving a description in the file that it came from
//! ([`save_scene`]), and copying and pasting parts as text ([`copy`], [`paste`]).
//!
//! Saving compares two trees of values, one of the description as it was loaded and one as it is, and changes only the
//! places of the text that differ:
//!
//! ```text
//! opened SceneDesc ──► tree ─┐
//!                            ├─ differences ──► splices ──► new text ──read again──► same scene? ──► file
//! edited SceneDesc ──► tree ─┘                                            otherwise: convert::to_toml
//! ```
//!
//! The position of an item in the file (`ObjectDesc::span` and the like) says which table of the text it comes from. The
//! new text is read again before it replaces the file, so a file never differs from the description.

mod clipboard;
mod in_memory;
mod known;
mod opened;
mod save;
mod sections;
mod splice;
mod tree;

pub use clipboard::{copy, paste};
pub use in_memory::scene_text;
pub use opened::Opened;
pub use save::{Saved, save_scene};

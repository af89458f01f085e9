//! Panels: one file each. The table in `layout` lists them.

pub(crate) mod alternatives;
pub(crate) mod compare;
pub(crate) mod doctor;
pub(crate) mod effects;
pub(crate) mod gallery;
pub(crate) mod history;
pub(crate) mod inspector;
pub(crate) mod model;
pub(crate) mod outliner;
pub(crate) mod properties;
pub(crate) mod rays;
pub(crate) mod render;
pub(crate) mod scopes;
pub mod second;
pub mod swatch;

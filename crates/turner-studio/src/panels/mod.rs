//! Panels: one file each. The table in `layout` lists them.

pub(crate) mod gallery;
pub(crate) mod history;
pub(crate) mod outliner;
pub(crate) mod properties;
pub(crate) mod render;

//! Widgets for the values of a scene.

pub(crate) mod color;
pub(crate) mod field;
pub(crate) mod transform;

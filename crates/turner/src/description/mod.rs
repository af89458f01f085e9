//! Scene descriptions: plain, editable data. [`SceneDesc`] holds the descriptions of all families. A scene file is read
//! into it and written from it.

pub(crate) mod animate;
#[cfg(test)]
mod animate_tests;
mod borrowed_assets;
mod builder;
pub mod default_studio;
#[cfg(test)]
mod default_tests;
mod draft;
mod edit;
mod edit_model;
pub mod framing;
mod groups;
mod hidden;
mod labels;
mod merge;
mod model;
mod parts;
mod read;
mod read_object;
mod read_parts;
mod read_scene;
mod references;
mod remove;
mod rename;
mod retarget;
mod same;
mod scene_desc;
mod value_at;
mod write;
mod write_names;

pub use default_studio::StudioDesc;
pub use edit::drop_foreign_keys;
pub use labels::{Label, Labels};
pub use model::{ModelDesc, UpAxis};
pub use read::{SECTIONS, SceneAssets};
pub use read_scene::read_scene;
pub use scene_desc::{GroupDesc, ImportSummary, ObjectContent, ObjectDesc, SceneDesc, SceneLight};
pub use write::{SceneAssetWriter, write_scene};
pub use write_names::PartNames;

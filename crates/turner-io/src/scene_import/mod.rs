//! What the importers of pbrt and Mitsuba share: the scene under construction, reports with source positions,
//! texture values.

mod ahead;
mod common_parts;
pub(crate) mod environment_light;
mod grid_box;
mod layer;
mod measured;
mod microfacets;
mod named_media;
mod open;
mod orient;
mod own_vertices;
mod rearranged;
pub(crate) mod report;
mod revolution;
mod scene_files;
mod values;

pub(crate) use common_parts::{CommonParts, is_sound, load_image, push, read_file};
pub(crate) use grid_box::{GridBox, ROTATED_GRID};
pub(crate) use layer::inner_reflectance;
pub(crate) use microfacets::{Microfacets, incoming, single_scattering};
pub(crate) use named_media::named_medium;
pub(crate) use open::fill_open;
pub(crate) use orient::orient;
pub(crate) use own_vertices::{bytes as own_vertices_bytes, with_own_vertices};
pub(crate) use rearranged::rearranged;
pub(crate) use report::{Place, unknown};
pub(crate) use revolution::{ALONG, AROUND, Surface, upright};
pub(crate) use scene_files::{FilesAhead, LoadedFile, LoadedMesh, SceneFile};
pub(crate) use values::{Through, map_colors, map_values, mix, product};

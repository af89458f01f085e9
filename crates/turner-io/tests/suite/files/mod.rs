//! Tests of all file formats.

mod environment;
mod gltf_files;
mod gltf_hostile;
mod hostile;
mod image_assets;
mod image_exr_writers;
mod image_hostile;
mod image_kinds;
mod image_output;
mod image_round_trip;
mod image_suite;
mod load_bench;
mod mesh_hostile;
mod mesh_import;
mod mesh_read;
mod mesh_scene;
mod mitsuba_hostile;
mod mitsuba_pictures;
mod old_names;
mod pbrt_hostile;
mod pbrt_pictures;
mod scene_errors;
mod scene_hostile;
mod stl_import;
mod whole_scenes;

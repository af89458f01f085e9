#![forbid(unsafe_code)]
//! File formats: bytes for a URI ([`assets`]), glTF models ([`gltf`]), measured lights ([`ies`]), pictures ([`image`]), meshes ([`mesh`]), text scenes ([`scene`]).

pub mod assets;
pub mod gltf;
pub mod ies;
pub mod image;
pub mod import;
pub mod mesh;
pub mod scene;
pub mod testing;

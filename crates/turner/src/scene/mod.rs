//! Scenes: description, preparation, and the errors on the way.

pub mod background;
pub mod desc;
pub mod error;
mod param;
pub mod read;
pub mod schema;
pub mod transform;
pub mod value;

pub use desc::*;
pub use error::{ErrorCode, SceneError};
pub use param::ColorSource;
pub use read::{SceneAssets, read_scene};

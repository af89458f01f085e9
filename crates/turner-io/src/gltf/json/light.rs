//! Lights (`KHR_lights_punctual`, `EXT_lights_image_based`).

use serde::Deserialize;

use super::{Index, List};

/// `KHR_lights_punctual` of the document.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Lights {
    pub(crate) lights: List<LightJson>,
}

/// A light.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct LightJson {
    pub(crate) name: Option<String>,
    #[serde(rename = "type")]
    pub(crate) kind: String,
    pub(crate) color: Option<[f64; 3]>,
    pub(crate) intensity: Option<f64>,
    pub(crate) range: Option<f64>,
    pub(crate) spot: Option<SpotJson>,
}

/// The cone of a spot light, as angles from its axis in radians.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct SpotJson {
    pub(crate) inner_cone_angle: Option<f64>,
    pub(crate) outer_cone_angle: Option<f64>,
}

/// `EXT_lights_image_based` of the document.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Environments {
    pub(crate) lights: List<EnvironmentJson>,
}

/// A cube map as light from all around.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct EnvironmentJson {
    pub(crate) name: Option<String>,
    /// A quaternion.
    pub(crate) rotation: Option<[f64; 4]>,
    pub(crate) intensity: Option<f64>,
    /// Six images for each of the resolutions, the highest first.
    pub(crate) specular_images: List<Vec<Index>>,
}

//! Materials, textures, samplers and images, as in the JSON.

use super::number::Index;
use serde::Deserialize;

/// A material. Missing members have the defaults of the specification; see `materials`.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Material {
    pub(crate) name: Option<String>,
    pub(crate) pbr_metallic_roughness: Option<Box<MetallicRoughness>>,
    pub(crate) normal_texture: Option<Box<TextureInfo>>,
    pub(crate) occlusion_texture: Option<Box<TextureInfo>>,
    pub(crate) emissive_texture: Option<Box<TextureInfo>>,
    pub(crate) emissive_factor: Option<Box<[f64; 3]>>,
    pub(crate) alpha_mode: Option<String>,
    pub(crate) alpha_cutoff: Option<f64>,
    pub(crate) double_sided: bool,
    pub(crate) extensions: Option<Box<MaterialExtensions>>,
}

/// `pbrMetallicRoughness`.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct MetallicRoughness {
    pub(crate) base_color_factor: Option<[f64; 4]>,
    pub(crate) base_color_texture: Option<Box<TextureInfo>>,
    pub(crate) metallic_factor: Option<f64>,
    pub(crate) roughness_factor: Option<f64>,
    pub(crate) metallic_roughness_texture: Option<Box<TextureInfo>>,
}

/// A reference to a texture; also a normal map with its scale, or an occlusion map with its strength.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct TextureInfo {
    pub(crate) index: Index,
    #[serde(default)]
    pub(crate) tex_coord: Index,
    /// Of normal maps.
    pub(crate) scale: Option<f64>,
    /// Of occlusion maps.
    pub(crate) strength: Option<f64>,
    pub(crate) extensions: Option<Box<TextureInfoExtensions>>,
}

/// Extensions of a texture reference.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct TextureInfoExtensions {
    #[serde(rename = "KHR_texture_transform")]
    pub(crate) transform: Option<TextureTransform>,
}

/// `KHR_texture_transform`.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct TextureTransform {
    pub(crate) offset: Option<[f64; 2]>,
    pub(crate) rotation: Option<f64>,
    pub(crate) scale: Option<[f64; 2]>,
    pub(crate) tex_coord: Option<Index>,
}

/// Extensions of a material.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct MaterialExtensions {
    #[serde(rename = "KHR_materials_emissive_strength")]
    pub(crate) emissive_strength: Option<EmissiveStrength>,
    #[serde(rename = "KHR_materials_ior")]
    pub(crate) ior: Option<Ior>,
    #[serde(rename = "KHR_materials_specular")]
    pub(crate) specular: Option<Box<Specular>>,
    #[serde(rename = "KHR_materials_transmission")]
    pub(crate) transmission: Option<Transmission>,
    #[serde(rename = "KHR_materials_volume")]
    pub(crate) volume: Option<Volume>,
    #[serde(rename = "KHR_materials_clearcoat")]
    pub(crate) clearcoat: Option<Box<Clearcoat>>,
    #[serde(rename = "KHR_materials_sheen")]
    pub(crate) sheen: Option<Box<Sheen>>,
    #[serde(rename = "KHR_materials_iridescence")]
    pub(crate) iridescence: Option<Box<Iridescence>>,
    #[serde(rename = "KHR_materials_anisotropy")]
    pub(crate) anisotropy: Option<Anisotropy>,
    #[serde(rename = "KHR_materials_dispersion")]
    pub(crate) dispersion: Option<Dispersion>,
    #[serde(rename = "KHR_materials_diffuse_transmission")]
    pub(crate) diffuse_transmission: Option<Box<DiffuseTransmission>>,
    #[serde(rename = "KHR_materials_volume_scatter")]
    pub(crate) volume_scatter: Option<Box<VolumeScatter>>,
    #[serde(rename = "KHR_materials_unlit")]
    pub(crate) unlit: Option<Unlit>,
    #[serde(rename = "KHR_materials_pbrSpecularGlossiness")]
    pub(crate) specular_glossiness: Option<Box<SpecularGlossiness>>,
}

/// `KHR_materials_emissive_strength`.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct EmissiveStrength {
    pub(crate) emissive_strength: Option<f64>,
}

/// `KHR_materials_ior`.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Ior {
    pub(crate) ior: Option<f64>,
}

/// `KHR_materials_specular`.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Specular {
    pub(crate) specular_factor: Option<f64>,
    pub(crate) specular_texture: Option<Box<TextureInfo>>,
    pub(crate) specular_color_factor: Option<[f64; 3]>,
    pub(crate) specular_color_texture: Option<Box<TextureInfo>>,
}

/// `KHR_materials_transmission`.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Transmission {
    pub(crate) transmission_factor: f64,
    pub(crate) transmission_texture: Option<Box<TextureInfo>>,
}

/// `KHR_materials_volume`.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Volume {
    pub(crate) thickness_factor: f64,
    pub(crate) thickness_texture: Option<Box<TextureInfo>>,
    pub(crate) attenuation_distance: Option<f64>,
    pub(crate) attenuation_color: Option<[f64; 3]>,
}

/// `KHR_materials_clearcoat`.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Clearcoat {
    pub(crate) clearcoat_factor: f64,
    pub(crate) clearcoat_texture: Option<Box<TextureInfo>>,
    pub(crate) clearcoat_roughness_factor: f64,
    pub(crate) clearcoat_roughness_texture: Option<Box<TextureInfo>>,
    pub(crate) clearcoat_normal_texture: Option<Box<TextureInfo>>,
}

/// `KHR_materials_sheen`.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Sheen {
    pub(crate) sheen_color_factor: [f64; 3],
    pub(crate) sheen_color_texture: Option<Box<TextureInfo>>,
    pub(crate) sheen_roughness_factor: f64,
    pub(crate) sheen_roughness_texture: Option<Box<TextureInfo>>,
}

/// `KHR_materials_iridescence`.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Iridescence {
    pub(crate) iridescence_factor: f64,
    pub(crate) iridescence_texture: Option<Box<TextureInfo>>,
    pub(crate) iridescence_ior: Option<f64>,
    pub(crate) iridescence_thickness_minimum: Option<f64>,
    pub(crate) iridescence_thickness_maximum: Option<f64>,
    pub(crate) iridescence_thickness_texture: Option<Box<TextureInfo>>,
}

/// `KHR_materials_anisotropy`.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Anisotropy {
    pub(crate) anisotropy_strength: f64,
    pub(crate) anisotropy_rotation: f64,
    pub(crate) anisotropy_texture: Option<Box<TextureInfo>>,
}

/// `KHR_materials_dispersion`.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Dispersion {
    pub(crate) dispersion: f64,
}

/// `KHR_materials_diffuse_transmission`.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct DiffuseTransmission {
    pub(crate) diffuse_transmission_factor: f64,
    pub(crate) diffuse_transmission_texture: Option<Box<TextureInfo>>,
    pub(crate) diffuse_transmission_color_factor: Option<[f64; 3]>,
    pub(crate) diffuse_transmission_color_texture: Option<Box<TextureInfo>>,
}

/// `KHR_materials_volume_scatter`; drafts of the extension named the factor differently.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct VolumeScatter {
    #[serde(alias = "multiscatterColor")]
    pub(crate) multiscatter_color_factor: Option<[f64; 3]>,
    pub(crate) multiscatter_color_texture: Option<Box<TextureInfo>>,
    pub(crate) scatter_anisotropy: f64,
}

/// `KHR_materials_unlit`.
#[derive(Debug, Default, Deserialize)]
pub(crate) struct Unlit {}

/// `KHR_materials_pbrSpecularGlossiness`.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct SpecularGlossiness {
    pub(crate) diffuse_factor: Option<[f64; 4]>,
    pub(crate) diffuse_texture: Option<Box<TextureInfo>>,
    pub(crate) specular_factor: Option<[f64; 3]>,
    pub(crate) glossiness_factor: Option<f64>,
    pub(crate) specular_glossiness_texture: Option<Box<TextureInfo>>,
}

/// A texture: an image and a sampler.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Texture {
    pub(crate) sampler: Option<Index>,
    pub(crate) source: Option<Index>,
    pub(crate) extensions: Option<Box<TextureExtensions>>,
}

/// Extensions of a texture: alternative images.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct TextureExtensions {
    #[serde(rename = "EXT_texture_webp")]
    pub(crate) webp: Option<OtherSource>,
    #[serde(rename = "KHR_texture_basisu")]
    pub(crate) basisu: Option<OtherSource>,
}

/// An image in another format.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct OtherSource {
    pub(crate) source: Option<Index>,
}

/// Filters and wrap modes, as OpenGL constants.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Sampler {
    pub(crate) mag_filter: Option<Index>,
    pub(crate) min_filter: Option<Index>,
    pub(crate) wrap_s: Option<Index>,
    pub(crate) wrap_t: Option<Index>,
}

/// An image.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct ImageJson {
    pub(crate) name: Option<String>,
    pub(crate) uri: Option<String>,
    pub(crate) mime_type: Option<String>,
    pub(crate) buffer_view: Option<Index>,
}

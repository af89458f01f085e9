//! The glTF document, as in the JSON (glTF 2.0 §5 and the schemas of the extensions).
//!
//! Members not declared here are skipped, including `extras` and unknown extensions. Arrays that can be long are
//! [`List`]s, which bound how much memory a few bytes of JSON can allocate.

mod light;
mod material;
mod number;
mod said;

pub(super) use light::*;
pub(super) use material::*;
pub(super) use number::{Index, List, Size};

use std::collections::BTreeMap;

use serde::Deserialize;
use turner::schema::ErrorCode;

use super::fault::{Fault, Outcome};

/// The document.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Document {
    pub(super) asset: Option<Header>,
    pub(super) extensions_used: Vec<String>,
    pub(super) extensions_required: Vec<String>,
    pub(super) scene: Option<Index>,
    pub(super) scenes: List<SceneJson>,
    pub(super) nodes: List<Node>,
    pub(super) meshes: List<Mesh>,
    pub(super) accessors: List<Accessor>,
    pub(super) buffer_views: List<BufferView>,
    pub(super) buffers: List<Buffer>,
    pub(super) materials: List<Material>,
    pub(super) textures: List<Texture>,
    pub(super) samplers: List<Sampler>,
    pub(super) images: List<ImageJson>,
    pub(super) cameras: List<Camera>,
    pub(super) skins: List<Skin>,
    pub(super) animations: List<Animation>,
    pub(super) extensions: DocumentExtensions,
}

/// Extensions of the document itself.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct DocumentExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub(super) lights: Option<Lights>,
    #[serde(rename = "KHR_materials_variants")]
    pub(super) variants: Option<Variants>,
    #[serde(rename = "EXT_lights_image_based")]
    pub(super) environments: Option<Environments>,
}

/// `asset`.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Header {
    pub(super) version: Option<String>,
    pub(super) min_version: Option<String>,
}

/// A scene: a set of root nodes.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct SceneJson {
    pub(super) name: Option<String>,
    pub(super) nodes: Vec<Index>,
    pub(super) extensions: Option<SceneExtensions>,
}

/// Extensions of a scene.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct SceneExtensions {
    #[serde(rename = "EXT_lights_image_based")]
    pub(super) environment: Option<LightReference>,
}

/// A node.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Node {
    pub(super) name: Option<String>,
    pub(super) children: Vec<Index>,
    /// Column-major.
    pub(super) matrix: Option<Box<[f64; 16]>>,
    pub(super) translation: Option<Box<[f64; 3]>>,
    /// (x, y, z, w).
    pub(super) rotation: Option<Box<[f64; 4]>>,
    pub(super) scale: Option<Box<[f64; 3]>>,
    pub(super) mesh: Option<Index>,
    pub(super) skin: Option<Index>,
    pub(super) camera: Option<Index>,
    pub(super) weights: Vec<f64>,
    pub(super) extensions: Option<Box<NodeExtensions>>,
}

/// Extensions of a node.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct NodeExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub(super) light: Option<LightReference>,
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub(super) instancing: Option<Instancing>,
    #[serde(rename = "KHR_node_visibility")]
    pub(super) visibility: Option<Visibility>,
}

/// `KHR_lights_punctual` of a node, or `EXT_lights_image_based` of a scene.
#[derive(Debug, Deserialize)]
pub(super) struct LightReference {
    pub(super) light: Index,
}

/// `EXT_mesh_gpu_instancing`: accessors by attribute name.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Instancing {
    pub(super) attributes: BTreeMap<String, Index>,
}

/// `KHR_node_visibility`.
#[derive(Debug, Deserialize)]
#[serde(default)]
pub(super) struct Visibility {
    pub(super) visible: bool,
}

impl Default for Visibility {
    fn default() -> Self {
        Visibility { visible: true }
    }
}

/// A mesh.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Mesh {
    pub(super) name: Option<String>,
    pub(super) primitives: List<Primitive>,
    pub(super) weights: Vec<f64>,
}

/// A primitive: part of a mesh with one material.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Primitive {
    pub(super) attributes: BTreeMap<String, Index>,
    pub(super) indices: Option<Index>,
    pub(super) material: Option<Index>,
    pub(super) mode: Option<Index>,
    pub(super) targets: Vec<BTreeMap<String, Index>>,
    pub(super) extensions: Option<Box<PrimitiveExtensions>>,
}

/// Extensions of a primitive.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct PrimitiveExtensions {
    #[serde(rename = "KHR_draco_mesh_compression")]
    pub(super) draco: Option<Draco>,
    #[serde(rename = "KHR_materials_variants")]
    pub(super) variants: Option<VariantMappings>,
}

/// `KHR_draco_mesh_compression` of a primitive.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Draco {
    pub(super) buffer_view: Index,
    /// The mesh's own numbers of its attributes.
    pub(super) attributes: BTreeMap<String, Index>,
}

/// `KHR_materials_variants` of a primitive.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct VariantMappings {
    pub(super) mappings: Vec<VariantMapping>,
}

/// A material and the variants in which it is used.
#[derive(Debug, Deserialize)]
pub(super) struct VariantMapping {
    pub(super) material: Index,
    pub(super) variants: Vec<Index>,
}

/// `KHR_materials_variants` of the document.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Variants {
    pub(super) variants: Vec<Variant>,
}

/// A variant.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Variant {
    pub(super) name: String,
}

/// An accessor: typed elements in a buffer view.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Accessor {
    pub(super) buffer_view: Option<Index>,
    pub(super) byte_offset: Size,
    pub(super) component_type: Option<Index>,
    pub(super) normalized: bool,
    pub(super) min: Option<Box<[f64]>>,
    pub(super) max: Option<Box<[f64]>>,
    pub(super) count: Option<Size>,
    #[serde(rename = "type")]
    pub(super) kind: Option<String>,
    pub(super) sparse: Option<Box<Sparse>>,
}

/// Sparse elements of an accessor.
#[derive(Debug, Deserialize)]
pub(super) struct Sparse {
    pub(super) count: Size,
    pub(super) indices: SparseIndices,
    pub(super) values: SparseValues,
}

/// Indices of the sparse elements.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseIndices {
    pub(super) buffer_view: Index,
    #[serde(default)]
    pub(super) byte_offset: Size,
    pub(super) component_type: Index,
}

/// Values of the sparse elements.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseValues {
    pub(super) buffer_view: Index,
    #[serde(default)]
    pub(super) byte_offset: Size,
}

/// A buffer view: a range of a buffer.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct BufferView {
    pub(super) buffer: Option<Index>,
    pub(super) byte_offset: Size,
    pub(super) byte_length: Option<Size>,
    pub(super) byte_stride: Option<Size>,
    pub(super) target: Option<Index>,
    pub(super) extensions: Option<Box<BufferViewExtensions>>,
}

/// Extensions of a buffer view.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct BufferViewExtensions {
    #[serde(rename = "EXT_meshopt_compression", alias = "KHR_meshopt_compression")]
    pub(super) meshopt: Option<Meshopt>,
}

/// `EXT_meshopt_compression` or `KHR_meshopt_compression` of a buffer view.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Meshopt {
    pub(super) buffer: Index,
    #[serde(default)]
    pub(super) byte_offset: Size,
    pub(super) byte_length: Size,
    pub(super) byte_stride: Size,
    pub(super) count: Size,
    pub(super) mode: String,
    pub(super) filter: Option<String>,
}

/// A buffer.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Buffer {
    pub(super) uri: Option<String>,
    pub(super) byte_length: Option<Size>,
    pub(super) extensions: Option<Box<BufferExtensions>>,
}

/// Extensions of a buffer.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct BufferExtensions {
    #[serde(rename = "EXT_meshopt_compression", alias = "KHR_meshopt_compression")]
    pub(super) meshopt: Option<MeshoptFallback>,
}

/// `EXT_meshopt_compression` of a buffer.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct MeshoptFallback {
    pub(super) fallback: bool,
}

/// A camera.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Camera {
    pub(super) name: Option<String>,
    pub(super) perspective: Option<Box<Perspective>>,
    pub(super) orthographic: Option<Box<Orthographic>>,
}

/// A perspective camera.
#[derive(Debug, Deserialize)]
pub(super) struct Perspective {
    /// Vertical field of view, in radians.
    pub(super) yfov: f64,
    #[serde(default)]
    pub(super) znear: f64,
    pub(super) zfar: Option<f64>,
}

/// An orthographic camera.
#[derive(Debug, Deserialize)]
pub(super) struct Orthographic {
    /// Half the width.
    pub(super) xmag: f64,
    /// Half the height.
    pub(super) ymag: f64,
    #[serde(default)]
    pub(super) znear: f64,
    pub(super) zfar: Option<f64>,
}

/// A skin.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Skin {
    pub(super) inverse_bind_matrices: Option<Index>,
    pub(super) skeleton: Option<Index>,
    pub(super) joints: Vec<Index>,
}

/// An animation.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Animation {
    pub(super) name: Option<String>,
    pub(super) channels: List<Channel>,
    pub(super) samplers: List<AnimationSampler>,
}

/// A channel: a sampler and the property that it animates.
#[derive(Debug, Deserialize)]
pub(super) struct Channel {
    pub(super) sampler: Index,
    pub(super) target: Target,
}

/// A property of a node.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Target {
    pub(super) node: Option<Index>,
    pub(super) path: String,
    pub(super) extensions: Option<Box<TargetExtensions>>,
}

/// Extensions of the target of a channel.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct TargetExtensions {
    #[serde(rename = "KHR_animation_pointer")]
    pub(super) pointer: Option<AnimationPointer>,
}

/// `KHR_animation_pointer`: a property by its JSON pointer.
#[derive(Debug, Deserialize)]
pub(super) struct AnimationPointer {
    pub(super) pointer: String,
}

/// A sampler: key times and values.
#[derive(Debug, Deserialize)]
pub(super) struct AnimationSampler {
    pub(super) input: Index,
    pub(super) output: Index,
    pub(super) interpolation: Option<String>,
}

/// The header alone.
#[derive(Deserialize)]
struct Probe {
    asset: Option<Header>,
}

fn first_version(version: &str) -> Fault {
    Fault::at("/asset/version", format!("this is glTF 1.0 (\"{version}\"); expected glTF 2.0"))
        .help("convert it to glTF 2.0")
}

/// Parses a document.
pub(super) fn parse(text: &[u8]) -> Outcome<Document> {
    // GLB pads the JSON with spaces; some writers pad it with zeros.
    let end = text.iter().rposition(|b| *b != 0).map_or(0, |last| last + 1);
    let text = text.get(..end).unwrap_or_default();
    let document: Document = serde_json::from_slice(text).map_err(|e| {
        // The lists of glTF 1.0 are objects.
        if let Ok(Probe { asset: Some(Header { version: Some(version), .. }) }) = serde_json::from_slice(text)
            && version.starts_with("1.")
        {
            return first_version(&version);
        }
        let place = format!("line {} column {}", e.line(), e.column());
        // serde's message repeats the position at its end.
        let said = e.to_string();
        let said = said.strip_suffix(&format!(" at {place}")).unwrap_or(&said);
        Fault::of_file(format!("{place} of the JSON text: {}", said::in_words(said))).code(ErrorCode::Syntax)
    })?;
    let Some(version) = document.asset.as_ref().and_then(|a| a.version.as_deref()) else {
        return Err(Fault::at("/asset/version", "is missing; expected \"2.0\"").help(
            "this may be another kind of JSON; a glTF file contains {\"asset\": {\"version\": \"2.0\"}",
        ));
    };
    let least = document.asset.as_ref().and_then(|a| a.min_version.as_deref()).unwrap_or("2.0");
    if version.starts_with("1.") {
        return Err(first_version(version));
    }
    if !version.starts_with("2.") || !(least == "2.0" || least == "2.1") {
        let found = if version.starts_with("2.") { least } else { version };
        return Err(Fault::at("/asset/version", format!("is \"{found}\"; expected \"2.0\""))
            .help("convert it to glTF 2.0"));
    }
    Ok(document)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(text: &str) -> String {
        parse(text.as_bytes()).map_or_else(|f| f.in_file("a.gltf").message, |_| "read".to_owned())
    }

    #[test]
    fn what_is_not_listed_is_skipped() {
        let text = r#"{"asset":{"version":"2.0","extras":[{}]},"extras":{"a":1},"nodes":[{"mesh":1.0,"extensions":{"X":{}}}]}"#;
        let document = parse(text.as_bytes()).unwrap();
        assert_eq!(document.nodes[Index(0)].mesh, Some(Index(1)));
        assert_eq!(said("{\"asset\":{\"version\":\"2.0\"}} \0\0"), "read");
    }

    #[test]
    fn errors_have_a_place() {
        let message = said("{\"asset\":{\"version\":\"2.0\"},\n \"nodes\": 7}");
        assert!(message.starts_with("a.gltf: line 2 column 11 of the JSON text: "), "{message}");
        assert!(said("{}").contains("/asset/version: is missing"));
        assert!(said(r#"{"asset":{"version":"1.0"}}"#).contains("this is glTF 1.0"));
        assert!(said(r#"{"asset":{"version":"1.0"},"nodes":{"a":{}}}"#).contains("this is glTF 1.0"));
        let info = r#"{"asset":{"version":"2.0"},"materials":[{"normalTexture":{"index":0,"extensions":{"KHR_texture_transform":7}}}]}"#;
        assert!(said(info).ends_with("found the number `7`, expected an object"), "{}", said(info));
        assert!(said("").contains("line 1 column 0"), "{}", said(""));
        let nested = |open: &str| format!("{open}{}{}", "[".repeat(100_000), "]".repeat(100_000));
        let skipped = format!("{{\"asset\":{{\"version\":\"2.0\"}},{}}}", nested("\"extras\":"));
        assert_eq!(said(&skipped), "read");
        assert!(said(&nested("")).contains("line 1 column"), "{}", said(&nested("")));
        assert!(said(r#"{"asset":{"version":"2.0"},"scene":-1}"#).contains("line 1"));
    }
}

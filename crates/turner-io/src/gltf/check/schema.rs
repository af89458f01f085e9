//! The schema of glTF 2.0: types, ranges, required members and references.

/// The kind of a value.
#[derive(Debug)]
pub(super) enum Kind {
    Any,
    Bool,
    /// A number of this range.
    Number(f64, f64),
    /// An integer of this range that is a multiple of `multiple`.
    Whole {
        least: f64,
        most: f64,
        multiple: f64,
    },
    Text,
    /// An index into a list of the document.
    Index(List),
    /// An array with `least` to `most` elements, all different if `unique`.
    Array {
        of: &'static Kind,
        least: usize,
        most: usize,
        unique: bool,
    },
    Object(&'static Object),
    /// Any members of one kind, at least one.
    Map(&'static Kind),
}

impl Kind {
    /// Its name in messages.
    pub(super) fn name(&self) -> &'static str {
        match self {
            Kind::Any => "anything",
            Kind::Bool => "a boolean",
            Kind::Number(..) => "a number",
            Kind::Whole { .. } | Kind::Index(_) => "an integer",
            Kind::Text => "text",
            Kind::Array { .. } => "an array",
            Kind::Object(_) | Kind::Map(_) => "an object",
        }
    }
}

/// The lists that indices refer to.
#[derive(Clone, Copy, Debug)]
pub(super) enum List {
    Accessors,
    BufferViews,
    Buffers,
    Cameras,
    Images,
    Materials,
    Meshes,
    Nodes,
    Samplers,
    Scenes,
    Skins,
    Textures,
    Lights,
    Variants,
    EnvironmentLights,
}

/// The number of [`List`]s.
pub(super) const LISTS: usize = 15;

impl List {
    pub(super) fn name(self) -> &'static str {
        match self {
            List::Accessors => "accessor",
            List::BufferViews => "buffer view",
            List::Buffers => "buffer",
            List::Cameras => "camera",
            List::Images => "image",
            List::Materials => "material",
            List::Meshes => "mesh",
            List::Nodes => "node",
            List::Samplers => "sampler",
            List::Scenes => "scene",
            List::Skins => "skin",
            List::Textures => "texture",
            List::Lights | List::EnvironmentLights => "light",
            List::Variants => "variant",
        }
    }
}

/// An object.
#[derive(Debug)]
pub(super) struct Object {
    /// Its name in messages and in [`EXTENSIONS`](super::extensions::EXTENSIONS).
    pub(super) name: &'static str,
    pub(super) fields: &'static [(&'static str, Kind)],
    pub(super) required: &'static [&'static str],
    /// Members that need another one.
    pub(super) needs: &'static [(&'static str, &'static str)],
    /// Members of which exactly one must be present.
    pub(super) one_of: &'static [&'static str],
}

pub(super) const fn object(
    name: &'static str,
    fields: &'static [(&'static str, Kind)],
    required: &'static [&'static str],
) -> Object {
    Object { name, fields, required, needs: &[], one_of: &[] }
}

pub(super) const MOST: f64 = f64::MAX;
pub(super) const NUMBER: Kind = Kind::Number(-MOST, MOST);
pub(super) const UNIT: Kind = Kind::Number(0.0, 1.0);
pub(super) const POSITIVE: Kind = Kind::Number(f64::MIN_POSITIVE, MOST);
pub(super) const NON_NEGATIVE: Kind = Kind::Number(0.0, MOST);
pub(super) const OFFSET: Kind = Kind::Whole { least: 0.0, most: MOST, multiple: 1.0 };
const COUNT: Kind = Kind::Whole { least: 1.0, most: MOST, multiple: 1.0 };
const STRIDE: Kind = Kind::Whole { least: 4.0, most: 252.0, multiple: 4.0 };

pub(super) const fn some(of: &'static Kind) -> Kind {
    Kind::Array { of, least: 1, most: usize::MAX, unique: false }
}

pub(super) const fn exactly(count: usize, of: &'static Kind) -> Kind {
    Kind::Array { of, least: count, most: count, unique: false }
}

pub(super) const fn set(of: &'static Kind) -> Kind {
    Kind::Array { of, least: 1, most: usize::MAX, unique: true }
}

pub(super) const COLOR: Kind = exactly(3, &UNIT);
const BOUNDS: Kind = Kind::Array { of: &NUMBER, least: 1, most: 16, unique: false };
pub(super) const ATTRIBUTES: Kind = Kind::Map(&Kind::Index(List::Accessors));

static ASSET: Object =
    object("the asset", &[("version", Kind::Text), ("minVersion", Kind::Text)], &["version"]);
static SPARSE_INDICES: Object = object(
    "sparse indices",
    &[("bufferView", Kind::Index(List::BufferViews)), ("byteOffset", OFFSET), ("componentType", OFFSET)],
    &["bufferView", "componentType"],
);
static SPARSE_VALUES: Object = object(
    "sparse values",
    &[("bufferView", Kind::Index(List::BufferViews)), ("byteOffset", OFFSET)],
    &["bufferView"],
);
static SPARSE: Object = object(
    "sparse elements",
    &[("count", COUNT), ("indices", Kind::Object(&SPARSE_INDICES)), ("values", Kind::Object(&SPARSE_VALUES))],
    &["count", "indices", "values"],
);
static ACCESSOR: Object = Object {
    name: "an accessor",
    fields: &[
        ("bufferView", Kind::Index(List::BufferViews)),
        ("byteOffset", OFFSET),
        ("componentType", OFFSET),
        ("normalized", Kind::Bool),
        ("count", COUNT),
        ("type", Kind::Text),
        ("max", BOUNDS),
        ("min", BOUNDS),
        ("sparse", Kind::Object(&SPARSE)),
    ],
    required: &["componentType", "count", "type"],
    needs: &[("byteOffset", "bufferView")],
    one_of: &[],
};
static TARGET: Object =
    object("a target", &[("node", Kind::Index(List::Nodes)), ("path", Kind::Text)], &["path"]);
static CHANNEL: Object =
    object("a channel", &[("sampler", OFFSET), ("target", Kind::Object(&TARGET))], &["sampler", "target"]);
static KEYS: Object = object(
    "an animation sampler",
    &[
        ("input", Kind::Index(List::Accessors)),
        ("output", Kind::Index(List::Accessors)),
        ("interpolation", Kind::Text),
    ],
    &["input", "output"],
);
static ANIMATION: Object = object(
    "an animation",
    &[("channels", some(&Kind::Object(&CHANNEL))), ("samplers", some(&Kind::Object(&KEYS)))],
    &["channels", "samplers"],
);
static BUFFER: Object = object("a buffer", &[("uri", Kind::Text), ("byteLength", COUNT)], &["byteLength"]);
static VIEW: Object = object(
    "a buffer view",
    &[
        ("buffer", Kind::Index(List::Buffers)),
        ("byteOffset", OFFSET),
        ("byteLength", COUNT),
        ("byteStride", STRIDE),
        ("target", OFFSET),
    ],
    &["buffer", "byteLength"],
);
static ORTHOGRAPHIC: Object = object(
    "an orthographic camera",
    &[("xmag", NUMBER), ("ymag", NUMBER), ("zfar", POSITIVE), ("znear", NON_NEGATIVE)],
    &["xmag", "ymag", "zfar", "znear"],
);
static PERSPECTIVE: Object = object(
    "a perspective camera",
    &[("aspectRatio", POSITIVE), ("yfov", POSITIVE), ("zfar", POSITIVE), ("znear", POSITIVE)],
    &["yfov", "znear"],
);
static CAMERA: Object = Object {
    one_of: &["orthographic", "perspective"],
    ..object(
        "a camera",
        &[
            ("type", Kind::Text),
            ("orthographic", Kind::Object(&ORTHOGRAPHIC)),
            ("perspective", Kind::Object(&PERSPECTIVE)),
        ],
        &["type"],
    )
};
static IMAGE: Object = Object {
    name: "an image",
    fields: &[("uri", Kind::Text), ("mimeType", Kind::Text), ("bufferView", Kind::Index(List::BufferViews))],
    required: &[],
    needs: &[("bufferView", "mimeType")],
    one_of: &["uri", "bufferView"],
};

macro_rules! texture_info {
    ($id:ident, $name:literal, $(($more:literal, $kind:expr)),*) => {
        pub(super) static $id: Object = object(
            $name,
            &[("index", Kind::Index(List::Textures)), ("texCoord", OFFSET), $(($more, $kind)),*],
            &["index"],
        );
    };
}
texture_info!(TEXTURE_INFO, "a texture reference",);
texture_info!(NORMAL_INFO, "a texture reference", ("scale", NUMBER));
texture_info!(OCCLUSION_INFO, "a texture reference", ("strength", UNIT));

pub(super) const MAP: Kind = Kind::Object(&TEXTURE_INFO);

static PBR: Object = object(
    "metallic roughness",
    &[
        ("baseColorFactor", exactly(4, &UNIT)),
        ("baseColorTexture", MAP),
        ("metallicFactor", UNIT),
        ("roughnessFactor", UNIT),
        ("metallicRoughnessTexture", MAP),
    ],
    &[],
);
static MATERIAL: Object = object(
    "a material",
    &[
        ("pbrMetallicRoughness", Kind::Object(&PBR)),
        ("normalTexture", Kind::Object(&NORMAL_INFO)),
        ("occlusionTexture", Kind::Object(&OCCLUSION_INFO)),
        ("emissiveTexture", MAP),
        ("emissiveFactor", COLOR),
        ("alphaMode", Kind::Text),
        ("alphaCutoff", NON_NEGATIVE),
        ("doubleSided", Kind::Bool),
    ],
    &[],
);
static PRIMITIVE: Object = object(
    "a primitive",
    &[
        ("attributes", ATTRIBUTES),
        ("indices", Kind::Index(List::Accessors)),
        ("material", Kind::Index(List::Materials)),
        ("mode", Kind::Whole { least: 0.0, most: MOST, multiple: 1.0 }),
        ("targets", some(&ATTRIBUTES)),
    ],
    &["attributes"],
);
static MESH: Object = object(
    "a mesh",
    &[("primitives", some(&Kind::Object(&PRIMITIVE))), ("weights", some(&NUMBER))],
    &["primitives"],
);
static NODE: Object = Object {
    needs: &[("skin", "mesh"), ("weights", "mesh")],
    ..object(
        "a node",
        &[
            ("camera", Kind::Index(List::Cameras)),
            ("children", set(&Kind::Index(List::Nodes))),
            ("skin", Kind::Index(List::Skins)),
            ("matrix", exactly(16, &NUMBER)),
            ("mesh", Kind::Index(List::Meshes)),
            ("rotation", exactly(4, &Kind::Number(-1.0, 1.0))),
            ("scale", exactly(3, &NUMBER)),
            ("translation", exactly(3, &NUMBER)),
            ("weights", some(&NUMBER)),
        ],
        &[],
    )
};
static SAMPLER: Object = object(
    "a sampler",
    &[("magFilter", OFFSET), ("minFilter", OFFSET), ("wrapS", OFFSET), ("wrapT", OFFSET)],
    &[],
);
static SCENE: Object = object("a scene", &[("nodes", set(&Kind::Index(List::Nodes)))], &[]);
static SKIN: Object = object(
    "a skin",
    &[
        ("inverseBindMatrices", Kind::Index(List::Accessors)),
        ("skeleton", Kind::Index(List::Nodes)),
        ("joints", set(&Kind::Index(List::Nodes))),
    ],
    &["joints"],
);
static TEXTURE: Object = object(
    "a texture",
    &[("sampler", Kind::Index(List::Samplers)), ("source", Kind::Index(List::Images))],
    &[],
);
static DOCUMENT: Object = object(
    "the document",
    &[
        ("asset", Kind::Object(&ASSET)),
        ("extensionsUsed", set(&Kind::Text)),
        ("extensionsRequired", set(&Kind::Text)),
        ("accessors", some(&Kind::Object(&ACCESSOR))),
        ("animations", some(&Kind::Object(&ANIMATION))),
        ("buffers", some(&Kind::Object(&BUFFER))),
        ("bufferViews", some(&Kind::Object(&VIEW))),
        ("cameras", some(&Kind::Object(&CAMERA))),
        ("images", some(&Kind::Object(&IMAGE))),
        ("materials", some(&Kind::Object(&MATERIAL))),
        ("meshes", some(&Kind::Object(&MESH))),
        ("nodes", some(&Kind::Object(&NODE))),
        ("samplers", some(&Kind::Object(&SAMPLER))),
        ("scene", Kind::Index(List::Scenes)),
        ("scenes", some(&Kind::Object(&SCENE))),
        ("skins", some(&Kind::Object(&SKIN))),
        ("textures", some(&Kind::Object(&TEXTURE))),
    ],
    &["asset"],
);

/// The whole document.
pub(super) static ROOT: Kind = Kind::Object(&DOCUMENT);

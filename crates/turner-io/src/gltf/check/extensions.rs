//! The schema of the extensions, and where they may be.

use std::f64::consts::FRAC_PI_2;

use super::schema::{
    ATTRIBUTES, COLOR, Kind, List, MAP, MOST, NON_NEGATIVE, NORMAL_INFO, NUMBER, OFFSET, Object, POSITIVE,
    UNIT, exactly, object, set, some,
};

const IN_MATERIAL: &[&str] = &["a material"];
const IN_TEXTURE_INFO: &[&str] = &["a texture reference"];

macro_rules! extension {
    ($name:literal, $of:expr, [$($required:literal),*], $(($field:literal, $kind:expr)),* $(,)?) => {
        ($name, $of, {
            static OBJECT: Object = object($name, &[$(($field, $kind)),*], &[$($required),*]);
            Kind::Object(&OBJECT)
        })
    };
}

static SPOT: Object = object(
    "a spot light",
    &[
        ("innerConeAngle", Kind::Number(0.0, FRAC_PI_2)),
        ("outerConeAngle", Kind::Number(f64::MIN_POSITIVE, FRAC_PI_2)),
    ],
    &[],
);
static LIGHT: Object = object(
    "a light",
    &[
        ("color", COLOR),
        ("intensity", NON_NEGATIVE),
        ("type", Kind::Text),
        ("range", POSITIVE),
        ("spot", Kind::Object(&SPOT)),
    ],
    &["type"],
);
static ENVIRONMENT: Object = object(
    "an environment light",
    &[
        ("rotation", exactly(4, &Kind::Number(-1.0, 1.0))),
        ("intensity", NON_NEGATIVE),
        ("irradianceCoefficients", exactly(9, &exactly(3, &NUMBER))),
        ("specularImages", some(&exactly(6, &Kind::Index(List::Images)))),
        ("specularImageSize", Kind::Whole { least: 1.0, most: MOST, multiple: 1.0 }),
    ],
    &["irradianceCoefficients", "specularImages", "specularImageSize"],
);
static VARIANT: Object = object("a variant", &[("name", Kind::Text)], &["name"]);
static MAPPING: Object = object(
    "a mapping",
    &[("material", Kind::Index(List::Materials)), ("variants", set(&Kind::Index(List::Variants)))],
    &["material", "variants"],
);

/// Extensions, the objects that may have them, and what they contain.
pub(super) static EXTENSIONS: &[(&str, &[&str], Kind)] = &[
    extension!("EXT_mesh_gpu_instancing", &["a node"], ["attributes"], ("attributes", ATTRIBUTES)),
    extension!("EXT_texture_webp", &["a texture"], [], ("source", Kind::Index(List::Images))),
    extension!("KHR_texture_basisu", &["a texture"], [], ("source", Kind::Index(List::Images))),
    extension!(
        "EXT_lights_image_based",
        &["a scene"],
        ["light"],
        ("light", Kind::Index(List::EnvironmentLights))
    ),
    extension!(
        "EXT_lights_image_based",
        &["the document"],
        ["lights"],
        ("lights", some(&Kind::Object(&ENVIRONMENT)))
    ),
    extension!("KHR_animation_pointer", &["a target"], ["pointer"], ("pointer", Kind::Text)),
    extension!("KHR_lights_punctual", &["the document"], ["lights"], ("lights", some(&Kind::Object(&LIGHT)))),
    extension!("KHR_lights_punctual", &["a node"], ["light"], ("light", Kind::Index(List::Lights))),
    extension!(
        "KHR_materials_anisotropy",
        IN_MATERIAL,
        [],
        ("anisotropyStrength", UNIT),
        ("anisotropyRotation", NUMBER),
        ("anisotropyTexture", MAP),
    ),
    extension!(
        "KHR_materials_clearcoat",
        IN_MATERIAL,
        [],
        ("clearcoatFactor", UNIT),
        ("clearcoatTexture", MAP),
        ("clearcoatRoughnessFactor", UNIT),
        ("clearcoatRoughnessTexture", MAP),
        ("clearcoatNormalTexture", Kind::Object(&NORMAL_INFO)),
    ),
    extension!(
        "KHR_materials_diffuse_transmission",
        IN_MATERIAL,
        [],
        ("diffuseTransmissionFactor", UNIT),
        ("diffuseTransmissionTexture", MAP),
        ("diffuseTransmissionColorFactor", exactly(3, &NON_NEGATIVE)),
        ("diffuseTransmissionColorTexture", MAP),
    ),
    extension!("KHR_materials_dispersion", IN_MATERIAL, [], ("dispersion", NON_NEGATIVE)),
    extension!("KHR_materials_emissive_strength", IN_MATERIAL, [], ("emissiveStrength", NON_NEGATIVE)),
    ("KHR_materials_ior", IN_MATERIAL, Kind::Any),
    extension!(
        "KHR_materials_iridescence",
        IN_MATERIAL,
        [],
        ("iridescenceFactor", UNIT),
        ("iridescenceTexture", MAP),
        ("iridescenceIor", Kind::Number(1.0, MOST)),
        ("iridescenceThicknessMinimum", NON_NEGATIVE),
        ("iridescenceThicknessMaximum", NON_NEGATIVE),
        ("iridescenceThicknessTexture", MAP),
    ),
    extension!(
        "KHR_materials_pbrSpecularGlossiness",
        IN_MATERIAL,
        [],
        ("diffuseFactor", exactly(4, &UNIT)),
        ("diffuseTexture", MAP),
        ("specularFactor", COLOR),
        ("glossinessFactor", UNIT),
        ("specularGlossinessTexture", MAP),
    ),
    extension!(
        "KHR_materials_sheen",
        IN_MATERIAL,
        [],
        ("sheenColorFactor", COLOR),
        ("sheenColorTexture", MAP),
        ("sheenRoughnessFactor", UNIT),
        ("sheenRoughnessTexture", MAP),
    ),
    extension!(
        "KHR_materials_specular",
        IN_MATERIAL,
        [],
        ("specularFactor", UNIT),
        ("specularTexture", MAP),
        ("specularColorFactor", exactly(3, &NON_NEGATIVE)),
        ("specularColorTexture", MAP),
    ),
    extension!(
        "KHR_materials_transmission",
        IN_MATERIAL,
        [],
        ("transmissionFactor", UNIT),
        ("transmissionTexture", MAP),
    ),
    ("KHR_materials_unlit", IN_MATERIAL, Kind::Any),
    extension!(
        "KHR_materials_variants",
        &["the document"],
        ["variants"],
        ("variants", some(&Kind::Object(&VARIANT))),
    ),
    extension!(
        "KHR_materials_variants",
        &["a primitive"],
        ["mappings"],
        ("mappings", some(&Kind::Object(&MAPPING))),
    ),
    extension!(
        "KHR_materials_volume",
        IN_MATERIAL,
        [],
        ("thicknessFactor", NON_NEGATIVE),
        ("thicknessTexture", MAP),
        ("attenuationDistance", POSITIVE),
        ("attenuationColor", COLOR),
    ),
    ("KHR_mesh_quantization", &[], Kind::Any),
    extension!("KHR_node_visibility", &["a node"], [], ("visible", Kind::Bool)),
    extension!(
        "KHR_texture_transform",
        IN_TEXTURE_INFO,
        [],
        ("offset", exactly(2, &NUMBER)),
        ("rotation", NUMBER),
        ("scale", exactly(2, &NUMBER)),
        ("texCoord", OFFSET),
    ),
];

use turner::description::SceneDesc;
use turner::material::{MaterialDesc, PrincipledMaterial, SpecularModel};
use turner::schema::ColorSource;

use crate::gltf::testing::{floats, glb, import};

/// The scene of a triangle with one material.
fn scene(material: &str) -> SceneDesc {
    let json = format!(
        r#""nodes":[{{"mesh":0}}],"materials":[{material}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"material":0}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}}],"buffers":[{{"byteLength":36}}]"#
    );
    import(glb(&json, &floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]))).unwrap()
}

fn principled(material: &str) -> PrincipledMaterial {
    match &scene(material).materials[0].value {
        MaterialDesc::Principled(m) => m.clone(),
        other => panic!("{other:?}"),
    }
}

fn constant(source: ColorSource) -> [f32; 3] {
    match source {
        ColorSource::Constant(c) => c.to_array(),
        ColorSource::Texture(_) => panic!("a texture"),
    }
}

#[test]
fn specular_colours_are_factors_of_f0() {
    let m = principled(
        r#"{"extensions":{"KHR_materials_specular":{"specularFactor":0.5,"specularColorFactor":[25,1,0]}}}"#,
    );
    assert_eq!(m.specular_model, SpecularModel::Gltf);
    assert_eq!((constant(m.specular_weight), constant(m.specular_color)), ([0.5; 3], [25.0, 1.0, 0.0]));
    assert_eq!(principled("{}").specular_model, SpecularModel::OpenPbr);
}

/// The specular colour is F₀; 0.04 is that of the index 1.5.
#[test]
fn specular_glossiness_keeps_both_of_its_colours() {
    let of = |specular: &str| {
        principled(&format!(
            r#"{{"extensions":{{"KHR_materials_pbrSpecularGlossiness":{{"glossinessFactor":0.75,{specular}}}}}}}"#
        ))
    };
    let gold = of(r#""diffuseFactor":[0.1,0.1,0.1,1],"specularFactor":[1,0.8,0.4]"#);
    assert_eq!((gold.specular_model, gold.specular_ior), (SpecularModel::Gltf, 1.5));
    assert_eq!((constant(gold.base_metalness), constant(gold.base_color)), ([0.0; 3], [0.1; 3]));
    for (factor, f0) in constant(gold.specular_color).into_iter().zip([1.0, 0.8, 0.4]) {
        assert!((factor * 0.04 - f0).abs() < 1e-6);
    }
    assert_eq!(constant(gold.specular_roughness), [0.25; 3]);
    let metal = of(r#""diffuseFactor":[0,0,0,1],"specularFactor":[1,0.8,0.4]"#);
    assert_eq!((constant(metal.base_metalness), constant(metal.base_color)), ([1.0; 3], [1.0, 0.8, 0.4]));
}

/// KHR_materials_transmission: the base colour tints at the surface, whatever the volume absorbs.
#[test]
fn the_base_colour_tints_glass_with_an_attenuation() {
    let glass = |volume: &str| {
        principled(&format!(
            r#"{{"pbrMetallicRoughness":{{"baseColorFactor":[0.9,0.5,0.1,1]}},"extensions":{{
            "KHR_materials_transmission":{{"transmissionFactor":1}},"KHR_materials_volume":{volume}}}}}"#
        ))
    };
    let m = glass(r#"{"thicknessFactor":1,"attenuationDistance":0.5,"attenuationColor":[0.2,0.3,0.4]}"#);
    assert_eq!(constant(m.transmission_tint), [0.9, 0.5, 0.1]);
    assert_eq!((constant(m.transmission_color), m.transmission_depth), ([0.2, 0.3, 0.4], 0.5));
    let clear = glass(r#"{"thicknessFactor":1}"#);
    assert_eq!(constant(clear.transmission_color), [0.9, 0.5, 0.1]);
    assert_eq!((constant(clear.transmission_tint), clear.transmission_depth), ([1.0; 3], 0.0));
}

//! Imports of complete files, each built in the test.

use turner::camera::CameraDesc;
use turner::color::Spectrum;
use turner::description::{ObjectContent, SceneDesc};
use turner::integrator::{IntegratorDesc, PathDesc};
use turner::light::LightDesc;
use turner::material::{AlphaMode, MaterialDesc, PrincipledMaterial};
use turner::math::{DVec3, degrees};
use turner::schema::{ColorSource, MeshData, PrepareOptions, WarningKind};
use turner::shape::ShapeDesc;
use turner::texture::TextureDesc;

use super::testing::{floats, glb, import, import_with};
use crate::import::ImportOptions;

/// A triangle in the plane z = 0 whose front faces +z, plus additions of the test.
fn triangle(node: &str, primitive: &str, members: &str) -> Vec<u8> {
    let json = format!(
        r#""nodes":[{{"mesh":0{node}}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}{primitive}}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}}],"buffers":[{{"byteLength":36}}]{members}"#
    );
    glb(&json, &floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]))
}

fn mesh(scene: &SceneDesc, object: usize) -> &MeshData {
    match &scene.objects[object].content {
        ObjectContent::Shape(ShapeDesc::Mesh(m)) => &scene.meshes[m.mesh.index()].data,
        other => panic!("{other:?}"),
    }
}

fn material(scene: &SceneDesc) -> &PrincipledMaterial {
    match &scene.materials[scene.objects[0].material.unwrap().index()].value {
        MaterialDesc::Principled(m) => m,
        other => panic!("{other:?}"),
    }
}

fn of_material(json: &str) -> PrincipledMaterial {
    let members = format!(r#","materials":[{json}]"#);
    material(&import(triangle("", r#","material":0"#, &members)).unwrap()).clone()
}

fn constant(source: ColorSource) -> [f32; 3] {
    match source {
        ColorSource::Constant(c) => c.to_array(),
        ColorSource::Texture(_) => panic!("a texture"),
    }
}

fn said(scene: &SceneDesc, kind: WarningKind, text: &str) -> bool {
    scene.warnings.iter().any(|w| w.kind == kind && w.message.contains(text))
}

fn refusal(bytes: Vec<u8>) -> String {
    let error = import(bytes).unwrap_err();
    format!("{}: {}; {}", error.code.as_str(), error.message, error.help.unwrap_or_default())
}

#[test]
fn a_triangle_without_anything_has_the_default_material() {
    let scene = import(triangle(r#","name":"t","translation":[1,2,3]"#, "", "")).unwrap();
    assert_eq!(scene.objects.len(), 1);
    assert_eq!(scene.objects[0].name.as_deref(), Some("t"));
    assert_eq!(scene.objects[0].transform.0.translation, DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(mesh(&scene, 0).triangles, [[0, 1, 2]]);
    let m = material(&scene);
    assert_eq!(constant(m.base_color), [1.0; 3]);
    assert_eq!((constant(m.base_metalness), constant(m.specular_roughness)), ([1.0; 3], [1.0; 3]));
    assert!(!m.double_sided && m.alpha_mode == AlphaMode::Opaque);
    assert!(scene.camera.is_none() && scene.lights.is_empty() && scene.warnings.is_empty());
    let counts = &scene.imports[0].counts;
    assert!(counts.contains(&("triangles", 1)) && counts.contains(&("nodes", 1)));
    scene.prepare(&Default::default()).unwrap();
}

#[test]
fn extensions_that_are_required_and_not_known_are_named() {
    let required = |name: &str| triangle("", "", &format!(r#","extensionsRequired":["{name}"]"#));
    let message = refusal(required("ACME_teapot"));
    assert!(message.starts_with("E0204: a.glb: /extensionsRequired/0: "), "{message}");
    assert!(message.contains("ACME_teapot") && message.contains("KHR_texture_transform"), "{message}");
    for known in ["KHR_texture_basisu", "KHR_draco_mesh_compression", "KHR_mesh_quantization"] {
        assert!(import(required(known)).is_ok(), "{known}");
    }
    let used = import(triangle("", "", r#","extensionsUsed":["ACME_teapot","KHR_materials_ior"]"#)).unwrap();
    assert!(said(&used, WarningKind::Ignored, "ACME_teapot") && used.warnings.len() == 1);
}

#[test]
fn indices_that_name_nothing_are_refused_where_they_stand() {
    let cases = [
        (triangle(r#","skin":4"#, "", ""), "/nodes/0: refers to skin 4, but there are 0"),
        (triangle(r#","camera":1"#, "", ""), "/nodes/0: refers to camera 1"),
        (triangle("", r#","material":2"#, ""), "/meshes/0/primitives/0: refers to material 2"),
        (triangle("", r#","indices":9"#, ""), "/meshes/0/primitives/0: refers to accessor 9"),
        (triangle("", r#","indices":0"#, ""), "/accessors/0: holds indices"),
        (triangle("", r#","mode":12"#, ""), "/meshes/0/primitives/0/mode: is 12"),
        (triangle(r#","extensions":{"KHR_lights_punctual":{"light":0}}"#, "", ""), "refers to light 0"),
        (glb(r#""nodes":[{"mesh":1}]"#, b""), "/nodes/0: refers to mesh 1"),
        (glb(r#""scene":3"#, b""), "/scene: refers to scene 3"),
        (glb(r#""scenes":[{"nodes":[5]}]"#, b""), "/scenes/0/nodes: refers to node 5"),
    ];
    for (bytes, expected) in cases {
        let message = refusal(bytes);
        assert!(message.contains(expected), "{message}");
    }
    let texture = r#","materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":3}}}]"#;
    assert!(refusal(triangle("", r#","material":0"#, texture)).contains("/materials/0: refers to texture 3"));
}

#[test]
fn morph_targets_move_vertices_by_their_weights() {
    let file = |node: &str| {
        let json = format!(
            r#""nodes":[{{"mesh":0{node}}},{{"mesh":0}}],
            "meshes":[{{"weights":[0.5],"primitives":[{{"attributes":{{"POSITION":0}},"targets":[{{"POSITION":1}}]}}]}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}},
                         {{"bufferView":0,"byteOffset":36,"componentType":5126,"count":3,"type":"VEC3"}}],
            "bufferViews":[{{"buffer":0,"byteLength":72}}],"buffers":[{{"byteLength":72}}]"#
        );
        let corners = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        let moves = [0.0, 0.0, 2.0, 0.0, 0.0, 4.0, 0.0, 0.0, 6.0];
        import(glb(&json, &floats(&[corners, moves].concat()))).unwrap()
    };
    let heights = |scene: &SceneDesc, i| mesh(scene, i).positions.iter().map(|p| p[2]).collect::<Vec<_>>();
    let scene = file("");
    assert_eq!(heights(&scene, 0), [1.0, 2.0, 3.0]);
    assert_eq!(scene.meshes.len(), 1);
    let scene = file(r#","weights":[-1]"#);
    assert_eq!(heights(&scene, 0), [-2.0, -4.0, -6.0]);
    assert_eq!((heights(&scene, 1), scene.meshes.len()), (vec![1.0, 2.0, 3.0], 2));
}

/// A mesh with two joints, the second at (10, 0, 0), and the given weights; its own node is far away.
fn skinned(weights: &[f32; 8 * 3], root_scale: &str) -> SceneDesc {
    let json = format!(
        r#""nodes":[{{"mesh":0,"skin":0,"translation":[500,0,0]}},
                 {{"children":[2]{root_scale}}},{{"translation":[10,0,0]}}],
        "skins":[{{"joints":[1,2]}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"JOINTS_0":1,"WEIGHTS_0":2,"JOINTS_1":1,"WEIGHTS_1":3}}}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}},
                     {{"bufferView":1,"componentType":5121,"count":3,"type":"VEC4"}},
                     {{"bufferView":2,"componentType":5126,"count":3,"type":"VEC4"}},
                     {{"bufferView":2,"byteOffset":48,"componentType":5126,"count":3,"type":"VEC4"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":12}},
                       {{"buffer":0,"byteOffset":48,"byteLength":96}}],
        "buffers":[{{"byteLength":144}}]"#
    );
    let corners = floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let joints = [0u8, 1, 99, 99, 0, 1, 99, 99, 0, 1, 99, 99];
    import(glb(&json, &[corners, joints.to_vec(), floats(weights)].concat())).unwrap()
}

#[test]
fn skins_put_vertices_between_their_joints() {
    let mut weights = [0.0; 24];
    // Vertex 0: joint 0 only. Vertex 1: half of each joint, in two sets. Vertex 2: no weights, so it follows the
    // first joint.
    weights[0] = 1.0;
    weights[4] = 0.25;
    weights[12 + 5] = 0.25;
    let scene = skinned(&weights, "");
    assert!(scene.objects[0].transform.is_identity());
    assert_eq!(mesh(&scene, 0).positions, [[0.0, 0.0, 0.0], [6.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    assert_eq!(mesh(&scene, 0).triangles, [[0, 1, 2]]);
    // Mirroring joints must not swap front and back faces.
    let mirrored = skinned(&weights, r#","scale":[-1,1,1]"#);
    assert_eq!(mesh(&mirrored, 0).positions[1], [-6.0, 0.0, 0.0]);
    assert_eq!(mesh(&mirrored, 0).triangles, [[0, 2, 1]]);
}

#[test]
fn flat_and_vanished_nodes_do_no_harm() {
    let flat = import(triangle(r#","scale":[2,3,0]"#, "", "")).unwrap();
    assert!(flat.objects[0].transform.is_identity());
    assert_eq!(mesh(&flat, 0).positions[2], [0.0, 3.0, 0.0]);
    for scale in ["[0,0,0]", "[0,0,1]"] {
        let gone = import(triangle(&format!(r#","scale":{scale}"#), "", "")).unwrap();
        assert!(gone.objects.is_empty() && said(&gone, WarningKind::Doubtful, "scale of 0"));
    }
    let huge = r#","matrix":[1e308,0,0,0,0,1e308,0,0,0,0,1e308,0,0,0,0,1],"children":[]"#;
    assert!(import(triangle(huge, "", "")).is_ok());
    let mirrored = import(triangle(r#","scale":[-1,1,1]"#, "", "")).unwrap();
    assert_eq!(mesh(&mirrored, 0).triangles, [[0, 1, 2]]);
    assert!(mirrored.objects[0].transform.0.matrix3.determinant() < 0.0);
}

#[test]
fn points_and_lines_are_shown_and_said_to_be_approximated() {
    for (mode, text) in [(0, "points"), (1, "lines"), (2, "lines"), (3, "lines")] {
        let scene = import(triangle("", &format!(r#","mode":{mode}"#), "")).unwrap();
        assert!(said(&scene, WarningKind::Approximated, text) && !scene.objects.is_empty());
        scene.prepare(&Default::default()).unwrap();
    }
    for mode in 4..=6 {
        let scene = import(triangle("", &format!(r#","mode":{mode}"#), "")).unwrap();
        assert!(scene.warnings.is_empty() && mesh(&scene, 0).triangles.len() == 1);
    }
}

#[test]
fn lights_keep_their_numbers() {
    let lights = r#","extensions":{"KHR_lights_punctual":{"lights":[
        {"type":"spot","name":"key","intensity":40,"color":[1,0.5,0],"range":3,"spot":{"innerConeAngle":0.5235987755982988,"outerConeAngle":0.7853981633974483}},
        {"type":"directional"},{"type":"point","intensity":7},{"type":"laser"}]}}"#;
    let at = |light: u32| {
        let node = format!(
            r#","translation":[1,2,3],"rotation":[0.7071067811865476,0,0,0.7071067811865476],"extensions":{{"KHR_lights_punctual":{{"light":{light}}}}}"#
        );
        import(triangle(&node, "", lights)).unwrap()
    };
    // A rotation by 90 degrees about x maps −z to +y.
    let scene = at(0);
    let LightDesc::Spot(spot) = &scene.lights[0].value else { panic!() };
    assert_eq!((scene.lights[0].name.as_deref(), spot.intensity), (Some("key"), 40.0));
    assert_eq!(spot.color, Spectrum::new(1.0, 0.5, 0.0));
    assert!((spot.angle - 45.0).abs() < 1e-9 && (spot.penumbra - 15.0).abs() < 1e-9);
    assert!(((spot.look_at - spot.position).normalize() - DVec3::Y).length() < 1e-9);
    assert!(said(&scene, WarningKind::Ignored, "range"));
    let LightDesc::Directional(sun) = &at(1).lights[0].value else { panic!() };
    assert!((sun.direction.unwrap() - DVec3::Y).length() < 1e-9 && sun.intensity == 1.0);
    let LightDesc::Point(point) = &at(2).lights[0].value else { panic!() };
    assert_eq!((point.position, point.intensity), (DVec3::new(1.0, 2.0, 3.0), 7.0));
    assert_eq!(point.attenuation.coefficients, [0.0, 0.0, 1.0]);
    assert!(at(3).lights.is_empty());
}

#[test]
fn cameras_are_in_the_space_of_the_scene() {
    let cameras = r#","cameras":[{"type":"perspective","perspective":{"yfov":0.7853981633974483,"znear":0.1}},
        {"type":"orthographic","orthographic":{"xmag":3,"ymag":2,"zfar":10,"znear":0}},
        {"type":"perspective","perspective":{"yfov":0}}]"#;
    let at = |camera: u32| {
        let node = format!(r#","name":"eye","translation":[0,0,9],"camera":{camera}"#);
        import(triangle(&node, "", cameras)).unwrap()
    };
    let scene = at(0);
    assert_eq!(scene.cameras.len(), 1);
    assert_eq!(scene.camera, Some(scene.cameras[0].clone()));
    assert_eq!(scene.cameras[0].name.as_deref(), Some("eye"));
    let CameraDesc::Pinhole(pinhole) = &scene.cameras[0].value else { panic!() };
    assert!((pinhole.fov.unwrap() - 45.0).abs() < 1e-9);
    assert_eq!((pinhole.look_at - pinhole.position).normalize(), DVec3::NEG_Z);
    let CameraDesc::Orthographic(o) = &at(1).cameras[0].value else { panic!() };
    assert_eq!(o.viewport.size(1.5).to_array(), [6.0, 4.0]);
    let none = at(2);
    assert!(none.camera.is_none() && said(&none, WarningKind::Doubtful, "field of view"));
}

#[test]
fn extensions_of_materials_become_layers() {
    let m = of_material(
        r#"{"name":"m","doubleSided":true,"emissiveFactor":[1,0.5,0],"alphaMode":"MASK","alphaCutoff":0.25,
        "pbrMetallicRoughness":{"baseColorFactor":[0.1,0.2,0.3,0.4],"metallicFactor":0.5,"roughnessFactor":0.25},
        "extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":8},"KHR_materials_ior":{"ior":1.33},
        "KHR_materials_specular":{"specularFactor":0.5,"specularColorFactor":[2,1,1]},
        "KHR_materials_transmission":{"transmissionFactor":0.75},
        "KHR_materials_clearcoat":{"clearcoatFactor":1,"clearcoatRoughnessFactor":0.1},
        "KHR_materials_sheen":{"sheenColorFactor":[0,0.5,0],"sheenRoughnessFactor":0.3},
        "KHR_materials_iridescence":{"iridescenceFactor":1,"iridescenceThicknessMaximum":500},
        "KHR_materials_anisotropy":{"anisotropyStrength":0.6,"anisotropyRotation":1.5},
        "KHR_materials_dispersion":{"dispersion":0.2},"KHR_materials_unlit":{}}}"#,
    );
    assert_eq!(constant(m.base_color), [0.1, 0.2, 0.3]);
    assert_eq!((constant(m.opacity), m.alpha_mode, m.alpha_cutoff), ([0.4; 3], AlphaMode::Mask, 0.25));
    assert_eq!((constant(m.base_metalness), constant(m.specular_roughness)), ([0.5; 3], [0.25; 3]));
    assert_eq!((constant(m.emission_color), m.emission_luminance), ([1.0, 0.5, 0.0], 8.0));
    assert_eq!((m.specular_ior, constant(m.specular_weight)), (1.33, [0.5; 3]));
    assert_eq!(constant(m.specular_color), [2.0, 1.0, 1.0]);
    assert_eq!((constant(m.transmission_weight), m.thin_walled), ([0.75; 3], true));
    assert_eq!(constant(m.transmission_color), [0.1, 0.2, 0.3]);
    assert_eq!((constant(m.coat_weight), constant(m.coat_roughness), m.coat_ior), ([1.0; 3], [0.1; 3], 1.5));
    assert_eq!((constant(m.fuzz_color), constant(m.fuzz_roughness)), ([0.0, 0.5, 0.0], [0.3; 3]));
    assert_eq!((constant(m.thin_film_thickness), m.thin_film_ior), ([0.5; 3], 1.3));
    assert_eq!((constant(m.specular_roughness_anisotropy), m.anisotropy_rotation), ([0.6; 3], degrees(1.5)));
    assert_eq!((m.transmission_dispersion_scale, m.unlit, m.double_sided), (f64::from(0.2f32), true, true));
}

#[test]
fn a_volume_with_thickness_is_solid_and_colours_by_distance() {
    let glass = |volume: &str| {
        of_material(&format!(
            r#"{{"extensions":{{"KHR_materials_transmission":{{"transmissionFactor":1}},"KHR_materials_volume":{volume}}}}}"#
        ))
    };
    let m = glass(r#"{"thicknessFactor":2,"attenuationDistance":0.5,"attenuationColor":[1,0,0]}"#);
    assert_eq!((m.thin_walled, m.transmission_depth, constant(m.thickness)), (false, 0.5, [2.0; 3]));
    assert_eq!(constant(m.transmission_color), [1.0, 0.0, 0.0]);
    let thin = glass(r#"{"attenuationDistance":0.5,"attenuationColor":[1,0,0]}"#);
    assert_eq!((thin.thin_walled, thin.transmission_depth), (true, 0.0));
    let clear = glass(r#"{"thicknessFactor":2}"#);
    assert_eq!((clear.thin_walled, clear.transmission_depth), (false, 0.0));
}

#[test]
fn light_is_scattered_inside_of_solids() {
    let body = |volume: &str, more: &str| {
        of_material(&format!(
            r#"{{"extensions":{{"KHR_materials_diffuse_transmission":{{"diffuseTransmissionFactor":0.75,"diffuseTransmissionColorFactor":[1,0.5,0.25]}},
            "KHR_materials_volume":{volume}{more}}}}}"#
        ))
    };
    let volume = r#"{"thicknessFactor":2,"attenuationDistance":0.5,"attenuationColor":[0.5,0.25,0.0625]}"#;
    let m = body(volume, "");
    assert_eq!((m.thin_walled, constant(m.subsurface_weight)), (false, [0.75; 3]));
    assert_eq!(constant(m.subsurface_color), [1.0, 0.5, 0.25]);
    // Half the light remains after 0.5: the mean free path is 0.5 / ln 2.
    assert!((m.subsurface_radius - 0.5 / std::f64::consts::LN_2).abs() < 1e-6);
    let [r, g, b] = constant(m.subsurface_radius_scale);
    assert!(r == 1.0 && (g - 0.5).abs() < 1e-6 && (b - 0.25).abs() < 1e-6);
    for color in ["multiscatterColorFactor", "multiscatterColor"] {
        let scatter = format!(
            r#","KHR_materials_volume_scatter":{{"{color}":[0.9,0.6,0.3],"scatterAnisotropy":-0.5}}"#
        );
        let m = body(volume, &scatter);
        assert_eq!((constant(m.subsurface_color), m.subsurface_scatter_anisotropy), ([0.9, 0.6, 0.3], -0.5));
    }
    assert!(body("{}", "").thin_walled);
}

#[test]
fn variants_choose_materials() {
    let members = r#","materials":[{"name":"a"},{"name":"b"}],
        "extensions":{"KHR_materials_variants":{"variants":[{"name":"red"},{"name":"blue"}]}}"#;
    let primitive = r#","material":0,"extensions":{"KHR_materials_variants":{"mappings":[{"material":1,"variants":[1]}]}}"#;
    let named = |variant: Option<&str>| -> Result<String, turner::schema::SceneError> {
        let options = ImportOptions { variant: variant.map(str::to_owned), ..ImportOptions::default() };
        let scene = import_with(triangle("", primitive, members), &options)?;
        Ok(scene.materials[0].name.clone().unwrap())
    };
    assert_eq!(named(None), Ok("a".to_owned()));
    assert_eq!(named(Some("red")), Ok("a".to_owned()));
    assert_eq!(named(Some("blue")), Ok("b".to_owned()));
    assert_eq!(named(Some("1")), Ok("b".to_owned()));
    let error = named(Some("blu")).unwrap_err();
    assert!(error.message.contains("no variant \"blu\"") && error.help.unwrap().contains("\"blue\""));
}

#[test]
fn a_missing_image_is_named_and_its_factor_stays() {
    let members = |image: &str| {
        format!(
            r#","materials":[{{"pbrMetallicRoughness":{{"baseColorFactor":[0.5,1,1,1],"baseColorTexture":{{"index":0}}}}}}],
            "textures":[{{"source":0}}],"images":[{image}]"#
        )
    };
    for (image, name) in [
        (r#"{"uri":"wood.png"}"#, "wood.png"),
        (r#"{"uri":"../../etc/passwd"}"#, "passwd"),
        (r#"{"uri":"%2e%2e/secret.png"}"#, "secret"),
        (r#"{"uri":"file:///etc/passwd"}"#, "passwd"),
        (r#"{"uri":"data:image/png;base64,iVBORw0K"}"#, "image 0"),
        (r#"{"name":"label","bufferView":0,"mimeType":"image/png"}"#, "label"),
        (r#"{"name":"none"}"#, "none"),
    ] {
        let scene = import(triangle("", r#","material":0"#, &members(image))).unwrap();
        assert!(said(&scene, WarningKind::Ignored, name), "{image}: {:?}", scene.warnings);
        assert_eq!(constant(material(&scene).base_color), [0.5, 1.0, 1.0]);
    }
}

#[test]
fn pictures_are_shared_and_looked_up_as_samplers_say() {
    // An image of one pixel.
    let png =
        "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8z8BQDwAEhQGAhKmMIQAAAABJRU5ErkJggg==";
    let members = format!(
        r#","materials":[{{"alphaMode":"BLEND","pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}},"metallicRoughnessTexture":{{"index":1,"texCoord":1}}}},
            "normalTexture":{{"index":1,"scale":0.5}},"occlusionTexture":{{"index":1,"strength":0.25}}}}],
        "textures":[{{"source":0,"sampler":0}},{{"source":0}}],"samplers":[{{"magFilter":9728,"wrapS":33071,"wrapT":33648}}],
        "images":[{{"uri":"data:image/png;base64,{png}"}}]"#
    );
    let scene = import(triangle("", r#","material":0"#, &members)).unwrap();
    assert_eq!(scene.images.len(), 1);
    let m = material(&scene);
    let image = |source: ColorSource| match source {
        ColorSource::Texture(id) => match &scene.textures[id.index()].value {
            TextureDesc::Image(image) => image.clone(),
            other => panic!("{other:?}"),
        },
        ColorSource::Constant(_) => panic!("a constant"),
    };
    use turner::texture::{Encoding, ImageChannel, ImageFilter, Wrap};
    let base = image(m.base_color);
    assert_eq!((base.filter, base.encoding, base.uv_set), (ImageFilter::NearestMipmap, Encoding::Srgb, 0));
    assert_eq!((base.wrap_u, base.wrap_v), (Some(Wrap::Clamp), Some(Wrap::Mirror)));
    assert_eq!(image(m.opacity).channel, ImageChannel::A);
    let (metal, rough) = (image(m.base_metalness), image(m.specular_roughness));
    assert_eq!(
        (metal.channel, rough.channel, rough.encoding),
        (ImageChannel::B, ImageChannel::G, Encoding::Linear)
    );
    assert_eq!((metal.uv_set, metal.wrap_u, metal.filter), (1, Some(Wrap::Repeat), ImageFilter::Mipmap));
    assert_eq!((m.normal_scale, m.occlusion_strength), (0.5, 0.25));
    assert_eq!(image(m.occlusion_map.unwrap()).channel, ImageChannel::R);
    assert!(said(&scene, WarningKind::Doubtful, "texture coordinates"));
    scene.prepare(&Default::default()).unwrap();
}

#[test]
fn instances_share_their_mesh() {
    let json = r#""nodes":[{"mesh":0,"scale":[2,2,2],"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":0}}}}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
        "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36}]"#;
    let scene = import(glb(json, &floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]))).unwrap();
    assert_eq!((scene.objects.len(), scene.meshes.len()), (3, 1));
    assert_eq!(scene.objects[2].transform.0.translation, DVec3::new(0.0, 2.0, 0.0));
    assert!(scene.imports[0].counts.contains(&("instances", 3)));
}

/// All nodes show the same triangle at the same position. Preparation must not trace probe rays here: with them it
/// took two minutes.
#[test]
fn two_hundred_thousand_nodes_under_one_another_are_prepared() {
    let count = 200_000;
    let node = |i: usize| match i + 1 {
        next if next < count => format!(r#"{{"mesh":0,"children":[{next}]}}"#),
        _ => r#"{"mesh":0}"#.to_owned(),
    };
    let nodes: Vec<String> = (0..count).map(node).collect();
    let members = format!(
        r#""scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{}],"buffers":[{{"byteLength":36}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}]"#,
        nodes.join(",")
    );
    let mut desc = import(glb(&members, &floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]))).unwrap();
    desc.integrator = IntegratorDesc::Path(PathDesc::default());
    let scene = desc.prepare(&PrepareOptions::default()).unwrap();
    assert_eq!(scene.scene.stats.primitives, count as u64);
    assert!(!scene.integrator.shares_paths());
}

//! Materials.

use super::*;

/// A triangle with the material of these shaders.
fn look(shaders: &str) -> String {
    triangle(&format!(
        "texCoord2f[] primvars:st = [(0, 0), (1, 0), (0, 1)] (interpolation = \"vertex\")\n\
         texCoord2f[] primvars:map2 = [(0, 0), (1, 0), (0, 1)] (interpolation = \"vertex\")\n\
         rel material:binding = </T/Look>\n def Material \"Look\" {{ token outputs:surface.connect = </T/Look/S.outputs:surface>\n{shaders} }}"
    ))
}

fn surface(inputs: &str) -> PrincipledMaterial {
    let text =
        look(&format!("def Shader \"S\" {{ uniform token info:id = \"UsdPreviewSurface\"\n{inputs} }}"));
    let scene = read(&text);
    assert_eq!(scene.warnings, [], "{inputs}");
    principled(&scene, 0).clone()
}

fn grey(v: f32) -> ColorSource {
    ColorSource::Constant(Spectrum::grey(v))
}

#[test]
fn constants_become_those_of_the_principled_material() {
    let plain = surface("");
    assert_eq!(
        (plain.base_color, plain.specular_roughness, plain.base_metalness),
        (grey(0.18), grey(0.5), grey(0.0))
    );
    assert_eq!(
        (plain.alpha_mode, plain.emission_luminance, plain.specular_ior),
        (AlphaMode::Opaque, 0.0, 1.5)
    );
    let m = surface(
        "color3f inputs:diffuseColor = (1, 0.5, 0)\n float inputs:metallic = 1\n float inputs:roughness = 0.25\n float inputs:ior = 1.8\n\
         color3f inputs:emissiveColor = (2, 0, 0)\n float inputs:clearcoat = 0.5\n float inputs:clearcoatRoughness = 0.1",
    );
    assert_eq!(m.base_color, ColorSource::Constant(Spectrum::new(1.0, 0.5, 0.0)));
    assert_eq!(
        (m.base_metalness, m.specular_roughness, m.specular_ior),
        (grey(1.0), grey(0.25), f64::from(1.8_f32))
    );
    assert_eq!(
        (m.emission_color, m.emission_luminance),
        (ColorSource::Constant(Spectrum::new(2.0, 0.0, 0.0)), 1.0)
    );
    assert_eq!((m.coat_weight, m.coat_roughness), (grey(0.5), grey(0.1)));
    // A dielectric of index 1.5 reflects 0.04.
    let m = surface(
        "int inputs:useSpecularWorkflow = 1\n color3f inputs:specularColor = (0.04, 0.08, 0)\n float inputs:metallic = 1",
    );
    let ColorSource::Constant(c) = m.specular_color else { panic!() };
    assert!(
        (c.r - 1.0).abs() < 1e-6 && (c.g - 2.0).abs() < 1e-6 && c.b == 0.0 && m.base_metalness == grey(0.0)
    );
    let m = surface("float inputs:opacity = 0.5");
    assert_eq!((m.alpha_mode, m.opacity), (AlphaMode::Blend, grey(0.5)));
    let m = surface("float inputs:opacity = 0.5\n float inputs:opacityThreshold = 0.25");
    assert_eq!((m.alpha_mode, m.alpha_cutoff), (AlphaMode::Mask, 0.25));
}

#[test]
fn inputs_may_come_from_the_material() {
    let text = look(
        "color3f inputs:paint = (0, 0, 1)\n def Shader \"S\" { uniform token info:id = \"UsdPreviewSurface\"\n\
         color3f inputs:diffuseColor.connect = </T/Look.inputs:paint> }",
    );
    assert_eq!(principled(&read(&text), 0).base_color, ColorSource::Constant(Spectrum::new(0.0, 0.0, 1.0)));
}

/// A scene whose surface input is connected to a texture with these attributes.
fn textured(input: &str, output: &str, more: &str) -> (SceneDesc, turner::texture::ImageDesc) {
    let text = look(&format!(
        "def Shader \"S\" {{ uniform token info:id = \"UsdPreviewSurface\"\n {input}.connect = </T/Look/P.outputs:{output}> }}\n\
         def Shader \"P\" {{ uniform token info:id = \"UsdUVTexture\"\n asset inputs:file = @p.png@\n\
         float2 inputs:st.connect = </T/Look/M.outputs:result>\n{more} }}\n\
         def Shader \"M\" {{ uniform token info:id = \"UsdTransform2d\"\n float2 inputs:in.connect = </T/Look/R.outputs:result>\n\
         float inputs:rotation = 90\n float2 inputs:scale = (2, 3)\n float2 inputs:translation = (0.5, 0.25) }}\n\
         def Shader \"R\" {{ uniform token info:id = \"UsdPrimvarReader_float2\"\n string inputs:varname = \"map2\" }}"
    ));
    let mut assets = MemoryAssets::default();
    let picture = crate::testing::seeds::seeds().into_iter().find(|s| s.name == "picture.png").unwrap();
    assets.files.insert("p.png".into(), picture.bytes);
    let text = format!("#usda 1.0\n{text}");
    let scene = import(text.into_bytes(), "a.usda", &assets, &ImportOptions::default()).unwrap();
    let image = scene.textures.iter().find_map(|t| match &t.value {
        TextureDesc::Image(image) => Some(image.clone()),
        _ => None,
    });
    let image = image.unwrap();
    (scene, image)
}

#[test]
fn textures_have_channels_transforms_and_encodings() {
    let (scene, image) =
        textured("color3f inputs:diffuseColor", "rgb", "float4 inputs:scale = (0.5, 1, 2, 1)");
    assert!(matches!(principled(&scene, 0).base_color, ColorSource::Texture(_)));
    assert_eq!((image.channel, image.encoding, image.uv_set), (ImageChannel::Rgb, Encoding::Srgb, 0));
    assert_eq!(image.tint, Spectrum::new(0.5, 1.0, 2.0));
    // The set that the material uses is the mesh's first. (1, 0) is scaled to (2, 0), turned to (0, 2), moved.
    let [a, b, c, d, e, f] = image.uv_matrix.unwrap();
    for ([u, v], [x, y]) in [([1.0, 0.0], [0.5, 2.25]), ([0.0, 1.0], [-2.5, 0.25])] {
        assert!((a * u + b * v + c - x).abs() < 1e-12 && (d * u + e * v + f - y).abs() < 1e-12);
    }
    let (scene, image) = textured(
        "float inputs:roughness",
        "g",
        "token inputs:sourceColorSpace = \"raw\"\n token inputs:wrapS = \"mirror\"",
    );
    assert!(matches!(principled(&scene, 0).specular_roughness, ColorSource::Texture(_)));
    assert_eq!((image.channel, image.encoding), (ImageChannel::G, Encoding::Linear));
    assert_eq!(
        (image.wrap_u, image.wrap_v),
        (Some(turner::texture::Wrap::Mirror), Some(turner::texture::Wrap::Repeat))
    );
    let (scene, image) = textured("float inputs:opacity", "a", "");
    assert_eq!((principled(&scene, 0).alpha_mode, image.channel), (AlphaMode::Blend, ImageChannel::A));
    let bias = "float4 inputs:scale = (2, -2, 2, 1)\n float4 inputs:bias = (-1, 1, -1, 0)";
    let (scene, image) = textured("normal3f inputs:normal", "rgb", bias);
    assert!(principled(&scene, 0).normal_map.is_some());
    // Green is flipped: 1 − v.
    assert_eq!((image.tint, image.offset), (Spectrum::new(1.0, -1.0, 1.0), Spectrum::new(0.0, 1.0, 0.0)));
    scene.prepare(&Default::default()).unwrap();
}

#[test]
fn a_missing_picture_leaves_the_fallback() {
    let text = look(
        "def Shader \"S\" { uniform token info:id = \"UsdPreviewSurface\"\n color3f inputs:diffuseColor.connect = </T/Look/P.outputs:rgb> }\n\
         def Shader \"P\" { uniform token info:id = \"UsdUVTexture\"\n asset inputs:file = @none.png@\n float4 inputs:fallback = (0, 1, 0, 1) }",
    );
    let scene = read(&text);
    assert_eq!(principled(&scene, 0).base_color, ColorSource::Constant(Spectrum::new(0.0, 1.0, 0.0)));
    assert!(scene.warnings[0].message.contains("none.png"), "{:?}", scene.warnings);
}

#[test]
fn packages_contain_their_textures() {
    let seed = crate::testing::seeds::seeds().into_iter().find(|s| s.name == "model.usdz").unwrap();
    let scene = import(seed.bytes, "in/a.usdz", &MemoryAssets::default(), &ImportOptions::default()).unwrap();
    assert_eq!(scene.warnings, []);
    assert_eq!((scene.images.len(), scene.images[0].data.width), (1, 8));
    assert!(matches!(principled(&scene, 0).base_color, ColorSource::Texture(_)));
}

#[test]
fn bindings_come_from_ancestors() {
    let color = |mesh: &str, strength: &str| {
        let material = |name: &str, color: &str| {
            format!(
                "def Material \"{name}\" {{ token outputs:surface.connect = </L/{name}/S.outputs:surface>\n\
                 def Shader \"S\" {{ uniform token info:id = \"UsdPreviewSurface\"\n color3f inputs:diffuseColor = {color} }} }}"
            )
        };
        let scene = read(&format!(
            "def Xform \"A\" {{ rel material:binding = </L/Red>{strength}\n{} }}\ndef Scope \"L\" {{ {}\n{} }}",
            triangle(mesh),
            material("Red", "(1, 0, 0)"),
            material("Blue", "(0, 0, 1)")
        ));
        let ColorSource::Constant(c) = principled(&scene, 0).base_color else { panic!() };
        [c.r, c.b]
    };
    let blue = "rel material:binding = </L/Blue>";
    assert_eq!(color("", ""), [1.0, 0.0]);
    assert_eq!(color(blue, ""), [0.0, 1.0]);
    assert_eq!(color(blue, " (bindMaterialAs = \"strongerThanDescendants\")"), [1.0, 0.0]);
    let full = "rel material:binding = </L/Red>\n rel material:binding:full = </L/Blue>";
    assert_eq!(color(full, ""), [0.0, 1.0]);
}

#[test]
fn unknown_materials_are_named() {
    let text = look("def Shader \"S\" { uniform token info:id = \"ND_standard_surface_surfaceshader\" }");
    let scene =
        read(&text.replace("rel material", "color3f[] primvars:displayColor = [(0, 1, 0)]\n rel material"));
    let warning = &scene.warnings[0];
    assert_eq!(warning.kind, WarningKind::Approximated);
    assert!(warning.message.contains("\"Look\" is ND_standard_surface_surfaceshader"), "{}", warning.message);
    assert!(matches!(principled(&scene, 0).base_color, ColorSource::Texture(_)));
}

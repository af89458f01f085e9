//! Tests of the import.

use turner::color::Spectrum;
use turner::description::{ObjectContent, SceneDesc};
use turner::light::LightDesc;
use turner::material::{MaterialDesc, PrincipledMaterial};
use turner::math::{DAffine3, DVec3};
use turner::schema::{ColorSource, ErrorCode, SceneError, WarningKind};
use turner::shape::ShapeDesc;
use turner::texture::{Mapping, PerlinKind, TextureDesc};

use super::import;
use crate::assets::MemoryAssets;
use crate::import::ImportOptions;

pub(super) fn read_with(text: &str, files: &[(&str, &[u8])]) -> Result<SceneDesc, SceneError> {
    let mut assets = MemoryAssets::default();
    assets.files.insert("scene.pbrt".into(), text.as_bytes().to_vec());
    for (name, bytes) in files {
        assets.files.insert((*name).into(), bytes.to_vec());
    }
    import("scene.pbrt", &assets, &ImportOptions::default())
}

pub(super) fn read(text: &str) -> SceneDesc {
    read_with(text, &[]).unwrap_or_else(|e| panic!("{e} {:?}", e.help))
}

fn refused(text: &str) -> SceneError {
    read_with(text, &[]).expect_err("refused")
}

/// A scene with this world block.
pub(super) fn world(text: &str) -> SceneDesc {
    read(&format!("WorldBegin\n{text}"))
}

/// The material of the only object.
pub(super) fn material(text: &str) -> PrincipledMaterial {
    let scene = world(&format!("{text}\nShape \"sphere\""));
    match &scene.materials[scene.objects[0].material.unwrap().index()].value {
        MaterialDesc::Principled(m) => m.clone(),
        other => panic!("{other:?}"),
    }
}

fn grey(v: f32) -> ColorSource {
    ColorSource::Constant(Spectrum::grey(v))
}

pub(super) fn value(source: ColorSource) -> f32 {
    match source {
        ColorSource::Constant(c) => c.r,
        ColorSource::Texture(_) => panic!("a texture"),
    }
}

#[test]
fn transforms_multiply_from_the_right() {
    let scene = world("Translate 1 2 3\nScale 2 2 2\nRotate 90 0 0 1\nShape \"disk\"");
    let t = scene.objects[0].transform.0;
    assert!((t.transform_point3(DVec3::X) - DVec3::new(1.0, 4.0, 3.0)).length() < 1e-12);
    let text = "AttributeBegin Translate 1 0 0 CoordinateSystem \"here\" AttributeEnd\nTransformBegin CoordSysTransform \"here\" Shape \"disk\" TransformEnd Shape \"disk\"";
    let scene = world(text);
    assert_eq!(scene.objects[0].transform.0, DAffine3::from_translation(DVec3::X));
    assert_eq!(scene.objects[1].transform.0, DAffine3::IDENTITY);
    let scene = world("ActiveTransform EndTime Translate 0 1 0 ActiveTransform All Shape \"disk\"");
    assert_eq!(scene.objects[0].motion.unwrap().0, DAffine3::from_translation(DVec3::Y));
}

#[test]
fn normals_decide_which_side_is_outside() {
    let mesh = |before: &str, n: &str| {
        let scene = world(&format!(
            "{before}\nShape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2] {n}"
        ));
        scene.meshes[0].data.triangles[0]
    };
    assert_eq!(mesh("", ""), [0, 1, 2]);
    assert_eq!(mesh("ReverseOrientation", ""), [0, 2, 1]);
    let down = "\"normal N\" [0 0 -1 0 0 -1 0 0 -1]";
    assert_eq!(mesh("", down), [0, 2, 1]);
    assert_eq!(mesh("ReverseOrientation", down), [0, 1, 2]);
}

#[test]
fn roughness_is_remapped_unless_it_is_not() {
    // α = √r, and Turner's roughness is √α.
    let m = material(
        "Material \"conductor\" \"float roughness\" 0.0625 \"spectrum eta\" \"metal-Au-eta\" \"spectrum k\" \"metal-Au-k\"",
    );
    assert!((value(m.specular_roughness) - 0.5).abs() < 1e-6);
    assert_eq!(m.base_metalness, grey(1.0));
    let m = material(
        "Material \"dielectric\" \"float roughness\" 0.25 \"bool remaproughness\" false \"float eta\" 1.33",
    );
    assert!((value(m.specular_roughness) - 0.5).abs() < 1e-6);
    assert_eq!(m.specular_ior, 1.33);
    let m = material(
        "Material \"conductor\" \"float uroughness\" 0.4 \"float vroughness\" 0.1 \"bool remaproughness\" false",
    );
    let (r, a) = (f64::from(value(m.specular_roughness)), f64::from(value(m.specular_roughness_anisotropy)));
    let long = r * r * (2.0 / (1.0 + (1.0 - a) * (1.0 - a))).sqrt();
    assert!(
        (long - 0.4).abs() < 1e-6 && (long * (1.0 - a) - 0.1).abs() < 1e-6 && m.anisotropy_rotation == 0.0
    );
}

#[test]
fn metals_have_the_colours_of_pbrt() {
    // From pbrt-v4's η and k at each nanometre under D65. Red, 1.022, lies outside Rec. 709 and is clipped.
    let m =
        material("Material \"conductor\" \"spectrum eta\" \"metal-Au-eta\" \"spectrum k\" \"metal-Au-k\"");
    let ColorSource::Constant(gold) = m.base_color else { panic!("a colour") };
    for (found, expected) in gold.to_array().into_iter().zip([1.0, 0.7825, 0.3434]) {
        assert!((found - expected).abs() < 0.004, "{gold:?}");
    }
    assert!(m.specular_multiple_scattering, "a mirror has no microfacets");
    let m = material("Material \"conductor\" \"float roughness\" 0.1");
    assert!(!m.specular_multiple_scattering, "pbrt follows light to one microfacet");
}

#[test]
fn layers_take_light() {
    let base = |text: &str| {
        let m = material(&format!("Material \"coateddiffuse\" \"rgb reflectance\" [0.5 0.5 0.5] {text}"));
        f64::from(value(m.base_color))
    };
    let clear = base("\"float thickness\" 0");
    // A smooth clear layer: ρ (1 − R) / (1 − ρ R), R = 0.5963.
    assert!((clear - 0.5 * 0.4037 / (1.0 - 0.5 * 0.5963)).abs() < 2e-3, "{clear}");
    let (plain, thick, rough) = (base(""), base("\"float thickness\" 0.1"), base("\"float roughness\" 0.2"));
    assert!(thick < plain && plain < clear && rough < 0.8 * plain, "{thick} {plain} {clear} {rough}");
}

#[test]
fn thin_walls_reflect_and_transmit_what_they_say() {
    for (r, t) in [(0.25, 0.25), (0.6, 0.2), (0.1, 0.7), (0.0, 0.5), (0.5, 0.0)] {
        let m = material(&format!(
            "Material \"diffusetransmission\" \"rgb reflectance\" [{r} {r} {r}] \"rgb transmittance\" [{t} {t} {t}]"
        ));
        let w = value(m.subsurface_weight);
        let found = ((1.0 - w) * value(m.base_color), w * value(m.subsurface_color));
        assert!((found.0 - r).abs() < 1e-6 && (found.1 - t).abs() < 1e-6, "{r} {t}: {found:?}");
    }
    // Together at most 1 in each band, though no weights keep both colours below 1.
    let m = material(
        "Material \"diffusetransmission\" \"rgb reflectance\" [.9 .1 .3] \"rgb transmittance\" [.1 .8 .6]",
    );
    let w = value(m.subsurface_weight);
    let (ColorSource::Constant(c), ColorSource::Constant(s)) = (m.base_color, m.subsurface_color) else {
        panic!()
    };
    for (found, expected) in [(c * (1.0 - w), [0.9, 0.1, 0.3]), (s * w, [0.1, 0.8, 0.6])] {
        assert!(found.to_array().into_iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
    }
}

#[test]
fn integrators_without_media_show_none() {
    let scene = |integrator: &str| {
        read(&format!(
            "Integrator \"{integrator}\" MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" MediumInterface \"\" \"fog\"\n             Camera \"perspective\" WorldBegin MediumInterface \"fog\" \"\" Material \"interface\" Shape \"sphere\"\n             MediumInterface \"\" \"fog\" Material \"diffuse\" Shape \"disk\""
        ))
    };
    let inside = |scene: &SceneDesc| match &scene.materials[0].value {
        MaterialDesc::Interface(b) => b.interior,
        other => panic!("{other:?}"),
    };
    let (with, without) = (scene("volpath"), scene("path"));
    assert!(inside(&with).is_some() && with.warnings.is_empty(), "{:?}", with.warnings);
    assert_eq!((inside(&without), without.background.medium), (None, None));
    assert!(
        without.warnings.iter().any(|w| w.message.contains("volpath renders media")),
        "{:?}",
        without.warnings
    );
}

#[test]
fn lights_have_the_strength_of_pbrt() {
    let light = |text: &str| world(text).lights[0].value.clone();
    let LightDesc::Point(p) =
        light("Translate 1 0 0 LightSource \"point\" \"rgb I\" [10 20 30] \"float scale\" 2")
    else {
        panic!()
    };
    assert_eq!((p.position, p.color, p.intensity), (DVec3::X, Spectrum::new(10.0, 20.0, 30.0), 2.0));
    let LightDesc::Point(p) = light("LightSource \"point\" \"float power\" 100 \"blackbody I\" 5000") else {
        panic!()
    };
    assert!(
        (p.intensity - 100.0 / (4.0 * std::f64::consts::PI)).abs() < 1e-9
            && (p.color.luminance() - 1.0).abs() < 1e-3
    );
    let LightDesc::Directional(d) = light(
        "LightSource \"distant\" \"point3 from\" [0 5 0] \"point3 to\" [0 0 0] \"float illuminance\" 3",
    ) else {
        panic!()
    };
    assert_eq!((d.direction, d.intensity), (Some(DVec3::NEG_Y), 3.0));
    let LightDesc::Environment(e) = light("LightSource \"infinite\" \"rgb L\" [.4 .45 .5]") else { panic!() };
    assert_eq!((e.tint, e.strength), (Spectrum::new(0.4, 0.45, 0.5), 1.0));
    // ISO and exposure time scale all light.
    let scene = read(
        "Film \"rgb\" \"float iso\" 200\nCamera \"perspective\" \"float shutterclose\" 0.25\nWorldBegin LightSource \"point\"",
    );
    let LightDesc::Point(p) = &scene.lights[0].value else { panic!() };
    assert!((p.intensity - 0.5).abs() < 1e-9);
    let m = material("AreaLightSource \"diffuse\" \"rgb L\" [1 2 3] \"float scale\" 5");
    assert_eq!((m.emission_luminance, m.emission_front_only), (5.0, true));
    let m = material("AreaLightSource \"diffuse\" \"bool twosided\" true \"float power\" 8");
    let expected = 8.0 / (2.0 * std::f64::consts::PI * 4.0 * std::f64::consts::PI);
    assert!((m.emission_luminance - expected).abs() < 1e-9 && !m.emission_front_only);
}

#[test]
fn lights_that_are_not_seen_shine() {
    let scene = world(
        "Translate 1 2 3 Scale 2 2 2 AreaLightSource \"diffuse\" \"rgb L\" [1 1 1] \"float scale\" 5\n\
         Shape \"sphere\" \"float radius\" 0.5 \"float alpha\" 0",
    );
    let LightDesc::Sphere(light) = &scene.lights[0].value else { panic!("{:?}", scene.lights) };
    assert_eq!((light.center, light.radius), (DVec3::new(1.0, 2.0, 3.0), 1.0));
    // Radiance times the area of the disk that the sphere appears as.
    assert!((light.intensity - 5.0 * std::f64::consts::PI).abs() < 1e-9);
    assert!(scene.objects.is_empty());
    let scene = world("AreaLightSource \"diffuse\" Shape \"disk\" \"float alpha\" 0");
    assert!(scene.warnings.iter().any(|w| w.message.contains("emits no light")), "{:?}", scene.warnings);
}

#[test]
fn what_is_misspelled_is_named_at_its_place() {
    let scene = world("Shape \"sphere\"\n  \"float radus\" 2 \"string radius\" \"a\"");
    let texts: Vec<&str> = scene.warnings.iter().map(|w| w.message.as_str()).collect();
    assert!(scene.warnings.iter().all(|w| w.kind == WarningKind::Ignored));
    assert!(
        texts.contains(
            &"scene.pbrt:3:3: unknown parameter radus of the shape \"sphere\"; did you mean radius?"
        ),
        "{texts:?}"
    );
    assert!(
        texts.contains(&"scene.pbrt:3:19: radius of the shape \"sphere\" is of type string; expected float"),
        "{texts:?}"
    );
    for (text, message, help) in [
        ("WorldBegin\nShap \"sphere\"", "scene.pbrt:2:1: unknown directive Shap", "did you mean Shape?"),
        (
            "WorldBegin Shape \"spher\"",
            "scene.pbrt:1:12: unknown shape \"spher\"",
            "did you mean \"sphere\"?",
        ),
        (
            "WorldBegin Shape \"sphere\" \"flot radius\" 1",
            "scene.pbrt:1:27: unknown type \"flot\"",
            "did you mean \"float\"?",
        ),
        (
            "WorldBegin NamedMaterial \"a\" Shape \"sphere\" MakeNamedMaterial \"b\" \"string type\" \"diffuse\"",
            "unknown material \"a\"",
            "b",
        ),
        ("WorldBegin Material \"matt\" Shape \"sphere\"", "unknown material \"matt\"", "matte"),
        (
            "WorldBegin Material \"diffuse\" \"texture reflectance\" \"wod\" Shape \"sphere\"",
            "unknown texture \"wod\"",
            "no texture",
        ),
        ("Translate 1 x 3", "scene.pbrt:1:13: expected a finite number, found x", ""),
        ("Shape \"sphere\" \"float radius\" [ 1", "the file ends", "missing"),
        ("Shape \"sphere", "a string is not closed", "close"),
        ("WorldBegin ObjectInstance \"o\"", "unknown object \"o\"", ""),
    ] {
        let error = refused(text);
        assert!(error.message.contains(message), "{text}: {}", error.message);
        assert!(error.help.clone().unwrap_or_default().contains(help), "{text}: {:?}", error.help);
    }
}

#[test]
fn of_equal_names_the_first_counts() {
    let scene = world("Shape \"sphere\" \"float radius\" 2 \"float radius\" 3");
    assert!(scene.warnings[0].message.contains("is given twice"), "{:?}", scene.warnings);
    let ObjectContent::Shape(ShapeDesc::Sphere(sphere)) = &scene.objects[0].content else {
        panic!("a sphere")
    };
    assert_eq!(sphere.radius, 2.0);
}

#[test]
fn names_may_be_used_before_they_are_defined() {
    let scene = world(
        "NamedMaterial \"m\" Shape \"sphere\" MakeNamedMaterial \"m\" \"string type\" \"mix\" \"string materials\" [\"a\" \"b\"] \"float amount\" .25\n\
         MakeNamedMaterial \"a\" \"string type\" \"diffuse\" MakeNamedMaterial \"b\" \"string type\" \"dielectric\"",
    );
    let MaterialDesc::Mix(mix) = &scene.materials[0].value else { panic!("a mix") };
    // `amount` is the weight of the second material.
    assert_eq!((mix.materials.len(), &mix.weights[..]), (2, &[grey(0.25)][..]));
    let circle = world(
        "MakeNamedMaterial \"m\" \"string type\" \"mix\" \"string materials\" [\"m\" \"m\"] NamedMaterial \"m\" Shape \"sphere\"",
    );
    assert_eq!(circle.prepare(&Default::default()).expect_err("a circle").code, ErrorCode::Cycle);
}

#[test]
fn objects_are_placed_as_instances() {
    let scene = world(
        "Translate 1 0 0 ObjectBegin \"o\" Translate 0 1 0 Shape \"sphere\" ObjectEnd ObjectInstance \"o\" Scale 2 2 2 ObjectInstance \"o\"",
    );
    assert_eq!((scene.groups.len(), scene.objects.len()), (1, 2));
    assert!(matches!(scene.objects[1].content, ObjectContent::Instance(_)));
    assert_eq!(scene.objects[0].transform.0, DAffine3::from_translation(DVec3::X));
    let own = &scene.groups[0].value.objects[0];
    assert_eq!(own.transform.0.translation, DVec3::new(1.0, 1.0, 0.0));
}

#[test]
fn noise_is_pbrts_own_and_stands_in_the_world() {
    let scene = |class: &str| {
        world(&format!(
            "Translate 0 0 5 Texture \"t\" \"float\" \"{class}\" \"integer octaves\" 3 Translate 1 0 0\n\
             Texture \"s\" \"spectrum\" \"scale\" \"texture scale\" \"t\" \"rgb tex\" [1 1 1] Material \"diffuse\" \"texture reflectance\" \"s\" Shape \"sphere\""
        ))
    };
    let found = scene("fbm");
    let TextureDesc::Perlin(p) = &found.textures[0].value else { panic!("noise") };
    assert_eq!((p.kind, p.octaves, p.mapping), (PerlinKind::Fbm, 3, Mapping::World));
    // The transform at the definition of the texture, not that of the shape.
    assert_eq!(p.transform.0, DAffine3::from_translation(DVec3::new(0.0, 0.0, 5.0)));
    assert!(found.warnings.is_empty(), "{:?}", found.warnings);
    for (class, kind) in [("wrinkled", PerlinKind::Wrinkled), ("dots", PerlinKind::Dots)] {
        assert!(
            matches!(&scene(class).textures[0].value, TextureDesc::Perlin(p) if p.kind == kind),
            "{class}"
        );
    }
}

#[test]
fn textures_are_pictures_boards_and_mixes() {
    let board = world(
        "Texture \"c\" \"spectrum\" \"checkerboard\" \"rgb tex1\" [1 0 0] \"rgb tex2\" [0 0 1] \"float uscale\" 8 \"float vscale\" 4\n\
         Texture \"s\" \"spectrum\" \"scale\" \"texture tex\" \"c\" \"float scale\" .5\nTexture \"m\" \"spectrum\" \"mix\" \"texture tex1\" \"c\" \"texture tex2\" \"s\" \"float amount\" .3\n\
         Material \"diffuse\" \"texture reflectance\" \"m\" Shape \"sphere\"",
    );
    assert!(board.warnings.is_empty(), "{:?}", board.warnings);
    let TextureDesc::Checkerboard(c) = &board.textures[0].value else { panic!("a board") };
    // u = 0.3 lies in the third of eight columns: 8·0.3 = 2.4.
    let at = c.transform.0.inverse().transform_point3(DVec3::new(2.0 * 0.3 - 1.0, 0.0, 0.0));
    assert!((at.x - 2.4).abs() < 1e-9 && (at.y - 2.0).abs() < 1e-9);
    assert!(
        matches!(board.textures[1].value, TextureDesc::Multiply(_))
            && matches!(board.textures[2].value, TextureDesc::Mix(_))
    );
}

#[test]
fn includes_are_read_and_circles_refused() {
    let main = "WorldBegin Include \"geometry/a.pbrt\" Import \"b.pbrt\" Shape \"disk\"";
    let files: &[(&str, &[u8])] = &[
        ("geometry/a.pbrt", b"Translate 1 0 0 Shape \"sphere\" # no end of line"),
        ("b.pbrt", b"AttributeBegin Translate 0 9 0 Shape \"disk\""),
    ];
    let scene = read_with(main, files).unwrap();
    assert_eq!(scene.objects.len(), 3);
    // An `Import` restores the state after it; an `Include` changes what follows.
    assert_eq!(scene.objects[2].transform.0, DAffine3::from_translation(DVec3::X));
    let circle = read_with("Include \"a.pbrt\"", &[("a.pbrt", b"Include \"scene.pbrt\"")]).unwrap_err();
    assert_eq!(circle.code, ErrorCode::Cycle);
    assert!(circle.message.starts_with("a.pbrt:1:1: "), "{}", circle.message);
    for outside in ["../secret.pbrt", "/etc/passwd", "a/../../b.pbrt"] {
        assert!(read_with(&format!("Include \"{outside}\""), &[]).is_err());
        assert!(
            read_with(&format!("WorldBegin Shape \"plymesh\" \"string filename\" \"{outside}\""), &[])
                .is_err()
        );
    }
}

#[test]
fn meshes_of_files_may_be_compressed() {
    let ply = b"ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";
    let mut packed = vec![0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 0];
    packed.extend(miniz_oxide::deflate::compress_to_vec(ply, 6));
    packed.extend([0; 4]);
    packed.extend((ply.len() as u32).to_le_bytes());
    let text = "WorldBegin Shape \"plymesh\" \"string filename\" \"m.ply.gz\" Translate 1 0 0 Shape \"plymesh\" \"string filename\" \"m.ply.gz\"";
    let scene = read_with(text, &[("m.ply.gz", &packed)]).unwrap();
    assert_eq!((scene.meshes.len(), scene.objects.len(), scene.meshes[0].data.triangles.len()), (1, 2, 2));
}

/// A `plymesh` takes image textures; pbrt measures edges in the space of the scene.
#[test]
fn meshes_are_displaced() {
    let ply = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n";
    let heights = b"Pf\n2 1\n-1.0\n\0\0\0\0\0\0\x80\x3f";
    let read = |class: &str| {
        let text = format!(
            "WorldBegin Texture \"h\" \"float\" {class} Scale 2 2 2 Shape \"plymesh\" \"string filename\" \"m.ply\" \
             \"texture displacement\" \"h\" \"float displacement.edgelength\" 0.5"
        );
        read_with(&text, &[("m.ply", ply), ("h.pfm", heights)]).unwrap()
    };
    let scene = read("\"imagemap\" \"string filename\" \"h.pfm\" \"float scale\" 0.25");
    let ObjectContent::Shape(ShapeDesc::Mesh(mesh)) = &scene.objects[0].content else { panic!() };
    assert_eq!(mesh.displacement.map(|d| (d.scale, d.midlevel)), Some((0.25, 0.0)));
    assert!((mesh.edge_length.unwrap() - 0.25).abs() < 1e-12);
    assert!(!scene.meshes[0].data.uvs.is_empty() && scene.warnings.is_empty(), "{:?}", scene.warnings);
    scene.prepare(&Default::default()).unwrap();
    let other = read("\"fbm\"");
    assert!(other.warnings.iter().any(|w| w.message.contains("displacement")), "{:?}", other.warnings);
}

#[test]
fn every_shape_is_shown() {
    let text = include_str!("../../tests/assets/pbrt/every-directive.pbrt");
    let part = b"Shape \"disk\"";
    let scene = read_with(text, &[("part.pbrt", part)]).unwrap_or_else(|e| panic!("{e} {:?}", e.help));
    let ignored: Vec<_> = scene.warnings.iter().filter(|w| w.kind == WarningKind::Ignored).collect();
    assert!(ignored.is_empty(), "{ignored:?}");
    let has = |f: &dyn Fn(&ShapeDesc) -> bool| {
        scene.objects.iter().any(|o| matches!(&o.content, ObjectContent::Shape(s) if f(s)))
    };
    assert!(has(&|s| matches!(s, ShapeDesc::Sphere(_))) && has(&|s| matches!(s, ShapeDesc::Cylinder(_))));
    assert!(has(&|s| matches!(s, ShapeDesc::Disk(_))) && scene.meshes.len() >= 6);
    for mesh in &scene.meshes {
        mesh.data.check().unwrap();
    }
    scene.prepare(&Default::default()).unwrap();
}

//! Numbers that mean nothing, and scenes without light: each gives an error that says so, or a defined picture and a warning.

use std::sync::Arc;

use turner::color::Spectrum;
use turner::description::SceneDesc;
use turner::image::{Image, Pixels};
use turner::light::{EnvironmentDesc, LightDesc};
use turner::material::MaterialDesc;
use turner::schema::{Asset, ColorSource, ImageId, WarningKind};
use turner_io::assets::MemoryAssets;
use turner_io::scene::{LoadOptions, load_text};

use crate::classic::common::{describe, render_with};

const SMALL: &str = "film = { width = 8, height = 8, antialias = \"monte-carlo\", samples = 16 }\n\
    integrator = { type = \"path\", rr_start = 1000 }\ncamera = { position = [0, 0, 4], look_at = [0, 0, 0], fov = 10 }\n";

fn sphere(material: &str) -> String {
    format!("{SMALL}object = [{{ type = \"sphere\", material = {{ {material} }} }}]\n")
}

/// What reading or preparing refuses it with.
fn refused(text: &str) -> String {
    match load_text(text.to_owned(), "s.toml", &MemoryAssets::default(), &LoadOptions::default()) {
        Err(error) => error.to_string(),
        Ok(loaded) => loaded.desc.prepare(&Default::default()).expect_err(text).to_string(),
    }
}

/// What preparing and judging say about it, notes left out.
fn said(desc: &SceneDesc) -> Vec<String> {
    let prepared = desc.prepare(&Default::default()).unwrap();
    let judged = turner::lint::lint(desc, &prepared);
    let loud = prepared.warnings.iter().chain(&judged).filter(|w| w.kind != WarningKind::Note);
    loud.map(|w| w.message.clone()).collect()
}

/// The mean of the first band; rendering itself counts what is no finite number, and fails.
fn brightness(desc: &SceneDesc) -> f64 {
    let picture = render_with(desc, 2, u32::MAX).0;
    assert!(picture.linear.iter().flatten().all(|v| v.is_finite() && *v >= 0.0));
    picture.linear.iter().map(|p| f64::from(p[0])).sum::<f64>() / picture.linear.len() as f64
}

#[track_caller]
fn has(messages: &[String], words: &str) {
    assert!(messages.iter().any(|m| m.contains(words)), "{words}: {messages:?}");
}

#[test]
fn colours_above_one_count_as_one_and_are_counted() {
    for material in [
        "type = \"matte\", color = [5, 3, 2]",
        "type = \"principled\", base_metalness = 1, base_color = [9, 1, 1]",
        "type = \"principled\", base_color = 1e30, coat_weight = 1, coat_color = 7, fuzz_weight = 0.5, fuzz_color = 4",
        "type = \"dielectric\", color = 20",
    ] {
        let desc = describe(&format!("{}background.color = 1", sphere(material)));
        has(&said(&desc), "colours of materials are above 1");
        let seen = brightness(&desc);
        assert!(seen > 0.5 && seen <= 1.002, "{material}: {seen}");
    }
    let two = describe(&format!(
        "{SMALL}background.color = 1\nobject = [{{ type = \"sphere\", material = {{ type = \"matte\", color = 2 }} }}, \
         {{ type = \"sphere\", material = {{ type = \"matte\", color = 3 }} }}]"
    ));
    has(&said(&two), "2 colours of materials are above 1");
    // White by rounding is white.
    assert!(
        said(&describe(&format!("{}background.color = 1", sphere("type = \"matte\", color = 1.00001"))))
            .is_empty()
    );
}

#[test]
fn numbers_out_of_range_are_errors_at_their_place() {
    for (material, words) in [
        ("type = \"emissive\", strength = -1", "0 or more, found -1"),
        ("type = \"emissive\", strength = nan", "finite number"),
        ("type = \"emissive\", strength = inf", "finite number"),
        ("type = \"emissive\", color = [1, -2, 0]", "0 or more, found -2"),
        ("type = \"emissive\", color = [nan, 1, 0]", "finite"),
        ("type = \"principled\", emission_luminance = -0.5", "0 or more, found -0.5"),
        ("type = \"matte\", color = [-0.1, 0, 0]", "0 or more"),
        ("type = \"matte\", color = nan", "finite"),
        ("type = \"dielectric\", ior = -1.5", "`ior` must be"),
        ("type = \"dielectric\", ior = nan", "finite"),
        ("type = \"principled\", coat_ior = 0", "`coat_ior` must be"),
        ("type = \"plastic\", ior = 1e6", "`ior` must be"),
        ("type = \"principled\", specular_ior = -1", "`specular_ior` must be"),
        ("type = \"principled\", specular_roughness = 1e9", "0 to 1, found 1000000000"),
        ("type = \"principled\", specular_roughness = -1", "0 to 1, found -1"),
        ("type = \"metal\", roughness = 55", "0 to 1, found 55"),
        ("type = \"mix\", materials = [{}, {}], weights = [-1]", "0 or more, found -1"),
    ] {
        let error = refused(&sphere(material));
        assert!(error.contains(words) && error.contains("s.toml:4:"), "{material}: {error}");
    }
}

#[test]
fn emission_that_is_no_light_is_none() {
    let text = format!("{}background.color = 0.25", sphere("type = \"emissive\""));
    let with = |luminance: f64, color: [f32; 3]| {
        let mut desc = describe(&text);
        let mut m = desc.materials[0].value.principled().unwrap();
        (m.emission_luminance, m.emission_color) = (luminance, ColorSource::Constant(Spectrum::from(color)));
        desc.materials[0].value = MaterialDesc::Principled(m);
        desc
    };
    for (luminance, color) in
        [(-1.0, [1.0; 3]), (f64::NAN, [1.0; 3]), (1.0, [f32::NAN, -1.0, f32::NEG_INFINITY])]
    {
        let desc = with(luminance, color);
        has(&said(&desc), "emission of 1 materials");
        assert!(brightness(&desc) == 0.0, "{luminance} {color:?}");
    }
    // As bright as can be counted, but a number.
    for desc in [with(1e300, [1e38; 3]), with(f64::INFINITY, [f32::INFINITY; 3])] {
        has(&said(&desc), "emission of 1 materials");
        let picture = render_with(&desc, 2, u32::MAX).0;
        assert!(picture.linear.iter().all(|p| p[0].is_finite() && p[0] > 1e9));
    }
}

#[test]
fn indices_and_roughnesses_at_the_ends_of_their_ranges() {
    // An index of 0 is a perfect mirror, as glTF has it.
    for (material, least) in [
        ("type = \"principled\", specular_ior = 0, specular_roughness = 0", 0.999),
        ("type = \"principled\", specular_ior = 0, specular_roughness = 1", 0.6),
        ("type = \"principled\", specular_ior = 0, transmission_weight = 1, specular_roughness = 0", 0.999),
        ("type = \"principled\", specular_ior = 100, base_color = 1, specular_roughness = 0", 0.99),
        ("type = \"principled\", specular_ior = 100, transmission_weight = 1, specular_roughness = 1", 0.2),
        ("type = \"principled\", base_color = 1, base_diffuse_roughness = 1, specular_roughness = 0", 0.95),
        ("type = \"dielectric\", ior = 0", 0.999),
        ("type = \"plastic\", ior = 0", 0.5),
        ("type = \"metal\", color = 1, roughness = 0", 0.999),
        ("type = \"metal\", color = 1, roughness = 1", 0.95),
        ("type = \"principled\", coat_weight = 1, coat_ior = 0.01, coat_roughness = 1", 0.2),
        ("type = \"principled\", thin_film_weight = 1, thin_film_thickness = 0", 0.2),
    ] {
        let text = sphere(material).replace("samples = 16", "samples = 256");
        let desc = describe(&format!("{text}background.color = 1"));
        let seen = brightness(&desc);
        assert!(seen >= least && seen <= 1.01, "{material}: {seen}");
    }
}

/// A matte sphere in an environment of 4 × 2 pixels.
fn surrounded(pixels: [f32; 24]) -> SceneDesc {
    let mut desc = describe(&sphere("type = \"matte\", color = 0.5"));
    let image = Image { width: 4, height: 2, channels: 3, pixels: Pixels::F32(pixels.to_vec()) };
    desc.images.push(Asset { uri: "sky.hdr".into(), data: Arc::new(image) });
    let value = LightDesc::Environment(EnvironmentDesc {
        file: Some(ImageId(desc.images.len() as u32 - 1)),
        ..EnvironmentDesc::studio()
    });
    desc.lights.push(value.into());
    desc
}

#[test]
fn environments_without_light_and_with_numbers_that_are_none() {
    let black = surrounded([0.0; 24]);
    let words = said(&black);
    has(&words, "environment is black");
    has(&words, "nothing in the scene shines");
    assert!(brightness(&black) == 0.0);

    let mut some = [1.0; 24];
    (some[0], some[4], some[11]) = (f32::NAN, f32::INFINITY, -3.0);
    let some = surrounded(some);
    has(&said(&some), "3 pixels of the environment");
    let seen = brightness(&some);
    assert!(seen > 0.3 && seen < 0.5, "{seen}");

    let none = surrounded([f32::NAN; 24]);
    let words = said(&none);
    has(&words, "8 pixels of the environment");
    has(&words, "environment is black");
    assert!(brightness(&none) == 0.0);
}

#[test]
fn lights_without_area() {
    for (light, words) in [
        ("type = \"rectangle\", center = [0, 2, 0], edge_u = [1, 0, 0], edge_v = [2, 0, 0]", "no area"),
        ("type = \"rectangle\", center = [0, 2, 0], edge_u = [0, 0, 0]", "no area"),
        ("type = \"disk\", center = [0, 2, 0], radius = 0", "greater than 0"),
        ("type = \"disk\", center = [0, 2, 0], normal = [0, 0, 0]", "must not be zero"),
        ("type = \"sphere\", center = [0, 2, 0], radius = 0", "greater than 0"),
    ] {
        let error = refused(&format!("{}light = [{{ {light} }}]", sphere("type = \"matte\"")));
        assert!(error.contains(words), "{light}: {error}");
    }
    let lamp = "material = { type = \"emissive\" }";
    for (shape, words) in [
        ("type = \"rectangle\", edge_u = [1, 0, 0], edge_v = [2, 0, 0]", "rectangle"),
        ("type = \"disk\", radius = 0", "greater than 0"),
        ("type = \"cylinder\", from = [1, 0, 0], to = [1, 0, 0]", "two points"),
        ("type = \"sphere\", transform = { scale = [1, 0, 1] }", "scale"),
    ] {
        let error = refused(&format!("{SMALL}object = [{{ {shape}, {lamp} }}]"));
        assert!(error.contains(words), "{shape}: {error}");
    }
    // Triangles without area among others, and alone: there is nothing to hit and nothing to sample.
    let mesh = |triangles: &str| {
        describe(&format!(
            "{SMALL}background.color = 0.5\nobject = [{{ type = \"mesh\", positions = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]], triangles = [{triangles}], {lamp} }}, \
             {{ type = \"sphere\", center = [0, -1.2, 0], material = {{ type = \"matte\" }} }}]"
        ))
    };
    let both = mesh("[0, 1, 2], [0, 1, 3], [1, 1, 1]");
    assert!(brightness(&both) > 0.4);
    let flat = mesh("[0, 1, 2], [1, 1, 1]");
    let seen = brightness(&flat);
    assert!(seen > 0.3 && seen < 0.51, "{seen}");
}

#[test]
fn scenes_without_light_say_so_and_others_do_not() {
    let dark = "nothing in the scene shines";
    let matte = sphere("type = \"matte\"");
    has(&said(&describe(&matte)), dark);
    has(
        &said(&describe(&format!(
            "{matte}light = [{{ type = \"point\", position = [0, 5, 0], intensity = 0 }}]"
        ))),
        dark,
    );
    has(&said(&describe(&format!("{matte}light = [{{ type = \"ambient\", intensity = 0 }}]"))), dark);
    has(&said(&describe(&sphere("type = \"emissive\", strength = 0"))), dark);
    // Defined, and added to no matter: not even the number of lights is 0 by accident.
    assert_eq!(brightness(&describe(&matte)), 0.0);

    for lit in [
        sphere("type = \"emissive\""),
        sphere("type = \"principled\", unlit = true"),
        sphere("type = \"mix\", materials = [{}, { type = \"emissive\" }]"),
        format!("{matte}background.color = 0.1"),
        format!("{matte}background.zenith = \"skyblue\""),
        format!("{matte}light = [{{ type = \"environment\" }}]"),
        format!("{matte}light = [{{ type = \"point\", position = [0, 5, 0] }}]"),
        format!("{matte}light = [{{ type = \"ambient\" }}]"),
        format!("{matte}stage = {{}}"),
        matte.replace("\"path\", rr_start = 1000", "\"normals\""),
    ] {
        assert!(said(&describe(&lit)).is_empty(), "{lit}: {:?}", said(&describe(&lit)));
    }
    // The classic integrator's surfaces do not see the background as light.
    let classic = "object = [{ type = \"sphere\" }]\nbackground.color = 1\n";
    has(&said(&describe(classic)), "the scene has no [[light]]");
    has(
        &said(&describe(&format!(
            "{classic}light = [{{ type = \"point\", position = [0, 5, 0], intensity = 0 }}]"
        ))),
        "all lights of the scene are black",
    );
    assert!(
        said(&describe("object = [{ type = \"sphere\", material = { type = \"emissive\" } }]")).is_empty()
    );
}

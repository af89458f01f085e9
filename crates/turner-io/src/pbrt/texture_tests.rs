//! Tests of textures.

use turner::description::SceneDesc;
use turner::image::{Image, Pixels};
use turner::material::MaterialDesc;
use turner::math::elementary::{acos, atan2, sin_cos};
use turner::math::{DVec2, DVec3, Ray};
use turner::schema::ColorSource;
use turner::texture::{Encoding, ImageChannel, ImageDesc, TextureDesc};

use super::tests::{material, read_with, world};

/// A PNG of two pixels.
fn png(color: png::ColorType, pixels: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, 2, 1);
    encoder.set_color(color);
    encoder.write_header().unwrap().write_image_data(pixels).unwrap();
    out
}

/// The image of a source.
fn picture(scene: &SceneDesc, source: ColorSource) -> (ImageDesc, Image) {
    let ColorSource::Texture(id) = source else { panic!("{source:?}") };
    let TextureDesc::Image(desc) = &scene.textures[id.index()].value else { panic!("an image") };
    (desc.clone(), (*scene.images[desc.file.index()].data).clone())
}

/// The image of a shape's alpha, from a file with this name.
fn alpha(name: &str, encoding: &str, bytes: &[u8]) -> (ImageDesc, Image) {
    let text = format!(
        "WorldBegin Texture \"a\" \"float\" \"imagemap\" \"string filename\" \"{name}\" {encoding}\n\
         Shape \"sphere\" \"texture alpha\" \"a\""
    );
    let scene = read_with(&text, &[(name, bytes)]).unwrap();
    let MaterialDesc::Principled(m) = &scene.materials[0].value else { panic!() };
    picture(&scene, m.opacity)
}

#[test]
fn float_textures_read_alpha_or_the_mean_of_the_colours() {
    let rgba = png::ColorType::Rgba;
    // Alpha is 1 everywhere: the colours, whose mean is used where there is no alpha.
    let (desc, image) = alpha("a.png", "", &png(rgba, &[10, 20, 30, 255, 40, 50, 60, 255]));
    assert_eq!((desc.channel, desc.encoding, image.channels), (ImageChannel::Rgb, Encoding::Srgb, 3));
    assert_eq!(image.pixels, Pixels::U8(vec![10, 20, 30, 40, 50, 60]));
    // Real alpha is decoded like colours.
    let partial = png(rgba, &[10, 20, 30, 128, 40, 50, 60, 255]);
    let (desc, image) = alpha("a.png", "", &partial);
    assert_eq!((desc.channel, desc.encoding, image.channels), (ImageChannel::Rgb, Encoding::Srgb, 1));
    assert_eq!(image.pixels, Pixels::U8(vec![128, 255]));
    // Alpha channels of Turner's images are linear.
    let linear = "\"string encoding\" \"linear\"";
    let (desc, image) = alpha("a.png", linear, &partial);
    assert_eq!((desc.channel, image.channels), (ImageChannel::A, 4));
    // 0 and 1 are the same in every encoding.
    let (desc, image) = alpha("a.png", "", &png(rgba, &[10, 20, 30, 0, 40, 50, 60, 255]));
    assert_eq!((desc.channel, image.channels), (ImageChannel::A, 4));
    // pbrt reads the colour of grey images with alpha.
    let (desc, image) = alpha("a.png", "", &png(png::ColorType::GrayscaleAlpha, &[10, 0, 20, 128]));
    assert_eq!((desc.channel, image.pixels), (ImageChannel::Rgb, Pixels::U8(vec![10, 20])));
}

/// A strip of two triangles that share an edge.
const STRIP: &str =
    "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0] \"integer indices\" [0 1 2 2 1 3]";

#[test]
fn textured_meshes_without_uv_have_pbrts() {
    let text = |before: &str, class: &str, color: &str| {
        let scene = world(&format!(
            "{before} Texture \"t\" \"spectrum\" {class} Material \"diffuse\" {color} {STRIP}"
        ));
        (*scene.meshes[0].data).clone()
    };
    let board = "\"checkerboard\" \"float uscale\" 4";
    let textured = "\"texture reflectance\" \"t\"";
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]];
    for before in ["", "ReverseOrientation"] {
        let data = text(before, board, textured);
        assert_eq!(data.uvs, [corners, corners].concat());
        assert_eq!(data.positions[3..], [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]);
        let order = if before.is_empty() { [3, 4, 5] } else { [3, 5, 4] };
        assert_eq!(data.triangles[1], order);
    }
    // Vertices stay shared where nothing looks at (u, v).
    for (class, color) in
        [(board, ""), ("\"checkerboard\" \"integer dimension\" 3", textured), ("\"marble\"", textured)]
    {
        let data = text("", class, color);
        assert!(data.uvs.is_empty() && data.positions.len() == 4, "{class} {color}");
    }
    // A name that is defined later may have textures; mixes of themselves end.
    let scene =
        world(&format!("NamedMaterial \"m\" {STRIP} MakeNamedMaterial \"m\" \"string type\" \"diffuse\""));
    assert_eq!(scene.meshes[0].data.positions.len(), 6);
    let scene = world(&format!(
        "MakeNamedMaterial \"m\" \"string type\" \"mix\" \"string materials\" [\"m\" \"m\"] NamedMaterial \"m\" {STRIP}"
    ));
    assert_eq!(scene.meshes[0].data.positions.len(), 4);
}

/// pbrt-v4: u is the azimuth from +x towards +y, v falls from 1 at the inner radius to 0 at the rim.
#[test]
fn whole_disks_have_the_uv_of_partial_ones() {
    let scene = world("Shape \"disk\" \"float radius\" 2 \"float innerradius\" 1 \"float height\" 3");
    let prepared = scene.prepare(&Default::default()).unwrap().scene;
    for (x, y, u, v) in
        [(1.5, 0.0, 0.0, 0.5), (0.0, 1.25, 0.25, 0.75), (-1.9, 0.0, 0.5, 0.1), (0.0, -1.0, 0.75, 1.0)]
    {
        let ray = Ray::new(DVec3::new(x, y, 9.0), DVec3::NEG_Z);
        let hit = prepared.intersect(&ray).unwrap();
        let found = prepared.texture_point(&prepared.surface(&ray, &hit)).uv;
        assert!((found - DVec2::new(u, v)).length() < 1e-6, "{x} {y}: {found}");
    }
}

/// A reflectance of 0.6 above 590 nm and 0.1 below, under a smooth clear layer: ρ (1 − R) / (1 − ρ R) at each wavelength,
/// R = 0.5963 (Egan and Hilgeman 1973), so that two reflectances are mixed, not two colours.
#[test]
fn layers_are_computed_by_wavelengths() {
    let layer = "Material \"coateddiffuse\" \"float thickness\" 0 \"integer maxdepth\" 100";
    let color = |text: &str| {
        let ColorSource::Constant(c) = material(text).base_color else { panic!() };
        c
    };
    let leaves = |rho: f32| rho * 0.4037 / (1.0 - rho * 0.5963);
    let step = "\"spectrum reflectance\" [380 .1 590 .1 590.001 .6 780 .6]";
    let found = color(&format!("{layer} {step}"));
    let plain = color(&format!("Material \"diffuse\" {step}"));
    // Both are affine in the share of light above 590 nm.
    for (found, plain) in found.to_array().into_iter().zip(plain.to_array()) {
        let share = (plain - 0.1) / 0.5;
        let expected = (leaves(0.1) + share * (leaves(0.6) - leaves(0.1))).max(0.0);
        assert!((found - expected).abs() < 0.01, "{found} {expected}");
    }
    // An orange: its red, to which the whole spectrum contributes, is darker than the same red alone.
    let orange = color(&format!("{layer} \"rgb reflectance\" [.9 .35 .05]"));
    assert!(orange.r < 0.95 * leaves(0.9) && orange.r > 0.7 * leaves(0.9), "{orange:?} {}", leaves(0.9));
    // White and grey stay.
    let grey = color(&format!("{layer} \"rgb reflectance\" [.5 .5 .5]"));
    assert!((grey.g - leaves(0.5)).abs() < 2e-3, "{grey:?}");
}

/// A PNG of 8 × 4 pixels whose red and green are column and row.
fn numbered() -> Vec<u8> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, 8, 4);
    encoder.set_color(png::ColorType::Rgb);
    let pixels: Vec<u8> = (0..32).flat_map(|i| [i % 8, i / 8, 0]).collect();
    encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
    out
}

/// pbrt-v4's SphericalMapping: s = θ / π, t = φ / 2π; CylindricalMapping: s = (π + φ) / 2π, t = z; both in the space of the
/// texture. t = 0 is the lower edge of the image.
#[test]
fn mappings_around_an_axis_are_pbrts() {
    use std::f64::consts::{PI, TAU};
    for kind in ["spherical", "cylindrical"] {
        let text = format!(
            "WorldBegin Translate 1 2 3 Rotate 90 1 0 0 Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"n.png\"\n\
             \"string filter\" \"point\" \"string encoding\" \"linear\" \"string mapping\" \"{kind}\"\n\
             Material \"diffuse\" \"texture reflectance\" \"t\" Shape \"sphere\""
        );
        let scene = read_with(&text, &[("n.png", &numbered())]).unwrap();
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        let MaterialDesc::Principled(material) = &scene.materials[0].value else { panic!() };
        let source = material.base_color;
        let prepared = scene.prepare(&Default::default()).unwrap().scene;
        let mut seen = 0;
        for i in 0..200 {
            let (sin_t, cos_t) = sin_cos(f64::from(i) * 0.1 + 0.05);
            let up = f64::from(i % 19) / 9.5 - 0.95;
            let p = DVec3::new(cos_t * (1.0 - up * up).sqrt(), sin_t * (1.0 - up * up).sqrt(), up);
            // Rotated by a quarter about x, y becomes z and z becomes −y.
            let place = DVec3::new(1.0, 2.0, 3.0);
            let ray = Ray::new(place + 2.0 * DVec3::new(p.x, -p.z, p.y), -DVec3::new(p.x, -p.z, p.y));
            let hit = prepared.intersect(&ray).unwrap();
            let found =
                prepared.textures.color(source, &prepared.texture_point(&prepared.surface(&ray, &hit)));
            let phi = atan2(p.y, p.x);
            let (s, t) = match kind {
                "spherical" => (acos(p.z) / PI, phi.rem_euclid(TAU) / TAU),
                _ => ((PI + phi) / TAU, p.z.rem_euclid(1.0)),
            };
            let (x, y) = (8.0 * s, 4.0 * (1.0 - t));
            // Not beside the edge of a pixel.
            if [x, y].iter().any(|v| (v - v.round()).abs() < 0.02) {
                continue;
            }
            seen += 1;
            let expected = [x, y].map(|v| v.floor() as f32 / 255.0);
            assert!(
                (found.r - expected[0]).abs() < 1e-4 && (found.g - expected[1]).abs() < 1e-4,
                "{kind} {p}: {found:?}, not {expected:?}"
            );
        }
        assert!(seen > 100);
    }
}

/// pbrt-v4: the share of tex1 is |n · dir|, in the space of the texture.
#[test]
fn directions_mix_textures() {
    let scene = world(
        "Rotate 90 1 0 0 Texture \"t\" \"spectrum\" \"directionmix\" \"rgb tex1\" [1 0 0] \"rgb tex2\" [0 0 1] \"vector3 dir\" [0 2 0]\n\
         Material \"diffuse\" \"texture reflectance\" \"t\" Shape \"sphere\"",
    );
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let MaterialDesc::Principled(material) = &scene.materials[0].value else { panic!() };
    let source = material.base_color;
    let prepared = scene.prepare(&Default::default()).unwrap().scene;
    // The rotation turns y to z.
    for n in [DVec3::X, DVec3::Z, DVec3::NEG_Z, DVec3::new(0.48, 0.64, 0.6), DVec3::new(0.0, 0.6, -0.8)] {
        let ray = Ray::new(3.0 * n, -n);
        let hit = prepared.intersect(&ray).unwrap();
        let found = prepared.textures.color(source, &prepared.texture_point(&prepared.surface(&ray, &hit)));
        let share = n.z.abs() as f32;
        assert!((found.r - share).abs() < 1e-5 && (found.b - (1.0 - share)).abs() < 1e-5, "{n}: {found:?}");
    }
}

//! Tests of lights: strengths in closed form.

use std::f64::consts::PI;

use turner::color::Spectrum;
use turner::description::{ObjectContent, SceneDesc};
use turner::light::{LightDesc, PointDesc};
use turner::material::MaterialDesc;
use turner::math::elementary::tan;
use turner::math::{DVec2, DVec3};
use turner::schema::{ColorSource, MaterialId};
use turner::shape::ShapeDesc;
use turner::texture::TextureDesc;

use super::tests::{material, read_with, value, world};

/// The radiance of a material.
fn radiance(scene: &SceneDesc, id: MaterialId) -> f64 {
    match &scene.materials[id.index()].value {
        MaterialDesc::Principled(m) => m.emission_luminance,
        _ => 0.0,
    }
}

/// The radiance of each triangle of the only object, or of the object itself.
fn radiances(text: &str) -> Vec<f64> {
    let scene = world(&format!("AreaLightSource \"diffuse\" \"rgb L\" [1 1 1] \"float power\" 10\n{text}"));
    let object = &scene.objects[0];
    let own = object.material.unwrap();
    let ObjectContent::Shape(ShapeDesc::Mesh(mesh)) = &object.content else {
        return vec![radiance(&scene, own)];
    };
    let data = &scene.meshes[mesh.mesh.index()].data;
    let of = |i: usize| match data.face_materials.get(i) {
        Some(&face) => mesh.materials[usize::from(face)].unwrap(),
        None => own,
    };
    (0..data.triangles.len()).map(|i| radiance(&scene, of(i))).collect()
}

/// Radiance of a one-sided light of 10 lumens.
fn over(area: f64) -> f64 {
    10.0 / (PI * area)
}

#[test]
fn tessellated_shapes_are_one_light() {
    for (shape, area) in [
        ("\"sphere\" \"float radius\" 2", 16.0 * PI),
        ("\"sphere\" \"float radius\" 2 \"float zmin\" 0", 8.0 * PI),
        ("\"sphere\" \"float radius\" 2 \"float zmin\" -1 \"float zmax\" 1 \"float phimax\" 90", 2.0 * PI),
        ("\"disk\" \"float radius\" 3 \"float innerradius\" 1", 8.0 * PI),
        ("\"disk\" \"float radius\" 3 \"float innerradius\" 1 \"float phimax\" 180", 4.0 * PI),
        ("\"cylinder\" \"float radius\" 2 \"float zmin\" 0 \"float zmax\" 3", 12.0 * PI),
        ("\"cylinder\" \"float radius\" 2 \"float zmin\" 0 \"float zmax\" 3 \"float phimax\" 60", 2.0 * PI),
    ] {
        // As in pbrt, the scale of a shape does not count.
        let found = radiances(&format!("Scale 2 2 2 Shape {shape}"));
        assert!(!found.is_empty());
        for found in found {
            assert!((found / over(area) - 1.0).abs() < 1e-6, "{shape}: {found} {}", over(area));
        }
    }
}

#[test]
fn each_patch_is_a_light() {
    // A rectangle of 2 by 3, and the saddle z = u v over the unit square, whose area is ∫∫ √(1 + u² + v²). The
    // diagonals of pbrt's three by three quads amount to the midpoint rule.
    let middles = [1.0 / 6.0, 0.5, 5.0 / 6.0];
    let heights = middles.iter().flat_map(|u| middles.map(|v| f64::sqrt(1.0 + u * u + v * v)));
    let saddle = heights.sum::<f64>() / 9.0;
    let found = radiances(
        "Shape \"bilinearmesh\" \"point3 P\" [0 0 0 2 0 0 0 3 0 2 3 0  5 0 0 6 0 0 5 1 0 6 1 1]\n\
         \"integer indices\" [0 1 2 3 4 5 6 7]",
    );
    assert_eq!(found.len(), 2 + 288);
    assert!(found[..2].iter().all(|r| (r / over(6.0) - 1.0).abs() < 1e-6), "{:?}", &found[..2]);
    assert!(
        found[2..].iter().all(|r| (r / over(saddle) - 1.0).abs() < 1e-6),
        "{} {saddle}",
        over(1.0) / found[2]
    );
}

#[test]
fn triangles_are_lights_by_their_own_areas() {
    let mesh = "\"point3 P\" [0 0 0 1 0 0 0 1 0 4 0 0] \"integer indices\" [0 1 2 0 3 2]";
    for (before, by) in [("", 1.0), ("Scale 2 2 2", 4.0), ("Scale 1 3 1", 3.0)] {
        let found = radiances(&format!("{before}\nShape \"trianglemesh\" {mesh}"));
        for (found, area) in found.iter().zip([0.5, 2.0]) {
            assert!((found / over(by * area) - 1.0).abs() < 1e-6, "{before}: {found}");
        }
    }
}

/// A straight curve whose width falls from 0.4 to 0.2 over a length of 3, in four parts.
#[test]
fn curves_are_lights_by_their_parts() {
    let found = radiances(
        "Shape \"curve\" \"integer splitdepth\" 2 \"float width0\" .4 \"float width1\" .2\n\
         \"point3 P\" [0 0 0 1 0 0 2 0 0 3 0 0]",
    );
    // Two rows of twelve triangles; the second row begins in the third part.
    assert_eq!(found.len(), 24);
    for (found, width) in found.chunks(12).zip([0.375, 0.275]) {
        assert!(found.iter().all(|r| (r / over(0.75 * width) - 1.0).abs() < 1e-6), "{found:?}");
    }
}

#[test]
fn interfaces_emit_no_light() {
    let scene = world("Material \"interface\" AreaLightSource \"diffuse\" Shape \"disk\"");
    assert!(matches!(scene.materials[0].value, MaterialDesc::Interface(_)), "{:?}", scene.materials);
    assert!(scene.warnings.iter().any(|w| w.message.contains("emits no light")), "{:?}", scene.warnings);
    let scene =
        world("Material \"interface\" AreaLightSource \"diffuse\" Shape \"sphere\" \"float alpha\" 0");
    assert!(scene.lights.is_empty(), "{:?}", scene.lights);
}

/// A picture is 3 where the light's z is positive and `low` elsewhere: 2π/N · N/2 · mean of 3 cos θ over the
/// hemisphere, 1/2, is 3π/2, whatever is below.
#[test]
fn the_illuminance_of_a_picture_is_that_from_above() {
    const SIDE: u32 = 64;
    for low in [0.0f32, 5.0] {
        let mut pfm = format!("PF\n{SIDE} {SIDE}\n-1.0\n").into_bytes();
        for y in 0..SIDE {
            for x in 0..SIDE {
                // |2u − 1| + |2v − 1| < 1 is the upper hemisphere.
                let from_centre = |i: u32| ((2.0 * f64::from(i) + 1.0) / f64::from(SIDE) - 1.0).abs();
                let above = from_centre(x) + from_centre(y) < 1.0;
                let value = if above { 3.0 } else { low };
                pfm.extend([value; 3].iter().flat_map(|v: &f32| v.to_le_bytes()));
            }
        }
        let text = "WorldBegin Rotate 40 1 2 3 LightSource \"infinite\" \"string filename\" \"sky.pfm\" \"float illuminance\" 7";
        let scene = read_with(text, &[("sky.pfm", &pfm)]).unwrap();
        let LightDesc::Environment(light) = &scene.lights[0].value else { panic!() };
        assert!((light.strength / (7.0 / (1.5 * PI)) - 1.0).abs() < 1e-3, "{}", light.strength);
    }
    let scene = world("LightSource \"infinite\" \"rgb L\" [1 1 1] \"float illuminance\" 7");
    let LightDesc::Environment(light) = &scene.lights[0].value else { panic!() };
    assert!((light.strength - 7.0 / PI).abs() < 1e-9);
}

/// The light of a wide colour space has the white point of that space: D60, x = 0.32168, y = 0.33767, for ACES2065-1.
#[test]
fn lights_have_the_white_of_their_colour_space() {
    let (x, y) = (0.32168, 0.33767);
    let xyz = [x / y, 1.0, (1.0 - x - y) / y];
    // XYZ to linear Rec. 709 (IEC 61966-2-1).
    let rows = [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.204, 1.057]];
    let d60 = rows.map(|row: [f64; 3]| row.iter().zip(xyz).map(|(a, b)| a * b).sum::<f64>());
    let color = |space: &str, light: &str| {
        let scene = world(&format!("ColorSpace \"{space}\" LightSource \"point\" {light}"));
        let LightDesc::Point(light) = &scene.lights[0].value else { panic!() };
        light.color.to_array().map(f64::from)
    };
    let near = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-3);
    for light in ["", "\"rgb I\" [1 1 1]"] {
        assert!(near(color("aces2065-1", light), d60), "{light}: {:?} {d60:?}", color("aces2065-1", light));
        for space in ["srgb", "dci-p3", "rec2020"] {
            assert!(near(color(space, light), [1.0; 3]), "{space} {:?}", color(space, light));
        }
    }
    // Surfaces stay white.
    let m = material("ColorSpace \"aces2065-1\" Material \"diffuse\" \"rgb reflectance\" [.5 .5 .5]");
    assert!((value(m.base_color) - 0.5).abs() < 1e-5);
}

/// A reflectance of 1 between 400 and 500 nm is blue, though its ends are 1.
#[test]
fn spectra_end_where_their_samples_end() {
    let m = material("Material \"diffuse\" \"spectrum reflectance\" [400 1 500 1]");
    let ColorSource::Constant(c) = m.base_color else { panic!() };
    assert!(c.r < 0.1 && c.g < 0.2 && c.b > 0.8, "{c:?}");
    let m = material("Material \"diffuse\" \"spectrum reflectance\" [300 .5 800 .5]");
    assert_eq!(m.base_color, ColorSource::Constant(turner::color::Spectrum::grey(0.5)));
}

/// A goniometric light whose image is 3 where the light's y is positive and 1 elsewhere (pbrt swaps y and z of the space of
/// the image).
#[test]
fn goniometric_lights_shine_by_their_image() {
    const SIDE: u32 = 64;
    let mut pfm = format!("PF\n{SIDE} {SIDE}\n-1.0\n").into_bytes();
    for y in 0..SIDE {
        for x in 0..SIDE {
            let from_centre = |i: u32| ((2.0 * f64::from(i) + 1.0) / f64::from(SIDE) - 1.0).abs();
            let value = if from_centre(x) + from_centre(y) < 1.0 { 3.0f32 } else { 1.0 };
            pfm.extend([value; 3].iter().flat_map(|v| v.to_le_bytes()));
        }
    }
    let light = |before: &str, power: &str| {
        let text = format!(
            "WorldBegin {before} LightSource \"goniometric\" \"string filename\" \"g.pfm\" {power} Shape \"sphere\""
        );
        let scene = read_with(&text, &[("g.pfm", &pfm)]).unwrap();
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        let LightDesc::Point(light) = scene.lights[0].value.clone() else { panic!() };
        light
    };
    // Vertical angles are counted from −y, and the horizontal angle 0 is +x.
    let towards = |light: &PointDesc, vertical: f64, horizontal: f64| {
        light.intensity * f64::from(light.ies.as_ref().unwrap().data.candela(vertical, horizontal))
    };
    let plain = light("", "");
    for (vertical, expected) in [(10.0, 1.0), (80.0, 1.0), (100.0, 3.0), (170.0, 3.0)] {
        assert!((towards(&plain, vertical, 40.0) - expected).abs() < 1e-3, "{vertical}");
    }
    // y turns to −x.
    let turned = light("Rotate 90 0 0 1", "");
    assert!(
        (towards(&turned, 90.0, 0.0) - 1.0).abs() < 1e-3
            && (towards(&turned, 90.0, 180.0) - 3.0).abs() < 1e-3
    );
    // 8π lumens over 4π steradians. Of the pixels, 1/2 − 1/64 have 3: those on the horizon have 1.
    let strong = light("", &format!("\"float power\" {}", 8.0 * PI));
    let by = 2.0 / (1.0 + 2.0 * (0.5 - 1.0 / 64.0));
    for (vertical, expected) in [(170.0, 3.0), (10.0, 1.0)] {
        assert!((towards(&strong, vertical, 0.0) / (by * expected) - 1.0).abs() < 1e-3, "{vertical}");
    }
}

/// An area light of two texels, white and black, on a unit square: 10 lumens by the mean luminance of ½.
#[test]
fn area_lights_show_their_images() {
    let pfm =
        [b"PF\n2 1\n-1.0\n".as_slice(), &[1.0f32, 1.0, 1.0, 0.0, 0.0, 0.0].map(f32::to_le_bytes).concat()]
            .concat();
    let text = "WorldBegin AreaLightSource \"diffuse\" \"string filename\" \"p.pfm\" \"float power\" 10\n\
                Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0]";
    let scene = read_with(text, &[("p.pfm", &pfm)]).unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let MaterialDesc::Principled(m) = &scene.materials[0].value else { panic!() };
    assert!((m.emission_luminance / over(0.5) - 1.0).abs() < 1e-6, "{}", m.emission_luminance);
    let ColorSource::Texture(id) = m.emission_color else { panic!() };
    assert!(matches!(scene.textures[id.index()].value, TextureDesc::Image(_)));
}

/// pbrt-v4's ProjectionLight: x to the right and y upwards in the picture, whose shorter side has the angle `fov`; its
/// power is the integral of the picture's luminance over the solid angle.
#[test]
fn projected_pictures_are_pbrts() {
    let mut png = Vec::new();
    let mut encoder = png::Encoder::new(&mut png, 4, 2);
    encoder.set_color(png::ColorType::Rgb);
    let pixels: Vec<u8> = (0..8u8).flat_map(|i| [30 * i + 40, 255, 10]).collect();
    encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
    for (transform, mirrors) in [("", false), ("Scale -1 1 1", true)] {
        let text = |power: &str| {
            let text = format!(
                "WorldBegin {transform} Translate 1 2 3 LightSource \"projection\" \"string filename\" \"p.png\" \"float fov\" 60\n\
                 \"float scale\" 2 {power} Shape \"sphere\""
            );
            read_with(&text, &[("p.png", &png)]).unwrap()
        };
        let scene = text("");
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        let LightDesc::Spot(spot) = scene.lights[0].value.clone() else { panic!() };
        let place = DVec3::new(if mirrors { -1.0 } else { 1.0 }, 2.0, 3.0);
        assert!((spot.position - place).length() < 1e-12);
        let prepared = scene.prepare(&Default::default()).unwrap().scene;
        let light = |p: DVec3| prepared.lights[0].illuminate(p, 0, DVec2::ZERO);
        let (half_x, half_y) = (2.0 * tan(PI / 6.0), tan(PI / 6.0));
        let mut power = 0.0;
        for (i, pixel) in pixels.chunks(3).enumerate() {
            // The centre of a pixel, in the light's own space.
            let (x, y) = (f64::from(i as u32 % 4) - 1.5, 0.5 - f64::from(i as u32 / 4));
            let own = DVec3::new(x / 2.0 * half_x, y * half_y, 1.0);
            let aside = if mirrors { -own.x } else { own.x };
            let found = light(place + DVec3::new(aside, own.y, own.z)).unwrap();
            let decoded = [0, 1, 2].map(|k| turner::color::srgb_decode(f32::from(pixel[k]) / 255.0));
            let expected = 2.0 * f64::from(decoded[0]) / own.length_squared();
            assert!((f64::from(found.intensity.r) - expected).abs() < 1e-5, "{i}: {found:?}, not {expected}");
            let area = half_x * half_y / 2.0;
            power +=
                area * f64::from(Spectrum::from(decoded).luminance()) / (own.length_squared() * own.length());
        }
        assert!(light(place + DVec3::new(0.0, 1.01 * half_y, 1.0)).is_none_or(|l| l.intensity.r == 0.0));
        let LightDesc::Spot(bright) = &text("\"float power\" 100").lights[0].value else { panic!() };
        assert!((bright.intensity / (2.0 * 100.0 / power) - 1.0).abs() < 1e-6, "{}", bright.intensity);
    }
}

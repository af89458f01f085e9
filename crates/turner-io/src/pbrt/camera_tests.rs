//! Tests of cameras: rays against pbrt's formulas.

use std::f64::consts::{PI, TAU};

use turner::math::elementary::sin_cos;
use turner::math::{DVec2, DVec3};

use turner::camera::{CameraDesc, LensBrightness};
use turner::description::SceneDesc;

use super::tests::{read, read_with};

/// pbrt-v4's SphericalCamera: θ = πv, φ = 2πu, (sin θ cos φ, cos θ, sin θ sin φ) in the space of the camera.
#[test]
fn panoramas_are_pbrts() {
    // World directions of the camera's x, y, z. `Rotate` turns x to −z and z to x on the way to the camera.
    for (transform, [x, y, z]) in [
        ("", [DVec3::X, DVec3::Y, DVec3::Z]),
        ("Scale -1 1 1", [-DVec3::X, DVec3::Y, DVec3::Z]),
        ("Rotate 90 0 1 0 Translate -1 -2 -3", [DVec3::Z, DVec3::Y, -DVec3::X]),
    ] {
        let text = format!(
            "{transform} Camera \"spherical\" \"string mapping\" \"equirectangular\" WorldBegin Shape \"sphere\""
        );
        let scene = read(&text);
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        let camera = scene.camera.unwrap().value.prepare(2.0).unwrap();
        for (u, v) in [(0.0, 0.5), (0.25, 0.5), (0.5, 0.5), (0.1, 0.3), (0.6, 0.8), (0.9, 0.05)] {
            let ((sin_theta, cos_theta), (sin_phi, cos_phi)) = (sin_cos(PI * v), sin_cos(TAU * u));
            let expected = x * (sin_theta * cos_phi) + y * cos_theta + z * (sin_theta * sin_phi);
            let found = camera.ray(DVec2::new(2.0 * u - 1.0, 1.0 - 2.0 * v), DVec2::ZERO).direction;
            assert!((found - expected).length() < 1e-9, "{transform} {u} {v}: {found} {expected}");
        }
    }
}

/// pbrt-v4's EqualAreaSquareToSphere, whose y and z the camera exchanges; v grows downwards.
#[test]
fn squares_are_pbrts() {
    for mapping in ["", "\"string mapping\" \"equalarea\""] {
        let text = format!(
            "Rotate 90 0 1 0 Translate -1 -2 -3 Camera \"spherical\" {mapping} WorldBegin Shape \"sphere\""
        );
        let scene = read(&text);
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        let camera = scene.camera.unwrap().value.prepare(1.0).unwrap();
        let [x, y, z] = [DVec3::Z, DVec3::Y, -DVec3::X];
        for (u, v) in [(0.0, 0.5), (0.25, 0.5), (0.5, 0.5), (0.1, 0.3), (0.6, 0.8), (0.9, 0.05), (0.98, 0.97)]
        {
            let (su, sv) = (2.0 * u - 1.0, 2.0 * v - 1.0);
            let inside: f64 = 1.0 - (f64::abs(su) + f64::abs(sv));
            let r = 1.0 - inside.abs();
            let quarter = if r == 0.0 { 1.0 } else { (f64::abs(sv) - f64::abs(su)) / r + 1.0 };
            let (sin, cos) = sin_cos(quarter * PI / 4.0);
            let out = r * (2.0 - r * r).sqrt();
            let own = [cos.copysign(su) * out, sin.copysign(sv) * out, (1.0 - r * r).copysign(inside)];
            let expected = x * own[0] + y * own[2] + z * own[1];
            let found = camera.ray(DVec2::new(su, -sv), DVec2::ZERO).direction;
            assert!((found - expected).length() < 1e-9, "{u} {v}: {found} {expected}");
        }
    }
}

/// A lens of 80 mm with its stop.
const LENS: &str = "# a lens\n\n 0 5 0 20 # the stop\n80 4 1.5\t20\n-80 0 1 20";

fn with_lens(camera: &str, lens: &str) -> Result<SceneDesc, turner::schema::SceneError> {
    let text = format!(
        "Film \"rgb\" \"integer xresolution\" 300 \"integer yresolution\" 200 \"float diagonal\" 43\n\
         Scale .5 .5 .5 LookAt 0 0 -5 0 0 0 0 1 0\n\
         Camera \"realistic\" {camera}\nWorldBegin Shape \"sphere\""
    );
    read_with(&text, &[("lenses/own.dat", lens.as_bytes())])
}

/// The film is at the origin of pbrt's camera space, which looks along +z with x to the right; a unit is a metre.
#[test]
fn lenses_are_read_from_their_files() {
    let file = "\"string lensfile\" \"lenses/own.dat\"";
    let scene =
        with_lens(&format!("{file} \"float aperturediameter\" 8 \"float focusdistance\" 2"), LENS).unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let value = scene.camera.unwrap().value;
    let CameraDesc::Realistic(c) = &value else { panic!("{value:?}") };
    assert_eq!(c.elements, [[0.0, 5.0, 0.0, 20.0], [80.0, 4.0, 1.5, 20.0], [-80.0, 0.0, 1.0, 20.0]]);
    assert_eq!((c.aperture_diameter, c.film_diagonal), (Some(8.0), 43.0));
    assert_eq!((c.blades, c.brightness), (0, LensBrightness::Absolute));
    // The scale makes camera space half as large as the world.
    assert!((c.units_per_metre - 2.0).abs() < 1e-12 && (c.focus_distance.unwrap() - 4.0).abs() < 1e-12);
    assert!((c.position - DVec3::new(0.0, 0.0, -5.0)).length() < 1e-9, "{}", c.position);
    let camera = value.prepare(1.5).unwrap();
    let direction = |x: f64, y: f64| camera.ray(DVec2::new(x, y), DVec2::splat(0.5)).direction;
    assert!((direction(0.0, 0.0) - DVec3::Z).length() < 1e-9);
    let corner = direction(0.9, 0.5);
    assert!(corner.x > 0.1 && corner.y > 0.05 && corner.z > 0.9, "{corner}");
    // pbrt's defaults, and apertures that are approximated.
    let scene = with_lens(&format!("{file} \"string aperture\" \"pentagon\""), LENS).unwrap();
    assert_eq!(scene.warnings.len(), 1);
    let value = scene.camera.unwrap().value;
    let CameraDesc::Realistic(c) = &value else { panic!("{value:?}") };
    assert_eq!((c.aperture_diameter, c.blades), (Some(1.0), 5));
    assert!((c.focus_distance.unwrap() - 20.0).abs() < 1e-12);
    // A lens without a stop has no aperture to close.
    let scene = with_lens(file, "80 4 1.5 20\n-80 0 1 20").unwrap();
    let value = scene.camera.unwrap().value;
    assert!(value.prepare(1.5).is_ok(), "{value:?}");
}

#[test]
fn damaged_lens_files_are_refused() {
    let file = "\"string lensfile\" \"lenses/own.dat\"";
    for (camera, lens, problem) in [
        (file, "80 4 1.5 20\n# then\n-80 x 1 20", "own.dat, line 3: \"x\" is not a number"),
        (file, "80 4 1.5 20\n-80 0 1", "own.dat, line 2: the last row has 3 of four numbers"),
        (file, "# nothing\n", "own.dat, line 1: the last row has 0 of four numbers"),
        (file, "80 4 inf 20", "own.dat, line 1: \"inf\" is not a number"),
        ("", LENS, "the camera \"realistic\" has no \"lensfile\""),
        ("\"string lensfile\" \"lenses/other.dat\"", LENS, "other.dat"),
    ] {
        let error = with_lens(camera, lens).expect_err(lens);
        assert!(error.message.contains(problem), "{lens}: {}", error.message);
        assert!(error.message.contains("scene.pbrt:3:"), "{}", error.message);
    }
}

//! Tests of cameras: rays against pbrt's formulas.

use std::f64::consts::{PI, TAU};

use turner::math::elementary::sin_cos;
use turner::math::{DVec2, DVec3};

use super::tests::read;

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

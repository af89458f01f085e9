//! Energy: nothing is created, and what absorbs nothing loses nothing.

use crate::bsdf::{Bsdf, PrincipledPoint};
use crate::color::Spectrum;
use crate::material::metals::MetalName;
use crate::testing::{albedo, direction, materials};

#[test]
fn energy_is_kept() {
    let mut bad = String::new();
    for (name, point) in materials() {
        let bsdf = Bsdf::new(&point);
        for mu in [1.0, 0.8, 0.5, 0.25, 0.1, 0.03] {
            let a = albedo(&bsdf, direction(mu, 0.9), 30_000);
            let (low, high) = (a[0].min(a[1]).min(a[2]), a[0].max(a[1]).max(a[2]));
            if high > 1.0 + 1e-3 || (name.starts_with("white") && low < 1.0 - 1e-2) {
                bad += &format!("{name}, µ {mu}: {low:.5} to {high:.5}\n");
            }
        }
    }
    assert!(bad.is_empty(), "\n{bad}");
}

#[test]
fn a_white_metal_furnace_is_white() {
    for roughness in [0.05, 0.12, 0.3, 0.55, 0.77, 1.0] {
        let point = PrincipledPoint {
            base_metalness: 1.0,
            base_color: Spectrum::WHITE,
            specular_roughness: roughness,
            ..Default::default()
        };
        let bsdf = Bsdf::new(&point);
        for mu in [1.0, 0.6, 0.2] {
            let a = albedo(&bsdf, direction(mu, 0.3), 40_000)[0];
            assert!((a - 1.0).abs() < 1.2e-3, "roughness {roughness}, µ {mu}: {a:.5}");
        }
    }
}

#[test]
fn named_metals_reflect_their_colour_head_on() {
    for word in MetalName::WORDS {
        let c = MetalName::from_word(word).unwrap().colors();
        let point = PrincipledPoint {
            base_metalness: 1.0,
            base_color: c.f0,
            specular_color: c.tint,
            specular_roughness: 0.0,
            ..Default::default()
        };
        let bsdf = Bsdf::new(&point);
        for (mu, tint) in [(1.0, Spectrum::WHITE), (1.0 / 7.0, c.tint)] {
            let s = bsdf.sample(direction(mu, 0.4), [0.5; 3]).unwrap();
            for ((f, f0), tint) in s.f.to_array().into_iter().zip(c.f0.to_array()).zip(tint.to_array()) {
                let schlick = f0 + (1.0 - f0) * crate::math::elementary::pow_int(1.0 - mu, 5) as f32;
                assert!((f * mu as f32 - schlick * tint).abs() < 1e-5, "{word} µ {mu}: {s:?}");
            }
        }
    }
}

//! A coat with its own normal.

use crate::bsdf::{Bsdf, PrincipledPoint};
use crate::color::Spectrum;
use crate::math::DVec3;
use crate::math::elementary::{cos, sin};
use crate::testing::{direction, spread};

fn coats() -> Vec<(String, Bsdf<'static>)> {
    let mut out = Vec::new();
    for roughness in [0.0, 0.2, 0.6] {
        for tilt in [0.15, 0.5] {
            let point = PrincipledPoint {
                base_color: Spectrum::grey(1.0),
                specular_roughness: 0.4,
                coat_weight: 1.0,
                coat_roughness: roughness,
                coat_darkening: 0.0,
                ..PrincipledPoint::default()
            };
            let n = DVec3::new(sin(tilt), 0.0, cos(tilt));
            out.push((format!("{roughness} {tilt}"), Bsdf::new(&point).with_coat_normal(n)));
        }
    }
    out
}

const OUT: [(f64, f64); 4] = [(0.95, 0.0), (0.6, 2.0), (0.4, 0.3), (0.25, 3.0)];

/// ∫ f cos and ∫ pdf over the upper hemisphere, on a fine grid.
fn integrals(bsdf: &Bsdf<'_>, wo: DVec3) -> (f64, f64) {
    let (rows, columns) = (600, 600);
    let (mut energy, mut density) = (0.0, 0.0);
    for i in 0..rows * columns {
        let z = (f64::from(i / columns) + 0.5) / f64::from(rows);
        let phi = std::f64::consts::TAU * (f64::from(i % columns) + 0.5) / f64::from(columns);
        let (f, pdf) = bsdf.eval_pdf(wo, direction(z, phi));
        energy += f64::from(f.g) * z;
        density += pdf;
    }
    let size = std::f64::consts::TAU / f64::from(rows * columns);
    (energy * size, density * size)
}

#[test]
fn no_energy_appears_and_samples_find_all_of_it() {
    for (name, bsdf) in coats() {
        for (z, phi) in OUT {
            let wo = direction(z, phi);
            let (energy, density) = integrals(&bsdf, wo);
            let (mut smooth, mut mirrored, mut probability) = (0.0, 0.0, 0.0);
            let n = 1 << 14;
            for i in 0..n {
                let Some(s) = bsdf.sample(wo, spread(i)) else { continue };
                let weight = f64::from(s.f.g) * s.wi.z.abs() / s.pdf / f64::from(n);
                if s.lobe.is_delta {
                    mirrored += weight;
                } else {
                    smooth += weight;
                    probability += 1.0 / f64::from(n);
                    let (f, pdf) = bsdf.eval_pdf(wo, s.wi);
                    assert!(
                        (pdf / s.pdf - 1.0).abs() < 1e-9
                            && (f - s.f).map(f32::abs).max_component() < 1e-5 * (1.0 + f.g)
                    );
                }
            }
            assert!((smooth - energy).abs() < 0.01, "{name} {z} {phi}: {smooth} and {energy}");
            assert!((probability - density).abs() < 0.01, "{name} {z} {phi}: {probability} and {density}");
            assert!(energy + mirrored < 1.001, "{name} {z} {phi}: {energy} + {mirrored}");
            // Callers bend shading normals until the mirror direction is above the surface; other normals lose more.
            let n = bsdf.coat_normal.unwrap();
            let mirror = 2.0 * wo.dot(n) * n - wo;
            assert!(mirror.z < 0.05 || energy + mirrored > 0.55, "{name} {z} {phi}: {energy} + {mirrored}");
        }
    }
}

#[test]
fn a_smooth_coat_mirrors_about_its_own_normal() {
    let (_, bsdf) = &coats()[1];
    let n = DVec3::new(sin(0.5), 0.0, cos(0.5));
    let wo = direction(0.9, 0.0);
    let expected = 2.0 * wo.dot(n) * n - wo;
    let found = (0..256).filter_map(|i| bsdf.sample(wo, spread(i))).find(|s| s.lobe.is_delta);
    assert!((found.unwrap().wi - expected).length() < 1e-12);
}

#[test]
fn a_coat_normal_along_the_surface_changes_nothing() {
    for (_, bsdf) in coats() {
        let plain = Bsdf { coat_normal: None, ..bsdf };
        let same = plain.with_coat_normal(DVec3::Z);
        let (wo, wi) = (direction(0.7, 0.3), direction(0.5, 2.0));
        assert_eq!(plain.eval_pdf(wo, wi), same.eval_pdf(wo, wi));
    }
}

//! Disney's principled BSDF: the models that its facets share with OpenPBR's, closed forms, samples and densities.

use std::f64::consts::PI;

use crate::bsdf::{Bsdf, DisneyPoint, FacetMasking, PrincipledPoint};
use crate::color::Spectrum;
use crate::math::DVec3;
use crate::testing::{
    ChiSquareOptions, albedo, direction, reciprocity_error, samples_agree_with_eval, samples_follow_density,
    sidak_level,
};

fn point() -> DisneyPoint {
    DisneyPoint {
        base_color: Spectrum::new(0.8, 0.4, 0.1),
        metallic: 0.0,
        roughness: 0.4,
        anisotropic: 0.0,
        ior: 1.5,
        spec_trans: 0.0,
        spec_tint: 0.0,
        sheen: 0.0,
        sheen_tint: 0.0,
        clearcoat: 0.0,
        clearcoat_gloss: 0.0,
        flatness: 0.0,
        diff_trans: 0.0,
        thin_walled: false,
        inside: false,
    }
}

fn cases() -> Vec<(&'static str, DisneyPoint)> {
    let p = point();
    let glass = DisneyPoint { spec_trans: 1.0, ..p };
    let thin = DisneyPoint { thin_walled: true, spec_trans: 0.5, diff_trans: 0.6, ..p };
    vec![
        ("plastic", p),
        ("metal", DisneyPoint { metallic: 1.0, anisotropic: 0.8, ..p }),
        ("half metal", DisneyPoint { metallic: 0.5, spec_tint: 0.7, ..p }),
        ("cloth", DisneyPoint { sheen: 1.0, sheen_tint: 0.5, flatness: 0.6, roughness: 0.9, ..p }),
        ("coated", DisneyPoint { clearcoat: 1.0, roughness: 0.6, ..p }),
        ("glass", glass),
        ("half glass", DisneyPoint { spec_trans: 0.5, metallic: 0.2, ..p }),
        ("glass from inside", DisneyPoint { inside: true, ..glass }),
        ("light glass", DisneyPoint { ior: 0.8, ..glass }),
        ("thin wall", thin),
        ("thin cloth", DisneyPoint { spec_trans: 0.0, sheen: 1.0, flatness: 1.0, ..thin }),
    ]
}

#[test]
fn samples_follow_the_density() {
    let cosines = [0.95, 0.5, 0.15];
    let level = sidak_level(0.01, cases().len() * cosines.len());
    let mut bad = String::new();
    for (name, p) in cases() {
        for (n, mu) in cosines.into_iter().enumerate() {
            let bsdf = Bsdf::disney(&p);
            let wo = direction(mu, 0.7 + n as f64);
            let test = samples_follow_density(&bsdf, wo, 31 + n as u64, &ChiSquareOptions::default());
            if test.p_value < level {
                bad += &format!("{name}, µ {mu}: {test:?}\n");
            }
            samples_agree_with_eval(&bsdf, wo, 400).unwrap();
        }
    }
    assert!(bad.is_empty(), "\n{bad}");
}

#[test]
fn exchanging_the_directions_changes_nothing() {
    for (name, p) in cases() {
        let error = reciprocity_error(&Bsdf::disney(&p), None, 300);
        assert!(error < 2e-5, "{name}: {error}");
    }
    for ior in [1.5, 0.8] {
        let glass = DisneyPoint { spec_trans: 0.7, ior, ..point() };
        let back = Bsdf::disney(&DisneyPoint { inside: true, ..glass });
        let error = reciprocity_error(&Bsdf::disney(&glass), Some((&back, ior)), 300);
        assert!(error < 2e-5, "{ior}: {error}");
    }
}

/// White metal reflects by F = 1 from the same facets as OpenPBR's, glass by the same Fresnel equations.
#[test]
fn facets_are_those_of_openpbr() {
    let facets = PrincipledPoint {
        base_color: Spectrum::WHITE,
        specular_roughness: 0.4,
        specular_multiple_scattering: false,
        specular_masking: FacetMasking::Separable,
        ..PrincipledPoint::default()
    };
    let white = DisneyPoint { base_color: Spectrum::WHITE, ..point() };
    let pairs = [
        (DisneyPoint { metallic: 1.0, ..white }, PrincipledPoint { base_metalness: 1.0, ..facets }),
        (DisneyPoint { spec_trans: 1.0, ..white }, PrincipledPoint { transmission_weight: 1.0, ..facets }),
    ];
    for (disney, openpbr) in pairs {
        let (a, b) = (Bsdf::disney(&disney), Bsdf::new(&openpbr));
        for k in 0..200 {
            let t = f64::from(k) / 200.0;
            let wo = direction(0.05 + 0.9 * t, 0.3);
            let wi = direction(
                (0.97 * (3.0 * t).fract()).max(0.05) * if k % 2 == 0 { 1.0 } else { -1.0 },
                7.0 * t,
            );
            let (f, g) = (f64::from(a.eval(wo, wi).g), f64::from(b.eval(wo, wi).g));
            assert!((f - g).abs() < 1e-4 * (f + g) + 1e-6, "{wo} {wi}: {f} and {g}");
        }
    }
}

#[test]
fn closed_forms() {
    // Seen and lit from straight above, diffuse reflection is Lambert's, beside a highlight of F₀ D / 4.
    let p = point();
    let (up, alpha) = (DVec3::Z, 0.16);
    let f = f64::from(Bsdf::disney(&p).eval(up, up).r);
    let expected = 0.8 / PI + 0.04 / (4.0 * PI * alpha * alpha);
    assert!((f - expected).abs() < 1e-5, "{f} {expected}");
    // A quarter turn apart at 45°: h = z, µ = cos 45°, and Burley's factor with cos² θd = 1/2.
    let rough = DisneyPoint { roughness: 1.0, ..p };
    let (wo, wi) = (direction(0.5f64.sqrt(), 0.0), direction(0.5f64.sqrt(), PI));
    let w = crate::math::elementary::pow_int(1.0 - 0.5f64.sqrt(), 5);
    let burley = (1.0 - 0.5 * w) * (1.0 - 0.5 * w) + 2.0 * w;
    let (dull, shiny) =
        (Bsdf::disney(&rough), Bsdf::disney(&DisneyPoint { base_color: Spectrum::BLACK, ..rough }));
    let diffuse = f64::from(dull.eval(wo, wi).r) - f64::from(shiny.eval(wo, wi).r);
    assert!((diffuse - 0.8 * burley / PI).abs() < 1e-5, "{diffuse}");
    // Sheen alone, on black: weight (1 − cos θd)⁵.
    let cloth = DisneyPoint { sheen: 1.0, base_color: Spectrum::BLACK, ..rough };
    let sheen = f64::from(Bsdf::disney(&cloth).eval(wo, wi).r) - f64::from(shiny.eval(wo, wi).r);
    assert!((sheen - w).abs() < 1e-5, "{sheen} {w}");
}

#[test]
fn white_glass_keeps_almost_all_light() {
    for (roughness, least) in [(0.1, 0.999), (0.4, 0.95)] {
        let glass = DisneyPoint { base_color: Spectrum::WHITE, spec_trans: 1.0, roughness, ..point() };
        for mu in [1.0, 0.6, 0.3] {
            let a = albedo(&Bsdf::disney(&glass), direction(mu, 0.4), 20_000)[1];
            assert!(a <= 1.001 && a >= least, "{roughness} {mu}: {a}");
        }
    }
}

/// Numbers of any kind give numbers.
#[test]
fn values_out_of_range_are_clamped() {
    for v in [-1.0, 0.0, 2.0, f64::NAN, f64::INFINITY, 1e300] {
        let p = DisneyPoint {
            base_color: Spectrum::grey(v as f32),
            metallic: v,
            roughness: v,
            anisotropic: v,
            ior: v,
            spec_trans: v,
            spec_tint: v,
            sheen: v,
            sheen_tint: v,
            clearcoat: v,
            clearcoat_gloss: v,
            flatness: v,
            diff_trans: v,
            thin_walled: false,
            inside: false,
        };
        for p in [p, DisneyPoint { thin_walled: true, ..p }, DisneyPoint { inside: true, ..p }] {
            let bsdf = Bsdf::disney(&p);
            for k in 0..50 {
                let u = crate::testing::spread(k);
                let wo = direction(u[0].max(1e-3), 6.0 * u[1]);
                let (f, pdf) = bsdf.eval_pdf(wo, direction(2.0 * u[2] - 1.0, 3.0 * u[0]));
                assert!(f.is_finite() && pdf.is_finite() && pdf >= 0.0, "{p:?}: {f:?} {pdf}");
                if let Some(s) = bsdf.sample(wo, u) {
                    assert!(s.f.is_finite() && s.pdf > 0.0, "{p:?}: {s:?}");
                }
            }
        }
    }
}

//! Properties of the BSDF follow from all of its lobes.

use crate::bsdf::albedo::AlbedoDirection;
use crate::bsdf::facets::FacetDistribution;
use crate::bsdf::mixture::{INTERFACE, LOBES, MULTI_REFLECT, REFLECT};
use crate::bsdf::{Bsdf, PrincipledPoint, Rgb};
use crate::color::Spectrum;
use crate::testing::{direction, materials};

/// Which lobes return light.
fn lobes(bsdf: &Bsdf<'_>) -> [bool; LOBES] {
    bsdf.albedos(bsdf.above_on(AlbedoDirection::all(0.6), bsdf.inside)).map(|albedo| albedo != Rgb::ZERO)
}

#[test]
fn every_lobe_is_in_the_table_of_materials() {
    let mut found = [false; LOBES];
    for (_, point) in materials() {
        for subsurface_walk in [false, true] {
            let bsdf = Bsdf::new(&PrincipledPoint { subsurface_walk, ..point });
            found.iter_mut().zip(lobes(&bsdf)).for_each(|(found, has)| *found |= has);
        }
    }
    assert_eq!(found, [true; LOBES], "testing::materials has no point for a lobe");
}

#[test]
fn bsdfs_of_few_lobes_have_no_other_lobe() {
    for (name, point) in materials() {
        let bsdf = Bsdf::new(&point);
        let only = |some: &[usize]| lobes(&bsdf).iter().enumerate().all(|(i, has)| !has || some.contains(&i));
        assert!(bsdf.as_lambert().is_none() || only(&[REFLECT]), "{name} is not Lambert's reflection alone");
        let base = [INTERFACE, REFLECT, MULTI_REFLECT];
        assert!(bsdf.as_opaque_base().is_none() || only(&base), "{name} is not an opaque base alone");
    }
}

#[test]
fn has_smooth_is_whether_light_is_scattered() {
    let wo = direction(0.6, 0.3);
    let directions = || (0..400).map(|i| (f64::from(i % 20) / 10.0 - 0.95, f64::from(i / 20) * 0.314));
    for (name, point) in materials() {
        let bsdf = Bsdf::new(&point);
        let scatters = directions().any(|(mu, phi)| !bsdf.eval(wo, direction(mu, phi)).is_black());
        assert_eq!(bsdf.has_smooth(), scatters, "{name}");
    }
}

#[test]
fn glass_alone_is_the_sum_of_all_lobes() {
    let glass = PrincipledPoint {
        transmission_weight: 1.0,
        transmission_tint: Spectrum::new(0.9, 0.5, 0.2),
        specular_multiple_scattering: false,
        ..Default::default()
    };
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-6 * a.abs().max(b.abs());
    let near_color = |a: Spectrum, b: Spectrum| {
        a.to_array().iter().zip(b.to_array()).all(|(a, b)| near(f64::from(*a), f64::from(b)))
    };
    let beckmann = FacetDistribution::Beckmann;
    for roughness in [0.0, 0.1, 0.5] {
        for (entering, thin_walled) in [(true, false), (false, false), (true, true)] {
            let point = PrincipledPoint { specular_roughness: roughness, entering, thin_walled, ..glass };
            let point = PrincipledPoint { specular_distribution: beckmann, ..point };
            let alone = Bsdf::new(&point);
            let general = Bsdf { glass_alone: false, ..alone };
            assert!(alone.glass_alone);
            for i in 0..200 {
                let along = f64::from(i) / 200.0;
                let wo = direction(0.05 + 0.9 * along, 0.3);
                let u = [(along * 37.0).fract(), (along * 91.0).fract(), (along * 53.0).fract()];
                let (a, b) = (alone.sample(wo, u), general.sample(wo, u));
                assert_eq!(a.is_some(), b.is_some());
                let (Some(a), Some(b)) = (a, b) else { continue };
                assert!(a.wi == b.wi && a.lobe == b.lobe && a.eta == b.eta);
                assert!(near(a.pdf, b.pdf) && near_color(a.f, b.f), "{a:?} {b:?}");
                let ((f, pdf), (g, other)) = (alone.eval_pdf(wo, a.wi), general.eval_pdf(wo, a.wi));
                assert!(near(pdf, other) && near_color(f, g), "{f:?} {g:?} {pdf} {other}");
            }
        }
    }
    let diffuse = PrincipledPoint { transmission_weight: 0.5, ..glass };
    let coated = PrincipledPoint { coat_weight: 0.5, ..glass };
    for point in [diffuse, coated, PrincipledPoint { specular_multiple_scattering: true, ..glass }] {
        let point = PrincipledPoint { specular_roughness: 0.3, ..point };
        assert!(!Bsdf::new(&point).glass_alone);
    }
}

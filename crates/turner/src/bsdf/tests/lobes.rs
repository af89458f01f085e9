//! Properties of the BSDF follow from all of its lobes.

use crate::bsdf::albedo::AlbedoDirection;
use crate::bsdf::mixture::{INTERFACE, LOBES, MULTI_REFLECT, REFLECT};
use crate::bsdf::{Bsdf, PrincipledPoint, Rgb};
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

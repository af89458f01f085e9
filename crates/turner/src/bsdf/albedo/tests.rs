//! The tables, between their nodes, against sums over many facets.

use super::microfacets::Lattice;
use super::rows::{index, value};
use super::*;
use crate::math::elementary::sin_cos;

#[test]
fn the_interpolated_tables_hold_what_lobes_reflect_and_lose() {
    let lattice = Lattice::new(28657, 17711);
    let mut bad = String::new();
    let round = [0.003, 0.02, 0.07, 0.25, 0.6, 0.99].map(|a| (a, 1.0));
    let stretched = [(0.05, 0.5), (0.3, 0.15), (0.65, 0.7), (0.9, 0.1)];
    for (alpha, ratio) in round.into_iter().chain(stretched) {
        let ggx = Facets::ggx(alpha, alpha * ratio);
        let azimuths: &[f64] = if ratio == 1.0 { &[0.0] } else { &[0.0, 0.5, 1.4] };
        for (mu, phi) in [0.01, 0.04, 0.1, 0.3, 0.6, 0.75, 1.0f64]
            .into_iter()
            .flat_map(|mu| azimuths.iter().map(move |a| (mu, *a)))
        {
            let (s, c) = sin_cos(phi);
            let r = (1.0 - mu * mu).sqrt();
            let wo = DVec3::new(r * c, r * s, mu);
            let mut test = |grid, contrast| {
                let curve = AlbedoCurve::new(grid, &ggx, index(contrast));
                let off = curve.at(AlbedoDirection::of(wo)) - value(grid, &ggx, wo, contrast, &lattice);
                // The critical angle is a sharp edge, near normal incidence for similar indices; strongly anisotropic
                // lobes are coarse at grazing angles.
                let limit = match (contrast < 0.1, ratio < 1.0) {
                    (true, true) => 3e-2,
                    (false, true) => 8e-3,
                    (true, false) => 3e-3,
                    _ => 1.2e-3,
                };
                if off.abs() > limit {
                    bad += &format!(
                        "{grid:?} α {alpha} ratio {ratio} µ {mu} φ {phi} contrast {contrast}: {off:+.5}\n"
                    );
                }
            };
            test(Grid::MirrorLoss, 1.0);
            for contrast in [0.0244, 0.13, 0.2, 0.35, 0.6, 0.8] {
                for grid in [Grid::Reflected, Grid::LossFromThin, Grid::LossFromDense] {
                    test(grid, contrast);
                }
            }
        }
    }
    assert!(bad.is_empty(), "\n{bad}");
}

#[test]
fn averages_are_those_of_the_curves() {
    for (ax, ay) in [(0.01, 0.01), (0.4, 0.4), (1.0, 1.0), (0.5, 0.1), (0.1, 0.9)] {
        let ggx = Facets::ggx(ax, ay);
        let n = 4000;
        let mean = |at: &dyn Fn(AlbedoDirection) -> f64| -> f64 {
            let of = |i: u32| {
                let s = (f64::from(i) + 0.5) / f64::from(n);
                at(AlbedoDirection::all(s * s)) * 4.0 * s * s * s / f64::from(n)
            };
            (0..n).map(of).sum()
        };
        for curve in [mirror_loss(&ggx), dielectric_loss(1.5, &ggx), dielectric_loss(1.0 / 1.5, &ggx)] {
            let (found, summed) = (curve.average(), mean(&|w| curve.at(w)));
            assert!((found - summed).abs() < 1e-3 * summed, "{curve:?}: {found} and {summed}");
        }
        let reflected = Reflected::new(&ggx, 1.7);
        let (found, summed) = (reflected.average(), mean(&|w| reflected.at(w)));
        let limit = if ax == ay { 3e-4 } else { 6e-4 };
        assert!((found - summed).abs() < limit, "{ggx:?}: {found} and {summed}");
    }
}

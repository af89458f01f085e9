//! Samples follow their filter, and a white image stays white.

use super::*;

const ALL: [FilterKind; 4] =
    [FilterKind::Box, FilterKind::Tent, FilterKind::Gaussian, FilterKind::BlackmanHarris];

/// The integral of a filter's profile over `from..to` radii, by Simpson's rule.
fn integral(kind: FilterKind, from: f64, to: f64) -> f64 {
    let n = 512;
    let h = (to - from) / f64::from(n);
    let at = |i: i32| kind.profile((from + h * f64::from(i)).abs().min(1.0));
    let inner: f64 = (1..n).map(|i| at(i) * if i % 2 == 1 { 4.0 } else { 2.0 }).sum();
    (at(0) + at(n) + inner) * h / 3.0
}

/// A low-discrepancy point of the unit square (Roberts 2018, the R2 sequence), shifted by `offset`.
fn point(i: u32, offset: f64) -> DVec2 {
    let step = DVec2::new(0.754_877_666_246_692_7, 0.569_840_290_998_053_3);
    (DVec2::splat(0.5 + offset) + step * f64::from(i)).fract()
}

#[test]
fn the_profiles_fall_from_the_centre_to_zero() {
    for kind in ALL {
        let values: Vec<f64> = (0..=100).map(|i| kind.profile(f64::from(i) / 100.0)).collect();
        assert!(values.windows(2).all(|v| v[1] <= v[0] + 1e-15) && values[0] > 0.0, "{kind:?}");
        let end = values[100];
        assert!(if kind == FilterKind::Box { end == 1.0 } else { end < 1e-4 * values[0] }, "{kind:?}: {end}");
    }
    // Harris 1978: the window is 1 at the centre.
    assert!((FilterKind::BlackmanHarris.profile(0.0) - 1.0).abs() < 1e-12);
}

#[test]
fn samples_follow_the_filter() {
    for kind in ALL {
        for radius in [None, Some(0.5), Some(3.0)] {
            let filter = Filter::new(kind, radius);
            let r = radius.unwrap_or(kind.default_radius());
            // Pearson's statistic against the exact profile, along each axis: the 99.9th percentile for 39 degrees of
            // freedom is 72.1. Independent random numbers: the points of a sequence would be too even.
            const BINS: usize = 40;
            let (mut seen, n) = ([[0u32; BINS]; 2], 200_000u32);
            for i in 0..n {
                let id = crate::sampler::SampleId { x: i % 512, y: i / 512, index: 0, seed: 5 };
                let p = (filter.place(id.unit_square(9)) - 0.5) / r;
                for (axis, v) in [p.x, p.y].into_iter().enumerate() {
                    assert!((-1.0..=1.0).contains(&v), "{kind:?} {v}");
                    seen[axis][(((v + 1.0) * 0.5 * BINS as f64) as usize).min(BINS - 1)] += 1;
                }
            }
            let whole = integral(kind, -1.0, 1.0);
            let edge = |i: usize| 2.0 * i as f64 / BINS as f64 - 1.0;
            for seen in seen {
                let (mut chi2, mut rare) = (0.0, (0.0, 0.0));
                for (i, seen) in seen.into_iter().enumerate() {
                    let expected = integral(kind, edge(i), edge(i + 1)) / whole * f64::from(n);
                    let seen = f64::from(seen);
                    if expected < 10.0 {
                        rare = (rare.0 + expected, rare.1 + seen);
                    } else {
                        chi2 += (seen - expected) * (seen - expected) / expected;
                    }
                }
                assert!(chi2 < 72.1, "{kind:?} {radius:?}: {chi2}");
                assert!((rare.1 - rare.0).abs() < 4.0 * (rare.0 + 1.0f64).sqrt(), "{kind:?}: {rare:?}");
            }
        }
    }
}

#[test]
fn the_table_is_the_filter_to_a_ten_thousandth() {
    for kind in [FilterKind::Gaussian, FilterKind::BlackmanHarris] {
        let table = Table::new(|x| kind.profile(x));
        let whole = integral(kind, 0.0, 1.0);
        for i in 0..=1000 {
            let x = f64::from(i) / 1000.0;
            let (density, exact) = (table.density(x), kind.profile(x) / whole);
            assert!((density - exact).abs() < 1e-4 * table.density(0.0), "{kind:?} {x}: {density} {exact}");
            // The position of a cumulative fraction, and the fraction at that position.
            let u = integral(kind, 0.0, x) / whole;
            assert!(exact < 0.05 || (table.invert(u) - x).abs() < 1e-4, "{kind:?} {u}: {}", table.invert(u));
        }
        for u in [-1.0, 0.0, 1.0, 2.0, f64::NAN, 1.0 - f64::EPSILON] {
            assert!((0.0..=1.0).contains(&table.invert(u)), "{u}");
        }
    }
}

#[test]
fn positions_have_the_mean_and_the_variance_of_the_filter() {
    for kind in ALL {
        let filter = Filter::new(kind, None);
        let (n, r) = (100_000, kind.default_radius());
        let positions: Vec<DVec2> = (0..n).map(|i| filter.place(point(i, 0.0)) - 0.5).collect();
        let mean = positions.iter().sum::<DVec2>() / f64::from(n);
        let spread = positions.iter().map(|p| *p * *p).sum::<DVec2>() / f64::from(n);
        // ∫x²f / ∫f, in closed form.
        let expected = r
            * r
            * match kind {
                FilterKind::Box => 1.0 / 3.0,
                FilterKind::Tent => 1.0 / 6.0,
                // (σ²·√(π/2)σ·erf(3/√2) − σ²e^(−9/2) − e^(−9/2)/3) / (√(π/2)σ·erf(3/√2) − e^(−9/2)), σ = 1/3.
                FilterKind::Gaussian => {
                    let (s, e) = (1.0 / 3.0_f64, exp(-4.5));
                    let bell = (PI / 2.0).sqrt() * s * 0.997_300_203_936_739_8;
                    (s * s * bell - s * s * e - e / 3.0) / (bell - e)
                }
                // ∫x²cos(nπx) over 0..1 is 2(−1)^n/(nπ)².
                FilterKind::BlackmanHarris => {
                    let pi2 = PI * PI;
                    (0.35875 / 3.0 - 2.0 * 0.48829 / pi2 + 0.14128 / (2.0 * pi2)
                        - 2.0 * 0.01168 / (9.0 * pi2))
                        / 0.35875
                }
            };
        assert!(mean.abs().max_element() < 1e-3, "{kind:?}: {mean}");
        assert!((spread - expected).abs().max_element() < 1e-3 * r * r, "{kind:?}: {spread} {expected}");
    }
}

#[test]
fn the_default_box_is_the_identity() {
    for radius in [None, Some(0.5)] {
        let filter = Filter::new(FilterKind::Box, radius);
        for i in 0..100 {
            assert_eq!(filter.place(point(i, 0.3)), point(i, 0.3));
        }
    }
    assert_eq!(Filter::new(FilterKind::Box, Some(2.0)).place(DVec2::new(0.0, 0.75)), DVec2::new(-1.5, 1.5));
}

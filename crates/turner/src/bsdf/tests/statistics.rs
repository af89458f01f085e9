//! Densities: samples follow them, they cover the sphere once, and samples agree with `eval` and `pdf`.

use super::energy::{direction, spread};
use super::materials::materials;
use crate::bsdf::Bsdf;
use crate::math::DVec3;
use crate::math::elementary::{exp, ln};

/// Rows of equal height and columns of equal angle.
const ROWS: usize = 24;
const COLUMNS: usize = 16;
const SAMPLES: u32 = 20_000;

fn cell(w: DVec3) -> usize {
    let row = (((1.0 - w.z) * 0.5 * ROWS as f64) as usize).min(ROWS - 1);
    let turn = crate::math::elementary::atan2(w.y, w.x) / std::f64::consts::TAU;
    let column = ((turn.rem_euclid(1.0) * COLUMNS as f64) as usize).min(COLUMNS - 1);
    row * COLUMNS + column
}

/// Pseudo-random numbers (PCG).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let x = ((self.0 >> 22) ^ self.0) >> (22 + (self.0 >> 61));
        f64::from(x as u32) / 4_294_967_296.0
    }
}

/// Mean of the density over each cell times its size, by adaptive subdivision: lobes may be narrow.
fn expected(bsdf: &Bsdf, wo: DVec3) -> Vec<f64> {
    let mut out = vec![0.0; ROWS * COLUMNS];
    for (k, slot) in out.iter_mut().enumerate() {
        let (row, column) = ((k / COLUMNS) as f64, (k % COLUMNS) as f64);
        let z1 = 1.0 - 2.0 * row / ROWS as f64;
        let p0 = column / COLUMNS as f64 * std::f64::consts::TAU;
        *slot = integrate(
            &|z, phi| bsdf.pdf(wo, direction(z, phi)),
            (z1 - 2.0 / ROWS as f64, z1),
            (p0, p0 + std::f64::consts::TAU / COLUMNS as f64),
            0,
        );
    }
    out
}

fn integrate(f: &impl Fn(f64, f64) -> f64, z: (f64, f64), phi: (f64, f64), depth: u32) -> f64 {
    let area = (z.1 - z.0) * (phi.1 - phi.0);
    let rule = |n: u32| {
        let mut sum = 0.0;
        for i in 0..n {
            for j in 0..n {
                let at = |(a, b): (f64, f64), k: u32| a + (b - a) * (f64::from(k) + 0.5) / f64::from(n);
                sum += f(at(z, i), at(phi, j));
            }
        }
        sum * area / f64::from(n * n)
    };
    let (coarse, fine) = (rule(2), rule(4));
    if depth >= 6 || (depth >= 1 && (coarse - fine).abs() < 2e-6 + 4e-3 * fine) {
        return fine;
    }
    let (zm, pm) = (0.5 * (z.0 + z.1), 0.5 * (phi.0 + phi.1));
    [((z.0, zm), (phi.0, pm)), ((z.0, zm), (pm, phi.1)), ((zm, z.1), (phi.0, pm)), ((zm, z.1), (pm, phi.1))]
        .into_iter()
        .map(|(z, phi)| integrate(f, z, phi, depth + 1))
        .sum()
}

/// Probability that χ² with `n` degrees of freedom exceeds `x` (Wilson and Hilferty's approximation by the normal distribution).
fn chi_square_tail(x: f64, n: f64) -> f64 {
    let v = 2.0 / (9.0 * n);
    let t = (crate::math::elementary::cbrt(x / n) - (1.0 - v)) / v.sqrt();
    // Abramowitz and Stegun 26.2.17.
    let k = 1.0 / (1.0 + 0.231_641_9 * t.abs());
    let poly = k
        * (0.319_381_53
            + k * (-0.356_563_782 + k * (1.781_477_937 + k * (-1.821_255_978 + k * 1.330_274_429))));
    let tail = 0.398_942_28 * exp(-0.5 * t * t) * poly;
    if t > 0.0 { tail } else { 1.0 - tail }
}

#[test]
fn samples_follow_the_density() {
    let cosines = [0.95, 0.5, 0.1];
    let list: Vec<_> = materials().into_iter().filter(|(_, p)| Bsdf::new(p).has_smooth()).collect();
    // Šidák: the chance that any of them fails is 1 % together.
    let level = 1.0 - exp(ln(0.99) / (list.len() * cosines.len()) as f64);
    let mut bad = String::new();
    for (name, point) in &list {
        let bsdf = Bsdf::new(point);
        for (n, mu) in cosines.into_iter().enumerate() {
            let wo = direction(mu, 0.7 + n as f64);
            let expected = expected(&bsdf, wo);
            let mut random = Random(7 + n as u64);
            let (mut counts, mut smooth, mut none) = (vec![0u32; ROWS * COLUMNS], 0u32, 0u32);
            for _ in 0..SAMPLES {
                match bsdf.sample(wo, [random.next(), random.next(), random.next()]) {
                    Some(s) if s.lobe.is_delta => smooth += 1,
                    Some(s) => counts[cell(s.wi)] += 1,
                    None => none += 1,
                }
            }
            let total: f64 = expected.iter().sum();
            let missing = f64::from(smooth + none) / f64::from(SAMPLES);
            let deviation = (missing * (1.0 - missing) / f64::from(SAMPLES)).sqrt();
            if (total + missing - 1.0).abs() > 4.0 * deviation + 3e-3 {
                bad += &format!("{name}, µ {mu}: the density covers {total:.5}, {missing:.5} are missing\n");
            }
            // Cells with few expected samples count as one.
            let (mut chi2, mut freedom, mut rest) = (0.0, 0.0, (0.0, 0.0));
            for (count, expected) in counts.iter().zip(&expected) {
                let (count, expected) = (f64::from(*count), expected * f64::from(SAMPLES));
                if expected < 8.0 {
                    rest = (rest.0 + count, rest.1 + expected);
                } else {
                    chi2 += (count - expected) * (count - expected) / expected;
                    freedom += 1.0;
                }
            }
            if rest.1 >= 8.0 {
                chi2 += (rest.0 - rest.1) * (rest.0 - rest.1) / rest.1;
                freedom += 1.0;
            } else if rest.0 > 40.0 {
                bad += &format!("{name}, µ {mu}: {} samples where {:.2} were expected\n", rest.0, rest.1);
            }
            if freedom >= 2.0 && chi_square_tail(chi2, freedom) < level {
                bad += &format!("{name}, µ {mu}: χ² {chi2:.1} with {freedom} cells\n");
            }
        }
    }
    assert!(bad.is_empty(), "\n{bad}");
}

#[test]
fn the_chi_square_test_notices_a_wrong_density() {
    assert!((chi_square_tail(124.34, 100.0) - 0.05).abs() < 1e-3);
    assert!((chi_square_tail(135.81, 100.0) - 0.01).abs() < 1e-3);
}

#[test]
fn samples_agree_with_eval_and_pdf() {
    for (name, point) in materials() {
        let bsdf = Bsdf::new(&point);
        for mu in [1.0, 0.6, 0.2, 0.01] {
            let wo = direction(mu, 2.0);
            for k in 0..500 {
                let Some(s) = bsdf.sample(wo, spread(k)) else { continue };
                assert!((s.wi.length() - 1.0).abs() < 1e-9, "{name}");
                assert!(s.pdf > 0.0 && s.pdf.is_finite() && s.f.is_finite(), "{name} {s:?}");
                assert_eq!(s.lobe.is_transmission, s.wi.z < 0.0, "{name} {s:?}");
                let (f, pdf) = (bsdf.eval(wo, s.wi), bsdf.pdf(wo, s.wi));
                if s.lobe.is_delta {
                    // A mirror's direction has no area: only other lobes answer for it.
                    assert!(f.is_finite() && pdf < 1e3, "{name} {s:?} {pdf}");
                    continue;
                }
                let close = |a: f64, b: f64| (a - b).abs() <= 1e-4 * a.abs().max(b.abs()) + 1e-9;
                assert!(close(pdf, s.pdf), "{name} µ {mu}: {pdf} and {s:?}");
                for (a, b) in f.to_array().into_iter().zip(s.f.to_array()) {
                    assert!(close(f64::from(a), f64::from(b)), "{name} µ {mu}: {f:?} and {s:?}");
                }
            }
        }
    }
}

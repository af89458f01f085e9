//! Pearson's χ² test: whether a sampler follows its pdf, over the unit square or over all directions.
//!
//! The domain is divided into cells of equal area. A cell of probability p, the integral of the pdf over it,
//! should receive p·n of n samples. If the sampler follows the pdf, the statistic
//!
//! ```text
//! χ² = Σ (counted − expected)² / expected          over all cells
//! ```
//!
//! has the χ² distribution with (cells − 1) degrees of freedom, and its tail is the p-value. The distribution
//! is approximate for small counts, so cells with an expectation below 8 are merged. The integrals are computed
//! by adaptive Gauss-Legendre quadrature, accurately enough that their error does not matter for this number of
//! samples.
//!
//! A second test checks the normalisation: the pdf must integrate to the probability that the sampler returns a
//! sample, which is 1 for most samplers. The p-value combines both. A sample where the pdf is 0 fails at once.

use super::random::direction;
use super::tails::{chi_square_tail, normal_tails, smallest_of};
use crate::math::elementary::atan2;
use crate::math::{DVec2, DVec3};

/// Number of samples and resolution of the test.
#[derive(Clone, Copy, Debug)]
pub struct ChiSquareOptions {
    /// Samples to draw.
    pub samples: u32,
    /// Cells along the first coordinate (for directions: of equal height, from +z to −z).
    pub rows: u32,
    /// Cells along the second coordinate (for directions: of equal angle around z).
    pub columns: u32,
    /// Error that the integral of the pdf may have in addition to the statistical one: for the quadrature of
    /// pdfs with edges.
    pub tolerance: f64,
}

impl Default for ChiSquareOptions {
    fn default() -> ChiSquareOptions {
        ChiSquareOptions { samples: 20_000, rows: 24, columns: 16, tolerance: 3e-3 }
    }
}

/// The result of a test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChiSquare {
    /// Σ (counted − expected)² / expected over the cells.
    pub statistic: f64,
    /// Degrees of freedom: cells, less one.
    pub freedom: f64,
    /// The integral of the pdf over the domain.
    pub covered: f64,
    /// Fraction of draws that returned no sample.
    pub missing: f64,
    /// Samples at which the pdf is not greater than 0.
    pub impossible: u32,
    /// The probability of deviations at least this large if sampler and pdf agree, for cells and normalisation
    /// together; 0 if there are impossible samples.
    pub p_value: f64,
}

/// Tests a sampler of directions against its pdf per solid angle. `sample` is called `samples` times and uses
/// its own random numbers. `None` means no sample; return it for directions that the pdf does not cover as
/// well, such as those of delta lobes.
///
/// ```
/// use turner::testing::{ChiSquareOptions, Random, chi_square_of_directions};
/// let mut random = Random::new(1);
/// let uniform = |_| 0.25 / std::f64::consts::PI;
/// let test = chi_square_of_directions(&ChiSquareOptions::default(), uniform, || Some(random.direction()));
/// assert!(test.p_value > 0.01, "{test:?}");
/// ```
pub fn chi_square_of_directions(
    options: &ChiSquareOptions,
    density: impl Fn(DVec3) -> f64,
    mut sample: impl FnMut() -> Option<DVec3>,
) -> ChiSquare {
    // Height and azimuth preserve area: the unit square is a solid angle of 4π.
    let place = |w: DVec3| {
        let turn = atan2(w.y, w.x) / std::f64::consts::TAU;
        DVec2::new(0.5 * (1.0 - w.z), if turn < 0.0 { turn + 1.0 } else { turn })
    };
    let sphere = 4.0 * std::f64::consts::PI;
    let on_square = |p: DVec2| sphere * density(direction(1.0 - 2.0 * p.x, p.y * std::f64::consts::TAU));
    chi_square_on_square(options, on_square, || sample().map(place))
}

/// Tests a sampler of points of the unit square against its pdf per area.
pub fn chi_square_on_square(
    options: &ChiSquareOptions,
    density: impl Fn(DVec2) -> f64,
    mut sample: impl FnMut() -> Option<DVec2>,
) -> ChiSquare {
    let (rows, columns) = (options.rows.max(1), options.columns.max(1));
    let mut counts = vec![0u32; rows as usize * columns as usize];
    let (mut none, mut impossible) = (0u32, 0);
    for _ in 0..options.samples {
        let Some(p) = sample() else {
            none += 1;
            continue;
        };
        impossible += u32::from(density(p).partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater));
        let along = |v: f64, n: u32| ((v * f64::from(n)) as u32).min(n - 1) as usize;
        counts[along(p.x, rows) * columns as usize + along(p.y, columns)] += 1;
    }
    // The error of the quadrature should be small next to the statistical error.
    let accuracy = 0.1 / f64::from(options.samples.max(1)).sqrt();
    let size = DVec2::new(1.0 / f64::from(rows), 1.0 / f64::from(columns));
    let cells = (0..rows).flat_map(|i| (0..columns).map(move |j| DVec2::new(f64::from(i), f64::from(j))));
    let expected: Vec<f64> = cells.map(|c| integrate(&density, c * size, size, accuracy, 0)).collect();
    judge(options, &counts, (none, impossible), &expected)
}

fn judge(
    options: &ChiSquareOptions,
    counts: &[u32],
    (none, impossible): (u32, u32),
    expected: &[f64],
) -> ChiSquare {
    let n = f64::from(options.samples);
    let covered: f64 = expected.iter().sum();
    let missing = f64::from(none) / n;
    let drawn = n - f64::from(none);
    let (mut statistic, mut cells, mut rest) = (0.0, 0.0, (0.0, 0.0));
    for (count, share) in counts.iter().zip(expected) {
        // The number of samples is tested separately: here they are distributed over the cells.
        let (count, expected) = (f64::from(*count), share / covered * drawn);
        if expected < 8.0 {
            rest = (rest.0 + count, rest.1 + expected);
        } else {
            statistic += (count - expected) * (count - expected) / expected;
            cells += 1.0;
        }
    }
    if rest != (0.0, 0.0) {
        // With a small expectation the deviation is divided by at least 5, where the χ² distribution is
        // accurate enough.
        statistic += (rest.0 - rest.1) * (rest.0 - rest.1) / rest.1.max(5.0);
        cells += 1.0;
    }
    let freedom = cells - 1.0;
    let by_cells = if freedom >= 1.0 { chi_square_tail(statistic, freedom) } else { 1.0 };
    let deviation = (missing * (1.0 - missing) / n).sqrt();
    let off = ((covered + missing - 1.0).abs() - options.tolerance).max(0.0);
    let by_whole = match deviation > 0.0 {
        true => normal_tails(off / deviation),
        false => f64::from(off == 0.0),
    };
    // A non-finite pdf is no pdf.
    let valid = impossible == 0 && statistic.is_finite() && covered.is_finite();
    let p_value = if valid { smallest_of(by_cells.min(by_whole), 2) } else { 0.0 };
    ChiSquare { statistic, freedom, covered, missing, impossible, p_value }
}

/// Nodes and weights of Gauss-Legendre quadrature on −1..1.
const THREE: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];
const FIVE: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

/// The integral over a rectangle, subdivided until two rules agree: the pdf may be narrow or have edges.
fn integrate(f: &impl Fn(DVec2) -> f64, at: DVec2, size: DVec2, accuracy: f64, depth: u32) -> f64 {
    const DEEPEST: u32 = 7;
    let rule = |points: &[(f64, f64)]| {
        let mut sum = 0.0;
        for (x, wx) in points {
            for (y, wy) in points {
                sum += wx * wy * f(at + 0.5 * size * (DVec2::new(*x, *y) + 1.0));
            }
        }
        0.25 * sum * size.x * size.y
    };
    let fine = rule(&FIVE);
    // The first level may miss a narrow lobe.
    if depth >= DEEPEST || (depth >= 1 && (rule(&THREE) - fine).abs() <= accuracy * (fine + accuracy * 1e-2))
    {
        return fine;
    }
    let half = 0.5 * size;
    [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE]
        .into_iter()
        .map(|corner| integrate(f, at + corner * half, half, accuracy, depth + 1))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::super::Random;
    use super::*;

    /// Points with the pdf 2x.
    fn ramp(random: &mut Random) -> Option<DVec2> {
        Some(DVec2::new(random.unit().sqrt(), random.unit()))
    }

    #[test]
    fn a_right_density_passes_and_wrong_ones_do_not() {
        let options = ChiSquareOptions { rows: 10, columns: 10, ..Default::default() };
        let mut random = Random::new(3);
        let right = chi_square_on_square(&options, |p| 2.0 * p.x, || ramp(&mut random));
        assert!(right.p_value > 0.01 && (right.covered - 1.0).abs() < 1e-9, "{right:?}");
        let tilted = chi_square_on_square(&options, |p| 2.0 * p.x * (0.9 + 0.2 * p.y), || ramp(&mut random));
        assert!(tilted.p_value < 1e-3, "{tilted:?}");
        let scaled = chi_square_on_square(&options, |p| 2.02 * p.x, || ramp(&mut random));
        assert!(scaled.p_value == 0.0, "{scaled:?}");
        let hole = |p: DVec2| if p.x < 0.5 { 0.0 } else { 8.0 / 3.0 * p.x };
        assert!(chi_square_on_square(&options, hole, || ramp(&mut random)).impossible > 100);
        // The pdf of a sampler that may return none integrates to the probability of a sample.
        let mut weak = random.clone();
        let some = || ramp(&mut weak).filter(|p| p.y < 0.5);
        let half = chi_square_on_square(&options, |p| if p.y < 0.5 { 2.0 * p.x } else { 0.0 }, some);
        assert!(half.p_value > 0.01 && (half.missing - 0.5).abs() < 0.02, "{half:?}");
    }

    /// P-values of a correct sampler are uniform: about a tenth of them lie below 0.1.
    #[test]
    fn false_alarms_are_as_rare_as_promised() {
        let options = ChiSquareOptions { samples: 2_000, rows: 6, columns: 5, ..ChiSquareOptions::default() };
        let test = |seed| {
            let mut random = Random::new(seed);
            chi_square_on_square(&options, |p| 2.0 * p.x, || ramp(&mut random)).p_value
        };
        let low = (0..400).filter(|seed| test(*seed) < 0.1).count();
        // The normalisation cannot fail here, so that the combined p-value is twice as large and below 0.1 for
        // 5 % of the seeds.
        assert!((5..40).contains(&low), "{low}");
    }

    #[test]
    fn narrow_lobes_are_integrated() {
        let f = |p: DVec2| {
            let d = (p - DVec2::new(0.317, 0.764)).length_squared();
            crate::math::elementary::exp(-d / 2e-4) / (2e-4 * std::f64::consts::PI)
        };
        let total: f64 = (0..100)
            .map(|i| {
                let at = DVec2::new(f64::from(i / 10), f64::from(i % 10)) * 0.1;
                integrate(&f, at, DVec2::splat(0.1), 1e-4, 0)
            })
            .sum();
        assert!((total - 1.0).abs() < 1e-4, "{total}");
    }
}

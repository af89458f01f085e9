//! Tails of probability distributions: the probability of a value at least as extreme by chance alone.
//!
//! The relative error is about 1e-10 for the arguments that tests use. All tails are expressed by the
//! incomplete gamma and beta functions (Press et al., "Numerical Recipes", chapter 6; Lanczos 1964 for ln Γ).

use crate::math::elementary::{exp, ln};

/// Most terms of series and continued fractions; a few hundred are enough up to 10⁵ degrees of freedom.
const STEPS: u32 = 20_000;
const TINY: f64 = 1e-300;

/// ln Γ(x) for x > 0.
pub fn ln_gamma(x: f64) -> f64 {
    const G: f64 = 7.0;
    const C: [f64; 9] = [
        0.999_999_999_999_809_9,
        676.520_368_121_885_1,
        -1_259.139_216_722_402_8,
        771.323_428_777_653_1,
        -176.615_029_162_140_6,
        12.507_343_278_686_905,
        -0.138_571_095_265_720_12,
        9.984_369_578_019_572e-6,
        1.505_632_735_149_311_6e-7,
    ];
    let x = x - 1.0;
    let sum = C[0] + (1..9).map(|i| C[i] / (x + i as f64)).sum::<f64>();
    let t = x + G + 0.5;
    0.5 * ln(std::f64::consts::TAU) + (x + 0.5) * ln(t) - t + ln(sum)
}

/// Q(a, x): the upper regularised incomplete gamma function, for a > 0 and x ≥ 0.
pub fn gamma_tail(a: f64, x: f64) -> f64 {
    if x.is_nan() || a.is_nan() {
        return f64::NAN;
    }
    if x <= 0.0 {
        return 1.0;
    }
    if x.is_infinite() {
        return 0.0;
    }
    let front = exp(a * ln(x) - x - ln_gamma(a));
    if x < a + 1.0 {
        // The series of the lower incomplete gamma function.
        let (mut term, mut sum) = (1.0 / a, 1.0 / a);
        for n in 1..STEPS {
            term *= x / (a + f64::from(n));
            sum += term;
            if term < sum * 1e-16 {
                break;
            }
        }
        return (1.0 - front * sum).clamp(0.0, 1.0);
    }
    // The continued fraction, by Lentz's method.
    let mut b = x + 1.0 - a;
    let mut c = 1.0 / TINY;
    let mut d = 1.0 / b;
    let mut h = d;
    for n in 1..STEPS {
        let an = -f64::from(n) * (f64::from(n) - a);
        b += 2.0;
        d = 1.0 / nonzero(an * d + b);
        c = nonzero(b + an / c);
        h *= d * c;
        if (d * c - 1.0).abs() < 1e-15 {
            break;
        }
    }
    (front * h).clamp(0.0, 1.0)
}

fn nonzero(v: f64) -> f64 {
    if v.abs() < TINY { TINY } else { v }
}

/// I_x(a, b): the regularised incomplete beta function, for a, b > 0 and 0 ≤ x ≤ 1.
pub fn beta_share(a: f64, b: f64, x: f64) -> f64 {
    if x.is_nan() || a.is_nan() || b.is_nan() {
        return f64::NAN;
    }
    if x <= 0.0 || x >= 1.0 {
        return x.clamp(0.0, 1.0);
    }
    let front = exp(ln_gamma(a + b) - ln_gamma(a) - ln_gamma(b) + a * ln(x) + b * ln(1.0 - x));
    if x < (a + 1.0) / (a + b + 2.0) {
        (front * beta_fraction(a, b, x) / a).clamp(0.0, 1.0)
    } else {
        (1.0 - front * beta_fraction(b, a, 1.0 - x) / b).clamp(0.0, 1.0)
    }
}

fn beta_fraction(a: f64, b: f64, x: f64) -> f64 {
    let mut c = 1.0;
    let mut d = 1.0 / nonzero(1.0 - (a + b) * x / (a + 1.0));
    let mut h = d;
    for n in 1..STEPS {
        let m = f64::from(n);
        for term in [
            m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m)),
            -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0)),
        ] {
            d = 1.0 / nonzero(1.0 + term * d);
            c = nonzero(1.0 + term / c);
            h *= d * c;
        }
        if (d * c - 1.0).abs() < 1e-15 {
            break;
        }
    }
    h
}

/// The probability that χ² with `freedom` degrees of freedom is at least `x`.
pub fn chi_square_tail(x: f64, freedom: f64) -> f64 {
    gamma_tail(0.5 * freedom, 0.5 * x)
}

/// The probability that a normal variable is at least `z` standard deviations from its mean, on either side.
pub fn normal_tails(z: f64) -> f64 {
    gamma_tail(0.5, 0.5 * z * z)
}

/// The same for Student's t with `freedom` degrees of freedom; with infinitely many it is the normal distribution.
pub fn student_tails(t: f64, freedom: f64) -> f64 {
    if freedom > 1e9 {
        return normal_tails(t);
    }
    beta_share(0.5 * freedom, 0.5, freedom / (freedom + t * t))
}

/// The probability of at least `k` successes in `n` trials of probability `p` each.
pub fn binomial_tail(k: u64, n: u64, p: f64) -> f64 {
    match k {
        0 => 1.0,
        k if k > n => 0.0,
        k => beta_share(k as f64, (n - k + 1) as f64, p),
    }
}

/// The level for each of `tests` independent tests at which any of them fails with probability `alpha` (Šidák 1967).
pub fn sidak_level(alpha: f64, tests: usize) -> f64 {
    1.0 - exp(ln(1.0 - alpha) / tests.max(1) as f64)
}

/// The p-value of the smallest of `tests` independent p-values.
pub fn smallest_of(p: f64, tests: usize) -> f64 {
    // 1 − (1 − p)ⁿ, without losing the digits of small p.
    if p < 1e-9 {
        return (p * tests as f64).min(1.0);
    }
    if p >= 1.0 { 1.0 } else { 1.0 - exp(ln(1.0 - p) * tests as f64) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn close(a: f64, b: f64) {
        assert!((a - b).abs() <= 1e-9 * b.abs() + 1e-14, "{a} and {b}");
    }

    #[test]
    fn values_of_tables() {
        close(ln_gamma(1.0), 0.0);
        close(ln_gamma(0.5), 0.572_364_942_924_700_1);
        close(ln_gamma(10.0), 12.801_827_480_081_469);
        // Exact for two degrees of freedom.
        for x in [0.1, 1.0, 5.0, 40.0, 600.0] {
            close(chi_square_tail(x, 2.0), exp(-0.5 * x));
        }
        // Quantiles of published tables, given with ten digits.
        assert!((chi_square_tail(124.342_113_4, 100.0) - 0.05).abs() < 1e-8);
        assert!((chi_square_tail(23.209_251_16, 10.0) - 0.01).abs() < 1e-8);
        assert!((chi_square_tail(1_106.969_1, 1000.0) - 0.01).abs() < 1e-4);
        assert!((normal_tails(1.959_963_985) - 0.05).abs() < 1e-9);
        assert!((student_tails(2.228_138_852, 10.0) - 0.05).abs() < 1e-9);
        // Cauchy's distribution in closed form.
        close(student_tails(1.0, 1.0), 0.5);
        close(student_tails(3.0, 1e12), normal_tails(3.0));
        close(binomial_tail(1, 10, 0.1), 1.0 - 0.348_678_440_1);
        close(binomial_tail(10, 10, 0.5), 1.0 / 1024.0);
        assert_eq!((binomial_tail(0, 3, 0.1), binomial_tail(4, 3, 0.9)), (1.0, 0.0));
    }

    #[test]
    fn both_ways_to_compute_agree_where_they_meet() {
        for a in [0.5, 3.0, 50.0, 5_000.0] {
            close(gamma_tail(a, (a + 1.0) * (1.0 - 1e-13)), gamma_tail(a, a + 1.0));
        }
        for (a, b, x) in [(2.0, 3.0, 0.3), (0.5, 0.5, 0.7), (200.0, 30.0, 0.9)] {
            close(beta_share(a, b, x), 1.0 - beta_share(b, a, 1.0 - x));
        }
    }

    #[test]
    fn many_tests_together() {
        close(sidak_level(0.01, 1), 0.01);
        close(smallest_of(sidak_level(0.01, 37), 37), 0.01);
        close(smallest_of(1e-12, 1000), 1e-9);
    }
}

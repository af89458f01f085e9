//! Values, derivatives and intervals of expressions.

use super::*;
use crate::testing::Random;

fn at(text: &str, p: [f64; 3]) -> f64 {
    Expression::parse(text).unwrap().evaluate(p)
}

#[test]
fn values_follow_the_usual_rules() {
    let p = [2.0, -3.0, 0.5];
    for (text, expected) in [
        ("1 + 2 * 3", 7.0),
        ("(1 + 2) * 3", 9.0),
        ("10 - 3 - 2", 5.0),
        ("-x^2", -4.0),
        ("2 * -y", 6.0),
        ("x^-2", 0.25),
        ("y^3", -27.0),
        ("z^0.5", 0.5f64.sqrt()),
        ("(x*z)^-0.5 + 1.5e1", 16.0),
        ("min(x, y, z) + max(x, y, z)", -1.0),
        ("length(x, y, 6)", 7.0),
        ("abs(y) + sqrt(x + 2) + exp(0) + ln(1)", 6.0),
        ("sin(pi / 2) + cos(0)", 2.0),
    ] {
        assert!((at(text, p) - expected).abs() < 1e-14, "{text} = {}", at(text, p));
    }
}

#[test]
fn faults_name_position_and_remedy() {
    let fault = |text: &str| Expression::parse(text).unwrap_err();
    assert!(fault("x +").message.contains("at character 4 of the expression, found the end"));
    assert!(fault("x y").message.contains("expected an operator or the end at character 3"));
    assert!(fault("(x").message.contains("expected `)`"));
    assert!(fault("x^y").message.contains("a number as exponent"));
    assert_eq!(fault("sine(x)").help.as_deref(), Some("write `sin`"));
    assert!(fault("min(x)").message.contains("another argument"));
    assert!(fault(&"(".repeat(1000)).message.contains("deeper than 64"));
    assert!(fault(&"x+(".repeat(30)).message.contains("expected"));
    assert!(fault(&("x+(".repeat(30) + "x" + &")".repeat(30))).message.contains("intermediate values"));
    assert!(fault(&("x".to_owned() + &"+x".repeat(3000))).message.contains("more than 1024"));
    for text in ["", "1e999", ".", "é", "x\u{0}", "𝔁", "1..2"] {
        fault(text);
    }
}

const TEXTS: [&str; 8] = [
    "x*x + y*y - z",
    "sin(3*x) * cos(2*y) + z",
    "max(abs(x) - 1, min(y, z), -x*y)",
    "length(x, y, z)^3 - exp(x) / (2 + z^2)",
    "sqrt(abs(x*y*z)) - ln(4 + x)",
    "(x^2 + 1)^1.7 - y^5",
    "x^-3 + cos(z)",
    "x / (y - z)",
];

#[test]
fn derivatives_agree_with_differences() {
    let mut random = Random::new(6);
    for text in TEXTS {
        let e = Expression::parse(text).unwrap();
        for _ in 0..300 {
            let (p, d) = (random.in_cube(), random.direction());
            let along = |s: f64| e.evaluate((p + s * d).to_array());
            let dual = |k: usize| Dual { value: p[k], slope: d[k] };
            let found = e.evaluate([dual(0), dual(1), dual(2)]);
            assert_eq!(found.value, along(0.0));
            let h = 1e-6;
            let difference = (along(h) - along(-h)) / (2.0 * h);
            let near = (found.slope - difference).abs() < 1e-4 * (1.0 + difference.abs());
            // Kinks and poles have no derivative.
            let kink = (along(h) + along(-h) - 2.0 * along(0.0)).abs() > 1e-9;
            assert!(near || kink, "{text} at {p}: {} {difference}", found.slope);
        }
    }
}

#[test]
fn intervals_contain_all_values() {
    let mut random = Random::new(7);
    for text in TEXTS {
        let e = Expression::parse(text).unwrap();
        for _ in 0..400 {
            let (center, size) = (2.0 * random.in_cube(), random.unit());
            let box_of = |k: usize| Interval::new(center[k] - size, center[k] + size);
            let range = e.evaluate([box_of(0), box_of(1), box_of(2)]);
            for _ in 0..20 {
                let p = center + size * random.in_cube();
                let v = e.evaluate(p.to_array());
                assert!(
                    v.is_nan() || (v >= range.low && v <= range.high),
                    "{text} at {p}: {v} not in {range:?}"
                );
            }
        }
    }
}

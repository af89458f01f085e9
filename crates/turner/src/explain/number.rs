//! Numbers for people. Front ends that write explanations share them.

use crate::color::Spectrum;
use crate::math::DVec3;

/// `count` significant digits, without trailing zeros.
fn digits(v: f64, count: usize) -> String {
    // Turns -0 into 0.
    let v = v + 0.0;
    let scientific = format!("{v:.*e}", count.saturating_sub(1));
    let exponent = scientific.split_once('e').and_then(|(_, e)| e.parse::<i32>().ok()).unwrap_or(0);
    if !v.is_finite() || !(-4..7).contains(&exponent) {
        return if v.is_infinite() { "∞".to_owned() } else { scientific };
    }
    let text = format!("{v:.*}", (count as i32 - 1 - exponent).max(0) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Five significant digits.
pub fn number(v: f64) -> String {
    digits(v, 5)
}

/// Three significant digits.
pub fn short(v: f64) -> String {
    digits(v, 3)
}

/// `(x, y, z)`
pub fn vector(v: DVec3) -> String {
    let [x, y, z] = v.to_array().map(number);
    format!("({x}, {y}, {z})")
}

/// `[r, g, b]`, or one number for a grey.
pub fn color(s: Spectrum) -> String {
    let [r, g, b] = s.to_array().map(|v| number(f64::from(v)));
    if r == g && g == b { r } else { format!("[{r}, {g}, {b}]") }
}

/// `[r, g, b]` with three significant digits.
pub fn short_color(s: Spectrum) -> String {
    let [r, g, b] = s.to_array().map(|v| short(f64::from(v)));
    if r == g && g == b { r } else { format!("[{r}, {g}, {b}]") }
}

/// A fraction as `12 %`, `0.3 %`, `≈ 0 %`.
pub fn percent(fraction: f64) -> String {
    match fraction * 100.0 {
        p if p >= 9.95 => format!("{p:.0} %"),
        p if p >= 0.01 => format!("{} %", digits(p, 2)),
        p if p > 0.0 => "≈ 0 %".to_owned(),
        _ => "0 %".to_owned(),
    }
}

/// The shortest decimals that give the same f32 values.
pub fn exact(s: Spectrum) -> String {
    format!("[{}, {}, {}]", s.r, s.g, s.b)
}

/// `1,532`
pub fn thousands(n: u64) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(c);
    }
    out
}

/// `1 ray`, `1,532 rays`.
pub fn rays(n: u64) -> String {
    if n == 1 { "1 ray".to_owned() } else { format!("{} rays", thousands(n)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_five_significant_digits() {
        for (v, text) in [
            (0.5, "0.5"),
            (-0.0, "0"),
            (1.0 / 3.0, "0.33333"),
            (123_456.0, "123456"),
            (1e9, "1.0000e9"),
            (0.000_012_345, "1.2345e-5"),
            (f64::INFINITY, "∞"),
        ] {
            assert_eq!(number(v), text);
        }
        assert_eq!(
            (thousands(999), thousands(1532), thousands(1_234_567)),
            ("999".into(), "1,532".into(), "1,234,567".into())
        );
        assert_eq!(color(Spectrum::new(0.5, 0.5, 0.5)), "0.5");
    }
}

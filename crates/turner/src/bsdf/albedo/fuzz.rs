//! Directional albedo of fuzz, tabulated over √µ and the roughness.

use super::fuzz_table::TABLE;
use super::{locate, spline};
use crate::bsdf::fuzz::MIN_ROUGHNESS;

/// Nodes in √µ.
pub(super) const ANGLES: usize = 22;
/// Roughnesses, evenly spaced from the minimum.
pub(super) const WIDTHS: usize = 28;
/// Values at the angles in units of 1/32767, then their cosine-weighted mean.
pub(super) type Row = [i16; ANGLES + 1];

/// Directional albedo of fuzz of one roughness.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct FuzzAlbedo {
    rows: [&'static Row; 2],
    f: f64,
}

impl FuzzAlbedo {
    /// `roughness` is within 0..=1.
    pub(in crate::bsdf) fn new(roughness: f64) -> FuzzAlbedo {
        let (k, f) =
            locate((roughness - MIN_ROUGHNESS) / (1.0 - MIN_ROUGHNESS) * (WIDTHS - 1) as f64, WIDTHS);
        FuzzAlbedo { rows: [&TABLE[k], &TABLE[k + 1]], f }
    }

    /// Fraction of light from the cosine µ that is reflected.
    pub(in crate::bsdf) fn at(&self, mu: f64) -> f64 {
        let (k, [a, b, c, d]) = spline(mu.clamp(0.0, 1.0).sqrt() * (ANGLES - 1) as f64, ANGLES);
        let of = |row: &Row| {
            let at = |k: usize| f64::from(row[k]);
            a * at(k.max(1) - 1) + b * at(k) + c * at(k + 1) + d * at((k + 2).min(ANGLES - 1))
        };
        ((1.0 - self.f) * of(self.rows[0]) + self.f * of(self.rows[1])) * (1.0 / 32767.0)
    }
}

#[cfg(test)]
mod tests {
    //! Writes the table: `TURNER_UPDATE=1 cargo test --release -p turner fuzz_table`. Otherwise recomputes some of its
    //! values.

    use super::*;
    use crate::bsdf::fuzz::Charlie;
    use crate::math::DVec3;
    use std::fmt::Write;

    fn fuzz_at(roughness: f64, mu: f64, n: u32) -> f64 {
        let charlie = Charlie::new(roughness);
        let mu = mu.max(1e-4);
        let wo = DVec3::new((1.0 - mu * mu).sqrt(), 0.0, mu);
        let mut sum = 0.0;
        for i in 0..n {
            for j in 0..n {
                let u = [(f64::from(i) + 0.5) / f64::from(n), (f64::from(j) + 0.5) / f64::from(n)];
                let wi = Charlie::sample([u[0] * u[0], u[1]]);
                sum += charlie.eval(wo, wi) * wi.z * 2.0 * u[0];
            }
        }
        sum / f64::from(n * n) / Charlie::PDF
    }

    fn row(roughness: f64) -> Row {
        let mut row = [0; ANGLES + 1];
        for (k, slot) in row.iter_mut().take(ANGLES).enumerate() {
            let root = k as f64 / (ANGLES - 1) as f64;
            *slot = (fuzz_at(roughness, root * root, 256) * 32767.0).round() as i16;
        }
        let curve = FuzzAlbedo { rows: [Box::leak(Box::new(row)); 2], f: 0.0 };
        let n = 30_000;
        let nodes = (0..n).map(|i| (f64::from(i) + 0.5) / f64::from(n));
        // Evenly in √µ, which resolves narrow features at grazing angles.
        let mean: f64 = nodes.map(|s| curve.at(s * s) * 4.0 * s * s * s).sum::<f64>() / f64::from(n);
        row[ANGLES] = (mean * 32767.0).round() as i16;
        row
    }

    #[test]
    fn fuzz_table_holds_the_albedo() {
        if std::env::var_os("TURNER_UPDATE").is_some() {
            let mut out = String::from(
                "//! Directional albedo of fuzz, written by the test in [`fuzz`](super::fuzz).\n#![cfg_attr(rustfmt, rustfmt_skip)]\n\nuse super::fuzz::{Row, WIDTHS};\n\n/// Directional albedo of fuzz, by roughness.\npub(super) static TABLE: [Row; WIDTHS] = [\n",
            );
            for k in 0..WIDTHS {
                let roughness = MIN_ROUGHNESS + (1.0 - MIN_ROUGHNESS) * k as f64 / (WIDTHS - 1) as f64;
                let numbers: Vec<String> = row(roughness).iter().map(i16::to_string).collect();
                writeln!(out, "    [{}],", numbers.join(", ")).unwrap();
            }
            let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/bsdf/albedo/fuzz_table.rs");
            std::fs::write(path, out + "];\n").unwrap();
            return;
        }
        for (r, m) in [(0.3, 0.5), (0.5, 0.1), (0.7, 0.9), (1.0, 0.02)] {
            let (found, fresh) = (FuzzAlbedo::new(r).at(m), fuzz_at(r, m, 256));
            assert!((found - fresh).abs() < 1e-3, "fuzz {r} {m}: {found} and {fresh}");
        }
    }
}

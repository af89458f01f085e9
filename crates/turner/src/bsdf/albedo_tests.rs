//! Makes the tables: `TURNER_UPDATE=1 cargo test --release -p turner albedo_tables`. Without it, some of their numbers are computed
//! again.

use super::*;
use crate::bsdf::fresnel;
use crate::bsdf::fuzz::{Charlie, MIN_ROUGHNESS};
use crate::bsdf::microfacet::Ggx;
use crate::math::{DVec3, reflect};
use std::fmt::Write;

/// The k-th of a sequence of well spread points in the unit square (Kronecker, by powers of the generalised golden ratio).
fn spread(k: u32) -> [f64; 2] {
    let g = 1.324_717_957_244_746;
    [1.0 / g, 1.0 / (g * g)].map(|a: f64| (0.5 + f64::from(k) * a).fract())
}

/// Reflected and transmitted share of light from µ, by `n` visible normals.
fn rough(mu: f64, alpha: f64, reflectance: impl Fn(f64) -> f64, eta: f64, n: u32) -> (f64, f64) {
    let mu = mu.max(1e-6);
    let alpha = alpha.max(MIN_ALPHA);
    let ggx = Ggx { ax: alpha, ay: alpha };
    let wo = DVec3::new((1.0 - mu * mu).sqrt(), 0.0, mu);
    let (mut r, mut t) = (0.0, 0.0);
    for k in 0..n {
        let h = ggx.sample_visible(wo, spread(k));
        let f = reflectance(wo.dot(h).clamp(0.0, 1.0));
        let wi = reflect(-wo, h);
        if wi.z > 0.0 {
            r += f * ggx.g2(wo, wi) / ggx.g1(wo);
        }
        if let Some(wi) = crate::math::refract(-wo, h, 1.0 / eta)
            && wi.z < 0.0
        {
            t += (1.0 - f) * ggx.g1(wi);
        }
    }
    (r / f64::from(n), t / f64::from(n))
}

/// The k-th angle.
fn mu(k: usize, alpha: Option<f64>) -> f64 {
    let t = k as f64 / (ANGLES - 1) as f64;
    match alpha {
        None => t * t,
        // The root of µ² + (1 + 2α − 2t) µ = 2 t α.
        Some(a) => {
            let half = 0.5 + a - t;
            (2.0 * t * a / (half + (half * half + 2.0 * t * a).sqrt())).min(1.0)
        }
    }
}

fn index(s: f64) -> f64 {
    let s = s.max(1e-3);
    (1.0 + s) / (1.0 - s).max(1e-9)
}

fn dielectric_at(s: f64, inside: bool, alpha: f64, mu: f64, n: u32) -> (f64, f64) {
    let eta = index(s);
    let eta = if inside { 1.0 / eta } else { eta };
    rough(mu, alpha, |c| if s == 1.0 { 1.0 } else { fresnel::dielectric(c, eta) }, eta, n)
}

fn shift_at(s: f64, alpha: f64, mu: f64, n: u32) -> f64 {
    let smooth = if s == 1.0 { 1.0 } else { fresnel::dielectric(mu.max(1e-6), index(s)) };
    dielectric_at(s, false, alpha, mu, n).0 - smooth
}

fn loss_at(s: f64, inside: bool, alpha: f64, mu: f64, n: u32) -> f64 {
    let (r, t) = dielectric_at(s, inside, alpha, mu, n);
    1.0 - r - t
}

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

/// A row from a function of µ: its values, and the mean of what is interpolated between them.
fn row(alpha: Option<f64>, f: impl Fn(f64) -> f64) -> Row {
    let mut row = [0; ANGLES + 1];
    for (k, slot) in row.iter_mut().take(ANGLES).enumerate() {
        *slot = (f(mu(k, alpha)) * 32767.0).round() as i16;
    }
    let line = |row: Row| Line { rows: [Box::leak(Box::new(row)); 4], weights: [1.0, 0.0, 0.0, 0.0], alpha };
    let line = line(row);
    let n = 30_000;
    let nodes = (0..n).map(|i| (f64::from(i) + 0.5) / f64::from(n));
    // Evenly in √µ, for what is narrow at grazing angles.
    let mean: f64 = nodes.map(|s| line.at(s * s) * 4.0 * s * s * s).sum::<f64>() / f64::from(n);
    row[ANGLES] = (mean * 32767.0).round() as i16;
    row
}

fn alpha(k: usize) -> f64 {
    let r = k as f64 / (WIDTHS - 1) as f64;
    (r * r).max(MIN_ALPHA)
}

fn roughness(k: usize) -> f64 {
    MIN_ROUGHNESS + (1.0 - MIN_ROUGHNESS) * k as f64 / (WIDTHS - 1) as f64
}

fn write_rows(out: &mut String, rows: &[Row], indent: &str) {
    for row in rows {
        let numbers: Vec<String> = row.iter().map(i16::to_string).collect();
        writeln!(out, "{indent}[{}],", numbers.join(", ")).unwrap();
    }
}

fn source() -> String {
    const N: u32 = 16_384;
    let mut out = String::from(
        "//! Numbers of [`albedo`](super::albedo), written by its test.\n#![cfg_attr(rustfmt, rustfmt_skip)]\n\nuse super::albedo::{CONTRASTS, Row, WIDTHS};\n",
    );
    let widths = |f: &dyn Fn(f64, f64) -> f64| -> Vec<Row> {
        (0..WIDTHS).map(|k| row(Some(alpha(k)), |m| f(alpha(k), m))).collect()
    };
    out += "\n/// Loss of a rough perfect mirror, by width.\npub(super) static GGX_LOSS: [Row; WIDTHS] = [\n";
    write_rows(&mut out, &widths(&|a, m| 1.0 - rough(m, a, |_| 1.0, 1.5, N).0), "    ");
    out += "];\n\n/// Albedo of fuzz, by roughness.\npub(super) static FUZZ: [Row; WIDTHS] = [\n";
    let fuzz: Vec<Row> = (0..WIDTHS).map(|k| row(None, |m| fuzz_at(roughness(k), m, 256))).collect();
    write_rows(&mut out, &fuzz, "    ");
    out += "];\n\n/// Reflectance of a rough dielectric less that of a smooth one, by contrast and width.\n";
    out += "pub(super) static REFLECT_SHIFT: [[Row; WIDTHS]; CONTRASTS.len()] = [\n";
    for s in CONTRASTS {
        out += "    [\n";
        write_rows(&mut out, &widths(&|a, m| shift_at(s, a, m, N)), "        ");
        out += "    ],\n";
    }
    out += "];\n\n/// Loss of a rough dielectric seen from the thinner and from the denser side, by contrast and width.\n";
    out += "pub(super) static DIELECTRIC_LOSS: [[[Row; WIDTHS]; CONTRASTS.len()]; 2] = [\n";
    for inside in [false, true] {
        out += "    [\n";
        for s in CONTRASTS {
            out += "        [\n";
            write_rows(&mut out, &widths(&|a, m| loss_at(s, inside, a, m, N)), "            ");
            out += "        ],\n";
        }
        out += "    ],\n";
    }
    out + "];\n"
}

#[test]
fn albedo_tables_hold_what_lobes_reflect() {
    if std::env::var_os("TURNER_UPDATE").is_some() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/bsdf/albedo_table.rs");
        std::fs::write(path, source()).unwrap();
        return;
    }
    for (a, m) in [(0.01, 0.3), (0.09, 0.05), (0.25, 0.6), (0.6, 0.2), (1.0, 1.0)] {
        let found = mirror_loss(a).at(m);
        let fresh = 1.0 - rough(m, a, |_| 1.0, 1.5, 20_000).0;
        assert!((found - fresh).abs() < 1e-3, "mirror {a} {m}: {found} and {fresh}");
        for s in [0.13, 0.2, 0.35, 0.45] {
            let (found, fresh) = (reflect_shift(index(s), a).at(m), shift_at(s, a, m, 20_000));
            assert!((found - fresh).abs() < 4e-3, "shift {s} {a} {m}: {found} and {fresh}");
            for inside in [false, true] {
                let eta = if inside { 1.0 / index(s) } else { index(s) };
                let (found, fresh) = (dielectric_loss(eta, a).at(m), loss_at(s, inside, a, m, 20_000));
                assert!((found - fresh).abs() < 2e-3, "loss {s} {inside} {a} {m}: {found} and {fresh}");
            }
        }
    }
    for (r, m) in [(0.2, 0.5), (0.5, 0.1), (0.7, 0.9), (1.0, 0.02)] {
        let (found, fresh) = (fuzz(r).at(m), fuzz_at(r, m, 256));
        assert!((found - fresh).abs() < 2e-3, "fuzz {r} {m}: {found} and {fresh}");
    }
}

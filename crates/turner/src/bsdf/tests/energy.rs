//! Energy: nothing is created, and what absorbs nothing loses nothing.

use super::materials::materials;
use crate::bsdf::Bsdf;
use crate::math::DVec3;

/// The k-th of a sequence of well spread points in the unit cube (Kronecker, by the powers of the generalised golden ratio).
pub(super) fn spread(k: u32) -> [f64; 3] {
    let g = 1.220_744_084_605_759_5;
    [1.0 / g, 1.0 / (g * g), 1.0 / (g * g * g)].map(|a: f64| (0.5 + f64::from(k) * a).fract())
}

pub(super) fn direction(mu: f64, phi: f64) -> DVec3 {
    let r = (1.0 - mu * mu).sqrt();
    let (s, c) = crate::math::elementary::sin_cos(phi);
    DVec3::new(r * c, r * s, mu)
}

/// Share of light towards `wo` that comes from all around: of power, so without the scale of radiance in a denser medium.
fn albedo(bsdf: &Bsdf, wo: DVec3, n: u32) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for k in 0..n {
        if let Some(s) = bsdf.sample(wo, spread(k)) {
            let weight = s.wi.z.abs() / s.pdf * s.eta * s.eta;
            for (sum, f) in sum.iter_mut().zip(s.f.to_array()) {
                *sum += f64::from(f) * weight;
            }
        }
    }
    sum.map(|v| v / f64::from(n))
}

#[test]
fn energy_is_kept() {
    let mut bad = String::new();
    for (name, point) in materials() {
        let bsdf = Bsdf::new(&point);
        for mu in [1.0, 0.8, 0.5, 0.25, 0.1, 0.03] {
            let a = albedo(&bsdf, direction(mu, 0.9), 30_000);
            let (low, high) = (a[0].min(a[1]).min(a[2]), a[0].max(a[1]).max(a[2]));
            println!("{name} µ {mu}: {low:.5} {high:.5}");
            if high > 1.0 + 1e-3 || (name.starts_with("white") && low < 1.0 - 1e-2) {
                bad += &format!("{name}, µ {mu}: {low:.5} to {high:.5}\n");
            }
        }
    }
    assert!(bad.is_empty(), "\n{bad}");
}

//! Densities: samples follow them, they integrate to the probability of a sample, and samples agree with `eval` and
//! `pdf`.

use crate::bsdf::Bsdf;
use crate::testing::{
    ChiSquareOptions, direction, materials, samples_agree_with_eval, samples_follow_density, sidak_level,
};

#[test]
fn samples_follow_the_density() {
    let cosines = [0.95, 0.5, 0.1];
    let list: Vec<_> = materials().into_iter().filter(|(_, p)| Bsdf::new(p).has_smooth()).collect();
    let level = sidak_level(0.01, list.len() * cosines.len());
    let mut bad = String::new();
    for (name, point) in &list {
        for (n, mu) in cosines.into_iter().enumerate() {
            let wo = direction(mu, 0.7 + n as f64);
            let test =
                samples_follow_density(&Bsdf::new(point), wo, 7 + n as u64, &ChiSquareOptions::default());
            if test.p_value < level {
                bad += &format!("{name}, µ {mu}: {test:?}\n");
            }
        }
    }
    assert!(bad.is_empty(), "\n{bad}");
}

#[test]
fn samples_have_the_values_that_eval_gives() {
    for (name, point) in materials() {
        for mu in [1.0, 0.6, 0.2, 0.01] {
            if let Err(wrong) = samples_agree_with_eval(&Bsdf::new(&point), direction(mu, 2.0), 500) {
                panic!("{name}, µ {mu}: {wrong}");
            }
        }
    }
}

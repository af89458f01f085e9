//! Tests BSDFs of the suite's materials: sampling density, energy conservation and reciprocity.

use turner::bsdf::{Bsdf, PrincipledPoint};
use turner::schema::SceneError;
use turner::testing::{
    Random, albedo, direction, materials, reciprocity_error, samples_agree_with_eval, samples_follow_density,
};
use turner_cli::verify::check::{Check, Context, Finding, fault};
use turner_cli::verify::densities::{finding, options};

pub(super) fn checks() -> Vec<Check> {
    let mut out = Vec::new();
    for (name, point) in materials() {
        let bsdf = Bsdf::new(&point);
        let id = name.replace(", ", " ").replace(' ', "-");
        if bsdf.has_smooth() {
            let seed = format!("density/{id}");
            out.push(Check::chance(format!("density/{id}"), move |cx| Ok(density(cx, &seed, &bsdf))));
        }
        out.push(Check::limit(format!("surface/{id}"), move |cx| surface(cx, name, &point)));
    }
    out
}

fn density(cx: &Context, seed: &str, bsdf: &Bsdf<'_>) -> Finding {
    let mut random = Random::new(cx.seed_for(seed));
    let tests = [0.95, 0.5, 0.1].map(|mu| {
        let [phi] = random.units::<1>();
        samples_follow_density(bsdf, direction(mu, 6.2 * phi), random.bits(), &options(cx))
    });
    finding(&tests)
}

/// The most energy that a surface may gain in a white furnace.
const FURNACE: f64 = 1e-3;
/// The most energy that a white surface may lose.
const LOSS: f64 = 2e-3;

fn surface(cx: &Context, name: &str, point: &PrincipledPoint) -> Result<Finding, SceneError> {
    let bsdf = Bsdf::new(point);
    for mu in [1.0, 0.6, 0.2, 0.01] {
        samples_agree_with_eval(&bsdf, direction(mu, 2.0), cx.times(500)).map_err(fault)?;
    }
    let back = Bsdf::new(&PrincipledPoint {
        entering: !point.entering,
        anisotropy_rotation: -point.anisotropy_rotation,
        ..*point
    });
    let eta = match (point.thin_walled, point.entering) {
        (true, _) => 1.0,
        (false, true) => point.specular_ior,
        (false, false) => 1.0 / point.specular_ior,
    };
    let reciprocity = reciprocity_error(&bsdf, None, cx.times(500)).max(reciprocity_error(
        &bsdf,
        Some((&back, eta)),
        cx.times(500),
    ));
    let (mut gained, mut lost): (f64, f64) = (0.0, 0.0);
    for mu in [1.0, 0.8, 0.5, 0.25, 0.1, 0.03] {
        let a = albedo(&bsdf, direction(mu, 0.9), cx.times(30_000));
        gained = gained.max(a[0].max(a[1]).max(a[2]) - 1.0);
        lost = lost.max(1.0 - a[0].min(a[1]).min(a[2]));
    }
    let white = name.starts_with("white") || name.contains(" white");
    let mut found = format!("furnace: gain at most {:+.5}", gained);
    let mut used = (gained / FURNACE).max(reciprocity / 2e-5);
    if white && name.starts_with("white") {
        found += &format!(", at least {:+.5}", -lost);
        used = used.max(lost / LOSS);
    }
    Ok(Finding::limit(used, 1.0, format!("{found}, reciprocity error {reciprocity:.0e}")))
}

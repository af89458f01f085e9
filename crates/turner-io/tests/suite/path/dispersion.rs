//! Glass that bends colours differently.

use crate::path::statistics::mean;

/// Indices of the three bands for n_d = 1.5 and an Abbe number of 10: Cauchy's formula at 611.4, 549.1 and 464.3 nm.
fn indices() -> [f64; 3] {
    let inverse2 = |l: f64| 1.0 / (l * l);
    let b = 0.5 / (10.0 * (inverse2(0.48613) - inverse2(0.65627)));
    [0.6114, 0.5491, 0.4643].map(|l| 1.5 + b * (inverse2(l) - inverse2(0.58756)))
}

const GLASS: &str = "material = { type = \"principled\", transmission_weight = 1, specular_roughness = 0, transmission_dispersion_scale = 2 }";

#[test]
fn each_band_is_shifted_by_its_own_index() {
    // A slab turned by 50 degrees shifts what is behind it; behind it is a slope of light. All ways in and out by refraction alone count.
    let (angle, thickness): (f64, f64) = (50f64.to_radians(), 2.0);
    let text = format!(
        "integrator = {{ type = \"path\", max_depth = 2 }}\n\
         camera = {{ position = [0, 0, 10], look_at = [0, 0, 0], fov = 0.001 }}\n\
         object = [{{ type = \"box\", min = [-9, -9, -1], max = [9, 9, 1], transform = {{ rotate = [0, 50, 0] }}, {GLASS} }},\n\
         {{ type = \"rectangle\", center = [0, 0, -20], edge_u = [8, 0, 0], edge_v = [0, 8, 0], material = {{ type = \"emissive\", \
         color = {{ type = \"gradient\", axis = \"x\" }} }} }}]"
    );
    let expected = indices().map(|n| {
        let inner = (angle.sin() / n).asin();
        let shift = thickness * (angle - inner).sin() / inner.cos();
        let (ci, ct) = (angle.cos(), inner.cos());
        let s = (ci - n * ct) / (ci + n * ct);
        let p = (n * ci - ct) / (n * ci + ct);
        let through = 1.0 - 0.5 * (s * s + p * p);
        // From black at x = −4 to white at x = 4.
        [through * through * (0.5 + shift / 8.0), through * through * (0.5 - shift / 8.0)]
    });
    let seen = mean(1024, &text);
    let side = usize::from(seen.value()[1] < 0.5 * expected[1][0] + 0.5 * expected[1][1]);
    seen.is(expected.map(|e| e[side]), 0.01);
    // The bands differ by far more than that.
    assert!((seen.value()[2] - seen.value()[0]).abs() > 0.01 * seen.value()[0], "{seen:?}");
}

#[test]
fn a_slab_seen_head_on_passes_each_band_by_its_index() {
    let text = format!(
        "integrator = {{ type = \"path\", max_depth = 100 }}\n\
         camera = {{ position = [0, 0, 10], look_at = [0, 0, 0], fov = 0.001 }}\n\
         object = [{{ type = \"box\", min = [-9, -9, -1], max = [9, 9, 1], {GLASS} }},\n\
         {{ type = \"rectangle\", center = [0, 0, -20], edge_u = [8, 0, 0], edge_v = [0, 8, 0], material = {{ type = \"emissive\" }} }}]"
    );
    let expected = indices().map(|n| {
        let r = ((n - 1.0) / (n + 1.0)).powi(2);
        (1.0 - r) / (1.0 + r)
    });
    mean(1024, &text).is(expected, 0.01);
}

#[test]
fn clear_glass_takes_nothing_from_light_all_around() {
    for (roughness, most, least) in [(0.0, 1.0002, 0.9998), (0.4, 1.003, 0.95)] {
        let text = format!(
            "integrator = {{ type = \"path\", max_depth = 1000, rr_start = 1000 }}\nbackground.color = 1\n\
             camera = {{ position = [0, 0, 4], look_at = [0, 0, 0], fov = 20 }}\n\
             object = [{{ type = \"sphere\", {} }}]",
            GLASS.replace("specular_roughness = 0", &format!("specular_roughness = {roughness}"))
        );
        let seen = mean(256, &text);
        for i in 0..3 {
            let slack = 4.0 * seen.error()[i];
            assert!(
                slack < 0.05 && seen.value()[i] > least - slack && seen.value()[i] < most + slack,
                "{seen:?}"
            );
        }
    }
}

#[test]
fn rough_dispersive_glass_is_lit_alike_by_both_ways_of_finding_light() {
    let text = |how: &str| {
        format!(
            "integrator = {{ type = \"path\", max_depth = 4, light_sampling = \"{how}\" }}\n\
             camera = {{ position = [0, 0, 4], look_at = [0, 0, 0], fov = 0.001 }}\n\
             object = [{{ type = \"box\", min = [-9, -9, -1], max = [9, 9, 1], {} }},\n\
             {{ type = \"rectangle\", center = [1, 0, -4], edge_u = [3, 0, 0], edge_v = [0, 3, 0], material = {{ type = \"emissive\" }} }}]",
            GLASS.replace("specular_roughness = 0", "specular_roughness = 0.5")
        )
    };
    mean(512, &text("both")).agrees(&mean(1024, &text("bsdf")), 0.03);
}

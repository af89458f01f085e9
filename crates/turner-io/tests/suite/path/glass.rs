//! Smooth glass: what passes, what is absorbed, solids in one another.

use crate::path::statistics::{Mean, mean};

/// Looks at a wall that shines with 1, through what is between; all else is black.
fn through(objects: &str) -> Mean {
    mean(
        256,
        &format!(
            "integrator = {{ type = \"path\", max_depth = 200 }}\n\
         camera = {{ position = [0, 0, 10], look_at = [0, 0, 0], fov = 0.001 }}\n\
         object = [{objects} {{ type = \"rectangle\", center = [0, 0, -10], edge_u = [9, 0, 0], edge_v = [0, 9, 0], material = {{ type = \"principled\", base_weight = 0, specular_weight = 0, emission_luminance = 1 }} }}]"
        ),
    )
}

fn glass(ior: f64, more: &str) -> String {
    format!(
        "material = {{ type = \"principled\", transmission_weight = 1, specular_roughness = 0, specular_ior = {ior}{more} }}"
    )
}

fn slab(z: [f64; 2], material: &str) -> String {
    format!("{{ type = \"box\", min = [-5, -5, {}], max = [5, 5, {}], {material} }},", z[0], z[1])
}

fn reflectance(a: f64, b: f64) -> f64 {
    ((a - b) / (a + b)).powi(2)
}

/// Of a slab with reflecting faces r and s and the share a left after one way through it, all ways between them counted.
fn passes(r: f64, s: f64, a: f64) -> f64 {
    (1.0 - r) * (1.0 - s) * a / (1.0 - r * s * a * a)
}

#[test]
fn a_slab_passes_what_its_faces_do_not_reflect() {
    for ior in [1.2, 1.5, 2.4] {
        let r = reflectance(1.0, ior);
        through(&slab([-1.0, 1.0], &glass(ior, ""))).is_grey(passes(r, r, 1.0), 0.01);
    }
}

#[test]
fn glass_absorbs_with_the_way_inside() {
    let tint = ", transmission_color = [0.25, 0.5, 1], transmission_depth = 4";
    let r = reflectance(1.0, 1.5);
    let expected = [0.25f64, 0.5, 1.0].map(|c| passes(r, r, c.powf(2.0 / 4.0)));
    through(&slab([-1.0, 1.0], &glass(1.5, tint))).is(expected, 0.01);
}

/// A texture counts as it is where light enters.
#[test]
fn glass_absorbs_by_its_texture() {
    let board = "{ type = \"chessboard\", even = [0.25, 0.5, 1], odd = [0.25, 0.5, 1] }";
    let tint = format!(", transmission_color = {board}, transmission_depth = 4");
    let r = reflectance(1.0, 1.5);
    let expected = [0.25f64, 0.5, 1.0].map(|c| passes(r, r, c.powf(2.0 / 4.0)));
    through(&slab([-1.0, 1.0], &glass(1.5, &tint))).is(expected, 0.01);
}

#[test]
fn solids_of_one_material_are_one_where_they_overlap() {
    let r = reflectance(1.0, 1.5);
    let tint = ", transmission_color = [0.25, 0.5, 1], transmission_depth = 4";
    let text = format!("{}{}", slab([-1.0, 0.4], "material = \"g\""), slab([-0.3, 1.0], "material = \"g\""));
    let named = glass(1.5, tint).replacen("material", "", 1).replacen("=", "", 1);
    let m = mean(
        256,
        &format!(
            "integrator = {{ type = \"path\", max_depth = 200 }}\n\
         camera = {{ position = [0, 0, 10], look_at = [0, 0, 0], fov = 0.001 }}\n\
         material.g = {named}\n\
         object = [{text} {{ type = \"rectangle\", center = [0, 0, -10], edge_u = [9, 0, 0], edge_v = [0, 9, 0], material = {{ type = \"principled\", base_weight = 0, specular_weight = 0, emission_luminance = 1 }} }}]"
        ),
    );
    m.is([0.25f64, 0.5, 1.0].map(|c| passes(r, r, c.powf(2.0 / 4.0))), 0.01);
}

/// A drink that reaches into its glass: the boundary between them is the glass's.
#[test]
fn where_solids_overlap_the_denser_one_is_there() {
    let (water, wall) = (glass(1.33, ""), glass(1.5, ""));
    let (air, between) = (reflectance(1.0, 1.5), reflectance(1.5, 1.33));
    // Glass from 1 to 2, water from −2 to 1.3 or exactly to 1: the rays see glass, then water.
    let overlapping = through(&format!("{}{}", slab([1.0, 2.0], &wall), slab([-2.0, 1.3], &water)));
    let wet = reflectance(1.33, 1.0);
    // Three faces: the first two as a slab with inner reflectance, then with the third.
    let t12 = passes(air, between, 1.0);
    let back = between + (1.0 - between).powi(2) * air / (1.0 - air * between);
    let expected = t12 * (1.0 - wet) / (1.0 - back * wet);
    overlapping.is_grey(expected, 0.01);
}

#[test]
fn rays_pass_thin_walls_and_hundreds_of_shells() {
    // A shell is glass outside and air inside: 64 of them in one another, with a clear material that reflects nothing.
    let shells: String = (0..64)
        .map(|i| {
            let (outer, inner) = (4.0 - 0.06 * f64::from(i), 3.97 - 0.06 * f64::from(i));
            format!(
                "{}{}",
                slab([-outer, -inner], "material = \"clear\""),
                slab([inner, outer], "material = \"clear\"")
            )
        })
        .collect();
    let m = mean(
        4,
        &format!(
            "integrator = {{ type = \"path\", max_depth = 1000, rr_start = 1000 }}\n\
         camera = {{ position = [0, 0, 10], look_at = [0, 0, 0], fov = 0.001 }}\n\
         material.clear = {{ type = \"principled\", transmission_weight = 1, specular_roughness = 0, specular_weight = 0 }}\n\
         background.color = 1\nobject = [{}]",
            shells.trim_end_matches(',')
        ),
    );
    m.is_grey(1.0, 1e-6);
}

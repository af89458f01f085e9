//! Thin clear panes: lights are found through them by sampling.

use crate::path::statistics::{Mean, mean};

const PANE: &str = "type = \"dielectric\", thin = true, ior = 1.5, color = [0.9, 0.6, 0.3]";

/// All reflections between the two faces of a pane that lets the share c through: what comes out behind.
fn passes(r: f64, c: f64) -> f64 {
    (1.0 - r) * (1.0 - r) * c / (1.0 - r * r * c * c)
}

#[test]
fn a_point_light_shines_through_panes() {
    // Two panes straight on.
    let pane = |y: f64| {
        format!(
            "{{ type = \"rectangle\", center = [0, {y}, 0], edge_u = [4, 0, 0], edge_v = [0, 0, 4], material = {{ {PANE} }} }}"
        )
    };
    let lit = mean(
        16,
        &format!(
            "integrator = {{ type = \"path\", max_depth = 1 }}\n\
             camera = {{ position = [0, 0.2, 0], look_at = [0, 0, 0], up = [0, 0, -1], fov = 0.001 }}\n\
             light = [{{ type = \"point\", position = [0, 3, 0], intensity = 9, attenuation = \"inverse-square\" }}]\n\
             object = [{{ type = \"plane\", material = {{ type = \"matte\", color = 1 }} }}, {}, {}]",
            pane(1.0),
            pane(2.0)
        ),
    );
    let expected = [0.9, 0.6, 0.3].map(|c| passes(0.04, c).powi(2) / std::f64::consts::PI);
    lit.is(expected, 0.0);
}

fn room(how: &str, depth: u32, samples: u32, pane: &str, light: &str) -> Mean {
    mean(
        samples,
        &format!(
            "integrator = {{ type = \"path\", max_depth = {depth}, light_sampling = \"{how}\" }}\n\
             camera = {{ position = [0, 0.2, 0], look_at = [0, 0, 0], up = [0, 0, -1], fov = 0.001 }}\n{light}\n\
             object = [{{ type = \"plane\", material = {{ type = \"matte\", color = 0.6 }} }},\n\
             {{ type = \"rectangle\", center = [0, 0.6, 0], edge_u = [20, 6, 0], edge_v = [0, 0, 20], material = {{ {pane} }} }},\n\
             {{ type = \"box\", min = [-0.5, 3, -0.8], max = [1, 4, 0.8], material = {{ type = \"emissive\", strength = 5 }} }}]"
        ),
    )
}

const PANES: [&str; 4] = [
    PANE,
    "type = \"principled\", thin_walled = true, transmission_weight = 0.6, specular_roughness = 0, subsurface_weight = 0.5, coat_weight = 0.5",
    "type = \"principled\", thin_walled = true, transmission_weight = 1, specular_roughness = 0, alpha_mode = \"blend\", opacity = 0.5",
    "type = \"mix\", materials = [{ type = \"dielectric\", thin = true }, { type = \"matte\" }], weights = [0.3]",
];

/// A light behind a slanted pane, with and without sampling it, where paths may end at the pane or go on.
#[test]
fn light_sampling_changes_no_mean_behind_panes() {
    for pane in PANES {
        for depth in [1, 3] {
            let chance = room("bsdf", depth, 1024, pane, "");
            room("both", depth, 128, pane, "").agrees(&chance, 0.03);
        }
    }
}

#[test]
fn an_environment_is_found_through_panes() {
    let light = "light = [{ type = \"environment\" }]";
    for pane in &PANES[..2] {
        let chance = room("bsdf", 2, 512, pane, light);
        room("both", 2, 128, pane, light).agrees(&chance, 0.03);
    }
}

/// Without sampling through the pane, this would be found by chance alone.
#[test]
fn a_small_lamp_behind_a_pane_is_no_noise() {
    let lit = mean(
        64,
        &format!(
            "integrator = {{ type = \"path\", max_depth = 1 }}\n\
             camera = {{ position = [0, 0.2, 0], look_at = [0, 0, 0], up = [0, 0, -1], fov = 0.001 }}\n\
             object = [{{ type = \"plane\", material = {{ type = \"matte\", color = 1 }} }},\n\
             {{ type = \"rectangle\", center = [0, 1, 0], edge_u = [4, 0, 0], edge_v = [0, 0, 4], material = {{ {PANE} }} }},\n\
             {{ type = \"sphere\", center = [0, 5, 0], radius = 0.01, material = {{ type = \"emissive\", strength = 1e5 }} }}]"
        ),
    );
    let expected = [0.9, 0.6, 0.3].map(|c| passes(0.04, c) * 1e5 * 0.0001 / 25.0);
    lit.is(expected, 0.001);
}

#[test]
fn the_direct_integrator_sees_light_through_panes() {
    let text = |how: &str| {
        format!(
            "integrator = {{ type = \"direct\", light_sampling = \"{how}\" }}\n\
             camera = {{ position = [0, 0.2, 0], look_at = [0, 0, 0], up = [0, 0, -1], fov = 0.001 }}\n\
             object = [{{ type = \"plane\", material = {{ type = \"matte\", color = 1 }} }},\n\
             {{ type = \"rectangle\", center = [0, 0.5, 0], edge_u = [9, 0, 0], edge_v = [0, 0, 9], material = {{ {PANE} }} }},\n\
             {{ type = \"disk\", center = [0, 1, 0], radius = 1, material = {{ type = \"emissive\" }} }}]"
        )
    };
    mean(64, &text("both")).agrees(&mean(512, &text("bsdf")), 0.02);
}

/// Smooth normals over flat triangles: both ways of finding light see the same, and less than without normals beyond the terminator.
#[test]
fn the_terminator_of_smooth_meshes_is_the_same_for_both_ways() {
    let text = |how: &str| {
        format!(
            "integrator = {{ type = \"path\", max_depth = 1, light_sampling = \"{how}\" }}\n\
             camera = {{ position = [0.2, 0.15, 4], look_at = [0.2, 0.15, 0], fov = 0.001 }}\n\
             object = [{{ type = \"mesh\", positions = [[-1, -1, 0], [1, -1, 0], [0, 1, 0]], normals = [[-0.6, -0.5, 0.6], [0.6, -0.5, 0.6], [0, 0.8, 0.6]], \
             triangles = [[0, 1, 2]], material = {{ type = \"matte\", color = 1 }} }},\n\
             {{ type = \"sphere\", center = [0, 4, 0.7], radius = 1, material = {{ type = \"emissive\" }} }}]"
        )
    };
    mean(256, &text("both")).agrees(&mean(2048, &text("bsdf")), 0.03);
}

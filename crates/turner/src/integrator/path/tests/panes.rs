//! Thin clear panes: light sampling finds lights through them.

use std::f64::consts::PI;

use crate::bsdf::Terminator;
use crate::description::SceneDesc;
use crate::integrator::{DirectDesc, IntegratorDesc, LightSampling, PathDesc};
use crate::light::{Attenuation, DirectionalDesc, EnvironmentDesc, LightDesc, PointDesc};
use crate::material::{AlphaMode, DielectricMaterial, MaterialDesc, MixMaterial, PrincipledMaterial};
use crate::math::DVec3;
use crate::schema::{MaterialId, MeshData};
use crate::shape::{DiskDesc, ShapeDesc};
use crate::testing::scenes::{
    Mean, cuboid, emissive, grey, matte, mean, path, plane, rectangle, rgb, scene, sphere, v,
};

const TINT: [f64; 3] = [0.9, 0.6, 0.3];

fn pane() -> PrincipledMaterial {
    DielectricMaterial { thin: true, ior: 1.5, color: rgb(TINT), ..DielectricMaterial::default() }
        .principled()
}

/// A horizontal square at this height.
fn level(height: f64, edge: f64) -> ShapeDesc {
    rectangle(v(0.0, height, 0.0), v(edge, 0.0, 0.0), v(0.0, 0.0, edge))
}

/// Transmission of a pane, all reflections between its two faces included. The pane itself transmits the fraction c.
fn passes(r: f64, c: f64) -> f64 {
    (1.0 - r) * (1.0 - r) * c / (1.0 - r * r * c * c)
}

/// A white floor with direct light.
fn white_floor() -> SceneDesc {
    path(PathDesc { max_depth: 1, ..PathDesc::default() }).seen_down().with(plane(), matte(grey(1.0)))
}

#[test]
fn a_point_light_through_panes() {
    // Two panes at normal incidence.
    let light = PointDesc {
        position: v(0.0, 3.0, 0.0),
        intensity: 9.0,
        attenuation: Attenuation { coefficients: [0.0, 0.0, 1.0] },
        ..PointDesc::default()
    };
    let desc = white_floor()
        .with(level(1.0, 4.0), pane())
        .with(level(2.0, 4.0), pane())
        .lit(LightDesc::Point(light));
    mean(16, desc).is(TINT.map(|c| passes(0.04, c).powi(2) / PI), 0.0);
}

/// A floor under a tilted pane and a light.
fn room(strategy: LightSampling, depth: u32, pane: MaterialDesc) -> SceneDesc {
    let mut desc =
        path(PathDesc { max_depth: depth, light_sampling: strategy, ..PathDesc::default() }).seen_down();
    for part in parts() {
        desc.material(part);
    }
    let pane = desc.material(pane);
    desc.with(plane(), matte(grey(0.6)))
        .with_shared(rectangle(v(0.0, 0.6, 0.0), v(20.0, 6.0, 0.0), v(0.0, 0.0, 20.0)), pane)
        .with(cuboid(v(-0.5, 3.0, -0.8), v(1.0, 4.0, 0.8)), emissive(5.0, grey(1.0)))
}

/// The parts of the mixed pane: the first materials of a room.
fn parts() -> [MaterialDesc; 2] {
    let thin = DielectricMaterial { thin: true, ..DielectricMaterial::default() };
    [MaterialDesc::Dielectric(thin), MaterialDesc::Matte(Default::default())]
}

fn panes() -> [MaterialDesc; 4] {
    let thin = PrincipledMaterial {
        thin_walled: true,
        transmission_weight: grey(1.0),
        specular_roughness: grey(0.0),
        ..PrincipledMaterial::default()
    };
    let coated = PrincipledMaterial {
        transmission_weight: grey(0.6),
        subsurface_weight: grey(0.5),
        coat_weight: grey(0.5),
        ..thin.clone()
    };
    let half = PrincipledMaterial { alpha_mode: AlphaMode::Blend, opacity: grey(0.5), ..thin };
    let mix = MixMaterial { materials: vec![MaterialId(0), MaterialId(1)], weights: vec![grey(0.3)] };
    [
        MaterialDesc::Principled(pane()),
        MaterialDesc::Principled(coated),
        MaterialDesc::Principled(half),
        MaterialDesc::Mix(mix),
    ]
}

/// A light behind a tilted pane, with and without light sampling, with depth limits at which paths end or continue at
/// the pane.
#[test]
fn light_sampling_changes_no_mean_behind_panes() {
    for pane in panes() {
        for depth in [1, 3] {
            let chance = mean(1024, room(LightSampling::Bsdf, depth, pane.clone()));
            mean(128, room(LightSampling::Both, depth, pane.clone())).agrees(&chance, 0.03);
        }
    }
}

#[test]
fn an_environment_is_found_through_panes() {
    for pane in &panes()[..2] {
        let lit = |strategy, samples| -> Mean {
            let studio = LightDesc::Environment(EnvironmentDesc::studio());
            mean(samples, room(strategy, 2, pane.clone()).lit(studio))
        };
        lit(LightSampling::Both, 128).agrees(&lit(LightSampling::Bsdf, 512), 0.03);
    }
}

/// Without light sampling through the pane, only BSDF-sampled rays would find the emitter.
#[test]
fn a_small_light_behind_a_pane_has_no_noise() {
    let desc = white_floor()
        .with(level(1.0, 4.0), pane())
        .with(sphere(v(0.0, 5.0, 0.0), 0.01), emissive(1e5, grey(1.0)));
    mean(64, desc).is(TINT.map(|c| passes(0.04, c) * 1e5 * 0.0001 / 25.0), 0.001);
}

#[test]
fn the_direct_integrator_sees_light_through_panes() {
    let lit = |light_sampling| {
        let direct = DirectDesc { light_sampling, ..DirectDesc::default() };
        let disk = DiskDesc { center: v(0.0, 1.0, 0.0), radius: 1.0, ..DiskDesc::default() };
        scene(IntegratorDesc::Direct(direct))
            .seen_down()
            .with(plane(), matte(grey(1.0)))
            .with(level(0.5, 9.0), pane())
            .with(ShapeDesc::Disk(disk), emissive(1.0, grey(1.0)))
    };
    mean(64, lit(LightSampling::Both)).agrees(&mean(512, lit(LightSampling::Bsdf)), 0.02);
}

/// Smooth normals over flat triangles: light sampling and BSDF sampling agree, and the result is darker than without
/// normals beyond the terminator.
#[test]
fn the_terminator_of_smooth_meshes_is_the_same_for_both_strategies() {
    let lit = |light_sampling| {
        let mut desc = path(PathDesc { max_depth: 1, light_sampling, ..PathDesc::default() }).seen_at(
            v(0.2, 0.15, 4.0),
            v(0.2, 0.15, 0.0),
            0.001,
        );
        let triangle = desc.mesh(MeshData {
            positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]],
            normals: vec![[-0.6, -0.5, 0.6], [0.6, -0.5, 0.6], [0.0, 0.8, 0.6]],
            triangles: vec![[0, 1, 2]],
            ..MeshData::default()
        });
        desc.with(triangle, matte(grey(1.0)))
            .with(sphere(DVec3::new(0.0, 4.0, 0.7), 1.0), emissive(1.0, grey(1.0)))
    };
    mean(256, lit(LightSampling::Both)).agrees(&mean(2048, lit(LightSampling::Bsdf)), 0.03);
}

/// A white triangle whose shading normal is (0.6, 0, 0.8): without softening, the light of a sun falls off with the cosine
/// to that normal.
#[test]
fn materials_choose_whether_terminators_are_soft() {
    let to_sun = v(0.98, 0.0, 0.2).normalize();
    let lit = |soften_terminator: bool| {
        let mut desc = path(PathDesc { max_depth: 1, ..PathDesc::default() }).seen_at(
            v(0.0, 0.0, 4.0),
            DVec3::ZERO,
            0.001,
        );
        let triangle = desc.mesh(MeshData {
            positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]],
            normals: vec![[0.6, 0.0, 0.8]; 3],
            triangles: vec![[0, 1, 2]],
            ..MeshData::default()
        });
        let sun = DirectionalDesc { from: Some(to_sun), intensity: PI, ..DirectionalDesc::default() };
        let white = PrincipledMaterial { soften_terminator, ..matte(grey(1.0)) };
        desc.with(triangle, white).lit(LightDesc::Directional(sun))
    };
    let ns = v(0.6, 0.0, 0.8);
    let cosine = ns.dot(to_sun);
    mean(1, lit(false)).is_grey(cosine, 0.0);
    let softening = Terminator::new(ns, DVec3::Z).softening(to_sun);
    assert!(softening < 0.6, "{softening}");
    mean(1, lit(true)).is_grey(cosine * softening, 0.0);
}

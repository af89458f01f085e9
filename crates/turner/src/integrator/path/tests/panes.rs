//! Thin clear panes: lights are found through them by sampling.

use std::f64::consts::PI;

use crate::description::SceneDesc;
use crate::integrator::{DirectDesc, IntegratorDesc, LightSampling, PathDesc};
use crate::light::{Attenuation, EnvironmentDesc, LightDesc, PointDesc};
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

/// A level square at that height.
fn level(height: f64, edge: f64) -> ShapeDesc {
    rectangle(v(0.0, height, 0.0), v(edge, 0.0, 0.0), v(0.0, 0.0, edge))
}

/// All reflections between the two faces of a pane that lets the share c through: what comes out behind.
fn passes(r: f64, c: f64) -> f64 {
    (1.0 - r) * (1.0 - r) * c / (1.0 - r * r * c * c)
}

/// A white floor, directly lit.
fn white_floor() -> SceneDesc {
    path(PathDesc { max_depth: 1, ..PathDesc::default() }).seen_down().with(plane(), matte(grey(1.0)))
}

#[test]
fn a_point_light_shines_through_panes() {
    // Two panes straight on.
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

/// A floor under a slanted pane and a lamp.
fn room(way: LightSampling, depth: u32, pane: MaterialDesc) -> SceneDesc {
    let mut desc =
        path(PathDesc { max_depth: depth, light_sampling: way, ..PathDesc::default() }).seen_down();
    for part in parts() {
        desc.material(part);
    }
    let pane = desc.material(pane);
    desc.with(plane(), matte(grey(0.6)))
        .with_shared(rectangle(v(0.0, 0.6, 0.0), v(20.0, 6.0, 0.0), v(0.0, 0.0, 20.0)), pane)
        .with(cuboid(v(-0.5, 3.0, -0.8), v(1.0, 4.0, 0.8)), emissive(5.0, grey(1.0)))
}

/// What the mixed pane is made of: the first materials of a room.
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

/// A light behind a slanted pane, with and without sampling it, where paths may end at the pane or go on.
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
        let lit = |way, samples| -> Mean {
            let studio = LightDesc::Environment(EnvironmentDesc::studio());
            mean(samples, room(way, 2, pane.clone()).lit(studio))
        };
        lit(LightSampling::Both, 128).agrees(&lit(LightSampling::Bsdf, 512), 0.03);
    }
}

/// Without sampling through the pane, this would be found by chance alone.
#[test]
fn a_small_lamp_behind_a_pane_is_no_noise() {
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

/// Smooth normals over flat triangles: both ways of finding light see the same, and less than without normals beyond the terminator.
#[test]
fn the_terminator_of_smooth_meshes_is_the_same_for_both_ways() {
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

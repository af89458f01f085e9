//! Caustics, found by every strategy: all give the same image.

use std::f64::consts::PI;

use crate::description::SceneDesc;
use crate::film::Antialias;
use crate::filter::FilterKind;
use crate::integrator::{Caustics, PathDesc};
use crate::light::{Attenuation, DirectionalDesc, LightDesc, PointDesc, SkyDesc};
use crate::material::{DielectricMaterial, MetalMaterial, PrincipledMaterial};
use crate::math::DVec3;
use crate::schema::PrepareOptions;
use crate::shape::{CylinderDesc, PlaneDesc, ShapeDesc};
use crate::testing::scenes::{
    Mean, cuboid, emissive, grey, matte, mean_of, path, plane, rectangle, render_with, rgb, sphere, v,
};

fn metal(roughness: f64) -> PrincipledMaterial {
    MetalMaterial { roughness: grey(roughness), ..MetalMaterial::default() }.principled()
}

fn emitter() -> PrincipledMaterial {
    emissive(4.0, grey(1.0))
}

fn glass() -> PrincipledMaterial {
    DielectricMaterial { ior: 1.5, ..DielectricMaterial::default() }.principled()
}

/// A horizontal square.
fn level(center: DVec3, edge: f64) -> ShapeDesc {
    rectangle(center, v(edge, 0.0, 0.0), v(0.0, 0.0, edge))
}

/// A glass ball, polished metal and brushed metal in the corner of a room.
fn table(desc: PathDesc) -> SceneDesc {
    let wall = || matte(rgb([0.7, 0.6, 0.5]));
    let back = PlaneDesc { point: v(0.0, 0.0, -2.0), normal: DVec3::Z };
    let drum = CylinderDesc {
        from: v(-0.8, 0.0, 0.4),
        to: v(-0.8, 0.5, 0.4),
        radius: 0.3,
        ..CylinderDesc::default()
    };
    path(desc)
        .seen_at(v(0.0, 1.6, 3.4), v(0.0, 0.5, 0.0), 45.0)
        .with(plane(), wall())
        .with(ShapeDesc::Plane(back), wall())
        .with(sphere(v(0.7, 0.5, 0.0), 0.5), glass())
        .with(cuboid(v(-0.3, 0.0, -0.6), v(0.1, 0.8, -0.3)), metal(0.0))
        .with(ShapeDesc::Cylinder(drum), metal(0.25))
}

/// Mean of the table under the given light.
fn mean_lit(samples: u32, desc: PathDesc, lit: impl Fn(SceneDesc) -> SceneDesc) -> Mean {
    mean_of(24, samples, lit(table(PathDesc { max_depth: 6, ..desc })))
}

fn estimate(samples: u32, caustics: Caustics, lit: impl Fn(SceneDesc) -> SceneDesc) -> Mean {
    mean_lit(samples, PathDesc { caustics, ..PathDesc::default() }, lit)
}

/// Polished metal that is no perfect mirror: its narrow lobe forms caustics and reflects those of other objects.
#[test]
fn of_polished_metal() {
    let lit = |desc: SceneDesc| {
        let tube =
            CylinderDesc { from: v(-0.2, 0.0, 0.4), to: v(-0.2, 0.4, 0.4), radius: 0.35, capped: false };
        desc.with(level(v(-0.5, 2.6, 0.5), 1.4), emitter())
            .with(sphere(v(0.1, 0.35, 0.9), 0.35), metal(0.12))
            .with(ShapeDesc::Cylinder(tube), metal(0.12))
    };
    let camera_paths_only = estimate(256, Caustics::Off, lit);
    camera_paths_only.agrees(&estimate(64, Caustics::LightTracing, lit), 0.02);
    // At this resolution the default radius would blur photons over the entire image.
    let photons = PathDesc { caustics: Caustics::Full, photon_radius: Some(0.03), ..PathDesc::default() };
    camera_paths_only.agrees(&mean_lit(64, photons, lit), 0.02);
}

/// Camera paths alone, with light paths, and with photons.
fn all_agree(lit: impl Fn(SceneDesc) -> SceneDesc, off: u32, tolerance: f64) {
    let camera_paths_only = estimate(off, Caustics::Off, &lit);
    camera_paths_only.agrees(&estimate(off / 4, Caustics::LightTracing, &lit), tolerance);
    camera_paths_only.agrees(&estimate(off / 4, Caustics::Full, &lit), tolerance);
}

#[test]
fn of_area_lights() {
    let lit = |desc: SceneDesc| {
        desc.with(level(v(-0.5, 2.6, 0.5), 1.4), emitter()).with(sphere(v(1.8, 1.6, 0.5), 0.5), emitter())
    };
    all_agree(lit, 256, 0.02);
}

#[test]
fn of_infinite_lights() {
    let lit = |desc: SceneDesc| {
        let around = SkyDesc { elevation: 60.0, sun: false, ..SkyDesc::default() };
        let disc = DirectionalDesc {
            from: Some(v(0.5, 1.0, 0.6)),
            angle: 25.0,
            intensity: 2.0,
            ..DirectionalDesc::default()
        };
        desc.lit(LightDesc::Sky(around)).lit(LightDesc::Directional(disc))
    };
    all_agree(lit, 256, 0.02);
}

/// A small emissive ball is nearly a point light. Camera paths never find point lights behind glass, light paths do.
#[test]
fn of_point_lights() {
    let at = v(0.5, 2.4, 1.0);
    let ball = |desc: SceneDesc| desc.with(sphere(at, 0.05), emissive(400.0, grey(1.0)));
    // Radiant intensity π r² L.
    let intensity = PI * 0.05 * 0.05 * 400.0;
    let point = |desc: SceneDesc| {
        let attenuation = Attenuation { coefficients: [0.0, 0.0, 1.0] };
        desc.lit(LightDesc::Point(PointDesc { position: at, intensity, attenuation, ..PointDesc::default() }))
    };
    let ball = estimate(128, Caustics::LightTracing, ball);
    let point_light = estimate(128, Caustics::LightTracing, point);
    // The ball itself blocks a little light and is visible in mirrors.
    ball.agrees(&point_light, 0.03);
    let without = estimate(128, Caustics::Off, point);
    let (without, with) = (without.value()[1], point_light.value()[1]);
    assert!(without < 0.985 * with, "{without} {with}");
}

#[test]
fn through_panes_and_with_many_lights() {
    let lit = |desc: SceneDesc| {
        let pane = PrincipledMaterial {
            transmission_weight: grey(1.0),
            thin_walled: true,
            specular_roughness: grey(0.0),
            ..PrincipledMaterial::default()
        };
        // More lights than a table holds: the light tree chooses.
        (0..70).fold(desc.with(level(v(0.0, 2.2, 0.5), 4.0), pane), |desc, i| {
            let (x, z) = (f64::from(i % 10) * 0.3 - 1.5, f64::from(i / 10) * 0.3 - 0.5);
            desc.with(sphere(v(x, 2.8, z), 0.12), emitter())
        })
    };
    all_agree(lit, 256, 0.02);
}

#[test]
fn any_number_of_threads_and_any_split_into_passes() {
    for caustics in [Caustics::LightTracing, Caustics::Full] {
        let mut desc = table(PathDesc { caustics, ..PathDesc::default() })
            .filmed([80, 50], 5)
            .with(level(v(-0.5, 2.6, 0.5), 0.6), emitter());
        desc.film.filter = FilterKind::Gaussian;
        let bits = |threads, pass| {
            let picture = render_with(&desc, threads, pass).0;
            picture.linear.iter().map(|p| p.map(f32::to_bits)).collect::<Vec<_>>()
        };
        let whole = bits(1, u32::MAX);
        for (threads, pass) in [(2, u32::MAX), (5, 1), (3, 2)] {
            assert!(bits(threads, pass) == whole, "{caustics:?}: {threads} threads, passes of {pass}");
        }
    }
}

/// Chrome grains on a bright floor: that one pixel in a thousand shows their glints is no reason for light paths. They have
/// little light, and all pixels would pay.
#[test]
fn rare_light_needs_no_light_paths() {
    let mut desc = (-2..3)
        .flat_map(|x| (-2..3).map(move |z| (f64::from(x), f64::from(z))))
        .fold(path(PathDesc::default()), |desc, (x, z)| {
            desc.with(sphere(v(0.3 * x, 0.02, 0.3 * z), 0.02), metal(0.0))
        })
        .seen_at(v(0.0, 2.0, 3.0), v(0.0, 0.0, 0.0), 40.0)
        .with(plane(), matte(grey(0.8)))
        .with(level(v(0.0, 3.0, 0.0), 0.02), emissive(4000.0, grey(1.0)))
        .lit(LightDesc::Sky(SkyDesc::default()));
    (desc.film.samples, desc.film.antialias) = (16, Antialias::MonteCarlo);
    assert_eq!(desc.prepare(&PrepareOptions::default()).unwrap().integrator.light_paths(), 0);
}

/// A small lamp in a lantern with a pane of glass: camera paths hardly ever find it, so that the picture is black without
/// light paths.
#[test]
fn light_that_the_pilot_run_never_sees_needs_light_paths() {
    let black = || matte(grey(0.0));
    let mut desc = path(PathDesc::default())
        .seen_at(v(0.0, 2.0, 3.0), v(0.0, 0.0, 0.0), 40.0)
        .with(plane(), matte(grey(0.8)))
        .with(level(v(0.0, 4.5, 0.0), 1.0), black())
        .with(rectangle(v(-0.5, 4.0, 0.0), v(0.0, 1.0, 0.0), v(0.0, 0.0, 1.0)), black())
        .with(rectangle(v(0.5, 4.0, 0.0), v(0.0, 1.0, 0.0), v(0.0, 0.0, 1.0)), black())
        .with(rectangle(v(0.0, 4.0, -0.5), v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0)), black())
        .with(rectangle(v(0.0, 4.0, 0.5), v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0)), black())
        .with(cuboid(v(-0.49, 3.5, -0.49), v(0.49, 3.55, 0.49)), glass())
        .with(sphere(v(0.0, 4.0, 0.0), 1e-3), emissive(4e5, grey(1.0)));
    (desc.film.samples, desc.film.antialias) = (16, Antialias::MonteCarlo);
    assert!(desc.prepare(&PrepareOptions::default()).unwrap().integrator.light_paths() > 0);
}

/// A room with a window of two panes, brushed metal in a corner, and the sky outside.
fn house() -> SceneDesc {
    let wall = || matte(grey(0.85));
    let side = |y: [f64; 2], z: [f64; 2]| {
        let middle = |[a, b]: [f64; 2]| 0.5 * (a + b);
        rectangle(v(-5.0, middle(y), middle(z)), v(0.0, y[1] - y[0], 0.0), v(0.0, 0.0, z[1] - z[0]))
    };
    let mut desc = path(PathDesc { max_depth: 64, ..PathDesc::default() })
        .seen_at(v(2.0, 1.5, 3.0), v(4.6, 1.2, -4.8), 40.0)
        .with(rectangle(v(0.0, 0.0, 0.0), v(10.0, 0.0, 0.0), v(0.0, 0.0, -10.0)), wall())
        .with(rectangle(v(0.0, 3.0, 0.0), v(10.0, 0.0, 0.0), v(0.0, 0.0, -10.0)), wall())
        .with(rectangle(v(0.0, 1.5, -5.0), v(10.0, 0.0, 0.0), v(0.0, 3.0, 0.0)), wall())
        .with(rectangle(v(0.0, 1.5, 5.0), v(10.0, 0.0, 0.0), v(0.0, 3.0, 0.0)), wall())
        .with(rectangle(v(5.0, 1.5, 0.0), v(0.0, 0.0, 10.0), v(0.0, 3.0, 0.0)), wall())
        .with(side([0.0, 1.0], [-5.0, 5.0]), wall())
        .with(side([2.0, 3.0], [-5.0, 5.0]), wall())
        .with(side([1.0, 2.0], [-5.0, -1.0]), wall())
        .with(side([1.0, 2.0], [1.0, 5.0]), wall())
        .with(cuboid(v(-5.05, 1.0, -1.0), v(-5.0, 2.0, 1.0)), glass())
        .with(cuboid(v(-5.25, 1.0, -1.0), v(-5.2, 2.0, 1.0)), glass())
        .with(cuboid(v(3.4, 0.0, -4.6), v(4.6, 1.6, -4.2)), metal(0.3))
        .lit(LightDesc::Sky(SkyDesc::default()));
    (desc.film.samples, desc.film.antialias) = (16, Antialias::MonteCarlo);
    desc
}

/// A large mirror outside the house takes nearly all light paths. Those that come in are too few for an estimate, and too
/// few for the pixels.
#[test]
fn a_few_bright_light_paths_are_not_trusted() {
    let desc = house().with(sphere(v(60.0, 20.0, 0.0), 20.0), metal(0.0));
    for seed in 0..4 {
        let mut desc = desc.clone();
        desc.film.seed = seed;
        assert_eq!(desc.prepare(&PrepareOptions::default()).unwrap().integrator.light_paths(), 0, "{seed}");
    }
}

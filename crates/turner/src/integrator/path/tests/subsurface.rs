//! Subsurface scattering: albedos with closed forms, bodies against the media they are made of, and one estimator
//! against another.

use crate::camera::{OrthographicDesc, Viewport};
use crate::color::Spectrum;
use crate::description::{ObjectDesc, SceneDesc};
use crate::integrator::{Caustics, DirectDesc, IntegratorDesc, LightSampling, PathDesc};
use crate::material::{DielectricMaterial, InterfaceMaterial, PrincipledMaterial};
use crate::math::{DAffine3, DVec3};
use crate::medium::{HomogeneousMedium, scattering_albedo};
use crate::schema::{MeshData, Transform};
use crate::shape::{PlaneDesc, ShapeDesc};
use crate::testing::scenes::{
    bands, cuboid, emissive, even, grey, lamp, matte, mean, mean_of, path, placed, plane, render_with, rgb,
    sphere, turned, v,
};
use crate::texture::{MarbleDesc, TextureDesc};

fn deep() -> PathDesc {
    PathDesc { max_depth: 1000, rr_start: Some(1000), ..PathDesc::default() }
}

/// A camera that looks at the origin from the front.
fn from_front(desc: PathDesc) -> SceneDesc {
    path(desc).seen_from_front(4.0, 20.0)
}

fn wax() -> PrincipledMaterial {
    PrincipledMaterial { subsurface_weight: grey(1.0), specular_weight: grey(0.0), ..Default::default() }
}

/// Wax with this subsurface radius.
fn wax_of(subsurface_radius: f64) -> PrincipledMaterial {
    PrincipledMaterial { subsurface_radius, ..wax() }
}

fn ball() -> ShapeDesc {
    sphere(DVec3::ZERO, 1.0)
}

/// White furnace: with emission 1 all around and no absorption, everything is 1.
#[test]
fn a_white_body_returns_all_light() {
    let mut start = from_front(deep()).before(1.0);
    let mesh = start.mesh(MeshData {
        positions: vec![[-1.0, -1.0, -1.0], [1.0, -1.0, -1.0], [0.0, -1.0, 1.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]],
        ..MeshData::default()
    });
    let twice = turned(20.0, 30.0, 40.0) * DAffine3::from_scale(v(1.0, 2.0, 0.5));
    let cube = cuboid(DVec3::splat(-0.5), DVec3::splat(0.5));
    let white = |radius: f64| PrincipledMaterial { subsurface_color: grey(1.0), ..wax_of(radius) };
    let forwards = PrincipledMaterial {
        subsurface_radius_scale: grey(1.0),
        subsurface_scatter_anisotropy: 0.8,
        ..white(1.0)
    };
    let layers = PrincipledMaterial { specular_weight: grey(1.0), ..white(0.1) };
    let coated =
        PrincipledMaterial { coat_weight: grey(1.0), specular_roughness: grey(0.1), ..layers.clone() };
    for (i, (object, material, tolerance)) in [
        (ObjectDesc::new(ball()), white(0.2), 1e-3),
        (placed(cube, turned(10.0, 20.0, 30.0)), forwards, 1e-3),
        (placed(mesh, twice), white(0.1), 1e-3),
        // Under layers, as much as any diffuse body; the layers themselves lose at most 1e-3.
        (ObjectDesc::new(ball()), layers, 2e-3),
        (ObjectDesc::new(ball()), coated, 2e-3),
    ]
    .into_iter()
    .enumerate()
    {
        let m = mean(512, start.clone().with_object(object, material));
        for (v, e) in m.value().into_iter().zip(m.error()) {
            assert!(e < 4e-3, "{i}: {m:?}");
            assert!((v - 1.0).abs() < tolerance + 4.0 * e, "{i}: {:?} ± {:?}", m.value(), m.error());
        }
    }
}

/// A half-space under uniform light has the specified colour.
#[test]
fn a_thick_body_has_its_colour() {
    for (g, tolerance) in [(0.0, 0.003), (0.5, 0.003), (0.9, 0.003), (-0.5, 0.012)] {
        for (color, radius) in [([0.9, 0.5, 0.2], 1.0), ([0.05, 0.3, 0.7], 0.01)] {
            let body = PrincipledMaterial {
                subsurface_color: rgb(color),
                subsurface_scatter_anisotropy: g,
                ..wax_of(radius)
            };
            // From 10 above, slightly off axis.
            let desc = path(deep()).seen_at(v(1.0, 10.0, 0.5), DVec3::ZERO, 5.0).before(1.0);
            let m = mean(256, desc.with(plane(), body));
            for (band, (v, e)) in m.value().into_iter().zip(m.error()).enumerate() {
                assert!(e < 5e-3, "{m:?}");
                let near = (v - color[band]).abs() < tolerance + 4.0 * e;
                assert!(near, "g {g}, {color:?}: {:?} ± {:?}", m.value(), m.error());
            }
        }
    }
}

/// Unscattered light: the mean over chords 2Rµ of a sphere that light enters with a cosine distribution.
#[test]
fn unscattered_light_follows_the_mean_free_path() {
    let body = PrincipledMaterial { subsurface_color: grey(1e-5), ..wax_of(0.8) };
    let m = mean(1024, from_front(deep()).before(1.0).with(ball(), body));
    let expected = [0.8, 0.4, 0.2].map(|way: f64| {
        let a = 2.0 / way;
        2.0 * (1.0 - (1.0 + a) * (-a).exp()) / (a * a)
    });
    for (band, (v, e)) in m.value().into_iter().zip(m.error()).enumerate() {
        assert!(e < 0.01 * expected[band] + 1e-3, "{m:?}");
        let near = (v - expected[band]).abs() < 2e-4 + 4.0 * e;
        assert!(near, "{:?} ± {:?}, not {expected:?}", m.value(), m.error());
    }
}

/// Under parallel rays a sphere of the medium is entered with a cosine distribution, as the body is: averaged over the
/// disc they agree.
#[test]
fn a_body_is_as_bright_as_a_sphere_of_its_medium() {
    let (color, g) = ([0.9, 0.6, 0.3], 0.4);
    let ways = [0.5, 0.25, 0.125];
    let albedo = color.map(|c| scattering_albedo(c, g));
    let camera = OrthographicDesc {
        position: v(0.0, 0.0, 4.0),
        viewport: Viewport::Height(2.0),
        ..OrthographicDesc::default()
    };
    let desc = path(deep()).seen(camera).before(1.0);
    let wax =
        PrincipledMaterial { subsurface_color: rgb(color), subsurface_scatter_anisotropy: g, ..wax_of(0.5) };
    let medium = HomogeneousMedium {
        scattering: bands([0, 1, 2].map(|band| albedo[band] / ways[band])),
        absorption: bands([0, 1, 2].map(|band| (1.0 - albedo[band]) / ways[band])),
        anisotropy: g,
        ..HomogeneousMedium::default()
    };
    let body = mean_of(16, 128, desc.clone().with(ball(), wax));
    let medium = mean_of(16, 128, desc.filled(ball(), medium));
    for band in 0..3 {
        let (a, b) = (body.value()[band], medium.value()[band]);
        let error = body.error()[band].hypot(medium.error()[band]);
        assert!(error < 3e-3 && (a - b).abs() < 4.0 * error + 1e-4, "band {band}: {a} and {b} ± {error}");
    }
}

/// The same scene ten times as large, lit by a light and an environment.
#[test]
fn lengths_scale_with_the_scene() {
    let scene = |k: f64, radius: f64| {
        path(deep())
            .seen_from_front(4.0 * k, 30.0)
            .before_color([0.1, 0.2, 0.3])
            .lit(lamp(v(2.0 * k, 3.0 * k, 2.0 * k), 20.0 * k * k))
            .with(sphere(DVec3::ZERO, k), wax_of(radius))
    };
    let one = mean_of(8, 256, scene(1.0, 0.2));
    one.agrees(&mean_of(8, 256, scene(10.0, 2.0)), 0.03);
    // With another mean free path less light leaves on this side.
    let (a, b) = (one.value()[0], mean_of(8, 64, scene(1.0, 1.0)).value()[0]);
    assert!(b < 0.97 * a, "{a} {b}");
}

/// Lights are sampled at the exits of walks, hit from there, or both.
#[test]
fn light_sampling_strategies_agree() {
    let coated = PrincipledMaterial { coat_weight: grey(0.5), coat_roughness: grey(0.3), ..wax_of(0.2) };
    let ground = PlaneDesc { point: v(0.0, -1.0, 0.0), ..PlaneDesc::default() };
    let [both, bsdf, light] =
        [LightSampling::Both, LightSampling::Bsdf, LightSampling::Light].map(|light_sampling| {
            let desc = from_front(PathDesc { max_depth: 4, light_sampling, ..deep() })
                .with(ball(), coated.clone())
                .with(ShapeDesc::Plane(ground.clone()), matte(grey(0.8)))
                .with(sphere(v(2.0, 2.0, 1.0), 0.7), emissive(5.0, grey(1.0)));
            mean_of(8, 256, desc)
        });
    both.agrees(&bsdf, 0.03);
    both.agrees(&light, 0.03);
}

/// A box inside another one is one body with it; interfaces and glass inside change nothing.
#[test]
fn bodies_that_overlap_are_one() {
    let mut start = path(deep())
        .seen_at(v(1.0, 2.0, 5.0), DVec3::ZERO, 25.0)
        .before_color([0.1, 0.2, 0.3])
        .lit(lamp(v(2.0, 3.0, 2.0), 20.0));
    let wax = start.material(wax_of(0.5).into());
    let cube = cuboid(DVec3::NEG_ONE, DVec3::ONE);
    let part = cuboid(v(-0.9, -0.5, -0.3), v(0.3, 0.9, 0.8));
    let one = mean_of(8, 256, start.clone().with_shared(cube.clone(), wax));
    let nested = start.clone().with_shared(part, wax).with_shared(cube.clone(), wax);
    one.agrees(&mean_of(8, 256, nested), 0.03);
    let filled = start
        .with_shared(cube, wax)
        .with(sphere(DVec3::ZERO, 0.8), InterfaceMaterial::default())
        .with(sphere(v(0.3, 0.0, 0.0), 0.6), DielectricMaterial::default());
    one.agrees(&mean_of(8, 256, filled), 0.03);
}

/// With a mean free path of 0 it is the diffuse surface of the same colour; in a thin wall light passes.
#[test]
fn limits_are_diffuse() {
    let color = rgb([0.9, 0.5, 0.2]);
    let scene = |material: PrincipledMaterial| {
        from_front(deep()).lit(lamp(v(2.0, 3.0, 2.0), 20.0)).with(ball(), material)
    };
    let picture = |material| render_with(&scene(material).filmed([16; 2], 4), 1, u32::MAX).0.linear;
    let plain = PrincipledMaterial { base_color: color, ..PrincipledMaterial::default() };
    let body = |radius: f64| PrincipledMaterial {
        subsurface_color: color,
        specular_weight: grey(1.0),
        ..wax_of(radius)
    };
    assert!(picture(plain.clone()) == picture(body(0.0)));
    // A short mean free path is close to that limit.
    let near = mean_of(8, 256, scene(body(0.002)));
    let flat = mean_of(8, 64, scene(plain));
    for band in 0..3 {
        let (a, b) = (near.value()[band], flat.value()[band]);
        assert!((a - b).abs() < 0.01 * b + 4.0 * near.error()[band], "{:?} {:?}", near.value(), flat.value());
    }
}

/// A moving translucent ball, one of marble and one of glass, in fog.
fn moving(integrator: IntegratorDesc) -> SceneDesc {
    let motion = Some(Transform(DAffine3::from_translation(v(0.3, 0.0, 0.0))));
    let mut desc = SceneDesc { integrator, ..SceneDesc::default() }
        .seen_at(v(0.0, 1.2, 5.0), v(0.0, 0.8, 0.0), 40.0)
        .filmed([37, 29], 6)
        .lit(lamp(v(2.0, 3.0, 1.0), 20.0));
    let marble = desc.texture(TextureDesc::Marble(MarbleDesc::default()));
    let body = PrincipledMaterial { specular_weight: grey(1.0), ..wax_of(0.3) };
    let half = PrincipledMaterial {
        subsurface_weight: grey(0.5),
        subsurface_color: marble,
        subsurface_scatter_anisotropy: 0.7,
        ..PrincipledMaterial::default()
    };
    let fog = HomogeneousMedium { extinction: even(0.05), albedo: even(0.8), ..Default::default() };
    desc.with(plane(), matte(grey(0.8)))
        .with_object(ObjectDesc { motion, ..ObjectDesc::new(sphere(v(0.0, 1.0, 0.0), 1.0)) }, body)
        .with(sphere(v(-1.5, 0.6, 0.5), 0.6), half)
        .with(sphere(v(1.5, 0.5, 1.0), 0.5), DielectricMaterial::default())
        .in_fog(fog)
}

#[test]
fn threads_and_passes_change_nothing() {
    for integrator in [
        IntegratorDesc::Path(PathDesc { max_depth: 8, ..PathDesc::default() }),
        IntegratorDesc::Direct(DirectDesc::default()),
    ] {
        let desc = moving(integrator);
        let (reference, _) = render_with(&desc, 1, u32::MAX);
        assert!(reference.linear.iter().any(|p| p[0] > 0.0));
        for (threads, pass) in [(2, u32::MAX), (3, 1), (1, 4)] {
            let again = render_with(&desc, threads, pass).0;
            let kind = desc.integrator.type_name();
            assert!(again.linear == reference.linear, "{kind}: {threads} threads, {pass} samples a pass");
        }
    }
}

/// Light paths contribute on the surface of a body; light through the body is left to camera paths.
#[test]
fn light_paths_leave_bodies_to_camera_paths() {
    let found = |caustics| {
        let rough = DielectricMaterial { roughness: grey(0.3), ..DielectricMaterial::default() };
        let desc = path(PathDesc { max_depth: 6, caustics, ..deep() })
            .seen_at(v(0.0, 2.0, 4.0), DVec3::ZERO, 30.0)
            .with(cuboid(DVec3::NEG_ONE, v(1.0, 0.0, 1.0)), wax_of(0.1))
            .with(sphere(v(0.0, 0.8, 0.0), 0.5), rough)
            .with(sphere(v(0.0, 3.0, 0.0), 0.8), emissive(5.0, grey(1.0)));
        mean_of(8, 512, desc)
    };
    found(Caustics::Off).agrees(&found(Caustics::LightTracing), 0.05);
}

#[test]
fn white_and_black_are_exact() {
    assert_eq!(Spectrum::WHITE.to_array().map(|c| scattering_albedo(f64::from(c), 0.5)), [1.0; 3]);
    assert!(scattering_albedo(0.0, 0.5).abs() < 1e-4);
}

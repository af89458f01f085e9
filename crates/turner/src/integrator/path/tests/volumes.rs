//! Participating media: radiance by closed form or quadrature, and one estimator against another.

use std::f64::consts::PI;

use crate::camera::{OrthographicDesc, Viewport};
use crate::color::Spectrum;
use crate::description::SceneDesc;
use crate::integrator::{DepthDesc, DirectDesc, IntegratorDesc, LightSampling, NormalsDesc, PathDesc};
use crate::material::{DielectricMaterial, InterfaceMaterial, PrincipledMaterial};
use crate::math::{DAffine3, DVec3};
use crate::medium::{HomogeneousMedium, PhaseFunction, SmokeMedium};
use crate::schema::{MaterialId, MeshData};
use crate::shape::{DiskDesc, ShapeDesc};
use crate::testing::Random;
use crate::testing::scenes::{
    Mean, bands, cuboid, emissive, even, grey, lamp, matte, mean, mean_of, path, pixel, placed, plane,
    rectangle, render_with, scene, sphere, turned, v,
};

fn deep() -> PathDesc {
    PathDesc { max_depth: 1000, ..PathDesc::default() }
}

/// A camera that looks along −z, from 10 above the origin.
fn along(desc: PathDesc) -> SceneDesc {
    path(desc).seen_from_front(10.0, 0.001)
}

fn glow() -> PrincipledMaterial {
    emissive(1.0, grey(1.0))
}

/// Adds a wall with emission 1 at z = −10.
fn walled(desc: SceneDesc) -> SceneDesc {
    desc.with(rectangle(v(0.0, 0.0, -10.0), v(9.0, 0.0, 0.0), v(0.0, 9.0, 0.0)), glow())
}

/// A box around the origin, 2 thick.
fn slab() -> ShapeDesc {
    cuboid(v(-3.0, -3.0, -1.0), v(3.0, 3.0, 1.0))
}

fn absorbing(absorption: Option<Spectrum>) -> HomogeneousMedium {
    HomogeneousMedium { absorption, ..HomogeneousMedium::default() }
}

fn scattering(scattering: Option<Spectrum>, anisotropy: f64) -> HomogeneousMedium {
    HomogeneousMedium { scattering, anisotropy, ..HomogeneousMedium::default() }
}

fn foggy(extinction: Option<Spectrum>, albedo: Option<Spectrum>, anisotropy: f64) -> HomogeneousMedium {
    HomogeneousMedium { extinction, albedo, anisotropy, ..HomogeneousMedium::default() }
}

const STRATEGIES: [LightSampling; 3] = [LightSampling::Both, LightSampling::Bsdf, LightSampling::Light];

#[test]
fn absorption_follows_beer_and_lambert() {
    let e = |depth: f64| (-depth).exp();
    let seen = |desc: PathDesc, medium| mean(2, walled(along(desc)).filled(slab(), medium));
    seen(deep(), absorbing(bands([0.5, 0.0, 2.0]))).is([e(1.0), 1.0, e(4.0)], 1e-6);
    let dense = HomogeneousMedium { density: 2.0, ..foggy(bands([0.25, 0.0, 1.0]), even(0.0), 0.0) };
    seen(deep(), dense).is([e(1.0), 1.0, e(4.0)], 1e-6);
    // Scattering attenuates direct light as absorption does: with depth 0 only the wall is visible.
    let straight = PathDesc { max_depth: 0, ..PathDesc::default() };
    seen(straight, scattering(bands([0.5, 0.0, 2.0]), 0.0)).is([e(1.0), 1.0, e(4.0)], 1e-6);
    // A scene filled with fog, 20 to the wall.
    let fog = absorbing(even(0.1));
    mean(2, walled(along(deep())).in_fog(fog.clone())).is_grey(e(2.0), 1e-6);
    // A hollow in the fog, 4 long, and the camera inside another one.
    let hollow = walled(along(deep()))
        .with(sphere(DVec3::ZERO, 2.0), InterfaceMaterial::default())
        .filled(cuboid(v(-1.0, -1.0, 8.0), v(1.0, 1.0, 11.0)), absorbing(even(0.5)))
        .in_fog(fog);
    mean(2, hollow).is_grey(e(0.1 * (20.0 - 4.0 - 2.0) + 0.5 * 2.0), 1e-5);
}

#[test]
fn shadow_rays_cross_boundaries_in_order() {
    // From 4 above, straight down: 2 through one medium, the inner 1 of it through another one that comes first in the
    // scene.
    let mut desc = path(deep()).seen_down().lit(lamp(v(0.0, 4.0, 0.0), 32.0));
    let [inner, outer] =
        [[0.3, 1.0, 0.0], [0.7, 0.2, 0.0]].map(|absorption| desc.boundary(absorbing(bands(absorption))));
    let desc = desc
        .with(plane(), matte(grey(0.5)))
        .with_shared(cuboid(v(-1.0, 1.0, -1.0), v(1.0, 3.0, 1.0)), outer)
        .with_shared(cuboid(v(-0.5, 1.5, -0.5), v(0.5, 2.5, 0.5)), inner);
    let e = |a: f64| 2.0 * 0.5 / PI * (-a).exp();
    mean(2, desc).is([e(0.7 + 0.3), e(0.2 + 1.0), e(0.0)], 1e-5);
}

/// The mesh of a box.
fn mesh_of_box(min: DVec3, max: DVec3) -> MeshData {
    let corner = |i: u32| {
        let at = |bit: u32, axis: usize| if i >> bit & 1 == 1 { max[axis] } else { min[axis] } as f32;
        [at(0, 0), at(1, 1), at(2, 2)]
    };
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    MeshData {
        positions: (0..8).map(corner).collect(),
        triangles: faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect(),
        ..MeshData::default()
    }
}

#[test]
fn floors_that_coincide_with_boundaries_are_seen() {
    // Thin fog before a wall of light, each as a shape and as a mesh, in both orders, slanted and far from the origin.
    let mut random = Random::new(5);
    for case in 0..32 {
        let [fog_is_mesh, wall_is_mesh, fog_first, is_slanted, fills_room] =
            [0, 1, 2, 3, 4].map(|bit| case >> bit & 1 == 1);
        let [x, y, z] = random.units::<3>();
        let (min, max) = (v(-3.0 - x, -3.0 - y, -1.0 - z), v(3.0, 3.0, 1.0 + x));
        let mut desc = along(deep()).seen_from_front(12.0, 20.0).filmed([24, 24], 4);
        let to_world = if is_slanted { turned(10.0 * x, 20.0 * y, 30.0) } else { DAffine3::IDENTITY };
        let fog = match fog_is_mesh {
            true => desc.mesh(mesh_of_box(min, max)),
            false => cuboid(min, max),
        };
        let wall = match (fills_room, wall_is_mesh) {
            (true, true) => desc.mesh(mesh_of_box(min, max)),
            (true, false) => cuboid(min, max),
            (false, true) => {
                let (low, high) = (v(-8.0, -9.0, min.z - 1.0), v(8.0, 7.0, min.z));
                desc.mesh(mesh_of_box(low, high))
            }
            (false, false) => rectangle(v(0.0, 0.5, min.z), v(9.0, 0.0, 0.0), v(0.0, 8.0, 0.0)),
        };
        let interior = desc.medium(absorbing(even(1e-3)));
        let (fog, wall) = (placed(fog, to_world), placed(wall, to_world));
        desc = match fog_first {
            true => desc.with_object(fog, InterfaceMaterial { interior }).with_object(wall, glow()),
            false => desc.with_object(wall, glow()).with_object(fog, InterfaceMaterial { interior }),
        };
        let (picture, _) = render_with(&desc, 1, 4);
        for [r, g, b] in (0..24 * 24).map(|i| pixel(&picture, i % 24, i / 24)) {
            assert!(r.min(g).min(b) > 0.98, "{case}: {r} {g} {b}");
        }
    }
}

#[test]
fn light_from_floors_under_fog_passes_the_fog_once_more() {
    // From 4 above, 2 of it through the medium on the floor, down and up again.
    for height in [0.0, 0.1, -0.3] {
        let base = v(0.0, height, 0.0);
        let floor = rectangle(base, v(9.0, 0.0, 0.0), v(0.0, 0.0, 9.0));
        let desc = path(deep())
            .seen_down_from(height + 4.0)
            .lit(lamp(base + v(0.0, 4.0, 0.0), 32.0))
            .filled(
                cuboid(base + v(-1.0, 0.0, -1.0), base + v(1.0, 2.0, 1.0)),
                absorbing(bands([0.7, 0.2, 0.0])),
            )
            .with(floor, matte(grey(0.5)));
        let e = |a: f64| 2.0 * 0.5 / PI * (-4.0 * a).exp();
        mean(2, desc).is([e(0.7), e(0.2), e(0.0)], 1e-5);
    }
}

/// Single scattering of a point light along the ray, by Simpson's rule.
fn single_scattering(
    end: f64,
    sigma: f64,
    albedo: f64,
    phase: PhaseFunction,
    light: [f64; 2],
    intensity: f64,
) -> f64 {
    let n = 400_000;
    let f = |t: f64| {
        // The light is at distance `light[0]` along the ray and `light[1]` from it.
        let (along, beside) = (light[0] - t, light[1]);
        let d = (along * along + beside * beside).sqrt();
        albedo * sigma * (-sigma * (t + d)).exp() * phase.value(along / d) * intensity / (d * d)
    };
    let h = end / f64::from(n);
    let inner: f64 = (1..n).map(|i| f(h * f64::from(i)) * if i % 2 == 1 { 4.0 } else { 2.0 }).sum();
    (f(0.0) + f(end) + inner) * h / 3.0
}

#[test]
fn single_scattering_matches_quadrature() {
    let once = PathDesc { max_depth: 1, ..PathDesc::default() };
    // Mean cosines of two lobes, the fraction of the second, and that of Rayleigh's function.
    let phases = [
        ([0.0, 0.0], 0.0, 0.0),
        ([0.7, 0.0], 0.0, 0.0),
        ([-0.5, 0.0], 0.0, 0.0),
        ([0.0, 0.0], 0.0, 1.0),
        ([0.8, -0.4], 0.4, 0.3),
    ];
    for (cosines, second_weight, rayleigh) in phases {
        let samples = 400;
        let phase = PhaseFunction::new(cosines, second_weight, rayleigh);
        let [g, second_anisotropy] = cosines;
        let with_phase =
            |fog: HomogeneousMedium| HomogeneousMedium { second_anisotropy, second_weight, rayleigh, ..fog };
        for light_sampling in [LightSampling::Both, LightSampling::Light] {
            // Unbounded fog, coloured.
            let desc = along(PathDesc { light_sampling, ..once.clone() })
                .lit(lamp(v(1.0, 0.0, 4.0), 10.0))
                .in_fog(with_phase(foggy(bands([0.1, 0.3, 0.05]), bands([0.9, 0.5, 1.0]), g)));
            let at = |sigma, albedo| single_scattering(150.0, sigma, albedo, phase, [6.0, 1.0], 10.0);
            mean(samples, desc).is([at(0.1, 0.9), at(0.3, 0.5), at(0.05, 1.0)], 0.02);
        }
        // In a box from z = 1 to z = 9 with the light inside, also with the direct integrator.
        for integrator in [IntegratorDesc::Path(once.clone()), IntegratorDesc::Direct(DirectDesc::default())]
        {
            let desc =
                scene(integrator).seen_from_front(10.0, 0.001).lit(lamp(v(0.0, 2.0, 3.0), 10.0)).filled(
                    cuboid(v(-50.0, -50.0, -1e3), v(50.0, 50.0, 11.0)),
                    with_phase(foggy(even(0.2), even(0.5), g)),
                );
            mean(samples, desc).is_grey(single_scattering(120.0, 0.2, 0.5, phase, [7.0, 2.0], 10.0), 0.02);
        }
    }
}

/// A ball of such a material in front of the camera.
fn ball(solid: fn(&mut SceneDesc) -> MaterialId) -> SceneDesc {
    let mut desc = path(PathDesc { rr_start: Some(100), ..deep() }).seen_from_front(4.0, 20.0);
    let material = solid(&mut desc);
    desc.with_shared(sphere(DVec3::ZERO, 1.0), material)
}

/// Adds a surrounding sphere with emission 1.
fn in_a_furnace(desc: SceneDesc) -> SceneDesc {
    desc.with(sphere(DVec3::ZERO, 20.0), glow())
}

/// Glass with an interior medium.
fn glass(desc: &mut SceneDesc, medium: HomogeneousMedium) -> MaterialId {
    let interior = desc.medium(medium);
    desc.material(DielectricMaterial { interior, ..DielectricMaterial::default() }.into())
}

/// White furnace: with emission 1 all around and no absorption, everything is 1.
#[test]
fn a_furnace_with_media_stays_even() {
    let solids: [fn(&mut SceneDesc) -> MaterialId; 6] = [
        |desc| desc.boundary(scattering(even(2.0), 0.0)),
        |desc| desc.boundary(scattering(bands([0.5, 1.0, 3.0]), 0.6)),
        |desc| desc.boundary(scattering(even(1.0), -0.5)),
        |desc| {
            let scattering = bands([4.0, 8.0, 12.0]);
            desc.boundary(SmokeMedium { scattering, resolution: 32, anisotropy: 0.4, ..Default::default() })
        },
        |desc| glass(desc, scattering(even(1.5), 0.0)),
        |desc| {
            let interior = desc.medium(scattering(even(1.5), 0.3));
            let (transmission_weight, specular_roughness) = (grey(1.0), grey(0.4));
            let rough = PrincipledMaterial {
                interior,
                transmission_weight,
                specular_roughness,
                ..Default::default()
            };
            desc.material(rough.into())
        },
    ];
    for (i, solid) in solids.into_iter().enumerate() {
        // The background is found by escaped rays only, an emissive sphere also by light sampling.
        for around in [|desc: SceneDesc| desc.before(1.0), in_a_furnace] {
            let m = mean(256, around(ball(solid)));
            // Rough glass loses a little energy itself (single scattering between microfacets).
            let slack = if i == 5 { 0.01 } else { 1e-3 };
            for (v, e) in m.value().into_iter().zip(m.error()) {
                assert!(e < 6e-3, "{i}: {m:?}");
                assert!((v - 1.0).abs() < slack + 4.0 * e, "{i}: {:?} ± {:?}", m.value(), m.error());
            }
        }
    }
}

#[test]
fn an_emissive_medium_absorbs_its_own_emission() {
    let emission = Spectrum::new(1.0, 2.0, 3.0);
    let emissive = HomogeneousMedium { emission, ..absorbing(bands([0.5, 0.0, 2.0])) };
    let of = |sigma: f64, emission: f64| emission * (1.0 - (-2.0 * sigma).exp()) / sigma;
    mean(2, along(deep()).filled(slab(), emissive)).is([of(0.5, 1.0), 4.0, of(2.0, 3.0)], 1e-6);
}

/// A medium whose emission balances its absorption is a furnace too: each point emits as much as it absorbs. In glass
/// radiance is larger by the square of the index.
#[test]
fn emission_balances_absorption() {
    fn balanced() -> HomogeneousMedium {
        HomogeneousMedium { emission: Spectrum::new(0.5, 1.0, 3.0), ..absorbing(bands([0.5, 1.0, 3.0])) }
    }
    let solids: [fn(&mut SceneDesc) -> MaterialId; 4] = [
        |desc| desc.boundary(balanced()),
        |desc| {
            let scattering = bands([2.0, 1.0, 0.5]);
            desc.boundary(HomogeneousMedium { scattering, anisotropy: 0.5, ..balanced() })
        },
        |desc| {
            desc.boundary(SmokeMedium {
                absorption: bands([2.0, 4.0, 1.0]),
                emission: Spectrum::new(2.0, 4.0, 1.0),
                scattering: even(3.0),
                resolution: 24,
                ..SmokeMedium::default()
            })
        },
        |desc| {
            let emission = Spectrum::new(1.125, 2.25, 6.75);
            glass(desc, HomogeneousMedium { emission, scattering: even(1.0), ..balanced() })
        },
    ];
    for (i, solid) in solids.into_iter().enumerate() {
        let m = mean(512, in_a_furnace(ball(solid)));
        for (v, e) in m.value().into_iter().zip(m.error()) {
            // Without scattering the result has no noise.
            assert!(if i == 0 { e < 1e-6 } else { e < 3e-3 }, "{i}: {m:?}");
            assert!((v - 1.0).abs() < 1e-3 + 4.0 * e, "{i}: {:?} ± {:?}", m.value(), m.error());
        }
    }
}

/// Light between two squares through a plate of rough glass with a scattering interior is the same in both directions.
#[test]
fn scattering_glass_is_reciprocal() {
    let power = |from: (f64, [f64; 2]), to: (f64, [f64; 2]), front: f64| {
        let square = |(side, [x, y]): (f64, [f64; 2]), z: f64| {
            rectangle(v(x, y, z), v(side, 0.0, 0.0), v(0.0, side, 0.0))
        };
        let ([x, y], view) = (to.1, 1.5 * to.0);
        let camera = OrthographicDesc {
            position: v(x, y, 0.7 * front),
            look_at: v(x, y, 1.5 * front),
            viewport: Viewport::Height(view),
            ..OrthographicDesc::default()
        };
        let settings =
            PathDesc { max_depth: 200, max_diffuse: Some(1), rr_start: Some(20), ..PathDesc::default() };
        let mut desc = path(settings)
            .seen(camera)
            .with(square(from, -1.5 * front), glow())
            .with(square(to, 1.5 * front), matte(grey(0.9)));
        let medium = HomogeneousMedium { absorption: even(0.1), ..scattering(bands([2.0, 1.0, 4.0]), 0.3) };
        let interior = desc.medium(medium);
        let plate = DielectricMaterial { roughness: grey(0.4), interior, ..DielectricMaterial::default() };
        let m = mean(1024, desc.with(cuboid(v(-4.0, -4.0, -0.2), v(4.0, 4.0, 0.2)), plate));
        [0, 1, 2].map(|band| (m.value()[band] * view * view, m.error()[band] * view * view))
    };
    let (one, other) = ((2.0, [0.4, 0.0]), (1.2, [-0.3, 0.5]));
    let (there, back) = (power(one, other, 1.0), power(other, one, -1.0));
    for ((a, ea), (b, eb)) in there.into_iter().zip(back) {
        let error = f64::hypot(ea, eb);
        assert!(error < 0.03 * a && (a - b).abs() < 4.5 * error, "{there:?} {back:?}");
    }
}

/// Area lights in media are found by three strategies; each setting gives the same result.
#[test]
fn light_sampling_strategies_agree_in_media() {
    let found = |light_sampling| -> Mean {
        let desc = path(PathDesc { max_depth: 6, light_sampling, ..PathDesc::default() })
            .seen_at(v(0.0, 1.0, 5.0), v(0.0, 1.0, 0.0), 50.0)
            .with(plane(), matte(grey(0.8)))
            .with(sphere(v(1.0, 2.0, 0.0), 0.7), emissive(5.0, grey(1.0)))
            .filled(sphere(v(-1.0, 1.0, 0.0), 1.0), scattering(bands([2.0, 3.0, 1.0]), 0.8))
            .in_fog(HomogeneousMedium { absorption: even(0.02), ..scattering(bands([0.1, 0.2, 0.3]), 0.4) });
        mean_of(8, 256, desc)
    };
    let [both, bsdf, light] = STRATEGIES.map(found);
    both.agrees(&bsdf, 0.02);
    both.agrees(&light, 0.02);
}

/// A medium may be divided by further boundaries without a change.
#[test]
fn a_medium_in_two_parts_is_one() {
    let seen = |parts: &[[DVec3; 2]]| {
        let mut desc = path(deep())
            .seen_at(v(0.0, 1.0, 5.0), DVec3::ZERO, 40.0)
            .before_color([0.1, 0.2, 0.3])
            .lit(lamp(v(2.0, 3.0, 1.0), 20.0));
        let milk = HomogeneousMedium { absorption: even(0.1), ..scattering(bands([1.0, 2.0, 3.0]), 0.0) };
        let interior = desc.medium(milk);
        for [min, max] in parts {
            desc = desc.with(cuboid(*min, *max), InterfaceMaterial { interior });
        }
        mean_of(8, 256, desc)
    };
    let whole = [DVec3::NEG_ONE, DVec3::ONE];
    let part = [v(-0.5, -0.7, -0.6), v(0.8, 0.3, 0.9)];
    seen(&[whole]).agrees(&seen(&[part, whole]), 0.02);
}

/// Reciprocity: exchange a small light and the camera. The radiance of a matte disk that both see through a cloud is
/// the same per irradiance.
#[test]
fn a_scattering_slab_is_reciprocal() {
    // Both are at distance 5 from the origin; the irradiance contains the light's cosine at the floor.
    let seen = |eye: DVec3, at: DVec3| {
        let place = DiskDesc { radius: 0.01, ..DiskDesc::default() };
        let desc = path(deep())
            .seen_at(eye, DVec3::ZERO, 0.001)
            .lit(lamp(at, 100.0))
            .with(ShapeDesc::Disk(place), matte(grey(0.5)))
            .filled(cuboid(v(-9.0, 1.0, -9.0), v(9.0, 2.0, 9.0)), absorbing(bands([0.3, 0.1, 0.7])));
        mean(2, desc).value()
    };
    let (one, other) = (v(0.0, 4.0, 3.0), v(0.0, 3.0, -4.0));
    let (there, back) = (seen(one, other), seen(other, one));
    for band in 0..3 {
        assert!(there[band] > 0.0);
        assert!((there[band] / 3.0 - back[band] / 4.0).abs() < 1e-5 * there[band], "{there:?} {back:?}");
    }
}

/// An emissive scattering ball, one of smoke, and one of glass with an interior medium, in fog.
fn cloudy() -> SceneDesc {
    let at = v(-1.5, 0.6, 0.5);
    let smoke = SmokeMedium {
        center: at,
        radius: 0.6,
        scattering: even(6.0),
        emission: Spectrum::new(0.2, 0.1, 0.0),
        resolution: 20,
        ..SmokeMedium::default()
    };
    let emissive_medium =
        HomogeneousMedium { emission: Spectrum::grey(0.1), ..scattering(bands([2.0, 3.0, 1.0]), 0.0) };
    let mut desc = path(PathDesc { max_depth: 12, ..PathDesc::default() })
        .seen_at(v(0.0, 1.0, 5.0), v(0.0, 1.0, 0.0), 40.0)
        .filmed([37, 29], 6)
        .lit(lamp(v(2.0, 3.0, 1.0), 20.0))
        .with(plane(), matte(grey(0.8)))
        .filled(sphere(v(0.0, 1.0, 0.0), 1.0), emissive_medium)
        .filled(sphere(at, 0.6), smoke);
    let full = glass(&mut desc, scattering(even(3.0), 0.0));
    desc.with_shared(sphere(v(1.5, 0.5, 1.0), 0.5), full).in_fog(foggy(even(0.1), even(0.8), 0.3))
}

#[test]
fn threads_and_passes_change_nothing() {
    let desc = cloudy();
    let (reference, _) = render_with(&desc, 1, u32::MAX);
    for (threads, pass) in [(2, u32::MAX), (3, 1), (1, 4)] {
        assert!(
            render_with(&desc, threads, pass).0.linear == reference.linear,
            "{threads} threads, {pass} samples a pass"
        );
    }
}

/// Integrators without media see neither media nor their interfaces.
#[test]
fn other_integrators_see_no_boundaries() {
    for integrator in [
        IntegratorDesc::Classic(Default::default()),
        IntegratorDesc::Normals(NormalsDesc::default()),
        IntegratorDesc::Depth(DepthDesc::default()),
    ] {
        let with = SceneDesc { integrator, ..cloudy() };
        let mut without = with.clone();
        without.objects.drain(1..3);
        assert!(
            render_with(&with, 2, u32::MAX).0.linear == render_with(&without, 2, u32::MAX).0.linear,
            "{}",
            with.integrator.type_name()
        );
    }
}

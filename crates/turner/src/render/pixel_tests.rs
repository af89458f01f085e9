//! Sampling of pixels: filters, cameras, clamped samples.
#![allow(
    clippy::disallowed_methods,
    reason = "expected values are independent of the renderer's own functions"
)]

use super::pixel as explain;
use crate::camera::{CameraDesc, EquirectangularDesc, FisheyeDesc, OrthographicDesc, Viewport};
use crate::color::Spectrum;
use crate::description::{ObjectDesc, SceneDesc};
use crate::film::{Antialias, FilmDesc};
use crate::filter::FilterKind;
use crate::integrator::{ClassicDesc, DirectDesc, IntegratorDesc, NormalsDesc, PathDesc};
use crate::light::{AmbientDesc, EnvironmentDesc, LightDesc, PointDesc};
use crate::material::{ClassicMaterial, MaterialDesc};
use crate::math::{DVec2, DVec3};
use crate::schema::PrepareOptions;
use crate::shape::{BoxDesc, ShapeDesc};
use crate::testing::scenes::{called, emissive, grey, path, pixel, rectangle, render, rgb, scene, sphere, v};

fn by_paths() -> IntegratorDesc {
    IntegratorDesc::Path(PathDesc::default())
}

fn directly() -> IntegratorDesc {
    IntegratorDesc::Direct(DirectDesc::default())
}

fn classically() -> IntegratorDesc {
    IntegratorDesc::Classic(ClassicDesc::default())
}

fn by_normals() -> IntegratorDesc {
    IntegratorDesc::Normals(NormalsDesc::default())
}

/// Pixels of one unit, seen from above; everything to the right of `from` has one material.
fn half(integrator: IntegratorDesc, from: f64, material: impl Into<MaterialDesc>) -> SceneDesc {
    let camera = OrthographicDesc {
        position: v(0.0, 1.0, 0.0),
        up: v(0.0, 0.0, -1.0),
        viewport: Viewport::Size(DVec2::new(12.0, 4.0)),
        ..OrthographicDesc::default()
    };
    let surface = rectangle(v(from + 50.0, 0.0, 0.0), v(100.0, 0.0, 0.0), v(0.0, 0.0, -100.0));
    scene(integrator).seen(camera).sized([12, 4]).with(surface, material)
}

/// One row of pixels; the right half of the image is an emitter.
fn edge(filter: FilterKind, filter_radius: Option<f64>, integrator: IntegratorDesc) -> Vec<f64> {
    let material: MaterialDesc = match integrator {
        IntegratorDesc::Classic(_) => {
            ClassicMaterial { color: grey(1.0), ka: 1.0, kd: 0.0, ..ClassicMaterial::default() }.into()
        }
        _ => emissive(1.0, grey(1.0)).into(),
    };
    let ambient = AmbientDesc { intensity: 1.0, ..AmbientDesc::default() };
    let mut desc = half(integrator, 0.0, material).filmed([12, 4], 4096).lit(LightDesc::Ambient(ambient));
    (desc.film.filter, desc.film.filter_radius) = (filter, filter_radius);
    let picture = render(&desc).0;
    (0..12).map(|x| f64::from(pixel(&picture, x, 1)[0])).collect()
}

/// The fraction of the filter f, even and 0 beyond r, that lies beyond `from`, by Simpson's rule.
fn fraction_beyond(f: impl Fn(f64) -> f64, r: f64, from: f64) -> f64 {
    let integral = |from: f64, to: f64| {
        let (n, h) = (2000, (to - from) / 2000.0);
        let inner: f64 = (1..n).map(|i| f(from + h * f64::from(i)) * f64::from(2 + 2 * (i % 2))).sum();
        (f(from) + f(to) + inner) * h / 3.0
    };
    integral(from.clamp(-r, r), r) / integral(-r, r)
}

#[test]
fn an_edge_shows_the_filter() {
    use std::f64::consts::PI;
    type Profile = fn(f64) -> f64;
    let blackman = |x: f64| {
        let c = |n: f64| (n * PI * x / 1.5).cos();
        0.35875 + 0.48829 * c(1.0) + 0.14128 * c(2.0) + 0.01168 * c(3.0)
    };
    let FilmDesc { filter: without, .. } = FilmDesc::default();
    let cases: [(FilterKind, Option<f64>, f64, Profile); 6] = [
        (without, None, 0.5, |_| 1.0),
        (FilterKind::Box, Some(2.25), 2.25, |_| 1.0),
        (FilterKind::Tent, None, 1.0, |x| 1.0 - x.abs()),
        (FilterKind::Gaussian, None, 1.5, |x| (-2.0 * x * x).exp() - (-4.5f64).exp()),
        (FilterKind::Gaussian, Some(3.0), 3.0, |x| (-0.5 * x * x).exp() - (-4.5f64).exp()),
        (FilterKind::BlackmanHarris, None, 1.5, blackman),
    ];
    for (filter, radius, r, f) in cases {
        for (integrator, tolerance) in [(by_paths(), 1.5e-3), (directly(), 1.5e-3), (classically(), 8e-3)] {
            let name = integrator.type_name();
            for (x, value) in edge(filter, radius, integrator).into_iter().enumerate() {
                // The distance of the edge from the pixel centre.
                let expected = fraction_beyond(f, r, 5.5 - x as f64);
                let near = (value - expected).abs() < tolerance;
                assert!(near, "{name} {filter:?} {radius:?} {x}: {value}, not {expected}");
            }
        }
    }
}

#[test]
fn the_default_filter_is_the_box() {
    let FilmDesc { filter, filter_radius, .. } = FilmDesc::default();
    for integrator in [by_paths(), classically()] {
        let plain = edge(filter, filter_radius, integrator.clone());
        assert_eq!(plain, edge(FilterKind::Box, Some(0.5), integrator));
    }
}

#[test]
fn a_white_picture_stays_white_under_every_filter() {
    for filter in [FilterKind::Box, FilterKind::Tent, FilterKind::Gaussian, FilterKind::BlackmanHarris] {
        let mut desc = path(PathDesc::default()).before_color([1.0, 0.5, 0.25]).filmed([7, 5], 7);
        (desc.film.filter, desc.film.filter_radius) = (filter, Some(4.0));
        assert!(render(&desc).0.linear.iter().all(|p| *p == [1.0, 0.5, 0.25, 1.0]), "{filter:?}");
    }
}

/// A panorama inside an environment equals the environment map.
#[test]
fn a_panorama_of_the_studio_is_the_studio() {
    let (position, look_at) = (v(3.0, 1.0, 2.0), v(3.0, 1.0, 1.0));
    let studio = EnvironmentDesc::studio();
    let around = |camera: CameraDesc, integrator: &IntegratorDesc| {
        scene(integrator.clone()).seen(camera).sized([64, 32]).lit(LightDesc::Environment(studio.clone()))
    };
    let panorama = EquirectangularDesc { position, look_at, ..EquirectangularDesc::default() };
    let fisheye = FisheyeDesc { position, look_at, ..FisheyeDesc::default() };
    let prepared = studio.prepare(&[], false).unwrap();
    for integrator in [by_paths(), directly(), classically(), by_normals()] {
        let picture = render(&around(panorama.clone().into(), &integrator)).0;
        for (x, y) in (0..32).flat_map(|y| (0..64).map(move |x| (x, y))) {
            let (lon, lat) = ((f64::from(x) - 31.5) / 32.0 * 180.0, (15.5 - f64::from(y)) / 16.0 * 90.0);
            let ((sin, cos), (up, flat)) = (lon.to_radians().sin_cos(), lat.to_radians().sin_cos());
            let expected = prepared.radiance(v(sin * flat, up, -cos * flat));
            let found = pixel(&picture, x, y);
            let near = (found[1] - expected.g).abs() < 1e-5 * (1.0 + expected.g);
            assert!(near, "{x} {y}: {found:?} {expected:?}");
        }
        // A fisheye shows the same in its circle, and black outside.
        let picture = render(&around(fisheye.clone().into(), &integrator)).0;
        let front = prepared.radiance(v(0.02, 0.02, -1.0));
        assert!((pixel(&picture, 32, 15)[0] - front.g).abs() < 0.05, "{:?}", pixel(&picture, 32, 15));
        for (x, y) in [(0, 0), (14, 15), (49, 15), (32 + 12, 3)] {
            assert_eq!(pixel(&picture, x, y), [0.0; 3], "{}", integrator.type_name());
            assert_eq!(picture.linear[(y * 64 + x) as usize][3], 1.0);
        }
    }
    let mut desc = around(fisheye.into(), &by_paths());
    desc.background.transparent = true;
    assert!(render(&desc).0.linear.iter().all(|p| p[3] == 0.0));
}

/// Pixels without a camera ray hit nothing in any scene.
#[test]
fn nothing_is_hit_beyond_the_circle_of_a_fisheye() {
    for integrator in [by_paths(), classically(), by_normals()] {
        let name = integrator.type_name();
        let camera = FisheyeDesc {
            position: DVec3::ZERO,
            look_at: DVec3::NEG_Z,
            fov: 360.0,
            ..FisheyeDesc::default()
        };
        let light = PointDesc { position: v(0.0, 0.0, 0.5), ..PointDesc::default() };
        let walls = BoxDesc { size: Some(DVec3::splat(2.0)), ..BoxDesc::default() };
        let white = ClassicMaterial { color: called("white"), ..ClassicMaterial::default() };
        let mut desc = scene(integrator)
            .seen(camera)
            .filmed([24, 24], 2)
            .lit(LightDesc::Point(light))
            .with(ShapeDesc::Box(walls), white);
        let ball = ObjectDesc::new(sphere(v(0.0, 0.0, -0.5), 0.1));
        desc.objects.extend(std::iter::repeat_n(ball, 9));
        let picture = render(&desc).0;
        assert_eq!(pixel(&picture, 0, 0), [0.0; 3]);
        for (x, y) in [(12, 12), (1, 12), (12, 22)] {
            assert!(pixel(&picture, x, y)[0] > 0.0, "{name} {x} {y}");
        }
    }
}

#[test]
fn samples_are_clamped_where_the_film_says_so() {
    let lit = half(by_paths(), 0.25, emissive(20.0, rgb([1.0, 0.5, 0.0]))).before_color([1.0, 2.0, 3.0]);
    for antialias in
        [Antialias::None, Antialias::Mean, Antialias::Grid, Antialias::Adaptive, Antialias::MonteCarlo]
    {
        let name = antialias.word();
        let clamped = |clamp_sample: f64| {
            let film = FilmDesc { antialias, samples: 64, clamp_sample, ..lit.film.clone() };
            SceneDesc { film, ..lit.clone() }
        };
        let at = |most: f64, x: u32| pixel(&render(&clamped(most)).0, x, 1);
        assert_eq!(at(0.0, 10), [20.0, 10.0, 0.0], "{name}");
        // The background is not brighter than the limit and stays.
        for (x, expected) in [(2, [1.0, 2.0, 3.0]), (10, [4.0, 2.0, 0.0])] {
            assert_eq!(at(4.0, x), expected, "{name} {x}");
        }
        // Samples are clamped, not pixels: red is below 4, and above the value that clamping the pixel's mean
        // would give.
        let [r, g, b] = at(4.0, 6);
        let weight = f64::from(r - 1.0) / 3.0;
        let mixed = [1.0 + 3.0 * weight, 2.0, 3.0 - 3.0 * weight];
        let found = [r, g, b].map(f64::from);
        let near = found.iter().zip(mixed).all(|(v, e)| (v - e).abs() < 1e-5);
        assert!(near, "{name}: {found:?}, {mixed:?}");
        let record = explain(&clamped(4.0).prepare(&PrepareOptions::default()).unwrap(), 6, 1).unwrap();
        let sum = |c: fn(&Spectrum) -> f32| -> f64 {
            record.samples.iter().map(|s| s.weight * f64::from(c(&s.radiance.color))).sum()
        };
        for (sum, value) in [sum(|c| c.r), sum(|c| c.g), sum(|c| c.b)].into_iter().zip(record.color) {
            assert!((sum - f64::from(value)).abs() < 1e-5, "{name}: {sum}, {value}");
        }
    }
}

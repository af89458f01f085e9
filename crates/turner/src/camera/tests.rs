//! Tests of the cameras' ray directions.

use std::f64::consts::{FRAC_PI_2, PI};

use turner_bvh::InstructionSet;
use turner_bvh::lanes::{Block, LANES};

use super::*;
use crate::math::elementary::{atan2, cos};

/// Looks along −z from above the origin, x to the right.
fn panorama() -> Camera {
    let desc = EquirectangularDesc {
        position: DVec3::new(0.0, 2.0, 0.0),
        look_at: DVec3::new(0.0, 2.0, -3.0),
        near: 0.25,
        ..EquirectangularDesc::default()
    };
    CameraDesc::Equirectangular(desc).prepare(2.0).unwrap()
}

fn fisheye(angle: f64, aspect: f64) -> Camera {
    let desc =
        FisheyeDesc { position: DVec3::ZERO, look_at: DVec3::NEG_Z, fov: angle, ..FisheyeDesc::default() };
    CameraDesc::Fisheye(desc).prepare(aspect).unwrap()
}

fn direction_at(camera: &Camera, x: f64, y: f64) -> DVec3 {
    camera.ray(DVec2::new(x, y), DVec2::ZERO).direction
}

/// The solid angle of a small square of the screen around a position, divided by its area.
fn solid_angle(camera: &Camera, at: DVec2) -> f64 {
    let e = 1e-4;
    let d = |x: f64, y: f64| direction_at(camera, at.x + x, at.y + y);
    (d(e, 0.0) - d(-e, 0.0)).cross(d(0.0, e) - d(0.0, -e)).length() / (4.0 * e * e)
}

#[test]
fn a_panorama_shows_everything_once() {
    let camera = panorama();
    let ray = camera.ray(DVec2::ZERO, DVec2::ZERO);
    assert_eq!((ray.origin, ray.t_min), (DVec3::new(0.0, 2.0, 0.0), 0.25));
    for (x, y, expected) in [
        (0.0, 0.0, DVec3::NEG_Z),
        (0.5, 0.0, DVec3::X),
        (-0.5, 0.0, DVec3::NEG_X),
        (1.0, 0.0, DVec3::Z),
        (-1.0, 0.0, DVec3::Z),
        (0.3, 1.0, DVec3::Y),
        (-0.8, -1.0, DVec3::NEG_Y),
        (0.0, 0.5, DVec3::new(0.0, 1.0, -1.0).normalize()),
    ] {
        assert!((direction_at(&camera, x, y) - expected).length() < 1e-15, "{x} {y}");
    }
    // dω = cos(latitude) dlat dlon: π²/2 · cos over the square screen.
    for (x, y) in [(0.1, 0.2), (-0.7, 0.0), (0.9, -0.8)] {
        let expected = PI * PI / 2.0 * cos(FRAC_PI_2 * y);
        let found = solid_angle(&camera, DVec2::new(x, y));
        assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
    }
}

#[test]
fn a_fisheye_keeps_angles_from_its_axis() {
    for (angle, aspect) in [(180.0, 1.0), (90.0, 1.5), (360.0, 0.5), (1e-3, 1.0)] {
        let camera = fisheye(angle, aspect);
        let nearer = DVec2::new(1.0 / aspect.max(1.0), aspect.min(1.0));
        for i in 0..=20 {
            let fraction = f64::from(i) / 20.0;
            for side in [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y] {
                let at = side * nearer * fraction * (1.0 - 1e-12);
                let d = direction_at(&camera, at.x, at.y);
                assert!((d.length() - 1.0).abs() < 1e-12);
                let from_axis = atan2(d.cross(DVec3::NEG_Z).length(), -d.z);
                let expected = radians(0.5 * angle) * fraction;
                assert!((from_axis - expected).abs() < 1e-7 * (1.0 + expected), "{from_axis} {expected}");
                // On the correct side of the picture.
                let flat = DVec2::new(d.x, d.y);
                assert!(fraction == 0.0 || fraction == 1.0 || flat.normalize().dot(side) > 1.0 - 1e-9);
            }
        }
        // There are no rays outside the circle.
        let rays = [DVec2::new(1.0, 1.0), DVec2::new(-1.0, 1.0)].map(|at| camera.ray(at, DVec2::ZERO));
        assert!(rays.iter().all(|ray| ray.t_max < 0.0 && ray.direction.is_finite()));
        // dω = sin θ dθ dφ; θ = rim · r.
        for r in [0.3, 0.8] {
            let rim = radians(0.5 * angle);
            let expected = rim * sin(rim * r) / r / (nearer.x * nearer.y);
            let found = solid_angle(&camera, DVec2::X * (nearer.x * r));
            assert!((found / expected - 1.0).abs() < 1e-4, "{angle} {found} {expected}");
        }
    }
}

#[test]
fn a_lens_with_blades_is_in_focus_where_a_round_one_is() {
    let desc = |blades| ThinLensDesc {
        position: DVec3::ZERO,
        look_at: DVec3::NEG_Z,
        fov: Some(40.0),
        lens_radius: 0.5,
        blades,
        blade_rotation: 10.0,
        focus_distance: Some(7.0),
        ..ThinLensDesc::default()
    };
    for blades in [0, 3, 6] {
        let camera = CameraDesc::ThinLens(desc(blades)).prepare(1.0).unwrap();
        assert!(camera.has_lens());
        let target = camera.ray(DVec2::new(0.3, -0.2), DVec2::splat(0.5));
        let at_focus = |r: &Ray| r.origin + r.direction * ((-7.0 - r.origin.z) / r.direction.z);
        for i in 0..25 {
            let lens = DVec2::new(f64::from(i % 5) / 5.0, f64::from(i / 5) / 5.0);
            let ray = camera.ray(DVec2::new(0.3, -0.2), lens);
            assert!(ray.origin.length() <= 0.5 + 1e-12 && ray.origin.z == 0.0);
            assert!((at_focus(&ray) - at_focus(&target)).length() < 1e-9);
        }
    }
    assert!(CameraDesc::ThinLens(desc(2)).prepare(1.0).is_err());
}

#[test]
fn a_shifted_screen_shows_the_adjacent_view() {
    let (position, look_at) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.0, 1.0, -4.0));
    let (up, handedness) = (DVec3::Y, Handedness::Right);
    let (fov, viewport, distance, near) = (Some(50.0), None, None, 0.0);
    let with = |shift: DVec2| PinholeDesc {
        motion: None,
        position,
        look_at,
        up,
        handedness,
        fov,
        viewport,
        distance,
        shift,
        near,
        far: None,
    };
    let pinhole = |shift: DVec2| CameraDesc::Pinhole(with(shift)).prepare(1.5).unwrap();
    let lens = |shift: DVec2| {
        let desc = ThinLensDesc {
            position,
            look_at,
            up,
            handedness,
            fov,
            viewport,
            distance,
            shift,
            lens_radius: 0.2,
            focus_distance: Some(3.0),
            near,
            ..ThinLensDesc::default()
        };
        CameraDesc::ThinLens(desc).prepare(1.5).unwrap()
    };
    let shift = DVec2::new(0.5, -0.25);
    for (plain, shifted) in [(pinhole(DVec2::ZERO), pinhole(shift)), (lens(DVec2::ZERO), lens(shift))] {
        for (x, y) in [(0.0, 0.0), (-1.0, 0.5), (0.3, 1.0)] {
            let at = |camera: &Camera, x: f64, y: f64| camera.ray(DVec2::new(x, y), DVec2::new(0.7, 0.2));
            let (a, b) = (at(&shifted, x, y), at(&plain, x + 1.0, y - 0.5));
            assert!((a.direction - b.direction).length() < 1e-12 && a.origin == b.origin, "{a:?} {b:?}");
        }
    }
    // The left edge is the viewing direction.
    let ahead = direction_at(&pinhole(DVec2::new(0.5, 0.0)), -1.0, 0.0).normalize();
    assert!((ahead - (look_at - position).normalize()).length() < 1e-12);
    // Eight rays at a time give the same.
    let film =
        crate::film::FilmDesc { width: 30, height: 20, ..crate::description::SceneDesc::default().film };
    let (mut x, mut y) = (Block([f64::NAN; LANES]), Block([f64::NAN; LANES]));
    (x.0[0], y.0[0], x.0[1], y.0[1]) = (3.5, 17.25, 29.0, 1.0);
    let mut rays = turner_bvh::RayBlock::NOTHING;
    camera_rays(InstructionSet::best(), &pinhole(shift), &film, &x, &y, |_| DVec2::ZERO, &mut rays);
    for lane in 0..2 {
        let at = DVec2::new(2.0 * x.0[lane] / 30.0 - 1.0, 1.0 - 2.0 * y.0[lane] / 20.0);
        let expected = direction_at(&pinhole(shift), at.x, at.y).normalize();
        let found =
            DVec3::new(rays.direction[0].0[lane], rays.direction[1].0[lane], rays.direction[2].0[lane]);
        assert!((found - expected).length() < 1e-12, "{found} {expected}");
    }
    assert!(with(DVec2::new(0.0, 2e3)).prepare(1.0).is_err());
}

//! Cameras and lights that move while the shutter is open.
#![allow(
    clippy::disallowed_methods,
    reason = "expected values are independent of the renderer's own functions"
)]

use crate::camera::{CameraDesc, OrthographicDesc, PinholeDesc, Viewport};
use crate::description::{ObjectDesc, SceneDesc, SceneLight};
use crate::integrator::PathDesc;
use crate::light::{Attenuation, DirectionalDesc, EnvironmentDesc, LightDesc, PointDesc, SpotDesc};
use crate::math::{DAffine3, DVec2, DVec3};
use crate::schema::Transform;
use crate::schema::transform::rotation;
use crate::shape::{BoxDesc, ShapeDesc, SphereDesc};
use crate::testing::scenes::{emissive, grey, matte, path, pixel, rectangle, render, v};

fn shifted(by: DVec3) -> Transform {
    Transform(DAffine3::from_translation(by))
}

/// A strip of 12 pixels of one unit each, seen from above.
fn strip(samples: u32) -> SceneDesc {
    let mut desc = path(PathDesc { max_depth: 1, ..PathDesc::default() }).filmed([12, 4], samples);
    let camera = OrthographicDesc {
        position: v(0.0, 9.0, 0.0),
        up: DVec3::NEG_Z,
        viewport: Viewport::Size(DVec2::new(12.0, 4.0)),
        ..OrthographicDesc::default()
    };
    desc.camera = Some(CameraDesc::Orthographic(camera).into());
    desc
}

fn row(desc: &SceneDesc) -> Vec<f64> {
    let picture = render(desc).0;
    (0..12).map(|x| f64::from(pixel(&picture, x, 1)[0])).collect()
}

/// The mean of `f` over the shutter times `open..close`.
fn mean(open: f64, close: f64, f: impl Fn(f64) -> f64) -> f64 {
    let n = 4000;
    (0..n).map(|i| f(open + (close - open) * (f64::from(i) + 0.5) / f64::from(n))).sum::<f64>() / f64::from(n)
}

#[test]
fn what_a_moving_camera_sees_moves_the_other_way() {
    for shutter @ [open, close] in [[0.0, 1.0], [0.25, 0.5]] {
        let mut desc = strip(4096);
        desc.film.shutter = shutter;
        let bar = rectangle(v(-4.0, 0.0, 0.0), v(2.0, 0.0, 0.0), v(0.0, 0.0, -10.0));
        desc = desc.with_object(ObjectDesc::new(bar), emissive(1.0, grey(1.0)));
        *desc.camera.as_mut().unwrap().value.motion_mut() = Some(shifted(v(-8.0, 0.0, 0.0)));
        for (x, value) in row(&desc).into_iter().enumerate() {
            let left = x as f64 - 6.0;
            let expected = mean(open, close, |t| {
                let edge = -5.0 + 8.0 * t;
                ((left + 1.0).min(edge + 2.0) - left.max(edge)).max(0.0)
            });
            assert!((value - expected).abs() < 0.01, "{open} to {close}, {x}: {value}, not {expected}");
        }
    }
}

#[test]
fn turning_the_camera_is_turning_the_world() {
    // A camera that turns about its axis of view sees what it sees if the object turns the other way.
    let turn = |degrees| Transform(DAffine3::from_mat3(rotation(DVec3::Z, degrees)));
    let seen = |of_camera: Option<Transform>, of_object: Option<Transform>, shutter: [f64; 2]| {
        let mut desc = path(PathDesc::default()).filmed([24, 24], 1024);
        desc.film.shutter = shutter;
        let camera = PinholeDesc { motion: of_camera, ..PinholeDesc::default() };
        desc.camera = Some(CameraDesc::Pinhole(camera).into());
        let bar = ShapeDesc::Box(BoxDesc { size: Some(v(2.5, 0.4, 0.1)), ..BoxDesc::default() });
        let object = ObjectDesc { motion: of_object, ..ObjectDesc::new(bar) };
        render(&desc.with_object(object, emissive(1.0, grey(1.0)))).0
    };
    for shutter in [[0.0, 1.0], [0.3, 0.3]] {
        let a = seen(Some(turn(-60.0)), None, shutter);
        let b = seen(None, Some(turn(60.0)), shutter);
        let lit = b.linear.iter().filter(|c| c[0] > 0.01).count();
        assert!(lit > 20, "{lit}");
        for (i, (a, b)) in a.linear.iter().zip(&b.linear).enumerate() {
            assert!((a[0] - b[0]).abs() < 0.03, "{shutter:?}, pixel {i}: {a:?} {b:?}");
        }
    }
}

/// A black-walled strip of floor lit by `lights`, with black objects in the air; `at(x, t)` is the radiance of the floor at
/// x, y and a time.
fn check_floor(lights: Vec<SceneLight>, objects: &[ObjectDesc], at: impl Fn(f64, f64, f64) -> f64) {
    let floor = rectangle(DVec3::ZERO, v(40.0, 0.0, 0.0), v(0.0, 0.0, -40.0));
    let mut desc = strip(1 << 15).with_object(ObjectDesc::new(floor), matte(grey(1.0)));
    for object in objects {
        desc = desc.with_object(object.clone(), matte(grey(0.0)));
    }
    desc.lights.extend(lights);
    let seen = row(&desc);
    for (x, value) in seen.iter().copied().enumerate() {
        // Row 1 of 4 lies between z = −1 and 0.
        let n = 12;
        let places = (0..n * n).map(|i| [i % n, i / n].map(|k| (f64::from(k) + 0.5) / f64::from(n)));
        let sum: f64 = places.map(|[a, b]| mean(0.0, 1.0, |t| at(x as f64 - 6.0 + a, b - 1.0, t))).sum();
        let expected = sum / f64::from(n * n);
        assert!((value - expected).abs() < 0.03 * expected + 0.003, "{x}: {value}, not {expected}: {seen:?}");
    }
}

const ATTENUATION: Attenuation = Attenuation { coefficients: [0.0, 0.0, 1.0] };

fn lamp(from: DVec3, to: DVec3) -> SceneLight {
    let point =
        PointDesc { position: from, intensity: 20.0, attenuation: ATTENUATION, ..PointDesc::default() };
    SceneLight { motion: Some(shifted(to - from)), ..LightDesc::Point(point).into() }
}

/// The radiance of a white floor at (x, 0, z) under a lamp of intensity 20 at a point.
fn lit(x: f64, z: f64, lamp: DVec3) -> f64 {
    let d = lamp - v(x, 0.0, z);
    20.0 * d.y / d.length().powi(3) / std::f64::consts::PI
}

#[test]
fn moving_lamps_light_where_they_are() {
    // One lamp, and two that a light tree chooses from.
    let ends = [(v(-4.0, 1.0, 0.0), v(4.0, 1.0, 0.0)), (v(0.0, 2.0, -3.0), v(3.0, 1.5, 2.0))];
    for count in 1..=2 {
        let lamps = ends[..count].iter().map(|(a, b)| lamp(*a, *b)).collect();
        check_floor(lamps, &[], |x, z, t| {
            ends[..count].iter().map(|(a, b)| lit(x, z, a.lerp(*b, t))).sum::<f64>()
        });
    }
}

#[test]
fn a_lamp_and_its_shade_move_together() {
    // A shade below the lamp keeps the floor dark within 2 units of the foot of the lamp at any time.
    let (from, to) = (v(-4.0, 2.0, 0.0), v(4.0, 2.0, 0.0));
    let shade = ShapeDesc::Sphere(SphereDesc { center: v(0.0, 1.0, 0.0), radius: 0.5f64.sqrt() });
    let at = |x: f64| Transform(DAffine3::from_translation(v(x, 0.0, 0.0)));
    let shade = ObjectDesc { transform: at(-4.0), motion: Some(at(4.0)), ..ObjectDesc::new(shade) };
    check_floor(vec![lamp(from, to)], &[shade], |x, z, t| {
        let lamp = from.lerp(to, t);
        // The cone from the lamp that touches the sphere has an angle of 45 degrees.
        let from_foot = (x - lamp.x).hypot(z - lamp.z);
        if from_foot < 2.0 { 0.0 } else { lit(x, z, lamp) }
    });
}

#[test]
fn spots_and_suns_turn() {
    // A spot that turns by 90 degrees about z, from pointing to −x to pointing down.
    let spot = SpotDesc {
        position: v(0.0, 1.0, 0.0),
        look_at: v(-1.0, 0.0, 0.0),
        angle: 10.0,
        penumbra: 0.0,
        intensity: 20.0,
        attenuation: ATTENUATION,
        ..SpotDesc::default()
    };
    let to = LightDesc::Spot(SpotDesc { look_at: v(1.0, 0.0, 0.0), ..spot.clone() });
    let spot = LightDesc::Spot(spot);
    let motion = spot.motion_to(&to);
    check_floor(vec![SceneLight { motion, ..spot.into() }], &[], |x, z, t| {
        let angle = (-45.0 + 90.0 * t).to_radians();
        let (axis, d) = (v(angle.sin(), -angle.cos(), 0.0), v(x, -1.0, z));
        if axis.dot(d.normalize()) < 10f64.to_radians().cos() { 0.0 } else { lit(x, z, v(0.0, 1.0, 0.0)) }
    });
    let sun =
        |from| LightDesc::Directional(DirectionalDesc { from: Some(from), ..DirectionalDesc::default() });
    let motion = sun(v(-1.0, 1.0, 0.0)).motion_to(&sun(v(1.0, 1.0, 0.0)));
    check_floor(vec![SceneLight { motion, ..sun(v(-1.0, 1.0, 0.0)).into() }], &[], |_, _, t| {
        (-45.0 + 90.0 * t).to_radians().cos() / std::f64::consts::PI
    });
}

#[test]
fn environments_cannot_move() {
    let environment = LightDesc::Environment(EnvironmentDesc::studio());
    let mut desc = strip(1);
    desc.lights.push(SceneLight { motion: Some(shifted(DVec3::X)), ..environment.into() });
    let error = desc.prepare(&Default::default()).err().unwrap();
    assert!(error.message.contains("cannot move"), "{}", error.message);
}

//! Motion blur.
#![allow(
    clippy::disallowed_methods,
    reason = "expected values are independent of the renderer's own functions"
)]

use std::f64::consts::PI;

use crate::camera::{CameraDesc, OrthographicDesc, PinholeDesc, Viewport};
use crate::description::{GroupDesc, ObjectContent, ObjectDesc, SceneDesc};
use crate::integrator::PathDesc;
use crate::light::{DirectionalDesc, LightDesc, PointDesc, SkyDesc};
use crate::material::PrincipledMaterial;
use crate::math::{DAffine3, DVec2, DVec3};
use crate::schema::transform::rotation;
use crate::schema::{GroupId, MeshData, Transform};
use crate::shape::{BoxDesc, PlaneDesc, ShapeDesc, SphereDesc};
use crate::testing::scenes::{
    emissive, grey, matte, mean, path, pixel, plane, rectangle, render, render_with, v,
};

/// The default shutter interval.
const OPEN: [f64; 2] = [0.0, 1.0];

fn moved(x: f64, y: f64) -> Transform {
    Transform(DAffine3::from_translation(v(x, y, 0.0)))
}

/// Rotated about an axis, then moved.
fn rotated_then_moved(axis: DVec3, degrees: f64, to: [f64; 2]) -> Transform {
    Transform(moved(to[0], to[1]).0 * DAffine3::from_mat3(rotation(axis, degrees)))
}

fn sized(x: f64, y: f64, z: f64) -> ShapeDesc {
    ShapeDesc::Box(BoxDesc { size: Some(v(x, y, z)), ..BoxDesc::default() })
}

fn triangles(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> MeshData {
    MeshData { positions: positions.into(), triangles: triangles.into(), ..MeshData::default() }
}

/// Moves from −4 to 4 along x.
fn moving_along_x(shape: ShapeDesc) -> ObjectDesc {
    ObjectDesc { transform: moved(-4.0, 0.0), motion: Some(moved(4.0, 0.0)), ..ObjectDesc::new(shape) }
}

/// A strip of pixels of one unit each, seen from above.
fn strip() -> SceneDesc {
    let mut desc = path(PathDesc::default()).filmed([12, 4], 4096);
    let camera = OrthographicDesc {
        position: v(0.0, 5.0, 0.0),
        up: DVec3::NEG_Z,
        viewport: Viewport::Size(DVec2::new(12.0, 4.0)),
        ..OrthographicDesc::default()
    };
    desc.camera = Some(CameraDesc::Orthographic(camera).into());
    desc
}

/// Its pixels with a shutter interval.
fn pixels(mut strip: SceneDesc, shutter: [f64; 2]) -> Vec<f64> {
    strip.film.shutter = shutter;
    let picture = render(&strip).0;
    (0..12).map(|x| f64::from(pixel(&picture, x, 1)[0])).collect()
}

/// The mean over `open..close` of the coverage of pixel `x` by an object two units wide whose left edge is at −5 +
/// 8·time.
fn covered(x: usize, open: f64, close: f64) -> f64 {
    let left = x as f64 - 6.0;
    let n = 4000;
    let share = |i: i32| {
        let edge = -5.0 + 8.0 * (open + (close - open) * (f64::from(i) + 0.5) / f64::from(n));
        ((left + 1.0).min(edge + 2.0) - left.max(edge)).max(0.0)
    };
    (0..n).map(share).sum::<f64>() / f64::from(n)
}

/// Makes a shape for a scene, which may hold its mesh.
type Make = fn(&mut SceneDesc) -> ShapeDesc;

#[test]
fn a_moving_bar_covers_pixels_in_part() {
    let bars: [Make; 3] = [
        |_| rectangle(DVec3::ZERO, v(2.0, 0.0, 0.0), v(0.0, 0.0, -10.0)),
        |_| sized(2.0, 1.0, 10.0),
        |desc| {
            let corners = [[-1.0, 0.0, -5.0], [1.0, 0.0, -5.0], [1.0, 0.0, 5.0], [-1.0, 0.0, 5.0]];
            desc.mesh(triangles(&corners, &[[0, 2, 1], [0, 3, 2]]))
        },
    ];
    let ball: Make = |_| ShapeDesc::Sphere(SphereDesc::default());
    let triangle: Make = |desc| {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        desc.mesh(triangles(&corners, &[[0, 1, 2]]))
    };
    // With other objects: in a sphere culler, in a BVH, beside a static world mesh.
    let others = [(0, ball), (9, ball), (80, ball), (3, triangle)];
    for (which, bar) in bars.into_iter().enumerate() {
        for (n, other) in others {
            for shutter @ [open, close] in [OPEN, [0.25, 0.5]] {
                let mut desc = strip();
                let bar = bar(&mut desc);
                desc = desc.with_object(moving_along_x(bar), emissive(1.0, grey(1.0)));
                for _ in 0..n {
                    let far = ObjectDesc::new(other(&mut desc));
                    desc.objects.push(ObjectDesc { transform: moved(500.0, 0.0), ..far });
                }
                for (x, value) in pixels(desc, shutter).into_iter().enumerate() {
                    let expected = covered(x, open, close);
                    let of = format!("{which} among {n}, {open} to {close}, {x}");
                    assert!((value - expected).abs() < 0.01, "{of}: {value}, not {expected}");
                }
            }
        }
    }
}

#[test]
fn an_instant_shutter_shows_no_motion() {
    let at = |degrees, x| rotated_then_moved(DVec3::Y, degrees, [x, 0.0]);
    let still = |transform| ObjectDesc { transform, ..ObjectDesc::new(sized(2.0, 1.0, 1.0)) };
    let moving = || ObjectDesc { motion: Some(at(90.0, 4.0)), ..still(moved(-4.0, 0.0)) };
    let seen = |object, shutter| pixels(strip().with_object(object, emissive(1.0, grey(1.0))), shutter);
    for (shutter, placement) in
        [([0.0, 0.0], moved(-4.0, 0.0)), ([1.0, 1.0], at(90.0, 4.0)), ([0.5, 0.5], at(45.0, 0.0))]
    {
        for (a, b) in seen(moving(), shutter).into_iter().zip(seen(still(placement), OPEN)) {
            assert!((a - b).abs() < 1e-3, "{shutter:?}: {a} {b}");
        }
    }
    // Classic integrators show the scene at shutter open.
    let classic = |object, shutter| {
        let camera = PinholeDesc { position: v(0.0, 1.0, 9.0), ..PinholeDesc::default() };
        let light = PointDesc { position: v(3.0, 5.0, 5.0), ..PointDesc::default() };
        let mut desc = SceneDesc::default().seen(camera).lit(LightDesc::Point(light));
        (desc.film.width, desc.film.height, desc.film.shutter) = (24, 16, shutter);
        desc.objects.push(object);
        render(&desc).0.linear
    };
    let opening = classic(moving(), OPEN);
    assert!(opening == classic(still(moved(-4.0, 0.0)), OPEN));
    assert!(opening != classic(moving(), [0.5, 1.0]));
}

#[test]
fn shadows_and_mirrors_use_the_time_of_the_ray() {
    let down = || path(PathDesc::default()).seen_down();
    let above = || DirectionalDesc { from: Some(v(0.0, 1.0, 0.0)), ..DirectionalDesc::default() };
    // The blind is between the light and the point for a quarter of the time.
    let blind = ObjectDesc {
        transform: moved(-2.0, 0.0),
        motion: Some(moved(6.0, 0.0)),
        ..ObjectDesc::new(rectangle(v(0.0, 1.0, 0.0), v(2.0, 0.0, 0.0), v(0.0, 0.0, 2.0)))
    };
    let desc = down()
        .lit(LightDesc::Directional(above()))
        .with(plane(), matte(grey(1.0)))
        .with_object(blind, matte(grey(0.0)));
    mean(256, desc).is_grey(0.75 / PI, 0.02);
    // A mirror that rocks from −9 to 9 degrees shows the light above it while it is level enough: within ±6 degrees
    // of reflection.
    let rocks = ObjectDesc {
        transform: rotated_then_moved(DVec3::Z, -9.0, [0.0; 2]),
        motion: Some(rotated_then_moved(DVec3::Z, 9.0, [0.0; 2])),
        ..ObjectDesc::new(rectangle(DVec3::ZERO, v(4.0, 0.0, 0.0), v(0.0, 0.0, -4.0)))
    };
    let mirror = PrincipledMaterial {
        base_metalness: grey(1.0),
        base_color: grey(1.0),
        specular_roughness: grey(0.0),
        ..PrincipledMaterial::default()
    };
    let light = LightDesc::Directional(DirectionalDesc { angle: 12.0, ..above() });
    // Rotated by a, it reflects by 2a: ±3 degrees of ±9.
    let radiance = 1.0 / (PI * 6f64.to_radians().sin().powi(2));
    mean(256, down().lit(light).with_object(rocks, mirror)).is_grey(radiance / 3.0, 0.02);
}

#[test]
fn groups_move_with_what_is_in_them_and_all_bytes_stay() {
    let camera = PinholeDesc { position: v(0.0, 3.0, 9.0), ..PinholeDesc::default() };
    let light = PrincipledMaterial { emission_luminance: 2.0, ..PrincipledMaterial::default() };
    let turning = ObjectDesc {
        motion: Some(rotated_then_moved(DVec3::X, 90.0, [0.0; 2])),
        ..ObjectDesc::new(sized(1.0, 1.0, 1.0))
    };
    let mut desc = path(PathDesc::default())
        .filmed([30, 20], 8)
        .seen(camera)
        .lit(LightDesc::Sky(SkyDesc::default()))
        .with_object(turning, light);
    let ball = ObjectDesc::new(ShapeDesc::Sphere(SphereDesc { center: v(2.0, 0.0, 0.0), radius: 1.0 }));
    let two = GroupDesc {
        objects: [ball].into_iter().chain(desc.objects.drain(..)).collect(),
        ..GroupDesc::default()
    };
    desc.groups.push(two.into());
    desc.objects.push(ObjectDesc {
        content: ObjectContent::Instance(GroupId(0)),
        motion: Some(rotated_then_moved(DVec3::Y, 80.0, [0.0, 1.0])),
        ..ObjectDesc::default()
    });
    let ground = PlaneDesc { point: v(0.0, -1.0, 0.0), ..PlaneDesc::default() };
    desc.objects.push(ObjectDesc::new(ShapeDesc::Plane(ground)));
    let (first, stats) = render_with(&desc, 1, u32::MAX);
    for (threads, pass) in [(2, u32::MAX), (5, 3)] {
        let (again, counted) = render_with(&desc, threads, pass);
        assert!(first.linear == again.linear && stats == counted);
    }
    let mut still = desc.clone();
    for object in still.objects.iter_mut().chain(&mut still.groups[0].value.objects) {
        object.transform = object.motion.take().unwrap_or(object.transform);
    }
    assert!(first.linear != render(&still).0.linear);
}

#[test]
fn motions_that_cannot_be_are_errors() {
    let prepare = |shutter, motion| {
        let mut desc = SceneDesc::default();
        desc.film.shutter = shutter;
        let ball = ObjectDesc::new(ShapeDesc::Sphere(SphereDesc::default()));
        desc.objects.push(ObjectDesc { motion: Some(motion), ..ball });
        desc.prepare(&Default::default()).err().map(|e| e.code.as_str())
    };
    let scaled = |x, y, z| Transform(DAffine3::from_scale(v(x, y, z)));
    assert_eq!(prepare([0.1, 0.9], scaled(2.0, 2.0, 2.0)), None);
    assert_eq!(prepare(OPEN, scaled(-1.0, 1.0, 1.0)), Some("E0301"));
    assert_eq!(prepare([0.6, 0.5], moved(1.0, 0.0)), Some("E0107"));
}

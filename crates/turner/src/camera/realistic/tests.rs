//! Tests of the lens against the equations of thin and thick lenses.

use std::f64::consts::PI;

use super::*;
use crate::camera::{Camera, CameraDesc, ThinLensDesc, Viewport};
use crate::film::FilmDesc;
use crate::math::elementary::{atan2, tan};

/// A lens of 12 mm in front of a film of 24 mm: Müller's fisheye, US patent 4,525,038 as a table of Smith, "Modern Lens
/// Design", scaled.
const FISHEYE: [[f64; 4]; 12] = [
    [30.2249, 0.8335, 1.62, 30.34],
    [11.3931, 7.4136, 1.0, 20.68],
    [75.2019, 1.0654, 1.639, 17.8],
    [8.3349, 11.1549, 1.0, 13.42],
    [9.5882, 2.0054, 1.654, 9.02],
    [43.8677, 5.3895, 1.0, 8.14],
    [0.0, 1.4163, 0.0, 6.08],
    [29.4541, 2.1934, 1.517, 5.96],
    [-5.2265, 0.9714, 1.805, 5.84],
    [-14.2884, 0.0627, 1.0, 5.96],
    [-22.3726, 0.94, 1.673, 5.96],
    [-15.0404, 0.0, 1.0, 6.52],
];

/// At the origin, looking along −z, 3 units in focus.
fn desc() -> RealisticDesc {
    let (position, look_at) = (DVec3::ZERO, DVec3::new(0.0, 0.0, -3.0));
    RealisticDesc { position, look_at, ..RealisticDesc::default() }
}

fn prepared(desc: &RealisticDesc) -> Realistic {
    desc.prepare(1.5).unwrap()
}

/// Points of the unit square, spread evenly.
fn squares(n: u32) -> impl Iterator<Item = DVec2> {
    (0..n).map(move |i| {
        let golden = 0.618_033_988_749_894_9 * f64::from(i);
        DVec2::new((f64::from(i) + 0.5) / f64::from(n), golden - golden.floor())
    })
}

/// Where a ray crosses the plane at a depth.
fn at_depth(ray: &Ray, depth: f64) -> DVec2 {
    let p = ray.origin + ray.direction * ((-depth - ray.origin.z) / ray.direction.z);
    DVec2::new(p.x, p.y)
}

/// A thin biconvex lens with a small stop in front of it; 1/f = (η − 1) (1/R₁ − 1/R₂).
#[test]
fn a_thin_lens_keeps_the_thin_lens_equation() {
    let elements = vec![[100.0, 1e-6, 1.5, 2.0], [-100.0, 0.0, 1.0, 2.0]];
    let focal_length = 100.0;
    for distance in [0.5, 0.8, 5.0] {
        let camera =
            prepared(&RealisticDesc { elements: elements.clone(), focus_distance: Some(distance), ..desc() });
        let film = camera.optics.lens.rear();
        // 1/s + 1/s' = 1/f with s + s' the distance from the film.
        let object = 1000.0 * distance - film;
        assert!((1.0 / object + 1.0 / film - 1.0 / focal_length).abs() < 1e-9, "{distance}: {film} {object}");
        // The rays of the film's centre meet at the object.
        for u in squares(64) {
            let at = at_depth(&camera.ray(DVec2::ZERO, u), distance);
            assert!(at.length() < 2e-5 * distance, "{distance} {u}: {at}");
        }
        // A point off the axis is imaged with the magnification s'/s, upright on the screen.
        let at = DVec2::new(0.03, 0.05);
        let expected = at * camera.half_film * 1e-3 * object / film;
        let found = at_depth(&camera.ray(at, DVec2::splat(0.5)), distance);
        assert!((found - expected).length() < 2e-3 * expected.length(), "{found} {expected}");
    }
}

#[test]
fn the_double_gauss_is_a_lens_of_fifty_millimetres() {
    let camera = prepared(&RealisticDesc { focus_distance: Some(1e6), ..desc() });
    assert!((camera.optics.lens.focal_length - 50.0).abs() < 0.4, "{}", camera.optics.lens.focal_length);
    // The field of view along the diagonal: tan = half the diagonal over the focal length, up to distortion.
    let corner = camera.ray(DVec2::ONE, DVec2::splat(0.5)).direction;
    let half = atan2(DVec2::new(corner.x, corner.y).length(), -corner.z);
    assert!((tan(half) - 17.5 / camera.optics.lens.focal_length).abs() < 0.03 * tan(half), "{half}");
    assert!(corner.x > 0.0 && corner.y > 0.0);
    let near_axis = camera.ray(DVec2::new(0.02, 0.0), DVec2::splat(0.5)).direction;
    let expected = 0.02 * camera.half_film.x / camera.optics.lens.focal_length;
    assert!((-near_axis.x / near_axis.z / expected - 1.0).abs() < 1e-3);
}

/// Irradiance of the centre of the film over radiance: π sin² of half the angle of the cone, which for parallel light is
/// π/4 (D/f)² with the diameter D of the entrance pupil (Abbe's sine condition).
#[test]
fn brightness_follows_the_f_number() {
    let absolute = |stop: f64| {
        let camera = prepared(&RealisticDesc {
            aperture_diameter: Some(stop),
            brightness: LensBrightness::Absolute,
            focus_distance: Some(1e6),
            ..desc()
        });
        // The marginal rays: the largest height of the rays of the centre where they leave the lens.
        let heights = squares(4096).map(|u| {
            let origin = camera.ray(DVec2::ZERO, u).origin;
            1e3 * DVec2::new(origin.x, origin.y).length()
        });
        let entrance = 2.0 * heights.fold(0.0, f64::max);
        let f_number = camera.optics.lens.focal_length / entrance;
        (f64::from(camera.weight(DVec2::ZERO)), f_number)
    };
    for stop in [17.1, 8.0, 4.0, 1.0] {
        let (found, f_number) = absolute(stop);
        let expected = PI / 4.0 / (f_number * f_number);
        assert!((found / expected - 1.0).abs() < 0.02, "{stop}: f/{f_number} {found} {expected}");
    }
    // Wide open it is the patent's f/2; the stop scales the area.
    assert!((absolute(17.1).1 - 2.0).abs() < 0.06, "{}", absolute(17.1).1);
    let ratio = absolute(2.0).0 / absolute(1.0).0;
    assert!((ratio - 4.0).abs() < 0.01, "{ratio}");
    // Relative to its centre, the picture is as bright as that of a pinhole.
    let relative = prepared(&RealisticDesc { aperture_diameter: Some(4.0), ..desc() });
    assert_eq!(relative.weight(DVec2::ZERO), 1.0);
    // With a small stop nothing is cut off, and the corners lose what cos⁴ of the angle on the film's side says, up to
    // the pupil's aberration.
    let r = relative.half_film.x * 0.3;
    let slope = -1.0 / relative.optics.lens.chief_slope();
    let cos2 = 1.0 / (1.0 + (r / slope) * (r / slope));
    let found = f64::from(relative.weight(DVec2::new(0.3, 0.0)));
    assert!(((1.0 - found) / (1.0 - cos2 * cos2) - 1.0).abs() < 0.25, "{found} {}", cos2 * cos2);
}

/// The irradiance of a point of the film, as pbrt integrates it: over the plane of the rear surface, with cos⁴ θ / z².
#[test]
fn the_pupils_area_is_the_irradiance() {
    for elements in [double_gauss(), FISHEYE.to_vec()] {
        let camera = prepared(&RealisticDesc { elements, brightness: LensBrightness::Absolute, ..desc() });
        let rear = camera.optics.lens.rear();
        for at in [DVec2::ZERO, DVec2::new(0.4, -0.3), DVec2::new(-0.7, 0.6)] {
            let film = (-at * camera.half_film).extend(0.0);
            let (side, n) = (26.0, 400_000);
            let sum: f64 = squares(n)
                .map(|u| {
                    let d = (side * (u - 0.5)).extend(rear) - film;
                    let unit = d.normalize();
                    let open = camera.optics.lens.trace(film, unit, |_| true).is_some();
                    let cos2 = unit.z * unit.z;
                    if open { cos2 * cos2 / (rear * rear) } else { 0.0 }
                })
                .sum();
            let expected = sum * side * side / f64::from(n);
            let found = f64::from(camera.weight(at));
            assert!((found - expected).abs() < 0.01 * expected + 1e-4, "{at}: {found} {expected}");
        }
    }
}

/// Every ray that passes the lens is in the region that the tables give, and the rays of the camera are uniform in
/// direction cosines: their mean and extent are those of the rays that pass.
#[test]
fn the_tables_contain_all_rays_and_rays_are_uniform() {
    for elements in [double_gauss(), FISHEYE.to_vec()] {
        let camera = prepared(&RealisticDesc { elements, ..desc() });
        for r in [0.0, 1.3, 5.77, 9.1, 13.0] {
            let Some(pupil) = camera.optics.pupils.at(r) else { continue };
            // Distances from the centre in the region, by 720 directions.
            let mut region = vec![0.0_f64; 720];
            let bin = |p: DVec2| ((atan2(p.y, p.x) / PI + 1.0) * 360.0).floor().clamp(0.0, 719.0) as usize;
            let (mut inside, mut points) = (DVec2::ZERO, 0.0);
            for u in squares(400_000) {
                let c = pupil.point(u);
                let p = c - DVec2::new(pupil.center(), 0.0);
                region[bin(p)] = region[bin(p)].max(p.length());
                if let Some(d) = direction(c.x, c.y)
                    && camera.optics.lens.trace(DVec3::new(r, 0.0, 0.0), d, |_| true).is_some()
                {
                    inside += c;
                    points += 1.0;
                }
            }
            assert!(points > 0.8 * 400_000.0, "{r}: {points}");
            let (mut all, mut count, mut outside) = (DVec2::ZERO, 0.0, 0.0);
            for u in squares(2_000_000) {
                let c = 2.0 * u - 1.0;
                let c = DVec2::new(pupil.center(), 0.0) + 0.4 * c;
                let Some(d) = direction(c.x, c.y) else { continue };
                if camera.optics.lens.trace(DVec3::new(r, 0.0, 0.0), d, |_| true).is_some() {
                    all += c;
                    count += 1.0;
                    let p = c - DVec2::new(pupil.center(), 0.0);
                    outside += f64::from(u8::from(p.length() > 1.01 * region[bin(p)]));
                }
            }
            assert!(outside <= 2e-3 * count, "{r}: {outside} of {count} rays");
            let shift = (all / count - inside / points).length();
            assert!(shift < 2e-3, "{r}: {shift}");
        }
    }
}

/// Light takes the same way in both directions: the lens turned round, traced from where a ray left it.
#[test]
fn rays_return_through_the_lens() {
    let elements = double_gauss();
    let camera = prepared(&desc());
    let mut turned: Vec<[f64; 4]> = Vec::new();
    for i in (0..elements.len()).rev() {
        let before = if i > 0 { elements[i - 1] } else { [0.0, 0.0, 1.0, 0.0] };
        turned.push([-elements[i][0], before[1], before[2], elements[i][3]]);
    }
    let mut back = Lens::new(&turned, None).unwrap();
    back.focus(1e4, 1.0).unwrap();
    let (length, rear) = (camera.optics.lens.length(), camera.optics.lens.rear());
    let mut passed = 0;
    for (i, u) in squares(500).enumerate() {
        let start = DVec3::new(0.02 * i as f64, -0.01 * i as f64, 0.0);
        let d = DVec3::new(0.3 * u.x - 0.15, 0.3 * u.y - 0.15, 1.0).normalize();
        let Some((p, out)) = camera.optics.lens.trace(start, d, |_| true) else { continue };
        // In the coordinates of the turned lens, in front of its rear surface.
        let mirrored = |p: DVec3| DVec3::new(p.x, p.y, back.rear() + (rear + length - p.z));
        let from = mirrored(p + 5.0 * out);
        let towards = DVec3::new(-out.x, -out.y, out.z);
        let (q, way) = back.trace(from, towards, |_| true).expect("the same way back");
        let end = q + way * ((mirrored(start).z - q.z) / way.z);
        assert!((end - mirrored(start)).length() < 1e-9, "{start}: {end}");
        assert!((way - DVec3::new(-d.x, -d.y, d.z)).length() < 1e-12);
        passed += 1;
    }
    assert!(passed > 200, "{passed}");
}

/// The picture is where that of a thin lens of the same focal length is, with the same blur.
#[test]
fn a_thin_lens_camera_shows_the_same() {
    let camera = CameraDesc::Realistic(desc()).prepare(1.5).unwrap();
    let Camera::Realistic(own) = &camera else { unreachable!() };
    let (length, radius) = own.thin();
    let thin = ThinLensDesc {
        position: DVec3::ZERO,
        look_at: DVec3::new(0.0, 0.0, -3.0),
        viewport: Some(Viewport::Size(2.0 * own.half_film * 1e-3)),
        distance: Some(length),
        lens_radius: radius,
        ..ThinLensDesc::default()
    };
    let thin = CameraDesc::ThinLens(thin).prepare(1.5).unwrap();
    for at in [DVec2::ZERO, DVec2::new(0.3, 0.2), DVec2::new(-0.6, 0.4), DVec2::new(0.1, -0.9)] {
        let [a, b] = [&camera, &thin].map(|c| at_depth(&c.ray(at, DVec2::splat(0.5)), 3.0));
        // Half the picture is 0.9 wide there; the lens has a distortion below 1 %.
        assert!((a - b).length() < 0.012, "{at}: {a} {b}");
    }
    // The circle of confusion at twice the distance.
    let spread = |c: &Camera| {
        let sum: f64 = squares(4000).map(|u| at_depth(&c.ray(DVec2::ZERO, u), 6.0).length_squared()).sum();
        (sum / 4000.0).sqrt()
    };
    assert!((spread(&camera) / spread(&thin) - 1.0).abs() < 0.05, "{} {}", spread(&camera), spread(&thin));
    let model = camera.model(300, 200);
    let tangents = height_of(&camera);
    assert!((model.scale.y * tangents - 200.0).abs() < 1e-9);
}

fn height_of(camera: &Camera) -> f64 {
    let Camera::Realistic(own) = camera else { unreachable!() };
    let height = 2.0 * own.half_tangents().y;
    assert!((desc().height_at_one(1.5).unwrap() - height).abs() < 1e-12 * height);
    height
}

#[test]
fn points_project_to_the_central_rays_that_pass_them() {
    let film = FilmDesc { width: 300, height: 200, ..crate::description::SceneDesc::default().film };
    for elements in [double_gauss(), FISHEYE.to_vec()] {
        let (near, far) = (0.5, Some(6.0));
        let camera =
            CameraDesc::Realistic(RealisticDesc { elements, near, far, ..desc() }).prepare(1.5).unwrap();
        for (x, y) in [(150.0, 100.0), (40.3, 71.9), (222.2, 150.0), (160.0, 33.0)] {
            let at = DVec2::new(x / 150.0 - 1.0, 1.0 - y / 100.0);
            let ray = camera.ray(at, DVec2::splat(0.5));
            let p = ray.origin + 4.0 * ray.direction;
            let seen = camera.project(&film, p, DVec2::splat(0.5)).unwrap();
            assert!((seen.place - DVec2::new(x, y)).length() < 1e-6, "{}: {x} {y}", seen.place);
            assert!((seen.to_camera + 4.0 * ray.direction).length() < 1e-9);
            assert!((1.0 - seen.free - ray.t_min / 4.0).abs() < 1e-9, "{} {}", seen.free, ray.t_min);
            let end = |scale: f64| {
                let p = ray.origin + scale * ray.t_max * ray.direction;
                camera.project(&film, p, DVec2::splat(0.5)).is_some()
            };
            assert!(end(0.9999) && !end(1.0001), "{}", ray.t_max);
            // One ray per pixel: the area between neighbours, far away.
            let d =
                |dx: f64, dy: f64| camera.ray(at + DVec2::new(dx, dy) * 1e-3, DVec2::splat(0.5)).direction;
            let angle = (d(1.0, 0.0) - d(-1.0, 0.0)).cross(d(0.0, 1.0) - d(0.0, -1.0)).length() / 4e-6;
            let found = camera.ray_density(&film, ray.direction).0;
            assert!((found * angle / 15_000.0 - 1.0).abs() < 0.02, "{x} {y}: {found} {angle}");
        }
        assert!(camera.project(&film, DVec3::Z, DVec2::splat(0.5)).is_none());
    }
}

#[test]
fn blades_bound_the_rays() {
    let camera = prepared(&RealisticDesc { blades: 3, blade_rotation: 20.0, ..desc() });
    let out: Vec<DVec3> = squares(3000).map(|u| camera.ray(DVec2::ZERO, u).origin).collect();
    assert!(out.iter().all(|p| p.is_finite()));
    // The triangle has the corners of the round aperture, and an area of 3 √3 / (4 π) of it.
    let radius = out.iter().map(|p| DVec2::new(p.x, p.y).length()).fold(0.0, f64::max);
    let far = out.iter().filter(|p| DVec2::new(p.x, p.y).length() < 0.5 * radius).count();
    let expected = PI * 0.25 / (3.0 * 3.0_f64.sqrt() / 4.0);
    assert!((far as f64 / 3000.0 - expected).abs() < 0.04, "{far}");
}

#[test]
fn hostile_lenses_are_refused() {
    let refused = |change: &dyn Fn(&mut RealisticDesc)| {
        let mut desc = desc();
        change(&mut desc);
        let Err(error) = desc.prepare(1.5) else { panic!("prepared") };
        assert!(!error.message.contains("NaN") && !error.message.is_empty(), "{error:?}");
        error.code
    };
    type Change<'a> = (ErrorCode, &'a dyn Fn(&mut RealisticDesc));
    let changes: [Change<'_>; 14] = [
        (ErrorCode::OutOfRange, &|d| d.elements.clear()),
        (ErrorCode::OutOfRange, &|d| d.elements = vec![[10.0, 1.0, 1.5, 5.0]; 65]),
        (ErrorCode::OutOfRange, &|d| d.elements[2][0] = f64::INFINITY),
        (ErrorCode::OutOfRange, &|d| d.elements[2][1] = -1.0),
        (ErrorCode::OutOfRange, &|d| d.elements[2][2] = 0.5),
        (ErrorCode::OutOfRange, &|d| d.elements[2][3] = 0.0),
        (ErrorCode::OutOfRange, &|d| d.elements[10][2] = 1.5),
        (ErrorCode::OutOfRange, &|d| d.units_per_metre = 1e300),
        (ErrorCode::OutOfRange, &|d| d.film_diagonal = 1e-300),
        (ErrorCode::OutOfRange, &|d| d.blades = 2),
        (ErrorCode::Camera, &|d| d.focus_distance = Some(0.1)),
        (ErrorCode::Camera, &|d| d.elements = vec![[-50.0, 2.0, 1.5, 10.0], [50.0, 0.0, 1.0, 10.0]]),
        (ErrorCode::Camera, &|d| d.elements = vec![[0.0, 2.0, 1.0, 10.0]]),
        (ErrorCode::Conflict, &|d| {
            d.elements.remove(5);
            d.aperture_diameter = Some(2.0);
        }),
    ];
    for (i, (code, change)) in changes.iter().enumerate() {
        assert_eq!(refused(change), *code, "{i}");
    }
    // Narrow apertures and large films work.
    for (stop, diagonal) in [(0.01, 35.0), (17.1, 1000.0), (1e-5, 1.0)] {
        let desc = RealisticDesc { aperture_diameter: Some(stop), film_diagonal: diagonal, ..desc() };
        let camera = prepared(&desc);
        for u in squares(50) {
            assert!(camera.ray(DVec2::ZERO, u).t_max > 0.0);
            let ray = camera.ray(2.0 * u - 1.0, u);
            assert!(ray.origin.is_finite() && (ray.direction.length() - 1.0).abs() < 1e-9);
            // A film of a metre is dark outside the image circle.
            assert!(ray.t_max > 0.0 || camera.weight(2.0 * u - 1.0) < 1e-3, "{stop} {diagonal}");
        }
        assert_eq!(camera.weight(DVec2::ONE) == 0.0, diagonal == 1000.0, "{stop} {diagonal}");
    }
}

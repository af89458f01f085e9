use turner::camera::PinholeDesc;

use super::*;

fn camera() -> CameraDesc {
    CameraDesc::Pinhole(PinholeDesc {
        position: DVec3::new(0.0, 1.0, 5.0),
        look_at: DVec3::new(0.0, 1.0, 0.0),
        ..PinholeDesc::default()
    })
}

fn position(camera: &mut CameraDesc) -> DVec3 {
    let [position, _, _] = camera.placement_mut();
    *position
}

#[test]
fn an_orbit_keeps_the_distance_and_goes_to_the_right() {
    let mut c = camera();
    orbit(&mut c, 0.3, 0.2);
    assert!((distance(&c) - 5.0).abs() < 1e-12);
    let at = position(&mut c);
    assert!(at.x > 1.0 && at.y > 1.5, "{at}");
}

#[test]
fn an_orbit_stops_before_the_poles() {
    let mut c = camera();
    for _ in 0..100 {
        orbit(&mut c, 0.0, 1.0);
        assert!(axes(&c).is_some());
    }
    let at = position(&mut c);
    assert!(at.y > 5.9 && at.is_finite(), "{at}");
}

#[test]
fn a_left_handed_camera_follows_the_hand_too() {
    let mut c = camera();
    if let CameraDesc::Pinhole(c) = &mut c {
        c.handedness = Handedness::Left;
    }
    let right = axes(&c).unwrap().right;
    let before = position(&mut c);
    orbit(&mut c, 0.1, 0.0);
    assert!((position(&mut c) - before).dot(right) > 0.1);
}

#[test]
fn a_pan_moves_the_picture_by_its_height() {
    let mut c = camera();
    pan(&mut c, 0.0, 1.0, 1.5);
    let height = 2.0 * 5.0 * tan(radians(20.0));
    assert!((position(&mut c).y - (1.0 - height)).abs() < 1e-9);
}

#[test]
fn a_dolly_keeps_the_angle_of_view_of_a_viewport() {
    let mut c = camera();
    if let CameraDesc::Pinhole(c) = &mut c {
        c.viewport = Some(Viewport::Height(6.0));
    }
    let before = height_at_one(&c, 1.0);
    dolly(&mut c, 0.5);
    assert_eq!(height_at_one(&c, 1.0), before);
    assert!((distance(&c) - 2.5).abs() < 1e-12);
}

#[test]
fn framed_bounds_lie_in_the_picture() {
    let bounds = Bounds { min: DVec3::new(2.0, -1.0, -3.0), max: DVec3::new(5.0, 4.0, 1.0) };
    for aspect in [0.5, 1.0, 2.0] {
        let mut c = camera();
        orbit(&mut c, 0.7, 0.4);
        frame(&mut c, &bounds, aspect);
        let axes = axes(&c).unwrap();
        let half = 0.5 * height_at_one(&c, aspect).unwrap();
        for i in 0..8 {
            let pick = |bit: usize, low: f64, high: f64| if i >> bit & 1 == 0 { low } else { high };
            let corner = DVec3::new(
                pick(0, bounds.min.x, bounds.max.x),
                pick(1, bounds.min.y, bounds.max.y),
                pick(2, bounds.min.z, bounds.max.z),
            );
            let d = corner - axes.position;
            let z = d.dot(axes.forward);
            assert!(
                z > 0.0
                    && (d.dot(axes.up) / z).abs() <= half
                    && (d.dot(axes.right) / z).abs() <= half * aspect
            );
        }
    }
}

#[test]
fn focus_makes_a_lens_that_is_sharp_at_the_point() {
    let mut c = camera();
    focus(&mut c, DVec3::new(1.0, 1.0, 2.0));
    let CameraDesc::ThinLens(lens) = &c else { panic!("{c:?}") };
    assert_eq!(lens.focus_distance, Some(3.0));
    assert!(lens.lens_radius > 0.0);
}

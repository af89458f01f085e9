//! Shadows on shadow catchers by formula.

use crate::description::{ObjectDesc, SceneDesc};
use crate::film::{Aov, Aovs, Picture};
use crate::filter::FilterKind;
use crate::integrator::{DirectDesc, IntegratorDesc, PathDesc};
use crate::light::{AmbientDesc, EnvironmentDesc, LightDesc};
use crate::math::DVec3;
use crate::schema::GroupId;
use crate::shape::{DiskDesc, ShapeDesc};
use crate::testing::scenes::{
    cuboid, emissive, grey, lamp, matte, path, plane, rectangle, render, render_with, sphere, v,
};

/// The camera's height, and the width of the floor that it sees.
const HEIGHT: f64 = 40.0;
const WIDTH: f64 = 8.0;
const PIXELS: u32 = 32;

fn disk() -> ShapeDesc {
    ShapeDesc::Disk(DiskDesc {
        center: v(0.0, 2.0, 0.0),
        normal: DVec3::Y,
        radius: 1.0,
        ..DiskDesc::default()
    })
}

/// A black disk of radius 1 at a height of 2 above a floor that catches its shadow, seen from above.
fn disk_above_floor(integrator: IntegratorDesc) -> SceneDesc {
    let floor = ObjectDesc { shadow_catcher: true, ..ObjectDesc::new(plane()) };
    let mut desc = SceneDesc { integrator, ..SceneDesc::default() }
        .with_object(floor, matte(grey(0.5)))
        .with(disk(), matte(grey(0.0)))
        .seen(crate::camera::PinholeDesc {
            position: v(0.0, HEIGHT, 0.0),
            up: v(0.0, 0.0, -1.0),
            fov: Some(2.0 * (0.5 * WIDTH / HEIGHT).atan().to_degrees()),
            ..Default::default()
        })
        .filmed([PIXELS, PIXELS], 16);
    desc.background.transparent = true;
    desc
}

/// The pixel that sees (x, 0, z).
fn at(picture: &Picture, x: f64, z: f64) -> [f32; 4] {
    let pixel = |v: f64| ((v / WIDTH + 0.5) * f64::from(PIXELS)) as u32;
    picture.linear[(pixel(z) * PIXELS + pixel(x)) as usize]
}

/// The centre of a pixel on the floor.
fn center(pixel: u32) -> f64 {
    ((f64::from(pixel) + 0.5) / f64::from(PIXELS) - 0.5) * WIDTH
}

/// A point light at a height of 4 casts a shadow of radius 2.
#[test]
fn a_point_light_casts_a_hard_shadow() {
    for integrator in
        [IntegratorDesc::Path(PathDesc::default()), IntegratorDesc::Direct(DirectDesc::default())]
    {
        let mut desc = disk_above_floor(integrator).lit(lamp(v(0.0, 4.0, 0.0), 5.0));
        desc.film.aovs = Aovs::new(&[Aov::Shadow]);
        let (picture, _) = render(&desc);
        assert!(picture.has_alpha);
        for y in 0..PIXELS {
            for x in 0..PIXELS {
                let [px, pz] = [center(x), center(y)];
                let (r, found) = (px.hypot(pz), picture.linear[(y * PIXELS + x) as usize]);
                // Half a pixel is 0.125 wide, 0.18 along the diagonal.
                if r < 1.8 {
                    assert_eq!(found, [0.0, 0.0, 0.0, 1.0], "{px} {pz}");
                } else if r > 2.2 {
                    assert_eq!(found, [0.0; 4], "{px} {pz}");
                }
            }
        }
    }
}

/// A square light of edge 1 at a height of 4: the fraction of its irradiance that the disk keeps off, by quadrature.
#[test]
fn an_area_light_casts_a_soft_shadow() {
    let light = rectangle(v(0.0, 4.0, 0.0), v(1.0, 0.0, 0.0), v(0.0, 0.0, 1.0));
    let mut desc =
        disk_above_floor(IntegratorDesc::Path(PathDesc::default())).with(light, emissive(9.0, grey(1.0)));
    desc.film.samples = 256;
    let (picture, _) = render(&desc);
    let kept_off = |x: f64, z: f64| {
        let (mut blocked, mut all) = (0.0, 0.0);
        let steps = 64;
        for i in 0..steps * steps {
            let along = |i: u32| (f64::from(i) + 0.5) / f64::from(steps) - 0.5;
            let to = v(along(i % steps) - x, 4.0, along(i / steps) - z);
            // Both cosines are the height over the distance.
            let arrives = 16.0 / to.length_squared().powi(2);
            all += arrives;
            // At a height of 2 the way is half done.
            let middle = v(x, 0.0, z) + 0.5 * to;
            if middle.x.hypot(middle.z) < 1.0 {
                blocked += arrives;
            }
        }
        blocked / all
    };
    let mut partial = 0;
    for x in 0..PIXELS {
        for z in [0.125, 1.125, -2.125] {
            let px = center(x);
            // The camera sees the disk and the light there.
            if px.hypot(z) < 1.3 {
                continue;
            }
            let mean = |f: &dyn Fn(f64, f64) -> f64| {
                let offsets = [-0.0833, 0.0, 0.0833];
                (0..9).map(|i| f(px + offsets[i % 3], z + offsets[i / 3])).sum::<f64>() / 9.0
            };
            let expected = mean(&kept_off);
            let [r, _, _, alpha] = at(&picture, px, z);
            assert!((f64::from(alpha) - expected).abs() < 0.02, "{px} {z}: {alpha} {expected}");
            assert!(r == 0.0);
            partial += u32::from(expected > 0.1 && expected < 0.9);
        }
    }
    assert!(partial >= 8, "{partial}");
}

/// Next to an endless wall half of the sky is missing.
#[test]
fn a_sky_casts_a_soft_shadow() {
    let wall = rectangle(v(0.0, 2000.0, 0.0), v(0.0, 0.0, 4000.0), v(0.0, 4000.0, 0.0));
    let floor = ObjectDesc { shadow_catcher: true, ..ObjectDesc::new(plane()) };
    let scene = || {
        let mut desc = path(PathDesc::default())
            .with_object(floor.clone(), matte(grey(0.5)))
            .with(wall.clone(), matte(grey(0.3)))
            .seen_at(v(3.0, 3.0, 0.0), v(0.5, 0.0, 0.0), 0.5)
            .filmed([4, 4], 256);
        desc.background.transparent = true;
        desc
    };
    let ambient = AmbientDesc { intensity: 0.5, ..AmbientDesc::default() };
    let mean = |desc: &SceneDesc, channel: usize| {
        render(desc).0.linear.iter().map(|p| f64::from(p[channel])).sum::<f64>() / 16.0
    };
    for desc in [scene().before(0.7), scene().lit(LightDesc::Ambient(ambient))] {
        let alpha = mean(&desc, 3);
        assert!((alpha - 0.5).abs() < 0.01, "{alpha}");
    }
    // The light of an environment on an ordinary white floor, with and without the wall.
    let caught = scene().lit(LightDesc::Environment(EnvironmentDesc::studio()));
    let mut floor = caught.clone();
    floor.integrator = IntegratorDesc::Direct(DirectDesc::default());
    floor.objects[0].shadow_catcher = false;
    let with = mean(&floor, 1);
    floor.objects.remove(1);
    let expected = 1.0 - with / mean(&floor, 1);
    let alpha = mean(&caught, 3);
    assert!((alpha - expected).abs() < 0.02 && expected > 0.1, "{alpha} {expected}");
}

/// Shadow catchers cast no shadow on one another: the photograph has it already.
#[test]
fn shadow_catchers_cast_no_shadow_on_one_another() {
    let catcher = |shape| ObjectDesc { shadow_catcher: true, ..ObjectDesc::new(shape) };
    let scene =
        || disk_above_floor(IntegratorDesc::Path(PathDesc::default())).lit(lamp(v(-3.0, 4.0, 0.0), 5.0));
    let wall = cuboid(v(-2.0, 0.0, -4.0), v(-1.8, 1.0, 4.0));
    let (with, _) = render(&scene().with_object(catcher(wall.clone()), matte(grey(0.5))));
    // The floor behind the wall, as far as the light does not reach it: nothing to keep off.
    assert_eq!(at(&with, -1.6, 2.0), [0.0; 4]);
    assert_eq!(at(&with, 1.5, 0.1)[3], at(&render(&scene()).0, 1.5, 0.1)[3]);
    // An object casts one.
    let (object, _) = render(&scene().with(wall, matte(grey(0.0))));
    assert_eq!(at(&object, -1.6, 2.0), [0.0, 0.0, 0.0, 1.0]);
}

/// Before an opaque background, and before an object behind it, the shadow darkens what is there.
#[test]
fn a_shadow_darkens_what_is_behind() {
    let mut desc =
        disk_above_floor(IntegratorDesc::Path(PathDesc::default())).lit(lamp(v(0.0, 4.0, 0.0), 40.0));
    (desc.background.transparent, desc.background.color) =
        (false, crate::color::Spectrum::new(0.2, 0.4, 0.6));
    // The background lights the floor, too, so that the shadow is not black.
    let (picture, _) = render(&desc);
    let [r, g, b, alpha] = at(&picture, 1.5, 0.1);
    assert!(alpha == 1.0 && (r / b - 1.0 / 3.0).abs() < 1e-4 && (g / b - 2.0 / 3.0).abs() < 1e-4);
    assert!(r > 0.05 && r < 0.1, "{r}");
    let [r, ..] = at(&picture, 3.6, 0.1);
    assert!(r > 0.17 && r <= 0.2, "{r}");
    // Its own colour and light from below do not matter. What is below is seen.
    let glow = rectangle(v(0.0, -1.0, 0.0), v(20.0, 0.0, 0.0), v(0.0, 0.0, -20.0));
    let mut below = desc.clone().with(glow, emissive(1.0, grey(1.0)));
    below.background.transparent = true;
    let (seen, _) = render(&below);
    let [lit, dark] = [at(&seen, 3.6, 0.1), at(&seen, 1.5, 0.1)];
    assert!((lit[0] - 5.0 * at(&picture, 3.6, 0.1)[0]).abs() < 0.05 && lit[3] == 1.0, "{lit:?}");
    assert!((dark[0] - 5.0 * at(&picture, 1.5, 0.1)[0]).abs() < 0.05 && dark[3] == 1.0, "{dark:?}");
}

/// Passes, threads and weighted samples give the same shadow; objects in groups are shadow catchers with their instance.
#[test]
fn shadows_do_not_depend_on_passes() {
    let mut desc = disk_above_floor(IntegratorDesc::Path(PathDesc::default()))
        .with(sphere(v(2.0, 0.5, 0.0), 0.5), matte(grey(0.5)))
        .lit(lamp(v(0.0, 4.0, 1.0), 5.0));
    desc.film.filter = FilterKind::Gaussian;
    let (whole, _) = render_with(&desc, 2, u32::MAX);
    assert!(whole == render_with(&desc, 1, 3).0);
    let mut grouped = desc.clone();
    let floor = ObjectDesc { shadow_catcher: false, ..grouped.objects[0].clone() };
    grouped.groups.push(crate::description::GroupDesc { objects: vec![floor], model: None }.into());
    grouped.objects[0].content = crate::description::ObjectContent::Instance(GroupId(0));
    assert!(whole == render(&grouped).0);
}

//! Scenes whose pixels are known in closed form.
#![allow(
    clippy::disallowed_methods,
    reason = "expected values are independent of the renderer's own functions"
)]

use crate::camera::PinholeDesc;
use crate::description::SceneDesc;
use crate::film::{Antialias, Picture};
use crate::integrator::{AtDepth, ClassicDesc, Combine, IntegratorDesc};
use crate::light::{
    AmbientDesc, Attenuation, DirectionalDesc, LightDesc, PointDesc, RectangleLightDesc, SphereLightDesc,
    SpotDesc,
};
use crate::material::{ClassicMaterial, Fresnel, ShadowKind};
use crate::math::DVec3;
use crate::shape::{DiskDesc, PlaneDesc, ShapeDesc, TorusDesc};
use crate::testing::scenes::{
    called, cuboid, pixel, plane, rectangle, render, render_with, rgb, scene, sphere, v,
};

fn classic(desc: ClassicDesc) -> SceneDesc {
    scene(IntegratorDesc::Classic(desc))
}

fn plain() -> SceneDesc {
    classic(ClassicDesc::default())
}

fn of_depth(max_depth: u32) -> ClassicDesc {
    ClassicDesc { max_depth, ..ClassicDesc::default() }
}

/// The one pixel of a scene rendered at 1x1.
fn one_pixel(desc: SceneDesc) -> [f32; 3] {
    pixel(&render(&desc.sized([1, 1])).0, 0, 0)
}

fn close(got: [f32; 3], expected: [f64; 3], tolerance: f64) {
    for (g, e) in got.iter().zip(expected) {
        assert!((f64::from(*g) - e).abs() <= tolerance, "{got:?} and {expected:?}");
    }
}

fn ambient(intensity: f64) -> LightDesc {
    LightDesc::Ambient(AmbientDesc { intensity, ..AmbientDesc::default() })
}

/// A directional light from above.
fn from_above(intensity: f64) -> LightDesc {
    LightDesc::Directional(DirectionalDesc { from: Some(DVec3::Y), intensity, ..DirectionalDesc::default() })
}

/// A diffuse surface of this colour.
fn colored(r: f64, g: f64, b: f64) -> ClassicMaterial {
    ClassicMaterial { color: rgb([r, g, b]), ..ClassicMaterial::default() }
}

fn white() -> ClassicMaterial {
    colored(1.0, 1.0, 1.0)
}

/// A surface without diffuse term that reflects and refracts with these coefficients.
fn glass(k_reflect: f64, k_refract: f64) -> ClassicMaterial {
    ClassicMaterial { kd: 0.0, k_reflect, k_refract, ..ClassicMaterial::default() }
}

fn ball(radius: f64) -> ShapeDesc {
    sphere(DVec3::ZERO, radius)
}

#[test]
fn lambert_and_phong_at_a_point() {
    // The camera looks straight down at the origin of a plane; the direction to the light is 60 degrees from the
    // normal.
    let seen = |material: ClassicMaterial, coefficients: [f64; 3]| {
        let position = v(1.732_050_807_568_877_2, 1.0, 0.0);
        let attenuation = Attenuation { coefficients };
        let light = LightDesc::Point(PointDesc { position, attenuation, ..PointDesc::default() });
        one_pixel(plain().seen_down_from(4.0).lit(light).with(plane(), material))
    };
    let even = [1.0, 0.0, 0.0];
    let diffuse = ClassicMaterial { kd: 1.0, ..colored(0.8, 0.4, 0.2) };
    // N·L = cos 60° = 1/2.
    close(seen(diffuse.clone(), even), [0.4, 0.2, 0.1], 1e-6);
    // R·V = cos 60° too: (1/2)^3 = 1/8 on every channel.
    let glossy = ClassicMaterial { kd: 0.0, ks: 1.0, shininess: 3.0, ..diffuse.clone() };
    close(seen(glossy.clone(), even), [0.125; 3], 1e-6);
    // A non-integer exponent.
    close(seen(ClassicMaterial { shininess: 2.5, ..glossy }, even), [0.5f64.powf(2.5); 3], 1e-6);
    // The distance is 2: a quarter of the light.
    close(seen(diffuse.clone(), [0.0, 0.0, 1.0]), [0.1, 0.05, 0.025], 1e-6);
    close(seen(diffuse, [1.0, 0.5, 0.5]), [0.1, 0.05, 0.025], 1e-6);
}

#[test]
fn spot_light_rim_and_ambient() {
    let seen = |x: f64| {
        let camera = PinholeDesc {
            position: v(x, 4.0, 0.0),
            look_at: v(x, 0.0, 0.0),
            up: v(0.0, 0.0, -1.0),
            fov: Some(0.001),
            ..PinholeDesc::default()
        };
        let spot = SpotDesc {
            position: DVec3::Y,
            angle: 45.0,
            penumbra: 0.0,
            intensity: 0.5,
            ..SpotDesc::default()
        };
        let material = ClassicMaterial { ka: 0.5, ..white() };
        let lit = plain().seen(camera).lit(ambient(0.25)).lit(LightDesc::Spot(spot));
        one_pixel(lit.with(plane(), material))
    };
    close(seen(0.0), [0.125 + 0.5; 3], 1e-6);
    close(seen(0.99), [0.125 + 0.5 / (1.0 + 0.99f64 * 0.99).sqrt(); 3], 1e-6);
    close(seen(1.01), [0.125; 3], 1e-6);
}

#[test]
fn facing_mirrors_show_exactly_max_depth_images() {
    // Two mirrors of brightness 1: one for the mirror that the camera sees and one for each image in it.
    for depth in [0, 1, 2, 5, 20, 1000] {
        let camera = PinholeDesc { position: DVec3::ZERO, look_at: DVec3::NEG_Z, ..PinholeDesc::default() };
        let settings = ClassicDesc { at_depth: AtDepth::Black, combine: Combine::Add, ..of_depth(depth) };
        let mirror = ClassicMaterial { kd: 0.0, k_reflect: 1.0, ..white() };
        let facing =
            |z: f64| ShapeDesc::Plane(PlaneDesc { point: v(0.0, 0.0, 2.0 * z), normal: v(0.0, 0.0, -z) });
        let mut desc = classic(settings).seen(camera).lit(ambient(1.0));
        let mirror = desc.material(mirror.into());
        let desc = desc.with_shared(facing(-1.0), mirror).with_shared(facing(1.0), mirror);
        close(one_pixel(desc), [f64::from(depth) + 1.0; 3], 0.0);
    }
}

#[test]
fn a_glass_slab_shifts_a_ray_by_the_textbook_amount() {
    // Incidence 40 degrees on a slab 1 thick: the shift is sin(i − t) / cos(t).
    let i = 40f64.to_radians();
    let t = (i.sin() / 1.5).asin();
    let shift = (i - t).sin() / t.cos();
    let (dx, dz) = (i.sin(), -i.cos());
    let hit = |extra: f64| {
        // The undeviated ray goes through the origin; (dz, −dx) is perpendicular to it in the plane of incidence.
        let s = shift + extra;
        let (x, z) = (dx * 5.0 + dz * s, dz * 5.0 - dx * s);
        let desc = plain()
            .seen_at(v(-dx * 5.0, 0.0, -dz * 5.0), DVec3::ZERO, 1e-6)
            .lit(ambient(1.0))
            .with(
                cuboid(v(-50.0, -50.0, -2.0), v(50.0, 50.0, -1.0)),
                ClassicMaterial { ka: 0.0, ior: 1.5, ..glass(0.0, 1.0) },
            )
            .with(sphere(v(x, 0.0, z), 0.001), colored(0.0, 1.0, 0.0));
        one_pixel(desc)
    };
    close(hit(0.0), [0.0, 1.0, 0.0], 0.0);
    close(hit(0.0009), [0.0, 1.0, 0.0], 0.0);
    close(hit(0.0011), [0.0; 3], 0.0);
    close(hit(-0.0011), [0.0; 3], 0.0);
}

#[test]
fn the_ray_tree_has_at_most_two_to_the_depth_leaves() {
    for depth in 0..7u32 {
        let camera = PinholeDesc { position: v(0.0, 0.0, 4.0), ..PinholeDesc::default() };
        let desc = classic(of_depth(depth)).seen(camera).before(1.0).with(ball(1.0), glass(0.5, 0.5));
        let (picture, stats) = render(&desc.sized([24, 24]));
        let most = stats.camera * ((2u64 << depth) - 2);
        assert!(stats.reflected + stats.refracted <= most);
        assert!(depth == 0 || stats.refracted > 0);
        // Lossless glass in front of a white background is white.
        assert!(picture.linear.iter().all(|p| (p[0] - 1.0).abs() < 1e-5));
    }
}

#[test]
fn total_internal_reflection_loses_nothing() {
    // From inside a dense sphere, beyond the critical angle.
    for fresnel in [Fresnel::Off, Fresnel::Schlick, Fresnel::Exact] {
        let k_reflect = if fresnel == Fresnel::Off { 0.0 } else { 1.0 };
        let settings = ClassicDesc { at_depth: AtDepth::Background, ..of_depth(50) };
        let dense = ClassicMaterial { ka: 0.0, ior: 2.0, fresnel, ..glass(k_reflect, 1.0) };
        let desc = classic(settings)
            .seen_at(v(0.0, 0.95, 0.0), v(1.0, 0.95, 0.0), 1.0)
            .before(1.0)
            .with(ball(1.0), dense);
        close(one_pixel(desc), [1.0; 3], 1e-5);
    }
}

/// A white plane lit from above, seen at a grazing angle.
fn shadowed(settings: ClassicDesc) -> SceneDesc {
    classic(settings).seen_at(v(0.0, 0.1, 3.0), DVec3::ZERO, 0.01).lit(from_above(1.0)).with(plane(), white())
}

#[test]
fn a_tinted_shadow_has_the_colour_of_its_glass() {
    let tinted = ClassicMaterial { k_refract: 0.8, shadow: ShadowKind::Tinted, ..colored(1.0, 0.5, 0.0) };
    let desc = shadowed(ClassicDesc::default()).with(sphere(v(0.0, 2.0, 0.0), 0.5), tinted);
    // Two crossings: (0.8·colour)².
    close(one_pixel(desc), [0.64, 0.16, 0.0], 1e-6);
}

#[test]
fn a_soft_shadow_is_the_visible_fraction_of_the_light() {
    // A wall's edge hides half of a rectangle light.
    let light = RectangleLightDesc {
        center: v(0.0, 1000.0, 0.0),
        edge_u: v(2.0, 0.0, 0.0),
        edge_v: v(0.0, 0.0, 2.0),
        samples: 64,
        ..RectangleLightDesc::default()
    };
    let desc = plain()
        .seen_down_from(1.0)
        .lit(LightDesc::Rectangle(light))
        .with(plane(), white())
        .with_default(rectangle(v(5.0, 500.0, 0.0), v(10.0, 0.0, 0.0), v(0.0, 0.0, 20.0)));
    close(one_pixel(desc), [0.5; 3], 1e-5);
}

#[test]
fn the_papers_shadow_reduces_light_by_a_factor() {
    let desc = shadowed(ClassicDesc { shadow_factor: 0.3, ..ClassicDesc::default() });
    close(one_pixel(desc.with_default(sphere(v(0.0, 2.0, 0.0), 0.5))), [0.3; 3], 1e-6);
}

#[test]
fn effects_are_switched_one_by_one() {
    let seen = |settings: ClassicDesc| {
        let disk = DiskDesc { center: v(0.0, 100.0, 0.0), normal: DVec3::NEG_Y, ..DiskDesc::default() };
        let black = ClassicMaterial { ka: 0.0, shadow: ShadowKind::Opaque, ..colored(0.0, 0.0, 0.0) };
        let red = ClassicMaterial { ks: 0.5, k_reflect: 0.5, ..colored(1.0, 0.0, 0.0) };
        let desc = classic(settings)
            .seen_down_from(4.0)
            .before_color([0.0, 0.0, 1.0])
            .lit(ambient(0.5))
            .lit(from_above(0.25))
            .with(plane(), red)
            .with(ShapeDesc::Disk(disk), black);
        one_pixel(desc)
    };
    // In shadow: only the ambient term, and the black disk in the mirror.
    let all = ClassicDesc::default();
    close(seen(all.clone()), [0.25, 0.0, 0.0], 1e-6);
    let light = ClassicDesc { shadows: false, ..all.clone() };
    close(seen(light.clone()), [0.5 * (0.5 + 0.25 + 0.125), 0.0625, 0.0625], 1e-6);
    close(seen(ClassicDesc { highlights: false, ..light.clone() }), [0.375, 0.0, 0.0], 1e-6);
    let dull = ClassicDesc { diffuse: false, ..light.clone() };
    close(seen(dull), [0.5 * (0.5 + 0.125), 0.0625, 0.0625], 1e-6);
    close(seen(ClassicDesc { ambient: false, highlights: false, ..light }), [0.125, 0.0, 0.0], 1e-6);
    close(seen(ClassicDesc { reflection: false, ..all }), [0.5, 0.0, 0.0], 1e-6);
}

/// A scene scaled by `k`.
fn scaled(k: f64) -> SceneDesc {
    let at = |x: f64, y: f64, z: f64| v(x * k, y * k, z * k);
    let camera =
        PinholeDesc { position: at(0.0, 2.0, 6.0), look_at: at(0.0, 1.0, 0.0), ..Default::default() };
    let light = PointDesc { position: at(3.0, 5.0, 4.0), intensity: 0.8, ..PointDesc::default() };
    let torus = TorusDesc {
        center: at(-2.0, 1.0, 0.0),
        axis: v(1.0, 2.0, 2.0),
        radius: 0.7 * k,
        tube_radius: 0.3 * k,
    };
    let shade = |name| ClassicMaterial { color: called(name), ..ClassicMaterial::default() };
    plain()
        .sized([64, 48])
        .seen(camera)
        .before_color([0.2, 0.3, 0.4])
        .lit(ambient(0.2))
        .lit(LightDesc::Point(light))
        .with(sphere(at(0.0, -5000.0, 0.0), 5000.0 * k), ClassicMaterial { k_reflect: 0.2, ..shade("khaki") })
        .with(sphere(at(0.0, 1.0, 0.0), k), ClassicMaterial { ks: 0.5, k_reflect: 0.3, ..shade("tomato") })
        .with(sphere(at(1.5, 0.7, 1.0), 0.7 * k), ClassicMaterial { kd: 0.1, ..glass(0.1, 0.8) })
        .with(ShapeDesc::Torus(torus), shade("teal"))
}

const MODES: [Antialias; 5] =
    [Antialias::None, Antialias::Mean, Antialias::Grid, Antialias::Adaptive, Antialias::MonteCarlo];

fn different(a: &Picture, b: &Picture) -> usize {
    a.display
        .iter()
        .zip(&b.display)
        .filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 1))
        .count()
}

#[test]
fn the_scale_of_a_scene_does_not_matter() {
    let one = render(&scaled(1.0)).0;
    for k in [1e-6, 1e-4, 1e5, 1e7] {
        let other = render(&scaled(k)).0;
        assert!(different(&one, &other) <= 64 * 48 / 200, "scale {k}: {} pixels", different(&one, &other));
    }
    // Scaling by a power of two keeps all arithmetic the same, bit for bit.
    assert_eq!(one.linear, render(&scaled(1024.0)).0.linear);
}

#[test]
fn bytes_do_not_depend_on_threads_or_passes() {
    for antialias in MODES {
        let mut desc = scaled(1.0);
        (desc.film.antialias, desc.film.samples) = (antialias, 9);
        let light = SphereLightDesc {
            center: v(-4.0, 6.0, 2.0),
            radius: 1.0,
            samples: 4,
            intensity: 0.3,
            ..SphereLightDesc::default()
        };
        desc.lights.insert(0, LightDesc::Sphere(light).into());
        let first = render_with(&desc, 1, u32::MAX).0;
        for (threads, pass) in [(2, 1), (7, 4), (16, 2)] {
            let again = render_with(&desc, threads, pass).0;
            assert_eq!(first.linear, again.linear, "{}, {threads} threads", antialias.word());
        }
    }
}

#[test]
fn a_crop_is_a_part_of_the_picture() {
    for antialias in MODES {
        let mut desc = scaled(1.0);
        (desc.film.antialias, desc.film.samples) = (antialias, 4);
        let full = render_with(&desc, 2, 8).0;
        desc.film.crop = Some([13, 7, 30, 25]);
        let part = render_with(&desc, 2, 8).0;
        for y in 0..25 {
            for x in 0..30 {
                let (part, full) = (pixel(&part, x, y), pixel(&full, x + 13, y + 7));
                assert_eq!(part, full, "{} at {x}, {y}", antialias.word());
            }
        }
    }
}

/// A few shapes are tested one by one, some dozens by the sphere culler, more by a BVH: the picture is the same.
#[test]
fn the_search_structure_does_not_change_the_picture() {
    let seen = |hidden: u32| {
        let floor = PlaneDesc { point: v(0.0, -0.5, 0.0), ..PlaneDesc::default() };
        let material =
            ClassicMaterial { color: called("gray"), k_reflect: 0.3, ..ClassicMaterial::default() };
        let mut desc = scaled(1.0).with(ShapeDesc::Plane(floor), material);
        desc.objects.rotate_right(1);
        // Nothing below an infinite floor is visible, reflected or shaded.
        let below = |i: u32| sphere(v(f64::from(i % 17), -3.0, f64::from(i / 17)), 0.2);
        render(&(0..hidden).fold(desc, |desc, i| desc.with_default(below(i)))).0
    };
    let few = seen(0);
    for hidden in [1, 20, 70, 500] {
        assert_eq!(few.linear, seen(hidden).linear, "{hidden} hidden shapes");
    }
}

/// An endless ray tree is cut and counted.
#[test]
fn an_endless_ray_tree_ends() {
    let camera = PinholeDesc { position: v(0.0, 0.0, 4.0), ..PinholeDesc::default() };
    let mut desc = classic(of_depth(1000)).seen(camera).before(1.0);
    let glass = desc.material(glass(0.5, 0.5).into());
    let desc = [1.0, 0.8, 0.6].into_iter().fold(desc, |desc, radius| desc.with_shared(ball(radius), glass));
    let (_, stats) = render(&desc.sized([4, 4]));
    assert!(stats.dropped > 0 && stats.dropped <= 16);
    assert!(stats.total() < 16 * 17_000);
}

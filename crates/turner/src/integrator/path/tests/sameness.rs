//! The same image, to the last bit, for any number of threads and passes, and scaled exactly with brightness.

use crate::camera::ThinLensDesc;
use crate::description::SceneDesc;
use crate::integrator::PathDesc;
use crate::material::{AlphaMode, PrincipledMaterial};
use crate::math::DVec3;
use crate::testing::scenes::{grey, lamp, path, pixel, plane, rectangle, render, render_with, sphere, v};
use crate::texture::{CheckerboardDesc, TextureDesc};

/// A ball of rough glass, a half-transparent sheet and two lights of this brightness over a checkerboard, seen through
/// a lens.
fn scene(bright: f64) -> SceneDesc {
    let camera = ThinLensDesc {
        position: v(0.0, 1.0, 4.0),
        look_at: v(0.0, 0.5, 0.0),
        fov: Some(40.0),
        focus_distance: Some(4.0),
        lens_radius: 0.05,
        ..ThinLensDesc::default()
    };
    let glass = PrincipledMaterial {
        transmission_weight: grey(1.0),
        specular_roughness: grey(0.1),
        ..PrincipledMaterial::default()
    };
    let sheet = PrincipledMaterial {
        alpha_mode: AlphaMode::Blend,
        opacity: grey(0.5),
        double_sided: false,
        ..PrincipledMaterial::default()
    };
    let emitter_list = PrincipledMaterial { emission_luminance: bright, ..PrincipledMaterial::default() };
    let mut desc = path(PathDesc { max_depth: 6, ..PathDesc::default() })
        .seen(camera)
        .filmed([50, 37], 6)
        .lit(lamp(v(2.0, 3.0, 2.0), bright));
    let base_color = desc.texture(TextureDesc::Checkerboard(CheckerboardDesc::default()));
    desc.with(plane(), PrincipledMaterial { base_color, ..PrincipledMaterial::default() })
        .with(sphere(v(0.0, 0.5, 0.0), 0.5), glass)
        .with(rectangle(v(-0.5, 0.8, 0.7), DVec3::X, v(0.0, 1.0, 0.2)), sheet)
        .with(sphere(v(1.0, 1.5, -1.0), 0.3), emitter_list)
}

#[test]
fn any_number_of_threads_and_any_split_into_passes() {
    let desc = scene(4.0);
    let (first, stats) = render_with(&desc, 1, u32::MAX);
    for (threads, pass) in [(2, u32::MAX), (7, 1), (2, 4), (1, 5)] {
        let (again, counted) = render_with(&desc, threads, pass);
        assert!(first.linear == again.linear, "{threads} threads, passes of {pass}");
        assert_eq!(stats, counted);
    }
    // The image is not black.
    assert!(first.linear.iter().any(|p| p[0] > 0.1));
}

/// A crop has the same pixels as the full image: no sample depends on its neighbours.
#[test]
fn a_crop_equals_its_part_of_the_image() {
    let mut desc = scene(4.0);
    let whole = render(&desc).0;
    desc.film.crop = Some([13, 9, 11, 7]);
    let part = render(&desc).0;
    for y in 0..7 {
        for x in 0..11 {
            assert_eq!(pixel(&part, x, y), pixel(&whole, x + 13, y + 9), "{x}, {y}");
        }
    }
}

#[test]
fn twice_the_light_is_twice_the_picture() {
    // The end of a path does not depend on the brightness of lights, and scaling by a power of two is exact.
    let one = render(&scene(4.0)).0;
    let two = render(&scene(8.0)).0;
    for (a, b) in one.linear.iter().zip(&two.linear) {
        for i in 0..3 {
            // The film's fixed-point sums have a smallest step.
            assert!((2.0 * a[i] - b[i]).abs() <= 1e-6 * b[i].abs() + 1e-13, "{a:?} {b:?}");
        }
    }
}

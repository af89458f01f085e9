//! Tests of texture filtering: a checkerboard to the horizon, mappings, bump and normal maps.

use std::sync::Arc;

use super::{
    Axis, CheckerboardDesc, Encoding, GradientDesc, ImageDesc, ImageFilter, Mapping, NoiseDesc, StripesDesc,
    TextureDesc,
};
use crate::camera::PixelCone;
use crate::description::{ObjectDesc, SceneDesc};
use crate::film::{Antialias, Picture, TextureFilter};
use crate::image::{Image, Pixels};
use crate::integrator::{IntegratorDesc, PathDesc, Prepared};
use crate::material::{Bump, BumpUnit, ClassicMaterial, PrincipledMaterial, bumped_normal, mapped_normal};
use crate::math::{DAffine3, DVec3, Ray};
use crate::scene::{Scene, SurfaceInteraction};
use crate::schema::{Asset, ColorSource, ImageId, MeshData, PrepareOptions, TextureId};
use crate::shape::{BoxDesc, ShapeDesc};
use crate::testing::scenes::{cuboid, grey, path, pixel, placed, plane, rectangle, render, sphere, v};

/// An image of 8 × 8 texels.
fn picture(at: impl Fn(u32, u32) -> [u8; 3]) -> Image {
    let samples = (0..64).flat_map(|i| at(i % 8, i / 8)).collect();
    Image { width: 8, height: 8, channels: 3, pixels: Pixels::U8(samples) }
}

fn with_picture(mut desc: SceneDesc, image: &Image) -> SceneDesc {
    desc.images.push(Asset { uri: String::new(), data: Arc::new(image.clone()) });
    desc
}

fn prepared(desc: &SceneDesc) -> Prepared {
    desc.prepare(&PrepareOptions { threads: 1, ..Default::default() }).unwrap()
}

/// An unlit plane to the horizon, at a grazing angle.
fn ground(color: impl Fn(&mut SceneDesc) -> ColorSource) -> SceneDesc {
    let mut desc = path(PathDesc::default())
        .before(0.5)
        .seen_at(v(0.0, 1.0, 0.0), v(0.3, 0.9, -1.0), 40.0)
        .sized([160, 90]);
    desc.film.crop = Some([0, 32, 160, 58]);
    let base_color = color(&mut desc);
    desc.with(plane(), PrincipledMaterial { unlit: true, base_color, ..PrincipledMaterial::default() })
}

fn horizon(texture: TextureDesc) -> SceneDesc {
    ground(|desc| desc.texture(texture.clone()))
}

fn board(density: f64) -> TextureDesc {
    TextureDesc::Checkerboard(CheckerboardDesc { density, ..CheckerboardDesc::default() })
}

/// Rendered at one sample per pixel.
fn show(desc: &SceneDesc, texture_filter: TextureFilter) -> Picture {
    let mut desc = desc.clone();
    desc.film.texture_filter = texture_filter;
    render(&desc).0
}

/// Rendered at many samples per pixel.
fn show_finely(desc: &SceneDesc, samples: u32, texture_filter: TextureFilter) -> Picture {
    let mut desc = desc.clone();
    (desc.film.antialias, desc.film.samples) = (Antialias::Grid, samples);
    show(&desc, texture_filter)
}

/// The root mean square of the differences in some rows of the cropped picture, and the largest difference.
fn difference(a: &Picture, b: &Picture, rows: std::ops::Range<u32>) -> (f64, f64) {
    let (mut sum, mut most, mut count) = (0.0, 0.0_f64, 0.0);
    for y in rows {
        for x in 0..a.width {
            let d = f64::from(pixel(a, x, y)[0]) - f64::from(pixel(b, x, y)[0]);
            (sum, most, count) = (sum + d * d, most.max(d.abs()), count + 1.0);
        }
    }
    ((sum / count).sqrt(), most)
}

/// Compares one filtered sample per pixel with 1024 unfiltered ones.
fn against_reference(desc: &SceneDesc, rms: f64, most: f64) {
    let one = show(desc, TextureFilter::Auto);
    let points = show(desc, TextureFilter::Off);
    let reference = show_finely(desc, 1024, TextureFilter::Off);
    // The horizon is at about row 6 of the crop; the rows below it hold hundreds of squares per pixel.
    let far = 10..20;
    let (filtered, worst) = difference(&one, &reference, far.clone());
    let (aliased, _) = difference(&points, &reference, far);
    println!("far: filtered {filtered:.4} (at most {worst:.4}), points {aliased:.4}");
    assert!(filtered < rms && worst < most, "filtered {filtered}, at most {worst}");
    assert!(aliased > 0.3, "unfiltered: {aliased}");
    // Nearby, edges are blurred over one pixel in both.
    let (filtered, worst) = difference(&one, &reference, 20..58);
    let (aliased, _) = difference(&points, &reference, 20..58);
    println!("near: filtered {filtered:.4} (at most {worst:.4}), points {aliased:.4}");
    assert!(filtered < 0.6 * aliased, "near: {filtered}, points {aliased}");
}

#[test]
fn a_checkerboard_to_the_horizon_has_no_moire_at_one_sample() {
    against_reference(&horizon(board(4.0)), 0.02, 0.08);
}

#[test]
fn an_image_of_a_checkerboard_has_none_either() {
    let squares = picture(|x, y| [if (x / 4 + y / 4) % 2 == 0 { 255 } else { 0 }; 3]);
    let texture = ImageDesc { file: ImageId(0), density: 2.0, ..ImageDesc::default() };
    against_reference(&with_picture(horizon(TextureDesc::Image(texture)), &squares), 0.03, 0.15);
}

#[test]
fn noise_and_stripes_become_uniform_far_away() {
    for texture in [
        TextureDesc::Stripes(StripesDesc { density: 9.0, axis: Axis::Y, ..StripesDesc::default() }),
        TextureDesc::Noise(NoiseDesc { density: 30.0, contrast: 4.0, ..NoiseDesc::default() }),
    ] {
        let name = texture.type_name();
        let far = show(&horizon(texture), TextureFilter::Auto);
        let values: Vec<f64> = (9..13)
            .flat_map(|y| (0..160).map(move |x| (x, y)))
            .map(|(x, y)| f64::from(pixel(&far, x, y)[0]))
            .collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let spread = values.iter().map(|v| (v - mean).abs()).fold(0.0, f64::max);
        assert!((mean - 0.5).abs() < 0.05 && spread < 0.1, "{name}: {mean} ± {spread}");
    }
}

#[test]
fn many_samples_keep_textures_sharp() {
    let [on, off] = [TextureFilter::Auto, TextureFilter::Off]
        .map(|filter| show_finely(&horizon(board(1.0)), 256, filter));
    let (rms, most) = difference(&on, &off, 10..58);
    assert!(rms < 0.01 && most < 0.1, "{rms}, at most {most}");
}

#[test]
fn the_classic_integrator_filters_when_asked() {
    let path = horizon(board(4.0));
    let classic = SceneDesc { integrator: IntegratorDesc::Classic(Default::default()), ..path.clone() };
    let [auto, off, on] = [TextureFilter::Auto, TextureFilter::Off, TextureFilter::On]
        .map(|filter| show(&classic, filter).linear);
    assert!(auto == off);
    assert!(on == show(&path, TextureFilter::Auto).linear);
}

/// Views have a pixel cone if the scene has textures to filter.
#[test]
fn views_have_pixel_cones_if_there_are_textures() {
    assert_eq!(prepared(&ground(|_| grey(0.5))).view.pixel_cone, None);
    let Prepared { view, .. } = prepared(&horizon(board(1.0)));
    assert_eq!(view.pixel_cone, Some(PixelCone::new(&view.camera, &view.film)));
}

/// The surface that a ray hits.
fn hit_surface(scene: &Scene, origin: DVec3, direction: DVec3) -> SurfaceInteraction {
    let ray = Ray::new(origin, direction);
    let hit = scene.intersect(&ray).unwrap();
    scene.surface(&ray, &hit)
}

/// The first texture of the scene.
const TEXTURE: ColorSource = ColorSource::Texture(TextureId(0));

/// An object with a texture, for the classic integrator.
fn textured(mut desc: SceneDesc, texture: TextureDesc, object: ObjectDesc) -> SceneDesc {
    let color = desc.texture(texture);
    desc.with_object(object, ClassicMaterial { color, ..ClassicMaterial::default() })
}

#[test]
fn a_bumped_slope_has_the_normal_of_the_slope() {
    // Heights that rise by one half per unit of x, times 0.6: a slope of 0.3.
    let sloped = |desc: SceneDesc, object: ObjectDesc, mapping| {
        let ramp = TextureDesc::Gradient(GradientDesc { mapping, ..GradientDesc::default() });
        prepared(&textured(desc, ramp, object)).scene
    };
    let expected = v(-0.3, 1.0, 0.0).normalize();
    let mut desc = SceneDesc::default();
    let mesh = desc.mesh(MeshData {
        positions: vec![[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 0.0, -1.0]],
        uvs: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..MeshData::default()
    });
    let square = rectangle(DVec3::ZERO, v(2.0, 0.0, 0.0), v(0.0, 0.0, -2.0));
    let cube = cuboid(v(-1.0, -2.0, -1.0), v(1.0, 0.0, 1.0));
    let seen = |scene: &Scene| hit_surface(scene, v(0.3, 2.0, -0.2), DVec3::NEG_Y);
    for shape in [plane(), square.clone(), mesh, cube] {
        let name = shape.type_name();
        for mapping in [Mapping::Uv, Mapping::Solid, Mapping::Triplanar] {
            let scene = sloped(desc.clone(), ObjectDesc::new(shape.clone()), mapping);
            let bump = Bump { map: TEXTURE, scale: 0.6, unit: BumpUnit::Scene };
            let mut surface = seen(&scene);
            for width in [0.0, 0.01, 0.1] {
                surface.see(DVec3::NEG_Y, width);
                let n = bumped_normal(&*scene, &surface, bump);
                assert!((n - expected).length() < 1e-5, "{name} {mapping:?} {width}: {n}");
            }
            if mapping == Mapping::Uv {
                // A tile is two units wide.
                let bump = Bump { scale: 0.3, unit: BumpUnit::Tile, ..bump };
                let n = bumped_normal(&*scene, &surface, bump);
                assert!((n - expected).length() < 1e-5, "{name}: {n}");
            }
        }
    }
    // Heights are in scene units, also on a scaled object: there the ramp is twice as long.
    let large = placed(square, DAffine3::from_scale(DVec3::splat(2.0)));
    let scene = sloped(desc, large, Mapping::Uv);
    let bump = Bump { map: TEXTURE, scale: 1.2, unit: BumpUnit::Scene };
    let n = bumped_normal(&*scene, &seen(&scene), bump);
    assert!((n - expected).length() < 1e-5, "{n}");
}

/// A shape with an image of linear values.
fn shown(image: &Image, texture: ImageDesc, shape: ShapeDesc) -> Arc<Scene> {
    let texture = TextureDesc::Image(ImageDesc { encoding: Encoding::Linear, ..texture });
    let desc = textured(SceneDesc::default(), texture, ObjectDesc::new(shape));
    prepared(&with_picture(desc, image)).scene
}

#[test]
fn normal_maps_follow_their_mapping() {
    // 0.6 to the right, 0.8 outwards.
    let tilted = picture(|_, _| [204, 128, 230]);
    let ball = || sphere(DVec3::ZERO, 1.0);
    let cube = ShapeDesc::Box(BoxDesc::default());
    let cases = [
        // Around the sphere u grows to the right, seen from outside.
        (ball(), Mapping::Uv, v(0.0, 0.0, 5.0), DVec3::X, DVec3::Z),
        (ball(), Mapping::Uv, v(5.0, 0.0, 0.0), DVec3::NEG_Z, DVec3::X),
        (ball(), Mapping::Spherical, v(5.0, 0.0, 0.0), DVec3::NEG_Z, DVec3::X),
        (ball(), Mapping::Cylindrical, v(-5.0, 0.0, 0.0), DVec3::Z, DVec3::NEG_X),
        (ball(), Mapping::Triplanar, v(0.0, 0.0, 5.0), DVec3::X, DVec3::Z),
        (ball(), Mapping::Triplanar, v(0.0, 5.0, 0.0), DVec3::X, DVec3::Y),
        (ball(), Mapping::Planar, v(0.0, 0.0, 5.0), DVec3::X, DVec3::Z),
        (plane(), Mapping::Uv, v(0.0, 5.0, 0.0), DVec3::X, DVec3::Y),
        (cube, Mapping::Triplanar, v(0.3, 0.2, -5.0), DVec3::NEG_X, DVec3::NEG_Z),
    ];
    for (shape, mapping, from, tangent, n) in cases {
        let name = shape.type_name();
        let scene = shown(&tilted, ImageDesc { mapping, ..ImageDesc::default() }, shape);
        let surface = hit_surface(&scene, from, -from.normalize());
        let found = mapped_normal(&*scene, &surface, TEXTURE, 1.0).unwrap();
        let expected = 0.6 * tangent + 0.8 * n;
        // The image has 256 steps, and the ray hits the box at an angle.
        assert!((found - expected).length() < 0.02, "{name} {mapping:?} {from:?}: {found} {expected}");
    }
}

#[test]
fn mappings_reach_known_texels() {
    // Columns in red, rows in green.
    let picture = picture(|x, y| [(x * 30) as u8, (y * 30) as u8, 0]);
    let color = |mapping, direction: DVec3| {
        let texture = ImageDesc { filter: ImageFilter::Nearest, mapping, ..ImageDesc::default() };
        let scene = shown(&picture, texture, sphere(DVec3::ZERO, 1.0));
        let from = 5.0 * direction.normalize();
        let surface = hit_surface(&scene, from, -from.normalize());
        let c = scene.textures.color(TEXTURE, &scene.texture_point(&surface));
        [c.r, c.g].map(|v| (v * 255.0 / 30.0).round())
    };
    // Slightly right of and above the centre of the front: column 4, row 3 (from the top).
    for mapping in
        [Mapping::Uv, Mapping::Planar, Mapping::Spherical, Mapping::Cylindrical, Mapping::Triplanar]
    {
        assert_eq!(color(mapping, v(0.1, 0.1, 1.0)), [4.0, 3.0], "{mapping:?}");
    }
    // On the right, at three quarters of the circumference; a projection along z sees the image's edge there.
    for mapping in [Mapping::Uv, Mapping::Spherical, Mapping::Cylindrical] {
        assert_eq!(color(mapping, v(1.0, 0.1, 0.05)), [5.0, 3.0], "{mapping:?}");
    }
    assert_eq!(color(Mapping::Planar, v(1.0, 0.1, 0.05)), [7.0, 3.0]);
    // Triplanar from the right: slightly left of the centre, because z points to the left.
    assert_eq!(color(Mapping::Triplanar, v(1.0, 0.1, 0.1)), [3.0, 3.0]);
}

//! Textures by what a sample covers of them: a board to the horizon, mappings and relief.

use std::path::Path;

use turner::camera::PixelCone;
use turner::film::Picture;
use turner::integrator::Prepared;
use turner::material::{Bump, BumpUnit};
use turner::math::{DVec3, Ray};
use turner::scene::{Scene, SurfaceInteraction};
use turner::schema::{ColorSource, PrepareOptions, TextureId};
use turner_io::assets::MemoryAssets;
use turner_io::image::{Display, ImageFormat, Metadata, OutputImage, Transfer, encode};
use turner_io::scene::{LoadOptions, load_text};

use crate::classic::common::{pixel, render_with};

/// A file of a picture of 8 × 8 texels.
fn file(at: impl Fn(u32, u32) -> [u8; 3]) -> Vec<u8> {
    let pixels: Vec<[u8; 4]> = (0..64)
        .map(|i| {
            let [r, g, b] = at(i % 8, i / 8);
            [r, g, b, 255]
        })
        .collect();
    let metadata = Metadata::new();
    let image = OutputImage {
        width: 8,
        height: 8,
        alpha: false,
        linear: None,
        display: Some(Display::U8(&pixels)),
        transfer: Transfer::Srgb,
        metadata: &metadata,
        threads: 1,
    };
    encode(&image, ImageFormat::of_path(Path::new("a.png")).unwrap()).unwrap()
}

fn prepared(text: &str, pictures: &[(&str, Vec<u8>)]) -> (turner::description::SceneDesc, Prepared) {
    let mut assets = MemoryAssets::default();
    for (name, bytes) in pictures {
        assets.files.insert((*name).to_owned(), bytes.clone());
    }
    let loaded = load_text(text.to_owned(), "test.toml", &assets, &LoadOptions::default());
    let desc = loaded.unwrap_or_else(|e| panic!("{e}\n{text}")).desc;
    let scene = desc.prepare(&PrepareOptions { threads: 1, ..Default::default() }).unwrap();
    (desc, scene)
}

/// A plane to the horizon, seen slantwise, from which only the texture's own colour comes.
fn horizon(film: &str, texture: &str) -> String {
    format!(
        "integrator = {{ type = \"path\" }}\nbackground = {{ color = 0.5 }}\n\
         camera = {{ position = [0, 1, 0], look_at = [0.3, 0.9, -1], fov = 40 }}\n\
         film = {{ width = 160, height = 90, crop = [0, 32, 160, 58], {film} }}\n\
         object = [{{ type = \"plane\", material = {{ type = \"principled\", unlit = true, base_color = {texture} }} }}]\n"
    )
}

fn show(text: &str, pictures: &[(&str, Vec<u8>)]) -> Picture {
    render_with(&prepared(text, pictures).0, 2, u32::MAX).0
}

/// The root of the mean square of the differences in some rows of the cropped picture, and the largest difference.
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

/// One sample per pixel, filtered, beside 1024 at points.
fn against_reference(texture: &str, pictures: &[(&str, Vec<u8>)], rms: f64, most: f64) {
    let one = show(&horizon("antialias = \"none\"", texture), pictures);
    let points = show(&horizon("antialias = \"none\", texture_filter = \"off\"", texture), pictures);
    let many = "antialias = \"grid\", samples = 1024, texture_filter = \"off\"";
    let reference = show(&horizon(many, texture), pictures);
    // The horizon lies in row 6 or so of the crop; the rows below it hold hundreds of squares per pixel.
    let far = 10..20;
    let (filtered, worst) = difference(&one, &reference, far.clone());
    let (aliased, _) = difference(&points, &reference, far);
    println!("far: filtered {filtered:.4} (at most {worst:.4}), points {aliased:.4}");
    assert!(filtered < rms && worst < most, "filtered {filtered}, at most {worst}");
    assert!(aliased > 0.3, "points alone: {aliased}");
    // Near, edges are one pixel soft in both.
    let (filtered, worst) = difference(&one, &reference, 20..58);
    let (aliased, _) = difference(&points, &reference, 20..58);
    println!("near: filtered {filtered:.4} (at most {worst:.4}), points {aliased:.4}");
    assert!(filtered < 0.6 * aliased, "near: {filtered}, points {aliased}");
}

#[test]
fn a_chessboard_to_the_horizon_has_no_moire_at_one_sample() {
    against_reference("{ type = \"chessboard\", density = 4 }", &[], 0.02, 0.08);
}

#[test]
fn a_picture_of_a_board_has_none_either() {
    let squares = file(|x, y| [if (x / 4 + y / 4) % 2 == 0 { 255 } else { 0 }; 3]);
    let texture = "{ type = \"image\", file = \"squares.png\", density = 2 }";
    against_reference(texture, &[("squares.png", squares)], 0.03, 0.15);
}

#[test]
fn noise_and_stripes_become_even_far_away() {
    for texture in [
        "{ type = \"stripes\", density = 9, axis = \"y\" }",
        "{ type = \"noise\", density = 30, contrast = 4 }",
    ] {
        let far = show(&horizon("antialias = \"none\"", texture), &[]);
        let values: Vec<f64> = (9..13)
            .flat_map(|y| (0..160).map(move |x| (x, y)))
            .map(|(x, y)| f64::from(pixel(&far, x, y)[0]))
            .collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let spread = values.iter().map(|v| (v - mean).abs()).fold(0.0, f64::max);
        assert!((mean - 0.5).abs() < 0.05 && spread < 0.1, "{texture}: {mean} ± {spread}");
    }
}

#[test]
fn many_samples_keep_pictures_as_sharp_as_they_were() {
    let texture = "{ type = \"chessboard\", density = 1 }";
    let film = |filter: &str| format!("antialias = \"grid\", samples = 256, texture_filter = \"{filter}\"");
    let (on, off) = (show(&horizon(&film("auto"), texture), &[]), show(&horizon(&film("off"), texture), &[]));
    let (rms, most) = difference(&on, &off, 10..58);
    assert!(rms < 0.01 && most < 0.1, "{rms}, at most {most}");
}

#[test]
fn the_classic_integrator_filters_when_asked() {
    let classic = |filter: &str| {
        let text = horizon(
            &format!("antialias = \"none\", texture_filter = \"{filter}\""),
            "{ type = \"chessboard\", density = 4 }",
        );
        show(&text.replace("type = \"path\"", "type = \"classic\""), &[])
    };
    let (auto, off, on) = (classic("auto"), classic("off"), classic("on"));
    assert!(auto.linear == off.linear);
    let path = show(&horizon("antialias = \"none\"", "{ type = \"chessboard\", density = 4 }"), &[]);
    assert!(on.linear == path.linear);
}

/// Scenes are filtered by one of 16 samples' cones: what is seen of a mirror's texture is as wide as what is seen of the thing itself.
#[test]
fn cones_are_made_where_textures_are() {
    let (_, plain) = prepared(&horizon("antialias = \"none\"", "0.5"), &[]);
    assert_eq!(plain.view.pixel_cone, None);
    let (_, scene) = prepared(&horizon("antialias = \"none\"", "{ type = \"chessboard\" }"), &[]);
    let view = &scene.view;
    assert_eq!(view.pixel_cone, Some(PixelCone::new(&view.camera, &view.film)));
}

/// The surface that a ray downwards or into the picture meets.
fn met(scene: &Scene, origin: [f64; 3], direction: [f64; 3]) -> SurfaceInteraction {
    let ray = Ray::new(DVec3::from(origin), DVec3::from(direction));
    let hit = scene.intersect(&ray).unwrap();
    scene.surface(&ray, &hit)
}

#[test]
fn a_bumped_slope_has_the_normal_of_the_slope() {
    // Heights that rise by one half per unit of x, times 0.6: a slope of 0.3.
    let ramp = "texture.ramp = { type = \"gradient\", mapping = \"MAPPING\" }\nobject = [SHAPE]\n";
    let material = "material = { color = \"ramp\" }";
    let expected = DVec3::new(-0.3, 1.0, 0.0).normalize();
    let plane = format!("{{ type = \"plane\", {material} }}");
    let square = format!("{{ type = \"rectangle\", edge_u = [2, 0, 0], edge_v = [0, 0, -2], {material} }}");
    let mesh = format!(
        "{{ type = \"mesh\", positions = [[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]], uvs = [[0, 0], [1, 0], [1, 1], [0, 1]], triangles = [[0, 1, 2], [0, 2, 3]], {material} }}"
    );
    let cube = format!("{{ type = \"box\", min = [-1, -2, -1], max = [1, 0, 1], {material} }}");
    for shape in [&plane, &square, &mesh, &cube] {
        for mapping in ["uv", "solid", "triplanar"] {
            let (_, Prepared { scene, .. }) =
                prepared(&ramp.replace("SHAPE", shape).replace("MAPPING", mapping), &[]);
            let bump = Bump { map: ColorSource::Texture(TextureId(0)), scale: 0.6, unit: BumpUnit::Scene };
            let mut surface = met(&scene, [0.3, 2.0, -0.2], [0.0, -1.0, 0.0]);
            for width in [0.0, 0.01, 0.1] {
                surface.see(DVec3::NEG_Y, width);
                let n = turner::material::bumped_normal(&*scene, &surface, bump);
                assert!((n - expected).length() < 1e-5, "{shape} {mapping} {width}: {n}");
            }
            if mapping == "uv" {
                // A tile is two units wide.
                let n = turner::material::bumped_normal(
                    &*scene,
                    &surface,
                    Bump { scale: 0.3, unit: BumpUnit::Tile, ..bump },
                );
                assert!((n - expected).length() < 1e-5, "{shape}: {n}");
            }
        }
    }
    // Scaled by its object, heights stay those of the scene: the ramp is twice as long.
    let large = square.replace("edge_u", "transform = { scale = 2 }, edge_u");
    let (_, Prepared { scene, .. }) = prepared(&ramp.replace("SHAPE", &large).replace("MAPPING", "uv"), &[]);
    let bump = Bump { map: ColorSource::Texture(TextureId(0)), scale: 1.2, unit: BumpUnit::Scene };
    let n = turner::material::bumped_normal(&*scene, &met(&scene, [0.3, 2.0, -0.2], [0.0, -1.0, 0.0]), bump);
    assert!((n - expected).length() < 1e-5, "{n}");
}

#[test]
fn normal_maps_lie_as_their_mapping_does() {
    // 0.6 to the right, 0.8 outwards.
    let tilted = file(|_, _| [204, 128, 230]);
    let text = |shape: &str, mapping: &str| {
        format!(
            "texture.n = {{ type = \"image\", file = \"n.png\", encoding = \"linear\", mapping = \"{mapping}\" }}\n\
             object = [{{ type = \"{shape}\", material = {{ color = \"n\" }} }}]\n"
        )
    };
    let cases = [
        // Around the sphere u grows to the right, seen from outside.
        ("sphere", "uv", [0.0, 0.0, 5.0], DVec3::X, DVec3::Z),
        ("sphere", "uv", [5.0, 0.0, 0.0], DVec3::NEG_Z, DVec3::X),
        ("sphere", "spherical", [5.0, 0.0, 0.0], DVec3::NEG_Z, DVec3::X),
        ("sphere", "cylindrical", [-5.0, 0.0, 0.0], DVec3::Z, DVec3::NEG_X),
        ("sphere", "triplanar", [0.0, 0.0, 5.0], DVec3::X, DVec3::Z),
        ("sphere", "triplanar", [0.0, 5.0, 0.0], DVec3::X, DVec3::Y),
        ("sphere", "planar", [0.0, 0.0, 5.0], DVec3::X, DVec3::Z),
        ("plane", "uv", [0.0, 5.0, 0.0], DVec3::X, DVec3::Y),
        ("box", "triplanar", [0.3, 0.2, -5.0], DVec3::NEG_X, DVec3::NEG_Z),
    ];
    for (shape, mapping, from, tangent, n) in cases {
        let (_, Prepared { scene, .. }) = prepared(&text(shape, mapping), &[("n.png", tilted.clone())]);
        let surface = met(&scene, from, (-DVec3::from(from).normalize()).to_array());
        let found =
            turner::material::mapped_normal(&*scene, &surface, ColorSource::Texture(TextureId(0)), 1.0)
                .unwrap();
        let expected = 0.6 * tangent + 0.8 * n;
        // The picture has 256 steps, and the ray to the box runs slantwise.
        assert!((found - expected).length() < 0.02, "{shape} {mapping} {from:?}: {found} {expected}");
    }
}

#[test]
fn mappings_look_up_known_places() {
    // Columns in red, rows in green.
    let picture = file(|x, y| [(x * 30) as u8, (y * 30) as u8, 0]);
    let color = |mapping: &str, from: [f64; 3]| {
        let text = format!(
            "texture.t = {{ type = \"image\", file = \"t.png\", filter = \"nearest\", encoding = \"linear\", mapping = \"{mapping}\" }}\n\
             object = [{{ type = \"sphere\", material = {{ color = \"t\" }} }}]\n"
        );
        let (_, Prepared { scene, .. }) = prepared(&text, &[("t.png", picture.clone())]);
        let surface = met(&scene, from, (-DVec3::from(from).normalize()).to_array());
        let c = scene.textures.color(ColorSource::Texture(TextureId(0)), &scene.texture_point(&surface));
        [c.r, c.g].map(|v| (v * 255.0 / 30.0).round())
    };
    let slightly = |x: f64, y: f64, z: f64| (5.0 * DVec3::new(x, y, z).normalize()).to_array();
    // A little right of and above the middle of the front: column 4, row 3 (from the top).
    for mapping in ["uv", "planar", "spherical", "cylindrical", "triplanar"] {
        assert_eq!(color(mapping, slightly(0.1, 0.1, 1.0)), [4.0, 3.0], "{mapping}");
    }
    // To the right, three quarters of the way around; a projector along z sees the picture's edge there.
    for mapping in ["uv", "spherical", "cylindrical"] {
        assert_eq!(color(mapping, slightly(1.0, 0.1, 0.05)), [5.0, 3.0], "{mapping}");
    }
    assert_eq!(color("planar", slightly(1.0, 0.1, 0.05)), [7.0, 3.0]);
    // From the right, triplanar: a little left of the middle, for z points to the left.
    assert_eq!(color("triplanar", slightly(1.0, 0.1, 0.1)), [3.0, 3.0]);
}

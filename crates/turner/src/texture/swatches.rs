//! Swatch pictures of every texture for visual inspection. `cargo test -p turner swatches -- --ignored` writes one
//! per texture to the system's temporary folder: a plane over −1..1 and a sphere.

use std::io::Write;

use super::tests::{read, text};
use super::*;
use crate::color::Transfer;
use crate::image::{Image, Pixels};
use crate::schema::value::Data;
use crate::shape::Sphere;

const SIZE: u32 = 320;

/// A plane (left) and a sphere (right), as 8-bit samples.
fn draw(textures: &Textures) -> Image {
    let light = DVec3::new(-0.45, 0.6, 0.66).normalize();
    let mut samples = Vec::new();
    for y in 0..SIZE {
        for x in 0..2 * SIZE {
            let place = |i: u32| 2.0 * (f64::from(i % SIZE) + 0.5) / f64::from(SIZE) - 1.0;
            let (s, t) = (place(x), -place(y));
            let mut shade = 1.0;
            let (uv, p) = if x < SIZE {
                (DVec2::new(0.5 + 0.5 * s, 0.5 + 0.5 * t), DVec3::new(s, t, 0.0))
            } else {
                let z = (1.0 - 1.08 * (s * s + t * t)).max(0.0).sqrt();
                let n = DVec3::new(s, t, z).normalize();
                shade = if z > 0.0 { 0.25 + 0.75 * n.dot(light).max(0.0) } else { 0.0 };
                (Sphere::uv(n), n)
            };
            let c = textures.eval(TextureId(0), &TexturePoint::new(uv, p)) * shade as f32;
            samples.extend(c.to_array().map(|v| (v.clamp(0.0, 1.0) * 255.0).round() as u8));
        }
    }
    Image { width: 2 * SIZE, height: SIZE, channels: 3, pixels: Pixels::U8(samples) }
}

#[test]
#[ignore = "writes pictures"]
fn swatches() {
    let noise = |kind| vec![("kind", text(kind))];
    for (file, name, keys) in [
        ("constant", "constant", vec![("color", text("tomato"))]),
        ("image", "image", vec![("file", text("picture.png"))]),
        ("checkerboard", "checkerboard", vec![]),
        ("stripes", "stripes", vec![("density", Data::Integer(4)), ("smooth", Data::Number(0.2))]),
        ("gradient", "gradient", vec![("kind", text("radial"))]),
        ("wood", "wood", vec![]),
        ("wood-uv", "wood", vec![("mapping", text("uv")), ("seed", Data::Integer(3))]),
        ("marble", "marble", vec![]),
        ("marble-fine", "marble", vec![("density", Data::Integer(3)), ("seed", Data::Integer(3))]),
        ("fbm", "noise", noise("fbm")),
        ("turbulence", "noise", noise("turbulence")),
        ("plain", "noise", [noise("plain"), vec![("density", Data::Integer(8))]].concat()),
    ] {
        let scene = read(name, &keys).expect("valid keys");
        let textures =
            Textures::prepare(&scene.textures, &scene.images, Transfer::None, false).expect("prepared");
        let path = std::env::temp_dir().join(format!("turner-{file}.ppm"));
        let image = draw(&textures);
        let Pixels::U8(samples) = &image.pixels else { unreachable!() };
        let mut file = std::fs::File::create(&path).expect("temporary folder");
        writeln!(file, "P6 {} {} 255", image.width, image.height).expect("written");
        file.write_all(samples).expect("written");
        println!("{}", path.display());
    }
}

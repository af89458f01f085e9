//! The five classic documents: compares the renderer with literal transcriptions of their pseudocode.

use turner::description::SceneDesc;
use turner::film::Picture;
use turner::math::DVec3 as V;
use turner::sampler::SampleId;

use crate::classic::common::describe;
use crate::classic::oracle::{World, document_000, document_001, document_003, document_004};

fn render(desc: &SceneDesc) -> Picture {
    crate::classic::common::render_with(desc, 2, u32::MAX).0
}

/// Asserts that at least 99 % of the pixels agree within 1/255 in every channel.
fn agree(name: &str, desc: &SceneDesc, oracle: impl Fn(&World, V) -> V) {
    let world = World::of(desc);
    let picture = render(desc);
    let (mut off, mut lit) = (0, 0);
    for y in 0..picture.height {
        for x in 0..picture.width {
            let expected = oracle(&world, world.direction(x, y)).clamp(V::ZERO, V::ONE);
            let [r, g, b, _] = picture.linear[(y * picture.width + x) as usize];
            let got = V::new(f64::from(r), f64::from(g), f64::from(b)).clamp(V::ZERO, V::ONE);
            off += u32::from((expected - got).abs().max_element() > 1.0 / 255.0);
            lit += u32::from(expected.max_element() > 0.02);
        }
    }
    let pixels = picture.width * picture.height;
    assert!(lit * 4 > pixels, "{name}: the picture is nearly black, it tests nothing");
    assert!(off * 100 <= pixels, "{name}: {off} of {pixels} pixels differ by more than 1/255");
}

/// A generator of random numbers in a range for scene `n`.
fn numbers(n: u32) -> impl FnMut(f64, f64) -> f64 {
    let mut i = 0;
    move |low, high| {
        i += 1;
        low + (high - low) * SampleId { x: n, y: i, index: 0, seed: 2 }.unit_square(0).x
    }
}

/// A random scene of spheres over a plane, with every feature of a document.
fn random_scene(n: u32, settings: &str, refraction: bool, highlight: bool) -> String {
    let mut u = numbers(n);
    let mut text = format!(
        "camera = {{ position = [{:.3}, {:.3}, 8], look_at = [0, 0.8, 0], viewport = [4.8, 3.6], distance = 7 }}\n\
         film = {{ width = 96, height = 72 }}\n\
         {settings}\n\
         [[light]]\ntype = \"ambient\"\nintensity = {:.3}\n\
         [[light]]\ntype = \"directional\"\nfrom = [{:.3}, {:.3}, {:.3}]\nintensity = {:.3}\n\
         [[light]]\ntype = \"point\"\nposition = [{:.3}, {:.3}, {:.3}]\ncolor = [{:.3}, {:.3}, {:.3}]\nintensity = 0.4\n",
        u(-2.0, 2.0),
        u(1.0, 3.0),
        u(0.05, 0.3),
        u(-2.0, 2.0),
        u(1.0, 3.0),
        u(0.5, 2.0),
        u(0.2, 0.6),
        u(-4.0, 4.0),
        u(3.0, 6.0),
        u(1.0, 5.0),
        u(0.5, 1.0),
        u(0.5, 1.0),
        u(0.5, 1.0),
    );
    for i in 0..7 {
        let kind = if i == 0 {
            "type = \"plane\"".to_owned()
        } else {
            let r = u(0.3, 1.1);
            format!(
                "type = \"sphere\"\ncenter = [{:.3}, {:.3}, {:.3}]\nradius = {r:.3}",
                u(-2.5, 2.5),
                r + u(0.01, 0.8),
                u(-3.0, 2.5)
            )
        };
        let glass = refraction && i % 3 == 1;
        let (kr, kt) = if glass { (u(0.0, 0.2), u(0.5, 0.75)) } else { (u(0.0, 0.5), 0.0) };
        let ks = if highlight { u(0.0, 0.8) } else { 0.0 };
        text += &format!(
            "[[object]]\n{kind}\nmaterial = {{ color = [{:.3}, {:.3}, {:.3}], ka = K, kd = K, ks = {ks:.3}, shininess = {:.0}, k_reflect = {kr:.3}, k_refract = {kt:.3}, ior = {:.3} }}\n",
            u(0.1, 1.0), u(0.1, 1.0), u(0.1, 1.0), u(4.0, 300.0), u(1.1, 1.8),
        )
        .replace("= K", &format!("= {:.3}", u(0.3, 1.0)));
    }
    text
}

#[test]
fn document_000_program_sketch() {
    let settings = "integrator = { max_depth = 4, at_depth = \"background\", combine = \"add\", light_seen = true }\nbackground = { color = [0.2, 0.3, 0.5] }";
    for n in 0..8 {
        let desc = describe(&random_scene(n, settings, true, false));
        agree("000", &desc, |w, d| document_000(w, w.eye, d.normalize(), 0));
    }
}

#[test]
fn document_001_eight_steps() {
    let settings =
        "integrator = { max_depth = 5, at_depth = \"black\" }\nbackground = { color = [0.6, 0.7, 0.9] }";
    for n in 10..18 {
        let desc = describe(&random_scene(n, settings, true, true));
        agree("001", &desc, |w, d| document_001(w, w.eye, d.normalize(), 5));
    }
}

#[test]
fn document_003_simplistic() {
    let settings =
        "integrator = { max_depth = 4, at_depth = \"black\", miss = \"black\", combine = \"add\" }";
    for n in 20..28 {
        let desc = describe(&random_scene(n, settings, true, true));
        agree("003", &desc, |w, d| document_003(w, w.eye, d.normalize(), 4));
    }
}

fn scene_004(name: &str) -> SceneDesc {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/classic/");
    let text = std::fs::read_to_string(format!("{path}{name}")).unwrap();
    describe(&text)
}

#[test]
fn document_004_from_scratch() {
    let mut desc = scene_004("004-from-scratch.toml");
    (desc.film.width, desc.film.height) = (96, 72);
    agree("004", &desc, |w, d| document_004(w, w.eye, d, 1.0, 3));
    let mut book = scene_004("004-book.toml");
    (book.film.width, book.film.height) = (96, 96);
    agree("004 book", &book, |w, d| document_004(w, w.eye, d, 1.0, 3));
}

/// The book's picture at its published size, 600 x 600: all but a few values agree within 1/255.
#[test]
fn the_books_picture() {
    let desc = scene_004("004-book.toml");
    let world = World::of(&desc);
    let picture = render(&desc);
    let mut off = 0;
    for (i, got) in picture.display.iter().enumerate() {
        let (x, y) = (i as u32 % picture.width, i as u32 / picture.width);
        let expected = document_004(&world, world.eye, world.direction(x, y), 1.0, 3).clamp(V::ZERO, V::ONE);
        for (g, e) in got.iter().zip((expected * 255.0).to_array()) {
            off += u32::from((f64::from(*g) - e).abs() > 1.5);
        }
    }
    assert!(off <= 12, "{off} of 1,080,000 values differ");
}

#[test]
fn the_oracle_can_fail() {
    let mut desc = scene_004("004-from-scratch.toml");
    (desc.film.width, desc.film.height) = (96, 72);
    let wrong = std::panic::catch_unwind(|| agree("004", &desc, |w, d| document_004(w, w.eye, d, 1.0, 0)));
    assert!(wrong.is_err(), "without reflections the pictures must differ");
}

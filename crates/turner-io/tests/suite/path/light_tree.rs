//! The tree over many lights: the same light as by one table for all points, and as found by chance.

use std::fmt::Write;

use turner::integrator::Prepared;
use turner::light::Receiver;
use turner::math::{DVec3, Ray};
use turner::scene::LightChoice;
use turner::schema::PrepareOptions;
use turner::testing::{CompareOptions, Random, Runs, compare, render_runs};

use crate::classic::common::describe;

/// Shapes that shine, of all forms, in a hall with a floor, a wall and some balls; beside them lights, if asked for.
fn hall(shapes: u32, lights: u32, integrator: &str) -> String {
    let mut random = Random::new(11);
    let mut text = format!(
        "integrator = {{ type = \"path\", max_depth = 2, {integrator} }}\n\
         film = {{ width = 8, height = 8, antialias = \"monte-carlo\", samples = 64 }}\n\
         camera = {{ position = [0, 3, 9], look_at = [0, 0.5, 0], fov = 60 }}\n\
         [material]\n\
         floor = {{ type = \"matte\", color = 0.6 }}\n\
         gloss = {{ type = \"principled\", base_color = [0.9, 0.6, 0.2], base_metalness = 1, specular_roughness = 0.4 }}\n\
         leaf = {{ type = \"principled\", base_color = 0.7, subsurface_weight = 0.6, thin_walled = true, specular_weight = 0 }}\n\
         lamp = {{ type = \"principled\", base_weight = 0, specular_weight = 0, emission_luminance = 3, emission_color = [1, 0.8, 0.5] }}\n\
         front = {{ type = \"principled\", base_weight = 0, specular_weight = 0, emission_luminance = 4, double_sided = false }}\n\
         board = {{ type = \"emissive\", strength = 3, color = {{ type = \"chessboard\", even = [1, 0.2, 0.1], odd = 0.05, density = 9 }} }}\n"
    );
    let mut object = |what: String| writeln!(text, "[[object]]\n{what}").unwrap();
    object("type = \"plane\"\nmaterial = \"floor\"".into());
    object("type = \"plane\"\npoint = [0, 0, -6]\nnormal = [0, 0, 1]\nmaterial = \"floor\"".into());
    object("type = \"sphere\"\ncenter = [1.5, 1, 0]\nradius = 1\nmaterial = \"gloss\"".into());
    object("type = \"rectangle\"\ncenter = [-2, 1, 0]\nedge_u = [2, 0, 0.5]\nedge_v = [0, 2, 0]\nmaterial = \"leaf\"".into());
    let show = |v: DVec3| format!("[{}, {}, {}]", v.x, v.y, v.z);
    for i in 0..shapes {
        let p = DVec3::new(12.0, 2.0, 8.0) * random.in_cube() + DVec3::new(0.0, 3.5, 0.0);
        let (a, b) = (0.3 * random.direction(), 0.3 * random.direction());
        let material = ["lamp", "front", "board"][(i / 5 % 3) as usize];
        object(match i % 5 {
            0 => format!("type = \"sphere\"\ncenter = {}\nradius = 0.15\nmaterial = \"{material}\"", show(p)),
            1 => format!(
                "type = \"rectangle\"\ncenter = {}\nedge_u = {}\nedge_v = {}\nmaterial = \"{material}\"",
                show(p),
                show(a),
                show(b)
            ),
            2 => format!(
                "type = \"disk\"\ncenter = {}\nnormal = {}\nradius = 0.2\nmaterial = \"{material}\"",
                show(p),
                show(a)
            ),
            3 => format!(
                "type = \"mesh\"\npositions = [{}, {}, {}, {}]\ntriangles = [[0, 1, 2], [0, 3, 1]]\nmaterial = \"{material}\"",
                show(p),
                show(p + a),
                show(p + b),
                show(p - b)
            ),
            _ => format!(
                "type = \"points\"\npositions = [{}, {}]\nradii = [0.1, 0.05]\nmaterial = \"{material}\"",
                show(p),
                show(p + a)
            ),
        });
    }
    for i in 0..lights {
        let p = show(DVec3::new(12.0, 2.0, 8.0) * random.in_cube() + DVec3::new(0.0, 3.5, 0.0));
        let rest = match i % 4 {
            0 => "type = \"point\"\nintensity = 0.05".to_owned(),
            1 => format!(
                "type = \"spot\"\nlook_at = {}\nangle = 50\npenumbra = 20\nintensity = 0.2",
                show(3.0 * random.in_cube())
            ),
            2 => "type = \"sphere\"\nradius = 0.2\nintensity = 0.05\nsamples = 1".to_owned(),
            _ => "type = \"point\"\nintensity = 0.0005".to_owned(),
        };
        let key = if i % 4 == 2 { "center" } else { "position" };
        // Some of them do not weaken, and stand beside the tree.
        let attenuation = if i % 4 == 3 { "none" } else { "inverse-square" };
        writeln!(text, "[[light]]\n{rest}\n{key} = {p}\nattenuation = \"{attenuation}\"").unwrap();
    }
    text
}

fn prepare(text: &str, how: LightChoice) -> Prepared {
    let mut scene = describe(text).prepare(&PrepareOptions::default()).unwrap();
    std::sync::Arc::make_mut(&mut scene.scene).choose_lights(how);
    scene
}

fn runs(text: &str, how: LightChoice, samples: u32) -> Runs {
    let mut scene = prepare(text, how);
    scene.view.film.samples = samples;
    let runs = render_runs(&scene, 8, 5, 2).unwrap();
    assert_eq!(runs.non_finite.count, 0);
    runs
}

#[track_caller]
fn agree(a: &Runs, b: &Runs, cap: f64) {
    let options = CompareOptions { tolerance: 4e-6, absolute: 1e-9, ..CompareOptions::default() };
    let found = compare(a, b, &options);
    assert!(found.ratio_error <= cap, "too noisy: {found:?}");
    assert!(found.p_value > 1e-5, "{found:?}");
}

#[test]
fn a_thousand_lights_give_by_the_tree_what_they_give_by_the_table() {
    let text = hall(600, 400, "");
    assert!(prepare(&text, LightChoice::Auto).scene.emitters.tree_bytes() > 0);
    assert_eq!(prepare(&text, LightChoice::Table).scene.emitters.tree_bytes(), 0);
    let tree = runs(&text, LightChoice::Auto, 64);
    agree(&tree, &runs(&text, LightChoice::Table, 512), 0.03);
}

#[test]
fn light_sampled_by_the_tree_is_what_is_found_by_chance() {
    let (both, chance, sampled) =
        ("light_sampling = \"both\"", "light_sampling = \"bsdf\"", "light_sampling = \"light\"");
    let chance = runs(&hall(200, 0, chance), LightChoice::Auto, 1024);
    agree(&runs(&hall(200, 0, both), LightChoice::Auto, 64), &chance, 0.03);
    agree(&runs(&hall(200, 0, sampled), LightChoice::Auto, 128), &chance, 0.04);
}

#[test]
fn few_lights_stand_in_the_tree_and_one_in_the_table() {
    let two = hall(2, 0, "");
    let (auto, tree) = (runs(&two, LightChoice::Auto, 4), runs(&two, LightChoice::Tree, 4));
    assert!(auto.pictures == tree.pictures);
    let one = hall(1, 0, "");
    let (auto, table) = (runs(&one, LightChoice::Auto, 4), runs(&one, LightChoice::Table, 4));
    assert!(auto.pictures == table.pictures);
    let text = hall(20, 5, "");
    agree(&runs(&text, LightChoice::Tree, 128), &runs(&text, LightChoice::Table, 128), 0.03);
}

/// Rough metal under small lamps: chosen by its lobe they bring what they bring by the table, with less noise.
#[test]
fn glossy_surfaces_choose_lights_by_their_lobe() {
    let text = "integrator = { type = \"path\", max_depth = 3, light_sampling = \"light\" }\n\
        camera = { position = [0, 3, 4], look_at = [0, 0, -1], fov = 40 }\n\
        [film]\nwidth = 24\nheight = 16\nantialias = \"monte-carlo\"\n\
        [[object]]\ntype = \"rectangle\"\ncenter = [0, 0, 0]\nedge_u = [8, 0, 0]\nedge_v = [0, 0, -8]\n\
        material = { type = \"metal\", color = 0.9, roughness = 0.3 }\n";
    let lamp = |x: f64| {
        format!(
            "[[object]]\ntype = \"sphere\"\ncenter = [{x}, 3, -6]\nradius = 0.15\nmaterial = {{ type = \"emissive\", color = 1, strength = 30 }}\n"
        )
    };
    let text: String = std::iter::once(text.to_owned()).chain([-2.5, -0.8, 0.9, 2.6].map(lamp)).collect();
    let (tree, table) = (runs(&text, LightChoice::Auto, 64), runs(&text, LightChoice::Table, 64));
    agree(&tree, &table, 0.02);
    // Estimates of the error of the mean over all of the picture.
    let error = |runs: &Runs| (0..3).map(|band| runs.mean(band).error()).sum::<f64>();
    assert!(error(&tree) < 0.8 * error(&table), "{} {}", error(&tree), error(&table));
}

/// The density at a hit is that with which it was sampled; triangles, points and faces of boxes included.
#[test]
fn hits_know_the_density_of_samples() {
    let text = hall(300, 0, "")
        + "[[object]]\ntype = \"box\"\nmin = [-3, 2, 1]\nmax = [-2.6, 2.2, 1.5]\nmaterial = \"lamp\"\n";
    let scene = prepare(&text, LightChoice::Auto).scene;
    let mut random = Random::new(3);
    let mut seen = 0;
    for _ in 0..20_000 {
        let p = DVec3::new(6.0, 3.0, 6.0) * random.in_cube() + DVec3::new(0.0, 3.0, 0.0);
        let at =
            if random.unit() < 0.5 { Receiver::from(p) } else { Receiver::facing(p, random.direction()) };
        let Some(s) = scene.emitters.sample(&scene, at, random.units()) else { continue };
        let ray = Ray::new(p, s.to_light.normalize());
        let Some(hit) = scene.intersect(&ray) else { continue };
        if (hit.shape.t - s.to_light.length()).abs() > 1e-6 {
            continue;
        }
        seen += 1;
        let pdf = scene.emitters.pdf_hit(&scene, at, &scene.surface(&ray, &hit));
        assert!((pdf / s.pdf - 1.0).abs() < 1e-3, "{pdf} and {}", s.pdf);
    }
    assert!(seen > 2000, "{seen}");
}

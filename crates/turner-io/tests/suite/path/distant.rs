//! Light from far away with an extent, the light of a clear day, and measured lamps.

use std::f64::consts::PI;

use turner_io::assets::MemoryAssets;
use turner_io::scene::{LoadOptions, load_text};

use crate::classic::common::{describe, pixel, render, render_with};
use crate::path::statistics::{mean, mean_of};

const DOWN: &str = "camera = { position = [0, 0.2, 0], look_at = [0, 0, 0], up = [0, 0, -1], fov = 0.001 }\n";
const WAYS: [&str; 3] = ["both", "bsdf", "light"];

fn integrator(way: &str) -> String {
    format!("integrator = {{ type = \"path\", light_sampling = \"{way}\" }}\n")
}

/// A disc brings a surface what a point in its middle brings, as long as all of it is above the surface.
#[test]
fn a_disc_in_the_sky_lights_a_matte_plane_as_a_point_does() {
    let plane = "object = [{ type = \"plane\", material = { type = \"matte\", color = [0.5, 0.25, 1] } }]\n";
    for (way, samples, cap) in [("both", 256, 0.01), ("light", 64, 0.01), ("bsdf", 1024, 0.02)] {
        let light = "light = [{ type = \"directional\", from = [1.7320508075688772, 1, 0], intensity = 8, angle = 50 }]\n";
        let m = mean(samples, &format!("{}{DOWN}{plane}{light}", integrator(way)));
        m.is([0.5, 0.25, 1.0].map(|c| c / PI * 4.0), cap);
    }
    // A sun as small as the real one is not found by chance; it is as good as none.
    let small = "light = [{ type = \"directional\", from = [1.7320508075688772, 1, 0], intensity = 8, angle = 0.53 }]\n";
    let m = mean(64, &format!("{}{DOWN}{plane}{small}", integrator("both")));
    m.is([0.5, 0.25, 1.0].map(|c| c / PI * 4.0), 0.001);
}

/// Mirrors and cameras see the disc itself: irradiance over π sin² of half its angle.
#[test]
fn discs_are_seen_in_mirrors_and_in_the_sky() {
    let light = "light = [{ type = \"directional\", from = [0, 1, 0], intensity = 3, angle = 10 }]\n";
    let radiance = 3.0 / (PI * 5f64.to_radians().sin().powi(2));
    let mirror = "object = [{ type = \"plane\", material = { type = \"principled\", base_metalness = 1, base_color = 1, specular_roughness = 0 } }]\n";
    let up = "camera = { position = [0, 0, 0], look_at = [0, 1, 0], up = [0, 0, -1], fov = 1 }\nbackground.color = 0.25\n";
    let beside = "camera = { position = [0, 0, 0], look_at = [0.1, 1, 0], up = [0, 0, -1], fov = 0.1 }\nbackground.color = 0.25\n";
    for way in WAYS {
        mean(1, &format!("{}{DOWN}{mirror}{light}", integrator(way))).is_grey(radiance, 0.0);
        mean(1, &format!("{}{up}{light}", integrator(way))).is_grey(radiance + 0.25, 0.0);
        mean(1, &format!("{}{beside}{light}", integrator(way))).is_grey(0.25, 0.0);
        let hidden = format!("{}{up}background.environment = false\n{light}", integrator(way));
        mean(1, &hidden).is_grey(0.25, 0.0);
    }
    // A rough mirror: whatever finds the light, the picture is one.
    let rough = mirror.replace("roughness = 0", "roughness = 0.35");
    let m = WAYS.map(|way| mean_of(24, 512, &format!("{}{DOWN}{rough}{light}", integrator(way))));
    m[0].agrees(&m[1], 0.02);
    m[0].agrees(&m[2], 0.02);
}

/// The penumbra of an edge under a disc: in the middle of it half of the light.
#[test]
fn a_shadow_of_a_disc_is_soft() {
    let text = |at: f64| {
        format!(
            "camera = {{ position = [{at}, 0.2, 0], look_at = [{at}, 0, 0], up = [0, 0, -1], fov = 0.001 }}\n\
             object = [{{ type = \"plane\", material = {{ type = \"matte\", color = 1 }} }}, {{ type = \"rectangle\", center = [50, 1, 0], \
             edge_u = [100, 0, 0], edge_v = [0, 0, 100], material = {{ type = \"matte\", color = 0 }} }}]\n\
             light = [{{ type = \"directional\", from = [0, 1, 0], angle = 20 }}]\nintegrator = {{ type = \"direct\" }}\n"
        )
    };
    let half = 10f64.to_radians();
    mean(64, &text(0.0)).is_grey(0.5 / PI, 0.01);
    // The disc's shadow is cut by a straight line: the share of a circle beyond it, in the plane of projected directions.
    let share = |x: f64| (x.acos() - x * (1.0 - x * x).sqrt()) / PI;
    let at: f64 = 0.08;
    let sin = (at / (1.0f64 + at * at).sqrt()) / half.sin();
    // An edge is a great circle of directions: nearly straight within ten degrees.
    let m = mean(256, &text(at));
    assert!((m.value()[0] * PI - share(sin)).abs() < 4e-3, "{m:?} {}", share(sin));
    mean(4, &text(0.2)).is_grey(0.0, 0.0);
    mean(4, &text(-0.2)).is_grey(1.0 / PI, 0.01);
}

/// The light of the day on level ground: that of its picture and its sun, whichever way it is found.
#[test]
fn a_clear_day_is_the_same_however_its_light_is_found() {
    let scene = |way: &str, more: &str| {
        format!(
            "{}{DOWN}object = [{{ type = \"plane\", material = {{ type = \"matte\", color = 1 }} }}]\n\
             light = [{{ type = \"sky\", elevation = 40, azimuth = 120{more} }}]\n",
            integrator(way)
        )
    };
    let m = ["both", "light"].map(|way| mean_of(24, 256, &scene(way, "")));
    m[0].agrees(&m[1], 0.01);
    let wide = ["both", "light", "bsdf"].map(|way| mean_of(24, 512, &scene(way, ", sun_angle = 40")));
    wide[0].agrees(&wide[1], 0.01);
    wide[0].agrees(&wide[2], 0.02);
    // The sky alone is blue and dimmer, and the two add up.
    let sky = mean_of(24, 256, &scene("both", ", sun = false"));
    assert!(sky.value()[2] > 1.3 * sky.value()[0] && sky.value()[1] < 0.35 * m[0].value()[1], "{sky:?}");
    let sun = scene("both", ", sun_strength = 2");
    let twice = mean_of(24, 256, &sun);
    for i in 0..3 {
        let expected = 2.0 * m[0].value()[i] - sky.value()[i];
        assert!((twice.value()[i] / expected - 1.0).abs() < 0.01, "{twice:?} {m:?} {sky:?}");
    }
}

#[test]
fn the_classic_integrator_takes_skies_and_discs() {
    let text = "light = [{ type = \"sky\", elevation = 40 }, { type = \"directional\", from = [0, 1, 0], angle = 30 }]\n\
                object = [{ type = \"plane\", material = { color = \"white\" } }]\n\
                film = { width = 8, height = 8 }\ncamera = { position = [0, 1, 0], look_at = [0, 0, 0], up = [0, 0, -1] }\n";
    let picture = render(text).0;
    // One from straight above, and a day whose light is 1/π of what surfaces get.
    let v = pixel(&picture, 4, 4)[1];
    assert!(v > 1.4 && v < 2.4, "{v}");
    assert!(render(&text.replace("width = 8", "antialias = \"adaptive\", width = 8")).1.shadow > 0);
}

/// Without a physical integrator, too: half of the disc, half of the light.
#[test]
fn the_classic_integrator_makes_soft_shadows_of_discs() {
    let lit = |at: f64| {
        let text = format!(
            "camera = {{ position = [{at}, 0.2, 0], look_at = [{at}, 0, 0], up = [0, 0, -1], fov = 0.001 }}\n\
             film = {{ width = 16, height = 16 }}\nobject = [{{ type = \"plane\", material = {{ color = 1 }} }}, {{ type = \"rectangle\", \
             center = [50, 1, 0], edge_u = [100, 0, 0], edge_v = [0, 0, 100] }}]\n\
             light = [{{ type = \"directional\", from = [0, 1, 0], angle = 20 }}]\n"
        );
        let picture = render(&text).0;
        picture.linear.iter().map(|p| f64::from(p[0])).sum::<f64>() / 256.0
    };
    // The mean cosine of the disc makes up for its width: all of it is 1.
    assert!((lit(-0.3) - 1.0).abs() < 2e-3, "{}", lit(-0.3));
    assert!((lit(0.0) - 0.5).abs() < 0.02, "{}", lit(0.0));
    assert_eq!(lit(0.3), 0.0);
}

/// A lamp that shines down a narrow beam, and brighter to the right: symmetrical about the plane of 0 and 180 degrees.
const LAMP: &str = "IESNA:LM-63-2002\n[TEST] made by hand\n[MANUFAC] nobody\nTILT=NONE\n\
    1 -1 2 3 3 1 2 0 0 0\n1 1 10\n0 30 90\n0 90 180\n100 80 0\n100 50 0\n100 20 0\n";

fn lit(light: &str, at: [f64; 2]) -> f64 {
    let mut assets = MemoryAssets::default();
    assets.files.insert("lamps/down.ies".into(), LAMP.into());
    let [x, z] = at;
    let text = format!(
        "camera = {{ position = [{x}, 0.2, {z}], look_at = [{x}, 0, {z}], up = [0, 0, -1], fov = 0.001 }}\nintegrator.type = \"direct\"\n\
         film = {{ width = 1, height = 1 }}\nobject = [{{ type = \"plane\", material = {{ type = \"matte\", color = 1 }} }}]\n\
         light = [{{ {light}, ies = \"lamps/down.ies\", position = [0, 1, 0] }}]\n"
    );
    let loaded = load_text(text, "test.toml", &assets, &LoadOptions::default()).unwrap();
    f64::from(pixel(&render_with(&loaded.desc, 1, 1).0, 0, 0)[0]) * PI
}

#[test]
fn measured_lamps_shine_as_measured() {
    let tan30 = 30f64.to_radians().tan();
    let cos30 = 30f64.to_radians().cos();
    let point = "type = \"point\", intensity = 3";
    let close = |found: f64, expected: f64| {
        assert!((found - expected).abs() < 2e-5 * expected.max(1.0), "{found} {expected}")
    };
    // Relative: 3 in the brightest direction. No attenuation: the cosine remains.
    close(lit(point, [0.0, 0.0]), 3.0);
    close(lit(point, [tan30, 0.0]), 3.0 * 0.8 * cos30);
    close(lit(point, [-tan30, 0.0]), 3.0 * 0.2 * cos30);
    close(lit(point, [0.0, tan30]), 3.0 * 0.5 * cos30);
    close(lit(point, [0.0, -tan30]), 3.0 * 0.5 * cos30);
    // Half way between 30 and 90 degrees, half of the intensity.
    close(lit(point, [3f64.sqrt(), 0.0]), 3.0 * 0.4 * 0.5);
    let candela = format!("{point}, ies_units = \"candela\", attenuation = \"inverse-square\"");
    close(lit(&candela, [0.0, 0.0]), 3.0 * 200.0);
    // Turned, and pointing sideways.
    close(lit(&format!("{point}, ies_rotation = 180"), [tan30, 0.0]), 3.0 * 0.2 * cos30);
    close(lit(&format!("{point}, ies_axis = [0, 1, 0]"), [0.0, 0.0]), 0.0);
    // A spot's beam goes where it looks, within its cone.
    let spot = "type = \"spot\", intensity = 3, angle = 40, penumbra = 0";
    close(lit(&format!("{spot}, look_at = [0, 0, 0]"), [tan30, 0.0]), 3.0 * 0.8 * cos30);
    close(lit(&format!("{spot}, look_at = [{tan30}, 0, 0]"), [tan30, 0.0]), 3.0 * cos30);
    close(lit(&format!("{spot}, look_at = [0, 0, 0]"), [3f64.sqrt(), 0.0]), 0.0);
}

#[test]
fn a_lamp_whose_file_is_missing_or_broken_is_an_error_at_its_name() {
    let scene = "light = [{ type = \"point\", position = [0, 1, 0], ies = \"a.ies\" }]\n";
    let load = |assets: &MemoryAssets| load_text(scene.into(), "test.toml", assets, &LoadOptions::default());
    let error = load(&MemoryAssets::default()).unwrap_err();
    assert_eq!((error.code(), error.line()), ("E0201", Some(1)));
    let mut assets = MemoryAssets::default();
    assets.files.insert("a.ies".into(), LAMP.replace("TILT=NONE", "TILT").into());
    let error = load(&assets).unwrap_err();
    assert_eq!((error.code(), error.line()), ("E0205", Some(1)));
    assert!(error.to_string().contains("a.ies: damaged IES file: line "), "{error}");
    // A tilt that is not applied is a remark.
    assets.files.insert("a.ies".into(), LAMP.replace("TILT=NONE", "TILT=lamp.tlt").into());
    let warnings = load(&assets).unwrap().desc.warnings;
    assert!(warnings.iter().any(|w| w.message.contains("TILT")), "{warnings:?}");
    assert!(describe("").lights.is_empty());
}

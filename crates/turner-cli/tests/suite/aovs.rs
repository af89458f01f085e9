//! `--aov` and `film.aovs`: channels, names, files, errors.

use std::collections::BTreeMap;

use turner_io::image::{MetaValue, exr, read_metadata};

use crate::common::{SCENE, folder, pixels};
use crate::folder::Folder;

/// The names of the channels of an EXR file.
fn channels(f: &Folder, name: &str) -> Vec<String> {
    let parts = exr::parts(&f.read(name), name).unwrap();
    parts.into_iter().flat_map(|part| part.channels).map(|channel| channel.name).collect()
}

fn attributes(f: &Folder, name: &str) -> BTreeMap<String, String> {
    let text = |(key, value): (String, MetaValue)| (key, value.to_string());
    read_metadata(&f.read(name), name).unwrap().into_iter().map(text).collect()
}

#[test]
fn an_exr_file_holds_them_next_to_the_colour() {
    let f = folder();
    f.turner(&["s.toml", "-o", "plain.exr"]).ok();
    let run = f.turner(&["s.toml", "-o", "a.exr", "--aov", "depth, normal,object_id,crypto_material"]).ok();
    assert!(run.stderr.starts_with("a.exr: 24x16") && !run.stderr.contains("AOVs in"), "{run:?}");
    let mut names = channels(&f, "a.exr");
    names.sort();
    let crypto = (0..3).flat_map(|i| ["A", "B", "G", "R"].map(|c| format!("CryptoMaterial{i:02}.{c}")));
    let mut expected: Vec<String> =
        ["B", "G", "N.X", "N.Y", "N.Z", "R", "Z", "object_id"].map(str::to_owned).into();
    expected.extend(crypto);
    expected.sort();
    assert_eq!(names, expected);
    assert_eq!(channels(&f, "plain.exr").len(), 3);
    f.turner(&["compare", "plain.exr", "a.exr", "--metric", "rmse", "--tolerance", "0"]).ok();

    let found = attributes(&f, "a.exr");
    let (key, _) = found.iter().find(|(_, v)| *v == "CryptoMaterial").unwrap();
    assert!(key.starts_with("cryptomatte/") && key.ends_with("/name") && key.len() == 24, "{key}");
    let manifest = found.iter().find(|(key, _)| key.ends_with("/manifest")).unwrap().1;
    let names: BTreeMap<String, String> = serde_json::from_str(manifest).unwrap();
    assert!(names.values().all(|hash| hash.len() == 8 && u32::from_str_radix(hash, 16).is_ok()), "{names:?}");
    let numbers: BTreeMap<String, String> = serde_json::from_str(&found["turner:object_id"]).unwrap();
    assert_eq!(numbers["1"], "object.1");
    // The same numbers for the complete scene.
    let info = f.turner(&["info", "s.toml", "-D", "film.aovs=[\"object_id\"]", "--json"]).ok();
    let info: serde_json::Value = serde_json::from_str(&info.stdout).unwrap();
    assert_eq!(info["aov_numbers"]["object_id"]["2"], "object.2");
}

#[test]
fn another_format_gets_an_exr_file_beside_it() {
    let f = folder();
    f.turner(&["s.toml", "-o", "plain.png"]).ok();
    let run = f.turner(&["s.toml", "-o", "a.png", "--aov", "albedo"]).ok();
    assert!(run.stderr.contains(", AOVs in a.exr"), "{run:?}");
    assert!(
        f.read("a.png").starts_with(b"\x89PNG") && pixels(&f.read("a.png")) == pixels(&f.read("plain.png"))
    );
    let names = channels(&f, "a.exr");
    assert!(names.contains(&"albedo.R".to_owned()) && names.contains(&"R".to_owned()), "{names:?}");
    let events = f.turner(&["s.toml", "-o", "a.png", "--aov", "albedo", "--json"]).ok().stdout;
    assert!(events.contains(r#""aov_output":"a.exr""#), "{events}");
    // The bytes do not depend on the number of threads.
    let bytes = f.read("a.exr");
    f.turner(&["s.toml", "-o", "a.png", "--aov", "albedo", "--threads", "1"]).ok();
    assert!(bytes == f.read("a.exr"));
    f.turner(&["s.toml", "-o", "-", "--format", "png", "--aov", "albedo"]).fails(2, &["E04", "--format exr"]);
    // It never overwrites what the scene reads.
    f.turner(&["s.toml", "-o", "sky.exr"]).ok();
    let sky =
        SCENE.replace("type = \"point\"\nposition = [5, 8, 5]", "type = \"environment\"\nfile = \"sky.exr\"");
    f.write("sky.toml", &sky);
    let before = f.read("sky.exr");
    f.turner(&["sky.toml", "-o", "sky.png", "--aov", "depth"]).fails(1, &["sky.exr", "reads this file"]);
    assert!(before == f.read("sky.exr"));
}

#[test]
fn names_of_other_programs_have_a_remedy() {
    let f = folder();
    f.turner(&["s.toml", "--aov", "nromal"]).fails(2, &["--aov nromal", "did you mean \"normal\""]);
    for (word, remedy) in [
        ("denoising_albedo", "`albedo`"),
        ("diffuse_color", "`albedo`"),
        ("mist", "`depth`"),
        ("Z", "`depth`"),
        ("N", "`normal`"),
        ("sh_normal", "`normal`"),
        ("P", "`position`"),
        ("motionvector", "`motion`"),
        ("dd.y", "`depth`"),
        ("Cryptomatte", "`crypto_object`"),
    ] {
        f.turner(&["s.toml", "--aov", word]).fails(2, &[format!("no AOV \"{word}\"").as_str(), remedy]);
    }
    f.turner(&["s.toml", "--aov", "albedo,"]).fails(2, &["separated by commas"]);
    let warned = f.turner(&["s.toml", "--aov", "direct"]).ok();
    assert!(warned.stderr.contains("\"classic\" does not know the AOV \"direct\""), "{warned:?}");
    let list = f.turner(&["list", "aovs"]).ok().stdout;
    assert!(list.contains("camera_normal") && list.contains("(albedo.R"), "{list}");
    assert!(f.turner(&["help", "camera_normal"]).ok().stdout.contains("camera's axes"));
}

/// The samples of a channel of an EXR file.
pub(crate) fn samples(f: &Folder, name: &str, channel: &str) -> Vec<f32> {
    let limits = turner_io::image::DecodeLimits::default();
    let found = exr::read_channels(&f.read(name), name, 0, |c| c == channel, &limits).unwrap();
    match &found[0].values {
        turner_io::image::ChannelValues::Float(values) => values.to_vec(),
        turner_io::image::ChannelValues::Uint(_) => panic!("{channel}"),
    }
}

#[test]
fn light_groups_have_layers() {
    let f = folder();
    let light =
        "[[light]]\ntype = \"point\"\nposition = [-4, 3, 2]\nintensity = 0.5\nlight_group = \"küche\"\n";
    f.write("g.toml", &format!("{SCENE}light_group = \"key\"\n\n{light}"));
    let options =
        ["--integrator", "path", "--samples", "8", "--aov", "light_groups, caustics, cost, variance"];
    f.turner(&[&["g.toml", "-o", "g.exr"], &options[..]].concat()).ok();
    for band in ["R", "G", "B"] {
        let layers =
            ["key", "k_che", "default"].map(|name| samples(&f, "g.exr", &format!("light.{name}.{band}")));
        let caustics = samples(&f, "g.exr", &format!("caustics.{band}"));
        for (i, color) in samples(&f, "g.exr", band).iter().enumerate() {
            let sum: f32 = caustics[i] + layers.iter().map(|layer| layer[i]).sum::<f32>();
            assert!((sum - color).abs() < 1e-5, "{band} {i}: {sum} {color}");
        }
        assert!(layers.iter().all(|layer| layer.iter().sum::<f32>() > 0.1), "{band}");
    }
    assert!(samples(&f, "g.exr", "cost").iter().all(|rays| *rays >= 1.0));
    assert!(samples(&f, "g.exr", "variance").iter().any(|v| *v > 0.0));
    f.turner(&["s.toml", "--aov", "heatmap"]).fails(2, &["`cost`"]);
}

#[test]
fn a_shadow_catcher_shows_only_the_shadow() {
    let f = folder();
    let floor = SCENE.replace("radius = 1000\n", "radius = 1000\nshadow_catcher = true\n");
    f.write("c.toml", &floor);
    let options =
        ["--background", "transparent", "--integrator", "path", "--samples", "16", "--aov", "shadow"];
    f.turner(&[&["c.toml", "-o", "c.exr"], &options[..]].concat()).ok();
    let (alpha, red) = (samples(&f, "c.exr", "A"), samples(&f, "c.exr", "R"));
    let shadow = samples(&f, "c.exr", "shadow");
    // The sphere, its shadow to the lower left, and the lit floor.
    let at = |x: usize, y: usize| (alpha[y * 24 + x], red[y * 24 + x], shadow[y * 24 + x]);
    assert!(at(11, 6).0 == 1.0 && at(11, 6).1 > 0.01 && at(11, 6).2 == 0.0, "{:?}", at(11, 6));
    // The background lights the shadow, too.
    assert!(shadow.iter().zip(&red).any(|(s, r)| *s > 0.4 && *s < 1.0 && *r == 0.0));
    // Here the sphere hides only a little of the background.
    let (alpha, red, shadow) = at(20, 14);
    assert!(red == 0.0 && alpha == shadow && (0.01..0.06).contains(&shadow), "{alpha} {red} {shadow}");
    // Another integrator shows the object itself, and says so.
    let classic = f.turner(&["c.toml", "-o", "d.exr", "--integrator", "classic"]).ok();
    assert!(classic.stderr.contains("does not know the shadow on shadow catchers"), "{classic:?}");
    assert!(samples(&f, "d.exr", "R")[14 * 24 + 20] > 0.01);
}

#[test]
fn the_guide_has_a_row_for_each() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/guides/aovs.md");
    let text = std::fs::read_to_string(path).unwrap();
    for aov in turner::film::Aov::all() {
        assert!(text.contains(&format!("| `{}` |", aov.word())), "{}", aov.word());
    }
}

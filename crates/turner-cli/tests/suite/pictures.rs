//! Picture files: options of encoding, `turner tonemap`, `turner view`, layers and sizes in `turner compare`.

use serde_json::Value;
use turner::image::Pixels;
use turner_io::image::{DecodeLimits, ExtraChannel, OutputImage, SampleKind, decode, exr, read_metadata};

use crate::common::{Folder, Run, folder};

impl Run {
    /// Asserts that the output contains a word.
    #[track_caller]
    fn says(self, word: &str) -> Run {
        assert!(self.stderr.contains(word) || self.stdout.contains(word), "{word}: {self:?}");
        self
    }
}

fn stored(f: &Folder, name: &str) -> turner::image::Image {
    decode(&f.read(name), name, &DecodeLimits::default()).unwrap()
}

/// The data of a chunk of a PNG.
fn chunk(png: &[u8], kind: &[u8; 4]) -> Option<Vec<u8>> {
    let mut rest = &png[8..];
    while rest.len() > 8 {
        let length = u32::from_be_bytes(rest[..4].try_into().unwrap()) as usize;
        if &rest[4..8] == kind {
            return Some(rest[8..8 + length].to_vec());
        }
        rest = &rest[length + 12..];
    }
    None
}

/// Writes an EXR of 4 x 2 pixels with a colour, normals and a depth with an infinite and a NaN value.
fn layers(f: &Folder, name: &str, depth: f32) {
    let linear: Vec<[f32; 4]> = (0..8).map(|i| [i as f32, 0.5, 0.25, 1.0]).collect();
    let z = [depth, 2.0, 3.0, f32::INFINITY, f32::NAN, 1.0, 1.0, 1.0];
    let x: Vec<f32> = (0..8).map(|i| i as f32 / 4.0 - 1.0).collect();
    let channels = [
        ExtraChannel::new("Z", SampleKind::Float, &z[..]),
        ExtraChannel::new("N.X", SampleKind::Half, x),
        ExtraChannel::new("N.Y", SampleKind::Half, vec![0.0f32; 8]),
        ExtraChannel::new("N.Z", SampleKind::Half, vec![1.0f32; 8]),
        ExtraChannel::new("id", SampleKind::Uint, vec![4_000_000_001u32; 8]),
    ];
    let image = OutputImage {
        width: 4,
        height: 2,
        linear: Some(&linear),
        channels: &channels,
        ..OutputImage::default()
    };
    std::fs::write(f.path().join(name), exr::encode(&image).unwrap()).unwrap();
}

#[test]
fn tonemap_makes_the_picture_that_was_rendered() {
    let f = folder();
    let srgb = ["-D", "film.transfer=srgb"];
    for extra in [
        &[][..],
        &srgb,
        &["-D", "film.transfer=srgb", "--tonemap", "agx", "--exposure", "0.7"],
        &["-D", "film.transfer=srgb", "--tonemap", "aces", "--auto-exposure"],
        &["--tonemap", "neutral", "--auto-exposure", "--exposure", "-0.3"],
        &["-D", "film.transfer=srgb", "--background", "transparent", "--tonemap", "agx"],
        &["-D", "film.transfer=srgb", "--bit-depth", "16"],
    ] {
        // EXR files have 16 bits as half floats, which are not what is compared here.
        let exr: Vec<&str> = extra.iter().copied().filter(|a| *a != "--bit-depth" && *a != "16").collect();
        let args = |name: &'static str, extra: &[&'static str]| [&["s.toml", "-o", name], extra].concat();
        f.turner(&args("a.png", extra)).ok();
        f.turner(&args("a.exr", &exr)).ok();
        let depth = if extra.contains(&"16") { &["--bit-depth", "16"][..] } else { &[] };
        f.turner(&[&["tonemap", "a.exr", "b.png"], depth].concat()).ok();
        assert!(stored(&f, "a.png") == stored(&f, "b.png"), "{extra:?}");
        // Metadata and declared encoding, too: the files are equal.
        assert!(f.read("a.png") == f.read("b.png"), "{extra:?}");
    }
}

#[test]
fn tonemap_can_change_how_a_picture_is_shown() {
    let f = folder();
    let srgb = ["-D", "film.transfer=srgb"];
    f.turner(&[&["s.toml", "-o", "a.exr"], &srgb[..]].concat()).ok();
    let cases: [(&[&str], &[&str]); 4] = [
        (&["--exposure", "1.5"], &["--exposure", "1.5"]),
        (&["--auto-exposure", "--exposure", "0.5"], &["--auto-exposure", "--exposure", "0.5"]),
        (&["--tonemap", "neutral", "--dither"], &["--tonemap", "neutral", "--dither"]),
        (&["--display-space", "display-p3"], &["--display-space", "display-p3"]),
    ];
    for (options, render) in cases {
        f.turner(&[&["tonemap", "a.exr", "b.png"], options].concat()).ok();
        f.turner(&[&["s.toml", "-o", "c.png"], &srgb[..], render].concat()).ok();
        assert!(stored(&f, "b.png") == stored(&f, "c.png"), "{options:?}");
    }
    // An EXR without Turner's metadata and an HDR file: sRGB, nothing else.
    layers(&f, "plain.exr", 1.0);
    f.turner(&["tonemap", "plain.exr", "plain.png"]).ok();
    let Pixels::U8(found) = stored(&f, "plain.png").pixels else { panic!("8 bits") };
    assert_eq!(found[..6], [0, 188, 137, 255, 188, 137]);
    f.turner(&["s.toml", "-o", "a.hdr"]).ok();
    f.turner(&["tonemap", "a.hdr", "hdr.webp"]).ok().says("exposure 0, tonemap none, srgb");
    assert_eq!(stored(&f, "hdr.webp").width, 24);
}

#[test]
fn tonemap_refuses_what_it_cannot_do() {
    let f = folder();
    f.turner(&["s.toml", "-o", "a.png"]).ok();
    layers(&f, "a.exr", 1.0);
    f.turner(&["tonemap", "a.png", "b.png"]).fails(1, &["a.png", "display values", "EXR"]);
    f.turner(&["tonemap", "a.exr", "b.exr"]).fails(2, &["scene values", ".png"]);
    f.turner(&["tonemap", "a.exr", "b.jpg", "--bit-depth", "16"]).fails(2, &["JPEG", "use 8"]);
    f.turner(&["tonemap", "a.exr", "b.jpg", "--display-space", "display-p3"]).fails(2, &["PNG"]);
    f.turner(&["tonemap", "a.exr", "b.png", "--exposure", "99"]).fails(2, &["-64 to 64"]);
    f.turner(&["tonemap", "a.exr", "b.png", "--layer", "albedo"]).fails(1, &["no layer", "N", "Z"]);
    f.turner(&["tonemap", "missing.exr", "b.png"]).fails(1, &["missing.exr"]);
    let p3 = ["--transfer", "none", "--display-space", "display-p3"];
    f.turner(&[&["tonemap", "a.exr", "b.png"], &p3[..]].concat()).fails(2, &["transfer"]);
    assert!(!f.names().contains(&"b.png".to_owned()));
    f.turner(&["tonemap", "a.exr", "n.png", "--layer", "N"]).ok();
    f.turner(&["s.toml", "-o", "d.exr", "--integrator", "depth"]).ok();
    f.turner(&["tonemap", "d.exr", "d.png"]).ok().says("debug view");
}

#[test]
fn pictures_have_the_requested_depth_and_colour_space() {
    let f = folder();
    let srgb = ["-D", "film.transfer=srgb"];
    let render = |name: &str, options: &[&str]| {
        f.turner(&[&["s.toml", "-o", name], &srgb[..], options].concat()).ok();
        f.read(name)
    };
    let png = render("a.png", &["--bit-depth", "16"]);
    assert!(matches!(stored(&f, "a.png").pixels, Pixels::U16(_)));
    assert!(chunk(&png, b"sRGB").is_some());
    let p3 = render("a.png", &["--display-space", "display-p3"]);
    assert_eq!(chunk(&p3, b"cICP"), Some(vec![12, 13, 0, 1]));
    assert!(chunk(&p3, b"iCCP").is_some());
    let pq = render("a.png", &["--display-space", "rec2100-pq"]);
    assert_eq!(chunk(&pq, b"cICP"), Some(vec![9, 16, 0, 1]));
    assert!(matches!(stored(&f, "a.png").pixels, Pixels::U16(_)));
    let (plain, dithered) = (render("a.png", &[]), render("b.png", &["--dither"]));
    assert_ne!(plain, dithered);
    // The same depth, the same dither pattern, on any number of threads.
    assert_eq!(render("b.png", &["--dither", "--threads", "1"]), dithered);
    assert!(
        render("half.exr", &["--bit-depth", "16", "--exr-compression", "piz"]).len()
            < f.read("a.png").len() * 9
    );
    let half = &exr::parts(&f.read("half.exr"), "half.exr").unwrap()[0];
    assert!(half.compression == "piz" && half.channels.iter().all(|c| c.kind == SampleKind::Half));

    f.turner(&["s.toml", "-o", "a.png", "--bit-depth", "32"]).fails(2, &["--bit-depth 32", "8 or 16"]);
    f.turner(&["s.toml", "-o", "a.hdr", "--bit-depth", "8"]).fails(2, &["Radiance"]);
    f.turner(&["s.toml", "-o", "a.png", "--exr-compression", "piz"]).fails(2, &["--exr-compression", "EXR"]);
    f.turner(&["s.toml", "-o", "a.png", "--dither", "--bit-depth", "16"]).fails(2, &["8 bits"]);
    let classic = ["-D", "film.transfer=none", "--display-space", "display-p3"];
    f.turner(&[&["s.toml", "-o", "a.png"], &classic[..]].concat()).fails(2, &["film.transfer=srgb"]);
    f.turner(&["s.toml", "-o", "a.png", "--bit-depth", "16", "--integrator", "depth"]).ok().says("ignored");
}

#[test]
fn lost_transparency_is_said() {
    let f = folder();
    let transparent = ["--background", "transparent"];
    f.turner(&[&["s.toml", "-o", "a.jpg"], &transparent[..]].concat()).ok().says("no transparency");
    f.turner(&[&["s.toml", "-o", "a.jpg", "--strict"], &transparent[..]].concat()).ok();
    let quiet = f.turner(&[&["s.toml", "-o", "a.webp"], &transparent[..]].concat()).ok();
    assert!(!quiet.stderr.contains("transparency"), "{}", quiet.stderr);
    assert_eq!(stored(&f, "a.webp").channels, 4);
}

#[test]
fn view_lists_channels_and_values() {
    let f = folder();
    layers(&f, "a.exr", 1.5);
    let text = f.turner(&["view", "a.exr"]).ok().stdout;
    assert!(text.starts_with("a.exr: OpenEXR, 4x2, zip compression, "), "{text}");
    for expected in [
        "N.X      half",
        "Z        float",
        "id       uint",
        "id       uint   4000000001",
        "(1 NaN, 1 infinite)",
    ] {
        assert!(text.contains(expected), "{expected}: {text}");
    }
    // Colours in their usual order, before other channels.
    let order = ["\n  R ", "\n  G ", "\n  B ", "\n  Z ", "\n  N.X "].map(|name| text.find(name));
    assert!(order.is_sorted() && order[0].is_some(), "{text}");
    // Standard output is no terminal: no preview.
    assert!(!text.contains('\x1b'));
    let text = f.turner(&["view", "a.exr", "--pixel", "1,1", "--layer", "Z"]).ok().stdout;
    assert!(text.contains("at 1,1") && !text.contains("N.X"), "{text}");
    let json = f.turner(&["view", "a.exr", "--json", "--pixel", "0,0"]).ok().stdout;
    let json: Value = serde_json::from_str(&json).unwrap();
    assert_eq!((&json["width"], &json["height"]), (&4.into(), &2.into()));
    assert_eq!(json["parts"][0]["compression"], "zip");
    let z = &json["parts"][0]["channels"].as_array().unwrap().iter().find(|c| c["name"] == "Z").unwrap();
    assert_eq!((&z["min"], &z["max"], &z["nan"]), (&1.0.into(), &3.0.into(), &1.into()));
    assert_eq!((&z["mean"], &z["infinite"]), (&Value::from(9.5 / 6.0), &1.into()));
    assert_eq!(json["pixel"]["values"]["Z"], 1.5);
    assert_eq!(json["pixel"]["values"]["id"], 4_000_000_001.0);

    f.turner(&["s.toml", "-o", "a.png", "--seed", "7"]).ok();
    let json: Value = serde_json::from_str(&f.turner(&["view", "a.png", "--json"]).ok().stdout).unwrap();
    assert_eq!(json["metadata"]["turner:seed"], "7");
    assert_eq!(json["parts"][0]["channels"][0]["type"], "8 bits");
    assert_eq!(json["parts"][0]["channels"][2]["name"], "B");
}

#[test]
fn view_shows_a_preview_when_asked() {
    let f = folder();
    layers(&f, "a.exr", 1.5);
    let text = f.turner(&["view", "a.exr", "--preview", "blocks"]).ok().stdout;
    // 4 x 2 pixels are one line of four half blocks; the last pixel is brighter than white.
    assert_eq!(text.matches('▀').count(), 4);
    assert!(text.contains("\x1b[38;2;0;188;137"), "{text:?}");
    let text = f.turner(&["view", "a.exr", "--preview", "kitty", "--layer", "N"]).ok().stdout;
    assert!(text.contains("\x1b_Ga=T,f=100"), "{text:?}");
}

#[test]
fn view_refuses_what_it_cannot_do() {
    let f = folder();
    layers(&f, "a.exr", 1.5);
    f.turner(&["view", "a.exr", "--pixel", "4,0"]).fails(2, &["outside", "0 to 3"]);
    f.turner(&["view", "a.exr", "--pixel", "4"]).fails(2, &["--pixel 320,240"]);
    f.turner(&["view", "a.exr", "--layer", "albedo"]).fails(1, &["no layer", "id"]);
    f.turner(&["view", "s.toml"]).fails(1, &["s.toml"]);
    f.turner(&["view", "missing.png"]).fails(1, &["missing.png"]);
    let bytes = f.read("a.exr");
    std::fs::write(f.path().join("cut.exr"), &bytes[..bytes.len() - 9]).unwrap();
    f.turner(&["view", "cut.exr"]).fails(1, &["cut.exr", "damaged"]);
}

#[test]
fn compare_reads_layers_and_scales() {
    let f = folder();
    layers(&f, "a.exr", 1.5);
    layers(&f, "b.exr", 1.75);
    let max = |args: &[&str]| -> Value {
        let run = f.turner(&[&["compare", "a.exr", "b.exr", "--metric", "max", "--json"], args].concat());
        serde_json::from_str(&run.ok().stdout).unwrap()
    };
    assert_eq!(max(&[])["metrics"]["max"]["value"], 0.0);
    assert_eq!(max(&["--layer", "Z"])["metrics"]["max"]["value"], 0.25);
    assert_eq!(max(&["--layer", "N"])["metrics"]["max"]["value"], 0.0);
    f.turner(&["compare", "a.exr", "b.exr", "--layer", "albedo"]).fails(1, &["no layer"]);

    let size = |name: &str, width: &str, height: &str| {
        f.turner(&["s.toml", "-o", name, "--width", width, "--height", height, "--samples", "16"]).ok();
    };
    size("small.exr", "24", "16");
    size("large.exr", "48", "32");
    f.turner(&["compare", "small.exr", "large.exr"]).fails(1, &["--resize"]);
    let run = f.turner(&["compare", "small.exr", "large.exr", "--resize"]).ok();
    assert!(run.stdout.contains("scaled from 48x32"), "{}", run.stdout);
    let run = f.turner(&["compare", "small.exr", "large.exr", "--resize", "--json"]).ok();
    let json: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(json["width"], 24);
    assert_eq!(json["resized_from"]["width"], 48);
    assert!(json["metrics"]["mean"]["value"].as_f64().unwrap() < 0.05, "{json}");
}

#[test]
fn metadata_survive_tone_mapping() {
    let f = folder();
    f.turner(&["s.toml", "-o", "a.exr", "--seed", "3"]).ok();
    f.turner(&["tonemap", "a.exr", "a.png", "--exposure", "0.123456"]).ok();
    let metadata = read_metadata(&f.read("a.png"), "a.png").unwrap();
    assert_eq!(metadata["turner:seed"].to_string(), "3");
    assert_eq!(metadata["turner:exposure"].to_string(), "0.123456");
    assert!(metadata["Software"].to_string().starts_with("Turner"));
}

//! `turner explain`: contributions sum to the sample, samples average to the pixel, and every format is valid.

use serde_json::Value;

use crate::common::{Folder, folder, pixels};

const GLASS: &str = r#"
integrator = { type = "path", rr_start = 1 }
camera = { position = [0, 1.5, 5], look_at = [0, 0.8, 0], fov = 40 }
film = { width = 24, height = 16, antialias = "none", transfer = "none" }
[material.floor]
type = "matte"
color = 0.6
[material.glass]
type = "principled"
transmission_weight = 1
specular_roughness = 0
transmission_color = [0.6, 0.9, 0.7]
transmission_depth = 1
[[object]]
type = "plane"
material = "floor"
[[object]]
type = "sphere"
center = [0, 1, 0]
material = "glass"
[[object]]
type = "box"
min = [-1, 3, -1]
max = [1, 3.2, 1]
material = { type = "emissive", strength = 8 }
[[light]]
type = "environment"
"#;

/// Glass, mirrors, shadows, and names that must be escaped in a terminal and on a page.
const CLASSIC: &str = r##"
camera = { position = [0, 1.2, 6], look_at = [0, 0.9, 0], fov = 40 }
film = { width = 24, height = 16 }
background = { color = [0.3, 0.4, 0.6] }
integrator = { max_depth = 4 }
[material.glass]
color = "white"
kd = 0.1
ks = 0.8
k_reflect = 0.3
k_refract = 0.7
shadow = "tinted"
[[object]]
name = "</title><script>alert('1')</script>&\u001b[31m"
type = "sphere"
center = [0, 1, 0]
material = "glass"
[[object]]
name = "floor"
type = "plane"
material = { color = { type = "checkerboard" }, k_reflect = 0.2 }
[[object]]
name = "screen"
type = "box"
min = [1.2, 0, -1]
max = [1.5, 2, 1]
[[light]]
type = "point"
position = [6, 4, 3]
intensity = 0.8
[[light]]
type = "ambient"
intensity = 0.2
"##;

fn explain(f: &Folder, scene: &str, pixel: &str, more: &[&str]) -> Value {
    let args = ["explain", scene, "--pixel", pixel, "--json"];
    serde_json::from_str(&f.turner(&[&args[..], more].concat()).ok().stdout).unwrap()
}

fn color(v: &Value) -> [f32; 3] {
    let v: Vec<f32> = v.as_array().unwrap().iter().map(|c| c.as_f64().unwrap() as f32).collect();
    v.try_into().unwrap()
}

fn keys(v: &Value) -> Vec<&str> {
    v.as_object().unwrap().keys().map(String::as_str).collect()
}

fn sum<'a>(parts: impl Iterator<Item = &'a Value>) -> [f32; 3] {
    parts.filter(|p| p.is_array()).fold([0f32; 3], |sum, part| {
        let c = color(part);
        [sum[0] + c[0], sum[1] + c[1], sum[2] + c[2]]
    })
}

#[test]
fn the_parts_sum_to_the_pixel_of_the_picture() {
    let f = folder();
    f.write("g.toml", GLASS);
    // Samples hold camera paths only: without light paths they are the complete picture.
    let alone = ["--caustics", "off"];
    f.turner(&["g.toml", "-o", "g.exr", alone[0], alone[1]]).ok();
    let (width, _, picture) = pixels(&f.read("g.exr"));
    let mut through_glass = false;
    for (x, y) in [(12, 7), (10, 9), (3, 12), (20, 2), (13, 12), (12, 5)] {
        let all = explain(&f, "g.toml", &format!("{x},{y}"), &alone);
        let path = &all["explained"][0];
        let vertices = path["vertices"].as_array().unwrap();
        let of_vertex =
            |v: &Value| [vec![v["emission"].clone()], v["lights"].as_array().unwrap().clone()].concat();
        let parts = vertices.iter().flat_map(of_vertex).chain([path["escape"].clone()]);
        let parts: Vec<Value> = parts.filter(|p| p.is_object()).collect();
        let sum = sum(parts.iter().map(|p| &p["contribution"]));
        assert_eq!(sum.map(f32::to_bits), color(&path["rendered"]).map(f32::to_bits), "{x},{y}: {path}");
        assert_eq!((sum, sum), (color(&path["sum"]), color(&all["color"])));
        assert_eq!(sum, picture[(y * width + x) as usize], "{x},{y}");
        assert_eq!((&all["exact"], &all["sample_count"]), (&true.into(), &1.into()));
        for v in vertices {
            assert!(v["t"].as_f64().unwrap() > 0.0 && v["object"]["primitive"].is_u64());
            through_glass |= v["material"]["name"] == "glass" && v["transmittance"].is_array();
        }
    }
    assert!(through_glass);
}

#[test]
fn a_classic_tree_sums_to_the_pixel_of_the_picture() {
    let f = folder();
    f.write("c.toml", CLASSIC);
    for mode in ["none", "mean", "grid", "adaptive", "monte-carlo"] {
        let options = ["--antialias", mode, "--samples", "4"];
        f.turner(&[&["c.toml", "-o", "c.exr"][..], &options].concat()).ok();
        let (width, _, picture) = pixels(&f.read("c.exr"));
        for (x, y) in [(12, 7), (8, 12), (0, 0), (17, 9)] {
            let all = explain(&f, "c.toml", &format!("{x},{y}"), &options);
            assert_eq!(color(&all["color"]), picture[(y * width + x) as usize], "{mode} {x},{y}");
            let samples = all["samples"].as_array().unwrap();
            for tree in all["explained"].as_array().unwrap() {
                let rays = tree["rays"].as_array().unwrap();
                let parts = rays.iter().flat_map(|ray| {
                    let cut = ray["hit"]["not_traced"].as_array().into_iter().flatten();
                    let own =
                        [&ray["miss"]["contribution"], &ray["hit"]["emission"], &ray["hit"]["contribution"]];
                    own.into_iter().chain(cut.map(|c| &c["contribution"]))
                });
                let sum = sum(parts);
                let sample = &samples[tree["sample"].as_u64().unwrap() as usize];
                assert_eq!(
                    sum.map(f32::to_bits),
                    color(&sample["color"]).map(f32::to_bits),
                    "{mode} {x},{y}"
                );
                assert_eq!((sum, &tree["exact"]), (color(&tree["rendered"]), &true.into()));
            }
        }
    }
}

#[test]
fn the_keys_of_the_json_are_these() {
    let f = folder();
    f.write("c.toml", CLASSIC);
    let all = explain(&f, "c.toml", "12,13", &[]);
    assert_eq!((&all["format"], &all["version"]), (&"turner-explanation".into(), &2.into()));
    let top = "alpha antialias color exact explained format integrator path_of pixel sample_count samples scene scene_hash seed size \
               squares turner version";
    assert_eq!(keys(&all).join(" "), top);
    assert_eq!(keys(&all["samples"][0]).join(" "), "alpha color pixel_position weight");
    let tree = &all["explained"][0];
    assert_eq!(
        keys(tree).join(" "),
        "alpha dropped_rays exact kind pixel_position rays rendered sample sum unrecorded_rays"
    );
    let ray = &tree["rays"][0];
    assert_eq!(keys(ray).join(" "), "depth direction hit kind miss origin parent weight");
    assert_eq!(
        keys(&ray["hit"]).join(" "),
        "ambient color contribution emission entering geometric_normal ior k_local k_reflect k_refract ka kd ks lights local material \
         normal not_traced object part position shading_normal shininess t total_internal_reflection uv"
    );
    assert_eq!(keys(&ray["hit"]["object"]).join(" "), "instance name primitive shape");
    assert_eq!(
        keys(&ray["hit"]["lights"][0]).join(" "),
        "added diffuse distance highlight intensity light n_dot_l name point r_dot_v reaches shadow to_light"
    );
    // Every key is documented.
    let docs =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/reference/explain.md"))
            .unwrap();
    for part in [&all, &all["samples"][0], tree, ray, &ray["hit"], &ray["hit"]["lights"][0]] {
        for key in keys(part) {
            assert!(
                docs.contains(&format!("`{key}`")),
                "docs/reference/explain.md does not document `{key}`"
            );
        }
    }
    let path = explain(&f, "c.toml", "12,7", &["--integrator", "path"]);
    assert_eq!(path["explained"][0]["kind"], "path");
    let normals = explain(&f, "c.toml", "12,7", &["--integrator", "normals"]);
    assert_eq!(normals["explained"][0]["kind"], "first-hit");
    assert_eq!(normals["explained"][0]["hit"]["object"]["shape"], "sphere");
}

#[test]
fn the_text_names_the_hits_and_shows_the_sum() {
    let f = folder();
    f.write("g.toml", GLASS);
    let options = ["--samples", "16", "--antialias", "monte-carlo"];
    let args = ["explain", "g.toml", "--pixel", "12,7", "--sample", "5"];
    let text = f.turner(&[&args[..], &options].concat()).ok().stdout;
    for word in [
        "g.toml: pixel 12,7 of 24x16, integrator \"path\"",
        "the mean of 16 samples",
        "sample 5 of 16",
        "sphere #1 (glass)",
        "enters",
        "leaves",
        "refracted ray →",
        "throughput 1",
        "specular transmission",
        "eta 0.66",
        "MIS weight",
        "the path ends: ",
        "equal to the last bit",
    ] {
        assert!(text.contains(word), "{word}: {text}");
    }
    assert!(!text.contains('\x1b'));
    let args = ["--sample", "5", "--samples", "16", "--antialias", "monte-carlo"];
    let json = explain(&f, "g.toml", "12,7", &args);
    let [r, g, b] = color(&json["explained"][0]["rendered"]);
    let line = text.lines().find(|l| l.trim_start().starts_with("sample as rendered")).unwrap();
    assert!(line.contains(&format!("[{r}, {g}, {b}]")), "{text}");
    // Another sample has another path. Without `--sample` the one with the largest contribution is shown.
    let args = ["--sample", "6", "--samples", "16", "--antialias", "monte-carlo"];
    let other = explain(&f, "g.toml", "12,7", &args);
    assert_ne!(json["explained"][0]["camera"], other["explained"][0]["camera"]);
    let args = ["explain", "g.toml", "--pixel", "12,7"];
    let text = f.turner(&[&args[..], &options].concat()).ok().stdout;
    let samples = json["samples"].as_array().unwrap().iter();
    let brightest = samples.map(|s| color(&s["color"]).into_iter().fold(0.0, f32::max)).enumerate();
    let most = brightest.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0))).unwrap().0;
    assert!(text.contains(&format!("sample {most} has the largest contribution")), "{text}");
    // Samples that the film clamps.
    let cut = f.turner(&[&args[..], &options, &["-D", "film.clamp_sample=0.001"]].concat()).ok().stdout;
    assert!(
        cut.contains("of them clamped to 0.001 (film.clamp_sample)") && cut.contains("equal to the last bit"),
        "{cut}"
    );
    let direct = explain(&f, "g.toml", "12,7", &["--integrator", "direct"]);
    assert_eq!((&direct["integrator"], &direct["exact"]), (&"direct".into(), &true.into()));
    f.write("c.toml", CLASSIC);
    let text = f.turner(&["explain", "c.toml", "--pixel", "12,7"]).ok().stdout;
    for word in [
        "camera ray →",
        "reflected ray →",
        "refracted ray →",
        "(glass), enters",
        "☀ point light",
        "ambient",
        "\\u{1b}[31m",
    ] {
        assert!(text.contains(word), "{word}: {text}");
    }
    let shaded = f.turner(&["explain", "c.toml", "--pixel", "12,13"]).ok().stdout;
    assert!(shaded.contains("☀ point light: "), "{shaded}");
    let normals = f.turner(&["explain", "c.toml", "--pixel", "12,7", "--integrator", "normals"]).ok().stdout;
    assert!(normals.contains("\"normals\" shows ["), "{normals}");
}

#[test]
fn large_trees_are_collapsed_by_weight() {
    let f = folder();
    // Nested glass shells in a room of mirrors.
    let mut deep = CLASSIC.replace("max_depth = 4", "max_depth = 10");
    for radius in [0.9, 0.8, 0.7, 0.6] {
        deep += &format!(
            "[[object]]\ntype = \"sphere\"\ncenter = [0, 1, 0]\nradius = {radius}\nmaterial = \"glass\"\n"
        );
    }
    deep +=
        "[[object]]\ntype = \"box\"\nmin = [-7, -1, -7]\nmax = [7, 7, 7]\nmaterial = { k_reflect = 0.6 }\n";
    f.write("c.toml", &deep);
    let args = ["explain", "c.toml", "--pixel", "12,7"];
    let text = f.turner(&args).ok().stdout;
    let all = f.turner(&[&args[..], &["--all"]].concat()).ok().stdout;
    let rays = |text: &str| text.lines().filter(|l| l.contains(" → ")).count();
    let hidden = |line: &str| -> Option<u64> {
        let count = line.split_once("… ")?.1.split_once(" ray")?.0;
        line.contains("not shown; --all").then(|| count.replace(',', "").parse().ok()).flatten()
    };
    let left_out: u64 = text.lines().filter_map(hidden).sum();
    let traced = explain(&f, "c.toml", "12,7", &[])["explained"][0]["rays"].as_array().unwrap().len();
    assert!(traced > 400 && rays(&text) <= 40 && text.lines().count() < 400, "{traced}: {text}");
    assert!(all.lines().filter_map(hidden).next().is_none() && rays(&all) >= traced);
    assert!(left_out > 0 && left_out as usize + rays(&text) >= traced, "{left_out} {traced}");
}

#[test]
fn path_of_selects_rays() {
    let f = folder();
    f.write("c.toml", CLASSIC);
    let args = |name: &'static str| ["explain", "c.toml", "--pixel", "12,7", "--path-of", name];
    let text = f.turner(&args("floor")).ok().stdout;
    assert!(text.contains("floor") && text.contains("do not touch \"floor\""), "{text}");
    // The camera ray is the ancestor of all others. Rays that neither lead to the floor nor start there are omitted.
    assert!(text.contains("camera ray →") && text.contains("equal to the last bit"));
    let glass = f.turner(&args("glass")).ok().stdout;
    assert!(!glass.contains("do not touch"), "{glass}");
    f.turner(&args("flor")).fails(1, &["E0103", "\"flor\"", "did you mean \"floor\"", "glass"]);
    f.turner(&args("sphere #0")).ok();
    let json = explain(&f, "c.toml", "0,0", &["--path-of", "screen"]);
    assert_eq!((&json["path_of"], &json["explained"][0]["touches"]), (&"screen".into(), &false.into()));
    let args = ["--path-of", "floor", "--integrator", "path", "--samples", "9", "--antialias", "monte-carlo"];
    let text = f.turner(&[&["explain", "c.toml", "--pixel", "12,13"][..], &args].concat()).ok().stdout;
    assert!(text.contains("of 9 samples touch \"floor\""), "{text}");
}

/// Checks that elements are nested correctly, and returns their names.
fn elements(text: &str) -> Vec<String> {
    let (mut names, mut open) = (Vec::new(), Vec::<String>::new());
    let mut rest = text;
    while let Some(start) = rest.find('<') {
        let between = &rest[..start];
        assert!(!between.contains('>') || open.last().is_some_and(|n| n == "style"), "{between}");
        rest = &rest[start + 1..];
        let end = rest.find('>').unwrap();
        let tag = &rest[..end];
        rest = &rest[end + 1..];
        if tag.starts_with('!') {
            continue;
        }
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop().as_deref(), Some(name), "{:.200}", rest);
            continue;
        }
        let name = tag.split([' ', '/', '\n']).next().unwrap().to_owned();
        assert!(tag.matches('"').count().is_multiple_of(2), "{tag}");
        names.push(name.clone());
        if name == "script" {
            rest = &rest[rest.find("</script>").unwrap() + 9..];
        } else if !tag.ends_with('/') {
            open.push(name);
        }
    }
    assert!(open.is_empty(), "{open:?}");
    names
}

#[test]
fn drawings_and_pages_are_well_formed_and_need_nothing_else() {
    let f = folder();
    f.write("c.toml", CLASSIC);
    f.write("g.toml", GLASS);
    let runs = [
        ("c.toml", "12,7", &[][..]),
        ("c.toml", "12,7", &["--max-depth", "20"]),
        ("c.toml", "0,0", &["--antialias", "adaptive"]),
        ("c.toml", "8,9", &["--antialias", "mean", "--path-of", "floor"]),
        ("g.toml", "12,7", &["--samples", "9", "--antialias", "monte-carlo"]),
        ("g.toml", "12,7", &["--integrator", "normals"]),
    ];
    for (scene, pixel, more) in runs {
        for name in ["e.svg", "e.html"] {
            let args = ["explain", scene, "--pixel", pixel, "-o", name];
            let run = f.turner(&[&args[..], more].concat()).ok();
            assert_eq!(run.stdout, "");
            let text = String::from_utf8(f.read(name)).unwrap();
            let names = elements(&text);
            let count = |name: &str| names.iter().filter(|n| *n == name).count();
            assert!(count("svg") >= 1 && count("path") > 0, "{scene} {name}");
            assert_eq!(count("script"), usize::from(name == "e.html"));
            // The page loads nothing: its only URL is the XML namespace.
            let addresses = text.replace("http://www.w3.org/2000/svg", "");
            for word in ["http:", "https:", "src=", "href=", "@import", "url(h", "alert('", "\x1b"] {
                assert!(!addresses.contains(word), "{scene} {name}: {word}");
            }
            assert!(text.contains("equal to the last bit") || text.contains("to the last bit"));
            assert!(!text.contains("object #"), "{scene} {name}: a shape has no name");
            // Rays are linked between the views and the tree.
            let once: std::collections::BTreeSet<&str> = text
                .match_indices("data-ray=\"")
                .map(|(i, m)| text[i + m.len()..].split('"').next().unwrap())
                .collect();
            assert!(!once.is_empty());
        }
    }
    // The output is deterministic.
    let page = || f.turner(&["explain", "c.toml", "--pixel", "12,7", "--format", "html"]).ok().stdout;
    assert_eq!(page(), page());
}

/// A ray that a ball reflects to the floor, 150 units away.
#[test]
fn hits_near_the_horizon_do_not_shrink_the_views() {
    let f = folder();
    let scene = "film = { width = 1001, height = 1001 }\n\
                 camera = { position = [0, 1, 5], look_at = [0, 1, 0], fov = 40 }\n\
                 integrator = { type = \"classic\" }\n\
                 object = [{ type = \"plane\", material = { color = \"grey\" } }, \
                 { type = \"sphere\", center = [0, 1, 0], radius = 1, material = { k_reflect = 0.5 } }]\n\
                 light = [{ type = \"point\", position = [3, 4, 5] }]\n";
    f.write("far.toml", scene);
    let rays = explain(&f, "far.toml", "500,501", &[])["explained"][0]["rays"].clone();
    assert!(rays[1]["hit"]["t"].as_f64().unwrap() > 50.0, "{rays}");
    let svg = f.turner(&["explain", "far.toml", "--pixel", "500,501", "--format", "svg"]).ok().stdout;
    let ball = svg.split("<circle class=\"object\"").nth(1).unwrap();
    let radius: f64 = ball.split(" r=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap();
    assert!(radius > 30.0, "{radius}");
}

#[test]
fn bad_arguments_are_errors() {
    let f = folder();
    f.write("g.toml", GLASS);
    let fails = |code: i32, args: &[&str], words: &[&str]| {
        f.turner(&[&["explain"], args].concat()).fails(code, words);
    };
    fails(1, &["g.toml", "--pixel", "24,0"], &["E0105", "g.toml", "no pixel in column 24, row 0", "24x16"]);
    fails(
        1,
        &["g.toml", "--pixel", "0,0", "--sample", "1"],
        &["E0105", "no sample 1", "one sample, number 0"],
    );
    fails(2, &["g.toml", "--pixel", "0"], &["two integers"]);
    fails(2, &["g.toml", "--pixel", "-1,2"], &["two integers X,Y"]);
    fails(2, &["g.toml"], &["--pixel"]);
    fails(2, &["g.toml", "--pixel", "0,0", "-o", "e.png"], &["E0401", "e.png", ".html"]);
    let before = f.names();
    for path in ["none/e.svg", "g.toml/e.json", "."] {
        fails(1, &["g.toml", "--pixel", "0,0", "--format", "svg", "-o", path], &["E0401"]);
    }
    // A failed run writes nothing.
    fails(1, &["g.toml", "--pixel", "99,0", "-o", "e.html"], &["E0105"]);
    assert_eq!(f.names(), before);
    let run = f.turner(&["explain", "g.toml", "--pixel", "99,0", "--json"]).fails(1, &["E0105"]);
    assert_eq!(run.stderr, "");
    assert_eq!(serde_json::from_str::<Value>(&run.stdout).unwrap()["event"], "error");
    f.turner(&["explain", "g.toml", "--pixel", "1,1", "-o", "e.json"]).ok();
    assert_eq!(serde_json::from_slice::<Value>(&f.read("e.json")).unwrap()["pixel"][0], 1);
}

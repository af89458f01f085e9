//! Limits: an error names the need and the option.

use crate::common::{SCENE, folder};

const TRIANGLES: &str = "[[object]]\ntype = \"mesh\"\npositions = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]\n\
triangles = [[0, 1, 2], [1, 3, 2]]\n";

#[test]
fn more_folders_may_be_read_when_they_are_named() {
    let f = folder();
    for name in ["in", "parts", "parts/deep", "secret"] {
        std::fs::create_dir(f.path().join(name)).unwrap();
    }
    f.write("parts/deep/part.toml", SCENE);
    f.write("secret/part.toml", SCENE);
    for (i, name) in ["../parts/deep/part.toml", "../secret/part.toml"].iter().enumerate() {
        f.write(&format!("in/s{i}.toml"), &format!("include = [\"{name}\"]\n"));
    }
    let absolute = f.path().canonicalize().unwrap().join("parts/deep/part.toml");
    f.write("in/s2.toml", &format!("include = [\"{}\"]\n", absolute.display()));
    for scene in ["in/s0.toml", "in/s1.toml", "in/s2.toml"] {
        f.turner(&[scene]).fails(1, &["error[E0201]", "--allow-path"]);
    }
    for scene in ["in/s0.toml", "in/s2.toml"] {
        f.turner(&[scene, "--allow-path", "parts"]).ok();
        f.turner(&["info", scene, "--allow-path", "secret", "--allow-path", "parts/deep"]).ok();
    }
    f.turner(&["in/s1.toml", "--allow-path", "parts"]).fails(1, &["error[E0201]", "--allow-path"]);
    f.turner(&["in/s0.toml", "--allow-path", "nowhere"]).fails(1, &["nowhere"]);
    // The message for a path outside the folder does not depend on whether the file exists.
    f.write("in/s3.toml", "include = [\"../secret/nothing.toml\"]\n");
    let error = |scene| f.turner(&[scene, "--allow-path", "parts"]).fails(1, &[]).stderr;
    let known = error("in/s1.toml").replace("part.toml", "X").replace("in/s1.toml", "S");
    assert_eq!(
        known.lines().next(),
        error("in/s3.toml").replace("nothing.toml", "X").replace("in/s3.toml", "S").lines().next()
    );
}

#[test]
#[cfg(unix)]
fn links_count_by_where_they_lead() {
    let f = folder();
    for name in ["in", "parts", "secret"] {
        std::fs::create_dir(f.path().join(name)).unwrap();
    }
    f.write("parts/part.toml", SCENE);
    f.write("secret/part.toml", SCENE);
    std::os::unix::fs::symlink("../parts/part.toml", f.path().join("in/a.toml")).unwrap();
    std::os::unix::fs::symlink("../secret/part.toml", f.path().join("parts/b.toml")).unwrap();
    f.write("in/s.toml", "include = [\"a.toml\"]\n");
    f.write("in/t.toml", "include = [\"../parts/b.toml\"]\n");
    f.turner(&["in/s.toml"]).fails(1, &["E0201", "link"]);
    f.turner(&["in/s.toml", "--allow-path", "parts"]).ok();
    f.turner(&["in/t.toml", "--allow-path", "parts"]).fails(1, &["E0201", "link"]);
}

#[test]
fn a_film_beyond_the_memory_is_refused_with_its_need() {
    let f = folder();
    let large = ["s.toml", "--width", "16384", "--height", "16384", "--max-memory", "1G"];
    let run = f.turner(&large).fails(1, &["error[E0109]", "16384x16384", "GiB", "--max-memory"]);
    assert!(run.stderr.lines().count() <= 3, "{run:?}");
    f.turner(&["s.toml", "--max-memory", "100M"]).ok();
    f.turner(&["s.toml", "--max-memory", "1M"]).fails(2, &["32M"]);
    f.turner(&["s.toml", "--max-memory", "lots"]).fails(2, &["4G"]);
}

#[test]
fn a_text_of_many_objects_ends_with_a_message() {
    let f = folder();
    f.write("many.toml", &"[[object]]\ntype = \"sphere\"\ncenter = [1.5, 2.5, 3.5]\n".repeat(60_000));
    f.turner(&["many.toml", "--max-memory", "64M"]).fails(1, &["error[E0109]", "many.toml", "--max-memory"]);
    // Memory that no estimate covers: at least 28 bytes per byte of text.
    let nodes = format!("{{\"asset\":{{\"version\":\"2.0\"}},\"nodes\":[{}{{}}]}}", "{},".repeat(1_000_000));
    f.write("nodes.gltf", &nodes);
    f.turner(&["nodes.gltf", "--max-memory", "100M"])
        .fails(1, &["error[E0109]", "nodes.gltf", "--max-memory"]);
    // The error is an event as well.
    let run = f.turner(&["nodes.gltf", "--max-memory", "100M", "--json"]);
    let last: serde_json::Value = serde_json::from_str(run.stdout.lines().last().unwrap()).unwrap();
    assert_eq!((&last["event"], &last["code"]), (&"error".into(), &"E0109".into()), "{run:?}");
    assert!(run.stderr.is_empty(), "{run:?}");
}

#[test]
fn triangles_are_counted_once_per_mesh() {
    let f = folder();
    f.write("t.toml", &format!("{SCENE}\n{TRIANGLES}"));
    f.turner(&["t.toml", "--max-triangles", "1"])
        .fails(1, &["error[E0109]", "2 triangles", "--max-triangles"]);
    f.turner(&["t.toml", "--max-triangles", "2"]).ok();
    let in_group = TRIANGLES.replace("[[object]]", "[[group.g.object]]");
    let placed = "[[object]]\ntype = \"instance\"\ngroup = \"g\"\n".repeat(5);
    f.write("g.toml", &format!("{SCENE}\n{in_group}{placed}"));
    f.turner(&["g.toml", "--max-triangles", "2"]).ok();
    f.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 2 1\n");
    f.turner(&["a.obj", "--max-triangles", "1"]).fails(1, &["a.obj", "--max-triangles"]);
}

#[test]
fn pictures_of_scenes_are_halved_too() {
    let f = folder();
    f.turner(&["s.toml", "-o", "p.png", "--width", "40", "--height", "20"]).ok();
    let text = "[[object]]\ntype = \"rectangle\"\nmaterial = { color = { type = \"image\", file = \"p.png\" } }\n\
[[light]]\ntype = \"ambient\"\n";
    f.write("i.toml", text);
    let bytes = |args: &[&str]| -> u64 {
        let json: serde_json::Value = serde_json::from_str(&f.turner(args).ok().stdout).unwrap();
        json["memory"]["textures"].as_u64().unwrap()
    };
    let full = bytes(&["info", "i.toml", "--json"]);
    let halved = bytes(&["info", "i.toml", "--json", "--max-texture-size", "20"]);
    assert_eq!(full, 4 * halved, "{full} {halved}");
}

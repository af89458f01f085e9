//! Paths that lead out of the scene's folder, and paths that are not regular files.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

use super::run::{Expected, SECRET, try_one};

/// A triangle whose positions are in the buffer.
const GLTF: &str = r#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
    "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":"$"}]}"#;

/// Scenes that name a file; `$` stands for the name.
const SCENES: [(&str, &str); 12] = [
    ("s.toml", "include = \"$\"\n"),
    ("s.toml", "[[object]]\ntype = \"sphere\"\nmaterial = { color = { type = \"image\", file = \"$\" } }\n"),
    ("s.toml", "[[object]]\ntype = \"mesh\"\nfile = \"$\"\n"),
    ("s.toml", "[[object]]\ntype = \"sphere\"\nmaterial = { type = \"measured\", file = \"$\" }\n"),
    ("s.toml", "[[light]]\ntype = \"point\"\nposition = [0, 0, 0]\nies = \"$\"\n"),
    ("s.toml", "[[object]]\ntype = \"text\"\ntext = \"a\"\nfont = \"$\"\n"),
    ("s.gltf", GLTF),
    ("s.pbrt", "WorldBegin\nInclude \"$\"\n"),
    ("s.pbrt", "WorldBegin\nShape \"plymesh\" \"string filename\" \"$\"\n"),
    ("s.usda", "#usda 1.0\ndef Sphere \"A\" (references = @$@) {}\n"),
    ("s.usda", "#usda 1.0\ndef Sphere \"A\" {}\ndef DomeLight \"L\" { asset inputs:texture:file = @$@ }\n"),
    ("s.obj", "mtllib $\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
];

/// Each case prepares a path; every scene is tried with all of them.
pub(super) fn try_them() {
    let top = tempfile::tempdir().unwrap();
    let secret = format!("{SECRET} = 1\n");
    fs::write(top.path().join("secret.toml"), &secret).unwrap();
    fs::write(top.path().join("secret.bin"), &secret).unwrap();
    let inside = top.path().join("in");
    fs::create_dir_all(inside.join("folder")).unwrap();
    symlink("../secret.toml", inside.join("link.toml")).unwrap();
    symlink("..", inside.join("up")).unwrap();
    symlink("loop", inside.join("loop")).unwrap();
    symlink("/dev/zero", inside.join("zero")).unwrap();
    symlink("/proc/self/mem", inside.join("mem")).unwrap();
    fs::write(inside.join("empty"), "").unwrap();
    assert!(Command::new("mkfifo").arg(inside.join("pipe")).status().unwrap().success());
    let absolute = top.path().join("secret.toml");
    let names = [
        "../secret.toml",
        "folder/../../secret.toml",
        "%2e%2e/secret.toml",
        "..%2fsecret.toml",
        "%2e%2e%2fsecret.bin",
        "..\\\\secret.toml",
        "file:///etc/passwd",
        "/etc/passwd",
        "\\\\\\\\host\\\\share\\\\x",
        "//host/share/x",
        "C:\\\\secret.toml",
        "http://127.0.0.1:9/x",
        "link.toml",
        "up/secret.toml",
        "loop",
        "zero",
        "mem",
        "pipe",
        "folder",
        ".",
        "..",
        "",
        "empty",
        "nowhere",
        &"n".repeat(5000),
        absolute.to_str().unwrap(),
    ];
    let mut faults = Vec::new();
    for (file, text) in SCENES {
        for name in names {
            fs::write(inside.join(file), text.replace('$', name)).unwrap();
            // An unreadable material library is ignored, and a reference of a USD stage.
            let is_lenient = file == "s.obj" || file == "s.usda" || name == "empty";
            let expected = if is_lenient { Expected::Either } else { Expected::Error };
            if let Err(fault) = try_one(&inside, file, expected) {
                faults.push(format!("{file} {name:.40}: {fault}"));
            }
        }
    }
    for main in ["folder", "pipe", "zero", "nowhere.toml", "loop"] {
        if let Err(fault) = try_one(Path::new(&inside), main, Expected::Error) {
            faults.push(format!("{main}: {fault}"));
        }
    }
    assert!(faults.is_empty(), "{}:\n{}", faults.len(), faults.join("\n"));
}

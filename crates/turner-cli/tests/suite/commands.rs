//! Runs every command of the documents with small pictures. For commands that take minutes or do not end only the
//! arguments are parsed.
#![cfg(unix)]

use crate::common::{Folder, SCENE, folder};
use crate::sh_blocks::{documents, lines, root};

/// The arguments of a `turner` command; `None` for other commands.
fn arguments(line: &str) -> Option<Vec<String>> {
    let line = line.split(" #").next().unwrap_or(line).trim();
    let line = line.split(" > ").next().unwrap_or(line);
    let rest = line.strip_prefix("turner ").or_else(|| line.strip_prefix("cargo run --release -- "))?;
    let name = |word: &str| match word {
        "SCENE" => "scene.toml".to_owned(),
        word => word.trim_matches('"').to_owned(),
    };
    Some(rest.split_whitespace().map(name).collect())
}

/// The command that is run instead.
fn small(mut args: Vec<String>) -> Vec<String> {
    const OTHERS: [&str; 18] = [
        "resume",
        "merge",
        "remake",
        "new",
        "explain",
        "doctor",
        "compare",
        "tonemap",
        "view",
        "convert",
        "farm",
        "info",
        "list",
        "help",
        "completions",
        "man",
        "bench",
        "verify",
    ];
    let command = args.first().cloned().unwrap_or_default();
    if ["bench", "verify", "watch", "studio", "serve"].contains(&&*command) {
        args.push("--help".to_owned());
        return args;
    }
    if OTHERS.contains(&&*command) || args.iter().any(|a| a.starts_with("--help")) {
        return args;
    }
    // Parts of the samples keep their ranges.
    let samples = if args.iter().any(|a| a == "--sample-range" || a == "--part") { "256" } else { "1" };
    for (option, value) in [("--width", "24"), ("--height", "16"), ("--samples", samples)] {
        match args.iter().position(|a| a == option) {
            Some(i) => args[i + 1] = value.to_owned(),
            None => args.extend([option.to_owned(), value.to_owned()]),
        }
    }
    args
}

/// A folder with all files that the commands in documents name.
fn desk() -> Folder {
    let f = folder();
    for name in ["scenes", "docs"] {
        std::os::unix::fs::symlink(root().join(name), f.path().join(name)).unwrap();
    }
    let model = root().join("crates/turner-io/tests/assets/gltf/Fox.glb");
    std::fs::copy(model, f.path().join("model.glb")).unwrap();
    // What `cargo xtask web` builds. The page of an explanation holds it as it is.
    std::fs::create_dir_all(f.path().join("target/web")).unwrap();
    std::fs::write(f.path().join("target/web/turner.wasm"), b"\0asm").unwrap();
    f.write("scene.toml", SCENE);
    f.write(
        "scene.pbrt",
        "Camera \"perspective\"\nWorldBegin\nLightSource \"infinite\"\nTranslate 0 0 4\nShape \"sphere\"\n",
    );
    f.write(
        "scene.xml",
        "<scene version=\"3.0.0\"><default name=\"spp\" value=\"1\"/><sensor type=\"perspective\"><float name=\"fov\" value=\"40\"/><sampler type=\"independent\"><integer name=\"sample_count\" value=\"$spp\"/></sampler></sensor><shape type=\"sphere\"><point name=\"center\" x=\"0\" y=\"0\" z=\"5\"/></shape><emitter type=\"constant\"/></scene>",
    );
    let mut seeds = turner_io::testing::seeds::seeds().into_iter();
    let mut seed = |end: &str| seeds.find(|seed| seed.name.ends_with(end)).unwrap().bytes;
    std::fs::write(f.path().join("shot.usda"), seed(".usda")).unwrap();
    std::fs::write(f.path().join("model.usdz"), seed(".usdz")).unwrap();
    let part =
        ["scene.toml", "--integrator", "path", "--sample-range", "0..2", "-o", "scene.png", "--checkpoint"];
    f.turner(&[&part[..], &[".scene.png.turner-checkpoint"]].concat()).ok();
    for picture in
        ["expected.png", "found.png", "expected.exr", "found.exr", "old.png", "new.png", "studio.hdr"]
    {
        f.turner(&["s.toml", "-o", picture]).ok();
    }
    f
}

#[test]
fn every_command_of_the_documents_runs() {
    let (mut wrong, mut count) = (Vec::new(), 0);
    for file in documents() {
        // A command may use the output of the previous one.
        let f = desk();
        for (number, line) in lines(&std::fs::read_to_string(&file).unwrap()) {
            let Some(args) = arguments(&line).map(small) else { continue };
            count += 1;
            let words: Vec<&str> = args.iter().map(String::as_str).collect();
            let run = f.turner(&words);
            if run.code != Some(0) {
                wrong.push(format!("{}:{number}: {line}\n{:?} {}", file.display(), run.code, run.stderr));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(count > 60, "{count} commands");
}

//! docs/*.md: generated references are up to date, and every snippet renders.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use turner::integrator::IntegratorDesc;
use turner::render::{PassOptions, Renderer};
use turner::schema::PrepareOptions;
use turner_io::assets::{AssetError, AssetSource};
use turner_io::image::ImageFormat;
use turner_io::scene::{LoadOptions, SceneFormat, load_text};

const BEGIN: &str = "<!-- generated: reference -->";
const END: &str = "<!-- end -->";

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs")
}

#[test]
fn the_reference_is_generated() {
    let path = docs().join("reference/scene-format.md");
    let text = std::fs::read_to_string(&path).unwrap();
    let begin = text.find(BEGIN).expect("a marker") + BEGIN.len();
    let end = text.find(END).expect("an end marker");
    let generated = format!("\n\n{}\n", turner_cli::reference::markdown());
    if std::env::var_os("TURNER_UPDATE").is_some_and(|v| v == "1") {
        std::fs::write(&path, format!("{}{generated}{}", &text[..begin], &text[end..])).unwrap();
        return;
    }
    let same = text[begin..end].replace("\r\n", "\n") == generated;
    assert!(same, "docs/reference/scene-format.md is out of date: run this test with TURNER_UPDATE=1");
}

/// Documents that are generated completely.
#[test]
fn the_lists_of_errors_and_options_are_generated() {
    let documents = [
        ("reference/errors.md", turner_cli::error_pages::markdown()),
        ("reference/command-line.md", turner_cli::command_line::markdown()),
    ];
    for (name, generated) in documents {
        let path = docs().join(name);
        if std::env::var_os("TURNER_UPDATE").is_some_and(|v| v == "1") {
            std::fs::write(&path, generated).unwrap();
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap_or_default().replace("\r\n", "\n");
        assert!(text == generated, "docs/{name} is out of date: run this test with TURNER_UPDATE=1");
    }
}

/// Documents that contain a complete list.
#[test]
fn lists_in_documents_are_complete() {
    let root = docs().join("..");
    let text = |name: &str| std::fs::read_to_string(root.join(name)).unwrap();
    let looking = text("docs/reference/debug-views.md");
    for entry in IntegratorDesc::DOC.entries {
        let is_view = IntegratorDesc::of_type(entry.name).unwrap().capabilities().debug;
        let row = format!("| `{}` |", entry.name);
        assert!(
            !is_view || looking.contains(&row),
            "docs/reference/debug-views.md has no row for {}",
            entry.name
        );
    }
    let words = |name: &str| -> Vec<String> {
        text(name).split(|c: char| !c.is_alphanumeric()).map(str::to_lowercase).collect()
    };
    let pictures = || ImageFormat::all().map(|f| (f.name(), f.extensions()));
    let scenes = SceneFormat::all().map(|f| (f.name(), f.extensions()));
    let (security, compare) = (words("SECURITY.md"), words("docs/reference/compare.md"));
    let names =
        |words: &[String], extensions: &[&str]| words.iter().any(|w| extensions.contains(&w.as_str()));
    for (name, extensions) in pictures().chain(scenes) {
        assert!(names(&security, extensions), "SECURITY.md does not name {name} by an extension");
    }
    for (name, extensions) in pictures() {
        let found = names(&compare, extensions) || text("docs/reference/compare.md").contains(name);
        assert!(found, "docs/reference/compare.md does not name {name}");
    }
}

/// Every format has a fuzz target, named after an extension or the format.
#[test]
fn formats_have_fuzz_targets() {
    let folder = docs().join("../fuzz");
    let [manifest, readme] =
        ["Cargo.toml", "README.md"].map(|name| std::fs::read_to_string(folder.join(name)).unwrap());
    let pictures = ImageFormat::all().map(|f| (f.name(), f.extensions()));
    let scenes = SceneFormat::all().map(|f| (f.name(), f.extensions()));
    for (name, extensions) in pictures.chain(scenes) {
        // The target of Turner's own format.
        let own = if name == "TOML" { "scene".to_owned() } else { name.to_lowercase() };
        let exists = |target: &&str| folder.join(format!("fuzz_targets/{target}.rs")).exists();
        let target = extensions.iter().copied().chain([own.as_str()]).find(exists);
        let target = target.unwrap_or_else(|| panic!("{name} has no fuzz target"));
        assert!(manifest.contains(&format!("name = \"{target}\"")), "fuzz/Cargo.toml: {target}");
        assert!(readme.contains(&format!("`{target}`")), "fuzz/README.md: {target}");
    }
}

/// A minimal file for a file name in a snippet.
struct AnyFile;

const TRIANGLE_PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
    property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

impl AssetSource for AnyFile {
    fn read(&self, uri: &str, _: u64) -> Result<Vec<u8>, AssetError> {
        let picture = |format| {
            let image = turner_io::image::OutputImage {
                width: 1,
                height: 1,
                alpha: false,
                linear: Some(&[[0.5, 0.5, 0.5, 1.0]]),
                display: Some(turner_io::image::Display::U8(&[[128, 128, 128, 255]])),
                transfer: turner_io::image::Transfer::Unstated,
                metadata: &Default::default(),
                threads: 1,
                ..turner_io::image::OutputImage::default()
            };
            turner_io::image::encode(&image, format).unwrap()
        };
        Ok(match uri.rsplit_once('.').map(|(_, e)| e) {
            Some("toml") => Vec::new(),
            Some("obj") => b"v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl paint\nf 1 2 3\n".to_vec(),
            Some(kind @ ("vdb" | "ttf" | "bsdf")) => {
                let mut seeds = turner_io::testing::seeds::seeds().into_iter();
                seeds.find(|seed| seed.name.ends_with(&format!(".{kind}"))).unwrap().bytes
            }
            // The points of one curve.
            Some("hair") => TRIANGLE_PLY.as_bytes().to_vec(),
            Some("ply") => TRIANGLE_PLY.as_bytes().to_vec(),
            _ => picture(turner_io::image::ImageFormat::of_path(Path::new(uri)).unwrap()),
        })
    }

    fn describe(&self, uri: &str) -> String {
        uri.to_owned()
    }
}

/// Loads, prepares and renders a snippet. A fragment gets an object and a light if it has none.
fn render(name: &str, snippet: &str) -> Result<(), String> {
    let mut text = snippet.to_owned();
    if !text.contains("[[object]]") {
        text += "\n[[object]]\ntype = \"sphere\"\n";
    }
    if !text.contains("[[light]]") {
        text += "\n[[light]]\ntype = \"point\"\nposition = [3, 5, 4]\n";
    }
    let fail = |what: &dyn std::fmt::Display| format!("{name}: {what}\n{text}\n");
    let mut desc = load_text(text.clone(), "snippet.toml", &AnyFile, &LoadOptions::default())
        .map_err(|e| fail(&e))?
        .desc;
    (desc.film.width, desc.film.height, desc.film.crop) = (16, 12, None);
    desc.film.samples = desc.film.samples.min(4);
    let scene = desc.prepare(&PrepareOptions { threads: 1, ..Default::default() }).map_err(|e| fail(&e))?;
    let mut renderer = Renderer::new(scene).map_err(|e| fail(&e))?;
    let options = PassOptions { threads: 1, cancel: &AtomicBool::new(false), progress: None };
    renderer.pass(u32::MAX, &options).map_err(|e| fail(&e))?;
    match renderer.film.non_finite.count {
        0 => Ok(()),
        n => Err(fail(&format!("{n} non-finite samples"))),
    }
}

/// The ```toml blocks of a document, with the line where each begins.
fn snippets(text: &str) -> Vec<(usize, String)> {
    let mut out: Vec<(usize, String)> = Vec::new();
    let mut inside = false;
    for (i, line) in text.lines().enumerate() {
        match (inside, line.trim()) {
            (false, "```toml") => {
                inside = true;
                out.push((i + 1, String::new()));
            }
            (true, "```") => inside = false,
            (true, _) => {
                let (_, text) = out.last_mut().unwrap();
                text.push_str(line);
                text.push('\n');
            }
            _ => {}
        }
    }
    out
}

#[test]
fn every_example_renders() {
    let examples = turner_cli::reference::examples();
    assert!(examples.len() > 10);
    let wrong: Vec<String> = examples.iter().filter_map(|(name, text)| render(name, text).err()).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_snippet_of_the_documents_renders() {
    let mut wrong = Vec::new();
    for path in crate::sh_blocks::markdown_below(&docs()) {
        let text = std::fs::read_to_string(&path).unwrap();
        let file = path.file_name().unwrap().to_string_lossy().into_owned();
        let each = snippets(&text);
        wrong.extend(each.iter().filter_map(|(line, text)| render(&format!("{file}:{line}"), text).err()));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

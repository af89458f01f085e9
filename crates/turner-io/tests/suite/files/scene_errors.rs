//! Error messages (code, position, problem, remedy), and scenes that load.

use std::path::Path;

use turner::description::{ObjectContent, SceneAssets};
use turner::image::Image;
use turner::schema::value::FileId;
use turner::shape::ShapeDesc;
use turner_io::assets::{AssetSource, FolderAssets, MemoryAssets};
use turner_io::scene::{LoadError, LoadOptions, Loaded, Override, load, load_text};

fn memory(files: &[(&str, &str)]) -> MemoryAssets {
    let files = files.iter().map(|(name, text)| ((*name).to_owned(), text.as_bytes().to_vec())).collect();
    MemoryAssets { files }
}

fn with(text: &str, files: &[(&str, &str)], overrides: &[&str]) -> Result<Loaded, LoadError> {
    let overrides = overrides.iter().map(|o| Override::parse(o).unwrap()).collect();
    let options = LoadOptions { overrides, ..LoadOptions::default() };
    load_text(text.to_owned(), "scene.toml", &memory(files), &options)
}

fn radii(loaded: &Loaded) -> Vec<f64> {
    let radius = |o: &turner::description::ObjectDesc| match &o.content {
        ObjectContent::Shape(ShapeDesc::Sphere(s)) => s.radius,
        _ => f64::NAN,
    };
    loaded.desc.objects.iter().map(radius).collect()
}

/// Text, other files, overrides; then code, file, line, column, words of the message, words of the help.
type Bad<'a> =
    (&'a str, &'a [(&'a str, &'a str)], &'a [&'a str], &'a str, &'a str, usize, usize, &'a str, &'a str);

#[test]
fn bad_scenes_say_where_and_what_to_do() {
    let cycle: &[(&str, &str)] =
        &[("a.toml", "include = \"b.toml\""), ("b.toml", "\ninclude = [\"a.toml\"]")];
    let parts: &[(&str, &str)] =
        &[("parts/p.toml", "[[object]]\ntype = \"spere\"\n"), ("parts/bad.toml", "a = \n")];
    #[rustfmt::skip]
    let table: &[Bad<'_>] = &[
        ("hello, world\n", &[], &[], "E0101", "scene.toml", 1, 6, "", "key = value"),
        ("[film\nwidth = 3\n", &[], &[], "E0101", "scene.toml", 1, 6, "]", "key = value"),
        ("a = 1\na = 2\n", &[], &[], "E0101", "scene.toml", 2, 1, "duplicate key", "appear once"),
        ("[[object]]\ntype = \"sphere\"\nradus = 2\n", &[], &[], "E0102", "scene.toml", 3, 1, "unknown key `radus`", "radius"),
        ("[[objekt]]\n", &[], &[], "E0102", "scene.toml", 1, 3, "objekt", "object"),
        ("[[object]]\n  type = \"spere\"\n", &[], &[], "E0103", "scene.toml", 2, 10, "spere", "did you mean \"sphere\""),
        ("[[object]]\ntype = \"sphere\"\nmaterial = \"gold\"\n[material.cold]\n", &[], &[], "E0103", "scene.toml", 3, 12, "gold", "cold"),
        ("[[object]]\ntype = \"sphere\"\nradius = \"two\"\n", &[], &[], "E0104", "scene.toml", 3, 10, "a string", ""),
        ("[[object]]\r\ntype = \"sphere\"\r\nradius = -1\r\n", &[], &[], "E0105", "scene.toml", 3, 10, "-1", ""),
        ("\u{feff}[film]\nwidth = 0\n", &[], &[], "E0105", "scene.toml", 2, 9, "width", ""),
        ("[camera]\nfov = nan\n", &[], &[], "E0105", "scene.toml", 2, 7, "NaN", ""),
        ("[film]\nwidth = 1979-05-27\n", &[], &[], "E0104", "scene.toml", 2, 9, "date", "quotes"),
        ("include = \"a.toml\"", cycle, &[], "E0108", "b.toml", 2, 12, "a.toml -> b.toml -> a.toml", "remove"),
        ("include = \"scene.toml\"", &[], &[], "E0108", "scene.toml", 1, 11, "scene.toml -> scene.toml", "remove"),
        ("include = 3", &[], &[], "E0104", "scene.toml", 1, 11, "an integer", "include = ["),
        ("include = \"parts/p.toml\"", parts, &[], "E0103", "parts/p.toml", 2, 8, "spere", "sphere"),
        ("include = \"parts/bad.toml\"", parts, &[], "E0101", "parts/bad.toml", 1, 5, "", "quotes"),
        ("include = [\n\"parts/q.toml\"]", parts, &[], "E0201", "scene.toml", 2, 1, "no such file", "check the name"),
        ("include = \"../x.toml\"", &[], &[], "E0201", "scene.toml", 1, 11, "..", "read that folder"),
        ("include = \"%2e%2e/x.toml\"", &[], &[], "E0201", "scene.toml", 1, 11, "..", "read that folder"),
        ("include = \"/etc/passwd\"", &[], &[], "E0201", "scene.toml", 1, 11, "absolute", "read that folder"),
        ("include = \"https://a.b/c.toml\"", &[], &[], "E0201", "scene.toml", 1, 11, "does not use the network", ""),
        ("", &[], &["film.width=0"], "E0105", "-D film.width=0", 1, 12, "width", ""),
        ("", &[], &["film.widht=3"], "E0102", "-D film.widht=3", 1, 6, "widht", "width"),
        ("[[object]]\ntype=\"sphere\"", &[], &["object.1.radius=3"], "E0105", "-D object.1.radius=3", 1, 8, "1 entries", "0 to 0"),
        ("[film]\nwidth = 3", &[], &["film.width.x=3"], "E0104", "-D film.width.x=3", 1, 12, "an integer", "replace its value"),
    ];
    for (text, files, overrides, code, file, line, column, message, help) in table {
        let Err(error) = with(text, files, overrides) else { panic!("loads: {text:?}") };
        let shown = error.to_string();
        assert_eq!((error.code(), error.file().unwrap_or("-")), (*code, *file), "{text:?}: {shown}");
        assert_eq!((error.line(), error.column()), (Some(*line), Some(*column)), "{text:?}: {shown}");
        assert!(error.error.message.contains(message), "{text:?}: {shown}");
        assert!(error.error.help.clone().unwrap_or_default().contains(help), "{text:?}: {shown}");
        assert!(
            shown.lines().count() <= 3 && shown.starts_with(&format!("error[{code}]: {file}")),
            "{shown}"
        );
    }
}

#[test]
fn included_sections_come_first_and_the_including_file_wins() {
    let base =
        "[film]\nwidth = 10\nheight = 20\n[[object]]\ntype=\"sphere\"\nradius=1\n[material.m]\nkd = 0.1\n";
    let files = [
        ("base.toml", base),
        ("sub/more.toml", "include = \"../base.toml\"\n[[object]]\ntype=\"sphere\"\nradius=2\n"),
    ];
    let text = "include = [\"base.toml\", \"sub/more.toml\"]\n[film]\nwidth = 30\n[[object]]\ntype=\"sphere\"\nradius=3\n[material.m]\ncolor = \"red\"\n";
    let loaded = with(text, &files, &[]).unwrap();
    assert_eq!(radii(&loaded), [1.0, 2.0, 3.0]);
    assert_eq!((loaded.desc.film.width, loaded.desc.film.height), (30, 20));
    assert_eq!(loaded.desc.materials.len(), 1);
    let span = loaded.desc.objects[1].span.unwrap();
    assert_eq!(
        loaded.sources.locate(span).map(|l| (l.file.to_owned(), l.line)),
        Some(("sub/more.toml".into(), 2))
    );
    let changed = with(text, &files, &["object.1.radius=7", "film.width=5"]).unwrap();
    assert_eq!((radii(&changed), changed.desc.film.width), (vec![1.0, 7.0, 3.0], 5));
    assert_ne!(changed.hash, loaded.hash);
    assert_eq!(with(text, &files, &[]).unwrap().hash, loaded.hash);
}

#[test]
fn chains_of_includes_end_at_a_limit() {
    let chain = |n: usize| {
        let files: Vec<(String, String)> =
            (0..n).map(|i| (format!("{i}.toml"), format!("include = \"{}.toml\"", i + 1))).collect();
        let mut files: Vec<(&str, &str)> = files.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
        let last = format!("{n}.toml");
        files.push((&last, ""));
        with("include = \"0.toml\"", &files, &[])
    };
    assert!(chain(60).is_ok());
    assert_eq!(chain(5000).unwrap_err().code(), "E0108");
}

#[test]
fn files_on_disk() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    let fail = |name: &str| load(&folder.path().join(name), &LoadOptions::default()).unwrap_err();
    write("scene.toml", b"[[object]]\ntype=\"sphere\"\n");
    assert!(load(&folder.path().join("scene.toml"), &LoadOptions::default()).is_ok());
    let error = fail("scne.toml");
    assert!(error.code() == "E0201" && error.to_string().contains("scene.toml"), "{error}");
    write("latin.toml", b"[film]\nwidth = 3 # caf\xe9\n");
    let error = fail("latin.toml");
    assert!(error.code() == "E0101" && error.to_string().contains("byte 22 (line 2) is 0xe9"), "{error}");
    assert!(fail("a.glb").to_string().contains("a.glb: no such file"));
    write("a.glb", b"glTF\x02\0\0\0\xff\xff\xff\xff");
    let error = fail("a.glb");
    assert!(error.code() == "E0204" && error.to_string().contains("a.glb"), "{error}");
    assert!(fail("a.fbx").to_string().contains("glTF"));
    assert!(fail("no/such/a.toml").to_string().contains("no/such"));
    write("inc.toml", b"include = \"latin.toml\"\n");
    assert_eq!(fail("inc.toml").line(), Some(1));
    assert!(fail(".").code() == "E0201");
}

/// Loads the files that shapes and textures refer to.
struct Probe<'a>(Vec<(&'a str, bool)>);

impl Probe<'_> {
    fn run(&self, assets: &dyn AssetSource) -> Vec<String> {
        let sources = turner_io::scene::Sources::default();
        let mut files = turner_io::scene::SceneFiles::new(assets, &sources);
        let show = |r: Result<(), turner::schema::SceneError>| match r {
            Ok(()) => "ok".to_owned(),
            Err(e) => format!("{} {} | {}", e.code.as_str(), e.message, e.help.unwrap_or_default()),
        };
        let run = |&(uri, is_mesh): &(&str, bool)| match is_mesh {
            true => show(files.mesh(uri, FileId(0)).map(|_| ())),
            false => show(files.image(uri, FileId(0)).map(|_: std::sync::Arc<Image>| ())),
        };
        self.0.iter().map(run).collect()
    }
}

#[test]
fn named_files_are_read_once_and_their_errors_name_them() {
    let folder = FolderAssets::new(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data")).unwrap();
    let mut files =
        memory(&[("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"), ("a.off", "OFF"), ("a.png", "")]);
    let png = folder.read("basn2c08.png", 1 << 20).unwrap();
    files.files.insert("cut.png".into(), png[..90].to_vec());
    let uris =
        vec![("a.obj", true), ("a.off", true), ("cut.png", false), ("../a.png", false), ("b.png", false)];
    let shown = Probe(uris).run(&files);
    assert!(
        shown[0].starts_with(
            "E0203 a.obj: damaged Wavefront OBJ: line 4: face 1 refers to vertex 4, but there are 3"
        ),
        "{shown:?}"
    );
    assert!(shown[1].starts_with("E0203 a.off: not a mesh") && shown[1].contains(".obj"), "{shown:?}");
    assert!(shown[2].starts_with("E0202 cut.png: damaged PNG"), "{shown:?}");
    assert!(shown[3].starts_with("E0201 ../a.png"), "{shown:?}");
    assert!(shown[4].starts_with("E0201 b.png: no such file") && shown[4].contains("a.png"), "{shown:?}");
    let sources = turner_io::scene::Sources::default();
    let mut files = turner_io::scene::SceneFiles::new(&folder, &sources);
    let first = files.mesh("cube.obj", FileId(0)).unwrap();
    assert!(std::sync::Arc::ptr_eq(&first, &files.mesh("./cube.obj", FileId(0)).unwrap()));
}

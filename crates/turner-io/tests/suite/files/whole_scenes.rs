//! Scenes of other renderers and models: their own settings, and the options that override them.

use std::path::PathBuf;

use turner::camera::CameraDesc;
use turner::description::{ObjectContent, SceneDesc};
use turner::film::TextureFilter;
use turner::integrator::{DepthMeasure, IntegratorDesc};
use turner::math::DVec3;
use turner::schema::value::{Data, Table};
use turner::schema::{ErrorCode, KeyEdit};
use turner_io::assets::FolderAssets;
use turner_io::import::{ImportOptions, import_file};
use turner_io::scene::{SceneFiles, Sources};
use turner_io::{LoadError, LoadOptions, Override, load, load_with};

const PBRT: &str = "LookAt 0 0 -5 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" 40\n\
    Film \"rgb\" \"integer xresolution\" 40 \"integer yresolution\" 30 \"float maxcomponentvalue\" 9\n\
    Sampler \"halton\" \"integer pixelsamples\" 7\n\
    Option \"bool disabletexturefiltering\" true\n\
    Integrator \"ambientocclusion\" \"float maxdistance\" 2.5\n\
    WorldBegin\n\
    MakeNamedMaterial \"paint\" \"string type\" \"diffuse\" \"rgb reflectance\" [ 0.2 0.4 0.6 ]\n\
    LightSource \"point\" NamedMaterial \"paint\" Shape \"sphere\" Translate 2 0 0 Shape \"sphere\"\n";

/// A file with a text, in a folder of its own.
fn file(name: &str, text: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    (folder, path)
}

fn changed(name: &str, text: &str, overrides: &[&str]) -> Result<SceneDesc, LoadError> {
    let (_folder, path) = file(name, text);
    let overrides = overrides.iter().map(|o| Override::parse(o).unwrap()).collect();
    load_with(path, &LoadOptions { overrides, ..LoadOptions::default() }).map(|loaded| loaded.desc)
}

#[test]
fn what_a_file_says_of_film_integrator_and_camera_is_what_is_loaded() {
    for (name, text) in [
        ("a.pbrt", PBRT),
        (
            "a.xml",
            "<scene version=\"3.0.0\"><integrator type=\"depth\"/><sensor type=\"perspective\"><film type=\"ldrfilm\"><float name=\"exposure\" value=\"1.5\"/></film></sensor><shape type=\"sphere\"/></scene>",
        ),
    ] {
        let (folder, path) = file(name, text);
        let scene = load(&path).unwrap();
        let assets = FolderAssets::new(folder.path()).unwrap();
        let imported = import_file(name, &assets, &ImportOptions::default()).unwrap();
        let own = SceneDesc { studio: scene.studio.clone(), ..imported };
        own.same_scene(&scene).unwrap_or_else(|e| panic!("{name}: {e}"));
    }
    let scene = changed("a.pbrt", PBRT, &[]).unwrap();
    assert!(matches!(&scene.integrator, IntegratorDesc::AmbientOcclusion(i) if i.distance == 2.5));
    let film = &scene.film;
    assert_eq!((film.width, film.samples, film.clamp_sample), (40, 7, 9.0));
    assert_eq!(film.texture_filter, TextureFilter::Off);
}

#[test]
fn exposures_and_depths_of_mitsuba_are_kept() {
    let film = |film: &str| {
        format!(
            "<scene version=\"0.6.0\"><integrator type=\"depth\"/><sensor type=\"perspective\"><film type=\"ldrfilm\">{film}</film></sensor><shape type=\"sphere\"/></scene>"
        )
    };
    let exposure = "<float name=\"exposure\" value=\"1.5\"/>";
    let scene = changed("a.xml", &film(exposure), &[]).unwrap();
    assert_eq!(scene.film.exposure, 1.5);
    assert!(matches!(&scene.integrator, IntegratorDesc::Depth(d) if d.measure == DepthMeasure::Distance));
    let reinhard = format!("{exposure}<string name=\"tonemapMethod\" value=\"reinhard\"/>");
    assert_eq!(changed("a.xml", &film(&reinhard), &[]).unwrap().film.exposure, 0.0);
}

#[test]
fn options_change_what_they_name_and_nothing_else() {
    let scene = |overrides: &[&str]| changed("a.pbrt", PBRT, overrides).unwrap();
    let own = scene(&[]);
    let more = scene(&["film.samples=64", "integrator.samples=3", "studio.ground=true"]);
    assert_eq!(more.film.samples, 64);
    assert!(
        matches!(&more.integrator, IntegratorDesc::AmbientOcclusion(i) if (i.distance, i.samples) == (2.5, 3))
    );
    let [mut a, mut b] = [own.clone(), more];
    (a.film.samples, b.film.samples) = (0, 0);
    (a.integrator, a.studio) = (b.integrator.clone(), b.studio.clone());
    a.same_scene(&b).unwrap();

    // Keys of the camera that are not overridden stay.
    let moved = scene(&["camera.position=[1, 2, 3]"]);
    let [Some(CameraDesc::Pinhole(was)), Some(CameraDesc::Pinhole(is))] =
        [own.camera.clone(), moved.camera].map(|c| c.map(|c| c.value))
    else {
        panic!("two pinhole cameras")
    };
    assert_eq!(
        (is.position, is.look_at, is.viewport),
        (DVec3::new(1.0, 2.0, 3.0), was.look_at, was.viewport)
    );

    // Objects by name and by index.
    let name = own.materials.iter().position(|m| m.name.as_deref() == Some("paint")).unwrap();
    let painted = scene(&["material.paint={ type = \"matte\", color = \"red\" }", "object.1.name=right"]);
    assert_ne!(painted.materials[name].value, own.materials[name].value);
    assert_eq!((painted.objects.len(), painted.objects[1].name.as_deref()), (2, Some("right")));
    assert_eq!(painted.objects[0], own.objects[0]);
    assert_eq!(painted.objects[1].transform, own.objects[1].transform);
    let new = scene(&["material.new={ color = \"red\" }", "object.0.material=new", "light=[]"]);
    assert_eq!((new.materials.len(), new.lights.len()), (own.materials.len() + 1, 0));
    assert_eq!(new.objects[0].material.map(|m| m.index()), Some(own.materials.len()));
}

#[test]
fn another_integrator_drops_the_keys_of_the_old_one() {
    let scene = changed("a.pbrt", PBRT, &["integrator.type=path", "integrator.max_depth=3"]).unwrap();
    assert!(matches!(&scene.integrator, IntegratorDesc::Path(p) if p.max_depth == 3));
    let error = changed("a.pbrt", PBRT, &["integrator.type=normals", "integrator.max_depth=3"]).unwrap_err();
    assert_eq!((error.error.code, error.file()), (ErrorCode::UnknownKey, Some("-D integrator.max_depth=3")));
    let (_folder, path) =
        file("a.toml", "integrator = { type = \"path\", max_depth = 3, caustics = \"off\" }");
    let options = LoadOptions { integrator: Some("classic".into()), ..LoadOptions::default() };
    let scene = load_with(path, &options).unwrap().desc;
    assert!(matches!(&scene.integrator, IntegratorDesc::Classic(c) if c.max_depth == 3));
}

#[test]
fn errors_of_options_are_at_their_places() {
    for (option, code, at, words) in [
        ("film.sampels=3", ErrorCode::UnknownKey, 6, "`samples`"),
        ("flim.samples=3", ErrorCode::UnknownKey, 1, "`film`"),
        ("film.samples=many", ErrorCode::WrongType, 14, "expected"),
        ("film.samples=0", ErrorCode::OutOfRange, 14, "must be"),
        ("object.7.name=x", ErrorCode::OutOfRange, 8, "valid: 0 to 1"),
        ("object.x.name=x", ErrorCode::WrongType, 8, "expected an index"),
        ("object.0.material=pain", ErrorCode::UnknownName, 19, "\"paint\""),
        ("integrator.type=pathh", ErrorCode::UnknownName, 17, "\"path\""),
        ("texture.red={ type = \"marble\" }", ErrorCode::Conflict, 9, "colour"),
        ("include=[\"a.toml\"]", ErrorCode::Conflict, 1, "include"),
    ] {
        let error = changed("a.pbrt", PBRT, &[option]).unwrap_err();
        assert_eq!(error.error.code, code, "{option}: {error}");
        assert_eq!((error.file(), error.column()), (Some(&*format!("-D {option}")), Some(at)), "{error}");
        assert!(error.to_string().contains(words), "{error}");
    }
}

#[test]
fn a_model_is_an_object_whose_keys_can_be_set() {
    let box_glb = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/assets/gltf/Box.glb");
    let with = |overrides: &[&str]| {
        let overrides = overrides.iter().map(|o| Override::parse(o).unwrap()).collect();
        load_with(box_glb, &LoadOptions { overrides, ..LoadOptions::default() }).map(|loaded| loaded.desc)
    };
    let own = load(box_glb).unwrap();
    assert_eq!((own.objects.len(), own.film.samples, own.meshes.len()), (1, 8, 1));
    assert!(matches!(own.objects[0].content, ObjectContent::Instance(_)));
    let turned = with(&["object.0.up=z"]).unwrap();
    assert_ne!(turned.objects[0].transform, own.objects[0].transform);
    let red = with(&["object.0.material={ color = \"red\" }", "film.samples=5"]).unwrap();
    assert_eq!((red.objects[0].material.is_some(), red.film.samples), (true, 5));
    let error = with(&["object.0.upp=z"]).unwrap_err();
    assert_eq!((error.error.code, error.column()), (ErrorCode::UnknownKey, Some(10)));
    let error = with(&["object.0.nodes=[\"nobody\"]"]).unwrap_err();
    assert!(error.to_string().contains("nobody"), "{error}");
}

#[test]
fn an_edit_that_fails_changes_nothing() {
    let before = changed("a.pbrt", PBRT, &[]).unwrap();
    let assets = FolderAssets::new("").unwrap();
    let sources = Sources::default();
    let good = [
        KeyEdit::new("texture.new", table(&[("type", Data::String("marble".into()))])),
        KeyEdit::new("object.0.material", table(&[("color", Data::String("new".into()))])),
        KeyEdit::new("light", Data::Array(Vec::new())),
    ];
    let bad = KeyEdit::new("film.samples", Data::Integer(0));
    let mut scene = before.clone();
    let error =
        scene.edit(&[&good[..], &[bad]].concat(), &mut SceneFiles::new(&assets, &sources)).unwrap_err();
    assert_eq!((error.code, error.span), (ErrorCode::OutOfRange, None));
    assert_eq!(scene, before);
    // The film is read before the light, whose error ends the edit.
    let bad = KeyEdit::new("light", table(&[]));
    assert!(scene.edit(&[&good[..], &[bad]].concat(), &mut SceneFiles::new(&assets, &sources)).is_err());
    assert_eq!(scene, before);
    scene.edit(&good, &mut SceneFiles::new(&assets, &sources)).unwrap();
    assert_eq!(scene.lights.len(), 0);
    assert_eq!((scene.textures.len(), scene.materials.len()), (1, before.materials.len() + 1));
}

fn table(entries: &[(&str, Data)]) -> Data {
    let mut table = Table::default();
    entries.iter().for_each(|(key, data)| table.push(key, data.clone()));
    Data::Table(table)
}

//! Hidden objects and lights.

use std::sync::atomic::AtomicBool;

use turner::description::SceneDesc;
use turner::math::{DVec3, Ray};
use turner::prepare::Preparer;
use turner::schema::KeyEdit;
use turner::schema::value::Data;
use turner::{PassOptions, PrepareOptions, Prepared, Renderer};

use super::scene;

const SCENE: &str = r##"
[film]
width = 24
height = 16
antialias = "monte-carlo"
samples = 4

[integrator]
type = "path"

[camera]
position = [0, 1, 6]
look_at = [0, 0, 0]

[[light]]
type = "point"
position = [3, 5, 4]
intensity = 40

[[light]]
type = "sky"
hidden = true

[[object]]
type = "sphere"
name = "a"

[[object]]
type = "sphere"
name = "lamp"
hidden = true
center = [0, 2, 0]
material = { type = "emissive", strength = 5 }

[[object]]
type = "instance"
group = "g"
hidden = true

[[object]]
type = "plane"
name = "b"
point = [0, -1, 0]

[[group.g.object]]
type = "box"
transform = { translate = [1, 0, 1] }

[[group.g.object]]
type = "sphere"
hidden = true
"##;

fn rendered(prepared: Prepared) -> Vec<u32> {
    let mut renderer = Renderer::new(prepared).unwrap();
    let options = PassOptions { threads: 1, cancel: &AtomicBool::new(false), progress: None };
    renderer.pass(renderer.samples_per_pixel(), &options).unwrap();
    renderer.develop().linear.iter().flat_map(|c| c.map(f32::to_bits)).collect()
}

fn picture(desc: &SceneDesc) -> Vec<u32> {
    rendered(desc.prepare(&PrepareOptions::default()).unwrap())
}

#[test]
fn a_hidden_part_is_not_in_the_picture() {
    let desc = scene(SCENE);
    let (without, count) = desc.without_hidden();
    assert_eq!((count, without.objects.len(), without.lights.len()), (4, 2, 1));
    let (a, b) = (picture(&desc), picture(&without));
    assert!(a == b, "the picture is that of the scene without the hidden parts, to the byte");
    let mut shown = desc.clone();
    shown.objects[1].hidden = false;
    assert!(picture(&shown) != a);
}

#[test]
fn hiding_and_showing_is_an_edit_like_any_other() {
    let mut desc = scene(SCENE);
    assert_eq!(desc.value_at("object.1.hidden").unwrap().unwrap().data, Data::Bool(true));
    assert_eq!(desc.value_at("object.0.hidden").unwrap(), None);
    let mut preparer = Preparer::new(PrepareOptions::default());
    for (path, hidden) in [
        ("object.1.hidden", false),
        ("light.1.hidden", false),
        ("light.0.hidden", true),
        ("object.2.hidden", false),
        ("object.1.hidden", true),
    ] {
        preparer.update(&desc).unwrap();
        let edit = [KeyEdit::new(path, Data::Bool(hidden))];
        super::with_files(|files| desc.edit(&edit, files)).unwrap();
        assert!(rendered(preparer.update(&desc).unwrap()) == picture(&desc), "{path} = {hidden}");
    }
}

#[test]
fn other_objects_keep_their_place_in_the_list() {
    let mut desc = scene(SCENE);
    // Rays at the first object and at the last.
    let rays = [([0.0, 0.0, 5.0], [0.0, 0.0, -1.0]), ([50.0, 5.0, 0.0], [0.0, -1.0, 0.0])];
    let entries = |desc: &SceneDesc| {
        let scene = desc.prepare(&PrepareOptions::default()).unwrap().scene;
        rays.map(|(from, to)| {
            let hit = scene.intersect(&Ray::new(DVec3::from_array(from), DVec3::from_array(to))).unwrap();
            scene.entry_of(scene.primitive_id(&hit))
        })
    };
    assert_eq!(entries(&desc), [0, 3]);
    desc.objects[1].hidden = false;
    assert_eq!(entries(&desc), [0, 3]);
}

#[test]
fn a_glb_file_has_no_hidden_parts_and_a_note_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("scene.glb");
    let converted = turner_io::convert::to_glb(&scene(SCENE), &out, &Default::default()).unwrap();
    let note = converted.warnings.iter().find(|w| w.message.contains("hidden")).unwrap();
    assert_eq!(note.count, 4);
}

//! Documents under long sequences of random actions: undo, redo, save and load keep every scene.

use std::path::Path;
use std::sync::Arc;

use turner::SceneDesc;
use turner::camera::CameraDesc;
use turner::description::{ObjectContent, ObjectDesc, SceneLight};
use turner::film::FilmDesc;
use turner::integrator::IntegratorDesc;
use turner::light::{BackgroundDesc, LightDesc};
use turner::material::MaterialDesc;
use turner::schema::value::{Data, Value};
use turner::schema::{EntryDoc, FamilyDoc, Field};
use turner::shape::ShapeDesc;
use turner::texture::TextureDesc;
use turner_live::document::{Document, STARTS};

/// A sequence of numbers that looks random (SplitMix64).
struct Random(u64);

impl Random {
    fn below(&mut self, count: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) % count as u64) as usize
    }

    fn of<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.below(list.len())]
    }
}

const NUMBERS: &[f64] =
    &[-1.0, 0.0, 0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 10.0, 100.0, 1e6, f64::NAN, f64::INFINITY];

/// A value for a key, often one that it refuses.
fn value(field: &Field, random: &mut Random) -> Data {
    let words = (field.words)();
    if !words.is_empty() && random.below(5) > 0 {
        return Data::String(random.of(words).0.to_owned());
    }
    let number = |random: &mut Random| Value::new(Data::Number(random.of(NUMBERS)));
    let kind = (field.kind)();
    match random.below(10) {
        0 => Data::String(random.of(&["", "white", "a b", "no such thing", "\u{1F600}\"\n"]).to_owned()),
        1 => Data::Array((0..random.below(5)).map(|_| number(random)).collect()),
        _ if kind == "true | false" => Data::Bool(random.below(2) == 0),
        _ if kind == "integer" => Data::Integer(random.of(&[-1, 0, 1, 2, 7, 64, 1000])),
        _ if kind == "number" => number(random).data,
        _ => Data::Array((0..3).map(|_| number(random)).collect()),
    }
}

/// A random part of the scene: its path and the keys of its type.
fn part(
    desc: &SceneDesc,
    random: &mut Random,
) -> Option<(String, &'static FamilyDoc, Option<&'static EntryDoc>)> {
    let entry =
        |family: &'static FamilyDoc, name: &str| family.entries.iter().find(|e| e.name == name).copied();
    let index = |count: usize, random: &mut Random| (count > 0).then(|| random.below(count));
    let names = desc.names();
    Some(match random.below(9) {
        0 | 1 => {
            let i = index(desc.objects.len(), random)?;
            let ObjectContent::Shape(shape) = &desc.objects[i].content else { return None };
            (format!("object.{i}"), &ShapeDesc::DOC, entry(&ShapeDesc::DOC, shape.type_name()))
        }
        2 => {
            let i = index(desc.lights.len(), random)?;
            (format!("light.{i}"), &LightDesc::DOC, entry(&LightDesc::DOC, desc.lights[i].value.type_name()))
        }
        3 => {
            let i = index(desc.materials.len(), random)?;
            let kind = desc.materials[i].value.type_name();
            (format!("material.{}", names.materials[i]), &MaterialDesc::DOC, entry(&MaterialDesc::DOC, kind))
        }
        4 => {
            let i = index(desc.textures.len(), random)?;
            let kind = desc.textures[i].value.type_name();
            (format!("texture.{}", names.textures[i]), &TextureDesc::DOC, entry(&TextureDesc::DOC, kind))
        }
        5 => {
            let kind = desc.camera.as_ref()?.value.type_name();
            ("camera".into(), &CameraDesc::DOC, entry(&CameraDesc::DOC, kind))
        }
        6 => {
            let kind = desc.integrator.type_name();
            ("integrator".into(), &IntegratorDesc::DOC, entry(&IntegratorDesc::DOC, kind))
        }
        7 => ("film".into(), &IntegratorDesc::DOC, Some(&FilmDesc::DOC)),
        _ => ("background".into(), &IntegratorDesc::DOC, Some(&BackgroundDesc::DOC)),
    })
}

/// Changes a key or the type of a part. Returns whether the scene took it.
fn set(document: &mut Document, random: &mut Random) -> bool {
    let desc = Arc::clone(document.desc());
    let Some((path, family, entry)) = part(&desc, random) else { return false };
    let has_type = path != "film" && path != "background";
    let before = Arc::clone(document.desc());
    let (key, data) = match entry {
        Some(entry) if !entry.fields.is_empty() && (!has_type || random.below(8) > 0) => {
            let field = &entry.fields[random.below(entry.fields.len())];
            (field.name, value(field, random))
        }
        _ if has_type => ("type", Data::String(random.of(family.entries).name.to_owned())),
        _ => return false,
    };
    let merge = (random.below(3) == 0).then_some("gesture");
    let done = document.set(&format!("{path}.{key}"), merge, &[(format!("{path}.{key}"), data.clone())]);
    if let Err(error) = &done {
        assert!(Arc::ptr_eq(&before, document.desc()), "{path}.{key}: an error changed the scene");
        assert!(!error.message.is_empty(), "{path}.{key} = {data:?}");
    }
    done.is_ok()
}

/// The key paths of all parts that can be duplicated, removed and copied.
fn paths(desc: &SceneDesc) -> Vec<String> {
    let names = desc.names();
    let numbered = |list: &'static str, count: usize| (0..count).map(move |i| format!("{list}.{i}"));
    let named =
        |list: &'static str, names: Vec<String>| names.into_iter().map(move |name| format!("{list}.{name}"));
    let all = numbered("object", desc.objects.len()).chain(numbered("light", desc.lights.len()));
    let all = all.chain(numbered("view", desc.cameras.len()));
    all.chain(named("material", names.materials)).chain(named("texture", names.textures)).collect()
}

/// Adds, removes, duplicates, groups or pastes parts. What cannot be done changes nothing.
fn restructure(document: &mut Document, random: &mut Random) {
    let before = Arc::clone(document.desc());
    let all = paths(&before);
    let path = all[random.below(all.len())].clone();
    let kind = random.of(ShapeDesc::DOC.entries).name;
    let light = random.of(LightDesc::DOC.entries).name;
    let objects: Vec<String> = (0..1 + random.below(3))
        .map(|_| format!("object.{}", random.below(before.objects.len() + 1)))
        .collect();
    let choice = random.below(8);
    if choice == 7 {
        let pasted = document.copy(&[path]).and_then(|text| document.paste(&text));
        assert!(pasted.is_ok() || Arc::ptr_eq(&before, document.desc()));
        return;
    }
    let result = document.edit("parts", None, |desc| match choice {
        0 => {
            let of_mesh =
                ["mesh", "points", "curves", "height_field", "text", "distance_grid"].contains(&kind);
            let shape = ShapeDesc::of_type(kind).filter(|_| !of_mesh);
            let content = ObjectContent::Shape(shape.unwrap_or_default());
            desc.add_object(ObjectDesc { content, ..ObjectDesc::default() });
            Ok(())
        }
        1 => {
            let value = LightDesc::of_type(light).unwrap_or_default();
            desc.add_light(SceneLight { value, ..SceneLight::default() });
            Ok(())
        }
        2 | 3 => desc.remove(&[&path]),
        4 => desc.duplicate(&path).map(drop),
        5 => desc.group_objects(&objects.iter().map(String::as_str).collect::<Vec<_>>(), "group").map(drop),
        _ => desc.ungroup(&path).map(drop),
    });
    assert!(result.is_ok() || Arc::ptr_eq(&before, document.desc()), "an error changed the scene");
}

/// Saves the scene, loads it again and compares.
fn saved_and_loaded(document: &mut Document, path: &Path) {
    let saving = document.save(path, || {});
    let saved = loop {
        match document.saved(&saving) {
            Some(result) => break result,
            None => std::thread::sleep(std::time::Duration::from_millis(1)),
        }
    };
    saved.unwrap_or_else(|e| panic!("{}", e.message));
    assert!(!document.is_changed());
    let again = Document::open(path).unwrap_or_else(|e| panic!("{}", e.message));
    again.desc().same_scene(document.desc()).unwrap();
}

/// The scenes on both sides of the present, as pointers: what undo and redo must give.
#[derive(Default)]
struct Model {
    undo: Vec<Arc<SceneDesc>>,
    redo: Vec<Arc<SceneDesc>>,
}

impl Model {
    /// After a change of `before`; a step that joined the last one replaces nothing.
    fn changed(&mut self, before: &Arc<SceneDesc>, document: &Document) {
        if Arc::ptr_eq(before, document.desc()) {
            return;
        }
        self.redo.clear();
        if document.steps().0.len() > self.undo.len() {
            self.undo.push(Arc::clone(before));
        }
    }

    fn step(&mut self, document: &mut Document, back: bool) {
        let before = Arc::clone(document.desc());
        let (from, to) =
            if back { (&mut self.undo, &mut self.redo) } else { (&mut self.redo, &mut self.undo) };
        let expected = from.pop();
        let label = if back { document.undo() } else { document.redo() };
        assert_eq!(label.is_some(), expected.is_some());
        if let Some(expected) = expected {
            assert!(Arc::ptr_eq(&expected, document.desc()));
            to.push(before);
        }
    }

    fn check(&self, document: &Document) {
        let (undo, redo) = document.steps();
        assert_eq!((undo.len(), redo.len()), (self.undo.len(), self.redo.len()));
    }
}

/// A thousand random actions on a scene of the gallery.
fn sequence(name: &str, seed: u64) {
    let start = STARTS.iter().find(|start| start.name == name).unwrap();
    let mut document = Document::start(start).unwrap();
    let folder = tempfile::tempdir().unwrap();
    for (file, bytes) in start.files {
        let path = folder.path().join(file);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    let path = folder.path().join("saved.toml");
    let first = Arc::clone(document.desc());
    let kept = SceneDesc::clone(&first);
    let mut random = Random(seed);
    let mut model = Model::default();
    let mut taken = 0;
    for action in 0..1000 {
        let before = Arc::clone(document.desc());
        let revision = document.revision();
        match random.below(20) {
            0..=9 => {
                taken += u32::from(set(&mut document, &mut random));
                model.changed(&before, &document);
            }
            10..=12 => {
                restructure(&mut document, &mut random);
                model.changed(&before, &document);
            }
            13..=15 => model.step(&mut document, true),
            16..=17 => model.step(&mut document, false),
            18 => document.end_gesture(),
            _ => {}
        }
        model.check(&document);
        let changed = !Arc::ptr_eq(&before, document.desc());
        assert_eq!(changed, document.revision() != revision, "action {action}");
        if action % 125 == 124 {
            saved_and_loaded(&mut document, &path);
        }
    }
    assert!(taken > 100, "{name}: only {taken} of the edits were valid");
    let end = Arc::clone(document.desc());
    let count = model.undo.len();
    for _ in 0..count {
        model.step(&mut document, true);
    }
    assert!(document.undo().is_none() && Arc::ptr_eq(document.desc(), &first));
    assert!(**document.desc() == kept, "the first scene itself has changed");
    document.desc().same_scene(&kept).unwrap();
    saved_and_loaded(&mut document, &path);
    for _ in 0..count {
        model.step(&mut document, false);
    }
    assert!(Arc::ptr_eq(document.desc(), &end));
}

#[test]
fn a_thousand_actions_on_a_classic_scene() {
    sequence("The paper's example", 1);
}

#[test]
fn a_thousand_actions_on_a_scene_of_many_materials() {
    sequence("Material balls", 2);
}

#[test]
fn a_thousand_actions_on_meshes() {
    sequence("Glass still life", 3);
}

#[test]
fn a_thousand_actions_in_fog() {
    sequence("Foggy beam", 4);
}

/// The history keeps the newest 500 steps, and forgets the oldest.
#[test]
fn more_steps_than_the_history_keeps() {
    let mut document = Document::empty();
    let mut scenes = vec![Arc::clone(document.desc())];
    for i in 0..700 {
        document.set("Width", None, &[("film.width".into(), Data::Integer(i + 1))]).unwrap();
        scenes.push(Arc::clone(document.desc()));
    }
    assert_eq!(document.steps().0.len(), 500);
    while document.undo().is_some() {}
    assert!(Arc::ptr_eq(document.desc(), &scenes[200]));
    while document.redo().is_some() {}
    assert!(Arc::ptr_eq(document.desc(), scenes.last().unwrap()));
}

/// What was saved stays saved: back at the saved scene, nothing is changed, by undo or redo.
#[test]
fn changed_means_another_scene_than_on_disk() {
    let folder = tempfile::tempdir().unwrap();
    let mut document = Document::empty();
    let edit = |document: &mut Document, width: i64| {
        document.set("Width", None, &[("film.width".into(), Data::Integer(width))]).unwrap();
    };
    edit(&mut document, 100);
    saved_and_loaded(&mut document, &folder.path().join("a.toml"));
    edit(&mut document, 200);
    assert!(document.is_changed());
    document.undo();
    assert!(!document.is_changed());
    document.undo();
    assert!(document.is_changed());
    document.redo();
    assert!(!document.is_changed());
    document.redo();
    assert!(document.is_changed());
}

/// A change while the file is written is not on disk.
#[test]
fn a_change_during_a_save_counts_as_changed() {
    let folder = tempfile::tempdir().unwrap();
    let mut document = Document::empty();
    let saving = document.save(&folder.path().join("a.toml"), || {});
    document.set("Width", None, &[("film.width".into(), Data::Integer(123))]).unwrap();
    let result = loop {
        if let Some(result) = document.saved(&saving) {
            break result;
        }
    };
    result.unwrap();
    assert!(document.is_changed());
    document.undo();
    assert!(!document.is_changed());
}

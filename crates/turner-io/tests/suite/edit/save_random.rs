//! Random edits of all scenes: what is saved is read back as the same scene, and other lines stay.

use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use proptest::prelude::*;
use turner::description::{ObjectContent, ObjectDesc, SceneDesc};
use turner::math::DVec3;
use turner::schema::Transform;
use turner::shape::ShapeDesc;
use turner_io::edit::{Opened, save_scene};
use turner_io::scene::LoadOptions;

use super::{all_scenes, scenes_folder};

/// A copy of the scenes, where scenes can be written next to the files that they name.
fn copied_scenes() -> &'static Path {
    fn copy(from: &Path, to: &Path) {
        fs::create_dir_all(to).unwrap();
        for entry in fs::read_dir(from).unwrap() {
            let entry = entry.unwrap();
            match entry.file_type().unwrap().is_dir() {
                true => copy(&entry.path(), &to.join(entry.file_name())),
                false => _ = fs::copy(entry.path(), to.join(entry.file_name())).unwrap(),
            }
        }
    }
    static COPY: LazyLock<tempfile::TempDir> = LazyLock::new(|| {
        let folder = tempfile::tempdir().unwrap();
        copy(&scenes_folder(), folder.path());
        folder
    });
    COPY.path()
}

/// One random edit.
fn change(desc: &mut SceneDesc, what: u32, which: usize, by: f64) {
    let objects = desc.objects.len().max(1);
    let object = format!("object.{}", which % objects);
    match what {
        0 => desc.film.width = 16 + which as u32 % 100,
        // Two objects share a mesh in place: a text has that mesh twice, so such a scene is written in full.
        1 if desc.objects.get(which % objects).is_some_and(has_no_mesh) => _ = desc.duplicate(&object),
        1 => {}
        2 => _ = desc.remove(&[&object]),
        3 => {
            if let Some(object) = desc.objects.get_mut(which % objects) {
                object.transform = Transform(
                    turner::math::DAffine3::from_translation(DVec3::splat(by)) * object.transform.0,
                );
            }
        }
        4 => {
            if let Some(object) = desc.objects.get_mut(which % objects) {
                object.hidden = !object.hidden;
            }
        }
        5 => _ = desc.add_light(turner::light::LightDesc::default().into()),
        6 => {
            let count = desc.lights.len().max(1);
            _ = desc.remove(&[&format!("light.{}", which % count)]);
        }
        7 => {
            let path = desc.add_material("new", Default::default());
            assert!(path.starts_with("material."));
            let id = turner::schema::MaterialId(desc.materials.len() as u32 - 1);
            if let Some(object) = desc.objects.get_mut(which % objects) {
                object.material = Some(id);
            }
        }
        8 => _ = desc.group_objects(&[&object], "group"),
        9 => _ = desc.add_view("view", Default::default()),
        10 => desc.camera = Some(Default::default()),
        _ => desc.background.color = turner::color::Spectrum::grey(by as f32),
    }
}

fn has_no_mesh(object: &ObjectDesc) -> bool {
    !matches!(
        object.content,
        ObjectContent::Shape(ShapeDesc::Mesh(_) | ShapeDesc::Points(_) | ShapeDesc::Curves(_))
    )
}

/// Whether all lines of `part` are in `whole`, in the same order.
fn is_subsequence(part: &[&str], whole: &[&str]) -> bool {
    let mut rest = whole.iter();
    part.iter().all(|line| rest.any(|other| other == line))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]
    #[test]
    fn what_is_saved_is_what_was_edited(
        scene in 0_usize..1000,
        edits in prop::collection::vec((0_u32..12, 0_usize..1000, 0.01_f64..2.0), 1..5),
    ) {
        let scenes = all_scenes();
        let path = &scenes[scene % scenes.len()];
        let path = &copied_scenes().join(path.strip_prefix(scenes_folder()).unwrap());
        let opened = Opened::load(path, &LoadOptions::default()).unwrap();
        let mut desc = opened.desc.clone();
        for (what, which, by) in &edits {
            change(&mut desc, *what, *which, *by);
        }
        let out = path.with_file_name("saved.toml");
        let saved = save_scene(&desc, Some(&opened), &out);
        let text = fs::read_to_string(&out).unwrap_or_default();
        let read = turner_io::load(&out);
        let saved = saved.unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        for file in &saved.files {
            let _ = fs::remove_file(&file.path);
        }
        let read = read.unwrap();
        // Written in full, parts that nothing uses stay, too, with names.
        let same = desc.same_apart_from_order(&read).or_else(|e| if saved.kept_text { Err(e) } else { desc.same_scene(&read) });
        prop_assert_eq!(same, Ok(()));
        let old = fs::read_to_string(path).unwrap();
        // Parts of included files are not changed in place: the scene is then written in one file.
        let includes = old.lines().any(|line| line.starts_with("include"));
        prop_assert!(saved.kept_text || includes, "{}: {edits:?} {:?}", path.display(), saved.notes);
        prop_assume!(saved.kept_text);
        let new: Vec<&str> = text.lines().collect();
        // Lines that are still there, as often as before, are in the old order.
        let kept: Vec<&str> = old.lines().filter(|line| {
            line.len() > 20 && new.iter().filter(|other| *other == line).count() == 1
                && old.lines().filter(|other| other == line).count() == 1
        }).collect();
        // Grouping moves an object, and so does the removal of one that was duplicated.
        let has = |kind: u32| edits.iter().any(|(what, ..)| *what == kind);
        prop_assert!(has(8) || has(1) && has(2) || is_subsequence(&kept, &new));
        let comments = |text: &str| text.lines().filter(|l| l.trim_start().starts_with('#')).count();
        let removes = [2, 6, 8].into_iter().any(has);
        prop_assert!(removes || comments(&old) == comments(&text));
    }
}

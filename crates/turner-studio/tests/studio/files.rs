//! Files: opened, dropped, broken, changed by others, saved; and the question before unsaved work is lost.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui::accesskit::Role;
use egui::{Key, Modifiers};
use turner::schema::value::Data;
use turner_live::document::Document;
use turner_studio::node::Node;
use turner_studio::studio::{Dialog, Purpose};

use super::common::*;

const ONE: &str =
    "# A comment that stays.\n[film]\nwidth = 32\nheight = 24\n\n[[object]]\ntype = \"sphere\"\nradius = 1\n";

/// A window that shows a file.
fn with_file(text: &str) -> (Window, tempfile::TempDir, PathBuf) {
    let (mut window, home) = window([1400.0, 900.0], 1.0);
    let file = home.path().join("scene.toml");
    std::fs::write(&file, text).unwrap();
    app(&mut window).open(&file);
    until(&mut window, "the file", |studio| studio.document.path().is_some());
    (window, home, file)
}

fn edit(window: &mut Window, radius: f64) {
    let studio = app(window);
    studio.document.set("Radius", None, &[("object.0.radius".into(), Data::Number(radius))]).unwrap();
    frames(window, 2);
}

fn wait_saved(window: &mut Window) {
    until(window, "the save", |studio| !studio.is_busy() && !studio.document.is_changed());
}

#[test]
fn save_writes_the_file_and_keeps_its_comments() {
    let (mut window, _home, file) = with_file(ONE);
    edit(&mut window, 2.5);
    assert!(says(&window, "(changed)"));
    press(&mut window, Modifiers::COMMAND, Key::S);
    wait_saved(&mut window);
    frames(&mut window, 1);
    assert!(!says(&window, "(changed)"));
    let text = std::fs::read_to_string(&file).unwrap();
    assert!(text.contains("# A comment that stays.") && text.contains("2.5"), "{text}");
    Document::open(&file).unwrap().desc().same_scene(seen(&window).document.desc()).unwrap();
    // Its own save is no change by another program.
    for _ in 0..5 {
        std::thread::sleep(std::time::Duration::from_millis(200));
        frames(&mut window, 1);
    }
    assert_eq!(seen(&window).document.steps().0.len(), 1);
}

#[test]
fn a_new_scene_is_saved_under_a_name_written_by_keyboard() {
    let (mut window, home) = sample([1400.0, 900.0]);
    let file = home.path().join("new.toml");
    press(&mut window, Modifiers::COMMAND, Key::S);
    assert!(matches!(seen(&window).dialog, Some(Dialog::File { purpose: Purpose::Save, .. })));
    press(&mut window, Modifiers::COMMAND, Key::A);
    write(&mut window, &file.to_string_lossy());
    press(&mut window, Modifiers::NONE, Key::Enter);
    until(&mut window, "the save", |studio| studio.document.path().is_some() && !studio.is_busy());
    Document::open(&file).unwrap().desc().same_scene(seen(&window).document.desc()).unwrap();
    assert!(seen(&window).settings.recent.contains(&file));
}

#[test]
fn unsaved_changes_are_asked_about() {
    let (mut window, _home, file) = with_file(ONE);
    edit(&mut window, 2.0);
    let changed = seen(&window).document.desc().clone();
    press(&mut window, Modifiers::COMMAND, Key::N);
    assert!(matches!(seen(&window).dialog, Some(Dialog::Unsaved(_))));
    click(&mut window, Role::Button, "Cancel");
    assert!(seen(&window).dialog.is_none());
    assert!(Arc::ptr_eq(seen(&window).document.desc(), &changed));
    // Escape is a Cancel, too.
    press(&mut window, Modifiers::COMMAND, Key::N);
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert!(seen(&window).dialog.is_none());
    assert!(Arc::ptr_eq(seen(&window).document.desc(), &changed));
    // Save, then the new scene.
    press(&mut window, Modifiers::COMMAND, Key::N);
    click(&mut window, Role::Button, "Save");
    until(&mut window, "the new scene", |studio| studio.document.path().is_none());
    Document::open(&file).unwrap().desc().same_scene(&changed).unwrap();
    assert!(!seen(&window).document.is_changed());
}

#[test]
fn changes_are_given_up_if_the_user_says_so() {
    let (mut window, _home, file) = with_file(ONE);
    edit(&mut window, 2.0);
    press(&mut window, Modifiers::COMMAND, Key::Q);
    assert!(!seen(&window).quit, "the window stays until the question is answered");
    click(&mut window, Role::Button, "Don't save");
    assert!(seen(&window).quit);
    assert_eq!(std::fs::read_to_string(file).unwrap(), ONE);
}

#[test]
fn without_changes_nothing_is_asked() {
    let (mut window, _home, _file) = with_file(ONE);
    edit(&mut window, 2.0);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    press(&mut window, Modifiers::COMMAND, Key::N);
    assert!(seen(&window).dialog.is_none() && seen(&window).document.path().is_none());
}

/// A scene without a file that is saved before another one opens: the name is asked for in between.
#[test]
fn saving_first_asks_for_a_name_where_there_is_none() {
    let (mut window, home) = sample([1400.0, 900.0]);
    let file = home.path().join("kept.toml");
    press(&mut window, Modifiers::COMMAND, Key::B);
    let changed = seen(&window).document.desc().clone();
    press(&mut window, Modifiers::COMMAND, Key::N);
    click(&mut window, Role::Button, "Save");
    assert!(matches!(seen(&window).dialog, Some(Dialog::File { purpose: Purpose::Save, .. })));
    press(&mut window, Modifiers::COMMAND, Key::A);
    write(&mut window, &file.to_string_lossy());
    press(&mut window, Modifiers::NONE, Key::Enter);
    until(&mut window, "the new scene", |studio| studio.document.name() == "Untitled");
    Document::open(&file).unwrap().desc().same_scene(&changed).unwrap();
}

#[derive(Debug)]
struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|error| error.to_string())
    }
}

#[test]
fn a_dropped_file_opens() {
    let (mut window, home) = sample([1400.0, 900.0]);
    let file = home.path().join("dropped.toml");
    std::fs::write(&file, ONE).unwrap();
    window.input_mut().dropped_files.push(Arc::new(Dropped(file.clone())));
    until(&mut window, "the file", |studio| studio.document.path() == Some(&file));
    // With unsaved changes, it asks first.
    edit(&mut window, 3.0);
    window.input_mut().dropped_files.push(Arc::new(Dropped(file)));
    frames(&mut window, 2);
    assert!(matches!(seen(&window).dialog, Some(Dialog::Unsaved(_))));
}

#[test]
fn a_broken_file_is_explained_and_the_last_scene_stays() {
    let (mut window, home) = sample([1400.0, 900.0]);
    let last = seen(&window).document.desc().clone();
    let files = [
        ("typo.toml", "[[object]]\ntype = \"sphere\"\nradiu = 2\n", "radiu", Some((3, "radiu = 2"))),
        (
            "range.toml",
            "\n\n[[object]]\ntype = \"sphere\"\nradius = -1\n",
            "radius",
            Some((5, "radius = -1")),
        ),
        ("syntax.toml", "[film\nwidth = 3\n", "", Some((1, "[film"))),
        ("model.obj", "f 1 2 3\n", "", None),
        ("picture.png", "no scene", "", None),
    ];
    for (name, text, part, line) in files {
        let file = home.path().join(name);
        std::fs::write(&file, text).unwrap();
        app(&mut window).open(&file);
        until(&mut window, name, |studio| studio.problem.is_some() && studio.opening().is_none());
        let problem = seen(&window).problem.clone().unwrap();
        assert!(problem.message.contains(part) && !problem.message.is_empty(), "{}", problem.message);
        if let Some((number, text)) = line {
            assert_eq!(problem.line, Some((number, text.to_owned())));
            assert!(says(&window, &format!("{number} | {text}")), "{:?}", names(&window));
        }
        assert!(says(&window, "Not shown:"));
        assert!(Arc::ptr_eq(seen(&window).document.desc(), &last), "{name}");
        click(&mut window, Role::Button, "Close the problem");
        assert!(seen(&window).problem.is_none());
    }
    let missing = home.path().join("missing.toml");
    app(&mut window).open(&missing);
    until(&mut window, "a missing file", |studio| studio.problem.is_some());
    assert!(Arc::ptr_eq(seen(&window).document.desc(), &last));
}

/// Another program changes the file: the scene follows, as a step that can be undone. What it breaks is explained.
#[test]
fn a_file_that_changes_on_disk_is_read_again() {
    let (mut window, _home, file) = with_file(ONE);
    let radius = |studio: &turner_studio::studio::Studio| match studio
        .document
        .desc()
        .value_at("object.0.radius")
        .unwrap()
        .map(|value| value.data)
    {
        Some(Data::Number(v)) => v,
        Some(Data::Integer(i)) => i as f64,
        _ => 1.0,
    };
    std::fs::write(&file, ONE.replace("radius = 1", "radius = 4.5")).unwrap();
    until(&mut window, "the new radius", |studio| radius(studio) == 4.5);
    assert!(!seen(&window).document.is_changed());
    assert_eq!(seen(&window).document.steps().0, ["Reload"]);
    std::fs::write(&file, ONE.replace("radius = 1", "radius = oops")).unwrap();
    until(&mut window, "the problem", |studio| studio.problem.is_some());
    assert_eq!(seen(&window).problem.as_ref().unwrap().line, Some((8, "radius = oops".to_owned())));
    assert_eq!(radius(seen(&window)), 4.5);
    std::fs::write(&file, ONE.replace("radius = 1", "radius = 0.25")).unwrap();
    until(&mut window, "the repaired file", |studio| radius(studio) == 0.25);
    assert!(seen(&window).problem.is_none());
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(radius(seen(&window)), 4.5);
    // With changes of the user's own, the file is not read over them.
    std::fs::write(&file, ONE.replace("radius = 1", "radius = 7")).unwrap();
    until(&mut window, "the message", |studio| {
        studio.message.as_ref().is_some_and(|message| message.text.contains("another program"))
    });
    assert_eq!(radius(seen(&window)), 4.5);
}

/// Unsaved work of a session that ended is offered, opened as changed, and can be saved.
#[test]
fn unsaved_work_is_offered_again() {
    let home = tempfile::tempdir().unwrap();
    let folder = home.path().join("recovery/session-4294967295");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("scene.toml"), ONE).unwrap();
    std::fs::write(folder.join("about.json"), r#"{"name":"lost.toml","path":null,"process":4294967295}"#)
        .unwrap();
    let at = home.path().to_owned();
    let show = move |ui: &mut egui::Ui, app: &mut Option<turner_studio::app::App>| {
        app.get_or_insert_with(|| turner_studio::app::App::new(ui.ctx(), at.clone())).show(ui);
    };
    let mut window = egui_kittest::Harness::builder().with_size([900.0, 700.0]).build_ui_state(show, None);
    frames(&mut window, 2);
    assert!(says(&window, "lost.toml"));
    click(&mut window, Role::Button, "Open");
    assert!(seen(&window).dialog.is_none());
    assert_eq!(seen(&window).document.name(), "lost.toml");
    assert!(seen(&window).document.is_changed());
    assert_eq!(seen(&window).document.desc().objects.len(), 1);
    app(&mut window).selection = Some(Node::Object(0));
    frames(&mut window, 2);
}

/// The finished picture is written with the bytes of the offline render.
#[test]
fn the_saved_picture_is_that_of_the_offline_render() {
    let (mut window, home, _file) = with_file(&format!(
        "{ONE}\n[integrator]\ntype = \"path\"\n\n[[light]]\ntype = \"directional\"\nfrom = [1, 3, 2]\n"
    ));
    app(&mut window).paused = false;
    until(&mut window, "the finished picture", |studio| {
        studio.frame.as_ref().is_some_and(|frame| frame.stage == turner_live::engine::Stage::Settled)
    });
    let file = home.path().join("picture.png");
    press(&mut window, Modifiers::COMMAND, Key::E);
    assert!(matches!(seen(&window).dialog, Some(Dialog::File { purpose: Purpose::Picture, .. })));
    press(&mut window, Modifiers::COMMAND, Key::A);
    write(&mut window, &file.to_string_lossy());
    press(&mut window, Modifiers::NONE, Key::Enter);
    until(&mut window, "the file", |studio| {
        studio.message.as_ref().is_some_and(|m| m.text.starts_with("Saved "))
    });
    let desc = seen(&window).document.desc().clone();
    let mut renderer = turner::Renderer::new(desc.prepare(&Default::default()).unwrap()).unwrap();
    let cancel = std::sync::atomic::AtomicBool::new(false);
    let options = turner::PassOptions { threads: 0, cancel: &cancel, progress: None };
    assert!(renderer.pass(u32::MAX, &options).unwrap());
    let picture = renderer.develop();
    let bytes = std::fs::read(&file).unwrap();
    let read = turner_io::image::decode(&bytes, "picture.png", &Default::default()).unwrap();
    assert_eq!((read.width, read.height), (picture.width, picture.height));
    let turner::image::Pixels::U8(shown) = &read.pixels else { panic!("8 bits per channel are expected") };
    let channels = usize::from(read.channels);
    assert!(channels == 3 || channels == 4);
    let own: Vec<u8> = picture.display.iter().flat_map(|pixel| &pixel[..channels]).copied().collect();
    assert!(*shown == own, "the saved picture differs from the offline render");
    let header = turner_io::image::read_metadata(&bytes, "picture.png").unwrap();
    assert!(format!("{header:?}").contains("turner:samples"), "{header:?}");
}

//! A window without a display, and ways to act in it.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::accesskit::Role;
use egui::{Key, Modifiers, Vec2};
use egui_kittest::kittest::NodeT;
use egui_kittest::{Harness, Node};
use tempfile::TempDir;
use turner::SceneDesc;
use turner_io::assets::MemoryAssets;
use turner_live::document::{Document, STARTS};
use turner_studio::app::App;
use turner_studio::studio::Studio;

pub(crate) type Window = Harness<'static, Option<App>>;

/// A window with its own folder for settings. Rendering waits, so that tests have the processor to themselves; previews
/// are drawn all the same.
pub(crate) fn window(size: [f32; 2], pixels_per_point: f32) -> (Window, TempDir) {
    let home = tempfile::tempdir().unwrap();
    let folder = home.path().to_owned();
    let builder = Harness::builder().with_size(Vec2::from(size)).with_pixels_per_point(pixels_per_point);
    let show = move |ui: &mut egui::Ui, app: &mut Option<App>| {
        let app = app.get_or_insert_with(|| {
            let mut app = App::new(ui.ctx(), folder.clone());
            app.studio.paused = true;
            app.studio.settings.threads = 1;
            app
        });
        app.show(ui);
    };
    let mut window = builder.with_max_steps(8).build_ui_state(show, None);
    frames(&mut window, 2);
    (window, home)
}

pub(crate) fn app(window: &mut Window) -> &mut Studio {
    &mut window.state_mut().as_mut().unwrap().studio
}

pub(crate) fn seen(window: &Window) -> &Studio {
    &window.state().as_ref().unwrap().studio
}

/// Some frames, each with the input that waits.
pub(crate) fn frames(window: &mut Window, count: usize) {
    window.run_steps(count);
}

/// Shows frames until `ready`; fails after a minute.
pub(crate) fn until(window: &mut Window, what: &str, ready: impl Fn(&Studio) -> bool) {
    let begun = Instant::now();
    loop {
        window.step();
        if ready(seen(window)) {
            return;
        }
        assert!(
            begun.elapsed() < Duration::from_secs(60),
            "waited for: {what}; {:?}, {:?}, {:?}",
            seen(window).status,
            seen(window).problem,
            seen(window).message
        );
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// A scene from its text.
pub(crate) fn scene(text: &str) -> SceneDesc {
    let loaded = turner_io::scene::load_text(
        text.to_owned(),
        "test.toml",
        &MemoryAssets::default(),
        &Default::default(),
    );
    loaded.unwrap_or_else(|e| panic!("{}\n{text}", e.error.message)).desc
}

/// A small scene with something of everything: objects, lights, named materials, textures, a medium, a view.
pub(crate) const SAMPLE: &str = r#"
[film]
width = 32
height = 24
samples = 1

[camera]
position = [0, 2, 6]
look_at = [0, 0.8, 0]
fov = 40

[[view]]
name = "from above"
type = "pinhole"
position = [0, 8, 0.1]
look_at = [0, 0, 0]

[integrator]
type = "path"

[texture.squares]
type = "checkerboard"

[texture.dots]
type = "checkerboard"

[medium.haze]
type = "homogeneous"

[material.gold]
type = "principled"
base_metalness = 1

[material.chalk]
type = "matte"
color = [0.8, 0.8, 0.8]

[material.unused]
type = "matte"

[[light]]
name = "lamp"
type = "point"
position = [3, 5, 4]
intensity = 40

[[light]]
type = "directional"
from = [1, 3, 2]

[[object]]
name = "floor"
type = "plane"
material = "chalk"

[[object]]
name = "ball"
type = "sphere"
center = [0, 1, 0]
material = "gold"

[[object]]
type = "box"
material = "chalk"
"#;

/// Shows a scene as a new document.
pub(crate) fn show(window: &mut Window, desc: SceneDesc) {
    let document = Document::of(desc, "Sample".into(), std::env::temp_dir());
    app(window).show(document);
    frames(window, 2);
}

/// Waits for a picture of the present scene.
pub(crate) fn has_picture(window: &mut Window) {
    until(window, "a picture", |studio| {
        studio.frame.as_ref().is_some_and(|frame| Arc::ptr_eq(&frame.stand.desc, studio.document.desc()))
    });
}

/// A window with the sample scene and its first picture.
pub(crate) fn sample(size: [f32; 2]) -> (Window, TempDir) {
    let (mut window, home) = window(size, 1.0);
    show(&mut window, scene(SAMPLE));
    has_picture(&mut window);
    (window, home)
}

/// Shows a scene of the gallery.
pub(crate) fn start(window: &mut Window, name: &str) {
    let start = STARTS.iter().find(|start| start.name == name).unwrap();
    app(window).show(Document::start(start).unwrap());
    frames(window, 2);
}

/// The nodes of a role and name, from the top down.
pub(crate) fn nodes<'w>(window: &'w Window, role: Role, label: &str) -> Vec<Node<'w>> {
    let all = window.root().children_recursive();
    let of_name = all.filter(|n| n.accesskit_node().role() == role);
    of_name.filter(|n| n.accesskit_node().label().as_deref() == Some(label)).collect()
}

/// The last node of a role and name: what was opened last lies on top.
pub(crate) fn node<'w>(window: &'w Window, role: Role, label: &str) -> Option<Node<'w>> {
    nodes(window, role, label).pop()
}

/// Clicks as an assistive program does, and shows two frames.
pub(crate) fn click(window: &mut Window, role: Role, label: &str) {
    match node(window, role, label) {
        Some(node) => node.click_accesskit(),
        None => panic!("no {role:?} named {label:?}; there are {:?}", names(window)),
    }
    frames(window, 2);
}

/// Opens a menu of the bar at the top, or closes it. A tab may have the same name.
pub(crate) fn open_menu(window: &mut Window, menu: &str) {
    nodes(window, Role::Button, menu)[0].click_accesskit();
    frames(window, 2);
}

/// Opens a menu and chooses an entry of it. An entry shows its shortcut after its name.
pub(crate) fn menu(window: &mut Window, menu: &str, entry: &str) {
    open_menu(window, menu);
    let found =
        entries(window).into_iter().find(|name| name == entry || name.starts_with(&format!("{entry} ")));
    let found = found.unwrap_or_else(|| panic!("{menu} has no entry {entry:?}: {:?}", entries(window)));
    click(window, Role::Button, &found);
}

/// The names of all buttons.
pub(crate) fn entries(window: &Window) -> Vec<String> {
    let all = window.root().children_recursive();
    all.filter(|n| n.accesskit_node().role() == Role::Button)
        .filter_map(|n| n.accesskit_node().label())
        .collect()
}

/// Role and name of all named nodes, for messages.
pub(crate) fn names(window: &Window) -> Vec<String> {
    let all = window.root().children_recursive();
    all.filter_map(|n| Some(format!("{:?} {:?}", n.accesskit_node().role(), n.accesskit_node().label()?)))
        .collect()
}

/// Whether any text of the window contains `text`.
pub(crate) fn says(window: &Window, text: &str) -> bool {
    let has = |value: Option<String>| value.is_some_and(|value| value.contains(text));
    window
        .root()
        .children_recursive()
        .any(|n| has(n.accesskit_node().label()) || has(n.accesskit_node().value()))
}

/// Whether a label is exactly `text`, which is the value of its node.
pub(crate) fn shows(window: &Window, text: &str) -> bool {
    let mut nodes = window.root().children_recursive();
    nodes.any(|n| {
        n.accesskit_node().role() == Role::Label && n.accesskit_node().value().as_deref() == Some(text)
    })
}

/// Presses and releases a key.
pub(crate) fn press(window: &mut Window, modifiers: Modifiers, key: Key) {
    window.key_press_modifiers(modifiers, key);
    frames(window, 2);
}

/// Types letters into what has the focus.
pub(crate) fn write(window: &mut Window, text: &str) {
    window.event(egui::Event::Text(text.to_owned()));
    frames(window, 2);
}

/// Saves a scene to a new file, reads it again, and fails if it is another one.
pub(crate) fn assert_saves(studio: &Studio, folder: &Path) {
    let file = folder.join("saved-by-the-test.toml");
    let saving = studio.document.save(&file, || {});
    let mut copy = Document::of(SceneDesc::clone(studio.document.desc()), "copy".into(), folder.to_owned());
    let result = loop {
        match copy.saved(&saving) {
            Some(result) => break result,
            None => std::thread::sleep(Duration::from_millis(1)),
        }
    };
    result.unwrap_or_else(|e| panic!("{}", e.message));
    let again = Document::open(&file).unwrap_or_else(|e| panic!("{}", e.message));
    again.desc().same_scene(studio.document.desc()).unwrap();
}

/// A sequence of numbers that looks random (SplitMix64).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn below(&mut self, count: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) % count as u64) as usize
    }

    pub(crate) fn of<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.below(list.len())]
    }
}

/// Does something that is one step of the history, takes it back, does it again, and takes it back again.
pub(crate) fn one_step(window: &mut Window, what: &str, act: impl FnOnce(&mut Window)) {
    app(window).document.end_gesture();
    let (before, count) = (seen(window).document.desc().clone(), seen(window).document.steps().0.len());
    act(window);
    frames(window, 2);
    let after = seen(window).document.desc().clone();
    let said = seen(window).message.as_ref().map(|message| message.text.clone());
    assert!(!Arc::ptr_eq(&before, &after), "{what}: nothing has changed; {said:?}");
    assert_eq!(
        seen(window).document.steps().0.len(),
        count + 1,
        "{what}: {:?}",
        seen(window).document.steps().0
    );
    press(window, Modifiers::COMMAND, Key::Z);
    assert!(Arc::ptr_eq(seen(window).document.desc(), &before), "{what}: undo gives another scene");
    press(window, Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::Z);
    assert!(Arc::ptr_eq(seen(window).document.desc(), &after), "{what}: redo gives another scene");
    press(window, Modifiers::COMMAND, Key::Z);
    assert!(Arc::ptr_eq(seen(window).document.desc(), &before), "{what}: undo gives another scene");
}

/// Sets a number by its name.
pub(crate) fn set(window: &mut Window, label: &str, value: f64) {
    match node(window, Role::SpinButton, label) {
        Some(node) => node.set_value_accesskit(value),
        None => panic!("no field {label:?}; there are {:?}", names(window)),
    }
    frames(window, 2);
}

/// Opens a list and chooses an entry.
pub(crate) fn choose(window: &mut Window, list: &str, entry: &str) {
    click(window, Role::ComboBox, list);
    click(window, Role::Button, entry);
}

/// Keys that a shape needs, apart from its type; `None` for those that need an image, a font or a grid, which the tests of the form of
/// textures read.
pub(crate) fn shape_keys(name: &str) -> Option<&'static str> {
    Some(match name {
        "mesh" => "positions = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\ntriangles = [[0, 1, 2]]",
        "points" => "positions = [[0, 0, 0], [1, 0, 0]]\nradius = 0.1",
        "curves" => "points = [[0, 0, 0], [1, 0, 0]]\nwidth = 0.1",
        "height_field" | "text" | "distance_grid" => return None,
        "union" | "intersection" | "difference" | "clipped" => {
            "parts = [{ type = \"sphere\" }, { type = \"plane\" }]"
        }
        "prism" => "points = [[0, 0], [1, 0], [0, 1]]",
        "lathe" => "points = [[0.5, 0], [1, 1]]",
        "sphere_sweep" => "spheres = [[0, 0, 0, 1], [1, 0, 0, 0.5]]",
        "blob" => "spheres = [[0, 0, 0, 1, 1]]",
        "polynomial" => "terms = [[1, 2, 0, 0], [-0.5, 0, 0, 0]]",
        "isosurface" => "function = \"x^2 + y^2 + z^2 - 0.5\"",
        _ => "",
    })
}

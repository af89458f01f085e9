//! Everything the user can do, as one table: menus, shortcuts and the command palette are made from it.

use egui::{Key, KeyboardShortcut, Modifiers};
use turner::camera::CameraDesc;
use turner::description::{ObjectContent, ObjectDesc, SceneLight};
use turner::integrator::IntegratorDesc;
use turner::light::LightDesc;
use turner::math::{Bounds, DVec3};
use turner::schema::value::Data;
use turner::schema::{MaterialId, Named};
use turner::shape::ShapeDesc;
use turner_live::{camera, pick};

use crate::node::Node;
use crate::settings::Theme;
use crate::studio::{After, Dialog, Studio};
use crate::viewport::Tool;

const COMMAND: Modifiers = Modifiers::COMMAND;
const NONE: Modifiers = Modifiers::NONE;
const SHIFT: Modifiers = Modifiers::SHIFT;

/// The table: variant, menu, label, shortcut.
macro_rules! actions {
    ($($variant:ident, $menu:literal, $label:literal $(, $modifiers:expr, $key:ident)?;)*) => {
        /// Something the user can do.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Action {
            $(#[allow(missing_docs)] $variant,)*
            /// Add a shape by its name in a scene.
            AddShape(&'static str),
            /// Add a light by its name in a scene.
            AddLight(&'static str),
            /// Show another integrator's picture, by its name; `None` for the scene's own.
            Show(Option<&'static str>),
        }

        /// The actions without arguments.
        const PLAIN: &[Action] = &[$(Action::$variant,)*];

        impl Action {
            /// The menu that it is in.
            pub fn menu(self) -> &'static str {
                match self {
                    $(Action::$variant => $menu,)*
                    Action::AddShape(_) | Action::AddLight(_) => "Add",
                    Action::Show(_) => "Show",
                }
            }

            /// Its name.
            pub fn label(self) -> String {
                match self {
                    $(Action::$variant => $label.to_owned(),)*
                    Action::AddShape(kind) => format!("Add {kind}"),
                    Action::AddLight(kind) => format!("Add {kind} light"),
                    Action::Show(None) => "Show picture".to_owned(),
                    Action::Show(Some(name)) => format!("Show {}", name.replace(['-', '_'], " ")),
                }
            }

            /// Its shortcut.
            pub fn shortcut(self) -> Option<KeyboardShortcut> {
                match self {
                    $($(Action::$variant => Some(KeyboardShortcut::new($modifiers, Key::$key)),)?)*
                    _ => None,
                }
            }
        }
    };
}

actions! {
    New, "File", "New", COMMAND, N;
    Open, "File", "Open…", COMMAND, O;
    Reload, "File", "Reload from disk", COMMAND, R;
    Save, "File", "Save", COMMAND, S;
    SaveAs, "File", "Save as…", COMMAND.plus(SHIFT), S;
    Quit, "File", "Quit", COMMAND, Q;
    Undo, "Edit", "Undo", COMMAND, Z;
    Redo, "Edit", "Redo", COMMAND.plus(SHIFT), Z;
    Duplicate, "Edit", "Duplicate", COMMAND, D;
    Delete, "Edit", "Delete", NONE, Delete;
    SelectNone, "Edit", "Select nothing", NONE, Escape;
    AddMaterial, "Add", "Add material";
    Palette, "View", "Commands…", COMMAND, K;
    Frame, "View", "Frame the selection", NONE, F;
    FrameAll, "View", "Frame everything", NONE, Home;
    Bookmark, "View", "Bookmark the camera", COMMAND, B;
    Pause, "View", "Pause or go on rendering", NONE, Space;
    Dark, "View", "Dark or light";
    Larger, "View", "Larger", COMMAND, Plus;
    Smaller, "View", "Smaller", COMMAND, Minus;
    ToolSelect, "Tool", "Select and look around", NONE, Q;
    ToolMove, "Tool", "Move", NONE, G;
    ToolRotate, "Tool", "Rotate", NONE, R;
    ToolScale, "Tool", "Scale", NONE, T;
    ToolFocus, "Tool", "Focus where I click", NONE, C;
    ToolExplain, "Tool", "Explain the pixel I click", NONE, X;
}

/// The menus in their order.
pub const MENUS: &[&str] = &["File", "Edit", "Add", "View", "Show", "Tool"];

impl Action {
    /// All actions.
    pub fn all() -> Vec<Action> {
        let plain = PLAIN.iter().copied();
        let shapes = ShapeDesc::DOC.entries.iter().filter(|e| !NEED_DATA.contains(&e.name));
        let lights = LightDesc::DOC.entries.iter();
        let shown = IntegratorDesc::DOC.entries.iter();
        plain
            .chain(shapes.map(|entry| Action::AddShape(entry.name)))
            .chain(lights.map(|entry| Action::AddLight(entry.name)))
            .chain([Action::Show(None)])
            .chain(shown.map(|entry| Action::Show(Some(entry.name))))
            .collect()
    }

    /// Whether it can be done now.
    pub fn is_possible(self, studio: &Studio) -> bool {
        let desc = studio.document.desc();
        match self {
            Action::Undo => !studio.document.steps().0.is_empty(),
            Action::Redo => !studio.document.steps().1.is_empty(),
            Action::Reload => studio.document.path().is_some(),
            Action::Duplicate => matches!(studio.selection, Some(Node::Object(_) | Node::Light(_))),
            Action::Delete => match studio.selection {
                Some(Node::Object(_) | Node::Light(_) | Node::View(_)) => true,
                Some(Node::Material(i)) => !desc.objects.iter().any(|o| o.material == Some(MaterialId(i as u32))),
                _ => false,
            },
            _ => true,
        }
    }

    /// Does it.
    pub fn run(self, studio: &mut Studio) {
        if !self.is_possible(studio) {
            return;
        }
        match self {
            Action::New => studio.leave(After::New),
            Action::Open => {
                let name = format!("{}{}", studio.document.folder().display(), std::path::MAIN_SEPARATOR);
                studio.dialog = Some(Dialog::File { save: false, name });
            }
            Action::Reload => studio.reload(),
            Action::Save => studio.save(None),
            Action::SaveAs => {
                let path = studio.document.path().map(|path| path.with_extension("toml"));
                let path = path.unwrap_or_else(|| studio.document.folder().join("untitled.toml"));
                studio.dialog = Some(Dialog::File { save: true, name: path.to_string_lossy().into_owned() });
            }
            Action::Quit => studio.leave(After::Quit),
            Action::Undo => {
                if let Some(label) = studio.document.undo() {
                    studio.say(format!("Undone: {label}"));
                }
            }
            Action::Redo => {
                if let Some(label) = studio.document.redo() {
                    studio.say(format!("Redone: {label}"));
                }
            }
            Action::Duplicate => duplicate(studio),
            Action::Delete => delete(studio),
            Action::SelectNone => studio.selection = None,
            Action::AddMaterial => add_material(studio),
            Action::AddShape(kind) => add_shape(studio, kind),
            Action::AddLight(kind) => add_light(studio, kind),
            Action::Palette => studio.viewport.palette = Some(String::new()),
            Action::Frame => frame(studio, studio.selection),
            Action::FrameAll => frame(studio, None),
            Action::Bookmark => bookmark(studio),
            Action::Pause => studio.paused = !studio.paused,
            Action::Dark => {
                let theme = studio.settings.theme;
                studio.settings.theme = if theme == Theme::Light { Theme::Dark } else { Theme::Light };
            }
            Action::Larger => studio.settings.zoom = (studio.settings.zoom * 1.1).min(4.0),
            Action::Smaller => studio.settings.zoom = (studio.settings.zoom / 1.1).max(0.5),
            Action::ToolSelect => studio.viewport.tool = Tool::Select,
            Action::ToolMove => studio.viewport.tool = Tool::Move,
            Action::ToolRotate => studio.viewport.tool = Tool::Rotate,
            Action::ToolScale => studio.viewport.tool = Tool::Scale,
            Action::ToolFocus => studio.viewport.tool = Tool::Focus,
            Action::ToolExplain => studio.viewport.tool = Tool::Explain,
            Action::Show(name) => studio.look.integrator = name.and_then(IntegratorDesc::of_type),
        }
    }
}

/// Shapes that are nothing without data: vertices, files, points.
const NEED_DATA: &[&str] = &["mesh", "points"];

/// The camera that the picture shows, also one that Turner added.
pub(crate) fn camera_of(studio: &Studio) -> Option<Named<CameraDesc>> {
    let own = studio.document.desc().camera.clone();
    let shown = || studio.frame.as_ref().map(|frame| frame.stand.prepared.view.camera_desc.clone().into());
    own.or_else(shown)
}

/// Changes the camera. Movements that follow one another are one step of the history.
pub(crate) fn move_camera(studio: &mut Studio, label: &str, change: impl FnOnce(&mut CameraDesc)) {
    let Some(mut camera) = camera_of(studio) else { return };
    change(&mut camera.value);
    if camera.value.prepare(1.0).is_err() {
        return;
    }
    studio.moving();
    let _ = studio.document.edit(label, Some("camera"), |desc| {
        desc.camera = Some(camera);
        Ok(())
    });
}

fn frame(studio: &mut Studio, node: Option<Node>) {
    let Some(frame) = &studio.frame else { return };
    let stand = frame.stand.clone();
    let of_node = match node {
        Some(Node::Object(i)) => pick::object_bounds(&stand, i),
        Some(Node::Light(i)) => stand.desc.lights.get(i).and_then(|light| {
            let at = position_of(&light.value)?;
            Some(Bounds { min: at - DVec3::splat(0.5), max: at + DVec3::splat(0.5) })
        }),
        _ => None,
    };
    let Some(bounds) = of_node.or_else(|| pick::scene_bounds(&stand)) else { return };
    let aspect = stand.desc.film.aspect();
    studio.document.end_gesture();
    move_camera(studio, "Frame", |c| camera::frame(c, &bounds, aspect));
    studio.document.end_gesture();
}

/// The position of a light that has one.
pub(crate) fn position_of(light: &LightDesc) -> Option<DVec3> {
    match light {
        LightDesc::Point(l) => Some(l.position),
        LightDesc::Spot(l) => Some(l.position),
        _ => None,
    }
}

fn bookmark(studio: &mut Studio) {
    let Some(mut camera) = camera_of(studio) else { return };
    let count = studio.document.desc().cameras.len();
    camera.name = Some(format!("view {}", count + 1));
    camera.span = None;
    let added = studio.document.edit("Bookmark", None, |desc| {
        desc.cameras.push(camera);
        Ok(())
    });
    if studio.check(added).is_some() {
        studio.say(format!("Camera kept as \"view {}\"", count + 1));
    }
}

fn duplicate(studio: &mut Studio) {
    let Some(node) = studio.selection else { return };
    let again = |name: &Option<String>| name.as_ref().map(|name| format!("{name} copy"));
    let result = studio.document.edit("Duplicate", None, |desc| {
        Ok(match node {
            Node::Object(i) => {
                let mut copy = desc.objects[i].clone();
                (copy.name, copy.span) = (again(&copy.name), None);
                desc.objects.push(copy);
                Node::Object(desc.objects.len() - 1)
            }
            Node::Light(i) => {
                let mut copy = desc.lights[i].clone();
                (copy.name, copy.span) = (again(&copy.name), None);
                desc.lights.push(copy);
                Node::Light(desc.lights.len() - 1)
            }
            other => other,
        })
    });
    if let Some(node) = studio.check(result) {
        studio.selection = Some(node);
    }
}

fn delete(studio: &mut Studio) {
    let Some(node) = studio.selection.take() else { return };
    let label = format!("Delete {}", node.label(studio.document.desc()));
    let result = studio.document.edit(&label, None, |desc| {
        match node {
            Node::Object(i) => drop(desc.objects.remove(i)),
            Node::Light(i) => drop(desc.lights.remove(i)),
            Node::View(i) => drop(desc.cameras.remove(i)),
            _ => {}
        }
        Ok(())
    });
    studio.check(result);
}

/// The point that new things are placed at: that at which the camera looks.
fn place(studio: &Studio) -> DVec3 {
    let Some(mut camera) = camera_of(studio) else { return DVec3::ZERO };
    let [_, look_at, _] = camera.value.placement_mut();
    *look_at
}

fn add_shape(studio: &mut Studio, kind: &'static str) {
    let Some(shape) = ShapeDesc::of_type(kind) else { return };
    // A plane is a floor; all else stands where the camera looks.
    let at = if matches!(shape, ShapeDesc::Plane(_)) { DVec3::ZERO } else { place(studio) };
    let result = studio.document.edit(&format!("Add {kind}"), None, |desc| {
        let mut object = ObjectDesc { content: ObjectContent::Shape(shape), ..ObjectDesc::default() };
        object.name = Some(free_name(kind, desc.objects.iter().map(|o| &o.name)));
        object.transform.0.translation = at;
        desc.objects.push(object);
        Ok(desc.objects.len() - 1)
    });
    if let Some(i) = studio.check(result) {
        studio.selection = Some(Node::Object(i));
    }
}

/// `kind`, or `kind 2`, … if it is taken.
fn free_name<'a>(kind: &str, taken: impl Iterator<Item = &'a Option<String>> + Clone) -> String {
    let is_free = |name: &String| !taken.clone().any(|other| other.as_ref() == Some(name));
    let numbered = (2..).map(|n: u32| format!("{kind} {n}"));
    std::iter::once(kind.to_owned()).chain(numbered).find(is_free).unwrap_or_default()
}

fn add_light(studio: &mut Studio, kind: &'static str) {
    let Some(mut light) = LightDesc::of_type(kind) else { return };
    let at = place(studio) + DVec3::new(1.0, 3.0, 1.0);
    match &mut light {
        LightDesc::Point(l) => l.position = at,
        LightDesc::Spot(l) => l.position = at,
        _ => {}
    }
    let result = studio.document.edit(&format!("Add {kind} light"), None, |desc| {
        let name = Some(free_name(&format!("{kind} light"), desc.lights.iter().map(|l| &l.name)));
        desc.lights.push(SceneLight { name, group: None, span: None, hidden: false, value: light });
        Ok(desc.lights.len() - 1)
    });
    if let Some(i) = studio.check(result) {
        studio.selection = Some(Node::Light(i));
    }
}

/// A new material of the kind that the integrator prefers; the selected object gets it.
fn add_material(studio: &mut Studio) {
    let desc = studio.document.desc();
    let kind = if desc.integrator.capabilities().physical { "principled" } else { "classic" };
    let mut name = free_name("material", desc.materials.iter().map(|m| &m.name));
    name = name.replace(' ', "-");
    let table = [("type".to_owned(), Data::String(kind.to_owned()))];
    let mut edits: Vec<(String, Data)> =
        table.into_iter().map(|(key, data)| (format!("material.{name}.{key}"), data)).collect();
    if let Some(Node::Object(i)) = studio.selection {
        edits.push((format!("object.{i}.material"), Data::String(name.clone())));
    }
    let result = studio.document.set("Add material", None, &edits);
    if studio.check(result).is_some() {
        let last = studio.document.desc().materials.len() - 1;
        studio.selection = Some(Node::Material(last));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_actions_share_a_shortcut_or_a_name() {
        let all = Action::all();
        for (i, a) in all.iter().enumerate() {
            for b in &all[i + 1..] {
                assert_ne!(a.label(), b.label());
                assert!(a.shortcut().is_none() || a.shortcut() != b.shortcut(), "{a:?} {b:?}");
            }
            assert!(MENUS.contains(&a.menu()), "{a:?}");
        }
    }
}

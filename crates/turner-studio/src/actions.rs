//! Everything the user can do, as one table: menus, shortcuts and the command palette are made from it.

use egui::{Key, KeyboardShortcut, Modifiers};
use turner::color::Vision;
use turner::description::ObjectContent;
use turner::integrator::IntegratorDesc;
use turner::light::LightDesc;
use turner::shape::ShapeDesc;
use turner_live::camera;

use crate::cameras::{STEP, bookmark, focus, frame, move_camera, pan};
use crate::changes::*;
use crate::layout::Panel;
use crate::node::Node;
use crate::settings::Theme;
use crate::studio::{After, Dialog, Purpose, Studio};
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
            /// Show colours as a kind of colour vision sees them.
            See(Vision),
            /// Open a panel, or bring it to the front.
            Panel(Panel),
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
                    Action::See(_) => "View",
                    Action::Panel(_) => "Panels",
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
                    Action::See(vision) => format!("As seen with {}", vision.name()),
                    Action::Panel(panel) => format!("{} panel", panel.title()),
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
    SavePicture, "File", "Save the picture…", COMMAND, E;
    Save, "File", "Save", COMMAND, S;
    SaveAs, "File", "Save as…", COMMAND.plus(SHIFT), S;
    Quit, "File", "Quit", COMMAND, Q;
    Undo, "Edit", "Undo", COMMAND, Z;
    Redo, "Edit", "Redo", COMMAND.plus(SHIFT), Z;
    Copy, "Edit", "Copy as TOML";
    Paste, "Edit", "Paste";
    Duplicate, "Edit", "Duplicate", COMMAND, D;
    Delete, "Edit", "Delete", NONE, Delete;
    Hide, "Edit", "Hide or show", NONE, H;
    Rename, "Edit", "Rename…", NONE, F2;
    Group, "Edit", "Group", COMMAND, G;
    Ungroup, "Edit", "Ungroup", COMMAND.plus(SHIFT), G;
    SelectNone, "Edit", "Select nothing", NONE, Escape;
    GoToMaterial, "Edit", "Go to its material", NONE, M;
    GoToProperties, "Edit", "Go to the properties", NONE, E;
    AddModel, "Add", "Add model file…";
    AddMaterial, "Add", "Add material";
    Palette, "View", "Commands…", COMMAND, K;
    Frame, "View", "Frame the selection", NONE, F;
    FrameAll, "View", "Frame everything", NONE, Home;
    OrbitLeft, "View", "Orbit to the left", COMMAND, ArrowLeft;
    OrbitRight, "View", "Orbit to the right", COMMAND, ArrowRight;
    OrbitUp, "View", "Orbit upwards", COMMAND, ArrowUp;
    OrbitDown, "View", "Orbit downwards", COMMAND, ArrowDown;
    PanLeft, "View", "Move to the left", COMMAND.plus(SHIFT), ArrowLeft;
    PanRight, "View", "Move to the right", COMMAND.plus(SHIFT), ArrowRight;
    PanUp, "View", "Move upwards", COMMAND.plus(SHIFT), ArrowUp;
    PanDown, "View", "Move downwards", COMMAND.plus(SHIFT), ArrowDown;
    Nearer, "View", "Nearer", COMMAND, PageUp;
    Farther, "View", "Farther", COMMAND, PageDown;
    FocusSelection, "View", "Focus on the selection", SHIFT, F;
    ExplainMiddle, "View", "Explain the pixel in the middle", SHIFT, X;
    Bookmark, "View", "Bookmark the camera", COMMAND, B;
    Pause, "View", "Pause or continue rendering", NONE, Space;
    Dark, "View", "Dark or light";
    Larger, "View", "Larger", COMMAND, Plus;
    Smaller, "View", "Smaller", COMMAND, Minus;
    ToolSelect, "Tool", "Select and look around", NONE, Q;
    ToolMove, "Tool", "Move", NONE, G;
    ToolRotate, "Tool", "Rotate", NONE, R;
    ToolScale, "Tool", "Scale", NONE, T;
    ToolFocus, "Tool", "Focus where I click", NONE, C;
    ToolAim, "Tool", "Aim the light where I click", NONE, V;
    ToolExplain, "Tool", "Explain the pixel I click", NONE, X;
}

/// The menus in their order.
pub const MENUS: &[&str] = &["File", "Edit", "Add", "View", "Show", "Tool", "Panels"];

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
            .chain(Vision::ALL.map(Action::See))
            .chain(Panel::ALL.iter().copied().map(Action::Panel))
            .collect()
    }

    /// Whether it can be done now.
    pub fn is_possible(self, studio: &Studio) -> bool {
        let desc = studio.document.desc();
        match self {
            Action::Undo => !studio.document.steps().0.is_empty(),
            Action::Redo => !studio.document.steps().1.is_empty(),
            Action::Reload => studio.document.path().is_some(),
            Action::Copy | Action::Duplicate | Action::Delete => {
                matches!(
                    studio.selection,
                    Some(
                        Node::Object(_)
                            | Node::Light(_)
                            | Node::View(_)
                            | Node::Material(_)
                            | Node::Texture(_)
                    )
                )
            }
            Action::Rename => studio.selection.is_some_and(|node| name_of(studio, node).is_some()),
            Action::Hide => matches!(studio.selection, Some(Node::Object(_) | Node::Light(_))),
            Action::Group => matches!(studio.selection, Some(Node::Object(_))),
            Action::GoToMaterial => material_of(studio).is_some(),
            Action::GoToProperties => studio.selection.is_some(),
            Action::Ungroup => match studio.selection {
                Some(Node::Object(i)) => {
                    matches!(desc.objects.get(i).map(|o| &o.content), Some(ObjectContent::Instance(_)))
                }
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
                studio.dialog = Some(Dialog::File { purpose: Purpose::Open, name });
            }
            Action::Reload => studio.reload(),
            Action::Save => studio.save(None),
            Action::SaveAs => {
                let path = studio.document.path().map(|path| path.with_extension("toml"));
                let path = path.unwrap_or_else(|| studio.document.folder().join("untitled.toml"));
                let name = path.to_string_lossy().into_owned();
                studio.dialog = Some(Dialog::File { purpose: Purpose::Save, name });
            }
            Action::SavePicture => {
                let name = studio.document.folder().join("picture.png").to_string_lossy().into_owned();
                studio.dialog = Some(Dialog::File { purpose: Purpose::Picture, name });
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
            Action::Copy => {
                let copied = studio.document.copy(&selected_paths(studio));
                if let Some(text) = studio.check(copied) {
                    studio.wake().copy_text(text);
                }
            }
            Action::Paste => studio.wake().send_viewport_cmd(egui::ViewportCommand::RequestPaste),
            Action::AddModel => {
                let name = format!("{}{}", studio.document.folder().display(), std::path::MAIN_SEPARATOR);
                studio.dialog = Some(Dialog::File { purpose: Purpose::Model, name });
            }
            Action::Duplicate => duplicate(studio),
            Action::Delete => delete(studio),
            Action::Rename => ask_name(studio),
            Action::Hide => hide(studio),
            Action::Group => group(studio),
            Action::Ungroup => ungroup(studio),
            Action::SelectNone => studio.select(None, false),
            Action::GoToMaterial => {
                if let Some(material) = material_of(studio) {
                    studio.select(Some(material), false);
                }
            }
            Action::GoToProperties => {
                studio.reveal = Some(Panel::Properties);
                studio.focus_properties = true;
            }
            Action::See(vision) => studio.viewport.vision = vision,
            Action::Panel(panel) => studio.reveal = Some(panel),
            Action::AddMaterial => add_material(studio),
            Action::AddShape(kind) => add_shape(studio, kind),
            Action::AddLight(kind) => add_light(studio, kind),
            Action::Palette => studio.viewport.palette = Some(String::new()),
            Action::Frame => frame(studio, studio.selection),
            Action::FrameAll => frame(studio, None),
            Action::OrbitLeft => move_camera(studio, "Orbit", |c| camera::orbit(c, -STEP, 0.0)),
            Action::OrbitRight => move_camera(studio, "Orbit", |c| camera::orbit(c, STEP, 0.0)),
            Action::OrbitUp => move_camera(studio, "Orbit", |c| camera::orbit(c, 0.0, STEP)),
            Action::OrbitDown => move_camera(studio, "Orbit", |c| camera::orbit(c, 0.0, -STEP)),
            Action::PanLeft => pan(studio, STEP, 0.0),
            Action::PanRight => pan(studio, -STEP, 0.0),
            Action::PanUp => pan(studio, 0.0, -STEP),
            Action::PanDown => pan(studio, 0.0, STEP),
            Action::Nearer => move_camera(studio, "Dolly", |c| camera::dolly(c, 1.0 - STEP)),
            Action::Farther => move_camera(studio, "Dolly", |c| camera::dolly(c, 1.0 / (1.0 - STEP))),
            Action::FocusSelection => focus(studio),
            Action::ExplainMiddle => {
                let film = &studio.document.desc().film;
                studio.viewport.explained = Some([film.width / 2, film.height / 2]);
            }
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
            Action::ToolAim => studio.viewport.tool = Tool::Aim,
            Action::ToolExplain => studio.viewport.tool = Tool::Explain,
            Action::Show(name) => studio.look.integrator = name.and_then(IntegratorDesc::of_type),
        }
    }
}

/// Shapes that are nothing without data: vertices, files, points.
const NEED_DATA: &[&str] = &["mesh", "points", "curves", "height_field", "text", "distance_grid"];

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

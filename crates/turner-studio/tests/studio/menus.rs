//! Panels, menus, themes, sizes.

use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT, Queryable};
use turner_live::document::STARTS;
use turner_studio::actions::{Action, MENUS};
use turner_studio::layout::Panel;
use turner_studio::node::Node;
use turner_studio::settings::Theme;

use super::common::*;

#[test]
fn every_panel_opens_from_its_menu() {
    let (mut window, _home) = sample([1400.0, 900.0]);
    for panel in Panel::ALL.iter().map(|panel| panel.title()) {
        menu(&mut window, "Panels", &format!("{panel} panel"));
        frames(&mut window, 2);
        assert!(says(&window, panel), "{panel}");
        assert!(window.unnamed_widgets().is_empty(), "{panel}: {:?}", window.unnamed_widgets());
    }
}

/// Each action in each menu, on a new window with the scene and each kind of part selected. The document stays whole:
/// what was changed can be undone.
#[test]
fn every_action_of_every_menu() {
    let selections =
        [None, Some(Node::Object(1)), Some(Node::Light(0)), Some(Node::Material(2)), Some(Node::View(0))];
    let (mut window, home) = sample([1400.0, 900.0]);
    let mut first = seen(&window).document.desc().clone();
    for action in Action::all() {
        if action == Action::Quit {
            continue;
        }
        for selection in selections {
            app(&mut window).selection = selection;
            frames(&mut window, 1);
            let possible = action.is_possible(seen(&window));
            menu(&mut window, action.menu(), &action.label());
            frames(&mut window, 2);
            if !possible {
                // An entry that does nothing leaves its menu open.
                press(&mut window, egui::Modifiers::NONE, egui::Key::Escape);
                assert_eq!(seen(&window).selection, selection);
            }
            let studio = app(&mut window);
            assert!(possible || studio.dialog.is_none(), "{action:?}");
            studio.dialog = None;
            studio.viewport.palette = None;
            if action != Action::New && action != Action::Undo && action != Action::Redo {
                let changed = studio.document.desc().clone();
                if !std::sync::Arc::ptr_eq(&changed, &first) {
                    let problem = changed.prepare(&Default::default()).err();
                    assert!(problem.is_none(), "{action:?} {selection:?}: {problem:?}");
                }
                let mut count = 0;
                while studio.document.undo().is_some() {
                    count += 1;
                }
                assert!(std::sync::Arc::ptr_eq(studio.document.desc(), &first), "{action:?} {selection:?}");
                for _ in 0..count {
                    studio.document.redo();
                }
                assert!(std::sync::Arc::ptr_eq(studio.document.desc(), &changed), "{action:?} {selection:?}");
                while studio.document.undo().is_some() {}
            }
            frames(&mut window, 1);
            if !std::sync::Arc::ptr_eq(seen(&window).document.desc(), &first) {
                show(&mut window, turner::SceneDesc::clone(&first));
                first = seen(&window).document.desc().clone();
            }
        }
        assert_eq!(first.objects.len(), 3, "{action:?}");
        break_if_panicked(&window);
    }
    drop(home);
}

fn break_if_panicked(window: &Window) {
    assert!(seen(window).status.error.is_none(), "{:?}", seen(window).status.error);
}

/// The menus are the table: no action is missing from them, none is there twice.
#[test]
fn menus_hold_all_actions() {
    let (mut window, _home) = sample([1400.0, 900.0]);
    for name in MENUS {
        let closed = entries(&window).len();
        open_menu(&mut window, name);
        let count = Action::all().into_iter().filter(|action| action.menu() == *name).count();
        assert_eq!(entries(&window).len() - closed, count, "{name}");
        press(&mut window, egui::Modifiers::NONE, egui::Key::Escape);
        assert_eq!(entries(&window).len(), closed, "{name} is closed by Escape");
    }
}

#[test]
fn every_theme_size_and_density() {
    let sizes = [[100.0, 100.0], [320.0, 240.0], [640.0, 1200.0], [1440.0, 900.0], [3840.0, 2160.0]];
    for theme in [Theme::Dark, Theme::Light, Theme::System] {
        for size in sizes {
            for density in [1.0, 2.0] {
                let (mut window, _home) = window(size, density);
                app(&mut window).settings.theme = theme;
                show(&mut window, scene(SAMPLE));
                app(&mut window).selection = Some(Node::Object(1));
                frames(&mut window, 3);
                for panel in Panel::ALL {
                    app(&mut window).reveal = Some(*panel);
                    frames(&mut window, 2);
                    assert!(
                        window.unnamed_widgets().is_empty(),
                        "{size:?} x {density}: {:?}",
                        window.unnamed_widgets()
                    );
                }
            }
        }
    }
}

/// Looking at a scene does not change it: not by any widget that shows a value, for any scene of the gallery.
#[test]
fn showing_every_part_of_every_scene_changes_nothing() {
    let (mut window, _home) = window([1400.0, 2000.0], 1.0);
    for start in STARTS {
        super::common::start(&mut window, start.name);
        let desc = seen(&window).document.desc().clone();
        // Some of each list are enough.
        let some = |count: usize| (0..count).step_by(1 + count / 12);
        let lists = some(desc.objects.len()).map(Node::Object);
        let lists = lists.chain(some(desc.lights.len()).map(Node::Light));
        let lists = lists.chain(some(desc.materials.len()).map(Node::Material));
        let lists = lists.chain(some(desc.textures.len()).map(Node::Texture));
        let lists = lists.chain(some(desc.media.len()).map(Node::Medium));
        let lists = lists.chain(some(desc.cameras.len()).map(Node::View));
        let single = [Node::Camera, Node::Film, Node::Integrator, Node::Background, Node::Studio];
        for part in lists.chain(single) {
            app(&mut window).selection = Some(part);
            frames(&mut window, 2);
            let studio = seen(&window);
            assert!(
                !studio.document.is_changed(),
                "{}: {part:?}: {:?}",
                start.name,
                studio.document.steps().0
            );
            assert!(
                window.unnamed_widgets().is_empty(),
                "{}: {part:?}: {:?}",
                start.name,
                window.unnamed_widgets()
            );
        }
    }
}

/// The list of the scene has every part, and a click selects it.
#[test]
fn the_list_selects_every_part() {
    let (mut window, _home) = sample([1400.0, 1400.0]);
    let desc = seen(&window).document.desc().clone();
    let mut parts = vec![Node::Camera, Node::Film, Node::Integrator, Node::Background];
    parts.extend((0..desc.objects.len()).map(Node::Object));
    parts.extend((0..desc.lights.len()).map(Node::Light));
    parts.extend((0..desc.materials.len()).map(Node::Material));
    parts.extend((0..desc.textures.len()).map(Node::Texture));
    parts.extend((0..desc.media.len()).map(Node::Medium));
    parts.extend((0..desc.cameras.len()).map(Node::View));
    for part in parts {
        app(&mut window).selection = None;
        frames(&mut window, 1);
        let label = part.label(&desc);
        let found = window.root().children_recursive().find(|n| {
            let n = n.accesskit_node();
            n.label().as_deref() == Some(&label) && n.role() != Role::Label
        });
        found.unwrap_or_else(|| panic!("{label} is not in {:?}", names(&window))).click_accesskit();
        frames(&mut window, 2);
        assert_eq!(seen(&window).selection, Some(part));
    }
    let _ = window.query_all_by_role(Role::Button).count();
}

//! The guide says what the program does.

use std::path::Path;

use egui::ModifierNames;
use turner_live::document::STARTS;
use turner_studio::actions::Action;
use turner_studio::layout::Panel;

const BEGIN: &str = "<!-- shortcuts: made from the table of actions -->\n";
const END: &str = "<!-- end of the shortcuts -->\n";

fn table() -> String {
    let mut table = String::from("| menu | command | key |\n|---|---|---|\n");
    for action in Action::all() {
        if let Some(shortcut) = action.shortcut() {
            let key = shortcut.format(&ModifierNames::NAMES, false);
            table += &format!("| {} | {} | {key} |\n", action.menu(), action.label());
        }
    }
    table
}

/// `TURNER_UPDATE=1` writes the table instead of comparing it.
#[test]
fn the_guide_lists_the_shortcuts() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/studio.md");
    let text = std::fs::read_to_string(&path).unwrap();
    let begin = text.find(BEGIN).expect("the guide has the table") + BEGIN.len();
    let end = text.find(END).expect("the table has an end");
    if std::env::var_os("TURNER_UPDATE").is_some() {
        std::fs::write(&path, format!("{}{}{}", &text[..begin], table(), &text[end..])).unwrap();
        return;
    }
    assert_eq!(&text[begin..end], table(), "TURNER_UPDATE=1 cargo test -p turner-studio writes it");
}

/// Every panel has a row in the guide, and what the guide calls by name exists.
#[test]
fn the_guide_names_what_there_is() {
    let text = include_str!("../../../../docs/studio.md");
    for panel in Panel::ALL.iter().map(|panel| panel.title()) {
        assert!(text.contains(&format!("\n| {panel} |")), "the guide has no row for the panel {panel}");
    }
    let groups: Vec<&str> = STARTS.iter().map(|start| start.group).collect();
    for named in ["The five classic systems", "The paper's table"] {
        assert!(text.contains(named) && groups.contains(&named), "{named}");
    }
    let labels: Vec<String> = Action::all().into_iter().map(Action::label).collect();
    for named in ["Add plane", "Add sphere", "Add box", "Add ambient light", "Add point light"] {
        assert!(text.contains(named) && labels.iter().any(|label| label == named), "{named}");
    }
}

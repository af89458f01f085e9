//! The doctor's findings, with remedies to apply.

use egui::{RichText, Ui};
use turner::doctor::Severity;
use turner::schema::value::Data;
use turner::schema::{KeyEdit, Remedy};

use crate::studio::Studio;

pub(crate) fn show(ui: &mut Ui, studio: &mut Studio) {
    ui.horizontal(|ui| {
        let stand = studio.frame.as_ref().map(|frame| frame.stand.clone());
        let possible = stand.is_some() && !studio.insight.is_examining();
        let button = ui.add_enabled(possible, egui::Button::new("Examine the scene"));
        if let Some(stand) = stand.filter(|_| button.clicked()) {
            studio.insight.examine(&ui.ctx().clone(), stand);
        }
        if studio.insight.is_examining() {
            ui.spinner();
            ui.label("Tracing paths");
        }
    });
    let Some((examination, of)) = studio.insight.examination.clone() else {
        ui.weak("Says why a picture is black, noisy, washed out or slow, and what to do.");
        return;
    };
    if !std::sync::Arc::ptr_eq(&of, studio.document.desc()) {
        ui.weak("The scene has changed since.");
    }
    if examination.findings.is_empty() {
        ui.label("Nothing is wrong.");
    }
    let mut chosen: Option<Vec<KeyEdit>> = None;
    egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        for finding in &examination.findings {
            let (word, color) = match finding.severity {
                Severity::Error => ("Error", ui.visuals().error_fg_color),
                Severity::Warning => ("Warning", ui.visuals().warn_fg_color),
                _ => ("Note", ui.visuals().text_color()),
            };
            ui.add_space(6.0);
            ui.label(RichText::new(format!("{word}: {}", finding.what)).color(color).strong());
            ui.label(&finding.why);
            ui.label(RichText::new(&finding.remedy).italics());
            for remedy in &finding.remedies {
                let Remedy::Set(edits) = remedy else { continue };
                let words: Vec<String> = edits.iter().map(text).collect();
                if ui.button(format!("Apply {}", words.join(", "))).clicked() {
                    chosen = Some(edits.clone());
                }
            }
        }
    });
    if let Some(edits) = chosen {
        let result = studio.document.apply("Remedy", None, &edits);
        studio.check(result);
    }
}

/// An edit in words: `film.samples = 256`.
fn text(edit: &KeyEdit) -> String {
    let path: Vec<&str> = edit.path.iter().map(|part| part.key.as_str()).collect();
    format!("{} = {}", path.join("."), shown(&edit.value.data))
}

fn shown(data: &Data) -> String {
    match data {
        Data::Bool(on) => on.to_string(),
        Data::Integer(i) => i.to_string(),
        Data::Number(v) => v.to_string(),
        Data::String(text) => format!("\"{text}\""),
        Data::Array(items) => {
            let items: Vec<String> = items.iter().map(|item| shown(&item.data)).collect();
            format!("[{}]", items.join(", "))
        }
        Data::Table(_) => "{ … }".into(),
    }
}

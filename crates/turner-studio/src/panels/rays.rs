//! The rays of a pixel, as a tree with numbers. Drawn in the picture by `viewport::overlay`.

use egui::{CollapsingHeader, RichText, Ui};
use turner::explain::{Explanation, number};

use crate::insight::Insight;
use crate::studio::Studio;
use crate::viewport::Tool;

/// Rays that the tree shows.
const MOST: usize = 2000;

pub(crate) fn show(ui: &mut Ui, studio: &mut Studio) {
    boxes(ui, studio);
    ui.separator();
    let Some([x, y]) = studio.viewport.explained else {
        ui.label("Choose the tool Explain and click a pixel: this panel shows its rays, and the picture draws them.");
        if ui.button("Explain a pixel").clicked() {
            studio.viewport.tool = Tool::Explain;
        }
        return;
    };
    ui.horizontal(|ui| {
        ui.strong(format!("Pixel {x}, {y}"));
        if ui.small_button("Close").clicked() {
            studio.viewport.explained = None;
        }
    });
    let explanation = match &studio.insight.explanation {
        None => {
            ui.horizontal(|ui| {
                ui.spinner();
                ui.label(studio.insight.waits_for());
            });
            if ui.button("Cancel").clicked() {
                studio.viewport.explained = None;
            }
            return;
        }
        Some(Err(message)) => {
            ui.label(message);
            return;
        }
        Some(Ok(explanation)) => explanation.clone(),
    };
    let samples = studio.document.desc().film.samples.max(1);
    choices(ui, &mut studio.insight, &explanation, samples);
    let tree = &explanation.tree;
    ui.label(format!("Sample {} gives {}", tree.number, number::color(tree.rendered)));
    for remark in &tree.remarks {
        ui.weak(remark);
    }
    egui::ScrollArea::both().auto_shrink(false).show(ui, |ui| {
        if !tree.nodes.is_empty() {
            let mut left = MOST;
            node(ui, &mut studio.insight, &explanation, 0, 0, &mut left);
        }
    });
}

/// The sample, and how many bounces are drawn.
fn choices(ui: &mut Ui, insight: &mut Insight, explanation: &Explanation, samples: u32) {
    ui.horizontal(|ui| {
        let mut largest = insight.sample.is_none();
        if ui.checkbox(&mut largest, "Brightest sample").changed() {
            insight.sample = if largest { None } else { Some(explanation.tree.number as u32) };
        }
        if let Some(sample) = &mut insight.sample {
            let drag = egui::DragValue::new(sample).range(0..=samples - 1).prefix("sample ");
            let response = ui.add(drag);
            crate::widgets::name_number(&response, "Sample", f64::from(*sample));
        }
    });
    let deepest = (0..explanation.tree.nodes.len()).map(|i| depth(explanation, i)).max().unwrap_or(0);
    ui.horizontal(|ui| {
        let mut shown = insight.bounces.unwrap_or(deepest);
        if ui.button("Back").on_hover_text("Draw one bounce less").clicked() {
            shown = shown.saturating_sub(1);
        }
        if ui.button("Step").on_hover_text("Draw one bounce more").clicked() {
            shown = if insight.bounces.is_none() { 0 } else { (shown + 1).min(deepest) };
        }
        if ui.button("All").clicked() {
            shown = deepest;
        }
        insight.bounces = (shown < deepest).then_some(shown);
        ui.label(format!("{} of {} bounces drawn", shown, deepest));
    });
}

/// The number of rays before this one on its way from the camera.
pub(crate) fn depth(explanation: &Explanation, mut index: usize) -> usize {
    let mut depth = 0;
    while let Some(parent) = explanation.tree.nodes.get(index).and_then(|node| node.parent) {
        (index, depth) = (parent, depth + 1);
    }
    depth
}

/// Levels that are nested; deeper ones follow without an indent.
const DEEPEST: usize = 24;

fn node(
    ui: &mut Ui,
    insight: &mut Insight,
    explanation: &Explanation,
    index: usize,
    level: usize,
    left: &mut usize,
) {
    let Some(ray) = explanation.tree.nodes.get(index) else { return };
    if *left == 0 || level > DEEPEST {
        return;
    }
    *left -= 1;
    let share = explanation.tree.fraction(ray.total);
    let mut title =
        RichText::new(format!("{}  {}", ray.summary().replace('→', "to"), number::percent(share)));
    if insight.marked == Some(index) {
        title = title.strong();
    }
    let header = CollapsingHeader::new(title).id_salt(index).default_open(level < 3);
    let response = header.show(ui, |ui| {
        for term in &ray.terms {
            ui.label(RichText::new(format!("{}: {}", term.name, term.text())).small())
                .on_hover_text(term.meaning().unwrap_or(term.name));
        }
        if let Some(cut) = &ray.cut {
            ui.label(RichText::new(cut.to_string()).small().italics());
        }
        for &child in &ray.children {
            node(ui, insight, explanation, child, level + 1, left);
        }
    });
    if response.header_response.clicked() {
        insight.marked = Some(index);
    }
}

/// Boxes of the BVH.
fn boxes(ui: &mut Ui, studio: &mut Studio) {
    ui.horizontal(|ui| {
        let mut on = studio.insight.boxes.is_some();
        if ui.checkbox(&mut on, "BVH boxes").changed() {
            studio.insight.boxes = on.then_some(2);
        }
        if let Some(depth) = &mut studio.insight.boxes {
            let response = ui.add(egui::Slider::new(depth, 0..=24).text("depth"));
            crate::widgets::name_number(&response, "Depth of BVH boxes", f64::from(*depth));
        }
    });
}

//! Text is readable: its contrast with what is behind it is at least 4.5 to 1 in both themes (WCAG 2, level AA). Measured
//! at the shapes that are drawn. Text of what cannot be used at the moment is exempt, as in WCAG.

use std::collections::BTreeMap;

use egui::epaint::TextShape;
use egui::{Color32, Key, Modifiers, Pos2, Shape};
use egui_kittest::kittest::NodeT;
use turner_studio::layout::Panel;
use turner_studio::node::Node;
use turner_studio::settings::Theme;

use super::common::*;

fn luminance(color: Color32) -> f32 {
    let linear = egui::Rgba::from(color.to_opaque());
    0.2126 * linear.r() + 0.7152 * linear.g() + 0.0722 * linear.b()
}

fn ratio(a: Color32, b: Color32) -> f32 {
    let (a, b) = (luminance(a), luminance(b));
    (a.max(b) + 0.05) / (a.min(b) + 0.05)
}

/// What was filled so far: rectangle and colour; `None` for pictures.
type Fills = Vec<(egui::Rect, Option<Color32>)>;

fn flatten(
    shape: &Shape,
    clip: egui::Rect,
    fills: &mut Fills,
    visit: &mut dyn FnMut(&TextShape, egui::Rect, &Fills),
) {
    match shape {
        Shape::Vec(shapes) => shapes.iter().for_each(|shape| flatten(shape, clip, fills, visit)),
        Shape::Rect(rect) if rect.brush.is_some() => fills.push((rect.rect.intersect(clip), None)),
        // Shadows are blurred: they darken a little, at the edge of what lies on them.
        Shape::Rect(rect) if rect.fill != Color32::TRANSPARENT && rect.blur_width == 0.0 => {
            fills.push((rect.rect.intersect(clip), Some(rect.fill)));
        }
        Shape::Text(text) => visit(text, clip, fills),
        _ => {}
    }
}

/// The colours that can be behind a point: one, or black and white below what lies on a picture.
fn behind(at: Pos2, fills: &Fills) -> Vec<Color32> {
    let mut colors = vec![Color32::BLACK];
    for (rect, fill) in fills.iter().filter(|(rect, _)| rect.contains(at)) {
        let _ = rect;
        match fill {
            None => colors = vec![Color32::BLACK, Color32::WHITE],
            Some(fill) if fill.is_opaque() => colors = vec![*fill],
            Some(fill) => colors.iter_mut().for_each(|color| *color = color.blend(*fill)),
        }
    }
    colors
}

/// Collects texts with too little contrast, each with its ratio.
fn weak_texts(window: &Window, where_: &str, found: &mut BTreeMap<String, f32>) -> usize {
    let all = window.root().children_recursive();
    let disabled: Vec<egui::Rect> = all
        .filter(|n| n.accesskit_node().is_disabled() && n.accesskit_node().bounding_box().is_some())
        .map(|n| n.rect())
        .collect();
    let mut fills = Fills::new();
    let mut count = 0;
    let mut visit = |text: &TextShape, clip: egui::Rect, fills: &Fills| {
        for row in &text.galley.rows {
            let rect = row.rect().translate(text.pos.to_vec2());
            let at = rect.center();
            let string = row.text();
            if !clip.contains(at) || string.trim().is_empty() || disabled.iter().any(|rect| rect.contains(at))
            {
                continue;
            }
            count += 1;
            for section in &text.galley.job.sections {
                let own = text.override_text_color.unwrap_or(section.format.color);
                let own = if own == Color32::PLACEHOLDER { text.fallback_color } else { own };
                let own = own.gamma_multiply(text.opacity_factor);
                for back in behind(at, fills) {
                    let ratio = ratio(back.blend(own), back);
                    if ratio < 4.5 {
                        let name = format!("{where_}: {string:?} is {own:?} on {back:?}");
                        found.insert(name, ratio);
                    }
                }
            }
        }
    };
    for clipped in &window.output().shapes {
        flatten(&clipped.shape, clipped.clip_rect, &mut fills, &mut visit);
    }
    count
}

#[test]
fn ratios_are_those_of_the_standard() {
    assert!((ratio(Color32::WHITE, Color32::BLACK) - 21.0).abs() < 1e-3);
    assert!((ratio(Color32::from_gray(0x76), Color32::WHITE) - 4.54).abs() < 0.01);
}

#[test]
fn text_is_readable_in_both_themes() {
    let mut found = BTreeMap::new();
    let mut count = 0;
    for theme in [Theme::Dark, Theme::Light] {
        let (mut window, _home) = sample([1600.0, 1200.0]);
        app(&mut window).settings.theme = theme;
        frames(&mut window, 3);
        let name = |what: &str| format!("{theme:?}, {what}");
        for part in
            [None, Some(Node::Object(1)), Some(Node::Light(0)), Some(Node::Material(0)), Some(Node::Film)]
        {
            app(&mut window).selection = part;
            frames(&mut window, 3);
            count += weak_texts(&window, &name(&format!("{part:?}")), &mut found);
        }
        for panel in Panel::ALL {
            app(&mut window).reveal = Some(*panel);
            frames(&mut window, 3);
            count += weak_texts(&window, &name(panel.title()), &mut found);
        }
        for menu in turner_studio::actions::MENUS {
            open_menu(&mut window, menu);
            count += weak_texts(&window, &name(menu), &mut found);
            press(&mut window, Modifiers::NONE, Key::Escape);
        }
        press(&mut window, Modifiers::COMMAND, Key::K);
        count += weak_texts(&window, &name("palette"), &mut found);
        write(&mut window, "no such command");
        count += weak_texts(&window, &name("empty palette"), &mut found);
        press(&mut window, Modifiers::NONE, Key::Escape);
        press(&mut window, Modifiers::COMMAND, Key::O);
        count += weak_texts(&window, &name("open"), &mut found);
        press(&mut window, Modifiers::NONE, Key::Escape);
        press(&mut window, Modifiers::COMMAND, Key::B);
        count += weak_texts(&window, &name("history and message"), &mut found);
        press(&mut window, Modifiers::COMMAND, Key::Z);
        press(&mut window, Modifiers::COMMAND, Key::B);
        press(&mut window, Modifiers::COMMAND, Key::N);
        count += weak_texts(&window, &name("question"), &mut found);
        press(&mut window, Modifiers::NONE, Key::Escape);
        app(&mut window).open(std::path::Path::new("no such file.toml"));
        until(&mut window, "an error", |studio| studio.problem.is_some());
        count += weak_texts(&window, &name("problem"), &mut found);
        let error =
            turner::schema::SceneError::new(turner::schema::ErrorCode::Output, "a fault").help("a remedy");
        app(&mut window).fail(&error);
        frames(&mut window, 2);
        count += weak_texts(&window, &name("error"), &mut found);
    }
    assert!(count > 1000, "only {count} texts were seen");
    let list: Vec<String> = found.iter().map(|(name, ratio)| format!("{ratio:.2} {name}")).collect();
    assert!(list.is_empty(), "{} of {count} texts:\n{}", list.len(), list.join("\n"));
}

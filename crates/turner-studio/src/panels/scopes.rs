//! Histogram and waveform of the picture's display values.

use egui::{Color32, Pos2, Rect, Sense, Shape, Stroke, Ui, Vec2, pos2};
use turner::Picture;

use crate::studio::Studio;

/// Pixels that are looked at: enough for smooth curves, few enough for every frame.
const MOST: usize = 40_000;

const CHANNELS: [Color32; 3] =
    [Color32::from_rgb(240, 90, 90), Color32::from_rgb(100, 210, 100), Color32::from_rgb(100, 150, 255)];

pub(crate) fn show(ui: &mut Ui, studio: &mut Studio) {
    let Some(frame) = studio.frame.clone() else { return };
    let picture = &frame.picture;
    ui.strong("Histogram");
    histogram(ui, picture);
    ui.add_space(6.0);
    ui.strong("Waveform");
    waveform(ui, picture);
    let clipped = picture.display.iter().step_by(step(picture)).filter(|p| p[..3].contains(&255)).count();
    let seen = picture.display.len().div_ceil(step(picture)).max(1);
    ui.weak(format!(
        "{:.1} % of the pixels have a channel at its limit",
        100.0 * clipped as f64 / seen as f64
    ));
}

fn step(picture: &Picture) -> usize {
    (picture.display.len() / MOST).max(1)
}

fn area(ui: &mut Ui, name: &str) -> (Rect, egui::Painter) {
    let size = Vec2::new(ui.available_width().max(10.0), 110.0);
    let (response, painter) = ui.allocate_painter(size, Sense::hover());
    crate::widgets::name(&response, egui::Role::Image, name);
    painter.rect_filled(response.rect, 2.0, ui.visuals().extreme_bg_color);
    (response.rect, painter)
}

fn histogram(ui: &mut Ui, picture: &Picture) {
    let mut counts = [[0u32; 64]; 3];
    for pixel in picture.display.iter().step_by(step(picture)) {
        for (channel, counts) in counts.iter_mut().enumerate() {
            counts[usize::from(pixel[channel]) / 4] += 1;
        }
    }
    let (rect, painter) = area(ui, "Histogram");
    // The ends, where clipped values are, would flatten the rest.
    let most = counts.iter().flat_map(|c| &c[1..63]).copied().max().unwrap_or(1).max(1);
    for (channel, (counts, color)) in counts.iter().zip(CHANNELS).enumerate() {
        let at = |(i, n): (usize, &u32)| {
            let height = (*n as f32 / most as f32).min(1.0);
            pos2(rect.left() + rect.width() * i as f32 / 63.0, rect.bottom() - rect.height() * height)
        };
        let line: Vec<Pos2> = counts.iter().enumerate().map(at).collect();
        let stroke = Stroke::new(1.5, color);
        // Lines differ in form, too.
        match channel {
            0 => _ = painter.add(Shape::line(line, stroke)),
            1 => painter.extend(Shape::dashed_line(&line, stroke, 7.0, 4.0)),
            _ => painter.extend(Shape::dotted_line(&line, color, 5.0, 1.3)),
        }
    }
    ui.weak("Red is solid, green dashed, blue dotted.");
}

/// Red, green and blue side by side, each from the left to the right of the picture.
fn waveform(ui: &mut Ui, picture: &Picture) {
    let (whole, painter) = area(ui, "Waveform");
    let (columns, width) = (48usize, picture.width.max(1) as usize);
    let third = whole.width() / 3.0;
    let part = |channel: usize| {
        let left = whole.left() + third * channel as f32;
        Rect::from_min_max(pos2(left + 1.0, whole.top()), pos2(left + third - 1.0, whole.bottom()))
    };
    let mut counts = vec![[[0u16; 64]; 3]; columns];
    for (i, pixel) in picture.display.iter().enumerate().step_by(step(picture) | 1) {
        let column = (i % width) * columns / width;
        for channel in 0..3 {
            let count = &mut counts[column][channel][usize::from(pixel[channel]) / 4];
            *count = count.saturating_add(1);
        }
    }
    let most = f32::from(counts.iter().flatten().flatten().copied().max().unwrap_or(1).max(1));
    let cell = Vec2::new(part(0).width() / columns as f32, whole.height() / 64.0);
    for (x, column) in counts.iter().enumerate() {
        for (i, (channel, color)) in column.iter().zip(CHANNELS).enumerate() {
            let rect = part(i);
            for (y, n) in channel.iter().enumerate().filter(|(_, n)| **n > 0) {
                let alpha = (60.0 + 195.0 * (f32::from(*n) / most).sqrt()) as u8;
                let at = pos2(rect.left() + cell.x * x as f32, rect.bottom() - cell.y * (y + 1) as f32);
                let [r, g, b, _] = color.to_array();
                painter.rect_filled(
                    Rect::from_min_size(at, cell),
                    0.0,
                    Color32::from_rgba_unmultiplied(r, g, b, alpha),
                );
            }
        }
    }
    let font = egui::TextStyle::Small.resolve(ui.style());
    for (i, letter) in ["R", "G", "B"].into_iter().enumerate() {
        let at = part(i).left_top() + Vec2::new(4.0, 2.0);
        painter.text(at, egui::Align2::LEFT_TOP, letter, font.clone(), ui.visuals().text_color());
    }
}

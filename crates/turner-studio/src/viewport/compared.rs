//! The kept picture against the present one: wipe, difference, FLIP.

use std::sync::Arc;

use egui::{Color32, ColorImage, Context, Painter, Rect, Stroke, TextureHandle, TextureOptions, pos2};
use turner::Picture;
use turner::color::heat;
use turner::compare::{Canvas, Metric, Pair};
use turner::image::{Image, Pixels};
use turner_live::engine::Frame;

use crate::insight::Comparison;
use crate::studio::Studio;
use crate::task::Task;

/// A picture of differences, and their mean.
type Differences = Result<(ColorImage, f64), String>;

/// The state of a comparison.
#[derive(Default)]
pub(super) struct Compared {
    kept: Option<(TextureHandle, Arc<Frame>)>,
    map: Option<TextureHandle>,
    of: Option<(Arc<Frame>, Arc<Frame>, bool)>,
    task: Option<Task<Differences>>,
    pub(super) text: Option<String>,
}

/// The colours of a picture for the window.
pub(crate) fn image(picture: &Picture) -> ColorImage {
    let pixels = picture.display.iter().map(|&[r, g, b, a]| match a {
        255 => Color32::from_rgb(r, g, b),
        _ => Color32::from_rgba_unmultiplied(r, g, b, a),
    });
    ColorImage::new([picture.width as usize, picture.height as usize], pixels.collect())
}

fn canvas(picture: &Picture) -> Canvas {
    let bytes = picture.display.iter().flatten().copied().collect();
    let image =
        Image { width: picture.width, height: picture.height, channels: 4, pixels: Pixels::U8(bytes) };
    Canvas::new(&image, false)
}

/// The differences of display values, or FLIP.
fn differences(a: &Picture, b: &Picture, is_flip: bool) -> Differences {
    let size = [b.width as usize, b.height as usize];
    if (a.width, a.height) != (b.width, b.height) {
        return Err("the pictures have different sizes; a preview is smaller until it is still".into());
    }
    if !is_flip {
        let pairs = a.display.iter().zip(&b.display);
        let each = pairs.map(|(a, b)| [0, 1, 2].map(|c| a[c].abs_diff(b[c])));
        let each: Vec<[u8; 3]> = each.collect();
        let sum: f64 = each.iter().flatten().map(|v| f64::from(*v)).sum();
        let pixels = each.iter().map(|v| {
            let [r, g, b] = v.map(|v| v.saturating_mul(4));
            Color32::from_rgb(r, g, b)
        });
        let mean = sum / (3.0 * 255.0 * each.len().max(1) as f64);
        return Ok((ColorImage::new(size, pixels.collect()), mean));
    }
    let pair = Pair::new(canvas(a), canvas(b)).map_err(|mismatch| mismatch.to_string())?;
    let measured = Metric::Flip.measure(&pair, 1);
    let byte = |v: f32| (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    let pixels = measured.map.iter().map(|v| {
        let [r, g, b] = heat(*v).to_array();
        Color32::from_rgb(byte(r), byte(g), byte(b))
    });
    Ok((ColorImage::new(size, pixels.collect()), measured.value))
}

/// Draws the comparison over the picture.
pub(super) fn show(ctx: &Context, painter: &Painter, rect: Rect, studio: &mut Studio) {
    let (Some(kept), Some(now)) = (studio.insight.snapshot.clone(), studio.frame.clone()) else {
        studio.viewport.compared = Compared::default();
        return;
    };
    let state = &mut studio.viewport.compared;
    let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    match studio.insight.comparison {
        Comparison::Off => state.text = None,
        Comparison::Wipe(at) => {
            state.text = None;
            let is_same = state.kept.as_ref().is_some_and(|(_, of)| Arc::ptr_eq(of, &kept));
            if !is_same {
                let texture = ctx.load_texture("kept picture", image(&kept.picture), TextureOptions::LINEAR);
                state.kept = Some((texture, kept));
            }
            let Some((texture, _)) = &state.kept else { return };
            let edge = rect.left() + rect.width() * at;
            let part = Rect::from_min_max(rect.min, pos2(edge, rect.bottom()));
            let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(at, 1.0));
            painter.image(texture.id(), part, uv, Color32::WHITE);
            painter.vline(edge, rect.y_range(), Stroke::new(2.0, Color32::WHITE));
        }
        comparison => {
            let is_flip = comparison == Comparison::Flip;
            if let Some(task) = &state.task
                && let Some(result) = task.poll()
            {
                match result.unwrap_or_else(|fault| Err(fault.into())) {
                    Ok((image, mean)) => {
                        state.text = Some(match is_flip {
                            true => format!("Mean FLIP {mean:.4}: 0 is equal"),
                            false => format!("Mean difference {:.3} %", 100.0 * mean),
                        });
                        state.map = Some(ctx.load_texture("differences", image, TextureOptions::LINEAR));
                    }
                    Err(message) => (state.text, state.map) = (Some(message), None),
                }
                state.task = None;
            }
            let is_same = state.of.as_ref().is_some_and(|(a, b, flip)| {
                Arc::ptr_eq(a, &kept) && Arc::ptr_eq(b, &now) && *flip == is_flip
            });
            if !is_same && state.task.is_none() {
                state.of = Some((Arc::clone(&kept), Arc::clone(&now), is_flip));
                state.task =
                    Some(Task::start(ctx, move |_| differences(&kept.picture, &now.picture, is_flip)));
            }
            if let Some(map) = &state.map {
                painter.image(map.id(), rect, whole, Color32::WHITE);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(value: u8) -> Picture {
        Picture {
            width: 8,
            height: 4,
            linear: vec![[0.0, 0.0, 0.0, 1.0]; 32],
            display: vec![[value, value, value, 255]; 32],
            has_alpha: false,
            missing: 0,
            exposure: 0.0,
        }
    }

    #[test]
    fn equal_pictures_differ_by_nothing_and_others_by_their_mean() {
        for is_flip in [false, true] {
            assert_eq!(differences(&picture(90), &picture(90), is_flip).unwrap().1, 0.0);
        }
        let (_, mean) = differences(&picture(0), &picture(51), false).unwrap();
        assert!((mean - 0.2).abs() < 1e-9);
        assert!(differences(&picture(0), &picture(255), true).unwrap().1 > 0.5);
    }
}

//! Display colours for values that are not colours, as in PNG and JPEG files. EXR and HDR files keep the values.

use crate::color::{ColorScale, heat};
use crate::film::Picture;

/// The values of a pixel that hit something, divided by alpha.
fn straight([r, g, b, a]: [f32; 4]) -> Option<[f32; 3]> {
    let values = [r, g, b].map(|v| v / a);
    (a > 0.0 && values.iter().all(|v| v.is_finite())).then_some(values)
}

fn byte(v: f32) -> u8 {
    // The cast saturates; NaN becomes 0.
    (v * 255.0 + 0.5) as u8
}

fn heat_bytes(v: f32) -> [u8; 3] {
    heat(v).to_array().map(byte)
}

/// Sets the display colour of each pixel that hit something to a function of its values.
fn each(picture: &mut Picture, f: impl Fn([f32; 3]) -> [u8; 3]) {
    for (shown, linear) in picture.display.iter_mut().zip(&picture.linear) {
        if let Some(values) = straight(*linear) {
            let [r, g, b] = f(values);
            *shown = [r, g, b, byte(linear[3].min(1.0))];
        }
    }
}

/// The smallest and the largest value of a channel.
fn range(picture: &Picture, channel: usize) -> (f32, f32) {
    let values = picture.linear.iter().filter_map(|p| straight(*p)).map(|p| p[channel]);
    values.fold((f32::INFINITY, f32::NEG_INFINITY), |(least, most), v| (least.min(v), most.max(v)))
}

/// The position of a value in a range, 0 to 1; 0.5 for an empty range.
fn between(v: f32, (least, most): (f32, f32)) -> f32 {
    if most > least { (v - least) / (most - least) } else { 0.5 }
}

pub(super) fn depth(picture: &mut Picture) {
    let (near, far) = range(picture, 0);
    let near = near.max(far * 1e-6);
    let reciprocals = (1.0 / far, 1.0 / near);
    each(picture, |p| heat_bytes(between(1.0 / p[0], reciprocals)));
}

pub(super) fn position(picture: &mut Picture) {
    let ranges = [0, 1, 2].map(|c| range(picture, c));
    each(picture, |p| [0, 1, 2].map(|c| byte(between(p[c], ranges[c]))));
}

pub(super) fn uv(picture: &mut Picture) {
    let fraction = |v: f32| byte(v - v.floor());
    // A value of exactly 1 is the end of a texture that does not repeat, so it is shown as 1, not as 0.
    let shown = |v: f32| if v == 1.0 { 255 } else { fraction(v) };
    each(picture, |p| [shown(p[0]), shown(p[1]), 0]);
}

pub(super) fn ids(picture: &mut Picture) {
    each(picture, |p| {
        // Steps of the golden ratio around the hue circle: neighbouring IDs get different hues.
        let turns = f64::from(p[0]) * 0.618_033_988_749_895;
        let hue = ((turns - turns.floor()) * 6.0) as f32;
        let light = [0.95, 0.7, 0.85][(p[0] as u32 % 3) as usize];
        let band = |offset: f32| {
            let at = (hue + offset) % 6.0;
            light * (0.3 + 0.7 * ((at - 3.0).abs() - 1.0).clamp(0.0, 1.0))
        };
        [band(0.0), band(4.0), band(2.0)].map(byte)
    });
}

/// The first value as a heat map from 0 to the largest in the picture.
pub(super) fn heat_from_0(picture: &mut Picture) {
    let (_, most) = range(picture, 0);
    each(picture, |p| heat_bytes(between(p[0], (0.0, most))));
}

/// The scale of [`heat_from_0`].
pub(super) fn scale_from_0(picture: &Picture, unit: &'static str) -> ColorScale {
    let (_, most) = range(picture, 0);
    ColorScale::linear(0.0, f64::from(most.max(0.0)), unit)
}

/// The scale of [`depth`], whose colours are even in 1 / depth.
pub(super) fn scale_of_depth(picture: &Picture) -> Option<ColorScale> {
    let (near, far) = range(picture, 0);
    let near = f64::from(near.max(far * 1e-6));
    let far = f64::from(far);
    if !(near > 0.0 && far >= near && far.is_finite()) {
        return None;
    }
    let at = |place: f64| 1.0 / (1.0 / far + (1.0 / near - 1.0 / far) * place);
    let marks = [0.0, 0.25, 0.5, 0.75, 1.0].map(|place| (place as f32, at(place)));
    Some(ColorScale { unit: "scene units", marks: marks.into() })
}

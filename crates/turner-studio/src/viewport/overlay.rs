//! Lines and marks over the picture.

use std::sync::Arc;

use egui::{Color32, Painter, Rect, Stroke, pos2};
use turner::explain::{Kind, RayNode};
use turner::integrator::Prepared;
use turner::math::{Bounds, DVec2, DVec3};
use turner_live::engine::Stand;
use turner_live::pick;

use super::Placed;
use crate::cameras::position_of;
use crate::node::Node;
use crate::panels::rays::depth;
use crate::studio::Studio;

/// The colour of what is selected: also to the colour-blind apart from the picture by its dark outline.
pub(crate) const SELECTED: Color32 = Color32::from_rgb(255, 170, 40);

/// Selected objects whose bounds are drawn.
const MOST_SELECTED: usize = 50;

/// A checkerboard behind transparent pictures.
pub(super) fn checkerboard(painter: &Painter, rect: Rect) {
    painter.rect_filled(rect, 0.0, Color32::from_gray(110));
    let size = 12.0;
    let (columns, rows) = ((rect.width() / size) as usize, (rect.height() / size) as usize);
    for row in 0..=rows {
        for column in (row % 2..=columns).step_by(2) {
            let at = rect.min + egui::vec2(column as f32 * size, row as f32 * size);
            let square = Rect::from_min_size(at, egui::vec2(size, size)).intersect(rect);
            painter.rect_filled(square, 0.0, Color32::from_gray(140));
        }
    }
}

/// Where a point is seen.
pub(crate) fn seen(prepared: &Prepared, placed: Placed, p: DVec3) -> Option<egui::Pos2> {
    let view = &prepared.view;
    let seen = view.camera.project(&view.film, p, DVec2::splat(0.5))?;
    Some(placed.to_window([seen.place.x, seen.place.y]))
}

/// A segment as seen by the camera, in pieces, so that the part behind the camera is left out and lenses that bend lines
/// are followed.
pub(crate) fn segment(
    prepared: &Prepared,
    placed: Placed,
    from: DVec3,
    to: DVec3,
    mut line: impl FnMut([egui::Pos2; 2]),
) {
    const PIECES: usize = 48;
    let at = |i: usize| seen(prepared, placed, from + (to - from) * (i as f64 / PIECES as f64));
    let mut last = at(0);
    for i in 1..=PIECES {
        let next = at(i);
        if let (Some(a), Some(b)) = (last, next) {
            line([a, b]);
        }
        last = next;
    }
}

/// A line with a dark outline, which is visible on any picture.
pub(crate) fn line(painter: &Painter, ends: [egui::Pos2; 2], width: f32, color: Color32) {
    painter.line_segment(ends, Stroke::new(width + 2.0, Color32::from_black_alpha(130)));
    painter.line_segment(ends, Stroke::new(width, color));
}

pub(super) fn show(painter: &Painter, placed: Placed, studio: &mut Studio) {
    bvh(painter, placed, studio);
    rays(painter, placed, studio);
    let Some(frame) = &studio.frame else { return };
    let stand = &frame.stand;
    let prepared = &stand.prepared;
    for node in studio.selected().into_iter().take(MOST_SELECTED) {
        let Node::Object(i) = node else { continue };
        let Some(bounds) = pick::object_bounds(stand, i) else { continue };
        boxed(painter, placed, prepared, &bounds.corners(), SELECTED);
    }
    for (i, light) in studio.document.desc().lights.iter().enumerate() {
        let Some(at) = position_of(&light.value).and_then(|p| seen(prepared, placed, p)) else { continue };
        let is_selected = studio.selection == Some(Node::Light(i));
        let color = if is_selected { SELECTED } else { Color32::from_rgb(255, 240, 150) };
        painter.circle_stroke(at, 6.0, Stroke::new(3.5, Color32::from_black_alpha(150)));
        painter.circle_stroke(at, 6.0, Stroke::new(1.5, color));
        // What is selected differs in its form, too.
        if is_selected {
            painter.circle_filled(at, 3.0, color);
        }
    }
    if let Some([x, y]) = studio.viewport.explained {
        let at = placed.to_window([f64::from(x) + 0.5, f64::from(y) + 0.5]);
        for (from, to) in [
            ((-9.0, 0.0), (-3.0, 0.0)),
            ((3.0, 0.0), (9.0, 0.0)),
            ((0.0, -9.0), (0.0, -3.0)),
            ((0.0, 3.0), (0.0, 9.0)),
        ] {
            line(
                painter,
                [pos2(at.x + from.0, at.y + from.1), pos2(at.x + to.0, at.y + to.1)],
                1.5,
                Color32::WHITE,
            );
        }
    }
}

/// The edges of a box from its eight corners, numbered by their bits.
pub(crate) fn boxed(
    painter: &Painter,
    placed: Placed,
    prepared: &Prepared,
    corners: &[DVec3; 8],
    color: Color32,
) {
    for a in 0..8usize {
        for bit in [1, 2, 4] {
            if a & bit == 0 {
                segment(prepared, placed, corners[a], corners[a | bit], |ends| {
                    line(painter, ends, 1.2, color)
                });
            }
        }
    }
}

/// Boxes of the BVH that are drawn at once.
const MOST_BOXES: usize = 1500;

/// The boxes that were asked for last.
#[derive(Default)]
pub(super) struct Boxes {
    of: Option<(Arc<Stand>, u32)>,
    list: Vec<Bounds>,
}

fn bvh(painter: &Painter, placed: Placed, studio: &mut Studio) {
    let (Some(depth), Some(frame)) = (studio.insight.boxes, studio.frame.clone()) else { return };
    let boxes = &mut studio.viewport.boxes;
    let is_same = boxes.of.as_ref().is_some_and(|(of, at)| Arc::ptr_eq(of, &frame.stand) && *at == depth);
    if !is_same {
        boxes.list = frame.stand.prepared.scene.bvh_boxes(depth, MOST_BOXES);
        boxes.of = Some((Arc::clone(&frame.stand), depth));
    }
    let color = Color32::from_rgba_unmultiplied(120, 220, 255, 110);
    let prepared = &frame.stand.prepared;
    for bounds in &boxes.list {
        let seen = bounds.corners().map(|corner| seen(prepared, placed, corner));
        for a in 0..8usize {
            for bit in [1, 2, 4] {
                if let (0, Some(from), Some(to)) = (a & bit, seen[a], seen[a | bit]) {
                    painter.line_segment([from, to], Stroke::new(1.0, color));
                }
            }
        }
    }
}

/// Colours of rays; kinds also differ by their names in the tree.
fn color_of(kind: Kind) -> Color32 {
    match kind {
        Kind::Camera => Color32::WHITE,
        Kind::Reflected => Color32::from_rgb(90, 170, 255),
        Kind::Refracted => Color32::from_rgb(60, 220, 190),
        Kind::Diffuse => Color32::from_rgb(255, 140, 60),
        Kind::Glossy => Color32::from_rgb(190, 130, 255),
        Kind::Straight => Color32::from_rgb(200, 200, 200),
        Kind::Shadow => Color32::from_rgb(255, 230, 90),
    }
}

/// Rays that are drawn at most.
const MOST_RAYS: usize = 3000;

fn rays(painter: &Painter, placed: Placed, studio: &Studio) {
    let (Some(frame), Some(Ok(explanation))) = (&studio.frame, &studio.insight.explanation) else { return };
    let prepared = &frame.stand.prepared;
    let reach = prepared.scene.stats.bounds.map_or(10.0, |bounds| bounds.size().length());
    for (i, ray) in explanation.tree.nodes.iter().enumerate().take(MOST_RAYS) {
        if studio.insight.bounces.is_some_and(|most| depth(explanation, i) > most) {
            continue;
        }
        draw(painter, placed, prepared, ray, reach, studio.insight.marked == Some(i));
    }
}

fn draw(painter: &Painter, placed: Placed, prepared: &Prepared, ray: &RayNode, reach: f64, is_marked: bool) {
    let end = ray.to.unwrap_or(ray.from + ray.direction * ray.distance.unwrap_or(reach));
    let width = if is_marked { 4.0 } else { 1.8 };
    let color = color_of(ray.kind);
    let mut piece = 0;
    segment(prepared, placed, ray.from, end, |ends| {
        piece += 1;
        // Blocked shadow rays are dashed.
        if ray.open || piece % 2 == 0 {
            line(painter, ends, width, color);
        }
    });
    if let Some(at) = ray.to.and_then(|p| seen(prepared, placed, p)) {
        painter.circle_filled(at, if is_marked { 5.0 } else { 3.0 }, color);
    }
}

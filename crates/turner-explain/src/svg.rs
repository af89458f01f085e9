//! An explanation as SVG: the tree, and the rays in two views of the scene.

use turner::color::Spectrum;

use super::draw::{Views, xml};
use super::record::Explanation;
use super::rows::{Row, light_remark, rows};
use super::shade::Display;
use super::style;
use super::views::WIDTH;
use turner::explain::number::{percent, rays, short, short_color as color};
use turner::explain::prune::shown;
use turner::explain::{SampleTree, over};

const LEFT: f64 = 24.0;
const TREE: f64 = 600.0;
const STEP: f64 = 20.0;
const RAY_ROW: f64 = 44.0;
const LIGHT_ROW: f64 = 24.0;
const TOP: f64 = 108.0;
/// Width of the bar that shows a ray's fraction of the sample.
const BAR: f64 = 84.0;

/// At most `budget` rays of each sample are drawn.
pub(crate) fn of(
    e: &Explanation<'_>,
    trees: &[SampleTree],
    views: &Views,
    display: &Display<'_>,
    budget: usize,
) -> String {
    let mut body = String::new();
    let mut y = TOP;
    for tree in trees {
        let shown = shown(&tree.nodes, budget, e.path_of.is_some());
        let rows = rows(tree, &shown);
        let top = y;
        if trees.len() > 1 || e.sample_count > 1 {
            let [px, py] = tree.pixel_position;
            let at =
                format!("sample {} of {}, at ({}, {})", tree.number, e.sample_count, short(px), short(py));
            body += &format!("<text class=\"sub\" x=\"{LEFT}\" y=\"{}\">{at}</text>\n", y + 8.0);
            y += 24.0;
        }
        tree_rows(&mut body, tree, &rows, display, &mut y);
        let mut notes = tree.remarks.clone();
        if shown.elsewhere.rays > 0 {
            let name = e.path_of.as_deref().unwrap_or_default();
            notes.push(format!("{} do not touch \"{name}\"", rays(shown.elsewhere.rays)));
        }
        for note in notes {
            body += &format!("<text class=\"dim\" x=\"{LEFT}\" y=\"{}\">{}</text>\n", y + 12.0, xml(&note));
            y += 20.0;
        }
        y = sums(&mut body, tree, display, y + 20.0);
        let views_height = views.svg(&mut body, tree, &shown, LEFT + TREE + 24.0, top);
        y = (top + views_height).max(y) + 28.0;
    }
    let width = LEFT + TREE + 24.0 + WIDTH + LEFT;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {y:.0}\" width=\"{width}\" height=\"{y:.0}\" \
         font-family=\"system-ui, sans-serif\">\n<title>{}</title>\n<style>{}</style>\n<rect class=\"page\" width=\"100%\" height=\"100%\"/>\n",
        xml(&title(e)),
        style::of_drawing()
    );
    out += &format!(
        "<rect class=\"swatch\" x=\"{LEFT}\" y=\"26\" width=\"54\" height=\"54\" rx=\"8\" fill=\"{}\"/>\n",
        display.hex(e.color)
    );
    let x = LEFT + 68.0;
    out += &format!("<text class=\"title\" x=\"{x}\" y=\"42\">{}</text>\n", xml(&title(e)));
    let equal = match (e.exact, e.sample_count) {
        (false, _) => "THE CONTRIBUTIONS DO NOT SUM TO THE SAMPLE",
        (true, 1) => "the contributions of the rays sum to the pixel to the last bit",
        (true, _) => "the rays of the sample shown sum to the sample to the last bit",
    };
    let line = format!("{}, {}", color(e.color), e.averaging);
    out += &format!("<text class=\"sub\" x=\"{x}\" y=\"62\">{}</text>\n", xml(&cut(&line, 170.0)));
    out += &format!("<text class=\"sub\" x=\"{x}\" y=\"80\">{equal}</text>\n");
    out + &body + "</svg>\n"
}

/// `pixel 12,7 of scene.toml`
pub(crate) fn title(e: &Explanation<'_>) -> String {
    format!("Pixel {},{} of {} ({})", e.pixel[0], e.pixel[1], e.scene, e.integrator)
}

fn tree_rows(out: &mut String, tree: &SampleTree, rows: &[Row], display: &Display<'_>, y: &mut f64) {
    // The swatches of the rows above, by depth: branches start there.
    let mut above: Vec<f64> = Vec::new();
    for row in rows {
        let depth = row.depth();
        let x = LEFT + STEP * depth.min(14) as f64;
        let height = if matches!(row, Row::Ray { .. }) { RAY_ROW } else { LIGHT_ROW };
        let center_y = *y + if height == RAY_ROW { 16.0 } else { 10.0 };
        above.truncate(depth);
        if let Some(from) = above.last() {
            let bend = x - STEP + 8.0;
            *out += &format!(
                "<path class=\"branch\" d=\"M{bend:.1} {from:.1}V{:.1}q0 6 6 6H{:.1}\"/>\n",
                center_y - 6.0,
                x - 1.0
            );
        }
        let room = (LEFT + TREE - BAR - x - 40.0) / 6.4;
        match row {
            Row::Ray { node: i, .. } => {
                above.push(center_y + 12.0);
                let node = &tree.nodes[*i];
                *out += &format!(
                    "<rect class=\"swatch\" x=\"{x}\" y=\"{:.1}\" width=\"18\" height=\"24\" rx=\"5\" fill=\"{}\"/>\n",
                    center_y - 12.0,
                    display.hex(tree.radiance(node))
                );
                let fraction = tree.fraction(node.total);
                let right = LEFT + TREE;
                *out += &format!(
                    "<rect class=\"rail\" x=\"{:.1}\" y=\"{:.1}\" width=\"{BAR}\" height=\"6\" rx=\"3\"/>\n",
                    right - BAR,
                    center_y - 9.0
                );
                if fraction > 0.0 {
                    *out += &format!(
                        "<rect class=\"bar {}\" x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"6\" rx=\"3\"/>\n",
                        node.kind.word(),
                        right - BAR,
                        center_y - 9.0,
                        (fraction * BAR).max(1.5)
                    );
                }
                *out += &format!(
                    "<text class=\"dim\" x=\"{right:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>\n",
                    center_y + 14.0,
                    percent(fraction)
                );
                let material = node.material.as_deref().map_or(String::new(), |m| format!(" ({m})"));
                let head = format!("{}{material}", node.target);
                *out += &format!(
                    "<text x=\"{:.1}\" y=\"{:.1}\"><tspan class=\"kind {}\">{} {}</tspan> <tspan class=\"name\">{}</tspan></text>\n",
                    x + 26.0,
                    center_y - 1.0,
                    node.kind.word(),
                    node.badge,
                    node.kind.title(),
                    xml(&cut(&head, room - 12.0))
                );
                let remark =
                    if node.remark.is_empty() { String::new() } else { format!("{} · ", node.remark) };
                let line = format!(
                    "{remark}weight {} · radiance {}",
                    color(node.weight),
                    color(tree.radiance(node))
                );
                *out += &format!(
                    "<text class=\"dim\" x=\"{:.1}\" y=\"{:.1}\">{}</text>\n",
                    x + 26.0,
                    center_y + 14.0,
                    xml(&cut(&line, room + 6.0))
                );
            }
            Row::Light { nodes, added, .. } => {
                let open = nodes.iter().any(|&n| tree.nodes[n].open);
                let class = if open { "lit" } else { "unlit" };
                *out += &format!(
                    "<circle class=\"{class}\" cx=\"{:.1}\" cy=\"{center_y:.1}\" r=\"5\"/>\n",
                    x + 8.0
                );
                let line = light_line(tree, nodes, *added);
                *out += &format!(
                    "<text class=\"small\" x=\"{:.1}\" y=\"{:.1}\">{}</text>\n",
                    x + 20.0,
                    center_y + 4.0,
                    xml(&cut(&line, room))
                );
            }
            Row::Hidden { hidden, .. } => {
                let line =
                    format!("… {} with a sum of {} not shown", rays(hidden.rays), color(hidden.contribution));
                *out += &format!(
                    "<text class=\"dim\" x=\"{:.1}\" y=\"{:.1}\">{}</text>\n",
                    x + 4.0,
                    center_y + 4.0,
                    xml(&line)
                );
            }
        }
        *y += height;
    }
}

/// `point light #1: lit · adds [r, g, b]`
fn light_line(tree: &SampleTree, nodes: &[usize], added: Spectrum) -> String {
    let sum = if added.is_black() { String::new() } else { format!(" · adds {}", color(added)) };
    format!("{}: {}{sum}", tree.nodes[nodes[0]].target, light_remark(tree, nodes))
}

/// The sum as a bar: a segment for the contribution of each ray without its descendants, in the colour that it returns.
fn sums(out: &mut String, tree: &SampleTree, display: &Display<'_>, y: f64) -> f64 {
    let mut parts: Vec<(usize, Spectrum)> = Vec::new();
    for (node, _, part) in tree.parts.iter().filter(|(_, _, part)| !part.is_black()) {
        match parts.last_mut() {
            Some((last, sum)) if last == node => *sum += *part,
            _ => parts.push((*node, *part)),
        }
    }
    let total: f64 = parts.iter().map(|(_, part)| tree.fraction(*part)).sum();
    if parts.is_empty() || total <= 0.0 {
        return y;
    }
    *out += &format!(
        "<text class=\"dim\" x=\"{LEFT}\" y=\"{y:.1}\">contribution of each ray without its descendants</text>\n"
    );
    let (mut x, y) = (LEFT, y + 8.0);
    for (node, part) in parts {
        let width = TREE * tree.fraction(part) / total;
        // Segments below 0.3 pixels are not visible.
        if width >= 0.3 {
            let weight = tree.nodes.get(node).map_or(Spectrum::WHITE, |n| n.weight);
            *out += &format!(
                "<rect class=\"swatch\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"22\" fill=\"{}\"/>\n",
                display.hex(over(part, weight))
            );
        }
        if width >= 14.0 {
            *out += &format!(
                "<text class=\"tiny\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>\n",
                x + 0.5 * width,
                y + 34.0,
                tree.nodes.get(node).map_or(0, |n| n.badge)
            );
        }
        x += width;
    }
    y + 42.0
}

/// Shortens a line to the room, with … at the end.
fn cut(text: &str, room: f64) -> String {
    let room = room.max(8.0) as usize;
    if text.chars().count() <= room {
        return text.to_owned();
    }
    let mut out: String = text.chars().take(room.saturating_sub(1)).collect();
    out.push('…');
    out
}

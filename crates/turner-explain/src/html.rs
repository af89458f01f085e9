//! An explanation as a self-contained HTML page: a foldable tree, linked with the rays in the views of the scene.

use turner::color::Spectrum;

use super::draw::{Views, xml};
use super::record::Explanation;
use super::rows::{Row, light_remark, rows};
use super::shade::Display;
use super::style;
use super::svg::title;
use super::views::WIDTH;
use turner::explain::number::{color, exact, number, percent, rays, short, short_color};
use turner::explain::prune::{Shown, shown};
use turner::explain::{RayNode, SampleTree};

const SCRIPT: &str = include_str!("page.js");

/// Largest indentation, levels.
const DEEPEST: usize = 24;

/// At most `budget` rays of each sample are on the page.
pub(crate) fn of(
    e: &Explanation<'_>,
    trees: &[SampleTree],
    views: &Views,
    display: &Display<'_>,
    budget: usize,
) -> String {
    let name = xml(&title(e));
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>{name}</title>\n\
         <style>{}</style>\n</head>\n<body>\n{}<script>//<![CDATA[\n{SCRIPT}//]]>\n</script>\n</body>\n</html>\n",
        style::of_page(),
        body(e, trees, views, display, budget)
    )
}

/// The contents of the page's body, without its script.
pub(crate) fn body(
    e: &Explanation<'_>,
    trees: &[SampleTree],
    views: &Views,
    display: &Display<'_>,
    budget: usize,
) -> String {
    let name = xml(&title(e));
    let mut out = "<header>\n".to_owned();
    out += &format!("<span class=\"big\" style=\"background:{}\"></span>\n<div>\n", display.hex(e.color));
    out += &format!("<h1>{name}</h1>\n<p><b>{}</b> · {}</p>\n", exact(e.color), xml(&e.averaging));
    let equal = if e.exact {
        "The contributions of the rays of each sample shown sum to the sample, equal to the last bit."
    } else {
        "THE CONTRIBUTIONS DO NOT SUM TO THE SAMPLE: this is a bug in Turner, please report it."
    };
    let choice = e.choice.as_deref().map_or(String::new(), |c| format!(" · {}", xml(c)));
    out += &format!("<p class=\"dim\">{equal}{choice}</p>\n</div>\n</header>\n");
    if trees.len() > 1 {
        samples(&mut out, trees, display);
    }
    let most =
        trees.iter().max_by(|a, b| contribution(a).total_cmp(&contribution(b)).then(b.number.cmp(&a.number)));
    let first = most.map(|t| t.number);
    for tree in trees {
        sample(&mut out, e, tree, views, display, budget, Some(tree.number) == first);
    }
    out + "<footer class=\"dim\">Click a ray to show its details; the triangle folds its descendants. Point at a ray or an object to highlight it in the tree and in the views.</footer>\n"
}

fn contribution(tree: &SampleTree) -> f64 {
    tree.weight * f64::from(tree.sum.map(f32::abs).max_component())
}

/// A button for each sample.
fn samples(out: &mut String, trees: &[SampleTree], display: &Display<'_>) {
    *out += "<nav>\n";
    for tree in trees {
        let [x, y] = tree.pixel_position.map(short);
        *out += &format!(
            "<button type=\"button\" data-sample=\"{0}\" title=\"sample {0} at ({x}, {y}), weight {1}\"><i style=\"background:{2}\"></i>{0}</button>\n",
            tree.number,
            number(tree.weight),
            display.hex(tree.sum)
        );
    }
    *out += "</nav>\n";
}

fn sample(
    out: &mut String,
    e: &Explanation<'_>,
    tree: &SampleTree,
    views: &Views,
    display: &Display<'_>,
    budget: usize,
    is_first: bool,
) {
    let shown = shown(&tree.nodes, budget, e.path_of.is_some());
    let hidden = if is_first { "" } else { " hidden=\"hidden\"" };
    *out += &format!("<section data-sample=\"{}\"{hidden}>\n<div class=\"tree\">\n", tree.number);
    let [x, y] = tree.pixel_position.map(number);
    *out += &format!(
        "<h2>Sample {} of {} <span class=\"dim\">at ({x}, {y}), weight {}</span></h2>\n",
        tree.number,
        e.sample_count,
        number(tree.weight)
    );
    for row in rows(tree, &shown) {
        write_row(out, tree, &row, display);
    }
    if shown.elsewhere.rays > 0 {
        let name = xml(e.path_of.as_deref().unwrap_or_default());
        *out += &format!(
            "<p class=\"dim\">{} with a sum of {} do not touch “{name}”</p>\n",
            rays(shown.elsewhere.rays),
            color(shown.elsewhere.contribution)
        );
    }
    if tree.unrecorded > 0 {
        *out += &format!(
            "<p class=\"dim\">{} more are part of the sum, but not recorded</p>\n",
            rays(tree.unrecorded)
        );
    }
    for remark in &tree.remarks {
        *out += &format!("<p class=\"dim\">{}</p>\n", xml(remark));
    }
    sums(out, tree, &shown, display);
    *out += "</div>\n<div class=\"views\">\n";
    *out += &format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {:.0}\" font-family=\"system-ui, sans-serif\">\n",
        views.height()
    );
    views.svg(out, tree, &shown, 0.0, 0.0);
    *out += "</svg>\n</div>\n</section>\n";
}

fn swatch(display: &Display<'_>, c: Spectrum) -> String {
    format!("<i style=\"background:{}\"></i>", display.hex(c))
}

fn details(out: &mut String, node: &RayNode) {
    *out += "<dl>";
    for term in &node.terms {
        *out += &format!("<dt>{}</dt><dd>{}</dd>", xml(term.name), xml(&term.text()));
    }
    *out += "</dl>\n";
}

fn write_row(out: &mut String, tree: &SampleTree, row: &Row, display: &Display<'_>) {
    let depth = row.depth();
    let style = format!("data-depth=\"{depth}\" style=\"--d:{}\"", depth.min(DEEPEST));
    match row {
        Row::Ray { node: i, .. } => {
            let node = &tree.nodes[*i];
            let material =
                node.material.as_deref().map_or(String::new(), |m| format!(" <em>{}</em>", xml(m)));
            let object = node.primitive.map_or(String::new(), |p| format!(" data-object=\"{p}\""));
            let remark = if node.remark.is_empty() {
                String::new()
            } else {
                format!(" <span class=\"tag\">{}</span>", xml(&node.remark))
            };
            let (word, title) = (node.kind.word(), node.kind.title());
            *out += &format!("<details class=\"row\" data-ray=\"{i}\"{object} {style}>\n<summary>");
            *out += "<button type=\"button\" class=\"fold\" title=\"fold\">▾</button>";
            *out += &swatch(display, tree.radiance(node));
            *out += &format!(
                "<span class=\"what\"><span class=\"kind {word}\">{} {title}</span> <b>{}</b>{material}{remark}</span>",
                node.badge,
                xml(&node.target)
            );
            *out += &format!(
                "<span class=\"sum\"><span title=\"weight (throughput)\">× {}</span><span class=\"rail\" title=\"contribution {}\"><span class=\"bar {word}\" \
                 style=\"width:{:.1}%\"></span></span><span class=\"fraction\">{}</span></span></summary>\n",
                short_color(node.weight),
                color(node.total),
                100.0 * tree.fraction(node.total),
                percent(tree.fraction(node.total))
            );
            details(out, node);
            *out += "</details>\n";
        }
        Row::Light { nodes, added, .. } => {
            let (first, open) = (&tree.nodes[nodes[0]], nodes.iter().any(|&n| tree.nodes[n].open));
            let numbers: Vec<String> = nodes.iter().map(usize::to_string).collect();
            let object = match (&nodes[..], first.primitive) {
                ([_], Some(p)) => format!(" data-object=\"{p}\""),
                _ => String::new(),
            };
            *out += &format!(
                "<details class=\"row light\" data-ray=\"{}\"{object} {style}>\n<summary><span class=\"light-mark {}\"></span>",
                numbers.join(" "),
                if open { "on" } else { "off" }
            );
            *out += &format!("<span>{}: {}</span>", xml(&first.target), xml(&light_remark(tree, nodes)));
            *out += &format!("<span class=\"sum\">{}</span></summary>\n", short_color(*added));
            details(out, first);
            *out += "</details>\n";
        }
        Row::Hidden { hidden, .. } => {
            *out += &format!(
                "<div class=\"row dim\" {style}>… {} with a sum of {} not shown; --all shows them</div>\n",
                rays(hidden.rays),
                color(hidden.contribution)
            );
        }
    }
}

fn sums(out: &mut String, tree: &SampleTree, shown: &Shown, display: &Display<'_>) {
    const MOST: usize = 60;
    *out += "<table>\n";
    let mut count = 0;
    for (node, what, part) in &tree.parts {
        if part.is_black() || !shown.nodes[*node] || count >= MOST {
            continue;
        }
        count += 1;
        let hit = tree.nodes.get(*node).filter(|n| n.traced && n.target != *what);
        let target = hit.map_or(String::new(), |n| format!("of {}", xml(&n.target)));
        *out += &format!(
            "<tr data-ray=\"{node}\"><td>{}</td><td>{}</td><td>{} {target}</td><td>{}</td></tr>\n",
            swatch(display, *part),
            tree.nodes.get(*node).map_or(0, |n| n.badge),
            xml(what),
            exact(*part)
        );
    }
    let rest = tree.parts.len() - count;
    if rest > 0 {
        *out += &format!(
            "<tr class=\"dim\"><td></td><td></td><td>{rest} more terms, some of them black</td><td></td></tr>\n"
        );
    }
    *out += &format!(
        "<tr class=\"total\"><td>{}</td><td></td><td>sum</td><td>{}</td></tr>\n",
        swatch(display, tree.sum),
        exact(tree.sum)
    );
    let rendered = tree.rendered;
    let equal = if tree.exact { "equal to the last bit" } else { "NOT EQUAL" };
    *out += &format!(
        "<tr class=\"total\"><td>{}</td><td></td><td>sample as rendered</td><td>{}<br/><span class=\"dim\">{equal}</span></td></tr>\n</table>\n",
        swatch(display, rendered),
        exact(rendered)
    );
}

//! Draws the rays of a sample and the objects that they hit, as SVG.

use turner::explain::prune::Shown;
use turner::explain::{Kind, Names, RayNode, SampleTree};
use turner::scene::Outline;

use super::views::{Figure, Point, View, WIDTH, touched, views};

/// The two views of the scene, the same for all samples.
pub(crate) struct Views {
    views: [View; 2],
    /// Objects with their names.
    objects: Vec<(u32, Outline, String)>,
}

/// Most objects that are drawn.
const OBJECTS: usize = 200;

/// Escapes text for XML and HTML, also within quotes. Control characters, which both forbid, become U+FFFD.
pub(crate) fn xml(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '\'' => out += "&#39;",
            '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            c if c.is_control() => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

impl Views {
    pub(crate) fn new(names: &Names<'_>, trees: &[SampleTree]) -> Views {
        let mut ids = touched(trees);
        ids.truncate(OBJECTS);
        let outlines = names.prepared.scene.outlines(&ids);
        let name = |id: u32| {
            let mut hits = trees.iter().flat_map(|t| &t.nodes).filter(|n| n.primitive == Some(id));
            names.object(id, hits.next().map_or("object", |n| n.shape))
        };
        let objects: Vec<(u32, Outline, String)> =
            ids.iter().zip(outlines).filter_map(|(&id, o)| Some((id, o?, name(id)))).collect();
        let only: Vec<Outline> = objects.iter().map(|(_, o, _)| o.clone()).collect();
        Views { views: views(&names.prepared.view, trees, &only), objects }
    }

    /// Height of both views with their titles.
    pub(crate) fn height(&self) -> f64 {
        self.views.iter().map(|v| v.height + 26.0).sum()
    }

    /// Draws both views, one below the other, and returns their height.
    pub(crate) fn svg(&self, out: &mut String, tree: &SampleTree, shown: &Shown, x: f64, y: f64) -> f64 {
        let mut top = y;
        for (i, view) in self.views.iter().enumerate() {
            let id = format!("clip-{}-{i}", tree.number);
            *out += &format!("<g transform=\"translate({x:.1} {:.1})\">\n", top + 18.0);
            *out += &format!("<text class=\"caption\" x=\"2\" y=\"-6\">{}</text>\n", view.name);
            let size = format!("width=\"{WIDTH}\" height=\"{:.1}\"", view.height);
            *out += &format!("<clipPath id=\"{id}\"><rect {size} rx=\"8\"/></clipPath>\n");
            *out += &format!("<rect class=\"view\" {size} rx=\"8\"/>\n<g clip-path=\"url(#{id})\">\n");
            self.objects_of(out, view);
            self.rays(out, view, tree, shown);
            *out += "</g>\n</g>\n";
            top += view.height + 26.0;
        }
        top - y
    }

    fn objects_of(&self, out: &mut String, view: &View) {
        let mut labels: Vec<(Point, f64)> = Vec::new();
        let mut texts = String::new();
        for (id, outline, name) in &self.objects {
            let Some(figure) = view.figure(outline) else { continue };
            let data = format!("class=\"object\" data-object=\"{id}\"");
            let title = format!("<title>{}</title>", xml(name));
            // Position of the label: inside, near the top.
            let at = match &figure {
                Figure::Circle([x, y], r) => {
                    *out += &format!(
                        "<circle {data} cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{r:.2}\">{title}</circle>\n"
                    );
                    [
                        *x,
                        if *r < 400.0 { y - r + 16.0 } else { (y - r).clamp(14.0, view.height - 6.0) + 14.0 },
                    ]
                }
                Figure::Polygon(points) => {
                    let list: Vec<String> = points.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
                    *out += &format!("<polygon {data} points=\"{}\">{title}</polygon>\n", list.join(" "));
                    let n = points.len() as f64;
                    let x = points.iter().map(|p| p[0]).sum::<f64>() / n;
                    [x, points.iter().map(|p| p[1]).fold(f64::INFINITY, f64::min) + 14.0]
                }
                Figure::Line([x0, y0], [x1, y1]) => {
                    *out += &format!(
                        "<line {data} x1=\"{x0:.1}\" y1=\"{y0:.1}\" x2=\"{x1:.1}\" y2=\"{y1:.1}\">{title}</line>\n"
                    );
                    let x = x0.max(*x1).min(WIDTH) - 50.0;
                    [x, if y0 == y1 { y0 + 14.0 } else { y0.max(*y1) }]
                }
            };
            let half = 3.2 * name.chars().count().min(24) as f64 + 4.0;
            let x = at[0].clamp(half + 4.0, (WIDTH - half - 4.0).max(half + 4.0));
            let mut y = at[1].clamp(14.0, view.height - 6.0);
            for _ in 0..6 {
                let clear = |(other, reach): &(Point, f64)| {
                    (other[0] - x).abs() > reach + half || (other[1] - y).abs() > 12.0
                };
                if labels.iter().all(clear) {
                    break;
                }
                y += 13.0;
            }
            if y < view.height && labels.len() < 24 {
                labels.push(([x, y], half));
                let mut shown: String = name.chars().take(24).collect();
                if shown.len() < name.len() {
                    shown.push('…');
                }
                texts += &format!(
                    "<text class=\"label\" x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"middle\">{}</text>\n",
                    xml(&shown)
                );
            }
        }
        *out += &texts;
    }

    fn rays(&self, out: &mut String, view: &View, tree: &SampleTree, shown: &Shown) {
        let visible = || tree.nodes.iter().enumerate().filter(|(i, _)| shown.nodes[*i]);
        // Shadow rays are drawn first, below the others.
        for (i, node) in visible().filter(|(_, n)| n.kind == Kind::Shadow && n.traced) {
            let light = node.light.map(|(light, _)| light);
            let is_same_light = |j: usize| {
                let other = tree.nodes.get(j);
                other.is_some_and(|n| n.parent == node.parent && n.light.map(|(l, _)| l) == light)
            };
            // Shadow rays to the sample points of one light are consecutive.
            let many = is_same_light(i + 4) || i >= 4 && is_same_light(i - 4);
            ray(out, view, i, node, if many { Mark::Faint } else { Mark::None });
        }
        for (i, node) in visible().filter(|(_, n)| n.kind != Kind::Shadow && n.traced) {
            ray(out, view, i, node, Mark::Number(node.badge));
        }
        let lights = visible().filter(|(_, n)| n.kind == Kind::Shadow && n.open);
        let mut marks: Vec<Point> = Vec::new();
        for p in lights.filter_map(|(_, n)| n.to).map(|p| view.point(p)) {
            let near = |o: &Point| (o[0] - p[0]).abs() < 3.0 && (o[1] - p[1]).abs() < 3.0;
            if marks.len() < 64 && !marks.iter().any(near) {
                *out += &format!(
                    "<circle class=\"light-mark\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"5\"/>\n",
                    p[0], p[1]
                );
                marks.push(p);
            }
        }
    }
}

/// How a ray is marked.
#[derive(Clone, Copy, PartialEq)]
enum Mark {
    None,
    /// One of many shadow rays to a light: drawn faintly.
    Faint,
    Number(usize),
}

/// Draws a ray as a line with an arrow at its centre, and its number.
fn ray(out: &mut String, view: &View, i: usize, node: &RayNode, mark: Mark) {
    let Some(([x0, y0], [x1, y1])) = view.segment(node.from, node.direction, node.to) else { return };
    let blocked = if node.open { "" } else { " blocked" };
    let faint = if mark == Mark::Faint { " faint" } else { "" };
    let (dx, dy) = (x1 - x0, y1 - y0);
    let length = (dx * dx + dy * dy).sqrt();
    *out += &format!("<g class=\"ray {}{blocked}{faint}\" data-ray=\"{i}\">", node.kind.word());
    *out += &format!("<title>{} → {}</title>", node.kind.title(), xml(&node.target));
    // A wide transparent line, which is easier to point at.
    *out += &format!("<path class=\"reach\" d=\"M{x0:.1} {y0:.1}L{x1:.1} {y1:.1}\"/>");
    *out += &format!("<path class=\"line\" d=\"M{x0:.1} {y0:.1}L{x1:.1} {y1:.1}\"/>");
    if length > 16.0 && mark != Mark::Faint {
        let (ux, uy) = (dx / length, dy / length);
        let (mx, my) = (x0 + 0.55 * dx, y0 + 0.55 * dy);
        let corner = |back: f64, side: f64| {
            format!("{:.1} {:.1}", mx - back * ux - side * uy, my - back * uy + side * ux)
        };
        let size = if node.kind == Kind::Shadow { 3.0 } else { 4.2 };
        *out += &format!(
            "<path class=\"head\" d=\"M{}L{}L{}Z\"/>",
            corner(-size, 0.0),
            corner(size, size),
            corner(size, -size)
        );
        if let Mark::Number(number) = mark
            && length > 40.0
        {
            let (nx, ny) = (mx + 10.0 * uy.abs() + 2.0, my - 9.0 * ux.abs() + 2.0);
            *out += &format!("<text class=\"number\" x=\"{nx:.1}\" y=\"{ny:.1}\">{number}</text>");
        }
    }
    if let (
        Some(_),
        Kind::Camera | Kind::Reflected | Kind::Refracted | Kind::Diffuse | Kind::Glossy | Kind::Straight,
    ) = (node.to, node.kind)
    {
        *out += &format!("<circle class=\"dot\" cx=\"{x1:.1}\" cy=\"{y1:.1}\" r=\"2.6\"/>");
    }
    if node.kind == Kind::Camera {
        *out += &format!("<circle class=\"camera-mark\" cx=\"{x0:.1}\" cy=\"{y0:.1}\" r=\"5\"/>");
    }
    *out += "</g>\n";
}

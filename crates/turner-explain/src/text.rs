//! An explanation as text: the tree of rays, and the terms of the sum.

use turner::color::Spectrum;
use turner::schema::error::escape;

use super::record::Explanation;
use super::rows::light_remark;
use super::shade::Display;
use turner::explain::number::{color, exact, number, rays};
use turner::explain::prune::{Hidden, Shown, shown};
use turner::explain::{Kind, RayNode, SampleTree};

/// How the text is written.
pub(crate) struct Style<'a> {
    /// Whether to print colours.
    pub(crate) colors: bool,
    pub(crate) display: Display<'a>,
    /// Most rays per tree.
    pub(crate) budget: usize,
}

/// Most samples that are listed one by one.
const LISTED: usize = 16;
/// Most terms of the sum that are listed one by one.
const TERMS: usize = 12;

impl Style<'_> {
    /// A patch of the colour and a space; empty without colours.
    fn swatch(&self, c: Spectrum) -> String {
        if !self.colors {
            return String::new();
        }
        let [r, g, b] = self.display.rgb(c);
        format!("\x1b[48;2;{r};{g};{b}m  \x1b[0m ")
    }

    fn paint(&self, code: &str, text: &str) -> String {
        if self.colors { format!("\x1b[{code}m{text}\x1b[0m") } else { text.to_owned() }
    }

    fn dim(&self, text: &str) -> String {
        self.paint("2", text)
    }

    fn bold(&self, text: &str) -> String {
        self.paint("1", text)
    }
}

pub(crate) fn of(e: &Explanation<'_>, trees: &[SampleTree], style: &Style<'_>) -> String {
    let [width, height] = e.size;
    let mut out = format!(
        "{}: pixel {},{} of {width}x{height}, integrator \"{}\", seed {}\n",
        escape(&e.scene),
        e.pixel[0],
        e.pixel[1],
        e.integrator,
        e.seed
    );
    out += &format!("pixel {}{}", style.swatch(e.color), exact(e.color));
    let alpha = e.alpha;
    out += &if alpha == 1.0 { "\n".to_owned() } else { format!(", alpha {alpha}\n") };
    out += &format!("  {}\n", e.averaging);
    if e.samples.len() > 1 {
        samples(&mut out, e, trees, style);
    }
    if let Some(choice) = &e.choice {
        out += &format!("  {}\n", escape_line(choice));
    }
    for tree in trees {
        sample(&mut out, e, tree, style);
    }
    out
}

fn escape_line(text: &str) -> String {
    text.chars()
        .flat_map(|c| if c.is_control() { c.escape_default().collect::<Vec<_>>() } else { vec![c] })
        .collect()
}

fn samples(out: &mut String, e: &Explanation<'_>, trees: &[SampleTree], style: &Style<'_>) {
    let is_shown = |i: usize| trees.iter().any(|t| t.number == i);
    let mut left = 0;
    for (i, s) in e.samples.iter().enumerate() {
        if i >= LISTED && !is_shown(i) {
            left += 1;
            continue;
        }
        let mark = if is_shown(i) { "*" } else { " " };
        let [x, y] = s.pixel_position.map(number);
        let c = s.color;
        *out += &format!(
            " {mark} sample {i:<4} {}{}  at ({x}, {y}), weight {}\n",
            style.swatch(c),
            exact(c),
            number(s.weight)
        );
    }
    let unlisted = e.sample_count - e.samples.len() as u64 + left;
    if unlisted > 0 {
        *out += &style.dim(&format!("   … and {unlisted} more samples\n"));
    }
}

fn sample(out: &mut String, e: &Explanation<'_>, tree: &SampleTree, style: &Style<'_>) {
    let [x, y] = tree.pixel_position.map(number);
    let title = format!("sample {} of {}", tree.number, e.sample_count);
    *out += &format!("\n{} at ({x}, {y})\n", style.bold(&title));
    let shown = shown(&tree.nodes, style.budget, e.path_of.is_some());
    Branches { tree, style, shown: &shown, out }.write();
    if shown.elsewhere.rays > 0 {
        let name = escape(e.path_of.as_deref().unwrap_or_default());
        let (what, sum) = (rays(shown.elsewhere.rays), short_sum(shown.elsewhere));
        *out += &style.dim(&format!("… {what} with a sum of {sum} do not touch \"{name}\"\n"));
    }
    if tree.unrecorded > 0 {
        let what = rays(tree.unrecorded);
        *out += &style.dim(&format!("… {what} more are part of the sum, but not recorded\n"));
    }
    for remark in &tree.remarks {
        *out += &format!("{remark}\n");
    }
    sums(out, tree, &shown, style);
}

/// The summed contribution of hidden rays.
fn short_sum(hidden: Hidden) -> String {
    color(hidden.contribution)
}

fn sums(out: &mut String, tree: &SampleTree, shown: &Shown, style: &Style<'_>) {
    out.push('\n');
    let listed = |(node, ..): &&(usize, &str, Spectrum)| tree.parts.len() <= TERMS || shown.nodes[*node];
    let (mut count, mut last) = (0, 0);
    for (node, what, part) in tree.parts.iter().filter(listed) {
        if tree.parts.len() > TERMS && (part.is_black() || count >= 4 * TERMS) {
            continue;
        }
        count += 1;
        last = last.max(*node);
        // Rays that were not traced have no hit to name.
        let hit = tree.nodes.get(*node).filter(|n| n.traced && n.target != *what);
        let of = hit.map_or(String::new(), |n| format!(" of {}", escape(&n.target)));
        *out += &format!("  {}{:<40} {}\n", style.swatch(*part), format!("{what}{of}"), exact(*part));
    }
    let rest = tree.parts.len() - count;
    if rest > 0 {
        *out += &style.dim(&format!("  … and {rest} more terms\n"));
    }
    *out += &format!("  {}{:<40} {}\n", style.swatch(tree.sum), "sum", exact(tree.sum));
    let equal = match (tree.exact, tree.rendered.is_finite()) {
        (_, false) => "non-finite: omitted from the picture",
        (true, true) => "equal to the last bit",
        (false, true) => "NOT EQUAL",
    };
    let rendered = tree.rendered;
    let line = format!("{:<40} {}  {equal}", "sample as rendered", exact(rendered));
    *out += &format!("  {}{line}\n", style.swatch(rendered));
}

/// Writes a tree with lines as branches.
struct Branches<'a, 'o> {
    tree: &'a SampleTree,
    style: &'a Style<'a>,
    shown: &'a Shown,
    out: &'o mut String,
}

impl Branches<'_, '_> {
    fn write(&mut self) {
        let nodes = &self.tree.nodes;
        let mut children: Vec<Vec<usize>> = vec![Vec::new(); nodes.len()];
        for (i, node) in nodes.iter().enumerate().filter(|(i, _)| self.shown.nodes[*i]) {
            if let Some(list) = node.parent.and_then(|p| children.get_mut(p)) {
                list.push(i);
            }
        }
        // (node, depth, whether it is the last child). An explicit stack: trees may be a hundred thousand levels deep.
        let mut stack: Vec<(usize, usize, bool)> = vec![(0, 0, true)];
        let mut open: Vec<bool> = Vec::new();
        while let Some((i, depth, last)) = stack.pop() {
            if !self.shown.nodes.get(i).copied().unwrap_or(false) {
                continue;
            }
            open.truncate(depth.saturating_sub(1));
            let (shadows, others): (Vec<usize>, Vec<usize>) =
                children[i].iter().copied().partition(|&c| nodes[c].kind == Kind::Shadow);
            let hidden = self.shown.hidden[i];
            let has_more = !others.is_empty() || hidden.rays > 0;
            self.node(i, &open, depth, last, has_more, &shadows);
            if depth > 0 {
                open.push(!last);
            }
            if hidden.rays > 0 {
                let line = format!(
                    "… {} with a sum of {} not shown; --all shows them",
                    rays(hidden.rays),
                    short_sum(hidden)
                );
                let end = if others.is_empty() { "└─ " } else { "├─ " };
                let line = format!("{}{end}{line}", indent(&open));
                *self.out += &format!("{}\n", self.style.dim(&line));
            }
            let count = others.len();
            stack.extend(others.into_iter().enumerate().rev().map(|(n, c)| (c, depth + 1, n + 1 == count)));
        }
    }

    fn node(&mut self, i: usize, open: &[bool], depth: usize, last: bool, has_more: bool, shadows: &[usize]) {
        let node = &self.tree.nodes[i];
        let style = self.style;
        let fork = if depth == 0 {
            ""
        } else if last {
            "└─ "
        } else {
            "├─ "
        };
        let head = indent(open) + fork;
        let mut line = format!("{} → {}", style.bold(node.kind.title()), style.bold(&escape(&node.target)));
        if let Some(material) = &node.material {
            line += &format!(" ({})", escape(material));
        }
        if !node.remark.is_empty() {
            line += &format!(", {}", escape_line(&node.remark));
        }
        line += &format!("  × {}", color(node.weight));
        line += &format!("  {}= {}", style.swatch(node.total), color(node.total));
        *self.out += &format!("{head}{line}\n");
        let mut inner = open.to_vec();
        if depth > 0 {
            inner.push(!last);
        }
        let margin = indent(&inner) + if has_more { "│    " } else { "     " };
        for row in rows(node) {
            *self.out += &style.dim(&format!("{margin}{row}\n"));
        }
        self.lights(&margin, shadows);
    }

    /// Shadow rays: a line for each light, with the details of the ray if there is only one.
    fn lights(&mut self, margin: &str, shadows: &[usize]) {
        let nodes = &self.tree.nodes;
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for &i in shadows {
            let light = nodes[i].light.map(|(light, _)| light);
            match groups.last_mut() {
                Some(group) if nodes[group[0]].light.map(|(l, _)| l) == light => group.push(i),
                _ => groups.push(vec![i]),
            }
        }
        for group in groups {
            let first = &nodes[group[0]];
            let added =
                group.iter().filter_map(|&i| nodes[i].light).fold(Spectrum::BLACK, |sum, (_, c)| sum + c);
            let name = escape(&first.target);
            let swatch = self.style.swatch(added);
            if let [only] = group[..] {
                let node = &nodes[only];
                let what = escape_line(&node.remark);
                *self.out += &format!("{margin}☀ {name}: {what}  {swatch}{}\n", color(added));
                if !added.is_black() || node.open {
                    for row in rows(node) {
                        *self.out += &self.style.dim(&format!("{margin}  {row}\n"));
                    }
                }
                continue;
            }
            let what = escape_line(&light_remark(self.tree, &group));
            *self.out += &format!("{margin}☀ {name}: {what}  {swatch}{}\n", color(added));
        }
    }
}

fn indent(open: &[bool]) -> String {
    // Limits the indentation of deep trees.
    const MOST: usize = 24;
    let skipped = open.len().saturating_sub(MOST);
    let mut out = if skipped > 0 { format!("({skipped}) ") } else { String::new() };
    out.extend(open.iter().skip(skipped).map(|&open| if open { "│  " } else { "   " }));
    out
}

/// Details as `name value · name value`, in lines of limited width.
fn rows(node: &RayNode) -> Vec<String> {
    const WIDTH: usize = 92;
    let mut lines = Vec::new();
    let mut line = String::new();
    for term in &node.terms {
        let cell = format!("{} {}", term.name, escape_line(&term.text()));
        if !line.is_empty() && line.chars().count() + cell.chars().count() + 3 > WIDTH {
            lines.push(std::mem::take(&mut line));
        }
        if !line.is_empty() {
            line += " · ";
        }
        line += &cell;
    }
    if !line.is_empty() {
        lines.push(line);
    }
    lines
}

//! A tree as rows, one below the other, for the drawing and the page.

use turner::color::Spectrum;

use turner::explain::prune::{Hidden, Shown};
use turner::explain::{Kind, SampleTree};

/// A row.
pub(crate) enum Row {
    /// A camera, reflected, refracted or scattered ray.
    Ray { node: usize, depth: usize },
    /// The shadow rays to one light from the surface of the ray above.
    Light { nodes: Vec<usize>, depth: usize, added: Spectrum },
    /// Rays that are not shown.
    Hidden { hidden: Hidden, depth: usize },
}

impl Row {
    pub(crate) fn depth(&self) -> usize {
        match self {
            Row::Ray { depth, .. } | Row::Light { depth, .. } | Row::Hidden { depth, .. } => *depth,
        }
    }
}

/// Rows from the camera ray down. Shadow rays to the same light share a row.
pub(crate) fn rows(tree: &SampleTree, shown: &Shown) -> Vec<Row> {
    let nodes = &tree.nodes;
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); nodes.len()];
    for (i, node) in nodes.iter().enumerate().filter(|(i, _)| shown.nodes[*i]) {
        if let Some(list) = node.parent.and_then(|p| children.get_mut(p)) {
            list.push(i);
        }
    }
    let mut out: Vec<Row> = Vec::new();
    let mut stack = vec![(0, 0)];
    while let Some((i, depth)) = stack.pop() {
        if !shown.nodes.get(i).copied().unwrap_or(false) {
            continue;
        }
        out.push(Row::Ray { node: i, depth });
        let mut rest = Vec::new();
        for &child in &children[i] {
            if nodes[child].kind != Kind::Shadow {
                rest.push((child, depth + 1));
                continue;
            }
            let (light, more) = nodes[child].light.unwrap_or((0, Spectrum::BLACK));
            match out.last_mut() {
                Some(Row::Light { nodes: group, added, .. })
                    if group.first().is_some_and(|&g| nodes[g].light.is_some_and(|(l, _)| l == light)) =>
                {
                    group.push(child);
                    *added += more;
                }
                _ => out.push(Row::Light { nodes: vec![child], depth: depth + 1, added: more }),
            }
        }
        if shown.hidden[i].rays > 0 {
            out.push(Row::Hidden { hidden: shown.hidden[i], depth: depth + 1 });
        }
        stack.extend(rest.into_iter().rev());
    }
    out
}

/// The result of the shadow rays to a light, in a few words.
pub(crate) fn light_remark(tree: &SampleTree, group: &[usize]) -> String {
    let nodes = &tree.nodes;
    if let [only] = group {
        return nodes[*only].remark.clone();
    }
    let open = group.iter().filter(|&&i| nodes[i].open).count();
    let mut others: Vec<&str> = Vec::new();
    for &i in group.iter().filter(|&&i| !nodes[i].open) {
        if !others.contains(&nodes[i].remark.as_str()) && others.len() < 3 {
            others.push(&nodes[i].remark);
        }
    }
    let of = group.len();
    match (open, &others[..]) {
        (0, [only]) => format!("{only} ({of} points)"),
        (_, []) => format!("lit ({of} points)"),
        _ => format!("{open} of {of} points lit, others {}", others.join(", ")),
    }
}

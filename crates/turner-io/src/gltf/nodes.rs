//! The node hierarchy: parents, world transforms, and which nodes are visible.
//!
//! Nodes form a forest (glTF 2.0 §3.5.2): each node has at most one parent, and none is its own ancestor. Files that
//! violate this are rejected: with shared children, a few nodes could stand for more nodes than fit in memory. No
//! traversal is recursive, because a chain can be as long as the file.

use super::fault::{Fault, Outcome};
use super::json::{Document, Index, Node};
use super::report::Report;
use crate::assets::{nearest, printable};
use turner::math::{DAffine3, DMat3, DVec3};

/// Marks a node without a parent.
const NONE: u32 = u32::MAX;

/// The local transform of a node: translation, rotation and scale, or a matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Local {
    /// Translation, rotation and scale; animations change them.
    Parts {
        /// Translation.
        translation: DVec3,
        /// Unit quaternion (x, y, z, w).
        rotation: [f64; 4],
        /// Scale.
        scale: DVec3,
    },
    /// A matrix.
    Matrix(DAffine3),
}

impl Local {
    /// The transform in the document.
    pub(super) fn of(node: &Node) -> Local {
        if let Some(m) = &node.matrix {
            let column = |c: usize| DVec3::new(m[4 * c], m[4 * c + 1], m[4 * c + 2]);
            let matrix3 = DMat3::from_cols(column(0), column(1), column(2));
            return Local::Matrix(DAffine3 { matrix3, translation: column(3) });
        }
        Local::Parts {
            translation: node.translation.as_deref().map_or(DVec3::ZERO, |v| DVec3::from(*v)),
            rotation: node.rotation.as_deref().copied().unwrap_or([0.0, 0.0, 0.0, 1.0]),
            scale: node.scale.as_deref().map_or(DVec3::ONE, |v| DVec3::from(*v)),
        }
    }

    /// As a matrix.
    pub(super) fn matrix(&self) -> DAffine3 {
        match *self {
            Local::Matrix(m) => m,
            Local::Parts { translation, rotation, scale } => from_parts(translation, rotation, scale),
        }
    }
}

/// The matrix of a scale, followed by a rotation, followed by a translation. A quaternion need not have length 1; one
/// of length 0 is no rotation.
pub(super) fn from_parts(translation: DVec3, rotation: [f64; 4], scale: DVec3) -> DAffine3 {
    let [x, y, z, w] = normalize(rotation);
    let (xx, yy, zz) = (x * x, y * y, z * z);
    let (xy, xz, yz, wx, wy, wz) = (x * y, x * z, y * z, w * x, w * y, w * z);
    let matrix3 = DMat3::from_cols(
        DVec3::new(1.0 - 2.0 * (yy + zz), 2.0 * (xy + wz), 2.0 * (xz - wy)) * scale.x,
        DVec3::new(2.0 * (xy - wz), 1.0 - 2.0 * (xx + zz), 2.0 * (yz + wx)) * scale.y,
        DVec3::new(2.0 * (xz + wy), 2.0 * (yz - wx), 1.0 - 2.0 * (xx + yy)) * scale.z,
    );
    DAffine3 { matrix3, translation }
}

/// Normalises a quaternion; the identity if its length is 0 or not finite.
pub(super) fn normalize(q: [f64; 4]) -> [f64; 4] {
    // Scaled first, because the squares of very large or small values overflow or underflow.
    let largest = q.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let q = q.map(|v| v / largest);
    let length = q.iter().map(|v| v * v).sum::<f64>().sqrt();
    if length.is_finite() && length > 0.0 { q.map(|v| v / length) } else { [0.0, 0.0, 0.0, 1.0] }
}

/// The node hierarchy of a document.
#[derive(Debug)]
pub(super) struct Tree {
    parents: Vec<u32>,
    /// All nodes; parents precede their children.
    order: Vec<u32>,
}

impl Tree {
    /// Checks that the nodes form a forest.
    pub(super) fn new(document: &Document) -> Outcome<Tree> {
        let count = document.nodes.len();
        let mut parents = vec![NONE; count];
        for (i, node) in document.nodes.iter().enumerate() {
            for (k, child) in node.children.iter().enumerate() {
                let pointer = || format!("/nodes/{i}/children/{k}");
                let Some(parent) = parents.get_mut(child.index()) else {
                    return Err(Fault::dangling(pointer(), "node", child.0, count));
                };
                if child.index() == i {
                    return Err(Fault::at(pointer(), format!("node {i} is its own child")));
                }
                if *parent != NONE {
                    let message = format!(
                        "node {} has two parents, nodes {parent} and {i}; expected at most one",
                        child.0
                    );
                    return Err(Fault::at(pointer(), message));
                }
                *parent = i as u32;
            }
        }
        let mut order: Vec<u32> = (0..count as u32).filter(|i| parents[*i as usize] == NONE).collect();
        let mut done = 0;
        while let Some(&node) = order.get(done) {
            order.extend(document.nodes[Index(node)].children.iter().map(|c| c.0));
            done += 1;
        }
        if order.len() < count {
            let mut reached = vec![false; count];
            order.iter().for_each(|i| reached[*i as usize] = true);
            let node = reached.iter().position(|r| !r).unwrap_or(0);
            let message = format!("node {node} is its own ancestor; expected a tree");
            return Err(Fault::at(format!("/nodes/{node}"), message));
        }
        Ok(Tree { parents, order })
    }

    /// The matrix of each node from its space to world space. On overflow a matrix is not finite.
    pub(super) fn world(&self, locals: Vec<Local>) -> Vec<DAffine3> {
        let mut world: Vec<DAffine3> = locals.into_iter().map(|local| local.matrix()).collect();
        for &node in &self.order {
            let parent = self.parents[node as usize];
            if parent != NONE {
                world[node as usize] = world[parent as usize] * world[node as usize];
            }
        }
        world
    }

    /// The visible nodes, in depth-first order: those of the selected scene, and if `wanted` is not empty only
    /// the nodes with these names and their descendants. Without scenes all nodes are visible.
    pub(super) fn shown(
        &self,
        document: &Document,
        scene: Option<&str>,
        wanted: &[String],
        report: &mut Report,
    ) -> Outcome<Vec<u32>> {
        let all: Vec<u32> = (0..self.parents.len() as u32).filter(|i| self.is_root(*i)).collect();
        let roots = match choose_scene(document, scene)? {
            Some(number) => {
                let pointer = format!("/scenes/{}/nodes", number.0);
                let listed = &document.scenes[number].nodes;
                if let Some(bad) = listed.iter().find(|n| n.index() >= self.parents.len()) {
                    return Err(Fault::dangling(pointer, "node", bad.0, self.parents.len()));
                }
                let inner = listed.iter().filter(|n| !self.is_root(n.0)).count();
                if inner > 0 {
                    report.doubtful("a scene lists child nodes: their parents' transforms apply");
                }
                listed.iter().map(|n| n.0).collect()
            }
            None => all,
        };
        // Visits each node once, even if it is listed several times.
        let mut visited = vec![false; self.parents.len()];
        let reach = |from: &[u32], visited: &mut [bool]| {
            let mut order = Vec::new();
            let mut stack: Vec<u32> = from.iter().rev().copied().collect();
            while let Some(node) = stack.pop() {
                if std::mem::replace(&mut visited[node as usize], true) {
                    continue;
                }
                let json = &document.nodes[Index(node)];
                let visibility = json.extensions.as_deref().and_then(|e| e.visibility.as_ref());
                if visibility.is_some_and(|v| !v.visible) {
                    continue;
                }
                order.push(node);
                stack.extend(json.children.iter().rev().map(|c| c.0));
            }
            order
        };
        let order = reach(&roots, &mut visited);
        if wanted.is_empty() {
            return Ok(order);
        }
        let name = |node: &u32| document.nodes[Index(*node)].name.as_deref();
        for wanted in wanted {
            if !order.iter().any(|n| name(n) == Some(wanted)) {
                let names = order.iter().filter_map(name);
                let near = nearest(wanted, names.clone());
                let list = names.take(24).map(printable).collect::<Vec<_>>().join(", ");
                let help = match near {
                    Some(near) => format!("did you mean \"{}\"? nodes: {list}", printable(near)),
                    None => format!("nodes: {list}"),
                };
                return Err(Fault::of_file(format!("there is no node \"{wanted}\" in the scene")).help(help));
            }
        }
        let picked: Vec<u32> = order
            .iter()
            .copied()
            .filter(|n| name(n).is_some_and(|n| wanted.iter().any(|w| w == n)))
            .collect();
        visited.fill(false);
        Ok(reach(&picked, &mut visited))
    }

    /// The root above each node.
    pub(super) fn roots(&self) -> Vec<u32> {
        let mut roots: Vec<u32> = (0u32..).take(self.parents.len()).collect();
        for &node in &self.order {
            if let Some(&parent) = self.parents.get(node as usize)
                && parent != NONE
            {
                roots[node as usize] = roots[parent as usize];
            }
        }
        roots
    }

    /// Whether each node is this one or below it.
    pub(super) fn below(&self, top: Index) -> Vec<bool> {
        let mut below = vec![false; self.parents.len()];
        for &node in &self.order {
            let parent = self.parents[node as usize];
            below[node as usize] = node == top.0 || parent != NONE && below[parent as usize];
        }
        below
    }

    fn is_root(&self, node: u32) -> bool {
        self.parents[node as usize] == NONE
    }
}

/// The scene with this name or index, or the document's default; `None` if it has no scenes.
pub(super) fn choose_scene(document: &Document, wanted: Option<&str>) -> Outcome<Option<Index>> {
    let scenes = &document.scenes;
    if let Some(wanted) = wanted {
        let names: Vec<Option<&str>> = scenes.iter().map(|s| s.name.as_deref()).collect();
        return choose(wanted, &names, "scene").map(Some);
    }
    match document.scene {
        Some(number) if number.index() < scenes.len() => Ok(Some(number)),
        Some(number) => Err(Fault::dangling("/scene", "scene", number.0, scenes.len())),
        None if scenes.is_empty() => Ok(None),
        None => Ok(Some(Index(0))),
    }
}

/// The index of the element with this name; if there is none, `wanted` may be an index.
pub(super) fn choose(wanted: &str, names: &[Option<&str>], kind: &str) -> Outcome<Index> {
    let by_name = names.iter().position(|n| *n == Some(wanted));
    let by_number = || wanted.parse::<usize>().ok().filter(|n| *n < names.len());
    match by_name.or_else(by_number) {
        Some(i) => Ok(Index(i as u32)),
        None => {
            let known = names.iter().flatten().copied();
            let near = nearest(wanted, known.clone())
                .map_or_else(String::new, |n| format!("did you mean \"{}\"? ", printable(n)));
            let list = known.take(24).map(printable).collect::<Vec<_>>().join(", ");
            let help = format!("{near}{kind}s: {} in all; by name: {list}", names.len());
            Err(Fault::of_file(format!("there is no {kind} \"{wanted}\"")).help(help))
        }
    }
}

#[cfg(test)]
mod tests;

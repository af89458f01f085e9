//! Collapses a binary tree (temporary).
use super::*;
use crate::node::*;
use crate::{Bvh2, Bvh2Options};

pub(crate) fn build(source: &Source<'_>, _options: &BuildOptions<'_>) -> Result<WideTree, BuildError> {
    let Source::Triangles { positions, triangles, scale } = *source else { unimplemented!() };
    let boxes: Vec<Aabb> = triangles
        .iter()
        .map(|t| t.iter().fold(Aabb::EMPTY, |b, &i| b.grow(positions[i as usize].map(|x| x * scale))))
        .collect();
    let t2 = Bvh2::build(&boxes, &Bvh2Options::default())?;
    let mut tree = WideTree::default();
    tree.stats.primitives = t2.order().len();
    if t2.nodes().is_empty() {
        return Ok(tree);
    }
    fn range(t2: &Bvh2, n: usize, s: usize) -> (u32, u32) {
        match t2.nodes()[n].leaf(s) {
            Some(r) => (r.start, r.end),
            None => {
                let c = t2.nodes()[n].child(s);
                (range(t2, c, 0).0.min(range(t2, c, 1).0), range(t2, c, 1).1.max(range(t2, c, 0).1))
            }
        }
    }
    fn leaf(t2: &Bvh2, n: usize, s: usize) -> Option<std::ops::Range<u32>> {
        let (a, b) = range(t2, n, s);
        if t2.nodes()[n].leaf(s).is_some() || b - a <= 4 { Some(a..b) } else { None }
    }
    fn go(t2: &Bvh2, tree: &mut WideTree, root: usize, depth: usize) -> usize {
        let at = tree.nodes.len();
        tree.nodes.push(WideNode::EMPTY);
        tree.stats.max_depth = tree.stats.max_depth.max(depth);
        let mut set: Vec<(Aabb, usize, usize)> =
            (0..2).map(|s| (t2.nodes()[root].bounds(s), root, s)).collect();
        while set.len() < 8 {
            let Some(i) = (0..set.len())
                .filter(|&i| leaf(t2, set[i].1, set[i].2).is_none())
                .max_by(|&a, &b| set[a].0.half_area().total_cmp(&set[b].0.half_area()))
            else {
                break;
            };
            let (_, n, s) = set.swap_remove(i);
            let c = t2.nodes()[n].child(s);
            for s in 0..2 {
                set.push((t2.nodes()[c].bounds(s), c, s));
            }
        }
        let mut node = WideNode::EMPTY;
        for (i, &(b, n, s)) in set.iter().enumerate() {
            let child = match leaf(t2, n, s) {
                Some(r) => {
                    let first = tree.slots.len() / 4;
                    let mut ids: Vec<u32> = r.map(|p| t2.order()[p as usize]).collect();
                    ids.sort_unstable();
                    let blocks = ids.len().div_ceil(4);
                    ids.resize(blocks * 4, NO_PRIMITIVE);
                    tree.slots.extend(ids);
                    ChildRef::leaf(first, blocks)
                }
                None => ChildRef::node(go(t2, tree, t2.nodes()[n].child(s), depth + 1)),
            };
            node.set(i, b, child);
        }
        for o in 0..8u32 {
            let mut idx: Vec<usize> = (0..8).collect();
            let key = |i: usize| {
                if i >= set.len() {
                    f32::INFINITY
                } else {
                    let c = set[i].0.center();
                    (0..3).map(|a| if o >> a & 1 != 0 { -c[a] } else { c[a] }).sum::<f32>()
                }
            };
            idx.sort_by(|&a, &b| key(a).total_cmp(&key(b)).then(a.cmp(&b)));
            node.order[o as usize] = idx.iter().enumerate().fold(0, |w, (k, &i)| w | (i as u32) << (3 * k));
        }
        tree.nodes[at] = node;
        at
    }
    go(&t2, &mut tree, 0, 1);
    tree.stats.nodes = tree.nodes.len();
    tree.stats.blocks = tree.slots.len() / 4;
    Ok(tree)
}

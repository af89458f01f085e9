//! The trees of nodes of prims.

use std::rc::Rc;

use super::{MAX_NODES, Stage};
use crate::usd::paths;
use crate::usd::value::{Broken, ListEdit, Offset, Read, Reference, Value};

/// Deepest nesting of arcs.
const MAX_ARCS: usize = 48;
/// Most nodes of one prim.
const MAX_TREE: usize = 1 << 12;

/// The kind of an arc, from the strongest to the weakest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Arc {
    Root,
    Inherit,
    Variant,
    Reference,
    Payload,
    Specialize,
}

/// A path in a stack of layers.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub(super) stack: usize,
    pub(super) path: String,
    /// From times of the stack to those of the stage.
    pub(super) offset: Offset,
    arc: Arc,
    /// The number of names in the path of the prim that has the arc.
    level: usize,
    parent: usize,
    children: Vec<usize>,
    /// Paths below `from` in this node are below `to` in its parent.
    from: String,
    to: String,
    /// Whether its specs count: in instances, local opinions about descendants do not.
    is_inert: bool,
}

/// A prim of the stage.
#[derive(Clone)]
pub(crate) struct Prim {
    /// Its path on the stage.
    pub(crate) path: String,
    pub(super) nodes: Rc<Vec<Node>>,
    /// Nodes that have specs, the strongest first.
    pub(super) order: Rc<Vec<usize>>,
}

/// A list of all edits of a stack's layers to a field.
fn edited<T: Clone + PartialEq>(edits: &[ListEdit<T>]) -> Vec<T> {
    let mut list = Vec::new();
    edits.iter().rev().for_each(|edit| edit.apply(&mut list));
    list
}

impl Stage<'_> {
    /// The root of all prims.
    pub(crate) fn root(&self) -> Prim {
        let nodes = Rc::new(vec![self.root_node(0)]);
        Prim { path: "/".to_owned(), nodes, order: Rc::new(vec![0]) }
    }

    fn root_node(&self, stack: usize) -> Node {
        Node {
            stack,
            path: "/".to_owned(),
            offset: Offset::default(),
            arc: Arc::Root,
            level: 0,
            parent: 0,
            children: Vec::new(),
            from: "/".to_owned(),
            to: "/".to_owned(),
            is_inert: false,
        }
    }

    /// The prim at a path, if it exists.
    pub(crate) fn prim_at(&self, path: &str) -> Read<Option<Prim>> {
        let mut prim = self.root();
        for name in path.split('/').filter(|n| !n.is_empty()) {
            prim = self.child(&prim, name)?;
            if prim.order.is_empty() {
                return Ok(None);
            }
        }
        Ok(Some(prim))
    }

    /// The children of a prim, in order.
    pub(crate) fn children(&self, prim: &Prim) -> Read<Vec<Prim>> {
        let names = self.names(prim, "primChildren")?;
        names.iter().map(|name| self.child(prim, name)).collect()
    }

    /// The names in a field of all nodes: those of weaker nodes come first.
    pub(crate) fn names(&self, prim: &Prim, field: &str) -> Read<Vec<String>> {
        let mut names: Vec<String> = Vec::new();
        let mut known = std::collections::BTreeSet::new();
        for &i in prim.order.iter().rev() {
            let node = &prim.nodes[i];
            for (layer, _) in self.stack_of(node.stack).layers.iter().rev() {
                let layer = self.layer(*layer);
                if let Some(Value::Texts(list)) = layer.layer.field(&node.path, field)?.as_deref() {
                    for name in list {
                        if known.insert(name.clone()) {
                            names.push(name.clone());
                        }
                    }
                }
            }
        }
        Ok(names)
    }

    /// The child of a prim; without nodes that have specs if there is none.
    fn child(&self, prim: &Prim, name: &str) -> Read<Prim> {
        let mut tree = self.descend(&prim.nodes, name, &mut Vec::new())?;
        self.add_variants(&mut tree)?;
        let order = self.order(&tree);
        Ok(Prim { path: paths::child(&prim.path, name), nodes: Rc::new(tree), order: Rc::new(order) })
    }

    /// A copy of an instance whose children have only the opinions of its arcs.
    pub(crate) fn shared(&self, prim: &Prim) -> Prim {
        let level = depth(&prim.path);
        let mut nodes = prim.nodes.as_ref().clone();
        for node in &mut nodes {
            node.is_inert |= node.level != level;
        }
        Prim { nodes: Rc::new(nodes), ..prim.clone() }
    }

    /// What two instances with the same contents have in common; `None` if the prim has no arcs of its own.
    pub(crate) fn instance_key(&self, prim: &Prim) -> Option<String> {
        let level = depth(&prim.path);
        let own =
            prim.order.iter().map(|i| &prim.nodes[*i]).filter(|n| n.level == level && n.arc != Arc::Root);
        let keys: Vec<String> = own
            .map(|n| format!("{}:{}:{}:{:?}", n.stack, n.path, n.offset.offset, (n.offset.scale, n.arc)))
            .collect();
        (!keys.is_empty()).then(|| keys.join("\n"))
    }

    /// The nodes of a child with its own arcs, except variants.
    fn descend(&self, parent: &[Node], name: &str, chain: &mut Vec<(usize, String)>) -> Read<Vec<Node>> {
        let mut tree: Vec<Node> = Vec::with_capacity(parent.len());
        let mut moved: Vec<Option<usize>> = vec![None; parent.len()];
        // Parents come before their children. Nodes without specs that nothing hangs on are dropped.
        let mut needed = vec![false; parent.len()];
        let mut paths: Vec<String> = Vec::with_capacity(parent.len());
        for node in parent {
            paths.push(paths::child(&node.path, name));
        }
        for (i, node) in parent.iter().enumerate().rev() {
            needed[i] |= i == 0 || (!node.is_inert && self.has_spec(node.stack, &paths[i])?);
            if needed[i] {
                needed[node.parent] = true;
            }
        }
        for (i, (node, path)) in parent.iter().zip(paths).enumerate() {
            if !needed[i] {
                continue;
            }
            let at = tree.len();
            moved[i] = Some(at);
            let parent = moved[node.parent].unwrap_or(0);
            if at > 0 {
                tree[parent].children.push(at);
            }
            tree.push(Node { path, parent, children: Vec::new(), ..node.clone() });
        }
        self.count(tree.len())?;
        for i in 0..tree.len() {
            self.add_arcs(&mut tree, i, chain)?;
        }
        Ok(tree)
    }

    fn count(&self, nodes: usize) -> Read<()> {
        let sum = self.nodes.get() + nodes as u64;
        self.nodes.set(sum);
        if sum > MAX_NODES {
            return Err(Broken::new("its references multiply to more prims than can be read"));
        }
        Ok(())
    }

    /// The tree of a path in a stack, without variants of the path itself.
    fn site(&self, stack: usize, path: &str, chain: &mut Vec<(usize, String)>) -> Read<Vec<Node>> {
        let mut tree = vec![self.root_node(stack)];
        let names: Vec<&str> = path.split('/').filter(|n| !n.is_empty()).collect();
        for (i, name) in names.iter().enumerate() {
            tree = self.descend(&tree, name, chain)?;
            if i + 1 < names.len() {
                self.add_variants(&mut tree)?;
            }
        }
        Ok(tree)
    }

    fn has_spec(&self, stack: usize, path: &str) -> Read<bool> {
        Ok(self.stack_of(stack).layers.iter().any(|(layer, _)| self.layer(*layer).layer.has(path)))
    }

    /// The edits of a field by the layers of a node's stack, the strongest first, with the layers.
    fn edits(&self, node: &Node, field: &str) -> Read<Vec<(usize, Offset, Value)>> {
        let mut out = Vec::new();
        if node.is_inert {
            return Ok(out);
        }
        for (id, offset) in &self.stack_of(node.stack).layers {
            if let Some(value) = self.layer(*id).layer.field(&node.path, field)? {
                out.push((*id, *offset, value.into_owned()));
            }
        }
        Ok(out)
    }

    fn texts(&self, node: &Node, field: &str) -> Read<Vec<String>> {
        let edits = self.edits(node, field)?.into_iter().filter_map(|(_, _, value)| match value {
            Value::List(edit) => Some(edit),
            Value::Texts(list) => Some(ListEdit::of(list)),
            _ => None,
        });
        Ok(edited(&edits.collect::<Vec<_>>()))
    }

    /// Adds the arcs of a node's specs.
    fn add_arcs(&self, tree: &mut Vec<Node>, at: usize, chain: &mut Vec<(usize, String)>) -> Read<()> {
        let node = tree[at].clone();
        if node.is_inert || !self.has_spec(node.stack, &node.path)? {
            return Ok(());
        }
        for (field, arc) in [("inheritPaths", Arc::Inherit), ("specializes", Arc::Specialize)] {
            for target in self.texts(&node, field)? {
                self.add_class(tree, at, arc, &target, chain)?;
            }
        }
        for (field, arc) in [("references", Arc::Reference), ("payload", Arc::Payload)] {
            // The layer of each item tells where its file is.
            let edits = self.edits(&node, field)?.into_iter().filter_map(|(id, offset, value)| match value {
                Value::References(edit) => Some(located(edit, id, offset)),
                _ => None,
            });
            for (reference, id, offset) in edited(&edits.collect::<Vec<_>>()) {
                let stack = match reference.asset.as_str() {
                    "" => node.stack,
                    asset => match self.open_layer(id, asset) {
                        Some(layer) => self.stack(layer)?,
                        None => continue,
                    },
                };
                let target = match reference.prim.as_str() {
                    "" => self.stack_of(stack).default_prim.clone(),
                    path => path.to_owned(),
                };
                if target.is_empty() {
                    self.problem(format!("{}: refers to a file without a default prim", node.path));
                    continue;
                }
                if !self.has_spec(stack, &target)? {
                    self.problem(format!("{}: refers to {target}, which does not exist", node.path));
                    continue;
                }
                let offset = offset.of(reference.offset);
                self.graft(tree, at, arc, (stack, &target, offset), chain)?;
            }
        }
        Ok(())
    }

    /// Adds a class, unless it is there.
    fn add_class(
        &self,
        tree: &mut Vec<Node>,
        at: usize,
        arc: Arc,
        target: &str,
        chain: &mut Vec<(usize, String)>,
    ) -> Read<()> {
        let stack = tree[at].stack;
        let is_known = tree.iter().any(|n| n.stack == stack && n.path == target && n.arc == arc);
        if is_known || !self.has_spec(stack, target)? {
            return Ok(());
        }
        self.graft(tree, at, arc, (stack, target, Offset::default()), chain)
    }

    /// Adds what the stacks that refer to a class's user say about the class.
    fn imply(&self, tree: &mut Vec<Node>, class: usize, chain: &mut Vec<(usize, String)>) -> Read<()> {
        let (arc, mut target, mut at) = (tree[class].arc, tree[class].from.clone(), tree[class].parent);
        while at != 0 {
            let node = &tree[at];
            target = paths::moved(&target, &node.from, &node.to).unwrap_or(target);
            at = node.parent;
            self.add_class(tree, at, arc, &target, chain)?;
        }
        Ok(())
    }

    /// Adds the tree of a site below a node.
    fn graft(
        &self,
        tree: &mut Vec<Node>,
        at: usize,
        arc: Arc,
        (stack, target, offset): (usize, &str, Offset),
        chain: &mut Vec<(usize, String)>,
    ) -> Read<()> {
        let node = tree[at].clone();
        // A prim that is composed of itself or of what contains it would not end.
        let mut above = at;
        let mut is_cycle = chain.iter().any(|(s, p)| *s == stack && overlap(p, target));
        loop {
            let n = &tree[above];
            is_cycle |= n.stack == stack && overlap(&paths::without_variants(&n.path), target);
            if above == 0 {
                break;
            }
            above = n.parent;
        }
        if is_cycle {
            self.problem(format!("{}: refers to itself through {target}", node.path));
            return Ok(());
        }
        if chain.len() >= MAX_ARCS || tree.len() >= MAX_TREE {
            self.problem(format!("{}: has references nested too deep", node.path));
            return Ok(());
        }
        let entry = (node.stack, paths::without_variants(&node.path));
        chain.push(entry);
        let made = self.site(stack, target, chain);
        chain.pop();
        let base = tree.len();
        let level = depth(&paths::without_variants(&tree[0].path));
        let offset = node.offset.of(offset);
        for (i, mut inner) in made?.into_iter().enumerate() {
            inner.children.iter_mut().for_each(|c| *c += base);
            inner.offset = offset.of(inner.offset);
            inner.level = level;
            if i == 0 {
                inner.arc = arc;
                inner.parent = at;
                inner.from = target.to_owned();
                inner.to.clone_from(&node.path);
            } else {
                inner.parent += base;
            }
            tree.push(inner);
        }
        tree[at].children.push(base);
        for i in base..tree.len() {
            if matches!(tree[i].arc, Arc::Inherit | Arc::Specialize) {
                self.imply(tree, i, chain)?;
            }
        }
        Ok(())
    }

    /// Adds the chosen variants of all nodes.
    fn add_variants(&self, tree: &mut Vec<Node>) -> Read<()> {
        let mut done: std::collections::BTreeSet<(usize, String)> = std::collections::BTreeSet::new();
        loop {
            let order = self.order(tree);
            let mut next = None;
            'search: for &i in &order {
                for set in self.texts(&tree[i], "variantSetNames")? {
                    if !done.contains(&(i, set.clone())) {
                        next = Some((i, set));
                        break 'search;
                    }
                }
            }
            let Some((at, set)) = next else { return Ok(()) };
            done.insert((at, set.clone()));
            let Some(selection) = self.selection(tree, &order, &set)? else { continue };
            let node = tree[at].clone();
            let path = format!("{}{{{set}={selection}}}", node.path);
            if tree.len() >= MAX_TREE || !self.has_spec(node.stack, &path)? {
                continue;
            }
            let made = tree.len();
            let (from, to) = (path.clone(), node.path.clone());
            let level = depth(&paths::without_variants(&tree[0].path));
            let variant =
                Node { path, arc: Arc::Variant, level, parent: at, children: Vec::new(), from, to, ..node };
            tree.push(variant);
            tree[at].children.push(made);
            self.add_arcs(tree, made, &mut Vec::new())?;
        }
    }

    /// The strongest selection of a variant set.
    fn selection(&self, tree: &[Node], order: &[usize], set: &str) -> Read<Option<String>> {
        for &i in order {
            for (id, _, value) in self.edits(&tree[i], "variantSelection")? {
                let Value::Dictionary(entries) = value else { continue };
                let Some(entry) = entries.get(set) else { continue };
                let entry = self.layer(id).layer.open(entry)?;
                return Ok(entry.text().filter(|t| !t.is_empty()).map(str::to_owned));
            }
        }
        Ok(None)
    }

    /// The nodes with specs, the strongest first.
    fn order(&self, tree: &[Node]) -> Vec<usize> {
        let (mut order, mut last) = (Vec::with_capacity(tree.len()), Vec::new());
        self.visit(tree, 0, &mut order, &mut last);
        // What is specialized is weaker than all else.
        while let Some(i) = (!last.is_empty()).then(|| last.remove(0)) {
            self.visit(tree, i, &mut order, &mut last);
        }
        order.retain(|i| {
            let node = &tree[*i];
            !node.is_inert && self.has_spec(node.stack, &node.path).unwrap_or(false)
        });
        order
    }

    fn visit(&self, tree: &[Node], from: usize, order: &mut Vec<usize>, last: &mut Vec<usize>) {
        let mut pending = vec![from];
        while let Some(i) = pending.pop() {
            order.push(i);
            let mut children = tree[i].children.clone();
            children.sort_by_key(|c| (tree[*c].arc, std::cmp::Reverse(tree[*c].level)));
            for c in children.into_iter().rev() {
                if tree[c].arc == Arc::Specialize {
                    last.push(c);
                } else {
                    pending.push(c);
                }
            }
        }
    }

    /// A path in the namespace of a node, on the stage.
    /// `None` if it lies outside what another file is referred to for.
    pub(super) fn on_stage(&self, prim: &Prim, node: usize, path: &str) -> Option<String> {
        let (mut at, mut path) = (node, paths::without_variants(path));
        while at != 0 {
            let node = &prim.nodes[at];
            let from = paths::without_variants(&node.from);
            let to = paths::without_variants(&node.to);
            match paths::moved(&path, &from, &to) {
                Some(moved) => path = moved,
                None if node.stack != prim.nodes[node.parent].stack => return None,
                None => {}
            }
            at = node.parent;
        }
        Some(path)
    }
}

/// References with the layer that names them.
fn located(edit: ListEdit<Reference>, id: usize, offset: Offset) -> ListEdit<(Reference, usize, Offset)> {
    let with = |list: Vec<Reference>| list.into_iter().map(|r| (r, id, offset)).collect();
    ListEdit {
        explicit: edit.explicit.map(with),
        prepended: with(edit.prepended),
        added: with(edit.added),
        appended: with(edit.appended),
        deleted: with(edit.deleted),
    }
}

/// The number of names in a path.
fn depth(path: &str) -> usize {
    path.split('/').filter(|n| !n.is_empty()).count()
}

/// Whether one path is the other or contains it.
fn overlap(a: &str, b: &str) -> bool {
    let within = |inner: &str, outer: &str| {
        inner.strip_prefix(outer).is_some_and(|rest| rest.is_empty() || rest.starts_with('/') || outer == "/")
    };
    within(a, b) || within(b, a)
}

//! Composition: the prims of a stage from the opinions of its layers.
//!
//! A prim has a tree of nodes. Each node is a path in a stack of layers, and each edge an arc: inherits, variants,
//! references, payloads, specializes. Depth-first, with the children of a node in this order, the tree lists the
//! opinions from the strongest to the weakest (Pixar's "LIVERPS"). The tree of a child begins with the nodes of its
//! parent's tree, moved to the child, and gains the arcs of the child's own specs.

#[cfg(test)]
mod tests;
mod tree;
mod values;

use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use super::layer::Layer;
use super::paths;
use super::value::{Offset, Read, Value};
pub(super) use tree::Prim;
pub(super) use values::Opinion;

/// Where layers come from.
pub(super) trait Source {
    /// The name of a file that the layer `anchor` names. The error is the problem in words.
    fn resolve(&self, anchor: &str, asset: &str) -> Result<String, String>;
    /// Reads a file by its resolved name.
    fn read(&self, name: &str) -> Result<Vec<u8>, String>;
}

/// Most layers of a stage.
const MAX_LAYERS: usize = 1 << 14;
/// Deepest nesting of sublayers.
const MAX_SUBLAYERS: u32 = 64;
/// Most nodes of all prims.
const MAX_NODES: u64 = 1 << 22;

/// A layer and its name.
struct NamedLayer {
    name: String,
    layer: Layer,
}

/// A layer with its sublayers, the strongest first, and their times.
struct Stack {
    layers: Vec<(usize, Offset)>,
    default_prim: String,
}

/// The composed layers.
pub(super) struct Stage<'a> {
    source: &'a dyn Source,
    layers: RefCell<Vec<Rc<NamedLayer>>>,
    /// By resolved name; `None` for those that cannot be read.
    layer_ids: RefCell<BTreeMap<String, Option<usize>>>,
    stacks: RefCell<Vec<Rc<Stack>>>,
    stack_ids: RefCell<BTreeMap<usize, usize>>,
    /// What could not be composed, in words.
    problems: RefCell<BTreeSet<String>>,
    nodes: Cell<u64>,
    animated: Cell<bool>,
    /// The time at which attributes are read.
    pub(super) time: f64,
}

impl<'a> Stage<'a> {
    /// Opens the stage of a layer. `name` is its resolved name.
    pub(super) fn open(source: &'a dyn Source, name: &str, bytes: Vec<u8>) -> Read<Stage<'a>> {
        let layer = Layer::read(bytes)?;
        let root = Rc::new(NamedLayer { name: name.to_owned(), layer });
        let stage = Stage {
            source,
            layers: RefCell::new(vec![root]),
            layer_ids: RefCell::new(BTreeMap::from([(name.to_owned(), Some(0))])),
            stacks: RefCell::default(),
            stack_ids: RefCell::default(),
            problems: RefCell::default(),
            nodes: Cell::new(0),
            animated: Cell::new(false),
            time: 0.0,
        };
        stage.stack(0)?;
        Ok(stage)
    }

    /// What could not be composed.
    pub(super) fn problems(&self) -> Vec<String> {
        self.problems.borrow().iter().cloned().collect()
    }

    fn problem(&self, problem: String) {
        let mut list = self.problems.borrow_mut();
        if list.len() < 100 {
            list.insert(problem);
        }
    }

    fn layer(&self, id: usize) -> Rc<NamedLayer> {
        Rc::clone(&self.layers.borrow()[id])
    }

    fn stack_of(&self, id: usize) -> Rc<Stack> {
        Rc::clone(&self.stacks.borrow()[id])
    }

    /// The layer that another layer names; `None`, which is a problem, if it cannot be read.
    fn open_layer(&self, anchor: usize, asset: &str) -> Option<usize> {
        let anchor = self.layer(anchor).name.clone();
        let name = match self.source.resolve(&anchor, asset) {
            Ok(name) => name,
            Err(problem) => {
                self.problem(problem);
                return None;
            }
        };
        if let Some(known) = self.layer_ids.borrow().get(&name) {
            return *known;
        }
        let id = self.layers.borrow().len();
        let read = if id >= MAX_LAYERS {
            Err("there are too many layers".to_owned())
        } else {
            self.source.read(&name)
        };
        let layer = read.and_then(|bytes| {
            Layer::read(bytes).map_err(|broken| match broken.line {
                0 => format!("{name}: {}", broken.problem),
                line => format!("{name}:{line}:{}: {}", broken.column, broken.problem),
            })
        });
        let made = match layer {
            Ok(layer) => {
                self.layers.borrow_mut().push(Rc::new(NamedLayer { name: name.clone(), layer }));
                Some(id)
            }
            Err(problem) => {
                self.problem(problem);
                None
            }
        };
        self.layer_ids.borrow_mut().insert(name, made);
        made
    }

    /// The stack whose strongest layer is `root`.
    fn stack(&self, root: usize) -> Read<usize> {
        if let Some(known) = self.stack_ids.borrow().get(&root) {
            return Ok(*known);
        }
        let mut layers = Vec::new();
        self.add_sublayers(root, Offset::default(), &mut layers, 0)?;
        let layer = self.layer(root);
        let default = layer.layer.field("/", "defaultPrim")?;
        let default = default.as_deref().and_then(Value::text).unwrap_or_default();
        let default_prim = match default {
            "" => String::new(),
            name if name.starts_with('/') => name.to_owned(),
            name => paths::child("/", name),
        };
        let id = self.stacks.borrow().len();
        self.stacks.borrow_mut().push(Rc::new(Stack { layers, default_prim }));
        self.stack_ids.borrow_mut().insert(root, id);
        Ok(id)
    }

    fn add_sublayers(
        &self,
        id: usize,
        offset: Offset,
        out: &mut Vec<(usize, Offset)>,
        depth: u32,
    ) -> Read<()> {
        if out.iter().any(|(known, _)| *known == id) || depth > MAX_SUBLAYERS {
            return Ok(());
        }
        out.push((id, offset));
        let layer = self.layer(id);
        let list = |name| layer.layer.field("/", name);
        let Some(files) = list("subLayers")? else { return Ok(()) };
        let Value::Texts(files) = files.as_ref() else { return Ok(()) };
        let offsets = list("subLayerOffsets")?;
        for (i, file) in files.iter().enumerate() {
            let own = match offsets.as_deref() {
                Some(Value::Offsets(list)) => list.get(i).copied().unwrap_or_default(),
                _ => Offset::default(),
            };
            if let Some(sub) = self.open_layer(id, file) {
                self.add_sublayers(sub, offset.of(own), out, depth + 1)?;
            }
        }
        Ok(())
    }

    /// Metadata of the root layer.
    pub(super) fn metadata(&self, name: &str) -> Read<Option<Value>> {
        for (layer, _) in &self.stack_of(0).layers {
            if let Some(value) = self.layer(*layer).layer.field("/", name)? {
                return Ok(Some(value.into_owned()));
            }
        }
        Ok(None)
    }

    /// Whether an attribute that was read has values by time.
    pub(super) fn is_animated(&self) -> bool {
        self.animated.get()
    }

    /// The number of layers.
    pub(super) fn layer_count(&self) -> usize {
        self.layers.borrow().len()
    }
}

//! Groups: how they are built and refitted.

use std::fmt;
use std::sync::Arc;

use super::MAX_LEVELS;
use super::bounds::Extent;
use super::leaves::Record;
use super::matrix::Affine;
use super::plan::{Plan, TASK, bounds};
use crate::build::wide::{self, Source, WideTree, each, set_order};
use crate::motion::MovingBvh;
use crate::node::{ChildRef, MAX_LEAF_BLOCKS, MAX_WIDE_DEPTH, WideNode};
use crate::refit::refit;
use crate::traverse::Space;
use crate::{Aabb, BuildError, BuildOptions, BuildStats, Bvh, RefitError};

/// What can be placed.
#[derive(Clone, Debug)]
pub enum Object {
    /// Triangles.
    Mesh(Arc<Bvh>),
    /// Triangles whose corners move.
    Moving(Arc<MovingBvh>),
    /// Another group.
    Group(Arc<Group>),
}

/// A placed object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// Its position among the objects.
    pub object: u32,
    /// From the object to the group: the rows of a 3x4 matrix.
    pub transform: Affine,
}

/// What a group is made of.
#[derive(Clone, Copy, Debug, Default)]
pub struct GroupParts<'a> {
    /// Placed objects.
    pub instances: &'a [Instance],
    /// Where they are at time 1, if they move: as many transforms as there are instances; none if nothing moves. Between, a
    /// transform is what lies between component by component, so a turn becomes a shear on the way; and at the ray's
    /// time, taken as 0 or 1 when it lies outside, an instance that has no inverse is not hit.
    pub ends: &'a [Affine],
    /// Boxes of primitives of the group's own, which the caller meets: see [`Visit`](super::Visit).
    pub boxes: &'a [Aabb],
}

/// Objects placed in space, and primitives of its own: a tree over trees.
///
/// Hits number instances through all levels: an instance of a mesh takes one number, an instance of a group as many as
/// that group holds, and then one for its own primitives if it has any. So in a group of meshes the number of an instance is its
/// position. [`path`](Self::path) takes a number apart. Own primitives of the outermost group have
/// [`Hit::NONE`](crate::Hit::NONE) for their instance.
#[derive(Clone, Debug)]
pub struct Group {
    pub(super) nodes: Vec<WideNode>,
    /// In the order of the leaves; those without a box last.
    pub(super) records: Vec<Record>,
    pub(super) motions: Vec<[Affine; 2]>,
    pub(super) objects: Vec<Object>,
    pub(super) space: Space,
    /// Numbers that instances take.
    pub(super) placed: u32,
    /// For each record with a box the position among instances, then own primitives.
    order: Vec<u32>,
    /// Nodes above the tree: of instances without boxes.
    loose_nodes: usize,
    /// The first number of each instance, and its object; empty if there are no groups among the objects.
    pub(super) firsts: Vec<[u32; 2]>,
    /// Instances, own primitives.
    pub(super) counts: [usize; 2],
    pub(super) levels: usize,
    pub(super) extent: Extent,
    stats: GroupStats,
}

/// The size of a group's own tree, without objects.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GroupStats {
    /// The tree over instances and own primitives.
    pub tree: BuildStats,
    /// Instances that are not hit because their transform has no inverse, or a number of either is not finite.
    pub singular: usize,
    /// Instances of nothing.
    pub empty: usize,
    /// Instances in no box because their transform is too near to one without inverse: every ray meets them.
    pub loose: usize,
    /// Own primitives left out because their boxes are not [valid](Aabb::is_valid).
    pub dropped: usize,
    /// Bytes of memory.
    pub bytes: usize,
}

/// Why a group was not built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum GroupError {
    /// The tree could not be built.
    Build(BuildError),
    /// The group does not fit the tree it is to refit.
    Refit(RefitError),
    /// Groups in groups, more than [`MAX_LEVELS`].
    TooDeep,
    /// An instance of something that is not there.
    NoSuchObject {
        /// The instance.
        instance: usize,
        /// The object.
        object: u32,
    },
    /// Not as many transforms at the end as there are instances.
    Ends {
        /// Instances.
        instances: usize,
        /// Transforms at the end.
        ends: usize,
    },
    /// More instances, through all levels, than 32 bits number.
    TooManyInstances,
}

impl fmt::Display for GroupError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            GroupError::Build(e) => e.fmt(f),
            GroupError::Refit(e) => e.fmt(f),
            GroupError::TooDeep => write!(f, "more than {MAX_LEVELS} groups one within the other"),
            GroupError::NoSuchObject { instance, object } => {
                write!(f, "instance {instance} is of object {object}, which is not there")
            }
            GroupError::Ends { instances, ends } => {
                write!(f, "{instances} instances, but {ends} transforms at the end of their motion")
            }
            GroupError::TooManyInstances => write!(f, "more instances than 32 bits number"),
        }
    }
}

impl std::error::Error for GroupError {}

impl From<BuildError> for GroupError {
    fn from(error: BuildError) -> GroupError {
        GroupError::Build(error)
    }
}

impl Group {
    /// Builds the tree over instances and own primitives; those of the objects are there already.
    ///
    /// For 1,000,000 instances that takes about 0.7 s on two threads. The tree has about 111 bytes for each, and 96 more for one
    /// that moves.
    pub fn build(
        objects: Vec<Object>,
        parts: &GroupParts<'_>,
        options: &BuildOptions<'_>,
    ) -> Result<Group, GroupError> {
        let plan = Plan::new(&objects, parts, options)?;
        let (boxes, stats, loose) = plan.boxes();
        let source = Source::Boxes { boxes: &boxes, scale: 1.0, width: 1 };
        let WideTree { nodes, slots: order, stats: tree } = wide::build(&source, options)?;
        drop(boxes);
        let space = Space { scale: 1.0, unscale: 1.0, reach: 0.0, far_padding: 0.0 };
        let mut group = Group {
            nodes,
            records: Vec::new(),
            motions: Vec::new(),
            objects: Vec::new(),
            space,
            placed: 0,
            order,
            loose_nodes: 0,
            firsts: Vec::new(),
            counts: [parts.instances.len(), parts.boxes.len()],
            levels: 0,
            extent: Extent::new(Some(Aabb::EMPTY), 0.0, 0.0),
            stats: GroupStats { tree, ..stats },
        };
        group.set(plan, stats, loose, |_| true)?;
        group.objects = objects;
        Ok(group)
    }

    /// Takes on other transforms, other objects, other boxes: as many of each as before. Much faster than to build anew; rays
    /// become slower as far as instances that were neighbours no longer are. Instances that were left out when the tree was built
    /// may come in, at the cost of being met by every ray.
    pub fn refit(
        &mut self,
        objects: Vec<Object>,
        parts: &GroupParts<'_>,
        options: &BuildOptions<'_>,
    ) -> Result<(), GroupError> {
        let given = [parts.instances.len(), parts.boxes.len()];
        for (built, given) in self.counts.into_iter().zip(given) {
            if built != given {
                return Err(GroupError::Refit(RefitError::Count { built, given }));
            }
        }
        let plan = Plan::new(&objects, parts, options)?;
        let (boxes, stats, mut loose) = plan.boxes();
        let mut there = vec![false; boxes.len()];
        for &id in &self.order {
            there[id as usize] = true;
        }
        let newly = |id: &usize| !there[*id] && boxes[*id].is_valid();
        loose.extend((0..given[0]).filter(newly).map(|id| id as u32));
        if let Some(id) = (given[0]..boxes.len()).find(newly) {
            return Err(GroupError::Refit(RefitError::LeftOut { primitive: id - given[0] }));
        }
        if 1 + self.stats.tree.max_depth > MAX_WIDE_DEPTH && !loose.is_empty() {
            return Err(GroupError::Refit(RefitError::LeftOut { primitive: loose[0] as usize }));
        }
        let mut nodes = self.nodes.split_off(self.loose_nodes);
        shift(&mut nodes, self.loose_nodes, 0);
        let order = &self.order;
        refit(&mut nodes, |leaf| {
            let ids = &order[leaf.first_block()..leaf.first_block() + leaf.blocks()];
            let boxes = ids.iter().map(|&id| boxes[id as usize]).filter(|b| b.is_valid());
            boxes.fold(Aabb::EMPTY, Aabb::union)
        });
        self.nodes = nodes;
        self.set(plan, stats, loose, |id| boxes[id as usize].is_valid())?;
        self.objects = objects;
        Ok(())
    }

    /// All but the tree itself. `in_tree` says whether a primitive with a place in the tree is met there.
    fn set(
        &mut self,
        plan: Plan<'_>,
        stats: GroupStats,
        loose: Vec<u32>,
        in_tree: impl Fn(u32) -> bool + Sync,
    ) -> Result<(), GroupError> {
        let count = self.order.len();
        self.records.clear();
        self.records.resize(count, Record::EMPTY);
        self.records.reserve_exact(loose.len());
        let tasks: Vec<_> = self.records.chunks_mut(TASK).zip(self.order.chunks(TASK)).collect();
        each(plan.threads, tasks, |(records, ids)| {
            for (record, &id) in records.iter_mut().zip(ids) {
                *record = if in_tree(id) { plan.record(id) } else { Record::EMPTY };
            }
        });
        self.records.extend(loose.iter().map(|&id| plan.record(id)));
        self.motions.clear();
        for record in &mut self.records {
            if record.motion != Record::STILL {
                let i = record.motion as usize;
                record.motion = self.motions.len() as u32;
                self.motions.push([plan.parts.instances[i].transform, plan.parts.ends[i]]);
            }
        }
        self.space = Space {
            scale: plan.scale,
            unscale: 1.0 / plan.scale,
            reach: plan.reach,
            far_padding: plan.far_padding,
        };
        self.placed = plan.placed;
        self.levels = plan.levels;
        let unscale = f64::from(self.space.unscale);
        let bounds = loose.is_empty().then(|| bounds(&self.nodes, self.space.unscale));
        self.extent = Extent::new(bounds, f64::from(plan.reach) * unscale, f64::from(plan.far_padding));
        self.loose_nodes = 0;
        if !loose.is_empty() {
            self.add_loose(count, loose.len())?;
        }
        self.firsts = plan.firsts;
        self.stats = GroupStats { tree: self.stats.tree, loose: loose.len(), ..stats };
        self.stats.bytes = size_of_val(&self.nodes[..])
            + size_of_val(&self.records[..])
            + size_of_val(&self.motions[..])
            + size_of_val(&self.order[..])
            + size_of_val(&self.firsts[..]);
        Ok(())
    }

    /// Leaves that every ray meets, above the tree.
    fn add_loose(&mut self, first: usize, count: usize) -> Result<(), GroupError> {
        let leaves: Vec<ChildRef> = (first..first + count)
            .step_by(MAX_LEAF_BLOCKS)
            .map(|i| ChildRef::leaf(i, MAX_LEAF_BLOCKS.min(first + count - i)))
            .collect();
        let mut above = vec![WideNode::EMPTY];
        let part = leaves.len().div_ceil(7);
        for (i, leaves) in leaves.chunks(part).enumerate() {
            let child = everywhere(&mut above, leaves);
            above[0].set(i, EVERYWHERE, child);
        }
        let offset = above.len();
        let tree = bounds(&self.nodes, 1.0);
        if !self.nodes.is_empty() {
            if 1 + self.stats.tree.max_depth > MAX_WIDE_DEPTH {
                return Err(GroupError::Build(BuildError::TooManyPrimitives { count, limit: 0 }));
            }
            above[0].set(7, tree, ChildRef::node(offset));
        }
        above.iter_mut().for_each(set_order);
        shift(&mut self.nodes, 0, offset);
        above.append(&mut self.nodes);
        self.nodes = above;
        self.loose_nodes = offset;
        Ok(())
    }

    /// The box around everything; none if something could be anywhere.
    pub fn bounds(&self) -> Option<Aabb> {
        self.extent.bounds
    }

    /// The size of the tree.
    pub fn stats(&self) -> &GroupStats {
        &self.stats
    }

    /// Objects that instances are of.
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// The instance numbers that [`Hit::instance`](crate::Hit::instance) stands for, one for each level, the outermost first. For own
    /// primitives of an inner group the last is that of the group's instance.
    pub fn path(&self, instance: u32) -> Vec<u32> {
        let mut path = Vec::new();
        let (mut group, mut number) = (self, instance);
        while number < group.placed {
            // Of groups that take no number the last begins with the same as the next instance.
            let position = match group.firsts.as_slice() {
                [] => number,
                firsts => firsts.partition_point(|&[first, _]| first <= number) as u32 - 1,
            };
            path.push(position);
            let Some(&[first, object]) = group.firsts.get(position as usize) else { break };
            let Object::Group(inner) = &group.objects[object as usize] else { break };
            number -= first;
            group = inner;
        }
        path
    }
}

const EVERYWHERE: Aabb = Aabb { min: [f32::NEG_INFINITY; 3], max: [f32::INFINITY; 3] };

/// A subtree of leaves that every ray meets.
fn everywhere(nodes: &mut Vec<WideNode>, leaves: &[ChildRef]) -> ChildRef {
    if let [leaf] = leaves {
        return *leaf;
    }
    let index = nodes.len();
    nodes.push(WideNode::EMPTY);
    for (i, leaves) in leaves.chunks(leaves.len().div_ceil(8)).enumerate() {
        let child = everywhere(nodes, leaves);
        nodes[index].set(i, EVERYWHERE, child);
    }
    ChildRef::node(index)
}

/// Renumbers references to nodes.
fn shift(nodes: &mut [WideNode], less: usize, more: usize) {
    for child in nodes.iter_mut().flat_map(|node| &mut node.children) {
        if !child.is_leaf() {
            *child = ChildRef::node(child.index() - less + more);
        }
    }
}

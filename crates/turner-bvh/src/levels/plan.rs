//! What a group's tree is built over: which instances have boxes, and how far they reach.

use super::MAX_LEVELS;
use super::bounds::{Extent, Place, Reach};
use super::group::{GroupError, GroupParts, GroupStats, Instance, Object};
use super::leaves::Record;
use super::matrix::{inverse64, rounded, scaled};
use crate::build::wide::each;
use crate::bvh::scale_of;
use crate::node::WideNode;
use crate::{Aabb, BuildOptions};

/// Instances that one task of a thread looks at.
pub(super) const TASK: usize = 1 << 13;

/// All that the tree is built over.
pub(super) struct Plan<'a> {
    extents: Vec<Extent>,
    pub(super) parts: &'a GroupParts<'a>,
    pub(super) threads: usize,
    pub(super) scale: f32,
    /// In the units of the tree.
    pub(super) reach: f32,
    pub(super) far_padding: f32,
    pub(super) firsts: Vec<[u32; 2]>,
    pub(super) placed: u32,
    pub(super) levels: usize,
}

/// What the plan says of an instance or an own primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Fate {
    Singular,
    Empty,
    Loose,
    Box,
}

impl<'a> Plan<'a> {
    pub(super) fn new(
        objects: &[Object],
        parts: &'a GroupParts<'a>,
        options: &BuildOptions<'_>,
    ) -> Result<Plan<'a>, GroupError> {
        let GroupParts { instances, ends, boxes } = *parts;
        if !ends.is_empty() && ends.len() != instances.len() {
            return Err(GroupError::Ends { instances: instances.len(), ends: ends.len() });
        }
        let wrong = instances.iter().enumerate().find(|(_, i)| i.object as usize >= objects.len());
        if let Some((instance, &Instance { object, .. })) = wrong {
            return Err(GroupError::NoSuchObject { instance, object });
        }
        let levels = 1 + objects.iter().map(Object::levels).max().unwrap_or(0);
        if levels > MAX_LEVELS {
            return Err(GroupError::TooDeep);
        }
        let numbers: Vec<u64> = objects.iter().map(Object::numbers).collect();
        let mut firsts = Vec::new();
        let mut placed = instances.len() as u64;
        if levels > 1 {
            firsts.reserve_exact(instances.len());
            placed = 0;
            for instance in instances {
                firsts.push([placed as u32, instance.object]);
                placed += numbers[instance.object as usize];
                if placed >= u64::from(u32::MAX) {
                    return Err(GroupError::TooManyInstances);
                }
            }
        }
        let placed = u32::try_from(placed).ok().filter(|&n| n < u32::MAX - 1);
        let placed = placed.ok_or(GroupError::TooManyInstances)?;
        let threads = match options.threads {
            0 => std::thread::available_parallelism().map_or(1, |n| n.get()),
            n => n,
        };
        let extents = objects.iter().map(Object::extent).collect();
        let mut plan = Plan {
            extents,
            parts,
            threads,
            scale: 1.0,
            reach: 0.0,
            far_padding: 0.0,
            firsts,
            placed,
            levels,
        };
        let own = boxes.iter().filter(|b| b.is_valid()).flat_map(|b| b.min.into_iter().chain(b.max));
        let own = own.fold(0.0, |reach: f32, x| reach.max(x.abs()));
        let (mut reach, mut far_padding) = plan.needed();
        plan.scale = scale_of((reach.max(f64::from(own)) as f32).min(f32::MAX));
        if plan.scale != 1.0 {
            (reach, far_padding) = plan.needed();
        }
        let reach = reach.max(f64::from(own) * f64::from(plan.scale));
        plan.reach = (reach as f32).next_up();
        // More where a hit lies beyond the reach itself.
        plan.far_padding = (1.35 * far_padding) as f32;
        Ok(plan)
    }

    fn place(&self, i: usize) -> Place<'a> {
        let start = &self.parts.instances[i].transform;
        match self.parts.ends.get(i) {
            Some(end) if end != start => Place::Moving(start, end),
            _ => Place::Still(start),
        }
    }

    fn reach_of(&self, i: usize) -> Reach {
        let object = &self.extents[self.parts.instances[i].object as usize];
        Reach::new(self.place(i), object, f64::from(self.scale))
    }

    /// The reach of the group and the padding of far rays.
    fn needed(&self) -> (f64, f64) {
        let tasks: Vec<usize> = (0..self.parts.instances.len()).step_by(TASK).collect();
        let found = each(self.threads, tasks, |first| {
            let mut needed = (0.0_f64, 0.0_f64);
            for i in first..(first + TASK).min(self.parts.instances.len()) {
                let reach = self.reach_of(i);
                needed = (needed.0.max(reach.needed()), needed.1.max(reach.far_padding()));
            }
            needed
        });
        found.into_iter().fold((0.0, 0.0), |a, b| (a.0.max(b.0), a.1.max(b.1)))
    }

    /// The boxes of all instances, then of own primitives, in the units of the tree: the empty one where there is none.
    /// And how many instances are singular, how many empty, and which are loose.
    pub(super) fn boxes(&self) -> (Vec<Aabb>, GroupStats, Vec<u32>) {
        let count = self.parts.instances.len();
        let mut boxes = vec![Aabb::EMPTY; count];
        boxes.reserve_exact(self.parts.boxes.len());
        let tasks: Vec<(usize, &mut [Aabb])> = boxes.chunks_mut(TASK).enumerate().collect();
        let fates = each(self.threads, tasks, |(chunk, boxes)| {
            let (mut stats, mut loose) = (GroupStats::default(), Vec::new());
            for (i, bounds) in boxes.iter_mut().enumerate() {
                let i = chunk * TASK + i;
                let (fate, b) = self.fate(i);
                *bounds = b;
                match fate {
                    Fate::Singular => stats.singular += 1,
                    Fate::Empty => stats.empty += 1,
                    Fate::Loose => loose.push(i as u32),
                    Fate::Box => {}
                }
            }
            (stats, loose)
        });
        let (mut stats, mut all_loose) = (GroupStats::default(), Vec::new());
        for (part, loose) in fates {
            stats.singular += part.singular;
            stats.empty += part.empty;
            all_loose.extend(loose);
        }
        boxes.extend(self.parts.boxes.iter().map(|b| self.own_box(b)));
        stats.dropped = boxes[count..].iter().filter(|b| !b.is_valid()).count();
        (boxes, stats, all_loose)
    }

    fn own_box(&self, b: &Aabb) -> Aabb {
        Aabb::new(b.min.map(|x| x * self.scale), b.max.map(|x| x * self.scale))
    }

    fn fate(&self, i: usize) -> (Fate, Aabb) {
        let reach = self.reach_of(i);
        let object = &self.extents[self.parts.instances[i].object as usize];
        match reach {
            Reach::Nowhere if object.bounds == Some(Aabb::EMPTY) => (Fate::Empty, Aabb::EMPTY),
            Reach::Nowhere => (Fate::Singular, Aabb::EMPTY),
            Reach::Anywhere => (Fate::Loose, Aabb::EMPTY),
            Reach::Box { .. } => match reach.padded(f64::from(self.reach)) {
                Some(bounds) => (Fate::Box, bounds),
                None => (Fate::Loose, Aabb::EMPTY),
            },
        }
    }

    /// What stands for an instance, or an own primitive, in the leaves.
    pub(super) fn record(&self, id: u32) -> Record {
        let i = id as usize;
        let Some(own) = i.checked_sub(self.parts.instances.len()) else {
            let mut record = Record {
                object: self.parts.instances[i].object,
                id: self.firsts.get(i).map_or(id, |&[first, _]| first),
                ..Record::EMPTY
            };
            if let Place::Still(transform) = self.place(i) {
                let matrix = scaled(&transform.map(|row| row.map(f64::from)), f64::from(self.scale));
                match inverse64(&matrix).and_then(|m| rounded(&m)) {
                    Some(inverse) => record.set_inverse(&inverse),
                    None => record.object = Record::NOTHING,
                }
            } else {
                // To be numbered with the others that move.
                record.motion = id;
            }
            return record;
        };
        Record { object: Record::OWN, id: own as u32, ..Record::EMPTY }
    }
}

impl Object {
    fn extent(&self) -> Extent {
        let (nodes, space) = match self {
            Object::Mesh(mesh) => (&mesh.nodes, &mesh.space),
            Object::Moving(mesh) => (&mesh.nodes, &mesh.space),
            Object::Group(group) => return group.extent,
        };
        Extent::new(
            Some(bounds(nodes, space.unscale)),
            f64::from(space.reach) * f64::from(space.unscale),
            0.0,
        )
    }

    /// Numbers that an instance of it takes.
    fn numbers(&self) -> u64 {
        match self {
            Object::Mesh(_) | Object::Moving(_) => 1,
            Object::Group(group) => u64::from(group.placed) + u64::from(group.counts[1] > 0),
        }
    }

    fn levels(&self) -> usize {
        match self {
            Object::Mesh(_) | Object::Moving(_) => 0,
            Object::Group(group) => group.levels,
        }
    }
}

/// The box around a tree, in units outside.
pub(super) fn bounds(nodes: &[WideNode], unscale: f32) -> Aabb {
    let Some(root) = nodes.first() else { return Aabb::EMPTY };
    let all = (0..8).map(|i| root.bounds(i)).fold(Aabb::EMPTY, Aabb::union);
    if all == Aabb::EMPTY {
        all
    } else {
        Aabb::new(all.min.map(|x| x * unscale), all.max.map(|x| x * unscale))
    }
}

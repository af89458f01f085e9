//! The order in which an attribute stores its values: a walk over the faces, which stores each vertex when it first
//! reaches it.

use super::corners::{Corners, NONE, at, next, previous, put};
use super::{Read, Room};

/// Which entry each vertex has.
#[derive(Debug, Default)]
pub(super) struct Order {
    /// A corner of the vertex of each entry.
    pub(super) corners: Vec<u32>,
    /// The entry of each vertex.
    pub(super) entries: Vec<u32>,
}

/// How the faces are walked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Walk {
    /// Depth first: to the right before to the left.
    DepthFirst,
    /// Faces that predict their vertex best come first.
    PredictionDegree,
}

impl Order {
    /// The order of a walk.
    pub(super) fn of(walk: Walk, table: &Corners, room: Room<'_>) -> Read<Order> {
        let (vertices, faces) = (table.leftmost.len(), table.vertex.len() / 3);
        let order = Order { corners: room.list(vertices)?, entries: room.filled(vertices, NONE)? };
        let mut walker = Walker { table, order, visited: room.filled(faces, false)? };
        match walk {
            Walk::DepthFirst => {
                let mut stack = room.list(faces)?;
                for face in 0..faces as u32 {
                    walker.depth_first(3 * face, &mut stack);
                }
            }
            Walk::PredictionDegree => {
                let mut ranks =
                    Ranks { degrees: room.filled(vertices, 0)?, stacks: Default::default(), best: 0 };
                for face in 0..faces as u32 {
                    walker.by_degree(3 * face, &mut ranks);
                }
            }
        }
        Ok(walker.order)
    }

    /// The entry of a vertex.
    #[inline]
    pub(super) fn entry(&self, vertex: u32) -> u32 {
        at(&self.entries, vertex)
    }
}

/// Corners by how well their faces predict, with the best first.
struct Ranks {
    /// For each vertex, how many faces that were reached can predict it.
    degrees: Vec<u32>,
    stacks: [Vec<u32>; 3],
    best: usize,
}

impl Ranks {
    fn push(&mut self, corner: u32, rank: usize) {
        if let Some(stack) = self.stacks.get_mut(rank) {
            stack.push(corner);
        }
        self.best = self.best.min(rank);
    }

    fn pop(&mut self) -> Option<u32> {
        for rank in self.best..self.stacks.len() {
            if let Some(corner) = self.stacks.get_mut(rank).and_then(Vec::pop) {
                self.best = rank;
                return Some(corner);
            }
        }
        None
    }
}

struct Walker<'a> {
    table: &'a Corners,
    order: Order,
    /// By face.
    visited: Vec<bool>,
}

impl Walker<'_> {
    /// Whether the face of a corner has been visited; true without a corner.
    #[inline]
    fn is_visited(&self, corner: u32) -> bool {
        self.visited.get((corner / 3) as usize).copied().unwrap_or(true)
    }

    #[inline]
    fn visit(&mut self, corner: u32) {
        if let Some(visited) = self.visited.get_mut((corner / 3) as usize) {
            *visited = true;
        }
    }

    /// Stores the vertex of a corner if it is new. Returns whether it is.
    #[inline]
    fn store(&mut self, corner: u32) -> bool {
        let vertex = self.table.vertex(corner);
        let is_new = self.is_new(vertex);
        if is_new {
            put(&mut self.order.entries, vertex, self.order.corners.len() as u32);
            self.order.corners.push(corner);
        }
        is_new
    }

    #[inline]
    fn is_new(&self, vertex: u32) -> bool {
        self.order.entries.get(vertex as usize) == Some(&NONE)
    }

    /// The corners that face the edges to the right and to the left of a corner, in the faces beyond.
    #[inline]
    fn beyond(&self, corner: u32) -> (u32, u32) {
        (self.table.opposite(next(corner)), self.table.opposite(previous(corner)))
    }

    fn depth_first(&mut self, start: u32, stack: &mut Vec<u32>) {
        if self.is_visited(start) {
            return;
        }
        self.store(next(start));
        self.store(previous(start));
        stack.push(start);
        while let Some(mut corner) = stack.pop() {
            while !self.is_visited(corner) {
                self.visit(corner);
                let (right, left) = self.beyond(corner);
                // Inside, all faces around a new vertex follow one another on the right.
                if self.store(corner) && !self.table.is_at_boundary(self.table.vertex(corner)) {
                    corner = right;
                    continue;
                }
                corner = match (self.is_visited(right), self.is_visited(left)) {
                    (true, true) => break,
                    (true, false) => left,
                    (false, true) => right,
                    (false, false) => {
                        stack.push(left);
                        right
                    }
                };
            }
        }
    }

    fn by_degree(&mut self, start: u32, ranks: &mut Ranks) {
        if self.is_visited(start) {
            return;
        }
        ranks.best = 0;
        ranks.push(start, 0);
        self.store(next(start));
        self.store(previous(start));
        self.store(start);
        while let Some(mut corner) = ranks.pop() {
            if self.is_visited(corner) {
                continue;
            }
            loop {
                self.visit(corner);
                self.store(corner);
                let (right, left) = self.beyond(corner);
                let (right_visited, left_visited) = (self.is_visited(right), self.is_visited(left));
                if !left_visited {
                    let rank = self.rank(left, ranks);
                    if right_visited && rank <= ranks.best {
                        corner = left;
                        continue;
                    }
                    ranks.push(left, rank);
                }
                if !right_visited {
                    let rank = self.rank(right, ranks);
                    if rank <= ranks.best {
                        corner = right;
                        continue;
                    }
                    ranks.push(right, rank);
                }
                break;
            }
        }
    }

    /// 0 if the vertex of a corner is known, 1 if several faces can predict it, 2 if one can.
    fn rank(&self, corner: u32, ranks: &mut Ranks) -> usize {
        let vertex = self.table.vertex(corner);
        if !self.is_new(vertex) {
            return 0;
        }
        let Some(degree) = ranks.degrees.get_mut(vertex as usize) else { return 2 };
        *degree = degree.saturating_add(1);
        if *degree > 1 { 1 } else { 2 }
    }
}

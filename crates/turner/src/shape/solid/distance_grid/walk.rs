//! Where lines cross the surface of a grid: a walk from cell to cell (Amanatides and Woo 1987, "A Fast Voxel Traversal
//! Algorithm for Ray Tracing") in which blocks of cells without surface are one step, and in each crossed cell the roots
//! of a cubic.
//!
//! Two neighbours agree on the sign at the point where the line passes from one to the other: both interpolate on the face
//! between them. So none of them misses a crossing that the other one leaves to it.

use super::crossed_cells::CrossedCells;
use super::lattice::{Corners, Lattice, cubic, interpolate};
use crate::math::DVec3;
use crate::shape::solid::contained::Field;
use crate::shape::solid::line::Line;
use crate::shape::solid::roots::{refine, value};

/// How far before the wanted part a walk begins, per unit of the length of the line: more than roundings.
const MARGIN: f64 = 1e-9;

/// A grid of values as a function in space.
#[derive(Clone, Debug)]
pub(super) struct GridField {
    pub(super) lattice: Lattice,
    pub(super) crossed: CrossedCells,
}

/// A line in units of cells.
struct Walk {
    origin: DVec3,
    direction: DVec3,
    /// Infinite along axes that the line is parallel to.
    inverse: DVec3,
}

/// Cells from the first of each axis to that before the last.
type Block = [[usize; 3]; 2];

/// A position on a line, and the axis of the plane that lies there.
type End = (f64, usize);

impl Walk {
    fn new(line: &Line, lattice: &Lattice) -> Walk {
        let (origin, direction) = (lattice.in_cells(line.origin), line.direction * lattice.scale);
        Walk { origin, direction, inverse: direction.recip() }
    }

    fn at(&self, s: f64) -> DVec3 {
        self.origin + s * self.direction
    }

    /// Where the line enters and leaves a block of cells. It depends on the planes alone, so that neighbours have one
    /// position in common.
    fn range(&self, [low, high]: Block) -> [End; 2] {
        let mut ends = [(f64::NEG_INFINITY, 0), (f64::INFINITY, 0)];
        for axis in (0..3).filter(|axis| self.inverse[*axis].is_finite()) {
            let plane = |i: usize| (i as f64 - self.origin[axis]) * self.inverse[axis];
            let [near, far] = if self.direction[axis] > 0.0 { [low, high] } else { [high, low] };
            let [near, far] = [near, far].map(|corner| plane(corner[axis]));
            if near > ends[0].0 {
                ends[0] = (near, axis);
            }
            if far < ends[1].0 {
                ends[1] = (far, axis);
            }
        }
        ends
    }

    /// Moves to the cell behind a block that the line leaves at `end`. Returns whether there is one.
    fn step(&self, cell: &mut [usize; 3], [low, high]: Block, end: End, cells: [usize; 3]) -> bool {
        let (s, across) = end;
        for axis in 0..3 {
            let forwards = self.direction[axis] > 0.0;
            if axis != across {
                let last = high[axis] - 1;
                let at = (self.at(s)[axis].max(0.0) as usize).clamp(low[axis], last);
                // Roundings must not lead backwards.
                cell[axis] = if forwards { at.max(cell[axis]) } else { at.min(cell[axis]) };
            } else if forwards {
                cell[axis] = high[axis];
            } else {
                let Some(before) = low[axis].checked_sub(1) else { return false };
                cell[axis] = before;
            }
        }
        cell[across] < cells[across]
    }
}

/// The part of a line in a cell that the surface crosses.
struct Piece {
    from: f64,
    to: f64,
    /// Whether the value is below the level at both ends.
    below: [bool; 2],
    cubic: [f64; 4],
}

impl Piece {
    fn new(walk: &Walk, corners: &Corners, cell: [usize; 3], [from, to]: [End; 2]) -> Piece {
        let corner = DVec3::from(cell.map(|i| i as f64));
        let is_below = |(s, axis): End, leaves: bool| {
            let mut f = (walk.at(s) - corner).clamp(DVec3::ZERO, DVec3::ONE);
            // Exactly on the face.
            f[axis] = if (walk.direction[axis] > 0.0) == leaves { 1.0 } else { 0.0 };
            interpolate(corners, f) < 0.0
        };
        Piece {
            from: from.0,
            to: to.0,
            below: [is_below(from, false), is_below(to, true)],
            cubic: cubic(corners, walk.at(from.0) - corner, walk.direction),
        }
    }

    /// Calls `visit` with the crossings in order until it returns true; returns whether it did. Between the turning
    /// points the cubic is monotone, so that a change of sign is one crossing.
    fn crossings(&self, mut visit: impl FnMut(f64) -> bool) -> bool {
        let c = &self.cubic;
        let slope = [c[1], 2.0 * c[2], 3.0 * c[3]];
        let length = self.to - self.from;
        let [first, second] = quadratic_roots(slope).map(|t| if t > 0.0 && t < length { t } else { length });
        let turns = [first.min(second), first.max(second), length];
        let (mut t, mut below) = (0.0, self.below[0]);
        for next in turns {
            let is_below = if next < length { value(c, next) < 0.0 } else { self.below[1] };
            if is_below != below {
                let root = refine(t, next, below, |t| (value(c, t), value(&slope, t)));
                if visit((self.from + root).min(self.to)) {
                    return true;
                }
            }
            (t, below) = (next, is_below);
        }
        false
    }
}

/// The real roots of a + b x + c x²; NaN or infinite if there are none.
fn quadratic_roots([a, b, c]: [f64; 3]) -> [f64; 2] {
    // Without cancellation; the square root of a negative number is NaN.
    let q = -0.5 * (b + (b * b - 4.0 * a * c).sqrt().copysign(b));
    [a / q, q / c]
}

impl Field for GridField {
    fn value(&self, p: DVec3) -> f64 {
        self.lattice.value(p)
    }

    fn gradient(&self, p: DVec3) -> (f64, DVec3) {
        self.lattice.gradient(p)
    }

    fn crossings(&self, line: &Line, from: f64, mut visit: impl FnMut(f64) -> bool) {
        let cells = self.lattice.cells;
        let walk = Walk::new(line, &self.lattice);
        let is_below = |s: f64| self.value(line.at(s)) < 0.0;
        let start = (from - MARGIN * (line.exit - line.enter)).max(line.enter);
        // The end of the last crossed cell, and the sign there.
        let mut last = (start == line.enter).then(|| (start, is_below(start)));
        let mut cell = self.lattice.cell(walk.at(start));
        loop {
            let empty = self.crossed.empty_block(cell);
            let shift = empty.unwrap_or(0);
            let low = cell.map(|i| i >> shift << shift);
            let high: [usize; 3] = std::array::from_fn(|axis| (low[axis] + (1 << shift)).min(cells[axis]));
            let [near, far] = walk.range([low, high]);
            let ends = [(near.0.max(line.enter), near.1), (far.0.min(line.exit), far.1)];
            if empty.is_none() && ends[0].0 < ends[1].0 {
                let piece = Piece::new(&walk, &self.lattice.corners(cell), cell, ends);
                // Where two planes meet, rounding may lead around a sliver of a cell with a crossing.
                let missed = last.filter(|(_, below)| *below != piece.below[0]);
                if missed.is_some_and(|(s, _)| visit(s)) || piece.crossings(&mut visit) {
                    return;
                }
                last = Some((piece.to, piece.below[1]));
            }
            if far.0 >= line.exit || !walk.step(&mut cell, [low, high], far, cells) {
                break;
            }
        }
        if let Some((s, below)) = last
            && below != is_below(line.exit)
        {
            visit(s);
        }
    }

    fn precision(&self) -> f64 {
        1e-11
    }

    fn memory(&self) -> usize {
        self.lattice.memory() + self.crossed.memory()
    }

    fn tests_per_ray(&self) -> f64 {
        8.0
    }
}

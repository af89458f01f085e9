//! Triangles between edges: a constrained Delaunay triangulation on a grid of integers, with exact decisions.
//!
//! Points are inserted one by one and edges flipped until all are Delaunay (Lawson 1977). Then each given edge is made an
//! edge of the triangulation by flips (Sloan 1993, "A fast algorithm for generating constrained Delaunay triangulations").

use super::planar::{Point, REACH};

/// No triangle.
pub(super) const NONE: u32 = u32::MAX;
/// The number of corners of the triangle around all points. They are the first points.
pub(super) const OUTER: u32 = 3;

/// Triangles, counter-clockwise.
pub(super) struct Triangulation {
    pub(super) points: Vec<Point>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Across the edge opposite to each corner; [`NONE`] outside.
    pub(super) neighbors: Vec<[u32; 3]>,
    /// A triangle at each point.
    at: Vec<u32>,
    last: u32,
}

fn orientation(a: Point, b: Point, c: Point) -> i128 {
    let [ux, uy, vx, vy] = [b[0] - a[0], b[1] - a[1], c[0] - a[0], c[1] - a[1]].map(i128::from);
    ux * vy - uy * vx
}

/// Whether `p` is inside the circle through a, b and c, which are counter-clockwise.
fn in_circle([a, b, c]: [Point; 3], p: Point) -> bool {
    let [[ax, ay], [bx, by], [cx, cy]] = [a, b, c].map(|q| [q[0] - p[0], q[1] - p[1]].map(i128::from));
    let square = |x: i128, y: i128| x * x + y * y;
    let (a2, b2, c2) = (square(ax, ay), square(bx, by), square(cx, cy));
    a2 * (bx * cy - by * cx) - b2 * (ax * cy - ay * cx) + c2 * (ax * by - ay * bx) > 0
}

/// The order of a curve that fills the square (Morton 1966): neighbours in it are near each other.
fn morton(p: Point) -> u64 {
    let spread = |v: i64| {
        let mut v = (v + REACH) as u64;
        for (shift, mask) in [
            (16, 0x0000_ffff_0000_ffff_u64),
            (8, 0x00ff_00ff_00ff_00ff),
            (4, 0x0f0f_0f0f_0f0f_0f0f),
            (2, 0x3333_3333_3333_3333),
            (1, 0x5555_5555_5555_5555),
        ] {
            v = (v | (v << shift)) & mask;
        }
        v
    };
    spread(p[0]) | spread(p[1]) << 1
}

impl Triangulation {
    /// The Delaunay triangulation of points that differ; their indices follow those of the [`OUTER`] corners.
    pub(super) fn new(points: &[Point]) -> Triangulation {
        let corners = [[-4 * REACH, -2 * REACH], [4 * REACH, -2 * REACH], [0, 4 * REACH]];
        let all: Vec<Point> = corners.iter().chain(points).copied().collect();
        let mut made = Triangulation {
            at: vec![0; all.len()],
            points: all,
            triangles: vec![[0, 1, 2]],
            neighbors: vec![[NONE; 3]],
            last: 0,
        };
        let mut order: Vec<u32> = (OUTER..made.points.len() as u32).collect();
        order.sort_by_key(|i| morton(made.points[*i as usize]));
        order.into_iter().for_each(|i| made.insert(i));
        made
    }

    fn p(&self, i: u32) -> Point {
        self.points[i as usize]
    }

    /// The triangle that contains a point, and the corner opposite to the edge that it is on, if it is on one.
    fn locate(&self, p: Point) -> (u32, Option<usize>) {
        let mut t = self.last;
        loop {
            let corners = self.triangles[t as usize].map(|i| self.p(i));
            let sides: [i128; 3] =
                std::array::from_fn(|k| orientation(corners[(k + 1) % 3], corners[(k + 2) % 3], p));
            match (0..3).find(|k| sides[*k] < 0 && self.neighbors[t as usize][*k] != NONE) {
                Some(k) => t = self.neighbors[t as usize][k],
                None => return (t, sides.iter().position(|s| *s == 0)),
            }
        }
    }

    fn insert(&mut self, i: u32) {
        let (t, on) = self.locate(self.p(i));
        let mut loose: Vec<u32> = vec![t];
        match on {
            Some(k) if self.neighbors[t as usize][k] != NONE => {
                let other = self.neighbors[t as usize][k];
                let (a, b) = (self.split(t, k, i), self.split_across(other, t, i));
                // The halves of both triangles on the same side of the point meet.
                self.join_halves([t, a], [other, b]);
                loose.extend([a, other, b]);
            }
            _ => {
                let [a, b, c] = self.triangles[t as usize];
                let [na, nb, nc] = self.neighbors[t as usize];
                let (t1, t2) = (self.triangles.len() as u32, self.triangles.len() as u32 + 1);
                self.triangles[t as usize] = [i, b, c];
                self.neighbors[t as usize] = [na, t1, t2];
                self.triangles.extend([[a, i, c], [a, b, i]]);
                self.neighbors.extend([[t, nb, t2], [t, t1, nc]]);
                self.relink(nb, t, t1);
                self.relink(nc, t, t2);
                for (p, s) in [(a, t1), (b, t), (c, t), (i, t)] {
                    self.at[p as usize] = s;
                }
                loose.extend([t1, t2]);
            }
        }
        self.last = t;
        while let Some(t) = loose.pop() {
            let Some(k) = self.triangles[t as usize].iter().position(|p| *p == i) else { continue };
            let other = self.neighbors[t as usize][k];
            if other == NONE {
                continue;
            }
            let far = self.opposite(other, t);
            if in_circle(self.triangles[t as usize].map(|p| self.p(p)), self.p(far)) {
                self.flip(t, k);
                loose.extend([t, other]);
            }
        }
    }

    /// Cuts a triangle from corner `k` to the point `i` on the opposite edge; returns the new triangle. The edges on both
    /// sides of the point are not linked.
    fn split(&mut self, t: u32, k: usize, i: u32) -> u32 {
        let corner = |n: usize| (k + n) % 3;
        let [a, b, c] = [0, 1, 2].map(|n| self.triangles[t as usize][corner(n)]);
        let [_, nb, nc] = [0, 1, 2].map(|n| self.neighbors[t as usize][corner(n)]);
        let new = self.triangles.len() as u32;
        self.triangles[t as usize] = [a, b, i];
        self.neighbors[t as usize] = [NONE, new, nc];
        self.triangles.push([a, i, c]);
        self.neighbors.push([NONE, nb, t]);
        self.relink(nb, t, new);
        for (p, s) in [(a, t), (b, t), (c, new), (i, t)] {
            self.at[p as usize] = s;
        }
        new
    }

    fn split_across(&mut self, other: u32, t: u32, i: u32) -> u32 {
        let k = self.neighbors[other as usize].iter().position(|n| *n == t).unwrap_or(0);
        self.split(other, k, i)
    }

    /// Links the halves of two triangles, `[a, b, i]` and `[a, i, c]` each, across the edge that was divided at `i`.
    fn join_halves(&mut self, [t, a]: [u32; 2], [other, b]: [u32; 2]) {
        // The other triangle runs the other way: its first half is beside the second half of this one.
        self.neighbors[t as usize][0] = b;
        self.neighbors[b as usize][0] = t;
        self.neighbors[a as usize][0] = other;
        self.neighbors[other as usize][0] = a;
    }

    fn relink(&mut self, t: u32, from: u32, to: u32) {
        if t != NONE {
            self.neighbors[t as usize].iter_mut().filter(|n| **n == from).for_each(|n| *n = to);
        }
    }

    /// The corner of a triangle that is not on the edge with a neighbour.
    fn opposite(&self, t: u32, neighbor: u32) -> u32 {
        let k = self.neighbors[t as usize].iter().position(|n| *n == neighbor).unwrap_or(0);
        self.triangles[t as usize][k]
    }

    /// Replaces the edge opposite to corner `k` by the other diagonal of the two triangles at it.
    fn flip(&mut self, t: u32, k: usize) {
        let other = self.neighbors[t as usize][k];
        let m = self.neighbors[other as usize].iter().position(|n| *n == t).unwrap_or(0);
        let [p, a, b] = [0, 1, 2].map(|n| self.triangles[t as usize][(k + n) % 3]);
        let [_, pb, pa] = [0, 1, 2].map(|n| self.neighbors[t as usize][(k + n) % 3]);
        let q = self.triangles[other as usize][m];
        // In the other triangle the edge runs from b to a.
        let [qb, qa] = [1, 2].map(|n| self.neighbors[other as usize][(m + n) % 3]);
        // `pb` is across (b, p), `pa` across (p, a), `qb` across (a, q), `qa` across (q, b).
        self.triangles[t as usize] = [p, a, q];
        self.neighbors[t as usize] = [qb, other, pa];
        self.triangles[other as usize] = [p, q, b];
        self.neighbors[other as usize] = [qa, pb, t];
        self.relink(qb, other, t);
        self.relink(pb, t, other);
        for (v, s) in [(p, t), (a, t), (q, t), (b, other)] {
            self.at[v as usize] = s;
        }
    }

    /// The triangles around a point that is not an outer corner, counter-clockwise, each with the index of the point.
    fn around(&self, i: u32) -> impl Iterator<Item = (u32, usize)> + '_ {
        let start = self.at[i as usize];
        let mut next = Some(start);
        std::iter::from_fn(move || {
            let t = next?;
            let k = self.triangles[t as usize].iter().position(|p| *p == i)?;
            let after = self.neighbors[t as usize][(k + 1) % 3];
            next = (after != start && after != NONE).then_some(after);
            Some((t, k))
        })
    }

    /// Makes the line between two points an edge. No other point lies on it, and no earlier line crosses it.
    pub(super) fn constrain(&mut self, a: u32, b: u32) {
        let mut crossing = self.crossed(a, b);
        let (pa, pb) = (self.p(a), self.p(b));
        // Each round of the queue flips at least one edge; edges of a concave pair wait for another round.
        let mut since = 0;
        while let Some((u, v)) = crossing.pop_front() {
            // An edge has an outer corner at most at one end, and triangles all around the other.
            let (u, v) = if u < OUTER { (v, u) } else { (u, v) };
            let edge = self.around(u).find(|(t, k)| self.triangles[*t as usize][(k + 1) % 3] == v);
            let Some((t, k)) = edge else { continue };
            // The edge from u to v is opposite to the corner after v.
            let k = (k + 2) % 3;
            let p = self.triangles[t as usize][k];
            let q = self.opposite(self.neighbors[t as usize][k], t);
            let side = |r: u32| orientation(self.p(p), self.p(q), self.p(r)).signum();
            if side(u) * side(v) >= 0 {
                crossing.push_back((u, v));
                since += 1;
                if since > crossing.len() {
                    debug_assert!(false, "no edge can be flipped");
                    return;
                }
                continue;
            }
            since = 0;
            self.flip(t, k);
            let across = |r: u32| orientation(pa, pb, self.p(r)).signum();
            if ![p, q].iter().any(|r| [a, b].contains(r)) && across(p) * across(q) < 0 {
                crossing.push_back((p, q));
            }
        }
    }

    /// The edges that a line between two points crosses, in order; none if it is an edge.
    fn crossed(&self, a: u32, b: u32) -> std::collections::VecDeque<(u32, u32)> {
        let mut out = std::collections::VecDeque::new();
        let (pa, pb) = (self.p(a), self.p(b));
        let side = |r: u32| orientation(pa, pb, self.p(r));
        let mut next = None;
        for (t, k) in self.around(a) {
            let [right, left] = [1, 2].map(|n| self.triangles[t as usize][(k + n) % 3]);
            if right == b || left == b {
                return out;
            }
            if side(right) < 0 && side(left) > 0 {
                next = Some((t, k));
            }
        }
        while let Some((t, k)) = next {
            let [right, left] = [1, 2].map(|n| self.triangles[t as usize][(k + n) % 3]);
            out.push_back((right, left));
            let other = self.neighbors[t as usize][k];
            let far = self.opposite(other, t);
            if far == b {
                break;
            }
            // The line leaves through the edge between the far corner and the one on its other side.
            let beside = if side(far) > 0 { left } else { right };
            let m = self.triangles[other as usize].iter().position(|p| *p == beside);
            next = m.map(|m| (other, m));
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(made: &Triangulation) {
        for (t, corners) in made.triangles.iter().enumerate() {
            let [a, b, c] = corners.map(|i| made.p(i));
            assert!(orientation(a, b, c) > 0, "{corners:?}");
            for k in 0..3 {
                let other = made.neighbors[t][k];
                if other != NONE {
                    let (from, to) = (corners[(k + 1) % 3], corners[(k + 2) % 3]);
                    let m = made.neighbors[other as usize].iter().position(|n| *n == t as u32).unwrap();
                    let of = made.triangles[other as usize];
                    assert_eq!((of[(m + 1) % 3], of[(m + 2) % 3]), (to, from));
                }
            }
        }
        for (i, t) in made.at.iter().enumerate() {
            assert!(made.triangles[*t as usize].contains(&(i as u32)));
        }
    }

    fn scattered(count: i64, size: i64) -> Vec<Point> {
        let mut points: Vec<Point> = (0..count)
            .map(|i| [(i * i * 7919 + 31 * i) % size, (i * i * i * 104_729 + 17 * i * i) % size])
            .collect();
        points.sort_unstable();
        points.dedup();
        points
    }

    #[test]
    fn triangles_are_delaunay() {
        for (count, size) in [(1, 10), (40, 8), (300, 40), (300, REACH)] {
            let points = scattered(count, size);
            let made = Triangulation::new(&points);
            check(&made);
            // Euler: 2n + 1 triangles for n points inside a triangle.
            assert_eq!(made.triangles.len(), 2 * points.len() + 1);
            for corners in &made.triangles {
                let circle = corners.map(|i| made.p(i));
                assert!(!made.points.iter().any(|p| in_circle(circle, *p)));
            }
        }
    }

    #[test]
    fn lines_become_edges() {
        let points = scattered(200, 5000);
        let mut made = Triangulation::new(&points);
        // A line to each of some points, from the point that is farthest to the left; they meet only there.
        let count = made.points.len() as u32;
        let ends: Vec<u32> = (OUTER + 1..count).step_by(7).collect();
        let is_free = |b: u32, made: &Triangulation| {
            (OUTER + 1..count).all(|c| c == b || orientation(made.p(OUTER), made.p(b), made.p(c)) != 0)
        };
        let ends: Vec<u32> = ends.into_iter().filter(|b| is_free(*b, &made)).collect();
        assert!(ends.len() > 20);
        for b in &ends {
            made.constrain(OUTER, *b);
        }
        check(&made);
        for b in ends {
            assert!(made.triangles.iter().any(|t| t.contains(&OUTER) && t.contains(&b)), "{b}");
        }
    }
}

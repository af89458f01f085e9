//! The area inside outlines, as triangles, and the walls around it.

use std::collections::HashMap;

use super::delaunay::{NONE, OUTER, Triangulation};
use super::planar::{Point, Segment, TooManyCrossings, cut};

/// A boundary edge of the area, with the area on its left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Wall {
    pub(super) from: u32,
    pub(super) to: u32,
    /// The edge of the outline that it is a part of.
    pub(super) source: u32,
}

/// An area: triangles, counter-clockwise, that share their points.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Filled {
    pub(super) points: Vec<Point>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) walls: Vec<Wall>,
}

/// Fills what outlines wind around, in either direction. Outlines may overlap, cross and touch; each is a closed loop.
pub(super) fn fill(outlines: Vec<Segment>) -> Result<Filled, TooManyCrossings> {
    let segments = cut(outlines)?;
    let mut index: HashMap<Point, u32> = HashMap::new();
    let mut points: Vec<Point> = Vec::new();
    let mut number = |p: Point| {
        *index.entry(p).or_insert_with(|| {
            points.push(p);
            points.len() as u32 - 1 + OUTER
        })
    };
    let edges: Vec<(u32, u32)> = segments.iter().map(|s| (number(s.from), number(s.to))).collect();
    let mut made = Triangulation::new(&points);
    edges.iter().for_each(|(a, b)| made.constrain(*a, *b));
    let by_ends: HashMap<(u32, u32), &Segment> = edges.iter().copied().zip(&segments).collect();
    // The edge between two points, and how often outlines run from the first to the second.
    let between = |a: u32, b: u32| {
        let there = by_ends.get(&(a, b)).map(|s| (s.source, s.weight));
        there.or_else(|| by_ends.get(&(b, a)).map(|s| (s.source, -s.weight)))
    };
    let corners = |t: usize, k: usize| [1, 2].map(|n| made.triangles[t][(k + n) % 3]);
    // Winding numbers spread from outside: on the left of an outline they are one more than on its right.
    let mut winding: Vec<Option<i32>> = vec![None; made.triangles.len()];
    let outside = made.triangles.iter().position(|t| t.contains(&0)).unwrap_or(0);
    winding[outside] = Some(0);
    let mut open = vec![outside];
    while let Some(t) = open.pop() {
        let own = winding[t].unwrap_or(0);
        for k in 0..3 {
            let other = made.neighbors[t][k];
            if other != NONE && winding[other as usize].is_none() {
                let [a, b] = corners(t, k);
                winding[other as usize] = Some(own - between(a, b).map_or(0, |(_, weight)| weight));
                open.push(other as usize);
            }
        }
    }
    let is_inside = |t: u32| t != NONE && winding[t as usize].is_some_and(|w| w != 0);
    let mut out = Filled { points, ..Filled::default() };
    for t in (0..made.triangles.len()).filter(|t| is_inside(*t as u32)) {
        // An outer corner is never inside; an edge that the triangulation lacks must not make it so.
        if made.triangles[t].iter().any(|i| *i < OUTER) {
            return Err(TooManyCrossings);
        }
        out.triangles.push(made.triangles[t].map(|i| i - OUTER));
        for k in (0..3).filter(|k| !is_inside(made.neighbors[t][*k])) {
            let [a, b] = corners(t, k);
            let source = between(a, b).map_or(0, |(source, _)| source);
            out.walls.push(Wall { from: a - OUTER, to: b - OUTER, source });
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::super::planar::area;
    use super::*;

    /// A closed loop of points.
    fn outline(points: &[Point]) -> Vec<Segment> {
        let next = points.iter().cycle().skip(1);
        points.iter().zip(next).map(|(a, b)| Segment { from: *a, to: *b, weight: 1, source: 0 }).collect()
    }

    fn rectangle(x: [i64; 2], y: [i64; 2]) -> Vec<Segment> {
        outline(&[[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]])
    }

    fn turned(loop_: &[Segment]) -> Vec<Segment> {
        loop_.iter().map(|s| Segment { from: s.to, to: s.from, ..*s }).collect()
    }

    /// The area, and the length of the walls in steps along the grid.
    fn measured(outlines: Vec<Segment>) -> (i64, i64) {
        let filled = fill(outlines).unwrap();
        let at = |i: u32| filled.points[i as usize];
        let whole: i64 = filled.triangles.iter().map(|t| area(at(t[0]), at(t[1]), at(t[2]))).sum();
        // The walls enclose the same area.
        assert_eq!(whole, filled.walls.iter().map(|w| area([0, 0], at(w.from), at(w.to))).sum::<i64>());
        let steps = |w: &Wall| (0..2).map(|k| (at(w.from)[k] - at(w.to)[k]).abs()).sum::<i64>();
        assert_eq!(whole % 2, 0);
        (whole / 2, filled.walls.iter().map(steps).sum())
    }

    #[test]
    fn holes_islands_and_overlaps() {
        let square = rectangle([0, 10], [0, 10]);
        assert_eq!(measured(square.clone()), (100, 40));
        assert_eq!(measured(turned(&square)), (100, 40));
        let hole = turned(&rectangle([2, 8], [2, 8]));
        assert_eq!(measured([square.clone(), hole.clone()].concat()), (64, 64));
        // A loop of the same direction is no hole; an island in a hole is solid again.
        assert_eq!(measured([square.clone(), turned(&hole)].concat()), (100, 40));
        let island = rectangle([4, 6], [4, 6]);
        assert_eq!(measured([square.clone(), hole, island].concat()), (68, 72));
        // Two that overlap, share an edge, touch at a corner, or are the same.
        assert_eq!(measured([square.clone(), rectangle([5, 15], [5, 15])].concat()), (175, 60));
        assert_eq!(measured([square.clone(), rectangle([10, 15], [0, 10])].concat()), (150, 50));
        assert_eq!(measured([square.clone(), rectangle([10, 15], [10, 15])].concat()), (125, 60));
        assert_eq!(measured([square.clone(), square.clone()].concat()), (100, 40));
        assert_eq!(measured([square.clone(), turned(&square)].concat()), (0, 0));
        assert_eq!(measured(Vec::new()), (0, 0));
        // A figure of eight: both loops are solid, though they wind in opposite directions.
        assert_eq!(measured(outline(&[[0, 0], [10, 10], [10, 0], [0, 10]])).0, 50);
    }

    #[test]
    fn many_random_loops_are_filled_without_gaps() {
        let mut state = 1u64;
        let mut random = |n: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 33) % n) as i64
        };
        for round in 0..200 {
            let size = [6, 40, 1000, 1 << 26][round % 4];
            let mut all = Vec::new();
            for _ in 0..1 + random(4) {
                let points: Vec<Point> = (0..3 + random(12)).map(|_| [random(size), random(size)]).collect();
                all.extend(outline(&points));
            }
            let segments = cut(all.clone()).unwrap();
            let filled = fill(all).unwrap();
            let at = |i: u32| filled.points[i as usize];
            assert!(filled.triangles.iter().all(|t| area(at(t[0]), at(t[1]), at(t[2])) > 0));
            // The middle of each triangle has a winding number that is not 0, by a ray along +x, in thirds.
            let inside = |p: [i64; 2]| {
                let crosses = |s: &Segment| {
                    let [a, b] = [s.from, s.to].map(|q| q.map(|v| 3 * v));
                    let up = a[1] <= p[1] && p[1] < b[1];
                    let down = b[1] <= p[1] && p[1] < a[1];
                    let side = area(a, b, p);
                    if up && side > 0 {
                        s.weight
                    } else if down && side < 0 {
                        -s.weight
                    } else {
                        0
                    }
                };
                segments.iter().map(crosses).sum::<i32>() != 0
            };
            for t in &filled.triangles {
                let [a, b, c] = t.map(at);
                assert!(inside([a[0] + b[0] + c[0], a[1] + b[1] + c[1]]));
            }
            // Every edge has a triangle or a wall on its other side.
            let mut net: HashMap<(u32, u32), i32> = HashMap::new();
            let edges = filled.triangles.iter().flat_map(|[a, b, c]| [(*a, *b), (*b, *c), (*c, *a)]);
            for (a, b) in edges.chain(filled.walls.iter().map(|w| (w.to, w.from))) {
                *net.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
            }
            assert!(net.values().all(|n| *n == 0));
            // Nothing is left out: a wall has no inside beyond it.
            for w in &filled.walls {
                let source = segments
                    .iter()
                    .any(|s| [(s.from, s.to), (s.to, s.from)].contains(&(at(w.from), at(w.to))));
                assert!(source);
            }
        }
    }
}

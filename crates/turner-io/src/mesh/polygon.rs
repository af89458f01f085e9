//! Polygon triangulation: fans for convex polygons, ear clipping for the others.
//!
//! The polygon is projected along its normal (Newell's method: the sum of the cross products of successive corners)
//! onto a coordinate plane. If all corners turn the same way, it is convex and becomes a fan around its first corner.
//! Otherwise ears are clipped: an ear is a convex corner whose triangle with its two neighbours contains no other
//! corner. Clipping it leaves a simple polygon with one corner less. Every simple polygon with more than three
//! corners has at least two ears (Meisters 1975, "Polygons have ears").
//!
//! ```text
//!   e───────d          corner b is an ear: abc contains no other corner
//!   │    ┌──┘          corner c is reflex: it is not an ear, and only
//!   │    c             reflex corners can lie inside a candidate triangle
//!   │     \
//!   a──────b
//! ```
//!
//! A self-intersecting polygon may have no ear; what remains of it becomes a fan. Each candidate is
//! tested against all reflex corners, so time can grow with the cube of the corners; a budget per file bounds it.

use super::MeshError;
use super::error::reserve_some;

/// Point comparisons for ear clipping per file; when they are used up, polygons become fans.
const BUDGET: u64 = 1 << 30;

/// The number of triangles of each polygon, for [`MeshData::polygons`](turner::schema::MeshData::polygons): empty while
/// all are triangles.
#[derive(Debug, Default)]
pub(crate) struct PolygonSizes {
    sizes: Vec<u32>,
    triangles: usize,
}

impl PolygonSizes {
    /// Adds a polygon of `count` triangles after `before` triangles, of which those after the last polygon are their own.
    pub(crate) fn add(&mut self, before: usize, count: usize, name: &str) -> Result<(), MeshError> {
        let single = before.saturating_sub(self.triangles);
        reserve_some(&mut self.sizes, single + 1, name)?;
        self.sizes.extend(std::iter::repeat_n(1, single));
        self.sizes.push(count as u32);
        self.triangles = before + count;
        Ok(())
    }

    /// The list for a mesh of `triangles` triangles.
    pub(crate) fn finish(mut self, triangles: usize, name: &str) -> Result<Vec<u32>, MeshError> {
        if !self.sizes.is_empty() {
            let single = triangles.saturating_sub(self.triangles);
            reserve_some(&mut self.sizes, single, name)?;
            self.sizes.extend(std::iter::repeat_n(1, single));
        }
        Ok(self.sizes)
    }
}

/// Triangulates the polygons of one file.
#[derive(Debug)]
pub(crate) struct Triangulator {
    budget: u64,
    flat: Vec<[f64; 2]>,
    next: Vec<u32>,
    previous: Vec<u32>,
    reflex: Vec<u32>,
    /// Number of non-convex polygons that became fans.
    pub(crate) fanned: usize,
}

impl Triangulator {
    pub(crate) fn new() -> Triangulator {
        let (flat, next, previous, reflex) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Triangulator { budget: BUDGET, flat, next, previous, reflex, fanned: 0 }
    }

    /// Passes the n − 2 triangles of a polygon with n corners to `out`, as corner indices.
    pub(crate) fn cut(
        &mut self,
        corners: usize,
        position: impl Fn(usize) -> [f32; 3],
        out: &mut impl FnMut([usize; 3]),
    ) {
        if corners < 3 {
            return;
        }
        if corners == 3 || !self.flatten(corners, position) || self.is_convex() {
            (1..corners - 1).for_each(|i| out([0, i, i + 1]));
            return;
        }
        self.cut_ears(out);
    }

    /// Projects the corners so that the polygon is counter-clockwise; false if it has no area or is not finite.
    fn flatten(&mut self, corners: usize, position: impl Fn(usize) -> [f32; 3]) -> bool {
        let origin = position(0).map(f64::from);
        let at = |i: usize| {
            let p = position(i).map(f64::from);
            [p[0] - origin[0], p[1] - origin[1], p[2] - origin[2]]
        };
        let mut n = [0.0_f64; 3];
        let mut a = at(corners - 1);
        for i in 0..corners {
            let b = at(i);
            n[0] += (a[1] - b[1]) * (a[2] + b[2]);
            n[1] += (a[2] - b[2]) * (a[0] + b[0]);
            n[2] += (a[0] - b[0]) * (a[1] + b[1]);
            a = b;
        }
        let size = n.map(f64::abs);
        if !size.iter().all(|v| v.is_finite()) || size == [0.0; 3] {
            return false;
        }
        // Drop the coordinate along which the normal is longest.
        let (u, v, axis) = if size[0] >= size[1] && size[0] >= size[2] {
            (1, 2, 0)
        } else if size[1] >= size[2] {
            (2, 0, 1)
        } else {
            (0, 1, 2)
        };
        let (u, v) = if n[axis] > 0.0 { (u, v) } else { (v, u) };
        self.flat.clear();
        self.flat.extend((0..corners).map(|i| {
            let p = at(i);
            [p[u], p[v]]
        }));
        true
    }

    fn is_convex(&self) -> bool {
        let n = self.flat.len();
        (0..n).all(|i| orientation(self.flat[i], self.flat[(i + 1) % n], self.flat[(i + 2) % n]) >= 0.0)
    }

    fn cut_ears(&mut self, out: &mut impl FnMut([usize; 3])) {
        let n = self.flat.len();
        self.next.clear();
        self.next.extend((0..n).map(|i| ((i + 1) % n) as u32));
        self.previous.clear();
        self.previous.extend((0..n).map(|i| ((i + n - 1) % n) as u32));
        self.reflex.clear();
        for i in 0..n {
            if self.orientation_at(i) <= 0.0 {
                self.reflex.push(i as u32);
            }
        }
        let (mut left, mut at, mut since) = (n, 0, 0);
        let mut crossed = false;
        while left > 3 {
            let (before, after) = (self.previous[at] as usize, self.next[at] as usize);
            // A full round without an ear: the polygon intersects itself.
            let give_up = since > left || self.budget == 0;
            crossed |= give_up;
            if give_up || self.is_ear(before, at, after) {
                out([before, at, after]);
                self.next[before] = after as u32;
                self.previous[after] = before as u32;
                left -= 1;
                since = 0;
                if self.budget > 0 {
                    self.budget = self.budget.saturating_sub(self.reflex.len() as u64);
                    // Only the two neighbours can stop being reflex.
                    let flat = &self.flat;
                    let (next, previous) = (&self.next, &self.previous);
                    self.reflex.retain(|&i| {
                        let i = i as usize;
                        let (p, q) = (flat[previous[i] as usize], flat[next[i] as usize]);
                        i != at && !((i == before || i == after) && orientation(p, flat[i], q) > 0.0)
                    });
                }
                // Continue with every second corner; this gives better-shaped triangles.
                at = self.next[after] as usize;
            } else {
                since += 1;
                at = after;
            }
        }
        out([self.previous[at] as usize, at, self.next[at] as usize]);
        self.fanned += usize::from(crossed);
    }

    fn orientation_at(&self, i: usize) -> f64 {
        orientation(self.flat[self.previous[i] as usize], self.flat[i], self.flat[self.next[i] as usize])
    }

    /// Whether a corner is convex and its triangle contains no other corner.
    fn is_ear(&mut self, before: usize, at: usize, after: usize) -> bool {
        let [a, b, c] = [self.flat[before], self.flat[at], self.flat[after]];
        let bulge = orientation(a, b, c);
        if bulge <= 0.0 || bulge.is_nan() {
            self.budget = self.budget.saturating_sub(1);
            return false;
        }
        self.budget = self.budget.saturating_sub(1 + self.reflex.len() as u64);
        self.reflex.iter().all(|&i| {
            let i = i as usize;
            let p = self.flat[i];
            let is_corner = i == before || i == at || i == after || p == a || p == b || p == c;
            is_corner
                || orientation(a, b, p) < 0.0
                || orientation(b, c, p) < 0.0
                || orientation(c, a, p) < 0.0
        })
    }
}

/// Twice the signed area of a triangle, positive if counter-clockwise.
fn orientation(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(points: &[[f32; 2]]) -> Vec<[usize; 3]> {
        let mut out = Vec::new();
        // In a slanted plane.
        let position = |i: usize| [points[i][0], points[i][1], 0.25 * points[i][0] - 0.5 * points[i][1]];
        Triangulator::new().cut(points.len(), position, &mut |t| out.push(t));
        out
    }

    fn area(points: &[[f32; 2]], triangles: &[[usize; 3]]) -> (f64, bool) {
        let areas = triangles.iter().map(|t| {
            let [a, b, c] = t.map(|i| points[i].map(f64::from));
            0.5 * orientation(a, b, c)
        });
        let areas: Vec<f64> = areas.collect();
        (areas.iter().sum(), areas.iter().all(|a| *a >= 0.0) || areas.iter().all(|a| *a <= 0.0))
    }

    #[test]
    fn convex_polygons_become_fans() {
        assert_eq!(cut(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]), [[0, 1, 2]]);
        assert_eq!(cut(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(cut(&[[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]]), [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn concave_polygons_are_covered_once() {
        // Polygons whose fan would overlap itself, starting at each corner, in both orientations.
        let arrow = [[0.0, 0.0], [2.0, 1.0], [0.0, 2.0], [0.5, 1.0]];
        let letter =
            [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [3.0, 4.0], [3.0, 1.0], [1.0, 1.0], [1.0, 4.0], [0.0, 4.0]];
        let comb: Vec<[f32; 2]> = (0..40)
            .map(|i| [i as f32, if i % 2 == 0 { 0.0 } else { 10.0 }])
            .chain([[39.0, -1.0], [0.0, -1.0]])
            .collect();
        for (polygon, expected) in [(&arrow[..], 1.5), (&letter[..], 10.0), (&comb[..], 39.0 + 195.0)] {
            for turned in 0..polygon.len() {
                let mut points = polygon.to_vec();
                points.rotate_left(turned);
                for reversed in [false, true] {
                    if reversed {
                        points.reverse();
                    }
                    let triangles = cut(&points);
                    assert_eq!(triangles.len(), points.len() - 2);
                    let (sum, one_way) = area(&points, &triangles);
                    assert!(one_way && (sum.abs() - expected).abs() < 1e-9, "{sum} {triangles:?}");
                }
            }
        }
    }

    #[test]
    fn what_is_no_polygon_becomes_as_many_triangles() {
        for points in [
            vec![[0.0, 0.0]; 7],
            vec![[f32::NAN, 0.0]; 5],
            (0..9).map(|i| [i as f32, 0.0]).collect(),
            vec![[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]],
            (0..50).map(|i| [((i * 7919) % 101) as f32, ((i * 104_729) % 97) as f32]).collect(),
        ] {
            let triangles = cut(&points);
            assert_eq!(triangles.len(), points.len() - 2);
            assert!(triangles.iter().flatten().all(|&i| i < points.len()));
        }
        assert!(cut(&[[0.0, 0.0], [1.0, 0.0]]).is_empty());
    }

    #[test]
    fn time_is_bounded() {
        // Nearly all corners are reflex: quadratic time, until the budget is used up.
        let points: Vec<[f32; 2]> =
            (0..200_000).map(|i| [i as f32, if i % 2 == 0 { 0.0 } else { 1.0 + (i % 7) as f32 }]).collect();
        let mut count = 0;
        let mut cutter = Triangulator::new();
        cutter.budget = 1 << 22;
        cutter.cut(points.len(), |i| [points[i][0], points[i][1], 0.0], &mut |_| count += 1);
        assert_eq!((count, cutter.fanned), (points.len() - 2, 1));
    }
}

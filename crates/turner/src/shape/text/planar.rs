//! Outlines that may cross, touch and overlap as edges that meet only at their ends.
//!
//! Points lie on a grid of integers, so that all decisions are exact. Where edges cross, both are cut at the nearest grid
//! point, which may move them onto others; this is repeated until nothing crosses (Hobby 1999, "Practical segment
//! intersection with finite precision output", without its hot pixels).

use std::collections::HashMap;

/// A point of the grid, each coordinate within ±[`REACH`].
pub(super) type Point = [i64; 2];
/// The largest coordinate of a point. With it, the predicates below fit into their integers.
pub(super) const REACH: i64 = 1 << 26;

/// A directed edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Segment {
    pub(super) from: Point,
    pub(super) to: Point,
    /// How often the outlines run along it, less how often against it.
    pub(super) weight: i32,
    /// The edge of the outline that it is a part of.
    pub(super) source: u32,
}

/// Why edges could not be cut: they cross too often.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct TooManyCrossings;

/// Most comparisons of two edges, and most edges.
const MOST_COMPARED: u64 = 1 << 30;
const MOST_SEGMENTS: usize = 1 << 22;
/// Rounds of cutting. One is usual, and a second that finds nothing.
const MOST_ROUNDS: u32 = 64;
/// Lists of up to so many edges are compared each with each.
const FEW: usize = 24;

/// Twice the area of a triangle, positive if it is counter-clockwise.
pub(super) fn area(a: Point, b: Point, c: Point) -> i64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Cuts edges until they meet only at their ends. Edges between the same points become one, which is left out if its
/// weight is 0.
pub(super) fn cut(segments: Vec<Segment>) -> Result<Vec<Segment>, TooManyCrossings> {
    let mut segments = merged(segments);
    let mut compared = 0;
    for _ in 0..MOST_ROUNDS {
        let mut cuts = Cuts { segments: &segments, at: Vec::new(), compared };
        let all: Vec<u32> = (0..segments.len() as u32).collect();
        cuts.find(&all)?;
        compared = cuts.compared;
        let mut at = cuts.at;
        if at.is_empty() {
            return Ok(segments);
        }
        at.sort_unstable();
        at.dedup();
        if segments.len() + at.len() > MOST_SEGMENTS {
            return Err(TooManyCrossings);
        }
        let mut next = Vec::with_capacity(segments.len() + at.len());
        let mut rest = at.as_slice();
        for (i, whole) in segments.iter().enumerate() {
            let count = rest.iter().take_while(|(of, _)| *of as usize == i).count();
            let (own, after) = rest.split_at(count);
            rest = after;
            let mut points: Vec<Point> = own.iter().map(|(_, p)| *p).collect();
            let along = |p: &Point| {
                (p[0] - whole.from[0]) * (whole.to[0] - whole.from[0])
                    + (p[1] - whole.from[1]) * (whole.to[1] - whole.from[1])
            };
            points.sort_by_key(along);
            let mut from = whole.from;
            for to in points.into_iter().chain([whole.to]) {
                next.push(Segment { from, to, ..*whole });
                from = to;
            }
        }
        segments = merged(next);
    }
    Err(TooManyCrossings)
}

/// Edges between the same points as one.
fn merged(segments: Vec<Segment>) -> Vec<Segment> {
    let mut index: HashMap<(Point, Point), usize> = HashMap::with_capacity(segments.len());
    let mut out: Vec<Segment> = Vec::with_capacity(segments.len());
    for segment in segments.into_iter().filter(|s| s.from != s.to) {
        if let Some(same) = index.get(&(segment.from, segment.to)) {
            out[*same].weight += segment.weight;
        } else if let Some(turned) = index.get(&(segment.to, segment.from)) {
            out[*turned].weight -= segment.weight;
        } else {
            index.insert((segment.from, segment.to), out.len());
            out.push(segment);
        }
    }
    out.retain(|s| s.weight != 0);
    out
}

struct Cuts<'a> {
    segments: &'a [Segment],
    /// An edge, and a point where it is cut.
    at: Vec<(u32, Point)>,
    compared: u64,
}

impl Cuts<'_> {
    /// Compares all edges of a list whose boxes overlap: the list is divided at the median until it is short.
    fn find(&mut self, list: &[u32]) -> Result<(), TooManyCrossings> {
        if list.len() > FEW {
            let middle = |i: u32, axis: usize| {
                let s = &self.segments[i as usize];
                s.from[axis] + s.to[axis]
            };
            let range = |axis: usize| {
                let values = list.iter().map(|i| middle(*i, axis));
                values.clone().max().unwrap_or(0) - values.min().unwrap_or(0)
            };
            let axis = usize::from(range(1) > range(0));
            let mut middles: Vec<i64> = list.iter().map(|i| middle(*i, axis)).collect();
            let (_, median, _) = middles.select_nth_unstable(list.len() / 2);
            let median = *median;
            let side = |below: bool| -> Vec<u32> {
                let reaches = |i: &&u32| {
                    let s = &self.segments[**i as usize];
                    let (a, b) = (2 * s.from[axis], 2 * s.to[axis]);
                    if below { a.min(b) <= median } else { a.max(b) >= median }
                };
                list.iter().filter(reaches).copied().collect()
            };
            let (low, high) = (side(true), side(false));
            // Both sides must be shorter, otherwise dividing does not end.
            if low.len().max(high.len()) * 8 <= list.len() * 7 {
                self.find(&low)?;
                return self.find(&high);
            }
        }
        self.compared += (list.len() * list.len() / 2) as u64;
        if self.compared > MOST_COMPARED || self.at.len() > 4 * MOST_SEGMENTS {
            return Err(TooManyCrossings);
        }
        for (k, i) in list.iter().enumerate() {
            for j in &list[k + 1..] {
                self.compare(*i, *j);
            }
        }
        Ok(())
    }

    fn compare(&mut self, i: u32, j: u32) {
        let [s, t] = [i, j].map(|i| &self.segments[i as usize]);
        let apart = |axis: usize| {
            s.from[axis].max(s.to[axis]) < t.from[axis].min(t.to[axis])
                || t.from[axis].max(t.to[axis]) < s.from[axis].min(s.to[axis])
        };
        if apart(0) || apart(1) {
            return;
        }
        let of_t = [t.from, t.to].map(|p| area(s.from, s.to, p));
        let of_s = [s.from, s.to].map(|p| area(t.from, t.to, p));
        if of_t[0].signum() * of_t[1].signum() < 0 && of_s[0].signum() * of_s[1].signum() < 0 {
            let p = crossing(s, of_s);
            self.at.extend(
                [(i, s), (j, t)].iter().filter(|(_, s)| p != s.from && p != s.to).map(|(i, _)| (*i, p)),
            );
            return;
        }
        // An end of one on the other.
        for (k, whole, ends, areas) in [(i, s, [t.from, t.to], of_t), (j, t, [s.from, s.to], of_s)] {
            for (p, area) in ends.into_iter().zip(areas) {
                let within = |axis: usize| {
                    let (a, b) = (whole.from[axis], whole.to[axis]);
                    (a.min(b)..=a.max(b)).contains(&p[axis])
                };
                if area == 0 && p != whole.from && p != whole.to && within(0) && within(1) {
                    self.at.push((k, p));
                }
            }
        }
    }
}

/// The grid point nearest to where an edge crosses a line; `sides` are the areas of its ends with that line.
fn crossing(s: &Segment, sides: [i64; 2]) -> Point {
    let (numerator, denominator) = (i128::from(sides[0]), i128::from(sides[0]) - i128::from(sides[1]));
    [0, 1].map(|axis| {
        let way = i128::from(s.to[axis] - s.from[axis]) * numerator;
        // Rounds to nearest; the denominator may be negative.
        let (way, by) = if denominator < 0 { (-way, -denominator) } else { (way, denominator) };
        s.from[axis] + (2 * way + by).div_euclid(2 * by) as i64
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(super) fn segment(from: Point, to: Point) -> Segment {
        Segment { from, to, weight: 1, source: 0 }
    }

    #[test]
    fn crossing_edges_are_cut_where_they_cross() {
        let out = cut(vec![segment([0, 0], [10, 10]), segment([0, 10], [10, 0])]).unwrap();
        assert_eq!(out.len(), 4);
        assert!(out.iter().all(|s| s.from == [5, 5] || s.to == [5, 5]));
        // An end on an edge, and edges on one line that overlap: the part in common is counted twice.
        let out =
            cut(vec![segment([0, 0], [10, 0]), segment([4, 0], [4, 5]), segment([6, 0], [20, 0])]).unwrap();
        let weights: Vec<_> = out.iter().map(|s| (s.from, s.to, s.weight)).collect();
        assert!(
            weights.contains(&([6, 0], [10, 0], 2)) && weights.contains(&([0, 0], [4, 0], 1)),
            "{weights:?}"
        );
        // Edges that cancel.
        assert_eq!(cut(vec![segment([0, 0], [3, 7]), segment([3, 7], [0, 0])]).unwrap(), []);
    }

    #[test]
    fn nothing_crosses_afterwards() {
        // A star of many points on a coarse grid, where cuts move edges onto others.
        let at = |i: i64| [(i * i * 37 + 11 * i) % 50, (i * 53 + i * i * i) % 50];
        let star: Vec<Segment> = (0..60).map(|i| segment(at(i), at(i + 1))).collect();
        let out = cut(star).unwrap();
        let mut check = Cuts { segments: &out, at: Vec::new(), compared: 0 };
        let all: Vec<u32> = (0..out.len() as u32).collect();
        for (k, i) in all.iter().enumerate() {
            all[k + 1..].iter().for_each(|j| check.compare(*i, *j));
        }
        assert!(out.len() > 150 && check.at.is_empty(), "{} {:?}", out.len(), check.at);
        // As many edges enter each point as leave it.
        let mut net: HashMap<Point, i32> = HashMap::new();
        for s in &out {
            *net.entry(s.from).or_default() += s.weight;
            *net.entry(s.to).or_default() -= s.weight;
        }
        net.retain(|_, n| *n != 0);
        assert_eq!(net.keys().filter(|p| **p != at(0) && **p != at(60)).count(), 0);
    }
}

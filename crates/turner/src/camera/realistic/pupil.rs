//! The exit pupil: the directions in which light can leave a point of the film through the lens.
//!
//! A lens is round, so the points of a radius suffice; others are turned. A direction is given by its cosines (p, q):
//! p away from the axis, q across. In these coordinates an area is a projected solid angle, ∫ cos θ dω, so uniform
//! points give every ray the same weight, and the pupil's area A is what the lens does to brightness: a uniform
//! radiance L gives the irradiance A L. This contains both vignetting and cos⁴ θ (pbrt § 5.4.6 samples points of the rear
//! surface with the weight cos⁴ θ / (pdf z²), which has the same mean).
//!
//! ```text
//!            q
//!            |    _..--.       the boundary at 33 angles of the upper half, as distances
//!            |   /      \      from the centre between its two ends on the axis of symmetry
//!            |  |   +----|
//!       -----+---------------> p
//! ```

use std::f64::consts::PI;

use super::lens::Lens;
use crate::math::elementary::{angle, sin_cos_turns};
use crate::math::{DVec2, DVec3};
use crate::sampler::concentric_disk;

/// Intervals of the film's radius.
const RADII: usize = 64;

/// Sectors of half the pupil.
const SECTORS: usize = 32;

/// The tables are larger than the pupil by this factor: between radii and angles it bulges.
const MARGIN: f64 = 1.03;

/// The pupil of one radius.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Node {
    /// Its area, both halves.
    area: f64,
    /// Its centre on the axis p.
    center: f64,
    /// Distance of the boundary from the centre, at multiples of π / SECTORS from the direction of p.
    edge: [f64; SECTORS + 1],
    /// Fractions of the area up to these angles.
    shares: [f64; SECTORS + 1],
}

/// The pupils of all points of the film.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Pupils {
    /// Ascending, from 0.
    radii: Vec<f64>,
    /// One for each radius.
    nodes: Vec<Node>,
    /// Whether the film is dark beyond: the last node is the edge of the image circle.
    ends: bool,
}

/// The place of a radius between two nodes.
#[derive(Clone, Copy)]
pub(super) struct Between<'a> {
    nodes: [&'a Node; 2],
    /// 0 at the first node, 1 at the second.
    fraction: f64,
}

/// Whether a ray leaves the lens.
fn passes(lens: &Lens, r: f64, p: f64, q: f64) -> bool {
    direction(p, q).is_some_and(|d| lens.trace(DVec3::new(r, 0.0, 0.0), d, |_| true).is_some())
}

/// The unit direction with these cosines.
#[inline]
pub(super) fn direction(p: f64, q: f64) -> Option<DVec3> {
    let z2 = 1.0 - p * p - q * q;
    (z2 > 0.0).then(|| DVec3::new(p, q, z2.sqrt()))
}

/// How far the pupil of radius `r` extends from an inner point of the axis in a direction, which is near `guess`.
fn extent(lens: &Lens, r: f64, center: f64, (cos, sin): (f64, f64), guess: f64) -> f64 {
    let is_inside = |t: f64| passes(lens, r, center + t * cos, t * sin);
    let (mut low, mut high) = (0.0, 1.1 * guess.max(1e-6));
    while is_inside(high) {
        (low, high) = (high, 1.3 * high);
    }
    for _ in 0..14 {
        let middle = 0.5 * (low + high);
        if is_inside(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// The ends of a pupil on its axis of symmetry, given where its centre and half its width may be.
fn ends(lens: &Lens, r: f64, guess: f64, half: f64) -> Option<[f64; 2]> {
    /// Points on either side of the guess.
    const TRIED: i32 = 48;
    let mut inside = guess;
    if !passes(lens, r, guess, 0.0) {
        let at = |i: i32| guess + 3.0 * half * f64::from(i) / f64::from(TRIED);
        let open: Vec<i32> = (-TRIED..=TRIED).filter(|i| passes(lens, r, at(*i), 0.0)).collect();
        inside = at(*open.get(open.len() / 2)?);
    }
    if !passes(lens, r, inside, 0.0) {
        return None;
    }
    let to = |side: f64| inside + side * extent(lens, r, inside, (side, 0.0), half);
    Some([to(-1.0), to(1.0)])
}

impl Node {
    /// The pupil of radius `r`, given that of a neighbour.
    fn new(lens: &Lens, r: f64, guess: f64, before: Option<&Node>) -> Option<Node> {
        let half = before.map_or(0.01, |before| 0.5 * (before.edge[0] + before.edge[SECTORS]));
        let [low, high] = ends(lens, r, guess, half)?;
        let center = 0.5 * (low + high);
        let step = 0.5 / SECTORS as f64;
        let mut edge = [0.5 * (high - low); SECTORS + 1];
        for i in 1..SECTORS {
            let (sin, cos) = sin_cos_turns(step * i as f64);
            let guess = before.map_or(edge[i - 1], |before| before.edge[i]);
            edge[i] = extent(lens, r, center, (cos, sin), guess);
        }
        let mut node = Node { area: 0.0, center, edge, shares: [0.0; SECTORS + 1] };
        // The sum of the trapezoid rule over the full turn converges fast where the boundary is smooth.
        let squares = |i: usize| node.edge[i] * node.edge[i];
        let inner: f64 = (1..SECTORS).map(squares).sum();
        node.area = (inner + 0.5 * (squares(0) + squares(SECTORS))) * PI / SECTORS as f64;
        let triangles: f64 = edge.windows(2).map(|e| e[0] * e[1]).sum();
        let mut sum = 0.0;
        for i in 1..SECTORS {
            sum += edge[i - 1] * edge[i];
            node.shares[i] = sum / triangles;
        }
        node.shares[SECTORS] = 1.0;
        (node.area > 0.0 && node.area.is_finite()).then_some(node)
    }
}

impl Pupils {
    /// The pupils of the points within `radius` millimetres of the axis. `None` if no light reaches the centre.
    pub(super) fn new(lens: &Lens, radius: f64) -> Option<Pupils> {
        let first = Node::new(lens, 0.0, 0.0, None)?;
        let fraction = |i: usize| i as f64 / RADII as f64;
        let film = Pupils::within(lens, first, |i| radius * fraction(i));
        if film.nodes.len() > RADII {
            return Some(film);
        }
        // The edge of the image circle is in the next interval.
        let last = film.nodes.len() - 1;
        let half = 0.5 * (film.nodes[last].edge[0] + film.nodes[last].edge[SECTORS]);
        let (mut low, mut high) = (radius * fraction(last), radius * fraction(last + 1));
        for _ in 0..12 {
            let middle = 0.5 * (low + high);
            let is_lit = ends(lens, middle, film.next_center(lens, middle), half).is_some_and(|[a, b]| b > a);
            (low, high) = if is_lit { (middle, high) } else { (low, middle) };
        }
        // The pupil shrinks to a point there, with the root of the distance from the edge.
        let circle = Pupils::within(lens, first, |i| low * fraction(i) * (2.0 - fraction(i)));
        (circle.nodes.len() > 1).then_some(Pupils { ends: true, ..circle })
    }

    /// The nodes at ascending radii, or up to where the film becomes dark.
    fn within(lens: &Lens, first: Node, radius: impl Fn(usize) -> f64) -> Pupils {
        let mut pupils = Pupils { radii: vec![0.0], nodes: vec![first], ends: false };
        for i in 1..=RADII {
            let r = radius(i);
            let Some(node) = Node::new(lens, r, pupils.next_center(lens, r), pupils.nodes.last()) else {
                break;
            };
            pupils.radii.push(r);
            pupils.nodes.push(node);
        }
        pupils
    }

    /// Where the centre of the pupil of a radius beyond the last should be.
    fn next_center(&self, lens: &Lens, r: f64) -> f64 {
        match (&self.nodes[..], &self.radii[..]) {
            ([.., a, b], [.., ra, rb]) => b.center + (b.center - a.center) * ((r - rb) / (rb - ra)),
            _ => r * lens.chief_slope(),
        }
    }

    /// The area of the pupil of the film's centre.
    pub(super) fn central_area(&self) -> f64 {
        self.nodes[0].area
    }

    /// The pupil at a distance from the axis; `None` where the film is dark.
    #[inline]
    pub(super) fn at(&self, r: f64) -> Option<Between<'_>> {
        let last = self.radii.len() - 1;
        if r > self.radii[last] && self.ends {
            return None;
        }
        let i = self.radii.partition_point(|radius| *radius <= r).clamp(1, last);
        let (from, to) = (self.radii[i - 1], self.radii[i]);
        let fraction = ((r - from) / (to - from)).min(1.0);
        Some(Between { nodes: [&self.nodes[i - 1], &self.nodes[i]], fraction })
    }

    /// The radii of the nodes.
    pub(super) fn radii(&self) -> impl Iterator<Item = f64> + '_ {
        self.radii.iter().copied()
    }
}

impl Between<'_> {
    fn mix(&self, of: impl Fn(&Node) -> f64) -> f64 {
        let [a, b] = self.nodes.map(of);
        a + self.fraction * (b - a)
    }

    /// The area of the pupil.
    #[inline]
    pub(super) fn area(&self) -> f64 {
        self.mix(|node| node.area)
    }

    /// The direction cosine of the pupil's centre.
    pub(super) fn center(&self) -> f64 {
        self.mix(|node| node.center)
    }

    /// Maps the unit square to a region that contains the pupil, preserving area; (0.5, 0.5) becomes its centre.
    #[inline]
    pub(super) fn point(&self, u: DVec2) -> DVec2 {
        let disk = concentric_disk(u);
        let radius = disk.length();
        let center = DVec2::new(self.center(), 0.0);
        if radius == 0.0 {
            return center;
        }
        // The sector between two angles, and the position between them.
        let turn = (angle(disk.y.abs(), disk.x) / PI).clamp(0.0, 1.0);
        let share = |i: usize| self.mix(|node| node.shares[i]);
        let (mut low, mut high) = (0, SECTORS);
        while high - low > 1 {
            let middle = (low + high) / 2;
            if share(middle) <= turn { low = middle } else { high = middle }
        }
        let (from, to) = (share(low), share(high));
        let along = if to > from { (turn - from) / (to - from) } else { 0.5 };
        let corner = |i: usize| {
            let (sin, cos) = sin_cos_turns(0.5 / SECTORS as f64 * i as f64);
            DVec2::new(cos, sin) * self.mix(|node| node.edge[i])
        };
        let at = MARGIN * radius * corner(low).lerp(corner(high), along);
        center + if disk.y < 0.0 { DVec2::new(at.x, -at.y) } else { at }
    }
}

//! Dividing long edges.
//!
//! Each pass divides all edges that are too long in their middle, and cuts the triangles beside them:
//!
//! ```text
//!   one edge          two edges, the shorter diagonal        three edges
//!       c                     c                                  c
//!      /|\                   / \                                / \
//!     / | \                 n───m                              n───m
//!    /  |  \               / ⟍  \                             / \ / \
//!   a───m───b             a─────⟍b                           a───k───b
//! ```
//!
//! Whether an edge is divided depends on its two points alone, so both of its triangles agree and no gap opens. The
//! position, (u, v) and colours of its middle are the means of those of its ends.

use std::collections::HashMap;

use super::heights::Heights;
use crate::math::DVec3;
use crate::schema::MeshData;

/// Edges shorter than this fraction of the longest one allowed are not divided, however steep their displacement is.
const SHORTEST: f64 = 1.0 / 8.0;
/// Most passes: a guard against edges that are thousands of times too long, which the number of triangles ends before.
const PASSES: u32 = 32;
/// Normals at one position that differ by less than this are one normal.
const SAME_NORMAL: f64 = 1e-6;

/// A position of the mesh, which all vertices there share.
#[derive(Clone, Copy)]
struct Point {
    /// Before displacement.
    base: DVec3,
    /// The unit vector along which it moves; 0 if there is none.
    direction: DVec3,
    /// Whether its vertices have different normals.
    hard: bool,
    /// The sum of the heights of its vertices, and their number.
    height: f64,
    vertices: u32,
    /// After displacement.
    displaced: DVec3,
}

impl Point {
    fn new(base: DVec3, direction: DVec3) -> Point {
        Point { base, direction, hard: false, height: 0.0, vertices: 0, displaced: base }
    }
}

/// Triangles whose edges are being divided.
pub(super) struct Diced {
    points: Vec<Point>,
    /// For each vertex its point, and its unit normal before displacement; none for meshes without normals.
    point_of: Vec<u32>,
    normals: Vec<DVec3>,
    /// For each vertex `width` values: the sets of (u, v), then its colour.
    values: Vec<f32>,
    width: usize,
    triangles: Vec<[u32; 3]>,
    materials: Vec<u16>,
    /// The edges to divide, by their points, with the new points once they exist.
    marked: HashMap<(u32, u32), u32>,
    /// Vertices below this number have added their heights.
    known: usize,
    curved: bool,
    passes: u32,
}

/// An edge between points or vertices, the smaller number first.
fn edge(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}

impl Diced {
    pub(super) fn new(data: &MeshData, curved: bool) -> Diced {
        let mut points: Vec<Point> = Vec::new();
        let mut by_position: HashMap<[u32; 3], u32> = HashMap::new();
        let mut point_of = Vec::with_capacity(data.positions.len());
        for p in &data.positions {
            // Zeros of both signs are one position.
            let key = p.map(|v| (v + 0.0).to_bits());
            let point = *by_position.entry(key).or_insert_with(|| {
                points.push(Point::new(DVec3::from(p.map(f64::from)), DVec3::ZERO));
                points.len() as u32 - 1
            });
            point_of.push(point);
        }
        let sets = || std::iter::once(&data.uvs).filter(|set| !set.is_empty()).chain(&data.more_uvs);
        let width = 2 * sets().count() + if data.colors.is_empty() { 0 } else { 4 };
        let mut values = Vec::with_capacity(width * point_of.len());
        for i in 0..point_of.len() {
            sets().for_each(|set| values.extend(set[i]));
            if let Some(color) = data.colors.get(i) {
                values.extend(color);
            }
        }
        let own = |n: &[f32; 3]| DVec3::from(n.map(f64::from)).normalize_or_zero();
        let normals = data.normals.iter().map(own).collect();
        let mut diced = Diced {
            points,
            point_of,
            normals,
            values,
            width,
            triangles: data.triangles.clone(),
            materials: data.face_materials.clone(),
            marked: HashMap::new(),
            known: 0,
            curved,
            passes: 0,
        };
        diced.find_directions();
        diced
    }

    /// The directions in which points move: the means of the normals of their vertices; without these, of their triangles.
    fn find_directions(&mut self) {
        if !self.normals.is_empty() {
            return self.find_directions_from(0, 0);
        }
        let sums = self.sums_of_triangles(|p| p.base, |vertex| self.point_of[vertex as usize]);
        for (point, sum) in self.points.iter_mut().zip(sums) {
            point.direction = sum.normalize_or_zero();
        }
    }

    /// The same from vertex normals, for all points and their vertices from these numbers on.
    fn find_directions_from(&mut self, point: usize, vertex: usize) {
        let mut first = vec![None; self.points.len() - point];
        for (&n, &at) in self.normals[vertex..].iter().zip(&self.point_of[vertex..]) {
            let known = first[at as usize - point].get_or_insert(n);
            let own = &mut self.points[at as usize];
            if (*known - n).length() > SAME_NORMAL {
                own.direction += n;
                own.hard = true;
            } else if !own.hard {
                // A seam of the (u, v) must not count a normal twice.
                own.direction = *known;
            }
        }
        self.points[point..].iter_mut().for_each(|p| p.direction = p.direction.normalize_or_zero());
    }

    /// For each group of vertices the sum of the normals of their triangles, weighted by area.
    fn sums_of_triangles(&self, place: impl Fn(&Point) -> DVec3, group: impl Fn(u32) -> u32) -> Vec<DVec3> {
        let mut sums = vec![DVec3::ZERO; self.point_of.len()];
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|v| place(&self.points[self.point_of[v as usize] as usize]));
            let normal = (b - a).cross(c - a);
            if normal.is_finite() {
                triangle.iter().for_each(|v| sums[group(*v) as usize] += normal);
            }
        }
        sums
    }

    /// Moves the points whose vertices are new.
    pub(super) fn displace(&mut self, heights: Option<&Heights<'_>>) {
        let first = self.known;
        self.known = self.point_of.len();
        let Some(heights) = heights else {
            return self.points.iter_mut().for_each(|p| p.displaced = p.base);
        };
        for vertex in first..self.known {
            let point = &mut self.points[self.point_of[vertex] as usize];
            let at = vertex * self.width;
            point.height += heights.at([self.values[at], self.values[at + 1]]);
            point.vertices += 1;
            point.displaced = point.base + point.direction * (point.height / f64::from(point.vertices));
        }
    }

    /// Finds the edges that are too long. Returns how many triangles there will be; `None` if no edge is.
    pub(super) fn mark(&mut self, longest: f64) -> Option<usize> {
        self.marked.clear();
        self.passes += 1;
        if !(longest > 0.0) || self.passes > PASSES {
            return None;
        }
        let mut count = self.triangles.len();
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|v| self.point_of[v as usize]);
            for (a, b) in [(a, b), (b, c), (c, a)] {
                let (p, q) = (&self.points[a as usize], &self.points[b as usize]);
                let long = (p.displaced - q.displaced).length() > longest
                    && (p.base - q.base).length() > SHORTEST * longest;
                if long {
                    self.marked.insert(edge(a, b), u32::MAX);
                    count += 1;
                }
            }
        }
        (!self.marked.is_empty()).then_some(count)
    }

    /// Divides the marked edges.
    pub(super) fn divide(&mut self) {
        let triangles = std::mem::take(&mut self.triangles);
        let materials = std::mem::take(&mut self.materials);
        let (points, vertices) = (self.points.len(), self.point_of.len());
        let mut middles = HashMap::new();
        for (i, [a, b, c]) in triangles.into_iter().enumerate() {
            let before = self.triangles.len();
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(a, b)| self.middle(a, b, &mut middles));
            match (ab, bc, ca) {
                (None, None, None) => self.triangles.push([a, b, c]),
                (Some(m), None, None) => self.triangles.extend([[a, m, c], [m, b, c]]),
                (None, Some(m), None) => self.triangles.extend([[b, m, a], [m, c, a]]),
                (None, None, Some(m)) => self.triangles.extend([[c, m, b], [m, a, b]]),
                (None, Some(m), Some(n)) => self.cut_corner(c, [n, m], [a, b]),
                (Some(m), None, Some(n)) => self.cut_corner(a, [m, n], [b, c]),
                (Some(n), Some(m), None) => self.cut_corner(b, [m, n], [c, a]),
                (Some(k), Some(m), Some(n)) => {
                    self.triangles.extend([[a, k, n], [k, b, m], [n, m, c], [k, m, n]]);
                }
            }
            if let Some(material) = materials.get(i) {
                let made = self.triangles.len() - before;
                self.materials.extend(std::iter::repeat_n(*material, made));
            }
        }
        if !self.normals.is_empty() {
            self.find_directions_from(points, vertices);
        }
    }

    /// Cuts off a corner whose two edges are divided: `next` is the middle of the edge that leaves it, which ends in the
    /// first of `far`; `previous` that of the edge that arrives. The rest is cut along its shorter diagonal.
    fn cut_corner(&mut self, corner: u32, [next, previous]: [u32; 2], [b, c]: [u32; 2]) {
        let at = |v: u32| self.points[self.point_of[v as usize] as usize].base;
        let (to_c, to_b) = ((at(next) - at(c)).length(), (at(previous) - at(b)).length());
        self.triangles.push([corner, next, previous]);
        if to_c < to_b {
            self.triangles.extend([[next, b, c], [next, c, previous]]);
        } else {
            self.triangles.extend([[next, b, previous], [b, c, previous]]);
        }
    }

    /// The vertex in the middle of an edge between vertices, if it is divided.
    fn middle(&mut self, a: u32, b: u32, middles: &mut HashMap<(u32, u32), u32>) -> Option<u32> {
        let (pa, pb) = (self.point_of[a as usize], self.point_of[b as usize]);
        let point = *self.marked.get(&edge(pa, pb))?;
        let point = if point == u32::MAX { self.new_point(pa, pb) } else { point };
        let known = middles.get(&edge(a, b)).copied();
        Some(known.unwrap_or_else(|| {
            let vertex = self.point_of.len() as u32;
            self.point_of.push(point);
            for k in 0..self.width {
                let [x, y] = [a, b].map(|v| self.values[v as usize * self.width + k]);
                self.values.push(0.5 * (x + y));
            }
            if !self.normals.is_empty() {
                let sum = self.normals[a as usize] + self.normals[b as usize];
                self.normals.push(sum.normalize_or_zero());
            }
            middles.insert(edge(a, b), vertex);
            vertex
        }))
    }

    /// The point in the middle of an edge between points. On a curved surface it lies on the cubic whose ends are
    /// perpendicular to the normals there (Vlachos et al. 2001, "Curved PN Triangles").
    fn new_point(&mut self, a: u32, b: u32) -> u32 {
        let (a, b) = edge(a, b);
        let (p, q) = (self.points[a as usize], self.points[b as usize]);
        let mut base = 0.5 * (p.base + q.base);
        if self.curved {
            let along = q.base - p.base;
            let rise = |end: &Point, way: DVec3| {
                if end.hard { DVec3::ZERO } else { end.direction * way.dot(end.direction) }
            };
            base -= (rise(&p, along) + rise(&q, -along)) / 8.0;
        }
        // With vertex normals, the direction follows from those of the new vertices.
        let mean = (p.direction + q.direction).normalize_or_zero();
        let direction = if self.normals.is_empty() { mean } else { DVec3::ZERO };
        self.points.push(Point::new(base, direction));
        let point = self.points.len() as u32 - 1;
        self.marked.insert((a, b), point);
        point
    }

    /// The displaced triangles, with the normals of the displaced surface.
    pub(super) fn into_mesh(mut self, data: &MeshData, smooth: bool) -> MeshData {
        let at = |v: u32| self.points[self.point_of[v as usize] as usize].displaced;
        let mut out = MeshData {
            positions: (0..self.point_of.len() as u32).map(|v| at(v).as_vec3().to_array()).collect(),
            material_names: data.material_names.clone(),
            ..MeshData::default()
        };
        if smooth {
            let group = self.smooth_groups();
            let sums = self.sums_of_triangles(|p| p.displaced, |vertex| group[vertex as usize]);
            let normal = |&group: &u32| sums[group as usize].normalize_or_zero().as_vec3().to_array();
            out.normals = group.iter().map(normal).collect();
        }
        out.triangles = std::mem::take(&mut self.triangles);
        out.face_materials = std::mem::take(&mut self.materials);
        let mut at = 0;
        let mut column = |count: usize| {
            at += count;
            at - count
        };
        let vertices = || self.values.chunks_exact(self.width.max(1));
        let pairs = |first: usize| vertices().map(|v| [v[first], v[first + 1]]).collect();
        if !data.uvs.is_empty() {
            out.uvs = pairs(column(2));
        }
        out.more_uvs = data.more_uvs.iter().map(|_| pairs(column(2))).collect();
        if !data.colors.is_empty() {
            let first = column(4);
            out.colors = vertices().map(|v| [0, 1, 2, 3].map(|k| v[first + k])).collect();
        }
        out
    }

    /// For each vertex the first one with which it shares its shading normal: all at a point, but where their normals
    /// differed, those of one normal.
    fn smooth_groups(&self) -> Vec<u32> {
        let mut first: HashMap<(u32, [u64; 3]), u32> = HashMap::new();
        (0..self.point_of.len() as u32)
            .map(|vertex| {
                let point = self.point_of[vertex as usize];
                let hard = self.points[point as usize].hard;
                let normal = self.normals.get(vertex as usize).filter(|_| hard);
                let key = normal.map_or([0; 3], |n| n.to_array().map(f64::to_bits));
                *first.entry((point, key)).or_insert(vertex)
            })
            .collect()
    }
}

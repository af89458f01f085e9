//! Triangles of solids, for programs that know only meshes: dual contouring (Ju et al. 2002).
//!
//! Rays along the lines of a grid find where the surface crosses its edges. Each cell with crossings has one vertex,
//! the point nearest to the planes of its crossings; each crossed edge has a quadrilateral between the four cells
//! around it. Creases stay sharp, because a vertex there lies on the planes of both sides.

use super::{Solid, SolidGeometry};
use crate::math::{Bounds, DMat3, DVec3, Ray};
use crate::schema::MeshData;
use crate::shape::SurfacePoint;

/// Cells along the longest edge of the bounds.
const CELLS: f64 = 96.0;

/// Weight of the mean of the crossings against their planes: it keeps vertices of flat parts in place.
const MEAN: f64 = 0.05;

/// Least cosine between a triangle and the normals of its vertices; at creases the triangle has its own normal.
const CREASE: f64 = 0.92;

/// Most crossings of one line.
const MAX_CROSSINGS: usize = 1024;

/// The cells around a solid.
struct Grid {
    min: DVec3,
    step: DVec3,
    /// Number of cells along each axis.
    cells: [usize; 3],
    /// Whether each corner of a cell is inside, x fastest.
    inside: Vec<bool>,
}

/// A crossed edge of the grid.
struct Edge {
    axis: usize,
    /// Its lower corner.
    from: [usize; 3],
    /// Whether the lower corner is inside.
    inside: bool,
    /// The position of the material among those of the solid.
    material: u16,
}

/// A crossing of a line.
struct Found {
    /// In cells from the start of the line.
    t: f64,
    surface: SurfacePoint,
    material: u16,
}

/// Crossings of one cell: points and normals.
#[derive(Clone, Default)]
struct Cell {
    crossings: Vec<(DVec3, DVec3)>,
    vertex: DVec3,
}

impl Grid {
    fn new(bounds: &Bounds) -> Grid {
        let size = bounds.size();
        let step = size.max_element() / CELLS;
        let cells = size.to_array().map(|length| (length / step).ceil().max(1.0) as usize + 2);
        let spread = DVec3::from(cells.map(|n| n as f64)) * step;
        // One cell more on all sides, and no grid line in a face of the bounds.
        let min = bounds.center() - 0.5 * spread + DVec3::new(0.013, 0.007, 0.011) * step;
        Grid { min, step: DVec3::splat(step), cells, inside: Vec::new() }
    }

    fn corner(&self, at: [usize; 3]) -> DVec3 {
        self.min + DVec3::from(at.map(|i| i as f64)) * self.step
    }

    fn corner_index(&self, at: [usize; 3]) -> usize {
        (at[2] * (self.cells[1] + 1) + at[1]) * (self.cells[0] + 1) + at[0]
    }

    fn cell_index(&self, at: [usize; 3]) -> usize {
        (at[2] * self.cells[1] + at[1]) * self.cells[0] + at[0]
    }
}

/// The surface along a line of the grid, in order.
fn crossings(solid: &Solid, ray: &Ray, cells: usize) -> Vec<Found> {
    let mut found = Vec::new();
    let mut ray = Ray { t_min: 0.0, t_max: cells as f64, ..*ray };
    while let Some(hit) = solid.intersect(&ray) {
        let surface = solid.surface(&ray, &hit);
        let material = u16::try_from(solid.material_slot(&hit)).unwrap_or(0);
        found.push(Found { t: hit.t, surface, material });
        ray.t_min = (hit.t + 1e-9).max(hit.t.next_up());
        if found.len() >= MAX_CROSSINGS {
            break;
        }
    }
    found
}

/// The point of a cell nearest to the planes of its crossings.
fn vertex(cell: &Cell, low: DVec3, high: DVec3) -> DVec3 {
    let count = cell.crossings.len() as f64;
    let mean = cell.crossings.iter().map(|(p, _)| *p).sum::<DVec3>() / count;
    let mut matrix = DMat3::from_diagonal(DVec3::splat(MEAN * count));
    let mut right = DVec3::ZERO;
    for (p, n) in &cell.crossings {
        matrix += DMat3::from_cols(*n * n.x, *n * n.y, *n * n.z);
        right += *n * n.dot(*p - mean);
    }
    (mean + matrix.inverse() * right).clamp(low, high)
}

/// Triangles with normals that approximate a solid within `bounds`, at a resolution of about a hundredth of the
/// longest edge. The materials of faces are positions in [`SolidGeometry::materials`]. Sheets thinner than a cell may
/// be lost.
pub fn tessellate(solid: &Solid, bounds: &Bounds) -> MeshData {
    let mut mesh = MeshData::default();
    if bounds.is_empty() || !bounds.is_finite() || bounds.size().max_element() <= 0.0 {
        return mesh;
    }
    let mut grid = Grid::new(bounds);
    let count = |extra: usize| grid.cells.iter().map(|n| n + extra).product::<usize>();
    grid.inside = vec![false; count(1)];
    let mut cells = vec![Cell::default(); count(0)];
    let mut edges = Vec::new();
    for axis in 0..3 {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        for j in 0..=grid.cells[b] {
            for k in 0..=grid.cells[c] {
                let mut start = [0; 3];
                (start[b], start[c]) = (j, k);
                let ray = Ray::new(grid.corner(start), DVec3::AXES[axis] * grid.step[axis]);
                line(solid, &ray, (axis, start), &mut grid, &mut cells, &mut edges);
            }
        }
    }
    for z in 0..grid.cells[2] {
        for y in 0..grid.cells[1] {
            for x in 0..grid.cells[0] {
                let cell = &mut cells[grid.cell_index([x, y, z])];
                if !cell.crossings.is_empty() {
                    let low = grid.corner([x, y, z]);
                    cell.vertex = vertex(cell, low, low + grid.step);
                }
            }
        }
    }
    for edge in &edges {
        quadrilateral(edge, &grid, &cells, &mut mesh);
    }
    mesh
}

/// Crosses the edges along one line of the grid. Corners are inside or outside as lines along x find them.
fn line(
    solid: &Solid,
    ray: &Ray,
    (axis, start): (usize, [usize; 3]),
    grid: &mut Grid,
    cells: &mut [Cell],
    edges: &mut Vec<Edge>,
) {
    let found = crossings(solid, ray, grid.cells[axis]);
    let mut next = found.iter().peekable();
    let mut inside = false;
    for i in 0..=grid.cells[axis] {
        let mut at = start;
        at[axis] = i;
        let corner = grid.corner_index(at);
        let mut crossing = None;
        while let Some(Found { surface, material, .. }) = next.next_if(|found| found.t <= i as f64) {
            inside = surface.ng[axis] < 0.0;
            crossing = Some((surface.p, surface.ng, *material));
        }
        let before = if i > 0 { grid.inside[grid.corner_index(lower(at, axis))] } else { false };
        if axis == 0 {
            grid.inside[corner] = inside;
        }
        let after = grid.inside[corner];
        // A closed solid has a surface where the sign changes; an open one only where a ray finds it.
        let crossed = if solid.is_closed() { before != after } else { crossing.is_some() };
        if i == 0 || !crossed {
            continue;
        }
        let before = if solid.is_closed() { before } else { crossing.is_some_and(|(_, n, _)| n[axis] > 0.0) };
        let from = lower(at, axis);
        // Lines along another axis may disagree where the surface runs along an edge.
        let middle = 0.5 * (grid.corner(from) + grid.corner(at));
        let sign = if before { 1.0 } else { -1.0 };
        let (p, n, material) = crossing.unwrap_or((middle, DVec3::AXES[axis] * sign, 0));
        edges.push(Edge { axis, from, inside: before, material });
        for around in cells_around(from, axis, grid).into_iter().flatten() {
            cells[around].crossings.push((p, n));
        }
    }
}

fn lower(mut at: [usize; 3], axis: usize) -> [usize; 3] {
    at[axis] -= 1;
    at
}

/// The four cells around an edge, in a circle about its axis; `None` outside the grid.
fn cells_around(from: [usize; 3], axis: usize, grid: &Grid) -> [Option<usize>; 4] {
    let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
    [(1, 1), (0, 1), (0, 0), (1, 0)].map(|(db, dc)| {
        let mut at = from;
        at[b] = from[b].checked_sub(db)?;
        at[c] = from[c].checked_sub(dc)?;
        (0..3).all(|k| at[k] < grid.cells[k]).then(|| grid.cell_index(at))
    })
}

/// Two triangles across a crossed edge.
fn quadrilateral(edge: &Edge, grid: &Grid, cells: &[Cell], mesh: &mut MeshData) {
    let [Some(a), Some(b), Some(c), Some(d)] = cells_around(edge.from, edge.axis, grid) else { return };
    // The circle runs counter-clockwise as seen from the end of the axis: outwards, if the lower corner is inside.
    let circle = if edge.inside { [a, b, c, d] } else { [d, c, b, a] };
    for triangle in [[0, 1, 2], [0, 2, 3]].map(|t| t.map(|i| &cells[circle[i]])) {
        let [p, q, r] = triangle.map(|cell| cell.vertex);
        let Some(face) = (q - p).cross(r - p).try_normalize() else { continue };
        let first = mesh.positions.len() as u32;
        for cell in triangle {
            let alike = cell.crossings.iter().map(|(_, n)| *n).filter(|n| n.dot(face) > CREASE);
            let normal = alike.sum::<DVec3>().try_normalize().unwrap_or(face);
            let normal = if normal.dot(face) > CREASE { normal } else { face };
            mesh.positions.push(cell.vertex.as_vec3().to_array());
            mesh.normals.push(normal.as_vec3().to_array());
        }
        mesh.triangles.push([first, first + 1, first + 2]);
        mesh.face_materials.push(edge.material);
    }
}

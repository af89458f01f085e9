//! Parametric surfaces: x, y and z as expressions of u and v.
//!
//! The surface becomes a grid of triangles. In each direction the number of cells is doubled until points of all cell
//! edges and diagonals are near enough to the surface. Normals are cross products of the derivatives by u and v, which
//! forward differentiation of the expressions gives exactly.

use super::solid::expression::{Dual, Expression};
use crate::math::{DVec2, DVec3};
use crate::schema::{ErrorCode, Limits, MeshData, Range, SceneError, params};

params! {
    /// A parametric surface: a point for each u and v of two ranges. Ends that coincide are closed, so that spheres and
    /// tori enclose a volume and may be parts of `union` or `difference`. The normal is ∂/∂u × ∂/∂v. The (u, v) of
    /// textures are 0..1 over the ranges.
    pub struct ParametricDesc as "parametric" {
        /// The x coordinate: an expression in u and v, with the functions that an isosurface has.
        x: String = "sin(v) * cos(u)".to_owned();
        /// The y coordinate.
        y: String = "-cos(v)".to_owned();
        /// The z coordinate.
        z: String = "-sin(v) * sin(u)".to_owned();
        /// The first and the last u.
        u_range: DVec2 = DVec2::new(0.0, std::f64::consts::TAU);
        /// The first and the last v.
        v_range: DVec2 = DVec2::new(0.0, std::f64::consts::PI);
        /// The largest distance between an edge of a triangle and the surface, relative to the size of the surface.
        tolerance: f64 = 1e-4, in Range::POSITIVE;
        /// Whether shading is smooth.
        smooth: bool = true;
        /// Whether the normal is turned to the other side.
        flip: bool = false;
    }
    example r#"# A Möbius band.
[[object]]
type = "parametric"
x = "(1 + v * cos(u / 2)) * cos(u)"
y = "v * sin(u / 2)"
z = "(1 + v * cos(u / 2)) * sin(u)"
v_range = [-0.4, 0.4]
material = { color = "goldenrod" }
"#
}

/// Cells in each direction at first, and most of them: two million triangles for a square grid.
const FIRST_CELLS: u32 = 8;
const MOST_CELLS: u32 = 4096;
const MOST_TRIANGLES: u64 = 1 << 21;
/// Bytes per vertex while the mesh is made: position, normal, (u, v), two triangles, and the point in double precision.
const VERTEX_BYTES: u64 = 12 + 12 + 8 + 24 + 24;
/// Where edges are compared with the surface: the middle, where a smooth curve is farthest from its chord, and a point
/// that no low harmonic of the grid shares with the corners.
const COMPARED: [f64; 2] = [0.5, 0.31];
/// Points nearer than this, relative to the size of the surface, coincide.
const SAME: f64 = 1e-9;

/// The three expressions, and where they are evaluated.
struct Surface {
    expressions: [Expression; 3],
    from: DVec2,
    size: DVec2,
}

impl Surface {
    fn new(desc: &ParametricDesc) -> Result<Surface, SceneError> {
        let parse = |key: &str, text: &str| {
            Expression::parse_in(text, &["u", "v"]).map_err(|error| SceneError {
                message: format!("`{key}` of a parametric surface: {}", error.message),
                ..error
            })
        };
        for (key, range) in [("u_range", desc.u_range), ("v_range", desc.v_range)] {
            if !(range.is_finite() && range.x < range.y && (range.y - range.x).is_finite()) {
                let message = format!("`{key}` of a parametric surface must increase, found {range}");
                return Err(SceneError::new(ErrorCode::OutOfRange, message).help("exchange the two numbers"));
            }
        }
        let expressions = [parse("x", &desc.x)?, parse("y", &desc.y)?, parse("z", &desc.z)?];
        let from = DVec2::new(desc.u_range.x, desc.v_range.x);
        Ok(Surface { expressions, from, size: DVec2::new(desc.u_range.y, desc.v_range.y) - from })
    }

    /// The point at fractions of the ranges, and the derivatives.
    fn at(&self, s: DVec2) -> [DVec3; 3] {
        let p = self.from + s * self.size;
        let along = |du: f64, dv: f64| {
            let at = [
                Dual { value: p.x, slope: du },
                Dual { value: p.y, slope: dv },
                Dual { value: 0.0, slope: 0.0 },
            ];
            let [x, y, z] = [0, 1, 2].map(|i| self.expressions[i].evaluate(at));
            (DVec3::new(x.value, y.value, z.value), DVec3::new(x.slope, y.slope, z.slope))
        };
        let ((point, du), (_, dv)) = (along(1.0, 0.0), along(0.0, 1.0));
        [point, du, dv]
    }

    fn point(&self, s: DVec2) -> DVec3 {
        let p = self.from + s * self.size;
        DVec3::from([0, 1, 2].map(|i| self.expressions[i].evaluate([p.x, p.y, 0.0])))
    }

    /// The unit normal. Where the derivatives vanish or are parallel, as at poles, that of a point further inside.
    fn normal(&self, s: DVec2) -> DVec3 {
        let mut step = 0.0;
        for _ in 0..4 {
            let [_, du, dv] = self.at(s + step * (DVec2::splat(0.5) - s));
            let (du, dv) = (du * self.size.x, dv * self.size.y);
            let normal = du.cross(dv);
            let square = du.length_squared().max(dv.length_squared());
            if normal.is_finite() && normal.length() > 1e-7 * square {
                return normal.normalize();
            }
            step = (step * 30.0).max(1e-5);
        }
        DVec3::Y
    }
}

/// The points of a grid.
struct Grid {
    cells: [u32; 2],
    points: Vec<DVec3>,
}

impl Grid {
    fn new(surface: &Surface, cells: [u32; 2]) -> Result<Grid, SceneError> {
        let mut points = Vec::with_capacity((cells[0] as usize + 1) * (cells[1] as usize + 1));
        for (i, j) in (0..=cells[1]).flat_map(|j| (0..=cells[0]).map(move |i| (i, j))) {
            let s = fraction(f64::from(i), f64::from(j), cells);
            let p = surface.point(s);
            if !(p.as_vec3().is_finite()) {
                let at = surface.from + s * surface.size;
                let message = format!("a parametric surface is not finite at u = {}, v = {}", at.x, at.y);
                return Err(
                    SceneError::new(ErrorCode::OutOfRange, message).help("choose ranges without poles")
                );
            }
            points.push(p);
        }
        Ok(Grid { cells, points })
    }

    fn index(&self, i: u32, j: u32) -> usize {
        j as usize * (self.cells[0] as usize + 1) + i as usize
    }

    fn at(&self, i: u32, j: u32) -> DVec3 {
        self.points[self.index(i, j)]
    }

    /// The largest coordinate difference of two points.
    fn size(&self) -> f64 {
        let min = self.points.iter().fold(DVec3::INFINITY, |m, p| m.min(*p));
        let max = self.points.iter().fold(DVec3::NEG_INFINITY, |m, p| m.max(*p));
        (max - min).max_element()
    }

    /// The largest distance between a point of an edge and the surface there: for edges along u, along v, and diagonals.
    fn errors(&self, surface: &Surface) -> [f64; 3] {
        let mut errors = [0.0f64; 3];
        let [w, h] = self.cells;
        for (i, j) in (0..=h).flat_map(|j| (0..=w).map(move |i| (i, j))) {
            let p = self.at(i, j);
            for ([di, dj], error) in [[1, 0], [0, 1], [1, 1]].into_iter().zip(&mut errors) {
                if i + di > w || j + dj > h {
                    continue;
                }
                let q = self.at(i + di, j + dj);
                for t in COMPARED {
                    let at = |i: u32, di: u32| f64::from(i) + t * f64::from(di);
                    let exact = surface.point(fraction(at(i, di), at(j, dj), self.cells));
                    *error = error.max((exact - p.lerp(q, t)).length());
                }
            }
        }
        errors
    }

    /// Gives points that coincide the same bits: rows and columns that are one point, and opposite borders, also if one
    /// of them runs the other way.
    fn close(&mut self) {
        let near = SAME * self.size();
        let [w, h] = self.cells;
        let line = |grid: &Grid, along: u32, last: bool| -> Vec<usize> {
            match (along, last) {
                (0, last) => (0..=w).map(|i| grid.index(i, if last { h } else { 0 })).collect(),
                (_, last) => (0..=h).map(|j| grid.index(if last { w } else { 0 }, j)).collect(),
            }
        };
        for along in [0, 1] {
            let [first, last] = [false, true].map(|end| line(self, along, end));
            for side in [&first, &last] {
                let p = self.points[side[0]];
                if side.iter().all(|i| (self.points[*i] - p).length() <= near) {
                    side.iter().for_each(|i| self.points[*i] = p);
                }
            }
            let turned: Vec<usize> = first.iter().rev().copied().collect();
            for other in [&first, &turned] {
                if last.iter().zip(other).all(|(a, b)| (self.points[*a] - self.points[*b]).length() <= near) {
                    last.iter().zip(other).for_each(|(a, b)| self.points[*a] = self.points[*b]);
                    break;
                }
            }
        }
    }
}

fn fraction(i: f64, j: f64, cells: [u32; 2]) -> DVec2 {
    DVec2::new(i / f64::from(cells[0]), j / f64::from(cells[1]))
}

impl ParametricDesc {
    /// The triangles, and whether they are within the tolerance.
    ///
    /// Errors: those of the expressions; empty ranges; a point that is not finite; more triangles than the limits allow.
    pub(super) fn mesh(&self, limits: &Limits) -> Result<(MeshData, bool), SceneError> {
        let surface = Surface::new(self)?;
        let mut cells = [FIRST_CELLS; 2];
        let (mut grid, reached) = loop {
            let triangles = 2 * u64::from(cells[0]) * u64::from(cells[1]);
            let what = || "a parametric surface".to_owned();
            limits.check_triangles(triangles, what)?;
            limits.memory.need(triangles.saturating_mul(VERTEX_BYTES), what)?;
            let grid = Grid::new(&surface, cells)?;
            let most = self.tolerance * grid.size();
            let [u, v, diagonal] = grid.errors(&surface);
            let mut over = [u > most, v > most];
            if over == [false; 2] && diagonal > most {
                // Twist: finer cells in either direction help, and square ones cost least.
                over = [cells[0] <= cells[1], cells[1] < cells[0]];
            }
            let mut finer = cells;
            for k in 0..2 {
                if over[k] && cells[k] < MOST_CELLS {
                    finer[k] *= 2;
                }
            }
            if finer == cells || 2 * u64::from(finer[0]) * u64::from(finer[1]) > MOST_TRIANGLES {
                break (grid, over == [false; 2]);
            }
            cells = finer;
        };
        grid.close();
        let mut mesh = MeshData::default();
        for (i, j) in (0..=cells[1]).flat_map(|j| (0..=cells[0]).map(move |i| (i, j))) {
            let s = fraction(f64::from(i), f64::from(j), cells);
            mesh.positions.push(grid.at(i, j).as_vec3().to_array());
            mesh.uvs.push(s.as_vec2().to_array());
            if self.smooth {
                let normal = surface.normal(s);
                mesh.normals.push((if self.flip { -normal } else { normal }).as_vec3().to_array());
            }
        }
        for (i, j) in (0..cells[1]).flat_map(|j| (0..cells[0]).map(move |i| (i, j))) {
            let [a, b, c, d] =
                [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| grid.index(i, j) as u32);
            for [a, b, c] in [[a, b, c], [a, c, d]] {
                // At poles, triangles have no area.
                let [p, q, r] = [a, b, c].map(|v| mesh.positions[v as usize]);
                if p != q && q != r && r != p {
                    mesh.triangles.push(if self.flip { [a, c, b] } else { [a, b, c] });
                }
            }
        }
        Ok((mesh, reached))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::solid::csg::open_edges;
    use std::f64::consts::{PI, TAU};

    fn made(desc: &ParametricDesc) -> MeshData {
        let (mesh, reached) = desc.mesh(&Limits::default()).unwrap();
        mesh.check().unwrap();
        assert!(reached);
        mesh
    }

    fn surface(x: &str, y: &str, z: &str, u: [f64; 2], v: [f64; 2]) -> ParametricDesc {
        let [x, y, z] = [x, y, z].map(str::to_owned);
        ParametricDesc { x, y, z, u_range: u.into(), v_range: v.into(), ..ParametricDesc::default() }
    }

    fn at(p: [f32; 3]) -> DVec3 {
        DVec3::from(p.map(f64::from))
    }

    fn area_and_volume(mesh: &MeshData) -> (f64, f64) {
        mesh.triangles.iter().fold((0.0, 0.0), |(area, volume), t| {
            let [a, b, c] = t.map(|i| at(mesh.positions[i as usize]));
            (area + 0.5 * (b - a).cross(c - a).length(), volume + a.dot(b.cross(c)) / 6.0)
        })
    }

    /// Whether normals are on the side of the triangles.
    fn is_oriented(mesh: &MeshData) -> bool {
        mesh.triangles.iter().all(|t| {
            let [a, b, c] = t.map(|i| at(mesh.positions[i as usize]));
            t.iter().all(|i| (b - a).cross(c - a).dot(at(mesh.normals[*i as usize])) > 0.0)
        })
    }

    #[test]
    fn spheres_and_tori_are_closed() {
        let sphere = made(&ParametricDesc::default());
        let (area, volume) = area_and_volume(&sphere);
        assert!(
            (area / (4.0 * PI) - 1.0).abs() < 1e-3 && (volume / (4.0 / 3.0 * PI) - 1.0).abs() < 1e-3,
            "{area} {volume}"
        );
        assert!(open_edges(&sphere) == 0 && is_oriented(&sphere));
        for (p, n) in sphere.positions.iter().zip(&sphere.normals) {
            assert!((at(*p) - at(*n)).length() < 1e-4, "{p:?} {n:?}");
        }
        let torus =
            surface("(2 + cos(v)) * cos(u)", "sin(v)", "-(2 + cos(v)) * sin(u)", [0.0, TAU], [0.0, TAU]);
        let torus = made(&ParametricDesc { tolerance: 1e-5, ..torus });
        let (area, volume) = area_and_volume(&torus);
        assert!(
            (area / (8.0 * PI * PI) - 1.0).abs() < 1e-4 && (volume / (4.0 * PI * PI) - 1.0).abs() < 1e-4,
            "{area} {volume}"
        );
        assert!(open_edges(&torus) == 0 && is_oriented(&torus));
        let flipped = made(&ParametricDesc { flip: true, ..ParametricDesc::default() });
        assert!(is_oriented(&flipped) && area_and_volume(&flipped).1 < 0.0);
    }

    #[test]
    fn open_surfaces() {
        // A helicoid of radius 1 and pitch 2π: the area is the integral of sqrt(1 + r²) over r times the angle.
        let helicoid = surface("v * cos(u)", "u", "v * sin(u)", [0.0, TAU], [-1.0, 1.0]);
        let helicoid = made(&ParametricDesc { tolerance: 1e-5, ..helicoid });
        let exact = TAU * (2f64.sqrt() + crate::math::elementary::ln(1.0 + 2f64.sqrt()));
        assert!((area_and_volume(&helicoid).0 / exact - 1.0).abs() < 1e-3, "{exact}");
        // Its normals: (∂/∂u × ∂/∂v) = (sin u, v, -cos u), normalized.
        for (p, n) in helicoid.positions.iter().zip(&helicoid.normals) {
            let (sin, cos) = crate::math::elementary::sin_cos(f64::from(p[1]));
            let v = f64::from(p[0]) * cos + f64::from(p[2]) * sin;
            assert!((at(*n) - DVec3::new(sin, v, -cos).normalize()).length() < 1e-5, "{p:?} {n:?}");
        }
        // A Möbius band has one border: the edges at which it is open form one closed curve. Where its ends meet, both
        // triangles run the same way along the edge, so those edges count as well.
        let band = surface(
            "(1 + v * cos(u / 2)) * cos(u)",
            "v * sin(u / 2)",
            "(1 + v * cos(u / 2)) * sin(u)",
            [0.0, TAU],
            [-0.4, 0.4],
        );
        let mesh = made(&band);
        let columns = mesh.uvs.iter().filter(|uv| uv[1] == 0.0).count() - 1;
        let rows = mesh.uvs.iter().filter(|uv| uv[0] == 0.0).count() - 1;
        assert_eq!(open_edges(&mesh), 2 * columns + rows);
        // A flat sheet needs no more cells than at first.
        let flat = made(&surface("u", "0", "-v", [0.0, 2.0], [0.0, 3.0]));
        assert!(flat.triangles.len() == 128 && (area_and_volume(&flat).0 - 6.0).abs() < 1e-5);
        assert!(flat.normals.iter().all(|n| *n == [0.0, 1.0, 0.0]));
    }

    #[test]
    fn the_error_is_bounded_or_refused() {
        // The middles of edges, and of cells, of a fine sphere.
        for tolerance in [1e-2, 1e-3] {
            let mesh = made(&ParametricDesc { tolerance, ..ParametricDesc::default() });
            let worst = mesh.triangles.iter().map(|t| {
                let [a, b, c] = t.map(|i| at(mesh.positions[i as usize]));
                1.0 - ((a + b + c) / 3.0).length()
            });
            let worst = worst.fold(0.0, f64::max);
            assert!(worst < 2.0 * 2.0 * tolerance, "{worst} {tolerance}");
        }
        let fault = |desc: &ParametricDesc| desc.mesh(&Limits::default()).unwrap_err().message;
        let default = ParametricDesc::default;
        assert!(
            fault(&ParametricDesc { x: "u + w".into(), ..default() })
                .contains("`x` of a parametric surface: there is no \"w\"")
        );
        assert!(fault(&ParametricDesc { y: "x".into(), ..default() }).contains("no \"x\""));
        assert!(fault(&ParametricDesc { u_range: DVec2::new(1.0, 1.0), ..default() }).contains("`u_range`"));
        assert!(fault(&ParametricDesc { z: "1 / (u - u)".into(), ..default() }).contains("not finite at u"));
        // A shell of eight turns needs many cells along them and few around: 2 million triangles were too few for the same
        // number along both.
        let shell = surface(
            "exp(v / 9) * cos(v) * (1 + 0.9 * cos(u))",
            "3.2 - exp(v / 9) * (3.2 - 0.9 * sin(u))",
            "exp(v / 9) * sin(v) * (1 + 0.9 * cos(u))",
            [0.0, TAU],
            [-50.0, 0.6],
        );
        assert!(made(&shell).triangles.len() as u64 <= MOST_TRIANGLES);
        // A saddle, whose edges along u and v are straight: its diagonals are not.
        let saddle =
            made(&ParametricDesc { tolerance: 1e-3, ..surface("u", "u * v", "v", [-1.0, 1.0], [-1.0, 1.0]) });
        assert!(saddle.triangles.len() > 128);
        // Eight waves, whose zeros are the corners and the middles of the first cells.
        let waves = made(&surface("u", "sin(8 * u)", "v", [0.0, TAU], [0.0, 1.0]));
        let highest = waves.positions.iter().map(|p| p[1]).fold(0.0, f32::max);
        assert!(highest > 0.999, "{highest}");
        // A discontinuity never comes within the tolerance; the triangles stay bounded.
        let step = ParametricDesc { y: "(u - 1) / abs(u - 1.0000001)".into(), ..default() };
        let (mesh, reached) = step.mesh(&Limits::default()).unwrap();
        assert!(!reached && mesh.triangles.len() as u64 <= MOST_TRIANGLES);
        let few = Limits { max_triangles: 1000, ..Limits::default() };
        assert!(default().mesh(&few).is_err());
        // A single point.
        let point = ParametricDesc { x: "0".into(), y: "0".into(), z: "0".into(), ..default() };
        assert!(point.mesh(&Limits::default()).unwrap().0.triangles.is_empty());
    }
}

//! Isosurfaces of expressions, found by interval arithmetic (Snyder 1992; Mitchell 1990, "Robust Ray Intersection with
//! Interval Arithmetic").
//!
//! A piece of the ray whose interval of values does not contain 0 has no crossing; one whose interval of slopes does not
//! contain 0 has at most one, which its ends bracket. Other pieces are halved, down to a small size. No step size has to
//! be given, and no thin sheet is stepped over.

use super::contained::{Contained, Container, Field};
use super::expression::{Dual, Expression, Interval, Number};
use super::line::Line;
use super::roots::refine;
use super::{PrepareSolid, Solid};
use crate::math::DVec3;
use crate::schema::{SceneError, params};
use crate::shape::MeshCache;

params! {
    /// The surface where an expression in x, y and z is 0, within a box; the inside is where it is negative. Signed
    /// distance fields are one kind of such expressions, but any will do. (u, v) are those of a sphere around the centre
    /// of the box.
    pub struct IsosurfaceDesc as "isosurface" {
        /// The expression. It may contain x, y, z, numbers, pi, + - * / ^, parentheses, and the functions abs, sqrt, exp,
        /// ln, sin, cos (in radians), min(a, b, …), max(a, b, …) and length(a, b, …).
        function: String, required, default "x^2 + y^2 + z^2 - 1".to_owned();
        /// Corner of the box with the smallest coordinates.
        min: DVec3 = DVec3::NEG_ONE;
        /// Corner of the box with the largest coordinates.
        max: DVec3 = DVec3::ONE;
        /// Whether the faces of the box close the solid where the surface leaves the box.
        capped: bool = true;
    }
    example r#"# A gyroid with walls, in a sphere.
[[object]]
type = "isosurface"
function = "max(abs(sin(6*x)*cos(6*y) + sin(6*y)*cos(6*z) + sin(6*z)*cos(6*x)) - 0.3, length(x, y, z) - 1)"
min = [-1.1, -1.1, -1.1]
max = [1.1, 1.1, 1.1]
material = { color = "turquoise" }
"#
}

/// Halvings of a line: pieces are not divided below 2^-30 of its length in the box.
const DEPTH: u32 = 30;
/// Most pieces per ray: a bound on the time for functions whose slopes are unbounded.
const MAX_PIECES: u32 = 4096;

/// The function of an isosurface.
#[derive(Clone, Debug)]
pub struct Isosurface {
    expression: Expression,
}

impl PrepareSolid for IsosurfaceDesc {
    fn prepare_solid(&self, _: &mut MeshCache<'_>) -> Result<Solid, SceneError> {
        let expression = Expression::parse(&self.function)?;
        let container = Container::new(self.min, self.max, self.capped, "isosurface")?;
        Ok(Solid::Isosurface(Contained { field: Isosurface { expression }, container }))
    }
}

impl Isosurface {
    /// The values and slopes on a piece of a line.
    fn piece(&self, line: &Line, from: f64, to: f64) -> Dual<Interval> {
        let s = Interval::new(from, to);
        let at = |axis: usize| {
            let (o, d) = (Interval::constant(line.origin[axis]), Interval::constant(line.direction[axis]));
            Dual { value: o + s * d, slope: d }
        };
        self.expression.evaluate([at(0), at(1), at(2)])
    }

    /// The value and slope at a position of a line.
    fn at(&self, line: &Line, s: f64) -> (f64, f64) {
        let p = line.at(s);
        let at = |axis: usize| Dual { value: p[axis], slope: line.direction[axis] };
        let Dual { value, slope } = self.expression.evaluate([at(0), at(1), at(2)]);
        (value, slope)
    }
}

impl Field for Isosurface {
    fn value(&self, p: DVec3) -> f64 {
        self.expression.evaluate(p.to_array())
    }

    fn gradient(&self, p: DVec3) -> (f64, DVec3) {
        let along = |axis: usize| {
            let at = |k: usize| Dual { value: p[k], slope: if k == axis { 1.0 } else { 0.0 } };
            self.expression.evaluate([at(0), at(1), at(2)])
        };
        let [x, y, z] = [along(0), along(1), along(2)];
        (x.value, DVec3::new(x.slope, y.slope, z.slope))
    }

    fn crossings(&self, line: &Line, from: f64, mut visit: impl FnMut(f64) -> bool) {
        // Pieces still to be searched, the nearest on top: at most one more per halving.
        let mut stack = [(0.0, 0.0, 0u32); DEPTH as usize + 2];
        stack[0] = (line.enter, line.exit, 0);
        let (mut height, mut pieces) = (1, 0);
        while height > 0 {
            height -= 1;
            let (a, b, depth) = stack[height];
            pieces += 1;
            if b < from {
                continue;
            }
            let Dual { value, slope } = self.piece(line, a, b);
            if value.excludes_zero() {
                continue;
            }
            let middle = 0.5 * (a + b);
            let end = depth >= DEPTH || !(middle > a && middle < b) || pieces > MAX_PIECES;
            if slope.excludes_zero() || end {
                let below = self.at(line, a).0 < 0.0;
                if (self.at(line, b).0 < 0.0) != below {
                    let root = refine(a, b, below, |s| self.at(line, s));
                    if visit(root) {
                        return;
                    }
                }
                continue;
            }
            stack[height] = (middle, b, depth + 1);
            stack[height + 1] = (a, middle, depth + 1);
            height += 2;
        }
    }

    fn precision(&self) -> f64 {
        1e-10
    }

    fn memory(&self) -> usize {
        self.expression.memory()
    }

    fn tests_per_ray(&self) -> f64 {
        16.0
    }
}

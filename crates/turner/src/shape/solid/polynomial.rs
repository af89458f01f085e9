//! Polynomial surfaces in x, y and z.

use super::contained::{Contained, Container, Field};
use super::line::Line;
use super::roots::{MAX_DEGREE, roots};
use super::{PrepareSolid, Solid};
use crate::math::DVec3;
use crate::schema::{ErrorCode, SceneError, params};
use crate::shape::MeshCache;

params! {
    /// A polynomial surface up to degree 8 within a box: all points where a sum of terms factor · x^i y^j z^k is 0. The
    /// inside is where the sum is negative. (u, v) are those of a sphere around the centre of the box.
    pub struct PolynomialDesc as "polynomial" {
        /// The terms: [[factor, i, j, k], …] with the powers of x, y and z.
        terms: Vec<[f64; 4]>, required, default vec![
            [1.0, 4.0, 0.0, 0.0],
            [1.0, 0.0, 4.0, 0.0],
            [1.0, 0.0, 0.0, 4.0],
            [-1.0, 0.0, 0.0, 0.0],
        ];
        /// Corner of the box with the smallest coordinates.
        min: DVec3 = DVec3::NEG_ONE;
        /// Corner of the box with the largest coordinates.
        max: DVec3 = DVec3::ONE;
        /// Whether the faces of the box close the solid where the surface leaves the box.
        capped: bool = true;
    }
    example r#"# The surface of Cayley: x² + y² + z² − 2xyz = 1.
[[object]]
type = "polynomial"
terms = [[1, 2, 0, 0], [1, 0, 2, 0], [1, 0, 0, 2], [-2, 1, 1, 1], [-1, 0, 0, 0]]
min = [-1.5, -1.5, -1.5]
max = [1.5, 1.5, 1.5]
material = { color = "tomato" }
"#
}

/// One term.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Term {
    factor: f64,
    powers: [usize; 3],
}

/// A polynomial in x, y and z.
#[derive(Clone, Debug)]
pub struct Polynomial {
    terms: Vec<Term>,
}

/// Most terms: all of degree 8 are 165.
const MAX_TERMS: usize = 256;

impl PrepareSolid for PolynomialDesc {
    fn prepare_solid(&self, _: &mut MeshCache<'_>) -> Result<Solid, SceneError> {
        let fault = |message: String, help: &str| {
            Err(SceneError::new(ErrorCode::OutOfRange, message).help(help.to_owned()))
        };
        let mut terms = Vec::with_capacity(self.terms.len());
        for [factor, powers @ ..] in &self.terms {
            let whole = powers.iter().all(|p| *p >= 0.0 && p.floor() == *p);
            if !whole || powers.iter().sum::<f64>() > MAX_DEGREE as f64 {
                let message = format!(
                    "the powers of a term must be whole numbers with a sum of at most {MAX_DEGREE}, found {powers:?}"
                );
                return fault(message, "write a term as [factor, power of x, power of y, power of z]");
            }
            terms.push(Term { factor: *factor, powers: powers.map(|p| p as usize) });
        }
        if terms.len() > MAX_TERMS || terms.iter().all(|t| t.factor == 0.0 || t.powers == [0; 3]) {
            let message =
                format!("a polynomial needs 1 to {MAX_TERMS} terms with x, y or z, found {}", terms.len());
            return fault(
                message,
                "for example `terms = [[1, 2, 0, 0], [1, 0, 2, 0], [1, 0, 0, 2], [-1, 0, 0, 0]]`",
            );
        }
        let container = Container::new(self.min, self.max, self.capped, "polynomial")?;
        Ok(Solid::Polynomial(Contained { field: Polynomial { terms }, container }))
    }
}

/// Coefficients of a polynomial along a line.
type Coefficients = [f64; MAX_DEGREE + 1];

impl Polynomial {
    /// The polynomial along a line, in powers of the distance.
    fn along(&self, line: &Line) -> Coefficients {
        // Powers of o + s d for each axis.
        let mut powers = [[Coefficients::default(); MAX_DEGREE + 1]; 3];
        let used = |axis: usize| self.terms.iter().map(|t| t.powers[axis]).max().unwrap_or(0);
        for (axis, list) in powers.iter_mut().enumerate() {
            list[0][0] = 1.0;
            let (o, d) = (line.origin[axis], line.direction[axis]);
            for n in 1..=used(axis) {
                for i in 0..=n {
                    let below = if i > 0 { list[n - 1][i - 1] } else { 0.0 };
                    list[n][i] = o * list[n - 1][i] + d * below;
                }
            }
        }
        let product = |a: &Coefficients, m: usize, b: &Coefficients, n: usize| {
            let mut out = Coefficients::default();
            for (i, a) in a.iter().enumerate().take(m + 1) {
                for (j, b) in b.iter().enumerate().take(n + 1) {
                    out[i + j] += a * b;
                }
            }
            out
        };
        let mut sum = Coefficients::default();
        for Term { factor, powers: [i, j, k] } in &self.terms {
            let xy = product(&powers[0][*i], *i, &powers[1][*j], *j);
            let xyz = product(&xy, i + j, &powers[2][*k], *k);
            sum.iter_mut().zip(xyz).for_each(|(sum, c)| *sum += factor * c);
        }
        sum
    }
}

impl Field for Polynomial {
    fn value(&self, p: DVec3) -> f64 {
        self.gradient(p).0
    }

    fn gradient(&self, p: DVec3) -> (f64, DVec3) {
        let mut powers = [[1.0; MAX_DEGREE + 1]; 3];
        for (axis, list) in powers.iter_mut().enumerate() {
            for n in 1..=MAX_DEGREE {
                list[n] = list[n - 1] * p[axis];
            }
        }
        let slope = |axis: usize, n: usize| if n == 0 { 0.0 } else { n as f64 * powers[axis][n - 1] };
        let (mut value, mut gradient) = (0.0, DVec3::ZERO);
        for Term { factor, powers: [i, j, k] } in &self.terms {
            let (x, y, z) = (powers[0][*i], powers[1][*j], powers[2][*k]);
            value += factor * x * y * z;
            gradient +=
                *factor * DVec3::new(slope(0, *i) * y * z, x * slope(1, *j) * z, x * y * slope(2, *k));
        }
        (value, gradient)
    }

    fn crossings(&self, line: &Line, _: f64, mut visit: impl FnMut(f64) -> bool) {
        for root in roots(&self.along(line), line.enter, line.exit).as_slice() {
            if visit(*root) {
                return;
            }
        }
    }

    fn precision(&self) -> f64 {
        1e-11
    }

    fn memory(&self) -> usize {
        size_of_val(&self.terms[..])
    }

    fn tests_per_ray(&self) -> f64 {
        4.0
    }
}

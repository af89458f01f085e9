//! Affine transforms and their inverses.

/// The rows of a 3x4 matrix.
pub(crate) type Affine = [[f32; 4]; 3];

/// The same in double precision.
pub(super) type Affine64 = [[f64; 4]; 3];

/// The inverse of a transform, computed in double precision and rounded once: the matrix by which a [`Group`] takes
/// rays into an instance. `None` if there is none, or if a number of either is not finite.
///
/// [`Group`]: crate::Group
pub fn inverse(transform: &Affine) -> Option<Affine> {
    rounded(&inverse64(&transform.map(|row| row.map(f64::from)))?)
}

/// To single precision, if that is finite.
pub(super) fn rounded(matrix: &Affine64) -> Option<Affine> {
    let matrix = matrix.map(|row| row.map(|x| x as f32));
    matrix.iter().flatten().all(|x| x.is_finite()).then_some(matrix)
}

/// By cofactors; `None` if it is not finite.
pub(super) fn inverse64(m: &Affine64) -> Option<Affine64> {
    let column = |j: usize| [m[0][j], m[1][j], m[2][j]];
    let (x, y, z, w) = (column(0), column(1), column(2), column(3));
    let rows = [cross(y, z), cross(z, x), cross(x, y)];
    let determinant = dot(x, rows[0]);
    if determinant == 0.0 {
        return None;
    }
    let inverse = rows.map(|row| {
        let [a, b, c] = row.map(|r| r / determinant);
        [a, b, c, -(a * w[0] + b * w[1] + c * w[2])]
    });
    inverse.iter().flatten().all(|x| x.is_finite()).then_some(inverse)
}

/// Where a moving transform is: component by component, `a * (1 - time) + b * time`.
pub(super) fn between(start: &Affine, end: &Affine, time: f32) -> Affine64 {
    let time = f64::from(time);
    std::array::from_fn(|i| {
        std::array::from_fn(|j| f64::from(start[i][j]) * (1.0 - time) + f64::from(end[i][j]) * time)
    })
}

/// Made larger by a power of two: from the units outside to those of a tree.
pub(super) fn scaled(matrix: &Affine64, scale: f64) -> Affine64 {
    matrix.map(|row| row.map(|x| x * scale))
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

//! Three-component vectors.

pub(super) type Vec3 = [f32; 3];

pub(super) fn add(a: Vec3, b: Vec3) -> Vec3 {
    std::array::from_fn(|i| a[i] + b[i])
}

pub(super) fn sub(a: Vec3, b: Vec3) -> Vec3 {
    std::array::from_fn(|i| a[i] - b[i])
}

pub(super) fn scale(s: f32, a: Vec3) -> Vec3 {
    a.map(|x| s * x)
}

pub(super) fn dot(a: Vec3, b: Vec3) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn length(a: Vec3) -> f32 {
    dot(a, a).sqrt()
}

/// The unit vector along `a`; the z axis for a zero vector.
pub(super) fn normalize(a: Vec3) -> Vec3 {
    let length = length(a);
    if length > 0.0 { scale(1.0 / length, a) } else { [0.0, 0.0, 1.0] }
}

/// Transforms a point by a 3x4 matrix.
pub(super) fn transform(matrix: &[[f32; 4]; 3], p: Vec3) -> Vec3 {
    matrix.map(|[x, y, z, w]| x * p[0] + y * p[1] + z * p[2] + w)
}

/// `4 * 2^doublings` points evenly on the unit circle, by bisecting arcs.
pub(super) fn circle(doublings: u32) -> Vec<[f32; 2]> {
    let mut points = vec![[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
    for _ in 0..doublings {
        let next = points.iter().cycle().skip(1);
        let halved = points.iter().zip(next).flat_map(|(&[a, b], &[c, d])| {
            let (x, y): (f32, f32) = (a + c, b + d);
            let length = (x * x + y * y).sqrt();
            [[a, b], [x / length, y / length]]
        });
        points = halved.collect();
    }
    points
}

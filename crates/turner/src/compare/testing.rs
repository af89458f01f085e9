//! Small images for the tests of metrics.

use super::{Canvas, Pair};

pub(super) fn canvas(width: u32, height: u32, f: impl Fn(u32, u32) -> [f32; 3]) -> Canvas {
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let pixels = places.map(|(x, y)| f(x, y)).map(|[r, g, b]| [r, g, b, 1.0]).collect();
    Canvas { width, height, pixels, has_alpha: false, is_linear: false }
}

pub(super) fn pair(
    width: u32,
    height: u32,
    is_linear: bool,
    a: impl Fn(u32, u32) -> [f32; 3],
    b: impl Fn(u32, u32) -> [f32; 3],
) -> Pair {
    let of = |canvas| Canvas { is_linear, ..canvas };
    Pair::new(of(canvas(width, height, a)), of(canvas(width, height, b))).unwrap()
}

//! Camera rays for eight picture positions at a time.

use turner_bvh::lanes::{Block, F64x8, LANES, Simd, Vec3x8, Work, dispatch};
use turner_bvh::{InstructionSet, RayBlock};

use super::Camera;
use super::pinhole::Pinhole;
use crate::film::FilmDesc;
use crate::math::DVec2;

/// The camera rays through eight picture positions, `x` and `y` in pixels from the top left corner, with unit
/// directions. Fills the lanes of `rays` where `x` is not NaN, and returns the lengths of the original directions.
/// `lens` gives a lane's point on the lens, if there is one.
#[inline]
pub fn camera_rays(
    set: InstructionSet,
    camera: &Camera,
    film: &FilmDesc,
    x: &Block,
    y: &Block,
    lens: impl Fn(usize) -> DVec2,
    rays: &mut RayBlock,
) -> Block {
    let size = [f64::from(film.width), f64::from(film.height)];
    if let Camera::Pinhole(pinhole) = camera {
        return dispatch(set, PinholeRays { pinhole, size, x, y, rays });
    }
    let mut lengths = Block::default();
    for lane in (0..LANES).filter(|lane| !x.0[*lane].is_nan()) {
        let screen = DVec2::new(2.0 * x.0[lane] / size[0] - 1.0, 1.0 - 2.0 * y.0[lane] / size[1]);
        let ray = camera.ray(screen, lens(lane));
        let length = ray.direction.length();
        let direction = ray.direction * length.recip();
        rays.set(lane, ray.origin.to_array(), direction.to_array(), ray.t_min * length, ray.t_max * length);
        lengths.0[lane] = length;
    }
    lengths
}

struct PinholeRays<'a> {
    pinhole: &'a Pinhole,
    size: [f64; 2],
    x: &'a Block,
    y: &'a Block,
    rays: &'a mut RayBlock,
}

impl Work for PinholeRays<'_> {
    /// The lengths of the original directions.
    type Output = Block;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Block {
        let splat = |v: f64| F64x8::splat(simd, v);
        let pixel_x = F64x8::load(simd, self.x);
        let x = splat(2.0) * pixel_x / splat(self.size[0]) - splat(1.0);
        let y = splat(1.0) - splat(2.0) * F64x8::load(simd, self.y) / splat(self.size[1]);
        let (d, [t_min, t_max]) = self.pinhole.directions(simd, x, y);
        let length = d.dot(d).sqrt();
        let (rays, mut lengths) = (self.rays, Block::default());
        Vec3x8::splat(simd, self.pinhole.position().to_array()).store(&mut rays.origin);
        (d * (splat(1.0) / length)).store(&mut rays.direction);
        (splat(t_min) * length).store(&mut rays.t_min);
        pixel_x.is_nan().select(pixel_x, splat(t_max) * length).store(&mut rays.t_max);
        length.store(&mut lengths);
        lengths
    }
}

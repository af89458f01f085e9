//! Rays of a rendering: camera rays, shadow rays, and rays around the visible points.

use super::math::{add, cross, dot, length, normalize, scale, sub};
use super::{Camera, Random, Scene};
use crate::Ray;

/// Secondary rays start this fraction of the scene's extent away from the surface.
const OFFSET: f32 = 2e-5;

/// A point that a camera ray hits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// The point, slightly offset from the surface.
    pub position: [f32; 3],
    /// The unit normal of the triangle, on the side of the incoming ray.
    pub normal: [f32; 3],
}

/// Camera rays through a square of `resolution` by `resolution` pixels, in Morton order, at a random position in each
/// pixel. Directions have length 1.
pub fn primary(camera: &Camera, resolution: u32) -> Vec<Ray> {
    let forward = normalize(sub(camera.target, camera.eye));
    let right = normalize(cross(forward, camera.up));
    let up = cross(right, forward);
    let mut random = Random::new(11);
    let side = u64::from(resolution.next_power_of_two());
    let pixels = (0..side * side).map(|i| (every_second_bit(i), every_second_bit(i >> 1)));
    let inside = pixels.filter(|&(x, y)| x < resolution && y < resolution);
    let rays = inside.map(|(x, y)| {
        let mut film_position = |pixel: u32| {
            let at = (pixel as f32 + random.unit()) / resolution as f32;
            camera.half_width * (2.0 * at - 1.0)
        };
        let (x, y) = (film_position(x), film_position(y));
        let direction = add(forward, add(scale(x, right), scale(-y, up)));
        Ray::new(camera.eye, normalize(direction))
    });
    rays.collect()
}

/// The bits 0, 2, 4, … of a Morton code.
fn every_second_bit(code: u64) -> u32 {
    (0..32).fold(0, |all, bit| all | ((code >> (2 * bit) & 1) << bit) as u32)
}

/// The point at which a ray hits a triangle of the scene at `t`. `None` if the triangle has no area.
pub fn point(scene: &Scene, extent: f32, ray: &Ray, t: f32, instance: u32, primitive: u32) -> Option<Point> {
    let [a, b, c] = scene.triangle(instance, primitive);
    let normal = cross(sub(b, a), sub(c, a));
    let area = length(normal);
    if !(area > 0.0 && area.is_finite()) {
        return None;
    }
    let side = if dot(normal, ray.direction) > 0.0 { -1.0 } else { 1.0 };
    let normal = scale(side / area, normal);
    Some(Point { position: add(ray.at(t), scale(OFFSET * extent, normal)), normal })
}

/// Shadow rays from each point to a point light: a hit at `0 <= t <= t_max` is an occluder.
pub fn shadow(points: &[Point], light: [f32; 3]) -> Vec<Ray> {
    let towards = points.iter().map(|point| {
        let to_light = sub(light, point.position);
        Ray { t_max: 0.9999 * length(to_light), ..Ray::new(point.position, normalize(to_light)) }
    });
    towards.collect()
}

/// Rays from each point in a cosine-distributed direction: diffuse interreflection.
pub fn diffuse(points: &[Point]) -> Vec<Ray> {
    from_points(points, f32::INFINITY, 13)
}

/// As [`diffuse`], up to the distance `reach`: ambient occlusion.
pub fn ambient(points: &[Point], reach: f32) -> Vec<Ray> {
    from_points(points, reach, 17)
}

fn from_points(points: &[Point], t_max: f32, seed: u64) -> Vec<Ray> {
    let mut random = Random::new(seed);
    let away = points.iter().map(|point| {
        let direction = random.cosine(point.normal);
        Ray { t_max, ..Ray::new(point.position, direction) }
    });
    away.collect()
}

//! Renders 400 spheres as characters: nearer spheres are darker.
//!
//! `cargo run -p turner-bvh --example nearest_sphere`

use turner_bvh::{Aabb, BuildError, Bvh2, Bvh2Options, Ray};

struct Sphere {
    center: [f32; 3],
    radius: f32,
}

impl Sphere {
    /// The nearest intersection with `t_min <= t <= t_max`.
    fn hit(&self, ray: &Ray, t_max: f32) -> Option<f32> {
        let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let to_center: [f32; 3] = std::array::from_fn(|i| self.center[i] - ray.origin[i]);
        let a = dot(ray.direction, ray.direction);
        let b = dot(to_center, ray.direction);
        let c = dot(to_center, to_center) - self.radius * self.radius;
        let discriminant = b * b - a * c;
        let t = (b - discriminant.max(0.0).sqrt()) / a;
        (discriminant >= 0.0 && t >= ray.t_min && t <= t_max).then_some(t)
    }
}

fn main() -> Result<(), BuildError> {
    // A curved sheet of 20 x 20 spheres.
    let spheres: Vec<Sphere> = (0..400)
        .map(|i| ((i % 20) as f32 - 9.5, (i / 20) as f32))
        .map(|(x, z)| Sphere { center: [x, 0.05 * x * x - 0.02 * z * z, z], radius: 0.45 })
        .collect();
    // Boxes slightly larger than the spheres, for the rounding in `hit`.
    let boxes: Vec<Aabb> = spheres
        .iter()
        .map(|s| Aabb::new(s.center.map(|c| c - 1.001 * s.radius), s.center.map(|c| c + 1.001 * s.radius)))
        .collect();
    let bvh = Bvh2::build(&boxes, &Bvh2Options::default())?;
    println!("{:?}", bvh.stats());

    let in_order: Vec<&Sphere> = bvh.order().iter().map(|&i| &spheres[i as usize]).collect();
    for row in 0..40 {
        let line = (0..100).map(|column| {
            let ray =
                Ray::new([0.0, 4.0, -12.0], [(column as f32 - 49.5) / 90.0, (12.0 - row as f32) / 45.0, 1.0]);
            let t = bvh.closest(&ray, |range, t_max| {
                let leaf = &in_order[range.start as usize..range.end as usize];
                leaf.iter().fold(t_max, |t_max, sphere| sphere.hit(&ray, t_max).unwrap_or(t_max))
            });
            if t == f32::INFINITY {
                ' '
            } else {
                char::from(b"@%#*+=-:."[((t - 10.0) / 2.5).clamp(0.0, 8.0) as usize])
            }
        });
        println!("{}", line.collect::<String>().trim_end());
    }
    Ok(())
}

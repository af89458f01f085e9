//! Points on the outline of a shape, for framing and drawing it.

use super::Shape;
use super::solid::SolidGeometry;
use crate::math::DVec3;
use crate::math::elementary::sin_cos;

/// Points per circle.
const CIRCLE_POINTS: u32 = 48;
/// At most about this many vertices of a mesh or points of a cloud are used; of more, every n-th.
const MAX_POINTS: usize = 4096;

fn circle([center, x, y]: [DVec3; 3]) -> impl Iterator<Item = DVec3> {
    (0..CIRCLE_POINTS).map(move |i| {
        let (s, c) = sin_cos(std::f64::consts::TAU * f64::from(i) / f64::from(CIRCLE_POINTS));
        center + c * x + s * y
    })
}

/// The vertices that reach farthest in each of 26 directions: those of a large mesh that are not to be left out.
fn farthest(positions: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let mut directions = Vec::new();
    for i in 0..27 {
        let d = [i / 9, i / 3 % 3, i % 3].map(|v| v as f32 - 1.0);
        let length = d.iter().map(|v| v * v).sum::<f32>().sqrt();
        if length > 0.0 {
            directions.push((d.map(|v| v / length), f32::NEG_INFINITY, [0.0; 3]));
        }
    }
    for p in positions {
        for (d, most, at) in &mut directions {
            let reach = d[0] * p[0] + d[1] * p[1] + d[2] * p[2];
            if reach > *most {
                (*most, *at) = (reach, *p);
            }
        }
    }
    directions.into_iter().filter(|(_, most, _)| most.is_finite()).map(|(_, _, at)| at).collect()
}

impl Shape {
    /// Surface points in the shape's own space whose convex hull approximates that of the shape. Empty for
    /// unbounded shapes. Spheres and tori are sampled by circles, large meshes by some of their vertices.
    pub(crate) fn hull_points(&self) -> Vec<DVec3> {
        match self {
            Shape::Plane(_) => Vec::new(),
            Shape::Sphere(s) => {
                let n = i32::try_from(CIRCLE_POINTS / 4).unwrap_or(1);
                let latitudes =
                    (-n + 1..n).map(|i| std::f64::consts::FRAC_PI_2 * f64::from(i) / f64::from(n));
                let ends = [DVec3::Y, DVec3::NEG_Y].map(|y| s.center + s.radius * y);
                latitudes
                    .flat_map(|latitude| {
                        let (y, r) = sin_cos(latitude);
                        let center = s.center + s.radius * y * DVec3::Y;
                        circle([center, s.radius * r * DVec3::X, s.radius * r * DVec3::Z])
                    })
                    .chain(ends)
                    .collect()
            }
            Shape::Box(b) => (0..8)
                .map(|i| {
                    let pick = |bit: u32, low: f64, high: f64| if i >> bit & 1 == 1 { high } else { low };
                    DVec3::new(
                        pick(0, b.min.x, b.max.x),
                        pick(1, b.min.y, b.max.y),
                        pick(2, b.min.z, b.max.z),
                    )
                })
                .collect(),
            Shape::Disk(d) => {
                let (center, x, y, _) = d.center_and_radii();
                circle([center, x, y]).collect()
            }
            Shape::Rectangle(r) => {
                let (corner, u, v) = r.corner_and_edges();
                vec![corner, corner + u, corner + u + v, corner + v]
            }
            Shape::Cylinder(c) => c.rims().into_iter().flat_map(circle).collect(),
            Shape::Cone(c) => c.rims().into_iter().flat_map(circle).collect(),
            Shape::Torus(t) => {
                let (center, [x, y, z], radius, tube) = t.ring();
                circle([DVec3::ZERO, x, y])
                    .flat_map(|out| circle([center + radius * out, tube * out, tube * z]))
                    .collect()
            }
            Shape::Mesh(mesh) => {
                let positions = &mesh.data().positions;
                let step = positions.len() / MAX_POINTS + 1;
                let chosen = positions.iter().step_by(step);
                let farthest = if step > 1 { farthest(positions) } else { Vec::new() };
                let vertices = chosen.chain(&farthest).map(|p| DVec3::from(p.map(f64::from)));
                vertices.filter(|p| p.is_finite()).collect()
            }
            Shape::Points(points) => {
                let step = points.count() / MAX_POINTS + 1;
                points.spheres().step_by(step).map(|(_, s)| s.center).collect()
            }
            Shape::Curves(curves) => {
                let positions = curves.positions();
                let step = positions.len() / MAX_POINTS + 1;
                let chosen = positions.iter().step_by(step).map(|p| DVec3::from(p.map(f64::from)));
                chosen.filter(|p| p.is_finite()).collect()
            }
            Shape::Solid(s) => s.hull_points(),
        }
    }
}

//! Points that show the extent of a shape, for drawings of it.

use super::Shape;
use crate::math::DVec3;
use crate::math::elementary::sin_cos;

/// Points to a circle.
const ROUND: u32 = 48;
/// The most vertices of a mesh, or points of a cloud, that are taken: every so manieth of more.
const MOST: usize = 4096;

fn circle([middle, x, y]: [DVec3; 3]) -> impl Iterator<Item = DVec3> {
    (0..ROUND).map(move |i| {
        let (s, c) = sin_cos(std::f64::consts::TAU * f64::from(i) / f64::from(ROUND));
        middle + c * x + s * y
    })
}

impl Shape {
    /// Points of the surface in the shape's own space, whose convex hull is that of the shape, nearly; none of a shape without bounds. Spheres
    /// and tori are given by circles, large meshes by some of their vertices.
    pub(crate) fn hull_points(&self) -> Vec<DVec3> {
        match self {
            Shape::Plane(_) => Vec::new(),
            Shape::Sphere(s) => {
                let n = i32::try_from(ROUND / 4).unwrap_or(1);
                let latitudes =
                    (-n + 1..n).map(|i| std::f64::consts::FRAC_PI_2 * f64::from(i) / f64::from(n));
                let ends = [DVec3::Y, DVec3::NEG_Y].map(|y| s.center + s.radius * y);
                latitudes
                    .flat_map(|latitude| {
                        let (y, r) = sin_cos(latitude);
                        let middle = s.center + s.radius * y * DVec3::Y;
                        circle([middle, s.radius * r * DVec3::X, s.radius * r * DVec3::Z])
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
                let (middle, x, y, _) = d.center_and_radii();
                circle([middle, x, y]).collect()
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
                let vertices = positions.iter().step_by(positions.len() / MOST + 1);
                vertices.map(|p| DVec3::from(p.map(f64::from))).filter(|p| p.is_finite()).collect()
            }
            Shape::Points(points) => {
                let step = points.count() / MOST + 1;
                points.spheres().step_by(step).map(|(_, s)| s.center).collect()
            }
        }
    }
}

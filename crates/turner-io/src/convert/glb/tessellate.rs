//! Tessellates analytic shapes.
//!
//! A circle has 96 corners, so a curved surface lies at most 1 − cos(π/96) = 0.054 % of its radius inside the true
//! surface. Normals are those of the true surface; (u, v) are those of the shape.

use turner::description::SceneDesc;
use turner::math::elementary::{cos, sin};
use turner::math::{Bounds, DVec3};
use turner::schema::{ErrorCode, MaterialId, MeshData, SceneError};
use turner::shape::curves::MAX_TRIANGLES;
use turner::shape::solid::{SolidGeometry, tessellate};
use turner::shape::{MeshCache, Shape, ShapeDesc};

/// Corners of a circle.
const SIDES: u32 = 96;
const TAU: f64 = 2.0 * std::f64::consts::PI;

/// A mesh under construction.
#[derive(Default)]
struct Builder(MeshData);

impl Builder {
    fn vertex(&mut self, p: DVec3, n: DVec3, u: f64, v: f64) {
        self.0.positions.push(p.as_vec3().to_array());
        self.0.normals.push(n.as_vec3().to_array());
        self.0.uvs.push([u as f32, v as f32]);
    }

    /// Adds a grid of `columns` by `rows` quads. `at` maps the parameters s and t in 0..=1 to position, normal
    /// and (u, v). Triangles are counter-clockwise seen from the side of ∂p/∂s × ∂p/∂t.
    fn grid(&mut self, columns: u32, rows: u32, at: impl Fn(f64, f64) -> (DVec3, DVec3, f64, f64)) {
        let first = self.0.positions.len() as u32;
        for j in 0..=rows {
            for i in 0..=columns {
                let (p, n, u, v) = at(f64::from(i) / f64::from(columns), f64::from(j) / f64::from(rows));
                self.vertex(p, n, u, v);
            }
        }
        for j in 0..rows {
            for i in 0..columns {
                let a = first + j * (columns + 1) + i;
                let [b, c, d] = [a + 1, a + columns + 2, a + columns + 1];
                for triangle in [[a, b, c], [a, c, d]] {
                    // Skip degenerate triangles at poles and tips.
                    let [p, q, r] = triangle.map(|k| self.0.positions[k as usize]);
                    if p != q && q != r && r != p {
                        self.0.triangles.push(triangle);
                    }
                }
            }
        }
    }

    /// Adds a disk or annulus facing `n`; `polar` as in [`DiskDesc`](turner::shape::DiskDesc).
    fn disk(&mut self, center: DVec3, n: DVec3, [radius, inner]: [f64; 2], polar: bool) {
        let (right, up) = plane_axes(n);
        let rows = 1;
        self.grid(SIDES, rows, |s, t| {
            // t runs inwards, so that ∂p/∂s × ∂p/∂t points along n.
            let r = radius + (inner - radius) * t;
            let (x, y) = (cos(TAU * s) * r, sin(TAU * s) * r);
            let (u, v) = if polar { (s, t) } else { (0.5 + 0.5 * x / radius, 0.5 + 0.5 * y / radius) };
            (center + right * x + up * y, n, u, v)
        });
    }

    /// Adds the side of a cone or cylinder.
    fn side(&mut self, from: DVec3, to: DVec3, [bottom, top]: [f64; 2]) {
        let axis = to - from;
        let length = axis.length();
        let direction = axis / length;
        let (zero, quarter) = perpendicular(direction);
        // A decreasing radius tilts the normal towards the axis direction.
        let lean = (bottom - top) / length;
        self.grid(SIDES, 1, |s, t| {
            let out = zero * cos(TAU * s) + quarter * sin(TAU * s);
            let p = from + axis * t + out * (bottom + (top - bottom) * t);
            (p, (out + direction * lean).normalize(), s, t)
        });
    }
}

/// Two directions perpendicular to an axis, at u = 0 and u = 1/4, counter-clockwise seen from its tip; for +y they
/// are −z and −x.
fn perpendicular(axis: DVec3) -> (DVec3, DVec3) {
    let flat = |v: DVec3| (v - axis * axis.dot(v)).try_normalize();
    let zero = if axis.z.abs() > 1.0 - 1e-6 { None } else { flat(DVec3::NEG_Z) };
    let zero = zero.or_else(|| flat(DVec3::NEG_Y)).unwrap_or(DVec3::NEG_Z);
    (zero, axis.cross(zero))
}

/// The directions right and up in a plane, seen from the side of its normal.
fn plane_axes(n: DVec3) -> (DVec3, DVec3) {
    if n.y.abs() > 1.0 - 1e-9 {
        return (DVec3::X, n.cross(DVec3::X));
    }
    let right = DVec3::Y.cross(n).try_normalize().unwrap_or(DVec3::X);
    (right, n.cross(right))
}

fn unit(v: DVec3) -> Result<DVec3, SceneError> {
    let message = "a shape with a zero direction vector cannot be tessellated";
    v.try_normalize().ok_or_else(|| SceneError::new(ErrorCode::OutOfRange, message))
}

/// The triangles of a shape.
pub(super) struct Tessellated {
    pub(super) mesh: MeshData,
    /// The materials of its parts, as for meshes; empty if it has no parts with materials.
    pub(super) materials: Vec<Option<MaterialId>>,
}

/// Tessellates a solid; `reach` is half the side of the cube that is left of an unbounded one.
fn solid(shape: &ShapeDesc, desc: &SceneDesc, reach: f64) -> Result<Tessellated, SceneError> {
    let mut cache = MeshCache::new(&desc.meshes).with_images(&desc.images);
    let solid = match shape.prepare(&mut cache)? {
        Shape::Solid(solid) => solid,
        Shape::Mesh(mesh) => {
            let materials =
                if let ShapeDesc::Mesh(desc) = shape { desc.materials.clone() } else { Vec::new() };
            return Ok(Tessellated { mesh: MeshData::clone(mesh.data()), materials });
        }
        _ => {
            let message = format!("there is no tessellation of the shape \"{}\"", shape.type_name());
            return Err(SceneError::new(ErrorCode::Internal, message));
        }
    };
    let bounds = solid.bounds().unwrap_or(Bounds::new(DVec3::splat(-reach), DVec3::splat(reach)));
    Ok(Tessellated { mesh: tessellate(&solid, &bounds), materials: solid.materials().to_vec() })
}

/// Curves as tubes.
fn curves(shape: &ShapeDesc, desc: &SceneDesc) -> Result<Tessellated, SceneError> {
    let mut cache = MeshCache::new(&desc.meshes);
    let mesh = match shape.prepare(&mut cache)? {
        Shape::Curves(curves) => curves.tubes().ok_or_else(|| {
            let message = format!("{} triangles of curves; at most {MAX_TRIANGLES}", curves.triangles());
            SceneError::new(ErrorCode::TooLarge, message)
        })?,
        _ => MeshData::default(),
    };
    Ok(Tessellated { mesh, materials: Vec::new() })
}

/// Tessellates a shape of a scene; `reach` is half the side of infinite planes. `None` for meshes that are not
/// subdivided, and points.
pub(super) fn triangles(
    shape: &ShapeDesc,
    desc: &SceneDesc,
    reach: f64,
) -> Result<Option<Tessellated>, SceneError> {
    let mut b = Builder::default();
    match shape {
        ShapeDesc::Sphere(s) => b.grid(SIDES, SIDES / 2, |u, v| {
            let (height, azimuth) = (TAU / 2.0 * (v - 0.5), TAU * u);
            let flat = if v == 0.0 || v == 1.0 { 0.0 } else { cos(height) };
            let n = DVec3::new(-sin(azimuth) * flat, sin(height), -cos(azimuth) * flat);
            // Make the seam close exactly.
            let n = if u == 1.0 { DVec3::new(0.0, n.y, -flat) } else { n };
            (s.center + n * s.radius, n, u, v)
        }),
        ShapeDesc::Plane(p) => {
            let n = unit(p.normal)?;
            let (right, up) = plane_axes(n);
            b.grid(1, 1, |s, t| {
                let (x, y) = ((2.0 * s - 1.0) * reach, (2.0 * t - 1.0) * reach);
                (p.point + right * x + up * y, n, 0.5 + 0.5 * x, 0.5 + 0.5 * y)
            });
        }
        ShapeDesc::Box(desc) => {
            let (min, max) = match (desc.min, desc.max) {
                (Some(min), Some(max)) => (min, max),
                _ => {
                    let center = desc.center.unwrap_or(DVec3::ZERO);
                    let half = desc.size.unwrap_or(DVec3::splat(2.0)) * 0.5;
                    (center - half, center + half)
                }
            };
            let (center_point, half) = ((min + max) * 0.5, (max - min) * 0.5);
            for n in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z] {
                let (right, up) = plane_axes(n);
                b.grid(1, 1, |s, t| {
                    let p = n + right * (2.0 * s - 1.0) + up * (2.0 * t - 1.0);
                    (center_point + p * half, n, s, t)
                });
            }
        }
        ShapeDesc::Disk(d) => b.disk(d.center, unit(d.normal)?, [d.radius, d.inner_radius], d.polar),
        ShapeDesc::Rectangle(r) => {
            let n = unit(r.edge_u.cross(r.edge_v))?;
            b.grid(1, 1, |s, t| (r.center + r.edge_u * (s - 0.5) + r.edge_v * (t - 0.5), n, s, t));
        }
        ShapeDesc::Cylinder(c) => {
            let axis = unit(c.to - c.from)?;
            b.side(c.from, c.to, [c.radius; 2]);
            if c.capped {
                b.disk(c.from, -axis, [c.radius, 0.0], false);
                b.disk(c.to, axis, [c.radius, 0.0], false);
            }
        }
        ShapeDesc::Cone(c) => {
            let axis = unit(c.to - c.from)?;
            b.side(c.from, c.to, [c.radius, c.tip_radius]);
            if c.capped {
                b.disk(c.from, -axis, [c.radius, 0.0], false);
                if c.tip_radius > 0.0 {
                    b.disk(c.to, axis, [c.tip_radius, 0.0], false);
                }
            }
        }
        ShapeDesc::Torus(t) => {
            let axis = unit(t.axis)?;
            let (zero, quarter) = perpendicular(axis);
            b.grid(SIDES, SIDES / 2, |u, v| {
                let out = zero * cos(TAU * u) + quarter * sin(TAU * u);
                // v starts at the inner side and continues below.
                let n = out * -cos(TAU * v) - axis * sin(TAU * v);
                (t.center + out * t.radius + n * t.tube_radius, n, u, v)
            });
        }
        ShapeDesc::Mesh(desc) if desc.subdivision.is_none() => return Ok(None),
        ShapeDesc::Points(_) => return Ok(None),
        ShapeDesc::Curves(_) => return curves(shape, desc).map(Some),
        _ => return solid(shape, desc, reach).map(Some),
    }
    Ok(Some(Tessellated { mesh: b.0, materials: Vec::new() }))
}

#[cfg(test)]
mod tests {
    use turner::shape::solid::DistanceGridDesc;

    use super::*;

    /// Triangles face the side of their normals; normals have unit length.
    #[test]
    fn triangles_face_outwards() {
        let scenes = [
            "\"sphere\"",
            "\"plane\"\nnormal = [1, 2, -1]",
            "\"box\"\nmin = [0, 1, 2]\nmax = [1, 5, 3]",
            "\"disk\"",
            "\"disk\"\ninner_radius = 0.3\nnormal = [1, 2, 3]",
            "\"disk\"\ninner_radius = 0.3\npolar = true",
            "\"rectangle\"",
            "\"cylinder\"",
            "\"cylinder\"\nfrom = [0, 1, 2]\nto = [3, 1, 1]",
            "\"cone\"",
            "\"cone\"\ntip_radius = 0.4",
            "\"torus\"",
            "\"torus\"\naxis = [1, -1, 0.4]",
            "\"union\"\nparts = [{ type = \"sphere\" }, { type = \"torus\" }]",
            "\"intersection\"\nparts = [{ type = \"sphere\", radius = 1.2 }, { type = \"box\" }]",
            "\"difference\"\nparts = [{ type = \"box\" }, { type = \"sphere\", radius = 1.2 }]",
            "\"parametric\"",
            "\"text\"\ntext = \"Io+\"\nfont = \"f.ttf\"",
            "\"prism\"\npoints = [[0, 0], [2, 0], [2, 1], [0, 1]]",
            "\"lathe\"\npoints = [[0.5, 0], [1, 1], [0.3, 2]]",
            "\"sphere_sweep\"\nspheres = [[0, 0, 0, 0.5], [1, 1, 0, 0.3]]",
            "\"superellipsoid\"",
            "\"blob\"\nspheres = [[0, 0, 0, 1, 1], [0.8, 0, 0, 1, 1]]",
            "\"quadric\"\nsquared = [1, -1, 1]",
            "\"polynomial\"\nterms = [[1, 4, 0, 0], [1, 0, 2, 0], [1, 0, 0, 2], [-0.5, 0, 0, 0]]",
            "\"curves\"\npoints = [[-1, 0, 0], [0, 0.4, 0.1], [1, 0, 0]]\nwidth = 0.1",
            "\"isosurface\"\nfunction = \"x^2 + y^2 + z^2 - 0.5\"",
            "\"distance_grid\"\nfile = \"d.grid\"\nlevel = 0.2",
            "\"clipped\"\nparts = [{ type = \"sphere\" }, { type = \"plane\" }]",
        ];
        for entry in
            ShapeDesc::DOC.entries.iter().filter(|e| !matches!(e.name, "mesh" | "points" | "height_field"))
        {
            let name = format!("\"{}\"", entry.name);
            assert!(scenes.iter().any(|scene| scene.starts_with(&name)), "no scene of the shape {name}");
        }
        for scene in scenes {
            let text = format!("[[object]]\ntype = {scene}\n");
            let mut assets = crate::assets::MemoryAssets::default();
            assets.files.insert("f.ttf".into(), include_bytes!("../../testing/font.ttf").to_vec());
            let mut ball = Vec::new();
            crate::grid::write(&DistanceGridDesc::default().file.data, &mut ball).unwrap();
            assets.files.insert("d.grid".into(), ball);
            let loaded = crate::scene::load_text(text.clone(), "s.toml", &assets, &Default::default());
            let desc = loaded.unwrap_or_else(|e| panic!("{}\n{text}", e.error)).desc;
            let turner::description::ObjectContent::Shape(shape) = &desc.objects[0].content else { panic!() };
            let mesh = triangles(shape, &desc, 10.0).unwrap().unwrap().mesh;
            // Tubes of curves have six sides: cos 30° = .866, less where they bend.
            let least = if scene.starts_with("\"curves\"") { 0.8 } else { 0.9 };
            mesh.check().unwrap();
            assert!(!mesh.triangles.is_empty());
            for t in &mesh.triangles {
                let p = t.map(|i| glam_of(mesh.positions[i as usize]));
                let n = t.map(|i| glam_of(mesh.normals[i as usize]));
                let face = (p[1] - p[0]).cross(p[2] - p[0]);
                assert!(face.length() > 0.0, "{scene}");
                for n in n {
                    assert!((n.length() - 1.0).abs() < 1e-6, "{scene}");
                    assert!(face.normalize().dot(n) > least, "{scene} {t:?} {face} {n}");
                }
            }
        }
    }

    fn glam_of(v: [f32; 3]) -> DVec3 {
        DVec3::from(v.map(f64::from))
    }
}

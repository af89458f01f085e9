//! Height fields: terrain from an image.

use crate::image::Image;
use crate::math::{DVec2, DVec3};
use crate::schema::{ErrorCode, ImageId, MeshData, Range, SceneError, params};

params! {
    /// A height field: a surface whose height comes from an image, black for the bottom of the box from `min` to `max` and
    /// white for the top, one vertex per pixel. Images of 16 bits or floats give smooth slopes; those of 8 bits show
    /// terraces. The top row of the image is at the back (−z). u runs along +x, v along −z.
    pub struct HeightFieldDesc as "height_field" {
        /// The image file. Heights are the mean of red, green and blue as stored; those of float files are not limited
        /// to 0..1.
        file: ImageId, required, default ImageId(0);
        /// Corner of the box with the smallest coordinates.
        min: DVec3 = DVec3::new(-1.0, 0.0, -1.0);
        /// Corner of the box with the largest coordinates.
        max: DVec3 = DVec3::new(1.0, 0.5, 1.0);
        /// Whether shading is smooth.
        smooth: bool = true;
        /// How far below `min` the solid reaches: four walls and a bottom close it, so that it can be a part of
        /// `union` or `difference`. Without this key it is an open surface.
        base: Option<f64> = None, in Range::POSITIVE;
    }
    example r#"[[object]]
type = "height_field"
file = "mountain.png"
min = [-5, 0, -5]
max = [5, 2, 5]
material = { color = "darkkhaki" }
"#
}

/// Bytes per pixel while the mesh is made: positions, normals, (u, v) and two triangles.
const PIXEL_BYTES: u64 = 12 + 12 + 8 + 24;

impl HeightFieldDesc {
    /// The triangles.
    ///
    /// Errors: an image with more pixels than a mesh may have vertices; an empty box.
    pub(super) fn mesh(&self, image: &Image) -> Result<MeshData, SceneError> {
        // Pixels beyond the border repeat it, so one row or column makes a flat strip.
        let (w, h) = (image.width.max(2), image.height.max(2));
        if u64::from(w) * u64::from(h) > u64::from(u32::MAX / 8) || !image.is_consistent() {
            let message =
                format!("a height field needs an image of up to about 23,000x23,000 pixels, found {w}x{h}");
            return Err(SceneError::new(ErrorCode::Image, message).help("scale the image"));
        }
        if !(self.min.cmplt(self.max).all()) {
            let message = format!(
                "each coordinate of `min` of a height field must be less than that of `max`: {}, {}",
                self.min, self.max
            );
            return Err(SceneError::new(ErrorCode::OutOfRange, message).help("exchange the two"));
        }
        let size = self.max - self.min;
        let step = DVec2::new(size.x / f64::from(w - 1), size.z / f64::from(h - 1));
        let height = |x: u32, y: u32| {
            let [r, g, b] = image.rgb(x, y).map(|v| if v.is_finite() { f64::from(v) } else { 0.0 });
            self.min.y + size.y * (r + g + b) / 3.0
        };
        let at = |x: u32, y: u32| {
            DVec3::new(self.min.x + step.x * f64::from(x), height(x, y), self.min.z + step.y * f64::from(y))
        };
        let mut mesh = MeshData::default();
        for (y, x) in (0..h).flat_map(|y| (0..w).map(move |x| (y, x))) {
            mesh.positions.push(at(x, y).as_vec3().to_array());
            let uv = DVec2::new(f64::from(x) / f64::from(w - 1), 1.0 - f64::from(y) / f64::from(h - 1));
            mesh.uvs.push(uv.as_vec2().to_array());
            if self.smooth {
                // Central differences, one-sided at the border.
                let slope = |a: f64, b: f64, cells: u32, step: f64| (b - a) / (f64::from(cells) * step);
                let (left, right) = (x.saturating_sub(1), (x + 1).min(w - 1));
                let (back, front) = (y.saturating_sub(1), (y + 1).min(h - 1));
                let dx = slope(height(left, y), height(right, y), right - left, step.x);
                let dz = slope(height(x, back), height(x, front), front - back, step.y);
                mesh.normals.push(DVec3::new(-dx, 1.0, -dz).normalize().as_vec3().to_array());
            }
        }
        for (y, x) in (0..h - 1).flat_map(|y| (0..w - 1).map(move |x| (y, x))) {
            let a = y * w + x;
            let (b, c, d) = (a + 1, a + w + 1, a + w);
            mesh.triangles.extend([[a, d, b], [b, d, c]]);
        }
        if let Some(base) = self.base {
            let border = (0..w - 1).map(|x| (x, 0)).chain((0..h - 1).map(|y| (w - 1, y)));
            let border = border.chain((1..w).rev().map(|x| (x, h - 1))).chain((1..h).rev().map(|y| (0, y)));
            let ring: Vec<DVec3> = border.map(|(x, y)| at(x, y)).collect();
            self.close(&ring, self.min.y - base, &mut mesh);
        }
        Ok(mesh)
    }

    /// Adds walls below the border, which runs clockwise as seen from above, and a bottom.
    fn close(&self, ring: &[DVec3], bottom: f64, mesh: &mut MeshData) {
        let down = |p: DVec3| DVec3::new(p.x, bottom, p.z);
        let mut vertex = |p: DVec3, n: DVec3| {
            mesh.positions.push(p.as_vec3().to_array());
            mesh.uvs.push([0.0; 2]);
            if self.smooth {
                mesh.normals.push(n.as_vec3().to_array());
            }
            mesh.positions.len() as u32 - 1
        };
        let mut faces = Vec::new();
        for (i, &p) in ring.iter().enumerate() {
            let q = ring[(i + 1) % ring.len()];
            let n = DVec3::new(q.z - p.z, 0.0, p.x - q.x).normalize_or(DVec3::X);
            let [a, b, c, d] = [p, q, down(q), down(p)].map(|p| vertex(p, n));
            faces.extend([[a, b, c], [a, c, d]]);
        }
        // A fan: its outer edges are those of the walls.
        let center = vertex(down(0.5 * (self.min + self.max)), DVec3::NEG_Y);
        for (i, &p) in ring.iter().enumerate() {
            let [a, b] = [p, ring[(i + 1) % ring.len()]].map(|p| vertex(down(p), DVec3::NEG_Y));
            faces.push([center, a, b]);
        }
        mesh.triangles.extend(faces);
    }

    /// Number of triangles of the top.
    pub(super) fn triangles(image: &Image) -> u64 {
        2 * u64::from(image.width) * u64::from(image.height)
    }

    /// Bytes of the mesh of an image.
    pub(super) fn bytes(image: &Image) -> u64 {
        u64::from(image.width) * u64::from(image.height) * PIXEL_BYTES
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Pixels;
    use crate::math::Ray;
    use crate::schema::Asset;
    use crate::shape::solid::csg::open_edges;
    use crate::shape::{MeshCache, Shape, ShapeDesc};
    use std::sync::Arc;

    /// A slope from 0 at the left to 1 at the right.
    fn slope() -> Image {
        let row = [0u16, 21845, 43690, 65535];
        Image { width: 4, height: 3, channels: 1, pixels: Pixels::U16(row.repeat(3)) }
    }

    fn prepared(desc: HeightFieldDesc) -> Shape {
        let images = [Asset { uri: String::new(), data: Arc::new(slope()) }];
        let mut cache = MeshCache::new(&[]).with_images(&images);
        let shape = ShapeDesc::HeightField(desc).prepare(&mut cache).unwrap();
        let Shape::Mesh(mesh) = &shape else { panic!() };
        mesh.build_tree(&Default::default()).unwrap();
        shape
    }

    #[test]
    fn heights_normals_and_coordinates() {
        let shape = prepared(HeightFieldDesc::default());
        for x in [-0.9, -0.3, 0.2, 0.7] {
            let ray = Ray::new(DVec3::new(x, 3.0, 0.3), DVec3::NEG_Y);
            let hit = shape.intersect(&ray).unwrap();
            let surface = shape.surface(&ray, &hit);
            assert!((surface.p.y - 0.25 * (x + 1.0)).abs() < 1e-6, "{}", surface.p);
            assert!((surface.ns - DVec3::new(-0.25, 1.0, 0.0).normalize()).length() < 1e-6, "{}", surface.ns);
            let uv = shape.uv(&hit, &surface);
            assert!((uv - DVec2::new(0.5 * (x + 1.0), 0.35)).length() < 1e-6, "{uv}");
        }
    }

    #[test]
    fn a_base_closes_it() {
        for smooth in [true, false] {
            let desc = HeightFieldDesc { base: Some(0.5), smooth, ..HeightFieldDesc::default() };
            let mesh = desc.mesh(&slope()).unwrap();
            mesh.check().unwrap();
            assert_eq!(open_edges(&mesh), 0);
            assert!(open_edges(&HeightFieldDesc::default().mesh(&slope()).unwrap()) > 0);
            // The enclosed volume: a wedge of 2 x 2 x 0.5 / 2 above a block of 2 x 2 x 0.5.
            let at = |i: u32| DVec3::from(mesh.positions[i as usize].map(f64::from));
            let six: f64 = mesh.triangles.iter().map(|[a, b, c]| at(*a).dot(at(*b).cross(at(*c)))).sum();
            assert!((six / 6.0 - 3.0).abs() < 1e-5, "{}", six / 6.0);
        }
    }

    #[test]
    fn small_images_and_refusals() {
        let one = Image { width: 1, height: 1, channels: 1, pixels: Pixels::U8(vec![255]) };
        let mesh = HeightFieldDesc::default().mesh(&one).unwrap();
        assert!(mesh.positions.len() == 4 && mesh.positions.iter().all(|p| p[1] == 0.5), "a flat square");
        let flat = HeightFieldDesc { max: DVec3::ZERO, ..HeightFieldDesc::default() };
        assert!(flat.mesh(&slope()).unwrap_err().message.contains("`min` of a height field"));
        let missing = ShapeDesc::HeightField(HeightFieldDesc::default());
        assert!(missing.prepare(&mut MeshCache::new(&[])).is_err());
    }
}

//! Shapes from grids of signed distances.

mod crossed_cells;
mod lattice;
#[cfg(test)]
mod tests;
mod walk;

use std::sync::Arc;

use super::contained::{Container, Field};
use super::{PrepareSolid, Solid, SolidGeometry};
use crate::math::{Bounds, DVec2, DVec3, Ray};
use crate::schema::{ErrorCode, GridData, GridFile, SceneError, params};
use crate::shape::{MeshCache, ShapeHit, Sphere, SurfacePoint};
use crossed_cells::CrossedCells;
use lattice::Lattice;
use walk::GridField;

params! {
    /// The surface of a grid of signed distances in a box: all points where the values, with trilinear interpolation between
    /// them, are `level`. The inside is where they are less. The first and the last value along each axis lie on the faces
    /// of the box. The file is OpenVDB (`.vdb`) or NanoVDB (`.nvdb`), a level set as a rule, or of the kind that
    /// docs/guides/fog-and-smoke.md describes. (u, v) are those of a sphere around the centre of the box.
    pub struct DistanceGridDesc as "distance_grid" {
        /// Path of the file, relative to the scene file. `rock.vdb#surface` is the grid `surface` of an OpenVDB or NanoVDB
        /// file; without a name it is `density` or the only grid of floats.
        file: GridFile, required, default ball();
        /// Corner of the box with the smallest coordinates, in scene units. If not given, where the file places it;
        /// (-1, -1, -1) if it does not.
        min: Option<DVec3> = None;
        /// Corner of the box with the largest coordinates; (1, 1, 1) if neither it nor the file gives one.
        max: Option<DVec3> = None;
        /// The value at the surface. With distances, the surface moves outwards by it.
        level: f64 = 0.0;
        /// Whether the faces of the box close the solid where the surface leaves the box.
        capped: bool = true;
        /// Whether shading is smooth: normals are continuous across cells.
        smooth: bool = true;
    }
    example r#"[[object]]
type = "distance_grid"
file = "rock.vdb"
min = [-1, 0, -1]
max = [1, 2, 1]
material = { color = "darkkhaki" }
"#
}

/// Three values along each axis, from the distance to a ball of radius 0.7.
fn ball() -> GridFile {
    let axis = [-1.0f32, 0.0, 1.0];
    let values = axis.iter().flat_map(|z| axis.iter().flat_map(move |y| axis.map(|x| (x, *y, *z))));
    let distances = values.map(|(x, y, z)| (x * x + y * y + z * z).sqrt() - 0.7).collect();
    let data = GridData::of_distances([3; 3], distances).unwrap_or_default();
    GridFile { uri: String::new(), data: Arc::new(data) }
}

impl DistanceGridDesc {
    /// The box on whose faces the first and the last values lie: `min` and `max`, or that of the file.
    pub fn bounds(&self) -> [DVec3; 2] {
        let [min, max] = self.file.data.vertex_bounds().unwrap_or([DVec3::NEG_ONE, DVec3::ONE]);
        [self.min.unwrap_or(min), self.max.unwrap_or(max)]
    }
}

impl PrepareSolid for DistanceGridDesc {
    fn prepare_solid(&self, meshes: &mut MeshCache<'_>) -> Result<Solid, SceneError> {
        let data = &self.file.data;
        let [x, y, z] = data.size();
        if [x, y, z].iter().any(|n| *n < 2) {
            let message =
                format!("a distance grid needs at least 2 values along each axis, found {x} × {y} × {z}");
            return Err(SceneError::new(ErrorCode::Volume, message).help("resample the grid"));
        }
        let [min, max] = self.bounds();
        let container = Container::new(min, max, self.capped, "distance grid")?;
        let lattice = Lattice::new(Arc::clone(data), self.level, &container.bounds);
        meshes.need(CrossedCells::bytes(lattice.cells), || "the cells of a distance grid".to_owned())?;
        let crossed = CrossedCells::new(&lattice);
        let border_is_outside = lattice.border_is_outside();
        if crossed.range.is_none() && (border_is_outside || !self.capped) {
            meshes.warn(format!("a distance grid has no surface: its values do not cross {}", self.level));
        }
        // A surface that stays within the box is closed with and without faces.
        let container = Container { capped: self.capped || border_is_outside, ..container };
        let bounds = match crossed.range {
            Some(range) if border_is_outside || !self.capped => {
                // Roundings of the vertices.
                let margin = 1e-12 * (container.bounds.size() + min.abs() + max.abs());
                let [low, high] = range.map(|vertex| lattice.vertex(vertex));
                Bounds::new((low - margin).max(min), (high + margin).min(max))
            }
            _ => container.bounds,
        };
        let field = GridField { lattice, crossed };
        Ok(Solid::DistanceGrid(DistanceGrid { field, container, bounds, smooth: self.smooth }))
    }
}

/// A grid of signed distances.
#[derive(Clone, Debug)]
pub struct DistanceGrid {
    field: GridField,
    container: Container,
    /// The part of the box that contains the surface.
    bounds: Bounds,
    smooth: bool,
}

impl SolidGeometry for DistanceGrid {
    fn bounds(&self) -> Option<Bounds> {
        Some(self.bounds)
    }

    fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        self.container.intersect(&self.field, ray)
    }

    fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        let point = self.container.surface(&self.field, ray, hit);
        if !self.smooth || hit.part > 0 {
            return point;
        }
        let ns = self.field.lattice.smooth_normal(point.p).filter(|n| n.dot(point.ng) > 0.0);
        SurfacePoint { ns: ns.unwrap_or(point.ng), ..point }
    }

    fn uv(&self, _: &ShapeHit, point: &SurfacePoint) -> DVec2 {
        Sphere::uv((point.p - self.container.bounds.center()).normalize_or(DVec3::Y))
    }

    fn curvature(&self, _: &ShapeHit) -> f64 {
        2.0 / self.bounds.size().max_element()
    }

    fn is_closed(&self) -> bool {
        self.container.capped
    }

    fn memory(&self) -> usize {
        self.field.memory()
    }

    fn tests_per_ray(&self) -> f64 {
        self.field.tests_per_ray()
    }
}

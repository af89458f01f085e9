//! Point clouds; each point is rendered as a small sphere.

use std::sync::Arc;

use turner_bvh::{BoxBvh, BuildOptions};

use super::mesh::write_lists;
use super::sphere::Sphere;
use super::traversal::TraversalFrame;
use super::{ShapeHit, SurfacePoint, mean_parts};
use crate::math::{Bounds, DVec3, Ray};
use crate::schema::value::{Data, Table};
use crate::schema::write::{list, single};
use crate::schema::{
    Asset, EntryDoc, ErrorCode, MeshData, MeshId, PrepareOptions, Range, ReadContext, Renumber, SceneError,
    TableReader, WriteContext, params,
};

params! {
    /// A point cloud from a PLY file (or the vertices of an OBJ file), or given inline. Each point is a sphere
    /// with the (u, v) of a sphere. The texture "vertex-color" shows the points' colours. Without `radius` or
    /// `radii`, the radius is three quarters of the mean distance between neighbouring points.
    pub struct PointsKeys as "points" {
        /// Path of a .ply or .obj file; of a mesh, its vertices are used.
        file: Option<String> = None;
        /// Point positions, instead of `file`.
        positions: Option<Vec<DVec3>> = None;
        /// Colours [r, g, b, opacity], linear, one per inline point.
        colors: Option<Vec<[f64; 4]>> = None;
        /// Radius of all points.
        radius: Option<f64> = None, in Range::POSITIVE;
        /// Radius of each point, instead of `radius`.
        radii: Option<Vec<f64>> = None, in Range::POSITIVE;
    }
    example r##"[[object]]
type = "points"
positions = [[-1, 0, 0], [0, 0.5, 0], [1, 0, 0], [0, -0.5, 0]]
colors = [[1, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 1], [1, 1, 0, 1]]
radius = 0.3
material = { color = { type = "vertex-color" } }
"##
}

/// Points whose positions and colours are in the scene's list of meshes; by default the vertices of the first
/// mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointsDesc {
    /// The mesh whose vertices they are.
    pub points: MeshId,
    /// Radius of all points, greater than 0; by default it follows from their distances.
    pub radius: Option<f64>,
    /// Radius of each point, or empty.
    pub radii: Vec<f32>,
}

impl PointsDesc {
    /// Its documentation.
    pub const DOC: EntryDoc = PointsKeys::DOC;

    /// Renumbers the ids it refers to.
    pub fn renumber(&mut self, by: &Renumber) {
        self.points = by.mesh(self.points);
    }

    /// The keys that [`PointsDesc::read`] reads.
    pub fn write(&self, cx: &mut dyn WriteContext) -> Result<Table, SceneError> {
        let mut table = Table::default();
        match cx.mesh(self.points)? {
            (_, Some(file)) => table.push("file", Data::String(file)),
            (data, None) => write_lists(data, &mut table),
        }
        table.push("radius", self.radius.map(Data::Number));
        let radii = self.radii.iter().map(|r| single(*r));
        table.push("radii", (!self.radii.is_empty()).then(|| list(radii)));
        Ok(table)
    }

    /// Reads its keys; adds inline points to the scene's list of meshes.
    pub fn read(table: &mut TableReader<'_>, cx: &mut dyn ReadContext) -> Result<PointsDesc, SceneError> {
        let keys = PointsKeys::read(table, cx)?;
        let points = match (keys.file, keys.positions) {
            (Some(uri), None) if keys.colors.is_none() => cx.mesh_file(&uri, table.span_of("file"))?,
            (None, Some(positions)) => {
                let colors = keys.colors.unwrap_or_default();
                let data = MeshData {
                    positions: positions.into_iter().map(|p| p.as_vec3().to_array()).collect(),
                    colors: colors.into_iter().map(|c| c.map(|x| x as f32)).collect(),
                    ..MeshData::default()
                };
                data.check().map_err(|e| e.or_at(Some(table.span())))?;
                cx.inline_mesh(data)
            }
            (None, None) => {
                let message = "points need a `file`, or `positions`";
                return Err(SceneError::at(ErrorCode::MissingKey, table.span(), message)
                    .help("add `file = \"cloud.ply\"`"));
            }
            _ => {
                let message = "points have either a `file` or inline `positions` and `colors`";
                return Err(SceneError::at(ErrorCode::Conflict, table.span_of("file"), message)
                    .help("remove one of the two"));
            }
        };
        let radii: Vec<f32> = keys.radii.unwrap_or_default().into_iter().map(|r| r as f32).collect();
        let count = cx.mesh_data(points).positions.len();
        if !radii.is_empty() && radii.len() != count {
            let message = format!("{} radii for {count} points", radii.len());
            return Err(SceneError::at(ErrorCode::Conflict, table.span_of("radii"), message)
                .help("give one per point, or one `radius` for all"));
        }
        Ok(PointsDesc { points, radius: keys.radius, radii })
    }

    /// Converts them to the form that rays are intersected with. `meshes` are the scene's.
    pub fn prepare(
        &self,
        meshes: &[Asset<MeshData>],
        options: &PrepareOptions,
    ) -> Result<Points, SceneError> {
        let Some(asset) = meshes.get(self.points.index()) else {
            let message = format!("points name mesh {}, but the scene has {}", self.points.0, meshes.len());
            return Err(SceneError::new(ErrorCode::Mesh, message));
        };
        asset.data.check()?;
        Points::build(&asset.data, self.radius, &self.radii, options)
    }
}

/// Spheres with their tree: some 90 bytes per point in addition to the positions, which are shared with the
/// description.
#[derive(Clone, Debug)]
pub struct Points {
    data: Arc<MeshData>,
    radius: f64,
    /// Radius of each point, or empty.
    radii: Vec<f32>,
    tree: BoxBvh,
    frame: TraversalFrame,
    bounds: Bounds,
    /// See [`Shape::tests_per_ray`](super::Shape::tests_per_ray).
    tests_per_ray: f64,
}

impl Points {
    /// Builds the tree. Skips points with non-finite positions, and points whose own radius is not above 0.
    pub fn build(
        data: &Arc<MeshData>,
        radius: Option<f64>,
        radii: &[f32],
        options: &PrepareOptions,
    ) -> Result<Points, SceneError> {
        let too_many = |e: &dyn std::fmt::Display| SceneError::new(ErrorCode::TooLarge, e.to_string());
        if !radii.is_empty() && radii.len() != data.positions.len() {
            let message = format!("{} radii for {} points", radii.len(), data.positions.len());
            return Err(SceneError::new(ErrorCode::Mesh, message));
        }
        let radius = radius
            .filter(|r| *r > 0.0 && r.is_finite())
            .unwrap_or_else(|| if radii.is_empty() { 0.75 * spacing(&data.positions) } else { 1.0 });
        let sphere = |i: usize| {
            let radius = radii.get(i).map_or(radius, |r| f64::from(*r));
            Sphere { center: DVec3::from(data.positions[i].map(f64::from)), radius }
        };
        let is_valid = |s: &Sphere| s.center.is_finite() && s.radius > 0.0 && s.radius.is_finite();
        let count = data.positions.len();
        let all = (0..count).map(sphere).filter(is_valid);
        // Half the surface area of the sphere's bounding cube is 3 (2r)².
        let (bounds, areas) = all.fold((Bounds::EMPTY, 0.0), |(b, areas), s| {
            (b.union(&s.bounds()), areas + 12.0 * s.radius * s.radius)
        });
        let frame = TraversalFrame::new(&bounds);
        /// Bytes per point while the tree is built: its box, and the builder's memory.
        const POINT: u64 = 24 + 208;
        options
            .limits
            .memory
            .need((count as u64).saturating_mul(POINT), || format!("the search tree of {count} points"))?;
        let mut boxes = Vec::new();
        boxes.try_reserve_exact(count).map_err(|e| too_many(&e))?;
        boxes.extend(
            (0..count)
                .map(sphere)
                .map(|s| frame.aabb(&if is_valid(&s) { s.bounds() } else { Bounds::EMPTY })),
        );
        let build = BuildOptions {
            quality: options.quality,
            threads: options.threads,
            instruction_set: options.instruction_set,
            ..BuildOptions::default()
        };
        let tree = BoxBvh::build(&boxes, &build).map_err(|e| too_many(&e))?;
        let tests_per_ray = mean_parts(areas, &bounds);
        Ok(Points {
            data: Arc::clone(data),
            radius,
            radii: radii.to_vec(),
            tree,
            frame,
            bounds,
            tests_per_ray,
        })
    }

    /// Bounding box; empty without points.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Number of points that can be hit.
    pub fn count(&self) -> usize {
        self.tree.order().len()
    }

    /// Bytes of memory, including the data shared with the description.
    pub fn memory(&self) -> usize {
        size_of_val(self) + self.tree.bytes() + size_of_val(&self.radii[..]) + self.data.memory()
    }

    /// See [`Shape::tests_per_ray`](super::Shape::tests_per_ray).
    pub(super) fn tests_per_ray(&self) -> f64 {
        self.tests_per_ray
    }

    /// The spheres that can be hit, with their indices.
    pub fn spheres(&self) -> impl Iterator<Item = (u32, Sphere)> + '_ {
        self.tree.order().iter().map(|&point| (point, self.sphere(point)))
    }

    /// The sphere of a point.
    #[inline]
    pub fn sphere(&self, point: u32) -> Sphere {
        let i = point as usize;
        let radius = if self.radii.is_empty() { self.radius } else { f64::from(self.radii[i]) };
        Sphere { center: DVec3::from(self.data.positions[i].map(f64::from)), radius }
    }

    /// The nearest hit; of several at the same t, that of the point with the lowest index.
    pub fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        self.intersect_where(ray, &|_| true)
    }

    /// The nearest hit that `accept` accepts. `accept` is called in any order.
    pub fn intersect_where(&self, ray: &Ray, accept: &dyn Fn(&ShapeHit) -> bool) -> Option<ShapeHit> {
        let search = self.frame.ray(ray)?;
        let mut nearest: Option<ShapeHit> = None;
        self.tree.closest(&search.ray, |range, t_max| {
            for &point in &self.tree.order()[range.start as usize..range.end as usize] {
                let Some(hit) = self.hit(point, ray, accept) else { continue };
                if nearest.is_none_or(|n| hit.t < n.t || hit.t == n.t && point < n.part) {
                    nearest = Some(hit);
                }
            }
            nearest.map_or(t_max, |n| search.end(n.t).min(t_max))
        });
        nearest
    }

    /// Whether there is a hit that `accept` accepts.
    pub fn occludes_where(&self, ray: &Ray, accept: &dyn Fn(&ShapeHit) -> bool) -> bool {
        let Some(search) = self.frame.ray(ray) else { return false };
        self.tree.any(&search.ray, |range| {
            let leaf = &self.tree.order()[range.start as usize..range.end as usize];
            leaf.iter().any(|&point| self.hit(point, ray, accept).is_some())
        })
    }

    /// The nearest accepted hit of one point: the front or the back of its sphere.
    #[inline]
    fn hit(&self, point: u32, ray: &Ray, accept: &dyn Fn(&ShapeHit) -> bool) -> Option<ShapeHit> {
        let sphere = self.sphere(point);
        let hit = ShapeHit { part: point, ..sphere.intersect(ray)? };
        if accept(&hit) {
            return Some(hit);
        }
        let behind = Ray { t_min: hit.t.next_up(), ..*ray };
        let hit = ShapeHit { part: point, ..sphere.intersect(&behind)? };
        accept(&hit).then_some(hit)
    }

    /// The surface point at a hit.
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        self.sphere(hit.part).surface(ray, hit)
    }

    /// The colour of the point that was hit, linear RGB and opacity, if the cloud has colours.
    pub fn color(&self, hit: &ShapeHit) -> Option<[f32; 4]> {
        self.data.colors.get(hit.part as usize).copied()
    }
}

/// Approximate mean distance from a point to its nearest neighbour. Candidates are the eight points before and
/// after it on a Morton curve (Morton 1966). Coinciding points do not count; 1 if there are no two distinct
/// points.
fn spacing(positions: &[[f32; 3]]) -> f64 {
    let finite = |p: &&[f32; 3]| p.iter().all(|x| x.is_finite());
    let wide = |p: &[f32; 3]| DVec3::from(p.map(f64::from));
    let bounds = Bounds::of(positions.iter().filter(finite).map(wide));
    if bounds.is_empty() {
        return 1.0;
    }
    let cells = f64::from(1_u32 << 21) / bounds.size().max_element().max(f64::MIN_POSITIVE);
    let key = |p: DVec3| {
        let cell = ((p - bounds.min) * cells).to_array().map(|c| spread(c as u64));
        cell[0] | cell[1] << 1 | cell[2] << 2
    };
    // A subset of a large cloud would be sparser than the cloud: sort all points.
    let mut order: Vec<(u64, u32)> = positions
        .iter()
        .enumerate()
        .filter(|(_, p)| finite(p))
        .map(|(i, p)| (key(wide(p)), i as u32))
        .collect();
    order.sort_unstable();
    let at = |i: usize| wide(&positions[order[i].1 as usize]);
    // About 100,000 points are enough for the mean.
    let step = order.len().div_ceil(100_000);
    let (mut sum, mut count) = (0.0, 0_u32);
    for i in (0..order.len()).step_by(step.max(1)) {
        let near = (i.saturating_sub(8)..order.len().min(i + 9)).filter(|&k| k != i);
        let distances = near.map(|k| at(k).distance_squared(at(i))).filter(|d| *d > 0.0);
        let nearest = distances.fold(f64::INFINITY, f64::min);
        if nearest.is_finite() {
            sum += nearest.sqrt();
            count += 1;
        }
    }
    if count == 0 { 1.0 } else { sum / f64::from(count) }
}

/// Spreads the lower 21 bits: two zero bits before each.
fn spread(x: u64) -> u64 {
    let mut x = x.min((1 << 21) - 1);
    for (shift, mask) in [
        (32, 0x001f_0000_0000_ffff),
        (16, 0x001f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ] {
        x = (x | x << shift) & mask;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::testing::Random;

    fn cloud(count: usize, seed: u64) -> Arc<MeshData> {
        let mut random = Random::new(seed);
        let positions = (0..count).map(|_| random.in_cube().as_vec3().to_array()).collect();
        Arc::new(MeshData { positions, ..MeshData::default() })
    }

    #[test]
    fn the_tree_finds_the_nearest_sphere() {
        let data = cloud(2000, 3);
        let radii: Vec<f32> = (0..2000).map(|i| 0.01 + 0.0001 * (i % 300) as f32).collect();
        let points = Points::build(&data, None, &radii, &PrepareOptions::default()).unwrap();
        let mut random = Random::new(4);
        let mut hits = 0;
        for i in 0..3000 {
            let far = if i % 3 == 0 { 1e5 } else { 2.0 };
            let origin = far * random.direction();
            let ray = Ray::new(origin, random.in_cube() - origin);
            let all = (0..2000).filter_map(|k| {
                let hit = points.sphere(k).intersect(&ray)?;
                Some(ShapeHit { part: k, ..hit })
            });
            let expected = all.min_by(|a, b| a.t.total_cmp(&b.t).then(a.part.cmp(&b.part)));
            assert_eq!(points.intersect(&ray), expected);
            assert_eq!(points.occludes_where(&ray, &|_| true), expected.is_some());
            let Some(hit) = expected else { continue };
            hits += 1;
            let surface = points.surface(&ray, &hit);
            let sphere = points.sphere(hit.part);
            assert!((surface.p.distance(sphere.center) - sphere.radius).abs() <= surface.error);
            // The back of the first sphere, or another sphere.
            let behind = points.intersect_where(&ray, &|h| h.t > hit.t).unwrap();
            assert!(behind.t > hit.t);
        }
        assert!(hits > 500, "{hits}");
    }

    #[test]
    fn a_million_points_take_less_than_a_hundred_bytes_each() {
        let data = cloud(100_000, 5);
        let points = Points::build(&data, Some(0.001), &[], &PrepareOptions::default()).unwrap();
        let beyond = points.memory() - data.memory();
        assert!(beyond < 100 * 100_000, "{beyond}");
        assert_eq!(points.count(), 100_000);
    }

    #[test]
    fn the_default_radius_follows_from_neighbours() {
        let grid: Vec<[f32; 3]> =
            (0..4096).map(|i| [(i % 64) as f32 * 0.25, (i / 64) as f32 * 0.25, 1.0]).collect();
        assert!((spacing(&grid) - 0.25).abs() < 0.03, "{}", spacing(&grid));
        assert_eq!(spacing(&[[1.0; 3]; 5]), 1.0);
        assert_eq!(spacing(&[]), 1.0);
        let mut broken = grid;
        broken.extend([[f32::NAN; 3], [f32::INFINITY, 0.0, 0.0]]);
        let data = Arc::new(MeshData { positions: broken, ..MeshData::default() });
        let points = Points::build(&data, None, &[], &PrepareOptions::default()).unwrap();
        assert!(points.count() == 4096 && points.bounds().is_finite());
        let none = Points::build(&Arc::default(), None, &[], &PrepareOptions::default()).unwrap();
        assert!(none.bounds().is_empty());
        assert!(none.intersect(&Ray::new(DVec3::ZERO, DVec3::X)).is_none());
    }
}

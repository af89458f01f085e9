//! Triangle meshes that rays can be intersected with.
//!
//! **Precision.** The tree ([`turner_bvh::Bvh`]) decides in f32 which triangle is hit; it holds the vertices exactly,
//! or shifted without loss. Where the ray hits that triangle, and whether t is within t_min..t_max, is computed in
//! f64 from the same vertices. Surface points are thus off by f64 rounding only, for meshes of any size and position,
//! and a ray that leaves a surface does not hit it again. Within some 2^-20 of the mesh's size of an edge, f32 may
//! report a hit that f64 does not confirm. Then the neighbouring triangles are tested in f64: no ray passes through
//! an edge, and none that leaves at a grazing angle hits the next triangle. Of several triangles at the same f32 t,
//! the one with the lowest index is hit.
//!
//! **Memory.** Vertices and triangles are shared with the description: 12 bytes per triangle and 12 per vertex, with
//! about one vertex per two triangles. The tree takes 46 to 54 bytes per triangle: 40 in partly filled blocks of
//! eight, the rest in nodes. Computed vertex normals take 12 bytes per vertex.

use std::sync::{Arc, OnceLock};

use turner_bvh::{BuildError, BuildOptions, Bvh, Hit, Quality, Triangles};

use super::extent::{Extent, without_flat};
use super::mesh_search::{MeshRay, MeshSpace};
use super::triangle::RayShear;
use super::{ROUNDING, ShapeHit, SurfacePoint, mean_parts};
use crate::math::{Bounds, DVec2, DVec3, Ray};
use crate::schema::{ErrorCode, MeshData, PrepareOptions, SceneError};

/// Peak bytes per triangle of a balanced build, including the tree; 49 are measured.
const BUILD: u64 = 60;

/// Triangles per intersection test.
const BLOCK: f64 = 8.0;

/// A triangle mesh with its tree.
#[derive(Clone, Debug)]
pub struct TriangleMesh {
    bounds: Bounds,
    space: MeshSpace,
    /// Built only if rays are traced through this mesh separately, not through the scene's joined mesh.
    tree: OnceLock<Bvh>,
    /// Number of triangles that can be hit, and whether degenerate ones must be filtered out for the tree.
    hittable: usize,
    has_flat: bool,
    /// See [`Shape::tests_per_ray`](super::Shape::tests_per_ray).
    tests_per_ray: f64,
    pub(super) data: Arc<MeshData>,
    smooth: bool,
    /// Computed if `smooth` is set and the data have none.
    computed_normals: Vec<[f32; 3]>,
    error: f64,
}

/// Triangles of a mesh that rays cannot hit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SkippedTriangles {
    /// With a NaN or infinite vertex.
    pub non_finite: usize,
    /// Without area.
    pub flat: usize,
}

pub(super) fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::from(v.map(f64::from))
}

/// The normal with twice the area as its length; zero or non-finite for a degenerate triangle.
pub(super) fn area_normal(v: &[[f32; 3]; 3]) -> DVec3 {
    let [a, b, c] = v.map(wide);
    (b - a).cross(c - a)
}

impl TriangleMesh {
    /// Checks the data and builds the tree. With `smooth`, missing normals are computed.
    pub fn build(
        data: &Arc<MeshData>,
        smooth: bool,
        options: &PrepareOptions,
    ) -> Result<(TriangleMesh, SkippedTriangles), SceneError> {
        let (mesh, skipped) = TriangleMesh::without_tree(data, smooth)?;
        mesh.build_tree(options)?;
        Ok((mesh, skipped))
    }

    /// Checks the data. Call [`TriangleMesh::build_tree`] before tracing rays.
    pub fn without_tree(
        data: &Arc<MeshData>,
        smooth: bool,
    ) -> Result<(TriangleMesh, SkippedTriangles), SceneError> {
        data.check()?;
        let extent = Extent::of(&data.positions, &data.triangles);
        let computed_normals =
            if smooth && data.normals.is_empty() { vertex_normals(data) } else { Vec::new() };
        Ok((TriangleMesh::of(Arc::clone(data), &extent, smooth, computed_normals), extent.skipped))
    }

    /// From checked data, without a tree.
    pub(super) fn of(
        data: Arc<MeshData>,
        extent: &Extent,
        smooth: bool,
        computed_normals: Vec<[f32; 3]>,
    ) -> TriangleMesh {
        let Extent { bounds, areas, skipped } = *extent;
        let far = if bounds.is_empty() { 0.0 } else { bounds.min.abs().max(bounds.max.abs()).max_element() };
        TriangleMesh {
            bounds,
            space: MeshSpace::new(&bounds, &data.positions),
            tree: OnceLock::new(),
            hittable: data.triangles.len() - skipped.flat - skipped.non_finite,
            has_flat: skipped.flat > 0,
            tests_per_ray: (mean_parts(areas, &bounds) / BLOCK).max(1.0),
            data,
            smooth,
            computed_normals,
            error: ROUNDING * far,
        }
    }

    /// Builds the tree, if there is none yet.
    pub fn build_tree(&self, options: &PrepareOptions) -> Result<(), SceneError> {
        if self.tree.get().is_some() {
            return Ok(());
        }
        let data = &self.data;
        let cleared = self.has_flat.then(|| without_flat(data));
        let moved = self.space.moved(&data.positions);
        let triangles = cleared.as_deref().unwrap_or(&data.triangles);
        let positions = moved.as_deref().unwrap_or(&data.positions);
        options.limits.memory.need((triangles.len() as u64).saturating_mul(BUILD), || self.tree_name())?;
        let tree = Bvh::build(&Triangles { positions, triangles }, &self.build_options(options))
            .map_err(|e| self.refused(&e, options))?;
        self.set_tree(tree);
        Ok(())
    }

    pub(super) fn tree_name(&self) -> String {
        format!("the search tree of a mesh of {} triangles", self.data.triangles.len())
    }

    pub(super) fn build_options(&self, options: &PrepareOptions) -> BuildOptions<'static> {
        // High quality falls back to what fits into the remaining memory.
        let left = usize::try_from(options.limits.memory.left()).ok().filter(|left| *left != usize::MAX);
        BuildOptions {
            quality: options.quality,
            threads: options.threads,
            instruction_set: options.instruction_set,
            memory_limit: left.filter(|_| options.quality == Quality::High),
            ..BuildOptions::default()
        }
    }

    /// The error for a tree that could not be built.
    pub(super) fn refused(&self, error: &BuildError, options: &PrepareOptions) -> SceneError {
        let memory = &options.limits.memory;
        let refused = match error {
            BuildError::OutOfMemory { needed } => memory.need(*needed as u64, || self.tree_name()).err(),
            _ => None,
        };
        refused.unwrap_or_else(|| SceneError::new(ErrorCode::TooLarge, error.to_string()))
    }

    /// Sets the tree if there is none; returns true. A tree set by another thread is identical.
    pub(super) fn set_tree(&self, tree: Bvh) -> bool {
        let _ = self.tree.set(tree);
        true
    }

    #[inline]
    pub(super) fn space(&self) -> &MeshSpace {
        &self.space
    }

    #[inline]
    pub(super) fn tree(&self) -> &Bvh {
        match self.tree.get() {
            Some(tree) => tree,
            None => unreachable!("trees are built when the scene is prepared"),
        }
    }

    /// Bounding box; empty without triangles.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The boxes of the nodes of its BVH at a depth, in the coordinates of the mesh, as for [`turner_bvh::Bvh::boxes`]. None
    /// without a BVH of its own.
    pub(crate) fn bvh_boxes(&self, depth: u32, limit: usize) -> Vec<Bounds> {
        let boxes = self.tree.get().map_or(Vec::new(), |tree| tree.boxes(depth, limit));
        let of = |v: [f32; 3]| wide(v) + self.space.shift();
        boxes.iter().map(|b| Bounds::new(of(b.min), of(b.max))).collect()
    }

    /// The data it is prepared from.
    pub fn data(&self) -> &Arc<MeshData> {
        &self.data
    }

    /// Number of triangles that can be hit.
    pub fn triangle_count(&self) -> usize {
        self.hittable
    }

    /// Bytes of the tree.
    pub fn tree_bytes(&self) -> usize {
        self.tree.get().map_or(0, |tree| tree.stats().bytes)
    }

    /// Bytes of memory, including the data shared with the description.
    pub fn memory(&self) -> usize {
        size_of_val(self) + self.tree_bytes() + size_of_val(&self.computed_normals[..]) + self.data.memory()
    }

    /// See [`Shape::tests_per_ray`](super::Shape::tests_per_ray).
    pub(crate) fn tests_per_ray(&self) -> f64 {
        self.tests_per_ray
    }

    /// Counts the traversal steps of a ray through the tree.
    pub fn search_steps(&self, ray: &Ray) -> turner_bvh::Steps {
        self.space.ray(ray).map_or_else(Default::default, |search| self.tree().steps(&search.ray))
    }

    /// The nearest triangle; of several at the same t, the one with the lowest index.
    pub fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        let search = self.space.ray(ray)?;
        let check = |hit: &Hit| !search.may_precede_start(hit) || self.exact(&search, hit).is_some();
        let hit = self.tree().intersect_filtered(&search.ray, check)?;
        self.finish(&search, &hit)
    }

    /// The nearest hit that `accept` accepts. `accept` is called in any order.
    pub fn intersect_where(&self, ray: &Ray, accept: &dyn Fn(&ShapeHit) -> bool) -> Option<ShapeHit> {
        let search = self.space.ray(ray)?;
        let check = |hit: &Hit| self.exact(&search, hit).is_some_and(|hit| accept(&hit));
        let hit = self.tree().intersect_filtered(&search.ray, check)?;
        self.exact(&search, &hit).filter(|hit| search.ends_after(hit.t))
    }

    /// Whether any triangle is hit. Between the ray's ends f32 decides: within some 2^-20 of the mesh's size of a
    /// silhouette, the answer may differ from that of [`TriangleMesh::intersect`].
    pub fn occludes(&self, ray: &Ray) -> bool {
        let Some(search) = self.space.ray(ray) else { return false };
        let check = |hit: &Hit| {
            search.is_safe(hit) || self.exact(&search, hit).is_some_and(|hit| search.ends_after(hit.t))
        };
        self.tree().occluded_filtered(&search.ray, check)
    }

    /// Whether there is a hit that `accept` accepts.
    pub fn occludes_where(&self, ray: &Ray, accept: &dyn Fn(&ShapeHit) -> bool) -> bool {
        let Some(search) = self.space.ray(ray) else { return false };
        let check =
            |hit: &Hit| self.exact(&search, hit).is_some_and(|hit| search.ends_after(hit.t) && accept(&hit));
        self.tree().occluded_filtered(&search.ray, check)
    }

    /// The corners of a triangle; `None` if the index is out of range.
    pub fn triangle_corners(&self, part: u32) -> Option<[DVec3; 3]> {
        Some(self.data.triangles.get(part as usize)?.map(|i| wide(self.data.positions[i as usize])))
    }

    /// Bound on the distance of surface points from the true surface.
    #[inline]
    pub(crate) fn error(&self) -> f64 {
        self.error
    }

    /// The corners of a triangle, as stored.
    #[inline]
    pub(crate) fn corners(&self, part: u32) -> [[f32; 3]; 3] {
        self.data.triangles[part as usize].map(|i| self.data.positions[i as usize])
    }

    /// Reads something of the corners of a triangle, and of its vertex normals in its own mesh.
    #[inline]
    pub(crate) fn touch(&self, part: u32, own: &TriangleMesh, own_part: u32) -> u32 {
        let at = |[a, b, c]: [u32; 3], v: &[[f32; 3]]| [a, b, c].map(|i| v[i as usize][0].to_bits());
        let [a, b, c] = at(self.data.triangles[part as usize], &self.data.positions);
        let normals = own.normals();
        if normals.is_empty() {
            return a ^ b ^ c;
        }
        let [d, e, f] = at(own.data.triangles[own_part as usize], normals);
        a ^ b ^ c ^ d ^ e ^ f
    }

    /// The vertex normals of a triangle; `None` if it is shaded with its geometric normal.
    #[inline]
    pub(crate) fn normals_at_corners(&self, part: u32) -> Option<[[f32; 3]; 3]> {
        let normals = self.normals();
        (!normals.is_empty()).then(|| self.data.triangles[part as usize].map(|i| normals[i as usize]))
    }

    /// The corners of a triangle.
    pub(super) fn corner_points(&self, part: u32) -> [DVec3; 3] {
        self.corners(part).map(wide)
    }

    /// The corners' (u, v) of a set (set 0 if there is no such set); without any, barycentric weights.
    pub(super) fn corner_uvs(&self, part: u32, set: usize) -> [DVec2; 3] {
        let other = set.checked_sub(1).and_then(|i| self.data.more_uvs.get(i));
        let uvs = other.unwrap_or(&self.data.uvs);
        if uvs.is_empty() {
            return [DVec2::ZERO, DVec2::X, DVec2::Y];
        }
        self.data.triangles[part as usize].map(|i| DVec2::from(uvs[i as usize].map(f64::from)))
    }

    /// The corners' shading normals, if it is smooth.
    pub(super) fn corner_normals(&self, part: u32) -> Option<[DVec3; 3]> {
        self.normals_at_corners(part).map(|normals| normals.map(wide))
    }

    /// Whether f64 confirms a hit near `t_min`.
    pub(super) fn is_exact(&self, ray: &Ray, hit: &Hit) -> bool {
        self.space.ray(ray).is_some_and(|search| self.exact(&search, hit).is_some())
    }

    /// Whether f64 confirms that a hit lies between the ray's ends.
    pub(super) fn is_within(&self, ray: &Ray, hit: &Hit) -> bool {
        self.space
            .ray(ray)
            .is_some_and(|search| self.exact(&search, hit).is_some_and(|hit| search.ends_after(hit.t)))
    }

    /// The f64 hit for a hit of the tree.
    #[inline]
    pub(super) fn finish_ray(&self, ray: &Ray, hit: &Hit) -> Option<ShapeHit> {
        if let Some(exact) = RayShear::new(ray).triangle(&self.corners(hit.primitive))
            && exact.t.is_finite()
            && exact.t >= ray.t_min
        {
            let hit = ShapeHit { t: exact.t, part: hit.primitive, u: exact.u, v: exact.v };
            return (hit.t <= ray.t_max).then_some(hit);
        }
        self.finish(&self.space.ray(ray)?, hit)
    }

    /// The f64 hit for a hit of the tree. In the rare case that there is none, searches again and checks every hit.
    fn finish(&self, search: &MeshRay, hit: &Hit) -> Option<ShapeHit> {
        let exact = self.exact(search, hit).or_else(|| self.search_again(search))?;
        search.ends_after(exact.t).then_some(exact)
    }

    #[cold]
    #[inline(never)]
    fn search_again(&self, search: &MeshRay) -> Option<ShapeHit> {
        let check = |hit: &Hit| self.exact(search, hit).is_some();
        let hit = self.tree().intersect_filtered(&search.ray, check)?;
        self.exact(search, &hit)
    }

    /// A hit in f64; `None` if it lies before `t_min` or is not confirmed.
    #[inline]
    fn exact(&self, search: &MeshRay, hit: &Hit) -> Option<ShapeHit> {
        match self.intersect_f64(search, hit) {
            Some(exact) => (exact.t >= search.original.t_min).then_some(exact),
            None => self.recheck_near_edge(search, hit),
        }
    }

    /// Where the ray hits a triangle in f64, if it does.
    #[inline]
    fn intersect_f64(&self, search: &MeshRay, hit: &Hit) -> Option<ShapeHit> {
        let at = RayShear::new(&search.original).triangle(&self.corners(hit.primitive))?;
        let hit = ShapeHit { t: at.t, part: hit.primitive, u: at.u, v: at.v };
        at.t.is_finite().then_some(hit)
    }

    /// Handles an f32 hit that f64 does not confirm: the ray passes just outside an edge, or lies almost in the
    /// plane. Usually it hits a neighbour, which slightly offset rays find; if not, it passes the mesh within the f32
    /// error.
    #[cold]
    #[inline(never)]
    fn recheck_near_edge(&self, search: &MeshRay, hit: &Hit) -> Option<ShapeHit> {
        let ray = &search.original;
        let [a, b, c] = self.corners(hit.primitive).map(wide);
        let normal = (b - a).cross(c - a);
        let start = normal.dot(ray.origin + ray.t_min * ray.direction - a);
        let approach = normal.dot(ray.direction);
        if approach > 0.0 && start > 0.0 || approach < 0.0 && start < 0.0 || approach == 0.0 {
            // The plane is behind the ray.
            return None;
        }
        let mut nearest: Option<ShapeHit> = None;
        for moved in search.offset_rays(hit) {
            let check = |hit: &Hit| self.intersect_f64(search, hit).is_some_and(|hit| hit.t >= ray.t_min);
            let found = self
                .tree()
                .intersect_filtered(&moved, check)
                .and_then(|hit| self.intersect_f64(search, &hit));
            if let Some(found) = found
                && nearest.is_none_or(|n| found.t < n.t || found.t == n.t && found.part < n.part)
            {
                nearest = Some(found);
            }
        }
        if nearest.is_some() || search.may_precede_start(hit) {
            return nearest;
        }
        // No neighbour. A front face counts even so: it may be too thin to be found. A back face counts only if it is
        // missed by no more than rounding; otherwise a ray that leaves a ridge would hit the ridge's far side.
        if approach > 0.0 && search.is_clear_miss(RayShear::new(ray).miss(&self.corners(hit.primitive))) {
            return None;
        }
        let u = f64::from(hit.u).clamp(0.0, 1.0);
        let v = f64::from(hit.v).clamp(0.0, 1.0 - u);
        let t = search.t_of((1.0 - u - v) * a + u * b + v * c);
        let counts = t >= ray.t_min && t < f64::INFINITY;
        counts.then_some(ShapeHit { t, part: hit.primitive, u, v })
    }

    /// Vertex normals for shading; empty for facets.
    fn normals(&self) -> &[[f32; 3]] {
        match (self.smooth, self.data.normals.is_empty()) {
            (false, _) => &[],
            (true, false) => &self.data.normals,
            (true, true) => &self.computed_normals,
        }
    }

    /// The surface point from the barycentric weights; the shading normal is on the side of the geometric normal.
    pub fn surface(&self, hit: &ShapeHit) -> SurfacePoint {
        let vertices = self.corners(hit.part);
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let mix = |v: [DVec3; 3]| weights[0] * v[0] + weights[1] * v[1] + weights[2] * v[2];
        let ng = area_normal(&vertices).normalize();
        let ns = self.interpolated_normal(hit).map_or(ng, |n| match n.dot(ng) {
            side if side > 0.0 => n,
            side if side < 0.0 => -n,
            _ => ng,
        });
        SurfacePoint { p: mix(vertices.map(wide)), error: self.error, ng, ns }
    }

    /// The unit normal of a triangle, by the order of its corners.
    #[inline]
    pub(crate) fn geometric_normal(&self, part: u32) -> DVec3 {
        area_normal(&self.corners(part)).normalize()
    }

    /// The vertex normals weighted by the barycentric weights, unit; `None` for facets, and where they cancel.
    #[inline]
    pub(crate) fn interpolated_normal(&self, hit: &ShapeHit) -> Option<DVec3> {
        let [a, b, c] = self.normals_at_corners(hit.part)?.map(wide);
        ((1.0 - hit.u - hit.v) * a + hit.u * b + hit.v * c).try_normalize()
    }
}

/// Area-weighted means of the triangle normals around each vertex.
fn vertex_normals(data: &MeshData) -> Vec<[f32; 3]> {
    let mut sums = vec![DVec3::ZERO; data.positions.len()];
    for t in &data.triangles {
        let n = area_normal(&t.map(|i| data.positions[i as usize]));
        // Skipped triangles may have non-finite normals.
        if n.is_finite() {
            for &i in t {
                sums[i as usize] += n;
            }
        }
    }
    sums.into_iter().map(|n| n.normalize_or_zero().as_vec3().to_array()).collect()
}

#[cfg(test)]
#[path = "triangle_mesh_tests.rs"]
mod tests;

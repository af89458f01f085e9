//! Triangle meshes ready to be traced.
//!
//! **Search and truth.** The tree ([`turner_bvh::Bvh`]) finds the triangle in single precision; it holds the vertices
//! as they are, or moved by a vector that loses no bit of them. Where a ray meets that triangle is then computed
//! in double precision from the same vertices, and so are `t_min` and `t_max` decided: a surface point is off by
//! rounding of double precision only, however large or far away the mesh is, and a ray that leaves a surface does
//! not meet it again. Where single precision sees a hit that double precision does not, which happens within some
//! 2^-20 of the mesh's size of an edge, the triangles around are asked in double precision: no ray slips through an
//! edge, and none that leaves a surface at a grazing angle is caught by the next triangle.
//!
//! Of several triangles at the same t, in single precision, the one with the lowest number is hit.
//!
//! **Memory.** The vertices and triangles are those of the description, shared with it: 12 bytes per triangle and 12 per
//! vertex, a vertex per two triangles. The tree takes 46 to 54 bytes per triangle: 40 in blocks of eight of which
//! some places stay empty, the rest in nodes. Vertex normals that a file does not have take 12 bytes per vertex.

use std::sync::{Arc, OnceLock};

use turner_bvh::{BuildError, BuildOptions, Bvh, Hit, Quality, Triangles};

use super::extent::{Extent, without_flat};
use super::mesh_search::{MeshRay, MeshSpace};
use super::triangle::RayShear;
use super::{ROUNDING, ShapeHit, SurfacePoint, mean_parts};
use crate::math::{Bounds, DVec2, DVec3, Ray};
use crate::schema::{ErrorCode, MeshData, PrepareOptions, SceneError};

/// Bytes that a triangle takes at the peak of a balanced build, the tree included; measured: 49.
const BUILD: u64 = 60;

/// Triangles that are tested at a time.
const BLOCK: f64 = 8.0;

/// A triangle mesh with its tree.
#[derive(Clone, Debug)]
pub struct TriangleMesh {
    bounds: Bounds,
    space: MeshSpace,
    /// Built when it is known that rays go through this mesh by itself.
    tree: OnceLock<Bvh>,
    /// Triangles that can be hit, and whether the list has to be cleared of others for the tree.
    shown: usize,
    has_flat: bool,
    /// See [`Shape::tests_per_ray`](super::Shape::tests_per_ray).
    tests_per_ray: f64,
    data: Arc<MeshData>,
    smooth: bool,
    /// Computed where the data have none and `smooth` wants them.
    made_normals: Vec<[f32; 3]>,
    error: f64,
}

/// Triangles that a mesh has but that cannot be shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SkippedTriangles {
    /// With a vertex that is NaN or infinite.
    pub non_finite: usize,
    /// Without area.
    pub flat: usize,
}

pub(super) fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::from(v.map(f64::from))
}

/// The normal with the length of twice the area; zero or not finite for a triangle without area.
pub(super) fn area_normal(v: &[[f32; 3]; 3]) -> DVec3 {
    let [a, b, c] = v.map(wide);
    (b - a).cross(c - a)
}

impl TriangleMesh {
    /// Checks the data and builds the tree. With `smooth`, normals that are missing are computed.
    pub fn build(
        data: &Arc<MeshData>,
        smooth: bool,
        options: &PrepareOptions,
    ) -> Result<(TriangleMesh, SkippedTriangles), SceneError> {
        let (mesh, left_out) = TriangleMesh::without_tree(data, smooth)?;
        mesh.build_tree(options)?;
        Ok((mesh, left_out))
    }

    /// Checks the data; [`TriangleMesh::build_tree`] must follow before rays are traced.
    pub fn without_tree(
        data: &Arc<MeshData>,
        smooth: bool,
    ) -> Result<(TriangleMesh, SkippedTriangles), SceneError> {
        data.check()?;
        let extent = Extent::of(&data.positions, &data.triangles);
        let made_normals = if smooth && data.normals.is_empty() { vertex_normals(data) } else { Vec::new() };
        Ok((TriangleMesh::of(Arc::clone(data), &extent, smooth, made_normals), extent.left_out))
    }

    /// Without a tree, of data that were checked.
    pub(super) fn of(
        data: Arc<MeshData>,
        extent: &Extent,
        smooth: bool,
        made_normals: Vec<[f32; 3]>,
    ) -> TriangleMesh {
        let Extent { bounds, areas, left_out } = *extent;
        let far = if bounds.is_empty() { 0.0 } else { bounds.min.abs().max(bounds.max.abs()).max_element() };
        TriangleMesh {
            bounds,
            space: MeshSpace::new(&bounds, &data.positions),
            tree: OnceLock::new(),
            shown: data.triangles.len() - left_out.flat - left_out.non_finite,
            has_flat: left_out.flat > 0,
            tests_per_ray: (mean_parts(areas, &bounds) / BLOCK).max(1.0),
            data,
            smooth,
            made_normals,
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
        // What high quality would take beyond what there is it saves.
        let left = usize::try_from(options.limits.memory.left()).ok().filter(|left| *left != usize::MAX);
        BuildOptions {
            quality: options.quality,
            threads: options.threads,
            instruction_set: options.instruction_set,
            memory_limit: left.filter(|_| options.quality == Quality::High),
            ..BuildOptions::default()
        }
    }

    /// Why there is no tree.
    pub(super) fn refused(&self, error: &BuildError, options: &PrepareOptions) -> SceneError {
        let memory = &options.limits.memory;
        let refused = match error {
            BuildError::OutOfMemory { needed } => memory.need(*needed as u64, || self.tree_name()).err(),
            _ => None,
        };
        refused.unwrap_or_else(|| SceneError::new(ErrorCode::TooLarge, error.to_string()))
    }

    /// Sets the tree if there is none; says that there is one. Another thread's tree is the same.
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

    /// The box around it; empty if it has no triangles.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// What it was made of.
    pub fn data(&self) -> &Arc<MeshData> {
        &self.data
    }

    /// Triangles that can be hit.
    pub fn triangle_count(&self) -> usize {
        self.shown
    }

    /// Bytes of the tree.
    pub fn tree_bytes(&self) -> usize {
        self.tree.get().map_or(0, |tree| tree.stats().bytes)
    }

    /// Bytes it takes, the data that it shares with the description included.
    pub fn memory(&self) -> usize {
        size_of_val(self) + self.tree_bytes() + size_of_val(&self.made_normals[..]) + self.data.memory()
    }

    /// See [`Shape::tests_per_ray`](super::Shape::tests_per_ray).
    pub(crate) fn tests_per_ray(&self) -> f64 {
        self.tests_per_ray
    }

    /// What lies on the way of a ray through its tree.
    pub fn search_steps(&self, ray: &Ray) -> turner_bvh::Steps {
        self.space.ray(ray).map_or_else(Default::default, |search| self.tree().steps(&search.ray))
    }

    /// The nearest triangle, of several at the same t the one with the lowest number.
    pub fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        let search = self.space.ray(ray)?;
        let check = |hit: &Hit| !search.is_doubtful(hit) || self.exact(&search, hit).is_some();
        let hit = self.tree().intersect_filtered(&search.ray, check)?;
        self.finish(&search, &hit)
    }

    /// The nearest of the hits that `accept` takes. It is asked about hits in any order.
    pub fn intersect_where(&self, ray: &Ray, accept: &dyn Fn(&ShapeHit) -> bool) -> Option<ShapeHit> {
        let search = self.space.ray(ray)?;
        let check = |hit: &Hit| self.exact(&search, hit).is_some_and(|hit| accept(&hit));
        let hit = self.tree().intersect_filtered(&search.ray, check)?;
        self.exact(&search, &hit).filter(|hit| search.ends_after(hit.t))
    }

    /// Whether any triangle is hit. Between the ray's ends single precision decides: within some 2^-20 of the mesh's size of a
    /// silhouette, a ray may be stopped that [`TriangleMesh::intersect`] lets pass, or the other way around.
    pub fn occludes(&self, ray: &Ray) -> bool {
        let Some(search) = self.space.ray(ray) else { return false };
        let check = |hit: &Hit| {
            search.is_certain(hit) || self.exact(&search, hit).is_some_and(|hit| search.ends_after(hit.t))
        };
        self.tree().occluded_filtered(&search.ray, check)
    }

    /// Whether there is a hit that `accept` takes.
    pub fn occludes_where(&self, ray: &Ray, accept: &dyn Fn(&ShapeHit) -> bool) -> bool {
        let Some(search) = self.space.ray(ray) else { return false };
        let check =
            |hit: &Hit| self.exact(&search, hit).is_some_and(|hit| search.ends_after(hit.t) && accept(&hit));
        self.tree().occluded_filtered(&search.ray, check)
    }

    /// The corners of a triangle; `None` if there are not so many.
    pub fn triangle_corners(&self, part: u32) -> Option<[DVec3; 3]> {
        Some(self.data.triangles.get(part as usize)?.map(|i| wide(self.data.positions[i as usize])))
    }

    /// Whether it is shaded with the normals of its triangles.
    #[inline]
    pub(crate) fn is_faceted(&self) -> bool {
        self.normals().is_empty()
    }

    /// Bound on the distance of points on it from the true ones.
    #[inline]
    pub(crate) fn error(&self) -> f64 {
        self.error
    }

    /// The corners of a triangle as they are kept.
    #[inline]
    pub(crate) fn corners(&self, part: u32) -> [[f32; 3]; 3] {
        self.data.triangles[part as usize].map(|i| self.data.positions[i as usize])
    }

    /// The corners of a triangle.
    pub(super) fn corner_points(&self, part: u32) -> [DVec3; 3] {
        self.corners(part).map(wide)
    }

    /// The corners' (u, v) of a set, or of the first one if there are not so many; without any, the weights of the second and third corner.
    pub(super) fn corner_uvs(&self, part: u32, set: usize) -> [DVec2; 3] {
        let other = set.checked_sub(1).and_then(|i| self.data.more_uvs.get(i));
        let uvs = other.unwrap_or(&self.data.uvs);
        if uvs.is_empty() {
            return [DVec2::ZERO, DVec2::X, DVec2::Y];
        }
        self.data.triangles[part as usize].map(|i| DVec2::from(uvs[i as usize].map(f64::from)))
    }

    /// The corners' normals, if it is smooth.
    pub(super) fn corner_normals(&self, part: u32) -> Option<[DVec3; 3]> {
        let normals = self.normals();
        let corners = self.data.triangles[part as usize];
        (!normals.is_empty()).then(|| corners.map(|i| wide(normals[i as usize])))
    }

    /// Whether a hit counts that may lie before `t_min`.
    pub(super) fn is_exact(&self, ray: &Ray, hit: &Hit) -> bool {
        self.space.ray(ray).is_some_and(|search| self.exact(&search, hit).is_some())
    }

    /// Whether a hit lies between the ray's ends.
    pub(super) fn is_within(&self, ray: &Ray, hit: &Hit) -> bool {
        self.space
            .ray(ray)
            .is_some_and(|search| self.exact(&search, hit).is_some_and(|hit| search.ends_after(hit.t)))
    }

    /// What the search found for a ray, in double precision.
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

    /// What the search found, in double precision. In the rare case that it is none, the search is done again with all
    /// hits checked.
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

    /// A hit in double precision; `None` if it lies before `t_min`, or is none and need not count.
    #[inline]
    fn exact(&self, search: &MeshRay, hit: &Hit) -> Option<ShapeHit> {
        match self.strict(search, hit) {
            Some(exact) => (exact.t >= search.original.t_min).then_some(exact),
            None => self.past_an_edge(search, hit),
        }
    }

    /// Where the ray meets a triangle that the search reports, if it does in double precision.
    #[inline]
    fn strict(&self, search: &MeshRay, hit: &Hit) -> Option<ShapeHit> {
        let at = RayShear::new(&search.original).triangle(&self.corners(hit.primitive))?;
        let hit = ShapeHit { t: at.t, part: hit.primitive, u: at.u, v: at.v };
        at.t.is_finite().then_some(hit)
    }

    /// A hit in single precision that is none in double precision: the ray passes an edge, or lies almost in the plane.
    /// Then it meets a neighbour, which rays moved by the precision of the search find; or it passes between the
    /// mesh and the search's idea of it.
    #[cold]
    #[inline(never)]
    fn past_an_edge(&self, search: &MeshRay, hit: &Hit) -> Option<ShapeHit> {
        let ray = &search.original;
        let [a, b, c] = self.corners(hit.primitive).map(wide);
        let normal = (b - a).cross(c - a);
        let start = normal.dot(ray.origin + ray.t_min * ray.direction - a);
        let way = normal.dot(ray.direction);
        if way > 0.0 && start > 0.0 || way < 0.0 && start < 0.0 || way == 0.0 {
            // The plane is behind.
            return None;
        }
        let mut nearest: Option<ShapeHit> = None;
        for moved in search.moved_around(hit) {
            let check = |hit: &Hit| self.strict(search, hit).is_some_and(|hit| hit.t >= ray.t_min);
            let found =
                self.tree().intersect_filtered(&moved, check).and_then(|hit| self.strict(search, &hit));
            if let Some(found) = found
                && nearest.is_none_or(|n| found.t < n.t || found.t == n.t && found.part < n.part)
            {
                nearest = Some(found);
            }
        }
        if nearest.is_some() || search.is_doubtful(hit) {
            return nearest;
        }
        // Without a neighbour, a front that is met counts, should it be too thin to be found; a back only if it is missed by
        // no more than rounding, or a ray that leaves a ridge would be caught by its far side.
        if way > 0.0 && search.is_beside(RayShear::new(ray).miss(&self.corners(hit.primitive))) {
            return None;
        }
        let u = f64::from(hit.u).clamp(0.0, 1.0);
        let v = f64::from(hit.v).clamp(0.0, 1.0 - u);
        let t = search.t_of((1.0 - u - v) * a + u * b + v * c);
        let counts = t >= ray.t_min && t < f64::INFINITY;
        counts.then_some(ShapeHit { t, part: hit.primitive, u, v })
    }

    /// Vertex normals to shade with; empty for facets.
    fn normals(&self) -> &[[f32; 3]] {
        match (self.smooth, self.data.normals.is_empty()) {
            (false, _) => &[],
            (true, false) => &self.data.normals,
            (true, true) => &self.made_normals,
        }
    }

    /// The surface at a hit: the point from its weights, the shading normal on the side of the geometric one.
    pub fn surface(&self, hit: &ShapeHit) -> SurfacePoint {
        let vertices = self.corners(hit.part);
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let mix = |v: [DVec3; 3]| weights[0] * v[0] + weights[1] * v[1] + weights[2] * v[2];
        let ng = area_normal(&vertices).normalize();
        let mut ns = ng;
        let normals = self.normals();
        if !normals.is_empty() {
            let corners = self.data.triangles[hit.part as usize].map(|i| wide(normals[i as usize]));
            if let Some(n) = mix(corners).try_normalize() {
                let side = n.dot(ng);
                ns = match side {
                    s if s > 0.0 => n,
                    s if s < 0.0 => -n,
                    _ => ng,
                };
            }
        }
        SurfacePoint { p: mix(vertices.map(wide)), error: self.error, ng, ns }
    }

    /// A value of the vertices, interpolated; `None` if the list is empty.
    fn interpolate<const N: usize>(&self, hit: &ShapeHit, values: &[[f32; N]]) -> Option<[f64; N]> {
        if values.is_empty() {
            return None;
        }
        let [a, b, c] = self.data.triangles[hit.part as usize].map(|i| values[i as usize].map(f64::from));
        let w = 1.0 - hit.u - hit.v;
        Some(std::array::from_fn(|i| w * a[i] + hit.u * b[i] + hit.v * c[i]))
    }

    /// The mesh's own (u, v), or the weights of the second and third vertex.
    pub fn uv(&self, hit: &ShapeHit) -> DVec2 {
        self.uv_set(hit, 0)
    }

    /// (u, v) of one of its sets; of the first one if there are not so many.
    pub fn uv_set(&self, hit: &ShapeHit, set: usize) -> DVec2 {
        let other = set.checked_sub(1).and_then(|i| self.data.more_uvs.get(i));
        let found = self.interpolate(hit, other.unwrap_or(&self.data.uvs));
        found.map_or(DVec2::new(hit.u, hit.v), DVec2::from)
    }

    /// The vertex colour, linear RGB and opacity, if there are any.
    pub fn color(&self, hit: &ShapeHit) -> Option<[f32; 4]> {
        self.interpolate(hit, &self.data.colors).map(|c| c.map(|x| x as f32))
    }

    /// The tangent along u, unit length, and on which side the bitangent lies (1 or -1), if there are any.
    pub fn tangent(&self, hit: &ShapeHit) -> Option<(DVec3, f64)> {
        let [x, y, z, side] = self.interpolate(hit, &self.data.tangents)?;
        let tangent = DVec3::new(x, y, z).try_normalize()?;
        Some((tangent, if side < 0.0 { -1.0 } else { 1.0 }))
    }

    /// The directions in which u and v of a set grow, of no particular length; `None` where they do not.
    pub fn uv_directions(&self, hit: &ShapeHit, set: usize) -> Option<(DVec3, DVec3)> {
        let other = set.checked_sub(1).and_then(|i| self.data.more_uvs.get(i));
        let uvs = other.unwrap_or(&self.data.uvs);
        if uvs.is_empty() {
            return None;
        }
        let [a, b, c] =
            self.data.triangles[hit.part as usize].map(|i| DVec2::from(uvs[i as usize].map(f64::from)));
        let (b, c) = (b - a, c - a);
        let [p, q, r] = self.corners(hit.part).map(wide);
        let (q, r) = (q - p, r - p);
        let area = b.x * c.y - b.y * c.x;
        let along_u = (q * c.y - r * b.y) * area.signum();
        let along_v = (r * b.x - q * c.x) * area.signum();
        let known = area != 0.0 && along_u.is_finite() && along_v.is_finite();
        known.then_some((along_u, along_v))
    }

    /// Which of the mesh's materials a triangle has: 0 if it does not say.
    pub fn face_material(&self, part: u32) -> usize {
        self.data.face_materials.get(part as usize).map_or(0, |&m| usize::from(m))
    }
}

/// Sums of the normals around each vertex, weighted by area.
fn vertex_normals(data: &MeshData) -> Vec<[f32; 3]> {
    let mut sums = vec![DVec3::ZERO; data.positions.len()];
    for t in &data.triangles {
        let n = area_normal(&t.map(|i| data.positions[i as usize]));
        // Those left out have none that is finite.
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

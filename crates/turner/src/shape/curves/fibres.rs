//! Prepared curves: their segments and the BVH over them.

use std::sync::Arc;

use turner_bvh::{BlockBvh, BuildOptions};

use super::blocks::{Block, BlockRay};
use super::cubic::{At, Cubic, Found, Section, SeenAlong, normal_of};
use super::{CurveBasis, CurveKind, CurvesDesc};
use crate::math::{Bounds, DVec2, DVec3, Ray};
use crate::schema::{ErrorCode, MeshData, PrepareOptions, SceneError};
use crate::shape::traversal::TraversalFrame;
use crate::shape::{ROUNDING, ShapeHit, SurfacePoint, mean_parts};

/// Bits of a segment's entry: it is the first or the last of its curve. The others are the index of its first point.
const FIRST: u32 = 1 << 31;
const LAST: u32 = 1 << 30;
const INDEX: u32 = LAST - 1;
/// A segment is divided into at most 2 parts with a box each, and into 2^3 where there are at most [`MANY`] parts.
const LEVEL: u32 = 1;
const MAX_LEVEL: u32 = 3;
const MANY: usize = 1 << 13;
/// Boxes are divided while that removes this fraction of their surface.
const WORTH: f64 = 0.3;
/// Most hits of one segment that are offered to a test, which may refuse them.
const MAX_HITS: usize = 8;

/// Curves with their BVH: some 40 bytes for each part of a segment (one or two parts, up to eight of few segments) and 4
/// for each segment and each curve, in addition to the points, which are shared with the description.
#[derive(Clone, Debug)]
pub struct Curves {
    data: Arc<MeshData>,
    basis: CurveBasis,
    kind: CurveKind,
    /// Width of all curves, or 0: that of the points.
    width: f64,
    segments: Vec<u32>,
    /// For each curve, the number of segments of all curves up to it.
    ends: Vec<u32>,
    /// Each segment has 2^level parts.
    level: u32,
    tree: BlockBvh,
    blocks: Vec<Block>,
    frame: TraversalFrame,
    bounds: Bounds,
    /// See [`Shape::tests_per_ray`](crate::shape::Shape::tests_per_ray).
    tests_per_ray: f64,
}

impl Curves {
    /// Builds the BVH. Skips segments with non-finite points and those without width.
    pub(super) fn build(
        data: &Arc<MeshData>,
        desc: &CurvesDesc,
        options: &PrepareOptions,
    ) -> Result<Curves, SceneError> {
        let too_many = |e: &dyn std::fmt::Display| SceneError::new(ErrorCode::TooLarge, e.to_string());
        if data.positions.len() > INDEX as usize {
            let message = format!("{} points of curves; at most {INDEX}", data.positions.len());
            return Err(SceneError::new(ErrorCode::TooLarge, message));
        }
        let own = !data.widths.is_empty();
        let width = desc.width.unwrap_or_else(|| if own { 0.0 } else { default_width(&data.positions) });
        let (segments, ends) = segments_of(data, desc.basis, options)?;
        let mut curves = Curves {
            data: Arc::clone(data),
            basis: desc.basis,
            kind: desc.kind,
            width,
            segments,
            ends,
            level: 0,
            tree: BlockBvh::build(&[], &BuildOptions::default()).map_err(|e| too_many(&e))?.0,
            blocks: Vec::new(),
            frame: TraversalFrame::new(&Bounds::EMPTY),
            bounds: Bounds::EMPTY,
            tests_per_ray: 1.0,
        };
        for segment in 0..curves.segments.len() as u32 {
            if let Some(cubic) = curves.visible(segment) {
                curves.bounds = curves.bounds.union(&cubic.bounds());
            }
        }
        let areas;
        (curves.level, areas) = curves.best_level();
        curves.frame = TraversalFrame::new(&curves.bounds);
        let parts = 1_u32 << curves.level;
        let count = curves.segments.len() as u64 * u64::from(parts);
        /// Bytes per part while the BVH is built: its box, the builder's memory and two lanes of a block.
        const PART: u64 = 24 + 208 + 64;
        options
            .limits
            .memory
            .need(count.saturating_mul(PART), || format!("the search tree of {count} parts of curves"))?;
        let mut boxes = Vec::new();
        boxes.try_reserve_exact(count as usize).map_err(|e| too_many(&e))?;
        for segment in 0..curves.segments.len() as u32 {
            let cubic = curves.visible(segment);
            let part = |i: u32| cubic.map_or(Bounds::EMPTY, |c| c.part(i, curves.level).bounds());
            boxes.extend((0..parts).map(|i| curves.frame.aabb(&part(i))));
        }
        let build = BuildOptions {
            quality: options.quality,
            threads: options.threads,
            instruction_set: options.instruction_set,
            ..BuildOptions::default()
        };
        let blocks;
        (curves.tree, blocks) = BlockBvh::build(&boxes, &build).map_err(|e| too_many(&e))?;
        drop(boxes);
        let mut made = Vec::new();
        made.try_reserve_exact(blocks.len()).map_err(|e| too_many(&e))?;
        let part =
            |id: u32| curves.visible(id >> curves.level).map(|c| c.part(curves.part_of(id), curves.level));
        made.extend(blocks.into_iter().map(|parts| Block::new(parts, &curves.frame, part)));
        curves.blocks = made;
        curves.tests_per_ray = mean_parts(areas, &curves.bounds);
        Ok(curves)
    }

    /// The number of halvings of each segment, and the half surface area of all boxes then. From some thousand segments.
    fn best_level(&self) -> (u32, f64) {
        let step = (self.segments.len() / 4096).max(1);
        let area = |level: u32| {
            let some = (0..self.segments.len() as u32).step_by(step).filter_map(|i| self.visible(i));
            let of = |b: Bounds| {
                let s = b.size();
                s.x * s.y + s.y * s.z + s.z * s.x
            };
            let sum: f64 =
                some.map(|c| (0..1 << level).map(|i| of(c.part(i, level).bounds())).sum::<f64>()).sum();
            sum * step as f64
        };
        let (mut level, mut least) = (0, area(0));
        while level < LEVEL || level < MAX_LEVEL && self.segments.len() << (level + 1) <= MANY {
            let next = area(level + 1);
            if !(next < (1.0 - WORTH) * least) {
                break;
            }
            (level, least) = (level + 1, next);
        }
        (level, least)
    }

    /// Bounding box; empty without curves.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Number of segments.
    pub fn count(&self) -> usize {
        self.segments.len()
    }

    /// The points of the curves.
    pub(crate) fn positions(&self) -> &[[f32; 3]] {
        &self.data.positions
    }

    /// Bytes of memory, including the data shared with the description.
    pub fn memory(&self) -> usize {
        size_of_val(self)
            + self.tree.bytes()
            + size_of_val(&self.blocks[..])
            + size_of_val(&self.segments[..])
            + size_of_val(&self.ends[..])
            + self.data.memory()
    }

    #[cfg(test)]
    pub(super) fn data_memory(&self) -> usize {
        self.data.memory()
    }

    /// See [`Shape::tests_per_ray`](crate::shape::Shape::tests_per_ray).
    pub(crate) fn tests_per_ray(&self) -> f64 {
        self.tests_per_ray
    }

    /// A segment that rays can hit.
    fn visible(&self, segment: u32) -> Option<Cubic> {
        let cubic = self.cubic(segment);
        let finite = cubic.p.iter().all(|p| p.is_finite()) && cubic.r.iter().all(|r| r.is_finite());
        (finite && cubic.r.iter().any(|r| *r > 0.0)).then_some(cubic)
    }

    /// A segment as a Bézier curve.
    pub(super) fn cubic(&self, segment: u32) -> Cubic {
        let entry = self.segments[segment as usize];
        let i = (entry & INDEX) as usize;
        let at = |i: usize| {
            let p = DVec3::from(self.data.positions[i].map(f64::from));
            let width = if self.width > 0.0 { self.width } else { f64::from(self.data.widths[i]).max(0.0) };
            (p, 0.5 * width)
        };
        match self.basis {
            CurveBasis::Bezier => Cubic::of([at(i), at(i + 1), at(i + 2), at(i + 3)]),
            CurveBasis::BSpline => {
                let [a, b, c, d] = [at(i), at(i + 1), at(i + 2), at(i + 3)];
                let mean = |weights: [f64; 4]| {
                    let [wa, wb, wc, wd] = weights.map(|w| w / 6.0);
                    (a.0 * wa + b.0 * wb + c.0 * wc + d.0 * wd, a.1 * wa + b.1 * wb + c.1 * wc + d.1 * wd)
                };
                Cubic::of([
                    mean([1.0, 4.0, 1.0, 0.0]),
                    mean([0.0, 4.0, 2.0, 0.0]),
                    mean([0.0, 2.0, 4.0, 0.0]),
                    mean([0.0, 1.0, 4.0, 1.0]),
                ])
            }
            CurveBasis::Linear => {
                let (b, c) = (at(i), at(i + 1));
                let between = |t: f64| (b.0.lerp(c.0, t), b.1 + (c.1 - b.1) * t);
                Cubic::of([b, between(1.0 / 3.0), between(2.0 / 3.0), c])
            }
            CurveBasis::CatmullRom => {
                let (b, c) = (at(i), at(i + 1));
                // The ends of a curve have no curvature along it.
                let a = if entry & FIRST != 0 { (2.0 * b.0 - c.0, 2.0 * b.1 - c.1) } else { at(i - 1) };
                let d = if entry & LAST != 0 { (2.0 * c.0 - b.0, 2.0 * c.1 - b.1) } else { at(i + 2) };
                let handle = |from: (DVec3, f64), x: (DVec3, f64), y: (DVec3, f64)| {
                    (from.0 + (x.0 - y.0) / 6.0, (from.1 + (x.1 - y.1) / 6.0).max(0.0))
                };
                Cubic::of([b, handle(b, c, a), handle(c, b, d), c])
            }
        }
    }

    /// The points between which attributes of a segment are interpolated.
    fn ends_of(&self, segment: u32) -> [usize; 2] {
        let i = (self.segments[segment as usize] & INDEX) as usize;
        match self.basis {
            CurveBasis::Bezier => [i, i + 3],
            CurveBasis::BSpline => [i + 1, i + 2],
            CurveBasis::Linear | CurveBasis::CatmullRom => [i, i + 1],
        }
    }

    fn section(&self, segment: u32) -> Section {
        let entry = self.segments[segment as usize];
        match self.kind {
            CurveKind::Tube => Section::Tube([entry & FIRST != 0, entry & LAST != 0]),
            CurveKind::Flat => Section::Flat,
            CurveKind::Ribbon => {
                let normal = |i: usize| self.data.normals.get(i).map_or([0.0, 0.0, 1.0], |n| *n);
                Section::Ribbon(self.ends_of(segment).map(|i| DVec3::from(normal(i).map(f64::from))))
            }
        }
    }

    /// The nearest hit; of several at the same t, that of the segment with the lowest index.
    pub fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        self.intersect_where(ray, &|_| true)
    }

    /// The nearest hit that `accept` accepts. `accept` is called in any order.
    pub fn intersect_where(&self, ray: &Ray, accept: &dyn Fn(&ShapeHit) -> bool) -> Option<ShapeHit> {
        let search = self.frame.ray(ray)?;
        let (seen, from) = (SeenAlong::new(ray)?, BlockRay::new(&search.ray));
        let set = self.tree.instruction_set();
        let mut nearest: Option<ShapeHit> = None;
        self.tree.closest(&search.ray, |range, t_max| {
            let mut end = t_max;
            for block in &self.blocks[range.start as usize..range.end as usize] {
                for lane in lanes(block.near(set, &from, end)) {
                    let limit = nearest.map_or(ray.t_max, |n| n.t);
                    let Some(hit) = self.hit(block.parts[lane], ray, &seen, limit, accept) else { continue };
                    if nearest.is_none_or(|n| hit.t < n.t || hit.t == n.t && hit.part < n.part) {
                        nearest = Some(hit);
                        end = search.end(hit.t).min(end);
                    }
                }
            }
            end
        });
        nearest
    }

    /// Whether there is a hit that `accept` accepts.
    pub fn occludes_where(&self, ray: &Ray, accept: &dyn Fn(&ShapeHit) -> bool) -> bool {
        let (Some(search), Some(seen)) = (self.frame.ray(ray), SeenAlong::new(ray)) else { return false };
        let (from, set) = (BlockRay::new(&search.ray), self.tree.instruction_set());
        self.tree.any(&search.ray, |range| {
            self.blocks[range.start as usize..range.end as usize].iter().any(|block| {
                lanes(block.near(set, &from, search.ray.t_max))
                    .any(|lane| self.hit(block.parts[lane], ray, &seen, ray.t_max, accept).is_some())
            })
        })
    }

    /// The index of a part within its segment.
    fn part_of(&self, part: u32) -> u32 {
        part & ((1 << self.level) - 1)
    }

    /// The nearest accepted hit of one part of a segment.
    fn hit(
        &self,
        part: u32,
        ray: &Ray,
        seen: &SeenAlong,
        t_max: f64,
        accept: &dyn Fn(&ShapeHit) -> bool,
    ) -> Option<ShapeHit> {
        let (segment, part) = (part >> self.level, self.part_of(part));
        let (cubic, section) = (self.cubic(segment), self.section(segment));
        let mut t_min = ray.t_min;
        for _ in 0..MAX_HITS {
            let Found { t, u, h } = seen.within(t_min, t_max).hit(&cubic, section, [part, self.level])?;
            let hit = ShapeHit { t, part: segment, u, v: 0.5 + 0.5 * h };
            if ray.contains(t) && accept(&hit) {
                return Some(hit);
            }
            t_min = (t + 1e-12 * t.abs()).next_up();
        }
        None
    }

    /// The surface point at a hit. That of flat curves is on the ray, with an error of half the radius: a ray that leaves
    /// starts outside the curve as it sees it.
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        let cubic = self.cubic(hit.part);
        let at = cubic.at(hit.u);
        let along = cubic.direction(hit.u);
        let p = ray.at(hit.t);
        let rounding = ROUNDING * (p.abs().max_element() + at.c.abs().max_element());
        if let CurveKind::Tube = self.kind {
            return Curves::on_tube(&at, along, p, hit.u, rounding);
        }
        let facing = -(ray.direction - along * ray.direction.dot(along));
        let facing = facing.try_normalize().unwrap_or_else(|| along.any_orthonormal_vector());
        let error = 0.5 * at.r + rounding;
        let n = match self.section(hit.part) {
            Section::Ribbon([a, b]) => {
                let n = a.lerp(b, hit.u);
                return match (n - along * n.dot(along)).try_normalize() {
                    Some(n) => SurfacePoint { p, error: 1e-6 * at.r + rounding, ng: n, ns: n },
                    None => SurfacePoint { p, error, ng: facing, ns: facing },
                };
            }
            Section::Flat | Section::Tube(_) => facing,
        };
        SurfacePoint { p, error, ng: n, ns: n }
    }

    fn on_tube(at: &At, along: DVec3, p: DVec3, u: f64, rounding: f64) -> SurfacePoint {
        let x = p - at.c;
        let error = 1e-6 * at.r + rounding;
        if u == 0.0 || u == 1.0 {
            let n = if u == 0.0 { -along } else { along };
            return SurfacePoint { p: p - along * x.dot(along), error, ng: n, ns: n };
        }
        let x = x - along * x.dot(along);
        let out = x.try_normalize().unwrap_or_else(|| along.any_orthonormal_vector());
        let n = normal_of(at, out * at.r).try_normalize().unwrap_or(out);
        SurfacePoint { p: at.c + out * at.r, error, ng: n, ns: n }
    }

    /// The curve of a segment: its first segment and their number.
    fn curve_of(&self, segment: u32) -> [u32; 2] {
        let curve = self.ends.partition_point(|end| *end <= segment);
        let first = if curve == 0 { 0 } else { self.ends[curve - 1] };
        [first, self.ends.get(curve).map_or(1, |end| end - first)]
    }

    /// u along the curve, v across it as the ray sees it.
    pub fn uv(&self, hit: &ShapeHit) -> DVec2 {
        let [first, count] = self.curve_of(hit.part);
        DVec2::new((f64::from(hit.part - first) + hit.u) / f64::from(count), hit.v)
    }

    /// Directional derivative of (u, v) along a vector at a surface point.
    pub(crate) fn uv_along(&self, hit: &ShapeHit, n: DVec3, d: DVec3) -> DVec2 {
        let at = self.cubic(hit.part).at(hit.u);
        let [_, count] = self.curve_of(hit.part);
        let along = at.d1 / at.d1.length_squared();
        let across = n.cross(at.d1) / (at.d1.length() * 2.0 * at.r);
        DVec2::new(d.dot(along) / f64::from(count), d.dot(across))
    }

    /// Direction along the curve at a hit, unit length.
    pub(crate) fn tangent(&self, hit: &ShapeHit) -> DVec3 {
        self.cubic(hit.part).direction(hit.u)
    }

    /// Radius at a hit.
    pub(crate) fn radius(&self, hit: &ShapeHit) -> f64 {
        self.cubic(hit.part).at(hit.u).r
    }

    /// The colour at a hit, linear RGB and opacity, if the curves have colours.
    pub fn color(&self, hit: &ShapeHit) -> Option<[f32; 4]> {
        let [a, b] = self.ends_of(hit.part).map(|i| self.data.colors.get(i).copied());
        let (a, b, u) = (a?, b?, hit.u as f32);
        Some([0, 1, 2, 3].map(|i| a[i] + (b[i] - a[i]) * u))
    }
}

/// The lanes of a set, the first lane lowest.
fn lanes(mut set: u8) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = (set != 0).then(|| set.trailing_zeros() as usize)?;
        set &= set - 1;
        Some(lane)
    })
}

impl Cubic {
    fn of(points: [(DVec3, f64); 4]) -> Cubic {
        Cubic { p: points.map(|p| p.0), r: points.map(|p| p.1.max(0.0)) }
    }
}

/// The entry of each segment, and the ends of the curves.
fn segments_of(
    data: &MeshData,
    basis: CurveBasis,
    options: &PrepareOptions,
) -> Result<(Vec<u32>, Vec<u32>), SceneError> {
    let of = |points: u32| basis.segments(points).unwrap_or(0);
    let count: u64 = data.curve_counts().map(|n| u64::from(of(n))).sum();
    let curves = data.curve_counts().count() as u64;
    options.limits.memory.need(4 * (count + curves), || format!("{count} segments of curves"))?;
    let (mut segments, mut ends) = (Vec::new(), Vec::new());
    let failed = |e: std::collections::TryReserveError| SceneError::new(ErrorCode::TooLarge, e.to_string());
    segments.try_reserve_exact(count as usize).map_err(failed)?;
    ends.try_reserve_exact(curves as usize).map_err(failed)?;
    let mut point = 0;
    for points in data.curve_counts() {
        let (count, step) = (of(points), if basis == CurveBasis::Bezier { 3 } else { 1 });
        for i in 0..count {
            let first = if i == 0 { FIRST } else { 0 };
            let last = if i + 1 == count { LAST } else { 0 };
            segments.push((point + i * step) | first | last);
        }
        ends.push(segments.len() as u32);
        point += points;
    }
    Ok((segments, ends))
}

/// 1/200 of the longest side of the bounding box.
fn default_width(positions: &[[f32; 3]]) -> f64 {
    let wide = |p: &[f32; 3]| DVec3::from(p.map(f64::from));
    let bounds = Bounds::of(positions.iter().map(wide).filter(|p| p.is_finite()));
    let side = if bounds.is_empty() { 0.0 } else { bounds.size().max_element() };
    if side > 0.0 { side / 200.0 } else { 1.0 }
}

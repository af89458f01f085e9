//! Two orthographic views of the scene, from the side and from above. The camera looks to the right in both.
//!
//! ```text
//! from the side          from above
//!     up ^                 ┌──> forward
//!        └──> forward      v right
//! ```

use turner::camera::{CameraDesc, Handedness};
use turner::math::DVec3;
use turner::scene::Outline;

use turner::explain::{Kind, RayNode, SampleTree};

/// Width of a view in pixels of the drawing.
pub(crate) const WIDTH: f64 = 560.0;
const TALLEST: f64 = 330.0;
const LEAST: f64 = 170.0;
const MARGIN: f64 = 28.0;

/// A point of a view, in pixels from its top left corner.
pub(crate) type Point = [f64; 2];

/// An orthographic view.
pub(crate) struct View {
    pub(crate) name: &'static str,
    pub(crate) height: f64,
    /// To the right and downwards in the drawing.
    x: DVec3,
    y: DVec3,
    scale: f64,
    /// The point at the centre.
    center: DVec3,
}

/// The projection of an outline.
pub(crate) enum Figure {
    Circle(Point, f64),
    Polygon(Vec<Point>),
    Line(Point, Point),
}

fn placement(camera: &CameraDesc) -> ([DVec3; 3], Handedness) {
    let mut camera = camera.clone();
    let handedness = match &camera {
        CameraDesc::Pinhole(c) => c.handedness,
        CameraDesc::Orthographic(c) => c.handedness,
        CameraDesc::ThinLens(c) => c.handedness,
        CameraDesc::Equirectangular(c) => c.handedness,
        CameraDesc::Fisheye(c) => c.handedness,
        CameraDesc::Realistic(c) => c.handedness,
    };
    (camera.placement_mut().map(|v| *v), handedness)
}

/// Forward, up and right of the camera, with forward perpendicular to up.
fn axes(view: &turner::view::View) -> [DVec3; 3] {
    let ([position, look_at, up], handedness) = placement(&view.camera_desc);
    let up = up.normalize_or(DVec3::Y);
    let flat = |v: DVec3| (v - v.dot(up) * up).try_normalize();
    let view_direction = (look_at - position).normalize_or(DVec3::NEG_Z);
    // For a camera that looks straight up or down any horizontal direction serves as forward.
    let level = flat(view_direction).filter(|_| view_direction.dot(up).abs() < 0.9999);
    let forward = level.or(flat(DVec3::NEG_Z)).or(flat(DVec3::X)).unwrap_or(DVec3::X);
    let right = match handedness {
        Handedness::Right => forward.cross(up),
        Handedness::Left => up.cross(forward),
    };
    [forward, up, right]
}

/// The bounding box of what is drawn, in the axes of the view.
struct Frame {
    low: DVec3,
    high: DVec3,
}

impl Frame {
    fn add(&mut self, p: DVec3) {
        if p.is_finite() {
            self.low = self.low.min(p);
            self.high = self.high.max(p);
        }
    }

    fn size(&self) -> f64 {
        (self.high - self.low).max_element().max(0.0)
    }

    fn distance(&self, p: DVec3) -> f64 {
        (self.low - p).max(p - self.high).max(DVec3::ZERO).length()
    }
}

/// A point farther away than this multiple of the size of everything nearer is outside the view, such as a hit on the
/// floor near the horizon.
const FAR: f64 = 6.0;

/// The two views of the samples' rays, scaled to contain the hits, objects that are not much larger, and near lights.
pub(crate) fn views(view: &turner::view::View, trees: &[SampleTree], outlines: &[Outline]) -> [View; 2] {
    let [forward, up, right] = axes(view);
    let local = |p: DVec3| DVec3::new(p.dot(forward), p.dot(up), p.dot(right));
    let mut frame = Frame { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };
    let rays = || trees.iter().flat_map(|t| &t.nodes).filter(|n| n.kind != Kind::Shadow && n.traced);
    let ends = |first: bool| {
        let of = move |n: &&RayNode| (n.kind == Kind::Camera) == first;
        rays().filter(of).filter_map(|n| n.to).map(local)
    };
    ends(true).for_each(|p| frame.add(p));
    let camera = rays().next().map(|n| local(n.from));
    // By distance from the first hits. Points not farther away than the camera are always near.
    let near = camera.map_or(0.0, |p| frame.distance(p));
    let mut others: Vec<DVec3> = ends(false).filter(|p| p.is_finite()).collect();
    others.sort_by(|a, b| frame.distance(*a).total_cmp(&frame.distance(*b)));
    for p in others {
        if frame.distance(p) < FAR * frame.size().max(near) {
            frame.add(p);
        }
    }
    if let Some(camera) = camera
        && (!frame.low.is_finite() || frame.size() == 0.0 || frame.distance(camera) < FAR * frame.size())
    {
        frame.add(camera);
    }
    if !frame.low.is_finite() {
        frame.add(DVec3::ZERO);
    }
    if frame.size() <= 0.0 {
        let (low, high) = (frame.low - 1.0, frame.high + 1.0);
        frame.add(low);
        frame.add(high);
    }
    let reach = frame.size();
    for outline in outlines {
        let points: Vec<DVec3> = match outline {
            Outline::Sphere { center, radius } => {
                let c = local(*center);
                vec![c - *radius, c + *radius]
            }
            Outline::Plane { .. } => Vec::new(),
            Outline::Points(points) => points.iter().map(|p| local(*p)).collect(),
        };
        let mut own = Frame { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };
        points.iter().for_each(|p| own.add(*p));
        if own.low.is_finite() && own.size() <= 2.5 * reach {
            frame.add(own.low);
            frame.add(own.high);
        }
    }
    let lights = trees.iter().flat_map(|t| &t.nodes).filter(|n| n.kind == Kind::Shadow);
    let reach = frame.size();
    for p in lights.filter_map(|n| n.to).map(local) {
        if frame.distance(p) <= 0.45 * reach {
            frame.add(p);
        }
    }
    let size = (frame.high - frame.low).max(DVec3::splat(1e-300));
    let tall = TALLEST - 2.0 * MARGIN;
    let scale = ((WIDTH - 2.0 * MARGIN) / size.x).min(tall / size.y).min(tall / size.z);
    let center = 0.5 * (frame.low + frame.high);
    let center = center.x * forward + center.y * up + center.z * right;
    let view = |name, y: DVec3, extent: f64| View {
        name,
        height: (extent * scale + 2.0 * MARGIN).clamp(LEAST, TALLEST),
        x: forward,
        y,
        scale,
        center,
    };
    [view("from the side", -up, size.y), view("from above", right, size.z)]
}

impl View {
    pub(crate) fn point(&self, p: DVec3) -> Point {
        let v = p - self.center;
        [0.5 * WIDTH + self.scale * v.dot(self.x), 0.5 * self.height + self.scale * v.dot(self.y)]
    }

    /// The projection of a direction: length 1 at most.
    pub(crate) fn direction(&self, d: DVec3) -> Point {
        [d.dot(self.x), d.dot(self.y)]
    }

    /// The part of a segment inside the view (Liang and Barsky 1984), with a margin of 4 pixels; `None` if there is
    /// none. Without `to` the segment is infinite.
    pub(crate) fn segment(&self, from: DVec3, direction: DVec3, to: Option<DVec3>) -> Option<(Point, Point)> {
        let a = self.point(from);
        let (d, end) = match to {
            Some(to) => {
                let b = self.point(to);
                ([b[0] - a[0], b[1] - a[1]], 1.0)
            }
            None => (self.direction(direction), f64::INFINITY),
        };
        self.clip(a, d, 0.0, end)
    }

    fn clip(&self, a: Point, d: Point, start: f64, end: f64) -> Option<(Point, Point)> {
        let (mut start, mut end) = (start, end);
        for (axis, most) in [WIDTH, self.height].into_iter().enumerate() {
            let (low, high) = (-4.0 - a[axis], most + 4.0 - a[axis]);
            if d[axis].abs() < 1e-12 {
                if low > 0.0 || high < 0.0 {
                    return None;
                }
                continue;
            }
            let (t0, t1) = (low / d[axis], high / d[axis]);
            start = start.max(t0.min(t1));
            end = end.min(t0.max(t1));
        }
        let at = |t: f64| [a[0] + t * d[0], a[1] + t * d[1]];
        // Also false for NaN.
        (start <= end && end.is_finite()).then(|| (at(start), at(end)))
    }

    /// The projection of an object; `None` if it has no edge in the view.
    pub(crate) fn figure(&self, outline: &Outline) -> Option<Figure> {
        match outline {
            Outline::Sphere { center, radius } => {
                let r = radius * self.scale;
                let [x, y] = self.point(*center);
                (r.is_finite() && r < 1e7 && x.abs() < 1e7 && y.abs() < 1e7)
                    .then_some(Figure::Circle([x, y], r))
            }
            Outline::Plane { point, normal } => {
                let [nx, ny] = self.direction(*normal);
                // A plane has an edge only where it is nearly perpendicular to the view.
                if nx * nx + ny * ny < 0.96 {
                    return None;
                }
                // The projection of the centre onto the plane.
                let foot = self.center - (self.center - *point).dot(*normal) * *normal;
                let (a, b) = self.clip(self.point(foot), [-ny, nx], f64::NEG_INFINITY, f64::INFINITY)?;
                Some(Figure::Line(a, b))
            }
            Outline::Points(points) => {
                let hull = hull(points.iter().map(|p| self.point(*p)));
                (hull.len() > 1).then_some(Figure::Polygon(hull))
            }
        }
    }
}

/// The convex hull (Andrew 1979, monotone chain), starting at the leftmost point.
fn hull(points: impl Iterator<Item = Point>) -> Vec<Point> {
    let mut points: Vec<Point> = points.filter(|p| p.iter().all(|v| v.abs() < 1e7)).collect();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup();
    if points.len() < 3 {
        return points;
    }
    let turns =
        |a: Point, b: Point, c: Point| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 1e-9;
    let half = |points: &mut dyn Iterator<Item = Point>| {
        let mut chain: Vec<Point> = Vec::new();
        for p in points {
            while let [.., a, b] = chain[..]
                && !turns(a, b, p)
            {
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut lower = half(&mut points.iter().copied());
    lower.extend(half(&mut points.iter().rev().copied()));
    lower
}

/// The primitives that the rays hit, in ascending order.
pub(crate) fn touched(trees: &[SampleTree]) -> Vec<u32> {
    let of = |n: &RayNode| n.primitive;
    let mut out: Vec<u32> = trees.iter().flat_map(|t| t.nodes.iter().filter_map(of)).collect();
    out.sort_unstable();
    out.dedup();
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hulls_are_convex_without_collinear_points() {
        let square = (0..5).flat_map(|x| (0..5).map(move |y| [f64::from(x), f64::from(y)]));
        assert_eq!(hull(square), [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]);
        assert_eq!(hull([[1.0, 2.0]; 7].into_iter()).len(), 1);
        assert!(hull([[f64::NAN, 0.0], [1e300, 0.0]].into_iter()).is_empty());
    }
}

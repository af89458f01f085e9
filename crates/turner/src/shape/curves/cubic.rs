//! A cubic segment of a curve, and its intersection with a ray.
//!
//! The segment is seen along the ray: the ray is the z axis of the frame, so a flat curve is hit where the axis is within its
//! width in the xy plane. A part of it is split in halves until it is nearly straight; halves whose box does not meet the axis
//! are left out (Nakamaru and Ohno 2002; Pharr, Jakob and Humphreys 2023, §6.7).
//!
//! ```text
//!            .-~-.            a tube: the disks around all c(u), perpendicular to the curve
//!     c(u) ·'  |  '·          ray · axis of a straight piece: a quadratic equation for a cone
//!    -----•----+----•---- z   then Newton's method for z and u:
//!              | r(u)            (p(z) − c(u)) · c'(u) = 0,   |p(z) − c(u)|² = r(u)²
//! ```

use crate::math::{Bounds, DVec3, Frame, Ray};

/// Most halvings of a segment.
const MAX_DEPTH: u32 = 8;
/// Largest distance of a piece from a straight line, in radii.
const STRAIGHT: f64 = 0.1;
/// Most steps of Newton's method.
const STEPS: usize = 8;
/// Relative size of a step after which no other follows: the error then is about its square.
const CONVERGED: f64 = 1e-6;
/// How far a piece continues beyond its ends, in u, so that neighbours leave no gap.
const OVERLAP: f64 = 1e-7;

/// A cubic Bézier segment: points and radii.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cubic {
    pub(super) p: [DVec3; 4],
    pub(super) r: [f64; 4],
}

/// Position, derivatives and radius at a parameter.
#[derive(Clone, Copy, Debug)]
pub(super) struct At {
    pub(super) c: DVec3,
    /// First and second derivative.
    pub(super) d1: DVec3,
    pub(super) d2: DVec3,
    pub(super) r: f64,
    /// Derivative of the radius.
    pub(super) dr: f64,
}

impl Cubic {
    pub(super) fn at(&self, u: f64) -> At {
        let [a, b, c, d] = self.p;
        let w = 1.0 - u;
        let [e, f, g] = [a * w + b * u, b * w + c * u, c * w + d * u];
        let [h, i] = [e * w + f * u, f * w + g * u];
        let [ra, rb, rc, rd] = self.r;
        let [re, rf, rg] = [ra * w + rb * u, rb * w + rc * u, rc * w + rd * u];
        let [rh, ri] = [re * w + rf * u, rf * w + rg * u];
        At {
            c: h * w + i * u,
            d1: 3.0 * (i - h),
            d2: 6.0 * ((c - 2.0 * b + a) * w + (d - 2.0 * c + b) * u),
            r: (rh * w + ri * u).max(0.0),
            dr: 3.0 * (ri - rh),
        }
    }

    /// The direction at a parameter; where the first derivative vanishes, that of the chord.
    pub(super) fn direction(&self, u: f64) -> DVec3 {
        let d = self.at(u).d1;
        let chord = self.p[3] - self.p[0];
        let other = || chord.try_normalize().unwrap_or(DVec3::Y);
        if d.length_squared() > 1e-20 * chord.length_squared() { d.normalize() } else { other() }
    }

    fn halves(&self) -> [Cubic; 2] {
        let [a, b, c, d] = self.p;
        let [e, f, g] = [0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + d)];
        let [h, i] = [0.5 * (e + f), 0.5 * (f + g)];
        let m = 0.5 * (h + i);
        let [ra, rb, rc, rd] = self.r;
        let [re, rf, rg] = [0.5 * (ra + rb), 0.5 * (rb + rc), 0.5 * (rc + rd)];
        let [rh, ri] = [0.5 * (re + rf), 0.5 * (rf + rg)];
        let rm = 0.5 * (rh + ri);
        [Cubic { p: [a, e, h, m], r: [ra, re, rh, rm] }, Cubic { p: [m, i, g, d], r: [rm, ri, rg, rd] }]
    }

    /// Part `i` of 2^`level` equal parts.
    pub(super) fn part(&self, i: u32, level: u32) -> Cubic {
        let mut out = *self;
        for bit in (0..level).rev() {
            let [first, second] = out.halves();
            out = if i >> bit & 1 == 0 { first } else { second };
        }
        out
    }

    fn widest(&self) -> f64 {
        self.r.iter().copied().fold(0.0, f64::max)
    }

    /// A box around the tube, and so around the flat curve.
    pub(super) fn bounds(&self) -> Bounds {
        let b = Bounds::of(self.p.iter().copied());
        let r = DVec3::splat(self.widest());
        Bounds::new(b.min - r, b.max + r)
    }

    /// Radius of a capsule around the tube: of all points within that distance of the chord.
    pub(super) fn capsule(&self) -> f64 {
        let [a, b, c, d] = self.p;
        let chord = d - a;
        let squared = chord.length_squared();
        let distance = |p: DVec3| {
            let s = if squared > 0.0 { ((p - a).dot(chord) / squared).clamp(0.0, 1.0) } else { 0.0 };
            (p - a - chord * s).length()
        };
        // The distance from the chord is convex: on the curve it is at most that of the control points.
        self.widest() + distance(b).max(distance(c))
    }

    /// Halvings after which each piece is straight within [`STRAIGHT`] (Wang's bound of the second differences).
    fn depth(&self) -> u32 {
        let [a, b, c, d] = self.p;
        let bend = (a - 2.0 * b + c).length_squared().max((b - 2.0 * c + d).length_squared()).sqrt();
        // A piece of 2^-n deviates by at most 6/8 · bend / 4^n.
        let mut left = 0.75 * bend;
        let most = STRAIGHT * self.widest();
        let mut depth = 0;
        while left > most && depth < MAX_DEPTH {
            left *= 0.25;
            depth += 1;
        }
        depth
    }
}

/// What is hit: u along the segment, and the offset across it, −1..=1 in radii.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pub(super) t: f64,
    pub(super) u: f64,
    pub(super) h: f64,
}

/// How a segment is hit.
#[derive(Clone, Copy, Debug)]
pub(super) enum Section {
    /// Whether its first and its last end are closed.
    Tube([bool; 2]),
    Flat,
    /// The normals at both ends.
    Ribbon([DVec3; 2]),
}

/// A ray as the z axis of a frame. Lengths are those of space.
#[derive(Clone, Copy, Debug)]
pub(super) struct SeenAlong {
    frame: Frame,
    origin: DVec3,
    /// Length of the ray's direction.
    speed: f64,
    near: f64,
    far: f64,
}

impl SeenAlong {
    /// `None` for a ray without direction.
    pub(super) fn new(ray: &Ray) -> Option<SeenAlong> {
        let speed = ray.direction.length();
        if !(speed > 0.0 && speed < f64::INFINITY && ray.is_finite()) {
            return None;
        }
        let frame = Frame::from_z(ray.direction / speed);
        Some(SeenAlong { frame, origin: ray.origin, speed, near: ray.t_min * speed, far: ray.t_max * speed })
    }

    /// The same ray within other ends, rounded outward: hits at the same t do not depend on the order of tests.
    pub(super) fn within(&self, t_min: f64, t_max: f64) -> SeenAlong {
        let (near, far) = (t_min * self.speed, t_max * self.speed);
        let round = |t: f64| if t.is_finite() { 1e-15 * t.abs() } else { 0.0 };
        SeenAlong { near: near - round(near), far: far + round(far), ..*self }
    }

    /// The nearest hit of part `part` of 2^`level` parts of a segment.
    pub(super) fn hit(&self, segment: &Cubic, section: Section, [part, level]: [u32; 2]) -> Option<Found> {
        let local = |p: DVec3| self.frame.to_local(p - self.origin);
        let whole = Cubic { p: segment.p.map(local), r: segment.r };
        let section = match section {
            Section::Ribbon(n) => Section::Ribbon(n.map(|n| self.frame.to_local(n))),
            other => other,
        };
        let size = 1.0 / f64::from(1_u32 << level);
        let from = f64::from(part) * size;
        let piece = whole.part(part, level);
        let mut search = Search { whole: &whole, section, near: self.near, far: self.far, found: None };
        search.walk(&piece, [from, from + size], piece.depth());
        if let Section::Tube(closed) = section {
            search.caps(closed, [part == 0, part + 1 == 1 << level]);
        }
        search.found.map(|f| Found { t: f.t / self.speed, ..f })
    }
}

/// The search for the nearest hit of one segment, in the frame of the ray; t is z.
struct Search<'a> {
    whole: &'a Cubic,
    section: Section,
    near: f64,
    far: f64,
    found: Option<Found>,
}

impl Search<'_> {
    fn walk(&mut self, piece: &Cubic, range: [f64; 2], depth: u32) {
        let b = piece.bounds();
        let meets = b.min.x <= 0.0 && b.max.x >= 0.0 && b.min.y <= 0.0 && b.max.y >= 0.0;
        if !(meets && b.max.z >= self.near && b.min.z <= self.far) {
            return;
        }
        if depth == 0 {
            match self.section {
                Section::Tube(_) => self.tube(piece, range),
                Section::Flat | Section::Ribbon(_) => self.flat(piece, range),
            }
            return;
        }
        let [from, to] = range;
        let middle = 0.5 * (from + to);
        let [first, second] = piece.halves();
        self.walk(&first, [from, middle], depth - 1);
        self.walk(&second, [middle, to], depth - 1);
    }

    fn offer(&mut self, found: Found) {
        if found.t >= self.near && found.t <= self.far {
            self.far = found.t;
            self.found = Some(found);
        }
    }

    /// A nearly straight piece of a curve that faces the ray, or of a ribbon.
    fn flat(&mut self, piece: &Cubic, [from, to]: [f64; 2]) {
        let [a, b, c, d] = piece.p.map(|p| p.truncate());
        // Beyond the lines across both ends it is another piece.
        if (b - a).dot(-a) < 0.0 || (c - d).dot(-d) < 0.0 {
            return;
        }
        let chord = d - a;
        let squared = chord.length_squared();
        let mut w = if squared > 0.0 { ((-a).dot(chord) / squared).clamp(0.0, 1.0) } else { 0.5 };
        let mut at = piece.at(w);
        for _ in 0..2 {
            // Newton's method for the nearest point of the curve.
            let (p, t) = (at.c.truncate(), at.d1.truncate());
            let dw = -p.dot(t) / (t.length_squared() + p.dot(at.d2.truncate()));
            let next = if dw.is_finite() { (w + dw).clamp(0.0, 1.0) } else { w };
            if next == w {
                break;
            }
            w = next;
            at = piece.at(w);
        }
        let u = from + (to - from) * w;
        let mut r = at.r;
        if let Section::Ribbon([first, second]) = self.section {
            let n = first * (1.0 - u) + second * u;
            let length = n.length();
            r *= if length > 0.0 { n.z.abs() / length } else { 1.0 };
        }
        let (p, t) = (at.c.truncate(), at.d1.truncate());
        let distance = p.length();
        if !(distance <= r && r > 0.0) {
            return;
        }
        let side = if p.y * t.x - p.x * t.y >= 0.0 { 1.0 } else { -1.0 };
        self.offer(Found { t: at.c.z, u, h: side * distance / r });
    }

    /// A nearly straight piece of a tube.
    fn tube(&mut self, piece: &Cubic, [from, to]: [f64; 2]) {
        let a = piece.p[0];
        let chord = piece.p[3] - a;
        let length = chord.length();
        if !(length > 0.0) {
            return;
        }
        let axis = chord / length;
        let k = (piece.r[3] - piece.r[0]) / length;
        // The ray is (0, 0, a.z + z); s is the place along the axis: z² + d² − s² = (r + k s)².
        let s0 = -a.x * axis.x - a.y * axis.y;
        let m = 1.0 + k * k;
        let q2 = 1.0 - m * axis.z * axis.z;
        let cone = |r: f64| {
            let q1 = -axis.z * (m * s0 + r * k);
            let q0 = a.x * a.x + a.y * a.y - m * s0 * s0 - 2.0 * r * k * s0 - r * r;
            (q1, q0, q1 * q1 - q2 * q0)
        };
        let (mut q1, mut q0, mut discriminant) = cone(piece.r[0]);
        if discriminant < 0.0 {
            // A bent piece may be as much wider than the cone as it deviates from a straight line.
            (q1, q0, discriminant) = cone(piece.r[0] + STRAIGHT * piece.widest());
        }
        if !(discriminant >= 0.0) {
            return;
        }
        let root = discriminant.sqrt();
        let q = if q1 >= 0.0 { -q1 - root } else { -q1 + root };
        let roots = [q / q2, if q == 0.0 { f64::NAN } else { q0 / q }];
        let nearer = if roots[1] < roots[0] { [roots[1], roots[0]] } else { roots };
        // Where two pieces bend away from one another, both reach a little into the gap.
        let beyond = 0.05 * length + 0.5 * piece.widest();
        for z in nearer {
            let s = s0 + axis.z * z;
            if !(s >= -beyond && s <= length + beyond) {
                continue;
            }
            let u = from + (to - from) * (s / length).clamp(0.0, 1.0);
            if let Some(found) = self.refine(a.z + z, u, [from, to]) {
                // The ray enters here; it leaves at the other root.
                self.offer(found);
                return;
            }
        }
    }

    /// The hit of the true tube near an approximate one, if the ray enters the tube there and u is in the range of the
    /// piece. Other hits are those of other pieces, which are tested or not: what is found must not depend on that.
    fn refine(&self, z: f64, u: f64, [from, to]: [f64; 2]) -> Option<Found> {
        let reach = 2.0 * (to - from);
        let (mut z, mut u, start) = (z, u, u);
        // u first: z is exact where the piece is straight.
        let mut at = self.whole.at(u);
        let x = DVec3::new(0.0, 0.0, z) - at.c;
        let du = x.dot(at.d1) / (at.d1.length_squared() - x.dot(at.d2));
        if du.is_finite() && du.abs() > CONVERGED * reach {
            u = (u + du).clamp(start - reach, start + reach);
            at = self.whole.at(u);
        }
        for _ in 0..STEPS {
            let x = DVec3::new(0.0, 0.0, z) - at.c;
            let (f, g) = (x.dot(at.d1), x.length_squared() - at.r * at.r);
            let (fz, fu) = (at.d1.z, x.dot(at.d2) - at.d1.length_squared());
            let (gz, gu) = (2.0 * x.z, -2.0 * x.dot(at.d1) - 2.0 * at.r * at.dr);
            let determinant = fz * gu - fu * gz;
            let (dz, du) = ((g * fu - f * gu) / determinant, (f * gz - g * fz) / determinant);
            if !(dz.is_finite() && du.is_finite()) {
                return None;
            }
            z += dz;
            u = (u + du).clamp(start - reach, start + reach);
            at = self.whole.at(u);
            if dz.abs() <= CONVERGED * at.r && du.abs() <= CONVERGED * reach {
                break;
            }
        }
        let x = DVec3::new(0.0, 0.0, z) - at.c;
        let is_there = (x.length() - at.r).abs() <= 1e-3 * at.r && u >= from - OVERLAP && u <= to + OVERLAP;
        if !is_there || normal_of(&at, x).z >= 0.0 {
            return None;
        }
        // 0 and 1 are the caps.
        Some(Found { t: z, u: u.clamp(1e-9, 1.0 - 1e-9), h: across(x, at.d1, at.r) })
    }

    /// The disks that close both ends of a curve.
    fn caps(&mut self, closed: [bool; 2], at_end: [bool; 2]) {
        for (i, u) in [0.0, 1.0].into_iter().enumerate() {
            if !(closed[i] && at_end[i]) {
                continue;
            }
            let at = self.whole.at(u);
            let direction = self.whole.direction(u);
            let outward = if i == 0 { -direction } else { direction };
            if outward.z >= 0.0 {
                continue;
            }
            let z = at.c.dot(direction) / direction.z;
            let x = DVec3::new(0.0, 0.0, z) - at.c;
            if x.length_squared() <= at.r * at.r && at.r > 0.0 {
                self.offer(Found { t: z, u, h: across(x, direction, at.r) });
            }
        }
    }
}

/// The offset across a curve of direction `d` as the ray along +z sees it, in radii: −1..=1.
fn across(x: DVec3, d: DVec3, r: f64) -> f64 {
    let length = d.truncate().length();
    let h = if length > 0.0 { (x.x * d.y - x.y * d.x) / (length * r) } else { 0.0 };
    if h.is_finite() { h.clamp(-1.0, 1.0) } else { 0.0 }
}

/// Outward normal, not normalized, of a tube at the offset `x` from the curve.
pub(super) fn normal_of(at: &At, x: DVec3) -> DVec3 {
    let squared = at.d1.length_squared();
    let speed = squared.sqrt();
    if !(speed > 0.0 && at.r > 0.0) {
        return x;
    }
    // The inner side of a bend is shorter than the curve.
    let stretch = ((squared - x.dot(at.d2)) / speed).max(1e-3 * speed);
    x / at.r * stretch - at.d1 * (at.dr / speed)
}

//! Framing: where a camera stands so that what it shows fills the picture.
//!
//! The viewing direction is given; the camera moves sideways, up and back until the silhouette is in the middle and its
//! longer extent fills [`FILL`] of the shorter side of the picture:
//!
//! ```text
//!   ┌──────────────────────┐
//!   │      ┌────────┐      │  ↑
//!   │      │ object │      │  │ shorter side
//!   │      └────────┘      │  ↓
//!   └──────────────────────┘
//! ```
//!
//! With the tangent t of half the angle that the silhouette may have, a point (x, y, z) in the camera's axes (z towards
//! the camera) touches the right edge of that angle from a camera at (c, …, d) if x − c = t (d − z). So the largest x + t z
//! and the largest −x + t z give c and d at once. Across, where the silhouette is smaller, bisection finds the middle.

use crate::camera::{CameraDesc, DEFAULT_FOV, PinholeDesc, ThinLensDesc};
use crate::description::default_studio::{FOV, Orbit, StudioDesc};
use crate::math::elementary::{atan2, cos, sin, sin_cos, tan};
use crate::math::{Bounds, DVec3, radians};

/// The part of the shorter side of the picture that the longer extent of a framed silhouette fills.
pub const FILL: f64 = 0.76;

/// The most points that are kept of a subject.
const MOST_POINTS: usize = 50_000;

/// Directions in which the farthest point is kept in any case: faces and corners of a cube.
const FACES_AND_CORNERS: [DVec3; 14] = {
    const fn v(x: i32, y: i32, z: i32) -> DVec3 {
        DVec3::new(x as f64, y as f64, z as f64)
    }
    [
        v(1, 0, 0),
        v(-1, 0, 0),
        v(0, 1, 0),
        v(0, -1, 0),
        v(0, 0, 1),
        v(0, 0, -1),
        v(1, 1, 1),
        v(1, 1, -1),
        v(1, -1, 1),
        v(1, -1, -1),
        v(-1, 1, 1),
        v(-1, 1, -1),
        v(-1, -1, 1),
        v(-1, -1, -1),
    ]
};

/// What a camera is to show: points with the convex hull of the objects.
#[derive(Clone, Debug, PartialEq)]
pub struct Subject {
    points: Vec<DVec3>,
    center: DVec3,
    radius: f64,
}

/// A viewing direction and its axes; `back` points towards the camera.
#[derive(Clone, Copy, Debug)]
struct Axes {
    right: DVec3,
    up: DVec3,
    back: DVec3,
}

/// The viewing direction and lens of a framed camera.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Shot {
    /// Degrees to the right of +z.
    azimuth: f64,
    /// Degrees above the horizon.
    elevation: f64,
    /// Distance from the centre, in radii of the bounding sphere. `None` chooses the distance by the silhouette.
    distance: Option<f64>,
    /// Field of view of the shorter side of the picture, degrees.
    fov: f64,
    /// Enlargement: 2 shows everything twice as large.
    zoom: f64,
}

impl Subject {
    /// From points and the bounds of the objects. Points outside the bounds are ignored; without points the corners of
    /// the bounds count.
    pub fn new(points: impl IntoIterator<Item = DVec3>, bounds: &Bounds) -> Subject {
        if bounds.is_empty() || !bounds.is_finite() {
            return Subject { points: Vec::new(), center: DVec3::ZERO, radius: 1.0 };
        }
        let center = bounds.center();
        let radius = 0.5 * bounds.size().length();
        // A bounding box of size 0 gets a small radius.
        let radius = if radius > 0.0 { radius } else { 1e-3 * (1.0 + center.abs().max_element()) };
        let slack = 1e-6 * radius;
        let is_inside =
            |p: &DVec3| p.is_finite() && (p.cmpge(bounds.min - slack) & p.cmple(bounds.max + slack)).all();
        let mut points: Vec<DVec3> = points.into_iter().filter(is_inside).map(|p| p - center).collect();
        if points.len() < 2 {
            points = bounds.corners().into_iter().map(|p| p - center).collect();
        }
        if points.len() > MOST_POINTS {
            let step = points.len() / MOST_POINTS + 1;
            let farthest = FACES_AND_CORNERS.map(|direction| {
                let along = |p: &&DVec3| direction.dot(**p);
                points.iter().max_by(|a, b| along(a).total_cmp(&along(b))).copied()
            });
            points = points.into_iter().step_by(step).chain(farthest.into_iter().flatten()).collect();
        }
        Subject { points, center, radius }
    }

    /// What the subject sweeps over in a full turn about the vertical axis through its centre.
    pub fn turned(&self) -> Subject {
        const DIRECTIONS: u32 = 64;
        const AZIMUTHS: u32 = 72;
        let profile = |p: &DVec3| (p.x * p.x + p.z * p.z).sqrt();
        let mut points = Vec::new();
        for i in 0..DIRECTIONS {
            let (s, c) = sin_cos(std::f64::consts::PI * ((f64::from(i) + 0.5) / f64::from(DIRECTIONS) - 0.5));
            let reach = |p: &&DVec3| c * profile(p) + s * p.y;
            let Some(farthest) = self.points.iter().max_by(|a, b| reach(a).total_cmp(&reach(b))) else {
                break;
            };
            let radius = profile(farthest);
            points.extend((0..AZIMUTHS).map(|k| {
                let (s, c) = sin_cos(std::f64::consts::TAU * f64::from(k) / f64::from(AZIMUTHS));
                DVec3::new(radius * s, farthest.y, radius * c)
            }));
        }
        Subject { points, ..*self }
    }

    /// The camera that shows the subject. `aspect` is width over height.
    fn camera(&self, shot: &Shot, aspect: f64) -> CameraDesc {
        let axes = shot.axes();
        let half = tan(radians(0.5 * shot.fov));
        let target = FILL * half;
        let (across, distance) = match shot.distance {
            Some(radii) => {
                let distance = radii * self.radius;
                (axes.pair().map(|axis| self.middle(axis, &axes, distance)), distance)
            }
            None => self.fit(&axes, target),
        };
        let aim = self.center + across[0] * axes.right + across[1] * axes.up;
        // `fov` is vertical.
        let half = half / shot.zoom / aspect.min(1.0);
        // Short numbers, for people who read them in a converted scene.
        let decimals = rounding(self.radius);
        let short = |p: DVec3| DVec3::from(p.to_array().map(|v| rounded(v, decimals)));
        CameraDesc::Pinhole(PinholeDesc {
            position: short(aim + distance * axes.back),
            look_at: short(aim),
            up: axes.upright(shot),
            fov: Some(rounded(degrees(half), 4)),
            ..PinholeDesc::default()
        })
    }

    /// Where the camera stands: right and up of the centre, and its distance along the viewing direction.
    fn fit(&self, axes: &Axes, tangent: f64) -> ([f64; 2], f64) {
        if self.points.is_empty() {
            return ([0.0; 2], 3.0 * self.radius);
        }
        let largest =
            |value: &dyn Fn(&DVec3) -> f64| self.points.iter().map(value).fold(f64::NEG_INFINITY, f64::max);
        let nearest = largest(&|p| p.dot(axes.back));
        let mut distance = nearest + 1e-3 * self.radius;
        for axis in axes.pair() {
            let right = largest(&|p| p.dot(axis) + tangent * p.dot(axes.back));
            let left = largest(&|p| -p.dot(axis) + tangent * p.dot(axes.back));
            distance = distance.max(0.5 * (right + left) / tangent);
        }
        (axes.pair().map(|axis| self.middle(axis, axes, distance)), distance)
    }

    /// The camera's position along an axis from which the silhouette reaches equally far to both sides.
    fn middle(&self, axis: DVec3, axes: &Axes, distance: f64) -> f64 {
        let seen: Vec<[f64; 2]> = self
            .points
            .iter()
            .map(|p| [p.dot(axis), distance - p.dot(axes.back)])
            .filter(|[_, depth]| *depth > 1e-3 * self.radius)
            .collect();
        if seen.is_empty() {
            return 0.0;
        }
        let (mut low, mut high) = (-self.radius, self.radius);
        for _ in 0..40 {
            let at = 0.5 * (low + high);
            let (least, most) = seen.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), [x, depth]| {
                let tangent = (x - at) / depth;
                (a.min(tangent), b.max(tangent))
            });
            (low, high) = if least + most > 0.0 { (at, high) } else { (low, at) };
        }
        0.5 * (low + high)
    }
}

/// Decimals that round to less than a ten-thousandth of a length.
fn rounding(length: f64) -> usize {
    let (mut decimals, mut step) = (0, 1.0);
    while step > 1e-4 * length && decimals < 15 {
        decimals += 1;
        step *= 0.1;
    }
    decimals
}

/// The nearest number with so many decimals; the same if there is none.
fn rounded(v: f64, decimals: usize) -> f64 {
    // Positive zero.
    format!("{v:.decimals$}").parse().map_or(v, |v: f64| v + 0.0)
}

/// The f-number where only the focus is given.
pub const F_STOP: f64 = 2.8;

/// Height of the sensor and radius of the object that f-numbers are meant for, in metres.
const SENSOR: f64 = 0.024;
const OBJECT: f64 = 0.15;

impl StudioDesc {
    /// The camera of an orbit with the settings of the studio. It keeps the lens of the scene's `own` camera; `aspect` is
    /// width over height.
    pub fn framed(
        &self,
        orbit: &Orbit,
        subject: &Subject,
        own: Option<&CameraDesc>,
        aspect: f64,
    ) -> CameraDesc {
        let vertical = match own {
            Some(CameraDesc::Pinhole(own)) => own.fov,
            Some(CameraDesc::ThinLens(own)) => own.fov,
            _ => None,
        };
        let of_own = vertical.map(|fov| degrees(tan(radians(0.5 * fov)) * aspect.min(1.0)));
        let Orbit { azimuth, elevation, distance } = *orbit;
        let fov = self.fov.or(of_own).unwrap_or(FOV);
        let shot = Shot { azimuth, elevation, distance, fov, zoom: self.zoom };
        let framed = subject.camera(&shot, aspect);
        let CameraDesc::Pinhole(PinholeDesc { position, look_at, up, fov, .. }) = framed else {
            return framed;
        };
        // `far` belongs to the distance of the scene's own camera.
        let camera = match own {
            Some(CameraDesc::ThinLens(own)) => CameraDesc::ThinLens(ThinLensDesc {
                position,
                look_at,
                up,
                fov,
                viewport: None,
                far: None,
                ..own.clone()
            }),
            Some(CameraDesc::Pinhole(own)) => CameraDesc::Pinhole(PinholeDesc {
                position,
                look_at,
                up,
                fov,
                viewport: None,
                far: None,
                ..own.clone()
            }),
            _ => framed,
        };
        self.with_lens(camera, subject.radius)
    }

    /// A camera of the scene or model with `fov`, `zoom`, `f_stop` and `focus` of the studio. `radius` is that of the
    /// bounding sphere.
    pub fn refined(&self, mut camera: CameraDesc, radius: f64, aspect: f64) -> CameraDesc {
        use CameraDesc::{Equirectangular, Fisheye, Orthographic, Pinhole, Realistic, ThinLens};
        let lens = match &mut camera {
            Pinhole(c) => Some((&mut c.fov, &mut c.viewport)),
            ThinLens(c) => Some((&mut c.fov, &mut c.viewport)),
            Orthographic(_) | Equirectangular(_) | Fisheye(_) | Realistic(_) => None,
        };
        if let Some((fov, viewport)) = lens
            && (self.fov.is_some() || self.zoom != 1.0 && viewport.is_none())
        {
            let wanted = self.fov.map(|fov| tan(radians(0.5 * fov)) / aspect.min(1.0));
            let half = wanted.unwrap_or_else(|| tan(radians(0.5 * fov.unwrap_or(DEFAULT_FOV))));
            (*fov, *viewport) = (Some(degrees(half / self.zoom)), None);
        }
        self.with_lens(camera, radius)
    }

    /// A pinhole camera with the lens of `f_stop` and `focus`; any other camera unchanged.
    fn with_lens(&self, camera: CameraDesc, radius: f64) -> CameraDesc {
        let CameraDesc::Pinhole(c) = &camera else { return camera };
        if self.f_stop.is_none() && self.focus.is_none() {
            return camera;
        }
        let focal_length = 0.5 * SENSOR / tan(radians(0.5 * c.fov.unwrap_or(DEFAULT_FOV)));
        let aperture = focal_length / self.f_stop.unwrap_or(F_STOP) * radius / OBJECT;
        let lens_radius = rounded(0.5 * aperture, rounding(radius) + 2);
        CameraDesc::ThinLens(c.with_lens(lens_radius, self.focus))
    }
}

/// The angle of twice this half extent at distance 1.
fn degrees(half: f64) -> f64 {
    2.0 * atan2(half, 1.0).to_degrees()
}

impl Shot {
    fn axes(&self) -> Axes {
        let (azimuth, elevation) = (radians(self.azimuth), radians(self.elevation));
        let back = DVec3::new(sin(azimuth) * cos(elevation), sin(elevation), cos(azimuth) * cos(elevation));
        // If the camera looks straight up or down, the front is at the lower edge of the picture.
        let up = match cos(elevation) {
            c if c > 1e-6 => DVec3::Y,
            c if c < -1e-6 => DVec3::NEG_Y,
            _ => -sin(elevation).signum() * DVec3::new(sin(azimuth), 0.0, cos(azimuth)),
        };
        let right = up.cross(back).try_normalize().unwrap_or(DVec3::X);
        Axes { right, up: back.cross(right), back }
    }
}

impl Axes {
    fn pair(&self) -> [DVec3; 2] {
        [self.right, self.up]
    }

    /// The up direction of the camera: an axis of the world where possible.
    fn upright(&self, shot: &Shot) -> DVec3 {
        match cos(radians(shot.elevation)) {
            c if c > 1e-6 => DVec3::Y,
            c if c < -1e-6 => DVec3::NEG_Y,
            _ => self.up,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::math::DVec2;

    /// Left, right, lower and upper end of the silhouette on the screen of -1..1.
    fn seen(desc: &CameraDesc, points: &[DVec3], aspect: f64) -> [f64; 4] {
        let camera = desc.prepare(aspect).unwrap();
        let Camera::Pinhole(_) = &camera else { panic!("a framed camera is a pinhole camera") };
        let at = camera.ray(DVec2::ZERO, DVec2::ZERO);
        let ray = |x, y| camera.ray(DVec2::new(x, y), DVec2::ZERO).direction;
        let forward = ray(0.0, 0.0).normalize();
        let scale = 1.0 / ray(0.0, 0.0).length();
        let (right, up) =
            (0.5 * scale * (ray(1.0, 0.0) - ray(-1.0, 0.0)), 0.5 * scale * (ray(0.0, 1.0) - ray(0.0, -1.0)));
        points.iter().fold(
            [f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY],
            |[l, r, b, t], p| {
                let p = *p - at.origin;
                let depth = p.dot(forward);
                assert!(depth > 0.0, "a point is behind the camera");
                let (x, y) =
                    (p.dot(right) / right.length_squared() / depth, p.dot(up) / up.length_squared() / depth);
                [l.min(x), r.max(x), b.min(y), t.max(y)]
            },
        )
    }

    /// Two blobs of points: most of the box is empty, as with a bent figure.
    fn figure() -> Vec<DVec3> {
        let mut points = Vec::new();
        for i in 0..400 {
            let (s, c) = sin_cos(f64::from(i));
            let t = f64::from(i) / 400.0;
            points.push(DVec3::new(s * (1.0 - t), 3.0 * t, 0.4 * c));
            points.push(DVec3::new(4.0 + 0.3 * c, 0.2 * s, -2.0 + t));
        }
        points
    }

    #[test]
    fn the_silhouette_fills_the_picture_from_everywhere() {
        let points = figure();
        let bounds = points.iter().fold(Bounds::EMPTY, |b, p| b.union(&Bounds::new(*p, *p)));
        let subject = Subject::new(points.clone(), &bounds);
        for (azimuth, elevation) in [(35.0, 22.0), (0.0, 90.0), (200.0, -90.0), (90.0, 0.0), (300.0, -60.0)] {
            for aspect in [0.3, 1.0, 1.5, 2.5] {
                for fov in [8.0, FOV, 80.0] {
                    let shot = Shot { azimuth, elevation, distance: None, fov, zoom: 1.0 };
                    let [l, r, b, t] = seen(&subject.camera(&shot, aspect), &points, aspect);
                    // Extents in halves of the shorter side.
                    let (width, height) = (0.5 * (r - l) * aspect.max(1.0), 0.5 * (t - b) / aspect.min(1.0));
                    let longer = width.max(height);
                    assert!((longer - FILL).abs() < 0.02, "{azimuth} {elevation} {aspect} {fov}: {longer}");
                    assert!(
                        (l + r).abs() < 1e-3 && (b + t).abs() < 1e-3,
                        "{azimuth} {elevation}: {l} {r} {b} {t}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_turned_subject_fits_at_every_angle() {
        let points = figure();
        let bounds = points.iter().fold(Bounds::EMPTY, |b, p| b.union(&Bounds::new(*p, *p)));
        let subject = Subject::new(points.clone(), &bounds).turned();
        let mut most = 0.0_f64;
        let mut places: Vec<(DVec3, DVec3)> = Vec::new();
        for degrees in 0..36 {
            let shot = Shot {
                azimuth: 10.0 * f64::from(degrees),
                elevation: 22.0,
                distance: None,
                fov: FOV,
                zoom: 1.0,
            };
            let mut camera = subject.camera(&shot, 1.0);
            let [l, r, b, t] = seen(&camera, &points, 1.0);
            most = [-l, r, -b, t].into_iter().fold(most, f64::max);
            let [position, look_at, _] = camera.placement_mut();
            places.push((*position, *look_at));
        }
        assert!((FILL - 0.03..FILL + 0.01).contains(&most), "{most}");
        let distance = |(position, look_at): &(DVec3, DVec3)| (*position - *look_at).length();
        for place in &places {
            assert!((distance(place) - distance(&places[0])).abs() < 3e-4 * distance(&places[0]));
            assert!((place.1.y - places[0].1.y).abs() < 1e-3, "{} {}", place.1, places[0].1);
        }
    }

    #[test]
    fn any_bounds_give_a_camera() {
        let boxes = [
            Bounds::EMPTY,
            Bounds::new(DVec3::new(1e6, 0.0, 0.0), DVec3::new(1e6 + 1.0, 0.0, 100.0)),
            Bounds::new(DVec3::splat(-1e-6), DVec3::splat(1e-6)),
            Bounds::new(DVec3::ONE, DVec3::ONE),
        ];
        for bounds in boxes {
            for elevation in [90.0, 0.0, -90.0, 135.0] {
                for distance in [None, Some(3.0)] {
                    let shot = Shot { azimuth: 10.0, elevation, distance, fov: FOV, zoom: 2.0 };
                    let desc = Subject::new([], &bounds).camera(&shot, 1.5);
                    assert!(desc.prepare(1.5).is_ok(), "{bounds:?} {elevation} {distance:?}");
                }
            }
        }
    }

    #[test]
    fn the_lens_of_the_scene_and_of_the_studio_keep_the_framing() {
        let points = figure();
        let bounds = points.iter().fold(Bounds::EMPTY, |b, p| b.union(&Bounds::new(*p, *p)));
        let subject = Subject::new(points.clone(), &bounds);
        let framed = |studio: &StudioDesc, own: Option<&CameraDesc>| {
            studio.framed(&Orbit::DEFAULT, &subject, own, 1.5)
        };
        let own = CameraDesc::Pinhole(PinholeDesc {
            fov: Some(12.0),
            near: 0.01,
            far: Some(0.1),
            ..PinholeDesc::default()
        });
        let studio = StudioDesc::default();
        let CameraDesc::Pinhole(kept) = framed(&studio, Some(&own)) else { panic!("a pinhole camera") };
        assert_eq!((kept.fov, kept.near, kept.far), (Some(12.0), 0.01, None));
        let width = |camera: &CameraDesc| {
            let [l, r, b, t] = seen(camera, &points, 1.5);
            (1.5 * (r - l)).max(t - b) / 2.0
        };
        assert!((width(&CameraDesc::Pinhole(kept)) - FILL).abs() < 0.02);
        let zoomed = framed(&StudioDesc { zoom: 2.0, ..studio.clone() }, None);
        assert!((width(&zoomed) - 2.0 * FILL).abs() < 0.04);
        let CameraDesc::ThinLens(lens) = framed(&StudioDesc { f_stop: Some(4.0), ..studio.clone() }, None)
        else {
            panic!("an f-number needs a lens")
        };
        // 24 mm / 2 tan 14° = 48.1 mm; half of a fourth of it, for an object of radius 150 mm.
        let expected = 0.5 * 0.048_13 / 4.0 * subject.radius / 0.15;
        assert!((lens.lens_radius / expected - 1.0).abs() < 2e-3, "{} {expected}", lens.lens_radius);
        let CameraDesc::ThinLens(lens) = framed(&StudioDesc { focus: Some(3.0), ..studio.clone() }, None)
        else {
            panic!("a focus needs a lens")
        };
        assert_eq!(lens.focus_distance, Some(3.0));
        let wide = StudioDesc { fov: Some(50.0), zoom: 2.0, ..studio };
        let CameraDesc::Pinhole(refined) = wide.refined(own.clone(), 1.0, 1.5) else {
            panic!("a pinhole camera")
        };
        assert!((tan(radians(0.5 * refined.fov.unwrap())) - 0.5 * tan(radians(25.0))).abs() < 1e-9);
        assert_eq!(
            wide.refined(own, 1.0, 1.5).placement_mut().map(|v| *v),
            [DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, DVec3::Y]
        );
    }
}

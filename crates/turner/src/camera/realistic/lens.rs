//! The surfaces of a lens: paraxial optics, focus, and rays through them by Snell's law.
//!
//! Coordinates are millimetres: z from the film towards the scene, (x, y) to the right and upwards as the camera sees
//! it. A positive radius means that the centre of curvature lies on the side of the film, as in pbrt's lens files.
//!
//! ```text
//!   film      rear surface                      front surface
//!    |            (   |  (  )  |stop|  ( )           )
//!    |------------+---------------------------------+----> z, scene
//!    0            rear                             rear + length
//! ```

use crate::math::{DVec2, DVec3};
use crate::schema::{ErrorCode, SceneError};

/// Most surfaces of a lens.
const MOST_SURFACES: usize = 64;

/// Largest length in a lens, in millimetres.
const LARGEST: f64 = 1e7;

/// A surface of the lens.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Surface {
    /// Where it crosses the axis; in front of the rear surface until the lens is focussed, then in front of the film.
    z: f64,
    /// Signed radius of curvature; 0 for a plane.
    radius: f64,
    /// 1 / radius; 0 for a plane.
    curvature: f64,
    /// Refractive indices on the side of the film and on that of the scene.
    eta: [f64; 2],
    /// The first over the second.
    ratio: f64,
    /// Half its diameter.
    aperture: f64,
}

impl Surface {
    /// The aperture stop: a plane in one medium.
    fn is_stop(&self) -> bool {
        self.radius == 0.0 && self.eta[0] == self.eta[1]
    }
}

/// A lens: its surfaces from the film to the scene.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Lens {
    surfaces: Vec<Surface>,
    /// Focal length.
    pub(super) focal_length: f64,
    /// Distances of the principal planes: that of the film side from the rear surface, that of the scene side from the
    /// front surface, both towards the scene.
    principal: [f64; 2],
}

/// Height and slope of a paraxial ray as linear functions of those at z = 0.
#[derive(Clone, Copy)]
struct Paraxial {
    height: [f64; 2],
    slope: [f64; 2],
}

impl Paraxial {
    const START: Paraxial = Paraxial { height: [1.0, 0.0], slope: [0.0, 1.0] };

    /// After a way along the axis.
    fn moved(self, by: f64) -> Paraxial {
        let height = [0, 1].map(|i| self.height[i] + by * self.slope[i]);
        Paraxial { height, ..self }
    }

    /// Behind a surface.
    fn refracted(self, s: &Surface) -> Paraxial {
        let power = (s.eta[1] - s.eta[0]) * s.curvature;
        let slope = [0, 1].map(|i| (s.eta[0] * self.slope[i] + power * self.height[i]) / s.eta[1]);
        Paraxial { slope, ..self }
    }
}

fn error(code: ErrorCode, message: String) -> SceneError {
    SceneError::new(code, message)
}

impl Lens {
    /// From rows [radius, thickness, eta, diameter], front first, and the diameter to which the stop is closed.
    pub(super) fn new(elements: &[[f64; 4]], stop: Option<f64>) -> Result<Lens, SceneError> {
        let range = |message: String| Err(error(ErrorCode::OutOfRange, message));
        if elements.is_empty() || elements.len() > MOST_SURFACES {
            let count = elements.len();
            return range(format!("the lens has {count} `elements`: expected 1 to {MOST_SURFACES}"));
        }
        let medium = |eta: f64| if eta == 0.0 { 1.0 } else { eta };
        let mut surfaces = Vec::with_capacity(elements.len());
        let (mut z, mut has_stop) = (0.0, false);
        for (i, &[radius, thickness, eta, diameter]) in elements.iter().enumerate().rev() {
            let row = i + 1;
            if !(radius.abs() <= LARGEST && (0.0..=LARGEST).contains(&thickness)) {
                return range(format!(
                    "row {row} of `elements` of the lens: radius {radius} and thickness {thickness} are not lengths in millimetres"
                ));
            }
            if !(eta == 0.0 || (1.0..=10.0).contains(&eta)) {
                return range(format!(
                    "row {row} of `elements` of the lens: the refractive index is {eta}: expected 1 to 10, or 0 for air"
                ));
            }
            if !(diameter > 0.0 && diameter <= LARGEST) {
                return range(format!("row {row} of `elements` of the lens: the diameter is {diameter}"));
            }
            // The thickness of the last row is that of the space before the film, which follows from the focus.
            z += if i + 1 < elements.len() { thickness } else { 0.0 };
            let front = if i > 0 { medium(elements[i - 1][2]) } else { 1.0 };
            let eta = [medium(eta), front];
            let curvature = if radius == 0.0 { 0.0 } else { 1.0 / radius };
            let (ratio, aperture) = (eta[0] / eta[1], 0.5 * diameter);
            let mut surface = Surface { z, radius, curvature, eta, ratio, aperture };
            if surface.is_stop() {
                has_stop = true;
                surface.aperture = surface.aperture.min(0.5 * stop.unwrap_or(f64::INFINITY));
            }
            surfaces.push(surface);
        }
        if surfaces[0].eta[0] != 1.0 {
            return range(
                "the last of the `elements` of the lens must have eta = 1: air is before the film".into(),
            );
        }
        if stop.is_some() && !has_stop {
            let message =
                "`aperture_diameter` has no effect: no row of `elements` is an aperture stop".to_owned();
            return Err(error(ErrorCode::Conflict, message)
                .help("a row with radius 0 between rows of air is the stop"));
        }
        let mut lens = Lens { surfaces, focal_length: 0.0, principal: [0.0; 2] };
        let [[a, _], [c, d]] = {
            let whole = lens.paraxial(lens.surfaces.len());
            [whole.height, whole.slope]
        };
        lens.focal_length = -1.0 / c;
        lens.principal = [(d - 1.0) / c, (1.0 - a) / c];
        if !(lens.focal_length > 0.0 && lens.focal_length <= LARGEST) {
            let message =
                "the lens of the camera does not collect parallel light: it makes no picture".to_owned();
            return Err(error(ErrorCode::Camera, message)
                .help("check the signs of the radii in `elements`: those of a front that bulges towards the scene are positive"));
        }
        Ok(lens)
    }

    /// The paraxial ray behind the first `count` surfaces, counted from the film.
    fn paraxial(&self, count: usize) -> Paraxial {
        let mut ray = Paraxial::START;
        let mut z = 0.0;
        for s in &self.surfaces[..count] {
            ray = ray.moved(s.z - z).refracted(s);
            z = s.z;
        }
        ray
    }

    /// From the film to the rear surface.
    #[cfg(test)]
    pub(super) fn rear(&self) -> f64 {
        self.surfaces[0].z
    }

    /// From the rear to the front surface.
    pub(super) fn length(&self) -> f64 {
        self.surfaces[self.surfaces.len() - 1].z - self.surfaces[0].z
    }

    /// Places the film so that what is at this distance from it is sharp, by the thick-lens equation: with the distances
    /// s' of the film and s of the object from their principal planes, 1/s' + 1/s = 1/f (pbrt § 5.4.3). Returns the
    /// magnification s'/s.
    pub(super) fn focus(&mut self, distance: f64, millimetre: f64) -> Result<f64, SceneError> {
        let f = self.focal_length;
        let hiatus = self.length() + self.principal[1] - self.principal[0];
        // s + s'.
        let both = distance - hiatus;
        if !(both >= 4.0 * f && both.is_finite()) {
            let (nearest, asked) = ((hiatus + 4.0 * f) * millimetre, distance * millimetre);
            let message =
                format!("the lens of the camera cannot focus at {asked}: its nearest distance is {nearest}");
            return Err(error(ErrorCode::Camera, message)
                .help("`focus_distance` is measured from the film in scene units; `units_per_metre` is the scale of the scene"));
        }
        let behind = 2.0 * f / (1.0 + (1.0 - 4.0 * f / both).max(0.0).sqrt());
        let rear = behind - self.principal[0];
        if rear.is_nan() || rear <= 0.0 {
            let message = "the picture of the lens is inside the lens: it cannot reach the film".to_owned();
            return Err(
                error(ErrorCode::Camera, message).help("check `elements` and `focus_distance` of the camera")
            );
        }
        let by = rear - self.surfaces[0].z;
        self.surfaces.iter_mut().for_each(|s| s.z += by);
        Ok(behind / (both - behind))
    }

    /// The slope, per millimetre from the axis, of the paraxial ray from a point of the film through the centre of the
    /// stop; that through the centre of the rear surface for a lens without a stop.
    pub(super) fn chief_slope(&self) -> f64 {
        let stop = self.surfaces.iter().position(Surface::is_stop).unwrap_or(0);
        let last = if stop > 0 { self.surfaces[stop - 1].z } else { 0.0 };
        // The lens stands before the film, where the ray begins.
        let [from_height, from_slope] = self.paraxial(stop).moved(self.surfaces[stop].z - last).height;
        -from_height / from_slope
    }

    /// Where a ray leaves the lens, and its unit direction there; `d` is a unit vector. `None` if the lens blocks it.
    /// `through_stop` says whether a point of the stop, in radii of the stop, is open.
    #[inline]
    pub(super) fn trace(
        &self,
        mut p: DVec3,
        mut d: DVec3,
        through_stop: impl Fn(DVec2) -> bool,
    ) -> Option<(DVec3, DVec3)> {
        for s in &self.surfaces {
            let from_vertex = p - DVec3::new(0.0, 0.0, s.z);
            let t = if s.radius == 0.0 { -from_vertex.z / d.z } else { to_sphere(from_vertex, d, s.radius)? };
            // Also false for NaN.
            if !(0.0..f64::INFINITY).contains(&t) {
                return None;
            }
            let hit = from_vertex + t * d;
            let across = hit.x * hit.x + hit.y * hit.y;
            if across > s.aperture * s.aperture {
                return None;
            }
            p = DVec3::new(hit.x, hit.y, hit.z + s.z);
            if s.is_stop() {
                if !through_stop(DVec2::new(hit.x, hit.y) / s.aperture) {
                    return None;
                }
                continue;
            }
            let normal = s.curvature * hit + DVec3::Z;
            d = refracted(d, normal, s.ratio)?;
        }
        Some((p, d))
    }
}

/// The way along a ray to a sphere that crosses the axis at the origin, at its side of that point.
#[inline]
fn to_sphere(p: DVec3, d: DVec3, radius: f64) -> Option<f64> {
    let b = p.dot(d) + radius * d.z;
    let c = p.dot(p) + 2.0 * radius * p.z;
    let root = (b * b - c).max(-1.0).sqrt();
    let t = -c / (b + root.copysign(radius));
    let same_side = (p.z + t * d.z + radius) * radius > 0.0;
    same_side.then_some(t)
}

/// Snell's law. The unit normal points along the ray; `eta` is the index that the ray comes from over the other. `None`
/// for total reflection.
#[inline]
fn refracted(d: DVec3, normal: DVec3, eta: f64) -> Option<DVec3> {
    let cos = d.dot(normal);
    let cos2 = 1.0 - eta * eta * (1.0 - cos * cos);
    (cos > 0.0 && cos2 > 0.0).then(|| eta * d + (cos2.sqrt() - eta * cos) * normal)
}

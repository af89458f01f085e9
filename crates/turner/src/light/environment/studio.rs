//! The built-in studio: a photographer's studio for product shots, in white and grey.
//!
//! A white sweep, that is a white floor that curves up into white walls, under a dark ceiling, with three soft boxes: a
//! large key light at the upper left of the front (+z), a dim upright fill light on the right, and a rim light high
//! behind. An unshadowed white floor has a brightness of 0.87 at exposure 0. The white floor and walls light objects softly
//! from below and from the sides; the dark ceiling gives mirrors and glass contrast, and black objects their shape.
//!
//! ```text
//!   from above:        rim
//!                    -------
//!                      -z
//!                -x  object  +x
//!          \           +z        |  fill
//!        key \                   |
//!                    camera
//! ```

use std::f64::consts::{PI, TAU};

use crate::image::{Image, Pixels};
use crate::math::elementary::{sin_cos, tan};
use crate::math::{DVec2, DVec3, radians};

/// Size of the image: the rim light is five rows high.
const WIDTH: u32 = 512;
const HEIGHT: u32 = WIDTH / 2;

/// Radiance of the room: straight down, at the horizon, straight up.
const FLOOR: f64 = 0.7;
const WALL: f64 = 0.75;
const CEILING: f64 = 0.12;

/// The sine of the elevation above which there is ceiling.
const SWEEP: f64 = 0.35;

const KEY: SoftBox = SoftBox {
    radiance: 5.0,
    azimuth: -46.0,
    elevation: 44.0,
    half_width: 22.0,
    half_height: 18.0,
    softness: 0.3,
};
const FILL: SoftBox = SoftBox {
    radiance: 0.9,
    azimuth: 65.0,
    elevation: 22.0,
    half_width: 14.0,
    half_height: 26.0,
    softness: 0.4,
};
const RIM: SoftBox = SoftBox {
    radiance: 3.2,
    azimuth: 180.0,
    elevation: 45.0,
    half_width: 40.0,
    half_height: 8.0,
    softness: 0.4,
};

/// The image: grey floats.
pub(super) fn image() -> Image {
    let boxes = [&KEY, &FILL, &RIM].map(SoftBox::prepare);
    let mut samples = Vec::with_capacity((WIDTH * HEIGHT) as usize);
    let columns: Vec<_> =
        (0..WIDTH).map(|x| sin_cos(TAU * ((f64::from(x) + 0.5) / f64::from(WIDTH) - 0.5))).collect();
    for y in 0..HEIGHT {
        let (sin_theta, cos_theta) = sin_cos(PI * (f64::from(y) + 0.5) / f64::from(HEIGHT));
        for (sin_phi, cos_phi) in &columns {
            let d = DVec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi);
            let light = boxes.iter().fold(room_radiance(d.y), |sum, b| sum + b.radiance(d));
            samples.push(light as f32);
        }
    }
    Image { width: WIDTH, height: HEIGHT, channels: 1, pixels: Pixels::F32(samples) }
}

/// Radiance of the room by height, −1 the floor and 1 the ceiling.
fn room_radiance(height: f64) -> f64 {
    FLOOR + (WALL - FLOOR) * smooth(-1.0, 0.0, height) + (CEILING - WALL) * smooth(0.0, SWEEP, height)
}

/// Smooth step: 0 before `from`, 1 after `to`, 3t² − 2t³ between.
fn smooth(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A rectangular soft box, upright, facing the centre. Angles in degrees.
struct SoftBox {
    /// At its centre; a tenth less at the centres of its edges.
    radiance: f64,
    /// To the right of the front (+z).
    azimuth: f64,
    /// Above the horizon.
    elevation: f64,
    /// From its centre to its right edge.
    half_width: f64,
    /// From its centre to its upper edge.
    half_height: f64,
    /// Width of the fade before and after each edge, as a fraction of the distance from the centre to the edge.
    softness: f64,
}

/// The directions to the centre, right and top of a box, and its half sizes in a plane at distance 1.
struct PreparedSoftBox {
    radiance: f64,
    direction: DVec3,
    right: DVec3,
    up: DVec3,
    half: DVec2,
    softness: f64,
}

impl SoftBox {
    fn prepare(&self) -> PreparedSoftBox {
        let (sin_a, cos_a) = sin_cos(radians(self.azimuth));
        let (sin_e, cos_e) = sin_cos(radians(self.elevation));
        let direction = DVec3::new(sin_a * cos_e, sin_e, cos_a * cos_e);
        let right = DVec3::new(cos_a, 0.0, -sin_a);
        PreparedSoftBox {
            radiance: self.radiance,
            direction,
            right,
            up: direction.cross(right),
            half: DVec2::new(tan(radians(self.half_width)), tan(radians(self.half_height))),
            softness: self.softness,
        }
    }
}

impl PreparedSoftBox {
    fn radiance(&self, d: DVec3) -> f64 {
        let distance = d.dot(self.direction);
        if distance <= 0.0 {
            return 0.0;
        }
        let at = DVec2::new(d.dot(self.right), d.dot(self.up)) / distance / self.half;
        let inside = |v: f64| 1.0 - smooth(1.0 - self.softness, 1.0 + self.softness, v.abs());
        let to_edge = 1.0 - 0.1 * at.length_squared().min(2.0);
        self.radiance * to_edge * inside(at.x) * inside(at.y)
    }
}

//! Radiance and reflectance as RGB.

use std::ops::{Add, AddAssign, Mul, MulAssign, Sub};

/// Linear Rec. 709 RGB (display values in a display-referred scene). This is the type to replace for spectral
/// rendering.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spectrum {
    /// Red.
    pub r: f32,
    /// Green.
    pub g: f32,
    /// Blue.
    pub b: f32,
}

impl Spectrum {
    /// No light.
    pub const BLACK: Spectrum = Spectrum::grey(0.0);
    /// One in every band.
    pub const WHITE: Spectrum = Spectrum::grey(1.0);

    /// From red, green and blue.
    pub const fn new(r: f32, g: f32, b: f32) -> Spectrum {
        Spectrum { r, g, b }
    }

    /// The same value in every band.
    pub const fn grey(v: f32) -> Spectrum {
        Spectrum { r: v, g: v, b: v }
    }

    /// The bands as an array.
    pub const fn to_array(self) -> [f32; 3] {
        [self.r, self.g, self.b]
    }

    /// Whether every band is finite.
    pub fn is_finite(self) -> bool {
        self.r.is_finite() && self.g.is_finite() && self.b.is_finite()
    }

    /// Whether every band is zero.
    pub fn is_black(self) -> bool {
        self == Spectrum::BLACK
    }

    /// The largest component.
    pub fn max_component(self) -> f32 {
        self.r.max(self.g).max(self.b)
    }

    /// Applies a function to each band.
    pub fn map(self, f: impl Fn(f32) -> f32) -> Spectrum {
        Spectrum { r: f(self.r), g: f(self.g), b: f(self.b) }
    }

    /// (1 − t)·self + t·other.
    pub fn lerp(self, other: Spectrum, t: f32) -> Spectrum {
        self * (1.0 - t) + other * t
    }

    /// Luminance with Rec. 709 weights.
    pub fn luminance(self) -> f32 {
        0.2126 * self.r + 0.7152 * self.g + 0.0722 * self.b
    }
}

impl From<[f32; 3]> for Spectrum {
    fn from([r, g, b]: [f32; 3]) -> Spectrum {
        Spectrum { r, g, b }
    }
}

impl Add for Spectrum {
    type Output = Spectrum;
    fn add(self, o: Spectrum) -> Spectrum {
        Spectrum::new(self.r + o.r, self.g + o.g, self.b + o.b)
    }
}

impl Sub for Spectrum {
    type Output = Spectrum;
    fn sub(self, o: Spectrum) -> Spectrum {
        Spectrum::new(self.r - o.r, self.g - o.g, self.b - o.b)
    }
}

impl Mul for Spectrum {
    type Output = Spectrum;
    fn mul(self, o: Spectrum) -> Spectrum {
        Spectrum::new(self.r * o.r, self.g * o.g, self.b * o.b)
    }
}

impl Mul<f32> for Spectrum {
    type Output = Spectrum;
    fn mul(self, k: f32) -> Spectrum {
        Spectrum::new(self.r * k, self.g * k, self.b * k)
    }
}

impl AddAssign for Spectrum {
    fn add_assign(&mut self, o: Spectrum) {
        *self = *self + o;
    }
}

impl MulAssign<f32> for Spectrum {
    fn mul_assign(&mut self, k: f32) {
        *self = *self * k;
    }
}

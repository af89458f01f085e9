//! Measured lights: the luminous intensity of a light in each direction (IES profiles).
//!
//! Angles are those of type C photometry (IES LM-63), in degrees. The vertical angle is measured from the main axis of
//! the light: 0 along the axis, 180 opposite to it. The horizontal angle goes around the axis.
//!
//! ```text
//!          180
//!           │
//!    light  ●──── 90
//!           │╲
//!           │ ╲ vertical angle
//!           0     (main axis)
//! ```

use std::sync::Arc;

use crate::schema::value::{Data, Value};
use crate::schema::{ParamType, ReadContext, SceneError, WriteContext, wrong_type};

/// Luminous intensities of a light on a grid of directions, with angles in degrees.
#[derive(Clone, Debug, PartialEq)]
pub struct LightProfile {
    /// Increasing, within 0..=180. The intensity is 0 before the first and after the last angle.
    vertical: Vec<f64>,
    /// Increasing, from 0 to 360; or only 0 if the profile is symmetric about the axis.
    horizontal: Vec<f64>,
    /// Candela: for each horizontal angle, the values of all vertical angles.
    candela: Vec<f32>,
    /// The largest intensity, candela.
    peak: f32,
}

impl LightProfile {
    /// A profile from its angles in degrees and intensities in candela.
    ///
    /// Errors: angles out of order or out of range, a wrong number of intensities, intensities that are negative or not
    /// finite.
    pub fn new(
        vertical: Vec<f64>,
        horizontal: Vec<f64>,
        candela: Vec<f32>,
    ) -> Result<LightProfile, &'static str> {
        let increasing = |v: &[f64]| v.windows(2).all(|w| w[0] < w[1]);
        let within = |v: &[f64], most: f64| v.iter().all(|v| (0.0..=most).contains(v));
        if vertical.is_empty() || !within(&vertical, 180.0) || !increasing(&vertical) {
            return Err("vertical angles must increase within 0 to 180");
        }
        let full_circle = horizontal.first() == Some(&0.0) && horizontal.last() == Some(&360.0);
        if !(horizontal == [0.0] || full_circle && increasing(&horizontal)) {
            return Err("horizontal angles must increase from 0 to 360, or be 0 alone");
        }
        if candela.len() != vertical.len() * horizontal.len() {
            return Err("there must be an intensity for each pair of angles");
        }
        if !candela.iter().all(|v| *v >= 0.0 && v.is_finite()) {
            return Err("intensities must be finite numbers, 0 or more");
        }
        let peak = candela.iter().copied().fold(0.0, f32::max);
        Ok(LightProfile { vertical, horizontal, candela, peak })
    }

    /// The vertical angles, degrees: increasing, within 0..=180.
    pub fn vertical(&self) -> &[f64] {
        &self.vertical
    }

    /// The horizontal angles, degrees: increasing from 0 to 360, or 0 alone.
    pub fn horizontal(&self) -> &[f64] {
        &self.horizontal
    }

    /// The intensities, candela: for each horizontal angle, the values of all vertical angles.
    pub fn intensities(&self) -> &[f32] {
        &self.candela
    }

    /// The largest intensity, candela.
    pub fn peak(&self) -> f32 {
        self.peak
    }

    /// The intensity in candela at angles in degrees, within 0..=180 and 0..=360: bilinear interpolation.
    pub fn candela(&self, vertical: f64, horizontal: f64) -> f32 {
        let (Some(first), Some(last)) = (self.vertical.first(), self.vertical.last()) else { return 0.0 };
        // Rounding must not make a direction at the first or last angle dark.
        if !(first - 1e-9..=last + 1e-9).contains(&vertical) {
            return 0.0;
        }
        let (row, down) = between(&self.vertical, vertical);
        let (column, across) = between(&self.horizontal, horizontal);
        let at = |column: usize| {
            let part = &self.candela[column * self.vertical.len()..][..self.vertical.len()];
            let next = part[(row + 1).min(part.len() - 1)];
            part[row] + (next - part[row]) * down
        };
        let here = at(column);
        if across == 0.0 { here } else { here + (at(column + 1) - here) * across }
    }
}

/// The interval of increasing values that holds `v`: the index of its lower end, and the position within it, 0 to 1.
fn between(values: &[f64], v: f64) -> (usize, f32) {
    let i = values.partition_point(|at| *at <= v).saturating_sub(1);
    match values.get(i + 1) {
        Some(next) => (i, ((v - values[i]) / (next - values[i])).clamp(0.0, 1.0) as f32),
        None => (i, 0.0),
    }
}

/// The IES file of a light. Two are equal if their data are equal.
#[derive(Clone, Debug)]
pub struct ProfileFile {
    /// The file name as written in the scene.
    pub uri: String,
    /// Its data.
    pub data: Arc<LightProfile>,
}

impl PartialEq for ProfileFile {
    fn eq(&self, other: &ProfileFile) -> bool {
        self.data == other.data
    }
}

impl ParamType for ProfileFile {
    fn kind() -> String {
        "\"IES file\"".into()
    }
    fn read(value: &Value, cx: &mut dyn ReadContext) -> Result<ProfileFile, SceneError> {
        match &value.data {
            Data::String(uri) => {
                Ok(ProfileFile { uri: uri.clone(), data: cx.light_profile(uri, value.span)? })
            }
            _ => Err(wrong_type(value, "the name of an IES file")),
        }
    }
    fn show(&self) -> String {
        "a file".into()
    }
    fn write(&self, cx: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
        cx.light_profile(self).map(Some)
    }
}

//! Measured lights: how strongly a lamp shines in each direction.
//!
//! Angles are those of photometry of type C (IES LM-63): the vertical angle is 0 along the lamp's axis, where its light
//! goes, and 180 behind; the horizontal one turns around the axis.

use std::sync::Arc;

use crate::schema::value::{Data, Value};
use crate::schema::{ParamType, ReadContext, SceneError, WriteContext, wrong_type};

/// Intensities of a lamp by direction, on a grid of angles in degrees.
#[derive(Clone, Debug, PartialEq)]
pub struct LightProfile {
    /// Increasing, within 0..=180. Beyond the first and the last it is dark.
    vertical: Vec<f64>,
    /// Increasing, from 0 to 360; or 0 alone, if all directions around the axis are alike.
    horizontal: Vec<f64>,
    /// Candela: for each horizontal angle those of all vertical ones.
    candela: Vec<f32>,
    /// The largest.
    peak: f32,
}

impl LightProfile {
    /// A profile of consistent numbers, or what is wrong with them.
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
        let whole = horizontal.first() == Some(&0.0) && horizontal.last() == Some(&360.0);
        if !(horizontal == [0.0] || whole && increasing(&horizontal)) {
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

    /// The intensities, candela: for each horizontal angle those of all vertical ones.
    pub fn intensities(&self) -> &[f32] {
        &self.candela
    }

    /// The largest intensity, candela.
    pub fn peak(&self) -> f32 {
        self.peak
    }

    /// The intensity at angles in degrees, 0..=180 and 0..=360: bilinear between those that were measured.
    pub fn candela(&self, vertical: f64, horizontal: f64) -> f32 {
        let (Some(first), Some(last)) = (self.vertical.first(), self.vertical.last()) else { return 0.0 };
        // Rounding must not put out a direction on the rim.
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

/// Between which two of increasing numbers a value lies: the place of the first, and the share of the way to the second.
fn between(values: &[f64], v: f64) -> (usize, f32) {
    let i = values.partition_point(|at| *at <= v).saturating_sub(1);
    match values.get(i + 1) {
        Some(next) => (i, ((v - values[i]) / (next - values[i])).clamp(0.0, 1.0) as f32),
        None => (i, 0.0),
    }
}

/// A file of measurements that a light names. Two are the same if they hold the same.
#[derive(Clone, Debug)]
pub struct ProfileFile {
    /// Its name as written.
    pub uri: String,
    /// What it holds.
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

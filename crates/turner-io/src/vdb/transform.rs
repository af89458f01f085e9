//! Transforms from indices of voxels to space.

use super::Cursor;

/// Scales and translates; rotated grids are refused.
pub(super) struct Transform {
    pub(super) scale: [f64; 3],
    pub(super) translation: [f64; 3],
}

/// Reads a transform: the name of its map, then that map's numbers.
pub(super) fn read(cursor: &mut Cursor<'_>) -> Result<Transform, String> {
    let kind = cursor.string()?;
    let mut vector = || -> Result<[f64; 3], String> { Ok([cursor.f64()?, cursor.f64()?, cursor.f64()?]) };
    let mut skip = [[0.0; 3]; 4];
    let transform = match kind.as_str() {
        "ScaleMap" | "UniformScaleMap" => {
            let scale = vector()?;
            // The voxel size and reciprocals follow from the scale.
            for v in &mut skip {
                *v = vector()?;
            }
            Transform { scale, translation: [0.0; 3] }
        }
        "ScaleTranslateMap" | "UniformScaleTranslateMap" => {
            let (translation, scale) = (vector()?, vector()?);
            for v in &mut skip {
                *v = vector()?;
            }
            Transform { scale, translation }
        }
        "TranslationMap" => Transform { scale: [1.0; 3], translation: vector()? },
        "AffineMap" | "UnitaryMap" => affine(cursor)?,
        other => {
            return Err(format!(
                "has the transform {other}: expected a linear one (scale, translation, affine); resample the grid"
            ));
        }
    };
    transform.checked()
}

impl Transform {
    /// From a matrix of 3 × 3 numbers and a translation.
    ///
    /// Errors: rotated or sheared grids, numbers that are not finite.
    pub(super) fn from_matrix([x, y, z]: [[f64; 3]; 3], translation: [f64; 3]) -> Result<Transform, String> {
        let scale = [x[0], y[1], z[2]];
        let most = scale.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let others = [x[1], x[2], y[0], y[2], z[0], z[1]];
        if others.iter().any(|v| v.is_nan() || v.abs() > 1e-9 * most) {
            return Err("is rotated or sheared: expected cells along the axes; resample the grid".into());
        }
        Transform { scale, translation }.checked()
    }

    fn checked(self) -> Result<Transform, String> {
        let numbers = self.scale.iter().chain(&self.translation);
        if numbers.clone().any(|v| !v.is_finite()) || self.scale.contains(&0.0) {
            return Err(format!(
                "its transform has the scale {:?}: expected finite numbers other than 0",
                self.scale
            ));
        }
        Ok(self)
    }
}

/// A matrix of 4 × 4 doubles that is multiplied by row vectors: the last row is the translation.
fn affine(cursor: &mut Cursor<'_>) -> Result<Transform, String> {
    let mut rows = [[0.0f64; 4]; 4];
    for v in rows.as_flattened_mut() {
        *v = cursor.f64()?;
    }
    let [x, y, z, t] = rows.map(|[a, b, c, _]| [a, b, c]);
    Transform::from_matrix([x, y, z], t)
}

//! Transforms of objects, instances and textures, as written in a scene.

use crate::math::elementary::sin_cos;
use crate::math::{DAffine3, DMat3, DVec3, radians};
use crate::schema::value::{Data, Table, Value};
use crate::schema::write::list;
use crate::schema::{ErrorCode, ParamType, ReadContext, SceneError, TableReader, WriteContext, wrong_type};

/// An invertible affine transform. Written as a table of `scale`, `rotate`, `translate`, `matrix` and `look_at`,
/// applied in that order, or as a list of such tables, applied from first to last.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Transform(pub DAffine3);

impl Transform {
    /// The identity.
    pub const IDENTITY: Transform = Transform(DAffine3::IDENTITY);

    /// As a value of a scene file.
    pub(crate) fn to_data(self) -> Data {
        Data::Table(written(&self.0).unwrap_or_default())
    }

    /// Whether it is the identity.
    pub fn is_identity(&self) -> bool {
        self.0 == DAffine3::IDENTITY
    }
}

/// A right-handed rotation about a unit axis: counter-clockwise as seen from the tip of the axis.
pub fn rotation(axis: DVec3, degrees: f64) -> DMat3 {
    // Multiples of 90° are exact, so that rotated boxes stay axis-aligned.
    let quarters = degrees / 90.0;
    let (s, c) = if quarters == quarters.floor() && quarters.abs() < 1e9 {
        [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][(quarters as i64).rem_euclid(4) as usize]
    } else {
        sin_cos(radians(degrees))
    };
    let (x, y, z) = (axis.x, axis.y, axis.z);
    let k = 1.0 - c;
    DMat3::from_cols(
        DVec3::new(c + x * x * k, y * x * k + z * s, z * x * k - y * s),
        DVec3::new(x * y * k - z * s, c + y * y * k, z * y * k + x * s),
        DVec3::new(x * z * k + y * s, y * z * k - x * s, c + z * z * k),
    )
}

/// Rotates about x, then y, then z.
fn euler(degrees: DVec3) -> DMat3 {
    rotation(DVec3::Z, degrees.z) * rotation(DVec3::Y, degrees.y) * rotation(DVec3::X, degrees.x)
}

impl ParamType for Transform {
    fn kind() -> String {
        "transform".into()
    }
    fn read(value: &Value, cx: &mut dyn ReadContext) -> Result<Transform, SceneError> {
        let total = match &value.data {
            Data::Table(_) => read_step(value, cx)?,
            Data::Array(steps) => {
                let mut total = DAffine3::IDENTITY;
                for step in steps {
                    total = read_step(step, cx)? * total;
                }
                total
            }
            _ => return Err(wrong_type(value, "a transform { translate = [x, y, z], … } or a list of them")),
        };
        invertible(total, value)?;
        Ok(Transform(total))
    }
    fn show(&self) -> String {
        if self.is_identity() { "none".into() } else { format!("{:?}", self.0) }
    }
    fn write(&self, _: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
        Ok(written(&self.0).map(Data::Table))
    }
}

/// Writes `scale` and `translate` if they reproduce the transform to the last bit, otherwise `matrix`; `None` for the
/// identity.
fn written(m: &DAffine3) -> Option<Table> {
    let bits = |m: &DAffine3| m.to_cols_array().map(f64::to_bits);
    let numbers = |v: DVec3| list(v.to_array().map(Data::Number));
    if bits(m) == bits(&DAffine3::IDENTITY) {
        return None;
    }
    let scale = DVec3::new(m.matrix3.x_axis.x, m.matrix3.y_axis.y, m.matrix3.z_axis.z);
    let mut plain = DAffine3::IDENTITY;
    let mut table = Table::default();
    if scale != DVec3::ONE {
        plain = DAffine3::from_scale(scale);
        let [x, y, z] = scale.to_array();
        table.push("scale", if x == y && y == z { Data::Number(x) } else { numbers(scale) });
    }
    if m.translation != DVec3::ZERO {
        plain = DAffine3::from_translation(m.translation) * plain;
        table.push("translate", numbers(m.translation));
    }
    if bits(&plain) == bits(m) {
        return Some(table);
    }
    let row = |i: usize| list(m.to_cols_array().into_iter().skip(i).step_by(3).map(Data::Number));
    let mut table = Table::default();
    table.push("matrix", list([0, 1, 2].map(row)));
    Some(table)
}

fn invertible(m: DAffine3, value: &Value) -> Result<(), SceneError> {
    let inverse = m.inverse();
    // A uniform scale of 1e-10 has the determinant 1e-30. So test the product with the inverse, not the determinant.
    let round_trip = (m.matrix3 * inverse.matrix3 - DMat3::IDENTITY).to_cols_array();
    if m.is_finite() && inverse.is_finite() && round_trip.iter().all(|v| v.abs() < 1e-6) {
        return Ok(());
    }
    let message = "this transform is not invertible (its matrix is singular or not finite)";
    Err(SceneError::at(ErrorCode::Transform, value.span, message)
        .help("every scale must differ from 0 and the matrix must have three independent axes"))
}

fn read_step(value: &Value, cx: &mut dyn ReadContext) -> Result<DAffine3, SceneError> {
    let mut table = TableReader::of(value, "a transform")?;
    let mut m = DAffine3::IDENTITY;
    if let Some(scale) = table.take("scale") {
        let s = match scale.data {
            Data::Array(_) => DVec3::read(scale, cx)?,
            _ => DVec3::splat(f64::read(scale, cx)?),
        };
        m = DAffine3::from_scale(s) * m;
    }
    if let Some(rotate) = table.take("rotate") {
        let r = match rotate.data {
            Data::Array(_) => euler(DVec3::read(rotate, cx)?),
            _ => {
                let mut inner = TableReader::of(rotate, "a rotation")?;
                let axis: DVec3 = inner.required("axis", None, cx, || DVec3::Y)?;
                let angle: f64 = inner.required("angle", None, cx, || 0.0)?;
                inner.finish(cx)?;
                let axis = axis.try_normalize().ok_or_else(|| {
                    SceneError::at(
                        ErrorCode::Transform,
                        rotate.span,
                        "the axis of a rotation must not be zero",
                    )
                })?;
                rotation(axis, angle)
            }
        };
        m = DAffine3::from_mat3(r) * m;
    }
    if let Some(translate) = table.take("translate") {
        m = DAffine3::from_translation(DVec3::read(translate, cx)?) * m;
    }
    if let Some(matrix) = table.take("matrix") {
        let matrix = read_matrix(matrix, cx)?;
        // A matrix on its own is kept to the last bit, including the signs of its zeros.
        m = if m == DAffine3::IDENTITY { matrix } else { matrix * m };
    }
    if let Some(look_at) = table.take("look_at") {
        m = read_look_at(look_at, cx)? * m;
    }
    table.finish(cx)?;
    Ok(m)
}

/// Reads the rows of a 3×4 or 4×4 matrix, flat or nested. Points are column vectors, so the translation is the last
/// column.
fn read_matrix(value: &Value, cx: &mut dyn ReadContext) -> Result<DAffine3, SceneError> {
    let Data::Array(items) = &value.data else {
        return Err(wrong_type(value, "12 or 16 numbers, row by row"));
    };
    let mut numbers = Vec::with_capacity(16);
    for item in items.iter().take(17) {
        match &item.data {
            Data::Array(row) => {
                for v in row.iter().take(17) {
                    numbers.push(f64::read(v, cx)?);
                }
            }
            _ => numbers.push(f64::read(item, cx)?),
        }
    }
    if numbers.len() != 12 && numbers.len() != 16 {
        let message = format!("expected 12 or 16 numbers, row by row, found {}", numbers.len());
        return Err(SceneError::at(ErrorCode::WrongType, value.span, message));
    }
    if numbers.len() == 16 && numbers[12..] != [0.0, 0.0, 0.0, 1.0] {
        let message = "the last row of a matrix must be 0, 0, 0, 1: perspective transforms are not supported";
        return Err(SceneError::at(ErrorCode::Transform, value.span, message));
    }
    let column = |c: usize| DVec3::new(numbers[c], numbers[4 + c], numbers[8 + c]);
    Ok(DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) })
}

/// Moves the origin to `from`, points +z at `to`, and turns +y as close to `up` as possible.
fn read_look_at(value: &Value, cx: &mut dyn ReadContext) -> Result<DAffine3, SceneError> {
    let mut table = TableReader::of(value, "a look_at transform")?;
    let from = table.optional::<DVec3>("from", None, cx)?.unwrap_or(DVec3::ZERO);
    let to: DVec3 = table.required("to", None, cx, || from + DVec3::Z)?;
    let up = table.optional::<DVec3>("up", None, cx)?.unwrap_or(DVec3::Y);
    table.finish(cx)?;
    let degenerate = |what: &str| SceneError::at(ErrorCode::Transform, value.span, what.to_owned());
    let z = (to - from).try_normalize().ok_or_else(|| degenerate("`from` and `to` are the same point"))?;
    let x = up
        .try_normalize()
        .and_then(|up| Some(up.cross(z)).filter(|x| x.length() > 1e-9))
        .ok_or_else(|| degenerate("`up` is zero or parallel to the direction from `from` to `to`"))?
        .normalize();
    Ok(DAffine3 { matrix3: DMat3::from_cols(x, z.cross(x), z), translation: from })
}

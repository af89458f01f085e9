//! Values between keyframes.
//!
//! A smooth curve is a cubic Hermite spline in each number. With the slopes d of the straight lines to the neighbours, the
//! tangent at a keyframe is the weighted harmonic mean of d before and after if both have the same sign, else 0. So the
//! curve is monotone wherever the keyframes are (Fritsch & Butland 1984, "A method for constructing local monotone
//! piecewise cubic interpolants"), and rests at turning points, at the first keyframe and at the last.

use super::Interpolation;
use crate::animation::motion::Motion;
use crate::math::DAffine3;
use crate::schema::value::{Data, Entry, Table, Value};
use crate::schema::{ParamType, ReadContext, SceneError, Transform};

/// Why two values cannot be interpolated.
pub(super) struct Mismatch(pub(super) String);

/// Whether a key path ends at a transform.
pub(super) fn is_transform(target: &str) -> bool {
    matches!(target.rsplit('.').next(), Some("transform" | "motion"))
}

fn number(data: &Data) -> Option<f64> {
    match data {
        Data::Integer(i) => Some(*i as f64),
        Data::Number(v) => Some(*v),
        _ => None,
    }
}

/// Checks that two values have the same form: numbers where the other has numbers, all else equal.
pub(super) fn check(a: &Data, b: &Data) -> Result<(), Mismatch> {
    let differ = |what: String| Err(Mismatch(what));
    match (a, b) {
        (Data::Array(a), Data::Array(b)) if a.len() != b.len() => {
            differ(format!("one has {} numbers and another {}", a.len(), b.len()))
        }
        (Data::Array(a), Data::Array(b)) => a.iter().zip(b).try_for_each(|(a, b)| check(&a.data, &b.data)),
        (Data::Table(a), Data::Table(b)) => {
            for (own, other) in [(a, b), (b, a)] {
                if let Some(lacks) = own.entries.iter().find(|e| other.get(&e.key).is_none()) {
                    return differ(format!("one has `{}` and another has not", lacks.key));
                }
            }
            let mut entries = a.entries.iter().filter_map(|e| Some((&e.value, b.get(&e.key)?)));
            entries.try_for_each(|(a, b)| check(&a.data, &b.data))
        }
        (a, b) => match (number(a), number(b)) {
            (Some(a), Some(b)) if a.is_finite() && b.is_finite() => Ok(()),
            (Some(_), Some(_)) => differ("a number is not finite".to_owned()),
            _ if a == b => Ok(()),
            _ => differ(format!("{} and {} have nothing between them", a.kind(), b.kind())),
        },
    }
}

/// A place between keyframes: `before` and `after` are their indices, `fraction` is 0 at the first and 1 at the second.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    before: usize,
    after: usize,
    fraction: f64,
}

fn place(times: &[f64], time: f64) -> Place {
    let last = times.len().saturating_sub(1);
    let after = times.partition_point(|own| *own <= time);
    let (before, after) = (after.saturating_sub(1), after.min(last));
    let length = times[after] - times[before];
    let fraction = if length > 0.0 { ((time - times[before]) / length).clamp(0.0, 1.0) } else { 0.0 };
    Place { before, after, fraction }
}

/// The value at a time, given times and values of the keyframes, of which there is at least one.
pub(super) fn value(
    target: &str,
    (times, values): (&[f64], &[Value]),
    interpolation: Interpolation,
    time: f64,
    cx: &mut dyn ReadContext,
) -> Result<Value, SceneError> {
    let at = place(times, time);
    let (a, b) = (&values[at.before], &values[at.after]);
    if interpolation == Interpolation::Step || at.before == at.after || at.fraction == 0.0 {
        return Ok(a.clone());
    }
    if is_transform(target)
        && !values.iter().all(|own| is_plain(&own.data) && check(&a.data, &own.data).is_ok())
    {
        return between_transforms(a, b, eased(interpolation, at.fraction), cx);
    }
    let data: Vec<&Data> = values.iter().map(|own| &own.data).collect();
    Ok(Value { data: blend(&data, times, at, interpolation), span: a.span })
}

/// The share of the second of two values that are not numbers, with the slopes of a curve of two keyframes.
fn eased(interpolation: Interpolation, t: f64) -> f64 {
    match interpolation {
        Interpolation::Step => 0.0,
        Interpolation::Linear => t,
        Interpolation::Smooth => t * t * (3.0 - 2.0 * t),
    }
}

/// Whether a transform is made of steps whose numbers can be interpolated.
fn is_plain(data: &Data) -> bool {
    match data {
        Data::Array(steps) => steps.iter().all(|step| is_plain(&step.data)),
        Data::Table(table) => table.entries.iter().all(|e| !matches!(e.key.as_str(), "matrix" | "look_at")),
        _ => true,
    }
}

/// By translation, rotation and stretch.
fn between_transforms(
    a: &Value,
    b: &Value,
    share: f64,
    cx: &mut dyn ReadContext,
) -> Result<Value, SceneError> {
    let ends: [DAffine3; 2] = [Transform::read(a, cx)?.0, Transform::read(b, cx)?.0];
    let motion = Motion::new(&ends[0], &ends[1]).map_err(|e| e.or_at(Some(b.span)))?;
    Ok(Value { data: Transform(motion.at(share)).to_data(), span: a.span })
}

/// Interpolates all numbers of values of one form.
fn blend(values: &[&Data], times: &[f64], at: Place, interpolation: Interpolation) -> Data {
    let own = values[at.before];
    match own {
        Data::Integer(_) | Data::Number(_) => {
            let numbers: Vec<f64> = values.iter().map(|v| number(v).unwrap_or(0.0)).collect();
            Data::Number(between(&numbers, times, at, interpolation))
        }
        Data::Array(items) => {
            let item = |(i, item): (usize, &Value)| {
                let parts = parts(values, &item.data, |v| match v {
                    Data::Array(own) => own.get(i).map(|v| &v.data),
                    _ => None,
                });
                Value { data: blend(&parts, times, at, interpolation), span: item.span }
            };
            Data::Array(items.iter().enumerate().map(item).collect())
        }
        Data::Table(table) => {
            let entry = |entry: &Entry| {
                let parts = parts(values, &entry.value.data, |v| match v {
                    Data::Table(own) => own.get(&entry.key).map(|v| &v.data),
                    _ => None,
                });
                let value = Value { data: blend(&parts, times, at, interpolation), span: entry.value.span };
                Entry { value, ..entry.clone() }
            };
            Data::Table(Table { entries: table.entries.iter().map(entry).collect() })
        }
        Data::Bool(_) | Data::String(_) => own.clone(),
    }
}

/// The same part of all values; `own` where one lacks it.
fn parts<'a>(
    values: &[&'a Data],
    own: &'a Data,
    part: impl Fn(&'a Data) -> Option<&'a Data>,
) -> Vec<&'a Data> {
    values.iter().map(|&v| part(v).unwrap_or(own)).collect()
}

/// One number between keyframes.
fn between(v: &[f64], times: &[f64], at: Place, interpolation: Interpolation) -> f64 {
    let Place { before, after, fraction: t } = at;
    let (a, b) = (v[before], v[after]);
    match interpolation {
        Interpolation::Step => a,
        Interpolation::Linear => a + (b - a) * t,
        Interpolation::Smooth => {
            let length = times[after] - times[before];
            let [leaving, arriving] = [before, after].map(|key| length * tangent(v, times, key));
            let (t2, t3) = (t * t, t * t * t);
            (2.0 * t3 - 3.0 * t2 + 1.0) * a
                + (t3 - 2.0 * t2 + t) * leaving
                + (3.0 * t2 - 2.0 * t3) * b
                + (t3 - t2) * arriving
        }
    }
}

/// The slope of a smooth curve at a keyframe, per second.
fn tangent(v: &[f64], times: &[f64], key: usize) -> f64 {
    if key == 0 || key + 1 >= v.len() {
        return 0.0;
    }
    let lengths = [times[key] - times[key - 1], times[key + 1] - times[key]];
    let slopes = [(v[key] - v[key - 1]) / lengths[0], (v[key + 1] - v[key]) / lengths[1]];
    let share = (lengths[0] + 2.0 * lengths[1]) / (3.0 * (lengths[0] + lengths[1]));
    match slopes[0] * slopes[1] {
        product if product > 0.0 => product / (share * slopes[1] + (1.0 - share) * slopes[0]),
        _ => 0.0,
    }
}

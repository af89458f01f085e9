//! Values of composed prims: the strongest opinion at a time.

use super::Stage;
use super::tree::Prim;
use crate::usd::paths::property;
use crate::usd::value::{ListEdit, Read, Value};

/// A value and the name of the layer that has it.
pub(crate) struct Opinion {
    pub(crate) value: Value,
    pub(crate) layer: String,
}

impl Stage<'_> {
    /// A field of a prim or of one of its properties: the strongest opinion.
    pub(crate) fn field(&self, prim: &Prim, name: Option<&str>, field: &str) -> Read<Option<Value>> {
        for &i in prim.order.iter() {
            let node = &prim.nodes[i];
            let path = name.map_or_else(|| node.path.clone(), |name| property(&node.path, name));
            for (layer, _) in &self.stack_of(node.stack).layers {
                if let Some(value) = self.layer(*layer).layer.field(&path, field)? {
                    return Ok(Some(value.into_owned()));
                }
            }
        }
        Ok(None)
    }

    /// A text field of a prim.
    pub(crate) fn text_field(&self, prim: &Prim, field: &str) -> Read<String> {
        let value = self.field(prim, None, field)?;
        Ok(value.as_ref().and_then(Value::text).unwrap_or_default().to_owned())
    }

    /// Whether a prim is defined, and not only an addition to one that is not there, or a class.
    pub(crate) fn is_defined(&self, prim: &Prim) -> Read<bool> {
        for &i in prim.order.iter() {
            let node = &prim.nodes[i];
            for (layer, _) in &self.stack_of(node.stack).layers {
                match self
                    .layer(*layer)
                    .layer
                    .field(&node.path, "specifier")?
                    .as_deref()
                    .and_then(Value::text)
                {
                    Some("def") => return Ok(true),
                    // A class that is inherited does not make an abstract prim of a defined one.
                    Some("class") if i == 0 => return Ok(false),
                    _ => {}
                }
            }
        }
        Ok(false)
    }

    /// The value of an attribute at the stage's time; `None` if none is authored or it is blocked.
    pub(crate) fn value(&self, prim: &Prim, name: &str) -> Read<Option<Value>> {
        Ok(self.opinion(prim, name)?.map(|opinion| opinion.value))
    }

    /// The same with the layer that has it.
    pub(crate) fn opinion(&self, prim: &Prim, name: &str) -> Read<Option<Opinion>> {
        for &i in prim.order.iter() {
            let node = &prim.nodes[i];
            let path = property(&node.path, name);
            for (id, offset) in &self.stack_of(node.stack).layers {
                let named = self.layer(*id);
                let layer = &named.layer;
                if !layer.has(&path) {
                    continue;
                }
                let mut found = None;
                if let Some(Value::Samples(samples)) = layer.field(&path, "timeSamples")?.as_deref() {
                    self.animated.set(self.animated.get() || samples.len() > 1);
                    let time = node.offset.of(*offset).inverse(self.time);
                    let is_rotation = layer.field(&path, "typeName")?;
                    let is_rotation =
                        is_rotation.as_deref().and_then(Value::text).is_some_and(|t| t.starts_with("quat"));
                    found = sampled(samples, time, is_rotation, |v| layer.open(v))?;
                }
                if found.is_none() {
                    found = layer.field(&path, "default")?.map(std::borrow::Cow::into_owned);
                }
                match found {
                    Some(Value::Blocked) => return Ok(None),
                    Some(value) => return Ok(Some(Opinion { value, layer: named.name.clone() })),
                    None => {}
                }
            }
        }
        Ok(None)
    }

    /// The targets of a relationship (`targetPaths`) or the connections of an attribute (`connectionPaths`), as paths
    /// of the stage.
    pub(crate) fn targets(&self, prim: &Prim, name: &str, field: &str) -> Read<Vec<String>> {
        let mut list: Vec<String> = Vec::new();
        for &i in prim.order.iter().rev() {
            let node = &prim.nodes[i];
            let path = property(&node.path, name);
            for (layer, _) in self.stack_of(node.stack).layers.iter().rev() {
                let layer = self.layer(*layer);
                let Some(value) = layer.layer.field(&path, field)? else { continue };
                let Value::List(edit) = value.as_ref() else { continue };
                let map =
                    |list: &Vec<String>| list.iter().filter_map(|p| self.on_stage(prim, i, p)).collect();
                let mapped = ListEdit {
                    explicit: edit.explicit.as_ref().map(map),
                    prepended: map(&edit.prepended),
                    added: map(&edit.added),
                    appended: map(&edit.appended),
                    deleted: map(&edit.deleted),
                };
                mapped.apply(&mut list);
            }
        }
        Ok(list)
    }
}

/// The value of time samples at a time code: numbers are interpolated linearly, other values are held.
fn sampled(
    samples: &[(f64, Value)],
    time: f64,
    is_rotation: bool,
    open: impl Fn(&Value) -> Read<Value>,
) -> Read<Option<Value>> {
    let after = samples.partition_point(|(t, _)| *t <= time);
    let Some((t0, first)) = samples.get(after.saturating_sub(1)) else { return Ok(None) };
    let first = open(first)?;
    let Some((t1, second)) = samples.get(after).filter(|_| after > 0 && *t0 < time) else {
        return Ok(Some(first));
    };
    let second = open(second)?;
    let mix = (time - t0) / (t1 - t0);
    Ok(Some(interpolated(&first, &second, mix, is_rotation).unwrap_or(first)))
}

fn interpolated(a: &Value, b: &Value, t: f64, is_rotation: bool) -> Option<Value> {
    let lerp = |a: f64, b: f64| a + t * (b - a);
    Some(match (a, b) {
        (Value::Real(a), Value::Real(b)) => Value::Real(lerp(*a, *b)),
        (Value::Vector(a), Value::Vector(b)) if a.len() == b.len() => {
            let dot: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
            // The shorter way between rotations.
            let sign = if is_rotation && dot < 0.0 { -1.0 } else { 1.0 };
            Value::Vector(a.iter().zip(b).map(|(a, b)| lerp(*a, sign * b)).collect())
        }
        (Value::Floats(width, a), Value::Floats(_, b)) if a.len() == b.len() && !is_rotation => {
            let mixed = a.iter().zip(b).map(|(a, b)| lerp(f64::from(*a), f64::from(*b)) as f32);
            Value::Floats(*width, mixed.collect())
        }
        (Value::Doubles(width, a), Value::Doubles(_, b)) if a.len() == b.len() && !is_rotation => {
            Value::Doubles(*width, a.iter().zip(b).map(|(a, b)| lerp(*a, *b)).collect())
        }
        _ => return None,
    })
}

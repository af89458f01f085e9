//! Animations, sampled at one time (glTF 2.0 §3.11 and appendix C).
//!
//! A channel animates one property of one node: its translation, rotation, scale or the weights of its mesh's morph
//! targets. The channel's sampler holds key times in seconds and values. With t = (time − t₀) / Δ between the
//! neighbouring keys at t₀ and t₀ + Δ:
//!
//! - `STEP`: the value of the key before.
//! - `LINEAR`: a + (b − a) t; rotations use spherical interpolation (slerp) along the shorter arc.
//! - `CUBICSPLINE`: a Hermite spline. Each key stores in-tangent, value and out-tangent; tangents are per second and
//!   are multiplied by Δ:
//!   (2t³ − 3t² + 1) a + Δ (t³ − 2t² + t) out(a) + (3t² − 2t³) b + Δ (t³ − t²) in(b).
//!
//! Before the first and after the last key the value is constant.

use std::collections::{BTreeMap, BTreeSet};

use turner::math::DVec3;
use turner::math::elementary::{acos, sin};
use turner::schema::WarningKind;

use super::accessors::Elements;
use super::budget::Budget;
use super::buffers::Buffers;
use super::fault::{Fault, Outcome};
use super::json::{AnimationSampler, Document, Index, Mesh};
use super::nodes::{Local, choose, normalize};
use super::report::Report;

/// The word for no animation.
const NONE: &str = "none";

/// The animation with this name or index, or else the first; `None` without animations, and for "none", with which
/// nodes have their own transforms.
pub(super) fn chosen(
    document: &Document,
    wanted: Option<&str>,
    report: &mut Report,
) -> Outcome<Option<Index>> {
    let animations = &document.animations;
    let names: Vec<_> = animations.iter().map(|a| a.name.as_deref()).collect();
    match wanted {
        Some(NONE) if !names.contains(&Some(NONE)) => Ok(None),
        Some(name) => choose(name, &names, "animation").map(Some),
        None => {
            if animations.len() > 1 {
                report.add(WarningKind::Note, "several animations: the first one is used");
            }
            Ok((!animations.is_empty()).then_some(Index(0)))
        }
    }
}

/// The transforms and morph weights of all nodes at one time.
#[derive(Debug)]
pub(super) struct Pose {
    /// The local transform of each node.
    pub(super) locals: Vec<Local>,
    /// By node index, the weights of its mesh's morph targets, if the node or the animation sets them.
    pub(super) weights: BTreeMap<u32, Vec<f64>>,
}

impl Pose {
    /// The pose without animation.
    pub(super) fn rest(document: &Document) -> Pose {
        Pose {
            locals: document.nodes.iter().map(Local::of).collect(),
            weights: (0u32..)
                .zip(&document.nodes)
                .filter(|(_, node)| !node.weights.is_empty())
                .map(|(number, node)| (number, node.weights.clone()))
                .collect(),
        }
    }

    /// Applies an animation at `time` seconds.
    pub(super) fn apply(
        &mut self,
        document: &Document,
        (buffers, budget): (&Buffers, &Budget),
        chosen: Index,
        time: f64,
        report: &mut Report,
    ) -> Outcome<()> {
        let animations = &document.animations;
        let animation = &animations[chosen];
        let targets_of: Vec<usize> = document.meshes.iter().map(morph_targets).collect();
        let mut driven = BTreeSet::new();
        for (c, channel) in animation.channels.iter().enumerate() {
            let pointer = format!("/animations/{}/channels/{c}", chosen.0);
            let Some(sampler) = animation.samplers.get(channel.sampler.index()) else {
                let count = animation.samplers.len();
                return Err(Fault::dangling(pointer, "sampler", channel.sampler.0, count));
            };
            let Some(node) = channel.target.node else {
                if channel.target.extensions.as_deref().is_some_and(|e| e.pointer.is_some()) {
                    continue; // see `pointers`
                }
                // The target is defined by an extension (§3.11).
                report.ignored("an animation of something other than a node");
                continue;
            };
            if node.index() >= self.locals.len() {
                return Err(Fault::dangling(pointer, "node", node.0, self.locals.len()));
            }
            let path = channel.target.path.as_str();
            let targets = match path {
                "translation" | "rotation" | "scale" => 1,
                "weights" => {
                    let mesh = document.nodes[node].mesh;
                    mesh.and_then(|m| targets_of.get(m.index())).copied().unwrap_or(0)
                }
                _ => {
                    report.ignored("an animation of an unknown property");
                    continue;
                }
            };
            if !driven.insert((node, path)) {
                report.doubtful("an animation targets a property twice: the first channel is used");
                continue;
            }
            let keys = Keys::open(document, buffers, sampler, targets, &pointer)?;
            let Some(keys) = keys else {
                report.doubtful("an animation without keyframes");
                continue;
            };
            let interval = keys.at(time);
            if path == "weights" {
                budget.take(targets, size_of::<f64>(), &pointer)?;
                let weights = (0..targets).map(|i| keys.value::<1>(&interval, i)[0]).collect();
                self.weights.insert(node.0, weights);
                continue;
            }
            let Local::Parts { translation, rotation, scale } = &mut self.locals[node.index()] else {
                report.doubtful("an animation of a node that has a matrix");
                continue;
            };
            match path {
                "translation" => *translation = DVec3::from(keys.value::<3>(&interval, 0)),
                "scale" => *scale = DVec3::from(keys.value::<3>(&interval, 0)),
                _ => *rotation = keys.rotation(&interval),
            }
        }
        Ok(())
    }
}

/// Number of morph targets of a mesh.
fn morph_targets(mesh: &Mesh) -> usize {
    mesh.primitives.iter().map(|p| p.targets.len()).max().unwrap_or(0)
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Interpolation {
    Step,
    Linear,
    Cubic,
}

/// The keyframes of a sampler.
pub(super) struct Keys<'a> {
    times: Elements<'a>,
    values: Elements<'a>,
    interpolation: Interpolation,
    /// Values per key: the number of morph targets for weights, else 1.
    targets: usize,
}

/// A time between two keys: `fraction` is the interpolation parameter, 0 at `before` and 1 at `after`; `length` is their
/// distance in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Interval {
    before: usize,
    after: usize,
    fraction: f64,
    length: f64,
}

impl<'a> Keys<'a> {
    /// Opens a sampler with `targets` values per key; `None` if it has no keys.
    pub(super) fn open(
        document: &Document,
        buffers: &'a Buffers,
        sampler: &AnimationSampler,
        targets: usize,
        pointer: &str,
    ) -> Outcome<Option<Keys<'a>>> {
        let times = Elements::open(document, buffers, sampler.input, pointer)?;
        let times = times.with_width(&[1], "the times of an animation")?;
        let values = Elements::open(document, buffers, sampler.output, pointer)?;
        let interpolation = match sampler.interpolation.as_deref().unwrap_or("LINEAR") {
            "STEP" => Interpolation::Step,
            "LINEAR" => Interpolation::Linear,
            "CUBICSPLINE" => Interpolation::Cubic,
            other => {
                let message = format!("has interpolation {other}; expected STEP, LINEAR or CUBICSPLINE");
                return Err(Fault::at(pointer, message));
            }
        };
        if times.count == 0 || targets == 0 {
            return Ok(None);
        }
        let per_key = targets.saturating_mul(if interpolation == Interpolation::Cubic { 3 } else { 1 });
        let values = values.with_count(times.count.saturating_mul(per_key), "the values of an animation")?;
        Ok(Some(Keys { times, values, interpolation, targets }))
    }

    /// Components of a value.
    pub(super) fn width(&self) -> usize {
        self.values.width
    }

    fn time(&self, key: usize) -> f64 {
        f64::from(self.times.get::<1>(key)[0])
    }

    /// The keys before and after a time; outside the animation, the first or last one twice.
    pub(super) fn at(&self, time: f64) -> Interval {
        let (mut from, mut to) = (0, self.times.count);
        while from < to {
            let middle = from + (to - from) / 2;
            if self.time(middle) <= time { from = middle + 1 } else { to = middle }
        }
        let last = self.times.count - 1;
        let (before, after) = (from.saturating_sub(1), from.min(last));
        let (start, length) = (self.time(before), self.time(after) - self.time(before));
        let fraction = if length > 0.0 { ((time - start) / length).clamp(0.0, 1.0) } else { 0.0 };
        Interval { before, after, fraction: if fraction.is_finite() { fraction } else { 0.0 }, length }
    }

    /// A stored value of a key. Of cubic splines, `which` is 0 for the in-tangent, 1 for the value, 2 for the
    /// out-tangent.
    fn stored<const N: usize>(&self, key: usize, which: usize, target: usize) -> [f64; N] {
        let row = match self.interpolation {
            Interpolation::Cubic => 3 * key + which,
            _ => key,
        };
        self.values.get::<N>(row * self.targets + target).map(f64::from)
    }

    /// The value of a target at a time.
    pub(super) fn value<const N: usize>(&self, interval: &Interval, target: usize) -> [f64; N] {
        let stored = |key, which| self.stored::<N>(key, which, target);
        let (a, b, t) = (stored(interval.before, 1), stored(interval.after, 1), interval.fraction);
        let value: [f64; N] = match self.interpolation {
            Interpolation::Step => {
                if t < 1.0 {
                    a
                } else {
                    b
                }
            }
            Interpolation::Linear => std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t),
            Interpolation::Cubic if interval.before == interval.after => a,
            Interpolation::Cubic => {
                let (out, into) = (stored(interval.before, 2), stored(interval.after, 0));
                let (t2, t3) = (t * t, t * t * t);
                let (from, leaving) = (2.0 * t3 - 3.0 * t2 + 1.0, interval.length * (t3 - 2.0 * t2 + t));
                let (to, arriving) = (3.0 * t2 - 2.0 * t3, interval.length * (t3 - t2));
                std::array::from_fn(|i| from * a[i] + leaving * out[i] + to * b[i] + arriving * into[i])
            }
        };
        value.map(|v| if v.is_finite() { v } else { 0.0 })
    }

    /// The value at a time as a unit quaternion.
    pub(super) fn rotation(&self, interval: &Interval) -> [f64; 4] {
        match self.interpolation {
            Interpolation::Linear => {
                let (a, b) = (self.stored(interval.before, 1, 0), self.stored(interval.after, 1, 0));
                slerp(normalize(a), normalize(b), interval.fraction)
            }
            _ => normalize(self.value::<4>(interval, 0)),
        }
    }
}

/// Spherical linear interpolation of unit quaternions along the shorter arc.
fn slerp(a: [f64; 4], b: [f64; 4], t: f64) -> [f64; 4] {
    let dot: f64 = (0..4).map(|i| a[i] * b[i]).sum();
    let angle = acos(dot.abs());
    let (from, to) = if angle > 1e-6 {
        (sin((1.0 - t) * angle) / sin(angle), sin(t * angle) / sin(angle))
    } else {
        (1.0 - t, t)
    };
    let to = if dot < 0.0 { -to } else { to };
    normalize(std::array::from_fn(|i| from * a[i] + to * b[i]))
}

#[cfg(test)]
mod tests;

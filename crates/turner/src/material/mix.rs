//! Materials mixed from others.

use super::{MaterialDesc, Mix};
use crate::schema::error::escape;
use crate::schema::{ColorSource, ErrorCode, MaterialId, Named, Range, SceneError, params};

params! {
    /// A weighted mix of materials: rust on steel, dirt on paint, glass with a frosted pattern. Scattering, emission
    /// and opacity are the weighted sums of those of the parts. Mixes can contain mixes, up to 16 levels.
    pub struct MixMaterial as "mix" {
        /// The materials, by name or inline: at least two.
        materials: Vec<MaterialId>, required, default Vec::new();
        /// Weights, numbers or textures. One per material: relative weights. One fewer: the first material gets what
        /// the others leave of 1. Without weights all materials count equally.
        weights: Vec<ColorSource> = Vec::new(), in Range::NON_NEGATIVE;
    }
    example r##"[material.steel]
type = "metal"
name = "iron"
roughness = 0.2

[material.rust]
type = "matte"
color = [0.3, 0.1, 0.04]

[material.rusty]
type = "mix"
materials = ["steel", "rust"]
weights = [{ type = "noise", low = 0, high = 1 }]

[[object]]
type = "sphere"
material = "rusty"
"##
}

/// Maximum nesting of mixes.
const MAX_DEPTH: usize = 16;

/// Maximum number of materials of one mix, those of nested mixes counted each time.
pub(super) const MAX_PARTS: u64 = 64;

/// State of a material in the depth-first search.
#[derive(Clone, Copy)]
enum State {
    New,
    Open,
    /// Number of materials it expands to, and how deep mixes nest in it.
    Done(u64, usize),
}

/// Rejects mixes that contain themselves, refer to unknown materials, have the wrong number of weights, or are too
/// large. `descs` are the scene's materials; the index after the last is the default material.
pub(crate) fn check(descs: &[Named<MaterialDesc>]) -> Result<(), SceneError> {
    let mut states = vec![State::New; descs.len()];
    for start in 0..descs.len() {
        // Depth-first with an explicit stack: a chain of names can be as long as the file.
        let mut stack = vec![start];
        while let Some(&node) = stack.last() {
            let MaterialDesc::Mix(mix) = &descs[node].value else {
                states[node] = State::Done(1, 0);
                stack.pop();
                continue;
            };
            let fail = |code, message: String| SceneError::new(code, message).or_at(descs[node].span);
            if matches!(states[node], State::New) {
                mix.check_alone(descs.len()).map_err(|e| e.or_at(descs[node].span))?;
                states[node] = State::Open;
            }
            let (mut parts, mut depth, mut next) = (0u64, 0, None);
            for child in mix.materials.iter().map(|m| m.index()) {
                if matches!(descs.get(child), Some(Named { value: MaterialDesc::Interface(_), .. })) {
                    let message = "an interface material is no surface and cannot be part of a mix";
                    return Err(fail(ErrorCode::Conflict, message.into()));
                }
                match states.get(child) {
                    None => parts += 1,
                    Some(State::Done(n, d)) => (parts, depth) = (parts.saturating_add(*n), depth.max(*d)),
                    Some(State::New) => next = Some(child),
                    Some(State::Open) => {
                        let message = format!("the material {} contains itself", label(descs, child));
                        return Err(fail(ErrorCode::Cycle, message));
                    }
                }
            }
            if let Some(child) = next {
                stack.push(child);
                continue;
            }
            if depth + 1 > MAX_DEPTH {
                let message = format!(
                    "in the material {} mixes are nested deeper than {MAX_DEPTH}",
                    label(descs, node)
                );
                return Err(fail(ErrorCode::Cycle, message));
            }
            if parts > MAX_PARTS {
                let message = format!(
                    "the material {} expands to {parts} materials, more than {MAX_PARTS}",
                    label(descs, node)
                );
                return Err(fail(ErrorCode::TooLarge, message));
            }
            states[node] = State::Done(parts, depth + 1);
            stack.pop();
        }
    }
    Ok(())
}

fn label(descs: &[Named<MaterialDesc>], node: usize) -> String {
    match &descs[node].name {
        Some(name) => format!("\"{}\"", escape(name)),
        None => "\"mix\"".into(),
    }
}

impl MixMaterial {
    /// Checks that need no other material. `known` is the number of materials without the default one.
    fn check_alone(&self, known: usize) -> Result<(), SceneError> {
        let (n, weights) = (self.materials.len(), self.weights.len());
        if n < 2 {
            let message = format!("a mix needs at least two materials, found {n}");
            return Err(SceneError::new(ErrorCode::OutOfRange, message));
        }
        if !(weights == 0 || weights == n || weights + 1 == n) {
            let message = format!("expected {} or {n} weights for {n} materials, found {weights}", n - 1);
            return Err(SceneError::new(ErrorCode::OutOfRange, message)
                .help("give one weight for each material, or omit that of the first"));
        }
        if let Some(id) = self.materials.iter().find(|m| m.index() > known) {
            let message = format!("a mix names material {}, but the scene has {known}", id.0);
            return Err(SceneError::new(ErrorCode::UnknownName, message));
        }
        Ok(())
    }

    /// Prepares the mix. `descs` are the scene's materials, already checked.
    pub(super) fn prepare(&self, physical: bool, descs: &[Named<MaterialDesc>]) -> Mix {
        let shadows = |id: MaterialId| {
            let default = MaterialDesc::default();
            let desc = descs.get(id.index()).map_or(&default, |d| &d.value);
            (desc.cutout(physical), desc.prepare(physical, descs).shadow())
        };
        Mix::new(self, shadows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Spectrum;

    fn named(list: Vec<MaterialDesc>) -> Vec<Named<MaterialDesc>> {
        list.into_iter().map(|value| Named { name: None, span: None, value }).collect()
    }

    fn mix(materials: &[u32], weights: usize) -> MaterialDesc {
        MaterialDesc::Mix(MixMaterial {
            materials: materials.iter().map(|i| MaterialId(*i)).collect(),
            weights: vec![ColorSource::Constant(Spectrum::WHITE); weights],
        })
    }

    fn refused(list: Vec<MaterialDesc>) -> ErrorCode {
        check(&named(list)).expect_err("refused").code
    }

    #[test]
    fn mixes_are_checked() {
        let plain = MaterialDesc::default;
        assert!(check(&named(vec![mix(&[1, 2], 1), plain(), mix(&[1, 1, 3], 3)])).is_ok());
        assert_eq!(refused(vec![mix(&[0, 1], 1), plain()]), ErrorCode::Cycle);
        assert_eq!(refused(vec![mix(&[1, 2], 1), mix(&[0, 2], 1), plain()]), ErrorCode::Cycle);
        assert_eq!(refused(vec![mix(&[1], 0), plain()]), ErrorCode::OutOfRange);
        assert_eq!(refused(vec![mix(&[1, 1, 1], 1), plain()]), ErrorCode::OutOfRange);
        assert_eq!(refused(vec![mix(&[1, 9], 1), plain()]), ErrorCode::UnknownName);
    }

    #[test]
    fn mixes_are_bounded() {
        // A chain of 100,000, and repeated doubling.
        let chain: Vec<_> = (0..100_000).map(|i| mix(&[i + 1, 100_000], 1)).collect();
        assert_eq!(refused(chain), ErrorCode::Cycle);
        let doubled: Vec<_> = (0..16).map(|i| mix(&[i + 1, i + 1], 1)).collect();
        assert_eq!(refused(doubled), ErrorCode::TooLarge);
    }
}

//! Keyframes of a scene as a glTF animation: the placements of objects, cameras and lights.
//!
//! glTF interpolates translation, rotation and scale of nodes; a scene interpolates the numbers of any key. So the scene is
//! sampled 24 times a second and at all keyframes, and samples that lie between their neighbours are left out. Where all
//! animations jump, the node jumps too.

use std::sync::Arc;

use serde_json::{Value, json};
use turner::animation::Interpolation;
use turner::description::{ModelDesc, SceneAssets, SceneDesc};
use turner::image::Image;
use turner::math::DAffine3;
use turner::schema::value::FileId;
use turner::schema::{ErrorCode, MeshData, SceneError};

use super::buffer::Buffer;
use super::cameras;
use super::nodes::{Nodes, Source, parts, quaternion};
use super::remarks::Remarks;

/// Samples per second.
const RATE: f64 = 24.0;
/// Most samples of an animation: more than an hour.
const MAX_SAMPLES: usize = 100_000;
/// Most samples of all nodes together: a gigabyte.
const MAX_POSES: usize = 12_000_000;
/// Largest difference of a component from the line between its neighbours, relative to its size.
const TOLERANCE: f64 = 1e-6;

/// No keyframe of a placement names a file.
struct NoFiles;

impl SceneAssets for NoFiles {
    fn image(&mut self, uri: &str, _: FileId) -> Result<Arc<Image>, SceneError> {
        Err(SceneError::new(
            ErrorCode::File,
            format!("{uri}: keyframes that name files are not written as glTF"),
        ))
    }
    fn mesh(&mut self, uri: &str, _: FileId) -> Result<Arc<MeshData>, SceneError> {
        Err(SceneError::new(
            ErrorCode::File,
            format!("{uri}: keyframes that name files are not written as glTF"),
        ))
    }
    fn model(&mut self, model: &ModelDesc, _: FileId) -> Result<Arc<SceneDesc>, SceneError> {
        let message = format!("{}: keyframes that name files are not written as glTF", model.file);
        Err(SceneError::new(ErrorCode::File, message))
    }
}

/// The times at which a scene is sampled, in seconds; glTF has none below 0.
fn times(desc: &SceneDesc) -> Vec<f64> {
    let all = || desc.animations.iter().flat_map(|own| own.value.times.iter().copied()).map(|t| t.max(0.0));
    let (first, last) = (all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max));
    let mut times: Vec<f64> = all().collect();
    if !jumps(desc) {
        let frames = ((last - first) * RATE).min(MAX_SAMPLES as f64) as usize;
        times.extend((0..=frames).map(|i| first + i as f64 / RATE).filter(|t| *t <= last));
    }
    times.sort_by(f64::total_cmp);
    // Single precision, in which glTF stores times, must tell them apart.
    times.dedup_by(|b, a| *b - *a < 1e-4);
    times.truncate(MAX_SAMPLES);
    times
}

/// Whether all animations are steps.
fn jumps(desc: &SceneDesc) -> bool {
    desc.animations.iter().all(|own| own.value.interpolation == Interpolation::Step)
}

/// Where a scene places everything that a node can have as its source.
struct Placements {
    objects: Vec<DAffine3>,
    cameras: Vec<Option<DAffine3>>,
    lights: Vec<Option<DAffine3>>,
}

impl Placements {
    fn of(desc: &SceneDesc) -> Placements {
        let in_groups = desc.groups.iter().flat_map(|group| &group.value.objects);
        let cameras = desc.camera.iter().chain(&desc.cameras);
        Placements {
            objects: in_groups.chain(&desc.objects).map(|own| own.transform.0).collect(),
            cameras: cameras.map(|own| cameras::camera_placement(&own.value)).collect(),
            lights: desc.lights.iter().map(|own| cameras::light_placement(&own.value)).collect(),
        }
    }

    fn get(&self, source: Source) -> Option<DAffine3> {
        match source {
            Source::Object(i) => self.objects.get(i).copied(),
            Source::Camera(i) => *self.cameras.get(i)?,
            Source::Light(i) => *self.lights.get(i)?,
        }
    }
}

/// Translation, rotation and scale.
type Pose = ([f64; 3], [f64; 4], [f64; 3]);

/// The animations of the document. `full` is the scene with hidden parts, of which the nodes are not made.
///
/// Errors: those of the keyframes.
pub(super) fn add(
    full: &SceneDesc,
    nodes: &Nodes,
    buffer: &mut Buffer<'_>,
    remarks: &mut Remarks,
) -> Result<Vec<Value>, SceneError> {
    if !full.has_keyframes() {
        return Ok(Vec::new());
    }
    let times = times(full);
    if nodes.sources.len().saturating_mul(times.len()) > MAX_POSES {
        let message = format!(
            "{} samples of {} nodes are too many keyframes for a glTF file",
            times.len(),
            nodes.sources.len()
        );
        return Err(SceneError::new(ErrorCode::TooLarge, message)
            .help("convert to a .toml file, which keeps the keyframes as they are"));
    }
    let mut poses: Vec<Vec<Pose>> = vec![Vec::with_capacity(times.len()); nodes.sources.len()];
    let mut is_sheared = vec![false; nodes.sources.len()];
    for &time in &times {
        let mut at = full.clone();
        at.animate(time, None, &mut NoFiles)?;
        let placements = Placements::of(&at.without_hidden().0);
        for (k, (source, _)) in nodes.sources.iter().enumerate() {
            let Some(placed) = placements.get(*source) else { continue };
            let parts = parts(&placed.matrix3);
            is_sheared[k] |= parts.inner.is_some();
            let mut rotation = quaternion(&parts.outer);
            // Of the two quaternions of a rotation, the nearer one.
            if let Some((_, before, _)) = poses[k].last()
                && before.iter().zip(&rotation).map(|(a, b)| a * b).sum::<f64>() < 0.0
            {
                rotation = rotation.map(|v| -v);
            }
            poses[k].push((placed.translation.to_array(), rotation, parts.scale.to_array()));
        }
    }
    let interpolation = if jumps(full) { "STEP" } else { "LINEAR" };
    let mut writer =
        Writer { times: &times, interpolation, buffer, samplers: Vec::new(), channels: Vec::new() };
    for (k, (_, node)) in nodes.sources.iter().enumerate() {
        let poses = &poses[k];
        let moves = poses.windows(2).any(|pair| pair[0] != pair[1]);
        if !moves || poses.len() != times.len() {
            continue;
        }
        if is_sheared[k] {
            remarks.ignored("animations of sheared objects");
            continue;
        }
        writer.channel(*node, "translation", poses.iter().map(|pose| pose.0).collect());
        writer.channel(*node, "rotation", poses.iter().map(|pose| pose.1).collect());
        writer.channel(*node, "scale", poses.iter().map(|pose| pose.2).collect());
    }
    let others = full.animations.iter().filter(|own| !places(&own.value.target));
    others.for_each(|_| remarks.ignored("animations of other keys than those of placement"));
    let Writer { samplers, channels, .. } = writer;
    match channels.is_empty() {
        true => Ok(Vec::new()),
        false => Ok(vec![json!({ "channels": channels, "samplers": samplers })]),
    }
}

/// Whether a target is the placement of something.
fn places(target: &str) -> bool {
    let key = target.rsplit('.').next().unwrap_or_default();
    ["transform", "position", "look_at", "up", "from", "direction"].contains(&key)
}

struct Writer<'w, 'a> {
    times: &'w [f64],
    interpolation: &'static str,
    buffer: &'w mut Buffer<'a>,
    samplers: Vec<Value>,
    channels: Vec<Value>,
}

impl Writer<'_, '_> {
    /// Adds a channel of a node, unless its values are all the same.
    fn channel<const N: usize>(&mut self, node: usize, path: &str, values: Vec<[f64; N]>) {
        if values.windows(2).all(|pair| pair[0] == pair[1]) {
            return;
        }
        let kept = match self.interpolation {
            "STEP" => (0..values.len()).collect(),
            _ => corners(self.times, &values),
        };
        let input = self.buffer.values(kept.iter().map(|i| [self.times[*i] as f32]).collect());
        let output = self.buffer.values(kept.iter().map(|i| values[*i].map(|v| v as f32)).collect());
        let sampler = json!({ "input": input, "output": output, "interpolation": self.interpolation });
        self.samplers.push(sampler);
        let target = json!({ "node": node, "path": path });
        self.channels.push(json!({ "sampler": self.samplers.len() - 1, "target": target }));
    }
}

/// The samples that do not lie on the line between those kept before and after.
fn corners<const N: usize>(times: &[f64], values: &[[f64; N]]) -> Vec<usize> {
    /// Most samples that one line replaces.
    const LONGEST: usize = 240;
    let mut kept = vec![0];
    let mut from = 0;
    for to in 2..values.len() {
        let is_line = to - from <= LONGEST
            && (from + 1..to).all(|i| {
                let share = (times[i] - times[from]) / (times[to] - times[from]);
                (0..N).all(|k| {
                    let line = values[from][k] + (values[to][k] - values[from][k]) * share;
                    (values[i][k] - line).abs() <= TOLERANCE * values[i][k].abs().max(1.0)
                })
            });
        if !is_line {
            from = to - 1;
            kept.push(from);
        }
    }
    kept.push(values.len() - 1);
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_on_lines_are_left_out() {
        let times: Vec<f64> = (0..11).map(f64::from).collect();
        let bent: Vec<[f64; 1]> = times.iter().map(|t| [if *t < 4.0 { *t } else { 4.0 }]).collect();
        assert_eq!(corners(&times, &bent), [0, 4, 10]);
        let curved: Vec<[f64; 1]> = times.iter().map(|t| [t * t]).collect();
        assert_eq!(corners(&times, &curved).len(), 11);
        assert_eq!(corners(&times[..2], &curved[..2]), [0, 1]);
    }
}

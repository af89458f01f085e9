//! Keyframes: values of any key of a scene at given times, and what lies between them.
//!
//! ```text
//! [[animation]] ── AnimationDesc ── value at a time ── SceneDesc::edit ──► the scene at that time
//! ```
//!
//! A key path names what is animated, as in `-D camera.fov=30`; objects, lights and views are named by their own names.
//! Keyframes hold values as a scene file has them, and all numbers in them are interpolated: see `interpolate`. The
//! description holds the values of one time, so integrators know nothing of animations. For motion blur,
//! `SceneDesc::animate` compares the scene at the beginning and at the end of a frame.

mod interpolate;
mod keyframes;
pub(crate) mod motion;

pub use keyframes::Keyframes;

use crate::schema::value::Value;
use crate::schema::{ErrorCode, Named, ReadContext, SceneError, TableReader, choice, params};
use interpolate::Mismatch;

choice! {
    /// How values between two keyframes follow from them.
    pub enum Interpolation {
        /// The value of the keyframe before.
        Step = "step",
        /// Straight from keyframe to keyframe.
        Linear = "linear",
        /// A smooth curve through all keyframes that does not overshoot, and rests at the first and the last.
        Smooth = "smooth",
    }
}

params! {
    /// Keyframes: the values of one key at several times, in seconds. `--frame`, `--time` and `--frames` choose the time
    /// that is rendered; without them it is 0. Before the first keyframe and after the last one the value stays.
    ///
    /// All numbers of a value are interpolated, each on its own: coordinates, colours, angles. So `rotate = [0, 720, 0]`
    /// turns twice from `rotate = [0, 0, 0]`. Transforms that contain `matrix` or `look_at`, or different steps, are
    /// interpolated by their translation, rotation (along the shorter arc) and stretch. Words, names, whole numbers such
    /// as `samples` and switches change with "step" only.
    pub struct AnimationDesc as "animation" {
        /// The key path: `camera.position`, `material.gold.base_color`, `film.exposure`. Objects, lights and views are
        /// found by their names, or by their index from 0: `object.ball.transform`, `light.lamp.intensity`,
        /// `group.robot.object.arm.transform`.
        target: String, required, default "camera.position".to_owned();
        /// Times of the keyframes in seconds, increasing.
        times: Vec<f64>, required, default vec![0.0];
        /// The value at each time, as the key takes it.
        values: Keyframes, required, default Keyframes::position([0.0, 0.0, 5.0]);
        /// How values between two keyframes follow from them.
        interpolation: Interpolation = Interpolation::Linear;
        /// Whether the keyframes repeat after the last one, and before the first.
        repeat: bool = false;
    }
    example r#"[[animation]]
target = "object.ball.transform"
times = [0, 0.5, 1]
values = [
    { translate = [0, 0, 0] },
    { translate = [0, 1.5, 0], rotate = [0, 90, 0] },
    { translate = [0, 0, 0], rotate = [0, 180, 0] },
]
interpolation = "smooth"

[[object]]
name = "ball"
type = "superellipsoid"
material = { color = "tomato" }
"#
}

impl AnimationDesc {
    /// Checks that there is one value for each time, that times increase, and that the values can be interpolated.
    pub(crate) fn check(&self) -> Result<(), SceneError> {
        let (times, values) = (&self.times, &self.values.0);
        let error = |code, message: String, help: &str| Err(SceneError::new(code, message).help(help));
        if times.is_empty() || times.len() != values.len() {
            let message = format!(
                "an animation has one value for each time: found {} times and {} values",
                times.len(),
                values.len()
            );
            return error(ErrorCode::Conflict, message, "write as many `values` as `times`");
        }
        if let Some(pair) = times.windows(2).find(|pair| pair[0] >= pair[1]) {
            let message =
                format!("the times of an animation must increase: {} is followed by {}", pair[0], pair[1]);
            return error(ErrorCode::OutOfRange, message, "sort the keyframes by time");
        }
        if self.interpolation == Interpolation::Step {
            return Ok(());
        }
        for value in values {
            if let Err(Mismatch(what)) = interpolate::check(&values[0].data, &value.data)
                && !interpolate::is_transform(&self.target)
            {
                let message = format!("keyframes of \"{}\" cannot be interpolated: {what}", self.target);
                let error = SceneError::at(ErrorCode::WrongType, value.span, message);
                return Err(error.help("give all values the same form, or write `interpolation = \"step\"`"));
            }
        }
        Ok(())
    }

    /// The value at a time in seconds.
    ///
    /// Errors: transforms that cannot be interpolated.
    pub(crate) fn at(&self, time: f64, cx: &mut dyn ReadContext) -> Result<Value, SceneError> {
        let time = if self.repeat { wrapped(time, &self.times) } else { time };
        interpolate::value(&self.target, (&self.times, &self.values.0), self.interpolation, time, cx)
    }
}

/// The time within the keyframes of an animation that repeats.
fn wrapped(time: f64, times: &[f64]) -> f64 {
    match (times.first(), times.last()) {
        (Some(first), Some(last)) if last > first => {
            let length = last - first;
            let turns = ((time - first) / length).floor();
            (time - turns * length).clamp(*first, *last)
        }
        _ => time,
    }
}

/// Reads an animation.
pub(crate) fn read_animation(
    value: &Value,
    cx: &mut dyn ReadContext,
) -> Result<Named<AnimationDesc>, SceneError> {
    let mut table = TableReader::of(value, "an animation")?;
    let name = table.optional::<String>("name", None, cx)?;
    let desc = AnimationDesc::read(&mut table, cx)?;
    table.finish(cx)?;
    desc.check().map_err(|e| e.or_at(Some(value.span)))?;
    Ok(Named { name, span: Some(value.span), value: desc })
}

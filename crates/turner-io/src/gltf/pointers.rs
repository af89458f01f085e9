//! `KHR_animation_pointer`: animations of any property of the document.
//!
//! A channel names its property by a JSON pointer. The values at the chosen time are written into the JSON text's tree,
//! from which the document is read again, so every property that the importer knows can be animated:
//!
//! ```text
//!   JSON text ──> tree ── keys at the time ──> tree with new values ──> Document
//! ```

use serde_json::Value;
use turner::schema::Memory;

use super::animations::Keys;
use super::budget::Budget;
use super::buffers::Buffers;
use super::fault::{Fault, Outcome};
use super::json::{self, Animation, Channel, Document};
use super::report::Report;

/// Memory of the tree for each byte of JSON text, in bytes.
const TREE_PER_BYTE: u64 = 32;
/// Most elements of an animated array.
const MOST_ELEMENTS: usize = 1 << 16;

/// The document at `time` seconds of an animation; `None` if it has no pointers.
pub(super) fn animated(
    text: &[u8],
    (document, animation, number): (&Document, &Animation, u32),
    (buffers, budget): (&Buffers, &Budget),
    memory: &Memory,
    time: f64,
    report: &mut Report,
) -> Outcome<Option<Document>> {
    if animation.channels.iter().all(|c| pointer_of(c).is_none()) {
        return Ok(None);
    }
    let needed = TREE_PER_BYTE.saturating_mul(text.len() as u64);
    memory.need(needed, || "the tree of its JSON text".to_owned()).map_err(Fault::of_scene)?;
    let end = text.iter().rposition(|b| *b != 0).map_or(0, |last| last + 1);
    let mut tree: Value = serde_json::from_slice(text.get(..end).unwrap_or_default())
        .map_err(|e| Fault::of_file(format!("the JSON text: {e}")))?;
    for (c, channel) in animation.channels.iter().enumerate() {
        let Some(target) = pointer_of(channel) else { continue };
        let at = format!("/animations/{number}/channels/{c}");
        let Some(sampler) = animation.samplers.get(channel.sampler.index()) else {
            return Err(Fault::dangling(at, "sampler", channel.sampler.0, animation.samplers.len()));
        };
        let Some(place) = place(&mut tree, target) else {
            report.doubtful("an animation of a property that is not in the document");
            continue;
        };
        // Each key of an array of scalars, such as weights, has all of its elements.
        let elements = place.as_array().map_or(1, Vec::len).clamp(1, MOST_ELEMENTS);
        let is_scalar = document
            .accessors
            .get(sampler.output.index())
            .is_some_and(|a| a.kind.as_deref() == Some("SCALAR"));
        let targets = if is_scalar { elements } else { 1 };
        budget.take(targets, size_of::<Value>(), &at)?;
        let Some(keys) = Keys::open(document, buffers, sampler, targets, &at)? else {
            report.doubtful("an animation without keyframes");
            continue;
        };
        let interval = keys.at(time);
        *place = match keys.width() {
            1 if place.is_boolean() || target.ends_with("/visible") => {
                Value::from(keys.value::<1>(&interval, 0)[0] != 0.0)
            }
            1 if place.is_array() => (0..targets).map(|i| keys.value::<1>(&interval, i)[0]).collect(),
            1 => Value::from(keys.value::<1>(&interval, 0)[0]),
            2 => Value::from(keys.value::<2>(&interval, 0).to_vec()),
            3 => Value::from(keys.value::<3>(&interval, 0).to_vec()),
            4 if target.starts_with("/nodes/") => Value::from(keys.rotation(&interval).to_vec()),
            4 => Value::from(keys.value::<4>(&interval, 0).to_vec()),
            _ => {
                report.ignored("an animation of a matrix");
                continue;
            }
        };
    }
    let text =
        serde_json::to_vec(&tree).map_err(|e| Fault::of_file(format!("the animated document: {e}")))?;
    json::parse(&text).map(Some)
}

/// The JSON pointer of a channel's property.
fn pointer_of(channel: &Channel) -> Option<&str> {
    let extension = channel.target.extensions.as_deref()?.pointer.as_ref()?;
    (channel.target.path == "pointer").then_some(&extension.pointer)
}

/// The value at a pointer. A property with its default value may be missing, the object that has it may not.
fn place<'a>(tree: &'a mut Value, pointer: &str) -> Option<&'a mut Value> {
    let (parent, member) = pointer.rsplit_once('/')?;
    match tree.pointer_mut(parent)? {
        Value::Object(members) => {
            let member = member.replace("~1", "/").replace("~0", "~");
            Some(members.entry(member).or_insert(Value::Null))
        }
        Value::Array(elements) => elements.get_mut(member.parse::<usize>().ok()?),
        _ => None,
    }
}

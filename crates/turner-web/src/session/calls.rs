//! The table of calls, and how they read their arguments.

use serde_json::{Value as Json, json};

use super::{CallError, Reply, Session, assist, files, gallery, inspect, look, parts, picture, save};

/// Files that belong to a call: name and bytes.
pub type Files = Vec<(String, Vec<u8>)>;

/// What a call does.
pub type Call = fn(&mut Session, &Json, Files) -> Result<Reply, CallError>;

/// All calls, by name.
pub const CALLS: &[(&str, Call)] = &[
    ("gallery", |_, _, _| gallery::gallery()),
    ("tutorial", |_, _, _| gallery::tutorial()),
    ("open_start", gallery::open),
    ("open", files::open),
    ("set_text", |s, args, _| files::set_text(s, args)),
    ("text", |s, _, _| files::text(s)),
    ("check", |s, args, _| assist::check(s, args)),
    ("complete", |s, args, _| assist::complete(s, args)),
    ("hover", |s, args, _| assist::hover(s, args)),
    ("view", |s, args, _| look::view(s, args)),
    ("integrators", |_, _, _| Ok(look::integrators())),
    ("gesture", |s, args, _| look::gesture(s, args)),
    ("gesture_end", |s, _, _| look::gesture_end(s)),
    ("frame", |s, args, _| look::frame(s, args)),
    ("focus", |s, args, _| look::focus(s, args)),
    ("pick", |s, args, _| inspect::pick(s, args)),
    ("value", |s, args, _| inspect::value(s, args)),
    ("explain", |s, args, _| inspect::explain(s, args)),
    ("doctor", |s, _, _| inspect::doctor(s)),
    ("outline", |s, _, _| parts::outline(s)),
    ("part", |s, args, _| parts::part(s, args)),
    ("set", |s, args, _| parts::set(s, args)),
    ("undo", |s, _, _| Ok(step_back(s, true))),
    ("redo", |s, _, _| Ok(step_back(s, false))),
    ("save", |s, args, _| save::save(s, args)),
    ("picture", |s, args, files| crate::picture::of_call(s.limits.clone(), s.threads, args, files)),
    ("picture_begin", picture::begin),
    ("picture_step", |s, args, _| picture::step(s, args)),
    ("picture_take", |s, args, _| picture::take(s, args)),
    ("picture_aovs", |s, _, _| picture::aovs(s)),
    ("picture_end", |s, _, _| Ok(picture::end(s))),
];

/// Calls that make the picture that is being rendered obsolete: whoever makes them ends the step that runs by
/// [`Session::stop`]. `page/engine.js` has the same list.
pub const REPLACES: &[&str] =
    &["open", "open_start", "set_text", "set", "undo", "redo", "gesture", "frame", "focus", "view"];

/// Calls that change nothing and take little time: those of viewers.
pub const READS: &[&str] = &[
    "gallery",
    "tutorial",
    "text",
    "complete",
    "hover",
    "integrators",
    "pick",
    "value",
    "explain",
    "outline",
    "part",
    "save",
];

fn step_back(session: &mut Session, undo: bool) -> Reply {
    let label = if undo { session.document.undo() } else { session.document.redo() };
    session.moving = false;
    session.order();
    json!({ "label": label }).into()
}

/// The arguments of a call.
#[derive(Clone, Copy)]
pub(crate) struct Args<'a>(pub(crate) &'a Json);

impl<'a> Args<'a> {
    fn get(self, key: &str) -> Option<&'a Json> {
        self.0.get(key).filter(|value| !value.is_null())
    }

    fn wrong(key: &str, expected: &str) -> CallError {
        CallError::new(format!("the argument \"{key}\" is missing or wrong; expected {expected}"))
    }

    pub(crate) fn text(self, key: &str) -> Result<&'a str, CallError> {
        self.optional_text(key)?.ok_or_else(|| Args::wrong(key, "text"))
    }

    pub(crate) fn optional_text(self, key: &str) -> Result<Option<&'a str>, CallError> {
        self.get(key).map(|value| value.as_str().ok_or_else(|| Args::wrong(key, "text"))).transpose()
    }

    pub(crate) fn number(self, key: &str) -> Result<f64, CallError> {
        self.optional_number(key)?.ok_or_else(|| Args::wrong(key, "a number"))
    }

    pub(crate) fn optional_number(self, key: &str) -> Result<Option<f64>, CallError> {
        self.get(key).map(|value| value.as_f64().ok_or_else(|| Args::wrong(key, "a number"))).transpose()
    }

    /// A whole number from 0.
    pub(crate) fn optional_index(self, key: &str) -> Result<Option<u32>, CallError> {
        let whole = |value: &Json| value.as_u64().and_then(|n| u32::try_from(n).ok());
        self.get(key)
            .map(|value| whole(value).ok_or_else(|| Args::wrong(key, "a whole number from 0")))
            .transpose()
    }

    pub(crate) fn flag(self, key: &str) -> Result<Option<bool>, CallError> {
        self.get(key)
            .map(|value| value.as_bool().ok_or_else(|| Args::wrong(key, "true or false")))
            .transpose()
    }

    pub(crate) fn list(self, key: &str) -> Result<&'a [Json], CallError> {
        self.get(key).and_then(Json::as_array).map(Vec::as_slice).ok_or_else(|| Args::wrong(key, "a list"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lists_name_calls_and_the_page_has_the_same() {
        let names: Vec<&str> = CALLS.iter().map(|(name, _)| *name).collect();
        assert!(REPLACES.iter().chain(READS).all(|name| names.contains(name)));
        assert!(!READS.iter().any(|name| REPLACES.contains(name)));
        let script = include_str!("../../page/engine.js");
        let start = script.find("const REPLACES = new Set([").unwrap();
        let list = &script[start..start + script[start..].find(']').unwrap()];
        let own: Vec<&str> = list.split('"').skip(1).step_by(2).collect();
        assert_eq!(own, REPLACES);
    }
}

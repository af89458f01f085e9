//! Walks the JSON text along the schema without building a tree: memory is proportional to the depth of the schema and
//! to the number of different faults.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};

use super::extensions::EXTENSIONS;
use super::schema::{Kind, LISTS, Object};
use crate::assets::printable;
use crate::gltf::report::Report;

/// Most faults that are kept; faults that differ in indices only count as one.
const MOST_FAULTS: usize = 64;

/// The faults that were found.
#[derive(Debug, Default)]
pub(super) struct Faults {
    /// By pattern, the first fault with its JSON pointer, and their number.
    found: BTreeMap<String, (String, u64)>,
}

impl Faults {
    /// Adds a fault; `pattern` is the same for faults that are listed once.
    pub(super) fn add(&mut self, pattern: String, pointer: &str, message: &str) {
        if self.found.len() >= MOST_FAULTS && !self.found.contains_key(&pattern) {
            return;
        }
        let first = || (format!("{}: {}", printable(pointer), printable(message)), 0);
        self.found.entry(pattern).or_insert_with(first).1 += 1;
    }

    /// Reports them.
    pub(super) fn report(self, report: &mut Report) {
        for (message, count) in self.found.into_values() {
            report.add_many(turner::schema::WarningKind::Doubtful, message, count);
        }
    }
}

/// A step of a JSON pointer.
#[derive(Debug)]
enum Step {
    Key(String),
    Number(usize),
}

/// The state of a walk.
pub(super) struct Walk<'a> {
    /// Lengths of the document's [`LISTS`].
    pub(super) lengths: [usize; LISTS],
    /// The declared extensions.
    pub(super) used: BTreeSet<&'a str>,
    pub(super) faults: Faults,
    path: Vec<Step>,
}

impl<'a> Walk<'a> {
    pub(super) fn new(lengths: [usize; LISTS], used: BTreeSet<&'a str>) -> Walk<'a> {
        Walk { lengths, used, faults: Faults::default(), path: Vec::new() }
    }

    fn pointer(&self, numbers: bool) -> String {
        let step = |step: &Step| match step {
            Step::Key(key) => format!("/{}", key.replace('~', "~0").replace('/', "~1")),
            Step::Number(n) if numbers => format!("/{n}"),
            Step::Number(_) => "/*".to_owned(),
        };
        self.path.iter().map(step).collect()
    }

    fn fault(&mut self, message: &str) {
        let (pattern, pointer) = (self.pointer(false), self.pointer(true));
        // Values in the message do not make a fault another one.
        let kind: String = message.chars().filter(|c| !c.is_ascii_digit()).collect();
        self.faults.add(format!("{pattern} {kind}"), &pointer, message);
    }

    fn fault_at(&mut self, key: &str, message: &str) {
        self.path.push(Step::Key(key.to_owned()));
        self.fault(message);
        self.path.pop();
    }

    fn number(&mut self, kind: &Kind, v: f64) {
        match *kind {
            Kind::Number(least, most) if v.is_nan() || v < least || v > most => {
                let to = if most < f64::MAX { format!(" to {most}") } else { " or more".to_owned() };
                let from =
                    if least == f64::MIN_POSITIVE { "above 0".to_owned() } else { format!("{least}{to}") };
                self.fault(&format!("is {v}; expected {from}"));
            }
            Kind::Whole { least, most, multiple }
                if v != v.floor() || v < least || v > most || v % multiple != 0.0 =>
            {
                let what = if multiple > 1.0 {
                    format!("a multiple of {multiple} from")
                } else {
                    "an integer from".to_owned()
                };
                self.fault(&format!("is {v}; expected {what} {least}"));
            }
            Kind::Index(list) => {
                let (name, length) = (list.name(), self.lengths.get(list as usize).copied().unwrap_or(0));
                if v < 0.0 || v >= length as f64 {
                    self.fault(&format!("refers to {name} {v}, but there are {length}"));
                }
            }
            Kind::Number(..) | Kind::Whole { .. } | Kind::Any => {}
            Kind::Bool | Kind::Text | Kind::Array { .. } | Kind::Object(_) | Kind::Map(_) => {
                self.mismatch(kind, "a number")
            }
        }
    }

    fn mismatch(&mut self, kind: &Kind, found: &str) {
        if !matches!(kind, Kind::Any) {
            self.fault(&format!("is {found}; expected {}", kind.name()));
        }
    }

    /// What the extension `name` of `parent` contains.
    fn extension(&mut self, name: &str, parent: &str) -> &'static Kind {
        if !self.used.contains(name) {
            self.fault("is an extension that is missing in extensionsUsed");
        }
        let mut known = EXTENSIONS.iter().filter(|(extension, ..)| *extension == name).peekable();
        if known.peek().is_none() {
            return &Kind::Any;
        }
        match known.find(|(_, of, _)| of.contains(&parent)) {
            Some((_, _, kind)) => kind,
            None => {
                self.fault(&format!("is not an extension of {parent}"));
                &Kind::Any
            }
        }
    }
}

/// A value of a kind that is walked.
struct Value<'w, 'a> {
    walk: &'w mut Walk<'a>,
    kind: &'static Kind,
}

/// The members of `extensions` of an object.
struct Extensions<'w, 'a> {
    walk: &'w mut Walk<'a>,
    parent: &'static str,
}

impl<'de> DeserializeSeed<'de> for Value<'_, '_> {
    type Value = ();
    fn deserialize<D: Deserializer<'de>>(self, from: D) -> Result<(), D::Error> {
        match self.kind {
            // Without the limit of recursion that other kinds have.
            Kind::Any => from.deserialize_ignored_any(IgnoredAny).map(|_| ()),
            _ => from.deserialize_any(self),
        }
    }
}

impl<'de> Visitor<'de> for Value<'_, '_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_bool<E: Error>(self, _: bool) -> Result<(), E> {
        if !matches!(self.kind, Kind::Bool) {
            self.walk.mismatch(self.kind, "a boolean");
        }
        Ok(())
    }

    fn visit_u64<E: Error>(self, v: u64) -> Result<(), E> {
        self.walk.number(self.kind, v as f64);
        Ok(())
    }

    fn visit_i64<E: Error>(self, v: i64) -> Result<(), E> {
        self.walk.number(self.kind, v as f64);
        Ok(())
    }

    fn visit_f64<E: Error>(self, v: f64) -> Result<(), E> {
        self.walk.number(self.kind, v);
        Ok(())
    }

    fn visit_str<E: Error>(self, _: &str) -> Result<(), E> {
        if !matches!(self.kind, Kind::Text) {
            self.walk.mismatch(self.kind, "text");
        }
        Ok(())
    }

    fn visit_unit<E: Error>(self) -> Result<(), E> {
        self.walk.mismatch(self.kind, "null");
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<(), A::Error> {
        let Kind::Array { of, least, most, unique } = self.kind else {
            self.walk.mismatch(self.kind, "an array");
            while seq.next_element::<IgnoredAny>()?.is_some() {}
            return Ok(());
        };
        let mut count = 0;
        let mut seen = BTreeSet::new();
        loop {
            self.walk.path.push(Step::Number(count));
            let found = if *unique {
                let element: Option<serde_json::Value> = seq.next_element()?;
                element.map(|element| self.walk.unique(of, &element, &mut seen))
            } else {
                seq.next_element_seed(Value { walk: self.walk, kind: of })?
            };
            self.walk.path.pop();
            if found.is_none() {
                break;
            }
            count += 1;
        }
        if count < *least || count > *most {
            let expected = match (least, most) {
                (least, most) if least == most => format!("{least}"),
                (least, _) => format!("at least {least}"),
            };
            self.walk.fault(&format!("has {count} elements; expected {expected}"));
        }
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        let walk = self.walk;
        let object = match self.kind {
            Kind::Object(object) => object,
            Kind::Map(of) => {
                let mut count = 0;
                while let Some(key) = map.next_key::<String>()? {
                    walk.path.push(Step::Key(key));
                    map.next_value_seed(Value { walk: &mut *walk, kind: of })?;
                    walk.path.pop();
                    count += 1;
                }
                if count == 0 {
                    walk.fault("is empty; expected at least one member");
                }
                return Ok(());
            }
            kind => {
                walk.mismatch(kind, "an object");
                while map.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
                return Ok(());
            }
        };
        let mut present = BTreeSet::new();
        while let Some(key) = map.next_key::<String>()? {
            if key == "extensions" {
                walk.path.push(Step::Key(key));
                map.next_value_seed(Extensions { walk: &mut *walk, parent: object.name })?;
                walk.path.pop();
                continue;
            }
            let Some((name, kind)) = object.fields.iter().find(|(name, _)| *name == key) else {
                map.next_value::<IgnoredAny>()?;
                continue;
            };
            present.insert(*name);
            walk.path.push(Step::Key(key));
            map.next_value_seed(Value { walk: &mut *walk, kind })?;
            walk.path.pop();
        }
        walk.members(object, &present);
        Ok(())
    }
}

impl Walk<'_> {
    /// Checks an element of an array of different texts or indices.
    fn unique(&mut self, of: &Kind, element: &serde_json::Value, seen: &mut BTreeSet<String>) {
        match element {
            serde_json::Value::Number(n) => self.number(of, n.as_f64().unwrap_or(-1.0)),
            serde_json::Value::String(_) if matches!(of, Kind::Text) => {}
            _ => self.mismatch(of, "something else"),
        }
        if !seen.insert(element.to_string()) {
            self.fault("is there twice");
        }
    }

    /// Checks which members an object has.
    fn members(&mut self, object: &Object, present: &BTreeSet<&'static str>) {
        for required in object.required {
            if !present.contains(required) {
                self.fault_at(required, "is missing; expected one");
            }
        }
        for (member, needs) in object.needs {
            if present.contains(member) && !present.contains(needs) {
                self.fault_at(member, &format!("needs {needs}, which is missing"));
            }
        }
        let given = object.one_of.iter().filter(|name| present.contains(*name)).count();
        if !object.one_of.is_empty() && given != 1 {
            self.fault(&format!("has {given} of {}; expected one", object.one_of.join(", ")));
        }
    }
}

impl<'de> DeserializeSeed<'de> for Extensions<'_, '_> {
    type Value = ();
    fn deserialize<D: Deserializer<'de>>(self, from: D) -> Result<(), D::Error> {
        from.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for Extensions<'_, '_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object with extensions")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        while let Some(name) = map.next_key::<String>()? {
            self.walk.path.push(Step::Key(name.clone()));
            let kind = self.walk.extension(&name, self.parent);
            map.next_value_seed(Value { walk: &mut *self.walk, kind })?;
            self.walk.path.pop();
        }
        Ok(())
    }
}

/// Walks a JSON text that has been parsed before.
pub(super) fn walk(text: &[u8], state: &mut Walk<'_>, root: &'static Kind) {
    let mut from = serde_json::Deserializer::from_slice(text);
    // Text that is not JSON was refused before; what the walk does not follow, it does not check.
    let _ = Value { walk: state, kind: root }.deserialize(&mut from);
}

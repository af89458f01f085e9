//! The contents of an element: named values and child objects. The importer asks for them by name;
//! [`Object::finish`] reports those that nobody asked for, with the nearest known name.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::rc::Rc;

use turner::math::{DAffine3, DVec3};
use turner::schema::ErrorCode;

use super::document::{Document, Node};
use super::transform;
use crate::assets::{nearest, printable};
use crate::scene_import::Place;
use crate::scene_import::report::{Fault, Report};

/// The tags of objects, which have a `type`.
pub(super) const OBJECTS: &[&str] = &[
    "bsdf",
    "texture",
    "emitter",
    "shape",
    "sensor",
    "film",
    "sampler",
    "rfilter",
    "integrator",
    "medium",
    "phase",
    "volume",
    "subsurface",
    "spectrum",
];

/// An object of the scene: an element with its contents.
pub(super) struct Object {
    pub(super) document: Rc<Document>,
    /// Index of the element.
    pub(super) node: usize,
    pub(super) place: Place,
    /// `bsdf`, `shape`, …
    pub(super) tag: String,
    /// Its `type`.
    pub(super) kind: String,
    asked: RefCell<BTreeSet<&'static str>>,
    used: RefCell<BTreeSet<usize>>,
}

impl Object {
    /// The object of an element; references are resolved.
    pub(super) fn new(document: &Rc<Document>, node: usize) -> Result<Object, Fault> {
        let node = document.resolve(node)?;
        let document = Rc::clone(document);
        let internal = || Fault::new(ErrorCode::Internal, "a missing element");
        let element = document.node(node).ok_or_else(internal)?;
        let (place, tag) = (element.place, element.tag.clone());
        let kind = element.attribute("type").unwrap_or_default().to_owned();
        Ok(Object { document, node, place, tag, kind, asked: RefCell::default(), used: RefCell::default() })
    }

    /// `the bsdf "diffuse"`.
    pub(super) fn title(&self) -> String {
        format!("the {} \"{}\"", printable(&self.tag), printable(&self.kind))
    }

    /// The `id`, if there is one.
    pub(super) fn id(&self) -> Option<String> {
        self.document.node(self.node)?.attribute("id").map(str::to_owned)
    }

    /// The elements in it, with their indices.
    fn children(&self) -> impl Iterator<Item = (usize, &Node)> {
        let list = self.document.node(self.node).map_or(&[][..], |n| &n.children);
        list.iter().filter_map(|c| Some((*c, self.document.node(*c)?)))
    }

    /// The element of a name. Of several the last one counts.
    pub(super) fn find(&self, name: &'static str) -> Option<(usize, &Node)> {
        self.asked.borrow_mut().insert(name);
        let found = self.children().filter(|(_, n)| n.attribute("name") == Some(name)).last()?;
        for (i, n) in self.children() {
            if n.attribute("name") == Some(name) {
                self.used.borrow_mut().insert(i);
            }
        }
        Some(found)
    }

    /// Whether there is an element of this name. This does not count as use.
    pub(super) fn has(&self, name: &str) -> bool {
        self.children().any(|(_, n)| n.attribute("name") == Some(name))
    }

    /// The position of an element, or of the object.
    pub(super) fn place_of(&self, name: &str) -> Place {
        self.children().find(|(_, n)| n.attribute("name") == Some(name)).map_or(self.place, |(_, n)| n.place)
    }

    /// Accepts names that have no effect in Turner.
    pub(super) fn pass(&self, names: &[&'static str]) {
        for name in names {
            self.find(name);
        }
    }

    /// Accepts all contents: the object itself is reported.
    pub(super) fn pass_all(&self) {
        self.used.borrow_mut().extend(self.children().map(|(i, _)| i).collect::<Vec<_>>());
    }

    /// The objects in it with one of these tags, in order and whatever their names; references are resolved.
    pub(super) fn objects(&self, tags: &[&str]) -> Result<Vec<usize>, Fault> {
        let mut out = Vec::new();
        for (i, node) in self.children() {
            if node.tag != "ref" && !tags.contains(&node.tag.as_str()) {
                continue;
            }
            let target = self.document.resolve(i)?;
            if self.document.node(target).is_some_and(|n| tags.contains(&n.tag.as_str())) {
                self.used.borrow_mut().insert(i);
                out.push(target);
            }
        }
        Ok(out)
    }

    /// The first object with this tag.
    pub(super) fn object(&self, tag: &str) -> Result<Option<Object>, Fault> {
        match self.objects(&[tag])?.first() {
            Some(node) => Object::new(&self.document, *node).map(Some),
            None => Ok(None),
        }
    }

    /// All objects in it.
    pub(super) fn all(&self) -> Result<Vec<Object>, Fault> {
        self.objects(OBJECTS)?.into_iter().map(|node| Object::new(&self.document, node)).collect()
    }

    fn value(&self, name: &'static str, tags: &[&str]) -> Result<Option<(&str, Place)>, Fault> {
        let Some((_, node)) = self.find(name) else { return Ok(None) };
        if !tags.contains(&node.tag.as_str()) {
            let message =
                format!("{} is written as <{}>; expected <{}>", name, printable(&node.tag), tags[0]);
            return Err(Fault::at(node.place, ErrorCode::WrongType, message));
        }
        match node.attribute("value") {
            Some(value) => Ok(Some((value, node.place))),
            None => Err(Fault::at(node.place, ErrorCode::MissingKey, format!("{name} has no value"))),
        }
    }

    /// A number.
    pub(super) fn float(&self, name: &'static str) -> Result<Option<f64>, Fault> {
        let Some((text, place)) = self.value(name, &["float", "integer", "spectrum", "rgb"])? else {
            return Ok(None);
        };
        number(text).map(Some).ok_or_else(|| bad_number(name, text, place))
    }

    /// An integer.
    pub(super) fn integer(&self, name: &'static str) -> Result<Option<i64>, Fault> {
        let Some((text, place)) = self.value(name, &["integer", "float"])? else { return Ok(None) };
        let parsed = text.trim().parse().ok().or_else(|| number(text).map(|v| v as i64));
        parsed.map(Some).ok_or_else(|| bad_number(name, text, place))
    }

    /// True or false.
    pub(super) fn boolean(&self, name: &'static str) -> Result<Option<bool>, Fault> {
        let Some((text, place)) = self.value(name, &["boolean"])? else { return Ok(None) };
        match text.trim() {
            "true" | "True" => Ok(Some(true)),
            "false" | "False" => Ok(Some(false)),
            other => {
                let message = format!("{name} is \"{}\"; expected true or false", printable(other));
                Err(Fault::at(place, ErrorCode::WrongType, message))
            }
        }
    }

    /// A string.
    pub(super) fn string(&self, name: &'static str) -> Result<Option<&str>, Fault> {
        Ok(self.value(name, &["string"])?.map(|(text, _)| text))
    }

    /// One of `words`. Any other word is reported, and the first of the list replaces it.
    pub(super) fn word(
        &self,
        name: &'static str,
        words: &'static [&'static str],
        report: &mut Report,
    ) -> Result<&'static str, Fault> {
        let first = words.first().copied().unwrap_or_default();
        let Some(found) = self.string(name)? else { return Ok(first) };
        if let Some(word) = words.iter().find(|w| **w == found) {
            return Ok(word);
        }
        let near = nearest(found, words.iter().copied());
        let near = near.map_or_else(String::new, |n| format!("; did you mean \"{n}\"?"));
        let message = format!("unknown {name} \"{}\"{near}: \"{first}\" replaces it", printable(found));
        report.ignored(self.place_of(name), message);
        Ok(first)
    }

    /// A point or a direction: `value="x, y, z"`, or x, y and z.
    pub(super) fn vector(&self, name: &'static str) -> Result<Option<DVec3>, Fault> {
        let Some((_, node)) = self.find(name) else { return Ok(None) };
        if !matches!(node.tag.as_str(), "point" | "vector") {
            let message = format!("{name} is written as <{}>; expected <vector>", printable(&node.tag));
            return Err(Fault::at(node.place, ErrorCode::WrongType, message));
        }
        transform::vector(node, 0.0).map(Some)
    }

    /// A transform; the identity if there is none.
    pub(super) fn transform(&self, name: &'static str) -> Result<DAffine3, Fault> {
        let Some((_, node)) = self.find(name) else { return Ok(DAffine3::IDENTITY) };
        if node.tag != "transform" {
            let message = format!("{name} is written as <{}>; expected <transform>", printable(&node.tag));
            return Err(Fault::at(node.place, ErrorCode::WrongType, message));
        }
        transform::of(&self.document, node)
    }

    /// Reports everything that nobody asked for.
    pub(super) fn finish(&self, report: &mut Report) {
        let (used, asked) = (self.used.borrow(), self.asked.borrow());
        for (i, node) in self.children() {
            if used.contains(&i) {
                continue;
            }
            let message = match node.attribute("name") {
                Some(name) => {
                    let near = nearest(name, asked.iter().copied());
                    let near = near.map_or_else(String::new, |n| format!("; did you mean \"{n}\"?"));
                    format!("{}: unknown parameter \"{}\"{near}", self.title(), printable(name))
                }
                None => {
                    let kind = node.attribute("type").or(node.attribute("id")).unwrap_or_default();
                    let shown = format!("<{} \"{}\">", printable(&node.tag), printable(kind));
                    format!("{}: unexpected {shown}", self.title())
                }
            };
            report.ignored(node.place, message);
        }
    }
}

fn bad_number(name: &str, text: &str, place: Place) -> Fault {
    let message = format!("{name} is \"{}\"; expected a number", printable(text));
    Fault::at(place, ErrorCode::WrongType, message)
}

/// A finite number.
pub(super) fn number(text: &str) -> Option<f64> {
    text.trim().trim_end_matches('f').parse().ok().filter(|v: &f64| v.is_finite())
}

/// Numbers separated by whitespace and commas, at most `most`.
pub(super) fn numbers(text: &str, most: usize) -> Option<Vec<f64>> {
    let mut out = Vec::new();
    for word in text.split(|c: char| c.is_whitespace() || c == ',').filter(|w| !w.is_empty()) {
        if out.len() >= most {
            return None;
        }
        out.push(number(word)?);
    }
    Some(out)
}

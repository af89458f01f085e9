//! Parameter lists such as `"float fov" [ 45 ]`. The importer asks for parameters by name; [`Params::finish`]
//! reports those that nobody asked for, with the nearest known name.

use std::cell::{Cell, RefCell};

use turner::math::DVec3;
use turner::schema::ErrorCode;

use super::lexer::{Lexer, Next};
use super::report::{Fault, Report};
use super::source::Place;
use crate::assets::{nearest, printable};
use crate::scene_import::push;

/// Most elements of one list: 2^30.
const MAX_LIST: usize = 1 << 30;
/// Most parameters of one list.
const MAX_PARAMS: usize = 4096;

/// The types of parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Type {
    Bool,
    Integer,
    Float,
    Point2,
    Vector2,
    Point3,
    Vector3,
    Normal,
    String,
    Texture,
    Rgb,
    Blackbody,
    Spectrum,
}

/// The names of all types; the last ones are pbrt-v3's.
const TYPES: &[(&str, Type)] = &[
    ("bool", Type::Bool),
    ("integer", Type::Integer),
    ("float", Type::Float),
    ("point2", Type::Point2),
    ("vector2", Type::Vector2),
    ("point3", Type::Point3),
    ("vector3", Type::Vector3),
    ("normal3", Type::Normal),
    ("normal", Type::Normal),
    ("string", Type::String),
    ("texture", Type::Texture),
    ("rgb", Type::Rgb),
    ("blackbody", Type::Blackbody),
    ("spectrum", Type::Spectrum),
    ("point", Type::Point3),
    ("vector", Type::Vector3),
    ("color", Type::Rgb),
];

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Numbers(Vec<f64>),
    Integers(Vec<i32>),
    Pairs(Vec<[f32; 2]>),
    Triples(Vec<[f32; 3]>),
    Strings(Vec<String>),
    Bools(Vec<bool>),
}

impl Value {
    /// Approximate size: numbers and letters, plus a constant.
    pub(super) fn cost(&self) -> usize {
        let letters = match self {
            Value::Strings(v) => v.iter().map(String::len).sum(),
            _ => 0,
        };
        8 + 3 * self.len() + letters
    }

    fn len(&self) -> usize {
        match self {
            Value::Numbers(v) => v.len(),
            Value::Integers(v) => v.len(),
            Value::Pairs(v) => v.len(),
            Value::Triples(v) => v.len(),
            Value::Strings(v) => v.len(),
            Value::Bools(v) => v.len(),
        }
    }
}

/// One parameter.
#[derive(Clone, Debug)]
pub(super) struct Param {
    pub(super) kind: Type,
    pub(super) name: String,
    pub(super) value: Value,
    pub(super) place: Place,
    used: Cell<bool>,
}

/// The parameters of the directive at `place`.
#[derive(Clone, Debug, Default)]
pub(super) struct Params {
    pub(super) place: Place,
    list: Vec<Param>,
    /// Names that were asked for.
    asked: RefCell<Vec<&'static str>>,
    /// Parameters that have another type than the one asked for, by index, with the expected type.
    mistyped: RefCell<Vec<(usize, &'static str)>>,
}

impl Params {
    /// Reads all parameters that follow.
    pub(super) fn read(lexer: &mut Lexer<'_>, place: Place) -> Result<Params, Fault> {
        let mut params = Params { place, ..Params::default() };
        while lexer.next()? == Next::Quote {
            let place = lexer.place();
            let declared = lexer.string()?;
            let mut words = declared.split_ascii_whitespace();
            let (Some(kind), Some(name), None) = (words.next(), words.next(), words.next()) else {
                let message =
                    format!("expected \"type name\" of a parameter, found \"{}\"", printable(&declared));
                return Err(Fault::at(place, ErrorCode::Syntax, message).help("as in \"float fov\" [ 45 ]"));
            };
            let Some((_, kind)) = TYPES.iter().find(|(word, _)| *word == kind) else {
                let all = TYPES.iter().map(|(word, _)| *word);
                let message =
                    format!("unknown type \"{}\" of the parameter {}", printable(kind), printable(name));
                let help = match nearest(kind, all.clone()) {
                    Some(near) => format!("did you mean \"{near}\"?"),
                    None => format!("types are {}", all.collect::<Vec<_>>().join(", ")),
                };
                return Err(Fault::at(place, ErrorCode::UnknownName, message).help(help));
            };
            let value = read_value(lexer, *kind, name)?;
            let param = Param { kind: *kind, name: name.to_owned(), value, place, used: Cell::new(false) };
            if params.list.len() >= MAX_PARAMS {
                let message = format!("more than {MAX_PARAMS} parameters");
                return Err(Fault::at(place, ErrorCode::TooLarge, message));
            }
            params.list.push(param);
        }
        Ok(params)
    }

    /// Adds default parameters; those of the list win.
    pub(super) fn with_defaults(mut self, defaults: &[Param]) -> Params {
        for d in defaults {
            if !self.list.iter().any(|p| p.name == d.name) {
                // Defaults apply to objects of many types, so that an unused one is no mistake.
                self.list.push(Param { used: Cell::new(true), ..d.clone() });
            }
        }
        self
    }

    /// Of parameters with the same name keeps the last, as pbrt-v3 does.
    pub(super) fn keep_last(&mut self) {
        let mut seen = std::collections::BTreeSet::new();
        let mut kept = std::mem::take(&mut self.list);
        kept.reverse();
        kept.retain(|p| seen.insert(p.name.clone()));
        kept.reverse();
        self.list = kept;
    }

    /// All parameters.
    pub(super) fn into_list(self) -> Vec<Param> {
        self.list
    }

    fn find(&self, name: &'static str, kinds: &[Type], expected: &'static str) -> Option<&Param> {
        let mut asked = self.asked.borrow_mut();
        if !asked.contains(&name) {
            asked.push(name);
        }
        let (i, param) = self.list.iter().enumerate().find(|(_, p)| p.name == name)?;
        param.used.set(true);
        if !kinds.contains(&param.kind) || param.value.len() == 0 {
            let mut mistyped = self.mistyped.borrow_mut();
            if !mistyped.iter().any(|(j, _)| *j == i) {
                mistyped.push((i, expected));
            }
            return None;
        }
        // Some callers try one type after the other.
        self.mistyped.borrow_mut().retain(|(j, _)| *j != i);
        Some(param)
    }

    /// Whether there is a parameter of this name. This does not count as use.
    pub(super) fn has(&self, name: &str) -> bool {
        self.list.iter().any(|p| p.name == name)
    }

    /// The names of all textures. This does not count as use.
    pub(super) fn texture_names(&self) -> impl Iterator<Item = &str> {
        self.list.iter().filter(|p| p.kind == Type::Texture).filter_map(|p| match &p.value {
            Value::Strings(v) => v.first().map(String::as_str),
            _ => None,
        })
    }

    /// The strings of a parameter. This does not count as use.
    pub(super) fn unread_strings(&self, name: &str) -> &[String] {
        match self.list.iter().find(|p| p.name == name).map(|p| &p.value) {
            Some(Value::Strings(v)) => v,
            _ => &[],
        }
    }

    /// The position of a parameter, or of the list.
    pub(super) fn place_of(&self, name: &str) -> Place {
        self.list.iter().find(|p| p.name == name).map_or(self.place, |p| p.place)
    }

    /// Whether there is a parameter of this name and type.
    pub(super) fn is(&self, name: &str, kind: Type) -> bool {
        self.list.iter().any(|p| p.name == name && p.kind == kind)
    }

    pub(super) fn float(&self, name: &'static str) -> Option<f64> {
        match &self.find(name, &[Type::Float, Type::Integer], "float")?.value {
            Value::Numbers(v) => v.first().copied(),
            Value::Integers(v) => v.first().map(|i| f64::from(*i)),
            _ => None,
        }
    }

    pub(super) fn integer(&self, name: &'static str) -> Option<i32> {
        match &self.find(name, &[Type::Integer], "integer")?.value {
            Value::Integers(v) => v.first().copied(),
            _ => None,
        }
    }

    pub(super) fn bool(&self, name: &'static str) -> Option<bool> {
        match &self.find(name, &[Type::Bool], "bool")?.value {
            Value::Bools(v) => v.first().copied(),
            _ => None,
        }
    }

    pub(super) fn string(&self, name: &'static str) -> Option<&str> {
        match &self.find(name, &[Type::String], "string")?.value {
            Value::Strings(v) => v.first().map(String::as_str),
            _ => None,
        }
    }

    pub(super) fn strings(&self, name: &'static str) -> &[String] {
        match self.find(name, &[Type::String], "string").map(|p| &p.value) {
            Some(Value::Strings(v)) => v,
            _ => &[],
        }
    }

    /// The name of a texture.
    pub(super) fn texture(&self, name: &'static str) -> Option<&str> {
        match &self.find(name, &[Type::Texture], "texture")?.value {
            Value::Strings(v) => v.first().map(String::as_str),
            _ => None,
        }
    }

    pub(super) fn floats(&self, name: &'static str) -> &[f64] {
        match self.find(name, &[Type::Float], "float").map(|p| &p.value) {
            Some(Value::Numbers(v)) => v,
            _ => &[],
        }
    }

    /// The numbers of a list of colours, three for each.
    pub(super) fn rgbs(&self, name: &'static str) -> &[f64] {
        match self.find(name, &[Type::Rgb], "rgb").map(|p| &p.value) {
            Some(Value::Numbers(v)) => v,
            _ => &[],
        }
    }

    pub(super) fn integers(&self, name: &'static str) -> &[i32] {
        match self.find(name, &[Type::Integer], "integer").map(|p| &p.value) {
            Some(Value::Integers(v)) => v,
            _ => &[],
        }
    }

    /// A 3D point or vector.
    pub(super) fn vector(&self, name: &'static str) -> Option<DVec3> {
        match &self.find(name, &[Type::Point3, Type::Vector3, Type::Normal], "point3")?.value {
            Value::Triples(v) => v.first().map(|v| DVec3::from(v.map(f64::from))),
            _ => None,
        }
    }

    /// Points, vectors or normals; removes them from the list.
    pub(super) fn take_triples(&mut self, name: &'static str) -> Vec<[f32; 3]> {
        self.find(name, &[Type::Point3, Type::Vector3, Type::Normal], "point3");
        match self.list.iter_mut().find(|p| p.name == name).map(|p| &mut p.value) {
            Some(Value::Triples(v)) => std::mem::take(v),
            _ => Vec::new(),
        }
    }

    /// 2D points, in pbrt-v3 also written as a list of numbers; removes them from the list.
    pub(super) fn take_pairs(&mut self, name: &'static str) -> Vec<[f32; 2]> {
        self.find(name, &[Type::Point2, Type::Vector2, Type::Float], "point2");
        match self.list.iter_mut().find(|p| p.name == name).map(|p| &mut p.value) {
            Some(Value::Pairs(v)) => std::mem::take(v),
            Some(Value::Numbers(v)) => {
                let numbers = std::mem::take(v);
                numbers.as_chunks().0.iter().map(|[u, v]| [*u as f32, *v as f32]).collect()
            }
            _ => Vec::new(),
        }
    }

    /// A parameter that is a colour or a spectrum: `rgb`, `blackbody` or `spectrum`.
    pub(super) fn spectrum(&self, name: &'static str) -> Option<&Param> {
        self.find(name, &[Type::Rgb, Type::Blackbody, Type::Spectrum], "rgb or spectrum")
    }

    /// Accepts parameters that do not change the picture of a converged renderer.
    pub(super) fn pass(&self, names: &[&'static str]) {
        for name in names {
            self.asked.borrow_mut().push(name);
            self.list.iter().filter(|p| p.name == *name).for_each(|p| p.used.set(true));
        }
    }

    /// Reports parameters that should change the picture but are not supported.
    pub(super) fn refuse(&self, names: &[&'static str], what: &str, report: &mut Report) {
        for name in names {
            self.asked.borrow_mut().push(name);
            for p in self.list.iter().filter(|p| p.name == *name) {
                p.used.set(true);
                report.ignored(p.place, format!("{name} of {what} is not supported"));
            }
        }
    }

    /// Reports unknown parameters and those of a wrong type; `what` is their owner, e.g. `the shape "sphere"`.
    pub(super) fn finish(&self, what: &str, report: &mut Report) {
        for (i, expected) in self.mistyped.borrow().iter() {
            let Some(p) = self.list.get(*i) else { continue };
            if p.value.len() == 0 {
                report.doubtful(
                    p.place,
                    format!("the parameter {} of {what} has no value", printable(&p.name)),
                );
                continue;
            }
            let found = TYPES.iter().find(|(_, t)| *t == p.kind).map_or("", |(word, _)| word);
            report.ignored(
                p.place,
                format!("{} of {what} is of type {found}; expected {expected}", printable(&p.name)),
            );
        }
        let asked = self.asked.borrow();
        for p in self.list.iter().filter(|p| !p.used.get()) {
            if asked.iter().any(|name| *name == p.name) {
                let message = format!("{} of {what} is given twice: the first counts", printable(&p.name));
                report.doubtful(p.place, message);
                continue;
            }
            let near = nearest(&p.name, asked.iter().copied())
                .map_or_else(String::new, |n| format!("; did you mean {n}?"));
            report.ignored(p.place, format!("unknown parameter {} of {what}{near}", printable(&p.name)));
        }
    }
}

/// Reads the value of a parameter: one element, or several in brackets.
fn read_value(lexer: &mut Lexer<'_>, kind: Type, name: &str) -> Result<Value, Fault> {
    let mut next = lexer.next()?;
    let bracketed = next == Next::Open;
    if bracketed {
        lexer.bracket();
        match kind {
            Type::Point3 | Type::Vector3 | Type::Normal => return lexer.groups(MAX_LIST).map(Value::Triples),
            Type::Point2 | Type::Vector2 => return lexer.groups(MAX_LIST).map(Value::Pairs),
            _ => next = lexer.next()?,
        }
    }
    let mut value = match (kind, next) {
        (_, Next::Quote) => Value::Strings(Vec::new()),
        (Type::Integer, _) => Value::Integers(Vec::new()),
        (Type::Bool, _) => Value::Bools(Vec::new()),
        _ => Value::Numbers(Vec::new()),
    };
    loop {
        match (next, &mut value) {
            (Next::Close, _) if bracketed => {
                lexer.bracket();
                break;
            }
            (Next::Quote, Value::Strings(list)) => {
                let text = lexer.string()?;
                push(list, text, 1 << 20).map_err(|p| Fault::at(lexer.place(), ErrorCode::TooLarge, p))?;
            }
            (Next::Word, Value::Numbers(list)) => {
                let number = lexer.number()?;
                push(list, number, MAX_LIST / 2)
                    .map_err(|p| Fault::at(lexer.place(), ErrorCode::TooLarge, p))?;
                if bracketed {
                    lexer.numbers(list, MAX_LIST / 2)?;
                }
            }
            (Next::Word, Value::Integers(list)) => {
                let number = lexer.integer()?;
                push(list, number, MAX_LIST).map_err(|p| Fault::at(lexer.place(), ErrorCode::TooLarge, p))?;
                if bracketed {
                    lexer.integers(list, MAX_LIST)?;
                }
            }
            (Next::Word, Value::Bools(list)) => {
                let place = lexer.place();
                list.push(match lexer.word()?.as_str() {
                    "true" => true,
                    "false" => false,
                    other => {
                        let message = format!("expected true or false, found {}", printable(other));
                        return Err(Fault::at(place, ErrorCode::WrongType, message));
                    }
                });
            }
            (Next::Open, _) => {
                let place = lexer.place();
                return Err(Fault::at(place, ErrorCode::Syntax, "expected a value or ], found ["));
            }
            (Next::End, _) => {
                let message = format!("the file ends within the parameter {}", printable(name));
                return Err(Fault::at(lexer.place(), ErrorCode::Syntax, message).help("is a ] missing?"));
            }
            _ => {
                let message = format!("values of the parameter {} are of different types", printable(name));
                return Err(Fault::at(lexer.place(), ErrorCode::WrongType, message));
            }
        }
        if !bracketed {
            break;
        }
        next = lexer.next()?;
    }
    checked(value, kind, name, lexer)
}

/// Checks a value against its type. Old files write `"bool b" "true"`.
fn checked(value: Value, kind: Type, name: &str, lexer: &mut Lexer<'_>) -> Result<Value, Fault> {
    match (value, kind) {
        (Value::Strings(list), Type::Bool) => {
            let bools: Option<Vec<bool>> = list
                .iter()
                .map(|s| match s.as_str() {
                    "true" => Some(true),
                    "false" => Some(false),
                    _ => None,
                })
                .collect();
            bools.map(Value::Bools).ok_or_else(|| wrong(name, "true or false", lexer))
        }
        (value @ Value::Strings(_), Type::String | Type::Texture | Type::Spectrum) => Ok(value),
        (Value::Strings(_), _) => Err(wrong(name, "numbers, not strings", lexer)),
        (_, Type::String | Type::Texture) => Err(wrong(name, "a string in quotes", lexer)),
        // A single point needs brackets; a single number does not.
        (Value::Numbers(_), Type::Point2 | Type::Vector2 | Type::Point3 | Type::Vector3 | Type::Normal) => {
            Err(wrong(name, "[ x y … ] in brackets", lexer))
        }
        (Value::Numbers(v), Type::Rgb) if v.len() % 3 != 0 => {
            Err(wrong(name, &format!("three numbers, found {}", v.len()), lexer))
        }
        (value, _) => Ok(value),
    }
}

fn wrong(name: &str, expected: &str, lexer: &mut Lexer<'_>) -> Fault {
    let message = format!("the parameter {}: expected {expected}", printable(name));
    Fault::at(lexer.place(), ErrorCode::WrongType, message)
}

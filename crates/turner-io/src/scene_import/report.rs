//! Errors and remarks of an import, with their positions in the file.

use std::collections::BTreeMap;

use turner::schema::{ErrorCode, Remedy, SceneError, Warning, WarningKind};

use crate::assets::{nearest, printable};

/// A position in a file: line and column in characters, from 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Place {
    /// Index of the file among those read.
    pub(crate) file: u32,
    pub(crate) line: u32,
    pub(crate) column: u32,
}

/// Most different remarks; further ones are only counted.
const MAX_REMARKS: usize = 200;

/// Why an import fails.
#[derive(Debug)]
pub(crate) struct Fault {
    place: Option<Place>,
    code: ErrorCode,
    problem: String,
    help: Option<String>,
    remedy: Option<Remedy>,
}

impl Fault {
    pub(crate) fn new(code: ErrorCode, problem: impl Into<String>) -> Fault {
        Fault { place: None, code, problem: problem.into(), help: None, remedy: None }
    }

    pub(crate) fn at(place: Place, code: ErrorCode, problem: impl Into<String>) -> Fault {
        Fault { place: Some(place), ..Fault::new(code, problem) }
    }

    pub(crate) fn help(mut self, help: impl Into<String>) -> Fault {
        self.help = Some(help.into());
        self
    }

    pub(crate) fn remedy(mut self, remedy: Remedy) -> Fault {
        self.remedy = Some(remedy);
        self
    }

    pub(crate) fn code(mut self, code: ErrorCode) -> Fault {
        self.code = code;
        self
    }

    /// An error of another part, at a position of this file.
    pub(crate) fn from_scene(place: Place, error: SceneError) -> Fault {
        Fault { place: Some(place), ..error.into() }
    }

    pub(crate) fn or_at(mut self, place: Place) -> Fault {
        self.place.get_or_insert(place);
        self
    }

    /// As an error of the scene; `files` are the names of the files read.
    pub(crate) fn into_error(self, files: &[String]) -> SceneError {
        let message = match self.place {
            Some(place) => format!("{}: {}", shown(place, files), self.problem),
            None => match files.first() {
                Some(file) => format!("{}: {}", printable(file), self.problem),
                None => self.problem,
            },
        };
        let error = SceneError::new(self.code, message).remedy(self.remedy);
        match self.help {
            Some(help) => error.help(help),
            None => error,
        }
    }
}

impl From<SceneError> for Fault {
    /// Without its position.
    fn from(error: SceneError) -> Fault {
        let SceneError { code, message, help, remedy, .. } = error;
        Fault { place: None, code, problem: message, help, remedy: remedy.map(|r| *r) }
    }
}

/// The error for an unknown name, with the nearest known one.
pub(crate) fn unknown(what: &str, name: &str, names: &[&str]) -> Fault {
    let message = format!("unknown {what} \"{}\"", printable(name));
    let fault = Fault::new(ErrorCode::UnknownName, message);
    match nearest(name, names.iter().copied()) {
        Some(near) => fault.help(format!("did you mean \"{}\"?", printable(near))),
        None if names.is_empty() => fault.help(format!("there is no {what} before this position")),
        None => {
            let shown: Vec<String> = names.iter().take(12).map(|n| printable(n)).collect();
            let more = if names.len() > 12 { ", …" } else { "" };
            fault.help(format!("there are {}{more}", shown.join(", ")))
        }
    }
}

/// `file:line:column`, or `file` for a format without lines.
fn shown(place: Place, files: &[String]) -> String {
    let name = files.get(place.file as usize).map_or_else(|| "?".to_owned(), |f| printable(f));
    if place.line == 0 {
        return name;
    }
    format!("{name}:{}:{}", place.line, place.column)
}

/// Remarks without repetition, each with its first position and its count.
#[derive(Debug, Default)]
pub(crate) struct Report {
    remarks: BTreeMap<(WarningKind, String), (usize, Option<Place>, u64)>,
    beyond: u64,
}

impl Report {
    fn add(&mut self, kind: WarningKind, place: Option<Place>, message: String) {
        let order = self.remarks.len();
        if order >= MAX_REMARKS && !self.remarks.contains_key(&(kind, message.clone())) {
            self.beyond += 1;
            return;
        }
        self.remarks.entry((kind, message)).or_insert((order, place, 0)).2 += 1;
    }

    /// Something that should affect the picture but is ignored.
    pub(crate) fn ignored(&mut self, place: Place, message: impl Into<String>) {
        self.add(WarningKind::Ignored, Some(place), message.into());
    }

    /// The same without a position.
    pub(crate) fn ignored_anywhere(&mut self, message: impl Into<String>) {
        self.add(WarningKind::Ignored, None, message.into());
    }

    /// Something that is rendered only approximately.
    pub(crate) fn approximated(&mut self, place: Place, message: impl Into<String>) {
        self.add(WarningKind::Approximated, Some(place), message.into());
    }

    /// Something that is probably a mistake.
    pub(crate) fn doubtful(&mut self, place: Place, message: impl Into<String>) {
        self.add(WarningKind::Doubtful, Some(place), message.into());
    }

    /// A choice of the importer.
    pub(crate) fn note(&mut self, message: impl Into<String>) {
        self.add(WarningKind::Note, None, message.into());
    }

    /// A remark of another part, whose message names its file.
    pub(crate) fn remark(&mut self, warning: Warning) {
        self.add(warning.kind, None, warning.message);
    }

    /// In the order of their first positions.
    pub(crate) fn into_warnings(self, files: &[String]) -> Vec<Warning> {
        let mut list: Vec<_> = self.remarks.into_iter().collect();
        list.sort_by_key(|(_, (order, _, _))| *order);
        let mut out: Vec<Warning> = list
            .into_iter()
            .map(|((kind, message), (_, place, count))| {
                let message = match place {
                    Some(place) => format!("{}: {message}", shown(place, files)),
                    None => message,
                };
                Warning { count, ..Warning::new(kind, message) }
            })
            .collect();
        if self.beyond > 0 {
            let message = format!("more than {MAX_REMARKS} different remarks; the others are not shown");
            out.push(Warning { count: self.beyond, ..Warning::new(WarningKind::Ignored, message) });
        }
        out
    }
}

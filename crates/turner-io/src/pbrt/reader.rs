//! Executes the directives of a file and of the files that it includes.

use super::assembly::Assembly;
use super::lexer::{Lexer, Next};
use super::params::Params;
use super::report::{Fault, Report};
use super::source::{Place, Source};
use super::state::{Ctm, State};
use super::{camera, transform};
use crate::assets::{AssetSource, printable};
pub(super) use crate::scene_import::unknown;
use std::collections::BTreeMap;
use turner::math::{DAffine3, DVec3};
use turner::schema::ErrorCode;
use turner::schema::GroupId;

/// Longest chain of includes.
const MAX_CHAIN: usize = 64;
/// Most files of a scene.
const MAX_FILES: usize = 4096;
/// Largest file: 64 GiB. Files are read as streams.
const MAX_FILE: u64 = 64 << 30;
/// Most open attribute blocks.
const MAX_OPEN: usize = 1 << 12;

/// The state that `AttributeEnd`, `TransformEnd` or `ObjectEnd` restores, and the position of its begin.
pub(super) struct Open {
    state: State,
    place: Place,
    begin: &'static str,
}

/// An object between `ObjectBegin` and `ObjectEnd`.
pub(super) struct Object {
    name: String,
    first: usize,
}

/// An open file in the chain of includes.
pub(super) struct File<'a> {
    lexer: Lexer<'a>,
    uri: String,
    /// Number of open blocks where it began.
    open: usize,
    /// The state to restore after an `Import`.
    after: Option<State>,
}

/// The state of the import.
pub(super) struct Reader<'a> {
    pub(super) assets: &'a dyn AssetSource,
    pub(super) files: Vec<File<'a>>,
    pub(super) stack: Vec<Open>,
    pub(super) state: State,
    pub(super) systems: BTreeMap<String, Ctm>,
    /// Objects by name, with their groups.
    pub(super) objects: BTreeMap<String, GroupId>,
    pub(super) defining: Option<Object>,
    pub(super) in_world: bool,
    /// The camera as written; it is made at `WorldBegin`.
    pub(super) camera: Option<(State, String, Params)>,
    pub(super) scene: Assembly<'a>,
}

impl<'a> Reader<'a> {
    /// Starts with a file whose bytes come from `start`.
    pub(super) fn new(
        assets: &'a dyn AssetSource,
        uri: &str,
        start: Box<dyn std::io::Read + 'a>,
        scene: Assembly<'a>,
    ) -> Reader<'a> {
        let mut scene = scene;
        let material = scene.materials.default_slot();
        let mut reader = Reader {
            assets,
            files: Vec::new(),
            stack: Vec::new(),
            state: State::new(material),
            systems: BTreeMap::new(),
            objects: BTreeMap::new(),
            defining: None,
            in_world: false,
            camera: None,
            scene,
        };
        reader.push(uri.to_owned(), start, None);
        reader
    }

    fn push(&mut self, uri: String, bytes: Box<dyn std::io::Read + 'a>, after: Option<State>) {
        let number = self.scene.files.len() as u32;
        self.scene.files.push(uri.clone());
        let lexer = Lexer::new(Source::new(bytes, number));
        self.files.push(File { lexer, uri, open: self.stack.len(), after });
    }

    pub(super) fn lexer(&mut self) -> Result<&mut Lexer<'a>, Fault> {
        self.files
            .last_mut()
            .map(|f| &mut f.lexer)
            .ok_or_else(|| Fault::new(ErrorCode::Internal, "no file is open"))
    }

    pub(super) fn report(&mut self) -> &mut Report {
        &mut self.scene.report
    }

    /// Reads everything.
    pub(super) fn read(&mut self) -> Result<(), Fault> {
        loop {
            let next = self.lexer()?.next()?;
            let place = self.lexer()?.place();
            match next {
                Next::End => {
                    let Some(file) = self.files.pop() else { return Ok(()) };
                    if self.files.is_empty() {
                        return self.finish(place);
                    }
                    if file.after.is_some() {
                        while self.stack.len() > file.open {
                            self.close(place)?;
                        }
                    }
                    if let Some(state) = file.after {
                        self.state = state;
                    }
                }
                Next::Word => {
                    let word = self.lexer()?.word()?;
                    self.directive(&word, place).map_err(|f| f.or_at(place))?;
                }
                _ => {
                    let found = match next {
                        Next::Quote => "a string",
                        Next::Open => "[",
                        _ => "]",
                    };
                    let message = format!("expected a directive, found {found}");
                    return Err(Fault::at(place, ErrorCode::Syntax, message)
                        .help("a directive is a word such as Shape or AttributeBegin"));
                }
            }
        }
    }

    /// Makes the camera, if there is one.
    pub(super) fn take_camera(&mut self) -> Result<(), Fault> {
        match self.camera.take() {
            Some((state, name, params)) => camera::define(&mut self.scene, &state, &name, params),
            None => Ok(()),
        }
    }

    fn finish(&mut self, place: Place) -> Result<(), Fault> {
        self.take_camera()?;
        if let Some(open) = self.stack.last() {
            let message = format!("{} is not closed", open.begin);
            let at = open.place;
            self.report().doubtful(at, message);
        }
        if !self.in_world {
            self.report().doubtful(place, "the file has no WorldBegin, so that it has no objects");
        }
        Ok(())
    }

    pub(super) fn open(&mut self, begin: &'static str, place: Place) -> Result<(), Fault> {
        if self.stack.len() >= MAX_OPEN {
            let message = format!("{begin} nests deeper than {MAX_OPEN}");
            return Err(Fault::at(place, ErrorCode::TooLarge, message).help("is an AttributeEnd missing?"));
        }
        self.stack.push(Open { state: self.state.clone(), place, begin });
        Ok(())
    }

    pub(super) fn close(&mut self, _: Place) -> Result<(), Fault> {
        if let Some(open) = self.stack.pop() {
            if open.begin == "TransformBegin" {
                (self.state.ctm, self.state.active) = (open.state.ctm, open.state.active);
            } else {
                self.state = open.state;
            }
        }
        Ok(())
    }

    pub(super) fn close_of(&mut self, begin: &str, end: &str, place: Place) -> Result<(), Fault> {
        match self.stack.last() {
            Some(open) if open.begin == begin => self.close(place),
            Some(open) => {
                let message = format!("{end} found, but {} is open", open.begin);
                Err(Fault::at(place, ErrorCode::Syntax, message))
            }
            None => {
                self.report().doubtful(place, format!("{end} without {begin}"));
                Ok(())
            }
        }
    }

    pub(super) fn object_begin(&mut self, place: Place) -> Result<(), Fault> {
        let name = self.name()?;
        if self.defining.is_some() {
            let message = "ObjectBegin within an object";
            return Err(Fault::at(place, ErrorCode::Syntax, message).help("is an ObjectEnd missing?"));
        }
        self.open("ObjectBegin", place)?;
        self.defining = Some(Object { name, first: self.scene.objects.len() });
        Ok(())
    }

    pub(super) fn object_end(&mut self, place: Place) -> Result<(), Fault> {
        let Some(object) = self.defining.take() else {
            return Err(Fault::at(place, ErrorCode::Syntax, "ObjectEnd without ObjectBegin"));
        };
        while self.stack.last().is_some_and(|open| open.begin != "ObjectBegin") {
            self.close(place)?;
        }
        self.close(place)?;
        let group = self.scene.group(&object.name, object.first, place)?;
        if self.objects.insert(object.name.clone(), group).is_some() {
            self.report().doubtful(place, format!("the object {} is defined twice", printable(&object.name)));
        }
        Ok(())
    }

    pub(super) fn medium_interface(&mut self) -> Result<(), Fault> {
        let inside = self.name()?;
        // A single name is both.
        let outside = match self.lexer()?.next()? {
            Next::Quote => self.lexer()?.string()?,
            _ => inside.clone(),
        };
        self.state.media = [inside, outside];
        Ok(())
    }

    pub(super) fn include(&mut self, word: &str, place: Place) -> Result<(), Fault> {
        let name = self.name()?;
        let root = self.files.first().map_or_else(String::new, |f| f.uri.clone());
        let from = self.files.last().map_or_else(String::new, |f| f.uri.clone());
        let fault = |e: crate::assets::AssetError| Fault::from_scene(place, e.to_scene_error());
        // Names are relative to the scene; some exporters write them relative to the including file.
        let uri = self.assets.resolve(&root, &name).map_err(fault)?;
        if self.files.iter().any(|f| f.uri == uri) {
            let message = format!("cyclic include: {}", printable(&uri));
            return Err(Fault::at(place, ErrorCode::Cycle, message).help("remove this include"));
        }
        if self.files.len() >= MAX_CHAIN || self.scene.files.len() >= MAX_FILES {
            let message = format!("more than {MAX_FILES} files, or includes deeper than {MAX_CHAIN}");
            return Err(Fault::at(place, ErrorCode::TooLarge, message));
        }
        let (uri, bytes) = match self.assets.open(&uri, MAX_FILE) {
            Ok(bytes) => (uri, bytes),
            Err(error) => {
                let beside = self.assets.resolve(&from, &name).ok().filter(|other| *other != uri);
                let found = beside.and_then(|other| Some((self.assets.open(&other, MAX_FILE).ok()?, other)));
                let Some((bytes, other)) = found else { return Err(fault(error)) };
                if self.files.iter().any(|f| f.uri == other) {
                    let message = format!("cyclic include: {}", printable(&other));
                    return Err(Fault::at(place, ErrorCode::Cycle, message).help("remove this include"));
                }
                (other, bytes)
            }
        };
        let bytes = super::opened(bytes, &uri, self.scene.options.limits.memory.left())
            .map_err(|f| f.or_at(place))?;
        let after = (word == "Import").then(|| self.state.clone());
        self.push(uri, bytes, after);
        Ok(())
    }

    /// A string in quotes.
    pub(super) fn name(&mut self) -> Result<String, Fault> {
        let lexer = self.lexer()?;
        if lexer.next()? == Next::Quote {
            return lexer.string();
        }
        let place = lexer.place();
        Err(Fault::at(place, ErrorCode::Syntax, "expected a name in quotes"))
    }

    pub(super) fn params(&mut self, place: Place) -> Result<Params, Fault> {
        let mut params = Params::read(self.lexer()?, place)?;
        if self.scene.frame.is_version3 {
            params.keep_last();
        }
        Ok(params)
    }

    /// A name and the parameters that follow.
    pub(super) fn typed(&mut self, place: Place) -> Result<(String, Params), Fault> {
        let name = self.name()?;
        Ok((name, self.params(place)?))
    }

    pub(super) fn number(&mut self) -> Result<f64, Fault> {
        let lexer = self.lexer()?;
        match lexer.next()? {
            Next::Word => lexer.number(),
            _ => {
                let place = lexer.place();
                Err(Fault::at(place, ErrorCode::Syntax, "expected a number"))
            }
        }
    }

    pub(super) fn vector(&mut self) -> Result<DVec3, Fault> {
        Ok(DVec3::new(self.number()?, self.number()?, self.number()?))
    }

    /// Sixteen numbers, in brackets or not.
    pub(super) fn matrix(&mut self, place: Place) -> Result<DAffine3, Fault> {
        let bracketed = self.lexer()?.next()? == Next::Open;
        if bracketed {
            self.lexer()?.bracket();
        }
        let mut m = [0.0; 16];
        for v in &mut m {
            *v = self.number()?;
        }
        if bracketed {
            if self.lexer()?.next()? != Next::Close {
                let at = self.lexer()?.place();
                return Err(Fault::at(at, ErrorCode::Syntax, "a matrix has sixteen numbers: expected ]"));
            }
            self.lexer()?.bracket();
        }
        let Some((matrix, is_affine)) = transform::of_numbers(&m) else {
            let message = "a matrix whose last element is 0 is not an affine transform";
            return Err(Fault::at(place, ErrorCode::Transform, message));
        };
        if !is_affine {
            let message =
                "a matrix whose last row is not 0 0 0 1 is not an affine transform: that row is ignored";
            self.report().doubtful(place, message);
        }
        Ok(matrix)
    }
}

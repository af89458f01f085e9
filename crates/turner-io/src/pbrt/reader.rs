//! Directives: one after the other, from the file and from those it includes.

use super::assembly::Assembly;
use super::lexer::{Lexer, Next};
use super::params::Params;
use super::report::{Fault, Report};
use super::source::{Place, Source};
use super::state::{ColorSpace, Ctm, IDENTITY, State, Target};
use super::{camera, lights, media, shapes, textures, transform};
use crate::assets::{AssetSource, nearest, printable};
use crate::scene::two_lines;
pub(super) use crate::whole::unknown;
use std::collections::BTreeMap;
use std::rc::Rc;
use turner::math::{DAffine3, DVec3};
use turner::scene::error::ErrorCode;
use turner::scene::{GroupId, ObjectContent};

/// Most files that include one another in a chain.
const MAX_CHAIN: usize = 64;
/// Most files of a scene.
const MAX_FILES: usize = 4096;
/// Most bytes of one file: 64 GiB; they are not held in memory.
const MAX_FILE: u64 = 64 << 30;
/// Most attributes that are open at a time.
const MAX_OPEN: usize = 1 << 12;

/// Most numbers and letters of all defaults that `Attribute` gives.
const MAX_DEFAULTS: usize = 1 << 12;

/// What `AttributeEnd` and `ObjectEnd` go back to, and where its begin stands.
struct Open {
    state: State,
    place: Place,
    begin: &'static str,
}

/// An object that is being defined, or was.
struct Object {
    name: String,
    first: usize,
}

/// A file on the way from the scene to what is being read.
struct File<'a> {
    lexer: Lexer<'a>,
    uri: String,
    /// How many attributes were open where it began.
    open: usize,
    /// What goes on after an `Import`.
    after: Option<State>,
}

/// The words of all directives.
const DIRECTIVES: &[&str] = &[
    "Accelerator",
    "ActiveTransform",
    "AreaLightSource",
    "Attribute",
    "AttributeBegin",
    "AttributeEnd",
    "Camera",
    "ColorSpace",
    "ConcatTransform",
    "CoordinateSystem",
    "CoordSysTransform",
    "Film",
    "Identity",
    "Import",
    "Include",
    "Integrator",
    "LightSource",
    "LookAt",
    "MakeNamedMaterial",
    "MakeNamedMedium",
    "Material",
    "MediumInterface",
    "NamedMaterial",
    "ObjectBegin",
    "ObjectEnd",
    "ObjectInstance",
    "Option",
    "PixelFilter",
    "ReverseOrientation",
    "Rotate",
    "Sampler",
    "Scale",
    "Shape",
    "Texture",
    "Transform",
    "TransformBegin",
    "TransformEnd",
    "TransformTimes",
    "Translate",
    "WorldBegin",
];

/// The state of reading.
pub(super) struct Reader<'a> {
    assets: &'a dyn AssetSource,
    files: Vec<File<'a>>,
    stack: Vec<Open>,
    state: State,
    systems: BTreeMap<String, Ctm>,
    /// Objects by name, with their groups.
    objects: BTreeMap<String, GroupId>,
    defining: Option<Object>,
    in_world: bool,
    pub(super) scene: Assembly<'a>,
}

impl<'a> Reader<'a> {
    /// Begins with a file whose bytes come from `start`.
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

    fn lexer(&mut self) -> Result<&mut Lexer<'a>, Fault> {
        self.files
            .last_mut()
            .map(|f| &mut f.lexer)
            .ok_or_else(|| Fault::new(ErrorCode::Internal, "no file is open"))
    }

    fn report(&mut self) -> &mut Report {
        &mut self.scene.report
    }

    /// Reads all.
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

    fn finish(&mut self, place: Place) -> Result<(), Fault> {
        if let Some(open) = self.stack.last() {
            let message = format!("{} is not closed", open.begin);
            let at = open.place;
            self.report().doubtful(at, message);
        }
        if !self.in_world {
            self.report().doubtful(place, "the file has no WorldBegin: it shows nothing");
        }
        Ok(())
    }

    fn directive(&mut self, word: &str, place: Place) -> Result<(), Fault> {
        match word {
            "AttributeBegin" => self.open("AttributeBegin", place)?,
            "AttributeEnd" => self.close_of("AttributeBegin", "AttributeEnd", place)?,
            "TransformBegin" => self.open("TransformBegin", place)?,
            "TransformEnd" => self.close_of("TransformBegin", "TransformEnd", place)?,
            "Shape" => {
                let (name, params) = self.typed(place)?;
                let params = self.state.with_defaults(params, Target::Shape);
                let in_object = self.defining.is_some();
                shapes::add(&mut self.scene, &self.state, &name, params, in_object)?;
            }
            "Translate" => {
                let v = self.vector()?;
                self.state.concat(DAffine3::from_translation(v));
            }
            "Scale" => {
                let v = self.vector()?;
                if v.min_element() <= 0.0 && v.to_array().contains(&0.0) {
                    self.report().doubtful(place, "a scale of 0: what it is for cannot be shown");
                }
                self.state.concat(DAffine3::from_scale(v));
            }
            "Rotate" => {
                let degrees = self.number()?;
                let axis = self.vector()?;
                match transform::rotate(degrees, axis) {
                    Some(by) => self.state.concat(by),
                    None => {
                        self.report().doubtful(place, "Rotate about an axis without a direction is left out")
                    }
                }
            }
            "LookAt" => {
                let (eye, look, up) = (self.vector()?, self.vector()?, self.vector()?);
                let by = transform::look_at(eye, look, up).ok_or_else(|| {
                    Fault::at(
                        place,
                        ErrorCode::Transform,
                        "LookAt: the eye is the point looked at, or up lies along the view",
                    )
                })?;
                self.state.concat(by);
            }
            "Identity" => self.state.set(IDENTITY),
            "Transform" | "ConcatTransform" => {
                let m = self.matrix(place)?;
                if word == "Transform" { self.state.set([m; 2]) } else { self.state.concat(m) }
            }
            "CoordinateSystem" => {
                let name = self.name()?;
                self.systems.insert(name, self.state.ctm);
            }
            "CoordSysTransform" => {
                let name = self.name()?;
                match self.systems.get(&name) {
                    Some(ctm) => self.state.set(*ctm),
                    None => {
                        let names: Vec<&str> = self.systems.keys().map(String::as_str).collect();
                        return Err(unknown("coordinate system", &name, &names));
                    }
                }
            }
            "ActiveTransform" => {
                let place = self.lexer()?.place();
                self.lexer()?.next()?;
                let which = self.lexer()?.word()?;
                self.state.active = match which.as_str() {
                    "StartTime" => [true, false],
                    "EndTime" => [false, true],
                    "All" => [true, true],
                    other => {
                        return Err(
                            unknown("active transform", other, &["All", "EndTime", "StartTime"]).or_at(place)
                        );
                    }
                };
            }
            "TransformTimes" => {
                let times = [self.number()?, self.number()?];
                self.scene.frame.transform_times = times;
            }
            "ReverseOrientation" => self.state.reverse = !self.state.reverse,
            "ColorSpace" => {
                let name = self.name()?;
                let words = ColorSpace::WORDS;
                match words.iter().find(|(word, _)| *word == name) {
                    Some((_, space)) => self.state.color_space = *space,
                    None => return Err(unknown("colour space", &name, &words.map(|w| w.0))),
                }
            }
            "MediumInterface" => self.medium_interface()?,
            "Attribute" => {
                let name = self.name()?;
                let params = self.params(place)?;
                let words = Target::WORDS;
                let Some((_, target)) = words.iter().find(|(word, _)| *word == name) else {
                    return Err(unknown("target of Attribute", &name, &words.map(|w| w.0)));
                };
                let defaults = Rc::make_mut(&mut self.state.defaults);
                for param in params.into_list() {
                    defaults.retain(|(t, p)| !(t == target && p.name == param.name));
                    defaults.push((*target, param));
                }
                // Each attribute that is open may have its own.
                if defaults.iter().map(|(_, p)| p.value.cost()).sum::<usize>() > MAX_DEFAULTS {
                    let message = "more defaults of parameters than a few thousand numbers";
                    return Err(Fault::at(place, ErrorCode::TooLarge, message));
                }
            }
            "Material" => {
                let (name, params) = self.typed(place)?;
                let params = self.state.with_defaults(params, Target::Material);
                self.state.material = self.scene.materials.add(None, name, params, &self.state)?;
            }
            "MakeNamedMaterial" => {
                let name = self.name()?;
                let params = self.params(place)?;
                let kind = params.string("type").map(str::to_owned);
                let kind = kind.ok_or_else(|| {
                    Fault::at(place, ErrorCode::MissingKey, "a named material needs \"string type\"")
                        .help("as in \"string type\" \"diffuse\"")
                })?;
                let params = self.state.with_defaults(params, Target::Material);
                self.scene.materials.add(Some(name), kind, params, &self.state)?;
            }
            "NamedMaterial" => {
                let name = self.name()?;
                self.state.material = self.scene.materials.named(&name, place);
            }
            "Texture" => {
                let name = self.name()?;
                let kind = self.name()?;
                let (class, params) = self.typed(place)?;
                let params = self.state.with_defaults(params, Target::Texture);
                textures::define(&mut self.scene, &self.state, (&name, &kind, &class), params)?;
            }
            "AreaLightSource" => {
                let (name, params) = self.typed(place)?;
                if !matches!(name.as_str(), "diffuse" | "area") {
                    return Err(unknown("area light", &name, &["diffuse"]));
                }
                let params = self.state.with_defaults(params, Target::Light);
                self.state.area_light = Some(Rc::new(params));
            }
            "LightSource" => {
                let (name, params) = self.typed(place)?;
                let params = self.state.with_defaults(params, Target::Light);
                lights::add(&mut self.scene, &self.state, &name, params)?;
            }
            "MakeNamedMedium" => {
                let name = self.name()?;
                let params = self.params(place)?;
                let params = self.state.with_defaults(params, Target::Medium);
                media::define(&mut self.scene, &self.state, name, params)?;
            }
            "ObjectBegin" => self.object_begin(place)?,
            "ObjectEnd" => self.object_end(place)?,
            "ObjectInstance" => {
                let name = self.name()?;
                let Some(&group) = self.objects.get(&name) else {
                    let names: Vec<&str> = self.objects.keys().map(String::as_str).collect();
                    return Err(unknown("object", &name, &names));
                };
                if self.defining.is_some() {
                    self.report().ignored(place, "an ObjectInstance within an object");
                    return Ok(());
                }
                self.scene.place(ObjectContent::Instance(group), None, &self.state, place)?;
            }
            "WorldBegin" => {
                self.in_world = true;
                self.state.ctm = IDENTITY;
                self.state.active = [true, true];
                self.systems.insert("world".into(), IDENTITY);
            }
            "WorldEnd" => {}
            "Include" | "Import" => self.include(word, place)?,
            "Camera" => {
                let (name, params) = self.typed(place)?;
                let inverse = self.state.ctm.map(|m| m.inverse());
                self.systems.insert("camera".into(), inverse);
                camera::define(&mut self.scene, &self.state, &name, params)?;
            }
            "Film" | "Sampler" | "PixelFilter" | "Filter" | "Integrator" | "Accelerator" => {
                let (name, params) = self.typed(place)?;
                match word {
                    "Film" => self.scene.frame.film(&name, params, &mut self.scene.stock.report),
                    "Sampler" => self.scene.frame.sampler(&name, params, &mut self.scene.stock.report),
                    "Integrator" => self.scene.frame.integrator(&name, params, &mut self.scene.stock.report),
                    // How rays are searched for changes no picture.
                    "Accelerator" => {}
                    _ => self.scene.frame.filter(&name, params, &mut self.scene.stock.report),
                }
            }
            "Option" => {
                let params = self.params(place)?;
                self.scene.frame.options(params, &mut self.scene.stock.report);
            }
            other => {
                let message = format!("unknown directive {}", printable(other));
                let help = match nearest(other, DIRECTIVES.iter().copied()) {
                    Some(near) => format!("did you mean {near}?"),
                    None => "directives are words such as Shape, Material, Translate, AttributeBegin".into(),
                };
                return Err(Fault::at(place, ErrorCode::UnknownName, message).help(help));
            }
        }
        Ok(())
    }

    fn open(&mut self, begin: &'static str, place: Place) -> Result<(), Fault> {
        if self.stack.len() >= MAX_OPEN {
            let message = format!("{begin} nests deeper than {MAX_OPEN}");
            return Err(Fault::at(place, ErrorCode::TooLarge, message).help("is an AttributeEnd missing?"));
        }
        self.stack.push(Open { state: self.state.clone(), place, begin });
        Ok(())
    }

    fn close(&mut self, _: Place) -> Result<(), Fault> {
        if let Some(open) = self.stack.pop() {
            if open.begin == "TransformBegin" {
                (self.state.ctm, self.state.active) = (open.state.ctm, open.state.active);
            } else {
                self.state = open.state;
            }
        }
        Ok(())
    }

    fn close_of(&mut self, begin: &str, end: &str, place: Place) -> Result<(), Fault> {
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

    fn object_begin(&mut self, place: Place) -> Result<(), Fault> {
        let name = self.name()?;
        if self.defining.is_some() {
            let message = "ObjectBegin within an object";
            return Err(Fault::at(place, ErrorCode::Syntax, message).help("is an ObjectEnd missing?"));
        }
        self.open("ObjectBegin", place)?;
        self.defining = Some(Object { name, first: self.scene.objects.len() });
        Ok(())
    }

    fn object_end(&mut self, place: Place) -> Result<(), Fault> {
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

    fn medium_interface(&mut self) -> Result<(), Fault> {
        let inside = self.name()?;
        // One name is that of both.
        let outside = match self.lexer()?.next()? {
            Next::Quote => self.lexer()?.string()?,
            _ => inside.clone(),
        };
        self.state.media = [inside, outside];
        Ok(())
    }

    fn include(&mut self, word: &str, place: Place) -> Result<(), Fault> {
        let name = self.name()?;
        let root = self.files.first().map_or_else(String::new, |f| f.uri.clone());
        let from = self.files.last().map_or_else(String::new, |f| f.uri.clone());
        let fault = |e: crate::assets::AssetError| {
            Fault::from_scene(place, two_lines(ErrorCode::File, &e.to_string()))
        };
        // Names are relative to the scene; some tools write them relative to the file that includes.
        let uri = self.assets.resolve(&root, &name).map_err(fault)?;
        if self.files.iter().any(|f| f.uri == uri) {
            let message = format!("files include each other in a circle: {}", printable(&uri));
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
                    let message = format!("files include each other in a circle: {}", printable(&other));
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
    fn name(&mut self) -> Result<String, Fault> {
        let lexer = self.lexer()?;
        if lexer.next()? == Next::Quote {
            return lexer.string();
        }
        let place = lexer.place();
        Err(Fault::at(place, ErrorCode::Syntax, "expected a name in quotes"))
    }

    fn params(&mut self, place: Place) -> Result<Params, Fault> {
        Params::read(self.lexer()?, place)
    }

    /// A name and the parameters that follow.
    fn typed(&mut self, place: Place) -> Result<(String, Params), Fault> {
        let name = self.name()?;
        Ok((name, self.params(place)?))
    }

    fn number(&mut self) -> Result<f64, Fault> {
        let lexer = self.lexer()?;
        match lexer.next()? {
            Next::Word => lexer.number(),
            _ => {
                let place = lexer.place();
                Err(Fault::at(place, ErrorCode::Syntax, "expected a number"))
            }
        }
    }

    fn vector(&mut self) -> Result<DVec3, Fault> {
        Ok(DVec3::new(self.number()?, self.number()?, self.number()?))
    }

    /// Sixteen numbers, in brackets or not.
    fn matrix(&mut self, place: Place) -> Result<DAffine3, Fault> {
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
        transform::of_numbers(&m).ok_or_else(|| {
            Fault::at(
                place,
                ErrorCode::Transform,
                "a matrix whose last row is not 0 0 0 1 is no affine transform",
            )
        })
    }
}

//! What each directive does.

use std::rc::Rc;

use turner::description::ObjectContent;
use turner::math::DAffine3;
use turner::schema::ErrorCode;

use super::reader::Reader;
use super::report::Fault;
use super::source::Place;
use super::state::{ColorSpace, IDENTITY, Target};
use super::{lights, media, shapes, textures, transform};
use crate::assets::{nearest, printable};
use crate::scene_import::unknown;

/// Largest total [cost](super::params::Value::cost) of the defaults that `Attribute` sets.
const MAX_DEFAULTS: usize = 1 << 12;

/// The names of all directives.
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
    // Those of pbrt-v2.
    "Renderer",
    "SurfaceIntegrator",
    "Volume",
    "VolumeIntegrator",
];

impl Reader<'_> {
    /// Executes one directive.
    pub(super) fn directive(&mut self, word: &str, place: Place) -> Result<(), Fault> {
        let known = self.transformation(word, place)?
            || self.attribute(word, place)?
            || self.definition(word, place)?
            || self.frame(word, place)?;
        if known {
            return Ok(());
        }
        let message = format!("unknown directive {}", printable(word));
        let help = match nearest(word, DIRECTIVES.iter().copied()) {
            Some(near) => format!("did you mean {near}?"),
            None => "directives are words such as Shape, Material, Translate, AttributeBegin".into(),
        };
        Err(Fault::at(place, ErrorCode::UnknownName, message).help(help))
    }

    /// Directives that change the current transformation; returns whether `word` is one.
    fn transformation(&mut self, word: &str, place: Place) -> Result<bool, Fault> {
        match word {
            "Translate" => {
                let v = self.vector()?;
                self.state.concat(DAffine3::from_translation(v));
            }
            "Scale" => {
                let v = self.vector()?;
                if v.min_element() <= 0.0 && v.to_array().contains(&0.0) {
                    self.report().doubtful(place, "a scale of 0: its objects are not rendered");
                }
                self.state.concat(DAffine3::from_scale(v));
            }
            "Rotate" => {
                let degrees = self.number()?;
                let axis = self.vector()?;
                match transform::rotate(degrees, axis) {
                    Some(by) => self.state.concat(by),
                    None => self.report().doubtful(place, "Rotate about a zero axis: omitted"),
                }
            }
            "LookAt" => {
                let (eye, look, up) = (self.vector()?, self.vector()?, self.vector()?);
                let by = transform::look_at(eye, look, up).ok_or_else(|| {
                    Fault::at(
                        place,
                        ErrorCode::Transform,
                        "LookAt: the eye equals the look-at point, or up is parallel to the viewing direction",
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
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Directives that change the graphics state; returns whether `word` is one.
    fn attribute(&mut self, word: &str, place: Place) -> Result<bool, Fault> {
        match word {
            "AttributeBegin" => self.open("AttributeBegin", place)?,
            "AttributeEnd" => self.close_of("AttributeBegin", "AttributeEnd", place)?,
            "TransformBegin" => self.open("TransformBegin", place)?,
            "TransformEnd" => self.close_of("TransformBegin", "TransformEnd", place)?,
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
                // Each open attribute block may hold a copy of its own.
                if defaults.iter().map(|(_, p)| p.value.cost()).sum::<usize>() > MAX_DEFAULTS {
                    let message = "Attribute sets too many default values";
                    return Err(Fault::at(place, ErrorCode::TooLarge, message));
                }
            }
            "Material" => {
                let (name, params) = self.typed(place)?;
                let params = self.state.with_defaults(params, Target::Material);
                self.state.material = self.scene.materials.add(None, name, params, &self.state)?;
            }
            "NamedMaterial" => {
                let name = self.name()?;
                self.state.material = self.scene.materials.named(&name, place);
            }
            "AreaLightSource" => {
                let (name, params) = self.typed(place)?;
                if !matches!(name.as_str(), "diffuse" | "area") {
                    return Err(unknown("area light", &name, &["diffuse"]));
                }
                let params = self.state.with_defaults(params, Target::Light);
                self.state.area_light = Some(Rc::new(params));
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Directives that define shapes, materials, textures, lights, media and objects; returns whether `word` is one.
    fn definition(&mut self, word: &str, place: Place) -> Result<bool, Fault> {
        match word {
            "Shape" => {
                let (name, params) = self.typed(place)?;
                let params = self.state.with_defaults(params, Target::Shape);
                let in_object = self.defining.is_some();
                shapes::add(&mut self.scene, &self.state, &name, params, in_object)?;
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
            "Texture" => {
                let name = self.name()?;
                let kind = self.name()?;
                let (class, params) = self.typed(place)?;
                let params = self.state.with_defaults(params, Target::Texture);
                textures::define(&mut self.scene, &self.state, (&name, &kind, &class), params)?;
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
                    self.report().ignored(place, "ObjectInstance between ObjectBegin and ObjectEnd");
                    return Ok(true);
                }
                self.scene.place(ObjectContent::Instance(group), None, &self.state, place)?;
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Directives of the camera, the film and the file; returns whether `word` is one.
    fn frame(&mut self, word: &str, place: Place) -> Result<bool, Fault> {
        match word {
            "WorldBegin" => {
                self.take_camera()?;
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
                // The film may follow and determines the aspect: the camera waits for WorldBegin.
                self.camera = Some((self.state.clone(), name, params));
            }
            "Volume" => {
                let (name, _) = self.typed(place)?;
                let message = format!("the volume \"{}\" of pbrt-v2", printable(&name));
                self.report().ignored(place, message);
            }
            // The integrator decides.
            "Renderer" | "VolumeIntegrator" => {
                self.typed(place)?;
            }
            "Film" | "Sampler" | "PixelFilter" | "Filter" | "Integrator" | "SurfaceIntegrator"
            | "Accelerator" => {
                let (name, params) = self.typed(place)?;
                match word {
                    "Film" => self.scene.frame.film(&name, params, &mut self.scene.stock.report),
                    "Sampler" => self.scene.frame.sampler(&name, params, &mut self.scene.stock.report),
                    "Integrator" | "SurfaceIntegrator" => {
                        self.scene.frame.integrator(&name, params, &mut self.scene.stock.report)
                    }
                    // The acceleration structure does not change the picture.
                    "Accelerator" => {}
                    _ => self.scene.frame.filter(&name, params, &mut self.scene.stock.report),
                }
            }
            "Option" => {
                let params = self.params(place)?;
                self.scene.frame.options(params, &mut self.scene.stock.report);
            }
            _ => return Ok(false),
        }
        Ok(true)
    }
}

//! Materials. They are made after everything is read, because a name may be used before its definition. A
//! material becomes one [`MaterialDesc`] per way in which shapes use it: with emission, alpha or a medium
//! inside.

use std::collections::BTreeMap;

use turner::material::{AlphaMode, InterfaceMaterial, MaterialDesc, MeasuredMaterial, PrincipledMaterial};
use turner::schema::{ColorSource, ErrorCode, MaterialId, MeasuredFile, MediumId, Named};

use super::assembly::Assembly;
use super::lights::Emission;
use super::params::Params;
use super::report::Fault;
use super::source::Place;
use super::state::{ColorSpace, State};
use super::surfaces::{Maker, grey};
use super::version3;
use crate::assets::printable;
use crate::measured::MAX_BSDF;
use crate::scene_import::{product, single_scattering};

/// Most materials.
const MAX_MATERIALS: usize = 1 << 22;

/// A material as the file describes it.
struct Slot {
    name: Option<String>,
    /// Type, parameters and colour space; `None` for a name that is used but not defined yet.
    written: Option<(String, Params, ColorSpace)>,
    place: Place,
}

/// How a shape uses a material.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Use {
    pub(super) emission: Option<Emission>,
    pub(super) alpha: Option<ColorSource>,
    pub(super) interior: Option<MediumId>,
}

/// The materials of a file.
#[derive(Default)]
pub(super) struct Materials {
    slots: Vec<Slot>,
    named: BTreeMap<String, usize>,
    wanted: BTreeMap<(usize, String), MaterialId>,
    /// Slot and use of each [`MaterialId`].
    list: Vec<(usize, Use)>,
}

impl Materials {
    /// The material of shapes before the first `Material`: diffuse.
    pub(super) fn default_slot(&mut self) -> usize {
        self.slots.push(Slot {
            name: None,
            written: Some(("diffuse".into(), Params::default(), ColorSpace::Srgb)),
            place: Place::default(),
        });
        self.slots.len() - 1
    }

    /// Adds the description of a material.
    pub(super) fn add(
        &mut self,
        name: Option<String>,
        kind: String,
        params: Params,
        state: &State,
    ) -> Result<usize, Fault> {
        let place = params.place;
        let written = Some((kind, params, state.color_space));
        if let Some(&slot) = name.as_ref().and_then(|n| self.named.get(n))
            && let Some(open) = self.slots.get_mut(slot)
            && open.written.is_none()
        {
            (open.written, open.place) = (written, place);
            return Ok(slot);
        }
        if self.slots.len() >= MAX_MATERIALS {
            return Err(Fault::at(
                place,
                ErrorCode::TooLarge,
                format!("more than {MAX_MATERIALS} materials"),
            ));
        }
        self.slots.push(Slot { name: name.clone(), written, place });
        let slot = self.slots.len() - 1;
        if let Some(name) = name {
            self.named.insert(name, slot);
        }
        Ok(slot)
    }

    /// The slot of a name, which may be defined later.
    pub(super) fn named(&mut self, name: &str, place: Place) -> usize {
        if let Some(&slot) = self.named.get(name) {
            return slot;
        }
        self.slots.push(Slot { name: Some(name.to_owned()), written: None, place });
        self.named.insert(name.to_owned(), self.slots.len() - 1);
        self.slots.len() - 1
    }

    /// The id of a slot's material for a use.
    pub(super) fn wanted(&mut self, slot: usize, usage: Use) -> MaterialId {
        let key = (slot, if usage == Use::default() { String::new() } else { format!("{usage:?}") });
        let next = MaterialId(self.list.len() as u32);
        let id = *self.wanted.entry(key).or_insert(next);
        if id == next {
            self.list.push((slot, usage));
        }
        id
    }

    /// Whether a shape encloses a medium.
    pub(super) fn encloses(&self, medium: MediumId) -> bool {
        self.list.iter().any(|(_, usage)| usage.interior == Some(medium))
    }

    /// The parameters of a slot; `None` for a name that is not defined yet.
    pub(super) fn params(&self, slot: usize) -> Option<&Params> {
        self.slots.get(slot).and_then(|s| s.written.as_ref()).map(|w| &w.1)
    }

    /// The slot of a name that was used or defined.
    pub(super) fn slot_named(&self, name: &str) -> Option<usize> {
        self.named.get(name).copied()
    }

    /// Whether a slot is an interface without a surface, as far as it is defined.
    pub(super) fn is_interface(&self, slot: usize) -> bool {
        let kind = self.slots.get(slot).and_then(|s| s.written.as_ref()).map(|w| w.0.as_str());
        matches!(kind, Some("interface" | "none" | ""))
    }
}

/// Makes all materials that are in use.
pub(super) fn finish(scene: &mut Assembly<'_>) -> Result<Vec<Named<MaterialDesc>>, Fault> {
    let mut made = Vec::new();
    let mut next = 0;
    // A mix adds its parts to the list.
    while let Some((slot, usage)) = scene.materials.list.get(next).cloned() {
        next += 1;
        let Some(entry) = scene.materials.slots.get_mut(slot) else { continue };
        let (name, place) = (entry.name.clone(), entry.place);
        let Some((kind, params, space)) = entry.written.take() else {
            let name = name.unwrap_or_default();
            let names: Vec<&str> =
                scene.materials.named.keys().map(String::as_str).filter(|n| *n != name).collect();
            return Err(super::reader::unknown("material", &name, &names).or_at(place));
        };
        let value = make(scene, &kind, &params, space, usage).map_err(|f| f.or_at(place))?;
        if let Some(entry) = scene.materials.slots.get_mut(slot) {
            entry.written = Some((kind, params, space));
        }
        if made.len() >= MAX_MATERIALS {
            return Err(Fault::at(
                place,
                ErrorCode::TooLarge,
                format!("more than {MAX_MATERIALS} materials"),
            ));
        }
        made.push(Named { name, span: None, value });
    }
    Ok(made)
}

impl Maker<'_, '_> {
    /// The file of a measured BRDF; `None` if there is none, or one that cannot be read.
    fn measured(&mut self) -> Result<Option<MeasuredFile>, Fault> {
        let Some(name) = self.params.string("filename").map(str::to_owned) else {
            let message = "a measured material without a filename: rendered as diffuse grey";
            self.scene.report.ignored(self.params.place, message);
            return Ok(None);
        };
        let place = self.params.place_of("filename");
        let read = self.scene.read(&name, MAX_BSDF, place)?;
        self.scene.measured_file(&name, read, place)
    }
}

/// One material for one use.
fn make(
    scene: &mut Assembly<'_>,
    kind: &str,
    params: &Params,
    space: ColorSpace,
    mut usage: Use,
) -> Result<MaterialDesc, Fault> {
    params.pass(&["type"]);
    let what = format!("the material \"{}\"", printable(kind));
    let mut maker = Maker { scene, params, space };
    let mut measured = None;
    let mut surface = match kind {
        "interface" | "none" | "" => {
            params.finish(&what, &mut maker.scene.report);
            if usage.emission.is_some() {
                let message = "an area light on an interface material: it emits no light, as in pbrt";
                maker.scene.report.ignored(params.place, message);
            }
            return Ok(MaterialDesc::Interface(InterfaceMaterial { interior: usage.interior }));
        }
        "mix" => return maker.mix(usage),
        "diffuse" => {
            PrincipledMaterial { base_color: maker.color("reflectance", 0.5)?, ..PrincipledMaterial::matte() }
        }
        "coateddiffuse" => maker.coated_diffuse()?,
        "conductor" => maker.conductor(0.0)?,
        "coatedconductor" => maker.coated_conductor()?,
        "dielectric" => maker.dielectric()?,
        "thindielectric" => PrincipledMaterial {
            specular_roughness: grey(0.0),
            transmission_weight: grey(1.0),
            thin_walled: true,
            ..maker.with_index("eta", PrincipledMaterial::default())?
        },
        "diffusetransmission" => maker.diffuse_transmission()?,
        "subsurface" => maker.subsurface(None)?,
        "hair" => {
            let hair = maker.hair()?;
            params.pass(&["displacement", "normalmap"]);
            params.finish(&what, &mut maker.scene.report);
            if usage.emission.is_some() || usage.alpha.is_some() {
                let message = "an area light on hair, or the alpha of hair: opaque hair without emission";
                maker.scene.report.ignored(params.place, message);
            }
            return Ok(MaterialDesc::Hair(hair));
        }
        "measured" => {
            measured = maker.measured()?;
            PrincipledMaterial { base_color: grey(0.5), ..PrincipledMaterial::matte() }
        }
        "disney" => {
            let made = version3::disney(&mut maker, usage)?;
            params.finish(&what, &mut maker.scene.report);
            return Ok(made);
        }
        old if version3::MATERIALS.contains(&old) => {
            if old == "uber"
                && let Some(opacity) = maker.opacity()?
            {
                let alpha = usage.alpha.take();
                usage.alpha = Some(alpha.map_or(opacity, |alpha| product(maker.scene, alpha, opacity)));
            }
            maker.version3(old)?
        }
        other => {
            let version4 = [
                "diffuse",
                "coateddiffuse",
                "conductor",
                "coatedconductor",
                "dielectric",
                "thindielectric",
                "diffusetransmission",
                "subsurface",
                "hair",
                "measured",
                "mix",
                "interface",
            ];
            let all: Vec<&str> = version4.iter().chain(version3::MATERIALS).copied().collect();
            let fault = super::reader::unknown("material", other, &all);
            return Err(fault.or_at(params.place));
        }
    };
    maker.details(&mut surface)?;
    params.finish(&what, &mut maker.scene.report);
    let surface = used(surface, usage);
    Ok(match measured {
        Some(file) => MaterialDesc::Measured(MeasuredMaterial::with_use_of(file, surface)),
        None => MaterialDesc::Principled(surface),
    })
}

/// The surface as a shape uses it: with emission, alpha or a medium inside.
fn used(mut surface: PrincipledMaterial, usage: Use) -> PrincipledMaterial {
    single_scattering(&mut surface);
    surface.soften_terminator = false;
    surface.alpha_mode = AlphaMode::Opaque;
    if let Some(alpha) = usage.alpha {
        (surface.opacity, surface.alpha_mode) = (alpha, AlphaMode::Blend);
    }
    if let Some(emission) = usage.emission {
        surface.emission_luminance = emission.radiance;
        surface.emission_color = emission.color;
        surface.emission_front_only = !emission.two_sided;
    }
    let is_solid_glass = surface.transmission_weight != grey(0.0) && !surface.thin_walled;
    if is_solid_glass {
        surface.interior = usage.interior;
    }
    surface
}

//! Materials. Those that shapes use are made when all has been read, for names may be used before they are defined; one for each way in
//! which shapes use it: with light, with holes, with a medium inside.

use super::assembly::Assembly;
use super::lights::Emission;
use super::media;
use super::params::{Params, Type};
use super::report::Fault;
use super::source::Place;
use super::spectra::{Curve, Role, color, curve, glass_of, metal_of, to_color};
use super::state::{ColorSpace, State};
use super::textures::{normal_picture, source_named};
use crate::assets::printable;
use crate::spectral::metal_of_index;
use crate::whole::{Through, inner_reflectance, map_values};
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;
use turner::color::Spectrum;
use turner::material::metals::{MetalColors, MetalName, colors_of_index};
use turner::material::{
    AlphaMode, BoundaryMaterial, BumpUnit, MaterialDesc, MixMaterial, PrincipledMaterial,
};
use turner::scene::error::ErrorCode;
use turner::scene::{ColorSource, MaterialId, MediumId, Named};

/// Most materials.
const MAX_MATERIALS: usize = 1 << 22;

/// A material as it was written.
struct Slot {
    name: Option<String>,
    /// Its type and parameters; `None` while a name was used that is not defined yet.
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
    /// What each [`MaterialId`] is to be.
    list: Vec<(usize, Use)>,
}

impl Materials {
    /// The material of shapes before any is said: diffuse.
    pub(super) fn default_slot(&mut self) -> usize {
        self.slots.push(Slot {
            name: None,
            written: Some(("diffuse".into(), Params::default(), ColorSpace::Srgb)),
            place: Place::default(),
        });
        self.slots.len() - 1
    }

    /// A material as written.
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

    /// The material of a slot for a use.
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

    /// Whether a slot is no surface, as far as is known.
    pub(super) fn is_interface(&self, slot: usize) -> bool {
        let kind = self.slots.get(slot).and_then(|s| s.written.as_ref()).map(|w| w.0.as_str());
        matches!(kind, Some("interface" | "none" | ""))
    }
}

/// Makes the materials that are used.
pub(super) fn finish(scene: &mut Assembly<'_>) -> Result<Vec<Named<MaterialDesc>>, Fault> {
    let mut made = Vec::new();
    let mut next = 0;
    // Mixes want more of them.
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

fn grey(v: f64) -> ColorSource {
    ColorSource::Constant(Spectrum::grey(v as f32))
}

/// One material for one use.
fn make(
    scene: &mut Assembly<'_>,
    kind: &str,
    params: &Params,
    space: ColorSpace,
    usage: Use,
) -> Result<MaterialDesc, Fault> {
    params.pass(&["type"]);
    let what = format!("the material \"{}\"", printable(kind));
    let mut maker = Maker { scene, params, space };
    let mut surface = match kind {
        "interface" | "none" | "" => {
            params.finish(&what, &mut maker.scene.report);
            if usage.emission.is_none() {
                return Ok(MaterialDesc::Boundary(BoundaryMaterial { interior: usage.interior }));
            }
            maker
                .scene
                .report
                .approximated(params.place, "a shape that shines and is no surface: it is black");
            PrincipledMaterial { base_color: grey(0.0), ..PrincipledMaterial::matte() }
        }
        "mix" => return maker.mix(usage),
        "diffuse" => {
            PrincipledMaterial { base_color: maker.color("reflectance", 0.5)?, ..PrincipledMaterial::matte() }
        }
        "coateddiffuse" => maker.coated_diffuse()?,
        "conductor" => maker.conductor("", ["eta", "k", "reflectance"])?,
        "coatedconductor" => maker.coated_conductor()?,
        "dielectric" => maker.dielectric()?,
        "thindielectric" => PrincipledMaterial {
            specular_roughness: grey(0.0),
            transmission_weight: grey(1.0),
            thin_walled: true,
            ..maker.with_index("eta", PrincipledMaterial::default())?
        },
        "diffusetransmission" => maker.diffuse_transmission()?,
        "subsurface" => maker.subsurface()?,
        "hair" => maker.hair()?,
        "measured" => {
            params.pass(&["filename"]);
            maker.scene.report.ignored(params.place, "a measured material: it is shown as diffuse grey");
            PrincipledMaterial { base_color: grey(0.5), ..PrincipledMaterial::matte() }
        }
        other => {
            let old = [
                "matte",
                "plastic",
                "glass",
                "mirror",
                "metal",
                "uber",
                "substrate",
                "translucent",
                "disney",
                "fourier",
                "kdsubsurface",
            ];
            let mut fault = super::reader::unknown(
                "material",
                other,
                &[
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
                ],
            );
            if old.contains(&other) {
                fault = fault.help("this is a material of pbrt-v3: convert the file by `pbrt --upgrade`");
            }
            return Err(fault.or_at(params.place));
        }
    };
    maker.details(&mut surface)?;
    params.finish(&what, &mut maker.scene.report);
    surface.alpha_mode = AlphaMode::Opaque;
    if let Some(alpha) = usage.alpha {
        (surface.opacity, surface.alpha_mode) = (alpha, AlphaMode::Blend);
    }
    if let Some(emission) = usage.emission {
        surface.emission_luminance = emission.radiance;
        surface.emission_color = ColorSource::Constant(emission.color);
        surface.emission_front_only = !emission.two_sided;
    }
    let is_solid_glass = surface.transmission_weight != grey(0.0) && !surface.thin_walled;
    if is_solid_glass {
        surface.interior = usage.interior;
    }
    Ok(MaterialDesc::Principled(surface))
}

struct Maker<'a, 'b> {
    scene: &'a mut Assembly<'b>,
    params: &'a Params,
    space: ColorSpace,
}

impl Maker<'_, '_> {
    /// A colour or a texture; `or` if it is not given.
    fn color(&mut self, name: &'static str, or: f64) -> Result<ColorSource, Fault> {
        if self.params.is(name, Type::Texture) {
            return self.texture(name);
        }
        let found = color(self.scene, self.space, self.params, name, Role::Albedo)?;
        Ok(found.map_or(grey(or), ColorSource::Constant))
    }

    fn texture(&mut self, name: &'static str) -> Result<ColorSource, Fault> {
        let texture = self.params.texture(name).unwrap_or_default().to_owned();
        source_named(self.scene, &texture, self.params.place_of(name))
    }

    /// A number or a texture.
    fn number(&mut self, name: &'static str) -> Result<Option<ColorSource>, Fault> {
        if self.params.is(name, Type::Texture) {
            return self.texture(name).map(Some);
        }
        Ok(self.params.float(name).map(grey))
    }

    /// The width of the lobe as roughness and anisotropy here: pbrt's distribution has the width α = √roughness, or the roughness itself if it is
    /// not remapped; here it is the square of the roughness.
    fn roughness(&mut self, names: [&'static str; 3], surface: &mut PrincipledMaterial) -> Result<(), Fault> {
        let remap = self.params.bool("remaproughness").unwrap_or(true);
        let through = Through::Roughness { remap };
        let both = self.number(names[0])?;
        let along = self.number(names[1])?.or(both).unwrap_or(grey(0.0));
        let across = self.number(names[2])?.or(both).unwrap_or(grey(0.0));
        let (ColorSource::Constant(u), ColorSource::Constant(v)) = (along, across) else {
            if along != across {
                let message = "a texture of roughness along one direction: it is taken for both";
                self.scene.report.approximated(self.params.place, message);
            }
            let texture = if matches!(along, ColorSource::Texture(_)) { along } else { across };
            surface.specular_roughness = map_values(self.scene, texture, self.params.place, through);
            return Ok(());
        };
        let alpha = |c: Spectrum| {
            let r = through.of(f64::from(c.r));
            r * r
        };
        let (u, v) = (alpha(u), alpha(v));
        let (long, short) = (u.max(v), u.min(v));
        if long - short <= 1e-9 || long <= 0.0 {
            surface.specular_roughness = grey(long.sqrt());
            return Ok(());
        }
        let ratio = short / long;
        // OpenPBR: the longer width is r²·√(2 / (1 + ratio²)).
        surface.specular_roughness = grey((long / (2.0 / (1.0 + ratio * ratio)).sqrt()).sqrt().min(1.0));
        surface.specular_roughness_anisotropy = grey(1.0 - ratio);
        surface.anisotropy_rotation = if u >= v { 0.0 } else { FRAC_PI_2 };
        Ok(())
    }

    /// An index of refraction, with the dispersion of a glass that is named.
    fn with_index(
        &mut self,
        name: &'static str,
        surface: PrincipledMaterial,
    ) -> Result<PrincipledMaterial, Fault> {
        if self.params.is(name, Type::Texture) {
            let message = "a texture of indices of refraction: it is 1.5";
            self.scene.report.ignored(self.params.place_of(name), message);
            self.params.pass(&[name]);
            return Ok(surface);
        }
        if let Some(ior) = self.params.float(name) {
            return Ok(PrincipledMaterial { specular_ior: ior.clamp(1e-3, 100.0), ..surface });
        }
        let Some(param) = self.params.spectrum(name) else { return Ok(surface) };
        let found = curve(self.scene, self.space, param, Role::Unbounded)?;
        if let Curve::Named(name) = &found
            && let Some(glass) = glass_of(name)
        {
            return Ok(PrincipledMaterial {
                specular_ior: glass.ior,
                transmission_dispersion_scale: 1.0,
                transmission_dispersion_abbe_number: glass.abbe,
                ..surface
            });
        }
        let ior = match &found {
            Curve::Sampled(s) => s.mean(),
            other => f64::from(to_color(other, Role::Unbounded)?.g),
        };
        Ok(PrincipledMaterial { specular_ior: ior.clamp(1e-3, 100.0), ..surface })
    }

    fn dielectric(&mut self) -> Result<PrincipledMaterial, Fault> {
        let glass = PrincipledMaterial { transmission_weight: grey(1.0), ..PrincipledMaterial::default() };
        let mut glass = self.with_index("eta", glass)?;
        self.roughness(["roughness", "uroughness", "vroughness"], &mut glass)?;
        Ok(glass)
    }

    /// The colours of a metal by its spectra or its reflectance.
    fn metal(&mut self, [eta, k, reflectance]: [&'static str; 3]) -> Result<(ColorSource, Spectrum), Fault> {
        if self.params.has(reflectance) {
            // pbrt takes η = 1 and the k that reflects so much head-on.
            let color = self.color(reflectance, 0.5)?;
            let ColorSource::Constant(f0) = color else { return Ok((color, Spectrum::WHITE)) };
            let index = f0.map(|r| {
                let r = r.clamp(0.0, 0.9999);
                2.0 * r.sqrt() / (1.0 - r).sqrt()
            });
            let colors = colors_of_index(Spectrum::WHITE, index);
            return Ok((ColorSource::Constant(colors.f0), colors.tint));
        }
        let mut curves = [None, None];
        for (slot, name) in curves.iter_mut().zip([eta, k]) {
            if self.params.is(name, Type::Texture) {
                let message = "a texture of a metal's index of refraction: it is copper";
                self.scene.report.ignored(self.params.place_of(name), message);
                self.params.pass(&[name]);
            } else if let Some(param) = self.params.spectrum(name) {
                *slot = Some(curve(self.scene, self.space, param, Role::Unbounded)?);
            } else if let Some(v) = self.params.float(name) {
                *slot = Some(Curve::Rgb(Spectrum::grey(v as f32)));
            }
        }
        let copper = MetalName::Copper.colors();
        let colors: MetalColors = match curves {
            [None, None] => copper,
            [Some(Curve::Named(a)), b] if b.is_none() || matches!(&b, Some(Curve::Named(_))) => {
                if let Some(Curve::Named(b)) = &b
                    && a.strip_suffix("-eta") != b.strip_suffix("-k")
                {
                    self.scene.report.approximated(
                        self.params.place,
                        "eta and k of different metals: the metal of eta is shown",
                    );
                }
                metal_of(&a).unwrap_or(copper)
            }
            [Some(Curve::Sampled(eta)), Some(Curve::Sampled(k))] => metal_of_index(&eta, &k),
            [eta, k] => {
                let or = |c: Option<Curve>, or: f32| {
                    c.map_or(Ok(Spectrum::grey(or)), |c| to_color(&c, Role::Unbounded))
                };
                colors_of_index(or(eta, 1.0)?, or(k, 0.0)?)
            }
        };
        Ok((ColorSource::Constant(colors.f0), colors.tint))
    }

    fn conductor(&mut self, prefix: &str, names: [&'static str; 3]) -> Result<PrincipledMaterial, Fault> {
        let (color, tint) = self.metal(names)?;
        let mut surface = PrincipledMaterial {
            base_color: color,
            base_metalness: grey(1.0),
            specular_color: ColorSource::Constant(tint),
            ..PrincipledMaterial::default()
        };
        let names = match prefix {
            "" => ["roughness", "uroughness", "vroughness"],
            _ => ["conductor.roughness", "conductor.uroughness", "conductor.vroughness"],
        };
        self.roughness(names, &mut surface)?;
        Ok(surface)
    }

    /// The clear layer of a coated material over a base.
    fn coat(
        &mut self,
        base: PrincipledMaterial,
        names: [&'static str; 3],
        index: &'static str,
    ) -> Result<PrincipledMaterial, Fault> {
        let layer = self.with_index(index, PrincipledMaterial::default())?;
        let mut rough = PrincipledMaterial::default();
        self.roughness(names, &mut rough)?;
        if rough.specular_roughness_anisotropy != grey(0.0) {
            self.scene.report.approximated(
                self.params.place,
                "an anisotropic clear layer: it is equally rough along and across",
            );
        }
        let absorbs = match self.params.spectrum("albedo") {
            None => false,
            Some(param) => curve(self.scene, self.space, param, Role::Albedo)? != Curve::Rgb(Spectrum::BLACK),
        };
        if absorbs {
            self.scene.report.approximated(
                self.params.place_of("albedo"),
                "what scatters within a clear layer: the layer is clear",
            );
        }
        self.params.pass(&["albedo", "g", "maxdepth", "nsamples", "thickness", "interface.thickness"]);
        Ok(PrincipledMaterial {
            coat_weight: grey(1.0),
            coat_roughness: rough.specular_roughness,
            coat_ior: layer.specular_ior,
            ..base
        })
    }

    /// A diffuse base under a clear layer. Light that comes back from the base is reflected at the layer's inner side, and so on: of a base of
    /// reflectance ρ, ρ (1 − R) / (1 − ρ R) gets out, R being what the inner side reflects of diffuse light. With that as its colour a dielectric here,
    /// whose base has what the layer lets in, is the same.
    fn coated_diffuse(&mut self) -> Result<PrincipledMaterial, Fault> {
        let color = self.color("reflectance", 0.5)?;
        let layer =
            self.coat(PrincipledMaterial::default(), ["roughness", "uroughness", "vroughness"], "eta")?;
        let inner = inner_reflectance(layer.coat_ior);
        let color = map_values(self.scene, color, self.params.place, Through::Layer { inner });
        Ok(PrincipledMaterial {
            base_color: color,
            specular_ior: layer.coat_ior,
            specular_roughness: layer.coat_roughness,
            ..PrincipledMaterial::default()
        })
    }

    fn coated_conductor(&mut self) -> Result<PrincipledMaterial, Fault> {
        let base = self.conductor("conductor.", ["conductor.eta", "conductor.k", "reflectance"])?;
        self.coat(
            base,
            ["interface.roughness", "interface.uroughness", "interface.vroughness"],
            "interface.eta",
        )
    }

    /// A thin wall that reflects R and lets T through, both diffuse: with the share w of a translucent part of colour S, half of which comes back,
    /// T = w·S/2 and R = T + (1 − w)·C.
    fn diffuse_transmission(&mut self) -> Result<PrincipledMaterial, Fault> {
        let scale = self.params.float("scale").unwrap_or(1.0).clamp(0.0, 1e6) as f32;
        let sources = [self.color("reflectance", 0.25)?, self.color("transmittance", 0.25)?];
        let thin = PrincipledMaterial { thin_walled: true, ..PrincipledMaterial::matte() };
        let [ColorSource::Constant(r), ColorSource::Constant(t)] = sources else {
            // By textures the two shares cannot be told apart everywhere: half of the light goes through.
            if sources[0] != sources[1] || scale != 1.0 {
                let message = "textures of diffuse transmission: as much light passes as comes back";
                self.scene.report.approximated(self.params.place, message);
            }
            let texture = if matches!(sources[0], ColorSource::Texture(_)) { sources[0] } else { sources[1] };
            let color =
                map_values(self.scene, texture, self.params.place, Through::Scale(2.0 * f64::from(scale)));
            return Ok(PrincipledMaterial { subsurface_weight: grey(1.0), subsurface_color: color, ..thin });
        };
        let (r, t) = (r * scale, t * scale);
        let most = (2.0 * t.max_component()).min(1.0);
        let left = |r: f32, t: f32| r - t;
        let rest = Spectrum::new(left(r.r, t.r), left(r.g, t.g), left(r.b, t.b));
        if rest.to_array().iter().any(|v| *v < -1e-4) {
            self.scene.report.approximated(
                self.params.place,
                "more light passes than comes back: as much comes back here",
            );
        }
        let base = rest.map(|v| if most < 1.0 { (v / (1.0 - most)).clamp(0.0, 1.0) } else { 0.0 });
        let through = t.map(|v| if most > 0.0 { (2.0 * v / most).clamp(0.0, 1.0) } else { 0.0 });
        Ok(PrincipledMaterial {
            base_color: ColorSource::Constant(base),
            subsurface_weight: grey(f64::from(most)),
            subsurface_color: ColorSource::Constant(through),
            ..thin
        })
    }

    fn subsurface(&mut self) -> Result<PrincipledMaterial, Fault> {
        let place = self.params.place;
        let scale = self.params.float("scale").unwrap_or(1.0).max(0.0);
        let named = self.params.string("name").map(str::to_owned);
        let (color, radius) = if self.params.has("reflectance") {
            let color = self.color("reflectance", 0.5)?;
            let mfp = self::color(self.scene, self.space, self.params, "mfp", Role::Unbounded)?;
            let mfp = mfp.unwrap_or(Spectrum::WHITE);
            (color, f64::from((mfp.r + mfp.g + mfp.b) / 3.0) * scale)
        } else {
            let found = named.as_deref().and_then(media::named);
            if let (Some(name), None) = (&named, found) {
                let message =
                    format!("the medium \"{}\" of a subsurface material is not known", printable(name));
                self.scene.report.ignored(self.params.place_of("name"), message);
            }
            let (a, s) = match found {
                Some(found) => found,
                None => {
                    let a = self::color(self.scene, self.space, self.params, "sigma_a", Role::Unbounded)?;
                    let s = self::color(self.scene, self.space, self.params, "sigma_s", Role::Unbounded)?;
                    (
                        a.unwrap_or(Spectrum::new(0.0011, 0.0024, 0.014)),
                        s.unwrap_or(Spectrum::new(2.55, 3.21, 3.77)),
                    )
                }
            };
            let g = self.params.float("g").unwrap_or(0.0).clamp(-0.999, 0.999) as f32;
            let (a, s) = (a.to_array(), s.to_array());
            let mut color = [0.0; 3];
            let mut mean = 0.0;
            for (i, c) in color.iter_mut().enumerate() {
                let scattering = s[i] * (1.0 - g);
                let extinction = a[i] + scattering;
                let albedo = if extinction > 0.0 { scattering / extinction } else { 0.0 };
                // Diffuse reflectance of a half-space under a rough estimate of its skin (van de Hulst's similarity).
                let q = (1.0 - albedo).max(0.0).sqrt();
                *c = (1.0 - q) * (1.0 - 0.139 * q) / (1.0 + 1.17 * q);
                mean += f64::from(extinction) / 3.0;
            }
            let radius = if mean * scale > 0.0 { 1.0 / (mean * scale) } else { 0.0 };
            (ColorSource::Constant(color.into()), radius)
        };
        self.params.pass(&["mfp", "reflectance", "sigma_a", "sigma_s", "g", "name"]);
        self.scene
            .report
            .approximated(place, "a subsurface material: its colour and mean way of light are kept");
        let base = PrincipledMaterial {
            subsurface_weight: grey(1.0),
            subsurface_color: color,
            subsurface_radius: if radius.is_finite() { radius.clamp(0.0, 1e30) } else { 0.0 },
            specular_ior: 1.33,
            ..PrincipledMaterial::default()
        };
        let mut surface = self.with_index("eta", base)?;
        self.roughness(["roughness", "uroughness", "vroughness"], &mut surface)?;
        surface.transmission_dispersion_scale = 0.0;
        Ok(surface)
    }

    fn hair(&mut self) -> Result<PrincipledMaterial, Fault> {
        let place = self.params.place;
        let color = if self.params.has("reflectance") {
            self.color("reflectance", 0.3)?
        } else {
            ColorSource::Constant(Spectrum::new(0.25, 0.14, 0.07))
        };
        self.params.pass(&[
            "sigma_a",
            "eumelanin",
            "pheomelanin",
            "eta",
            "beta_m",
            "beta_n",
            "alpha",
            "reflectance",
        ]);
        self.scene.report.approximated(place, "hair is shown as a glossy dielectric of its colour");
        Ok(PrincipledMaterial {
            base_color: color,
            specular_roughness: grey(0.4),
            specular_ior: 1.55,
            ..PrincipledMaterial::default()
        })
    }

    fn mix(&mut self, usage: Use) -> Result<MaterialDesc, Fault> {
        let place = self.params.place;
        let names = self.params.strings("materials").to_vec();
        let [a, b] = &names[..] else {
            let message = format!("a mix has two materials, found {}", names.len());
            return Err(Fault::at(place, ErrorCode::MissingKey, message)
                .help("as in \"string materials\" [ \"a\" \"b\" ]"));
        };
        let amount = match self.number("amount")? {
            Some(ColorSource::Constant(c)) => ColorSource::Constant(c.map(|v| v.clamp(0.0, 1.0))),
            Some(texture) => texture,
            None => grey(0.5),
        };
        let materials = &mut self.scene.materials;
        let slots = [materials.named(a, place), materials.named(b, place)];
        if slots.iter().any(|s| materials.is_interface(*s)) {
            let message = "a mix with an interface: the other material is there with its share as opacity";
            self.scene.report.approximated(place, message);
            let materials = &mut self.scene.materials;
            let surface = usize::from(materials.is_interface(slots[0]));
            let slot = slots.get(surface).copied().unwrap_or_default();
            let share =
                if surface == 1 { amount } else { map_values(self.scene, amount, place, Through::Rest) };
            let materials = &mut self.scene.materials;
            let id = materials.wanted(slot, Use { alpha: Some(share), ..usage });
            return Ok(MaterialDesc::Mix(MixMaterial { materials: vec![id, id], weights: vec![grey(0.0)] }));
        }
        let ids = slots.map(|slot| materials.wanted(slot, usage.clone()));
        self.params.finish("the material \"mix\"", &mut self.scene.report);
        Ok(MaterialDesc::Mix(MixMaterial { materials: ids.to_vec(), weights: vec![amount] }))
    }

    /// What every surface may have: a texture of heights or a picture of normals.
    fn details(&mut self, surface: &mut PrincipledMaterial) -> Result<(), Fault> {
        if self.params.is("displacement", Type::Texture) {
            let heights = self.texture("displacement")?;
            if matches!(heights, ColorSource::Texture(_)) {
                (surface.bump_map, surface.bump_scale, surface.bump_unit) =
                    (Some(heights), 1.0, BumpUnit::Scene);
            }
        } else {
            self.params.pass(&["displacement"]);
        }
        if let Some(file) = self.params.string("normalmap").map(str::to_owned) {
            surface.normal_map = normal_picture(self.scene, &file, self.params.place_of("normalmap"));
        }
        Ok(())
    }
}

//! pbrt's material types as Turner's principled material (OpenPBR).

use turner::color::Spectrum;
use turner::material::metals::{MAX_INDEX, MetalColors, colors_of_index, index_of_reflectances};
use turner::material::{BumpUnit, MaterialDesc, MixMaterial, PrincipledMaterial};
use turner::math::elementary::exp;
use turner::schema::{ColorSource, ErrorCode};

use super::assembly::Assembly;
use super::layers::{Conductor, Layer};
use super::materials::Use;
use super::params::{Params, Type};
use super::report::Fault;
use super::spectra::{Curve, Role, color, curve, glass_of, metal_of, to_color};
use super::state::ColorSpace;
use super::textures::{normal_picture, source_named};
use crate::scene_import::{Through, inner_reflectance, map_colors, map_values, product};
use crate::spectral::{at_each_wavelength, metal_at, metal_of_index, metal_reflectances, seen_in_daylight};

/// A grey colour.
pub(super) fn grey(v: f64) -> ColorSource {
    ColorSource::Constant(Spectrum::grey(v as f32))
}

/// The reflectance of a conductor.
#[derive(Clone)]
enum Metal {
    Constant {
        colors: MetalColors,
        /// η and k by colour band.
        index: (Spectrum, Spectrum),
        /// Reflectance by wavelength or colour.
        conductor: Conductor,
    },
    Texture(ColorSource),
}

impl Metal {
    fn surface(&self) -> PrincipledMaterial {
        let (color, tint) = match self {
            Metal::Constant { colors, .. } => (ColorSource::Constant(colors.f0), colors.tint),
            Metal::Texture(color) => (*color, Spectrum::WHITE),
        };
        PrincipledMaterial {
            base_color: color,
            base_metalness: grey(1.0),
            specular_color: ColorSource::Constant(tint),
            ..PrincipledMaterial::default()
        }
    }
}

/// Makes one material from its parameters.
pub(super) struct Maker<'a, 'b> {
    pub(super) scene: &'a mut Assembly<'b>,
    pub(super) params: &'a Params,
    pub(super) space: ColorSpace,
}

impl Maker<'_, '_> {
    /// A colour or a texture; `or` if it is not given.
    pub(super) fn color(&mut self, name: &'static str, or: f64) -> Result<ColorSource, Fault> {
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
    pub(super) fn number(&mut self, name: &'static str) -> Result<Option<ColorSource>, Fault> {
        if self.params.is(name, Type::Texture) {
            return self.texture(name).map(Some);
        }
        Ok(self.params.float(name).map(grey))
    }

    /// Roughness and anisotropy. pbrt's GGX has α = √roughness, or α = roughness if it is not remapped;
    /// Turner's α is roughness².
    pub(super) fn roughness(
        &mut self,
        names: [&'static str; 3],
        or: f64,
        surface: &mut PrincipledMaterial,
    ) -> Result<(), Fault> {
        let remap = self.params.bool("remaproughness").unwrap_or(true);
        let through = match remap && self.scene.frame.is_version3 {
            true => Through::RemappedRoughness,
            false => Through::Roughness { remap },
        };
        let both = self.number(names[0])?;
        let along = self.number(names[1])?.or(both).unwrap_or(grey(or));
        let across = self.number(names[2])?.or(both).unwrap_or(grey(or));
        let (ColorSource::Constant(u), ColorSource::Constant(v)) = (along, across) else {
            if along != across {
                let message = "a roughness texture for one direction: used for both";
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
        // OpenPBR: the longer α is r²·√(2 / (1 + ratio²)).
        surface.specular_roughness = grey((long / (2.0 / (1.0 + ratio * ratio)).sqrt()).sqrt().min(1.0));
        surface.specular_roughness_anisotropy = grey(1.0 - ratio);
        surface.anisotropy_rotation = if u >= v { 0.0 } else { 90.0 };
        Ok(())
    }

    /// An index of refraction; a named glass has its dispersion.
    pub(super) fn with_index(
        &mut self,
        name: &'static str,
        surface: PrincipledMaterial,
    ) -> Result<PrincipledMaterial, Fault> {
        if self.params.is(name, Type::Texture) {
            let message = "a texture of an index of refraction: 1.5 replaces it";
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

    pub(super) fn dielectric(&mut self) -> Result<PrincipledMaterial, Fault> {
        let glass = PrincipledMaterial { transmission_weight: grey(1.0), ..PrincipledMaterial::default() };
        let mut glass = self.with_index("eta", glass)?;
        self.roughness(["roughness", "uroughness", "vroughness"], 0.0, &mut glass)?;
        Ok(glass)
    }

    /// The colours of a conductor by its spectra or its reflectance, below a medium with the IOR `outer`.
    fn metal(&mut self, [eta, k, reflectance]: [&'static str; 3], outer: f64) -> Result<Metal, Fault> {
        let by = (1.0 / outer) as f32;
        if self.params.has(reflectance) {
            // pbrt: η = 1, and the k with this reflectance at normal incidence.
            let color = self.color(reflectance, 0.5)?;
            let ColorSource::Constant(f0) = color else { return Ok(Metal::Texture(color)) };
            let index = |r: f64| {
                let r = r.clamp(0.0, 0.9999);
                2.0 * r.sqrt() / (1.0 - r).sqrt()
            };
            let relative = (Spectrum::grey(by), f0.map(|r| index(f64::from(r)) as f32) * by);
            let colors = colors_of_index(relative.0, relative.1);
            let conductor = match self.scene.layers.colors.smooth(f0) {
                Some(smooth) => Conductor::new(at_each_wavelength(|nm| {
                    metal_at(1.0 / outer, index(smooth.at(nm)) / outer)
                })),
                None => Conductor::of_colors(colors),
            };
            return Ok(Metal::Constant { colors, index: relative, conductor });
        }
        let mut curves = [None, None];
        for ((slot, name), copper) in curves.iter_mut().zip([eta, k]).zip(["metal-Cu-eta", "metal-Cu-k"]) {
            if self.params.is(name, Type::Texture) {
                let message = "a texture of a metal's index of refraction: copper replaces it";
                self.scene.report.ignored(self.params.place_of(name), message);
                self.params.pass(&[name]);
            } else if let Some(param) = self.params.spectrum(name) {
                *slot = Some(curve(self.scene, self.space, param, Role::Unbounded)?);
            } else if let Some(v) = self.params.float(name) {
                *slot = Some(Curve::Rgb(Spectrum::grey(v as f32)));
            }
            *slot = slot.take().or_else(|| metal_of(copper).map(Curve::Sampled));
        }
        Ok(match curves {
            [Some(Curve::Sampled(eta)), Some(Curve::Sampled(k))] => {
                let at = |nm: f64| metal_at(eta.at(nm, false) / outer, k.at(nm, false) / outer);
                let [f0, grazing] = metal_reflectances(&eta, &k, outer);
                Metal::Constant {
                    colors: metal_of_index(&eta, &k, outer),
                    index: index_of_reflectances(f0, grazing),
                    conductor: Conductor::new(at_each_wavelength(at)),
                }
            }
            [eta, k] => {
                let or = |c: Option<Curve>, or: f32| {
                    c.map_or(Ok(Spectrum::grey(or)), |c| to_color(&c, Role::Unbounded))
                };
                let index = (or(eta, 1.0)? * by, or(k, 0.0)? * by);
                let colors = colors_of_index(index.0, index.1);
                Metal::Constant { colors, index, conductor: Conductor::of_colors(colors) }
            }
        })
    }

    /// A metal; `or` is the roughness if none is given.
    pub(super) fn conductor(&mut self, or: f64) -> Result<PrincipledMaterial, Fault> {
        let metal = self.metal(["eta", "k", "reflectance"], 1.0)?;
        let mut surface = metal.surface();
        if let Metal::Constant { index: (eta, k), .. } = &metal {
            let within = |c: &Spectrum| Some(c.map(|v| v.clamp(0.0, MAX_INDEX)));
            (surface.metal_eta, surface.metal_k) = (within(eta), within(k));
            surface.specular_color = grey(1.0);
        }
        self.roughness(["roughness", "uroughness", "vroughness"], or, &mut surface)?;
        Ok(surface)
    }

    /// The layer of a coated material: IOR, roughness, and a [`Layer`] if both are constant.
    fn layer(
        &mut self,
        names: [&'static str; 3],
        index: &'static str,
        thickness: &'static str,
    ) -> Result<(f64, ColorSource, Option<Layer>), Fault> {
        let ior = self.with_index(index, PrincipledMaterial::default())?.specular_ior;
        let mut rough = PrincipledMaterial::default();
        self.roughness(names, 0.0, &mut rough)?;
        if rough.specular_roughness_anisotropy != grey(0.0) {
            self.scene
                .report
                .approximated(self.params.place, "an anisotropic clear layer: rendered as isotropic");
        }
        let absorbs = match self.params.spectrum("albedo") {
            None => false,
            Some(param) => curve(self.scene, self.space, param, Role::Albedo)? != Curve::Rgb(Spectrum::BLACK),
        };
        if absorbs {
            self.scene.report.approximated(
                self.params.place_of("albedo"),
                "scattering inside a clear layer: not rendered",
            );
        }
        let is_texture = self.params.is(thickness, Type::Texture);
        if is_texture {
            self.scene.report.approximated(
                self.params.place_of(thickness),
                "a texture of a layer's thickness: 0.01 replaces it",
            );
        }
        let thickness = match is_texture {
            true => None,
            false => self.params.float(thickness),
        };
        let depth = self.params.integer("maxdepth").unwrap_or(10).clamp(1, 100) as u32;
        self.params.pass(&["albedo", "g", "nsamples", "thickness"]);
        let layer = match rough.specular_roughness {
            ColorSource::Constant(r) if ior >= 1.0 => Some(Layer {
                alpha: f64::from(r.g * r.g),
                ior,
                // Scattered light is not absorbed.
                thickness: if absorbs { 0.0 } else { thickness.unwrap_or(0.01).clamp(0.0, 1e3) },
                depth,
            }),
            _ => None,
        };
        Ok((ior, rough.specular_roughness, layer))
    }

    /// A diffuse base under a dielectric layer. The layer's inner side reflects light back to the base: of a
    /// base reflectance ρ, ρ (1 − R) / (1 − ρ R) leaves, with R the inner side's diffuse reflectance. With this
    /// as its base colour, Turner's dielectric reflects the same, since its base receives what the layer
    /// transmits. Rough and absorbing layers pass less ([`Layer`]).
    pub(super) fn coated_diffuse(&mut self) -> Result<PrincipledMaterial, Fault> {
        let spectrum = match self.params.spectrum("reflectance") {
            Some(param) => Some(curve(self.scene, self.space, param, Role::Albedo)?),
            None => None,
        };
        let color = self.color("reflectance", 0.5)?;
        let (ior, roughness, layer) =
            self.layer(["roughness", "uroughness", "vroughness"], "eta", "thickness")?;
        let turns = layer.map(|l| l.depth.div_ceil(2));
        let smooth = inner_reflectance(ior);
        let (gain, inner) =
            layer.and_then(|l| self.scene.layers.over_diffuse(l)).unwrap_or((1.0 - smooth, smooth));
        let f = Through::Layer { gain, inner, turns };
        let color = match (color, spectrum) {
            (_, Some(Curve::Sampled(s))) => {
                ColorSource::Constant(seen_in_daylight(|nm| f.of(s.at(nm, true).clamp(0.0, 1.0))))
            }
            (ColorSource::Constant(c), _) => ColorSource::Constant(self.scene.layers.colors.of(c, f)),
            (texture, _) => {
                let name = format!("by wavelengths {f:?}");
                match self.scene.layers.colors.table(f) {
                    Some(table) => {
                        map_colors(self.scene, texture, self.params.place, &name, &|color| table.at(color))
                    }
                    None => map_values(self.scene, texture, self.params.place, f),
                }
            }
        };
        Ok(PrincipledMaterial {
            base_color: color,
            specular_ior: ior,
            specular_roughness: roughness,
            ..PrincipledMaterial::default()
        })
    }

    /// A conductor under a dielectric layer: OpenPBR's coat, with a colour that reflects as much light as pbrt's.
    pub(super) fn coated_conductor(&mut self) -> Result<PrincipledMaterial, Fault> {
        let names = ["interface.roughness", "interface.uroughness", "interface.vroughness"];
        let (ior, roughness, layer) = self.layer(names, "interface.eta", "interface.thickness")?;
        let metal = self.metal(["conductor.eta", "conductor.k", "reflectance"], ior.max(1e-3))?;
        let mut surface = metal.surface();
        self.roughness(
            ["conductor.roughness", "conductor.uroughness", "conductor.vroughness"],
            0.0,
            &mut surface,
        )?;
        if roughness != grey(0.0) {
            let message = "a rough layer over metal: same reflected energy, different blur of reflections";
            self.scene.report.approximated(self.params.place, message);
        }
        surface.coat_weight = grey(1.0);
        surface.coat_roughness = roughness;
        surface.coat_ior = ior;
        if let Some(layer) = layer {
            let known = match (&metal, surface.specular_roughness) {
                (Metal::Constant { colors, conductor, .. }, ColorSource::Constant(r)) => {
                    self.scene.layers.over_metal(layer, *colors, conductor, f64::from(r.g * r.g))
                }
                _ => None,
            };
            if let Some(known) = known {
                surface.base_color = ColorSource::Constant(known.f0);
            }
            // A coat's colour is its transmittance in and out at normal incidence.
            let absorbed = Spectrum::grey(exp(-2.0 * layer.thickness) as f32);
            surface.coat_color = ColorSource::Constant(known.map_or(absorbed, |known| known.coat));
        }
        Ok(surface)
    }

    /// A thin wall with diffuse reflectance R and transmittance T. With a subsurface weight w, T = w·S for the
    /// subsurface colour S and R = (1 − w)·C for the base colour C.
    pub(super) fn diffuse_transmission(&mut self) -> Result<PrincipledMaterial, Fault> {
        let scale = self.params.float("scale").unwrap_or(1.0).clamp(0.0, 1e6);
        let sources = [self.color("reflectance", 0.25)?, self.color("transmittance", 0.25)?];
        Ok(self.thin_diffuse(sources, scale))
    }

    /// A thin wall with these diffuse reflectance and transmittance.
    pub(super) fn thin_diffuse(&mut self, sources: [ColorSource; 2], scale: f64) -> PrincipledMaterial {
        let thin = PrincipledMaterial { thin_walled: true, ..PrincipledMaterial::matte() };
        let most = |source: ColorSource| match source {
            ColorSource::Constant(c) => Some(f64::from(c.max_component()) * scale),
            ColorSource::Texture(_) => None,
        };
        // The weights are free, because the colours of a thin wall may exceed 1: together it reflects and transmits at
        // most 1.
        let share = match sources.map(most) {
            [Some(r), Some(t)] if r + t > 0.0 => t / (r + t),
            [Some(_), Some(_)] => 0.0,
            _ => 0.5,
        };
        let [base_color, subsurface_color] = [(sources[0], 1.0 - share), (sources[1], share)]
            .map(|(c, share)| if share > 0.0 { product(self.scene, c, grey(scale / share)) } else { c });
        PrincipledMaterial { base_color, subsurface_weight: grey(share), subsurface_color, ..thin }
    }

    pub(super) fn mix(&mut self, usage: Use) -> Result<MaterialDesc, Fault> {
        let place = self.params.place;
        let mut names = self.params.strings("materials").to_vec();
        // In pbrt-v3 `amount` is the weight of the first material.
        if let Some(first) = self.params.string("namedmaterial1").map(str::to_owned) {
            names =
                self.params.string("namedmaterial2").into_iter().map(str::to_owned).chain([first]).collect();
        }
        let [a, b] = &names[..] else {
            let message = format!("a mix has two materials, found {}", names.len());
            return Err(Fault::at(place, ErrorCode::MissingKey, message)
                .help("as in \"string materials\" [ \"a\" \"b\" ]"));
        };
        let given = match self.params.spectrum("amount") {
            Some(_) => Some(self.color("amount", 0.5)?),
            None => self.number("amount")?,
        };
        let amount = match given {
            Some(ColorSource::Constant(c)) => ColorSource::Constant(c.map(|v| v.clamp(0.0, 1.0))),
            Some(texture) => texture,
            None => grey(0.5),
        };
        let materials = &mut self.scene.materials;
        let slots = [materials.named(a, place), materials.named(b, place)];
        if slots.iter().any(|s| materials.is_interface(*s)) {
            let message =
                "a mix with an interface: rendered as the other material with its weight as opacity";
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

    /// The texture of a bump map and its scale: `displacement`, or `bumpmap` of pbrt-v3.
    pub(super) fn bump(&mut self) -> Result<Option<(ColorSource, f64)>, Fault> {
        let name = if self.params.has("bumpmap") { "bumpmap" } else { "displacement" };
        if !self.params.is(name, Type::Texture) {
            self.params.pass(&[name]);
            return Ok(None);
        }
        let heights = self.texture(name)?;
        Ok(matches!(heights, ColorSource::Texture(_)).then_some((heights, 1.0)))
    }

    /// What every material may have: a displacement texture (used as a bump map) or a normal map.
    pub(super) fn details(&mut self, surface: &mut PrincipledMaterial) -> Result<(), Fault> {
        if let Some((heights, scale)) = self.bump()? {
            (surface.bump_map, surface.bump_scale, surface.bump_unit) =
                (Some(heights), scale, BumpUnit::Scene);
        }
        if let Some(file) = self.params.string("normalmap").map(str::to_owned) {
            surface.normal_map = normal_picture(self.scene, &file, self.params.place_of("normalmap"));
        }
        Ok(())
    }
}

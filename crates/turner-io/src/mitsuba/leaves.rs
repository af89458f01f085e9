//! BSDFs that contain no others, as Turner's principled material.

use turner::bsdf::{FacetDistribution, FacetMasking};
use turner::color::Spectrum;
use turner::material::PrincipledMaterial;
use turner::material::metals::{MAX_INDEX, colors_of_index, index_of_reflectances};
use turner::schema::ColorSource;

use super::assembly::Assembly;
use super::materials::{color_of, grey, number_of};
use super::metals;
use super::params::Object;
use super::rough_layer::RoughLayer;
use super::spectra::{Role, color, index, sampled};
use super::textures::Surface;
use crate::scene_import::report::Fault;
use crate::scene_import::{Through, inner_reflectance, map_values, product, unknown};
use crate::spectral::metal_reflectances;

/// Known BSDFs that are not supported.
const UNSUPPORTED: &[&str] =
    &["measured_polarized", "polarizer", "retarder", "circular", "bsdf_hair", "irawan", "hk"];

/// All known BSDFs.
const KNOWN: &[&str] = &[
    "diffuse",
    "dielectric",
    "thindielectric",
    "roughdielectric",
    "conductor",
    "roughconductor",
    "plastic",
    "roughplastic",
    "principled",
    "principledthin",
    "roughdiffuse",
    "twosided",
    "mask",
    "bumpmap",
    "normalmap",
    "blendbsdf",
    "null",
    "measured",
    "hair",
    "pplastic",
    "phong",
    "ward",
    "coating",
    "roughcoating",
    "mixturebsdf",
    "difftrans",
];

/// The material of a BSDF.
pub(super) fn surface(
    scene: &mut Assembly<'_>,
    object: &Object,
    on: Surface,
) -> Result<PrincipledMaterial, Fault> {
    let mut maker = Maker { scene, object, on };
    match object.kind.as_str() {
        "diffuse" => Ok(PrincipledMaterial {
            base_color: maker.color("reflectance", 0.5)?,
            ..PrincipledMaterial::matte()
        }),
        "roughdiffuse" => {
            object.pass(&["use_fast_approx"]);
            let roughness = maker.number("alpha", 0.2)?;
            Ok(PrincipledMaterial {
                base_color: maker.color("reflectance", 0.5)?,
                base_diffuse_roughness: map_values(
                    &mut maker.scene.stock,
                    roughness,
                    object.place,
                    Through::Scale(1.0),
                ),
                ..PrincipledMaterial::matte()
            })
        }
        "dielectric" => maker.dielectric(false),
        "roughdielectric" => maker.dielectric(true),
        "thindielectric" => {
            let glass = maker.dielectric(false)?;
            Ok(PrincipledMaterial { thin_walled: true, ..glass })
        }
        "conductor" => maker.conductor(false),
        "roughconductor" => maker.conductor(true),
        "plastic" => maker.plastic(false),
        "roughplastic" => maker.plastic(true),
        "pplastic" => {
            let message = "pplastic: rendered as roughplastic, without polarization";
            maker.scene.report.approximated(object.place, message);
            maker.plastic(true)
        }
        kind if UNSUPPORTED.contains(&kind) => {
            let message = format!("{} is not supported: rendered as diffuse grey", object.title());
            maker.scene.report.ignored(object.place, message);
            let color = maker.color("diffuse_reflectance", 0.5)?;
            object.pass_all();
            Ok(PrincipledMaterial { base_color: color, ..PrincipledMaterial::matte() })
        }
        other => Err(unknown("bsdf", other, KNOWN).or_at(object.place)),
    }
}

/// A metal.
struct Conductor {
    /// Reflectance at normal incidence.
    f0: Spectrum,
    eta: Spectrum,
    k: Spectrum,
}

impl Conductor {
    fn of_index(eta: Spectrum, k: Spectrum) -> Conductor {
        let within = |c: Spectrum| c.map(|v| v.clamp(0.0, MAX_INDEX));
        Conductor { f0: colors_of_index(eta, k).f0, eta: within(eta), k: within(k) }
    }
}

struct Maker<'a, 'b> {
    scene: &'a mut Assembly<'b>,
    object: &'a Object,
    on: Surface,
}

impl Maker<'_, '_> {
    fn color(&mut self, name: &'static str, or: f64) -> Result<ColorSource, Fault> {
        color_of(self.scene, self.object, name, or, self.on)
    }

    fn number(&mut self, name: &'static str, or: f64) -> Result<ColorSource, Fault> {
        number_of(self.scene, self.object, name, or, self.on)
    }

    /// A colour factor, 1 by default.
    fn factor(&mut self, name: &'static str) -> Result<ColorSource, Fault> {
        self.color(name, 1.0)
    }

    /// Microfacets that light meets once, and their α.
    fn roughness(&mut self, surface: &mut PrincipledMaterial) -> Result<(), Fault> {
        let object = self.object;
        object.pass(&["sample_visible"]);
        surface.specular_distribution = match object.string("distribution")?.unwrap_or("beckmann") {
            "ggx" => FacetDistribution::Ggx,
            "beckmann" => FacetDistribution::Beckmann,
            // Mitsuba 0.6.
            "phong" | "as" => {
                let message = "microfacets of Phong's distribution: Beckmann's of the same α replaces it";
                self.scene.report.approximated(object.place, message);
                FacetDistribution::Beckmann
            }
            other => {
                let all = ["ggx", "beckmann"];
                return Err(unknown("distribution", other, &all).or_at(object.place_of("distribution")));
            }
        };
        let both = self.number("alpha", 0.1)?;
        let (along, across) = match (object.has("alpha_u"), object.has("alpha_v")) {
            (false, false) => (both, both),
            _ => (self.number("alpha_u", 0.1)?, self.number("alpha_v", 0.1)?),
        };
        single_scattering(surface);
        match (along, across) {
            (ColorSource::Constant(u), ColorSource::Constant(v)) => {
                stretched(f64::from(u.g), f64::from(v.g), surface);
            }
            _ => {
                (surface.specular_alpha_x, surface.specular_alpha_y) = (Some(along), Some(across));
                // Not smooth, for those who ask whether it is.
                surface.specular_roughness = grey(0.3);
            }
        }
        Ok(())
    }

    fn index_ratio(&mut self, inside: f64) -> Result<f64, Fault> {
        let outer = index(self.object, "ext_ior", 1.000277)?;
        Ok((index(self.object, "int_ior", inside)? / outer).clamp(1e-3, 100.0))
    }

    fn dielectric(&mut self, is_rough: bool) -> Result<PrincipledMaterial, Fault> {
        let ior = self.index_ratio(1.5046)?;
        let mut glass = PrincipledMaterial {
            transmission_weight: grey(1.0),
            specular_roughness: grey(0.0),
            specular_ior: ior,
            transmission_color: self.factor("specular_transmittance")?,
            ..PrincipledMaterial::default()
        };
        if self.object.has("eta") {
            glass.specular_ior = self.object.float("eta")?.unwrap_or(1.5).clamp(1e-3, 100.0);
        }
        let reflected = self.factor("specular_reflectance")?;
        if reflected != grey(1.0) {
            glass.specular_color = reflected;
            let message = "specular_reflectance of glass: it tints reflection at normal incidence";
            self.scene.report.approximated(self.object.place_of("specular_reflectance"), message);
        }
        if is_rough {
            self.roughness(&mut glass)?;
        }
        Ok(glass)
    }

    /// The conductor; `None` for a perfect mirror.
    fn metal(&mut self) -> Result<Option<Conductor>, Fault> {
        let object = self.object;
        if let Some(name) = object.string("material")? {
            object.pass(&["eta", "k", "ext_eta"]);
            if name == "none" {
                return Ok(None);
            }
            let Some((eta, k)) = metals::index_of(name) else {
                return Err(unknown("material", name, &metals::names()).or_at(object.place_of("material")));
            };
            return Ok(Some(Conductor::of_index(eta, k)));
        }
        let outer = index(object, "ext_eta", 1.0)?;
        let mut found = [None, None];
        for (slot, name) in found.iter_mut().zip(["eta", "k"]) {
            let Some((node, element)) = object.find(name) else { continue };
            let resolved = object.document.resolve(node)?;
            if object.document.node(resolved).is_some_and(|n| n.tag == "texture") {
                let message = format!("a texture of {name}: a perfect mirror replaces the metal");
                self.scene.report.ignored(element.place, message);
                object.pass(&["eta", "k"]);
                return Ok(None);
            }
            *slot = Some((color(self.scene, resolved, Role::Unbounded)?, sampled(self.scene, resolved)?));
        }
        Ok(match found {
            // As in Mitsuba: η = 0 and k = 1 reflect all light.
            [None, None] => None,
            [Some((_, Some(eta))), Some((_, Some(k)))] => {
                let [f0, grazing] = metal_reflectances(&eta, &k, outer);
                let (eta, k) = index_of_reflectances(f0, grazing);
                Some(Conductor::of_index(eta, k))
            }
            [eta, k] => {
                let eta = eta.map_or(Spectrum::BLACK, |c| c.0);
                let k = k.map_or(Spectrum::WHITE, |c| c.0);
                if eta == Spectrum::BLACK {
                    return Ok(None);
                }
                let by = (1.0 / outer) as f32;
                Some(Conductor::of_index(eta * by, k * by))
            }
        })
    }

    fn conductor(&mut self, is_rough: bool) -> Result<PrincipledMaterial, Fault> {
        let factor = self.factor("specular_reflectance")?;
        let mut surface = match self.metal()? {
            None => PrincipledMaterial {
                base_weight: grey(0.0),
                specular_ior: 0.0,
                specular_color: factor,
                specular_roughness: grey(0.0),
                ..PrincipledMaterial::default()
            },
            Some(metal) => {
                let Conductor { f0, eta, k } = metal;
                PrincipledMaterial {
                    metal_eta: Some(eta),
                    metal_k: Some(k),
                    base_color: product(&mut self.scene.stock, ColorSource::Constant(f0), factor),
                    base_metalness: grey(1.0),
                    specular_color: factor,
                    specular_roughness: grey(0.0),
                    ..PrincipledMaterial::default()
                }
            }
        };
        if is_rough {
            self.roughness(&mut surface)?;
        }
        Ok(surface)
    }

    /// A diffuse base under a dielectric layer. As in pbrt's coated materials the base colour accounts for
    /// reflections at the layer's inner side: ρ (1 − R) / (1 − ρ R), or, unless the file sets `nonlinear`, ρ
    /// itself. Under a rough layer it is darker: see [`RoughLayer`].
    fn plastic(&mut self, is_rough: bool) -> Result<PrincipledMaterial, Fault> {
        let ior = self.index_ratio(1.49)?;
        let color = self.color("diffuse_reflectance", 0.5)?;
        let mut surface = PrincipledMaterial {
            specular_ior: ior,
            specular_roughness: grey(0.0),
            ..PrincipledMaterial::default()
        };
        let reflected = self.factor("specular_reflectance")?;
        if reflected != grey(1.0) {
            surface.specular_color = reflected;
            let message = "specular_reflectance of plastic: it tints reflection at normal incidence";
            self.scene.report.approximated(self.object.place_of("specular_reflectance"), message);
        }
        if is_rough {
            self.roughness(&mut surface)?;
        }
        let smooth = inner_reflectance(ior);
        let layer = match surface.specular_roughness {
            ColorSource::Constant(r) if is_rough && ior >= 1.0 => {
                self.scene.materials.rough_layer(surface.specular_distribution, f64::from(r.g * r.g), ior)
            }
            _ => None,
        };
        let (gain, inner) = layer.map_or((1.0 - smooth, smooth), RoughLayer::gain);
        let through = match self.object.boolean("nonlinear")? {
            Some(true) => Through::Layer { gain, inner, turns: None },
            _ => Through::Scale(gain / (1.0 - inner)),
        };
        surface.base_color = match through {
            Through::Scale(1.0) => color,
            through => map_values(&mut self.scene.stock, color, self.object.place, through),
        };
        Ok(surface)
    }
}

/// Microfacets as in Mitsuba: light meets one, masking and shadowing are independent.
fn single_scattering(surface: &mut PrincipledMaterial) {
    surface.specular_multiple_scattering = false;
    surface.specular_masking = FacetMasking::Separable;
}

/// Roughness and anisotropy from α along u and v. OpenPBR: the longer α is r²·√(2 / (1 + ratio²)).
pub(super) fn stretched(u: f64, v: f64, surface: &mut PrincipledMaterial) {
    let (u, v) = (u.clamp(0.0, 1.0), v.clamp(0.0, 1.0));
    let (long, short) = (u.max(v), u.min(v));
    if long - short <= 1e-9 || long <= 0.0 {
        surface.specular_roughness = grey(long.sqrt());
        return;
    }
    let ratio = short / long;
    surface.specular_roughness = grey((long / (2.0 / (1.0 + ratio * ratio)).sqrt()).sqrt().min(1.0));
    surface.specular_roughness_anisotropy = grey(1.0 - ratio);
    surface.anisotropy_rotation = if u >= v { 0.0 } else { 90.0 };
}

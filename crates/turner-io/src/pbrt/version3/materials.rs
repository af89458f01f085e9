//! The materials of pbrt-v3. Its lobes are added; OpenPBR's are layered, so that energy is kept.

use turner::color::Spectrum;
use turner::material::{AlphaMode, BumpUnit, DisneyMaterial, MaterialDesc, PrincipledMaterial};
use turner::schema::ColorSource;

use crate::pbrt::materials::Use;
use crate::pbrt::report::Fault;
use crate::pbrt::surfaces::{Maker, grey};
use crate::scene_import::{Through, map_values, product};

/// The names of roughness along and across the tangent.
const ROUGHNESS: [&str; 3] = ["roughness", "uroughness", "vroughness"];

/// The hemispherical reflectance of a smooth dielectric of IOR 1.5.
const DIFFUSE_FRESNEL: f64 = 0.092;

/// A colour as a weight of at most 1 and a colour whose largest component is 1; textures are the colour.
fn weight_and_color(source: ColorSource) -> (f64, ColorSource) {
    match source {
        ColorSource::Constant(c) if c.max_component() > 0.0 => {
            let weight = c.max_component();
            (f64::from(weight), ColorSource::Constant(c * (1.0 / weight)))
        }
        ColorSource::Constant(_) => (0.0, grey(1.0)),
        texture @ ColorSource::Texture(_) => (1.0, texture),
    }
}

impl Maker<'_, '_> {
    /// A diffuse colour times a factor. Constants stay at most 1, so that energy is conserved.
    fn scaled(&mut self, color: ColorSource, factor: f64) -> ColorSource {
        match product(self.scene, color, grey(factor)) {
            ColorSource::Constant(c) => ColorSource::Constant(c.map(|v| v.min(1.0))),
            texture @ ColorSource::Texture(_) => texture,
        }
    }

    /// One of [`MATERIALS`](super::MATERIALS), without "disney".
    pub(in crate::pbrt) fn version3(&mut self, kind: &str) -> Result<PrincipledMaterial, Fault> {
        match kind {
            "matte" => self.matte(),
            "plastic" => self.plastic(),
            "metal" => self.conductor(0.01),
            "glass" => self.glass(),
            "mirror" => self.mirror(),
            "uber" => self.uber(),
            "substrate" => self.substrate(),
            "translucent" => self.translucent(),
            "kdsubsurface" => self.subsurface(Some("Kd")),
            _ => {
                let message = "a fourier material: rendered as diffuse grey";
                self.scene.report.ignored(self.params.place, message);
                self.params.pass(&["bsdffile"]);
                Ok(PrincipledMaterial { base_color: grey(0.5), ..PrincipledMaterial::matte() })
            }
        }
    }

    /// `sigma` is the standard deviation of Oren and Nayar's facets, in degrees.
    fn matte(&mut self) -> Result<PrincipledMaterial, Fault> {
        let base_color = self.color("Kd", 0.5)?;
        let sigma = self.number("sigma")?.unwrap_or(grey(0.0));
        let to_radians = Through::Scale(1f64.to_radians());
        let base_diffuse_roughness = map_values(self.scene, sigma, self.params.place, to_radians);
        Ok(PrincipledMaterial { base_color, base_diffuse_roughness, ..PrincipledMaterial::matte() })
    }

    /// Diffuse reflection and a glossy lobe, which are added. pbrt-v3's Fresnel reflectance is that of a ray inside the
    /// dielectric: averaged over directions, six times that of a ray outside.
    fn plastic(&mut self) -> Result<PrincipledMaterial, Fault> {
        let ks = self.color("Ks", 0.25)?;
        let (weight, specular_color) = weight_and_color(ks);
        let weight = (6.0 * weight).min(10.0);
        // The mean of a texture is taken for the default of Ks.
        let mean = if matches!(ks, ColorSource::Texture(_)) { 1.5 } else { weight };
        let kd = self.color("Kd", 0.25)?;
        let base_color = self.scaled(kd, 1.0 / (1.0 - (DIFFUSE_FRESNEL * mean).min(0.5)));
        let mut surface = PrincipledMaterial {
            base_color,
            specular_color,
            specular_weight: grey(weight),
            specular_ior: 1.5,
            ..PrincipledMaterial::default()
        };
        self.roughness(ROUGHNESS, 0.1, &mut surface)?;
        Ok(surface)
    }

    fn glass(&mut self) -> Result<PrincipledMaterial, Fault> {
        let glass = PrincipledMaterial { transmission_weight: grey(1.0), ..PrincipledMaterial::default() };
        let mut glass = self.with_index(if self.params.has("eta") { "eta" } else { "index" }, glass)?;
        glass.specular_color = self.color("Kr", 1.0)?;
        glass.transmission_color = self.color("Kt", 1.0)?;
        self.roughness(ROUGHNESS, 0.0, &mut glass)?;
        Ok(glass)
    }

    /// A mirror whose reflectance does not depend on the angle: the tint at 82° cancels the increase of Schlick's
    /// approximation.
    fn mirror(&mut self) -> Result<PrincipledMaterial, Fault> {
        let base_color = self.color("Kr", 0.9)?;
        let tint = |r: f32| {
            // (1 − cos 82°)⁵
            let grazing = 0.4734;
            r / (r + (1.0 - r) * grazing)
        };
        let specular_color = match base_color {
            ColorSource::Constant(c) => ColorSource::Constant(c.map(|r| tint(r.max(1e-3)))),
            ColorSource::Texture(_) => grey(1.0),
        };
        Ok(PrincipledMaterial {
            base_color,
            base_metalness: grey(1.0),
            specular_color,
            specular_roughness: grey(0.0),
            ..PrincipledMaterial::default()
        })
    }

    /// Diffuse and glossy reflection, mirror reflection as a coat, and transmission.
    fn uber(&mut self) -> Result<PrincipledMaterial, Fault> {
        let mut surface = PrincipledMaterial { base_color: self.color("Kd", 0.25)?, ..Default::default() };
        surface = self.with_index(if self.params.has("eta") { "eta" } else { "index" }, surface)?;
        let (glossy, color) = weight_and_color(self.color("Ks", 0.25)?);
        (surface.specular_weight, surface.specular_color) = (grey(glossy.min(1.0)), color);
        let mirror = self.color("Kr", 0.0)?;
        if mirror != grey(0.0) {
            surface.coat_weight = match mirror {
                ColorSource::Constant(c) => grey(f64::from(c.max_component().min(1.0))),
                texture @ ColorSource::Texture(_) => texture,
            };
            (surface.coat_ior, surface.coat_roughness) = (surface.specular_ior.max(1.0), grey(0.0));
            surface.coat_darkening = 0.0;
        }
        match self.color("Kt", 0.0)? {
            texture @ ColorSource::Texture(_) => surface.transmission_weight = texture,
            constant => {
                let (through, color) = weight_and_color(constant);
                let through = through.min(1.0);
                (surface.transmission_weight, surface.transmission_color) = (grey(through), color);
                // OpenPBR's base has the rest of the weight.
                surface.base_color = self.scaled(surface.base_color, 1.0 / (1.0 - through).max(0.1));
            }
        }
        self.roughness(ROUGHNESS, 0.1, &mut surface)?;
        Ok(surface)
    }

    /// A diffuse base under a glossy layer that reflects `Ks` at normal incidence (Ashikhmin and Shirley 2000). Averaged over a
    /// sphere, the albedo of their diffuse lobe is 0.82 · Kd · (1 − Ks); Turner's base receives about 1 − 0.8 · Ks.
    fn substrate(&mut self) -> Result<PrincipledMaterial, Fault> {
        let kd = self.color("Kd", 0.5)?;
        let (weight, specular_color) = match self.color("Ks", 0.5)? {
            texture @ ColorSource::Texture(_) => {
                let message = "a texture Ks of a substrate: its reflectance at normal incidence is 0.5 times its colour";
                self.scene.report.approximated(self.params.place_of("Ks"), message);
                (0.5, texture)
            }
            constant => weight_and_color(constant),
        };
        let weight = weight.clamp(0.0, 0.95);
        let base_color = self.scaled(kd, 0.82 * (1.0 - weight) / (1.0 - 0.8 * weight));
        let root = weight.sqrt();
        let specular_ior = (1.0 + root) / (1.0 - root);
        let mut surface =
            PrincipledMaterial { base_color, specular_color, specular_ior, ..PrincipledMaterial::default() };
        self.roughness(ROUGHNESS, 0.1, &mut surface)?;
        Ok(surface)
    }

    /// A thin sheet with diffuse reflection and transmission.
    fn translucent(&mut self) -> Result<PrincipledMaterial, Fault> {
        let kd = self.color("Kd", 0.25)?;
        let parts = [self.color("reflect", 0.5)?, self.color("transmit", 0.5)?];
        let sources = parts.map(|part| product(self.scene, kd, part));
        if self.color("Ks", 0.25)? != grey(0.0) {
            let message = "the glossy part of a translucent material: not rendered";
            self.scene.report.approximated(self.params.place, message);
        }
        self.params.pass(&["roughness", "remaproughness"]);
        Ok(self.thin_diffuse(sources, 1.0))
    }

    /// `opacity` of "uber"; `None` if it is opaque.
    pub(in crate::pbrt) fn opacity(&mut self) -> Result<Option<ColorSource>, Fault> {
        match self.color("opacity", 1.0)? {
            ColorSource::Constant(c) if c == Spectrum::WHITE => Ok(None),
            ColorSource::Constant(c) => Ok(Some(grey(f64::from(c.r + c.g + c.b) / 3.0))),
            texture @ ColorSource::Texture(_) => Ok(Some(texture)),
        }
    }
}

/// `disney`: Burley's material of 2015.
pub(in crate::pbrt) fn disney(maker: &mut Maker<'_, '_>, usage: Use) -> Result<MaterialDesc, Fault> {
    let mut number = |name, or| -> Result<ColorSource, Fault> { Ok(maker.number(name)?.unwrap_or(grey(or))) };
    let mut made = DisneyMaterial {
        metallic: number("metallic", 0.0)?,
        roughness: number("roughness", 0.5)?,
        spec_tint: number("speculartint", 0.0)?,
        anisotropic: number("anisotropic", 0.0)?,
        sheen: number("sheen", 0.0)?,
        sheen_tint: number("sheentint", 0.5)?,
        clearcoat: number("clearcoat", 0.0)?,
        clearcoat_gloss: number("clearcoatgloss", 1.0)?,
        spec_trans: number("spectrans", 0.0)?,
        flatness: number("flatness", 0.0)?,
        ..DisneyMaterial::default()
    };
    let through = number("difftrans", 1.0)?;
    made.base_color = maker.color("color", 0.5)?;
    made.ior = maker.params.float("eta").unwrap_or(1.5).clamp(1e-3, 100.0);
    made.thin_walled = maker.params.bool("thin").unwrap_or(false);
    if made.thin_walled {
        // 2 is all light.
        made.diff_trans = map_values(maker.scene, through, maker.params.place, Through::Scale(0.5));
    }
    if maker.params.has("scatterdistance") {
        let place = maker.params.place_of("scatterdistance");
        maker.scene.report.ignored(place, "the scattering inside a disney material: rendered as diffuse");
        maker.params.pass(&["scatterdistance"]);
    }
    if let Some((heights, scale)) = maker.bump()? {
        (made.bump_map, made.bump_scale, made.bump_unit) = (Some(heights), scale, BumpUnit::Scene);
    }
    made.alpha_mode = AlphaMode::Opaque;
    if let Some(alpha) = usage.alpha {
        (made.opacity, made.alpha_mode) = (alpha, AlphaMode::Blend);
    }
    if let Some(emission) = usage.emission {
        (made.emission_luminance, made.emission_color) = (emission.radiance, emission.color);
        made.emission_front_only = !emission.two_sided;
    }
    if made.spec_trans != grey(0.0) && !made.thin_walled {
        made.interior = usage.interior;
    }
    Ok(MaterialDesc::Disney(made))
}

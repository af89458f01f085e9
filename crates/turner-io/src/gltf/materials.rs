//! Materials: maps metallic-roughness and its extensions to the parameters of OpenPBR.
//!
//! | glTF | Turner |
//! |---|---|
//! | `baseColor` | `base_color`: factor × sRGB image × vertex colour; `opacity`: the product of their alphas |
//! | `metallic`, `roughness` | `base_metalness` (blue), `specular_roughness` (green) |
//! | `normalTexture`, `occlusionTexture` | `normal_map` with `normal_scale`, `occlusion_map` (red) with its strength |
//! | `emissive` × `emissive_strength` | `emission_color`, `emission_luminance` |
//! | `ior`, `specular` | `specular_ior`, `specular_weight` (alpha), `specular_color` with `specular_model` "gltf" |
//! | `transmission` | `transmission_weight` (red), `transmission_color` is the base colour; thin-walled without a volume |
//! | `volume` | solid object: `transmission_color` at `transmission_depth`, `transmission_tint` is the base colour; `thickness` (green) |
//! | `clearcoat` | `coat_weight` (red), `coat_roughness` (green), its own normals, `coat_ior` 1.5 |
//! | `sheen` | `fuzz_color`, `fuzz_roughness` (alpha) |
//! | `iridescence` | `thin_film_weight` (red), thickness (green) in micrometres |
//! | `anisotropy` | `specular_roughness_anisotropy` and its rotation, or the anisotropy texture |
//! | `dispersion` | `transmission_dispersion_scale` at an Abbe number of 20 |
//! | `diffuse_transmission` | `subsurface_weight` (alpha), `subsurface_color`, thin-walled without a volume |
//! | `volume_scatter` | with `diffuse_transmission`: `subsurface_color`, `subsurface_scatter_anisotropy`; the volume's attenuation is `subsurface_radius` |
//! | `unlit` | `unlit` |

use turner::color::Spectrum;
use turner::material::{AlphaMode, PrincipledMaterial, SpecularModel};
use turner::math::degrees;
use turner::math::elementary::ln;
use turner::schema::ColorSource;
use turner::texture::ImageChannel;

use super::images::Images;
use super::json::{
    Document, Index, Material, MaterialExtensions, MetallicRoughness, SpecularGlossiness, TextureInfo,
};
use super::report::Report;
use super::textures::{Textures, Use};

/// All textures that a material refers to; the flag is true for colours.
pub(super) fn textures_of(material: &Material) -> Vec<(&TextureInfo, bool)> {
    let mut all: Vec<(Option<&TextureInfo>, bool)> = Vec::new();
    if let Some(pbr) = &material.pbr_metallic_roughness {
        all.push((pbr.base_color_texture.as_deref(), true));
        all.push((pbr.metallic_roughness_texture.as_deref(), false));
    }
    all.push((material.normal_texture.as_deref(), false));
    all.push((material.occlusion_texture.as_deref(), false));
    all.push((material.emissive_texture.as_deref(), true));
    if let Some(e) = material.extensions.as_deref() {
        if let Some(x) = &e.specular {
            all.push((x.specular_texture.as_deref(), false));
            all.push((x.specular_color_texture.as_deref(), true));
        }
        if let Some(x) = &e.transmission {
            all.push((x.transmission_texture.as_deref(), false));
        }
        if let Some(x) = &e.volume {
            all.push((x.thickness_texture.as_deref(), false));
        }
        if let Some(x) = &e.clearcoat {
            all.push((x.clearcoat_texture.as_deref(), false));
            all.push((x.clearcoat_roughness_texture.as_deref(), false));
            all.push((x.clearcoat_normal_texture.as_deref(), false));
        }
        if let Some(x) = &e.sheen {
            all.push((x.sheen_color_texture.as_deref(), true));
            all.push((x.sheen_roughness_texture.as_deref(), false));
        }
        if let Some(x) = &e.iridescence {
            all.push((x.iridescence_texture.as_deref(), false));
            all.push((x.iridescence_thickness_texture.as_deref(), false));
        }
        if let Some(x) = &e.anisotropy {
            all.push((x.anisotropy_texture.as_deref(), false));
        }
        if let Some(x) = &e.diffuse_transmission {
            all.push((x.diffuse_transmission_texture.as_deref(), false));
            all.push((x.diffuse_transmission_color_texture.as_deref(), true));
        }
        if let Some(x) = &e.volume_scatter {
            all.push((x.multiscatter_color_texture.as_deref(), true));
        }
        if let Some(x) = &e.specular_glossiness {
            all.push((x.diffuse_texture.as_deref(), true));
            all.push((x.specular_glossiness_texture.as_deref(), true));
        }
    }
    all.into_iter().filter_map(|(info, is_color)| Some((info?, is_color))).collect()
}

/// The texture that determines the UV set for the tangents of meshes with this material.
pub(super) fn normal_map(material: &Material) -> Option<&TextureInfo> {
    let clearcoat = material.extensions.as_deref().and_then(|e| e.clearcoat.as_ref());
    material
        .normal_texture
        .as_deref()
        .or_else(|| clearcoat.and_then(|c| c.clearcoat_normal_texture.as_deref()))
        .or_else(|| material.extensions.as_deref()?.anisotropy.as_ref()?.anisotropy_texture.as_deref())
}

/// Clamps a factor to 0..=1.
fn unit(v: f64) -> f32 {
    v.clamp(0.0, 1.0) as f32
}

/// Clamps a factor to the non-negative range of single precision.
fn positive(v: f64) -> f32 {
    v.clamp(0.0, f64::from(f32::MAX)) as f32
}

fn color(v: [f64; 3]) -> Spectrum {
    let [r, g, b] = v.map(positive);
    Spectrum::new(r, g, b)
}

fn grey(v: f32) -> ColorSource {
    ColorSource::Constant(Spectrum::grey(v))
}

/// The mean free paths of a volume that transmits `attenuation` over `distance`: the longest one, and the paths by
/// channel relative to it.
fn mean_free_paths(attenuation: Spectrum, distance: f64) -> (f64, ColorSource) {
    // A channel without attenuation gets a finite path: a million times the distance.
    let paths = attenuation.to_array().map(|c| {
        let depth = -ln(f64::from(c).clamp(1e-10, 1.0));
        distance / depth.max(1e-6)
    });
    let longest = paths[0].max(paths[1]).max(paths[2]).min(1e30);
    let [r, g, b] = paths.map(|path| (path / longest) as f32);
    (longest, ColorSource::Constant(Spectrum::new(r, g, b)))
}

/// Converts materials; adds the textures that they need to `textures`.
pub(super) struct Converter<'a> {
    pub(super) document: &'a Document,
    pub(super) images: &'a Images,
    pub(super) textures: &'a mut Textures,
    pub(super) report: &'a mut Report,
}

impl Converter<'_> {
    fn picture(&mut self, info: Option<&TextureInfo>, as_what: Use) -> Option<ColorSource> {
        self.textures.picture(self.document, self.images, info?, as_what)
    }

    /// A colour: factor times texture.
    fn color(&mut self, info: &Option<Box<TextureInfo>>, factor: [f64; 3]) -> ColorSource {
        let factor = color(factor);
        self.picture(info.as_deref(), Use::color(factor)).unwrap_or(ColorSource::Constant(factor))
    }

    /// A scalar: factor times one channel of the texture.
    fn number(&mut self, info: &Option<Box<TextureInfo>>, channel: ImageChannel, factor: f32) -> ColorSource {
        self.picture(info.as_deref(), Use::number(channel, factor)).unwrap_or(grey(factor))
    }

    /// Converts the material with this index, or the default material (§3.7.2.1, §5.19). `has_colors`: whether
    /// the mesh has vertex colours.
    pub(super) fn convert(&mut self, material: Option<Index>, has_colors: bool) -> PrincipledMaterial {
        let default = Material::default();
        let json = material.and_then(|m| self.document.materials.get(m.index())).unwrap_or(&default);
        let (none, no_extensions) = (MetallicRoughness::default(), MaterialExtensions::default());
        let extensions = json.extensions.as_deref().unwrap_or(&no_extensions);

        let mut out = PrincipledMaterial { double_sided: json.double_sided, ..PrincipledMaterial::default() };
        let base = match &extensions.specular_glossiness {
            Some(x) => self.specular_glossiness(&mut out, json, x),
            None => {
                let pbr = json.pbr_metallic_roughness.as_deref().unwrap_or(&none);
                let metal_rough = &pbr.metallic_roughness_texture;
                let metallic = unit(pbr.metallic_factor.unwrap_or(1.0));
                let roughness = unit(pbr.roughness_factor.unwrap_or(1.0));
                out.base_metalness = self.number(metal_rough, ImageChannel::B, metallic);
                out.specular_roughness = self.number(metal_rough, ImageChannel::G, roughness);
                (pbr.base_color_texture.as_deref(), pbr.base_color_factor.unwrap_or([1.0; 4]))
            }
        };
        self.base_color(&mut out, json, base, has_colors);
        self.surface(&mut out, json);
        self.specular(&mut out, extensions);
        self.transmission(&mut out, extensions);
        self.layers(&mut out, extensions);
        out.unlit = extensions.unlit.is_some();
        out
    }

    fn base_color(
        &mut self,
        out: &mut PrincipledMaterial,
        json: &Material,
        (info, [r, g, b, a]): (Option<&TextureInfo>, [f64; 4]),
        has_colors: bool,
    ) {
        let factor = color([r, g, b]);
        out.base_color = self.picture(info, Use::color(factor)).unwrap_or(ColorSource::Constant(factor));
        out.alpha_mode = match json.alpha_mode.as_deref().unwrap_or("OPAQUE") {
            "MASK" => AlphaMode::Mask,
            "BLEND" => AlphaMode::Blend,
            other => {
                if other != "OPAQUE" {
                    self.report.doubtful("a material with an unknown alphaMode: rendered as opaque");
                }
                AlphaMode::Opaque
            }
        };
        out.alpha_cutoff = f64::from(positive(json.alpha_cutoff.unwrap_or(0.5)));
        let colors = has_colors.then(|| self.textures.vertex_color());
        if let Some(colors) = colors {
            out.base_color = self.textures.product(out.base_color, colors);
        }
        if out.alpha_mode != AlphaMode::Opaque {
            let alpha = unit(a);
            out.opacity = self.picture(info, Use::number(ImageChannel::A, alpha)).unwrap_or(grey(alpha));
            if let Some(colors) = colors {
                out.opacity = self.textures.product(out.opacity, colors);
            }
        }
    }

    fn surface(&mut self, out: &mut PrincipledMaterial, json: &Material) {
        out.normal_map = self.picture(json.normal_texture.as_deref(), Use::numbers());
        out.normal_scale = json.normal_texture.as_deref().and_then(|n| n.scale).unwrap_or(1.0);
        let red = Use::number(ImageChannel::R, 1.0);
        out.occlusion_map = self.picture(json.occlusion_texture.as_deref(), red);
        let strength = json.occlusion_texture.as_deref().and_then(|o| o.strength);
        out.occlusion_strength = f64::from(unit(strength.unwrap_or(1.0)));
        let emissive = json.emissive_factor.as_deref().copied().unwrap_or([0.0; 3]);
        if emissive.iter().any(|v| *v > 0.0) {
            out.emission_color = self.color(&json.emissive_texture, emissive);
            let strength = json.extensions.as_deref().and_then(|e| e.emissive_strength.as_ref());
            out.emission_luminance =
                f64::from(positive(strength.and_then(|s| s.emissive_strength).unwrap_or(1.0)));
        }
    }

    fn specular(&mut self, out: &mut PrincipledMaterial, extensions: &MaterialExtensions) {
        if let Some(ior) = extensions.ior.as_ref().and_then(|x| x.ior) {
            out.specular_ior = ior.clamp(0.0, 100.0);
        }
        if let Some(x) = &extensions.specular {
            out.specular_model = SpecularModel::Gltf;
            let weight = unit(x.specular_factor.unwrap_or(1.0));
            out.specular_weight = self.number(&x.specular_texture, ImageChannel::A, weight);
            let factor = x.specular_color_factor.unwrap_or([1.0; 3]);
            out.specular_color = self.color(&x.specular_color_texture, factor);
        }
        if let Some(x) = &extensions.anisotropy {
            out.specular_roughness_anisotropy = grey(unit(x.anisotropy_strength));
            out.anisotropy_rotation = degrees(x.anisotropy_rotation);
            out.anisotropy_map = self.picture(x.anisotropy_texture.as_deref(), Use::numbers());
        }
    }

    fn transmission(&mut self, out: &mut PrincipledMaterial, extensions: &MaterialExtensions) {
        let solid = extensions.volume.as_ref().filter(|v| v.thickness_factor > 0.0);
        if let Some(x) = &extensions.transmission {
            let weight = unit(x.transmission_factor);
            out.transmission_weight = self.number(&x.transmission_texture, ImageChannel::R, weight);
            // Transmitted light is tinted by the base colour.
            out.transmission_color = out.base_color;
            out.thin_walled = solid.is_none();
        }
        if let Some(x) = &extensions.diffuse_transmission {
            let weight = unit(x.diffuse_transmission_factor);
            let picture = &x.diffuse_transmission_texture;
            out.subsurface_weight = self.number(picture, ImageChannel::A, weight);
            let factor = x.diffuse_transmission_color_factor.unwrap_or([1.0; 3]);
            out.subsurface_color = self.color(&x.diffuse_transmission_color_texture, factor);
            out.thin_walled = solid.is_none();
        }
        if let Some(x) = solid {
            let thickness = positive(x.thickness_factor);
            out.thickness = self.number(&x.thickness_texture, ImageChannel::G, thickness);
            let attenuation = color(x.attenuation_color.unwrap_or([1.0; 3]));
            let distance = x.attenuation_distance.filter(|d| *d > 0.0);
            if let (Some(distance), true) = (distance, attenuation != Spectrum::WHITE) {
                if extensions.transmission.is_some() {
                    out.transmission_tint = out.base_color;
                }
                out.transmission_color = ColorSource::Constant(attenuation);
                out.transmission_depth = distance;
                (out.subsurface_radius, out.subsurface_radius_scale) = mean_free_paths(attenuation, distance);
            }
            self.scattering(out, extensions);
        }
        if let Some(x) = &extensions.dispersion {
            out.transmission_dispersion_scale = f64::from(positive(x.dispersion));
        }
    }

    /// Subsurface scattering of a solid object.
    fn scattering(&mut self, out: &mut PrincipledMaterial, extensions: &MaterialExtensions) {
        let Some(x) = &extensions.volume_scatter else { return };
        let factor = x.multiscatter_color_factor.unwrap_or([0.0; 3]);
        if extensions.diffuse_transmission.is_none() {
            if factor.iter().any(|v| *v > 0.0) {
                self.report.approximated("glass with volume scattering: rendered as clear");
            }
            return;
        }
        out.subsurface_color = self.color(&x.multiscatter_color_texture, factor);
        out.subsurface_scatter_anisotropy = x.scatter_anisotropy.clamp(-1.0, 1.0);
    }

    fn layers(&mut self, out: &mut PrincipledMaterial, extensions: &MaterialExtensions) {
        if let Some(x) = &extensions.clearcoat {
            let weight = unit(x.clearcoat_factor);
            out.coat_weight = self.number(&x.clearcoat_texture, ImageChannel::R, weight);
            let roughness = unit(x.clearcoat_roughness_factor);
            out.coat_roughness = self.number(&x.clearcoat_roughness_texture, ImageChannel::G, roughness);
            out.coat_ior = 1.5;
            // The clearcoat extension only subtracts the coat's reflection from the base.
            out.coat_darkening = 0.0;
            out.specular_model = SpecularModel::Gltf;
            let normals = x.clearcoat_normal_texture.as_deref();
            out.coat_normal_map = self.picture(normals, Use::numbers());
            out.coat_normal_scale = normals.and_then(|n| n.scale).unwrap_or(1.0);
        }
        if let Some(x) = &extensions.sheen
            && x.sheen_color_factor.iter().any(|v| *v > 0.0)
        {
            out.fuzz_weight = grey(1.0);
            out.fuzz_color = self.color(&x.sheen_color_texture, x.sheen_color_factor);
            let roughness = unit(x.sheen_roughness_factor);
            out.fuzz_roughness = self.number(&x.sheen_roughness_texture, ImageChannel::A, roughness);
        }
        if let Some(x) = &extensions.iridescence {
            let weight = unit(x.iridescence_factor);
            out.thin_film_weight = self.number(&x.iridescence_texture, ImageChannel::R, weight);
            out.thin_film_ior = x.iridescence_ior.unwrap_or(1.3).clamp(1.0, 100.0);
            // Nanometres to micrometres; the green channel interpolates between minimum and maximum.
            let least = positive(x.iridescence_thickness_minimum.unwrap_or(100.0) / 1000.0);
            let most = positive(x.iridescence_thickness_maximum.unwrap_or(400.0) / 1000.0);
            let green = Use { offset: least, ..Use::number(ImageChannel::G, most - least) };
            let picture = self.picture(x.iridescence_thickness_texture.as_deref(), green);
            out.thin_film_thickness = picture.unwrap_or(grey(most));
        }
    }

    /// The archived specular-glossiness workflow: a diffuse base under a dielectric whose reflectance at normal incidence
    /// is the specular colour. Without a diffuse colour it is a metal. Returns the base colour's texture and factor.
    fn specular_glossiness<'x>(
        &mut self,
        out: &mut PrincipledMaterial,
        json: &Material,
        x: &'x SpecularGlossiness,
    ) -> (Option<&'x TextureInfo>, [f64; 4]) {
        let diffuse = x.diffuse_factor.unwrap_or([1.0; 4]);
        let specular = x.specular_factor.unwrap_or([1.0; 3]);
        let gloss = unit(x.glossiness_factor.unwrap_or(1.0));
        let picture = x.specular_glossiness_texture.as_deref();
        let smooth = Use { offset: 1.0, ..Use::number(ImageChannel::A, -gloss) };
        out.specular_roughness = self.picture(picture, smooth).unwrap_or(grey(1.0 - gloss));
        out.base_metalness = grey(0.0);
        let [r, g, b, alpha] = diffuse;
        let is_opaque = matches!(json.alpha_mode.as_deref(), None | Some("OPAQUE"));
        if [r, g, b].iter().all(|v| *v <= 0.0) && is_opaque {
            out.base_metalness = grey(1.0);
            let [r, g, b] = specular;
            return (picture, [r, g, b, alpha]);
        }
        // A dielectric of index 1.5 reflects 0.04 at normal incidence.
        out.specular_model = SpecularModel::Gltf;
        let factor = color(specular.map(|v| v / 0.04));
        out.specular_color =
            self.picture(picture, Use::color(factor)).unwrap_or(ColorSource::Constant(factor));
        (x.diffuse_texture.as_deref(), diffuse)
    }
}

#[cfg(test)]
mod tests;

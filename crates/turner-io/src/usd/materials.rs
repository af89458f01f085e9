//! Materials: UsdPreviewSurface as the principled material.
//!
//! | UsdPreviewSurface | Turner |
//! |---|---|
//! | `diffuseColor` | `base_color` |
//! | `metallic`, `roughness` | `base_metalness`, `specular_roughness` |
//! | `ior` | `specular_ior` |
//! | `specularColor` with `useSpecularWorkflow` | `specular_color` of a dielectric that reflects it at normal incidence |
//! | `clearcoat`, `clearcoatRoughness` | `coat_weight`, `coat_roughness` |
//! | `opacity`, `opacityThreshold` | `opacity`, blended, or cut out with a threshold |
//! | `emissiveColor` | `emission_color` |
//! | `normal`, `occlusion` | `normal_map`, `occlusion_map` |

use std::collections::BTreeMap;
use std::rc::Rc;

use turner::color::Spectrum;
use turner::image::Pixels;
use turner::material::{AlphaMode, MaterialDesc, PrincipledMaterial, SpecularModel};
use turner::schema::{ColorSource, ImageId, MaterialId, MeshData, Named, WarningKind};
use turner::texture::{Encoding, ImageChannel, ImageDesc, TextureDesc, VertexColorDesc, Wrap};

use super::network::{Input, Network, Texture, surface};
use super::scene::Scene;
use super::value::Value;
use crate::assets::{AssetSource, printable};
use crate::scene_import::Place;
use crate::scene_import::report::Fault;

/// Diffuse reflectance without a material.
const GREY: f32 = 0.5;
/// What a dielectric of index 1.5 reflects at normal incidence.
const F0: f32 = 0.04;

/// What tells materials apart: the path, the number of each of its sets of texture coordinates in the mesh, the use of
/// vertex colours, a colour instead.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Key {
    path: Option<String>,
    sets: Vec<(String, usize)>,
    colors: Colors,
    color: Option<[u32; 3]>,
}

/// What the vertices of a mesh have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Colors {
    Nothing,
    Opaque,
    SeeThrough,
}

impl Colors {
    /// Those of a mesh.
    pub(super) fn of(mesh: &MeshData) -> Colors {
        match mesh.colors.is_empty() {
            true => Colors::Nothing,
            false if mesh.colors.iter().any(|c| c[3] < 1.0) => Colors::SeeThrough,
            false => Colors::Opaque,
        }
    }
}

/// Networks by the path of their material; `None` for those without a known surface.
#[derive(Debug, Default)]
pub(super) struct Looks {
    networks: BTreeMap<String, Option<Rc<Network>>>,
}

fn grey(v: f32) -> ColorSource {
    ColorSource::Constant(Spectrum::grey(v))
}

impl Scene<'_> {
    /// The surface of a material, read once.
    fn network(&mut self, path: &str) -> Result<Option<Rc<Network>>, Fault> {
        if let Some(known) = self.looks.networks.get(path) {
            return Ok(known.clone());
        }
        let made = match surface(self.stage, path)? {
            Ok(network) => Some(Rc::new(network)),
            Err(instead) => {
                let name = printable(super::paths::name(path));
                let message = format!(
                    "the material \"{name}\" {instead}, not a UsdPreviewSurface: the display colour or grey replaces it"
                );
                self.warn(WarningKind::Approximated, message);
                None
            }
        };
        self.looks.networks.insert(path.to_owned(), made.clone());
        Ok(made)
    }

    /// The sets of texture coordinates that materials use, each once.
    pub(super) fn uv_sets(&mut self, paths: &[Option<String>]) -> Result<Vec<String>, Fault> {
        /// Most sets of a mesh.
        const MOST: usize = 8;
        let mut sets: Vec<String> = Vec::new();
        for path in paths.iter().flatten() {
            if let Some(network) = self.network(path)? {
                for set in network.sets() {
                    if !sets.contains(set) && sets.len() < MOST {
                        sets.push(set.clone());
                    }
                }
            }
        }
        if sets.is_empty() {
            sets.push("st".to_owned());
        }
        Ok(sets)
    }

    /// The material of a mesh with these sets of texture coordinates.
    pub(super) fn material(
        &mut self,
        path: Option<&str>,
        sets: &[String],
        colors: Colors,
    ) -> Result<MaterialId, Fault> {
        self.material_of(path, sets, colors, None)
    }

    /// The material of a shape without vertices, which may have a colour.
    pub(super) fn material_or_color(
        &mut self,
        path: Option<&str>,
        color: Option<[f32; 3]>,
    ) -> Result<MaterialId, Fault> {
        self.material_of(path, &[], Colors::Nothing, color)
    }

    fn material_of(
        &mut self,
        path: Option<&str>,
        sets: &[String],
        colors: Colors,
        color: Option<[f32; 3]>,
    ) -> Result<MaterialId, Fault> {
        let network = match path {
            Some(path) => self.network(path)?,
            None => None,
        };
        let mut own: Vec<(String, usize)> = Vec::new();
        for set in network.iter().flat_map(|n| n.sets()) {
            let number = sets.iter().position(|s| s == set).unwrap_or(0);
            own.push((set.clone(), number));
        }
        own.sort();
        own.dedup();
        let needs_colors =
            network.as_ref().is_none_or(|n| n.inputs.values().any(|input| matches!(input, Input::Colors)));
        let key = Key {
            path: network.as_ref().and(path).map(str::to_owned),
            sets: own,
            colors: if needs_colors { colors } else { Colors::Nothing },
            color: color.filter(|_| needs_colors).map(|c| c.map(f32::to_bits)),
        };
        if let Some(known) = self.material_ids.get(&key) {
            return Ok(*known);
        }
        let value = match &network {
            Some(network) => self.preview(network, &key),
            None => self.plain(&key),
        };
        let name = key.path.as_deref().map(|path| super::paths::name(path).to_owned());
        let id = self.add_material(Named { name, span: None, value: MaterialDesc::Principled(value) });
        self.material_ids.insert(key, id);
        Ok(id)
    }

    /// Adds a material, or finds an equal one among the last.
    pub(super) fn add_material(&mut self, material: Named<MaterialDesc>) -> MaterialId {
        let same = self.materials.iter().rev().take(16).position(|m| *m == material);
        if let Some(back) = same {
            return MaterialId((self.materials.len() - 1 - back) as u32);
        }
        self.materials.push(material);
        MaterialId(self.materials.len() as u32 - 1)
    }

    /// The colour of a mesh or a shape, or grey.
    fn display_color(&mut self, key: &Key) -> ColorSource {
        match key.color {
            _ if key.colors != Colors::Nothing => {
                let fallback = Spectrum::grey(GREY);
                self.stock.texture(TextureDesc::VertexColor(VertexColorDesc { fallback }))
            }
            Some(bits) => {
                let [r, g, b] = bits.map(f32::from_bits).map(|v| if v > 0.0 { v.min(1e6) } else { 0.0 });
                ColorSource::Constant(Spectrum::new(r, g, b))
            }
            None => grey(GREY),
        }
    }

    /// The material of what has none.
    fn plain(&mut self, key: &Key) -> PrincipledMaterial {
        let base_color = self.display_color(key);
        let is_see_through = key.colors == Colors::SeeThrough;
        PrincipledMaterial {
            base_color,
            specular_roughness: grey(0.5),
            opacity: if is_see_through { base_color } else { grey(1.0) },
            alpha_mode: if is_see_through { AlphaMode::Blend } else { AlphaMode::Opaque },
            ..PrincipledMaterial::default()
        }
    }

    fn preview(&mut self, network: &Network, key: &Key) -> PrincipledMaterial {
        let number = |name: &str| match network.inputs.get(name) {
            Some(Input::Value(v)) => v.real(),
            _ => None,
        };
        let ior = number("ior").unwrap_or(1.5).clamp(1.0, 100.0);
        let mut out = PrincipledMaterial {
            base_color: self.color(network, key, "diffuseColor", Spectrum::grey(0.18)),
            specular_roughness: self.unit(network, key, "roughness", 0.5),
            specular_ior: ior,
            alpha_mode: AlphaMode::Opaque,
            ..PrincipledMaterial::default()
        };
        if number("useSpecularWorkflow").is_some_and(|v| v != 0.0) {
            out.specular_model = SpecularModel::Gltf;
            out.specular_ior = 1.5;
            let f0 = self.scaled_color(network, key, "specularColor", Spectrum::BLACK, 1.0 / F0);
            out.specular_color = f0;
        } else {
            out.base_metalness = self.unit(network, key, "metallic", 0.0);
        }
        out.coat_weight = self.unit(network, key, "clearcoat", 0.0);
        if out.coat_weight != grey(0.0) {
            out.coat_roughness = self.unit(network, key, "clearcoatRoughness", 0.01);
            out.coat_ior = ior;
            out.coat_darkening = 0.0;
        }
        let emission = self.color(network, key, "emissiveColor", Spectrum::BLACK);
        if emission != ColorSource::Constant(Spectrum::BLACK) {
            (out.emission_color, out.emission_luminance) = (emission, 1.0);
        }
        out.opacity = self.unit(network, key, "opacity", 1.0);
        let threshold = number("opacityThreshold").unwrap_or(0.0);
        if threshold > 0.0 {
            (out.alpha_mode, out.alpha_cutoff) = (AlphaMode::Mask, threshold.min(1.0));
        } else if out.opacity != grey(1.0) {
            out.alpha_mode = AlphaMode::Blend;
        }
        if let Some(Input::Texture(texture)) = network.inputs.get("normal") {
            out.normal_map = self.normals(texture, key);
        }
        if network.inputs.contains_key("occlusion") {
            let occlusion = self.unit(network, key, "occlusion", 1.0);
            out.occlusion_map = Some(occlusion).filter(|o| matches!(o, ColorSource::Texture(_)));
        }
        if network.inputs.get("displacement").is_some_and(|input| match input {
            Input::Value(v) => v.real().is_some_and(|v| v != 0.0),
            _ => true,
        }) {
            self.ignored("displacement of materials");
        }
        for (name, input) in &network.inputs {
            if let Input::Unknown(what) = input {
                let message = format!("{} connected to {name}: its default replaces it", printable(what));
                self.ignored(message);
            }
        }
        out
    }

    fn color(&mut self, network: &Network, key: &Key, name: &str, otherwise: Spectrum) -> ColorSource {
        self.scaled_color(network, key, name, otherwise, 1.0)
    }

    /// An input with a colour, times a factor.
    fn scaled_color(
        &mut self,
        network: &Network,
        key: &Key,
        name: &str,
        otherwise: Spectrum,
        factor: f32,
    ) -> ColorSource {
        let sound = |v: f64| if v > 0.0 { v.min(1e30) as f32 } else { 0.0 };
        let of = |v: &[f64]| match v {
            [r, g, b, ..] => Some(Spectrum::new(sound(*r), sound(*g), sound(*b)) * factor),
            _ => None,
        };
        let otherwise = ColorSource::Constant(otherwise * factor);
        match network.inputs.get(name) {
            Some(Input::Value(Value::Vector(v))) => of(v).map_or(otherwise, ColorSource::Constant),
            Some(Input::Colors) => self.display_color(key),
            Some(Input::Texture(texture)) => {
                let made = self.picture_of(texture, key, Use { factor, is_normal: false });
                let fallback = texture.fallback.and_then(|v| of(&v));
                made.unwrap_or(fallback.map_or(otherwise, ColorSource::Constant))
            }
            _ => otherwise,
        }
    }

    /// An input from 0 to 1.
    fn unit(&mut self, network: &Network, key: &Key, name: &str, otherwise: f32) -> ColorSource {
        let sound = |v: f64| if v > 0.0 { v.min(1.0) as f32 } else { 0.0 };
        match network.inputs.get(name) {
            Some(Input::Value(v)) => v.real().map_or(grey(otherwise), |v| grey(sound(v))),
            Some(Input::Colors) => self.display_color(key),
            Some(Input::Texture(texture)) => {
                let made = self.picture_of(texture, key, Use { factor: 1.0, is_normal: false });
                made.unwrap_or(grey(texture.fallback.map_or(otherwise, |[v, ..]| sound(v))))
            }
            _ => grey(otherwise),
        }
    }

    /// A normal map: Turner reads 0..1 as −1..1, USD has a scale of 2 and a bias of −1 for that.
    fn normals(&mut self, texture: &Texture, key: &Key) -> Option<ColorSource> {
        self.picture_of(texture, key, Use { factor: 1.0, is_normal: true })
    }

    /// An image that a layer names.
    pub(super) fn picture(&mut self, layer: &str, name: &str) -> Option<ImageId> {
        if name.contains("<UDIM>") {
            self.ignored("textures of several tiles (<UDIM>)");
            return None;
        }
        match AssetSource::resolve(self.stock.assets, layer, name) {
            Ok(path) => self.stock.image(&path, Place::default()),
            Err(error) => {
                let text = error.to_string();
                let first = text.lines().next().unwrap_or_default();
                self.ignored(format!("the image {first}; omitted"));
                None
            }
        }
    }

    fn picture_of(&mut self, texture: &Texture, key: &Key, how: Use) -> Option<ColorSource> {
        let file = self.picture(&texture.layer, &texture.file)?;
        let image = self.stock.images.get(file.index())?.data.clone();
        let channel = match texture.output.as_str() {
            "r" => ImageChannel::R,
            "g" => ImageChannel::G,
            "b" => ImageChannel::B,
            "a" => ImageChannel::A,
            _ => ImageChannel::Rgb,
        };
        let is_display = matches!(image.pixels, Pixels::U8(_)) && image.channels >= 3;
        let is_srgb = match texture.color_space.as_str() {
            "sRGB" => true,
            "raw" => false,
            _ => is_display && !how.is_normal,
        };
        let component = match channel {
            ImageChannel::R => Some(0),
            ImageChannel::G => Some(1),
            ImageChannel::B => Some(2),
            ImageChannel::A => Some(3),
            ImageChannel::Rgb => None,
        };
        let of = |v: [f32; 4]| match component {
            Some(i) => Spectrum::grey(v[i]),
            None => Spectrum::new(v[0], v[1], v[2]),
        };
        let bias = texture.bias.unwrap_or([0.0; 4]);
        let (tint, offset) = match (how.is_normal, texture.bias) {
            (true, None) => (Spectrum::WHITE, Spectrum::BLACK),
            (true, Some(_)) => (of(texture.scale) * 0.5, of(bias.map(|b| 0.5 * (b + 1.0)))),
            (false, _) => (of(texture.scale) * how.factor, of(bias) * how.factor),
        };
        let wrap = |word: &str| match word {
            "clamp" => Wrap::Clamp,
            "mirror" => Wrap::Mirror,
            "black" => Wrap::Black,
            _ => Wrap::Repeat,
        };
        let set = key.sets.iter().find(|(name, _)| *name == texture.set).map_or(0, |(_, number)| *number);
        Some(self.stock.texture(TextureDesc::Image(ImageDesc {
            file,
            wrap_u: Some(wrap(&texture.wrap[0])),
            wrap_v: Some(wrap(&texture.wrap[1])),
            uv_matrix: texture.matrix,
            channel,
            encoding: if is_srgb { Encoding::Srgb } else { Encoding::Linear },
            tint,
            offset,
            uv_set: set as u32,
            ..ImageDesc::default()
        })))
    }
}

/// How a texture is used.
#[derive(Clone, Copy)]
struct Use {
    factor: f32,
    is_normal: bool,
}

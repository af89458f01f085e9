//! Materials: maps OpenPBR parameters to metallic-roughness and its extensions, the inverse of the table in
//! `gltf::materials`.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Map, Value, json};
use turner::bsdf::{FacetDistribution, FacetMasking};
use turner::color::Spectrum;
use turner::description::SceneDesc;
use turner::material::{AlphaMode, MaterialDesc, PrincipledMaterial};
use turner::math::radians;
use turner::schema::{ColorSource, MaterialId, SceneError};
use turner::texture::ImageChannel;

use super::json::{put, put_all, sets_asked_for, unit, unit_color};
use super::remarks::Remarks;
use super::textures::{Product, TextureWriter, Used, is_channel};

/// Material, number of UV sets of the mesh, and whether vertex colours are used.
type Key = (Option<MaterialId>, usize, bool);

/// The document's materials.
pub(super) struct MaterialWriter<'a> {
    desc: &'a SceneDesc,
    pub(super) textures: TextureWriter<'a>,
    pub(super) list: Vec<Value>,
    /// Indices of materials with a normal map; their meshes need tangents.
    pub(super) normal_mapped: BTreeSet<usize>,
    /// Number of UV sets that each material needs.
    pub(super) uv_sets: Vec<usize>,
    known: BTreeMap<Key, usize>,
    pub(super) extensions: BTreeSet<&'static str>,
}

/// Context of writing a material.
struct Job<'r> {
    uv_sets: usize,
    remarks: &'r mut Remarks,
}

impl<'a> MaterialWriter<'a> {
    pub(super) fn new(desc: &'a SceneDesc, textures: TextureWriter<'a>) -> Self {
        MaterialWriter {
            desc,
            textures,
            list: Vec::new(),
            normal_mapped: BTreeSet::new(),
            uv_sets: Vec::new(),
            known: BTreeMap::new(),
            extensions: BTreeSet::new(),
        }
    }

    /// The index of a material for meshes with this number of UV sets, and whether it uses vertex colours.
    pub(super) fn number(
        &mut self,
        id: Option<MaterialId>,
        uv_sets: usize,
        remarks: &mut Remarks,
    ) -> Result<(usize, bool), SceneError> {
        let default = MaterialDesc::default();
        let named = id.and_then(|id| self.desc.materials.get(id.index()));
        let mut desc = named.map_or(&default, |m| &m.value);
        for _ in 0..16 {
            let MaterialDesc::Mix(mix) = desc else { break };
            remarks.approximated("mixed materials: only the first is written");
            let first = mix.materials.first().and_then(|id| self.desc.materials.get(id.index()));
            desc = first.map_or(&default, |m| &m.value);
        }
        if matches!(desc, MaterialDesc::Interface(_)) {
            remarks.ignored("participating media");
        }
        let material = desc.principled().unwrap_or_default();
        let colors = self.textures.product(material.base_color, 0, &mut Remarks::default()).vertex_colors;
        if let Some(known) = self.known.get(&(id, uv_sets, colors)) {
            return Ok((*known, colors));
        }
        let name = named.and_then(|m| m.name.as_deref());
        let mut job = Job { uv_sets, remarks };
        let written = self.write(&material, name, &mut job)?;
        self.uv_sets.push(sets_asked_for(&written));
        self.list.push(written);
        let number = self.list.len() - 1;
        if self.list[number].get("normalTexture").is_some() {
            self.normal_mapped.insert(number);
        }
        self.known.insert((id, uv_sets, colors), number);
        Ok((number, colors))
    }

    /// A colour: its factor and texture.
    fn color(
        &mut self,
        source: ColorSource,
        job: &mut Job<'_>,
    ) -> Result<(Product, Option<Used>), SceneError> {
        let product = self.textures.product(source, 0, job.remarks);
        let used = match &product.picture {
            Some(picture) => {
                if !is_channel(picture, ImageChannel::Rgb) {
                    job.remarks.approximated("colours from one channel of an image: all channels are used");
                }
                self.textures.used(picture, job.uv_sets, true, job.remarks)?
            }
            None => None,
        };
        Ok((product, used))
    }

    /// A scalar: its factor, and the texture if it uses the given channel.
    fn value(
        &mut self,
        source: ColorSource,
        channel: ImageChannel,
        job: &mut Job<'_>,
    ) -> Result<(f64, Option<Value>), SceneError> {
        let product = self.textures.product(source, 0, job.remarks);
        let factor = f64::from(product.factor.r + product.factor.g + product.factor.b) / 3.0;
        match &product.picture {
            Some(picture) if is_channel(picture, channel) => {
                let used = self.textures.used(picture, job.uv_sets, false, job.remarks)?;
                Ok((factor, used.map(|u| u.info)))
            }
            Some(_) => {
                job.remarks.approximated(
                    "textures in other channels than glTF's: half their factor is written instead",
                );
                Ok((0.5 * factor, None))
            }
            None => Ok((factor, None)),
        }
    }

    fn write(
        &mut self,
        m: &PrincipledMaterial,
        name: Option<&str>,
        job: &mut Job<'_>,
    ) -> Result<Value, SceneError> {
        let mut out = Map::new();
        let mut ext = Map::new();
        if let Some(name) = name {
            put(&mut out, "name", name);
        }
        let mut pbr = Map::new();
        let (transmission, transmission_texture) = self.value(m.transmission_weight, ImageChannel::R, job)?;
        // glTF tints transmitted light by the base colour.
        let base = match (transmission > 0.5, m.transmission_depth > 0.0) {
            (false, _) => m.base_color,
            (true, true) => m.transmission_tint,
            (true, false) if m.transmission_tint == ColorSource::Constant(Spectrum::WHITE) => {
                m.transmission_color
            }
            (true, false) => {
                job.remarks.approximated("glass with two surface colours: the tint is written");
                m.transmission_tint
            }
        };
        let (base, base_used) = self.color(base, job)?;
        let (weight, _) = self.value(m.base_weight, ImageChannel::Rgb, job)?;
        let mut factor = base.factor * weight as f32;
        let (subsurface, _) = self.value(m.subsurface_weight, ImageChannel::A, job)?;
        if subsurface > 0.0 {
            job.remarks.approximated("subsurface scattering: written as diffuse reflection");
            let (color, _) = self.color(m.subsurface_color, job)?;
            factor = factor.lerp(color.factor, subsurface.clamp(0.0, 1.0) as f32);
        }
        if factor.max_component() > 1.0 {
            job.remarks.approximated("surface colours above 1: clamped");
        }
        let alpha = self.alpha(m, base_used.as_ref(), &mut out, job)?;
        let [r, g, b] = unit_color(factor);
        if [r, g, b, alpha] != [1.0; 4] {
            put(&mut pbr, "baseColorFactor", json!([r, g, b, alpha]));
        }
        if let Some(used) = base_used {
            put(&mut pbr, "baseColorTexture", used.info);
        }
        self.metal_and_roughness(m, &mut pbr, job)?;
        put(&mut out, "pbrMetallicRoughness", pbr);
        self.normals(m, &mut out, job)?;
        self.emission(m, &mut out, &mut ext, job)?;
        self.specular(m, &mut ext, job)?;
        if transmission > 0.0 {
            let mut x = Map::new();
            put(&mut x, "transmissionFactor", transmission.clamp(0.0, 1.0));
            if let Some(texture) = transmission_texture {
                put(&mut x, "transmissionTexture", texture);
            }
            put(&mut ext, "KHR_materials_transmission", x);
            if !m.thin_walled {
                self.volume(m, &mut ext, job)?;
            }
        }
        self.layers(m, &mut ext, job)?;
        if m.interior.is_some() {
            job.remarks.ignored("participating media");
        }
        if m.bump_map.is_some() {
            job.remarks.ignored("bump maps (bump_map)");
        }
        if m.base_diffuse_roughness != ColorSource::Constant(Spectrum::BLACK) {
            job.remarks.approximated("diffuse roughness (base_diffuse_roughness): written as 0");
        }
        if m.unlit {
            put(&mut ext, "KHR_materials_unlit", json!({}));
        }
        // A solid transmissive object is rendered from both sides anyway, and `doubleSided` would mark it as
        // thin.
        if m.double_sided && !ext.contains_key("KHR_materials_volume") {
            put(&mut out, "doubleSided", true);
        }
        for name in EXTENSIONS {
            if ext.contains_key(*name) {
                self.extensions.insert(name);
            }
        }
        if !ext.is_empty() {
            put(&mut out, "extensions", ext);
        }
        Ok(Value::Object(out))
    }

    /// Writes the alpha mode; returns the factor of alpha.
    fn alpha(
        &mut self,
        m: &PrincipledMaterial,
        base: Option<&Used>,
        out: &mut Map<String, Value>,
        job: &mut Job<'_>,
    ) -> Result<f64, SceneError> {
        let opacity = self.textures.product(m.opacity, 0, job.remarks);
        let factor = unit((opacity.factor.r + opacity.factor.g + opacity.factor.b) / 3.0);
        let is_whole = opacity.picture.is_none() && !opacity.vertex_colors && factor >= 1.0;
        if m.alpha_mode == AlphaMode::Opaque || is_whole {
            return Ok(1.0);
        }
        let same_picture = |p: &turner::texture::ImageDesc| {
            base.is_some_and(|b| b.desc.file == p.file && b.desc.uv_matrix == p.uv_matrix)
        };
        if let Some(picture) = &opacity.picture
            && !(same_picture(picture) && matches!(picture.channel, ImageChannel::A | ImageChannel::Rgb))
        {
            job.remarks.ignored("opacity from another image than the base colour");
            return Ok(1.0);
        }
        match m.alpha_mode {
            AlphaMode::Blend => put(out, "alphaMode", "BLEND"),
            _ => {
                put(out, "alphaMode", "MASK");
                put(out, "alphaCutoff", m.alpha_cutoff);
            }
        }
        Ok(factor)
    }

    fn metal_and_roughness(
        &mut self,
        m: &PrincipledMaterial,
        pbr: &mut Map<String, Value>,
        job: &mut Job<'_>,
    ) -> Result<(), SceneError> {
        let (metal, metal_texture) = self.value(m.base_metalness, ImageChannel::B, job)?;
        let (rough, rough_texture) = self.value(m.specular_roughness, ImageChannel::G, job)?;
        put(pbr, "metallicFactor", metal.clamp(0.0, 1.0));
        put(pbr, "roughnessFactor", rough.clamp(0.0, 1.0));
        let texture = match (metal_texture, rough_texture) {
            (Some(a), Some(b)) if a == b => Some(a),
            // A material without metalness needs no metalness texture.
            (None, Some(b)) if metal == 0.0 => Some(b),
            (None, None) => None,
            (a, b) => {
                job.remarks
                    .approximated("metalness and roughness with separate textures: only one is written");
                a.or(b)
            }
        };
        if let Some(texture) = texture {
            put(pbr, "metallicRoughnessTexture", texture);
        }
        Ok(())
    }

    /// The texture of a normal map or occlusion map.
    fn data(&mut self, source: Option<ColorSource>, job: &mut Job<'_>) -> Result<Option<Value>, SceneError> {
        let Some(source) = source else { return Ok(None) };
        let product = self.textures.product(source, 0, job.remarks);
        let Some(picture) = &product.picture else { return Ok(None) };
        Ok(self.textures.used(picture, job.uv_sets, false, job.remarks)?.map(|u| u.info))
    }

    fn normals(
        &mut self,
        m: &PrincipledMaterial,
        out: &mut Map<String, Value>,
        job: &mut Job<'_>,
    ) -> Result<(), SceneError> {
        if let Some(mut texture) = self.data(m.normal_map, job)? {
            if m.normal_scale != 1.0 {
                texture["scale"] = json!(m.normal_scale);
            }
            put(out, "normalTexture", texture);
        }
        if let Some(mut texture) = self.data(m.occlusion_map, job)? {
            if m.occlusion_strength != 1.0 {
                texture["strength"] = json!(m.occlusion_strength);
            }
            put(out, "occlusionTexture", texture);
        }
        Ok(())
    }

    fn emission(
        &mut self,
        m: &PrincipledMaterial,
        out: &mut Map<String, Value>,
        ext: &mut Map<String, Value>,
        job: &mut Job<'_>,
    ) -> Result<(), SceneError> {
        if m.emission_luminance <= 0.0 {
            return Ok(());
        }
        let (color, used) = self.color(m.emission_color, job)?;
        let color = color.factor * m.emission_luminance as f32;
        let most = color.max_component();
        if most <= 0.0 || most.is_nan() {
            return Ok(());
        }
        let strength = most.max(1.0);
        put(out, "emissiveFactor", json!(unit_color(color * (1.0 / strength))));
        if let Some(used) = used {
            put(out, "emissiveTexture", used.info);
        }
        if strength > 1.0 {
            put(ext, "KHR_materials_emissive_strength", json!({ "emissiveStrength": strength }));
        }
        if m.emission_front_only && m.double_sided {
            job.remarks.approximated("one-sided emission of double-sided materials: written as two-sided");
        }
        Ok(())
    }

    fn specular(
        &mut self,
        m: &PrincipledMaterial,
        ext: &mut Map<String, Value>,
        job: &mut Job<'_>,
    ) -> Result<(), SceneError> {
        if !m.specular_multiple_scattering {
            job.remarks.approximated("single-scattering microfacets (specular_multiple_scattering = false)");
        }
        if m.specular_distribution != FacetDistribution::Ggx || m.specular_masking != FacetMasking::Correlated
        {
            job.remarks.approximated("microfacets of another distribution or masking: written as GGX");
        }
        if m.specular_alpha_x.is_some() || m.specular_alpha_y.is_some() {
            job.remarks.approximated("specular_alpha_x and specular_alpha_y: specular_roughness is written");
        }
        let ior = if m.specular_ior > 0.0 && m.specular_ior < 1.0 {
            job.remarks.approximated("indices of refraction below 1: written as 1");
            1.0
        } else {
            m.specular_ior
        };
        if ior != 1.5 {
            put(ext, "KHR_materials_ior", json!({ "ior": ior }));
        }
        let (weight, texture) = self.value(m.specular_weight, ImageChannel::A, job)?;
        let (color, used) = self.color(m.specular_color, job)?;
        if weight != 1.0 || texture.is_some() || color.factor != Spectrum::WHITE || used.is_some() {
            let mut x = Map::new();
            put(&mut x, "specularFactor", weight.clamp(0.0, 1.0));
            // In glTF the colour may exceed 1, the weight may not.
            let factor = color.factor * weight.max(1.0) as f32;
            put(&mut x, "specularColorFactor", json!(factor.to_array().map(|v| v.max(0.0))));
            if let Some(texture) = texture {
                put(&mut x, "specularTexture", texture);
            }
            if let Some(used) = used {
                put(&mut x, "specularColorTexture", used.info);
            }
            put(ext, "KHR_materials_specular", x);
        }
        Ok(())
    }

    fn volume(
        &mut self,
        m: &PrincipledMaterial,
        ext: &mut Map<String, Value>,
        job: &mut Job<'_>,
    ) -> Result<(), SceneError> {
        let (thickness, texture) = self.value(m.thickness, ImageChannel::G, job)?;
        let mut x = Map::new();
        // glTF requires a thickness above 0 for volumes.
        put(&mut x, "thicknessFactor", if thickness > 0.0 { thickness } else { 1.0 });
        if let Some(texture) = texture {
            put(&mut x, "thicknessTexture", texture);
        }
        if m.transmission_depth > 0.0 {
            let (color, _) = self.color(m.transmission_color, job)?;
            put(&mut x, "attenuationDistance", m.transmission_depth);
            put(&mut x, "attenuationColor", json!(unit_color(color.factor)));
        }
        put(ext, "KHR_materials_volume", x);
        if m.transmission_dispersion_scale > 0.0 {
            let dispersion = m.transmission_dispersion_scale * 20.0 / m.transmission_dispersion_abbe_number;
            put(ext, "KHR_materials_dispersion", json!({ "dispersion": dispersion }));
        }
        Ok(())
    }

    fn layers(
        &mut self,
        m: &PrincipledMaterial,
        ext: &mut Map<String, Value>,
        job: &mut Job<'_>,
    ) -> Result<(), SceneError> {
        let (coat, texture) = self.value(m.coat_weight, ImageChannel::R, job)?;
        if coat > 0.0 {
            let (rough, rough_texture) = self.value(m.coat_roughness, ImageChannel::G, job)?;
            let mut x = Map::new();
            put(&mut x, "clearcoatFactor", coat.clamp(0.0, 1.0));
            put(&mut x, "clearcoatRoughnessFactor", rough.clamp(0.0, 1.0));
            let normals = self.data(m.coat_normal_map, job)?;
            let named = [
                ("clearcoatTexture", texture),
                ("clearcoatRoughnessTexture", rough_texture),
                ("clearcoatNormalTexture", normals),
            ];
            put_all(&mut x, named);
            put(ext, "KHR_materials_clearcoat", x);
            if m.coat_ior != 1.5 || m.coat_color != ColorSource::Constant(Spectrum::WHITE) {
                job.remarks.approximated("colour and index of refraction of coats");
            }
        }
        let (fuzz, _) = self.value(m.fuzz_weight, ImageChannel::R, job)?;
        if fuzz > 0.0 {
            let (color, used) = self.color(m.fuzz_color, job)?;
            let (rough, rough_texture) = self.value(m.fuzz_roughness, ImageChannel::A, job)?;
            let mut x = Map::new();
            put(&mut x, "sheenColorFactor", json!(unit_color(color.factor * fuzz as f32)));
            put(&mut x, "sheenRoughnessFactor", rough.clamp(0.0, 1.0));
            let named =
                [("sheenColorTexture", used.map(|u| u.info)), ("sheenRoughnessTexture", rough_texture)];
            put_all(&mut x, named);
            put(ext, "KHR_materials_sheen", x);
        }
        let (film, texture) = self.value(m.thin_film_weight, ImageChannel::R, job)?;
        if film > 0.0 {
            let (thickness, _) = self.value(m.thin_film_thickness, ImageChannel::G, job)?;
            let mut x = Map::new();
            put(&mut x, "iridescenceFactor", film.clamp(0.0, 1.0));
            put(&mut x, "iridescenceIor", m.thin_film_ior.max(1.0));
            // Micrometres to nanometres.
            put(&mut x, "iridescenceThicknessMaximum", thickness * 1000.0);
            if let Some(texture) = texture {
                put(&mut x, "iridescenceTexture", texture);
            }
            put(ext, "KHR_materials_iridescence", x);
        }
        let (anisotropy, _) = self.value(m.specular_roughness_anisotropy, ImageChannel::R, job)?;
        if anisotropy > 0.0 {
            let mut x = Map::new();
            put(&mut x, "anisotropyStrength", anisotropy.clamp(0.0, 1.0));
            put(&mut x, "anisotropyRotation", radians(m.anisotropy_rotation));
            if let Some(texture) = self.data(m.anisotropy_map, job)? {
                put(&mut x, "anisotropyTexture", texture);
            }
            put(ext, "KHR_materials_anisotropy", x);
        }
        Ok(())
    }
}

/// The extensions that materials may use.
const EXTENSIONS: &[&str] = &[
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
];

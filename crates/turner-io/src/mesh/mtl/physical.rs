//! Converts an MTL material to the closest physically based material.
//!
//! | MTL | physically based |
//! |---|---|
//! | `Kd`, `map_Kd` | `base_color`: the image times `Kd`, or only the image if `Kd` is black |
//! | `Ks`, `map_Ks` | `specular_color` is the hue, `specular_weight` twice the largest component, at most 1 (exporters write 0.5 for an ordinary plastic, which becomes 1); 1 without `Ks` |
//! | `illum` 0, 1 | no specular reflection |
//! | `illum` 3, 5 | a mirror in addition to the diffuse part: `base_metalness` = Ks / (Kd + Ks) by the largest components, `base_color` = Kd + Ks, roughness 0 |
//! | `illum` 4, 6, 7, 9, or `d` < 1 with `Ni` > 1 | glass: `transmission_weight` 1 (1 − `d` if `d` < 1), `specular_ior` = `Ni`, `transmission_color` = `Tf`, roughness 0 |
//! | `d` or `Tr` otherwise, `map_d` | `opacity`; images that are nearly all black and white become masks |
//! | `Ns` | `specular_roughness` = (2 / (Ns + 2))^¼: the GGX lobe as wide as the Phong lobe (Walter et al. 2007, "Microfacet models for refraction", sec. 5.3: alpha² = 2 / (Ns + 2), and alpha is the square of the roughness) |
//! | `Ke`, `map_Ke` | `emission_color`; without it `Ka` if above 1, because some files mark lights that way |
//! | `Pr`, `Pm`, `Ps`, `Pc`, `Pcr`, `aniso`, `anisor`, `norm` | roughness, metalness, fuzz, coat, coat roughness, anisotropy, its rotation (1 is 360 degrees), normal map. They override the keys above |
//! | `map_Bump`, `bump` | a normal map if the mean colour is that of one, else a height map (`bump_map`), whose unit is a guess |
//! | `disp`, `decal`, `refl`, `map_Ns`, `map_Ka` | ignored |
//!
//! `Kd`, `Ks`, … are linear values. Colour images are sRGB, other images linear. Options: `-s` and `-o` give
//! u' = s·u + o; `-mm` base and gain of the values; `-clamp` clamps to the edge; `-imfchan` selects the channel; `-bm` is the
//! strength of a bump or normal map.

use std::collections::BTreeMap;

use turner::color::Spectrum;
use turner::image::Image;
use turner::material::{AlphaMode, BumpUnit, PrincipledMaterial};
use turner::math::elementary::pow;
use turner::schema::{ColorSource, WarningKind};
use turner::texture::{Encoding, ImageChannel, ImageDesc, TextureDesc, Wrap};

use super::{MtlMap, MtlMaterial};
use crate::image::ColorOrData;
use crate::mesh::pictures::{PictureName, Pictures};

/// Warnings about materials, with their counts.
pub(in crate::mesh) type Remarks = BTreeMap<(WarningKind, String), u64>;

/// Texture maps without a counterpart.
const IGNORED: [&str; 5] = ["disp", "decal", "refl", "map_ns", "map_ka"];
/// Texture maps with colours; the others are data.
const COLORS: [&str; 3] = ["map_kd", "map_ks", "map_ke"];

/// The images that a material of the library `from` needs.
pub(in crate::mesh) fn wanted(
    material: &MtlMaterial,
    from: &str,
    all: &mut BTreeMap<PictureName, ColorOrData>,
) {
    for (key, map) in material.maps.iter().filter(|(key, _)| !IGNORED.contains(key)) {
        let used_as = if COLORS.contains(key) { ColorOrData::Color } else { ColorOrData::Data };
        let slot = all.entry((from.to_owned(), map.file.clone())).or_insert(used_as);
        if used_as == ColorOrData::Color {
            *slot = used_as;
        }
    }
}

fn grey(v: f32) -> ColorSource {
    ColorSource::Constant(Spectrum::grey(v))
}

fn spectrum([r, g, b]: [f32; 3]) -> Spectrum {
    Spectrum::new(r, g, b)
}

fn largest(c: [f32; 3]) -> f32 {
    c[0].max(c[1]).max(c[2])
}

/// A material, with the images of its library `from`.
struct Converter<'a> {
    from: &'a str,
    material: &'a MtlMaterial,
    pictures: &'a mut Pictures,
    remarks: &'a mut Remarks,
}

/// Converts a material.
pub(in crate::mesh) fn physical(
    material: &MtlMaterial,
    from: &str,
    pictures: &mut Pictures,
    remarks: &mut Remarks,
) -> PrincipledMaterial {
    let mut mapping = Converter { from, material, pictures, remarks };
    for key in IGNORED {
        if material.maps.contains_key(key) {
            let message = format!("images after `{key}` in materials are ignored");
            mapping.remark(WarningKind::Ignored, message);
        }
    }
    let mut out = PrincipledMaterial::default();
    mapping.base(&mut out);
    mapping.specular(&mut out);
    mapping.transparency(&mut out);
    mapping.emission(&mut out);
    mapping.layers(&mut out);
    mapping.relief(&mut out);
    out
}

impl Converter<'_> {
    fn remark(&mut self, kind: WarningKind, message: impl Into<String>) {
        *self.remarks.entry((kind, message.into())).or_default() += 1;
    }

    /// The texture of a keyword, if present: a colour times `tint`, or one channel of data.
    fn picture(&mut self, key: &str, tint: Spectrum) -> Option<ColorSource> {
        let map = self.material.maps.get(key)?;
        let (file, _) = self.pictures.image(&(self.from.to_owned(), map.file.clone()))?;
        let is_color = COLORS.contains(&key);
        let whole = is_color || matches!(key, "norm" | "map_bump" | "map_d");
        let channel = match map.channel {
            Some(b'r') => ImageChannel::R,
            Some(b'g') => ImageChannel::G,
            Some(b'b') => ImageChannel::B,
            Some(b'm') => ImageChannel::A,
            _ if whole => ImageChannel::Rgb,
            _ => ImageChannel::R,
        };
        let encoding = if is_color { Encoding::Srgb } else { Encoding::Linear };
        let desc = image_desc(file, map, channel, encoding, tint);
        Some(self.pictures.texture(TextureDesc::Image(desc)))
    }

    fn image(&self, key: &str) -> Option<&Image> {
        let map = self.material.maps.get(key)?;
        Some(self.pictures.image(&(self.from.to_owned(), map.file.clone()))?.1)
    }

    fn base(&mut self, out: &mut PrincipledMaterial) {
        let m = self.material;
        let diffuse = m.diffuse.unwrap_or([0.8; 3]);
        let has_map = m.maps.contains_key("map_kd");
        let tint = if has_map && (m.diffuse.is_none() || diffuse == [0.0; 3]) { [1.0; 3] } else { diffuse };
        let picture = self.picture("map_kd", spectrum(tint));
        out.base_color = picture.unwrap_or(ColorSource::Constant(spectrum(diffuse)));
        let metalness = m.metalness.unwrap_or(f32::from(m.maps.contains_key("map_pm")));
        out.base_metalness = self.picture("map_pm", Spectrum::grey(metalness)).unwrap_or(grey(metalness));
        let mirror =
            matches!(m.illum, Some(3 | 5)) && m.metalness.is_none() && !m.maps.contains_key("map_pm");
        let specular = m.specular.unwrap_or([0.0; 3]);
        if mirror && largest(specular) > 0.0 {
            let fraction = largest(specular)
                / (largest(specular) + if picture.is_some() { 1.0 } else { largest(diffuse) });
            out.base_metalness = grey(fraction.clamp(0.0, 1.0));
            if picture.is_none() {
                let sum = [0, 1, 2].map(|i| (diffuse[i] + specular[i]).min(1.0));
                out.base_color = ColorSource::Constant(spectrum(sum));
            }
        }
    }

    fn specular(&mut self, out: &mut PrincipledMaterial) {
        let m = self.material;
        let is_physical = m.metalness.is_some() || m.roughness.is_some();
        let strength = m.specular.map_or(1.0, largest);
        let weight = match m.illum {
            Some(0 | 1) if !is_physical => 0.0,
            // Metals reflect specularly in any case.
            _ if m.metalness.is_some_and(|v| v > 0.0) || out.base_metalness != grey(0.0) => 1.0,
            _ => (2.0 * strength).min(1.0),
        };
        out.specular_weight = grey(weight);
        if let Some(specular) = m.specular.filter(|_| strength > 0.0 && out.base_metalness == grey(0.0)) {
            let hue = spectrum(specular.map(|v| v / strength));
            out.specular_color = self.picture("map_ks", hue).unwrap_or(ColorSource::Constant(hue));
        }
        let roughness = match (m.roughness, m.exponent, m.illum) {
            (Some(r), ..) => r,
            (None, _, Some(3..=7 | 9)) => 0.0,
            (None, Some(n), _) => pow(2.0 / (f64::from(n) + 2.0), 0.25) as f32,
            // The texture gives the roughness.
            (None, None, _) if m.maps.contains_key("map_pr") => 1.0,
            (None, None, _) => 0.5,
        };
        out.specular_roughness = self.picture("map_pr", Spectrum::grey(roughness)).unwrap_or(grey(roughness));
        out.specular_roughness_anisotropy = grey(m.anisotropy.unwrap_or(0.0));
        // MTL counts revolutions; `anisotropy_rotation` is in degrees.
        out.anisotropy_rotation = f64::from(m.anisotropy_rotation.unwrap_or(0.0)) * 360.0;
    }

    fn transparency(&mut self, out: &mut PrincipledMaterial) {
        let m = self.material;
        let dissolve = m.dissolve.unwrap_or(1.0);
        let ior = m.ior.unwrap_or(1.0);
        let by_illum = matches!(m.illum, Some(4 | 6 | 7 | 9));
        let is_clear = dissolve < 1.0 && ior > 1.0;
        if let Some(ior) = m.ior.filter(|n| *n > 1.0) {
            out.specular_ior = f64::from(ior).min(100.0);
        }
        if by_illum || is_clear {
            let fraction = if dissolve < 1.0 { 1.0 - dissolve } else { 1.0 };
            out.transmission_weight = grey(fraction);
            let filter = m.filter.filter(|f| largest(*f) > 0.0).unwrap_or([1.0; 3]);
            out.transmission_color = ColorSource::Constant(spectrum(filter));
            if m.roughness.is_none() {
                out.specular_roughness = grey(0.0);
            }
            if !by_illum {
                let message = "transparent materials (`d` below 1) with an index of refraction (`Ni`): rendered as glass";
                self.remark(WarningKind::Approximated, message);
            }
        }
        let opacity = if by_illum || is_clear { 1.0 } else { dissolve };
        let key = if m.maps.contains_key("map_d") { "map_d" } else { "map_tr" };
        if key == "map_tr" && m.maps.contains_key(key) {
            self.remark(WarningKind::Ignored, "images after `map_tr` in materials are ignored");
        } else if let Some(picture) = self.picture(key, Spectrum::grey(opacity)) {
            out.opacity = picture;
            let is_mask = self.image(key).is_some_and(is_mask);
            out.alpha_mode = if is_mask && opacity == 1.0 { AlphaMode::Mask } else { AlphaMode::Blend };
            return;
        }
        if opacity < 1.0 {
            out.opacity = grey(opacity);
            out.alpha_mode = AlphaMode::Blend;
        } else {
            out.alpha_mode = AlphaMode::Opaque;
        }
    }

    fn emission(&mut self, out: &mut PrincipledMaterial) {
        let m = self.material;
        let mut color = m.emission.unwrap_or([0.0; 3]);
        if let Some(ambient) = m.ambient.filter(|a| m.emission.is_none() && largest(*a) > 1.0) {
            color = ambient;
            let message = "ambient colours (`Ka`) above 1: read as emission";
            self.remark(WarningKind::Approximated, message);
        }
        let has_map = m.maps.contains_key("map_ke");
        if has_map && largest(color) == 0.0 {
            color = [1.0; 3];
        }
        let picture = self.picture("map_ke", spectrum(color));
        if picture.is_some() || largest(color) > 0.0 && !has_map {
            out.emission_luminance = 1.0;
            out.emission_color = picture.unwrap_or(ColorSource::Constant(spectrum(color)));
        }
    }

    fn layers(&mut self, out: &mut PrincipledMaterial) {
        let m = self.material;
        let coat = m.coat.unwrap_or(f32::from(m.maps.contains_key("map_pc")));
        let sheen = m.sheen.unwrap_or(f32::from(m.maps.contains_key("map_ps")));
        out.coat_weight = self.picture("map_pc", Spectrum::grey(coat)).unwrap_or(grey(m.coat.unwrap_or(0.0)));
        out.coat_roughness = grey(m.coat_roughness.unwrap_or(0.0));
        out.fuzz_weight =
            self.picture("map_ps", Spectrum::grey(sheen)).unwrap_or(grey(m.sheen.unwrap_or(0.0)));
    }

    fn relief(&mut self, out: &mut PrincipledMaterial) {
        let strength = |key: &str| self.material.maps.get(key).map_or(1.0, |map| f64::from(map.bump));
        let scales = [strength("norm"), strength("map_bump")];
        if let Some(picture) = self.picture("norm", Spectrum::WHITE) {
            (out.normal_map, out.normal_scale) = (Some(picture), scales[0]);
        } else if self.image("map_bump").is_some_and(is_normal_map) {
            self.remark(
                WarningKind::Approximated,
                "images after `map_bump` with the colours of normals: read as normal maps",
            );
            (out.normal_map, out.normal_scale) = (self.picture("map_bump", Spectrum::WHITE), scales[1]);
        }
        if self.image("map_bump").is_some_and(|image| !is_normal_map(image)) {
            self.remark(
                WarningKind::Approximated,
                "bump maps (`map_bump`) have no unit: white is a fiftieth of the image's side above black, times `-bm`",
            );
            out.bump_map = self.picture("map_bump", Spectrum::WHITE);
            (out.bump_scale, out.bump_unit) = (RELIEF * scales[1], BumpUnit::Tile);
        }
    }
}

/// Height of white above black in height maps, as a fraction of the image's side.
const RELIEF: f64 = 0.02;

fn image_desc(
    file: turner::schema::ImageId,
    map: &MtlMap,
    channel: ImageChannel,
    encoding: Encoding,
    tint: Spectrum,
) -> ImageDesc {
    let ([su, sv], [ou, ov]) = (map.scale.map(f64::from), map.offset.map(f64::from));
    let is_plain = map.scale == [1.0; 2] && map.offset == [0.0; 2];
    ImageDesc {
        file,
        wrap: if map.clamp { Wrap::Clamp } else { Wrap::Repeat },
        uv_matrix: (!is_plain).then_some([su, 0.0, ou, 0.0, sv, ov]),
        channel,
        encoding,
        tint: tint * map.gain,
        offset: tint * map.base,
        ..ImageDesc::default()
    }
}

/// A regular grid of pixels of an image, about 64 x 64.
fn samples(image: &Image) -> impl Iterator<Item = (u32, u32)> {
    let (step_x, step_y) = (image.width.div_ceil(64).max(1), image.height.div_ceil(64).max(1));
    let (width, height) = (image.width, image.height);
    (0..height)
        .step_by(step_y as usize)
        .flat_map(move |y| (0..width).step_by(step_x as usize).map(move |x| (x, y)))
}

/// Whether the mean colour is that of a normal map: blue, with red and green near 0.5.
fn is_normal_map(image: &Image) -> bool {
    let (mut sum, mut count) = ([0.0_f64; 3], 0.0);
    for (x, y) in samples(image) {
        let rgb = image.rgb(x, y).map(f64::from);
        (0..3).for_each(|i| sum[i] += rgb[i]);
        count += 1.0;
    }
    let [r, g, b] = sum.map(|v| v / count);
    b > 0.6 && (r - 0.5).abs() < 0.1 && (g - 0.5).abs() < 0.1
}

/// Whether most pixels of an opacity image are nearly 0 or nearly 1.
fn is_mask(image: &Image) -> bool {
    let has_alpha = matches!(image.channels, 2 | 4);
    let (mut between, mut count) = (0, 0);
    for (x, y) in samples(image) {
        let [r, g, b] = image.rgb(x, y);
        let v = if has_alpha { image.alpha(x, y) } else { (r + g + b) / 3.0 };
        between += u32::from(v > 0.1 && v < 0.9);
        count += 1;
    }
    4 * between <= count
}

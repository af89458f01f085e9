//! Colour sources: products, mixes, and values mapped by a function.

use turner::color::{Spectrum, srgb_decode, srgb_encode};
use turner::image::{Image, Pixels};
use turner::math::elementary::{ln, pow_int};
use turner::schema::ColorSource;
use turner::texture::{CheckerboardDesc, Encoding, ImageDesc, MixDesc, MultiplyDesc, TextureDesc};

use super::common_parts::CommonParts;
use super::report::Place;

/// The product of two sources.
pub(crate) fn product(scene: &mut CommonParts<'_>, a: ColorSource, b: ColorSource) -> ColorSource {
    match (a, b) {
        (ColorSource::Constant(a), ColorSource::Constant(b)) => ColorSource::Constant(a * b),
        (ColorSource::Constant(c), texture) | (texture, ColorSource::Constant(c)) => {
            if c == Spectrum::WHITE {
                return texture;
            }
            match scene.texture_desc(texture) {
                Some(TextureDesc::Image(image)) => {
                    let desc = ImageDesc { tint: image.tint * c, offset: image.offset * c, ..image.clone() };
                    scene.texture(TextureDesc::Image(desc))
                }
                _ => scene.texture(TextureDesc::Multiply(MultiplyDesc { a, b })),
            }
        }
        _ => scene.texture(TextureDesc::Multiply(MultiplyDesc { a, b })),
    }
}

/// `a` where `amount` is 0, `b` where it is 1.
pub(crate) fn mix(
    scene: &mut CommonParts<'_>,
    a: ColorSource,
    b: ColorSource,
    amount: ColorSource,
) -> ColorSource {
    match (a, b, amount) {
        (ColorSource::Constant(a), ColorSource::Constant(b), ColorSource::Constant(t)) => {
            ColorSource::Constant(a.lerp(b, t.r))
        }
        (a, _, ColorSource::Constant(t)) if t == Spectrum::BLACK => a,
        (_, b, ColorSource::Constant(t)) if t == Spectrum::WHITE => b,
        _ => scene.texture(TextureDesc::Mix(MixDesc { a, b, amount, ..MixDesc::default() })),
    }
}

/// A function of the values of a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Through {
    /// From pbrt's roughness, remapped or not, to Turner's √α.
    Roughness { remap: bool },
    /// From the roughness of pbrt-v3, remapped, to Turner's √α.
    RemappedRoughness,
    /// From the reflectance ρ of a diffuse base to what leaves the clear layer above it: ρ · `gain` / (1 − ρ ·
    /// `inner`). `inner` is what the layer's inner side reflects of diffuse light; `gain` is 1 − `inner` for
    /// smooth layers. `max_bounces` bounds the reflections at the base.
    Layer { gain: f64, inner: f64, turns: Option<u32> },
    /// Multiplied by a factor, at most 1.
    Scale(f64),
    /// 1 − v.
    Rest,
}

impl Through {
    /// The function at `v`.
    pub(crate) fn of(self, v: f64) -> f64 {
        let unit = v.clamp(0.0, 1.0);
        match self {
            Through::Roughness { remap: true } => unit.sqrt().sqrt(),
            Through::Roughness { remap: false } => unit.sqrt(),
            // pbrt-v3's fit of Beckmann's α; 0 stays smooth.
            Through::RemappedRoughness if unit <= 0.0 => 0.0,
            Through::RemappedRoughness => {
                let x = ln(unit.max(1e-3));
                let alpha = 1.62142 + x * (0.819955 + x * (0.1734 + x * (0.0171201 + x * 0.000640711)));
                alpha.clamp(0.0, 1.0).sqrt()
            }
            Through::Layer { gain, inner, turns } => {
                let again = unit * inner;
                let left = turns.map_or(0.0, |turns| pow_int(again, turns));
                unit * gain * (1.0 - left) / (1.0 - again)
            }
            Through::Scale(by) => (v * by).min(1.0),
            Through::Rest => 1.0 - unit,
        }
    }
}

/// A function of colours.
enum Function<'a> {
    /// Each component on its own.
    Each(Through),
    /// The whole colour, with a name for the function.
    Colors(&'a str, &'a dyn Fn([f64; 3]) -> [f64; 3]),
}

impl Function<'_> {
    fn of(&self, color: [f64; 3]) -> [f64; 3] {
        match self {
            Function::Each(f) => color.map(|v| f.of(v)),
            Function::Colors(_, f) => f(color),
        }
    }

    fn name(&self) -> String {
        match self {
            Function::Each(f) => format!("{f:?}"),
            Function::Colors(name, _) => (*name).to_owned(),
        }
    }
}

/// Deepest nesting of textures.
const MAX_DEPTH: u32 = 32;

/// A source with its values mapped: constants directly, images by a copy of their texels. Procedural textures
/// stay as they are, which is reported.
pub(crate) fn map_values(
    scene: &mut CommonParts<'_>,
    source: ColorSource,
    place: Place,
    f: Through,
) -> ColorSource {
    mapped_source(scene, source, place, &Function::Each(f), 0)
}

/// The same with a function of whole colours; `name` tells it from others.
pub(crate) fn map_colors(
    scene: &mut CommonParts<'_>,
    source: ColorSource,
    place: Place,
    name: &str,
    f: &dyn Fn([f64; 3]) -> [f64; 3],
) -> ColorSource {
    mapped_source(scene, source, place, &Function::Colors(name, f), 0)
}

fn mapped_source(
    scene: &mut CommonParts<'_>,
    source: ColorSource,
    place: Place,
    f: &Function<'_>,
    depth: u32,
) -> ColorSource {
    let id = match source {
        ColorSource::Constant(c) => {
            let made = f.of(c.to_array().map(f64::from)).map(|v| v as f32);
            return ColorSource::Constant(made.into());
        }
        ColorSource::Texture(id) => id,
    };
    let key = (id, f.name());
    if let Some(&known) = scene.mapped.get(&key) {
        return known;
    }
    let made = if depth < MAX_DEPTH { mapped_texture(scene, source, place, f, depth + 1) } else { None };
    let made = made.unwrap_or_else(|| {
        let message = "a procedural texture whose values need a conversion: they are used unconverted";
        scene.report.approximated(place, message);
        source
    });
    scene.mapped.insert(key, made);
    made
}

fn mapped_texture(
    scene: &mut CommonParts<'_>,
    source: ColorSource,
    place: Place,
    f: &Function<'_>,
    depth: u32,
) -> Option<ColorSource> {
    let desc = scene.texture_desc(source)?.clone();
    let inner = |scene: &mut CommonParts<'_>, source| mapped_source(scene, source, place, f, depth);
    let desc = match desc {
        TextureDesc::Image(image) => {
            let asset = scene.images.get(image.file.index())?;
            let (old, uri) = (asset.data.clone(), asset.uri.clone());
            let is_encoded = old.is_display_encoded() && image.encoding != Encoding::Linear;
            let (tint, offset) = (image.tint.to_array(), image.offset.to_array());
            let value = |color: [f32; 3]| {
                let shown = [0, 1, 2].map(|i| {
                    let v = f64::from(color[i] * tint[i]) * image.gain + f64::from(offset[i]);
                    if v.is_finite() { v } else { 0.0 }
                });
                f.of(shown).map(|v| v as f32)
            };
            if !scene.may_copy(u64::from(old.width) * u64::from(old.height) * 12) {
                return None;
            }
            let is_separable = matches!(f, Function::Each(_));
            let made = mapped_picture(&old, is_encoded, is_separable, &value)?;
            let file = scene.add_image(&uri, made);
            TextureDesc::Image(ImageDesc {
                file,
                tint: Spectrum::WHITE,
                offset: Spectrum::BLACK,
                gain: 1.0,
                ..image
            })
        }
        TextureDesc::Checkerboard(board) => {
            let (even, odd) = (inner(scene, board.even), inner(scene, board.odd));
            TextureDesc::Checkerboard(CheckerboardDesc { even, odd, ..board })
        }
        // Exact at both ends of a mix, not between them.
        TextureDesc::Mix(mix) => {
            let (a, b) = (inner(scene, mix.a), inner(scene, mix.b));
            TextureDesc::Mix(MixDesc { a, b, ..mix })
        }
        _ => return None,
    };
    Some(scene.texture(desc))
}

/// An image with its colours mapped; 8-bit images stay 8-bit. `None` if memory is short.
fn mapped_picture(
    old: &Image,
    is_encoded: bool,
    is_separable: bool,
    value: &dyn Fn([f32; 3]) -> [f32; 3],
) -> Option<Image> {
    let count = (old.width as usize).checked_mul(old.height as usize)?.checked_mul(3)?;
    let rgb = |i: usize| old.rgb((i % old.width as usize) as u32, (i / old.width as usize) as u32);
    let pixels = if let (Pixels::U8(_), true) = (&old.pixels, is_encoded) {
        let byte = |v: f32| (srgb_encode(v.clamp(0.0, 1.0)) * 255.0 + 0.5) as u8;
        let decoded: Vec<f32> = (0..=u8::MAX).map(|v| srgb_decode(f32::from(v) / 255.0)).collect();
        let of_byte = |v: f32| (v * 255.0 + 0.5) as usize;
        let table: Vec<[u8; 3]> = decoded.iter().map(|v| value([*v; 3]).map(byte)).collect();
        let mut bytes = Vec::new();
        bytes.try_reserve_exact(count).ok()?;
        for i in 0..count / 3 {
            let at = rgb(i).map(of_byte);
            if is_separable {
                let of = at.map(|v| table.get(v).copied().unwrap_or_default());
                bytes.extend([of[0][0], of[1][1], of[2][2]]);
            } else {
                bytes.extend(value(at.map(|v| decoded.get(v).copied().unwrap_or_default())).map(byte));
            }
        }
        Pixels::U8(bytes)
    } else {
        let mut floats = Vec::new();
        floats.try_reserve_exact(count).ok()?;
        for i in 0..count / 3 {
            floats.extend(value(if is_encoded { rgb(i).map(srgb_decode) } else { rgb(i) }));
        }
        Pixels::F32(floats)
    };
    Some(Image { width: old.width, height: old.height, channels: 3, pixels })
}

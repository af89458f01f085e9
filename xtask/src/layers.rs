//! Shows layers of an EXR file as pictures.

use std::path::Path;

use turner::color::Transfer as Curve;
use turner_io::image::{
    ChannelValues, DecodeLimits, Display, ExtraChannel, ImageFormat, OutputFile, OutputImage, Transfer,
    encode, exr,
};

/// A layer, and how it is shown.
#[derive(Clone, Copy)]
pub(crate) enum Layer {
    /// A colour, brightened by a factor: the channels `NAME.R .G .B`, or `R G B`.
    Color(&'static str, f32),
    /// A vector with a length up to 1: `NAME.X .Y .Z`, grey where it is 0.
    Vector(&'static str),
    /// A distance: white is the nearest.
    Distance(&'static str),
    /// A number from 0 to this.
    Number(&'static str, f32),
    /// A Cryptomatte: a colour for each name.
    Matte(&'static str),
}

/// Writes one layer of an EXR file as a PNG file.
pub(crate) fn write(exr_file: &Path, size: (u32, u32), layer: Layer, to: &Path) -> Result<(), String> {
    let name = exr_file.display().to_string();
    let bytes = std::fs::read(exr_file).map_err(|e| format!("{name}: {e}"))?;
    let channels = exr::read_channels(&bytes, &name, 0, |_| true, &DecodeLimits::default());
    let channels = channels.map_err(|e| e.to_string())?;
    let count = size.0 as usize * size.1 as usize;
    let pixels = match layer {
        Layer::Color(layer, by) => {
            let bands = bands(&channels, layer, ["R", "G", "B"])?;
            let shown = |v: f32| (Curve::Srgb.encode((v * by).clamp(0.0, 1.0)) * 255.0).round() as u8;
            colors(count, |i| bands.map(|band| shown(band[i])))
        }
        Layer::Vector(layer) => {
            let bands = bands(&channels, layer, ["X", "Y", "Z"])?;
            colors(count, |i| bands.map(|band| byte(0.5 + 0.5 * band[i])))
        }
        Layer::Distance(channel) => {
            let values = floats(&channels, channel)?;
            let hits = || values.iter().copied().filter(|v| *v < 1e9);
            let (near, far) = (hits().fold(f32::MAX, f32::min), hits().fold(0.0, f32::max));
            colors(count, |i| [byte((far - values[i]) / (far - near)); 3])
        }
        Layer::Number(channel, most) => {
            let values = floats(&channels, channel)?;
            colors(count, |i| [byte(values[i] / most); 3])
        }
        Layer::Matte(layer) => {
            let ranks = (0..3).flat_map(|i| {
                [["R", "G"], ["B", "A"]].map(|pair| pair.map(|c| format!("{layer}{i:02}.{c}")))
            });
            let ranks: Vec<[&[f32]; 2]> = ranks
                .map(|[id, part]| Ok([floats(&channels, &id)?, floats(&channels, &part)?]))
                .collect::<Result<_, String>>()?;
            colors(count, |i| {
                let mut sum = [0.0; 3];
                for [id, part] in &ranks {
                    let color = color_of(id[i].to_bits());
                    sum.iter_mut().zip(color).for_each(|(s, c)| *s += part[i] * c);
                }
                sum.map(byte)
            })
        }
    };
    let image = OutputImage {
        width: size.0,
        height: size.1,
        alpha: false,
        display: Some(Display::U8(&pixels)),
        transfer: Transfer::Unstated,
        metadata: &Default::default(),
        threads: 1,
        ..OutputImage::default()
    };
    let bytes = encode(&image, ImageFormat::Png).map_err(|e| e.to_string())?;
    OutputFile::create(to).and_then(|file| file.commit(&bytes)).map_err(|e| e.to_string())
}

fn colors(count: usize, color: impl Fn(usize) -> [u8; 3]) -> Vec<[u8; 4]> {
    (0..count).map(&color).map(|[r, g, b]| [r, g, b, 255]).collect()
}

fn byte(v: f32) -> u8 {
    (v.clamp(0.0, 1.0) * 255.0).round() as u8
}

/// A bright colour from the bits of a name.
fn color_of(hash: u32) -> [f32; 3] {
    let turned = hash.wrapping_mul(0x9e37_79b9);
    [0, 8, 16].map(|by| 0.25 + 0.75 * ((turned >> by & 0xff) as f32 / 255.0))
}

fn bands<'a>(
    channels: &'a [ExtraChannel<'static>],
    layer: &str,
    names: [&str; 3],
) -> Result<[&'a [f32]; 3], String> {
    let full = |band: &str| if layer.is_empty() { band.to_owned() } else { format!("{layer}.{band}") };
    let [x, y, z] = names.map(|band| floats(channels, &full(band)));
    Ok([x?, y?, z?])
}

fn floats<'a>(channels: &'a [ExtraChannel<'static>], name: &str) -> Result<&'a [f32], String> {
    let found = channels.iter().find(|channel| channel.name == name);
    match found.map(|channel| &channel.values) {
        Some(ChannelValues::Float(values)) => Ok(values),
        _ => Err(format!("the file has no channel {name} of floats")),
    }
}

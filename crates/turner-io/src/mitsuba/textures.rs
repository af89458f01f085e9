//! Textures. Row 0 of an image lies at v = 0 in Mitsuba, at v = 1 in Turner. The v of some shapes differs as
//! well ([`Surface`]).

use std::sync::Arc;

use turner::color::{Spectrum, srgb_decode};
use turner::image::{Image, Pixels};
use turner::math::{DAffine3, DMat3, DVec3};
use turner::schema::{ColorSource, ErrorCode, ImageId, Transform};
use turner::texture::{
    CheckerboardDesc, Encoding, ImageChannel, ImageDesc, ImageFilter, Mapping, TextureDesc, VertexColorDesc,
    Wrap,
};

use super::assembly::Assembly;
use super::params::Object;
use super::spectra::{COLORS, Role, color};
use crate::scene_import::report::Fault;
use crate::scene_import::{is_sound, product, unknown};

/// Deepest nesting of textures.
const MAX_DEPTH: u32 = 16;

/// How the (u, v) of a shape in Turner relate to those in Mitsuba.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Surface {
    /// They are equal.
    #[default]
    Same,
    /// Turner's v is 1 − v.
    Flipped,
    /// A disk: Turner's are azimuth and 1 − radius, Mitsuba's radius and azimuth.
    Polar,
    /// The same for a disk that is seen from behind: Turner's azimuth is 1 − azimuth.
    PolarBehind,
    /// Mitsuba's are 0 everywhere.
    Point,
}

/// What the values of a texture are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Values {
    /// Colours, or numbers derived from colours: decoded unless the file says otherwise.
    Colors,
    /// Numbers of a BSDF: decoded as colours are.
    Numbers,
    /// Opacities and weights: decoded as well, but without the image's own alpha.
    Shares,
    /// Normals and heights: not decoded unless the file says so.
    Plain,
}

/// What a texture is made for: its element, the surface, the role and the values.
pub(super) type TextureKey = (usize, Surface, Role, Values);

/// The colour or texture of the element `node` on a surface.
pub(super) fn source(
    scene: &mut Assembly<'_>,
    node: usize,
    role: Role,
    surface: Surface,
) -> Result<ColorSource, Fault> {
    of(scene, node, role, surface, Values::Colors, 0)
}

/// The same for normals and heights, which are not decoded by default.
pub(super) fn numbers(
    scene: &mut Assembly<'_>,
    node: usize,
    role: Role,
    surface: Surface,
) -> Result<ColorSource, Fault> {
    of(scene, node, role, surface, Values::Plain, 0)
}

/// The same for opacities and the weights of blends.
pub(super) fn shares(scene: &mut Assembly<'_>, node: usize, surface: Surface) -> Result<ColorSource, Fault> {
    of(scene, node, Role::Albedo, surface, Values::Shares, 0)
}

/// The same for other numbers of a BSDF.
pub(super) fn scalars(
    scene: &mut Assembly<'_>,
    node: usize,
    role: Role,
    surface: Surface,
) -> Result<ColorSource, Fault> {
    of(scene, node, role, surface, Values::Numbers, 0)
}

/// Whether an element is a colour or a texture.
pub(super) fn is_source(tag: &str) -> bool {
    tag == "texture" || COLORS.contains(&tag)
}

fn of(
    scene: &mut Assembly<'_>,
    node: usize,
    role: Role,
    surface: Surface,
    values: Values,
    depth: u32,
) -> Result<ColorSource, Fault> {
    let object = Object::new(&scene.document, node)?;
    if object.tag != "texture" {
        return color(scene, object.node, role).map(ColorSource::Constant);
    }
    let key = (object.node, surface, role, values);
    if let Some(known) = scene.textures.get(&key) {
        return Ok(*known);
    }
    if depth >= MAX_DEPTH {
        let message = format!("textures nest deeper than {MAX_DEPTH}");
        return Err(Fault::at(object.place, ErrorCode::TooLarge, message));
    }
    let made = match object.kind.as_str() {
        "bitmap" | "ldrtexture" => picture(scene, &object, surface, values)?,
        "checkerboard" => checkerboard(scene, &object, (role, surface, values), depth)?,
        "mesh_attribute" | "vertexcolors" => attribute(scene, &object)?,
        // Mitsuba 0.6.
        "scale" => {
            let scale = object.find("scale").map(|(i, _)| i);
            let by = match scale {
                Some(i) => color(scene, i, Role::Unbounded)?,
                None => Spectrum::WHITE,
            };
            let inner = object.objects(&["texture", "spectrum", "rgb"])?;
            let inner = match inner.first() {
                Some(inner) => of(scene, *inner, role, surface, values, depth + 1)?,
                None => ColorSource::Constant(Spectrum::WHITE),
            };
            product(&mut scene.stock, inner, ColorSource::Constant(by))
        }
        "uniform" | "srgb" | "rawconstant" => {
            let value = object.find("value").or(object.find("color"));
            match value {
                Some((_, node)) if node.tag == "vector" => {
                    let v = object.vector("value")?.unwrap_or_default().as_vec3();
                    ColorSource::Constant(Spectrum::new(v.x, v.y, v.z))
                }
                Some((node, _)) => ColorSource::Constant(color(scene, node, role)?),
                None => grey(1.0),
            }
        }
        "d65" | "blackbody" | "regular" | "irregular" => {
            let message = format!("{} is written as <texture>: grey replaces it", object.title());
            scene.report.ignored(object.place, message);
            grey(0.5)
        }
        "volume" => {
            object.pass(&["volume"]);
            scene.report.ignored(object.place, "a volume as a texture: grey replaces it");
            grey(0.5)
        }
        other => {
            let all = ["bitmap", "checkerboard", "mesh_attribute", "volume"];
            return Err(unknown("texture", other, &all).or_at(object.place));
        }
    };
    scene.finish(&object);
    scene.textures.insert(key, made);
    Ok(made)
}

fn grey(v: f64) -> ColorSource {
    ColorSource::Constant(Spectrum::grey(v as f32))
}

/// The two rows of an affine map of (u, v).
type Rows = [f64; 6];

fn uv_rows(object: &Object) -> Result<Rows, Fault> {
    if object.has("to_uv") {
        let t = object.transform("to_uv")?;
        let (m, d) = (t.matrix3, t.translation);
        return Ok([m.x_axis.x, m.y_axis.x, d.x, m.x_axis.y, m.y_axis.y, d.y]);
    }
    // Mitsuba 0.6.
    let float = |name, or: f64| object.float(name).map(|v| v.unwrap_or(or));
    let both = float("uvscale", 1.0)?;
    let (su, sv) = (float("uscale", both)?, float("vscale", both)?);
    Ok([su, 0.0, float("uoffset", 0.0)?, 0.0, sv, float("voffset", 0.0)?])
}

/// `rows` as a map of Turner's (u, v) on a surface.
fn from_here([a, b, c, d, e, f]: Rows, surface: Surface) -> Rows {
    match surface {
        Surface::Same => [a, b, c, d, e, f],
        Surface::Flipped => [a, -b, b + c, d, -e, e + f],
        Surface::Polar => [b, -a, a + c, e, -d, d + f],
        Surface::PolarBehind => [-b, -a, a + b + c, -e, -d, d + e + f],
        Surface::Point => [0.0, 0.0, c, 0.0, 0.0, f],
    }
}

fn picture(
    scene: &mut Assembly<'_>,
    object: &Object,
    surface: Surface,
    values: Values,
) -> Result<ColorSource, Fault> {
    let place = object.place_of("filename");
    let raw = object.boolean("raw")?.unwrap_or(values == Values::Plain);
    let gamma = object.float("gamma")?;
    let nearest = object.string("filter_type")? == Some("nearest");
    object.pass(&["filter_type", "accel", "format", "max_anisotropy", "cache", "data"]);
    let both = object.string("wrap_mode")?;
    let wrap = |word: Option<&str>| match word.or(both) {
        None | Some("repeat") => Some(Wrap::Repeat),
        Some("mirror") => Some(Wrap::Mirror),
        Some("clamp" | "one") => Some(Wrap::Clamp),
        Some("zero") => Some(Wrap::Black),
        Some(_) => None,
    };
    let (u, v) = (wrap(object.string("wrap_mode_u")?), wrap(object.string("wrap_mode_v")?));
    if u.is_none() || v.is_none() {
        let message = "unknown wrap_mode (expected repeat, mirror or clamp): repeat replaces it";
        scene.report.ignored(object.place_of("wrap_mode"), message);
    }
    let channel = match object.string("channel")? {
        Some("r") => ImageChannel::R,
        Some("g") => ImageChannel::G,
        Some("b") => ImageChannel::B,
        Some("a") => ImageChannel::A,
        _ => ImageChannel::Rgb,
    };
    let rows = uv_rows(object)?;
    let Some(name) = object.string("filename")?.map(str::to_owned) else {
        scene.report.ignored(object.place, "a bitmap without filename: grey replaces it");
        return Ok(grey(0.5));
    };
    let name = scene.picture_name(&name);
    let Some(mut file) = scene.image(&name, place) else { return Ok(grey(0.5)) };
    let mut raw = raw || gamma == Some(1.0);
    if values == Values::Shares
        && channel == ImageChannel::Rgb
        && let Some(made) = luminance(scene, &name, file, raw)
    {
        (file, raw) = (made, true);
    }
    let [a, b, c, d, e, f] = from_here(rows, surface);
    // Row 0 of the image is at v = 0 in Mitsuba, at v = 1 in Turner.
    let rows = [a, b, c, -d, -e, 1.0 - f];
    let desc = ImageDesc {
        file,
        filter: if nearest { ImageFilter::Nearest } else { ImageFilter::Mipmap },
        wrap_u: u.filter(|w| *w != Wrap::Repeat),
        wrap_v: v.filter(|w| *w != Wrap::Repeat),
        uv_matrix: (rows != [1.0, 0.0, 0.0, 0.0, 1.0, 0.0]).then_some(rows),
        channel,
        encoding: if raw { Encoding::Linear } else { Encoding::Srgb },
        ..ImageDesc::default()
    };
    Ok(scene.texture(TextureDesc::Image(desc)))
}

/// The luminance of an image without its alpha, which Mitsuba uses as opacity. `None` keeps the image: it is
/// grey without alpha, or the budget of images is spent.
fn luminance(scene: &mut Assembly<'_>, name: &str, id: ImageId, raw: bool) -> Option<ImageId> {
    let image = scene.images.get(id.index()).map(|a| Arc::clone(&a.data))?;
    if image.channels < 2 {
        return None;
    }
    let key = format!("{name}\0luminance {raw}");
    if let Some(known) = scene.image_ids.get(&key) {
        return *known;
    }
    let pixels = u64::from(image.width) * u64::from(image.height);
    let made = scene.may_copy(4 * pixels).then(|| {
        let is_encoded = image.is_display_encoded() && !raw;
        let decoded = |v: f32| if is_encoded { srgb_decode(v) } else { v };
        let luminance = |x, y| Spectrum::from(image.rgb(x, y).map(decoded)).luminance();
        let rows = (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x, y)));
        let pixels = Pixels::F32(rows.map(|(x, y)| luminance(x, y)).collect());
        scene.add_image(name, Image { width: image.width, height: image.height, channels: 1, pixels })
    });
    scene.image_ids.insert(key, made);
    made
}

fn checkerboard(
    scene: &mut Assembly<'_>,
    object: &Object,
    (role, surface, values): (Role, Surface, Values),
    depth: u32,
) -> Result<ColorSource, Fault> {
    let mut colors = [grey(0.4), grey(0.2)];
    for (slot, name) in colors.iter_mut().zip(["color0", "color1"]) {
        if let Some((node, _)) = object.find(name) {
            *slot = of(scene, node, role, surface, values, depth + 1)?;
        }
    }
    // Where a number is wanted, Mitsuba exchanges the two.
    if matches!(values, Values::Numbers | Values::Shares) {
        colors.reverse();
    }
    let [even, odd] = colors;
    let [a, b, c, d, e, f] = from_here(uv_rows(object)?, surface);
    // Turner's texture coordinates are 2u − 1 with squares of size 1. Mitsuba's squares are half a unit of u
    // wide, the first colour at the corner.
    let to_squares = DAffine3::from_mat3_translation(
        DMat3::from_cols(DVec3::new(a, d, 0.0), DVec3::new(b, e, 0.0), DVec3::Z),
        DVec3::new(a + b + 2.0 * c, d + e + 2.0 * f, 0.0),
    );
    if surface == Surface::Point {
        // One square.
        let is_odd = |v: f64| (2.0 * v).floor().rem_euclid(2.0) != 0.0;
        return Ok(if is_odd(c) == is_odd(f) { even } else { odd });
    }
    if !is_sound(&to_squares) {
        scene.report.doubtful(object.place, "a checkerboard of size 0: one colour");
        return Ok(even);
    }
    let transform = Transform(to_squares.inverse());
    let desc = CheckerboardDesc { even, odd, density: 1.0, mapping: Mapping::Uv, blend: 4.0, transform };
    Ok(scene.texture(TextureDesc::Checkerboard(desc)))
}

fn attribute(scene: &mut Assembly<'_>, object: &Object) -> Result<ColorSource, Fault> {
    // The mesh has the colours of this attribute: see `attributes`.
    object.pass(&["name"]);
    let scale = object.float("scale")?.unwrap_or(1.0);
    let texture = scene.texture(TextureDesc::VertexColor(VertexColorDesc { fallback: Spectrum::BLACK }));
    Ok(product(&mut scene.stock, texture, grey(scale)))
}

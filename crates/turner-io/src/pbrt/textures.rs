//! pbrt's textures as Turner's.

use turner::color::Spectrum;
use turner::image::{Image, Pixels};
use turner::math::{DAffine3, DMat3, DVec3};
use turner::schema::{ColorSource, ImageId, Transform};
use turner::texture::{
    CheckerboardDesc, Encoding, ImageChannel, ImageDesc, ImageFilter, Mapping, MixDesc, PerlinDesc,
    PerlinKind, TextureDesc, Wrap,
};

use super::assembly::{Assembly, Texture};
use super::float_pictures;
use super::params::{Params, Type};
use super::report::Fault;
use super::source::Place;
use super::spectra::{Role, color};
use super::state::State;
use super::transform::is_sound;
use crate::assets::printable;
use crate::scene_import::{mix, product, rearranged};

/// A texture by its name.
pub(super) fn source_named(scene: &mut Assembly<'_>, name: &str, place: Place) -> Result<ColorSource, Fault> {
    match scene.textures.get(name) {
        Some(texture) => Ok(texture.source),
        None => {
            let names: Vec<&str> = scene.textures.keys().map(String::as_str).collect();
            Err(super::reader::unknown("texture", name, &names).or_at(place))
        }
    }
}

/// A normal map.
pub(super) fn normal_picture(scene: &mut Assembly<'_>, file: &str, place: Place) -> Option<ColorSource> {
    let image = scene.image(file, place)?;
    let desc = ImageDesc { encoding: Encoding::Linear, ..picture(image) };
    Some(scene.texture(TextureDesc::Image(desc)))
}

fn picture(file: ImageId) -> ImageDesc {
    ImageDesc { file, encoding: Encoding::Srgb, ..ImageDesc::default() }
}

/// Defines a texture: its name, `float` or `spectrum`, and its class.
pub(super) fn define(
    scene: &mut Assembly<'_>,
    state: &State,
    (name, kind, class): (&str, &str, &str),
    params: Params,
) -> Result<(), Fault> {
    let place = params.place;
    let is_float = match kind {
        "float" => true,
        "spectrum" => false,
        // The name in pbrt-v3.
        "color" => false,
        other => {
            return Err(super::reader::unknown("type of texture", other, &["float", "spectrum"]).or_at(place));
        }
    };
    let mut maker = Maker { scene, state, params: &params, is_float };
    let source = match class {
        "constant" => maker.input("value", 1.0)?,
        "scale" => {
            let [a, b] =
                if params.has("tex1") || params.has("tex2") { ["tex1", "tex2"] } else { ["tex", "scale"] };
            let (a, b) = (maker.input(a, 1.0)?, maker.input(b, 1.0)?);
            product(maker.scene, a, b)
        }
        "mix" => {
            let (a, b) = (maker.input("tex1", 0.0)?, maker.input("tex2", 1.0)?);
            let amount = maker.float_input("amount", 0.5)?;
            mix(maker.scene, a, b, amount)
        }
        "directionmix" => {
            // The first texture lies where the surface faces along the direction or against it.
            let (b, a) = (maker.input("tex1", 0.0)?, maker.input("tex2", 1.0)?);
            let direction = params.vector("dir").unwrap_or(DVec3::Y);
            let direction = state.ctm[0].transform_vector3(direction).try_normalize();
            if direction.is_none() {
                let message = "a directionmix without a direction: both textures have the same weight";
                maker.scene.report.doubtful(params.place_of("dir"), message);
            }
            maker.scene.texture(TextureDesc::Mix(MixDesc { a, b, direction, ..MixDesc::default() }))
        }
        "imagemap" => maker.picture()?,
        "checkerboard" => maker.checkerboard()?,
        "bilerp" => maker.bilerp()?,
        "uv" => maker.uv_colors(),
        "dots" => {
            let (inside, outside) = (maker.input("inside", 1.0)?, maker.input("outside", 0.0)?);
            maker.only_uv();
            match maker.squares() {
                Some(transform) => {
                    // pbrt-v4 shows `outside` in the dots and `inside` around them; scenes rely on it.
                    let [low, high] = match maker.scene.frame.is_version3 {
                        true => [outside, inside],
                        false => [inside, outside],
                    };
                    let dots = perlin(PerlinKind::Dots);
                    let desc = PerlinDesc { low, high, mapping: Mapping::Uv, transform, ..dots };
                    maker.scene.texture(TextureDesc::Perlin(desc))
                }
                None => {
                    maker.scene.report.doubtful(place, "dots with a uv scale of 0: one colour");
                    outside
                }
            }
        }
        "fbm" | "wrinkled" | "windy" | "marble" => maker.noise(class),
        "ptex" => {
            params.pass(&["filename", "encoding", "scale"]);
            maker.scene.report.ignored(place, "a Ptex texture: grey replaces it");
            ColorSource::Constant(Spectrum::grey(0.5))
        }
        other => {
            let all = [
                "constant",
                "scale",
                "mix",
                "directionmix",
                "imagemap",
                "checkerboard",
                "bilerp",
                "uv",
                "dots",
                "fbm",
                "wrinkled",
                "windy",
                "marble",
                "ptex",
            ];
            return Err(super::reader::unknown("texture class", other, &all).or_at(place));
        }
    };
    params.finish(&format!("the texture \"{}\"", printable(name)), &mut scene.report);
    scene.textures.insert(name.to_owned(), Texture { source });
    Ok(())
}

/// Noise in world space, as in pbrt.
fn perlin(kind: PerlinKind) -> PerlinDesc {
    PerlinDesc { kind, mapping: Mapping::World, ..PerlinDesc::default() }
}

struct Maker<'a, 'b> {
    scene: &'a mut Assembly<'b>,
    state: &'a State,
    params: &'a Params,
    is_float: bool,
}

impl Maker<'_, '_> {
    /// A value or another texture.
    fn input(&mut self, name: &'static str, or: f64) -> Result<ColorSource, Fault> {
        if self.params.is(name, Type::Texture) {
            let texture = self.params.texture(name).unwrap_or_default().to_owned();
            return source_named(self.scene, &texture, self.params.place_of(name));
        }
        if self.is_float || self.params.is(name, Type::Float) {
            return Ok(grey(self.params.float(name).unwrap_or(or)));
        }
        let found = color(self.scene, self.state.color_space, self.params, name, Role::Unbounded)?;
        Ok(found.map_or(grey(or), ColorSource::Constant))
    }

    fn float_input(&mut self, name: &'static str, or: f64) -> Result<ColorSource, Fault> {
        if self.params.is(name, Type::Texture) {
            return self.input(name, or);
        }
        Ok(grey(self.params.float(name).unwrap_or(or)))
    }

    /// Perlin noise of a class.
    fn noise(&mut self, class: &str) -> ColorSource {
        let kind = match class {
            "fbm" => PerlinKind::Fbm,
            "wrinkled" => PerlinKind::Wrinkled,
            "windy" => PerlinKind::Windy,
            _ => PerlinKind::Marble,
        };
        let number = |name, or: f64, most: f64| {
            self.params.float(name).filter(|v| v.is_finite()).unwrap_or(or).clamp(0.0, most)
        };
        let ctm = self.state.ctm[0];
        let desc = PerlinDesc {
            octaves: self.params.integer("octaves").unwrap_or(8).clamp(1, 16) as u32,
            gain: number("roughness", 0.5, 1.0),
            variation: number("variation", 0.2, 1e6),
            density: if class == "marble" { number("scale", 1.0, 1e9) } else { 1.0 },
            transform: if is_sound(&ctm) { Transform(ctm) } else { Transform::IDENTITY },
            ..perlin(kind)
        };
        self.scene.texture(TextureDesc::Perlin(desc))
    }

    /// Scales and offsets of (u, v).
    fn uv(&self) -> [f64; 4] {
        let float = |name, or| self.params.float(name).filter(|v: &f64| v.is_finite()).unwrap_or(or);
        let mapping = self.params.string("mapping").unwrap_or("uv");
        if matches!(mapping, "uv") {
            self.params.pass(&["v1", "v2"]);
        }
        [float("uscale", 1.0), float("vscale", 1.0), float("udelta", 0.0), float("vdelta", 0.0)]
    }

    /// Maps the squares of s·u + d to Turner's texture coordinates 2u − 1; `None` if a scale is 0.
    fn squares(&self) -> Option<Transform> {
        let [su, sv, du, dv] = self.uv();
        let to_squares = DAffine3::from_mat3_translation(
            DMat3::from_diagonal(DVec3::new(su / 2.0, sv / 2.0, 1.0)),
            DVec3::new(su / 2.0 + du, sv / 2.0 + dv, 0.0),
        );
        is_sound(&to_squares).then(|| Transform(to_squares.inverse()))
    }

    /// A mapping in world space and its transform; `None` for (u, v) and for unknown mappings.
    fn in_world(&mut self) -> Option<(Mapping, Transform)> {
        let mapping = self.params.string("mapping").unwrap_or("uv").to_owned();
        let place = self.params.place_of("mapping");
        // From pbrt's axes to those of Turner's mappings, which go once around y.
        let (kind, rows, shift) = match mapping.as_str() {
            "uv" => return None,
            "planar" => {
                let [_, _, du, dv] = self.uv();
                let v1 = self.params.vector("v1").unwrap_or(DVec3::X);
                let v2 = self.params.vector("v2").unwrap_or(DVec3::Y);
                // Rows: 2(v·p + d) − 1, because an image covers −1 to 1.
                let rows = DMat3::from_cols(2.0 * v1, 2.0 * v2, v1.cross(v2));
                (Mapping::World, rows, DVec3::new(2.0 * du - 1.0, 2.0 * dv - 1.0, 0.0))
            }
            // φ / 2π from the left to the right, where φ begins at x; θ / π downwards: see `turned`.
            "spherical" => {
                (Mapping::WorldSpherical, DMat3::from_cols(DVec3::NEG_Y, DVec3::Z, DVec3::NEG_X), DVec3::ZERO)
            }
            // φ from −π to π, z from 0 to 1.
            "cylindrical" => {
                let rows = DMat3::from_cols(DVec3::Y, 2.0 * DVec3::Z, DVec3::X);
                (Mapping::WorldCylindrical, rows, DVec3::NEG_Y)
            }
            other => {
                let message = format!("the texture mapping \"{}\": (u, v) replaces it", printable(other));
                self.scene.report.approximated(place, message);
                return None;
            }
        };
        let to_texture = DAffine3::from_mat3_translation(rows.transpose(), shift);
        let to_texture = to_texture * self.state.ctm[0].inverse();
        if !is_sound(&to_texture) {
            let message = format!("a {mapping} mapping whose transform is not invertible");
            self.scene.report.ignored(place, message);
            return None;
        }
        Some((kind, Transform(to_texture.inverse())))
    }

    /// Reports mappings of patterns that have no counterpart.
    fn only_uv(&mut self) {
        let mapping = self.params.string("mapping").unwrap_or("uv").to_owned();
        self.params.pass(&["v1", "v2"]);
        if mapping != "uv" {
            let message =
                format!("the texture mapping \"{}\" of a pattern: (u, v) replaces it", printable(&mapping));
            self.scene.report.approximated(self.params.place_of("mapping"), message);
        }
    }

    fn picture(&mut self) -> Result<ColorSource, Fault> {
        let place = self.params.place_of("filename");
        let Some(name) = self.params.string("filename").map(str::to_owned) else {
            self.scene.report.ignored(self.params.place, "an imagemap without filename: grey replaces it");
            return Ok(grey(0.5));
        };
        let in_world = self.in_world();
        let [su, sv, du, dv] = self.uv();
        let filter = match self.params.string("filter") {
            Some("point") => ImageFilter::Nearest,
            _ => ImageFilter::Mipmap,
        };
        let wrap = match self.params.string("wrap") {
            None | Some("repeat" | "octahedralsphere") => Wrap::Repeat,
            Some("clamp") => Wrap::Clamp,
            Some("black") => Wrap::Black,
            Some(other) => {
                let message =
                    format!("unknown wrap mode \"{}\" of an image: \"repeat\" replaces it", printable(other));
                self.scene.report.ignored(self.params.place_of("wrap"), message);
                Wrap::Repeat
            }
        };
        let of_type = |ending: &str| name.to_ascii_lowercase().ends_with(ending);
        let encoding = match self.params.string("encoding") {
            // As in pbrt, it counts for PNG files only.
            Some("linear") if of_type(".png") => Encoding::Linear,
            Some("linear") => Encoding::Srgb,
            None if self.params.bool("gamma") == Some(false) => Encoding::Linear,
            None | Some("sRGB") => Encoding::Srgb,
            Some(other) => {
                let message = format!("the image encoding \"{}\": sRGB replaces it", printable(other));
                self.scene.report.approximated(self.params.place_of("encoding"), message);
                Encoding::Srgb
            }
        };
        let scale = self.params.float("scale").unwrap_or(1.0) as f32;
        let invert = self.params.bool("invert").unwrap_or(false);
        self.params.pass(&["maxanisotropy", "trilinear", "gamma"]);
        let Some(file) = self.scene.image(&name, place) else { return Ok(grey(0.5)) };
        // pbrt drops the alpha channel of formats other than these.
        let has_alpha = of_type(".png") || of_type(".exr");
        let file = match in_world {
            Some((Mapping::WorldSpherical, _)) => self.turned(&name, file),
            _ => file,
        };
        let (file, channel) = match self.is_float {
            true => float_pictures::of_float(self.scene, file, encoding, has_alpha),
            false => (file, ImageChannel::Rgb),
        };
        let plain = [su, sv, du, dv] == [1.0, 1.0, 0.0, 0.0];
        let desc = ImageDesc {
            filter,
            wrap,
            encoding,
            channel,
            tint: Spectrum::grey(if invert { -scale } else { scale }),
            offset: if invert { Spectrum::WHITE } else { Spectrum::BLACK },
            uv_matrix: (!plain && in_world.is_none()).then_some([su, 0.0, du, 0.0, sv, dv]),
            mapping: in_world.map_or(Mapping::Uv, |(mapping, _)| mapping),
            transform: in_world.map_or(Transform::IDENTITY, |(_, transform)| transform),
            ..picture(file)
        };
        Ok(self.scene.texture(TextureDesc::Image(desc)))
    }

    /// The picture of a spherical mapping. pbrt's goes from pole to pole from left to right, and around upwards; Turner's
    /// goes around from left to right, and from pole to pole downwards.
    fn turned(&mut self, name: &str, file: ImageId) -> ImageId {
        let turned = |old: &Image| rearranged(old, [old.height, old.width], |x, y| (y, old.height - 1 - x));
        self.scene.derived_image((name, file), "turned", turned).unwrap_or_else(|| {
            let message = "the images of spherical mappings take too much memory: shown as they are";
            self.scene.report.approximated(self.params.place, message);
            file
        })
    }

    fn checkerboard(&mut self) -> Result<ColorSource, Fault> {
        let (even, odd) = (self.input("tex1", 1.0)?, self.input("tex2", 0.0)?);
        let solid = self.params.integer("dimension") == Some(3);
        let (mapping, transform) = if solid {
            let ctm = self.state.ctm[0];
            (Mapping::World, if is_sound(&ctm) { Transform(ctm) } else { Transform::IDENTITY })
        } else {
            self.only_uv();
            self.params.pass(&["aamode"]);
            let Some(transform) = self.squares() else {
                self.scene
                    .report
                    .doubtful(self.params.place, "a checkerboard with a uv scale of 0: one colour");
                return Ok(even);
            };
            (Mapping::Uv, transform)
        };
        let desc = CheckerboardDesc { even, odd, density: 1.0, mapping, blend: 4.0, transform };
        Ok(self.scene.texture(TextureDesc::Checkerboard(desc)))
    }

    /// Four colours at the corners of (u, v), as a small image.
    fn bilerp(&mut self) -> Result<ColorSource, Fault> {
        let mut corners = [Spectrum::BLACK; 4];
        for (corner, (name, or)) in
            corners.iter_mut().zip([("v00", 0.0), ("v01", 1.0), ("v10", 0.0), ("v11", 1.0)])
        {
            if let ColorSource::Constant(c) = self.input(name, or)? {
                *corner = c;
            }
        }
        Ok(self.corners(corners, Wrap::Clamp))
    }

    /// (u, v) as red and green, repeated.
    fn uv_colors(&mut self) -> ColorSource {
        let color = |r, g| Spectrum::new(r, g, 0.0);
        let corners = [color(0.0, 0.0), color(0.0, 1.0), color(1.0, 0.0), color(1.0, 1.0)];
        self.corners(corners, Wrap::Repeat)
    }

    fn corners(&mut self, [v00, v01, v10, v11]: [Spectrum; 4], wrap: Wrap) -> ColorSource {
        const SIDE: u32 = 32;
        let [su, sv, du, dv] = self.uv();
        let mut pixels = Vec::with_capacity((SIDE * SIDE * 3) as usize);
        for y in 0..SIDE {
            for x in 0..SIDE {
                let (u, v) = ((x as f32 + 0.5) / SIDE as f32, 1.0 - (y as f32 + 0.5) / SIDE as f32);
                pixels.extend(v00.lerp(v10, u).lerp(v01.lerp(v11, u), v).to_array());
            }
        }
        let image = Image { width: SIDE, height: SIDE, channels: 3, pixels: Pixels::F32(pixels) };
        let file = self.scene.add_image("bilerp", image);
        let desc = ImageDesc { wrap, uv_matrix: Some([su, 0.0, du, 0.0, sv, dv]), ..picture(file) };
        self.scene.texture(TextureDesc::Image(desc))
    }
}

fn grey(v: f64) -> ColorSource {
    ColorSource::Constant(Spectrum::grey(v as f32))
}

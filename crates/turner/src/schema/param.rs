//! The types of values: numbers, vectors, colours, and references by name.

use crate::choice::Choice;
use crate::color::{NAMES, Spectrum, from_rgb24, named};
use crate::math::{DVec2, DVec3};
use crate::schema::error::{escape, unknown_name};
use crate::schema::value::{Data, Value};
use crate::schema::write::{list, single};
use crate::schema::{
    ErrorCode, ImageId, MaterialId, MediumId, ParamType, Range, ReadContext, Renumber, SceneError, TextureId,
    WriteContext, unknown_choice, wrong_type,
};

fn number(value: &Value) -> Option<f64> {
    match value.data {
        Data::Integer(i) => Some(i as f64),
        Data::Number(v) => Some(v),
        _ => None,
    }
}

/// Shows a number as TOML writes it.
pub(crate) fn show_number(v: f64) -> String {
    if v.is_infinite() { if v > 0.0 { "inf".into() } else { "-inf".into() } } else { format!("{v}") }
}

impl ParamType for f64 {
    fn kind() -> String {
        "number".into()
    }
    fn read(value: &Value, _: &mut dyn ReadContext) -> Result<f64, SceneError> {
        let v = number(value).ok_or_else(|| wrong_type(value, "a number"))?;
        if v.is_finite() {
            return Ok(v);
        }
        Err(SceneError::at(ErrorCode::OutOfRange, value.span, format!("expected a finite number, found {v}")))
    }
    fn show(&self) -> String {
        show_number(*self)
    }
    fn write(&self, _: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
        Ok(Some(Data::Number(*self)))
    }
    fn outside(&self, range: &Range) -> Option<f64> {
        (!range.contains(*self)).then_some(*self)
    }
}

impl ParamType for u32 {
    fn kind() -> String {
        "integer".into()
    }
    fn read(value: &Value, _: &mut dyn ReadContext) -> Result<u32, SceneError> {
        match value.data {
            Data::Integer(i) => u32::try_from(i).map_err(|_| {
                let message = format!("expected an integer from 0 to {}, found {i}", u32::MAX);
                SceneError::at(ErrorCode::OutOfRange, value.span, message)
            }),
            Data::Number(v) => Err(SceneError::at(
                ErrorCode::WrongType,
                value.span,
                format!("expected a whole number, found {v}"),
            )),
            _ => Err(wrong_type(value, "an integer")),
        }
    }
    fn show(&self) -> String {
        self.to_string()
    }
    fn write(&self, _: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
        Ok(Some(Data::Integer(i64::from(*self))))
    }
    fn outside(&self, range: &Range) -> Option<f64> {
        let v = f64::from(*self);
        (!range.contains(v)).then_some(v)
    }
}

impl ParamType for bool {
    fn kind() -> String {
        "true | false".into()
    }
    fn read(value: &Value, _: &mut dyn ReadContext) -> Result<bool, SceneError> {
        match value.data {
            Data::Bool(b) => Ok(b),
            _ => Err(wrong_type(value, "true or false")),
        }
    }
    fn show(&self) -> String {
        self.to_string()
    }
    fn write(&self, _: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
        Ok(Some(Data::Bool(*self)))
    }
}

impl ParamType for String {
    fn kind() -> String {
        "\"text\"".into()
    }
    fn read(value: &Value, _: &mut dyn ReadContext) -> Result<String, SceneError> {
        match &value.data {
            Data::String(s) => Ok(s.clone()),
            _ => Err(wrong_type(value, "a string")),
        }
    }
    fn show(&self) -> String {
        format!("\"{self}\"")
    }
    fn write(&self, _: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
        Ok(Some(Data::String(self.clone())))
    }
}

impl<T: ParamType> ParamType for Option<T> {
    fn kind() -> String {
        T::kind()
    }
    fn words() -> &'static [(&'static str, &'static str)] {
        T::words()
    }
    fn read(value: &Value, cx: &mut dyn ReadContext) -> Result<Option<T>, SceneError> {
        T::read(value, cx).map(Some)
    }
    fn show(&self) -> String {
        self.as_ref().map_or("none".into(), T::show)
    }
    fn write(&self, cx: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
        self.as_ref().map_or(Ok(None), |v| v.write(cx))
    }
    fn renumber(&mut self, by: &Renumber) {
        self.iter_mut().for_each(|v| v.renumber(by));
    }
    fn outside(&self, range: &Range) -> Option<f64> {
        self.as_ref().and_then(|v| v.outside(range))
    }
}

/// Writes the elements of a list.
fn write_list<T: ParamType>(items: &[T], cx: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
    let items: Result<Vec<_>, _> = items.iter().map(|v| v.write(cx)).collect();
    Ok(Some(list(items?.into_iter().flatten())))
}

/// A list of `T`.
impl<T: ParamType> ParamType for Vec<T> {
    fn kind() -> String {
        format!("[{}, …]", T::kind())
    }
    fn read(value: &Value, cx: &mut dyn ReadContext) -> Result<Vec<T>, SceneError> {
        match &value.data {
            Data::Array(items) => {
                let mut list = Vec::with_capacity(items.len());
                for item in items {
                    let read = T::read(item, cx);
                    list.extend(cx.noted(read)?);
                }
                Ok(list)
            }
            _ => Err(wrong_type(value, &format!("an array {}", Self::kind()))),
        }
    }
    fn show(&self) -> String {
        format!("[{}]", self.iter().map(T::show).collect::<Vec<_>>().join(", "))
    }
    fn write(&self, cx: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
        write_list(self, cx)
    }
    fn renumber(&mut self, by: &Renumber) {
        self.iter_mut().for_each(|v| v.renumber(by));
    }
    fn outside(&self, range: &Range) -> Option<f64> {
        self.iter().find_map(|v| v.outside(range))
    }
}

impl<T: ParamType + Copy, const N: usize> ParamType for [T; N] {
    fn kind() -> String {
        format!("[{}]", vec![T::kind(); N].join(", "))
    }
    fn read(value: &Value, cx: &mut dyn ReadContext) -> Result<[T; N], SceneError> {
        let Data::Array(items) = &value.data else {
            return Err(wrong_type(value, &format!("an array of {N} values {}", Self::kind())));
        };
        if items.len() != N {
            let message = format!("expected an array of {N} values {}, found {}", Self::kind(), items.len());
            return Err(SceneError::at(ErrorCode::WrongType, value.span, message));
        }
        let mut out = [None; N];
        for (slot, item) in out.iter_mut().zip(items) {
            *slot = Some(T::read(item, cx)?);
        }
        Ok(out.map(|v| v.expect("every slot was filled")))
    }
    fn show(&self) -> String {
        format!("[{}]", self.iter().map(T::show).collect::<Vec<_>>().join(", "))
    }
    fn write(&self, cx: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
        write_list(self, cx)
    }
    fn renumber(&mut self, by: &Renumber) {
        self.iter_mut().for_each(|v| v.renumber(by));
    }
    fn outside(&self, range: &Range) -> Option<f64> {
        self.iter().find_map(|v| v.outside(range))
    }
}

impl ParamType for DVec3 {
    fn kind() -> String {
        "[x, y, z]".into()
    }
    fn read(value: &Value, cx: &mut dyn ReadContext) -> Result<DVec3, SceneError> {
        match &value.data {
            Data::Array(items) if items.len() == 3 => <[f64; 3]>::read(value, cx).map(DVec3::from),
            Data::Array(items) => Err(SceneError::at(
                ErrorCode::WrongType,
                value.span,
                format!("expected three numbers [x, y, z], found {}", items.len()),
            )),
            _ => Err(wrong_type(value, "three numbers [x, y, z]")),
        }
    }
    fn show(&self) -> String {
        self.to_array().show()
    }
    fn write(&self, cx: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
        self.to_array().write(cx)
    }
    fn outside(&self, range: &Range) -> Option<f64> {
        self.to_array().outside(range)
    }
}

impl ParamType for DVec2 {
    fn kind() -> String {
        "[u, v]".into()
    }
    fn read(value: &Value, cx: &mut dyn ReadContext) -> Result<DVec2, SceneError> {
        <[f64; 2]>::read(value, cx).map(DVec2::from)
    }
    fn show(&self) -> String {
        self.to_array().show()
    }
    fn write(&self, cx: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
        self.to_array().write(cx)
    }
    fn outside(&self, range: &Range) -> Option<f64> {
        self.to_array().outside(range)
    }
}

/// A colour. `[r, g, b]` and a single number are linear scene values; `"#rrggbb"`, `"#rgb"` and names are display
/// values, which the film's transfer curve decodes.
impl ParamType for Spectrum {
    fn kind() -> String {
        "color".into()
    }
    fn read(value: &Value, cx: &mut dyn ReadContext) -> Result<Spectrum, SceneError> {
        let band = |v: f64| {
            let band = v as f32;
            if band.is_finite() {
                return Ok(band);
            }
            let message = format!("expected a finite colour value, found {v}");
            Err(SceneError::at(ErrorCode::OutOfRange, value.span, message))
        };
        match &value.data {
            Data::Integer(_) | Data::Number(_) => Ok(Spectrum::grey(band(f64::read(value, cx)?)?)),
            Data::Array(items) if items.len() == 3 => {
                let [r, g, b] = <[f64; 3]>::read(value, cx)?;
                Ok(Spectrum::new(band(r)?, band(g)?, band(b)?))
            }
            Data::String(s) => display_color(s, value).map(|c| cx.transfer().decode_color(c)),
            _ => Err(wrong_type(value, "a colour: [r, g, b], \"#rrggbb\", a name or one number for grey")),
        }
    }
    fn show(&self) -> String {
        let [r, g, b] = self.to_array();
        if r == g && g == b { format!("{r}") } else { format!("[{r}, {g}, {b}]") }
    }
    fn write(&self, _: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
        let [r, g, b] = self.to_array();
        let grey = r.to_bits() == g.to_bits() && g.to_bits() == b.to_bits();
        Ok(Some(if grey { single(r) } else { list([r, g, b].map(single)) }))
    }
    fn outside(&self, range: &Range) -> Option<f64> {
        self.to_array().iter().map(|v| f64::from(*v)).find(|v| !range.contains(*v))
    }
}

fn display_color(text: &str, value: &Value) -> Result<Spectrum, SceneError> {
    if let Some(hex) = text.strip_prefix('#') {
        let digits = u32::from_str_radix(hex, 16).ok().filter(|_| hex.bytes().all(|b| b.is_ascii_hexdigit()));
        return match (digits, hex.len()) {
            (Some(rgb), 6) => Ok(from_rgb24(rgb)),
            (Some(rgb), 3) => {
                let (r, g, b) = (rgb >> 8, rgb >> 4 & 15, rgb & 15);
                Ok(from_rgb24(r * 0x11_0000 + g * 0x1100 + b * 0x11))
            }
            _ => {
                let message = format!("expected #rrggbb or #rgb, found \"{}\"", escape(text));
                Err(SceneError::at(ErrorCode::UnknownName, value.span, message))
            }
        };
    }
    named(text).ok_or_else(|| {
        let names: Vec<&str> = NAMES.iter().map(|(n, _)| *n).collect();
        unknown_name(ErrorCode::UnknownName, value.span, "colour", text, &names)
    })
}

/// A colour, or a texture by name or written in place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ColorSource {
    /// A constant colour.
    Constant(Spectrum),
    /// The colour of a texture.
    Texture(TextureId),
}

impl ParamType for ColorSource {
    fn kind() -> String {
        "color | texture".into()
    }
    fn read(value: &Value, cx: &mut dyn ReadContext) -> Result<ColorSource, SceneError> {
        match &value.data {
            Data::Table(_) => cx.inline_texture(value).map(ColorSource::Texture),
            Data::String(s) => {
                if let Some(id) = cx.texture_named(s) {
                    return Ok(ColorSource::Texture(id));
                }
                match Spectrum::read(value, cx) {
                    Ok(c) => Ok(ColorSource::Constant(c)),
                    Err(error) if s.starts_with('#') => Err(error),
                    Err(_) => {
                        let mut names = cx.texture_names();
                        names.extend(NAMES.iter().map(|(n, _)| *n));
                        Err(unknown_name(ErrorCode::UnknownName, value.span, "texture or colour", s, &names))
                    }
                }
            }
            _ => Spectrum::read(value, cx).map(ColorSource::Constant),
        }
    }
    fn show(&self) -> String {
        match self {
            ColorSource::Constant(c) => c.show(),
            ColorSource::Texture(_) => "a texture".into(),
        }
    }
    fn write(&self, cx: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
        match self {
            ColorSource::Constant(c) => c.write(cx),
            ColorSource::Texture(id) => cx.texture(*id).map(Some),
        }
    }
    fn renumber(&mut self, by: &Renumber) {
        *self = by.source(*self);
    }
    /// The values of textures are checked where they are used.
    fn outside(&self, range: &Range) -> Option<f64> {
        match self {
            ColorSource::Constant(c) => c.outside(range),
            ColorSource::Texture(_) => None,
        }
    }
}

/// A decoded image file.
impl ParamType for ImageId {
    fn kind() -> String {
        "\"image file\"".into()
    }
    fn read(value: &Value, cx: &mut dyn ReadContext) -> Result<ImageId, SceneError> {
        match &value.data {
            Data::String(uri) => cx.image(uri, value.span),
            _ => Err(wrong_type(value, "the name of an image file")),
        }
    }
    fn show(&self) -> String {
        "a file".into()
    }
    fn write(&self, cx: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
        cx.image(*self).map(Some)
    }
    fn renumber(&mut self, by: &Renumber) {
        *self = by.image(*self);
    }
}

/// A material, by its name or written in place.
impl ParamType for MaterialId {
    fn kind() -> String {
        "material".into()
    }
    fn read(value: &Value, cx: &mut dyn ReadContext) -> Result<MaterialId, SceneError> {
        cx.material(value)
    }
    fn show(&self) -> String {
        "a material".into()
    }
    fn write(&self, cx: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
        cx.material(*self).map(Some)
    }
    fn renumber(&mut self, by: &Renumber) {
        *self = by.material(*self);
    }
}

/// A medium, by its name or written in place.
impl ParamType for MediumId {
    fn kind() -> String {
        "medium".into()
    }
    fn read(value: &Value, cx: &mut dyn ReadContext) -> Result<MediumId, SceneError> {
        cx.medium(value)
    }
    fn show(&self) -> String {
        "a medium".into()
    }
    fn write(&self, cx: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
        cx.medium(*self).map(Some)
    }
    fn renumber(&mut self, by: &Renumber) {
        *self = by.medium(*self);
    }
}

/// One word of a choice.
impl<T: Choice> ParamType for T {
    fn kind() -> String {
        T::ALL_WORDS.iter().map(|w| format!("\"{w}\"")).collect::<Vec<_>>().join(" | ")
    }
    fn words() -> &'static [(&'static str, &'static str)] {
        T::ALL_DOCS
    }
    fn read(value: &Value, _: &mut dyn ReadContext) -> Result<T, SceneError> {
        match &value.data {
            Data::String(s) => T::of_word(s).ok_or_else(|| unknown_choice(value, "choice", s, T::ALL_WORDS)),
            _ => Err(wrong_type(value, &Self::kind())),
        }
    }
    fn show(&self) -> String {
        format!("\"{}\"", self.to_word())
    }
    fn write(&self, _: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
        Ok(Some(Data::String(self.to_word().to_owned())))
    }
}

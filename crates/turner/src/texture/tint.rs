//! Colours whose defaults look the same under every transfer curve.

use crate::color::{Transfer, from_rgb24};
use crate::schema::value::{Data, Value};
use crate::schema::{ColorSource, ParamType, ReadContext, Renumber, SceneError, WriteContext};

/// A colour or texture from a scene, or a display colour 0xrrggbb that the film's transfer curve decodes when the
/// texture is prepared. The defaults of wood and marble are display colours: they look the same under every curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tint {
    /// A display colour.
    Display(u32),
    /// A colour in scene values, or a texture.
    Source(ColorSource),
}

impl Tint {
    /// Converts to scene values.
    pub fn resolve(self, transfer: Transfer) -> ColorSource {
        match self {
            Tint::Display(rgb) => ColorSource::Constant(transfer.decode_color(from_rgb24(rgb))),
            Tint::Source(source) => source,
        }
    }

    /// Visits the source unless it is a display colour.
    pub(super) fn visit(self, visit: &mut dyn FnMut(ColorSource)) {
        if let Tint::Source(source) = self {
            visit(source);
        }
    }
}

impl ParamType for Tint {
    fn kind() -> String {
        ColorSource::kind()
    }
    fn read(value: &Value, cx: &mut dyn ReadContext) -> Result<Tint, SceneError> {
        ColorSource::read(value, cx).map(Tint::Source)
    }
    fn renumber(&mut self, by: &Renumber) {
        if let Tint::Source(source) = self {
            source.renumber(by);
        }
    }
    fn show(&self) -> String {
        match self {
            Tint::Display(rgb) => format!("\"#{:06x}\"", rgb & 0xff_ffff),
            Tint::Source(source) => source.show(),
        }
    }
    fn write(&self, cx: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
        match self {
            Tint::Display(rgb) => Ok(Some(Data::String(format!("#{:06x}", rgb & 0xff_ffff)))),
            Tint::Source(source) => source.write(cx),
        }
    }
}

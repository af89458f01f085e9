//! Colour gradients.

use super::prepare::{Kind, PrepareContext};
use super::{Axis, Mapping, Placement, TexturePoint, Textures};
use crate::color::Spectrum;
use crate::schema::value::{Data, Value};
use crate::schema::write::list;
use crate::schema::{
    ColorSource, ErrorCode, ParamType, Range, ReadContext, Renumber, SceneError, Transform, WriteContext,
    choice, params, wrong_type,
};

choice! {
    /// Direction of a gradient.
    pub enum GradientKind {
        /// Along an axis: from −1 to 1.
        Linear = "linear",
        /// Outwards: from the origin to distance 1.
        Radial = "radial",
    }
}

/// A colour at a position of a gradient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// The position, 0..=1.
    pub at: f64,
    /// The colour there.
    pub color: ColorSource,
}

impl ParamType for Stop {
    fn kind() -> String {
        format!("[position, {}]", ColorSource::kind())
    }
    fn read(value: &Value, cx: &mut dyn ReadContext) -> Result<Stop, SceneError> {
        match &value.data {
            Data::Array(items) if items.len() == 2 => {
                Ok(Stop { at: f64::read(&items[0], cx)?, color: ColorSource::read(&items[1], cx)? })
            }
            _ => Err(wrong_type(value, "a pair [position, colour]")),
        }
    }
    fn show(&self) -> String {
        format!("[{}, {}]", self.at.show(), self.color.show())
    }
    fn write(&self, cx: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
        Ok(Some(list([Data::Number(self.at)].into_iter().chain(self.color.write(cx)?))))
    }
    fn renumber(&mut self, by: &Renumber) {
        self.color.renumber(by);
    }
    fn outside(&self, range: &Range) -> Option<f64> {
        self.at.outside(range)
    }
}

params! {
    /// A gradient from one colour to another, along an axis or outwards, optionally through further colours. A linear
    /// gradient runs from −1 to 1, so that density 1 covers a shape; a radial one runs from the origin (the centre of
    /// the surface) to distance 1. Outside this range the colour of the nearer end continues.
    pub struct GradientDesc as "gradient" {
        /// The colour at the start.
        from: ColorSource = ColorSource::Constant(Spectrum::BLACK);
        /// The colour at the end.
        to: ColorSource = ColorSource::Constant(Spectrum::WHITE);
        /// Colours in between: [[position, colour], …], with positions in order from 0, the start, to 1, the end. Two
        /// stops at one position make a hard edge.
        stops: Vec<Stop> = Vec::new(), in Range::UNIT;
        /// Linear (along an axis) or radial (outwards).
        kind: GradientKind = GradientKind::Linear;
        /// Axis of a linear gradient: "x" is the first texture coordinate (u on a surface), "y" the second (v); "z"
        /// is for `mapping = "solid"`.
        axis: Axis = Axis::X;
        /// Scales the gradient: with density 2 it is half as long.
        density: f64 = 1.0;
        /// Where the texture coordinates come from.
        mapping: Mapping = Mapping::Uv;
        /// For `mapping = "triplanar"`: sharpness of the transitions between the three projections; higher is sharper.
        blend: f64 = 4.0, in Range::closed(1.0, 64.0);
        /// Translates, rotates or scales the gradient.
        transform: Transform = Transform::IDENTITY;
    }
    example r##"[texture.dusk]
type = "gradient"
axis = "y"
from = "midnightblue"
to = "gold"
stops = [[0.4, "mediumvioletred"], [0.7, "tomato"]]

[[object]]
type = "sphere"
material = { color = "dusk" }
"##
}

/// A colour gradient.
#[derive(Clone, Debug)]
pub(super) struct Gradient {
    /// From position 0 to 1, in order.
    stops: Box<[Stop]>,
    kind: GradientKind,
    axis: Axis,
    placement: Placement,
}

impl Kind for GradientDesc {
    type Prepared = Gradient;
    const MAX_INPUTS: u64 = 2;

    fn sources(&self, visit: &mut dyn FnMut(ColorSource)) {
        visit(self.from);
        visit(self.to);
        self.stops.iter().for_each(|stop| visit(stop.color));
    }

    fn mapping(&self) -> Mapping {
        self.mapping
    }

    fn triplanar(&self) -> Option<(f64, Transform)> {
        (self.mapping == Mapping::Triplanar).then_some((self.blend, self.transform))
    }

    fn prepare(&self, _: &mut PrepareContext<'_>) -> Result<Gradient, SceneError> {
        let mut stops = vec![Stop { at: 0.0, color: self.from }];
        stops.extend_from_slice(&self.stops);
        stops.push(Stop { at: 1.0, color: self.to });
        if let Some(bad) = stops.iter().find(|stop| !(0.0..=1.0).contains(&stop.at)) {
            let message = format!("the positions of stops must be from 0 to 1, found {}", bad.at);
            return Err(SceneError::new(ErrorCode::OutOfRange, message));
        }
        if let Some(pair) = stops.windows(2).find(|pair| pair[0].at > pair[1].at) {
            let message = format!("the stop at {} follows the one at {}", pair[1].at, pair[0].at);
            return Err(SceneError::new(ErrorCode::Conflict, message).help("give the stops in order, 0 to 1"));
        }
        Ok(Gradient {
            stops: stops.into(),
            kind: self.kind,
            axis: self.axis,
            placement: Placement::new(self.mapping, self.density, self.transform),
        })
    }
}

impl Gradient {
    pub(super) fn eval(&self, textures: &Textures, at: &TexturePoint<'_>) -> Spectrum {
        let c = self.placement.coordinates(at);
        let position = match self.kind {
            GradientKind::Linear => 0.5 + 0.5 * self.axis.of(c),
            GradientKind::Radial => c.length(),
        };
        // Of several stops at one position the last applies from there on.
        let after = self.stops.partition_point(|stop| stop.at <= position);
        if after == 0 {
            return textures.color(self.stops[0].color, at);
        }
        let a = self.stops[after - 1];
        let Some(b) = self.stops.get(after) else { return textures.color(a.color, at) };
        textures.mix(a.color, b.color, (position - a.at) / (b.at - a.at), at)
    }

    /// See [`Placement::spacing`].
    pub(super) fn spacing(&self, _: &Textures, at: &TexturePoint<'_>) -> Option<f64> {
        self.placement.spacing(at)
    }

    pub(super) fn memory(&self) -> usize {
        size_of_val(&*self.stops)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{at, prepare_texture, read, table, text, value};
    use super::*;
    use crate::color::Transfer;

    fn stop(position: f64, color: &str) -> Value {
        value(Data::Array(vec![value(Data::Number(position)), value(text(color))]))
    }

    #[test]
    fn a_gradient_runs_from_end_to_end_and_goes_on() {
        let g = prepare_texture("gradient", &[]);
        for (s, expected) in [(-5.0, 0.0), (-1.0, 0.0), (-0.5, 0.25), (0.0, 0.5), (1.0, 1.0), (9.0, 1.0)] {
            assert_eq!(at(&g, s, 0.3), Spectrum::grey(expected), "at {s}");
        }
        let g = prepare_texture("gradient", &[("axis", text("y")), ("density", Data::Integer(2))]);
        assert_eq!(at(&g, 0.9, 0.25), Spectrum::grey(0.75));
        assert_eq!(at(&g, 0.9, 0.5), Spectrum::WHITE);
        let g = prepare_texture("gradient", &[("kind", text("radial"))]);
        assert_eq!(at(&g, 0.0, 0.0), Spectrum::BLACK);
        assert_eq!(at(&g, -0.3, 0.4), Spectrum::grey(0.5));
        assert_eq!(at(&g, 1.0, 1.0), Spectrum::WHITE);
        let turn = table(&[("rotate", super::super::tests::list(&[0.0, 0.0, 90.0]))]);
        let g = prepare_texture("gradient", &[("transform", turn)]);
        assert_eq!(at(&g, 0.7, 0.5), Spectrum::grey(0.75));
    }

    #[test]
    fn stops_are_reached_and_two_at_one_place_make_an_edge() {
        let stops = vec![stop(0.25, "red"), stop(0.5, "lime"), stop(0.5, "blue")];
        let g = prepare_texture("gradient", &[("stops", Data::Array(stops))]);
        assert_eq!(at(&g, -0.5, 0.0), Spectrum::new(1.0, 0.0, 0.0));
        assert_eq!(at(&g, -0.25, 0.0), Spectrum::new(0.5, 0.5, 0.0));
        assert_eq!(at(&g, 0.0, 0.0), Spectrum::new(0.0, 0.0, 1.0));
        assert!((at(&g, -1e-9, 0.0) - Spectrum::new(0.0, 1.0, 0.0)).map(f32::abs).max_component() < 1e-6);
        assert_eq!(at(&g, 0.5, 0.0), Spectrum::new(0.5, 0.5, 1.0));
    }

    #[test]
    fn wrong_stops_are_refused() {
        let with = |stops| read("gradient", &[("stops", Data::Array(stops))]);
        assert_eq!(with(vec![stop(1.5, "red")]).unwrap_err().code, ErrorCode::OutOfRange);
        assert_eq!(with(vec![value(text("red"))]).unwrap_err().code, ErrorCode::WrongType);
        let scene = with(vec![stop(0.5, "red"), stop(0.2, "red")]).unwrap();
        let error = Textures::prepare(&scene.textures, &[], Transfer::None, false).unwrap_err();
        assert_eq!(error.code, ErrorCode::Conflict);
        assert!(error.span.is_some());
    }
}

//! A run from colour to colour.

use super::prepare::{Kind, Preparing};
use super::{Axis, Mapping, Placement, TexturePoint, Textures};
use crate::color::Spectrum;
use crate::schema::value::{Data, Value};
use crate::schema::write::list;
use crate::schema::{
    ColorSource, ErrorCode, ParamType, Range, ReadContext, Renumber, SceneError, Transform, WriteContext,
    choice, params, wrong_type,
};

choice! {
    /// How a gradient runs.
    pub enum GradientKind {
        /// Along an axis: 0 at −1, 1 at 1.
        Linear = "linear",
        /// Outwards: 0 at the origin, 1 at distance 1 from it.
        Radial = "radial",
    }
}

/// A colour at a place on a gradient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// The place, 0..=1.
    pub at: f64,
    /// The colour there.
    pub color: ColorSource,
}

impl ParamType for Stop {
    fn kind() -> String {
        format!("[place, {}]", ColorSource::kind())
    }
    fn read(value: &Value, cx: &mut dyn ReadContext) -> Result<Stop, SceneError> {
        match &value.data {
            Data::Array(items) if items.len() == 2 => {
                Ok(Stop { at: f64::read(&items[0], cx)?, color: ColorSource::read(&items[1], cx)? })
            }
            _ => Err(wrong_type(value, "a pair [place, colour]")),
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
    /// Runs from one colour to another, along an axis or outwards, through others on the way if wanted. Along an axis it begins at −1
    /// and ends at 1, so that density 1 covers a shape; outwards it begins at the origin (the middle of a surface) and ends at distance 1.
    /// Beyond the ends the last colour goes on.
    pub struct GradientDesc as "gradient" {
        /// The colour at the beginning.
        from: ColorSource = ColorSource::Constant(Spectrum::BLACK);
        /// The colour at the end.
        to: ColorSource = ColorSource::Constant(Spectrum::WHITE);
        /// Colours on the way: [[place, colour], …] with places in order, 0 the beginning and 1 the end. Two at one place make an edge.
        stops: Vec<Stop> = Vec::new(), in Range::UNIT;
        /// Along an axis, or outwards.
        kind: GradientKind = GradientKind::Linear;
        /// The axis of a linear gradient: "x" is s on a surface, "y" is t; "z" is for `mapping = "solid"`.
        axis: Axis = Axis::X;
        /// Number of times it fits into −1..1.
        density: f64 = 1.0;
        /// How the gradient lies on the surface or goes through the solid.
        mapping: Mapping = Mapping::Uv;
        /// For `mapping = "triplanar"`: how sharply one direction follows another where the surface turns.
        blend: f64 = 4.0, in Range::closed(1.0, 64.0);
        /// Moves and turns the gradient.
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

/// A run from colour to colour.
#[derive(Clone, Debug)]
pub(super) struct Gradient {
    /// From 0 to 1, in order.
    stops: Box<[Stop]>,
    kind: GradientKind,
    axis: Axis,
    placement: Placement,
}

impl Kind for GradientDesc {
    type Ready = Gradient;
    const AT_ONCE: u64 = 2;

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

    fn prepare(&self, _: &mut Preparing<'_>) -> Result<Gradient, SceneError> {
        let mut stops = vec![Stop { at: 0.0, color: self.from }];
        stops.extend_from_slice(&self.stops);
        stops.push(Stop { at: 1.0, color: self.to });
        if let Some(bad) = stops.iter().find(|stop| !(0.0..=1.0).contains(&stop.at)) {
            let message = format!("the places of stops must be 0 to 1, found {}", bad.at);
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
        let place = match self.kind {
            GradientKind::Linear => 0.5 + 0.5 * self.axis.of(c),
            GradientKind::Radial => c.length(),
        };
        // Of the stops at one place the last counts from there on.
        let after = self.stops.partition_point(|stop| stop.at <= place);
        if after == 0 {
            return textures.color(self.stops[0].color, at);
        }
        let a = self.stops[after - 1];
        let Some(b) = self.stops.get(after) else { return textures.color(a.color, at) };
        textures.mix(a.color, b.color, (place - a.at) / (b.at - a.at), at)
    }

    /// A step on the surface over which it changes little, as [`Placement::spacing`].
    pub(super) fn spacing(&self, _: &Textures, at: &TexturePoint<'_>) -> Option<f64> {
        self.placement.spacing(at)
    }

    pub(super) fn memory(&self) -> usize {
        size_of_val(&*self.stops)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{at, read, ready, table, text, value};
    use super::*;
    use crate::color::Transfer;

    fn stop(place: f64, color: &str) -> Value {
        value(Data::Array(vec![value(Data::Number(place)), value(text(color))]))
    }

    #[test]
    fn a_gradient_runs_from_end_to_end_and_goes_on() {
        let g = ready("gradient", &[]);
        for (s, expected) in [(-5.0, 0.0), (-1.0, 0.0), (-0.5, 0.25), (0.0, 0.5), (1.0, 1.0), (9.0, 1.0)] {
            assert_eq!(at(&g, s, 0.3), Spectrum::grey(expected), "at {s}");
        }
        let g = ready("gradient", &[("axis", text("y")), ("density", Data::Integer(2))]);
        assert_eq!(at(&g, 0.9, 0.25), Spectrum::grey(0.75));
        assert_eq!(at(&g, 0.9, 0.5), Spectrum::WHITE);
        let g = ready("gradient", &[("kind", text("radial"))]);
        assert_eq!(at(&g, 0.0, 0.0), Spectrum::BLACK);
        assert_eq!(at(&g, -0.3, 0.4), Spectrum::grey(0.5));
        assert_eq!(at(&g, 1.0, 1.0), Spectrum::WHITE);
        let turn = table(&[("rotate", super::super::tests::list(&[0.0, 0.0, 90.0]))]);
        let g = ready("gradient", &[("transform", turn)]);
        assert_eq!(at(&g, 0.7, 0.5), Spectrum::grey(0.75));
    }

    #[test]
    fn stops_are_reached_and_two_at_one_place_make_an_edge() {
        let stops = vec![stop(0.25, "red"), stop(0.5, "lime"), stop(0.5, "blue")];
        let g = ready("gradient", &[("stops", Data::Array(stops))]);
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

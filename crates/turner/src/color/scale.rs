//! The scale of a picture whose colours stand for numbers, such as a heat map.

/// Which values the colours of the map [`heat`](super::heat) stand for.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorScale {
    /// What the values are measured in, in a few words.
    pub unit: &'static str,
    /// Places in the map, from 0 (black) to 1 (pale yellow), and their values, from 0 upwards.
    pub marks: Vec<(f32, f64)>,
}

impl ColorScale {
    /// Values that rise evenly from `least` to `most`, with five marks.
    pub fn linear(least: f64, most: f64, unit: &'static str) -> ColorScale {
        let at = |place: f32| (place, least + (most - least) * f64::from(place));
        ColorScale { unit, marks: [0.0, 0.25, 0.5, 0.75, 1.0].map(at).into() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_scale_has_even_marks() {
        let scale = ColorScale::linear(-5.0, 5.0, "stops");
        assert_eq!(scale.marks, [(0.0, -5.0), (0.25, -2.5), (0.5, 0.0), (0.75, 2.5), (1.0, 5.0)]);
    }
}

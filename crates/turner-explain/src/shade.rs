//! Scene values as the picture displays them.

use turner::color::Spectrum;
use turner::film::FilmDesc;

/// Exposure, tone mapping and transfer function, to 8 bits.
pub(crate) struct Display<'a> {
    film: &'a FilmDesc,
    factor: f32,
}

impl Display<'_> {
    pub(crate) fn new(film: &FilmDesc) -> Display<'_> {
        let stops = film.exposure.clamp(-64.0, 64.0);
        Display { film, factor: turner::math::elementary::pow(2.0, stops) as f32 }
    }

    /// Red, green and blue; magenta for NaN.
    pub(crate) fn rgb(&self, color: Spectrum) -> [u8; 3] {
        if color.to_array().iter().any(|v| v.is_nan()) {
            return [255, 0, 255];
        }
        let shown = self.film.tonemap.map(color * self.factor).to_array();
        shown.map(|v| (f64::from(self.film.transfer.encode(v)) * 255.0 + 0.5) as u8)
    }

    /// `#rrggbb`
    pub(crate) fn hex(&self, color: Spectrum) -> String {
        let [r, g, b] = self.rgb(color);
        format!("#{r:02x}{g:02x}{b:02x}")
    }
}

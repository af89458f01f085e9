//! Ambient light: the same everywhere, from nowhere.

use crate::color::Spectrum;
use crate::schema::{Range, params};

params! {
    /// Light that reaches every point alike and casts no shadow: the documents' stand-in for light between surfaces.
    pub struct AmbientDesc as "ambient" {
        /// Its colour.
        color: Spectrum = Spectrum::WHITE;
        /// Its strength.
        intensity: f64 = 0.1, in Range::NON_NEGATIVE;
    }
    example r#"[[light]]
type = "ambient"
intensity = 0.2
"#
}

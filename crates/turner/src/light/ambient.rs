//! Ambient light: constant everywhere, without a direction.

use crate::color::Spectrum;
use crate::schema::{Range, params};

params! {
    /// Constant light that reaches every point equally and casts no shadow: classic ray tracing's approximation of
    /// light between surfaces.
    pub struct AmbientDesc as "ambient" {
        /// Colour of the light.
        color: Spectrum = Spectrum::WHITE;
        /// Strength of the light.
        intensity: f64 = 0.1, in Range::NON_NEGATIVE;
    }
    example r#"[[light]]
type = "ambient"
intensity = 0.2
"#
}

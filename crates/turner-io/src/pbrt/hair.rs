//! The material "hair": the model of Turner's.

use turner::material::HairMaterial;
use turner::schema::ColorSource;

use super::params::Type;
use super::report::Fault;
use super::spectra::{Role, color};
use super::surfaces::Maker;

impl Maker<'_, '_> {
    pub(super) fn hair(&mut self) -> Result<HairMaterial, Fault> {
        let number = |maker: &mut Self, name: &'static str, or: f64, to: [f64; 2]| {
            let value = match maker.number(name)? {
                None => or,
                Some(ColorSource::Constant(c)) => f64::from(c.g),
                Some(ColorSource::Texture(_)) => {
                    let message = format!("a texture of {name} of hair: {or} replaces it");
                    maker.scene.report.approximated(maker.params.place_of(name), message);
                    or
                }
            };
            Ok::<f64, Fault>(value.clamp(to[0], to[1]))
        };
        let mut hair = HairMaterial {
            ior: number(self, "eta", 1.55, [1.0, 10.0])?,
            beta_m: number(self, "beta_m", 0.3, [0.0, 1.0])?,
            beta_n: number(self, "beta_n", 0.3, [0.0, 1.0])?,
            alpha: number(self, "alpha", 2.0, [-30.0, 30.0])?,
            ..HairMaterial::default()
        };
        // As in pbrt, the first of these that is given counts.
        if self.params.has("sigma_a") {
            if self.params.is("sigma_a", Type::Texture) {
                let message = "a texture of sigma_a of hair: brown hair replaces it";
                self.scene.report.approximated(self.params.place_of("sigma_a"), message);
                self.params.pass(&["sigma_a"]);
            } else {
                let found = color(self.scene, self.space, self.params, "sigma_a", Role::Unbounded)?;
                hair.sigma_a = found.map(|c| c.map(|v| v.clamp(0.0, 1e6)));
            }
        } else if self.params.has("reflectance") {
            hair.color = Some(self.color("reflectance", 0.3)?);
        } else if self.params.has("eumelanin") || self.params.has("pheomelanin") {
            hair.eumelanin = number(self, "eumelanin", 0.0, [0.0, 1e6])?;
            hair.pheomelanin = number(self, "pheomelanin", 0.0, [0.0, 1e6])?;
        }
        self.params.pass(&["sigma_a", "reflectance", "eumelanin", "pheomelanin"]);
        Ok(hair)
    }
}

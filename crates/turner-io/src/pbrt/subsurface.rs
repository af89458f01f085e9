//! Subsurface scattering: `subsurface`, and `kdsubsurface` of pbrt-v3.

use turner::color::Spectrum;
use turner::material::PrincipledMaterial;
use turner::math::elementary::exp;
use turner::schema::ColorSource;

use super::report::Fault;
use super::spectra::{self, Role};
use super::surfaces::{Maker, grey};
use crate::assets::printable;
use crate::scene_import::{inner_reflectance, named_medium};

impl Maker<'_, '_> {
    /// `reflectance` is the name of the diffuse reflectance, if the material always has one.
    pub(super) fn subsurface(
        &mut self,
        reflectance: Option<&'static str>,
    ) -> Result<PrincipledMaterial, Fault> {
        let place = self.params.place;
        let scale = self.params.float("scale").unwrap_or(1.0).max(0.0);
        let named = self.params.string("name").map(str::to_owned);
        let plain = PrincipledMaterial { specular_ior: 1.33, ..PrincipledMaterial::default() };
        let mut surface = self.with_index("eta", plain)?;
        let (color, radius) = if reflectance.is_some() || self.params.has("reflectance") {
            let color = self.color(reflectance.unwrap_or("reflectance"), 0.5)?;
            let mfp = spectra::color(self.scene, self.space, self.params, "mfp", Role::Unbounded)?;
            let mfp = mfp.unwrap_or(Spectrum::WHITE);
            (color, f64::from((mfp.r + mfp.g + mfp.b) / 3.0) * scale)
        } else {
            let found = named.as_deref().and_then(named_medium);
            if let (Some(name), None) = (&named, found) {
                let message = format!("unknown medium \"{}\" of a subsurface material", printable(name));
                self.scene.report.ignored(self.params.place_of("name"), message);
            }
            let (a, s) = match found {
                Some(found) => found,
                None => {
                    let a = spectra::color(self.scene, self.space, self.params, "sigma_a", Role::Unbounded)?;
                    let s = spectra::color(self.scene, self.space, self.params, "sigma_s", Role::Unbounded)?;
                    (
                        a.unwrap_or(Spectrum::new(0.0011, 0.0024, 0.014)),
                        s.unwrap_or(Spectrum::new(2.55, 3.21, 3.77)),
                    )
                }
            };
            let g = self.params.float("g").unwrap_or(0.0).clamp(-0.999, 0.999) as f32;
            let (a, s) = (a.to_array(), s.to_array());
            let mut color = [0.0; 3];
            let mut mean = 0.0;
            for (i, c) in color.iter_mut().enumerate() {
                let scattering = s[i] * (1.0 - g);
                let extinction = a[i] + scattering;
                let albedo = if extinction > 0.0 { scattering / extinction } else { 0.0 };
                // Diffuse reflectance of a half-space with a boundary (dipole: Jensen et al. 2001, eq. 15).
                let inner = inner_reflectance(surface.specular_ior);
                let (a, q) =
                    ((1.0 + inner) / (1.0 - inner), (3.0 * (1.0 - f64::from(albedo)).max(0.0)).sqrt());
                *c = (0.5 * f64::from(albedo) * (1.0 + exp(-4.0 / 3.0 * a * q)) * exp(-q)) as f32;
                mean += f64::from(extinction) / 3.0;
            }
            let radius = if mean * scale > 0.0 { 1.0 / (mean * scale) } else { 0.0 };
            (ColorSource::Constant(color.into()), radius)
        };
        self.params.pass(&["mfp", "reflectance", "sigma_a", "sigma_s", "g", "name"]);
        self.scene.report.approximated(place, "a subsurface material: matched by colour and mean free path");
        surface.subsurface_weight = grey(1.0);
        surface.subsurface_color = color;
        surface.subsurface_radius = if radius.is_finite() { radius.clamp(0.0, 1e30) } else { 0.0 };
        self.roughness(["roughness", "uroughness", "vroughness"], 0.0, &mut surface)?;
        surface.transmission_dispersion_scale = 0.0;
        Ok(surface)
    }
}

//! Measured BRDFs in the parameterisation of Dupuy and Jakob (2018, "An adaptive parameterization for efficient material
//! acquisition and rendering"), as in the files of the RGL material database.

mod piecewise_linear;

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;

use crate::math::DVec3;
use crate::math::elementary::{acos, atan2};
use crate::schema::value::{Data, Value};
use crate::schema::{ParamType, ReadContext, SceneError, WriteContext, wrong_type};

use piecewise_linear::{PiecewiseLinear2D, Slices};

/// Most values of one table of a measured BRDF.
pub const MAX_MEASURED_VALUES: u64 = 1 << 28;

/// A table as a file has it: values by the last index first.
#[derive(Clone, Debug, Default)]
pub struct MeasuredTable {
    /// Number of columns and rows, each at least 2.
    pub size: [usize; 2],
    /// The values: slices, rows, columns.
    pub values: Vec<f32>,
}

/// What a file of a measured BRDF holds. Angles are those of the direction of view, in radians.
#[derive(Clone, Debug, Default)]
pub struct MeasuredFields {
    /// Angles from the normal, increasing.
    pub theta_i: Vec<f32>,
    /// Azimuths, increasing; one or two if the material is isotropic.
    pub phi_i: Vec<f32>,
    /// Distribution of normals of microfacets.
    pub ndf: MeasuredTable,
    /// Projected area of the microfacets, by direction.
    pub sigma: MeasuredTable,
    /// Distribution of visible normals: a slice for each azimuth and, within it, each angle from the normal.
    pub vndf: MeasuredTable,
    /// Luminance, in the space of the numbers that sample the visible normals; slices as those of `vndf`.
    pub luminance: MeasuredTable,
    /// Linear sRGB, three slices for each of `luminance`.
    pub rgb: MeasuredTable,
    /// Whether `rgb` is the BRDF without the factor ndf / (4 sigma).
    pub jacobian: bool,
}

/// A measured BRDF.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredBrdf {
    theta: Vec<f32>,
    phi: Vec<f32>,
    ndf: PiecewiseLinear2D,
    sigma: PiecewiseLinear2D,
    vndf: PiecewiseLinear2D,
    luminance: PiecewiseLinear2D,
    rgb: PiecewiseLinear2D,
    jacobian: bool,
    symmetry: Symmetry,
}

/// Which directions of view are measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Symmetry {
    /// One azimuth stands for all.
    Isotropic,
    /// All azimuths.
    None,
    /// Half of them: turned by 180° the material is the same.
    Half,
    /// A quarter: mirrored along x or y the material is the same.
    Quarter,
}

/// A BRDF seen from one direction.
#[derive(Clone, Copy, Debug)]
pub struct MeasuredView {
    slices: Slices,
    /// Azimuth of the direction of view if the material is isotropic: that of a normal is relative to it.
    turned: f64,
    /// Signs by which x and y of all directions are multiplied.
    signs: [f64; 2],
    /// The factor of the values that depends on the direction of view alone.
    factor: f64,
}

impl MeasuredBrdf {
    /// From the fields of a file.
    ///
    /// Errors: angles out of order or out of range, tables whose sizes disagree, values that are not finite, and negative
    /// ones other than colours.
    pub fn new(fields: MeasuredFields) -> Result<MeasuredBrdf, String> {
        let MeasuredFields { theta_i: theta, phi_i: phi, ndf, sigma, vndf, luminance, rgb, jacobian } =
            fields;
        for (name, angles, [low, high]) in [("theta_i", &theta, [0.0, FRAC_PI_2]), ("phi_i", &phi, [-PI, PI])]
        {
            let is_within = |v: &f32| (low - 1e-4..=high + 1e-4).contains(&f64::from(*v));
            if angles.is_empty() || !angles.iter().all(is_within) {
                return Err(format!("the angles {name} are not within {low:.4} to {high:.4}"));
            }
            if !angles.windows(2).all(|w| w[0] < w[1]) {
                return Err(format!("the angles {name} do not increase"));
            }
        }
        let views = theta.len() as u64 * phi.len() as u64;
        for (name, table, slices, least) in [
            ("ndf", &ndf, 1, 0.0),
            ("sigma", &sigma, 1, 0.0),
            ("vndf", &vndf, views, 0.0),
            ("luminance", &luminance, views, 0.0),
            ("rgb", &rgb, views * 3, -1e6f32),
        ] {
            let [width, height] = table.size;
            if width.min(height) < 2 {
                return Err(format!(
                    "the table {name} has {width} × {height} values: expected 2 × 2 or more"
                ));
            }
            let wanted = (width as u64).saturating_mul(height as u64).saturating_mul(slices);
            if wanted != table.values.len() as u64 || wanted > MAX_MEASURED_VALUES {
                return Err(format!("the table {name} has {} values: expected {wanted}", table.values.len()));
            }
            if let Some(bad) = table.values.iter().find(|v| !(least..=1e6).contains(*v)) {
                return Err(format!("the table {name} holds {bad}: expected {least} to 1e6"));
            }
        }
        let symmetry = symmetry(&phi)?;
        let [plain, density] = [PiecewiseLinear2D::new, PiecewiseLinear2D::densities];
        let make = |make: fn(usize, usize, Vec<f32>) -> PiecewiseLinear2D, table: MeasuredTable| {
            make(table.size[0], table.size[1], table.values)
        };
        Ok(MeasuredBrdf {
            ndf: make(plain, ndf),
            sigma: make(plain, sigma),
            vndf: make(density, vndf),
            luminance: make(density, luminance),
            rgb: make(plain, rgb),
            theta,
            phi,
            jacobian,
            symmetry,
        })
    }

    /// The fields of a file with this BRDF.
    pub fn fields(&self) -> MeasuredFields {
        let table = |t: &PiecewiseLinear2D| MeasuredTable { size: t.size(), values: t.values().to_vec() };
        MeasuredFields {
            theta_i: self.theta.clone(),
            phi_i: self.phi.clone(),
            ndf: table(&self.ndf),
            sigma: table(&self.sigma),
            vndf: table(&self.vndf),
            luminance: table(&self.luminance),
            rgb: table(&self.rgb),
            jacobian: self.jacobian,
        }
    }

    /// Whether it is the same from all azimuths.
    pub fn is_isotropic(&self) -> bool {
        self.symmetry == Symmetry::Isotropic
    }

    /// The BRDF seen from `wo`, a unit vector above the surface.
    pub fn seen_from(&self, wo: DVec3) -> MeasuredView {
        let sign = |v: f64| if v > 0.0 { -1.0 } else { 1.0 };
        let signs = match self.symmetry {
            Symmetry::Isotropic | Symmetry::None => [1.0, 1.0],
            Symmetry::Half => [sign(wo.y); 2],
            Symmetry::Quarter => [sign(wo.x), sign(wo.y)],
        };
        let theta = acos(wo.z.clamp(0.0, 1.0));
        let phi = match (self.symmetry, atan2(wo.y * signs[1], wo.x * signs[0])) {
            // The azimuths of a part begin at −π, which is also π.
            (Symmetry::Half | Symmetry::Quarter, phi) if phi > FRAC_PI_2 => phi - TAU,
            (_, phi) => phi,
        };
        let slices = Slices::new(between(&self.phi, phi), between(&self.theta, theta), self.theta.len());
        let factor = if self.jacobian {
            let sigma = self.sigma.eval([number_of_theta(theta), number_of_phi(phi)], &Slices::ONLY);
            if sigma > 0.0 { 0.25 / sigma } else { 0.0 }
        } else {
            1.0
        };
        MeasuredView { slices, turned: if self.is_isotropic() { phi } else { 0.0 }, signs, factor }
    }

    /// The numbers in 0..=1 that stand for a normal of microfacets, a unit vector.
    pub fn numbers_of_normal(&self, wm: DVec3, view: &MeasuredView) -> [f64; 2] {
        let phi = atan2(wm.y * view.signs[1], wm.x * view.signs[0]) - view.turned;
        let turn = number_of_phi(phi);
        [number_of_theta(acos(wm.z.clamp(-1.0, 1.0))), turn - turn.floor()]
    }

    /// The normal of microfacets for numbers in 0..=1: angle from the normal and azimuth, in radians.
    pub fn angles_of_numbers(&self, u: [f64; 2], view: &MeasuredView) -> [f64; 2] {
        [u[0] * u[0] * FRAC_PI_2, (2.0 * u[1] - 1.0) * PI + view.turned]
    }

    /// BRDF times the cosine of the direction of light, where the visible normal has the numbers `normal`, for which
    /// `number` is sampled.
    pub fn value(&self, number: [f64; 2], normal: [f64; 2], view: &MeasuredView) -> DVec3 {
        let channel = |c| self.rgb.eval(number, &view.slices.of_channel(c, 3)).max(0.0);
        let facets = if self.jacobian { self.ndf.eval(normal, &Slices::ONLY) } else { 1.0 };
        DVec3::new(channel(0), channel(1), channel(2)) * (facets * view.factor)
    }

    /// Samples a visible normal: its numbers, those that it was sampled by, and the density of its numbers.
    pub fn sample(&self, u: [f64; 2], view: &MeasuredView) -> ([f64; 2], [f64; 2], f64) {
        let (number, by_luminance) = self.luminance.sample(u, &view.slices);
        let (normal, by_facets) = self.vndf.sample(number, &view.slices);
        (normal, number, by_luminance * by_facets)
    }

    /// The numbers by which a visible normal is sampled, and the density of its own numbers.
    pub fn invert(&self, normal: [f64; 2], view: &MeasuredView) -> ([f64; 2], f64) {
        let (number, by_facets) = self.vndf.invert(normal, &view.slices);
        (number, by_facets * self.luminance.eval(number, &view.slices))
    }

    /// α of a GGX distribution with the same density of microfacets along the normal, 0 to 1.
    pub fn alpha(&self) -> f64 {
        let density = self.ndf.eval([0.0, 0.5], &Slices::ONLY);
        let area = self.sigma.eval([0.0, 0.5], &Slices::ONLY);
        if density > 0.0 { (area / (PI * density)).sqrt().min(1.0) } else { 1.0 }
    }
}

impl MeasuredView {
    /// A direction of the local frame in the frame of the tables, or back.
    pub fn mirrored(&self, w: DVec3) -> DVec3 {
        DVec3::new(w.x * self.signs[0], w.y * self.signs[1], w.z)
    }
}

fn symmetry(phi: &[f32]) -> Result<Symmetry, String> {
    if phi.len() <= 2 {
        return Ok(Symmetry::Isotropic);
    }
    let span = f64::from(phi[phi.len() - 1]) - f64::from(phi[0]);
    match (TAU / span).round() {
        1.0 => Ok(Symmetry::None),
        2.0 => Ok(Symmetry::Half),
        4.0 => Ok(Symmetry::Quarter),
        _ => Err(format!("the angles phi_i span {span:.3}: expected a circle, a half or a quarter of it")),
    }
}

fn number_of_theta(theta: f64) -> f64 {
    (theta / FRAC_PI_2).max(0.0).sqrt()
}

fn number_of_phi(phi: f64) -> f64 {
    (phi + PI) / TAU
}

/// The two of increasing values around `v`, with their weights.
fn between(values: &[f32], v: f64) -> [(usize, f64); 2] {
    let i = values.partition_point(|at| f64::from(*at) <= v).saturating_sub(1);
    let Some(next) = values.get(i + 1).map(|v| f64::from(*v)) else { return [(i, 1.0), (i, 0.0)] };
    let here = f64::from(values[i]);
    let part = ((v - here) / (next - here)).clamp(0.0, 1.0);
    [(i, 1.0 - part), (i + 1, part)]
}

/// The file of a measured BRDF. Two are equal if their data are equal.
#[derive(Clone, Debug)]
pub struct MeasuredFile {
    /// The file name as written in the scene.
    pub uri: String,
    /// Its data.
    pub data: Arc<MeasuredBrdf>,
}

impl PartialEq for MeasuredFile {
    fn eq(&self, other: &MeasuredFile) -> bool {
        Arc::ptr_eq(&self.data, &other.data) || self.data == other.data
    }
}

impl Default for MeasuredFile {
    /// A diffuse grey, as measured from one direction.
    fn default() -> MeasuredFile {
        MeasuredFile { uri: String::new(), data: Arc::new(MeasuredBrdf::grey()) }
    }
}

impl MeasuredBrdf {
    /// A smooth distribution of microfacets whose light is grey.
    fn grey() -> MeasuredBrdf {
        let table = |slices: usize, v: f32| MeasuredTable { size: [2, 2], values: vec![v; 4 * slices] };
        let fields = MeasuredFields {
            theta_i: vec![0.0],
            phi_i: vec![0.0],
            ndf: table(1, 1.0),
            sigma: table(1, 1.0),
            vndf: table(1, 1.0),
            luminance: table(1, 1.0),
            rgb: table(3, 0.15),
            jacobian: false,
        };
        MeasuredBrdf::new(fields).unwrap_or_else(|_| unreachable!("the fields agree"))
    }
}

impl ParamType for MeasuredFile {
    fn kind() -> String {
        "\"BSDF file\"".into()
    }
    fn read(value: &Value, cx: &mut dyn ReadContext) -> Result<MeasuredFile, SceneError> {
        match &value.data {
            Data::String(uri) => {
                Ok(MeasuredFile { uri: uri.clone(), data: cx.measured_brdf(uri, value.span)? })
            }
            _ => Err(wrong_type(value, "the name of a BSDF file")),
        }
    }
    fn show(&self) -> String {
        "a file".into()
    }
    fn write(&self, cx: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
        cx.measured_brdf(self).map(Some)
    }
}

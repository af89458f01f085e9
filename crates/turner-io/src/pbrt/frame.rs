//! What comes before `WorldBegin`: film, sampler, pixel filter, integrator, options.

use turner::camera::CameraDesc;
use turner::color::Spectrum;
use turner::description::SceneDesc;
use turner::film::{Antialias, ClampSpace, TextureFilter};
use turner::filter::FilterKind;
use turner::integrator::{AmbientOcclusionDesc, DirectDesc, IntegratorDesc, PathDesc};
use turner::math::{DMat3, DVec3};
use turner::schema::Named;

use super::params::Params;
use super::report::Report;
use crate::assets::printable;
use crate::spectral;

/// Most columns or rows.
const MAX_SIDE: i32 = 65536;

/// Camera, film and integrator of the file, with pbrt's defaults.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    pub(super) camera: Option<Named<CameraDesc>>,
    pub(super) size: [u32; 2],
    crop: Option<[u32; 4]>,
    samples: u32,
    filter: Option<(FilterKind, f64)>,
    integrator: IntegratorDesc,
    pub(super) shutter: [f64; 2],
    /// Diagonal of the film in millimetres.
    pub(super) diagonal: f64,
    pub(super) transform_times: [f64; 2],
    iso: f64,
    /// Largest component of a sample; 0 for no limit.
    clamp_sample: f64,
    /// Whether the integrator renders media; some of pbrt's ignore them.
    pub(super) shows_media: bool,
    /// Name of the medium around the camera; empty for none.
    pub(super) medium: String,
    /// The white balance of the sensor, for linear Rec. 709.
    balance: Option<DMat3>,
    /// Whether the sensor has an exposure time.
    has_sensor: bool,
    texture_filter: TextureFilter,
    /// Whether the film is that of pbrt-v3, "image".
    pub(super) is_version3: bool,
}

impl Default for Frame {
    fn default() -> Frame {
        Frame {
            camera: None,
            size: [1280, 720],
            crop: None,
            samples: 16,
            filter: None,
            integrator: IntegratorDesc::Path(PathDesc { max_depth: 5, ..PathDesc::default() }),
            shutter: [0.0, 1.0],
            diagonal: 35.0,
            transform_times: [0.0, 1.0],
            iso: 100.0,
            clamp_sample: 0.0,
            shows_media: true,
            medium: String::new(),
            balance: None,
            has_sensor: true,
            texture_filter: TextureFilter::Auto,
            is_version3: false,
        }
    }
}

fn size(v: Option<i32>, or: u32) -> u32 {
    v.map_or(or, |v| v.clamp(1, MAX_SIDE) as u32)
}

impl Frame {
    /// The factor on all light: exposure time times sensitivity (ISO / 100).
    pub(super) fn exposure(&self) -> f64 {
        let time = if self.has_sensor { self.shutter[1] - self.shutter[0] } else { 1.0 };
        (time.max(0.0) * self.iso / 100.0).clamp(0.0, 1e12)
    }

    /// A light's colour after the film's white balance.
    pub(super) fn balanced(&self, light: Spectrum) -> Spectrum {
        let Some(balance) = self.balance else { return light };
        let seen = balance * DVec3::from(light.to_array().map(f64::from));
        Spectrum::from(seen.max(DVec3::ZERO).as_vec3().to_array())
    }

    /// Width over height.
    pub(super) fn aspect(&self) -> f64 {
        f64::from(self.size[0]) / f64::from(self.size[1])
    }

    pub(super) fn film(&mut self, name: &str, mut params: Params, report: &mut Report) {
        if !matches!(name, "rgb" | "gbuffer" | "spectral" | "image") {
            report.ignored(params.place, format!("unknown film \"{}\": read as \"rgb\"", printable(name)));
        }
        self.is_version3 = name == "image";
        if self.is_version3 {
            params.keep_last();
        }
        self.has_sensor = !self.is_version3;
        let [columns, rows] = if self.is_version3 { [640, 480] } else { [1280, 720] };
        self.size = [size(params.integer("xresolution"), columns), size(params.integer("yresolution"), rows)];
        let [w, h] = self.size;
        let bounds = params.integers("pixelbounds");
        if let &[x0, x1, y0, y1] = bounds {
            self.crop = crop([x0, x1, y0, y1].map(f64::from), [w, h]);
        }
        if let &[x0, x1, y0, y1] = params.floats("cropwindow") {
            let (w, h) = (f64::from(w), f64::from(h));
            self.crop = crop([(x0 * w).ceil(), (x1 * w).ceil(), (y0 * h).ceil(), (y1 * h).ceil()], self.size);
        }
        self.diagonal = params.float("diagonal").unwrap_or(35.0);
        self.iso = params.float("iso").unwrap_or(100.0);
        if self.is_version3 {
            self.iso = 100.0 * params.float("scale").unwrap_or(1.0).max(0.0);
            if params.float("maxsampleluminance").is_some_and(f64::is_finite) {
                let message = "the largest luminance of a sample: not limited";
                report.approximated(params.place_of("maxsampleluminance"), message);
            }
        }
        if let Some(sensor) = params.string("sensor").filter(|s| *s != "cie1931") {
            let message = format!("the sensor \"{}\": read as \"cie1931\"", printable(sensor));
            report.approximated(params.place_of("sensor"), message);
        }
        if let Some(kelvin) = params.float("whitebalance").filter(|v| *v > 0.0) {
            self.balance = Some(white_balance(spectral::daylight(kelvin)));
            let message = "the white balance of the film: applied to the colours of lights";
            report.approximated(params.place_of("whitebalance"), message);
        }
        self.clamp_sample =
            params.float("maxcomponentvalue").filter(|v| *v > 0.0 && v.is_finite()).unwrap_or(0.0);
        // The command line names the output; its format decides about half precision and layers.
        params.pass(&[
            "filename",
            "savefp16",
            "coordinatesystem",
            "nbuckets",
            "lambdamin",
            "lambdamax",
            "scale",
        ]);
        params.finish("the film", report);
    }

    pub(super) fn sampler(&mut self, name: &str, params: Params, report: &mut Report) {
        let samples = match name {
            "stratified" => {
                let x = params.integer("xsamples").unwrap_or(4).clamp(1, 65536);
                let y = params.integer("ysamples").unwrap_or(4).clamp(1, 65536);
                x.saturating_mul(y)
            }
            _ => params.integer("pixelsamples").unwrap_or(16),
        };
        self.samples = samples.clamp(1, 1 << 24) as u32;
        params.pass(&["seed", "randomization", "jitter", "dimensions", "pixelsamples"]);
        params.finish("the sampler", report);
    }

    pub(super) fn filter(&mut self, name: &str, params: Params, report: &mut Report) {
        let (kind, radius) = match name {
            "box" => (FilterKind::Box, 0.5),
            "triangle" => (FilterKind::Tent, 2.0),
            "gaussian" => (FilterKind::Gaussian, 1.5),
            "mitchell" | "sinc" | "lanczossinc" => {
                let message =
                    format!("the filter \"{name}\" has negative weights: \"blackman-harris\" replaces it");
                report.approximated(params.place, message);
                (FilterKind::BlackmanHarris, 2.0)
            }
            other => {
                report.ignored(params.place, format!("unknown pixel filter \"{}\"", printable(other)));
                return;
            }
        };
        let radius_of = |name, of_version3| params.float(name).or_else(|| params.float(of_version3));
        let (x, y) = (radius_of("xradius", "xwidth"), radius_of("yradius", "ywidth"));
        if let (Some(x), Some(y)) = (x, y)
            && x != y
        {
            report.approximated(params.place, "different filter radii in x and y: their mean is used");
        }
        let mut radius = (x.unwrap_or(radius) + y.unwrap_or(radius)) / 2.0;
        match kind {
            FilterKind::Gaussian => {
                // Turner's Gaussian ends at three standard deviations.
                let sigma = params.float("sigma").or_else(|| params.float("alpha").map(|a| (0.5 / a).sqrt()));
                radius = (3.0 * sigma.unwrap_or(0.5)).min(2.0 * radius);
            }
            FilterKind::BlackmanHarris => radius = 1.5,
            _ => {}
        }
        params.pass(&["B", "C", "tau", "sigma", "alpha"]);
        params.finish("the pixel filter", report);
        self.filter = Some((kind, if radius.is_finite() { radius.clamp(0.01, 16.0) } else { 0.5 }));
    }

    pub(super) fn integrator(&mut self, name: &str, params: Params, report: &mut Report) {
        let known = [
            "path",
            "volpath",
            "simplepath",
            "simplevolpath",
            "bdpt",
            "mlt",
            "sppm",
            "lightpath",
            "randomwalk",
            "ambientocclusion",
            "function",
            "whitted",
            "directlighting",
        ];
        if !known.contains(&name) {
            report.ignored(
                params.place,
                format!("unknown integrator \"{}\": \"path\" replaces it", printable(name)),
            );
        }
        let without_media =
            ["path", "simplepath", "lightpath", "randomwalk", "sppm", "ambientocclusion", "function"];
        self.shows_media = !without_media.contains(&name);
        if name == "ambientocclusion" {
            let distance = params.float("maxdistance").filter(|v| v.is_finite()).unwrap_or(0.0).max(0.0);
            self.integrator =
                IntegratorDesc::AmbientOcclusion(AmbientOcclusionDesc { distance, samples: 16 });
            params.pass(&["cossample"]);
        } else if matches!(name, "directlighting" | "whitted") {
            let max_depth = params.integer("maxdepth").unwrap_or(5).clamp(0, 100_000) as u32;
            self.integrator = IntegratorDesc::Direct(DirectDesc { max_depth, ..DirectDesc::default() });
        } else {
            let depth = params.integer("maxdepth").unwrap_or(5).clamp(0, 100_000) as u32;
            self.integrator = IntegratorDesc::Path(PathDesc { max_depth: depth, ..PathDesc::default() });
        }
        if params.bool("regularize") == Some(true) {
            report.ignored(params.place_of("regularize"), "regularize: path regularization is not supported");
        }
        params.pass(&[
            "maxdepth",
            "lightsampler",
            "lightsamplestrategy",
            "strategy",
            "nsamples",
            "rrthreshold",
            "samplelights",
            "samplebsdf",
            "visualizestrategies",
            "visualizeweights",
            "photonsperiteration",
            "radius",
            "seed",
            "bootstrapsamples",
            "chains",
            "mutationsperpixel",
            "largestepprobability",
            "sigma",
            "pixelbounds",
            "iterations",
        ]);
        params.finish("the integrator", report);
    }

    pub(super) fn options(&mut self, params: Params, report: &mut Report) {
        if let Some(is_off) = params.bool("disabletexturefiltering") {
            self.texture_filter = if is_off { TextureFilter::Off } else { TextureFilter::Auto };
        }
        params.refuse(
            &["disablepixeljitter", "disablewavelengthjitter", "displacementedgescale", "forcediffuse"],
            "Option",
            report,
        );
        params.pass(&[
            "msereferenceimage",
            "msereferenceout",
            "rendercoordsys",
            "seed",
            "pixelstats",
            "wavefront",
        ]);
        params.finish("Option", report);
    }

    /// Writes these settings into a scene.
    pub(super) fn apply(self, scene: &mut SceneDesc) {
        let film = &mut scene.film;
        [film.width, film.height] = self.size;
        film.crop = self.crop;
        film.antialias = Antialias::MonteCarlo;
        film.samples = self.samples;
        film.clamp_sample = self.clamp_sample;
        if self.clamp_sample > 0.0 {
            // The sensor's values.
            film.clamp_space = ClampSpace::Xyz;
        }
        let default = if self.is_version3 { (FilterKind::Box, 0.5) } else { (FilterKind::Gaussian, 1.5) };
        let (filter, radius) = self.filter.unwrap_or(default);
        (film.filter, film.filter_radius) = (filter, Some(radius));
        film.texture_filter = self.texture_filter;
        film.transfer = turner::color::Transfer::Srgb;
        scene.integrator = self.integrator;
        scene.cameras = self.camera.iter().cloned().collect();
        scene.camera = self.camera;
    }
}

/// The matrix, for linear Rec. 709, that makes the colour `white` white: chromatic adaptation by Bradford's cone responses
/// (Lam 1985), as in pbrt's sensors.
fn white_balance(white: Spectrum) -> DMat3 {
    let rows = |m: [[f64; 3]; 3]| DMat3::from_cols_array_2d(&m).transpose();
    let xyz_of_rgb = rows([
        [0.412_456_4, 0.357_576_1, 0.180_437_5],
        [0.212_672_9, 0.715_152_2, 0.072_175],
        [0.019_333_9, 0.119_192, 0.950_304_1],
    ]);
    let bradford = rows([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]]);
    let cones_of_rgb = bradford * xyz_of_rgb;
    let from = cones_of_rgb * DVec3::from(white.to_array().map(f64::from));
    let to = cones_of_rgb * DVec3::ONE;
    cones_of_rgb.inverse() * DMat3::from_diagonal(to / from.max(DVec3::splat(1e-6))) * cones_of_rgb
}

/// `[first column, first row, columns, rows]` of `x0 x1 y0 y1`; `None` if it is empty or covers the complete picture.
fn crop([x0, x1, y0, y1]: [f64; 4], [w, h]: [u32; 2]) -> Option<[u32; 4]> {
    let cut = |v: f64, most: u32| if v.is_finite() { v.clamp(0.0, f64::from(most)) as u32 } else { 0 };
    let (x0, x1, y0, y1) = (cut(x0, w), cut(x1, w), cut(y0, h), cut(y1, h));
    (x1 > x0 && y1 > y0 && [x0, y0, x1, y1] != [0, 0, w, h]).then(|| [x0, y0, x1 - x0, y1 - y0])
}

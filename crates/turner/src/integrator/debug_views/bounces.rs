//! The number of bounces of paths.

use std::sync::Arc;

use super::display;
use crate::color::{ColorScale, Spectrum};
use crate::film::Picture;
use crate::integrator::{
    AskedDetails, CameraSamples, Capabilities, Caustics, Integrator, PathDesc, PreparedIntegrator, Radiance,
    RayStats, SharedPathsMode, Tracer,
};
use crate::scene::Scene;
use crate::schema::{Range, SceneError, params};
use crate::view::View;

params! {
    /// Shows the mean number of bounces of the paths of each pixel as a heat map: how deep paths go before they end by
    /// absorption, by Russian roulette, at `max_depth` or outside the scene. The paths are those of "path" without
    /// photons and without shared paths. EXR files hold the mean in all three channels. PNG files range from black
    /// (none) to pale yellow (the maximum in the picture).
    pub struct BouncesDesc as "bounces" {
        /// Maximum number of bounces of a path.
        max_depth: u32 = 16, in Range::closed(0.0, 100000.0);
        /// Number of bounces after which Russian roulette starts.
        rr_start: u32 = 3;
    }
    example r#"[integrator]
type = "bounces"
max_depth = 32
"#
}

impl Integrator for BouncesDesc {
    fn name(&self) -> &str {
        BouncesDesc::DOC.name
    }

    fn capabilities(&self) -> Capabilities {
        Capabilities { debug: true, splits_light: false, ..PathDesc::default().capabilities() }
    }

    fn prepare(&self, scene: &Scene, view: &View) -> Result<Arc<dyn PreparedIntegrator>, SceneError> {
        let paths = PathDesc {
            max_depth: self.max_depth,
            rr_start: Some(self.rr_start),
            caustics: Caustics::Off,
            shared_paths: SharedPathsMode::Off,
            ..PathDesc::default()
        };
        let paths = paths.prepare(scene, view)?;
        // With both switched off there is nothing to choose.
        paths.choose(scene, view, 1);
        Ok(Arc::new(Bounces { paths, capabilities: self.capabilities() }))
    }
}

struct Bounces {
    paths: Arc<dyn PreparedIntegrator>,
    capabilities: Capabilities,
}

impl PreparedIntegrator for Bounces {
    fn name(&self) -> &str {
        BouncesDesc::DOC.name
    }

    fn capabilities(&self) -> Capabilities {
        self.capabilities
    }

    fn show(&self, picture: &mut Picture) {
        display::heat_from_0(picture);
    }

    fn scale(&self, picture: &Picture) -> Option<ColorScale> {
        Some(display::scale_from_0(picture, "bounces"))
    }

    fn tracer<'a>(&'a self, scene: &'a Scene, view: &'a View) -> Box<dyn Tracer + 'a> {
        let mut paths = self.paths.tracer(scene, view);
        paths.ask(AskedDetails { bounces: true, ..AskedDetails::default() });
        Box::new(BouncesTracer { paths })
    }
}

struct BouncesTracer<'a> {
    paths: Box<dyn Tracer + 'a>,
}

impl Tracer for BouncesTracer<'_> {
    fn radiance(&mut self, samples: &CameraSamples, out: &mut Vec<Radiance>, stats: &mut RayStats) {
        self.paths.radiance(samples, out, stats);
        for (shown, bounces) in out.iter_mut().zip(self.paths.details().bounces) {
            *shown = Radiance { color: Spectrum::grey(*bounces as f32), alpha: 1.0 };
        }
    }
}

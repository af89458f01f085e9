//! The classic integrator, prepared. It precomputes nothing.

use std::sync::Arc;

use super::ClassicDesc;
use super::radiance::TreeBatch;
use super::record::Off;
use crate::integrator::{Capabilities, Integrator, PreparedIntegrator, Tracer};
use crate::scene::Scene;
use crate::schema::SceneError;
use crate::view::View;

impl Integrator for ClassicDesc {
    fn name(&self) -> &str {
        ClassicDesc::DOC.name
    }

    fn capabilities(&self) -> Capabilities {
        Capabilities::default()
    }

    fn prepare(&self, _: &Scene, _: &View) -> Result<Arc<dyn PreparedIntegrator>, SceneError> {
        Ok(Arc::new(ClassicIntegrator(self.clone())))
    }
}

/// The prepared classic integrator.
#[derive(Clone, Debug)]
pub(super) struct ClassicIntegrator(pub(super) ClassicDesc);

impl PreparedIntegrator for ClassicIntegrator {
    fn name(&self) -> &str {
        ClassicDesc::DOC.name
    }

    fn capabilities(&self) -> Capabilities {
        self.0.capabilities()
    }

    fn tracer<'a>(&'a self, scene: &'a Scene, view: &'a View) -> Box<dyn Tracer + 'a> {
        Box::new(TreeBatch::new(&self.0, scene, view, Off))
    }
}

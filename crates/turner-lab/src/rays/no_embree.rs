//! Replaces Embree in a program built without the feature `embree`.

use std::ops::Range;
use std::path::Path;

use turner_bvh::Ray;
use turner_bvh::generate::Scene;

use super::Rival;
use super::measure::{CHUNK, Query, RaySet, Tracer};
use super::tracer::Hit;

pub(super) type Packets = ();

pub(super) fn packets(_: &[Ray]) -> Packets {}

/// Has no values.
pub(super) enum Embree {}
pub(super) enum EmbreeScene {}
pub(super) enum Built {}

impl Embree {
    pub(super) fn load(_: &Path) -> Result<Embree, String> {
        Err("this program was built without its feature `embree`".into())
    }

    pub(super) fn version(&self) -> String {
        match *self {}
    }

    pub(super) fn scene_for(&self, _: &Scene, _: usize) -> Result<EmbreeScene, String> {
        match *self {}
    }
}

impl EmbreeScene {
    pub(super) fn build(&self, _: Rival) -> Result<Built, String> {
        match *self {}
    }
}

impl Built {
    pub(super) fn bytes(&self) -> usize {
        match *self {}
    }
}

impl Tracer for Built {
    fn nearest(&self, _: Query, _: &RaySet, _: Range<usize>, _: &mut [Hit; CHUNK]) {
        match *self {}
    }

    fn any(&self, _: Query, _: &RaySet, _: Range<usize>, _: &mut [bool; CHUNK]) {
        match *self {}
    }
}

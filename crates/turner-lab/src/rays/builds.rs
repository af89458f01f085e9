//! Builds BVHs and measures time and size.

use std::time::Instant;

use turner_bvh::generate::Scene;
use turner_cli::bench::median;

use super::embree::{Built, Embree};
use super::measure::Tracer;
use super::table::Column;
use super::tracer::{Quality, Turner};
use super::{RaysArgs, Rival};

/// Builds are repeated until this many seconds have passed.
const ENOUGH_SECONDS: f64 = 2.0;

/// The BVHs that are traced.
pub(super) struct Trees {
    pub(super) turner: Vec<(Quality, Turner)>,
    pub(super) embree: Vec<(Rival, Built)>,
}

/// The result of one builder.
pub(super) struct BuildRow {
    pub(super) column: Column,
    /// Each build, in order.
    pub(super) seconds: Vec<f64>,
    /// The median of `seconds`.
    pub(super) median: f64,
    pub(super) bytes: usize,
    /// Triangles of the meshes, counted once, plus instances.
    pub(super) items: usize,
}

/// A builder and its latest result.
struct Builder<'a, T> {
    column: Column,
    build: Box<dyn Fn() -> Result<T, String> + 'a>,
    seconds: Vec<f64>,
    last: Option<T>,
}

impl<'a, T> Builder<'a, T> {
    fn new(column: Column, build: impl Fn() -> Result<T, String> + 'a) -> Builder<'a, T> {
        Builder { column, build: Box::new(build), seconds: Vec::new(), last: None }
    }

    fn turn(&mut self) -> Result<(), String> {
        if self.last.is_some() && self.seconds.iter().sum::<f64>() > ENOUGH_SECONDS {
            return Ok(());
        }
        // Free the memory of the previous build first.
        self.last = None;
        let start = Instant::now();
        self.last = Some((self.build)()?);
        self.seconds.push(start.elapsed().as_secs_f64());
        Ok(())
    }

    fn row(&self, items: usize, bytes: impl Fn(&T) -> usize) -> BuildRow {
        BuildRow {
            column: self.column,
            median: median(&self.seconds).unwrap_or(f64::NAN),
            seconds: self.seconds.clone(),
            bytes: self.last.as_ref().map_or(0, bytes),
            items,
        }
    }
}

impl Trees {
    /// Runs all builders in turn.
    pub(super) fn build(
        args: &RaysArgs,
        embree: Option<&Embree>,
        scene: &Scene,
        threads: usize,
    ) -> Result<(Trees, Vec<BuildRow>), String> {
        let items = scene.meshes.iter().map(|m| m.triangles.len()).sum::<usize>() + scene.instances.len();
        let embree_scene = embree.map(|e| e.scene_for(scene, threads)).transpose()?;
        let mut turner: Vec<(Quality, Builder<'_, Turner>)> = Vec::new();
        for &quality in &args.quality {
            let build = move || Turner::build(scene, quality, threads);
            turner.push((quality, Builder::new(Column::Turner(quality), build)));
        }
        let mut rivals: Vec<(Rival, Builder<'_, Built>)> = Vec::new();
        if let Some(embree_scene) = &embree_scene {
            // Low quality is always built for its build time, even if it is not traced.
            let low = (!args.embree_quality.contains(&Rival::Low)).then_some(Rival::Low);
            for rival in low.into_iter().chain(args.embree_quality.iter().copied()) {
                rivals.push((rival, Builder::new(Column::Embree(rival), move || embree_scene.build(rival))));
            }
        }
        for _ in 0..args.repeat {
            for (_, builder) in &mut turner {
                builder.turn()?;
            }
            for (_, builder) in &mut rivals {
                builder.turn()?;
            }
        }
        let mut rows: Vec<BuildRow> =
            turner.iter().map(|(_, builder)| builder.row(items, Turner::bytes)).collect();
        rows.extend(rivals.iter().map(|(_, builder)| builder.row(items, Built::bytes)));
        let traced = rivals.into_iter().filter(|(rival, _)| args.embree_quality.contains(rival));
        let trees = Trees {
            turner: turner.into_iter().filter_map(|(q, builder)| Some((q, builder.last?))).collect(),
            embree: traced.filter_map(|(r, builder)| Some((r, builder.last?))).collect(),
        };
        if trees.turner.is_empty() {
            return Err("--quality is empty".into());
        }
        Ok((trees, rows))
    }

    /// Turner's BVH of the last quality named.
    pub(super) fn best(&self) -> &dyn Tracer {
        &self.turner[self.turner.len() - 1].1
    }

    /// Embree's BVH that hits are compared with: the watertight one if it was built.
    pub(super) fn reference(&self) -> Option<&dyn Tracer> {
        let robust = self.embree.iter().find(|(rival, _)| *rival == Rival::Robust);
        robust.or(self.embree.last()).map(|(_, tree)| tree as &dyn Tracer)
    }
}

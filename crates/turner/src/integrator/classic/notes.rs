//! How the rendering code fills a [`TreeRecord`].

use turner_bvh::lanes::Block;

use super::points::{PointBlock, get};
use super::record::{
    CutReason, CutRecord, HitRecord, LightTerm, MAX_WRITTEN, MissRecord, RayEnd, RayKind, RayRecord, Seen,
    ShadowRecord, TreeRecord,
};
use crate::color::Spectrum;
use crate::material::Classic;
use crate::math::elementary::Exponent;
use crate::math::{DVec3, Ray};
use crate::scene::{Hit, RayBatch, Scene, SpectrumBlock};

/// A record under construction, and the rays that are still to be traced.
pub(super) struct Notes {
    pub(super) tree: TreeRecord,
    /// Kind and parent of the spawned rays, a stack: the last ray is traced first.
    waiting: Vec<(RayKind, u32)>,
    /// The index of the current ray in the record, if it is recorded; below, its number in any case.
    current: Option<usize>,
    number: u32,
    /// Whether the current ray is beyond [`MAX_WRITTEN`] and not recorded.
    beyond: bool,
}

/// Values for the record that rendering itself does not need: what [`Illuminate`](super::shade::Illuminate) and
/// [`Accumulate`](super::shade::Accumulate) compute at eight hits.
#[derive(Clone, Copy, Default)]
pub(super) struct TermNotes {
    pub(super) reaches: u8,
    pub(super) to_light: [Block; 3],
    pub(super) intensity: SpectrumBlock,
    pub(super) n_dot_l: Block,
    pub(super) r_dot_v: Block,
    pub(super) diffuse: SpectrumBlock,
    pub(super) highlight: SpectrumBlock,
    pub(super) added: SpectrumBlock,
}

impl Notes {
    pub(super) fn new(tree: TreeRecord) -> Notes {
        Notes { tree, waiting: vec![(RayKind::Camera, 0)], current: None, number: 0, beyond: false }
    }

    /// The next ray is traced.
    pub(super) fn traced(&mut self, ray: &Ray, depth: u32, weight: f64) {
        let (kind, parent) = self.waiting.pop().unwrap_or((RayKind::Camera, 0));
        self.number = self.tree.rays.len() as u32;
        self.beyond = self.tree.rays.len() >= MAX_WRITTEN;
        if self.beyond {
            self.tree.unwritten += 1;
            self.current = None;
            return;
        }
        self.current = Some(self.tree.rays.len());
        self.tree.rays.push(RayRecord {
            kind,
            parent: (kind != RayKind::Camera).then_some(parent),
            depth,
            origin: ray.origin,
            direction: ray.direction,
            weight,
            end: RayEnd::Miss(MissRecord { seen: Seen::Nothing, contribution: Spectrum::BLACK }),
        });
    }

    fn ray(&mut self) -> Option<&mut RayRecord> {
        self.tree.rays.get_mut(self.current?)
    }

    fn hit(&mut self) -> Option<&mut HitRecord> {
        match &mut self.ray()?.end {
            RayEnd::Hit(hit) => Some(hit),
            RayEnd::Miss(_) => None,
        }
    }

    /// Adds the contribution of a ray that is not recorded.
    fn rest(&mut self, contribution: Spectrum) {
        if self.beyond {
            self.tree.total = Some(self.tree.sum() + contribution);
        }
    }

    /// The current ray hit nothing.
    pub(super) fn missed(&mut self, seen: Seen, contribution: Option<Spectrum>) {
        match self.ray() {
            Some(ray) => {
                // No contribution is recorded as black: adding black does not change the sum.
                let contribution = contribution.unwrap_or(Spectrum::BLACK);
                ray.end = RayEnd::Miss(MissRecord { seen, contribution });
            }
            None => contribution.into_iter().for_each(|c| self.rest(c)),
        }
    }

    /// The current ray hit a surface.
    pub(super) fn hit_surface(&mut self, scene: &Scene, ray: &Ray, hit: &Hit) {
        let Some(to) = self.ray() else { return };
        let surface = scene.surface(ray, hit);
        to.end = RayEnd::Hit(Box::new(HitRecord {
            t: hit.shape.t,
            p: surface.p,
            ng: surface.ng,
            ns: surface.ns,
            n: surface.ns,
            primitive: scene.primitive_id(hit),
            shape: scene.shape_word(hit),
            part: hit.shape.part,
            uv: scene.texture_point(&surface).uv.into(),
            material: surface.material,
            entering: true,
            color: Spectrum::BLACK,
            coefficients: [0.0; 3],
            shininess: 0.0,
            ior: 1.0,
            ambient: Spectrum::BLACK,
            lights: Vec::new(),
            local: Spectrum::BLACK,
            weights: [0.0; 3],
            total_internal_reflection: false,
            emitted: None,
            contribution: None,
            cut: Vec::new(),
        }));
    }

    /// The surface at the hit is emissive.
    pub(super) fn emitted(&mut self, contribution: Spectrum) {
        match self.hit() {
            Some(hit) => hit.emitted = Some(contribution),
            None => self.rest(contribution),
        }
    }

    /// The surface as it is shaded. It is in lane 0, since the batch has one sample.
    pub(super) fn shaded(&mut self, b: &PointBlock, m: &Classic, weights: [f64; 3], total: bool) {
        let Some(hit) = self.hit() else { return };
        hit.p = get(&b.p, 0);
        hit.ng = get(&b.ng, 0);
        hit.ns = get(&b.ns, 0);
        hit.n = get(&b.lit, 0);
        hit.entering = b.entering & 1 == 1;
        hit.color = b.color.get(0);
        hit.coefficients = [f64::from(b.ka.0[0]), b.kd.0[0], b.ks.0[0]];
        hit.shininess = match m.exponent {
            Exponent::Whole(n) => f64::from(n),
            Exponent::Real(y) => y,
        };
        hit.ior = m.ior;
        hit.weights = weights;
        hit.total_internal_reflection = total;
    }

    /// The ambient term.
    pub(super) fn ambient(&mut self, b: &PointBlock) {
        if let Some(hit) = self.hit() {
            (hit.ambient, hit.local) = (b.local.get(0), b.local.get(0));
        }
    }

    /// The terms of one light, before the shadow ray.
    pub(super) fn lit(&mut self, light: usize, sample: u32, finite: bool, terms: &TermNotes) {
        let Some(hit) = self.hit() else { return };
        let reaches = terms.reaches & 1 == 1;
        let if_reached = |c: &SpectrumBlock| if reaches { c.get(0) } else { Spectrum::BLACK };
        hit.lights.push(LightTerm {
            light: light as u32,
            sample,
            to_light: get(&terms.to_light, 0),
            finite,
            reaches,
            intensity: if_reached(&terms.intensity),
            n_dot_l: terms.n_dot_l.0[0],
            r_dot_v: terms.r_dot_v.0[0],
            diffuse: if_reached(&terms.diffuse),
            highlight: if_reached(&terms.highlight),
            shadow: None,
            added: Spectrum::BLACK,
        });
    }

    /// The light that arrives after the shadow ray.
    pub(super) fn arrived(
        &mut self,
        scene: &Scene,
        b: &PointBlock,
        terms: &TermNotes,
        rays: &RayBatch,
        through: Option<&[SpectrumBlock]>,
    ) {
        let Some(hit) = self.hit() else { return };
        hit.local = b.local.get(0);
        let Some(term) = hit.lights.last_mut() else { return };
        term.added = terms.added.get(0);
        if let (Some(through), Some(ray)) = (through.and_then(|t| t.first()), rays.get(0)) {
            let through = through.get(0);
            let casters = if through == Spectrum::WHITE { Vec::new() } else { scene.shadow_casters(&ray) };
            term.shadow = Some(ShadowRecord {
                origin: ray.origin,
                direction: ray.direction,
                t_min: ray.t_min,
                t_max: ray.t_max,
                through,
                casters,
            });
        }
    }

    /// The local colour was added to the pixel.
    pub(super) fn added(&mut self, contribution: Spectrum) {
        match self.hit() {
            Some(hit) => hit.contribution = Some(contribution),
            None => self.rest(contribution),
        }
    }

    /// A ray was spawned. Of two spawned at one surface, the later one is traced first.
    pub(super) fn spawned(&mut self, kind: RayKind) {
        self.waiting.push((kind, self.number));
    }

    /// A ray is not traced.
    pub(super) fn cut(
        &mut self,
        kind: RayKind,
        direction: DVec3,
        weight: f64,
        reason: CutReason,
        seen: Seen,
        contribution: Option<Spectrum>,
    ) {
        self.tree.dropped += u64::from(reason == CutReason::Count);
        match self.hit() {
            Some(hit) => {
                let contribution = contribution.unwrap_or(Spectrum::BLACK);
                hit.cut.push(CutRecord { kind, direction, weight, reason, seen, contribution });
            }
            None => contribution.into_iter().for_each(|c| self.rest(c)),
        }
    }
}

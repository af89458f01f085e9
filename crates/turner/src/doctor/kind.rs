//! Classifies the contributions of a path by the kind of path and by the light or emissive object.
//!
//! Heckbert ("Adaptive Radiosity Textures for Bidirectional Ray Tracing", SIGGRAPH 1990) writes a path as a string from
//! the light L to the camera E, with one letter per vertex: D for diffuse scattering and S for specular scattering.
//! S+ means one or more, D? none or one:
//!
//! ```text
//! L ── D wall ── S glass ── E    LDSE: specular, a lit wall seen through glass
//! L ── S glass ── D floor ── E   LSDE: caustic, light that glass focuses on the floor
//! ```
//!
//! A path tracer starts at E and reads the string backwards. [`PathState`] follows the recorded vertices from the
//! camera and remembers which lobes were sampled. A path has several contributions: hits on emitters, light samples,
//! the environment. Each completes the string with an L at a different vertex, and the state there gives its kind.
//! Delta lobes count as S. Glossy lobes are a third letter, G; after a diffuse lobe, narrow ones count as S.

use super::materials;
use crate::bsdf::Lobe;
use crate::color::Spectrum;
use crate::integrator::path::{LightRecord, Passage, PathRecord, ScatterRecord, VertexRecord};
use crate::light::Light;
use crate::math::{Bounds, DVec3, Ray};
use crate::scene::Scene;
use crate::schema::MaterialId;

/// A kind of path, in Heckbert's notation from the light to the camera: D diffuse, G glossy, S specular.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PathKind {
    /// A directly visible emitter, also through thin panes: LE.
    Emitted,
    /// The directly visible background or environment: LE.
    Background,
    /// Direct light on a visible surface: LDE, LGE.
    Direct,
    /// An emitter or a lit surface, seen in a mirror or through glass: LD?S+E.
    Specular,
    /// Light after several diffuse reflections: LDD+E.
    Indirect,
    /// Indirect light with a glossy reflection at the visible surface: LDGE.
    Glossy,
    /// Light that mirrors, glass or glossy surfaces focus on a diffuse surface: LS+DE.
    Caustic,
}

impl PathKind {
    /// All kinds, in the order of the legend.
    pub const ALL: [PathKind; 7] = [
        PathKind::Emitted,
        PathKind::Background,
        PathKind::Direct,
        PathKind::Specular,
        PathKind::Indirect,
        PathKind::Glossy,
        PathKind::Caustic,
    ];

    /// Its word in reports.
    pub fn word(self) -> &'static str {
        match self {
            PathKind::Emitted => "emitted",
            PathKind::Background => "background",
            PathKind::Direct => "direct",
            PathKind::Specular => "specular",
            PathKind::Indirect => "indirect",
            PathKind::Glossy => "glossy",
            PathKind::Caustic => "caustic",
        }
    }

    /// Its name in sentences.
    pub fn words(self) -> &'static str {
        match self {
            PathKind::Emitted => "emitters, seen directly",
            PathKind::Background => "the background, seen directly",
            PathKind::Direct => "direct light",
            PathKind::Specular => "light seen in mirrors and through glass",
            PathKind::Indirect => "indirect diffuse light",
            PathKind::Glossy => "glossy reflections",
            PathKind::Caustic => "caustics",
        }
    }

    /// Its colour in maps, sRGB.
    pub fn color(self) -> [u8; 3] {
        // Okabe & Ito 2008: distinguishable with any type of colour vision.
        match self {
            PathKind::Emitted => [240, 228, 66],
            PathKind::Background => [110, 110, 110],
            PathKind::Direct => [86, 180, 233],
            PathKind::Specular => [0, 114, 178],
            PathKind::Indirect => [0, 158, 115],
            PathKind::Glossy => [204, 121, 167],
            PathKind::Caustic => [213, 94, 0],
        }
    }
}

/// The source of a contribution.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Source {
    /// A light, by its index in the prepared scene.
    Light(u32),
    /// An emissive shape, by its primitive index.
    Object(u32),
    /// The background colour.
    Background,
    /// Ambient light.
    Ambient,
    /// Unknown: the scene has too many lights to identify one by its position.
    Unknown,
}

/// One contribution of a path.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contribution {
    pub(super) kind: PathKind,
    pub(super) source: Source,
    /// The material that determines the kind: the glass of a caustic, the surface of direct light.
    pub(super) material: Option<MaterialId>,
    /// Whether a BSDF-sampled ray hit the light; false for light samples.
    pub(super) is_bsdf_sampled: bool,
    /// Its luminance.
    pub(super) value: f64,
}

/// The bounds of all lights, which identify a light by a point on it.
pub(super) struct LightBounds(Vec<Option<Bounds>>);

/// Lights are not identified in scenes with more lights than this.
const MAX: usize = 4096;

impl LightBounds {
    pub(super) fn new(scene: &Scene) -> LightBounds {
        if scene.lights.len() > MAX {
            return LightBounds(Vec::new());
        }
        let one = |i| scene.emitter_bounds(crate::scene::ListedEmitter::Light(i));
        LightBounds((0..scene.lights.len() as u32).map(one).collect())
    }

    /// The source of a light sample.
    pub(super) fn source_of(&self, scene: &Scene, v: &VertexRecord, l: &LightRecord) -> Source {
        if !l.distance.is_finite() {
            return infinite_light(scene, l.direction, l.is_delta);
        }
        if !l.is_delta {
            return shape_at(scene, v.p, l.direction, l.distance);
        }
        let q = v.p + l.direction * l.distance;
        let slack = 1e-6 * (q.abs().max_element() + l.distance);
        let holds = |b: &Bounds| (q.cmpge(b.min - slack) & q.cmple(b.max + slack)).all();
        let found = self.0.iter().position(|b| b.as_ref().is_some_and(holds));
        found.map_or(Source::Unknown, |i| Source::Light(i as u32))
    }
}

/// The infinite light in a direction.
fn infinite_light(scene: &Scene, direction: DVec3, is_delta: bool) -> Source {
    let mut environment = Source::Background;
    for (i, light) in (0..).zip(&scene.lights[..]) {
        match light {
            Light::Directional(l) if l.is_disc() && !is_delta && l.found(direction).is_some() => {
                return Source::Light(i);
            }
            Light::Directional(l) if is_delta && l.to_light.dot(direction) > 1.0 - 1e-9 => {
                return Source::Light(i);
            }
            Light::Environment(_) => environment = Source::Light(i),
            Light::Directional(_) | Light::Point(_) | Light::Spot(_) | Light::Area(_) => {}
        }
    }
    environment
}

/// The emissive shape at a point.
fn shape_at(scene: &Scene, p: DVec3, direction: DVec3, distance: f64) -> Source {
    let ray =
        Ray { t_min: distance * (1.0 - 1e-3), t_max: distance * (1.0 + 1e-2), ..Ray::new(p, direction) };
    scene.intersect(&ray).map_or(Source::Unknown, |hit| Source::Object(scene.primitive_id(&hit)))
}

/// The lobes that a path from the camera sampled so far.
#[derive(Clone, Copy, Default)]
struct PathState {
    /// It sampled a delta lobe (a mirror, clear glass) before any diffuse lobe.
    specular: bool,
    /// It sampled a diffuse lobe.
    diffuse: bool,
    /// It sampled a glossy lobe before any diffuse one.
    glossy: bool,
    /// The first mirror, glass or glossy surface since the last diffuse lobe.
    focusing: Option<MaterialId>,
    /// The number of non-delta lobes that it sampled, without focusing ones.
    rough: u32,
    /// The material of the first non-delta lobe.
    first: Option<MaterialId>,
}

impl PathState {
    fn scatter(&mut self, s: &ScatterRecord, material: MaterialId) {
        /// The pdf (1/sr) above which a lobe counts as focusing light; about that of a roughness of 0.3.
        const SHARP: f64 = 10.0;
        let Lobe { is_delta, is_diffuse, .. } = s.lobe;
        if self.diffuse && !is_diffuse && (is_delta || s.pdf > SHARP) {
            self.focusing.get_or_insert(material);
            return;
        }
        if is_delta {
            self.specular = true;
            return;
        }
        self.focusing = None;
        self.rough += 1;
        self.first.get_or_insert(material);
        self.diffuse |= is_diffuse;
        self.glossy |= !is_diffuse;
    }

    /// The kind of path if its last ray hits the `background` or an emitter.
    fn hit_kind(&self, background: bool) -> PathKind {
        match self {
            PathState { focusing: Some(_), .. } => PathKind::Caustic,
            PathState { specular: true, rough: 1, .. } => PathKind::Specular,
            PathState { rough: 1, .. } => PathKind::Direct,
            PathState { diffuse: true, .. } => PathKind::Indirect,
            PathState { glossy: true, .. } => PathKind::Glossy,
            PathState { specular: true, .. } => PathKind::Specular,
            _ if background => PathKind::Background,
            _ => PathKind::Emitted,
        }
    }

    /// The kind of path of a light sample at the current surface.
    fn light_sample_kind(&self) -> PathKind {
        match self {
            PathState { focusing: Some(_), .. } => PathKind::Caustic,
            PathState { diffuse: true, .. } => PathKind::Indirect,
            PathState { glossy: true, .. } => PathKind::Glossy,
            PathState { specular: true, .. } => PathKind::Specular,
            _ => PathKind::Direct,
        }
    }
}

/// Calls `each` with every contribution of a path.
pub(super) fn contributions(
    scene: &Scene,
    light_bounds: &LightBounds,
    path: &PathRecord,
    mut each: impl FnMut(Contribution),
) {
    let value = |s: Spectrum| f64::from(s.luminance());
    let mut state = PathState::default();
    for (i, v) in path.vertices.iter().enumerate() {
        let own = v.chosen.unwrap_or(v.material);
        if let Some(e) = v.emission.filter(|e| !e.contribution.is_black()) {
            each(Contribution {
                kind: state.hit_kind(false),
                source: Source::Object(v.primitive),
                material: state.focusing.or(state.first),
                is_bsdf_sampled: state.rough > 0,
                value: value(e.contribution),
            });
        }
        for l in v.lights.iter().filter(|l| l.visible.is_some() && !l.contribution.is_black()) {
            each(Contribution {
                kind: state.light_sample_kind(),
                source: light_bounds.source_of(scene, v, l),
                material: state.focusing.or(state.first).or(Some(own)),
                is_bsdf_sampled: false,
                value: value(l.contribution),
            });
        }
        // Subsurface scattering counts once, where the path exits.
        let enters = path.vertices.get(i + 1).is_some_and(|next| next.walk.is_some());
        if let (Some(s), Passage::Surface | Passage::Exit, false) = (&v.scatter, v.passage, enters) {
            state.scatter(s, own);
        }
    }
    if let Some(e) = path.escape.as_ref().filter(|e| !e.contribution.is_black()) {
        let source = if !e.lights.is_empty() {
            infinite_light(scene, e.direction, false)
        } else if !e.background.is_black() {
            Source::Background
        } else if !e.ambient.is_black() {
            Source::Ambient
        } else {
            Source::Background
        };
        each(Contribution {
            kind: state.hit_kind(true),
            source,
            material: state.focusing.or(state.first),
            is_bsdf_sampled: state.rough > 0,
            value: value(e.contribution),
        });
    }
}

/// Whether a material focuses light to caustics.
pub(super) fn casts_caustics(scene: &Scene, id: MaterialId) -> bool {
    materials::transmits(scene, id)
}

//! The kinds of paths, and which light or emissive object their light comes from.

use super::materials;
use crate::bsdf::Lobe;
use crate::color::Spectrum;
use crate::integrator::path::{LightRecord, Passage, PathRecord, ScatterRecord, VertexRecord};
use crate::light::Light;
use crate::math::{Bounds, DVec3, Ray};
use crate::scene::Scene;
use crate::schema::MaterialId;

/// A kind of path between camera and light. In Heckbert's notation, from the light to the camera: L, diffuse D, other lobes S, E.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PathKind {
    /// An emitter is seen, directly or through thin panes: LE.
    Emitted,
    /// The background or environment is seen: LE.
    Background,
    /// Light on a visible surface: LDE, L(glossy)E.
    Direct,
    /// An emitter or a lit surface is seen in a mirror or through glass: L(D)S+E.
    Specular,
    /// Light that other diffuse surfaces reflect: LDD+E.
    Indirect,
    /// Light that another surface reflects glossily, or that the visible surface reflects glossily.
    Glossy,
    /// Light that mirrors, glass or glossy surfaces focus on a diffuse surface: LS+DE, wherever that is seen.
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

    /// The word in reports.
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

    /// What it is, for a sentence.
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

    /// The colour in the legend, display values.
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

/// Where light comes from.
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
    /// One of too many lights to tell apart.
    Unknown,
}

/// Light along a path.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub(super) kind: PathKind,
    pub(super) source: Source,
    /// The material that makes it this kind: the glass of a caustic, the surface of direct light.
    pub(super) material: Option<MaterialId>,
    /// Whether a BSDF-sampled ray hit the light, rather than light sampling.
    pub(super) by_chance: bool,
    /// Luminance.
    pub(super) value: f64,
}

/// The bounds of lights, to tell them apart.
pub(super) struct LightPlaces(Vec<Option<Bounds>>);

/// More lights than this are not told apart by position.
const MOST: usize = 4096;

impl LightPlaces {
    pub(super) fn new(scene: &Scene) -> LightPlaces {
        if scene.lights.len() > MOST {
            return LightPlaces(Vec::new());
        }
        let one = |i| scene.emitter_bounds(crate::scene::ListedEmitter::Light(i));
        LightPlaces((0..scene.lights.len() as u32).map(one).collect())
    }

    /// Which light was sampled.
    pub(super) fn source_of(&self, scene: &Scene, v: &VertexRecord, l: &LightRecord) -> Source {
        if !l.distance.is_finite() {
            return around(scene, l.direction, l.is_delta);
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
fn around(scene: &Scene, direction: DVec3, is_delta: bool) -> Source {
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

/// What a path from the camera did so far.
#[derive(Clone, Copy, Default)]
struct Way {
    /// Its first surface was a mirror or clear glass.
    specular: bool,
    /// It sampled a diffuse lobe.
    diffuse: bool,
    /// It sampled a glossy lobe before any diffuse one.
    glossy: bool,
    /// The first mirror, glass or glossy surface since the last diffuse lobe.
    focused: Option<MaterialId>,
    /// How many lobes it sampled that are not delta lobes.
    rough: u32,
    /// The surface of the first diffuse lobe.
    first: Option<MaterialId>,
}

impl Way {
    fn take(&mut self, s: &ScatterRecord, material: MaterialId) {
        /// Density (1/sr) from which a lobe counts as focusing light: about that of a roughness of 0.3.
        const SHARP: f64 = 10.0;
        let Lobe { is_delta, is_diffuse, .. } = s.lobe;
        if self.diffuse && !is_diffuse && (is_delta || s.pdf > SHARP) {
            self.focused.get_or_insert(material);
            return;
        }
        if is_delta {
            self.specular = true;
            return;
        }
        self.focused = None;
        self.rough += 1;
        self.first.get_or_insert(material);
        self.diffuse |= is_diffuse;
        self.glossy |= !is_diffuse;
    }

    /// The kind of light that the path's last ray hits: the `background`, or an emitter.
    fn found(&self, background: bool) -> PathKind {
        match self {
            Way { focused: Some(_), .. } => PathKind::Caustic,
            Way { specular: true, rough: 1, .. } => PathKind::Specular,
            Way { rough: 1, .. } => PathKind::Direct,
            Way { diffuse: true, .. } => PathKind::Indirect,
            Way { glossy: true, .. } => PathKind::Glossy,
            Way { specular: true, .. } => PathKind::Specular,
            _ if background => PathKind::Background,
            _ => PathKind::Emitted,
        }
    }

    /// The kind of light that is sampled at a surface.
    fn sampled(&self) -> PathKind {
        match self {
            Way { focused: Some(_), .. } => PathKind::Caustic,
            Way { diffuse: true, .. } => PathKind::Indirect,
            Way { glossy: true, .. } => PathKind::Glossy,
            Way { specular: true, .. } => PathKind::Specular,
            _ => PathKind::Direct,
        }
    }
}

/// All contributions of a path, one at a time.
pub(super) fn parts(scene: &Scene, places: &LightPlaces, path: &PathRecord, mut each: impl FnMut(Part)) {
    let value = |s: Spectrum| f64::from(s.luminance());
    let mut way = Way::default();
    for (i, v) in path.vertices.iter().enumerate() {
        let own = v.chosen.unwrap_or(v.material);
        if let Some(e) = v.emission.filter(|e| !e.contribution.is_black()) {
            each(Part {
                kind: way.found(false),
                source: Source::Object(v.primitive),
                material: way.focused.or(way.first),
                by_chance: way.rough > 0,
                value: value(e.contribution),
            });
        }
        if let Some(l) = v.light.as_ref().filter(|l| l.visible.is_some() && !l.contribution.is_black()) {
            each(Part {
                kind: way.sampled(),
                source: places.source_of(scene, v, l),
                material: way.focused.or(way.first).or(Some(own)),
                by_chance: false,
                value: value(l.contribution),
            });
        }
        // Subsurface scattering counts once: where the path leaves the body.
        let enters = path.vertices.get(i + 1).is_some_and(|next| next.walk.is_some());
        if let (Some(s), Passage::Surface | Passage::Exit, false) = (&v.scatter, v.passage, enters) {
            way.take(s, own);
        }
    }
    if let Some(e) = path.escape.as_ref().filter(|e| !e.contribution.is_black()) {
        let source = if !e.lights.is_empty() {
            around(scene, e.direction, false)
        } else if !e.background.is_black() {
            Source::Background
        } else if !e.ambient.is_black() {
            Source::Ambient
        } else {
            Source::Background
        };
        each(Part {
            kind: way.found(true),
            source,
            material: way.focused.or(way.first),
            by_chance: way.rough > 0,
            value: value(e.contribution),
        });
    }
}

/// Whether a material focuses light into caustics.
pub(super) fn casts_caustics(scene: &Scene, id: MaterialId) -> bool {
    materials::lets_through(scene, id)
}

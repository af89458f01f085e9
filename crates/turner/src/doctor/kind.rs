//! What sorts of paths there are, and whose light they bring.

use super::materials;
use crate::bsdf::Lobe;
use crate::color::Spectrum;
use crate::integrator::path::{LightRecord, Passage, PathRecord, ScatterRecord, VertexRecord};
use crate::light::Light;
use crate::math::{Bounds, DVec3, Ray};
use crate::scene::Scene;
use crate::schema::MaterialId;

/// A sort of path from the camera to light. In Heckbert's letters, from light to eye: L, diffuse D, other lobes S, E.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PathKind {
    /// What shines is seen, straight or through panes: LE.
    Emitted,
    /// The background or environment is seen: LE.
    Background,
    /// Light on a surface that is seen: LDE, L(glossy)E.
    Direct,
    /// What shines, or a lit surface, is seen in a mirror or through glass: L(D)S+E.
    Specular,
    /// Light that came by way of another diffuse surface: LDD+E.
    Indirect,
    /// Light that came by way of another surface's gloss, or in the gloss of the surface that is seen.
    Glossy,
    /// Light that mirrors, glass or gloss throw on a diffuse surface: LS+DE, wherever that is seen.
    Caustic,
}

impl PathKind {
    /// All of them, in the order of the legend.
    pub const ALL: [PathKind; 7] = [
        PathKind::Emitted,
        PathKind::Background,
        PathKind::Direct,
        PathKind::Specular,
        PathKind::Indirect,
        PathKind::Glossy,
        PathKind::Caustic,
    ];

    /// In a word.
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

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            PathKind::Emitted => "what shines, seen directly",
            PathKind::Background => "the background, seen directly",
            PathKind::Direct => "direct light",
            PathKind::Specular => "what is seen in mirrors and through glass",
            PathKind::Indirect => "light by way of other diffuse surfaces",
            PathKind::Glossy => "glossy reflections",
            PathKind::Caustic => "caustics",
        }
    }

    /// The colour of the legend, display values.
    pub fn color(self) -> [u8; 3] {
        // Okabe & Ito 2008: told apart by those who see colours differently, too.
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

/// Whose light it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Source {
    /// A light, by its number among the prepared scene's.
    Light(u32),
    /// A shape that shines, by its number in the description.
    Object(u32),
    /// The background's colour.
    Background,
    /// Ambient light.
    Ambient,
    /// One of very many lights.
    Unknown,
}

/// Light that a path brought.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub(super) kind: PathKind,
    pub(super) source: Source,
    /// The material that makes it what it is: the glass of a caustic, the surface of direct light.
    pub(super) material: Option<MaterialId>,
    /// Whether it was found by chance rather than by sampling a light.
    pub(super) by_chance: bool,
    /// Luminance.
    pub(super) value: f64,
}

/// Where lights are, to tell them apart.
pub(super) struct LightPlaces(Vec<Option<Bounds>>);

/// More lights than this are not told apart by place.
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

/// The light in a direction around the scene.
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

/// The shape that shines at a place.
fn shape_at(scene: &Scene, p: DVec3, direction: DVec3, distance: f64) -> Source {
    let ray =
        Ray { t_min: distance * (1.0 - 1e-3), t_max: distance * (1.0 + 1e-2), ..Ray::new(p, direction) };
    scene.intersect(&ray).map_or(Source::Unknown, |hit| Source::Object(scene.primitive_id(&hit)))
}

/// What the way from the camera was like so far.
#[derive(Clone, Copy, Default)]
struct Way {
    /// A mirror or clear glass was met before anything else.
    specular: bool,
    /// A diffuse lobe was taken.
    diffuse: bool,
    /// Another lobe that is not a mirror's, before any diffuse one.
    glossy: bool,
    /// Mirrors, glass or gloss since the last diffuse lobe.
    focused: Option<MaterialId>,
    /// How many lobes were taken that are not a mirror's.
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

    /// Of light that is found at the end of the way, behind `background` or on a surface.
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

    /// Of light that is sampled from a surface.
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

/// All light that a path brought, part by part.
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
        // A body is entered and left by one scattering: that where it is left.
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

/// Whether a material bends or mirrors light into caustics.
pub(super) fn casts_caustics(scene: &Scene, id: MaterialId) -> bool {
    materials::lets_through(scene, id)
}

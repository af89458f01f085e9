//! Prepares one description after another. A step whose inputs equal those of the last update returns its cached
//! result:
//!
//! ```text
//! textures    texture descriptions, images, transfer, filtering        CachedTextures; mipmaps by image
//! materials   material descriptions                                    CachedMaterials, per material
//! media       media, materials, background medium                      CachedMedia
//! lights      light description and its image                          CachedLights, per light
//! objects     objects, groups, meshes, light groups, shutter, opacity  CachedObjects; meshes by data
//! trees       objects, floor                                           Last::geometry
//! light tree  objects, lights, textures, emissive materials            emitters of the last scene
//! integrator  its settings, scene, camera, sampling of the film        Last::prepared
//! ```
//!
//! All steps also depend on the integrator's [`Capabilities`]. `Changed` collects what differs from the last
//! completed update, over failed and cancelled ones, too, since their steps replaced cached results.

use std::sync::Arc;

use turner_bvh::InstructionSet;

use super::default_studio::DefaultStudio;
use super::geometry::Geometry;
use super::lights::{CachedLights, PreparedLights};
use super::placed::{CachedObjects, ChangedObjects, ground_of};
use super::steps::{PrepareStep, UpdateOptions};
use super::surfaces::{CachedMaterials, CachedMedia, CachedTextures};
use crate::animation::motion::Displacement;
use crate::camera::CameraDesc;
use crate::color::Spectrum;
use crate::description::SceneDesc;
use crate::description::framing::Subject;
use crate::film::{Film, FilmDesc};
use crate::integrator::{Capabilities, IntegratorDesc, Prepared};
use crate::light::{BackgroundDesc, Light};
use crate::material::Material;
use crate::math::Bounds;
use crate::scene::camera_visibility::PrimitiveSet;
use crate::scene::emitters::Emitters;
use crate::scene::light_groups::LightGroups;
use crate::scene::placed_emitters::LightChoice;
use crate::scene::volumes::Volumes;
use crate::scene::{Scene, SceneStats};
use crate::schema::{ErrorCode, Named, PrepareOptions, SceneError, Warning};
use crate::shape::Plane;
use crate::texture::Textures;
use crate::view::{View, ViewSampling};

/// Prepares a scene after each edit of its description. Caches make an update cost only what the edit changed.
/// The result has the same bytes as a fresh [`SceneDesc::prepare`].
///
/// ```
/// use turner::description::SceneDesc;
/// use turner::prepare::Preparer;
///
/// let mut preparer = Preparer::new(Default::default());
/// let mut desc = SceneDesc::default();
/// let first = preparer.update(&desc)?;
/// desc.film.exposure = 1.0;
/// let second = preparer.update(&desc)?;
/// assert!(std::sync::Arc::ptr_eq(&first.scene, &second.scene));
/// # Ok::<(), turner::schema::SceneError>(())
/// ```
#[derive(Default)]
pub struct Preparer {
    options: PrepareOptions,
    textures: CachedTextures,
    materials: CachedMaterials,
    volumes: CachedMedia,
    lights: CachedLights,
    placed: CachedObjects,
    last: Option<Last>,
    /// What changed since `last`, including failed and cancelled updates.
    changed: Changed,
    /// Bytes reserved for the film.
    promised: u64,
}

/// The last completed preparation.
struct Last {
    prepared: Prepared,
    geometry: Geometry,
    ground: Option<Plane>,
    capabilities: Capabilities,
    /// `None` if it is not the description's.
    integrator: Option<IntegratorDesc>,
}

struct Surfaces {
    textures: Arc<Textures>,
    volumes: Option<Arc<Volumes>>,
    /// Whether texture lookups are filtered.
    filtered: bool,
}

/// Lights and materials, including those of the default studio.
struct WithStudio {
    has_studio: bool,
    studio: DefaultStudio,
    ground: Option<Plane>,
    floor: usize,
    physical: bool,
    materials: Vec<Material>,
    lights: Vec<Light>,
    sources: Vec<Option<u32>>,
    light_motions: Vec<Option<Displacement>>,
    shutter: [f64; 2],
    ambient: Spectrum,
    light_groups: LightGroups,
    shadow_catchers: PrimitiveSet,
    hidden_from_camera: PrimitiveSet,
    material_names: Arc<[Option<String>]>,
}

impl WithStudio {
    /// The camera of the view, with its source position.
    fn camera(&self, desc: &SceneDesc, geometry: &Geometry) -> Named<CameraDesc> {
        let named = self.studio.camera.as_ref().or(desc.camera.as_ref());
        named.cloned().unwrap_or_else(|| CameraDesc::framing(&geometry.total, desc.film.aspect()).into())
    }
}

/// The scene without its emitters.
fn assemble(
    surfaces: Surfaces,
    with_studio: WithStudio,
    g: Geometry,
    background: BackgroundDesc,
    instruction_set: InstructionSet,
) -> Scene {
    let Surfaces { textures, volumes, .. } = surfaces;
    let stats = SceneStats {
        primitives: g.primitives.len() as u64,
        triangles: g.triangles(),
        bounds: (!g.total.is_empty()).then_some(g.total),
        tree_bytes: g.tree_bytes(),
        mesh_bytes: g.mesh_bytes(),
        texture_bytes: textures.picture_memory() as u64,
    };
    Scene {
        background,
        textures,
        materials: with_studio.materials.into(),
        moves: g.moves || !with_studio.light_motions.is_empty(),
        lights: with_studio.lights.into(),
        light_motions: with_studio.light_motions.into(),
        shutter: with_studio.shutter,
        ambient: with_studio.ambient,
        primitives: g.primitives,
        bounded: g.bounded,
        gathered: g.gathered,
        world_mesh: g.world_mesh,
        transforms: g.transforms,
        bvh: g.bvh,
        culler: g.culler,
        frame: g.frame,
        batch: g.batch,
        faces: g.faces,
        physical: with_studio.physical,
        volumes,
        emitters: Arc::new(Emitters::default()),
        object_names: g.names,
        material_names: with_studio.material_names,
        light_groups: with_studio.light_groups,
        shadow_catchers: with_studio.shadow_catchers,
        hidden_from_camera: with_studio.hidden_from_camera,
        light_sources: with_studio.sources,
        stats,
        instruction_set,
    }
}

#[derive(Clone, Copy, Default)]
struct Changed {
    rebuilt: Rebuilt,
    /// A changed material is or was emissive.
    emissive: bool,
    volumes: bool,
    placed: bool,
}

/// What an update prepared again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rebuilt {
    /// The textures.
    pub textures: bool,
    /// Number of materials.
    pub materials: usize,
    /// Number of lights of the description.
    pub lights: usize,
    /// Number of meshes, with their BVHs unless they are part of the world mesh.
    pub meshes: usize,
    /// The placed objects and the BVH over them.
    pub objects: bool,
    /// The BVH of the static world mesh: meshes that are placed once or a few times.
    pub world_mesh: bool,
    /// The light tree.
    pub light_tree: bool,
    /// The integrator's preparation and its choices.
    pub integrator: bool,
}

/// A prepared scene, and what of it is new.
#[derive(Clone, Debug)]
pub struct Update {
    /// The prepared scene.
    pub prepared: Prepared,
    /// What was prepared again.
    pub rebuilt: Rebuilt,
}

impl Preparer {
    /// A preparer with an empty cache.
    pub fn new(options: PrepareOptions) -> Preparer {
        Preparer { options, ..Preparer::default() }
    }

    /// A preparer for a single preparation, which keeps no copies.
    pub(super) fn once(options: PrepareOptions) -> Preparer {
        Preparer { options, placed: CachedObjects::once(), ..Preparer::default() }
    }

    /// Prepares a description. The integrator makes its choices later, before the first sample
    /// ([`Prepared::choose`]).
    ///
    /// Errors: those of [`SceneDesc::prepare`]. The preparer stays usable.
    pub fn update(&mut self, desc: &SceneDesc) -> Result<Prepared, SceneError> {
        let update = self.update_with(desc, &UpdateOptions::default())?;
        update
            .map(|update| update.prepared)
            .ok_or_else(|| SceneError::new(ErrorCode::Internal, "an update stopped without a cancel"))
    }

    /// The same with cancel, progress and a report; `None` if it was cancelled.
    ///
    /// Errors: those of [`SceneDesc::prepare`].
    pub fn update_with(
        &mut self,
        desc: &SceneDesc,
        wanted: &UpdateOptions<'_>,
    ) -> Result<Option<Update>, SceneError> {
        let integrator = wanted.integrator.unwrap_or_else(|| desc.integrator.integrator());
        let capabilities = integrator.capabilities();
        self.options.limits.memory.begin("preparing the scene");
        let mut warnings = desc.warnings.clone();
        warnings.extend(desc.check_film()?);
        self.promise_film(&desc.film)?;

        if wanted.step(PrepareStep::Surfaces) {
            return Ok(None);
        }
        let surfaces = self.surfaces(desc, capabilities)?;
        if wanted.step(PrepareStep::Lights) {
            return Ok(None);
        }
        let lights = self.lights.prepare(desc, capabilities, self.options.threads)?;
        self.changed.rebuilt.lights += lights.rebuilt;
        if wanted.step(PrepareStep::Objects) {
            return Ok(None);
        }
        let with_studio = self.place(desc, capabilities, lights, &mut warnings)?;
        if wanted.step(PrepareStep::Trees) {
            return Ok(None);
        }
        let Some(geometry) = self.geometry(&with_studio, capabilities.shows_search, wanted)? else {
            return Ok(None);
        };
        wanted.begin(PrepareStep::LightTree);
        let background = with_studio.studio.background(&desc.background);
        let filtered = surfaces.filtered;
        let camera = with_studio.camera(desc, &geometry);
        let (ground, exposure) = (with_studio.ground, with_studio.studio.exposure);
        let scene = self.scene(surfaces, with_studio, geometry.clone(), background, capabilities);
        wanted.begin(PrepareStep::View);
        let sampling = ViewSampling {
            sobol: capabilities.physical,
            filtered,
            moves: scene.moves,
            weighted: !capabilities.debug,
            labels: capabilities.labels,
            instruction_set: scene.instruction_set,
        };
        let exposure = (desc.film.exposure + exposure).clamp(-64.0, 64.0);
        let film = FilmDesc { exposure, ..desc.film.clone() };
        let mut view = View::new(camera.value.clone(), film, sampling).map_err(|e| e.or_at(camera.span))?;
        let catches = capabilities.splits_light && !scene.shadow_catchers.is_empty();
        view.film.aovs.know_scene(scene.light_groups.names(), catches);
        warnings.extend(view.prepare_denoiser(capabilities.splits_light));
        self.promise_film(&view.film)?;
        let own = wanted.integrator.is_none().then(|| desc.integrator.clone());
        let last = self.last.as_ref().filter(|last| {
            own.is_some()
                && last.integrator == own
                && Arc::ptr_eq(&last.prepared.scene, &scene)
                && last.prepared.view.camera_desc == camera.value
                && last.prepared.view.film.has_samples_of(&view.film)
        });
        let integrator = match last {
            Some(last) => last.prepared.integrator.clone(),
            None => {
                self.changed.rebuilt.integrator = true;
                integrator.prepare(&scene, &view)?
            }
        };
        let prepared = Prepared { scene, view, integrator, warnings };
        let rebuilt = std::mem::take(&mut self.changed).rebuilt;
        self.last =
            Some(Last { prepared: prepared.clone(), geometry, ground, capabilities, integrator: own });
        Ok(Some(Update { prepared, rebuilt }))
    }

    fn surfaces(&mut self, desc: &SceneDesc, capabilities: Capabilities) -> Result<Surfaces, SceneError> {
        let physical = capabilities.physical;
        let filtered = desc.filters_textures(capabilities);
        let (textures, new) = self.textures.prepare(desc, filtered, &self.options)?;
        self.changed.rebuilt.textures |= new;
        let (count, emissive) = self.materials.prepare(desc, physical)?;
        self.changed.rebuilt.materials += count;
        self.changed.emissive |= emissive;
        let (volumes, new) = self.volumes.prepare(desc, physical)?;
        self.changed.volumes |= new;
        Ok(Surfaces { textures, volumes, filtered })
    }

    /// Places the objects and adds what the default studio provides.
    fn place(
        &mut self,
        desc: &SceneDesc,
        capabilities: Capabilities,
        lights: PreparedLights,
        warnings: &mut Vec<Warning>,
    ) -> Result<WithStudio, SceneError> {
        let Capabilities { physical, compensates, .. } = capabilities;
        let PreparedLights { mut lights, mut sources, ambient, .. } = lights;
        let traits = self.materials.traits();
        let ChangedObjects { placed: new, meshes } =
            self.placed.prepare(desc, &traits, &sources, physical, &self.options)?;
        self.changed.rebuilt.meshes += meshes;
        self.changed.placed |= new;
        let placed = self.placed.placed();
        let total = placed.map_or(Bounds::EMPTY, |placed| placed.total);
        let invalid: u64 = lights.iter().map(|l| l.invalid_pixels()).sum();
        warnings.extend(placed.iter().flat_map(|placed| placed.warnings.iter().cloned()));
        warnings.extend((invalid > 0).then(|| super::lights::invalid_pixels(invalid)));
        let studio = match &desc.studio {
            Some(studio) => {
                let subject = |name: Option<&str>| {
                    placed.map_or_else(|| Ok(Subject::new([], &total)), |placed| placed.subject(name))
                };
                studio.complete(desc, (&total, &subject), compensates, &mut lights)?
            }
            None => DefaultStudio::default(),
        };
        sources.resize(lights.len(), None);
        let light_motions =
            if physical { super::lights::motions(desc, &lights, &sources)? } else { Vec::new() };
        warnings.extend(studio.notes.iter().cloned());
        let mut materials = self.materials.materials();
        let floor = materials.len();
        studio.add_floor(physical, &mut materials);
        let ground = ground_of(&studio);
        let mut light_groups = placed.map_or_else(Default::default, |placed| placed.light_groups.clone());
        let mut shadow_catchers =
            placed.map_or_else(Default::default, |placed| placed.shadow_catchers.clone());
        if let (Some(placed), Some(_)) = (placed, &ground) {
            let floor = placed.primitives.len() as u32;
            light_groups.add(floor, None);
            // An opaque floor without end would hide the backdrop, or leave nothing of a transparent background.
            studio.catches_shadows.then(|| shadow_catchers.add(floor));
        }
        let has_studio = desc.studio.is_some();
        Ok(WithStudio {
            has_studio,
            studio,
            ground,
            floor,
            physical,
            materials,
            lights,
            sources,
            light_motions,
            shutter: desc.film.shutter,
            ambient,
            light_groups,
            shadow_catchers,
            hidden_from_camera: placed.map_or_else(Default::default, |p| p.hidden_from_camera.clone()),
            material_names: desc.materials.iter().map(|m| m.name.clone()).collect(),
        })
    }

    /// The BVHs: those of the last preparation if the objects are the same. `None` if cancelled.
    fn geometry(
        &mut self,
        with_studio: &WithStudio,
        full_rebuild: bool,
        wanted: &UpdateOptions<'_>,
    ) -> Result<Option<Geometry>, SceneError> {
        let last = self.last.as_ref();
        let same = |last: &&Last| {
            last.ground == with_studio.ground
                && last.capabilities.physical == with_studio.physical
                && !(full_rebuild && last.geometry.is_changed())
        };
        if let Some(last) = last.filter(same).filter(|_| !self.changed.placed) {
            return Ok(Some(last.geometry.clone()));
        }
        self.changed.rebuilt.objects = true;
        let Some(mut placed) = self.placed.take() else { return Ok(None) };
        placed.add_ground(&with_studio.studio, with_studio.floor);
        let before = last.map(|last| &last.geometry);
        let cancelled = || wanted.is_cancelled();
        let made =
            Geometry::new(placed, &with_studio.materials, before, full_rebuild, &self.options, &cancelled)?;
        let Some((geometry, world_mesh)) = made else { return Ok(None) };
        self.changed.rebuilt.world_mesh |= world_mesh;
        Ok(Some(geometry))
    }

    /// The scene: the last one if nothing changed.
    fn scene(
        &mut self,
        surfaces: Surfaces,
        with_studio: WithStudio,
        geometry: Geometry,
        background: BackgroundDesc,
        capabilities: Capabilities,
    ) -> Arc<Scene> {
        let Changed { rebuilt, emissive, volumes, .. } = self.changed;
        let has_studio = with_studio.has_studio;
        let mut scene = assemble(surfaces, with_studio, geometry, background, self.options.instruction_set);
        let last = self.last.as_ref().map(|last| (&last.prepared.scene, last.capabilities));
        let same_emitters =
            !(rebuilt.objects || rebuilt.lights > 0 || rebuilt.textures || emissive || has_studio);
        let kept = last.filter(|(last, own)| {
            same_emitters
                && *own == capabilities
                && last.lights.len() == scene.lights.len()
                && last.shutter == scene.shutter
        });
        let Some((last, _)) = kept else {
            self.changed.rebuilt.light_tree = capabilities.physical;
            scene.choose_lights(LightChoice::Auto);
            return Arc::new(scene);
        };
        let same = rebuilt.materials == 0
            && !volumes
            && last.has_settings_of(&scene)
            && last.materials.len() == scene.materials.len();
        if same {
            return last.clone();
        }
        scene.emitters = last.emitters.clone();
        Arc::new(scene)
    }

    /// Reserves the memory of a film, once.
    fn promise_film(&mut self, film: &FilmDesc) -> Result<(), SceneError> {
        let peak = Film::peak(film)?;
        if peak > self.promised {
            let more = peak - self.promised;
            let what = || format!("a picture of {}x{} pixels", film.width, film.height);
            self.options.limits.memory.promise(more, what)?;
            self.promised = peak;
        }
        Ok(())
    }
}

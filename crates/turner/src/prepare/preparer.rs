//! Descriptions prepared one after the other, each by what the last one left.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use turner_bvh::InstructionSet;

use super::default_studio::DefaultStudio;
use super::geometry::Geometry;
use super::lights::{CachedLights, PreparedLights};
use super::placed::{CachedObjects, ChangedObjects, ground_of};
use super::surfaces::{CachedMaterials, CachedMedia, CachedTextures};
use crate::camera::CameraDesc;
use crate::color::Spectrum;
use crate::description::SceneDesc;
use crate::film::{Film, FilmDesc};
use crate::integrator::{Capabilities, Integrator, IntegratorDesc, Prepared};
use crate::light::{BackgroundDesc, Light};
use crate::material::Material;
use crate::math::Bounds;
use crate::scene::emitters::Emitters;
use crate::scene::light_groups::LightGroups;
use crate::scene::placed_emitters::LightChoice;
use crate::scene::volumes::Volumes;
use crate::scene::{Scene, SceneStats};
use crate::schema::{ErrorCode, Named, PrepareOptions, SceneError, Warning, WarningKind};
use crate::shape::Plane;
use crate::texture::Textures;
use crate::view::{View, ViewSampling};

/// Prepares a scene again and again while its description is edited. It keeps what it made: textures, trees of meshes, tables of lights; an update costs what
/// the edit changed. What it gives has the bytes of a fresh [`SceneDesc::prepare`].
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
    /// What was made anew since then, also by updates that failed or were cancelled.
    changed: Changed,
    /// Bytes that were promised to the film.
    promised: u64,
}

/// The last preparation.
struct Last {
    prepared: Prepared,
    geometry: Geometry,
    ground: Option<Plane>,
    capabilities: Capabilities,
    /// `None` for one that is not the description's.
    integrator: Option<IntegratorDesc>,
}

/// What surfaces are made of.
struct Surfaces {
    textures: Arc<Textures>,
    volumes: Option<Arc<Volumes>>,
    /// Textures are averaged over what a ray stands for.
    filtered: bool,
}

/// Lights and materials, with what the stage added to them.
struct WithStudio {
    is_staged: bool,
    studio: DefaultStudio,
    ground: Option<Plane>,
    /// The number of the floor's material.
    floor: usize,
    physical: bool,
    materials: Vec<Material>,
    lights: Vec<Light>,
    sources: Vec<Option<u32>>,
    ambient: Spectrum,
    light_groups: LightGroups,
}

impl WithStudio {
    /// The camera to look through, and where it stands in a file.
    fn camera(&self, desc: &SceneDesc, geometry: &Geometry) -> Named<CameraDesc> {
        let named = self.studio.camera.as_ref().or(desc.camera.as_ref());
        named.cloned().unwrap_or_else(|| CameraDesc::framing(&geometry.total, desc.film.aspect()).into())
    }
}

/// All parts of a scene but what lights are chosen from.
fn assemble(
    surfaces: Surfaces,
    with_studio: WithStudio,
    g: Geometry,
    background: BackgroundDesc,
    instruction_set: InstructionSet,
) -> Scene {
    let Surfaces { textures, volumes, .. } = surfaces;
    let WithStudio { physical, materials, lights, sources, ambient, light_groups, .. } = with_studio;
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
        materials: materials.into(),
        lights: lights.into(),
        ambient,
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
        physical,
        moves: g.moves,
        volumes,
        emitters: Arc::new(Emitters::default()),
        object_names: g.names,
        light_groups,
        light_sources: sources,
        stats,
        instruction_set,
    }
}

/// What differs from the last preparation that came to its end.
#[derive(Clone, Copy, Default)]
struct Changed {
    remade: Remade,
    /// Materials that shine, or did.
    shines: bool,
    volumes: bool,
    /// Objects were placed anew.
    placed: bool,
}

/// How an update is made.
#[derive(Clone, Copy, Default)]
pub struct UpdateOptions<'a> {
    /// In place of the description's integrator.
    pub integrator: Option<&'a dyn Integrator>,
    /// Becomes true when the update should end: between its steps, and between trees of meshes. What was made so far is kept for the next one.
    pub cancel: Option<&'a AtomicBool>,
    /// Told of each step as it begins.
    pub progress: Option<&'a dyn Fn(PrepareStep)>,
}

impl UpdateOptions<'_> {
    fn is_cancelled(&self) -> bool {
        self.cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed))
    }

    fn begin(&self, step: PrepareStep) {
        if let Some(progress) = self.progress {
            progress(step);
        }
    }

    /// Begins a step; says whether to leave off instead.
    fn step(&self, step: PrepareStep) -> bool {
        self.begin(step);
        self.is_cancelled()
    }
}

/// A step of a preparation, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PrepareStep {
    /// Textures and their smaller sizes, materials, media.
    Surfaces,
    /// Lights and the tables of environments.
    Lights,
    /// Objects, placed in the world.
    Objects,
    /// Trees of meshes, and the tree over objects.
    Trees,
    /// What lights are chosen from.
    LightTree,
    /// Camera, film and integrator.
    View,
}

/// What an update made anew.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Remade {
    /// The textures.
    pub textures: bool,
    /// How many materials.
    pub materials: usize,
    /// How many lights of the description.
    pub lights: usize,
    /// How many meshes, with their trees if they have their own.
    pub meshes: usize,
    /// The objects in the world and the tree over them.
    pub objects: bool,
    /// The one tree over meshes that are placed once or a few times.
    pub world_mesh: bool,
    /// What lights are chosen from.
    pub light_tree: bool,
    /// What the integrator knows of the scene and the view: it chooses anew.
    pub integrator: bool,
}

/// A scene, ready, and what of it is new.
#[derive(Clone, Debug)]
pub struct Update {
    /// What is rendered.
    pub prepared: Prepared,
    /// What was made anew.
    pub remade: Remade,
}

impl Preparer {
    /// One that has made nothing so far.
    pub fn new(options: PrepareOptions) -> Preparer {
        Preparer { options, ..Preparer::default() }
    }

    /// One for a single preparation, which keeps no copy of what it makes.
    pub(super) fn once(options: PrepareOptions) -> Preparer {
        Preparer { options, placed: CachedObjects::once(), ..Preparer::default() }
    }

    /// Prepares a description. What its integrator chooses by probing, it chooses before its first sample ([`Prepared::choose`]).
    ///
    /// Errors: those of [`SceneDesc::prepare`]. The next update is right all the same.
    pub fn update(&mut self, desc: &SceneDesc) -> Result<Prepared, SceneError> {
        let update = self.update_with(desc, &UpdateOptions::default())?;
        update
            .map(|update| update.prepared)
            .ok_or_else(|| SceneError::new(ErrorCode::Internal, "an update ended that nobody cancelled"))
    }

    /// The same, cancellable, with progress and a report; `None` if it was cancelled.
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
        let lights = self.lights.prepare(desc, capabilities)?;
        self.changed.remade.lights += lights.remade;
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
        let background = desc.background.prepared();
        let filtered = surfaces.filtered;
        let camera = with_studio.camera(desc, &geometry);
        let ground = with_studio.ground;
        let scene = self.scene(surfaces, with_studio, geometry.clone(), background, capabilities);
        wanted.begin(PrepareStep::View);
        let sampling = ViewSampling {
            sobol: capabilities.physical,
            filtered,
            moves: scene.moves,
            labels: capabilities.labels,
            instruction_set: scene.instruction_set,
        };
        let view =
            View::new(camera.value.clone(), desc.film.clone(), sampling).map_err(|e| e.or_at(camera.span))?;
        let own = wanted.integrator.is_none().then(|| desc.integrator.clone());
        let last = self.last.as_ref().filter(|last| {
            own.is_some()
                && last.integrator == own
                && Arc::ptr_eq(&last.prepared.scene, &scene)
                && last.prepared.view.camera_desc == camera.value
                && same_samples(&last.prepared.view.film, &view.film)
        });
        let integrator = match last {
            Some(last) => last.prepared.integrator.clone(),
            None => {
                self.changed.remade.integrator = true;
                integrator.prepare(&scene, &view)?
            }
        };
        let prepared = Prepared { scene, view, integrator, warnings };
        let remade = std::mem::take(&mut self.changed).remade;
        self.last =
            Some(Last { prepared: prepared.clone(), geometry, ground, capabilities, integrator: own });
        Ok(Some(Update { prepared, remade }))
    }

    /// Textures, materials, media.
    fn surfaces(&mut self, desc: &SceneDesc, capabilities: Capabilities) -> Result<Surfaces, SceneError> {
        let physical = capabilities.physical;
        let filtered = desc.filters_textures(capabilities);
        let (textures, new) = self.textures.prepare(desc, filtered, &self.options)?;
        self.changed.remade.textures |= new;
        let (count, shines) = self.materials.prepare(desc, physical)?;
        self.changed.remade.materials += count;
        self.changed.shines |= shines;
        let (volumes, new) = self.volumes.prepare(desc, physical)?;
        self.changed.volumes |= new;
        Ok(Surfaces { textures, volumes, filtered })
    }

    /// Objects in the world, and what a stage adds to a scene without camera, light or floor.
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
        self.changed.remade.meshes += meshes;
        self.changed.placed |= new;
        let placed = self.placed.placed();
        let total = placed.map_or(Bounds::EMPTY, |placed| placed.total);
        let invalid: u64 = lights.iter().map(|l| l.invalid_pixels()).sum();
        warnings.extend(placed.iter().flat_map(|placed| placed.warnings.iter().cloned()));
        warnings.extend((invalid > 0).then(|| invalid_pixels(invalid)));
        let studio = match &desc.studio {
            Some(studio) => studio.complete(desc, &total, compensates, &mut lights)?,
            None => DefaultStudio::default(),
        };
        sources.resize(lights.len(), None);
        warnings.extend(studio.notes.iter().cloned());
        let mut materials = self.materials.materials();
        let floor = materials.len();
        studio.add_floor(physical, &mut materials);
        let ground = ground_of(&studio);
        let mut light_groups = placed.map_or_else(Default::default, |placed| placed.light_groups.clone());
        if let (Some(placed), Some(_)) = (placed, &ground) {
            light_groups.add(placed.primitives.len() as u32, None);
        }
        let is_staged = desc.studio.is_some();
        Ok(WithStudio {
            is_staged,
            studio,
            ground,
            floor,
            physical,
            materials,
            lights,
            sources,
            ambient,
            light_groups,
        })
    }

    /// The trees: those of the last preparation, where they are of the same objects. `None` if it was cancelled.
    fn geometry(
        &mut self,
        with_studio: &WithStudio,
        whole: bool,
        wanted: &UpdateOptions<'_>,
    ) -> Result<Option<Geometry>, SceneError> {
        let last = self.last.as_ref();
        let same = |last: &&Last| {
            last.ground == with_studio.ground
                && last.capabilities.physical == with_studio.physical
                && !(whole && last.geometry.is_changed())
        };
        if let Some(last) = last.filter(same).filter(|_| !self.changed.placed) {
            return Ok(Some(last.geometry.clone()));
        }
        self.changed.remade.objects = true;
        let Some(mut placed) = self.placed.take() else { return Ok(None) };
        placed.add_ground(&with_studio.studio, with_studio.floor);
        let before = last.map(|last| &last.geometry);
        let cancelled = || wanted.is_cancelled();
        let made = Geometry::new(placed, &with_studio.materials, before, whole, &self.options, &cancelled)?;
        let Some((geometry, world_mesh)) = made else { return Ok(None) };
        self.changed.remade.world_mesh |= world_mesh;
        Ok(Some(geometry))
    }

    /// The scene: the last one, where nothing of it changed.
    fn scene(
        &mut self,
        surfaces: Surfaces,
        with_studio: WithStudio,
        geometry: Geometry,
        background: BackgroundDesc,
        capabilities: Capabilities,
    ) -> Arc<Scene> {
        let Changed { remade, shines, volumes, .. } = self.changed;
        let is_staged = with_studio.is_staged;
        let mut scene = assemble(surfaces, with_studio, geometry, background, self.options.instruction_set);
        let last = self.last.as_ref().map(|last| (&last.prepared.scene, last.capabilities));
        let same_emitters = !(remade.objects || remade.lights > 0 || remade.textures || shines || is_staged);
        let kept = last.filter(|(last, own)| {
            same_emitters && *own == capabilities && last.lights.len() == scene.lights.len()
        });
        let Some((last, _)) = kept else {
            self.changed.remade.light_tree = capabilities.physical;
            scene.choose_lights(LightChoice::Auto);
            return Arc::new(scene);
        };
        let same = remade.materials == 0
            && !volumes
            && last.background == scene.background
            && last.ambient == scene.ambient
            && last.light_groups == scene.light_groups
            && last.light_sources == scene.light_sources
            && last.materials.len() == scene.materials.len();
        if same {
            return last.clone();
        }
        scene.emitters = last.emitters.clone();
        Arc::new(scene)
    }

    /// Asks for the memory of a film, once.
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

/// Whether two films take the same samples, so that what an integrator found out for one holds for the other: they may differ in what is made of the samples.
fn same_samples(a: &FilmDesc, b: &FilmDesc) -> bool {
    let of = |film: &FilmDesc| FilmDesc {
        exposure: 0.0,
        auto_exposure: false,
        tonemap: Default::default(),
        crop: None,
        threshold: 0.0,
        ..film.clone()
    };
    of(a) == of(b)
}

fn invalid_pixels(count: u64) -> Warning {
    let message =
        format!("{count} pixels of the environment map are negative or non-finite: 0 is used for them");
    Warning::new(WarningKind::Doubtful, message)
}

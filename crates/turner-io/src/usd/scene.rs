//! The walk over the prims of a stage, and the scene under construction.

use std::collections::{BTreeMap, BTreeSet};

use turner::camera::CameraDesc;
use turner::description::ObjectContent;
use turner::material::MaterialDesc;
use turner::math::DAffine3;
use turner::schema::{ErrorCode, GroupId, MaterialId, Named, Warning, WarningKind};

use super::materials::{Key, Looks};
use super::stage::{Prim, Stage};
use super::transforms;
use super::value::{Broken, Read, Value};
use super::{cameras, curves, instances, lights, meshes, shapes};
use crate::scene_import::CommonParts;
use crate::scene_import::report::{Fault, Place, unknown};

/// Most prims, those of prototypes once.
const MAX_PRIMS: u64 = 1 << 21;

/// What a prim takes from those that contain it.
#[derive(Clone, Debug)]
pub(super) struct State {
    /// To the space of the scene, or of the group that is under construction.
    pub(super) transform: DAffine3,
    /// Whether its purpose is one that is rendered.
    is_rendered: bool,
    /// Whether it is among the prims that were asked for.
    is_wanted: bool,
    /// The path of its material, and whether those below it cannot have another.
    pub(super) material: Option<String>,
    is_forced: bool,
}

impl State {
    /// The state in a group of its own.
    pub(super) fn inside(&self) -> State {
        State { transform: DAffine3::IDENTITY, ..self.clone() }
    }
}

/// What was found.
#[derive(Debug, Default)]
pub(super) struct Counts {
    pub(super) prims: u64,
    pub(super) meshes: u64,
    pub(super) lights: u64,
    pub(super) instances: u64,
}

/// The scene under construction.
pub(super) struct Scene<'a> {
    pub(super) stage: &'a Stage<'a>,
    pub(super) stock: CommonParts<'a>,
    /// Metres per unit of the stage.
    pub(super) unit: f64,
    pub(super) materials: Vec<Named<MaterialDesc>>,
    pub(super) material_ids: BTreeMap<Key, MaterialId>,
    pub(super) looks: Looks,
    pub(super) groups: BTreeMap<String, Option<GroupId>>,
    pub(super) cameras: Vec<Named<CameraDesc>>,
    pub(super) counts: Counts,
    /// Depth of the groups under construction; 0 is the scene.
    pub(super) depth: u32,
    /// Faces that subdivision may still make.
    pub(super) divisions: u64,
    to_scene: DAffine3,
    /// The names that were asked for and not found yet.
    missing: BTreeSet<String>,
}

impl From<Broken> for Fault {
    fn from(broken: Broken) -> Fault {
        Fault::new(ErrorCode::Model, broken.problem).help("export the file again")
    }
}

impl<'a> Scene<'a> {
    pub(super) fn new(stage: &'a Stage<'a>, stock: CommonParts<'a>, unit: f64) -> Scene<'a> {
        let missing = stock.options.nodes.iter().cloned().collect();
        Scene {
            stage,
            stock,
            unit,
            materials: Vec::new(),
            material_ids: BTreeMap::new(),
            looks: Looks::default(),
            groups: BTreeMap::new(),
            cameras: Vec::new(),
            counts: Counts::default(),
            depth: 0,
            divisions: 1 << 23,
            to_scene: DAffine3::IDENTITY,
            missing,
        }
    }

    pub(super) fn warn(&mut self, kind: WarningKind, message: impl Into<String>) {
        self.stock.report.remark(Warning::new(kind, message));
    }

    pub(super) fn ignored(&mut self, message: impl Into<String>) {
        self.stock.report.ignored_anywhere(message);
    }

    /// Imports all prims.
    pub(super) fn fill(&mut self, to_scene: DAffine3) -> Result<(), Fault> {
        self.to_scene = to_scene;
        let state = State {
            transform: to_scene,
            is_rendered: true,
            is_wanted: self.missing.is_empty(),
            material: None,
            is_forced: false,
        };
        let roots = self.stage.children(&self.stage.root())?;
        let names: Vec<String> = roots.iter().map(|prim| prim.path.clone()).collect();
        self.walk(roots, &state)?;
        match self.missing.first() {
            Some(name) => {
                let names: Vec<&str> = names.iter().map(|path| super::paths::name(path)).collect();
                Err(unknown("prim", name, &names))
            }
            None => Ok(()),
        }
    }

    /// Imports prims with all that they contain.
    pub(super) fn walk(&mut self, prims: Vec<Prim>, state: &State) -> Result<(), Fault> {
        let mut pending: Vec<(Prim, State)> = prims.into_iter().rev().map(|p| (p, state.clone())).collect();
        while let Some((prim, state)) = pending.pop() {
            self.counts.prims += 1;
            if self.counts.prims > MAX_PRIMS {
                let message = format!("more than {MAX_PRIMS} prims: its references multiply");
                return Err(Fault::new(ErrorCode::TooLarge, message).help("use instances"));
            }
            let is_active = self.stage.field(&prim, None, "active")? != Some(Value::Bool(false));
            if !is_active || !self.stage.is_defined(&prim)? {
                continue;
            }
            let Some(state) = self.enter(&prim, &state)? else { continue };
            let kind = self.stage.text_field(&prim, "typeName")?;
            let is_shown = state.is_rendered && state.is_wanted;
            if !self.add(&prim, &kind, &state, is_shown)? {
                continue;
            }
            if self.stage.field(&prim, None, "instanceable")? == Some(Value::Bool(true))
                && let Some(key) = self.stage.instance_key(&prim)
            {
                instances::place(self, &prim, key, &state)?;
                continue;
            }
            let children = self.stage.children(&prim)?;
            pending.extend(children.into_iter().rev().map(|child| (child, state.clone())));
        }
        Ok(())
    }

    /// What the contents of a prim take from it; `None` if it is invisible.
    pub(super) fn enter(&mut self, prim: &Prim, outer: &State) -> Read<Option<State>> {
        let stage = self.stage;
        let mut state = outer.clone();
        if let Some(Value::Text(word)) = stage.value(prim, "visibility")?
            && word == "invisible"
        {
            return Ok(None);
        }
        if let Some(Value::Text(purpose)) = stage.value(prim, "purpose")? {
            state.is_rendered = !matches!(purpose.as_str(), "proxy" | "guide");
        }
        let name = super::paths::name(&prim.path);
        let wanted = &self.stock.options.nodes;
        if wanted.iter().any(|n| n == name || *n == prim.path) {
            self.missing.remove(name);
            self.missing.remove(&prim.path);
            state.is_wanted = true;
        }
        let local = transforms::local(stage, prim)?;
        let base = if local.resets && self.depth == 0 { self.to_scene } else { outer.transform };
        state.transform = base * local.transform;
        self.bind(prim, &mut state)?;
        Ok(Some(state))
    }

    /// The material of a prim (UsdShadeMaterialBindingAPI).
    fn bind(&self, prim: &Prim, state: &mut State) -> Read<()> {
        if state.is_forced {
            return Ok(());
        }
        for name in ["material:binding:full", "material:binding"] {
            let targets = self.stage.targets(prim, name, "targetPaths")?;
            if let Some(path) = targets.into_iter().next() {
                state.material = Some(path);
                let strength = self.stage.field(prim, Some(name), "bindMaterialAs")?;
                state.is_forced = strength.as_ref().and_then(Value::text) == Some("strongerThanDescendants");
                break;
            }
        }
        Ok(())
    }

    /// The path of the material bound at a prim itself.
    pub(super) fn bound(&self, prim: &Prim, outer: &State) -> Read<Option<String>> {
        let mut state = outer.clone();
        self.bind(prim, &mut state)?;
        Ok(state.material)
    }

    /// Adds what a prim itself is. Returns whether it may contain more.
    fn add(&mut self, prim: &Prim, kind: &str, state: &State, is_shown: bool) -> Result<bool, Fault> {
        match kind {
            "PointInstancer" => {
                if is_shown {
                    instances::points(self, prim, state)?;
                }
                return Ok(false);
            }
            "Material" | "Shader" | "NodeGraph" | "GeomSubset" => return Ok(false),
            "Camera" => cameras::add(self, prim, state)?,
            _ if !is_shown => {}
            "Mesh" => meshes::add(self, prim, state)?,
            "Sphere" | "Cube" | "Cylinder" | "Cylinder_1" | "Cone" | "Capsule" | "Capsule_1" | "Plane" => {
                shapes::add(self, prim, kind, state)?;
            }
            "BasisCurves" => curves::add_curves(self, prim, state)?,
            "Points" => curves::add_points(self, prim, state)?,
            "NurbsPatch" | "NurbsCurves" | "HermiteCurves" | "TetMesh" | "Volume" => {
                self.ignored(format!("a prim of the type {kind}"));
            }
            _ if kind.ends_with("Light") || kind == "DomeLight_1" => lights::add(self, prim, kind, state)?,
            _ => {}
        }
        Ok(true)
    }

    /// Places a shape; without an invertible transform it is omitted.
    pub(super) fn place(
        &mut self,
        content: ObjectContent,
        material: Option<MaterialId>,
        prim: &Prim,
        transform: DAffine3,
    ) -> Result<(), Fault> {
        let before = self.stock.objects.len();
        self.stock.place_at(content, material, [transform; 2], Place::default())?;
        if let Some(object) = self.stock.objects.get_mut(before) {
            object.name = Some(super::paths::name(&prim.path).to_owned());
        }
        Ok(())
    }
}

//! Instances: prims that share a prototype (`instanceable`), and point instancers (UsdGeomPointInstancer).

use std::collections::BTreeSet;

use turner::description::ObjectContent;
use turner::math::{DAffine3, DVec3};
use turner::schema::{ErrorCode, GroupId, WarningKind};

use super::primvars::{integers, vectors};
use super::scene::{Scene, State};
use super::stage::Prim;
use super::transforms;
use super::value::Value;
use crate::scene_import::Place;
use crate::scene_import::report::Fault;

/// Deepest nesting of groups.
const MAX_DEPTH: u32 = 16;
/// Most instances of one instancer.
const MAX_INSTANCES: usize = 1 << 24;

/// Places an instance of a prim's contents.
pub(super) fn place(scene: &mut Scene<'_>, prim: &Prim, key: String, state: &State) -> Result<(), Fault> {
    let key = format!("{key}\n{:?}", state.material);
    let shared = scene.stage.shared(prim);
    let inside = state.inside();
    let children = scene.stage.children(&shared)?;
    let Some(id) = group(scene, prim, key, |scene| scene.walk(children, &inside))? else { return Ok(()) };
    scene.counts.instances += 1;
    scene.place(ObjectContent::Instance(id), None, prim, state.transform)
}

/// The group with a key; `fill` adds its objects the first time. `None` if it is empty.
fn group(
    scene: &mut Scene<'_>,
    prim: &Prim,
    key: String,
    fill: impl FnOnce(&mut Scene<'_>) -> Result<(), Fault>,
) -> Result<Option<GroupId>, Fault> {
    if let Some(known) = scene.groups.get(&key) {
        return Ok(*known);
    }
    if scene.depth >= MAX_DEPTH {
        scene.ignored(format!("instances nested more than {MAX_DEPTH} deep"));
        return Ok(None);
    }
    let first = scene.stock.objects.len();
    scene.depth += 1;
    let filled = fill(scene);
    scene.depth -= 1;
    filled?;
    let made = if scene.stock.objects.len() > first {
        let name = format!("{} {}", super::paths::name(&prim.path), scene.stock.groups.len());
        Some(scene.stock.group(&name, first, Place::default())?)
    } else {
        None
    };
    scene.groups.insert(key, made);
    Ok(made)
}

/// Places the instances of a point instancer.
pub(super) fn points(scene: &mut Scene<'_>, prim: &Prim, state: &State) -> Result<(), Fault> {
    let stage = scene.stage;
    let indices = integers(stage.value(prim, "protoIndices")?);
    let positions = stage.value(prim, "positions")?.as_ref().and_then(vectors::<3>).unwrap_or_default();
    let turns = stage.value(prim, "orientationsf")?.as_ref().and_then(vectors::<4>);
    let turns = match turns {
        Some(turns) => turns,
        None => stage.value(prim, "orientations")?.as_ref().and_then(vectors::<4>).unwrap_or_default(),
    };
    let scales = stage.value(prim, "scales")?.as_ref().and_then(vectors::<3>).unwrap_or_default();
    let ids = integers(stage.value(prim, "ids")?);
    let mut hidden: BTreeSet<i64> = integers(stage.value(prim, "invisibleIds")?).into_iter().collect();
    if let Some(Value::List(edit)) = stage.field(prim, None, "inactiveIds")? {
        let mut list = Vec::new();
        edit.apply(&mut list);
        hidden.extend(list.iter().filter_map(|id| id.parse::<i64>().ok()));
    }
    if indices.len() != positions.len() {
        let message = "a point instancer with other numbers of positions and indices";
        scene.warn(WarningKind::Doubtful, message);
    }
    if positions.len() > MAX_INSTANCES {
        let message = format!("{} instances; at most {MAX_INSTANCES} are read", positions.len());
        return Err(Fault::new(ErrorCode::TooLarge, message).help("use several instancers"));
    }
    let mut prototypes = Vec::new();
    for path in stage.targets(prim, "prototypes", "targetPaths")? {
        prototypes.push(prototype(scene, prim, &path, state)?);
    }
    for (i, (index, position)) in indices.iter().zip(&positions).enumerate() {
        let id = ids.get(i).copied().unwrap_or(i as i64);
        let Some(Some(group)) = usize::try_from(*index).ok().and_then(|i| prototypes.get(i)) else {
            continue;
        };
        if hidden.contains(&id) {
            continue;
        }
        let vector = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        let turn = turns.get(i).map(|q| transforms::rotation(q.map(f64::from))).unwrap_or_default();
        let scale = scales.get(i).map_or(DVec3::ONE, |s| vector(*s));
        let own = DAffine3::from_translation(vector(*position))
            * DAffine3::from_mat3(turn)
            * DAffine3::from_scale(scale);
        scene.counts.instances += 1;
        scene.place(ObjectContent::Instance(*group), None, prim, state.transform * own)?;
    }
    Ok(())
}

/// The group of a prototype, with the prototype's own transform.
fn prototype(
    scene: &mut Scene<'_>,
    instancer: &Prim,
    path: &str,
    state: &State,
) -> Result<Option<GroupId>, Fault> {
    if path == instancer.path || instancer.path.strip_prefix(path).is_some_and(|rest| rest.starts_with('/')) {
        scene.warn(WarningKind::Doubtful, format!("{}: has itself as a prototype", instancer.path));
        return Ok(None);
    }
    let Some(prim) = scene.stage.prim_at(path)? else {
        scene.warn(WarningKind::Doubtful, format!("{}: has no prototype {path}", instancer.path));
        return Ok(None);
    };
    let key = format!("prototype {path}\n{:?}", state.material);
    let inside = state.inside();
    group(scene, &prim.clone(), key, |scene| scene.walk(vec![prim], &inside))
}

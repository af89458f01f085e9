//! The attributes: their descriptions, then their values, in groups that are walked in the same order.

use super::connectivity::{Connectivity, Surface};
use super::corners::{Corners, NONE, at, put};
use super::order::{Order, Walk};
use super::prediction::{self, Neighbours};
use super::reader::Reader;
use super::values::{Coding, Kind};
use super::{Attribute, Read, Room, damaged, values};

/// Most attributes of a mesh. glTF's have some dozens.
const MAX_ATTRIBUTES: usize = 256;

/// Type of attribute: positions.
const POSITION: u8 = 0;

/// How an attribute is described.
#[derive(Clone, Copy, Debug)]
pub(super) struct Described {
    /// Its use: positions, normals …
    usage: u8,
    pub(super) kind: Kind,
    /// Components per entry.
    pub(super) width: usize,
    normalized: bool,
    id: u32,
}

/// Attributes whose values are stored in the same order.
struct Group {
    /// Which connectivity with seams it has; that of the positions if `None`.
    seamed: Option<usize>,
    walk: Walk,
    attributes: Vec<(Described, Coding)>,
}

/// Positions as integers, which predict other attributes.
struct Positions {
    values: Vec<i32>,
    of_point: Option<Vec<u32>>,
}

/// Reads all attributes.
pub(super) fn read(mesh: &Connectivity, reader: &mut Reader<'_>, room: Room<'_>) -> Read<Vec<Attribute>> {
    let groups = read_groups(mesh, reader)?;
    let mut positions = None;
    let mut attributes = Vec::new();
    for group in &groups {
        read_group(group, mesh, (&mut positions, &mut attributes), reader, room)?;
    }
    Ok(attributes)
}

fn read_groups(mesh: &Connectivity, reader: &mut Reader<'_>) -> Read<Vec<Group>> {
    let count = reader.byte()?;
    let mut groups = Vec::with_capacity(usize::from(count));
    for _ in 0..count {
        let (mut seamed, mut walk) = (None, Walk::DepthFirst);
        if let Some(surface) = &mesh.surface {
            let (number, by_corner, how) = (reader.byte()? as i8, reader.byte()?, reader.byte()?);
            walk = match how {
                0 => Walk::DepthFirst,
                1 => Walk::PredictionDegree,
                other => return damaged(&format!("walks the faces in way {other}; expected 0 or 1")),
            };
            if by_corner != 0 {
                match usize::try_from(number) {
                    Ok(number) if number < surface.seamed.len() => seamed = Some(number),
                    _ => {
                        let all = surface.seamed.len();
                        return damaged(&format!("refers to seams {number}, but there are {all}"));
                    }
                }
            }
        }
        groups.push(Group { seamed, walk, attributes: Vec::new() });
    }
    let mut total = 0;
    for group in &mut groups {
        let count = reader.varint()? as usize;
        total += count;
        if total > MAX_ATTRIBUTES {
            return damaged(&format!("has {total} attributes; expected at most {MAX_ATTRIBUTES}"));
        }
        let mut described = Vec::with_capacity(count);
        for _ in 0..count {
            let (usage, kind, width, normalized) =
                (reader.byte()?, reader.byte()?, reader.byte()?, reader.byte()?);
            let id = reader.varint()?;
            let Some(kind) = Kind::of(kind).filter(|_| width > 0) else {
                return damaged(&format!("has an attribute with {width} components of type {kind}"));
            };
            described.push(Described { usage, kind, width: width.into(), normalized: normalized != 0, id });
        }
        for described in described {
            group.attributes.push((described, Coding::read(reader, &described)?));
        }
    }
    Ok(groups)
}

fn read_group(
    group: &Group,
    mesh: &Connectivity,
    (positions, attributes): (&mut Option<Positions>, &mut Vec<Attribute>),
    reader: &mut Reader<'_>,
    room: Room<'_>,
) -> Read<()> {
    let walked = match &mesh.surface {
        Some(surface) => {
            let table = table(surface, group.seamed);
            Some((table, Order::of(group.walk, table, room)?))
        }
        None => None,
    };
    let entries = walked.as_ref().map_or(mesh.points, |(_, order)| order.corners.len());
    let of_point = match &walked {
        Some((table, order)) => Some(entries_of_points(mesh, table, order, room)?),
        None => None,
    };
    // All integers come first, then what turns them into values.
    let mut integers = Vec::with_capacity(group.attributes.len());
    for (described, coding) in &group.attributes {
        if *coding == Coding::Raw {
            integers.push(values::read_raw(described, entries, reader, room)?);
            continue;
        }
        let scheme = prediction::Scheme::read(reader, *coding)?;
        let mut neighbours = None;
        if let Some((table, order)) = &walked {
            let mut at_entries = Vec::new();
            if scheme.needs_positions() {
                let Some(positions) = &*positions else {
                    return damaged("predicts an attribute from positions, but has none before it");
                };
                at_entries = positions_of_entries(mesh, order, positions, room)?;
            }
            neighbours = Some(Neighbours { table, order, positions: at_entries });
        }
        let width = coding.width(described);
        let list = scheme.decode(entries, width, neighbours.as_ref(), reader, room)?;
        if described.usage == POSITION && width == 3 && positions.is_none() {
            let mut values = room.list(list.len())?;
            values.extend_from_slice(&list);
            *positions = Some(Positions { values, of_point: of_point.clone() });
        }
        integers.push(values::Portable::Integers(list));
    }
    for ((described, coding), portable) in group.attributes.iter().zip(integers) {
        let data = values::finish(described, *coding, portable, reader, room)?;
        attributes.push(Attribute {
            id: described.id,
            width: described.width,
            normalized: described.normalized,
            data,
            of_point: of_point.clone(),
        });
    }
    Ok(())
}

fn table(surface: &Surface, seamed: Option<usize>) -> &Corners {
    seamed.and_then(|number| surface.seamed.get(number)).unwrap_or(&surface.corners)
}

/// The entry of each point.
fn entries_of_points(mesh: &Connectivity, table: &Corners, order: &Order, room: Room<'_>) -> Read<Vec<u32>> {
    let mut map = room.filled(mesh.points, NONE)?;
    for (point, vertex) in mesh.faces.as_flattened().iter().zip(&table.vertex) {
        put(&mut map, *point, order.entry(*vertex));
    }
    if map.contains(&NONE) {
        return damaged("has a point without a value");
    }
    Ok(map)
}

/// The position of each entry.
fn positions_of_entries(
    mesh: &Connectivity,
    order: &Order,
    positions: &Positions,
    room: Room<'_>,
) -> Read<Vec<[i32; 3]>> {
    let points = mesh.faces.as_flattened();
    let mut list = room.list(order.corners.len())?;
    list.extend(order.corners.iter().map(|corner| {
        let point = at(points, *corner);
        let entry = positions.of_point.as_ref().map_or(point, |map| at(map, point));
        positions.values.as_chunks().0.get(entry as usize).copied().unwrap_or_default()
    }));
    Ok(list)
}

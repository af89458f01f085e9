//! (u, v) of meshes that have none: in pbrt each triangle has (0, 0), (1, 0), (1, 1). Triangles that share vertices cannot
//! have that, so the vertices are copied; only where a texture of the material asks for (u, v).

use std::collections::BTreeSet;

use turner::schema::{ColorSource, MeshData};
use turner::texture::{Mapping, TextureDesc};

use super::super::assembly::Assembly;
use super::super::state::State;

/// Whether the material of a shape, as far as it is defined, its alpha or its area light looks up a texture at (u, v).
pub(super) fn are_used(scene: &Assembly<'_>, state: &State, alpha: Option<ColorSource>) -> bool {
    if state.area_light.as_ref().is_some_and(|light| light.has("filename")) {
        return true;
    }
    let mut sources: Vec<ColorSource> = alpha.into_iter().collect();
    let (mut slots, mut seen) = (vec![state.material], BTreeSet::new());
    while let Some(slot) = slots.pop() {
        if !seen.insert(slot) {
            continue;
        }
        // A name that is defined later may have any texture.
        let Some(params) = scene.materials.params(slot) else { return true };
        if params.has("normalmap") {
            return true;
        }
        let textures = params.texture_names().filter_map(|name| scene.textures.get(name));
        sources.extend(textures.map(|t| t.source));
        // The parts of a mix.
        for name in params.unread_strings("materials") {
            let Some(slot) = scene.materials.slot_named(name) else { return true };
            slots.push(slot);
        }
    }
    let mut seen = BTreeSet::new();
    while let Some(source) = sources.pop() {
        let ColorSource::Texture(id) = source else { continue };
        if !seen.insert(id) {
            continue;
        }
        match scene.texture_desc(source) {
            None => {}
            Some(TextureDesc::Image(image)) if image.mapping != Mapping::Uv => {}
            Some(TextureDesc::Perlin(noise)) if noise.mapping != Mapping::Uv => {}
            Some(TextureDesc::Checkerboard(board)) if board.mapping != Mapping::Uv => {
                sources.extend([board.even, board.odd]);
            }
            Some(TextureDesc::Mix(mix)) => sources.extend([mix.a, mix.b, mix.amount]),
            Some(TextureDesc::Multiply(product)) => sources.extend([product.a, product.b]),
            Some(_) => return true,
        }
    }
    false
}

/// The mesh with vertices and (u, v) of its own for each triangle; `None` if memory is short.
pub(super) fn with_own_vertices(data: &MeshData, left: u64) -> Option<MeshData> {
    fn copied<T: Copy + Default>(list: &[T], triangles: &[[u32; 3]]) -> Option<Vec<T>> {
        let mut out = Vec::new();
        if !list.is_empty() {
            out.try_reserve_exact(triangles.len().checked_mul(3)?).ok()?;
            let of = |i: u32| list.get(i as usize).copied().unwrap_or_default();
            out.extend(triangles.iter().flatten().map(|&i| of(i)));
        }
        Some(out)
    }
    const CORNERS: [[f32; 2]; 3] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]];
    // Positions, normals and (u, v) of three corners, and their indices.
    const BYTES: u64 = 3 * (12 + 12 + 8) + 12;
    let count = u32::try_from(data.triangles.len()).ok().filter(|n| *n <= u32::MAX / 3)?;
    if u64::from(count) * BYTES > left {
        return None;
    }
    let mut uvs = Vec::new();
    uvs.try_reserve_exact(count as usize * 3).ok()?;
    uvs.extend((0..count).flat_map(|_| CORNERS));
    Some(MeshData {
        positions: copied(&data.positions, &data.triangles)?,
        normals: copied(&data.normals, &data.triangles)?,
        uvs,
        triangles: (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        face_materials: data.face_materials.clone(),
        material_names: data.material_names.clone(),
        ..MeshData::default()
    })
}

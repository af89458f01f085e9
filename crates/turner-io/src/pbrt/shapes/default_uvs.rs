//! (u, v) of meshes that have none: in pbrt each triangle has (0, 0), (1, 0), (1, 1). Triangles that share vertices cannot
//! have that, so the vertices are copied; only where a texture of the material asks for (u, v).

use std::collections::BTreeSet;

use turner::schema::{ColorSource, MeshData};
use turner::texture::{Mapping, TextureDesc};

use super::super::assembly::Assembly;
use super::super::state::State;
use crate::scene_import::{own_vertices_bytes, with_own_vertices};

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
        let parts = ["materials", "namedmaterial1", "namedmaterial2"];
        for name in parts.iter().flat_map(|part| params.unread_strings(part)) {
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

/// The mesh with vertices and (u, v) of its own for each triangle; `None` if it takes more than `left` bytes or memory is
/// short.
pub(super) fn with_default_uvs(data: &MeshData, left: u64) -> Option<MeshData> {
    const CORNERS: [[f32; 2]; 3] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]];
    let count = data.triangles.len();
    if own_vertices_bytes(data) + size_of_val(&CORNERS) as u64 * count as u64 > left {
        return None;
    }
    let mut uvs = Vec::new();
    uvs.try_reserve_exact(count.checked_mul(3)?).ok()?;
    uvs.extend((0..count).flat_map(|_| CORNERS));
    Some(MeshData { uvs, polygons: Vec::new(), ..with_own_vertices(data)? })
}

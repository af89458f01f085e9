//! Attributes of meshes: colours of vertices or faces that `mesh_attribute` textures show.
//!
//! A mesh in Turner has one colour for each vertex. So a mesh gets the colours of the attribute that its shape's BSDF
//! shows; where these belong to faces, each triangle gets vertices of its own.

use turner::schema::MeshData;

use super::assembly::Assembly;
use super::document::Document;
use super::meshes::MAX_FILE;
use super::params::Object;
use crate::assets::printable;
use crate::mesh::ply::attribute::{Of, read};
use crate::scene_import::report::Fault;
use crate::scene_import::{own_vertices_bytes, with_own_vertices};

/// The mesh attribute that every mesh is imported with: vertex colours.
const VERTEX_COLORS: &str = "vertex_color";

/// The name of the mesh attribute in the `mesh_attribute` textures of a shape; `None` if there are no such textures, or if
/// they use `vertex_color`, which is imported in any case.
pub(super) fn of_shape(scene: &mut Assembly<'_>, object: &Object) -> Result<Option<String>, Fault> {
    let names = names(&scene.document, object.node);
    if let [first, second, ..] = &names[..] {
        let (first, second) = (printable(first), printable(second));
        let message = format!("a shape with two mesh attributes: \"{first}\" replaces \"{second}\"");
        scene.report.approximated(object.place, message);
    }
    Ok(names.into_iter().next().filter(|name| name != VERTEX_COLORS))
}

/// The different names of attributes in an element, in the order of the document.
fn names(document: &Document, index: usize) -> Vec<String> {
    /// Most elements to look at.
    const MOST: usize = 1000;
    let mut open = vec![index];
    let mut names: Vec<String> = Vec::new();
    for _ in 0..MOST {
        let Some(index) = open.pop() else { break };
        let Some(node) = document.resolve(index).ok().and_then(|index| document.node(index)) else {
            continue;
        };
        if node.tag == "texture" && node.attribute("type") == Some("mesh_attribute") {
            let children = node.children.iter().filter_map(|child| document.node(*child));
            let mut named = children.filter(|n| n.tag == "string" && n.attribute("name") == Some("name"));
            let name = named.next().and_then(|n| n.attribute("value")).unwrap_or(VERTEX_COLORS).to_owned();
            if !names.contains(&name) {
                names.push(name);
            }
        }
        open.extend(node.children.iter().rev());
    }
    names
}

/// Gives a mesh the colours of an attribute.
pub(super) fn paint(
    scene: &mut Assembly<'_>,
    mesh: &mut MeshData,
    object: &Object,
    file: &str,
    name: &str,
) -> Result<(), Fault> {
    let wanted = Of::split(name).filter(|_| object.kind == "ply");
    let found = match wanted {
        None => Ok(None),
        Some((of, rest)) => {
            let (_, bytes) = scene.read(file, MAX_FILE, object.place_of("filename"))?;
            read(&bytes, of, rest).map(|colors| colors.map(|colors| (of, colors)))
        }
    };
    let problem = match found {
        Ok(Some((Of::Vertices, colors))) if colors.len() == mesh.positions.len() => {
            mesh.colors = colors.into_iter().map(opaque).collect();
            return Ok(());
        }
        Ok(Some((Of::Vertices, colors))) => {
            format!("{} colours for {} vertices", colors.len(), mesh.positions.len())
        }
        Ok(Some((Of::Faces, colors))) if colors.len() == mesh.triangles.len() => {
            let memory = &scene.options.limits.memory;
            let corners = colors.len().saturating_mul(3 * size_of::<[f32; 4]>()) as u64;
            memory
                .need(own_vertices_bytes(mesh) + corners, || format!("{}: its colours", printable(file)))?;
            match by_face(mesh, &colors) {
                Some(painted) => {
                    *mesh = painted;
                    return Ok(());
                }
                None => "not enough memory for vertices of each face".to_owned(),
            }
        }
        Ok(Some((Of::Faces, _))) => "polygons with attributes are not supported".to_owned(),
        Ok(None) => "the file has no such attribute".to_owned(),
        Err(problem) => problem,
    };
    let message = format!("the mesh attribute \"{}\": {}", printable(name), printable(&problem));
    scene.report.ignored(object.place, message);
    mesh.colors = Vec::new();
    Ok(())
}

fn opaque([r, g, b]: [f32; 3]) -> [f32; 4] {
    [r, g, b, 1.0]
}

/// The mesh with vertices of its own for each triangle, in its colour. `None` if memory is short.
fn by_face(mesh: &MeshData, colors: &[[f32; 3]]) -> Option<MeshData> {
    let mut corners = Vec::new();
    corners.try_reserve_exact(colors.len().checked_mul(3)?).ok()?;
    corners.extend(colors.iter().flat_map(|c| [opaque(*c); 3]));
    Some(MeshData { colors: corners, ..with_own_vertices(mesh)? })
}

#[cfg(test)]
mod tests {
    use turner::description::SceneDesc;

    use crate::assets::MemoryAssets;
    use crate::import::ImportOptions;

    const QUAD: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                        property float warm_r\nproperty float warm_g\nproperty float warm_b\n\
                        element face 2\nproperty list uchar int vertex_indices\nproperty float r\nproperty float g\n\
                        property float b\nend_header\n0 0 0 .1 .2 .3\n1 0 0 .4 .5 .6\n1 1 0 .7 .8 .9\n0 1 1 1 1 1\n\
                        3 0 1 2 1 0.5 0.25\n3 0 2 3 0 1 0.125\n";

    fn with(attributes: &[&str]) -> SceneDesc {
        let texture = |(i, name): (usize, &&str)| {
            let parameter = ["reflectance", "other"][i];
            format!(
                "<texture type='mesh_attribute' name='{parameter}'><string name='name' value='{name}'/></texture>"
            )
        };
        let textures: String = attributes.iter().enumerate().map(texture).collect();
        let text = format!(
            "<scene version='3.0.0'><bsdf id='b' type='diffuse'>{textures}</bsdf><shape type='ply'>\
             <string name='filename' value='q.ply'/><ref id='b'/></shape></scene>"
        );
        let mut assets = MemoryAssets::default();
        assets.files.insert("q.ply".into(), QUAD.as_bytes().to_vec());
        crate::mitsuba::import_from(text.into_bytes(), "a.xml", &assets, &ImportOptions::default()).unwrap()
    }

    #[test]
    fn faces_have_their_colors() {
        let scene = with(&["face_color"]);
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        let mesh = &scene.meshes[0].data;
        assert_eq!(mesh.triangles, [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(mesh.positions[3..], [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 1.0]]);
        assert_eq!(mesh.colors[2..4], [[1.0, 0.5, 0.25, 1.0], [0.0, 1.0, 0.125, 1.0]]);
        // Smooth across the edge, as before the triangles were separated.
        assert_eq!(mesh.normals[2], mesh.normals[4]);
    }

    #[test]
    fn attributes_are_found_by_their_names() {
        let scene = with(&["vertex_warm_color"]);
        let mesh = &scene.meshes[0].data;
        assert_eq!((mesh.colors.len(), mesh.colors[1]), (4, [0.4, 0.5, 0.6, 1.0]));
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        let said = |attributes: &[&str], what: &str| {
            let warnings = with(attributes).warnings;
            assert!(warnings.iter().any(|w| w.message.contains(what)), "{warnings:?}");
        };
        said(&["face_heat"], "\"face_heat\": the file has no such attribute");
        said(&["color"], "\"color\": the file has no such attribute");
    }
}

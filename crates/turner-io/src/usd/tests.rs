//! Tests of the import.

use turner::camera::CameraDesc;
use turner::color::Spectrum;
use turner::description::{ObjectContent, SceneDesc};
use turner::light::LightDesc;
use turner::material::{AlphaMode, MaterialDesc, PrincipledMaterial};
use turner::math::{DAffine3, DVec3};
use turner::schema::{ColorSource, MeshData, SceneError, WarningKind};
use turner::shape::ShapeDesc;
use turner::shape::mesh::MeshDesc;
use turner::texture::{Encoding, ImageChannel, TextureDesc};

use super::import;
use crate::assets::MemoryAssets;
use crate::import::ImportOptions;
use crate::testing::usd_seed;

mod hostile;
mod lighting;
mod looks;

fn try_read(text: &str, options: &ImportOptions) -> Result<SceneDesc, SceneError> {
    let text = if text.starts_with("#usda") {
        text.to_owned()
    } else {
        format!("#usda 1.0\n(metersPerUnit = 1)\n{text}")
    };
    import(text.into_bytes(), "a.usda", &MemoryAssets::default(), options)
}

fn read(text: &str) -> SceneDesc {
    try_read(text, &ImportOptions::default()).unwrap()
}

fn mesh(scene: &SceneDesc, object: usize) -> (&MeshDesc, &MeshData) {
    match &scene.objects[object].content {
        ObjectContent::Shape(ShapeDesc::Mesh(desc)) => (desc, &scene.meshes[desc.mesh.index()].data),
        other => panic!("{other:?}"),
    }
}

fn principled(scene: &SceneDesc, object: usize) -> &PrincipledMaterial {
    let id = scene.objects[object].material.unwrap();
    match &scene.materials[id.index()].value {
        MaterialDesc::Principled(m) => m,
        other => panic!("{other:?}"),
    }
}

fn near(a: DVec3, b: DVec3) {
    assert!((a - b).length() < 1e-9, "{a} {b}");
}

/// A triangle with further attributes.
fn triangle(more: &str) -> String {
    format!(
        "def Mesh \"T\" {{ int[] faceVertexCounts = [3]\n int[] faceVertexIndices = [0, 1, 2]\n\
         point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]\n{more} }}"
    )
}

#[test]
fn text_and_binary_are_the_same_scene() {
    let options = ImportOptions::default();
    let text = read(usd_seed::TEXT);
    let binary = import(usd_seed::BINARY.to_vec(), "a.usda", &MemoryAssets::default(), &options).unwrap();
    text.same_scene(&binary).unwrap();
    assert_eq!(text.warnings, binary.warnings);
    assert_eq!(text.warnings, []);
    // A square, two instances of a ball, a light.
    assert_eq!((text.objects.len(), text.groups.len(), text.cameras.len()), (4, 1, 1));
    assert!(text.is_animated());
    let later = ImportOptions { time: 1.0 / 24.0, ..options };
    let moved = try_read(usd_seed::TEXT, &later).unwrap();
    near(moved.objects[0].transform.0.translation, DVec3::X);
}

#[test]
fn the_scene_has_metres_and_y_up() {
    let text = format!(
        "#usda 1.0\n(upAxis = \"Z\"\n metersPerUnit = 0.1)\ndef Xform \"A\" {{ double3 xformOp:translate = (1, 2, 3)\n\
         uniform token[] xformOpOrder = [\"xformOp:translate\"]\n{} }}",
        triangle("")
    );
    let scene = read(&text);
    let place = scene.objects[0].transform.0;
    near(place.transform_point3(DVec3::ZERO), DVec3::new(0.1, 0.3, -0.2));
    near(place.transform_vector3(DVec3::Z), DVec3::new(0.0, 0.1, 0.0));
    // Without metersPerUnit the unit is a centimetre.
    let scene = read(&format!("#usda 1.0\n{}", triangle("")));
    near(scene.objects[0].transform.0.transform_vector3(DVec3::X), DVec3::X * 0.01);
}

/// The transforms are those of OpenUSD 26.11 (`UsdGeom.Xformable.GetLocalTransformation`).
#[test]
fn transforms_are_those_of_openusd() {
    let place = |ops: &str, order: &str| -> DAffine3 {
        let text = format!("{ops}\nuniform token[] xformOpOrder = [{order}]");
        read(&triangle(&text)).objects[0].transform.0
    };
    let point = DVec3::new(1.0, 2.0, 3.0);
    let (c, s) = (0.866_025_403_784_438_6, 0.5);
    let found = place("float3 xformOp:rotateXYZ = (30, 40, 50)", "\"xformOp:rotateXYZ\"");
    let expected = DVec3::new(1.801_281_061_9, 2.507_690_147_2, 2.113_498_677_9);
    assert!((found.transform_point3(point) - expected).length() < 1e-6, "{}", found.transform_point3(point));
    let found = place("float3 xformOp:rotateZYX = (30, 40, 50)", "\"xformOp:rotateZYX\"");
    let expected = DVec3::new(1.247_118_527_9, 0.341_872_161_0, 3.511_099_372_4);
    assert!((found.transform_point3(point) - expected).length() < 1e-6, "{}", found.transform_point3(point));
    // About a pivot, and turned by a quaternion.
    let found = place(
        "double3 xformOp:translate:pivot = (1, 0, 0)\nquatf xformOp:orient = (0.8660254037844386, 0, 0, 0.5)",
        "\"xformOp:translate:pivot\", \"xformOp:orient\", \"!invert!xformOp:translate:pivot\"",
    );
    let turned = found.transform_point3(DVec3::new(2.0, 0.0, 0.0));
    assert!((turned - DVec3::new(1.0 + s, c, 0.0)).length() < 1e-6, "{turned}");
    // Scaled first, then moved.
    let ops = "double3 xformOp:translate = (10, 0, 0)\nfloat3 xformOp:scale = (2, 3, 4)";
    let found = place(ops, "\"xformOp:translate\", \"xformOp:scale\"");
    near(found.transform_point3(point), DVec3::new(12.0, 6.0, 12.0));
}

#[test]
fn a_reset_begins_from_the_stage() {
    let text = format!(
        "def Xform \"A\" {{ double3 xformOp:translate = (5, 5, 5)\nuniform token[] xformOpOrder = [\"xformOp:translate\"]\n{} }}",
        triangle(
            "double xformOp:translateX = 1\nuniform token[] xformOpOrder = [\"!resetXformStack!\", \"xformOp:translateX\"]"
        )
    );
    near(read(&text).objects[0].transform.0.translation, DVec3::X);
}

#[test]
fn what_is_invisible_or_a_guide_is_not_shown() {
    for (more, expected) in [
        ("", 1),
        ("token visibility = \"invisible\"", 0),
        ("uniform token purpose = \"render\"", 1),
        ("uniform token purpose = \"proxy\"", 0),
        ("uniform token purpose = \"guide\"", 0),
    ] {
        assert_eq!(read(&triangle(more)).objects.len(), expected, "{more}");
    }
    let inactive = triangle("").replace("\"T\"", "\"T\" (active = false)");
    assert_eq!(read(&inactive).objects.len(), 0);
    assert_eq!(read(&triangle("").replace("def", "over")).objects.len(), 0);
    let class = format!("class \"C\" {{ {} }}", triangle(""));
    assert_eq!(read(&class).objects.len(), 0);
}

#[test]
fn polygons_are_cut_and_holes_left_out() {
    // An arrow, which is concave at its fourth corner, and a triangle that is a hole.
    let scene = read(
        "def Mesh \"M\" { int[] faceVertexCounts = [4, 3]\n int[] faceVertexIndices = [0, 1, 2, 3, 0, 1, 2]\n\
         int[] holeIndices = [1]\n point3f[] points = [(0, 0, 0), (2, 1, 0), (0, 2, 0), (0.5, 1, 0)] }",
    );
    let (_, data) = mesh(&scene, 0);
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| DVec3::from(data.positions[i as usize].map(f64::from)));
        0.5 * (b - a).cross(c - a).z
    };
    assert_eq!(data.triangles.len(), 2);
    assert!(data.triangles.iter().all(|t| area(t) > 0.0));
    assert!((data.triangles.iter().map(area).sum::<f64>() - 1.5).abs() < 1e-6);
}

#[test]
fn left_handed_faces_run_the_other_way() {
    let normal = |more: &str| {
        let scene = read(&triangle(more));
        let (_, data) = mesh(&scene, 0);
        let [a, b, c] = data.triangles[0].map(|i| DVec3::from(data.positions[i as usize].map(f64::from)));
        (b - a).cross(c - a).z
    };
    assert!(normal("") > 0.0);
    assert!(normal("uniform token orientation = \"leftHanded\"") < 0.0);
}

#[test]
fn primvars_have_every_interpolation() {
    // Two triangles of a square; each vertex shows which value it has by its colour.
    let square = |primvar: &str| {
        read(&format!(
            "def Mesh \"M\" {{ int[] faceVertexCounts = [3, 3]\n int[] faceVertexIndices = [0, 1, 2, 0, 2, 3]\n\
             point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]\n color3f[] primvars:displayColor = {primvar} }}"
        ))
    };
    let reds = |scene: &SceneDesc| -> Vec<Vec<f32>> {
        let (_, data) = mesh(scene, 0);
        data.triangles.iter().map(|t| t.map(|i| data.colors[i as usize][0]).to_vec()).collect()
    };
    let values = |n: usize| (0..n).map(|i| format!("({i}, 0, 0)")).collect::<Vec<_>>().join(", ");
    for (primvar, expected) in [
        ("[(7, 0, 0)]".to_owned(), [[7.0; 3]; 2]),
        (format!("[{}] (interpolation = \"uniform\")", values(2)), [[0.0; 3], [1.0; 3]]),
        (format!("[{}] (interpolation = \"vertex\")", values(4)), [[0.0, 1.0, 2.0], [0.0, 2.0, 3.0]]),
        (format!("[{}] (interpolation = \"varying\")", values(4)), [[0.0, 1.0, 2.0], [0.0, 2.0, 3.0]]),
        (format!("[{}] (interpolation = \"faceVarying\")", values(6)), [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]]),
        (
            format!(
                "[{}] (interpolation = \"uniform\")\n int[] primvars:displayColor:indices = [1, 0]",
                values(2)
            ),
            [[1.0; 3], [0.0; 3]],
        ),
        (
            format!(
                "[{}] (interpolation = \"faceVarying\")\n int[] primvars:displayColor:indices = [1, 1, 0, 1, 0, 0]",
                values(2)
            ),
            [[1.0, 1.0, 0.0], [1.0, 0.0, 0.0]],
        ),
    ] {
        let scene = square(&primvar);
        assert_eq!(reds(&scene), expected, "{primvar}");
        mesh(&scene, 0).1.check().unwrap();
    }
    // Corners with equal values share a vertex.
    let scene =
        square("[(1, 0, 0)] (interpolation = \"uniform\")\n int[] primvars:displayColor:indices = [0, 0]");
    assert_eq!(mesh(&scene, 0).1.positions.len(), 4);
}

#[test]
fn normals_are_smooth_where_authored() {
    let normals = "normal3f[] normals = [(0, 0, 1), (0, 1, 0), (1, 0, 0)] (interpolation = \"vertex\")";
    assert_eq!(mesh(&read(&triangle("")), 0).1.normals.len(), 0);
    assert_eq!(mesh(&read(&triangle(normals)), 0).1.normals[1], [0.0, 1.0, 0.0]);
    let primvar =
        format!("{normals}\nnormal3f[] primvars:normals = [(0, 0, -1)] (interpolation = \"constant\")");
    assert_eq!(mesh(&read(&triangle(&primvar)), 0).1.normals, [[0.0, 0.0, -1.0]; 3]);
}

#[test]
fn subdivision_needs_an_authored_scheme() {
    let cube = |more: &str| {
        read(&format!(
            "def Mesh \"M\" {{ int[] faceVertexCounts = [4, 4, 4, 4, 4, 4]\n\
             int[] faceVertexIndices = [0, 1, 3, 2, 2, 3, 5, 4, 4, 5, 7, 6, 6, 7, 1, 0, 1, 7, 5, 3, 6, 0, 2, 4]\n\
             point3f[] points = [(-1, -1, 1), (1, -1, 1), (-1, 1, 1), (1, 1, 1), (-1, 1, -1), (1, 1, -1), (-1, -1, -1), (1, -1, -1)]\n{more} }}"
        ))
    };
    assert!(mesh(&cube(""), 0).0.subdivision.is_none());
    assert!(mesh(&cube("uniform token subdivisionScheme = \"none\""), 0).0.subdivision.is_none());
    let creased = cube(
        "uniform token subdivisionScheme = \"catmullClark\"\n int[] creaseIndices = [0, 1, 3, 0, 3]\n int[] creaseLengths = [3, 2]\n\
         float[] creaseSharpnesses = [2, 5]\n int[] cornerIndices = [7]\n float[] cornerSharpnesses = [10]",
    );
    let subdivision = mesh(&creased, 0).0.subdivision.as_deref().unwrap();
    // 0–1 and 1–3 are edges, 0–3 is a diagonal.
    assert_eq!(subdivision.creases.len(), 3);
    assert_eq!(subdivision.creases.iter().map(|c| c[2]).collect::<Vec<_>>(), [2.0, 2.0, 10.0]);
    assert!(creased.warnings.iter().any(|w| w.kind == WarningKind::Doubtful));
    creased.prepare(&Default::default()).unwrap();
}

#[test]
fn subsets_have_their_own_materials() {
    let scene = read(
        "def Mesh \"M\" ( prepend apiSchemas = [\"MaterialBindingAPI\"] ) { int[] faceVertexCounts = [3, 4]\n\
         int[] faceVertexIndices = [0, 1, 2, 0, 2, 3, 4]\n rel material:binding = </Looks/A>\n\
         point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0.5, 2, 0), (0, 1, 0)]\n\
         def GeomSubset \"S\" { uniform token elementType = \"face\"\n uniform token familyName = \"materialBind\"\n\
         int[] indices = [1]\n rel material:binding = </Looks/B> } }\n\
         def Scope \"Looks\" { def Material \"A\" { token outputs:surface.connect = </Looks/A/S.outputs:surface>\n\
         def Shader \"S\" { uniform token info:id = \"UsdPreviewSurface\"\n color3f inputs:diffuseColor = (1, 0, 0) } }\n\
         def Material \"B\" { token outputs:surface.connect = </Looks/B/S.outputs:surface>\n\
         def Shader \"S\" { uniform token info:id = \"UsdPreviewSurface\"\n color3f inputs:diffuseColor = (0, 1, 0) } } }",
    );
    let (desc, data) = mesh(&scene, 0);
    assert_eq!(data.face_materials, [0, 1, 1]);
    let name =
        |id: Option<turner::schema::MaterialId>| scene.materials[id.unwrap().index()].name.clone().unwrap();
    assert_eq!([name(desc.materials[0]), name(desc.materials[1])], ["A", "B"]);
    assert_eq!(principled(&scene, 0).base_color, ColorSource::Constant(Spectrum::new(1.0, 0.0, 0.0)));
    scene.prepare(&Default::default()).unwrap();
}

#[test]
fn shapes_have_their_sizes_and_axes() {
    for (text, low, high) in [
        ("def Sphere \"A\" { double radius = 2 }", [-2.0; 3], [2.0; 3]),
        ("def Cube \"A\" { double size = 3 }", [-1.5; 3], [1.5; 3]),
        ("def Cylinder \"A\" { double height = 4 }", [-1.0, -1.0, -2.0], [1.0, 1.0, 2.0]),
        (
            "def Cylinder \"A\" { double height = 4\n uniform token axis = \"X\" }",
            [-2.0, -1.0, -1.0],
            [2.0, 1.0, 1.0],
        ),
        (
            "def Cone \"A\" { double radius = 0.5\n uniform token axis = \"Y\" }",
            [-0.5, -1.0, -0.5],
            [0.5, 1.0, 0.5],
        ),
        ("def Capsule \"A\" { double height = 2 }", [-0.5, -0.5, -1.5], [0.5, 0.5, 1.5]),
        ("def Plane \"A\" { double width = 4\n double length = 6 }", [-2.0, -3.0, 0.0], [2.0, 3.0, 0.0]),
        (
            "def Plane \"A\" { double width = 4\n double length = 6\n uniform token axis = \"Y\" }",
            [-2.0, 0.0, -3.0],
            [2.0, 0.0, 3.0],
        ),
        (
            "def Plane \"A\" { double width = 4\n double length = 6\n uniform token axis = \"X\" }",
            [0.0, -3.0, -2.0],
            [0.0, 3.0, 2.0],
        ),
    ] {
        let scene = read(text);
        let prepared = scene.prepare(&Default::default()).unwrap();
        let (_, bounds) = prepared.scene.all_bounds().next().unwrap();
        let close = |a: DVec3, b: [f64; 3]| (a - DVec3::from(b)).length() < 1e-3;
        assert!(close(bounds.min, low) && close(bounds.max, high), "{text}: {bounds:?}");
    }
}

#[test]
fn instances_share_a_group() {
    let scene = read(&format!(
        "class \"P\" {{ {} }}\n\
         def Xform \"A\" ( instanceable = true\n inherits = </P> ) {{ double3 xformOp:translate = (1, 0, 0)\n\
         uniform token[] xformOpOrder = [\"xformOp:translate\"] }}\n\
         def Xform \"B\" ( instanceable = true\n inherits = </P> ) {{ over \"T\" {{ token visibility = \"invisible\" }} }}\n\
         def Xform \"C\" ( inherits = </P> ) {{}}",
        triangle("")
    ));
    // What an instance says about its contents does not count.
    let instances: Vec<_> =
        scene.objects.iter().filter(|o| matches!(o.content, ObjectContent::Instance(_))).collect();
    assert_eq!((scene.objects.len(), instances.len(), scene.groups.len()), (3, 2, 1));
    assert_eq!(instances[0].content, instances[1].content);
    near(instances[0].transform.0.translation, DVec3::X);
}

#[test]
fn instancers_place_their_prototypes() {
    let scene = read(
        "def PointInstancer \"I\" { point3f[] positions = [(1, 0, 0), (2, 0, 0), (3, 0, 0)]\n int[] protoIndices = [0, 1, 0]\n\
         int64[] ids = [10, 11, 12]\n int64[] invisibleIds = [12]\n quath[] orientations = [(1, 0, 0, 0), (0.7071, 0, 0, 0.7071), (1, 0, 0, 0)]\n\
         float3[] scales = [(2, 2, 2), (1, 3, 1), (1, 1, 1)]\n rel prototypes = [</I/A>, </I/B>]\n\
         def Sphere \"A\" {}\n def Cube \"B\" { double xformOp:translateX = 1\n uniform token[] xformOpOrder = [\"xformOp:translateX\"] } }",
    );
    assert_eq!((scene.objects.len(), scene.groups.len()), (2, 2));
    near(scene.objects[0].transform.0.transform_point3(DVec3::X), DVec3::new(3.0, 0.0, 0.0));
    let second = scene.objects[1].transform.0;
    // Scaled along y, then turned by 90° about z.
    assert!((second.transform_point3(DVec3::Y) - DVec3::new(-1.0, 0.0, 0.0)).length() < 1e-3);
    near(scene.groups[1].value.objects[0].transform.0.translation, DVec3::X);
}

#[test]
fn references_bring_parts_of_other_files() {
    let mut assets = MemoryAssets::default();
    let chair = format!(
        "#usda 1.0\n(defaultPrim = \"Chair\")\ndef Xform \"Chair\" {{ {} }}",
        triangle("rel material:binding = </Chair/Look>")
    );
    assets.files.insert("parts/chair.usda".into(), chair.into_bytes());
    let text = "#usda 1.0\n(metersPerUnit = 1)\ndef \"One\" (references = @./parts/chair.usda@) {}\n\
                def \"Two\" (payload = @parts/chair.usda@</Chair>) { over \"T\" { token visibility = \"invisible\" } }\n\
                def \"Three\" (references = @../chair.usda@) {}\ndef \"Four\" (references = @/etc/passwd@) {}";
    let scene = import(text.into(), "a.usda", &assets, &ImportOptions::default()).unwrap();
    assert_eq!(scene.objects.len(), 1);
    // The material is looked for in the namespace of the reference.
    let messages: Vec<&str> = scene.warnings.iter().map(|w| w.message.as_str()).collect();
    assert!(messages.iter().any(|m| m.contains("\"Look\" does not exist")), "{messages:?}");
    assert!(messages.iter().any(|m| m.contains("leaves the folder")), "{messages:?}");
    assert!(messages.iter().any(|m| m.contains("absolute path")), "{messages:?}");
}

#[test]
fn nodes_select_prims() {
    let text = format!("def Xform \"A\" {{ {} }}\ndef Sphere \"B\" {{}}", triangle(""));
    let of = |nodes: &[&str]| {
        let nodes = nodes.iter().map(|n| (*n).to_owned()).collect();
        try_read(&text, &ImportOptions { nodes, ..ImportOptions::default() })
    };
    assert_eq!(of(&["A"]).unwrap().objects.len(), 1);
    assert_eq!(of(&["/A/T", "B"]).unwrap().objects.len(), 2);
    assert!(of(&["C"]).unwrap_err().message.contains("unknown prim \"C\""));
}

#[test]
fn curves_and_points_are_read() {
    let curve = |more: &str| {
        read(&format!(
            "def BasisCurves \"C\" {{ int[] curveVertexCounts = [4]\n\
             point3f[] points = [(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0)]\n{more} }}"
        ))
    };
    let strands = |scene: &SceneDesc| scene.meshes[0].data.strands.clone();
    let scene = curve("float[] widths = [0.1, 0.2, 0.3, 0.4] (interpolation = \"vertex\")");
    assert_eq!((strands(&scene), scene.meshes[0].data.widths.clone()), (vec![4], vec![0.1, 0.2, 0.3, 0.4]));
    // Two ends of one segment.
    let scene = curve("float[] widths = [0.1, 0.4] (interpolation = \"varying\")");
    let widths = &scene.meshes[0].data.widths;
    assert_eq!((widths[0], widths[3]), (0.1, 0.4));
    let linear = "uniform token type = \"linear\"";
    assert_eq!(strands(&curve(linear)), [4]);
    assert_eq!(strands(&curve(&format!("{linear}\nuniform token wrap = \"periodic\""))), [5]);
    assert_eq!(strands(&curve("uniform token basis = \"catmullRom\"")), [2]);
    assert_eq!(strands(&curve("uniform token basis = \"bspline\"\nuniform token wrap = \"pinned\"")), [6]);
    let scene = read(
        "def Points \"P\" { point3f[] points = [(0, 0, 0), (1, 0, 0)]\n float[] widths = [0.5, 1] (interpolation = \"vertex\") }",
    );
    let ObjectContent::Shape(ShapeDesc::Points(points)) = &scene.objects[0].content else { panic!() };
    assert_eq!(points.radii, [0.25, 0.5]);
    scene.prepare(&Default::default()).unwrap();
}

//! Integrators that show things rather than light: what they show is known by formula.

use turner::film::Picture;

use crate::classic::common::{describe, render, render_with};

const CAMERA: &str = "camera = { position = [0, 0, 5], look_at = [0, 0, 0], fov = 50 }\n";

fn look(integrator: &str, rest: &str) -> Picture {
    let film = if rest.contains("film =") { "" } else { "film = { width = 24, height = 16 }\n" };
    render(&format!("{CAMERA}{film}integrator = {{ {integrator} }}\n{rest}")).0
}

const WALL: &str = "[[object]]\ntype = \"plane\"\nnormal = [0, 0, 1]\n";
const BALL: &str = "[[object]]\ntype = \"sphere\"\nradius = 1.5\n";

/// The numbers of all pixels that hit something.
fn hits(picture: &Picture) -> Vec<[f64; 3]> {
    let hit = picture.linear.iter().filter(|p| p[3] == 1.0);
    hit.map(|p| [p[0], p[1], p[2]].map(f64::from)).collect()
}

#[test]
fn depth_of_a_plane_is_its_distance() {
    let axis = look("type = \"depth\", measure = \"axis\"", WALL);
    assert_eq!(hits(&axis).len(), 24 * 16);
    assert!(hits(&axis).iter().all(|d| d.iter().all(|d| (d - 5.0).abs() < 1e-6)));
    // All are equally near: a half of the range of colours.
    assert!(axis.display.iter().all(|c| *c == axis.display[0]));
    // Along the ray it is 5 over the cosine: p = 5 (tan x, tan y, 1).
    let distance = look("type = \"depth\"", WALL);
    let tan = (25f64.to_radians()).tan();
    for (i, d) in hits(&distance).iter().enumerate() {
        let (x, y) = ((i % 24) as f64 + 0.5 - 12.0, (i / 24) as f64 + 0.5 - 8.0);
        // The angle of view is that of the height.
        let expected = 5.0 * (1.0 + (x * x + y * y) * (tan / 8.0) * (tan / 8.0)).sqrt();
        assert!((d[0] - expected).abs() < 1e-5, "{d:?} {expected}");
    }
    // The nearest is the brightest, the farthest black.
    let [near, far] = [distance.display[7 * 24 + 11], distance.display[0]];
    assert_eq!((near, far), ([252, 253, 191, 255], [0, 0, 4, 255]));
}

#[test]
fn positions_lie_on_the_sphere() {
    let picture = look("type = \"position\"", BALL);
    let found = hits(&picture);
    assert!(found.len() > 50 && found.len() < 24 * 16);
    for [x, y, z] in found {
        assert!(((x * x + y * y + z * z).sqrt() - 1.5).abs() < 1e-6 && z > 0.0);
    }
    // Beside it there is no place.
    assert_eq!(picture.linear[0], [0.0; 4]);
    assert_eq!(picture.display[0], [0; 4]);
}

#[test]
fn coordinates_run_along_the_edges() {
    let rectangle = "[[object]]\ntype = \"rectangle\"\nedge_u = [4, 0, 0]\nedge_v = [0, 4, 0]\n";
    let (uv, at) = (look("type = \"uv\"", rectangle), look("type = \"position\"", rectangle));
    assert!(!hits(&uv).is_empty());
    for (uv, p) in hits(&uv).iter().zip(hits(&at)) {
        assert!((uv[0] - (p[0] / 4.0 + 0.5)).abs() < 1e-6 && (uv[1] - (p[1] / 4.0 + 0.5)).abs() < 1e-6);
    }
    // Of what repeats, the part after the point is shown.
    let wall = look("type = \"uv\"", WALL);
    for (shown, p) in wall.display.iter().zip(hits(&wall)) {
        let expected = ((p[0] - p[0].floor()) * 255.0).round();
        assert!((f64::from(shown[0]) - expected).abs() <= 1.0, "{shown:?} {p:?}");
    }
}

#[test]
fn albedo_is_the_colour_without_light() {
    let objects = "background = { color = [0.25, 0.5, 1] }\n[[object]]\ntype = \"sphere\"\nradius = 1.5\nmaterial = { color = [0.5, 0.25, 0.125], ka = 0.1 }\n";
    let picture = look("type = \"albedo\"", objects);
    assert_eq!(picture.linear[8 * 24 + 12], [0.5, 0.25, 0.125, 1.0]);
    assert_eq!(picture.linear[0], [0.25, 0.5, 1.0, 1.0]);
    let mixed = "[[object]]\ntype = \"sphere\"\nradius = 1.5\nmaterial = { type = \"mix\", materials = [\"a\", \"b\"], weights = [0.25] }\n\
        [material.a]\ntype = \"matte\"\ncolor = [1, 0, 0]\n[material.b]\ntype = \"principled\"\nbase_color = [0, 0, 1]\n";
    assert_eq!(look("type = \"albedo\"", mixed).linear[8 * 24 + 12], [0.75, 0.0, 0.25, 1.0]);
}

#[test]
fn ids_are_places_in_the_description() {
    let two = "[material.one]\ncolor = 1\n[material.two]\ncolor = 1\n\
        [[object]]\ntype = \"sphere\"\nradius = 0.8\ncenter = [-1, 0, 0]\nmaterial = \"two\"\n\
        [[object]]\ntype = \"box\"\nmin = [0.5, -0.5, -0.5]\nmax = [1.5, 0.5, 0.5]\nmaterial = \"one\"\n";
    let picture = look("type = \"ids\"", two);
    let mut seen: Vec<[u32; 2]> = hits(&picture).iter().map(|p| [p[0] as u32, p[1] as u32]).collect();
    seen.sort_unstable();
    seen.dedup();
    assert_eq!(seen, [[0, 1], [1, 0]]);
    let mut colors: Vec<[u8; 4]> = picture.display.clone();
    colors.sort_unstable();
    colors.dedup();
    assert_eq!(colors.len(), 3);
    let doubts = |film: &str| {
        let text = format!("{CAMERA}film = {{ {film} }}\nintegrator = {{ type = \"ids\" }}\n{BALL}");
        let desc = describe(&text);
        let found = turner::lint::lint(&desc, &desc.prepare(&Default::default()).unwrap());
        found.iter().filter(|w| w.message.contains("numbers of objects")).count()
    };
    assert_eq!((doubts("antialias = \"none\""), doubts("antialias = \"mean\"")), (0, 1));
}

#[test]
fn holes_are_not_there() {
    // The front of two walls has holes in a chessboard.
    let walls = "[texture.board]\ntype = \"chessboard\"\neven = 0\nodd = 1\n\
        [[object]]\ntype = \"plane\"\nnormal = [0, 0, 1]\npoint = [0, 0, 1]\nmaterial = { color = 1, opacity = \"board\" }\n\
        [[object]]\ntype = \"plane\"\nnormal = [0, 0, 1]\n";
    let picture = look("type = \"depth\", measure = \"axis\"", walls);
    let count = |depth: f64| hits(&picture).iter().filter(|d| (d[0] - depth).abs() < 1e-6).count();
    assert!(count(4.0) > 50 && count(5.0) > 50);
    assert_eq!(count(4.0) + count(5.0), 24 * 16);
}

#[test]
fn occlusion_by_formula() {
    let open = |more: &str, settings: &str| {
        let camera =
            "camera = { position = [3, 1, 0], look_at = [0, 0, 0] }\nfilm = { width = 1, height = 1 }\n";
        let integrator =
            format!("integrator = {{ type = \"ambient-occlusion\", samples = 4096{settings} }}\n");
        let floor = "[[object]]\ntype = \"plane\"\n";
        let (picture, stats) = render(&format!("{camera}{integrator}{floor}{more}"));
        assert_eq!(stats.shadow, 4096);
        f64::from(picture.linear[0][0])
    };
    assert_eq!(open("", ""), 1.0);
    // A wall takes the half of all directions that lead towards it, however far it is away.
    let wall = "[[object]]\ntype = \"plane\"\nnormal = [1, 0, 0]\npoint = [-2, 0, 0]\n";
    assert!((open(wall, "") - 0.5).abs() < 2e-3);
    assert_eq!(open(wall, ", distance = 1.5"), 1.0);
    // A sphere overhead takes (r / h)².
    let sphere = "[[object]]\ntype = \"sphere\"\ncenter = [0, 2, 0]\nradius = 1\n";
    assert!((open(sphere, "") - 0.75).abs() < 2e-3, "{}", open(sphere, ""));
    let none = look("type = \"ambient-occlusion\"", "");
    assert!(none.linear.iter().all(|p| *p == [1.0; 4]));
}

const TRIANGLE: &str = "[[object]]\ntype = \"mesh\"\npositions = [[-2, -2, 0], [2, -2, 0], [0, 2, 0]]\ntriangles = [[0, 1, 2]]\n\
    material = { color = 1 }\n";

#[test]
fn lines_have_their_width() {
    // In the row of y = -0.5 both long edges are crossed: 1 in 4 of the width per height, the line is wider by √(1 + 1/4) across x.
    let text = format!("film = {{ width = 240, height = 160 }}\n{TRIANGLE}");
    for width in [1.0, 3.0] {
        let picture = look(&format!("type = \"wireframe\", width = {width}"), &text);
        let row = &picture.linear[100 * 240..101 * 240];
        // Within the triangle surfaces are seen a little from the side.
        let inside: Vec<f32> = row.iter().filter(|p| p[0] < 1.0).map(|p| p[0]).collect();
        let dark: f64 = inside.iter().map(|v| (1.0 - f64::from(*v)).max(0.0)).sum();
        let shade: f64 = 0.02 * inside.len() as f64;
        // Half of each line lies on the triangle, half beside it, where there is nothing to draw on.
        let expected = 2.0 * (0.5 * width) * (1.25f64).sqrt();
        assert!((dark - expected).abs() < 0.6 + shade, "{dark} {expected}");
        assert!(picture.linear[150 * 240 + 120][0] > 0.9, "no line where none is");
    }
    // A sphere has lines of its coordinates: the equator covers the two rows in the middle, and the next line is 20 rows away.
    let film = "film = { width = 240, height = 160 }\n";
    let ball = look("type = \"wireframe\", width = 2", &format!("{film}{BALL}"));
    let row = |y: usize| &ball.linear[y * 240 + 85..y * 240 + 155];
    for y in [79, 80] {
        assert!(row(y).iter().all(|p| p[0] < 0.01), "{y}: {:?}", row(y));
    }
    for y in [76, 84] {
        let light = row(y).iter().filter(|p| p[0] > 0.5).count();
        // The next meridians, 45 degrees away, lie outside of these columns.
        assert_eq!(light, 68, "{y}: all but the two columns of the meridian in the middle");
    }
}

#[test]
fn cost_counts_what_lies_on_the_way() {
    // Shapes of a sieve and planes are tested one by one.
    let planes = format!("{WALL}{}", WALL.replace("[0, 0, 1]", "[0, 0, -1]"));
    let picture = look("type = \"cost\"", &planes);
    assert!(hits(&picture).iter().all(|c| *c == [2.0, 0.0, 2.0]));
    // One triangle: a node and a block where its box is met, nothing beside it.
    let picture = look("type = \"cost\"", TRIANGLE);
    let found = hits(&picture);
    assert_eq!(found.len(), 24 * 16, "rays that hit nothing cost something, too");
    let most = found.iter().map(|c| c[0]).fold(0.0, f64::max);
    assert!((1.0..=3.0).contains(&most) && found.iter().any(|c| c[0] < most), "{most}");
    assert!(found.iter().all(|c| c[0] == c[1] + c[2]));
}

#[test]
fn threads_change_nothing() {
    let scene = format!("background = {{ color = 0.5 }}\n{BALL}{TRIANGLE}{WALL}")
        .replace("normal", "point = [0, 0, -1]\nnormal");
    for integrator in
        ["depth", "position", "uv", "albedo", "ids", "wireframe", "ambient-occlusion", "cost", "normals"]
    {
        let film = "film = { width = 40, height = 40, antialias = \"monte-carlo\", samples = 4 }\n";
        let desc = describe(&format!("{CAMERA}{film}integrator = {{ type = \"{integrator}\" }}\n{scene}"));
        let (one, three) = (render_with(&desc, 1, u32::MAX).0, render_with(&desc, 3, 1).0);
        assert_eq!(one, three, "{integrator}");
    }
}

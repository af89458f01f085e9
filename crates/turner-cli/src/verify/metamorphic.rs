//! Metamorphic tests: equivalent scenes must give the same picture.
//!
//! Both scenes are rendered with the same seeds, so that most paths are equal up to rounding and small differences are
//! visible. Where rounding changes a decision, the paths differ; the mean of the differences must still be 0.

use turner::math::elementary::sin_cos;
use turner::schema::SceneError;
use turner::testing::{CompareOptions, Reference, compare};

use super::check::{Check, Context, Finding};

/// A transformation of the scene that does not change the picture.
#[derive(Clone, Copy)]
struct Spelling {
    /// Scale of all lengths.
    scale: f64,
    /// Translation after scaling.
    shift: [f64; 3],
    /// Mirrored in x.
    mirrored: bool,
    /// The floor is placed by an instance of a group.
    instanced: bool,
    /// Factor of all emission; the picture is divided by it.
    light: f64,
}

const PLAIN: Spelling =
    Spelling { scale: 1.0, shift: [0.0; 3], mirrored: false, instanced: false, light: 1.0 };

impl Spelling {
    fn point(&self, p: [f64; 3]) -> String {
        let x = if self.mirrored { -p[0] } else { p[0] };
        let at = |v: f64, shift: f64| v * self.scale + shift;
        format!("[{:?}, {:?}, {:?}]", at(x, self.shift[0]), at(p[1], self.shift[1]), at(p[2], self.shift[2]))
    }

    fn vector(&self, p: [f64; 3]) -> String {
        Spelling { shift: [0.0; 3], ..*self }.point(p)
    }

    /// The transform of an object without keys for position and size.
    fn transform(&self) -> String {
        let s = self.scale;
        let x = if self.mirrored { -s } else { s };
        let [a, b, c] = self.shift;
        format!("transform = [{{ scale = [{x:?}, {s:?}, {s:?}] }}, {{ translate = [{a:?}, {b:?}, {c:?}] }}]")
    }

    fn scene(&self) -> String {
        let length = |v: f64| format!("{:?}", v * self.scale);
        let light = |v: f64| format!("{:?}", v * self.light);
        // A wavy floor. Mesh vertices have single precision, so a transform places it.
        let n = 8;
        let mut positions = Vec::new();
        for i in 0..=n {
            for j in 0..=n {
                let (x, z) = (f64::from(i) - 4.0, f64::from(j) - 4.0);
                positions.push(format!("[{x}, {:.3}, {z}]", 0.1 * sin_cos(x + 2.0 * z).0));
            }
        }
        let mut triangles = Vec::new();
        for i in 0..n {
            for j in 0..n {
                let a = i * (n + 1) + j;
                let (b, c, d) = (a + 1, a + n + 1, a + n + 2);
                triangles.push(format!("[{a}, {b}, {c}], [{b}, {d}, {c}]"));
            }
        }
        let floor = format!(
            "type = \"mesh\"\npositions = [{}]\ntriangles = [{}]\nsmooth = true\nmaterial = \"wall\"",
            positions.join(", "),
            triangles.join(", ")
        );
        let (groups, floor) = if self.instanced {
            let group = format!("[[group.floor.object]]\n{floor}\n");
            (group, format!("[[object]]\ntype = \"instance\"\ngroup = \"floor\"\n{}\n", self.transform()))
        } else {
            (String::new(), format!("[[object]]\n{floor}\n{}\n", self.transform()))
        };
        // The camera is not mirrored itself: it sees the mirrored scene mirrored, and the caller flips the picture.
        format!(
            "camera = {{ position = {eye}, look_at = {target}, fov = 40 }}\n\
             integrator = {{ type = \"path\", max_depth = 6 }}\n\
             material.wall = {{ type = \"matte\", color = [0.7, 0.6, 0.5] }}\n\
             material.gloss = {{ type = \"metal\", name = \"copper\", roughness = 0.3 }}\n\
             material.glass = {{ type = \"dielectric\", color = [0.9, 1, 0.9], depth = {depth} }}\n\
             material.lamp = {{ type = \"emissive\", strength = {shine} }}\n{groups}\
             [[light]]\ntype = \"point\"\nposition = {bulb}\nintensity = {intensity}\nattenuation = \"inverse-square\"\n\
             {floor}\
             [[object]]\ntype = \"sphere\"\ncenter = {a}\nradius = {ra}\nmaterial = \"gloss\"\n\
             [[object]]\ntype = \"sphere\"\ncenter = {b}\nradius = {rb}\nmaterial = \"glass\"\n\
             [[object]]\ntype = \"box\"\nmin = {low}\nmax = {high}\nmaterial = \"wall\"\n\
             [[object]]\ntype = \"rectangle\"\ncenter = {c}\nedge_u = {u}\nedge_v = {v}\nmaterial = \"lamp\"\n",
            eye = self.point([0.0, 2.0, 6.0]),
            target = self.point([0.0, 0.7, 0.0]),
            depth = length(1.0),
            shine = light(6.0),
            bulb = self.point([2.0, 4.0, 2.0]),
            // Inverse-square falloff is in scene units.
            intensity = light(20.0 * self.scale * self.scale),
            a = self.point([-1.0, 0.8, 0.0]),
            ra = length(0.7),
            b = self.point([0.8, 0.7, 0.6]),
            rb = length(0.6),
            low = self.corner([0.6, 0.0, -1.8], [1.8, 1.2, -0.8], f64::min),
            high = self.corner([0.6, 0.0, -1.8], [1.8, 1.2, -0.8], f64::max),
            c = self.point([0.0, 3.0, 0.0]),
            u = self.vector([1.5, 0.0, 0.0]),
            v = self.vector([0.0, 0.0, 1.5]),
        )
    }

    fn corner(&self, a: [f64; 3], b: [f64; 3], of: impl Fn(f64, f64) -> f64) -> String {
        let flip = |p: [f64; 3]| if self.mirrored { [-p[0], p[1], p[2]] } else { p };
        let (a, b) = (flip(a), flip(b));
        Spelling { mirrored: false, ..*self }.point([of(a[0], b[0]), of(a[1], b[1]), of(a[2], b[2])])
    }
}

pub(super) fn checks() -> Vec<Check> {
    let far = [1e6, -1e6, 1e6];
    let mut out: Vec<Check> = [
        ("sixteen-times-as-large", Spelling { scale: 16.0, ..PLAIN }),
        ("a-1024th-as-large", Spelling { scale: 1.0 / 1024.0, ..PLAIN }),
        ("scale-1e-4", Spelling { scale: 1e-4, ..PLAIN }),
        ("scale-1e5", Spelling { scale: 1e5, ..PLAIN }),
        ("a-million-away", Spelling { shift: far, ..PLAIN }),
        ("instance-or-flat", Spelling { instanced: true, ..PLAIN }),
        ("eight-times-the-light", Spelling { light: 8.0, ..PLAIN }),
    ]
    .into_iter()
    .map(|(name, spelling)| Check::chance(format!("same/{name}"), move |cx| paired(cx, name, &spelling)))
    .collect();
    out.push(Check::chance("same/mirrored", |cx| {
        // Mirroring changes the frames in which directions are sampled: other paths, so no pairs.
        let size = [24, 24];
        let render = |spelling: &Spelling, seed: &str| {
            let scene = cx.scene(size, cx.times(32), &spelling.scene())?;
            cx.runs(&scene, 12, seed)
        };
        let plain = render(&PLAIN, "mirrored/one")?;
        let mut mirrored = render(&Spelling { mirrored: true, ..PLAIN }, "mirrored/other")?;
        for picture in &mut mirrored.pictures {
            picture.chunks_exact_mut(size[0] as usize).for_each(<[_]>::reverse);
        }
        Ok(Finding::comparison(&compare(&plain, &mirrored, &CompareOptions::default()), 0.02))
    }));
    out
}

fn paired(cx: &Context, name: &str, spelling: &Spelling) -> Result<Finding, SceneError> {
    let render = |spelling: &Spelling| {
        let scene = cx.scene([24, 24], cx.times(16), &spelling.scene())?;
        cx.runs(&scene, 12, name)
    };
    let (plain, mut other) = (render(&PLAIN)?, render(spelling)?);
    for v in other.pictures.iter_mut().flatten().flatten() {
        *v /= spelling.light as f32;
    }
    let pairs = plain.pictures.iter().flatten().zip(other.pictures.iter().flatten());
    let equal = pairs.filter(|(a, b)| (0..3).all(|c| (a[c] - b[c]).abs() <= 1e-5 * a[c].abs())).count();
    let fraction = equal as f64 / (plain.pictures.len() * 24 * 24) as f64;
    let zero = Reference::constant(24, 24, [0.0; 3]);
    // The tolerance covers rounding of sums in single precision.
    let mean = (0..3).map(|band| plain.mean(band).mean).fold(0.0, f64::max);
    let options = CompareOptions { absolute: 1e-5 * mean, ..CompareOptions::default() };
    let mut found = compare(&plain.minus(&other), &zero, &options);
    let unpaired = compare(&plain, &other, &CompareOptions::default());
    (found.ratio, found.ratio_error) = (unpaired.ratio, unpaired.ratio_error);
    // The test is on the differences. Noise cancels in them, since both pictures have the same seeds.
    let mut finding = Finding::comparison(&found, 1.0);
    finding.found = format!("{:.1} % of pixels equal, {}", 100.0 * fraction, finding.found);
    Ok(finding)
}

//! Phase functions: `hg`, `isotropic`, `rayleigh`, and mixtures of them by `blendphase`. Others become the lobe with the same
//! mean cosine.

use super::assembly::Assembly;
use super::params::Object;
use crate::scene_import::report::Fault;
use crate::scene_import::unknown;

/// Deepest nesting of blends.
const MAX_NESTING: u32 = 16;

/// What a medium of Turner has.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Phase {
    pub(super) anisotropy: f64,
    pub(super) second_anisotropy: f64,
    pub(super) second_weight: f64,
    pub(super) rayleigh: f64,
}

/// The mean cosines of lobes, with the fractions of light that they scatter, and that of Rayleigh's function.
#[derive(Default)]
struct Parts {
    lobes: Vec<[f64; 2]>,
    rayleigh: f64,
}

/// The phase function of a medium.
pub(super) fn of_medium(scene: &mut Assembly<'_>, medium: &Object) -> Result<Phase, Fault> {
    let Some(object) = medium.object("phase")? else { return Ok(Phase::default()) };
    let mut parts = Parts::default();
    collect(scene, &object, 1.0, &mut parts, 0)?;
    parts.lobes.sort_by(|a, b| b[1].total_cmp(&a[1]));
    // Two lobes remain; the others join the nearer of them.
    while let Some([g, weight]) = parts.lobes.get(2).copied() {
        scene.report.approximated(object.place, "a blend of more than two lobes: two remain");
        let distance = |i: usize| (parts.lobes[i][0] - g).abs();
        let nearer = usize::from(distance(1) < distance(0));
        let to = &mut parts.lobes[nearer];
        *to = [(to[0] * to[1] + g * weight) / (to[1] + weight), to[1] + weight];
        parts.lobes.remove(2);
    }
    let lobe = |i: usize| parts.lobes.get(i).copied().unwrap_or_default();
    let ([first, first_weight], [second, second_weight]) = (lobe(0), lobe(1));
    let both = first_weight + second_weight;
    Ok(Phase {
        anisotropy: first.clamp(-0.999, 0.999),
        second_anisotropy: second.clamp(-0.999, 0.999),
        second_weight: if both > 0.0 { second_weight / both } else { 0.0 },
        rayleigh: parts.rayleigh.clamp(0.0, 1.0),
    })
}

/// Adds a phase function that scatters a fraction of light.
fn collect(
    scene: &mut Assembly<'_>,
    object: &Object,
    weight: f64,
    parts: &mut Parts,
    depth: u32,
) -> Result<(), Fault> {
    match object.kind.as_str() {
        "blendphase" if depth < MAX_NESTING => blend(scene, object, weight, parts, depth)?,
        "hg" => parts.add(object.float("g")?.unwrap_or(0.8), weight),
        "isotropic" => parts.add(0.0, weight),
        "rayleigh" => parts.rayleigh += weight,
        "tabphase" => {
            let g = object.string("values")?.and_then(mean_cosine).unwrap_or(0.0);
            let message = format!("{}: a lobe with its mean cosine, {g:.3}, replaces it", object.title());
            scene.report.approximated(object.place, message);
            parts.add(g, weight);
        }
        "sggx" | "blendphase" => {
            object.pass_all();
            scene.report.approximated(object.place, format!("{}: rendered as isotropic", object.title()));
            parts.add(0.0, weight);
        }
        other => {
            let all = ["hg", "isotropic", "rayleigh", "blendphase", "sggx", "tabphase"];
            return Err(unknown("phase", other, &all).or_at(object.place));
        }
    }
    scene.finish(object);
    Ok(())
}

/// `blendphase`: the second of two functions with a constant weight.
fn blend(
    scene: &mut Assembly<'_>,
    object: &Object,
    weight: f64,
    parts: &mut Parts,
    depth: u32,
) -> Result<(), Fault> {
    let children = object.objects(&["phase"])?;
    let second = match object.find("weight") {
        Some((_, element)) if element.tag != "float" => {
            object.pass(&["weight"]);
            scene.report.approximated(
                object.place_of("weight"),
                "a volume of weights of phase functions: 0.5 replaces it",
            );
            0.5
        }
        _ => object.float("weight")?.unwrap_or(0.5).clamp(0.0, 1.0),
    };
    for (child, part) in children.into_iter().zip([1.0 - second, second]) {
        let child = Object::new(&scene.document, child)?;
        collect(scene, &child, weight * part, parts, depth + 1)?;
    }
    Ok(())
}

impl Parts {
    fn add(&mut self, g: f64, weight: f64) {
        match self.lobes.iter_mut().find(|lobe| lobe[0] == g) {
            Some(lobe) => lobe[1] += weight,
            None if weight > 0.0 => self.lobes.push([g, weight]),
            None => {}
        }
    }
}

/// The mean cosine of a function by its values at evenly spaced cosines, from −1 (straight back) to 1 (straight forward).
fn mean_cosine(values: &str) -> Option<f64> {
    let numbers: Option<Vec<f64>> = values
        .split([',', ' '])
        .filter(|word| !word.is_empty())
        .map(|word| word.parse().ok().filter(|v: &f64| v.is_finite() && *v >= 0.0))
        .collect();
    let numbers = numbers.filter(|numbers| numbers.len() > 1)?;
    let step = 2.0 / (numbers.len() - 1) as f64;
    let (mut total, mut moment) = (0.0, 0.0);
    for (i, pair) in numbers.windows(2).enumerate() {
        let from = -1.0 + step * i as f64;
        // Linear between the values.
        total += 0.5 * (pair[0] + pair[1]);
        moment += 0.5 * (pair[0] + pair[1]) * from + step * (pair[0] + 2.0 * pair[1]) / 6.0;
    }
    (total > 0.0).then(|| moment / total)
}

#[cfg(test)]
mod tests {
    use turner::medium::MediumDesc;

    use super::*;
    use crate::assets::MemoryAssets;
    use crate::import::ImportOptions;

    /// The phase function of a medium, and the number of warnings.
    fn read(phase: &str) -> ([f64; 4], usize) {
        let text = format!(
            "<scene version='3.0.0'><shape type='sphere'><bsdf type='null'/>
             <medium type='homogeneous' name='interior'>{phase}</medium></shape></scene>"
        );
        let (assets, options) = (MemoryAssets::default(), ImportOptions::default());
        let scene = super::super::import_from(text.into_bytes(), "a.xml", &assets, &options).unwrap();
        let MediumDesc::Homogeneous(m) = &scene.media[0].value else { panic!() };
        ([m.anisotropy, m.second_anisotropy, m.second_weight, m.rayleigh], scene.warnings.len())
    }

    fn hg(g: f64) -> String {
        format!("<phase type='hg'><float name='g' value='{g}'/></phase>")
    }

    fn blend(weight: f64, parts: [&str; 2]) -> String {
        let [first, second] = parts;
        format!("<phase type='blendphase'><float name='weight' value='{weight}'/>{first}{second}</phase>")
    }

    #[test]
    fn blends_become_two_lobes_and_rayleigh_scattering() {
        let air = "<phase type='rayleigh'/>";
        assert_eq!(read(""), ([0.0; 4], 0));
        assert_eq!(read(&hg(0.4)), ([0.4, 0.0, 0.0, 0.0], 0));
        assert_eq!(read(air), ([0.0, 0.0, 0.0, 1.0], 0));
        assert_eq!(read(&blend(0.25, [&hg(0.8), &hg(-0.5)])), ([0.8, -0.5, 0.25, 0.0], 0));
        assert_eq!(read(&blend(0.75, [&hg(0.8), &hg(-0.5)])), ([-0.5, 0.8, 0.25, 0.0], 0));
        assert_eq!(read(&blend(0.25, [air, &hg(0.5)])), ([0.5, 0.0, 0.0, 0.75], 0));
        let nested = blend(0.5, [&blend(0.5, [&hg(0.8), &hg(-0.5)]), air]);
        assert_eq!(read(&nested), ([0.8, -0.5, 0.5, 0.5], 0));
        // The smallest of three lobes joins the nearer one.
        let (three, warnings) = read(&blend(0.2, [&blend(0.5, [&hg(0.8), &hg(-0.5)]), &hg(0.5)]));
        assert_eq!((three[1], warnings), (-0.5, 1));
        assert!((three[0] - (0.4 * 0.8 + 0.2 * 0.5) / 0.6).abs() < 1e-12 && (three[2] - 0.4).abs() < 1e-12);
    }

    #[test]
    fn hostile_blends_end() {
        let deep = (0..20).fold(hg(0.5), |inner, _| blend(0.5, [&inner, &hg(0.1)]));
        assert!(read(&deep).1 > 0);
        assert_eq!(read("<phase type='blendphase'/>"), ([0.0; 4], 0));
        assert_eq!(mean_cosine(""), None);
        assert_eq!(mean_cosine("0, 0, -1"), None);
        assert!((mean_cosine("1, 1, 1").unwrap()).abs() < 1e-12);
        // Linear from 0 to 1: ∫ c (1 + c) / 2 dc = 1/3.
        assert!((mean_cosine("0,0.5,1").unwrap() - 1.0 / 3.0).abs() < 1e-12);
    }
}

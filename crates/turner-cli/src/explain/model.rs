//! The tree of rays of each sample, made from the record: text, drawing and page show it.

use turner::color::Spectrum;
use turner::math::DVec3;

use super::record::{Explanation, Sample, What};
use super::{classic, other, path};

/// The rays of one sample.
pub(super) struct SampleTree {
    /// Its index among the pixel's samples.
    pub(super) number: usize,
    /// Position in the picture, pixels.
    pub(super) pixel_position: [f64; 2],
    /// Its weight in the pixel.
    pub(super) weight: f64,
    /// The sample as rendered.
    pub(super) rendered: Spectrum,
    /// Whether the contributions sum to it to the last bit.
    pub(super) exact: bool,
    /// Parents come before their children.
    pub(super) nodes: Vec<Node>,
    /// The sum of all contributions, in the order in which they were added.
    pub(super) sum: Spectrum,
    /// The terms of the sum: index of the node, what it is, and its value.
    pub(super) parts: Vec<(usize, &'static str, Spectrum)>,
    /// Number of rays that are part of the sum, but not of the record.
    pub(super) unrecorded: u64,
    /// Remarks about the sample.
    pub(super) remarks: Vec<String>,
}

/// The trees of all samples that are shown.
pub(super) fn trees(e: &Explanation<'_>) -> Vec<SampleTree> {
    let tree = |sample: &Sample<'_>| {
        let mut out = SampleTree::new(sample);
        match &sample.what {
            What::Tree(tree) => classic::grow(&mut out, tree),
            What::Path(path) => path::grow(&mut out, path),
            What::FirstHit(first) => other::grow(&mut out, e.integrator, first),
        }
        out.add_up();
        out
    };
    e.explained.iter().map(tree).collect()
}

impl SampleTree {
    /// Without nodes, parts and remarks.
    fn new(sample: &Sample<'_>) -> SampleTree {
        SampleTree {
            number: sample.sample,
            pixel_position: sample.pixel_position,
            weight: sample.weight,
            rendered: sample.rendered,
            exact: sample.exact,
            nodes: Vec::new(),
            sum: sample.sum,
            parts: Vec::new(),
            unrecorded: 0,
            remarks: Vec::new(),
        }
    }

    /// The radiance that a ray returns: its contribution over its weight.
    pub(super) fn radiance(&self, node: &Node) -> Spectrum {
        over(node.total, node.weight)
    }

    /// The fraction of the sample that a contribution is, 0 to 1, by luminance.
    pub(super) fn fraction(&self, part: Spectrum) -> f64 {
        let fraction = f64::from(part.luminance()) / f64::from(self.sum.luminance());
        if fraction.is_finite() { fraction.clamp(0.0, 1.0) } else { 0.0 }
    }

    /// Numbers the rays, and sums the contributions of each node and its descendants.
    fn add_up(&mut self) {
        let mut rays = 0;
        for node in &mut self.nodes {
            node.total = node.contribution;
            rays += usize::from(node.kind != Kind::Shadow);
            node.badge = rays;
        }
        for i in (0..self.nodes.len()).rev() {
            let Some((parent, total)) = self.nodes.get(i).map(|n| (n.parent, n.total)) else { continue };
            if let Some(parent) = parent.and_then(|p| self.nodes.get_mut(p)) {
                parent.total += total;
            }
        }
    }
}

/// A colour divided by another per channel; 0 where the divisor is 0.
pub(super) fn over(color: Spectrum, by: Spectrum) -> Spectrum {
    let divide = |v: f32, by: f32| if by == 0.0 { 0.0 } else { v / by };
    Spectrum::new(divide(color.r, by.r), divide(color.g, by.g), divide(color.b, by.b))
}

/// The kind of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Camera,
    Reflected,
    Refracted,
    /// Sampled from a diffuse lobe, or from a phase function.
    Diffuse,
    /// Sampled from a glossy lobe.
    Glossy,
    /// Passes straight through a surface that is transparent to the path.
    Straight,
    /// A shadow ray.
    Shadow,
}

impl Kind {
    /// Its name in texts.
    pub(super) fn title(self) -> &'static str {
        match self {
            Kind::Camera => "camera ray",
            Kind::Reflected => "reflected ray",
            Kind::Refracted => "refracted ray",
            Kind::Diffuse => "diffuse sample",
            Kind::Glossy => "glossy sample",
            Kind::Straight => "transmitted ray",
            Kind::Shadow => "shadow ray",
        }
    }

    /// Its class in the style sheets.
    pub(super) fn word(self) -> &'static str {
        match self {
            Kind::Camera => "camera",
            Kind::Reflected => "reflected",
            Kind::Refracted => "refracted",
            Kind::Diffuse => "diffuse",
            Kind::Glossy => "glossy",
            Kind::Straight => "straight",
            Kind::Shadow => "shadow",
        }
    }
}

/// A ray and its hit.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub(super) parent: Option<usize>,
    pub(super) kind: Kind,
    /// Its number among the sample's rays, from 1. Shadow rays are not counted: they have the number of the ray to
    /// their surface.
    pub(super) badge: usize,
    pub(super) from: DVec3,
    pub(super) direction: DVec3,
    /// Its end; `None` if it leaves the scene.
    pub(super) to: Option<DVec3>,
    /// What it hits, or the light of a shadow ray.
    pub(super) target: String,
    /// The material there.
    pub(super) material: Option<String>,
    /// The primitive that it hits; for a shadow ray the first occluder.
    pub(super) primitive: Option<u32>,
    /// The shape of that primitive as a word.
    pub(super) shape: &'static str,
    /// Its weight in the sample: the throughput.
    pub(super) weight: Spectrum,
    /// A few words: lit, in shadow, enters, total internal reflection.
    pub(super) remark: String,
    /// False for an occluded shadow ray, which is drawn dashed.
    pub(super) open: bool,
    /// Whether it was traced.
    pub(super) traced: bool,
    /// Colour of the surface.
    pub(super) surface: Option<Spectrum>,
    /// Its contribution without its descendants. That of a shadow ray belongs to the node of its surface.
    pub(super) contribution: Spectrum,
    /// Its contribution with its descendants.
    pub(super) total: Spectrum,
    /// For shadow rays: index of the light, and its term in the local colour of the surface.
    pub(super) light: Option<(u32, Spectrum)>,
    /// Further values with their names.
    pub(super) rows: Vec<(&'static str, String)>,
    /// Whether `--path-of` selects it.
    pub(super) touches: bool,
}

impl Node {
    /// A ray without a hit.
    pub(super) fn new(kind: Kind, parent: Option<usize>, from: DVec3, direction: DVec3) -> Node {
        Node {
            parent,
            kind,
            badge: 0,
            from,
            direction,
            to: None,
            target: String::new(),
            material: None,
            primitive: None,
            shape: "object",
            weight: Spectrum::WHITE,
            remark: String::new(),
            open: true,
            traced: true,
            surface: None,
            contribution: Spectrum::BLACK,
            total: Spectrum::BLACK,
            light: None,
            rows: Vec::new(),
            touches: false,
        }
    }
}

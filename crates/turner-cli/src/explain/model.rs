//! What text and drawings have in common: a tree of rays for each sample, made from the record.

use turner::color::Spectrum;
use turner::math::DVec3;

use super::record::{Explanation, Sample, What};
use super::{classic, other, path};

/// The rays of one sample.
pub(super) struct SampleTree {
    /// Its number among the pixel's samples.
    pub(super) number: usize,
    pub(super) place: [f64; 2],
    /// Its share of the pixel.
    pub(super) weight: f64,
    /// Its colour as rendered.
    pub(super) rendered: Spectrum,
    /// Whether the parts sum to it to the last bit.
    pub(super) exact: bool,
    /// Parents come before their children.
    pub(super) nodes: Vec<Node>,
    /// The sum of all contributions, in the order in which they were added.
    pub(super) sum: Spectrum,
    /// What went into it: the number of the node, what it is, and how much.
    pub(super) parts: Vec<(usize, &'static str, Spectrum)>,
    /// Rays that are part of the sum, but not of the tree.
    pub(super) unwritten: u64,
    /// Remarks about the whole.
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
            place: sample.place,
            weight: sample.share,
            rendered: sample.rendered,
            exact: sample.exact,
            nodes: Vec::new(),
            sum: sample.sum,
            parts: Vec::new(),
            unwritten: 0,
            remarks: Vec::new(),
        }
    }

    /// The colour that a node's ray found: what it brought, over its weight.
    pub(super) fn found(&self, node: &Node) -> Spectrum {
        over(node.total, node.weight)
    }

    /// The share of the sample that a part of it is, 0 to 1, by luminance.
    pub(super) fn share(&self, part: Spectrum) -> f64 {
        let share = f64::from(part.luminance()) / f64::from(self.sum.luminance());
        if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 }
    }

    /// Numbers the rays, and fills in what each node's descendants bring together with it.
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

/// A colour divided by another; black where that is.
pub(super) fn over(color: Spectrum, by: Spectrum) -> Spectrum {
    let divide = |v: f32, by: f32| if by == 0.0 { 0.0 } else { v / by };
    Spectrum::new(divide(color.r, by.r), divide(color.g, by.g), divide(color.b, by.b))
}

/// What a ray is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Camera,
    Reflected,
    Refracted,
    /// Scattered in a random direction.
    Diffuse,
    /// The same, about a mirror direction.
    Glossy,
    /// On through what is not there for it.
    Straight,
    /// To a light.
    Shadow,
}

impl Kind {
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

/// A ray and what it found.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub(super) parent: Option<usize>,
    pub(super) kind: Kind,
    /// Its number among the sample's rays, from 1, without shadow rays; that of its surface for these.
    pub(super) badge: usize,
    pub(super) from: DVec3,
    pub(super) direction: DVec3,
    /// Where it ends; `None` where it leaves the scene.
    pub(super) to: Option<DVec3>,
    /// What it meets, or the light it goes to.
    pub(super) target: String,
    /// The material there.
    pub(super) material: Option<String>,
    /// The primitive it meets; of a shadow ray the first in its way.
    pub(super) primitive: Option<u32>,
    /// That primitive's shape, in a word.
    pub(super) shape: &'static str,
    /// Its share of the pixel.
    pub(super) weight: Spectrum,
    /// A few words: lit, in shadow, enters, total internal reflection.
    pub(super) remark: String,
    /// Whether anything arrives along it: shadow rays that are blocked, and rays that were not traced, are drawn otherwise.
    pub(super) open: bool,
    /// Whether it was traced.
    pub(super) traced: bool,
    /// Colour of the surface.
    pub(super) surface: Option<Spectrum>,
    /// What it brought by itself, and with its descendants. Shadow rays have none: what they bring is their surface's.
    pub(super) contribution: Spectrum,
    pub(super) total: Spectrum,
    /// For shadow rays: the light, and what it adds to the surface's local colour.
    pub(super) light: Option<(u32, Spectrum)>,
    /// All else: what, and how much.
    pub(super) rows: Vec<(&'static str, String)>,
    /// Whether it touches what `--path-of` asks for.
    pub(super) touches: bool,
}

impl Node {
    /// A ray of which nothing else is known.
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

//! The tree of rays of a sample: plain data for texts, drawings, pages and windows.

use crate::color::Spectrum;
use crate::math::DVec3;

use super::names::Names;
use super::number::color;
use super::replay::Replay;
use super::term::Term;
use crate::render::SampleRecord;
use crate::schema::{MaterialId, SceneError};

/// The rays of one sample.
#[derive(Clone, Debug)]
pub struct SampleTree {
    /// Its index among the pixel's samples.
    pub number: usize,
    /// Position in the picture, pixels.
    pub pixel_position: [f64; 2],
    /// Its weight in the pixel.
    pub weight: f64,
    /// The sample as rendered.
    pub rendered: Spectrum,
    /// Whether the contributions sum to it to the last bit.
    pub exact: bool,
    /// Parents come before their children.
    pub nodes: Vec<RayNode>,
    /// The sum of all contributions, in the order in which they were added.
    pub sum: Spectrum,
    /// The terms of the sum: index of the node, what it is, and its value.
    pub parts: Vec<(usize, &'static str, Spectrum)>,
    /// Number of rays that are part of the sum, but not of the record.
    pub unrecorded: u64,
    /// Remarks about the sample.
    pub remarks: Vec<String>,
}

impl SampleTree {
    /// Traces sample `number` of a pixel again and explains it.
    ///
    /// Errors: those of [`Replay::new`].
    pub fn new(names: &Names<'_>, number: usize, sample: &SampleRecord) -> Result<SampleTree, SceneError> {
        Ok(SampleTree::of(names, number, sample, &Replay::new(names.prepared, names.desc, sample)?))
    }

    /// Explains a sample that was traced again.
    pub fn of(names: &Names<'_>, number: usize, sample: &SampleRecord, replay: &Replay) -> SampleTree {
        let bits = |s: Spectrum| s.to_array().map(f32::to_bits);
        let (sum, rendered) = (replay.sum(), sample.radiance.color);
        let mut out = SampleTree {
            number,
            pixel_position: sample.place,
            weight: sample.weight,
            rendered,
            // A non-finite sample has no meaningful sum.
            exact: bits(sum) == bits(rendered) || !rendered.is_finite(),
            nodes: Vec::new(),
            sum,
            parts: Vec::new(),
            unrecorded: 0,
            remarks: Vec::new(),
        };
        replay.grow(&mut out, names);
        out.add_up();
        out
    }

    /// The radiance that a ray returns: its contribution over its weight.
    pub fn radiance(&self, node: &RayNode) -> Spectrum {
        over(node.total, node.weight)
    }

    /// The fraction of the sample that a contribution is, 0 to 1, by luminance.
    pub fn fraction(&self, part: Spectrum) -> f64 {
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
        for i in 0..self.nodes.len() {
            let parent = self.nodes.get(i).and_then(|n| n.parent);
            if let Some(parent) = parent.and_then(|p| self.nodes.get_mut(p)) {
                parent.children.push(i);
            }
        }
    }
}

/// A colour divided by another per channel; 0 where the divisor is 0.
pub fn over(color: Spectrum, by: Spectrum) -> Spectrum {
    let divide = |v: f32, by: f32| if by == 0.0 { 0.0 } else { v / by };
    Spectrum::new(divide(color.r, by.r), divide(color.g, by.g), divide(color.b, by.b))
}

/// The kind of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// From the camera.
    Camera,
    /// Mirrored at a surface.
    Reflected,
    /// Refracted, or scattered through a surface.
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
    pub fn title(self) -> &'static str {
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

    /// The same as one word.
    pub fn word(self) -> &'static str {
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
pub struct RayNode {
    /// Index of the ray that it continues; `None` for the camera ray.
    pub parent: Option<usize>,
    /// Indices of the rays that continue it and of the shadow rays from its hit.
    pub children: Vec<usize>,
    /// What sent it.
    pub kind: Kind,
    /// Its number among the sample's rays, from 1. Shadow rays are not counted: they have the number of the ray to
    /// their surface.
    pub badge: usize,
    /// Its origin.
    pub from: DVec3,
    /// Its direction, a unit vector.
    pub direction: DVec3,
    /// Length from the origin to the hit, or from the surface to the light; `None` if it is infinite.
    pub distance: Option<f64>,
    /// Shading normal at the hit.
    pub normal: Option<DVec3>,
    /// Its end; `None` if it leaves the scene.
    pub to: Option<DVec3>,
    /// What it hits, or the light of a shadow ray.
    pub target: String,
    /// The material there.
    pub material: Option<String>,
    /// The ID of that material in the description.
    pub material_id: Option<MaterialId>,
    /// The primitive that it hits; for a shadow ray the first occluder.
    pub primitive: Option<u32>,
    /// The shape of that primitive as a word.
    pub shape: &'static str,
    /// Its weight in the sample: the throughput.
    pub weight: Spectrum,
    /// A few words: lit, in shadow, enters, total internal reflection.
    pub remark: String,
    /// Why it is not traced, or why nothing continues it; `None` if it was not cut.
    pub cut: Option<String>,
    /// For shadow rays: the fraction of the light that passes; `None` if none was traced.
    pub transmittance: Option<Spectrum>,
    /// False for an occluded shadow ray, which is drawn dashed.
    pub open: bool,
    /// Whether it was traced.
    pub traced: bool,
    /// Colour of the surface.
    pub surface: Option<Spectrum>,
    /// Its contribution without its descendants. That of a shadow ray belongs to the node of its surface.
    pub contribution: Spectrum,
    /// Its contribution with its descendants.
    pub total: Spectrum,
    /// For shadow rays: index of the light, and its term in the local colour of the surface.
    pub light: Option<(u32, Spectrum)>,
    /// Further values with their names.
    pub terms: Vec<Term>,
    /// Whether the name of [`Names::path_of`] selects it.
    pub touches: bool,
}

impl RayNode {
    /// A ray without a hit.
    pub(super) fn new(kind: Kind, parent: Option<usize>, from: DVec3, direction: DVec3) -> RayNode {
        RayNode {
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
            terms: Vec::new(),
            children: Vec::new(),
            distance: None,
            normal: None,
            material_id: None,
            cut: None,
            transmittance: None,
            touches: false,
        }
    }

    /// The ray in a line of words: kind, what it hits, remark, weight and contribution.
    pub fn summary(&self) -> String {
        let mut out = format!("{} → {}", self.kind.title(), self.target);
        if let Some(material) = &self.material {
            out += &format!(" ({material})");
        }
        if !self.remark.is_empty() {
            out += &format!(", {}", self.remark);
        }
        match self.light {
            Some((_, added)) => out += &format!(", adds {}", color(added)),
            None => out += &format!(", × {} = {}", color(self.weight), color(self.total)),
        }
        out
    }

    /// Its value by name, as text.
    pub fn term(&self, name: &str) -> Option<&Term> {
        self.terms.iter().find(|t| t.name == name)
    }
}

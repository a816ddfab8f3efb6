//! Solids painted one over another: the field of HU.

use crate::surface::{Surface, ramp};
use crate::vec3::{Vec3, sub};

/// HU of the air around the patient.
pub(crate) const AIR_HU: f64 = -1000.0;
/// z of the scan's lower and upper end, mm: the patient ends there.
pub(crate) const ENDS_Z: [f64; 2] = [-130.0, 210.0];
/// Width of the ramp between tissues, mm: a scanner's blur.
pub(crate) const TISSUE_EDGE: f64 = 1.6;
/// Width of the ramp of what is small and hard: beads and lymph nodes, mm.
pub(crate) const SHARP_EDGE: f64 = 1.0;
/// Boxes are this much larger than the algebra says, mm, so that rounding never cuts a ramp off.
const BOX_MARGIN: f64 = 1e-6;

/// The part of space inside some surfaces and outside others, with one HU.
#[derive(Debug, Clone)]
pub(crate) struct Solid {
    hu: f64,
    /// What it is of, as [`crate::Phantom::structure`] says; `None`: of what it is painted over.
    structure: Option<u16>,
    edge: f64,
    inside: Vec<Surface>,
    outside: Vec<Surface>,
    /// It reaches the scan's ends and is cut off there.
    cut: bool,
    low: Vec3,
    high: Vec3,
}

impl Solid {
    /// What lies inside `surface`, with a tissue's edge: half of `hu` is reached on the surface itself.
    pub(crate) fn tissue(hu: f64, surface: Surface) -> Self {
        Self::empty(hu, TISSUE_EDGE).and(surface)
    }

    /// What lies inside `surface`, with the sharper edge.
    pub(crate) fn sharp(hu: f64, surface: Surface) -> Self {
        Self::empty(hu, SHARP_EDGE).and(surface)
    }

    fn empty(hu: f64, edge: f64) -> Self {
        Self {
            hu,
            structure: Some(0),
            edge,
            inside: Vec::new(),
            outside: Vec::new(),
            cut: false,
            low: [f64::NEG_INFINITY; 3],
            high: [f64::INFINITY; 3],
        }
    }

    /// It is a part of this structure; `None`: of what it is painted over.
    pub(crate) fn of(self, structure: Option<u16>) -> Self {
        Self { structure, ..self }
    }

    /// Only what is also inside `surface`.
    pub(crate) fn and(mut self, surface: Surface) -> Self {
        let grown = surface.grown(self.edge / 2.0);
        let (low, high) = grown.bounds();
        for i in 0..3 {
            self.low[i] = self.low[i].max(low[i] - BOX_MARGIN);
            self.high[i] = self.high[i].min(high[i] + BOX_MARGIN);
        }
        self.inside.push(grown);
        self
    }

    /// Only what is outside `surface`.
    pub(crate) fn without(mut self, surface: Surface) -> Self {
        self.outside.push(surface.grown(self.edge / 2.0));
        self
    }

    /// Only the side of the plane through `point` that `normal` (a unit vector) points away from.
    pub(crate) fn below(self, normal: Vec3, point: Vec3) -> Self {
        let offset = crate::vec3::dot(normal, point);
        self.and(Surface::HalfSpace { normal, offset })
    }

    /// Cut off at the scan's ends, where it reaches them.
    fn capped(mut self) -> Self {
        let [low, high] = [ENDS_Z[0] - self.edge / 2.0, ENDS_Z[1] + self.edge / 2.0];
        self.cut = self.low[2] < low || self.high[2] > high;
        self.low[2] = self.low[2].max(low - BOX_MARGIN);
        self.high[2] = self.high[2].min(high + BOX_MARGIN);
        self
    }

    /// The coverage that the scan's ends leave at height `z`.
    fn left_by_ends(&self, z: f64) -> f64 {
        let depth = (z - ENDS_Z[0]).min(ENDS_Z[1] - z) + self.edge / 2.0;
        // Most of a scan is far from its ends.
        if depth >= self.edge {
            1.0
        } else {
            ramp(depth, self.edge)
        }
    }

    /// Paints this solid over `value` at `p`; exactly `value` outside the box.
    pub(crate) fn paint(&self, p: Vec3, value: f64) -> f64 {
        // A NaN is in no range.
        if (0..3).any(|i| !(self.low[i]..=self.high[i]).contains(&p[i])) {
            return value;
        }
        value + (self.hu - value) * self.coverage(p)
    }

    /// What lies at `p`: this where it covers at least half, else what was there.
    pub(crate) fn structure(&self, p: Vec3, before: u16) -> u16 {
        let holds = || (0..3).all(|i| (self.low[i]..=self.high[i]).contains(&p[i]));
        match self.structure {
            Some(structure) if holds() && self.coverage(p) >= 0.5 => structure,
            _ => before,
        }
    }

    fn coverage(&self, p: Vec3) -> f64 {
        let mut coverage = if self.cut { self.left_by_ends(p[2]) } else { 1.0 };
        for surface in &self.inside {
            coverage *= surface.coverage(p, self.edge);
            if coverage == 0.0 {
                return 0.0;
            }
        }
        for surface in &self.outside {
            coverage *= 1.0 - surface.coverage(p, self.edge);
        }
        coverage
    }

    /// True where the box meets the box (`low`, `high`).
    pub(crate) fn meets(&self, low: Vec3, high: Vec3) -> bool {
        (0..3).all(|i| self.low[i] <= high[i] && self.high[i] >= low[i])
    }

    /// The indices i of 0..`count` for which `start` + i `step` may lie in the box; never too few.
    pub(crate) fn span(&self, start: Vec3, step: Vec3, count: usize) -> std::ops::Range<usize> {
        let (mut first, mut last) = (0.0_f64, count as f64);
        let (to_low, to_high) = (sub(self.low, start), sub(self.high, start));
        for i in 0..3 {
            // Where the row hardly moves along this axis, the box test of each point decides.
            if step[i].abs() < 1e-9 {
                continue;
            }
            let (a, b) = (to_low[i] / step[i], to_high[i] / step[i]);
            // A whole voxel of margin swallows the rounding of the division.
            first = first.max(a.min(b) - 1.0);
            last = last.min(a.max(b) + 2.0);
        }
        // A float below zero becomes index 0; `first` above `last` becomes an empty range.
        let last = (last as usize).min(count);
        (first as usize).min(last)..last
    }
}

/// The painting: solids in order, the later over the earlier, all cut off at the scan's ends.
#[derive(Debug, Clone, Default)]
pub(crate) struct Canvas {
    solids: Vec<Solid>,
}

impl Canvas {
    /// Paints `solid` over what is there.
    pub(crate) fn add(&mut self, solid: Solid) {
        self.solids.push(solid.capped());
    }

    /// The inside of `surface`, as tissue.
    pub(crate) fn tissue(&mut self, hu: f64, surface: Surface) {
        self.add(Solid::tissue(hu, surface));
    }

    /// Tubes along `path`, thick as told at each of its points, that are no structure.
    pub(crate) fn vessel(&mut self, hu: f64, path: &[(Vec3, f64)]) {
        self.vessel_of(Some(0), hu, path);
    }

    /// The same as a part of a structure; `None`: of what they are painted over.
    pub(crate) fn vessel_of(&mut self, structure: Option<u16>, hu: f64, path: &[(Vec3, f64)]) {
        for pair in path.windows(2) {
            let ends = [pair[0].0, pair[1].0];
            let radii = [pair[0].1, pair[1].1];
            self.add(Solid::tissue(hu, Surface::Tube { ends, radii }).of(structure));
        }
    }

    /// Bone: `surface` filled with `cortical`, and `cancellous` from `shell` mm under it on.
    pub(crate) fn bone(&mut self, [cortical, cancellous]: [f64; 2], shell: f64, surface: Surface) {
        let marrow = surface.grown(-shell);
        self.tissue(cortical, surface);
        self.tissue(cancellous, marrow);
    }

    /// The solids, in the order of painting.
    pub(crate) fn solids(&self) -> &[Solid] {
        &self.solids
    }

    /// The structure at `p`, 0 for none.
    pub(crate) fn structure(&self, p: Vec3) -> u16 {
        let solids = self.solids.iter();
        solids.fold(0, |before, solid| solid.structure(p, before))
    }

    /// HU at `p`.
    pub(crate) fn hu(&self, p: Vec3) -> f64 {
        self.solids.iter().fold(AIR_HU, |value, solid| solid.paint(p, value))
    }
}

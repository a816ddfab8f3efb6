//! The tube in its entry: it turns about it and slides through it.

use geometry::{Ct, Direction, Point, Rigid, Tool, Vector};

/// How the tube stands: two angles about the entry, and how deep it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Posture {
    /// Tangents of the angles between its axis and the planned line, towards the two directions across that line.
    pub tilt: [f64; 2],
    /// From the entry to the tip, mm.
    pub depth_mm: f64,
}

/// The planned line, and the tube that is to go along it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Way {
    entry: Point<Ct>,
    line: Direction<Ct>,
    across: [Direction<Ct>; 2],
    length_mm: f64,
    roll_rad: f64,
}

impl Way {
    /// From an entry to a target, for a tube so long from its tip to the hand, held with this roll; `None` where there
    /// is no line.
    pub fn new(entry: Point<Ct>, target: Point<Ct>, length_mm: f64, roll_rad: f64) -> Option<Self> {
        let line = (target - entry).direction()?;
        // The patient's axis that is least along the line.
        let axes = [Direction::X, Direction::Y, Direction::Z];
        let least = axes
            .into_iter()
            .min_by(|a, b| line.dot(*a).abs().total_cmp(&line.dot(*b).abs()))?;
        let first = line.cross(least).direction()?;
        Some(Self {
            entry,
            line,
            across: [first, line.cross(first).direction()?],
            length_mm,
            roll_rad,
        })
    }

    /// Where the tube enters.
    pub const fn entry(&self) -> Point<Ct> {
        self.entry
    }

    /// The tube's axis, towards the tip.
    pub fn axis(&self, posture: &Posture) -> Direction<Ct> {
        let [a, b] = posture.tilt;
        let along = self.line.vector() + self.across[0] * a + self.across[1] * b;
        along.direction().unwrap_or(self.line)
    }

    /// The tip.
    pub fn tip(&self, posture: &Posture) -> Point<Ct> {
        self.entry + self.axis(posture) * posture.depth_mm
    }

    /// The pose: tip at the origin of `Tool`, axis along its +z. `None` for a tilt without end.
    pub fn pose(&self, posture: &Posture) -> Option<Rigid<Ct, Tool>> {
        let axis = self.axis(posture);
        let (sin, cos) = self.roll_rad.sin_cos();
        let up = (self.across[0] * sin + self.across[1] * cos).direction()?;
        Rigid::from_axes(self.tip(posture), axis, up)
    }

    /// The tilt of a tube that is turned about the entry until the point `lever_mm` along its axis has moved by
    /// `beside`, mm.
    pub fn turned(&self, posture: &Posture, beside: Vector<Ct>, lever_mm: f64) -> [f64; 2] {
        let to = self.axis(posture) * lever_mm + beside;
        let along = to.dot(self.line.vector());
        self.across.map(|across| to.dot(across.vector()) / along)
    }

    /// How the hand moves from one posture to another, mm: twice across the tube, and along it. The hand is at the
    /// tube's end, which turns about the entry the other way than the tip.
    pub fn of_hand(&self, from: &Posture, to: &Posture) -> [f64; 3] {
        let outside = self.outside_mm(from);
        let across = |k: usize| (from.tilt[k] - to.tilt[k]) * outside;
        [across(0), across(1), to.depth_mm - from.depth_mm]
    }

    /// The posture that a motion of the hand leads to: the inverse of [`Way::of_hand`].
    pub fn moved(&self, from: &Posture, [a, b, along]: [f64; 3]) -> Posture {
        let outside = self.outside_mm(from);
        Posture {
            tilt: [from.tilt[0] - a / outside, from.tilt[1] - b / outside],
            depth_mm: from.depth_mm + along,
        }
    }

    /// What of the tube is outside, from the entry to the hand, mm; a hand's breadth at least.
    fn outside_mm(&self, posture: &Posture) -> f64 {
        (self.length_mm - posture.depth_mm).max(10.0)
    }
}

//! What of a display reaches the operator.

use geometry::{Ct, Direction, Point, Rigid, Tool};
use guidance::sight::{Aim, Covariance};

/// What a display is given to show: the newest pose that has come to it.
#[derive(Debug, Clone, Copy)]
pub struct Shown {
    /// The measured pose.
    pub pose: Rigid<Ct, Tool>,
    /// What it states of its error.
    pub covariance: Covariance,
    /// What is aimed at.
    pub aim: Aim,
    /// Where the tube was planned to enter.
    pub entry: Point<Ct>,
}

/// What is read off one picture at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// From the tip's place to the target's, along the picture's right and up, mm. Looking along the tube that is the
    /// miss.
    pub target_mm: [f64; 2],
    /// The tube's unit axis as the picture shows it, (right, up): short where one looks along it.
    pub axis: [f64; 2],
    /// How far there is to go, where the picture says it by itself, mm.
    pub to_go_mm: Option<f64>,
    /// How far the target's middle may be off for the tip with its error to lie in the target, mm.
    pub room_mm: f64,
    /// The picture says that the tip has arrived.
    pub is_inside: bool,
}

/// A display as a person reads it: one picture, or several that she looks at one after another.
pub trait Reader {
    /// The pictures that have something to show of the target, by number below 8. Seen without looking: a ring in a
    /// colour of its own stands out of any number of other things (Treisman and Gelade 1980).
    fn pictures(&self, shown: &Shown) -> Vec<usize>;

    /// Right and up of a picture in the patient, for a tube at `pose`: what a trained hand knows of it.
    fn axes(&self, picture: usize, pose: Rigid<Ct, Tool>) -> [Direction<Ct>; 2];

    /// What a picture says; `None` where the target is not on it.
    fn read(&mut self, picture: usize, shown: &Shown) -> Option<Reading>;

    /// How far she pushes on where no picture shows the target, mm.
    fn unseen_mm(&self, shown: &Shown) -> f64;
}

/// Right and up of a picture along the tube: up is as near to the patient's head as it can be, as on the image across
/// the tube.
pub fn upright_axes(axis: Direction<Ct>) -> [Direction<Ct>; 2] {
    let right = axis.cross(Direction::Z).direction().unwrap_or(Direction::X);
    let up = right.cross(axis).direction().unwrap_or(Direction::Z);
    [right, up]
}

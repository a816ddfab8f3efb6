//! The plan of an operation: what is aimed at, the way there, and what was measured. Made before the operation, for one examination,
//! which it names by its hash; read-only once a person has confirmed it.
//!
//! [`Editor`] changes a plan and takes changes back; [`file`](mod@file) is its text; [`Trajectory`] the numbers of a way;
//! [`concerns`] what speaks against it in the examination. All in `Ct`: patient axes LPS, mm.

mod concern;
mod editor;
mod error;
pub mod file;
mod trajectory;

pub use concern::{Concern, DENSE_HU, Hu, What, concerns};
pub use editor::{Edit, Editor};
pub use error::PlanError;
pub use trajectory::Trajectory;

use geometry::{Ct, Point};

use crate::workflow::VolumeId;

/// Most targets of a plan.
pub const MAX_TARGETS: usize = 64;
/// Most distances and angles.
pub const MAX_MEASURES: usize = 32;
/// Most bytes of a target's name.
pub const MAX_NAME: usize = 40;
/// Most bytes of the notes.
pub const MAX_NOTES: usize = 4096;
/// Most bytes of the words that say who confirmed it.
pub const MAX_WHO: usize = 64;
/// Most bytes of a time, RFC 3339.
pub const MAX_TIME: usize = 24;
/// No coordinate is larger, mm.
pub const MAX_MM: f64 = 1e4;

/// A target and the way to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// For people: 1 to [`MAX_NAME`] bytes without control characters, and no other target's.
    pub name: String,
    /// Its centre.
    pub centre: Point<Ct>,
    /// Its diameter, 0.1 to 200 mm.
    pub diameter_mm: f64,
    /// Where the tube is to enter on its way there: farther from the centre than the tip is to stop.
    pub entry: Option<Point<Ct>>,
    /// How far before the centre the tip is to stop, 0 to 500 mm.
    pub stop_mm: f64,
}

/// What was measured on the images.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Measure {
    /// Between two points.
    Distance([Point<Ct>; 2]),
    /// At the second of three points, between the other two.
    Angle([Point<Ct>; 3]),
}

/// A person has said that the plan is to be followed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Confirmed {
    /// Who, in her own words.
    pub by: String,
    /// When, as [`file`](mod@file) writes times.
    pub at: String,
}

/// A plan. Everything in it was checked; see [`Plan::checked`].
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// The examination that it was made for.
    pub volume: VolumeId,
    /// In the order in which they were made.
    pub targets: Vec<Target>,
    /// In the order in which they were made.
    pub measures: Vec<Measure>,
    /// For people.
    pub notes: String,
    /// Nothing changes after this.
    pub confirmed: Option<Confirmed>,
}

impl Plan {
    /// Of this examination, with nothing in it.
    pub fn new(volume: VolumeId) -> Self {
        Self {
            volume,
            targets: Vec::new(),
            measures: Vec::new(),
            notes: String::new(),
            confirmed: None,
        }
    }

    /// The target of this name.
    pub fn target(&self, name: &str) -> Option<&Target> {
        self.targets.iter().find(|target| target.name == name)
    }

    /// The same, each part of it within its domain.
    ///
    /// # Errors
    /// [`PlanError`], of the first part that is not.
    pub fn checked(self) -> Result<Self, PlanError> {
        at_most("targets", self.targets.len(), MAX_TARGETS)?;
        at_most("measures", self.measures.len(), MAX_MEASURES)?;
        at_most("bytes of notes", self.notes.len(), MAX_NOTES)?;
        for (i, target) in self.targets.iter().enumerate() {
            target.check()?;
            if self.targets[..i].iter().any(|other| other.name == target.name) {
                return Err(PlanError::NameTaken(target.name.clone()));
            }
        }
        self.measures.iter().try_for_each(Measure::check)?;
        if let Some(confirmed) = &self.confirmed {
            check_words("the name of who confirmed it", &confirmed.by, MAX_WHO)?;
            check_words("the time of its confirmation", &confirmed.at, MAX_TIME)?;
        }
        Ok(self)
    }
}

impl Target {
    /// Refuses what is outside the domain of its part.
    pub(crate) fn check(&self) -> Result<(), PlanError> {
        check_words("the target's name", &self.name, MAX_NAME)?;
        let of = |what| format!("{what} of {}", self.name);
        point(|| of("centre"), self.centre)?;
        number(|| of("diameter"), self.diameter_mm, 0.1, 200.0)?;
        number(|| of("stop distance"), self.stop_mm, 0.0, 500.0)?;
        let Some(entry) = self.entry else { return Ok(()) };
        point(|| of("entry"), entry)?;
        let way_mm = entry.distance(self.centre);
        // A tube that stops where it enters has no direction.
        if way_mm <= self.stop_mm + SHORTEST_MM {
            return Err(PlanError::NoWay {
                name: self.name.clone(),
                way_mm,
                least_mm: self.stop_mm + SHORTEST_MM,
            });
        }
        Ok(())
    }
}

/// The shortest way of a tube, mm: its direction is then good to the accuracy with which a person points.
pub const SHORTEST_MM: f64 = 1.0;

impl Measure {
    /// Its points.
    pub fn points(&self) -> &[Point<Ct>] {
        match self {
            Self::Distance(points) => points,
            Self::Angle(points) => points,
        }
    }

    /// The distance, mm; of an angle `None`.
    pub fn distance_mm(&self) -> Option<f64> {
        match self {
            Self::Distance([a, b]) => Some(a.distance(*b)),
            Self::Angle(_) => None,
        }
    }

    /// The angle, 0 to pi, rad; of a distance, or where two of the points lie together, `None`. Near 0 and pi, too, it is good to a few
    /// roundings, as it comes from the arc tangent of sine and cosine.
    pub fn angle_rad(&self) -> Option<f64> {
        let Self::Angle([a, b, c]) = self else { return None };
        let (u, v) = ((*a - *b).direction()?, (*c - *b).direction()?);
        Some(u.cross(v).norm().atan2(u.dot(v)))
    }

    fn check(&self) -> Result<(), PlanError> {
        self.points()
            .iter()
            .try_for_each(|p| point(|| "a measured point".to_owned(), *p))
    }
}

fn at_most(what: &'static str, found: usize, most: usize) -> Result<(), PlanError> {
    match found <= most {
        true => Ok(()),
        false => Err(PlanError::TooMany { what, found, most }),
    }
}

/// Words that go over the bus in fields of fixed length, and onto a screen in one line.
fn check_words(what: &'static str, words: &str, most: usize) -> Result<(), PlanError> {
    let found = words.len();
    match found == 0 || found > most || words.trim() != words || words.contains(is_unseen) {
        true => Err(PlanError::Words {
            what,
            found: words.chars().take(64).collect(),
            most,
        }),
        false => Ok(()),
    }
}

/// Control characters, and those that change how others are read, or are not seen at all: two names would look alike.
fn is_unseen(letter: char) -> bool {
    let is_format = matches!(letter, '\u{ad}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}');
    letter.is_control() || is_format
}

fn number(what: impl Fn() -> String, found: f64, least: f64, most: f64) -> Result<(), PlanError> {
    match (least..=most).contains(&found) {
        true => Ok(()),
        false => Err(PlanError::Number {
            what: what(),
            found,
            least,
            most,
        }),
    }
}

fn point(what: impl Fn() -> String, p: Point<Ct>) -> Result<(), PlanError> {
    p.mm().iter().try_for_each(|x| number(&what, *x, -MAX_MM, MAX_MM))
}

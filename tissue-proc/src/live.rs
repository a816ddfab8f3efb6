//! The organs' state for one pose after the other.

use geometry::{Ct, Model, Point, Rigid, Tool};
use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use organs::{Meeting, Meetings};
use simulation::space::frames::{Frame, Refused, State, Together};
use simulation::space::tube::{Tube, TubeError};

/// A tube that was elsewhere is walked to its pose through tissue over no longer a way, mm: how it came there nobody saw.
pub(crate) const MOST_WALKED_MM: f64 = 30.0;

/// Names in words about organs are cut after so many bytes: what is told of a pose has room for 160.
const NAME: usize = 44;

/// Two organs that have come into one another.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Met {
    names: [String; 2],
    /// mm; below 0 where they are apart by so much.
    depth: f64,
}

impl Met {
    pub(crate) fn new(names: [&str; 2], depth: f64) -> Self {
        let cut = |name: &str| name[..name.floor_char_boundary(NAME)].to_owned();
        Self {
            names: names.map(cut),
            depth,
        }
    }

    /// In words, of organs that nothing has moved.
    pub(crate) fn at_rest(&self) -> String {
        let [one, other] = &self.names;
        match self.depth > 0.0 {
            true => format!(
                "organs {one} and {other} lie {:.2} mm in one another at rest",
                self.depth
            ),
            false => format!("organs {one} and {other} touch at rest"),
        }
    }
}

impl std::fmt::Display for Met {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [one, other] = &self.names;
        let depth = self.depth;
        write!(
            f,
            "organs {one} and {other} lie {depth:.2} mm in one another, which the model does not bear"
        )
    }
}

/// What became of a pose.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Answer {
    /// A state, at the pose or on the way to it.
    State(Frame),
    /// There is none: see [`Refused`].
    Refused(Refused),
    /// Organs would lie in one another, and nothing in the model keeps them apart.
    Met(Met),
    /// The tube lies in tissue, and nobody knows how it came there: it was far off, its way was not seen, or poses rest on another registration.
    Unseen {
        /// From where it was, mm.
        way: f64,
    },
}

impl Answer {
    /// Why there is no state, in words.
    pub(crate) fn why(&self) -> Option<String> {
        match self {
            Self::State(_) => None,
            Self::Refused(why) => Some(why.to_string()),
            Self::Met(met) => Some(met.to_string()),
            Self::Unseen { way } => Some(format!(
                "in tissue by a way that nobody saw, {way:.0} mm from where it was last, draw it back"
            )),
        }
    }
}

/// Organs and the tube.
#[derive(Debug)]
pub(crate) struct Live {
    pub(crate) frames: Together,
    /// What tells whether organs lie in one another, and their names.
    meetings: (Meetings, Vec<String>),
    ct_from_model: Rigid<Ct, Model>,
    /// From the tool's frame, whose origin is the foremost point, to the middle of the round tip, mm along z.
    radius: f64,
    /// Nobody knows how the tube came to where it is in tissue, or whether it does: until it is seen where it touches none.
    unseen: bool,
    /// What the pose before rested on.
    registration_id: Option<u64>,
}

/// The scene's tube in a frame of its own: the middle of its round tip is the origin, and the handle is along -z.
///
/// # Errors
/// [`TubeError`], of numbers that no checked scene has.
pub(crate) fn tube(diameter_mm: f64, length_mm: f64, pose: Isometry3<f64>) -> Result<Tube, TubeError> {
    let radius = 0.5 * diameter_mm;
    let handle = Point3::new(0.0, 0.0, -(length_mm - radius).max(0.0));
    Tube::new(pose, &[Point3::origin(), handle], &[radius; 2])
}

/// The pose of that tube with its foremost point at `tip`, pushed along `direction`, of length 1.
pub(crate) fn pose_at(tip: &Vector3<f64>, direction: &Vector3<f64>, radius: f64) -> Isometry3<f64> {
    // Straight on or straight back: any half turn will do.
    let turn = UnitQuaternion::rotation_between(&Vector3::z(), direction)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
    Isometry3::from_parts(Translation3::from(tip - direction * radius), turn)
}

impl Live {
    pub(crate) fn new(frames: Together, ct_from_model: Rigid<Ct, Model>, meetings: (Meetings, Vec<String>)) -> Self {
        let radius = frames.tube().least_radius();
        Self {
            frames,
            meetings,
            ct_from_model,
            radius,
            unseen: true,
            registration_id: None,
        }
    }

    /// Whether a pose rests on another registration or calibration than the one before it. What lies between the two is then no way of the tube
    /// in the organ: until the tube touches none, nobody knows how it came to where it is.
    pub(crate) fn is_of_another(&mut self, registration_id: u64) -> bool {
        let before = self.registration_id.replace(registration_id);
        let is_another = before.is_some_and(|before| before != registration_id);
        self.unseen |= is_another;
        is_another
    }

    /// The pose of the tube in the model's frame.
    pub(crate) fn pose(&self, ct_from_tool: Rigid<Ct, Tool>) -> Isometry3<f64> {
        let model_from_tool = self.ct_from_model.inverse() * ct_from_tool;
        let [w, x, y, z] = model_from_tool.quaternion();
        let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        let tip = Vector3::from(model_from_tool.translation_mm());
        Isometry3::from_parts(Translation3::from(tip - turn * Vector3::z() * self.radius), turn)
    }

    /// The state for a pose.
    pub(crate) fn answer(&mut self, ct_from_tool: Rigid<Ct, Tool>) -> Answer {
        let pose = self.pose(ct_from_tool);
        let way = self.frames.way_to(&pose);
        self.unseen |= way > MOST_WALKED_MM;
        // Where the tube presses, or pressed when it was last seen, it may have pushed the organ along to beyond its own place: there the organ
        // is at rest only if the tube has left it as it is now, too.
        let may_rest = self.frames.is_free() || (self.unseen && self.frames.is_clear_now(&pose));
        if may_rest && let Some(frame) = self.frames.rest(&pose) {
            self.unseen = false;
            return Answer::State(frame);
        }
        if self.unseen {
            return Answer::Unseen { way };
        }
        let (meetings, names) = &self.meetings;
        let (mut met, before) = (None, self.frames.state().to_vec());
        // A state in which organs lie in one another is none to go on from either, nor one behind such: they would have pushed one another
        // elsewhere.
        let frame = self.frames.frame_where(&pose, |bodies, a| {
            met = meetings.deepest_between(bodies, &before, a);
            met.is_none()
        });
        match (frame.state, met) {
            (State::Refused(_), Some(Meeting { organs, depth })) => {
                Answer::Met(Met::new(organs.map(|k| names[k].as_str()), depth))
            }
            (State::Refused(why), None) => Answer::Refused(why),
            _ => Answer::State(frame),
        }
    }

    /// A place of the patient in the model's frame, mm.
    pub(crate) fn own(&self, place: Point<Ct>) -> [f64; 3] {
        (self.ct_from_model.inverse() * place).mm()
    }

    /// What a vector of the model's axes is in the CT's.
    pub(crate) fn turned(&self, vector: &Vector3<f64>) -> [f64; 3] {
        let moved = self.ct_from_model * geometry::Vector::<Model>::new(vector.x, vector.y, vector.z);
        moved.mm()
    }

    /// The moment about the foremost point of the tube, from that about the middle of its tip, in the CT's axes.
    pub(crate) fn moment_about_tip(&self, frame: &Frame) -> [f64; 3] {
        let forward = self.frames.tube().pose().rotation * Vector3::z() * self.radius;
        self.turned(&(frame.force.moment - forward.cross(&frame.force.force)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is told of a pose has room for 160 bytes: of long names the depth was lost first.
    #[test]
    fn organs_of_long_names_are_told_with_how_deep_they_are() {
        let names = ["\u{e4}".repeat(64), "kidney of the left side ".repeat(2)];
        let met = Met::new([&names[0], &names[1]], 12.345).to_string();
        assert!(
            met.len() <= 160 && met.ends_with("12.35 mm in one another, which the model does not bear"),
            "{met}"
        );
        assert!(
            met.contains("organs \u{e4}\u{e4}") && met.contains(" and kidney of the left side kidney"),
            "{met}"
        );
        let touch = Met::new(["a", "b"], -0.02).at_rest();
        assert_eq!(touch, "organs a and b touch at rest");
    }
}

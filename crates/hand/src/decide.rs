//! What the operator does about what she has seen.

use crate::human::Human;
use crate::reader::Reading;

/// What a look leaves: the means of what was shown meanwhile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Percept {
    /// See [`Reading::target_mm`].
    pub target_mm: [f64; 2],
    /// See [`Reading::axis`].
    pub axis: [f64; 2],
    /// See [`Reading::to_go_mm`].
    pub to_go_mm: Option<f64>,
    /// See [`Reading::room_mm`].
    pub room_mm: f64,
    /// In most of the frames the picture said that the tip has arrived.
    pub is_inside: bool,
}

/// What she does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Act {
    /// Nothing that this picture would ask for.
    Leave,
    /// One stroke: the axis is turned until it lies `beside_mm` (right, up of the picture) further at the target, and
    /// the tube is pushed by `push_mm`.
    Stroke {
        /// Along right and up of the picture, mm.
        beside_mm: [f64; 2],
        /// How far the target is, where the picture says so, mm.
        ahead_mm: Option<f64>,
        /// Along the tube, mm.
        push_mm: f64,
    },
}

/// Below this length of the drawn unit axis a picture looks along the tube rather than across it: depth is not read
/// there.
const END_ON: f64 = 0.5;

impl Percept {
    /// Of the readings of one look; `None` where none was had.
    pub fn of(readings: &[Reading]) -> Option<Self> {
        let (first, count) = (readings.first()?, readings.len() as f64);
        let mean = |of: &dyn Fn(&Reading) -> f64| readings.iter().map(of).sum::<f64>() / count;
        let inside = readings.iter().filter(|reading| reading.is_inside).count();
        Some(Self {
            target_mm: [mean(&|r| r.target_mm[0]), mean(&|r| r.target_mm[1])],
            axis: [mean(&|r| r.axis[0]), mean(&|r| r.axis[1])],
            to_go_mm: first.to_go_mm.map(|_| mean(&|r| r.to_go_mm.unwrap_or(0.0))),
            room_mm: mean(&|r| r.room_mm),
            is_inside: 2 * inside > readings.len(),
        })
    }

    /// How far the target is along the tube, mm; `None` on a picture that looks along it and does not say.
    pub fn ahead_mm(&self) -> Option<f64> {
        let square = dot(self.axis, self.axis);
        // The drawn axis is short by the same part as the way along it.
        let along = (square.sqrt() >= END_ON).then(|| dot(self.target_mm, self.axis) / square);
        self.to_go_mm.or(along)
    }

    /// What the picture shows of the miss: all where it looks along the tube, else what lies across the drawn axis, mm
    /// (right, up).
    pub fn beside_mm(&self) -> [f64; 2] {
        let square = dot(self.axis, self.axis);
        if square.sqrt() < END_ON {
            return self.target_mm;
        }
        let along = dot(self.target_mm, self.axis) / square;
        [0, 1].map(|k| self.target_mm[k] - along * self.axis[k])
    }

    /// Whether she is content: the picture says that the tip has arrived, and shows it no further off than she puts up
    /// with.
    pub fn is_arrived(&self, human: &Human) -> bool {
        let [x, y] = self.beside_mm();
        self.is_inside && x.hypot(y).hypot(self.ahead_mm().unwrap_or(0.0)) <= human.content_mm
    }

    /// Whether the tube points at the target, as far as this picture tells: the axis goes through the target, or passes
    /// under a small angle.
    pub fn is_aligned(&self, human: &Human, radius_mm: f64) -> bool {
        let [x, y] = self.beside_mm();
        let ahead = self.ahead_mm().unwrap_or(0.0);
        x.hypot(y) <= radius_mm.max(ahead * human.align_rad.tan())
    }
}

/// What she does about what she sees in one picture; `may_push` where every other picture that shows the target has
/// been found aligned.
pub fn decide(seen: &Percept, human: &Human, radius_mm: f64, may_push: bool) -> Act {
    let beside_mm = seen.beside_mm();
    let ahead_mm = seen.ahead_mm();
    let stroke = |push_mm: f64| Act::Stroke {
        beside_mm,
        ahead_mm,
        push_mm,
    };
    if seen.is_arrived(human) {
        return Act::Leave;
    }
    match ahead_mm {
        _ if !seen.is_aligned(human, radius_mm) => stroke(0.0),
        Some(ahead) if may_push => stroke(human.caution() * ahead),
        _ if beside_mm[0].hypot(beside_mm[1]) > seen.room_mm.min(human.content_mm) => stroke(0.0),
        _ => Act::Leave,
    }
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

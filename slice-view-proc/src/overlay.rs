//! What is drawn over the slice: tube, tip and the path ahead, the plan, the other planes, targets, letters, scale, words.

mod cuts;
mod layout;
mod ruler;
mod shapes;
mod tissue;
mod tube;
mod way;
mod words;

use bus::message::{Chosen, Lost, Marks};
use bus::run::ReplayOf;
use geometry::{Ct, Rigid, SlicePlane, Tool};
use picture::{Canvas, Rgb, palette};
use scene::{Plane, Target, ToolSpec, View};

use crate::accuracy::Accuracy;
use crate::tissue::Tissues;

pub use shapes::NEAR_PLANE_MM;
pub(crate) use tissue::covered_twice;
pub(crate) use words::SMALLEST_WITH_WORDS;

/// What the image claims about the present.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Notice {
    /// The pose is young.
    Live,
    /// The pose was asked for and not just measured.
    Requested,
    /// The plane was asked for, and follows no pose.
    Look,
    /// The pose is this old, ns.
    Stale(i64),
    /// There is no pose; the slice shown, if any, is of a pose this old, ns.
    Lost(Lost, Option<i64>),
}

/// Where poses come from, as far as images must say it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// The tracker, now.
    Tracker,
    /// A recording, made in the examination that is shown.
    Recording,
    /// A recording made in another examination: tube and anatomy do not belong together.
    RecordingOfAnother,
    /// A recording that does not say in which examination it was made.
    RecordingOfUnknown,
    /// The tracker, in simulated time: not the present.
    SimulatedTime,
}

impl Origin {
    /// Of a run that shows the examination with the hash `shown`: of its tracker, or of the recording that it replays.
    pub(crate) fn of(replay: Option<&ReplayOf>, shown: &str) -> Self {
        match replay.map(|replay| replay.volume_hash.as_deref()) {
            None => Self::Tracker,
            Some(None) => Self::RecordingOfUnknown,
            Some(Some(recorded)) if recorded == shown => Self::Recording,
            Some(Some(_)) => Self::RecordingOfAnother,
        }
    }

    /// As stamps say it.
    pub const fn code(self) -> u32 {
        match self {
            Self::Tracker => 0,
            Self::Recording | Self::RecordingOfAnother | Self::RecordingOfUnknown => 1,
            Self::SimulatedTime => 2,
        }
    }

    /// What whatever moves says in the place of LIVE.
    fn word(self) -> &'static str {
        match self {
            Self::Tracker => "LIVE",
            Self::Recording | Self::RecordingOfAnother | Self::RecordingOfUnknown => "REPLAY",
            Self::SimulatedTime => "SIMULATED TIME",
        }
    }

    /// What every image says, also a held one.
    fn warning(self) -> &'static str {
        match self {
            Self::Tracker | Self::Recording | Self::SimulatedTime => "",
            Self::RecordingOfAnother => "NOT THE EXAMINATION OF THE RECORDING",
            Self::RecordingOfUnknown => "EXAMINATION NOT VERIFIED",
        }
    }
}

/// Everything that is drawn over one slice.
#[derive(Debug, Clone, Copy)]
pub struct Overlay<'a> {
    /// The image.
    pub view: &'a View,
    /// Its plane.
    pub plane: &'a SlicePlane,
    /// Whether a pose or a request placed it; else there is no slice, and nothing is said of where it lies.
    pub is_placed: bool,
    /// All images of the scene: where their planes cut this one is drawn.
    pub views: &'a [View],
    /// The tool, drawn where there is a valid pose.
    pub pose: Option<Rigid<Ct, Tool>>,
    /// How good that pose is; `None` says nothing of it.
    pub accuracy: Option<Accuracy>,
    /// Whether its tip is outside the examination.
    pub outside: bool,
    /// What a person must be told besides, each an alarm.
    pub remarks: &'a [&'a str],
    /// Its shape.
    pub tool: &'a ToolSpec,
    /// The targets.
    pub targets: &'a [Target],
    /// The one that a person chose: told from the others by a second ring, and its distance stands on the image.
    pub chosen: Option<&'a Chosen>,
    /// What the image claims.
    pub notice: Notice,
    /// Where the pose comes from.
    pub origin: Origin,
    /// Sequence number of the pose.
    pub seq: u64,
    /// The registration.
    pub registration_id: u64,
    /// First bytes of the volume's hash, as hex.
    pub volume: &'a str,
    /// What every image of it must say.
    pub marks: Marks,
    /// What the back end that sampled it has to say, see [`Resampler::caution`](crate::reslice::Resampler::caution).
    pub caution: &'a str,
    /// What is shown of the tissue.
    pub tissue: Tissues<'a>,
}

impl Overlay<'_> {
    /// Draws it all: frames first, so that no word is covered. An image with a side below 192 pixels has frames and
    /// lines only.
    pub fn draw(&self, canvas: &mut Canvas) {
        // On a surface they are solids, drawn with it.
        if !self.is_surface() {
            self.draw_cuts(canvas);
            self.draw_planned(canvas);
            self.draw_outlines(canvas);
        }
        self.ring_chosen(canvas);
        if let Some(pose) = self.pose {
            self.tube(canvas, pose);
        }
        self.model_frame(canvas);
        self.wordless_frame(canvas);
        if let Some((colour, width)) = self.frame() {
            canvas.border(colour, width);
        }
        if !self.has_words() {
            return;
        }
        let words = self.words();
        if words.scale {
            self.draw_scale(canvas);
        }
        let inset = 5.0 * self.unit();
        let width = f64::from(canvas.width());
        for band in &words.bands {
            canvas.fill([inset, band.top], [width - 2.0 * inset, band.height], palette::RIM, 200);
        }
        for word in &words.layout.placed {
            canvas.text(word.at, &word.text, word.size, word.colour, word.anchor);
        }
    }

    /// An overview, and no slice: nothing is measured on it, and no figure stands on it.
    fn is_surface(&self) -> bool {
        self.view.plane == Plane::Surface
    }

    /// Lines are meant for 512 pixels and follow the image.
    fn unit(&self) -> f64 {
        let shorter = self.view.size[0].min(self.view.size[1]);
        (f64::from(shorter) / 512.0).clamp(0.4, 3.0)
    }

    /// Whatever moves in a replay says so, so that nobody takes it for the present: a frame and a word in a colour that
    /// nothing else has. A held image claims nothing of the present, and is the same bytes as in the run that was recorded.
    fn is_moving_replay(&self) -> bool {
        self.origin != Origin::Tracker && !matches!(self.notice, Notice::Requested | Notice::Look)
    }

    /// The frame around the image: colour and width, pixels.
    fn frame(&self) -> Option<(Rgb, f64)> {
        // Where there are no words, the frame alone says that something is amiss.
        let wordless = !self.has_words();
        let colour = match self.notice {
            Notice::Lost(..) => palette::ALARM,
            _ if wordless && !self.origin.warning().is_empty() => palette::ALARM,
            Notice::Stale(_) => palette::WARN,
            Notice::Look if wordless => palette::WARN,
            _ if self.is_moving_replay() => palette::REPLAY,
            _ if self.tissue_alarm().or(self.covered_twice_words()).is_some() => palette::WARN,
            _ if !self.remarks.is_empty() || (wordless && self.outside) => palette::WARN,
            _ => return None,
        };
        Some((colour, 5.0 * self.unit()))
    }
}

#[cfg(test)]
mod cost_tests;
#[cfg(test)]
mod geometry_tests;
#[cfg(test)]
mod moved_tests;
#[cfg(test)]
mod placement_tests;
#[cfg(test)]
mod tests;

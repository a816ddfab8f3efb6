//! What a run's poses come from, as every client must be told: a replay or a simulation must not look like the present.

use bus::run::RunContext;
use igtl::DeviceName;
use scene::{Scene, TrackerSource};

/// Where poses come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Origin {
    /// A localizer, or a program that stands for one.
    Localizer,
    /// The tracker makes them up, in the present.
    SimulatedTracker,
    /// A file of poses, played in the present.
    Sequence,
    /// Time itself is made up.
    SimulatedTime,
    /// A recording.
    Replay,
}

impl Origin {
    /// Of a run.
    pub(crate) fn of(run: &RunContext, scene: &Scene) -> Self {
        if run.replay.is_some() {
            return Self::Replay;
        }
        if run.simulated_time {
            return Self::SimulatedTime;
        }
        match scene.tracker.source {
            TrackerSource::Simulated(_) | TrackerSource::OperatingRoom(_) => Self::SimulatedTracker,
            TrackerSource::Sequence(_) => Self::Sequence,
            TrackerSource::Emitters(_) | TrackerSource::Markers(_) | TrackerSource::External => Self::Localizer,
        }
    }

    /// Whether poses are of the present.
    pub(crate) const fn is_present(self) -> bool {
        !matches!(self, Self::Replay | Self::SimulatedTime)
    }

    /// In words, for every status; empty where there is nothing to say.
    pub(crate) const fn words(self) -> &'static str {
        match self {
            Self::Localizer => "",
            Self::SimulatedTracker => "SIMULATED TRACKER",
            Self::Sequence => "TRACKER PLAYS A FILE",
            Self::SimulatedTime => "SIMULATED TIME, NOT LIVE",
            Self::Replay => "REPLAY, NOT LIVE",
        }
    }

    /// The same for metadata.
    pub(crate) const fn session(self) -> &'static str {
        match self {
            Self::Localizer => "LIVE",
            other => other.words(),
        }
    }

    /// The device of the tool's pose in the patient. A client of version 1 reads no metadata, and a program that was set up for the tool
    /// of a live run must not follow a recording: where poses are not of the present, the device has another name.
    pub(crate) fn tool(self) -> DeviceName {
        let name = match self {
            Self::Replay => "ReplayToolToRas",
            Self::SimulatedTime => "SimulatedToolToRas",
            Self::Localizer | Self::SimulatedTracker | Self::Sequence => "ToolToRas",
        };
        DeviceName::new(name).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Origin; 5] = [
        Origin::Localizer,
        Origin::SimulatedTracker,
        Origin::Sequence,
        Origin::SimulatedTime,
        Origin::Replay,
    ];

    #[test]
    fn what_is_not_of_the_present_has_another_device_and_words() {
        for origin in ALL {
            assert_eq!(origin.tool() == "ToolToRas", origin.is_present(), "{origin:?}");
            assert!(!origin.tool().is_empty());
            let says = origin.words().contains("NOT LIVE");
            assert_eq!(says, !origin.is_present());
            assert_eq!(origin.session() == "LIVE", origin == Origin::Localizer);
        }
    }
}

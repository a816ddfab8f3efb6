//! How far the run has come: feeds the workflow with facts and with what a person says.

use bus::message::{Lost, ToolPose, Tracked, VolumeHash};
use guidance::workflow::{Action, Event, Rules, Stage, State, VolumeId, step};

use super::identity;

/// Nobody tells the pilot of a check yet: the age of one that never was.
const NEVER_NS: i64 = i64::MAX;

/// The workflow's state, and what it is fed with.
#[derive(Debug)]
pub(super) struct Progress {
    state: State,
    /// A pose that is older is none.
    lost_ns: i64,
    /// When the newest valid pose was captured.
    seen_ns: Option<i64>,
    /// A person has ended the navigation: it does not start by itself again.
    rests: bool,
    /// For the log.
    said: Vec<String>,
}

impl Progress {
    /// An empty run.
    pub(super) fn new(rules: Rules, lost_ns: i64) -> Self {
        Self {
            state: State::new(rules),
            lost_ns,
            seen_ns: None,
            rests: false,
            said: Vec::new(),
        }
    }

    pub(super) fn state(&self) -> &State {
        &self.state
    }

    /// What happened since the last call, in words.
    pub(super) fn take_said(&mut self) -> Vec<String> {
        std::mem::take(&mut self.said)
    }

    /// The run's examination is in memory.
    pub(super) fn volume(&mut self, hash: VolumeHash) {
        self.take(Event::VolumeLoaded {
            volume: VolumeId(hash.0),
        });
    }

    /// A sample came. A valid pose rests on a calibration and a registration; a tracker that lacks one of them publishes none.
    pub(super) fn pose(&mut self, pose: &ToolPose, tracked: &Tracked) {
        let Some(volume) = self.state.volume() else { return };
        let id = pose.registration_id;
        let calibration = |is_valid| Event::Calibration { id, is_valid };
        let registration = |is_within_gates| Event::Registration {
            id,
            volume,
            is_within_gates,
        };
        match tracked {
            Tracked::Valid(_) => {
                self.seen_ns = Some(pose.t_capture_ns);
                // Again with every pose: what comes too early is refused, and not kept.
                self.take(calibration(true));
                self.take(registration(true));
                self.start_by_itself();
                self.take(Event::ToolSeen);
            }
            Tracked::Lost(reason) => {
                match reason {
                    Lost::NotCalibrated => {
                        self.take(calibration(false));
                    }
                    // The tracker asks for the calibration first.
                    Lost::NotRegistered => {
                        self.take(calibration(true));
                        self.take(registration(false));
                    }
                    _ => {}
                }
                self.seen_ns = None;
                self.take(Event::ToolLost);
            }
        }
    }

    /// Time goes by.
    pub(super) fn turn(&mut self, now_ns: i64) {
        self.take(Event::CheckAge { age_ns: NEVER_NS });
        if self
            .seen_ns
            .is_some_and(|seen| now_ns.saturating_sub(seen) > self.lost_ns)
        {
            self.seen_ns = None;
            self.take(Event::ToolLost);
        }
    }

    /// A research run starts by itself.
    fn start_by_itself(&mut self) {
        let is_ready = matches!(self.state.stage(), Stage::Registered | Stage::Checked);
        if self.state.is_research() && is_ready && !self.rests {
            self.take(Event::Start { check_age_ns: NEVER_NS });
        }
    }

    /// A person says that the examination with this hash is the patient's.
    pub(super) fn confirm(&mut self, hash: &str) -> Result<String, String> {
        let Some(run) = self.state.volume() else {
            return Err("there is no examination yet".to_owned());
        };
        let Some(volume) = identity::volume(hash) else {
            return Err(format!(
                "{hash:?} is no hash of an examination: 64 hexadecimal digits are"
            ));
        };
        // Of another one too: whoever saw that has said nothing of the run's.
        self.take(Event::IdentityConfirmed { volume });
        let of = |volume: VolumeId| VolumeHash(volume.0).to_string();
        match volume == run {
            true => Ok(format!("confirmed: the examination {} is the patient's", of(run))),
            false => Err(format!(
                "the run's examination is {}: what was confirmed is another, {}, and nobody has confirmed the run's",
                of(run),
                of(volume)
            )),
        }
    }

    /// A person says that it is not.
    pub(super) fn reject(&mut self) -> Result<String, String> {
        match self.state.volume() {
            None => Err("there is no examination yet".to_owned()),
            Some(volume) => {
                self.take(Event::IdentityRejected);
                let hash = VolumeHash(volume.0);
                Ok(format!("rejected: the examination {hash} is not the patient's"))
            }
        }
    }

    /// A person starts the navigation.
    pub(super) fn navigate(&mut self) -> Result<String, String> {
        let actions = self.take(Event::Start { check_age_ns: NEVER_NS });
        match self.state.stage() {
            Stage::Navigating => {
                self.rests = false;
                Ok("navigating".to_owned())
            }
            stage => Err(format!("the run is {}: {}", stage.word(), why(&actions))),
        }
    }

    /// A person ends it.
    pub(super) fn rest(&mut self) -> Result<String, String> {
        match self.state.stage() {
            Stage::Navigating => {
                self.rests = true;
                self.take(Event::Stop);
                Ok("the navigation rests".to_owned())
            }
            stage => Err(format!("the run is {} and does not navigate", stage.word())),
        }
    }

    fn take(&mut self, event: Event) -> Vec<Action> {
        let (next, actions) = step(self.state, event);
        if next.stage() != self.state.stage() {
            let why = why(&actions);
            let because = if why.is_empty() {
                String::new()
            } else {
                format!(": {why}")
            };
            self.said.push(format!("stage {}{because}", next.stage().word()));
        }
        self.state = next;
        actions
    }
}

/// Why something was refused or taken back, in words; empty where it was not.
fn why(actions: &[Action]) -> &'static str {
    let said = actions.iter().find_map(|action| match action {
        Action::Say(why) => Some(why.words()),
        _ => None,
    });
    said.unwrap_or_default()
}

#[cfg(test)]
mod tests;

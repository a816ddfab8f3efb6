//! How far the run has come: feeds the workflow with facts and with what a person says.

use bus::message::{Command, Lost, ToolPose, Tracked, VolumeHash};
use guidance::workflow::{Action, Check, Event, Rules, Stage, State, VolumeId, step};
use serde::Serialize;

use super::identity;

/// The age of a check that never was.
const NEVER_NS: i64 = i64::MAX;
/// What is further ahead is from the future, and not read a moment earlier by another process.
const CLOCKS_NS: i64 = 5_000_000;

/// The last check of the registration in use.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Checked {
    /// The largest distance of a touched point from its place, mm.
    pub(super) worst_mm: f64,
    /// How many points were touched.
    pub(super) points: u32,
    /// When the first of them was, ns on the session's clock.
    pub(super) t_ns: i64,
    registration_id: u64,
}

/// The last check of a run, for its report.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct CheckReport {
    /// As poses bear it.
    registration_id: String,
    points: u32,
    worst_mm: f64,
    pub(super) passed: bool,
    /// What `calib` said against the registration; `null`: nothing.
    pub(super) warning: Option<String>,
}

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
    checked: Option<Checked>,
    report: Option<CheckReport>,
    /// When a person said last that the marker on the patient was moved, ns on the session's clock, and how often she did.
    bumped: (Option<i64>, u32),
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
            checked: None,
            report: None,
            bumped: (None, 0),
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
                // What was checked is another registration than what is in use.
                self.checked = self.checked.filter(|checked| checked.registration_id == id);
                self.seen_ns = Some(pose.t_capture_ns);
                // Again with every pose: what comes too early is refused, and not kept.
                self.take(calibration(true));
                self.take(registration(true));
                self.start_by_itself(pose.t_capture_ns);
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
        self.take(Event::CheckAge {
            age_ns: self.check_age_ns(now_ns),
        });
        if self
            .seen_ns
            .is_some_and(|seen| now_ns.saturating_sub(seen) > self.lost_ns)
        {
            self.seen_ns = None;
            self.take(Event::ToolLost);
        }
    }

    /// A research run starts by itself.
    fn start_by_itself(&mut self, now_ns: i64) {
        let is_ready = matches!(self.state.stage(), Stage::Registered | Stage::Checked);
        if self.state.is_research() && is_ready && !self.rests {
            let check_age_ns = self.check_age_ns(now_ns);
            self.take(Event::Start { check_age_ns });
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
    pub(super) fn navigate(&mut self, now_ns: i64) -> Result<String, String> {
        let check_age_ns = self.check_age_ns(now_ns);
        let actions = self.take(Event::Start { check_age_ns });
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

    /// The last check of the registration in use.
    pub(super) const fn checked(&self) -> Option<Checked> {
        self.checked
    }

    /// The last check of any registration.
    pub(super) const fn report(&self) -> Option<&CheckReport> {
        self.report.as_ref()
    }

    /// How often a person said that the marker on the patient was moved.
    pub(super) const fn bumps(&self) -> u32 {
        self.bumped.1
    }

    /// How old it is, ns.
    fn check_age_ns(&self, now_ns: i64) -> i64 {
        // Clocks are read one after the other: a check that was told is not from the future.
        let age = self.checked.map(|checked| now_ns.saturating_sub(checked.t_ns).max(0));
        age.unwrap_or(NEVER_NS)
    }

    /// Known points were touched; with `fails`, one of them is too far off by what the registration promises. At `now_ns`.
    pub(super) fn check(&mut self, request: &Command, now_ns: i64) -> Result<String, String> {
        let (pose, worst_mm, fails) = (&request.pose, request.number, request.words());
        if self.state.registration() != Some(pose.registration_id) {
            return Err("the registration that was checked is not the one in use: check that".to_owned());
        }
        if !(worst_mm >= 0.0 && worst_mm.is_finite()) || pose.t_capture_ns > now_ns.saturating_add(CLOCKS_NS) {
            return Err(format!(
                "a check with a distance of {worst_mm} mm, or from the future, is none"
            ));
        }
        // Touches of before say nothing of where the patient is now.
        if self.bumped.0.is_some_and(|bumped_ns| pose.t_capture_ns <= bumped_ns) {
            return Err("the marker on the patient was moved after the first of these points was touched: touch all of them again".to_owned());
        }
        self.checked = Some(Checked {
            worst_mm,
            points: request.view,
            t_ns: pose.t_capture_ns,
            registration_id: pose.registration_id,
        });
        let allowed = if fails.is_empty() { worst_mm } else { f64::INFINITY };
        let age_ns = now_ns.saturating_sub(pose.t_capture_ns).max(0);
        self.take(Event::CheckDone {
            worst_mm: allowed,
            age_ns,
        });
        let because = if fails.is_empty() {
            String::new()
        } else {
            format!(" ({fails})")
        };
        let verdict = match self.state.check() {
            Check::Passed => "passed",
            Check::Failed => "FAILED",
            Check::Bumped | Check::NotMade => "does not hold",
        };
        self.report = Some(CheckReport {
            registration_id: format!("{:016x}", pose.registration_id),
            points: request.view,
            worst_mm,
            passed: self.state.check() == Check::Passed,
            warning: (!fails.is_empty()).then_some(fails),
        });
        // `recorder report` takes these words apart.
        Ok(format!(
            "check {verdict}: {} points, the worst {worst_mm:.2} mm off{because}",
            request.view
        ))
    }

    /// A person says that the marker on the patient was moved, or may have been.
    pub(super) fn bumped(&mut self, now_ns: i64) -> Result<String, String> {
        self.checked = None;
        self.bumped = (Some(now_ns), self.bumped.1.saturating_add(1));
        self.take(Event::ReferenceBumped);
        Ok("the marker on the patient was moved: the registration must be checked".to_owned())
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

//! Where a run stands.

use super::event::VolumeId;

/// How far a run has come. Each stage rests on all before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stage {
    /// There is no volume.
    Empty,
    /// There is a volume, nobody has said whose.
    Loaded,
    /// A person has confirmed that it is the patient's.
    Confirmed,
    /// The tool's calibration is valid.
    Calibrated,
    /// The patient's registration is within its gates.
    Registered,
    /// Known points were touched, and were where they had to be.
    Checked,
    /// The tool is followed, the sight may be shown.
    Navigating,
}

impl Stage {
    /// Every stage, in order.
    pub const ALL: [Self; 7] = [
        Self::Empty,
        Self::Loaded,
        Self::Confirmed,
        Self::Calibrated,
        Self::Registered,
        Self::Checked,
        Self::Navigating,
    ];

    /// As a person reads it.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Empty => "EMPTY",
            Self::Loaded => "LOADED",
            Self::Confirmed => "CONFIRMED",
            Self::Calibrated => "CALIBRATED",
            Self::Registered => "REGISTERED",
            Self::Checked => "CHECKED",
            Self::Navigating => "NAVIGATING",
        }
    }
}

/// What a person has said of the volume.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Identity {
    /// Nothing.
    NotAsked,
    /// It is the patient's.
    Confirmed,
    /// It is not.
    Rejected,
}

/// What is known of the check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Check {
    /// None was made of what holds now.
    NotMade,
    /// Passed, and young enough when that was last told.
    Passed,
    /// A point was further off than the gate allows.
    Failed,
    /// The reference was bumped since the registration was told first.
    Bumped,
}

/// What a run demands: a person's choice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rules {
    strict: bool,
    check_mm: f64,
    check_age_ns: i64,
}

/// Why rules were refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum RulesError {
    /// The gate of the check is no distance.
    #[error("gate of the check: {0} mm, a finite distance above zero is needed")]
    Gate(f64),
    /// The age of the check is none.
    #[error("longest age of the check: {0} ns, above zero is needed")]
    Age(i64),
}

impl Rules {
    /// With `strict`, nothing is skipped. A check passes where no point is off by more than `check_mm`, and holds for
    /// `check_age_ns`.
    ///
    /// # Errors
    /// Each variant of [`RulesError`].
    pub fn new(strict: bool, check_mm: f64, check_age_ns: i64) -> Result<Self, RulesError> {
        if !(check_mm > 0.0 && check_mm.is_finite()) {
            return Err(RulesError::Gate(check_mm));
        }
        if check_age_ns <= 0 {
            return Err(RulesError::Age(check_age_ns));
        }
        Ok(Self {
            strict,
            check_mm,
            check_age_ns,
        })
    }

    /// Whether a worst distance is within the gate; what is no distance is not.
    pub(super) fn passes(&self, worst_mm: f64) -> bool {
        (0.0..=self.check_mm).contains(&worst_mm)
    }

    /// Whether a check of this age still holds; one from the future does not.
    pub(super) fn is_fresh(&self, age_ns: i64) -> bool {
        (0..=self.check_age_ns).contains(&age_ns)
    }
}

/// What a research run went on without.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Skipped {
    /// Nobody has confirmed the identity.
    pub identity: bool,
    /// No check was passed.
    pub check: bool,
}

/// Where a run stands: begun by [`State::new`], changed by [`super::step`] alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State {
    pub(super) rules: Rules,
    pub(super) stage: Stage,
    pub(super) volume: Option<VolumeId>,
    pub(super) identity: Identity,
    /// Whether a person has ever said of a volume that it is not the patient's: from then on every volume needs her word.
    pub(super) was_rejected: bool,
    /// The calibration that was accepted last.
    pub(super) calibration: Option<u64>,
    /// The registration within its gates that was told last: what is known of the check is known of this one.
    pub(super) registration: Option<u64>,
    pub(super) check: Check,
    pub(super) tool_is_seen: bool,
}

impl State {
    /// EMPTY, the tool not seen.
    pub const fn new(rules: Rules) -> Self {
        Self {
            rules,
            stage: Stage::Empty,
            volume: None,
            identity: Identity::NotAsked,
            was_rejected: false,
            calibration: None,
            registration: None,
            check: Check::NotMade,
            tool_is_seen: false,
        }
    }

    /// How far the run has come.
    pub const fn stage(&self) -> Stage {
        self.stage
    }

    /// The volume that everything rests on; `None` in EMPTY.
    pub const fn volume(&self) -> Option<VolumeId> {
        self.volume
    }

    /// What a person has said of the volume.
    pub const fn identity(&self) -> Identity {
        self.identity
    }

    /// The registration within its gates that was told last.
    pub const fn registration(&self) -> Option<u64> {
        self.registration
    }

    /// What is known of the check.
    pub const fn check(&self) -> Check {
        self.check
    }

    /// Whether there is a valid pose of the tool.
    pub const fn tool_is_seen(&self) -> bool {
        self.tool_is_seen
    }

    /// Whether confirmations may be skipped: every screen has to say RESEARCH.
    pub const fn is_research(&self) -> bool {
        !self.rules.strict
    }

    /// What the run went on without; nothing where the rules are strict.
    pub fn skipped(&self) -> Skipped {
        Skipped {
            identity: self.stage > Stage::Confirmed && self.identity != Identity::Confirmed,
            check: self.stage == Stage::Navigating && self.check != Check::Passed,
        }
    }

    /// Whether sight, digits and verdict may be shown: NAVIGATING, and the tool is seen.
    pub fn shows_sight(&self) -> bool {
        self.stage == Stage::Navigating && self.tool_is_seen
    }
}

//! What happens to a run.

/// The BLAKE3 of geometry and voxels: the examination's name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct VolumeId(pub [u8; 32]);

/// What happened.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// A volume is in memory: the run's first, the same again, or another.
    VolumeLoaded {
        /// Which.
        volume: VolumeId,
    },
    /// The volume is gone.
    VolumeGone,
    /// A person has confirmed that this volume is the patient's.
    IdentityConfirmed {
        /// The volume that was on the screen.
        volume: VolumeId,
    },
    /// A person says that it is not.
    IdentityRejected,
    /// The tool's calibration is there for the first time, or another has taken its place.
    Calibration {
        /// Which: the same again changes nothing.
        id: u64,
        /// Whether it is within its gates and of this tool.
        is_valid: bool,
    },
    /// A registration is there for the first time, or another has taken its place.
    Registration {
        /// Which: the same again changes nothing, and clears no doubt.
        id: u64,
        /// The volume that it leads to.
        volume: VolumeId,
        /// Whether it is within its gates.
        is_within_gates: bool,
    },
    /// The marker on the patient was pushed, or may have been.
    ReferenceBumped,
    /// Known points were touched.
    CheckDone {
        /// The largest distance of a touched point from its place, mm.
        worst_mm: f64,
        /// How long ago that was, ns.
        age_ns: i64,
    },
    /// Time went by.
    CheckAge {
        /// How old the check is that was passed last, ns.
        age_ns: i64,
    },
    /// A person has changed targets, entry or stop distance.
    PlanChanged,
    /// A person starts the navigation.
    Start {
        /// How old the check is that was passed last, ns; of no meaning where none was.
        check_age_ns: i64,
    },
    /// A person ends it.
    Stop,
    /// There is no valid pose of the tool any more.
    ToolLost,
    /// There is one again.
    ToolSeen,
    /// The images are older than they may be.
    ImagesOld,
    /// The operator's window is there again after it had ended.
    WindowRestarted,
}

/// An event without its numbers: what rows of the table name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[allow(missing_docs, reason = "each is the event of the same name")]
pub enum Kind {
    VolumeLoaded,
    VolumeGone,
    IdentityConfirmed,
    IdentityRejected,
    Calibration,
    Registration,
    ReferenceBumped,
    CheckDone,
    CheckAge,
    PlanChanged,
    Start,
    Stop,
    ToolLost,
    ToolSeen,
    ImagesOld,
    WindowRestarted,
}

impl Event {
    /// Which event it is.
    pub const fn kind(&self) -> Kind {
        match self {
            Self::VolumeLoaded { .. } => Kind::VolumeLoaded,
            Self::VolumeGone => Kind::VolumeGone,
            Self::IdentityConfirmed { .. } => Kind::IdentityConfirmed,
            Self::IdentityRejected => Kind::IdentityRejected,
            Self::Calibration { .. } => Kind::Calibration,
            Self::Registration { .. } => Kind::Registration,
            Self::ReferenceBumped => Kind::ReferenceBumped,
            Self::CheckDone { .. } => Kind::CheckDone,
            Self::CheckAge { .. } => Kind::CheckAge,
            Self::PlanChanged => Kind::PlanChanged,
            Self::Start { .. } => Kind::Start,
            Self::Stop => Kind::Stop,
            Self::ToolLost => Kind::ToolLost,
            Self::ToolSeen => Kind::ToolSeen,
            Self::ImagesOld => Kind::ImagesOld,
            Self::WindowRestarted => Kind::WindowRestarted,
        }
    }
}

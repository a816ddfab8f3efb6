//! The steps by which a device is set up: what each asks, and which comes next.

use super::rules::ClientRules;
use crate::command::{Command, WIRELESS};
use crate::handle::Handle;

/// PHSR: handles whose tool is gone.
const STALE: u8 = 1;
/// PHSR: tools that are not initialised.
const UNINITIALIZED: u8 = 2;
/// PHSR: tools that are initialised and not enabled.
const UNENABLED: u8 = 3;
/// VER: the firmware of the whole system.
pub(super) const VERSION: Command = Command::Ver(4);

/// A step; the first three stand alone, the others are each for one thing of a list.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Step {
    /// Stop tracking: the device may still do so from before.
    Stop,
    Init,
    Comm,
    Version,
    Stale,
    /// Free these, from the last one on.
    Free(Vec<Handle>),
    /// A handle for this tool of the rules.
    Request(usize),
    /// This piece of its definition.
    Write(usize, usize),
    Initialize(usize),
    Enable(usize),
    FindUninitialized,
    InitializeWired(Vec<Handle>),
    FindUnenabled,
    EnableWired(Vec<Handle>),
    Start,
    /// It is set up.
    Track,
}

impl Step {
    /// What is asked; `None` where there is nothing to ask.
    pub(super) fn command(&self, rules: &ClientRules, handles: &[Handle]) -> Option<Command> {
        let handle = |tool: &usize| handles.get(*tool).copied();
        match self {
            Self::Stop => Some(Command::Tstop),
            Self::Init => Some(Command::Init),
            Self::Comm => rules.comm.clone().map(Command::Comm),
            Self::Version => Some(VERSION),
            Self::Stale => Some(Command::Phsr(STALE)),
            Self::Free(handles) => handles.last().copied().map(Command::Phf),
            Self::Request(tool) => rules.tools.get(*tool).map(|_| Command::Phrq(WIRELESS.to_owned())),
            Self::Write(tool, piece) => {
                let (address, piece) = rules.tools.get(*tool)?.rom.pieces().nth(*piece)?;
                Some(Command::Pvwr(handle(tool)?, address, Box::new(piece)))
            }
            Self::Initialize(tool) => handle(tool).map(Command::Pinit),
            Self::Enable(tool) => Some(Command::Pena(handle(tool)?, rules.tools.get(*tool)?.priority)),
            Self::FindUninitialized => rules.wired.then_some(Command::Phsr(UNINITIALIZED)),
            Self::InitializeWired(handles) => handles.last().copied().map(Command::Pinit),
            Self::FindUnenabled => rules.wired.then_some(Command::Phsr(UNENABLED)),
            Self::EnableWired(handles) => handles.last().map(|handle| Command::Pena(*handle, 'D')),
            Self::Start => Some(Command::Tstart),
            Self::Track => None,
        }
    }

    /// The step behind this one, if it had nothing to ask or was answered.
    pub(super) fn after(self, rules: &ClientRules) -> Self {
        match self {
            Self::Stop => Self::Init,
            Self::Init => Self::Comm,
            Self::Comm => Self::Version,
            Self::Version => Self::Stale,
            Self::Stale => Self::Request(0),
            Self::Free(handles) => Self::shorter(handles, Self::Free, Self::Request(0)),
            Self::Request(tool) if tool >= rules.tools.len() => Self::FindUninitialized,
            Self::Request(tool) => Self::Write(tool, 0),
            Self::Write(tool, piece) => {
                let pieces = rules.tools.get(tool).map_or(0, |tool| tool.rom.pieces().count());
                let has_next = piece + 1 < pieces;
                if has_next {
                    Self::Write(tool, piece + 1)
                } else {
                    Self::Initialize(tool)
                }
            }
            Self::Initialize(tool) => Self::Enable(tool),
            Self::Enable(tool) => Self::Request(tool + 1),
            Self::FindUninitialized => Self::FindUnenabled,
            Self::InitializeWired(handles) => Self::shorter(handles, Self::InitializeWired, Self::FindUnenabled),
            Self::FindUnenabled => Self::Start,
            Self::EnableWired(handles) => Self::shorter(handles, Self::EnableWired, Self::Start),
            Self::Start | Self::Track => Self::Track,
        }
    }

    /// The same for the rest of a list, or what comes behind it.
    fn shorter(mut handles: Vec<Handle>, same: impl Fn(Vec<Handle>) -> Self, then: Self) -> Self {
        handles.pop();
        if handles.is_empty() { then } else { same(handles) }
    }
}

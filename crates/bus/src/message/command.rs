//! Requests to a process and the head of its reply.

use iceoryx2::prelude::ZeroCopySend;

use super::ToolPose;

/// A request. The reply is bytes (text or JSON) behind a [`ReplyHeader`].
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend)]
#[repr(C)]
#[type_name("trocar/Command/3")]
pub struct Command {
    /// Code of a [`CommandKind`].
    pub kind: u32,
    /// Room for alignment; zero.
    pub reserved: u32,
    /// For [`CommandKind::Seek`]: seconds behind the recording's first pose. For [`CommandKind::Speed`]: how many times the
    /// recording's own speed, infinite for as fast as images can be drawn. For [`CommandKind::Restart`]: which process, by its
    /// place in the status. Else 0.
    pub number: f64,
    /// For [`CommandKind::Render`]: the pose to draw.
    pub pose: ToolPose,
}

const _: () = assert!(size_of::<Command>() == 320);

/// What is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CommandKind {
    /// Pilot: the state of the run as JSON.
    Status,
    /// Pilot: stop the run in an orderly way.
    Stop,
    /// Renderer: draw this very pose in each view and publish the images, so that all views show one pose.
    Render,
    /// Renderer: nobody publishes poses any more; what is shown is lost at once.
    NoPoses,
    /// Pilot: start a process again that ended too often and was left alone.
    Restart,
    /// Replayer: stand still.
    Pause,
    /// Replayer: go on.
    Play,
    /// Replayer: publish the next pose and stand still.
    Step,
    /// Replayer: go on from [`Command::number`].
    Seek,
    /// Replayer: go on at [`Command::number`].
    Speed,
}

/// Every kind of request with its code on the wire.
const CODES: [(CommandKind, u32); 10] = [
    (CommandKind::Status, 1),
    (CommandKind::Stop, 2),
    (CommandKind::Render, 3),
    (CommandKind::Pause, 4),
    (CommandKind::Play, 5),
    (CommandKind::Step, 6),
    (CommandKind::Seek, 7),
    (CommandKind::Speed, 8),
    (CommandKind::NoPoses, 9),
    (CommandKind::Restart, 10),
];

impl Command {
    /// A request without a pose or a number.
    pub fn new(kind: CommandKind) -> Self {
        Self {
            kind: CODES
                .iter()
                .find(|(known, _)| *known == kind)
                .map_or(0, |&(_, code)| code),
            reserved: 0,
            number: 0.0,
            pose: ToolPose::EMPTY,
        }
    }

    /// The request to draw `pose`.
    pub fn render(pose: ToolPose) -> Self {
        Self {
            pose,
            ..Self::new(CommandKind::Render)
        }
    }

    /// A request with a number: [`CommandKind::Seek`], [`CommandKind::Speed`], [`CommandKind::Restart`].
    pub fn with_number(kind: CommandKind, number: f64) -> Self {
        Self {
            number,
            ..Self::new(kind)
        }
    }

    /// What is asked for, or `None` for an unknown code.
    pub fn command_kind(&self) -> Option<CommandKind> {
        CODES.iter().find(|(_, code)| *code == self.kind).map(|&(kind, _)| kind)
    }
}

/// Travels in front of a reply's bytes.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq, ZeroCopySend)]
#[repr(C)]
#[type_name("trocar/ReplyHeader/1")]
pub struct ReplyHeader {
    /// 0: done. Anything else: refused, and the bytes say why.
    pub refused: u32,
}

const _: () = assert!(size_of::<ReplyHeader>() == 4);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_comes_back_by_its_code() {
        for (kind, code) in CODES {
            let command = Command::new(kind);
            assert_eq!((command.kind, command.command_kind()), (code, Some(kind)));
        }
        let unknown = Command {
            kind: 99,
            ..Command::new(CommandKind::Stop)
        };
        assert_eq!(unknown.command_kind(), None);
    }
}

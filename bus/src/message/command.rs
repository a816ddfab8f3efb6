//! Requests to a process and the head of its reply.

use iceoryx2::prelude::ZeroCopySend;

use super::ToolPose;

/// A request. The reply is bytes (text or JSON) behind a [`ReplyHeader`].
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend)]
#[repr(C)]
#[type_name("trocar/Command/2")]
pub struct Command {
    /// Code of a [`CommandKind`].
    pub kind: u32,
    /// Room for alignment; zero.
    pub reserved: u32,
    /// For [`CommandKind::Render`]: the pose to draw.
    pub pose: ToolPose,
}

const _: () = assert!(size_of::<Command>() == 312);

/// What is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CommandKind {
    /// Pilot: the state of the run as JSON.
    Status,
    /// Pilot: stop the run in an orderly way.
    Stop,
    /// Renderer: draw this very pose in each view and publish the images, so that all views show one pose.
    Render,
}

impl Command {
    /// A request without a pose.
    pub fn new(kind: CommandKind) -> Self {
        Self {
            kind: match kind {
                CommandKind::Status => 1,
                CommandKind::Stop => 2,
                CommandKind::Render => 3,
            },
            reserved: 0,
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

    /// What is asked for, or `None` for an unknown code.
    pub fn command_kind(&self) -> Option<CommandKind> {
        match self.kind {
            1 => Some(CommandKind::Status),
            2 => Some(CommandKind::Stop),
            3 => Some(CommandKind::Render),
            _ => None,
        }
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

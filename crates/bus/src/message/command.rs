//! Requests to a process and the head of its reply.

use geometry::SlicePlane;
use iceoryx2::prelude::ZeroCopySend;
use scene::WindowLevel;

use super::{ImagePlane, PlanEdit, PlanWish, ToolPose, field_text, text_field};

/// A request. The reply is bytes (text or JSON) behind a [`ReplyHeader`].
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend)]
#[repr(C)]
#[type_name("trocar/Command/7")]
pub struct Command {
    /// Code of a [`CommandKind`].
    pub kind: u32,
    /// For [`CommandKind::Look`] and [`CommandKind::Turn`]: index of the view in the scene's list. For [`CommandKind::Checked`]: how many
    /// points were touched. For [`CommandKind::Practise`]: the frame of `pose`. For [`CommandKind::Images`]: which numbers are of meaning.
    /// Else 0.
    pub view: u32,
    /// For [`CommandKind::Seek`]: seconds behind the recording's first pose. For [`CommandKind::Speed`]: how many times the
    /// recording's own speed, infinite for as fast as images can be drawn. For [`CommandKind::Practise`]: an angle, radians. For
    /// [`CommandKind::Images`]: the field, mm. Else 0.
    pub number: f64,
    /// For [`CommandKind::Render`]: the pose to draw. For [`CommandKind::Hold`]: the pose to be held.
    pub pose: ToolPose,
    /// For [`CommandKind::Look`]: the plane and window to draw. For [`CommandKind::Turn`]: how the image is to lie, or zero. For
    /// [`CommandKind::Images`]: the window. Else zero.
    pub plane: ImagePlane,
    /// For [`CommandKind::Choose`]: the target's name in the scene. For [`CommandKind::Mark`]: what is to be noted. For
    /// [`CommandKind::Confirm`]: the examination's hash, in hex. For [`CommandKind::Restart`]: the process's name. For
    /// [`CommandKind::Plan`]: the words of the change. Else empty.
    pub text: [u8; Self::TEXT],
    /// For [`CommandKind::Plan`]: the change. Else none.
    pub edit: PlanEdit,
}

const _: () = assert!(size_of::<Command>() == 320 + size_of::<ImagePlane>() + Command::TEXT + size_of::<PlanEdit>());

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
    /// Pilot: start a process again that ended too often and was left alone, or the localizer, so that it dials anew.
    Restart,
    /// Replayer: stand still.
    Pause,
    /// Replayer: go on.
    Play,
    /// Replayer: publish the next pose and stand still.
    Step,
    /// Replayer: publish the pose before this one and stand still.
    StepBack,
    /// Replayer: stand still, and write what is shown as files.
    Moment,
    /// Replayer: go on from [`Command::number`].
    Seek,
    /// Replayer: go on at [`Command::number`].
    Speed,
    /// Renderer: draw this very plane of one view, whatever the tool does, and publish the image.
    Look,
    /// Pilot: the target with this name is the one that is aimed at; none where the name is empty.
    Choose,
    /// Pilot: note this moment, with these words, in the recording.
    Mark,
    /// Pilot: all screens hold this pose until [`CommandKind::Follow`].
    Hold,
    /// Pilot: nothing is held any more.
    Follow,
    /// Pilot: a person says that the examination with this hash, which she saw on her screen, is the patient's.
    Confirm,
    /// Pilot: a person says that it is not.
    Reject,
    /// Pilot: a person starts the navigation.
    Navigate,
    /// Pilot: a person ends it, and the run goes on.
    Rest,
    /// Pilot of a planning run: change the plan, take a change back, or confirm it.
    Plan,
    /// Pilot: known points were touched; the largest distance of one from its place is [`Command::number`], mm. `pose` says of which
    /// registration (`registration_id`) and when the first of them was touched (`t_capture_ns`). Words say why it fails whatever the distance.
    Checked,
    /// Pilot: a person says that the marker on the patient was moved, or may have been.
    Bumped,
    /// Calibrator: the step that is asked for, see [`StepWish`](super::StepWish).
    Steps,
    /// Simulated tracker: what its hand is to do, see [`Practice`](super::Practice).
    Practise,
    /// Renderer of a surface: see the patient from elsewhere, until another such request or the process's end.
    Turn,
    /// Pilot: how images look, see [`ImagesWish`](super::ImagesWish).
    Images,
}

/// Every kind of request with its code on the wire.
const CODES: [(CommandKind, u32); 28] = [
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
    (CommandKind::Look, 11),
    (CommandKind::Choose, 12),
    (CommandKind::Mark, 13),
    (CommandKind::Hold, 14),
    (CommandKind::Follow, 15),
    (CommandKind::Confirm, 16),
    (CommandKind::Reject, 17),
    (CommandKind::Navigate, 18),
    (CommandKind::Rest, 19),
    (CommandKind::Plan, 20),
    (CommandKind::Checked, 21),
    (CommandKind::Bumped, 22),
    (CommandKind::Steps, 23),
    (CommandKind::Practise, 24),
    (CommandKind::Turn, 25),
    (CommandKind::Images, 26),
    (CommandKind::StepBack, 27),
    (CommandKind::Moment, 28),
];

impl Command {
    /// Most bytes of a request's words.
    pub const TEXT: usize = 96;

    /// A request without a pose or a number.
    pub fn new(kind: CommandKind) -> Self {
        Self {
            kind: CODES
                .iter()
                .find(|(known, _)| *known == kind)
                .map_or(0, |&(_, code)| code),
            view: 0,
            number: 0.0,
            pose: ToolPose::EMPTY,
            plane: ImagePlane::default(),
            text: [0; Self::TEXT],
            edit: PlanEdit::NONE,
        }
    }

    /// The request to draw `pose`.
    pub fn render(pose: ToolPose) -> Self {
        Self {
            pose,
            ..Self::new(CommandKind::Render)
        }
    }

    /// A request with a number: [`CommandKind::Seek`], [`CommandKind::Speed`].
    pub fn with_number(kind: CommandKind, number: f64) -> Self {
        Self {
            number,
            ..Self::new(kind)
        }
    }

    /// A request with words: [`CommandKind::Choose`], [`CommandKind::Mark`], [`CommandKind::Confirm`], [`CommandKind::Restart`].
    /// What does not fit is cut off.
    pub fn with_text(kind: CommandKind, text: &str) -> Self {
        Self {
            text: text_field(text),
            ..Self::new(kind)
        }
    }

    /// The request that all screens hold `pose`.
    pub fn hold(pose: ToolPose) -> Self {
        Self {
            pose,
            ..Self::new(CommandKind::Hold)
        }
    }

    /// The request to draw `plane` in the view with this index.
    pub fn look(view: u32, plane: ImagePlane) -> Self {
        Self {
            view,
            plane,
            ..Self::new(CommandKind::Look)
        }
    }

    /// The request to see the patient of the surface view with this index along `camera`, by parallel projection; `None`: as the scene
    /// says again.
    pub fn turn(view: u32, camera: Option<&SlicePlane>) -> Self {
        // Any window will do: a surface has none.
        let window = WindowLevel {
            centre_hu: 0.0,
            width_hu: 1.0,
        };
        let plane = camera.map(|camera| ImagePlane::of(Some(camera), window));
        Self {
            view,
            plane: plane.unwrap_or_default(),
            ..Self::new(CommandKind::Turn)
        }
    }

    /// The request to change the plan; `None` for a change that has no room in one, and for words that would be cut off.
    pub fn plan(wish: &PlanWish) -> Option<Self> {
        let (edit, words) = PlanEdit::of(wish)?;
        (words.len() <= Self::TEXT).then(|| Self {
            edit,
            ..Self::with_text(CommandKind::Plan, &words)
        })
    }

    /// The word of a check of the registration `registration_id`: the touched points lay up to `worst_mm` from their places, the last one
    /// at `t_ns` on the session's clock.
    pub fn checked(worst_mm: f64, points: u32, t_ns: i64, registration_id: u64) -> Self {
        let pose = ToolPose {
            t_capture_ns: t_ns,
            registration_id,
            ..ToolPose::EMPTY
        };
        Self {
            pose,
            view: points,
            ..Self::with_number(CommandKind::Checked, worst_mm)
        }
    }

    /// The same with these words.
    #[must_use]
    pub fn because(self, words: &str) -> Self {
        Self {
            text: text_field(words),
            ..self
        }
    }

    /// The request's words.
    pub fn words(&self) -> String {
        field_text(&self.text)
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

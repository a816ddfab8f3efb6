//! What goes over the bus: plain `repr(C)` numbers with versioned type names and asserted sizes.
//!
//! iceoryx2 compares type name, size and alignment when a process joins a topic, but not the order of the fields: a
//! changed layout needs a new version in its name. Each message is turned into typed geometry once, at the door
//! ([`ToolPose::tracked`], [`VolumeHeader::grid`]), where impossible values are refused.

mod clock_law;
mod command;
mod emitters;
mod event;
mod frame;
mod guide;
mod heartbeat;
mod identity;
mod images;
mod images_request;
mod lost;
mod markers;
mod plan;
mod plan_edit;
mod pose;
mod practice;
mod step_motion;
mod steps;
mod timeline;
mod tissue;
mod tissue_mesh;
mod us_image;
mod volume_header;
mod wire;
mod workflow;

pub use crate::volume::{Marks, VolumeHash};
pub use clock_law::{ClockLaw, ReplayState};
pub use command::{Command, CommandKind, ReplyHeader};
pub use emitters::{EmitterFrame, EmitterSight, TooManyEmitters};
pub use event::{Event, Level};
pub use frame::{Ages, FrameHeader, FrameStamp, FrameState, ImagePlane, LookError};
pub use guide::{Chosen, Guide, GuideError};
pub use heartbeat::{
    Counters, GPU_GIVEN_UP, Heartbeat, MAY_BE_OLDER, NOT_RECORDING, ProcessState, RECORDED_ANEW, may_be_older_ms,
};
pub use identity::{Identity, IdentitySource};
pub use images::{Change, Images, ImagesError, ImagesWish};
pub use lost::Lost;
pub use markers::{CaptureClock, MarkerFrame, MarkerSight, MarkersError, Sight};
pub use plan::{Plan, PlanMeasure, PlanMessageError, PlanTarget};
pub use plan_edit::{PlanEdit, PlanWish};
pub use pose::{PoseError, ToolPose, Tracked};
pub use practice::{Practice, PracticeFrame, PracticeMotion};
pub use step_motion::{StepMotion, StepMotionKind};
pub use steps::{StepFigure, StepGate, StepPhase, StepPoint, StepTask, StepWish, Steps};
pub use timeline::{Timeline, TimelineColumn, TimelineMark};
pub use tissue::{
    MOST_DEPTH_MM, MOST_ERRORS, PlaceError, TargetShown, TissueError, TissueHeader, TissueShown, TissueState,
};
pub use tissue_mesh::{MeshCube, MeshOrgan, TissueMesh, TissueMeshError, TissueMeshHeader};
pub use us_image::{UsImageError, UsImageHeader};
pub use volume_header::{HeaderError, VolumeHeader};
pub use wire::{Wire, WireError, node_bytes, nodes_from, voxel_bytes, voxels_from};
pub use workflow::Workflow;

/// A fixed-size text field: UTF-8, cut at a character's boundary, zero-padded.
pub(crate) fn text_field<const N: usize>(text: &str) -> [u8; N] {
    let mut end = text.len().min(N);
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    let mut field = [0; N];
    field[..end].copy_from_slice(&text.as_bytes()[..end]);
    field
}

/// The text of a field, with anything that is not UTF-8 replaced.
pub(crate) fn field_text(field: &[u8]) -> String {
    let end = field.iter().position(|&b| b == 0).unwrap_or(field.len());
    String::from_utf8_lossy(&field[..end]).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_fields_cut_at_characters() {
        let field = text_field::<4>("abcé");
        assert_eq!(field_text(&field), "abc");
        assert_eq!(field_text(&text_field::<8>("abcé")), "abcé");
        assert_eq!(field_text(&[0xff, b'a', 0, b'b']), "\u{fffd}a");
    }
}

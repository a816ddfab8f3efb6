//! A frame of the room as the device tells it of its client's tools.

use bus::message::Lost;
use ndi::session::Device;
use ndi::status::{MarkerStatus, ToolStatus};
use ndi::{Bx2Frame, Bx2Marker, Bx2Markers, Bx2Tool, FrameKind, Handle, MOST_MARKERS, Transform};

use super::roles::{Role, Roles};
use super::room::{RoomFrame, RoomMarker};

/// Frames are those of passive tools, which clients load definitions of; that the room's emitters shine is not told.
const KIND: FrameKind = FrameKind(2);
/// Nothing is said against a pose.
const GOOD: u16 = 0;

/// The frame for the tools that this client has loaded.
pub(super) fn served(frame: &RoomFrame, device: &Device, roles: &Roles) -> Bx2Frame {
    let mut told = Bx2Frame {
        kind: KIND,
        index: 0,
        status: ToolStatus(GOOD),
        // The device's counter has 32 bits, and begins anew.
        number: frame.number as u32,
        device_ns: frame.device_ns,
        tools: Vec::new(),
        markers: Vec::new(),
        errors: Vec::new(),
    };
    for tool in device.tools().filter(|tool| tool.enabled) {
        let marker = match roles.of(tool.handle) {
            Some(Role::Tool) => Some(&frame.tool),
            Some(Role::Patient) => frame.patient.as_ref(),
            None => None,
        };
        told.tools.push(stated(tool.handle, marker));
        told.markers.extend(marker.map(|marker| emitters(tool.handle, marker)));
    }
    told
}

fn stated(handle: Handle, marker: Option<&RoomMarker>) -> Bx2Tool {
    let (status, transform) = match marker.map_or(Err(Lost::NotSeen), |marker| marker.pose) {
        Ok(pose) => {
            let transform = Transform {
                q: pose.q,
                t_mm: pose.t_mm,
                error_mm: pose.error_mm,
            };
            (GOOD, Some(transform))
        }
        Err(why) => (ToolStatus::MISSING | code(why), None),
    };
    Bx2Tool {
        handle,
        status: ToolStatus(status),
        transform,
    }
}

/// The device's code of a reason.
fn code(why: Lost) -> u16 {
    match why {
        Lost::NotSeen => 31,
        Lost::OutOfVolume => 9,
        Lost::TooFew => 13,
        Lost::Residual => 17,
        Lost::Interference => 14,
        // No others come of a room; whatever they would mean, the device failed.
        _ => 22,
    }
}

/// Single emitters, as far as tools of such a device have them: clients make room for so many.
fn emitters(handle: Handle, marker: &RoomMarker) -> Bx2Markers {
    let told = marker.emitters_mm.iter().filter_map(|(emitter, place_mm)| {
        let index = u16::try_from(*emitter)
            .ok()
            .filter(|index| *index < MOST_MARKERS.into())?;
        Some(Bx2Marker {
            status: MarkerStatus(0),
            index,
            place_mm: *place_mm,
        })
    });
    Bx2Markers {
        handle,
        markers: told.collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::roles::Definitions;
    use crate::simulate::room::RoomPose;
    use crate::simulate::testing::{client, rom};
    use ndi::Why;

    fn marker(pose: Result<f64, Lost>) -> RoomMarker {
        let pose = pose.map(|x| RoomPose {
            q: [0.5, -0.5, 0.5, 0.5],
            t_mm: [x, 2.0, 1500.0],
            error_mm: 0.25,
        });
        RoomMarker {
            pose,
            emitters_mm: vec![(3, [1.0, 2.0, 3.0]), (19, [4.0; 3]), (20, [5.0; 3])],
        }
    }

    fn frame(tool: Result<f64, Lost>, patient: Option<Result<f64, Lost>>) -> RoomFrame {
        RoomFrame {
            number: 7,
            device_ns: 3_600_000_000_123,
            tool: marker(tool),
            patient: patient.map(marker),
        }
    }

    fn of(frame: &RoomFrame) -> Bx2Frame {
        let device = client(&[rom("a"), rom("b"), rom("c")]);
        let mut roles = Roles::new(Definitions::default());
        roles.look(&device);
        served(frame, &device, &roles)
    }

    #[test]
    fn each_tool_has_the_pose_of_its_marker_and_one_too_many_is_missing() {
        let told = of(&frame(Ok(1.0), Some(Ok(100.0))));
        assert_eq!((told.number, told.device_ns), (7, 3_600_000_000_123));
        let x: Vec<_> = told
            .tools
            .iter()
            .map(|tool| (tool.handle.0, tool.status.why(), tool.transform.map(|t| t.t_mm[0])))
            .collect();
        let expected = [
            (1, Why::Valid, Some(1.0)),
            (2, Why::Valid, Some(100.0)),
            (3, Why::Missing, None),
        ];
        assert_eq!(x, expected);
        let indices: Vec<u16> = told.markers[0].markers.iter().map(|marker| marker.index).collect();
        assert_eq!((told.markers.len(), indices), (2, vec![3, 19]));
    }

    #[test]
    fn each_reason_is_told_as_such_and_never_with_a_pose() {
        for lost in Lost::ALL {
            let told = of(&frame(Err(lost), Some(Ok(100.0))));
            let expected = match lost {
                Lost::NotSeen => Why::Missing,
                Lost::OutOfVolume => Why::OutOfVolume,
                Lost::TooFew => Why::TooFewMarkers,
                Lost::Residual => Why::BadFit,
                Lost::Interference => Why::Interference,
                _ => Why::ProcessingError,
            };
            assert_eq!((told.tools[0].status.why(), told.tools[0].transform), (expected, None));
            assert_eq!(told.tools[1].status.why(), Why::Valid);
        }
        let without = of(&frame(Ok(1.0), None));
        assert_eq!(without.tools[1].status.why(), Why::Missing);
    }
}

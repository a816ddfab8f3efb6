//! A reply to BX2 as bytes.

use super::{ALERTS, Bx2, Bx2Frame, Bx2Markers, Bx2Tool, ERRORS, FRAME, HEADER, MARKERS, TOOLS, VERSION};
use crate::handle::Handle;
use crate::polled::bx::put_transform;
use crate::pose::Transform;
use crate::wire::put_reals;

/// The body of a reply. Empty parts are left out.
pub fn bx2_body(reply: &Bx2) -> Vec<u8> {
    let frames: Vec<u8> = reply.frames.iter().flat_map(frame).collect();
    let alerts = reply.alerts.iter().flat_map(|alert| pair(alert.kind, alert.code));
    container(&[
        (FRAME, reply.frames.len(), frames),
        (ALERTS, reply.alerts.len(), alerts.collect()),
    ])
}

fn container(parts: &[(u16, usize, Vec<u8>)]) -> Vec<u8> {
    let there: Vec<_> = parts.iter().filter(|(_, items, _)| *items > 0).collect();
    let count = u16::try_from(there.len()).unwrap_or(u16::MAX);
    let mut out = pair(VERSION, count).to_vec();
    for (kind, items, content) in there {
        let size = u32::try_from(content.len()).unwrap_or(u32::MAX).saturating_add(HEADER);
        out.extend(kind.to_le_bytes());
        out.extend(size.to_le_bytes());
        out.extend(0_u16.to_le_bytes());
        out.extend(u32::try_from(*items).unwrap_or(u32::MAX).to_le_bytes());
        out.extend(content);
    }
    out
}

fn frame(frame: &Bx2Frame) -> Vec<u8> {
    let mut out = vec![frame.kind.0, frame.index];
    out.extend(frame.status.0.to_le_bytes());
    out.extend(frame.number.to_le_bytes());
    let second = 1_000_000_000;
    let parts = [frame.device_ns.div_euclid(second), frame.device_ns.rem_euclid(second)];
    parts
        .iter()
        .for_each(|part| out.extend(u32::try_from(*part).unwrap_or_default().to_le_bytes()));
    out.extend(container(&[
        (TOOLS, frame.tools.len(), frame.tools.iter().flat_map(tool).collect()),
        (
            MARKERS,
            frame.markers.len(),
            frame.markers.iter().flat_map(markers).collect(),
        ),
        (
            ERRORS,
            frame.errors.len(),
            frame.errors.iter().flat_map(errors).collect(),
        ),
    ]));
    out
}

fn tool(tool: &Bx2Tool) -> Vec<u8> {
    let mut out = pair(tool.handle.0, tool.status.0).to_vec();
    if !tool.status.is_missing() {
        put_transform(&mut out, &tool.transform.unwrap_or(Transform::NOTHING));
    }
    out
}

fn markers(list: &Bx2Markers) -> Vec<u8> {
    let count = u16::try_from(list.markers.len()).unwrap_or(u16::MAX);
    let mut out = pair(list.handle.0, count).to_vec();
    for marker in list.markers.iter().take(usize::from(count)) {
        out.extend([marker.status.0, 0]);
        out.extend(marker.index.to_le_bytes());
        put_reals(&mut out, &marker.place_mm);
    }
    out
}

fn errors((handle, errors): &(Handle, Vec<f64>)) -> Vec<u8> {
    let count = u16::try_from(errors.len()).unwrap_or(u16::MAX);
    let mut out = pair(handle.0, count).to_vec();
    put_reals(&mut out, errors.get(..usize::from(count)).unwrap_or_default());
    out
}

fn pair(a: u16, b: u16) -> [u8; 4] {
    let ([a, b], [c, d]) = (a.to_le_bytes(), b.to_le_bytes());
    [a, b, c, d]
}

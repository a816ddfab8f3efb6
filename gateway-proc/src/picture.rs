//! The image of a view as an IMAGE: its pixels with the place in the patient where the renderer drew them, or a cover where what stands
//! on them is no longer true.

use std::sync::Arc;

use bus::message::{Ages, FrameState};
use bus::port::Frame;
use igtl::{Body, DeviceName, Message, Metadata, Stamp, Text};

use crate::letter::{Letter, Voxels};
use crate::origin::Origin;
use crate::place::of_plane;

/// Why there is no image to be sent.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub(crate) enum PictureError {
    /// No pose ever placed it.
    #[error("the view has no place in the patient yet")]
    NoPlace,
    /// Its plane is none.
    #[error("the view's plane: {0}")]
    Plane(String),
    /// A side is longer than the wire can say.
    #[error("an image of more than 65535 pixels a side")]
    TooLarge,
}

/// What an image may claim now, in a word; `None` where it claims something else than what stands on it.
fn claim(frame: &Frame, now_ns: i64, ages: Ages) -> Option<FrameState> {
    let now = frame.shown(now_ns, ages).state?;
    (frame.header().stamp.frame_state() == Some(now)).then_some(now)
}

/// Whether the words on an image are still true.
pub(crate) fn is_true(frame: &Frame, now_ns: i64, ages: Ages) -> bool {
    claim(frame, now_ns, ages).is_some()
}

/// Why an image is black that nothing else covers.
pub(crate) const GROWN_OLD: &str = "the image has grown old";

/// The image as it is at `now_ns` on the session's clock: a black one where it claims what is no longer true, or where
/// the run does not let images be shown (`why_not`).
///
/// # Errors
/// [`PictureError`].
pub(crate) fn letter(
    device: DeviceName,
    frame: &Frame,
    (now_ns, ages): (i64, Ages),
    why_not: Option<&str>,
    (origin, stamp): (Origin, Stamp),
) -> Result<Letter, PictureError> {
    let plane = frame
        .header()
        .slice_plane()
        .map_err(|e| PictureError::Plane(e.to_string()))?;
    let image = of_plane(&plane.ok_or(PictureError::NoPlace)?).ok_or(PictureError::TooLarge)?;
    let claim = claim(frame, now_ns, ages).filter(|_| why_not.is_none());
    let rgba = frame.shown(now_ns, ages).rgba;
    let pixels = match claim {
        Some(_) => without_alpha(rgba),
        None => vec![0; rgba.len() / 4 * 3],
    };
    let status = match (claim, why_not) {
        (_, Some(why)) => format!("COVERED: {why}"),
        (None, None) => format!("COVERED: {GROWN_OLD}"),
        (Some(FrameState::Live), None) if origin.is_present() => "LIVE".to_owned(),
        (Some(FrameState::Live), None) => "VALID".to_owned(),
        (Some(FrameState::Stale), None) => "STALE".to_owned(),
        (Some(FrameState::Requested | FrameState::Look), None) => "NOT FOLLOWING".to_owned(),
        (Some(FrameState::Lost(reason)), None) => format!("LOST: {}", reason.words()),
    };
    let metadata = Metadata::EMPTY
        .with("ImageStatus", Text::new(&status))
        .with("SessionStatus", Text::new(origin.session()))
        .with("PoseNumber", Text::new(&frame.header().stamp.seq.to_string()));
    Ok(Letter::new(Message {
        stamp,
        metadata,
        ..Message::new(device, Body::Image(image))
    })
    .with(Arc::new(Voxels::Bytes(pixels))))
}

/// Red, green, blue: what covers what is in no image of a view.
fn without_alpha(rgba: &[u8]) -> Vec<u8> {
    let mut out = Vec::with_capacity(rgba.len() / 4 * 3);
    for [r, g, b, _] in rgba.as_chunks::<4>().0 {
        out.extend([*r, *g, *b]);
    }
    out
}

/// The devices of the scene's views, in their order. A name that is too long, or that is another's, gives way to the view's number.
pub(crate) fn devices<'a>(names: impl Iterator<Item = &'a str>, taken: &[DeviceName]) -> Vec<DeviceName> {
    let mut all: Vec<DeviceName> = Vec::new();
    for (at, name) in names.enumerate() {
        let own = DeviceName::new(name).ok();
        let own = own.filter(|own| !own.is_empty() && !taken.contains(own) && !all.contains(own));
        let numbered = || DeviceName::new(&format!("view.{}", at + 1)).unwrap_or_default();
        all.push(own.unwrap_or_else(numbered));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tell::named;

    #[test]
    fn views_have_names_of_their_own_whatever_the_scene_calls_them() {
        let names = [
            "axial-local",
            "Volume",
            "axial-local",
            "a-name-that-is-much-too-long",
            "",
        ];
        let found = devices(names.into_iter(), &[named("Volume")]);
        let texts: Vec<String> = found.iter().map(ToString::to_string).collect();
        assert_eq!(texts, ["axial-local", "view.2", "view.3", "view.4", "view.5"]);
    }

    #[test]
    fn pixels_keep_their_colours() {
        assert_eq!(without_alpha(&[1, 2, 3, 255, 4, 5, 6, 255]), [1, 2, 3, 4, 5, 6]);
    }
}

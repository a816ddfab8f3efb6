//! What a model of organs says of the tube, of the very image that the sight is in step with.

use bus::message::{FrameState, TissueShown};

use super::{Known, Tone};

/// How organs are shown, and what they do to the tube.
#[derive(Debug, Clone, PartialEq)]
pub struct Organs {
    /// As on images.
    pub word: &'static str,
    /// A warning wherever organs are not where a settled state has them.
    pub tone: Tone,
    /// The force on the tube, and what is uncertain of it, in words; empty where nothing is known.
    pub force: String,
}

/// `None` where the scene moves no organs.
pub fn organs(known: &Known<'_>) -> Option<Organs> {
    known.scene.tissue.as_ref()?;
    let header = known.sighted();
    let shown = header.and_then(|header| TissueShown::from_code(header.stamp.tissue));
    let word = match shown {
        Some(TissueShown::Settled) => "MODEL",
        Some(TissueShown::Approximate) => "MODEL NOT SETTLED",
        Some(TissueShown::Late) => "TISSUE LATE",
        Some(TissueShown::CatchingUp) => "TISSUE CATCHING UP",
        Some(TissueShown::Refused) => "TISSUE REFUSED",
        Some(TissueShown::Rigid) => "ORGANS AT REST",
        Some(TissueShown::None) | None => "ORGANS NOT KNOWN",
    };
    // A force of a moment ago is none of now.
    let is_current = |state| matches!(state, FrameState::Live | FrameState::Requested);
    let stamp = header.map(|header| header.stamp);
    let stamp = stamp.filter(|stamp| stamp.state_at(known.now_ns, known.ages()).is_some_and(is_current));
    // Nor is where organs were.
    let (word, shown) = match stamp {
        Some(_) => (word, shown),
        None => ("ORGANS NOT KNOWN", None),
    };
    let force = stamp.and_then(|stamp| stamp.force()).map(|(force, error)| {
        let error = error.map_or_else(|| "UNKNOWN".to_owned(), |error| format!("{error:.2}"));
        format!("{force:.2} N \u{b1}{error} (95 %)")
    });
    Some(Organs {
        word,
        tone: match shown {
            Some(TissueShown::Settled) => Tone::Quiet,
            _ => Tone::Warning,
        },
        force: force.unwrap_or_default(),
    })
}

//! The refusals of a marker's calibration in the numbers of its file, with what a person can do about each.

use crate::commands::common::OwnError;
use std::path::PathBuf;

use calib::bundle::{Mislabelled, Refused};

/// Why frames that were read well give no marker.
#[derive(Debug, thiserror::Error)]
#[error("marker calibration from the {frames} frames of {path}: {refused}. {}", advice(.refused))]
pub(crate) struct NoMarker {
    pub(crate) frames: usize,
    pub(crate) path: PathBuf,
    pub(crate) refused: Box<Refused>,
}

impl OwnError for NoMarker {}

/// The refusal with the views' places in the recording replaced by their numbers in the file.
pub(super) fn numbered(refused: Refused, numbers: &[usize]) -> Refused {
    let number = |view: usize| numbers.get(view).copied().unwrap_or(view);
    let all = |views: Vec<usize>| views.into_iter().map(number).collect::<Vec<_>>();
    match refused {
        Refused::Twice { view, emitter } => Refused::Twice {
            view: number(view),
            emitter,
        },
        Refused::BadNoise { view, emitter } => Refused::BadNoise {
            view: number(view),
            emitter,
        },
        Refused::NoSuchEmitter {
            view,
            emitter,
            emitters,
        } => Refused::NoSuchEmitter {
            view: number(view),
            emitter,
            emitters,
        },
        Refused::Mislabelled(list) => Refused::Mislabelled(
            list.into_iter()
                .map(|m| Mislabelled {
                    views: all(m.views),
                    ..m
                })
                .collect(),
        ),
        Refused::Mirrored { views, of } => Refused::Mirrored { views: all(views), of },
        Refused::Inconsistent {
            views,
            emitters,
            residual_mm,
            limit_mm,
        } => Refused::Inconsistent {
            views: all(views),
            emitters,
            residual_mm,
            limit_mm,
        },
        Refused::Outliers {
            rejected,
            sightings,
            allowed,
            gate,
            view,
            emitter,
            worst_mm,
        } => Refused::Outliers {
            rejected,
            sightings,
            allowed,
            gate,
            view: number(view),
            emitter,
            worst_mm,
        },
        other => other,
    }
}

fn advice(refused: &Refused) -> &'static str {
    match refused {
        Refused::Collinear { .. } => {
            "Use a marker with three emitters or more off a line, and bring them into view together"
        }
        Refused::Seldom { .. } => {
            "Turn those emitters towards the localizer and record on, or leave them out with --allow-missing; --emitters says \
             how many there are"
        }
        Refused::Unconnected { .. } => {
            "Turn the marker in small steps, so that three emitters stay in view from one to the next"
        }
        Refused::Mislabelled(_) => "Exchange the numbers in the file, or the plugs of these emitters, and record again",
        Refused::Mirrored { .. } | Refused::MirroredDesign { .. } => {
            "Check the signs of the localizer's axes and the order of the emitters"
        }
        Refused::Inconsistent { .. } => {
            "Check whether the marker is bent or an emitter loose, and the noise given by --sigma-mm"
        }
        Refused::OffDesign { .. } | Refused::NoDesign(_) => {
            "Check that the drawing is of this marker, or widen --tolerance-mm"
        }
        Refused::Outliers { .. } => "Look for reflections and for a loose emitter, or check --sigma-mm",
        Refused::OnePlace { .. } | Refused::Torn { .. } => {
            "Check the numbers of these emitters, and whether a plug or the emitter was changed while recording; record again"
        }
        Refused::Weak { .. } | Refused::NoConvergence { .. } => "Record more frames, from more sides",
        Refused::Twice { .. } | Refused::NoSuchEmitter { .. } | Refused::NotFinite { .. } => {
            "Check that frame in the file"
        }
        Refused::BadNoise { .. } | Refused::Unmatched { .. } => "Check the columns cxx to czz of that frame",
    }
}

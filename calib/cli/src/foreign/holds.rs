//! What a transform of a file maps, which no file of ITK says.

use clap::ValueEnum;
use exchange::{itk, turned_to};
use geometry::{Frame, Rigid};

/// What a file's transform maps: points of the second frame to points of the first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Holds {
    /// Points of the tool to the marker
    MarkerFromTool,
    /// Points of the marker to the tool
    ToolFromMarker,
    /// Points of the localizer to the CT
    CtFromTracker,
    /// Points of the CT to the localizer
    TrackerFromCt,
    /// Points of the patient's marker to the CT
    CtFromReference,
    /// Points of the CT to the patient's marker
    ReferenceFromCt,
    /// What 3D Slicer saves of a transform node whose matrix takes the tool to the marker, or the localizer to the patient (RAS)
    SlicerNode,
}

impl Holds {
    /// The word on the command line.
    pub(super) fn word(self) -> String {
        self.to_possible_value()
            .map_or_else(String::new, |value| value.get_name().to_owned())
    }

    /// Whether the file holds `to_from_from` as it is (true), or its inverse (false); `None`: neither.
    pub(super) fn way<To: Frame, From: Frame>(self) -> Option<bool> {
        let [to, from] = [To::NAME, From::NAME].map(str::to_ascii_lowercase);
        let word = self.word();
        match word == format!("{to}-from-{from}") {
            true => Some(true),
            false => (word == format!("{from}-from-{to}")).then_some(false),
        }
    }

    /// What is to be written of a registration or a tool's frame; `None` where this says nothing of it. `is_patient`: `To` is the patient,
    /// whose axes are RAS in 3D Slicer; a tool's or localizer's are what they are in both.
    pub(super) fn written<To: Frame, From: Frame>(self, given: &Rigid<To, From>, is_patient: bool) -> Option<String> {
        if self == Self::SlicerNode {
            let node = if is_patient { turned_to(given) } else { *given };
            return Some(itk::write(&itk::slicer_file(&node)));
        }
        Some(match self.way::<To, From>()? {
            true => itk::write(given),
            false => itk::write(&given.inverse()),
        })
    }
}

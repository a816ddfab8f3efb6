//! The `calib` program.

use calib_cli::cli::Hands;
use calib_cli::{Delivered, Follow, Loaded, Seen};
use geometry::{Marker, Tool, Uncertain};
use scene::Scene;
use tracker_proc::{Markers, PosedMarkers};

fn main() -> std::process::ExitCode {
    calib_cli::cli::main(Hands {
        load: |spec| {
            let (volume, told) = volume_loader::load_told(spec)?;
            Ok(Loaded {
                volume,
                modality: told.modality,
                warnings: told.warnings,
            })
        },
        labels: volume_loader::load_labels,
        label_names: |path| Ok(volume_loader::label_names(path)?),
        follow,
    })
}

/// The markers of a run as the tracker follows them.
enum Following {
    /// By emitters that a localizer sees.
    Emitters(Box<Markers>),
    /// By poses that a localizer makes.
    Posed(Box<PosedMarkers>),
}

fn follow(scene: &Scene) -> Result<Box<dyn Follow>, Box<dyn std::error::Error + Send + Sync>> {
    Ok(Box::new(match PosedMarkers::of(scene)? {
        Some(markers) => Following::Posed(Box::new(markers)),
        None => Following::Emitters(Box::new(Markers::of(scene)?)),
    }))
}

impl Follow for Following {
    fn has_reference(&self) -> bool {
        match self {
            Self::Emitters(markers) => markers.has_reference(),
            Self::Posed(markers) => markers.has_reference(),
        }
    }

    fn marker_from_tool(&self) -> Result<Uncertain<Marker, Tool>, String> {
        match self {
            Self::Emitters(markers) => markers.marker_from_tool(),
            Self::Posed(markers) => markers.marker_from_tool(),
        }
    }

    fn see(&mut self, frame: Delivered<'_>, now_ns: i64) -> Result<Seen, String> {
        let seen = match (self, frame) {
            (Self::Emitters(markers), Delivered::Emitters(frame)) => markers.see(frame, now_ns)?,
            (Self::Posed(markers), Delivered::Markers(frame)) => markers.see(frame, now_ns)?,
            // Both follow from the scene's source.
            _ => return Err("a frame of another kind than the scene's localizer delivers".to_owned()),
        };
        Ok(Seen {
            marker: seen.marker,
            reference: seen.reference,
        })
    }
}

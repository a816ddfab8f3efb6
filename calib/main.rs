//! The `calib` program.

use calib_cli::cli::Hands;
use calib_cli::{Delivered, Follow, Loaded, Seen};
use geometry::{Marker, Tool, Uncertain};
use scene::Scene;
use tracker_proc::Following;

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
struct Tracked(Following);

fn follow(scene: &Scene) -> Result<Box<dyn Follow>, Box<dyn std::error::Error + Send + Sync>> {
    Ok(Box::new(Tracked(Following::of(scene)?)))
}

impl Follow for Tracked {
    fn has_reference(&self) -> bool {
        self.0.has_reference()
    }

    fn marker_from_tool(&self) -> Result<Uncertain<Marker, Tool>, String> {
        self.0.marker_from_tool()
    }

    fn see(&mut self, frame: Delivered<'_>, now_ns: i64) -> Result<Seen, String> {
        let seen = match frame {
            Delivered::Emitters(frame) => self.0.see_emitters(frame, now_ns)?,
            Delivered::Markers(frame) => self.0.see_markers(frame, now_ns)?,
        };
        Ok(Seen {
            marker: seen.marker,
            reference: seen.reference,
        })
    }
}

//! The `recorder` process.

use recorder::edit::export::follow::{Delivered, Follow, Seen};
use scene::Scene;
use tracker_proc::{Markers, PosedMarkers};

fn main() -> std::process::ExitCode {
    recorder::cli::main(follow)
}

/// The markers of a scene as the tracker follows them.
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
    fn see(&mut self, frame: Delivered<'_>, now_ns: i64) -> Result<Seen, String> {
        let seen = match (self, frame) {
            (Self::Emitters(markers), Delivered::Emitters(frame)) => markers.see(frame, now_ns)?,
            (Self::Posed(markers), Delivered::Markers(frame)) => markers.see(frame, now_ns)?,
            // Both follow from the scene's source.
            _ => return Err("a frame of another kind than the scene's localizer delivers".to_owned()),
        };
        Ok(Seen {
            marker: seen.marker.transform(),
            reference: seen.reference.map(|pose| pose.transform()),
        })
    }
}

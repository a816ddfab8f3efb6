//! The `recorder` process.

use recorder::edit::export::follow::{Delivered, Follow, Seen};
use scene::Scene;
use tracker_proc::Following;

fn main() -> std::process::ExitCode {
    recorder::cli::main(follow)
}

/// The markers of a recording's scene as the tracker follows them.
struct Tracked(Following);

fn follow(scene: &Scene) -> Result<Box<dyn Follow>, Box<dyn std::error::Error + Send + Sync>> {
    Ok(Box::new(Tracked(Following::of(scene)?)))
}

impl Follow for Tracked {
    fn see(&mut self, frame: Delivered<'_>, now_ns: i64) -> Result<Seen, String> {
        let seen = match frame {
            Delivered::Emitters(frame) => self.0.see_emitters(frame, now_ns)?,
            Delivered::Markers(frame) => self.0.see_markers(frame, now_ns)?,
        };
        Ok(Seen {
            marker: seen.marker.transform(),
            reference: seen.reference.map(|pose| pose.transform()),
        })
    }
}

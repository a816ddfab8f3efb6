//! The `calib` program.

use bus::message::EmitterFrame;
use calib_cli::cli::Hands;
use calib_cli::{Follow, Seen};
use geometry::{Marker, Tool, Uncertain};
use scene::Scene;
use tracker_proc::Markers;

fn main() -> std::process::ExitCode {
    calib_cli::cli::main(Hands {
        load: volume_loader::load,
        follow,
    })
}

/// The markers of a run as the tracker follows them.
struct Following(Markers);

fn follow(scene: &Scene) -> Result<Box<dyn Follow>, Box<dyn std::error::Error + Send + Sync>> {
    Ok(Box::new(Following(Markers::of(scene)?)))
}

impl Follow for Following {
    fn has_reference(&self) -> bool {
        self.0.has_reference()
    }

    fn marker_from_tool(&self) -> Result<Uncertain<Marker, Tool>, String> {
        self.0.marker_from_tool()
    }

    fn see(&mut self, frame: &EmitterFrame, now_ns: i64) -> Result<Seen, String> {
        let seen = self.0.see(frame, now_ns)?;
        Ok(Seen {
            marker: seen.marker,
            reference: seen.reference,
        })
    }
}

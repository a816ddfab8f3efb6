//! The `localizer-proc` process.

use std::path::Path;

use geometry::Frame as GeometryFrame;
use localizer_proc::simulate::{Hands, Room, RoomFrame, RoomMarker, RoomPose};
use tracker_proc::operating_room::{Fitted, PosedRoom};

fn main() -> std::process::ExitCode {
    localizer_proc::cli::main(Hands { room })
}

/// The simulated operating room of a scene, as a run of the same scene has it.
fn room(scene: &Path) -> Result<Box<dyn Room>, Box<dyn std::error::Error + Send + Sync>> {
    let scene = pilot::scene_of_run(scene)?;
    let grid = *volume_loader::open(&scene.volume, scene.seed)?.grid();
    Ok(Box::new(InRoom(PosedRoom::of(&scene, Some(&grid))?)))
}

struct InRoom(PosedRoom);

impl Room for InRoom {
    fn emitters_mm(&self) -> (Vec<[f64; 3]>, Option<Vec<[f64; 3]>>) {
        self.0.emitters_mm()
    }

    fn newest(&mut self, after_ns: i64, until_ns: i64) -> Option<u64> {
        self.0.newest(after_ns, until_ns)
    }

    fn frame(&self, number: u64) -> RoomFrame {
        let posed = self.0.frame(number);
        let seen = &posed.frame;
        RoomFrame {
            number,
            device_ns: posed.frame.t_device_ns,
            tool: RoomMarker {
                pose: posed.tool.map(pose),
                emitters_mm: seen.tool.iter().map(|one| (one.emitter, one.place.mm())).collect(),
            },
            patient: posed.reference.map(|reference| RoomMarker {
                pose: reference.map(pose),
                emitters_mm: seen.reference.iter().map(|one| (one.emitter, one.place.mm())).collect(),
            }),
        }
    }
}

fn pose<M: GeometryFrame>(fitted: Fitted<M>) -> RoomPose {
    RoomPose {
        q: fitted.tracker_from_marker.quaternion(),
        t_mm: fitted.tracker_from_marker.translation_mm(),
        error_mm: fitted.error_mm,
    }
}

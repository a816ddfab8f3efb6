//! A moment of a replay as files: the image of every view, and what was known then as JSON.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use bus::message::{Ages, Guide, ToolPose, Tracked};
use bus::{Bus, BusError};
use scene::Scene;
use serde::Serialize;

use super::renderers::{self, DrawnError, Renderer};

/// A renderer that was just killed is there again within so many requests of a second.
const TRIES: usize = 3;
/// The facts, in the folder of a moment.
const FACTS: &str = "moment.json";

/// Why a moment was not written.
#[derive(Debug, thiserror::Error)]
pub enum MomentError {
    /// The folder, or the file of facts.
    #[error(
        "writing the moment to {path}: {source}. Begin the replay with `--out DIR`, a folder that you may write into"
    )]
    Write {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// An image.
    #[error(transparent)]
    Drawn(#[from] DrawnError),
    /// The bus.
    #[error(transparent)]
    Bus(#[from] BusError),
}

/// Writes moments.
#[derive(Debug)]
pub struct Moments {
    folder: PathBuf,
    renderers: Vec<Renderer>,
    ages: Ages,
}

/// Of which replay a moment is.
#[derive(Debug, Clone, Copy)]
pub struct Whence<'a> {
    /// The recording.
    pub recording: &'a Path,
    /// The examination that it was made in, where it says so.
    pub recorded_volume: Option<&'a str>,
    /// The examination that is shown.
    pub shown_volume: &'a str,
    /// The zero of the seconds that people name, ns.
    pub zero_ns: i64,
    /// Whether it is known for how long the measurement had stood still.
    pub standstill_judged: bool,
}

/// What `moment.json` holds. Keys are only ever added.
#[derive(Debug, Serialize)]
struct Facts {
    /// Lengths are mm, places LPS, times of the recorded run's clock.
    format: &'static str,
    recording: String,
    recorded_volume_hash: Option<String>,
    volume_hash: String,
    same_examination: bool,
    seq: u64,
    /// Behind the recording's first pose.
    seconds: f64,
    t_capture_ns: i64,
    t_publish_ns: i64,
    registration_id: String,
    /// valid, or why there is no pose
    status: String,
    /// Whether it is known for how long the measurement had stood still; without, FROZEN MEASUREMENT cannot be told.
    standstill_judged: bool,
    pose: Option<Pose>,
    target: Option<Target>,
    /// File names, by view.
    images: Vec<String>,
    /// Views without an image, and why.
    left_out: Vec<String>,
}

#[derive(Debug, Serialize)]
struct Pose {
    tip_mm: [f64; 3],
    /// Of `ct_from_tool`.
    quaternion_wxyz: [f64; 4],
    /// 95 % of the errors predicted at the tip are below.
    tip_95_mm: Option<f64>,
    /// Upper triangle by rows of the covariance of (rotation vector, translation); rad and mm.
    covariance: Option<[f64; 21]>,
}

/// What was aimed at when the pose was captured.
#[derive(Debug, Serialize)]
struct Target {
    name: String,
    centre_mm: [f64; 3],
    radius_mm: f64,
    entry_mm: Option<[f64; 3]>,
    stop_mm: f64,
    plan_id: String,
    /// From the tip to its centre, where there is a pose.
    distance_mm: Option<f64>,
}

impl Moments {
    /// Into folders in `folder`.
    ///
    /// # Errors
    /// [`BusError::Open`].
    pub fn open(bus: &Bus, scene: &Scene, folder: &Path) -> Result<Self, BusError> {
        Ok(Self {
            folder: folder.to_owned(),
            renderers: renderers::open(bus, scene)?,
            ages: Ages::of(&scene.limits),
        })
    }

    /// Writes the moment of `pose`, with what was aimed at then, into a folder of its own, whose path it returns with the number of images.
    /// Calls `alive` now and then.
    ///
    /// # Errors
    /// [`MomentError`].
    pub fn write(
        &self,
        pose: &ToolPose,
        guide: Option<&Guide>,
        whence: Whence<'_>,
        alive: &mut dyn FnMut() -> Result<(), BusError>,
    ) -> Result<(PathBuf, usize), MomentError> {
        let folder = self.folder.join(folder_name(pose));
        // What an earlier replay left of another recording's pose of this number is not to lie beside this one's.
        let emptied = fs::remove_dir_all(&folder).or_else(|error| match error.kind() {
            io::ErrorKind::NotFound => Ok(()),
            _ => Err(error),
        });
        let failed = |path: &Path| {
            let path = path.to_owned();
            move |source| MomentError::Write { path, source }
        };
        emptied
            .and_then(|()| fs::create_dir_all(&folder))
            .map_err(failed(&folder))?;
        let (images, left_out) = self.images(&folder, pose, alive)?;
        let count = images.len();
        let facts = Facts {
            images,
            left_out,
            ..facts(pose, guide, whence)
        };
        let path = folder.join(FACTS);
        let text = serde_json::to_string_pretty(&facts).unwrap_or_default() + "\n";
        fs::write(&path, text).map_err(failed(&path))?;
        Ok((folder, count))
    }

    fn images(
        &self,
        folder: &Path,
        pose: &ToolPose,
        alive: &mut dyn FnMut() -> Result<(), BusError>,
    ) -> Result<(Vec<String>, Vec<String>), MomentError> {
        let (mut images, mut left_out) = (Vec::new(), Vec::new());
        for renderer in &self.renderers {
            let drawn = renderer.ask(pose, TRIES, alive)?;
            for view in &renderer.views {
                let name = format!("{}.png", view.0);
                let written = match &drawn {
                    Ok(()) => renderers::write(&folder.join(&name), view, pose, self.ages)?,
                    Err(_) => false,
                };
                match (written, &drawn) {
                    (true, _) => images.push(name),
                    (false, Err(why)) => left_out.push(format!("{}: {why}", view.0)),
                    (false, Ok(())) => left_out.push(format!("{}: another image was drawn meanwhile", view.0)),
                }
            }
        }
        Ok((images, left_out))
    }
}

/// A source that was started anew may count from 0 again: the capture, ms, as well.
fn folder_name(pose: &ToolPose) -> String {
    format!("pose-{:06}-{}", pose.seq, pose.t_capture_ns / 1_000_000)
}

fn facts(pose: &ToolPose, guide: Option<&Guide>, whence: Whence<'_>) -> Facts {
    let tracked = pose.tracked();
    let status = match &tracked {
        Ok(Tracked::Valid(_)) => "valid".to_owned(),
        Ok(Tracked::Lost(reason)) => format!("lost: {}", reason.words()),
        Err(error) => format!("refused: {error}"),
    };
    let is_known = pose.tip_95_mm().is_some();
    let valid = matches!(tracked, Ok(Tracked::Valid(_))).then_some(Pose {
        tip_mm: pose.t_mm,
        quaternion_wxyz: pose.q,
        tip_95_mm: pose.tip_95_mm(),
        covariance: is_known.then_some(pose.covariance),
    });
    Facts {
        format: "trocar/Moment/1",
        recording: whence.recording.display().to_string(),
        recorded_volume_hash: whence.recorded_volume.map(str::to_owned),
        volume_hash: whence.shown_volume.to_owned(),
        same_examination: whence.recorded_volume == Some(whence.shown_volume),
        seq: pose.seq,
        seconds: bus::clock::ms(pose.t_publish_ns.saturating_sub(whence.zero_ns)) / 1e3,
        t_capture_ns: pose.t_capture_ns,
        t_publish_ns: pose.t_publish_ns,
        registration_id: format!("{:016x}", pose.registration_id),
        status,
        standstill_judged: whence.standstill_judged,
        target: target(guide, valid.as_ref()),
        pose: valid,
        images: Vec::new(),
        left_out: Vec::new(),
    }
}

fn target(guide: Option<&Guide>, pose: Option<&Pose>) -> Option<Target> {
    let guide = guide?;
    let chosen = guide.chosen().ok().flatten()?;
    let centre_mm = chosen.centre.mm();
    let distance = |pose: &Pose| {
        let [x, y, z] = std::array::from_fn(|k| centre_mm[k] - pose.tip_mm[k]);
        f64::hypot(x, y).hypot(z)
    };
    Some(Target {
        name: chosen.name,
        centre_mm,
        radius_mm: chosen.radius_mm,
        entry_mm: chosen.entry.map(geometry::Point::mm),
        stop_mm: chosen.stop_mm,
        plan_id: format!("{:016x}", guide.plan_id),
        distance_mm: pose.map(distance),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;
    use bus::message::{Chosen, Lost};
    use geometry::Point;

    fn whence(recorded_volume: Option<&str>) -> Whence<'_> {
        Whence {
            recording: Path::new("s.mcap"),
            recorded_volume,
            shown_volume: "aa",
            zero_ns: 0,
            standstill_judged: true,
        }
    }

    #[test]
    fn poses_of_one_number_have_folders_of_their_own() {
        let pose = testing::pose(19);
        let anew = ToolPose {
            t_capture_ns: pose.t_capture_ns + 500_000_000,
            ..pose
        };
        assert_ne!(folder_name(&pose), folder_name(&anew));
    }

    #[test]
    fn a_moment_says_how_far_the_chosen_target_is_and_of_which_examination() {
        let mut pose = testing::pose(7);
        let chosen = Chosen {
            name: "node".to_owned(),
            centre: Point::new(pose.t_mm[0] + 3.0, pose.t_mm[1] - 4.0, pose.t_mm[2] + 12.0),
            radius_mm: 2.5,
            entry: None,
            stop_mm: 0.0,
        };
        let guide = Guide::default().choosing(Some(&chosen), 9);
        let said = facts(&pose, Some(&guide), whence(Some("aa")));
        let target = said.target.unwrap();
        assert!((target.distance_mm.unwrap() - 13.0).abs() < 1e-12);
        assert!(said.same_examination && said.status == "valid");
        assert!(!facts(&pose, None, whence(Some("bb"))).same_examination);
        assert!(!facts(&pose, None, whence(None)).same_examination);
        // A lost pose has no numbers, and no distance.
        pose.set(Tracked::Lost(Lost::NotSeen));
        let said = facts(&pose, Some(&guide), whence(None));
        assert!(said.pose.is_none() && said.target.unwrap().distance_mm.is_none());
        assert!(said.status.starts_with("lost: "), "{}", said.status);
    }
}

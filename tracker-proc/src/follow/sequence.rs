//! Poses of markers from a sequence of the PLUS toolkit, at the times of its stamps.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

use bus::clock;
use bus::message::ProcessState;
use bus::process::Process;
use calib::file::sequence::{Frame, Pose, frames, header_end, transforms};
use calib::pose::Lost as BodyLost;
use geometry::{Frame as GeometryFrame, Point, Tracker, Uncertain};
use scene::operating_room::Deviations;
use scene::tracking::SequenceSource;

use super::play_error::{MAX_BYTES, MAX_S, PlayError};
use super::{Follower, Stamp, examination, posed};
use crate::chain::{Found, Links, Reason};
use crate::errors::errors_about;
use crate::output::{LOOK_UP, OVER, Output};
use crate::run_error::RunError;
use crate::simulated_time::SimulatedTime;

/// Plays the sequence once, and then is silent until asked to stop.
///
/// # Errors
/// [`RunError`].
pub(crate) fn follow(process: &mut Process, output: &Output, spec: &SequenceSource) -> Result<(), RunError> {
    let mut played = Played::load(spec)?;
    played.keep(|due_ns| !process.run.is_beyond(due_ns));
    let Some(examination) = examination(process)? else {
        return Ok(());
    };
    let source = posed::source(&spec.markers, process.scene.tracker.ct_from_tracker);
    let mut follower = Follower::new(process, output, source, examination);
    // A process that starts while the sequence is played begins with the next frame.
    let Some(start) = output.start(process)? else {
        return Ok(());
    };
    if process.run.simulated_time {
        return played.follow_in_simulated_time(process, &mut follower);
    }
    let mut next = match start.is_first {
        true => 0,
        false => played.due(process.clock().now_ns() - start.at_ns),
    };
    while !process.stop.is_set() {
        let due = played.due(process.clock().now_ns() - start.at_ns);
        for seq in next..due {
            played.frame(seq, &mut follower, process)?;
        }
        next = next.max(due);
        follower.tend(process);
        let has_ended = next == played.frames.len();
        let words = || match has_ended {
            true => format!("the sequence has ended; {}", follower.words()),
            false => follower.words(),
        };
        match process.run.duration_ns.is_some() && has_ended {
            true => process.beat(ProcessState::Stopping, OVER)?,
            false => process.beat_with(ProcessState::Ready, words)?,
        }
        let look_up = process.clock().now_ns() + clock::ns(LOOK_UP);
        let due_ns = played.due_ns.get(next).map_or(look_up, |due| due + start.at_ns);
        process.clock().sleep_until(due_ns.min(look_up));
    }
    process.beat(ProcessState::Stopping, "asked to stop")?;
    Ok(())
}

/// A sequence that is played.
struct Played {
    frames: Vec<Frame>,
    /// When each frame comes, ns from the beginning: at its time, and not before those before it.
    due_ns: Vec<i64>,
    noise: Option<Deviations>,
}

impl Played {
    fn load(spec: &SequenceSource) -> Result<Self, PlayError> {
        let path = &spec.file;
        let text = header(path)?;
        let failed = |source| PlayError::Sequence {
            path: path.clone(),
            source,
        };
        let marker = match &spec.markers.marker {
            Some(marker) => marker.clone(),
            None => only(&text, path)?,
        };
        let names = [
            Some(marker.as_str()),
            spec.markers.reference.as_ref().map(|(name, _)| name.as_str()),
        ];
        let names: Vec<&str> = names.into_iter().flatten().collect();
        let frames = frames(&text, &names).map_err(failed)?;
        let mut due_ns: Vec<i64> = Vec::with_capacity(frames.len());
        for frame in &frames {
            let t_s = frame
                .t_s
                .filter(|t_s| t_s.abs() <= MAX_S)
                .ok_or_else(|| PlayError::NoTime {
                    path: path.clone(),
                    frame: frame.number,
                })?;
            let first_s = frames[0].t_s.unwrap_or(t_s);
            let latest = due_ns.last().copied().unwrap_or(0);
            due_ns.push(clock::seconds(t_s - first_s).max(latest));
        }
        let noise = spec.markers.noise;
        // Here, so that it is refused before the run begins.
        if let Some(noise) = noise {
            errors_about(Point::<Tracker>::new(0.0, 0.0, 0.0), noise)?;
        }
        Ok(Self { frames, due_ns, noise })
    }

    /// How many frames are due at `t_ns`.
    fn due(&self, t_ns: i64) -> usize {
        self.due_ns.partition_point(|due| *due <= t_ns)
    }

    /// Leaves out what comes later than is wanted.
    fn keep(&mut self, wanted: impl Fn(i64) -> bool) {
        self.frames
            .truncate(self.due_ns.partition_point(|due_ns| wanted(*due_ns)));
        self.due_ns.truncate(self.frames.len());
    }

    /// Plays it in simulated time.
    fn follow_in_simulated_time(&self, process: &mut Process, follower: &mut Follower<'_>) -> Result<(), RunError> {
        let output = follower.output;
        let mut time = SimulatedTime::open(process, output)?;
        for (seq, due_ns) in self.due_ns.iter().enumerate() {
            let at_ns = output.start_ns() + due_ns;
            if SimulatedTime::is_past(output, at_ns) {
                continue;
            }
            time.expect(process, seq as u64, at_ns, at_ns)?;
            follower.tend(process);
            if !self.frame(seq, follower, process)? {
                time.forget();
            }
            if !time.wait(process, output, seq as u64)? {
                break;
            }
        }
        Ok(time.end(process, output)?)
    }

    /// Returns whether there was a pose.
    fn frame(&self, seq: usize, follower: &mut Follower<'_>, process: &mut Process) -> Result<bool, RunError> {
        let frame = &self.frames[seq];
        let t_device_ns = clock::seconds(frame.t_s.unwrap_or_default());
        let stamp = Stamp {
            seq: seq as u64,
            t_device_ns,
            t_order_ns: t_device_ns,
            t_capture_ns: follower.output.start_ns() + self.due_ns[seq],
            visible: 0,
        };
        if !follower.admit(&stamp, process) {
            return Ok(false);
        }
        let places = [0, 1].map(|i| frame.poses.get(i).copied().flatten().into_iter().flat_map(numbers));
        follower.frame(&stamp, places, process, |links| self.solve(frame, links))?;
        Ok(true)
    }

    fn solve(&self, frame: &Frame, links: &Links) -> Result<Found, Reason> {
        let pose = |i: usize| frame.poses.get(i).copied().flatten();
        let marker = self.uncertain(pose(0)).ok_or(Reason::Tool(BodyLost::NotSeen))?;
        let reference = |_| self.uncertain(pose(1)).ok_or(Reason::Reference(BodyLost::NotSeen));
        Ok(Found::of(links.ct_from_tool(marker, reference)?))
    }

    /// The pose with the noise that the scene states, about the marker's origin.
    fn uncertain<F: GeometryFrame>(&self, pose: Option<Pose>) -> Option<Uncertain<Tracker, F>> {
        posed::uncertain(pose?.rigid()?, self.noise)
    }
}

/// The only transform of a sequence.
fn only(text: &str, path: &Path) -> Result<String, PlayError> {
    let there = transforms(text);
    if there.len() > 1 {
        return Err(PlayError::SeveralTransforms {
            path: path.to_owned(),
            found: there.into_iter().take(10).collect::<Vec<_>>().join(", "),
        });
    }
    Ok(there.first().copied().unwrap_or_default().to_owned())
}

/// The header of the file as text.
fn header(path: &Path) -> Result<String, PlayError> {
    let failed = |source| PlayError::Read {
        path: path.to_owned(),
        source,
    };
    // Asked for before opening: opening a pipe would wait for its writer.
    if !fs::metadata(path).map_err(failed)?.is_file() {
        return Err(failed(io::Error::other("this is not a file")));
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(failed)?;
    file.take(MAX_BYTES).read_to_end(&mut bytes).map_err(failed)?;
    let no_header = || PlayError::NoHeader { path: path.to_owned() };
    bytes.truncate(header_end(&bytes).ok_or_else(no_header)?);
    String::from_utf8(bytes).map_err(|_| no_header())
}

/// The numbers of a marker's pose.
fn numbers(pose: Pose) -> impl Iterator<Item = f64> + Clone {
    pose.quaternion.into_iter().chain(pose.translation_mm)
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use geometry::Rigid;
    use scene::tracking::PosedMarkers;

    use super::*;
    use crate::chain::Registration;

    fn spec(file: PathBuf) -> SequenceSource {
        SequenceSource {
            file,
            markers: PosedMarkers {
                marker: Some("ProbeToTracker".to_owned()),
                marker_from_tool: Rigid::identity(),
                reference: Some(("ReferenceToTracker".to_owned(), Rigid::identity())),
                noise: Some(Deviations {
                    shift_mm: 0.1,
                    turn_rad: 0.0,
                }),
            },
        }
    }

    #[test]
    fn a_recording_of_plus_has_its_one_invalid_frame_and_its_times() {
        let file = "../../shared/data/tracker-plus/TransformInterpolationTest.igs.mha";
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
        if !file.exists() {
            println!("skipped: {} is not there", file.display());
            return;
        }
        let played = Played::load(&spec(file)).unwrap();
        assert_eq!((played.frames.len(), played.due_ns[0]), (500, 0));
        // 50 Hz; a frame is due at its stamp.
        assert!(played.due_ns.is_sorted() && (9_900_000_000..10_100_000_000).contains(&played.due_ns[499]));
        assert_eq!(played.due(played.due_ns[7]), 8);
        let links = Links {
            marker_from_tool: Rigid::identity().into(),
            registration: Registration::Referenced(Rigid::identity().into()),
        };
        let lost: Vec<usize> = (0..500)
            .filter(|i| played.solve(&played.frames[*i], &links).is_err())
            .collect();
        assert_eq!(lost, [7]);
        let found = played.solve(&played.frames[0], &links).unwrap();
        // The probe's 0.1 mm; the reference's, of the same size, and nothing else.
        let trace = (found.ct_from_tool * Point::<geometry::Tool>::new(0.0, 0.0, 0.0))
            .covariance()
            .trace();
        assert!((trace - 2.0 * 0.03).abs() < 1e-6, "{trace}");
    }
}

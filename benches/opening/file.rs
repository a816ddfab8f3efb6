//! A recording as the recorder makes it, of any size, without a run.

use std::fs;
use std::path::{Path, PathBuf};

use bus::message::{Chosen, Guide, ToolPose, Tracked};
use chance::SplitMix64;
use geometry::{Ct, Point, Rigid, Tool, Vector};
use recorder::wire::proto::{self, ProcessStatus};
use recorder::wire::schema::{RunFacts, Source};
use recorder::write::pose_log::Entry;
use recorder::write::session_file::{Content, SessionFile};

/// Poses a second, and in a chunk: those of half a second.
const RATE_HZ: u64 = 60;
const PER_CHUNK: u64 = 30;
/// From one choice of a target to the next, in poses.
const CHOICE: u64 = 60 * RATE_HZ;

/// Writes a recording of about so many bytes: poses at 60 Hz with their truths, whose last digits are noise, the states of eight
/// processes each second, and a choice of a target each minute. In chunks of half a second, as the recorder has them.
pub(crate) fn make(folder: &Path, name: &str, scene: &Path, bytes: u64) -> PathBuf {
    let facts = RunFacts {
        name: "bench".to_owned(),
        epoch_ns: 0,
        registration_id: None,
        volume_hash: None,
        remade_from: None,
    };
    let path = folder.join(name);
    let mut file = SessionFile::create(&path, &Content::new(scene, &facts)).unwrap();
    let mut random = SplitMix64::new(7);
    for seq in 0.. {
        if file.bytes() >= bytes {
            break;
        }
        let (pose, truth) = (pose(seq, 0.1, &mut random), pose(seq, 0.0, &mut random));
        if seq % CHOICE == 0 {
            let guide = proto::Guide::from(&guide(seq, pose.t_capture_ns));
            file.put(Entry::Guide(pose.t_capture_ns, &guide)).unwrap();
        }
        if seq % RATE_HZ == 0 {
            states(&mut file, pose.t_capture_ns);
        }
        file.put(Entry::Pose(Source::Tool, &pose)).unwrap();
        file.put(Entry::Pose(Source::Truth, &truth)).unwrap();
        if seq % PER_CHUNK == PER_CHUNK - 1 {
            file.flush().unwrap();
        }
    }
    let made = file.finish().unwrap().path;
    // What the disk has not taken yet can not be dropped from memory either.
    fs::File::open(&made).unwrap().sync_all().unwrap();
    made
}

fn states(file: &mut SessionFile, t_ns: i64) {
    for pid in 1..9 {
        let status = ProcessStatus {
            t_ns,
            process: format!("process-{pid}"),
            pid,
            ..ProcessStatus::default()
        };
        file.put(Entry::Status(&status)).unwrap();
    }
}

fn guide(seq: u64, t_ns: i64) -> Guide {
    let chosen = Chosen {
        name: format!("node {}", seq / CHOICE % 5),
        centre: Point::new(0.0, 10.0, 20.0),
        radius_mm: 4.0,
        entry: None,
        stop_mm: 0.0,
    };
    Guide {
        t_ns,
        ..Guide::default()
    }
    .choosing(Some(&chosen), 7)
}

fn pose(seq: u64, size: f64, random: &mut SplitMix64) -> ToolPose {
    let s = seq as f64 / RATE_HZ as f64;
    let t_ns = bus::clock::seconds(s);
    let mut noise = |most: f64| random.around(0.0, most);
    let turn = Vector::new(0.3 * s.sin() + noise(size * 1e-4), -1.2, 0.7);
    let place = Vector::new(noise(size), 10.0 * s.cos() + noise(size), 10.0 * s.sin() + noise(size));
    let at: Rigid<Ct, Tool> = Rigid::from_rotation_vector(turn, place).unwrap();
    let mut pose = ToolPose {
        seq,
        t_device_ns: t_ns,
        t_capture_ns: t_ns,
        t_publish_ns: t_ns + 1_500_000,
        registration_id: 0xfeed,
        visible: 24,
        used: 24,
        fre_rms_mm: 0.2 + noise(size * 0.05),
        covariance: std::array::from_fn(|i| size * 1e-4 * (i as f64 + noise(1.0).abs())),
        ..ToolPose::EMPTY
    };
    pose.set(Tracked::Valid(at));
    pose
}

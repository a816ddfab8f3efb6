use std::fs;

use bus::clock::{Clock, monotonic_ns};
use bus::port::Publisher;

use super::*;
use crate::reader;
use crate::schema::{GROUND_TRUTH, TOOL_POSE};
use crate::testing;

const CHUNK: Duration = Duration::from_millis(500);

struct Rig {
    _tmp: tempfile::TempDir,
    run: RunContext,
    bus: Bus,
    out: PathBuf,
}

impl Rig {
    fn new() -> Self {
        let tmp = tempfile::tempdir_in("/tmp").unwrap();
        let run = RunContext::new(tmp.path(), monotonic_ns()).unwrap();
        run.store().unwrap();
        fs::write(run.scene_path(), "seed = 7\n").unwrap();
        let bus = Bus::join(&run).unwrap();
        let out = tmp.path().join("s.mcap");
        Self {
            _tmp: tmp,
            run,
            bus,
            out,
        }
    }

    fn recorder(&self) -> Recorder {
        Recorder::open(&self.bus, &self.run, CHUNK, &self.out).unwrap()
    }

    fn poses(&self, topic: &str) -> Vec<ToolPose> {
        reader::poses(&self.out, topic).unwrap().map(Result::unwrap).collect()
    }
}

impl Drop for Rig {
    fn drop(&mut self) {
        self.run.sweep();
    }
}

#[test]
fn what_is_published_is_in_the_file_bit_for_bit() {
    let rig = Rig::new();
    let tool = Publisher::open(&rig.bus, &topic::TOOL_POSE, "").unwrap();
    let truth = Publisher::open(&rig.bus, &topic::GROUND_TRUTH, "").unwrap();
    let mut recorder = rig.recorder();
    let clock = Clock::fake(0);
    let mut sent = Vec::new();
    for seq in 0..100 {
        let mut pose = testing::pose(seq);
        pose.covariance[3] = f64::from_bits(0x7ff8_0000_0000_0000 + seq);
        tool.send(pose).unwrap();
        truth.send(testing::pose(seq)).unwrap();
        sent.push(pose);
        clock.advance(Duration::from_millis(16));
        recorder.step(clock.now_ns()).unwrap();
    }
    let mut lost = ToolPose::EMPTY;
    lost.seq = 103;
    tool.send(lost).unwrap();
    sent.push(lost);
    let finished = recorder.finish(clock.now_ns()).unwrap();
    assert_eq!((finished.path.as_path(), finished.messages), (rig.out.as_path(), 201));
    let found: Vec<_> = rig.poses(TOOL_POSE).iter().map(testing::bytes).collect();
    assert_eq!(found, sent.iter().map(testing::bytes).collect::<Vec<_>>());
    assert_eq!(rig.poses(GROUND_TRUTH).len(), 100);
    let info = crate::info::info(&rig.out).unwrap();
    assert_eq!(info.tally.topics["/tf"].messages, 200);
    assert!(info.damage.is_empty());
}

#[test]
fn the_facts_name_the_registration_and_the_scene_is_attached() {
    let rig = Rig::new();
    let tool = Publisher::open(&rig.bus, &topic::TOOL_POSE, "").unwrap();
    let truth = Publisher::open(&rig.bus, &topic::GROUND_TRUTH, "").unwrap();
    let recorder = rig.recorder();
    tool.send(testing::pose(0)).unwrap();
    // The truth rests on no registration.
    truth.send(ToolPose::EMPTY).unwrap();
    recorder.finish(0).unwrap();
    let beside = reader::beside(&rig.out).unwrap();
    assert_eq!(beside.scene.as_deref(), Some("seed = 7\n"));
    let facts = beside.run.unwrap().metadata;
    assert_eq!(facts["registration_id"], "feed000000000042");
    assert_eq!(facts["epoch_ns"], rig.run.epoch_ns.to_string());
}

#[test]
fn poses_are_on_disk_one_chunk_after_they_came() {
    let rig = Rig::new();
    let tool = Publisher::open(&rig.bus, &topic::TOOL_POSE, "").unwrap();
    let mut recorder = rig.recorder();
    tool.send(testing::pose(0)).unwrap();
    recorder.step(0).unwrap();
    tool.send(testing::pose(1)).unwrap();
    recorder.step(clock::ns(CHUNK) - 1).unwrap();
    assert_eq!(recorder.progress().counters.recorded, 0);
    recorder.step(clock::ns(CHUNK)).unwrap();
    assert_eq!(recorder.progress().counters.recorded, 2);
    // What a kill at this moment leaves.
    let growing = crate::paths::recording(&rig.out);
    let seqs: Vec<_> = reader::poses(&growing, TOOL_POSE)
        .unwrap()
        .filter_map(Result::ok)
        .map(|pose| pose.seq)
        .collect();
    assert_eq!(seqs, [0, 1]);
}

#[test]
fn gaps_and_refused_poses_are_counted_and_recorded_all_the_same() {
    let rig = Rig::new();
    let tool = Publisher::open(&rig.bus, &topic::TOOL_POSE, "").unwrap();
    let mut recorder = rig.recorder();
    for seq in [4, 5, 8, 9, 11] {
        let mut pose = testing::pose(seq);
        if seq == 9 {
            pose.q[2] = f64::NAN;
        }
        tool.send(pose).unwrap();
    }
    recorder.step(0).unwrap();
    let progress = recorder.progress();
    assert_eq!(
        (progress.gaps, progress.counters.dropped, progress.counters.refused),
        (2, 3, 1)
    );
    recorder.finish(1).unwrap();
    assert_eq!(rig.poses(TOOL_POSE).len(), 5);
}

#[test]
fn a_killed_recorder_loses_nothing_it_acknowledged() {
    let rig = Rig::new();
    let tool = Publisher::open(&rig.bus, &topic::TOOL_POSE, "").unwrap();
    let mut recorder = rig.recorder();
    for seq in 0..40 {
        tool.send(testing::pose(seq)).unwrap();
    }
    recorder.step(0).unwrap();
    recorder.step(clock::ns(CHUNK)).unwrap();
    assert_eq!(recorder.progress().counters.recorded, 40);
    let killed = fs::read(crate::paths::recording(&rig.out)).unwrap();
    drop(recorder);
    fs::write(crate::paths::recording(&rig.out), killed).unwrap();
    leftovers::recover_in_background(leftovers::set_aside(&rig.out).unwrap())
        .join()
        .unwrap();
    let second = rig.recorder();
    second.finish(0).unwrap();
    let part = crate::paths::part(&rig.out, 1);
    assert_eq!(reader::poses(&part, TOOL_POSE).unwrap().map(Result::unwrap).count(), 40);
}

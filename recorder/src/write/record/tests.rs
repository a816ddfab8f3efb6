use std::fs;

use bus::clock::{Clock, monotonic_ns};
use bus::message::{Event, Guide, Heartbeat, Level, Lost, ToolPose, Tracked, Workflow};
use bus::port::Publisher;

use super::*;
use crate::read::reader;
use crate::testing;
use crate::wire::schema::{GROUND_TRUTH, LOG, STATUS, TOOL_POSE};

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
        self.recorder_of("[recording]\nchunk_s = 0.5")
    }

    fn recorder_of(&self, scene: &str) -> Recorder {
        let scene = Scene::parse(scene, Path::new("s.toml")).unwrap();
        Recorder::open(&self.bus, &self.run, &scene, &self.out).unwrap()
    }

    /// Lines of the log: who, and what.
    fn log(&self) -> Vec<(String, String)> {
        let items = crate::read::scan::open(&self.out).unwrap().map(Result::unwrap);
        let messages = items.filter_map(|item| match item {
            crate::read::scan::Item::Message(message) if message.channel.topic == LOG => Some(message),
            _ => None,
        });
        let log = |data: &[u8]| <proto::Log as prost::Message>::decode(data).unwrap();
        messages
            .map(|m| log(&m.data))
            .map(|log| (log.name, log.message))
            .collect()
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
        pose.fre_rms_mm = f64::from_bits(0x7ff8_0000_0000_0000 + seq);
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
    let info = crate::read::info::info(&rig.out).unwrap();
    assert_eq!(info.tally.topics["/tf"].messages, 200);
    assert!(info.damage.is_empty());
}

#[test]
fn ultrasound_images_are_in_the_file_bit_for_bit_and_gaps_are_counted() {
    let rig = Rig::new();
    let images = bus::port::UsImagePublisher::open(&rig.bus, 20).unwrap();
    let mut recorder = rig.recorder();
    let mut sent = Vec::new();
    for number in [0, 1, 2, 5] {
        let image = testing::us_frame(number, number, 0);
        images.send(image.header, &image.grey).unwrap();
        recorder.step(image.header.t_publish_ns).unwrap();
        sent.push(image);
    }
    let progress = recorder.progress();
    assert_eq!((progress.gaps, progress.counters.dropped), (1, 2));
    recorder.finish(1_000_000_000).unwrap();
    let session = crate::read::seek::Session::open(&rig.out).unwrap();
    let found: Vec<_> = session.us_images_from(0).unwrap().map(Result::unwrap).collect();
    assert_eq!(found, sent);
    let verified = crate::read::verify::verify(&rig.out).unwrap();
    assert!(verified.findings.is_empty(), "{:?}", verified.findings);
}

#[test]
fn what_a_person_chose_is_in_the_file_bit_for_bit() {
    let rig = Rig::new();
    let guides = Publisher::open(&rig.bus, &topic::GUIDE, "").unwrap();
    let workflows = Publisher::open(&rig.bus, &topic::WORKFLOW, "").unwrap();
    let mut sent = vec![Guide {
        radius_mm: f64::from_bits(0x7ff8_0000_0000_0001),
        ..Guide::default()
    }];
    // Before any recorder is there.
    guides.send(sent[0]).unwrap();
    let mut recorder = rig.recorder();
    guides.serve_late_joiners();
    recorder.step(1).unwrap();
    sent.push(Guide {
        t_ns: 77,
        plan_id: 5,
        flags: Guide::CHOSEN,
        name: [0xff; Guide::NAME],
        ..Guide::default()
    });
    guides.send(sent[1]).unwrap();
    let workflow = Workflow {
        t_ns: 78,
        stage: 6,
        flags: Workflow::RESEARCH,
        ..Workflow::default()
    };
    workflows.send(workflow).unwrap();
    recorder.finish(100).unwrap();
    let found: Vec<_> = reader::guides(&rig.out).unwrap().map(Result::unwrap).collect();
    // A NaN is not itself.
    let words = |guides: &[Guide]| guides.iter().map(|guide| format!("{guide:?}")).collect::<Vec<_>>();
    assert_eq!(words(&found), words(&sent));
    assert_eq!(found[0].radius_mm.to_bits(), sent[0].radius_mm.to_bits());
    let info = crate::read::info::info(&rig.out).unwrap();
    assert_eq!(info.tally.topics[crate::wire::schema::WORKFLOW].messages, 1);
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
    let growing = crate::write::paths::recording(&rig.out);
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
    let killed = fs::read(crate::write::paths::recording(&rig.out)).unwrap();
    drop(recorder);
    fs::write(crate::write::paths::recording(&rig.out), killed).unwrap();
    leftovers::recover_in_background(leftovers::set_aside(&rig.out).unwrap())
        .join()
        .unwrap();
    let second = rig.recorder();
    second.finish(0).unwrap();
    let part = crate::write::paths::part(&rig.out, 1);
    assert_eq!(reader::poses(&part, TOOL_POSE).unwrap().map(Result::unwrap).count(), 40);
}

#[test]
fn what_comes_while_the_disk_makes_the_recorder_wait_is_kept() {
    let rig = Rig::new();
    let tool = Publisher::open(&rig.bus, &topic::TOOL_POSE, "").unwrap();
    let mut recorder = rig.recorder();
    // No step, as if one took long; three times what the bus holds.
    let most = topic::TOOL_POSE.buffer;
    for lot in 1..=3 {
        for i in 0..most {
            tool.send(testing::pose(((lot - 1) * most + i) as u64)).unwrap();
        }
        while recorder.intake.waiting() < lot * most {
            std::thread::sleep(TICK);
        }
    }
    recorder.step(0).unwrap();
    let progress = recorder.progress();
    assert_eq!((progress.gaps, progress.counters.dropped), (0, 0));
    assert_eq!(progress.waited.0, 3 * most);
    assert_eq!(recorder.finish(1).unwrap().messages, 3 * most as u64);
}

#[test]
fn what_has_no_room_is_counted_as_missing() {
    let rig = Rig::new();
    let tool = Publisher::open(&rig.bus, &topic::TOOL_POSE, "").unwrap();
    let mut recorder = rig.recorder();
    recorder.intake = Intake::start(&rig.run, (10, false), bus::life::LifeLine::none()).unwrap();
    for seq in 0..5 {
        tool.send(testing::pose(seq)).unwrap();
    }
    recorder.step(0).unwrap();
    let most = topic::TOOL_POSE.buffer as u64;
    for seq in 5..5 + 20 + most {
        tool.send(testing::pose(seq)).unwrap();
        while seq == 14 && recorder.intake.waiting() < 10 {
            std::thread::sleep(TICK);
        }
    }
    // Ten in memory, as many as it holds on the bus, and the ten between them lost.
    while recorder.tool.seqs.range.unwrap().1 < 24 + most {
        recorder.step(0).unwrap();
    }
    assert_eq!(
        (recorder.progress().gaps, recorder.progress().counters.dropped),
        (1, 10)
    );
}

#[test]
fn emitters_are_recorded_bit_for_bit_and_impossible_frames_counted() {
    let rig = Rig::new();
    let emitters = Publisher::open(&rig.bus, &topic::EMITTERS, "").unwrap();
    let mut recorder = rig.recorder();
    let mut sent = Vec::new();
    for seq in 0..50 {
        let frame = testing::frame(seq);
        emitters.send(frame).unwrap();
        sent.push(frame);
    }
    let mut hostile = testing::frame(50);
    hostile.tool_seen = 33;
    emitters.send(hostile).unwrap();
    recorder.step(0).unwrap();
    assert_eq!(recorder.progress().counters.refused, 1);
    assert_eq!(recorder.progress().waited, (51, intake::ROOM + topic::EMITTERS.buffer));
    assert_eq!(recorder.finish(1).unwrap().messages, 50);
    let found: Vec<_> = reader::emitters(&rig.out).unwrap().map(Result::unwrap).collect();
    assert_eq!(found, sent);
}

#[test]
fn states_events_and_changes_of_tracking_are_in_the_log() {
    let rig = Rig::new();
    let beats = Publisher::open(&rig.bus, &topic::HEARTBEAT, "tracker").unwrap();
    let events = Publisher::open(&rig.bus, &topic::EVENT, "pilot").unwrap();
    let tool = Publisher::open(&rig.bus, &topic::TOOL_POSE, "").unwrap();
    // Before the recorder joins: the topic keeps it.
    events.send(Event::new(0, 5, Level::Info, "started")).unwrap();
    let mut recorder = rig.recorder();
    events.serve_late_joiners();
    let beat = |state, note: &str| Heartbeat::new(state, 7, Counters::default(), note);
    for (state, note) in [
        (ProcessState::Starting, "joined"),
        (ProcessState::Ready, "1 pose published"),
        (ProcessState::Ready, "207.5 pose published"),
        (ProcessState::Ready, "the tool is not calibrated"),
    ] {
        beats.send(beat(state, note)).unwrap();
        recorder.step(0).unwrap();
    }
    for (seq, tracked) in [(0, true), (1, true), (2, false), (3, false), (4, true)] {
        let mut pose = testing::pose(seq);
        if !tracked {
            pose.set(Tracked::Lost(Lost::TooFew));
        }
        tool.send(pose).unwrap();
    }
    recorder.finish(1).unwrap();
    let pid = std::process::id();
    let expected = [
        ("tracker", format!("starting (process {pid}): joined")),
        ("pilot", "started".to_owned()),
        ("tracker", format!("ready (process {pid}): 1 pose published")),
        ("tracker", format!("ready (process {pid}): the tool is not calibrated")),
        ("tracking", "from pose 0 on: tracked".to_owned()),
        ("tracking", "from pose 2 on: too few emitters".to_owned()),
        ("tracking", "from pose 4 on: tracked".to_owned()),
    ];
    assert_eq!(rig.log(), expected.map(|(who, what)| (who.to_owned(), what)));
    let info = crate::read::info::info(&rig.out).unwrap();
    assert_eq!(info.tally.topics[STATUS].messages, 3);
}

#[test]
fn what_was_shown_is_kept_small_where_the_scene_asks() {
    let rig = Rig::new();
    let scene = "[recording]\nthumbnails_per_s = 2.0\n[[views]]\nname = \"a\"\nplane = \"axial\"\nextent = \"local\"";
    let rgba = vec![90; 4 * 300 * 200];
    let view = bus::port::FramePublisher::open(&rig.bus, &topic::VIEW_FRAME, "a", rgba.len()).unwrap();
    let mut recorder = rig.recorder_of(scene);
    let mut header = bus::message::FrameHeader {
        width: 300,
        height: 200,
        ..bus::message::FrameHeader::default()
    };
    for step in 0..30 {
        header.stamp.seq = step;
        view.send(header, &rgba, rig.bus.clock(), i64::MAX).unwrap();
        recorder.step(100_000_000 * step.cast_signed()).unwrap();
    }
    recorder.finish(3_000_000_000).unwrap();
    let items = crate::read::scan::open(&rig.out).unwrap().map(Result::unwrap);
    let images: Vec<_> = items
        .filter_map(|item| match item {
            crate::read::scan::Item::Message(message) if message.channel.topic == "/view/a" => Some(message),
            _ => None,
        })
        .collect();
    // At 0 s, 0.5 s, ... 2.5 s; at 3 s the newest is that of 2.9 s.
    assert_eq!(
        images.iter().map(|image| image.sequence).collect::<Vec<_>>(),
        [0, 5, 10, 15, 20, 25, 29]
    );
    let image = <proto::CompressedImage as prost::Message>::decode(&*images[0].data).unwrap();
    assert_eq!((image.format.as_str(), image.frame_id.as_str()), ("png", "a"));
    assert!(image.data.starts_with(b"\x89PNG"));
}

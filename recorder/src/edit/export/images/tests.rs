use std::fs;
use std::io::Cursor;

use bus::message::{CaptureClock, EmitterFrame, UsImageHeader};
use geometry::{Rigid, Vector};
use scene::Compression;

use super::super::follow::{Delivered, Follow, Seen};
use super::super::{ExportedImages, export_images};
use crate::testing;
use crate::wire::proto::{self, UsFrame};
use crate::write::pose_log::{Entry, PoseLog};

const MS: i64 = 1_000_000;
const SIDE: u32 = 16;
const LOST: &str = "too few emitters";

/// The tool's marker goes 1 mm and 0.01 rad a frame along and about z; where a frame has no emitter, there is no pose.
struct Glide;

impl Follow for Glide {
    fn see(&mut self, frame: Delivered<'_>, _: i64) -> Result<Seen, String> {
        let Delivered::Emitters(frame) = frame else {
            panic!("another kind")
        };
        if frame.tool_seen == 0 {
            return Err(LOST.to_owned());
        }
        let along = frame.seq as f64;
        Ok(Seen {
            marker: Rigid::from_rotation_vector(Vector::new(0.0, 0.0, 0.01 * along), Vector::new(0.0, 0.0, along))
                .unwrap(),
            reference: Some(Rigid::identity()),
        })
    }
}

/// Frame `seq`, 20 ms after the one before.
fn emitters(seq: u64, is_seen: bool) -> EmitterFrame {
    EmitterFrame {
        seq,
        t_device_ns: 20 * MS * seq as i64,
        t_capture_ns: 20 * MS * seq as i64,
        t_publish_ns: 20 * MS * seq as i64 + 1,
        tool_seen: u32::from(is_seen),
        ..EmitterFrame::EMPTY
    }
}

fn image(seq: u64, t_capture_ns: i64) -> UsFrame {
    let header = UsImageHeader {
        seq,
        t_capture_ns,
        pixel_mm: [0.25, 0.5],
        depth_mm: 7.0,
        beams: [0.0, 3.75, 0.5, 0.0],
        array: UsImageHeader::LINEAR,
        clock: CaptureClock::Mapped.code(),
        width: SIDE,
        height: SIDE,
        ..UsImageHeader::default()
    };
    UsFrame {
        header: header.turned("MF"),
        grey: (0..SIDE * SIDE).map(|i| (i + seq as u32) as u8).collect(),
    }
}

struct Log(PoseLog<Cursor<Vec<u8>>>);

impl Log {
    fn new() -> Self {
        let mut log = PoseLog::new(Cursor::new(Vec::new()), Compression::Zstd, &[]).unwrap();
        log.scene("seed = 1\n[tool]\nname = \"sonde\"\n", 0).unwrap();
        log.facts(&testing::facts()).unwrap();
        Self(log)
    }

    fn frames(mut self, seqs: impl IntoIterator<Item = (u64, bool)>) -> Self {
        for (seq, is_seen) in seqs {
            let frame = proto::EmitterFrame::try_from(&emitters(seq, is_seen)).unwrap();
            self.0.put(Entry::Emitters(&frame)).unwrap();
        }
        self
    }

    fn images(mut self, images: impl IntoIterator<Item = UsFrame>) -> Self {
        for image in images {
            self.0.put(Entry::UsImage(&proto::RawImage::from(&image))).unwrap();
        }
        self
    }

    /// What is said of the export, and the header's text and the bytes behind it.
    fn exported(self) -> Result<(ExportedImages, String, Vec<u8>), String> {
        self.exported_of(|bytes| bytes)
    }

    /// The same of bytes that were changed.
    fn exported_of(self, change: impl FnOnce(Vec<u8>) -> Vec<u8>) -> Result<(ExportedImages, String, Vec<u8>), String> {
        let tmp = tempfile::tempdir().unwrap();
        let (input, out) = (tmp.path().join("s.mcap"), tmp.path().join("s.igs.mha"));
        fs::write(&input, change(self.0.finish().unwrap().into_inner())).unwrap();
        let exported = export_images(&input, |_| Ok(Box::new(Glide)), &out, false).map_err(|error| {
            assert!(!out.exists());
            error.to_string()
        })?;
        let bytes = fs::read(&out).unwrap();
        let end = b"ElementDataFile = LOCAL\n";
        let at = bytes.windows(end.len()).position(|window| window == end).unwrap() + end.len();
        Ok((
            exported,
            String::from_utf8(bytes[..at].to_vec()).unwrap(),
            bytes[at..].to_vec(),
        ))
    }
}

/// The numbers of a transform of an image, and its status.
fn transform(header: &str, number: usize, name: &str) -> (Vec<f64>, String) {
    let value = |key: String| {
        let line = header
            .lines()
            .find_map(|line| line.strip_prefix(&key).map(str::to_owned));
        line.unwrap_or_else(|| panic!("{key}"))
    };
    let key = format!("Seq_Frame{number:04}_{name}Transform");
    let numbers = value(format!("{key} = "));
    let numbers = numbers.split(' ').map(|word| word.parse().unwrap()).collect();
    (numbers, value(format!("{key}Status = ")))
}

#[test]
fn images_go_out_bit_for_bit_with_the_pose_of_their_own_stamp() {
    let images = [image(4, 30 * MS), image(5, 60 * MS), image(6, 75 * MS)];
    let log = Log::new().frames((0..6).map(|seq| (seq, true))).images(images.clone());
    let (exported, header, pixels) = log.exported().unwrap();
    assert_eq!((exported.images, exported.unposed, exported.left_out), (3, 0, 0));
    let options = "--array linear:0,15,1 --depth-mm 7 --tool sonde";
    assert_eq!(exported.options.as_deref(), Some(options));
    assert_eq!(
        pixels,
        images.iter().flat_map(|image| image.grey.clone()).collect::<Vec<_>>()
    );
    assert!(header.contains("DimSize = 16 16 3\n") && header.contains("UltrasoundImageOrientation = MF\n"));
    assert!(header.contains("Seq_Frame0002_FrameNumber = 6\nSeq_Frame0002_Timestamp = 0.075000000\n"));
    for (number, share) in [1.5, 3.0, 3.75].into_iter().enumerate() {
        let (found, status) = transform(&header, number, "ProbeToTracker");
        let (sin, cos) = (0.01_f64 * share).sin_cos();
        for (at, expected) in [(0, cos), (1, -sin), (4, sin), (11, share), (15, 1.0)] {
            // Sums of a few numbers of at most 4.
            assert!((found[at] - expected).abs() < 1e-14, "{number} {at}: {found:?}");
        }
        assert_eq!(status, "OK");
        assert_eq!(transform(&header, number, "ReferenceToTracker").1, "OK");
    }
    // As the reader of `calib probe` composes it.
    let (frames, _) = calib::file::sequence::chained(&header, "ProbeToReference").unwrap();
    assert_eq!(frames.len(), 3);
    assert!((frames[0].poses[0].unwrap().translation_mm[2] - 1.5).abs() < 1e-14);
}

/// Between two frames of which one has no pose, or that are far apart, nothing says where the probe was: no pose is made up there.
#[test]
fn no_pose_is_made_up_over_a_lost_stretch_nor_before_or_behind_the_frames() {
    let lost = |seq| (seq, seq != 5);
    let frames = (2..9).map(lost).chain((20..23).map(lost));
    let stamps = [30, 50, 90, 100, 110, 130, 165, 390, 410, 445];
    let images = (0..).zip(stamps).map(|(seq, ms)| image(seq, ms * MS));
    let (exported, header, _) = Log::new().frames(frames).images(images).exported().unwrap();
    let has_pose: Vec<bool> = (0..stamps.len())
        .map(|number| transform(&header, number, "ProbeToTracker").1 == "OK")
        .collect();
    let expected = [false, true, false, false, false, true, false, false, true, false];
    assert_eq!(has_pose, expected, "{header}");
    assert_eq!(exported.unposed, 7);
    assert_eq!(exported.why, "the localizer's frames end before its stamp");
    // A frame that came late does not break the way between its neighbours.
    let late = Log::new().frames([(0, true), (2, true), (1, false), (3, true)]);
    let (exported, ..) = late.images([image(0, 30 * MS), image(1, 50 * MS)]).exported().unwrap();
    assert_eq!(exported.unposed, 0);
}

#[test]
fn an_image_that_is_stamped_by_its_arrival_has_no_pose_and_one_out_of_order_is_left_out() {
    let mut arrived = image(1, 50 * MS);
    arrived.header.clock = CaptureClock::Arrival.code();
    let images = [image(0, 30 * MS), arrived, image(2, 40 * MS), image(3, 70 * MS)];
    let log = || Log::new().frames((0..6).map(|seq| (seq, true)));
    let (exported, header, pixels) = log().images(images).exported().unwrap();
    assert_eq!((exported.images, exported.unposed, exported.left_out), (3, 1, 1));
    assert!(exported.why.contains("stamped by its arrival"), "{}", exported.why);
    assert_eq!(transform(&header, 1, "ProbeToTracker").1, "INVALID");
    assert_eq!(pixels[2 * 256], 3);
    let mut unturned = image(0, 30 * MS);
    unturned.header = unturned.header.turned("");
    let (_, header, _) = log().images([unturned]).exported().unwrap();
    assert!(!header.contains("UltrasoundImageOrientation"), "{header}");
}

#[test]
fn what_makes_no_sequence_is_refused_with_the_reason() {
    let log = || Log::new().frames((0..6).map(|seq| (seq, true)));
    let refused = |log: Log, words: &str| {
        let error = log.exported().unwrap_err();
        assert!(error.contains(words), "{words}: {error}");
    };
    refused(log(), "there is no image of an ultrasound probe in it");
    refused(
        log().images([image(0, 900 * MS)]),
        "none of its images has a pose: the localizer's frames end",
    );
    refused(Log::new().images([image(0, 0)]), "none of its images has a pose");
    let mut deeper = image(1, 50 * MS);
    deeper.header.depth_mm = 6.0;
    refused(
        log().images([image(0, 30 * MS), deeper]),
        "image 1 differs from the first",
    );
    let mut small = image(0, 30 * MS);
    (small.header.width, small.header.height) = (8, 32);
    refused(log().images([small]), "8 x 32 pixels; sides of 16 to 4096");
    // Images of a replay have the stamps of the run that it is of.
    let mut replayed = log();
    let facts = crate::wire::schema::RunFacts {
        remade_from: Some("before.mcap".to_owned()),
        ..testing::facts()
    };
    replayed.0.facts(&facts).unwrap();
    refused(
        replayed.images([image(0, 30 * MS)]),
        "it is of a replay: export before.mcap",
    );
    // Of two runs nobody knows which scene draws the markers.
    let mut two = log();
    two.0.scene("seed = 2\n", 0).unwrap();
    refused(two.images([image(0, 30 * MS)]), "it holds two scenes");
}

/// Stated: so many images, and nothing else. True: the file ends within a record, and the gesture's end is missing.
#[test]
fn images_of_a_recording_that_is_cut_off_are_said_to_be() {
    let log = || {
        let frames = Log::new().frames((0..400).map(|seq| (seq, true)));
        frames.images((0..200).map(|seq| image(seq, (20 * seq as i64 + 5) * MS)))
    };
    let (whole, ..) = log().exported().unwrap();
    assert_eq!((whole.images, whole.is_cut_off), (200, false));
    // Behind the last byte of the messages everything is index and summary.
    let (cut, ..) = log()
        .exported_of(|mut bytes| {
            bytes.truncate(bytes.len() - 7);
            bytes
        })
        .unwrap();
    assert!(cut.is_cut_off, "{cut:?}");
}

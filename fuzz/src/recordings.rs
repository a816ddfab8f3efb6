//! Recordings: MCAP, ours and anybody's, and sequences of the PLUS toolkit.

use std::path::Path;

use bus::message::{EmitterFrame, MarkerFrame, ToolPose};
use recorder::edit::export::{Format, export};
use recorder::edit::{cut, import, recover};
use recorder::read::{info, reader, verify};
use recorder::replay::facts::facts;
use recorder::replay::tape::{Delivery, Tape};
use recorder::wire::proto;
use recorder::wire::schema::{RunFacts, Source, TOOL_POSE};
use recorder::write::pose_log::{Entry, PoseLog};
use scene::Compression;

use crate::{Failure, Folder};

/// More moments than this are not replayed.
const MOMENTS: usize = 10_000;

/// Reads, checks, replays, exports and recovers a recording.
pub(crate) fn mcap(bytes: &[u8]) {
    let Ok(folder) = Folder::new() else { return };
    let Some(path) = folder.file("bytes.mcap", bytes) else {
        return;
    };
    let out = |name: &str| folder.path().join(name);
    match verify::verify(&path) {
        Ok(verified) => drop((verified.findings, verified.left_out)),
        Err(error) => drop(error.to_string()),
    }
    let _ = info::info(&path).map(|info| info.to_string());
    let _ = facts(&path).map_err(|error| error.to_string());
    let _ = reader::poses(&path, TOOL_POSE).map(|poses| poses.take(MOMENTS).count());
    let _ = reader::emitters(&path).map(|frames| frames.take(MOMENTS).count());
    let _ = reader::markers(&path).map(|frames| frames.take(MOMENTS).count());
    for delivery in [Delivery::Emitters, Delivery::Markers] {
        let Ok(mut tape) = Tape::with_frames(&path, delivery) else {
            continue;
        };
        let mut taken = 0;
        while tape.take().is_some() && taken < MOMENTS {
            taken += 1;
        }
        let _ = (tape.near(0), tape.unread());
    }
    for (format, name) in [(Format::Csv, "a.csv"), (Format::Json, "a.json"), (Format::Mha, "a.mha")] {
        let _ = export(&path, TOOL_POSE, format, &out(name), false).map_err(|error| error.to_string());
    }
    let stretch = cut::Stretch {
        from_ns: 0,
        to_ns: 1_000_000,
    };
    let _ = recover::recover(&path, &out("recovered.mcap")).map_err(|error| error.to_string());
    let _ = cut::cut(&path, stretch, &out("cut.mcap"), false).map_err(|error| error.to_string());
}

/// Imports a sequence, and calibrates a tip by it.
pub(crate) fn sequence(bytes: &[u8]) {
    let Ok(folder) = Folder::new() else { return };
    let Some(path) = folder.file("bytes.mha", bytes) else {
        return;
    };
    for transform in [None, Some("ProbeToTracker"), Some("StylusToReference")] {
        let out = folder.path().join("bytes.mcap");
        let _ = import::import(&path, transform, &out, true).map_err(|error| error.to_string());
    }
    crate::calibrations::calib(&["pivot", "--transform", "StylusToReference", "--poses"], Some(&path));
}

fn pose(seq: u64) -> ToolPose {
    ToolPose {
        seq,
        t_device_ns: 1_000_000 * seq as i64,
        t_capture_ns: 1_000_000 * seq as i64,
        t_publish_ns: 1_000_000 * seq as i64 + 7,
        registration_id: 42,
        status: 0,
        q: [0.6, 0.0, 0.8, 0.0],
        t_mm: [1.0, -2.5, seq as f64],
        ..ToolPose::EMPTY
    }
}

fn recording(compression: Compression) -> Result<Vec<u8>, Failure> {
    let mut log = PoseLog::new(std::io::Cursor::new(Vec::new()), compression, &["tip".to_owned()])?;
    log.scene("version = 1\n", 3)?;
    log.facts(&RunFacts {
        name: "fuzz".to_owned(),
        epoch_ns: 5,
        registration_id: Some(42),
        volume_hash: None,
        remade_from: None,
    })?;
    for seq in 0..20 {
        log.pose(Source::Tool, &pose(seq))?;
        log.pose(Source::Truth, &pose(seq))?;
        let frame = proto::EmitterFrame::try_from(&EmitterFrame {
            seq,
            ..EmitterFrame::EMPTY
        })?;
        log.put(Entry::Emitters(&frame))?;
        let frame = proto::MarkerFrame::try_from(&MarkerFrame {
            seq,
            ..MarkerFrame::EMPTY
        })?;
        log.put(Entry::Markers(&frame))?;
        if seq == 9 {
            log.flush()?;
        }
    }
    Ok(log.finish()?.into_inner())
}

pub(crate) fn seeds() -> Result<Vec<Vec<u8>>, Failure> {
    [Compression::None, Compression::Lz4, Compression::Zstd]
        .into_iter()
        .map(recording)
        .collect()
}

pub(crate) fn sequences() -> Result<Vec<Vec<u8>>, Failure> {
    let head = "ObjectType = Image\nNDims = 3\nAnatomicalOrientation = RAI\nBinaryData = True\n\
                BinaryDataByteOrderMSB = False\nCompressedData = False\nDimSize = 1 1 3\nElementNumberOfChannels = 1\n\
                ElementSpacing = 1 1 1\nElementType = MET_UCHAR\nKinds = domain domain list\n";
    let mut text = head.to_owned();
    for i in 0..3 {
        for name in ["ProbeToTracker", "StylusToTracker", "ReferenceToTracker"] {
            text += &format!(
                "Seq_Frame{i:04}_{name}Transform = 0.6 0 0.8 {i} 0 1 0 2.5 -0.8 0 0.6 -3 0 0 0 1\n\
                 Seq_Frame{i:04}_{name}TransformStatus = OK\n"
            );
        }
        text += &format!("Seq_Frame{i:04}_Timestamp = {i}.125\n");
    }
    text += "ElementDataFile = LOCAL\nabc";
    let exported = exported()?;
    Ok(vec![text.into_bytes(), exported])
}

/// What we write as such a sequence.
fn exported() -> Result<Vec<u8>, Failure> {
    let folder = Folder::new()?;
    let (from, to) = (folder.path().join("a.mcap"), folder.path().join("a.mha"));
    std::fs::write(&from, recording(Compression::None)?)?;
    export(&from, TOOL_POSE, Format::Mha, Path::new(&to), false)?;
    Ok(std::fs::read(to)?)
}

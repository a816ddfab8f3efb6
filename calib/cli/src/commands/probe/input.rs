//! Points and poses, put together by the frames' numbers.

use std::collections::BTreeMap;
use std::path::Path;

use geometry::{Probe, Reference, Rigid, Vector};
use probe::{MOST_POINTS, Mark, Seen};
use serde::Deserialize;

use super::error::ProbeCommandError;
use crate::input_files::source::Source;
use crate::poses::Timed;

/// What was read.
pub(super) struct Read {
    /// Frames with points and a pose.
    pub(super) frames: Vec<Seen>,
    /// All poses with a time.
    pub(super) timed: Vec<(f64, Rigid<Reference, Probe>)>,
    /// Frames with points whose pose was lost.
    pub(super) lost: usize,
    /// Frames of the sequence.
    pub(super) of: usize,
}

#[derive(Deserialize)]
struct Points {
    frames: BTreeMap<String, Vec<PointRecord>>,
}

#[derive(Deserialize)]
struct PointRecord {
    #[serde(default)]
    wire: String,
    px: [f64; 2],
}

/// Puts points and poses together; `points` is the file that the points are of.
pub(super) fn join(
    marks: BTreeMap<u32, Vec<Mark>>,
    points: &Path,
    sequence: &Path,
    poses: &[Timed],
) -> Result<Read, ProbeCommandError> {
    let by_number: BTreeMap<u32, &Timed> = poses.iter().map(|frame| (frame.number, frame)).collect();
    let (mut frames, mut lost, all) = (Vec::new(), 0, marks.len());
    for (number, marks) in marks {
        let Some(frame) = by_number.get(&number) else {
            return Err(ProbeCommandError::NoFrame {
                path: points.to_owned(),
                sequence: sequence.to_owned(),
                frame: number,
            });
        };
        let Some(pose) = frame.pose else {
            lost += 1;
            continue;
        };
        frames.push(Seen {
            number,
            t_s: frame.t_s,
            reference_from_probe: renamed(&pose),
            marks,
        });
    }
    if 2 * lost > all {
        return Err(ProbeCommandError::Lost {
            sequence: sequence.to_owned(),
            lost,
            all,
        });
    }
    Ok(Read {
        frames,
        timed: poses.iter().filter_map(|f| Some((f.t_s?, renamed(&f.pose?)))).collect(),
        lost,
        of: poses.len(),
    })
}

/// The poses of the frames that have one.
pub(super) fn poses_of(poses: &[Timed]) -> BTreeMap<u32, Rigid<Reference, Probe>> {
    let all = poses
        .iter()
        .filter_map(|frame| Some((frame.number, renamed(&frame.pose?))));
    all.collect()
}

/// The same transform between the frames that --transform says it is of.
fn renamed<A, B>(pose: &Rigid<A, B>) -> Rigid<Reference, Probe> {
    let [x, y, z] = pose.translation_mm();
    Rigid::from_parts(pose.rotation(), Vector::new(x, y, z))
}

/// Reads points. `names` are the wires', one empty name where points lie on a wall.
pub(super) fn marks(path: &Path, names: &[String]) -> Result<BTreeMap<u32, Vec<Mark>>, ProbeCommandError> {
    let source = Source::read_whole(path)?;
    let is_json = source.text.trim_start().starts_with('{');
    let rows = if is_json { json(&source)? } else { csv(&source)? };
    if rows.len() > MOST_POINTS {
        return Err(ProbeCommandError::TooMany {
            path: path.to_owned(),
            found: rows.len(),
            most: MOST_POINTS,
        });
    }
    let mut frames: BTreeMap<u32, Vec<Mark>> = BTreeMap::new();
    for (frame, record) in rows {
        let known = names.iter().position(|name| *name == record.wire);
        let wire = known.ok_or_else(|| ProbeCommandError::NoWire {
            path: path.to_owned(),
            frame,
            found: record.wire.chars().take(64).collect(),
            known: names
                .iter()
                .take(20)
                .map(|n| format!("{n:?}"))
                .collect::<Vec<_>>()
                .join(", "),
        })?;
        frames.entry(frame).or_default().push(Mark { wire, px: record.px });
    }
    Ok(frames)
}

fn json(source: &Source) -> Result<Vec<(u32, PointRecord)>, ProbeCommandError> {
    let points: Points = serde_json::from_str(&source.text).map_err(|error| ProbeCommandError::Json {
        path: source.path.clone(),
        source: error,
    })?;
    let mut rows = Vec::new();
    for (name, records) in points.frames {
        let frame = name.parse().map_err(|_| ProbeCommandError::FrameName {
            path: source.path.clone(),
            found: name.chars().take(64).collect(),
        })?;
        rows.extend(records.into_iter().map(|record| (frame, record)));
    }
    Ok(rows)
}

fn csv(source: &Source) -> Result<Vec<(u32, PointRecord)>, ProbeCommandError> {
    let mut rows = source.rows();
    let refused = |line: usize, found: &str, expected| ProbeCommandError::Csv {
        path: source.path.clone(),
        line,
        found: found.chars().take(80).collect(),
        expected,
    };
    let head = rows.next();
    let is_head = head.is_some_and(|(_, text)| text.split(',').map(str::trim).eq(["frame", "wire", "u", "v"]));
    if !is_head {
        let (line, text) = head.unwrap_or((1, ""));
        return Err(refused(line, text, "the columns frame,wire,u,v"));
    }
    rows.map(|(line, text)| {
        let expected = "a frame's number, a wire's name and two finite numbers";
        let wrong = || refused(line, text, expected);
        let fields: Vec<&str> = text.split(',').map(str::trim).collect();
        let [frame, wire, u, v] = fields[..] else {
            return Err(wrong());
        };
        let number = |field: &str| field.parse::<f64>().ok().filter(|x| x.is_finite()).ok_or_else(wrong);
        let record = PointRecord {
            wire: wire.to_owned(),
            px: [number(u)?, number(v)?],
        };
        Ok((frame.parse().map_err(|_| wrong())?, record))
    })
    .collect()
}

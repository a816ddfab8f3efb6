//! Messages as rows of named cells.

use std::io::{self, Write};

use bus::message::{EmitterFrame, EmitterSight, Lost, MarkerFrame, MarkerSight, ToolPose};
use mcap::Message;
use prost::Message as _;

use super::reader::{self, ReadError};
use crate::wire::proto::{DecodeError, Log, ProcessStatus};
use crate::wire::schema::{EMITTER_SCHEMA, LOG_SCHEMA, MARKER_SCHEMA, POSE_SCHEMA, STATUS_SCHEMA};

/// The content of a cell.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Cell {
    Number(f64),
    Whole(i128),
    Text(String),
    None,
}

/// Names and cells; the names of all rows of one schema are the same.
pub(super) type Row = Vec<(&'static str, Cell)>;

/// The elements of the upper triangle of a 6 x 6 matrix, row by row.
const COVARIANCE: [&str; 21] = [
    "c00", "c01", "c02", "c03", "c04", "c05", "c11", "c12", "c13", "c14", "c15", "c22", "c23", "c24", "c25", "c33",
    "c34", "c35", "c44", "c45", "c55",
];

/// The rows of a message: none where its schema has no table.
pub(super) fn of(message: &Message<'_>) -> Result<Vec<Row>, ReadError> {
    let schema = message.channel.schema.as_ref().map_or("", |schema| &schema.name);
    let decoded = |schema, source| ReadError::Decode {
        topic: message.channel.topic.clone(),
        source: DecodeError::Protobuf { schema, source },
    };
    match schema {
        EMITTER_SCHEMA => Ok(emitters(&reader::decode(message)?)),
        MARKER_SCHEMA => Ok(markers(&reader::decode(message)?)),
        LOG_SCHEMA => {
            let log = Log::decode(&*message.data).map_err(|e| decoded(LOG_SCHEMA, e))?;
            Ok(vec![log_row(message.log_time, log)])
        }
        STATUS_SCHEMA => {
            let status = ProcessStatus::decode(&*message.data).map_err(|e| decoded(STATUS_SCHEMA, e))?;
            Ok(vec![status_row(status)])
        }
        POSE_SCHEMA => Ok(vec![pose(&reader::decode(message)?)]),
        _ => reader::decode::<ToolPose>(message).map(|_| Vec::new()),
    }
}

fn whole(n: impl Into<i128>) -> Cell {
    Cell::Whole(n.into())
}

/// What a status says.
fn words(status: u32) -> String {
    match (status, Lost::from_code(status)) {
        (0, _) => "valid".to_owned(),
        (_, Some(reason)) => reason.words().to_owned(),
        (_, None) => "unknown".to_owned(),
    }
}

fn pose(pose: &ToolPose) -> Row {
    let valid = pose.status == 0;
    let number = |x: f64| if valid { Cell::Number(x) } else { Cell::None };
    let words = words(pose.status);
    let mut row = vec![
        ("seq", whole(pose.seq)),
        ("t_device_ns", whole(pose.t_device_ns)),
        ("t_capture_ns", whole(pose.t_capture_ns)),
        ("t_publish_ns", whole(pose.t_publish_ns)),
        ("registration_id", Cell::Text(format!("{:016x}", pose.registration_id))),
        ("status", whole(pose.status)),
        ("words", Cell::Text(words)),
        ("visible", whole(pose.visible)),
        ("used", whole(pose.used)),
    ];
    row.extend(["qw", "qx", "qy", "qz"].into_iter().zip(pose.q.map(number)));
    row.extend(["tx_mm", "ty_mm", "tz_mm"].into_iter().zip(pose.t_mm.map(number)));
    row.push(("fre_rms_mm", number(pose.fre_rms_mm)));
    row.push(("tip_95_mm", pose.tip_95_mm().map_or(Cell::None, Cell::Number)));
    row.push(("outside", whole(i32::from(pose.said_outside()))));
    row.push(("delay_ns", whole(pose.delay_ns)));
    row.extend(COVARIANCE.into_iter().zip(pose.covariance.map(number)));
    row
}

fn emitters(frame: &EmitterFrame) -> Vec<Row> {
    // Decoded: never more than there is room for.
    let tool = frame.tool().unwrap_or_default().iter().map(|sight| ("tool", sight));
    let reference = frame
        .reference()
        .unwrap_or_default()
        .iter()
        .map(|sight| ("reference", sight));
    tool.chain(reference)
        .map(|(marker, sight)| sight_row(frame, marker, sight))
        .collect()
}

fn sight_row(frame: &EmitterFrame, marker: &str, sight: &EmitterSight) -> Row {
    let [x, y, z] = sight.place_mm.map(Cell::Number);
    vec![
        ("seq", whole(frame.seq)),
        ("t_device_ns", whole(frame.t_device_ns)),
        ("t_capture_ns", whole(frame.t_capture_ns)),
        ("t_publish_ns", whole(frame.t_publish_ns)),
        ("marker", Cell::Text(marker.to_owned())),
        ("emitter", whole(sight.emitter)),
        ("x_mm", x),
        ("y_mm", y),
        ("z_mm", z),
    ]
}

fn markers(frame: &MarkerFrame) -> Vec<Row> {
    // Decoded: never more than there is room for.
    let sights = frame.sights().unwrap_or_default();
    sights.iter().map(|sight| marker_row(frame, sight)).collect()
}

fn marker_row(frame: &MarkerFrame, sight: &MarkerSight) -> Row {
    let number = |x: f64| if sight.status == 0 { Cell::Number(x) } else { Cell::None };
    let mut row = vec![
        ("seq", whole(frame.seq)),
        ("t_device_ns", whole(frame.t_device_ns)),
        ("t_capture_ns", whole(frame.t_capture_ns)),
        ("t_arrival_ns", whole(frame.t_arrival_ns)),
        ("t_publish_ns", whole(frame.t_publish_ns)),
        ("t_uncertain_ns", whole(frame.t_uncertain_ns)),
        ("clock", Cell::Text(frame.capture_clock().words().to_owned())),
        ("device", Cell::Text(frame.device_name())),
        ("marker", whole(sight.marker)),
        ("status", whole(sight.status)),
        ("words", Cell::Text(words(sight.status))),
        ("age_ns", whole(sight.age_ns)),
    ];
    row.extend(["qw", "qx", "qy", "qz"].into_iter().zip(sight.q.map(number)));
    row.extend(["tx_mm", "ty_mm", "tz_mm"].into_iter().zip(sight.t_mm.map(number)));
    row.push(("error_mm", number(sight.error_mm)));
    row
}

fn log_row(t_ns: u64, log: Log) -> Row {
    let level = match log.level {
        2 => "info",
        3 => "warning",
        _ => "error",
    };
    vec![
        ("t_ns", whole(t_ns)),
        ("level", Cell::Text(level.to_owned())),
        ("name", Cell::Text(log.name)),
        ("message", Cell::Text(log.message)),
    ]
}

fn status_row(status: ProcessStatus) -> Row {
    vec![
        ("t_ns", whole(status.t_ns)),
        ("process", Cell::Text(status.process)),
        ("pid", whole(status.pid)),
        ("state", Cell::Text(status.state)),
        ("note", Cell::Text(status.note)),
        ("published", whole(status.published)),
        ("lost", whole(status.lost)),
        ("dropped", whole(status.dropped)),
        ("refused", whole(status.refused)),
        ("recorded", whole(status.recorded)),
    ]
}

impl Cell {
    /// RFC 4180: what holds a comma, a quote or an end of line is quoted.
    pub(super) fn write_csv(&self, out: &mut impl Write) -> io::Result<()> {
        match self {
            Self::Number(x) => write!(out, "{x}"),
            Self::Whole(n) => write!(out, "{n}"),
            Self::Text(text) if text.contains([',', '"', '\n', '\r']) => {
                write!(out, "\"{}\"", text.replace('"', "\"\""))
            }
            Self::Text(text) => out.write_all(text.as_bytes()),
            Self::None => Ok(()),
        }
    }

    fn write_json(&self, out: &mut impl Write) -> io::Result<()> {
        match self {
            // JSON has neither NaN nor infinity.
            Self::Number(x) if x.is_finite() => write!(out, "{x:?}"),
            Self::Number(_) | Self::None => out.write_all(b"null"),
            Self::Whole(n) => write!(out, "{n}"),
            Self::Text(text) => write_json_text(out, text),
        }
    }
}

fn write_json_text(out: &mut impl Write, text: &str) -> io::Result<()> {
    out.write_all(b"\"")?;
    for c in text.chars() {
        match c {
            '"' | '\\' => write!(out, "\\{c}")?,
            c if (c as u32) < 0x20 => write!(out, "\\u{:04x}", c as u32)?,
            c => write!(out, "{c}")?,
        }
    }
    out.write_all(b"\"")
}

/// The row as a JSON object on one line.
pub(super) fn write_json(out: &mut impl Write, row: &Row) -> io::Result<()> {
    out.write_all(b"{")?;
    for (index, (name, cell)) in row.iter().enumerate() {
        let comma = if index == 0 { "" } else { ", " };
        write!(out, "{comma}\"{name}\": ")?;
        cell.write_json(out)?;
    }
    out.write_all(b"}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn json(cell: &Cell) -> String {
        let mut out = Vec::new();
        cell.write_json(&mut out).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn numbers_come_back_bit_for_bit() {
        for x in [0.1, -0.0, 1e300, f64::MIN_POSITIVE / 3.0, 1.0 / 3.0] {
            let mut csv = Vec::new();
            Cell::Number(x).write_csv(&mut csv).unwrap();
            for text in [String::from_utf8(csv).unwrap(), json(&Cell::Number(x))] {
                assert_eq!(text.parse::<f64>().unwrap().to_bits(), x.to_bits(), "{text}");
            }
        }
        assert_eq!(json(&Cell::Number(f64::NAN)), "null");
    }

    #[test]
    fn words_are_quoted_where_they_must_be() {
        let text = Cell::Text("a \"b\", c\n\u{1}\\".to_owned());
        assert_eq!(json(&text), "\"a \\\"b\\\", c\\u000a\\u0001\\\\\"");
        let mut csv = Vec::new();
        text.write_csv(&mut csv).unwrap();
        assert_eq!(csv, b"\"a \"\"b\"\", c\n\x01\\\"");
    }
}

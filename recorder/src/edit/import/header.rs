//! The header of a sequence: text lines up to the one that says where the pixels are.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead, Read};
use std::path::Path;

use geometry::named::{Chain, MAX_NAMES};

use super::ImportError;

/// Longest line.
const MAX_LINE: u64 = 1 << 16;
/// Most frames: ten hours at 100 Hz.
const MAX_FRAMES: usize = 4_000_000;
/// The line that ends a header.
const END: &str = "ElementDataFile";

/// What is said of one frame: of each transform that is read, by their order.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Frame {
    /// The line, and the matrix by rows, mm.
    pub(super) matrices: Vec<Option<(usize, [f64; 16])>>,
    /// Whether the transform's status is not OK; where it is not said it is.
    pub(super) bad: Vec<bool>,
    /// s
    pub(super) time_s: Option<f64>,
}

/// The names of the transforms, without `Transform`.
pub(super) fn names(path: &Path, input: impl BufRead) -> Result<BTreeSet<String>, ImportError> {
    let mut names = BTreeSet::new();
    each_field(path, input, |_, _, field, _| {
        if let Some(name) = field.strip_suffix("Transform")
            && names.len() <= MAX_NAMES
        {
            names.insert(name.to_owned());
        }
        Ok(())
    })?;
    Ok(names)
}

/// The frames by their numbers, with the transforms asked for in that order.
pub(super) fn frames(path: &Path, input: impl BufRead, asked: &[&str]) -> Result<BTreeMap<u32, Frame>, ImportError> {
    let mut frames: BTreeMap<u32, Frame> = BTreeMap::new();
    let at = |name: Option<&str>| asked.iter().position(|a| Some(*a) == name);
    let empty = || Frame {
        matrices: vec![None; asked.len()],
        bad: vec![false; asked.len()],
        time_s: None,
    };
    each_field(path, input, |line, number, field, value| {
        let (status, matrix) = (
            at(field.strip_suffix("TransformStatus")),
            at(field.strip_suffix("Transform")),
        );
        if field != "Timestamp" && status.is_none() && matrix.is_none() {
            return Ok(());
        }
        if frames.len() > MAX_FRAMES {
            return Err(format!("more than {MAX_FRAMES} frames"));
        }
        let frame = frames.entry(number).or_insert_with(empty);
        match (status, matrix) {
            (Some(i), _) => frame.bad[i] = value != "OK",
            (_, Some(i)) => frame.matrices[i] = Some((line, sixteen(value)?)),
            _ => frame.time_s = Some(one_number(value)?),
        }
        Ok(())
    })?;
    Ok(frames)
}

/// Calls `take` with each field of a frame: its line, the frame, its name and its value.
fn each_field(
    path: &Path,
    mut input: impl BufRead,
    mut take: impl FnMut(usize, u32, &str, &str) -> Result<(), String>,
) -> Result<(), ImportError> {
    for line in 1.. {
        let Some(text) = next_line(path, &mut input, line)? else {
            break;
        };
        if let Some((number, field, value)) = field(&text) {
            take(line, number, field, value).map_err(|what| ImportError::Line {
                path: path.to_owned(),
                line,
                what,
            })?;
        }
    }
    Ok(())
}

/// The next line of the header; `None` behind its last.
fn next_line(path: &Path, input: &mut impl BufRead, line: usize) -> Result<Option<String>, ImportError> {
    let mut bytes = Vec::new();
    let read = input.by_ref().take(MAX_LINE).read_until(b'\n', &mut bytes);
    read.map_err(|source| ImportError::Read {
        path: path.to_owned(),
        source,
    })?;
    let fail = |what: &str| ImportError::Line {
        path: path.to_owned(),
        line,
        what: what.to_owned(),
    };
    if bytes.is_empty() {
        return Err(fail(
            "the file ends before the line ElementDataFile, which ends a sequence's header",
        ));
    }
    if bytes.len() as u64 == MAX_LINE {
        return Err(fail("the line has more than 65536 bytes: this is no sequence's header"));
    }
    let text = String::from_utf8(bytes).map_err(|_| fail("the line is not text: this is no sequence's header"))?;
    Ok((!text.starts_with(END)).then(|| text.trim_end().to_owned()))
}

/// The frame, the name of a field and its value, of a line that has them.
fn field(line: &str) -> Option<(u32, &str, &str)> {
    let rest = line.strip_prefix("Seq_Frame")?;
    let (number, rest) = rest.split_once('_')?;
    let (name, value) = rest.split_once('=')?;
    Some((number.parse().ok()?, name.trim(), value.trim()))
}

fn one_number(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|x: &f64| x.abs() <= 1e9);
    number.ok_or_else(|| format!("found {:.40?} where a number of at most 1e9 belongs", text))
}

fn sixteen(text: &str) -> Result<[f64; 16], String> {
    let numbers: Vec<f64> = text
        .split_whitespace()
        .take(17)
        .map(one_number)
        .collect::<Result<_, _>>()?;
    let found = numbers.len();
    numbers.try_into().map_err(|_| match found {
        17 => "more than the 16 numbers of a matrix".to_owned(),
        _ => format!("{found} numbers of a matrix instead of 16"),
    })
}

/// The chain to the transform asked for; without one, to the only transform there is.
pub(super) fn chosen(path: &Path, asked: Option<&str>, names: &BTreeSet<String>) -> Result<Chain, ImportError> {
    let fail = |asked: String| {
        let found: Vec<_> = names.iter().take(10).map(|name| format!("{name:.60}")).collect();
        let found = if found.is_empty() {
            "no transform".to_owned()
        } else {
            found.join(", ")
        };
        let path = path.to_owned();
        ImportError::Transform { path, asked, found }
    };
    let asked = match (asked, names.first()) {
        (Some(asked), _) => asked.strip_suffix("Transform").unwrap_or(asked),
        (None, Some(only)) if names.len() == 1 => only,
        (None, _) => return Err(fail("which transform is the tool's pose is not said".to_owned())),
    };
    let there: BTreeSet<&str> = names.iter().map(String::as_str).collect();
    Chain::find(&there, asked).map_err(|none| fail(none.to_string()))
}

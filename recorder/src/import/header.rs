//! The header of a sequence: text lines up to the one that says where the pixels are.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead, Read};
use std::path::Path;

use super::ImportError;

/// Longest line.
const MAX_LINE: u64 = 1 << 16;
/// Most frames: ten hours at 100 Hz.
const MAX_FRAMES: usize = 4_000_000;
/// The line that ends a header.
const END: &str = "ElementDataFile";

/// What is said of one frame.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Frame {
    /// The line, and the matrix by rows, mm.
    pub(super) matrix: Option<(usize, [f64; 16])>,
    /// Whether the transform's status is OK, or not said.
    pub(super) is_ok: bool,
    /// s
    pub(super) time_s: Option<f64>,
}

/// The frames of the transform asked for, or of the only one, by their numbers; and its name, without `Transform`.
pub(super) fn frames(
    path: &Path,
    mut input: impl BufRead,
    asked: Option<&str>,
) -> Result<(String, BTreeMap<u32, Frame>), ImportError> {
    let mut all: BTreeMap<String, BTreeMap<u32, Frame>> = BTreeMap::new();
    let mut times = BTreeMap::new();
    let asked = asked.map(|name| name.strip_suffix("Transform").unwrap_or(name));
    let mut names = BTreeSet::new();
    for line in 1.. {
        let Some(text) = next_line(path, &mut input, line)? else {
            break;
        };
        let Some((number, field, value)) = field(&text) else {
            continue;
        };
        let fail = |what| ImportError::Line {
            path: path.to_owned(),
            line,
            what,
        };
        if times.len() > MAX_FRAMES {
            return Err(fail(format!("more than {MAX_FRAMES} frames")));
        }
        if field == "Timestamp" {
            times.insert(number, one_number(value).map_err(fail)?);
        } else if let Some(name) = field.strip_suffix("TransformStatus") {
            frame(&mut all, name, number).is_ok = value == "OK";
        } else if let Some(name) = field.strip_suffix("Transform") {
            names.insert(name.to_owned());
            if asked.is_none_or(|asked| asked == name) && names.len() < 64 {
                frame(&mut all, name, number).matrix = Some((line, sixteen(value).map_err(fail)?));
            }
        }
    }
    let name = chosen(path, asked, &names)?;
    let mut frames = all.remove(&name).unwrap_or_default();
    for (number, time_s) in times {
        frames.entry(number).or_default().time_s = Some(time_s);
    }
    Ok((name, frames))
}

fn frame<'a>(all: &'a mut BTreeMap<String, BTreeMap<u32, Frame>>, name: &str, number: u32) -> &'a mut Frame {
    let frames = all.entry(name.to_owned()).or_default();
    frames.entry(number).or_insert(Frame {
        is_ok: true,
        ..Frame::default()
    })
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

fn chosen(path: &Path, asked: Option<&str>, names: &BTreeSet<String>) -> Result<String, ImportError> {
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
    match (asked, names.first()) {
        (Some(asked), _) if names.contains(asked) => Ok(asked.to_owned()),
        (Some(asked), _) => Err(fail(format!("it has no transform {asked:?}"))),
        (None, Some(only)) if names.len() == 1 => Ok(only.clone()),
        (None, _) => Err(fail("which transform is the tool's pose is not said".to_owned())),
    }
}

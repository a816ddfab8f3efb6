//! The folder of a study: whose it is, how far it is, and nothing twice.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::plan::Plan;
use crate::record::{HEADER, MOST_LINE, Row};

/// The value of `format` in `study.json`.
const FORMAT: &str = "trocar-study";
/// Of `version`. It rises when lines mean something else than before.
const VERSION: u32 = 5;
const STUDY: &str = "study.json";
const LINES: &str = "operations.csv";
/// The folder of examinations.
pub(crate) const IMAGES: &str = "images";
/// Begins the name of `study.json` while it is written.
const BESIDE: &str = ".study-";

/// Why a folder cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// What the system says.
    #[error("{path}: {source}")]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// Something else lies there.
    #[error("{0} is not empty and holds no study; give --out a folder of its own")]
    Foreign(PathBuf),
    /// Of another version, or no study's file.
    #[error(
        "{path}: found {found}; this program goes on with format {FORMAT:?}, version {VERSION}. Give --out another folder"
    )]
    Version {
        /// `study.json`.
        path: PathBuf,
        /// What stands there.
        found: String,
    },
    /// Of other study files.
    #[error(
        "{path} is of another study ({found}) than these files ({expected}): they were changed, or are others. Give --out another folder"
    )]
    Other {
        /// `study.json`.
        path: PathBuf,
        /// The hash that stands there.
        found: String,
        /// That of the files.
        expected: String,
    },
    /// Begun by another program.
    #[error(
        "{path} was begun by program {found}, and this is {expected}: what both wrote would not be one study. Give --out another folder"
    )]
    Program {
        /// `study.json`.
        path: PathBuf,
        /// The program that stands there.
        found: String,
        /// This one.
        expected: String,
    },
    /// Somebody is at it.
    #[error("{0}: another program is working in this folder")]
    Busy(PathBuf),
    /// Beads or the bone of an examination that this study has not written there.
    #[error(
        "{0} was changed after it was written; remove its folder, and it is made again, or give --out another folder"
    )]
    Changed(PathBuf),
    /// A line that this study has not written there.
    #[error("{path}, line {line}: {why}. The file is not as it was written; give --out another folder")]
    Line {
        /// `operations.csv`.
        path: PathBuf,
        /// Which, from 1.
        line: usize,
        /// What is wrong.
        why: String,
    },
}

#[derive(Debug, Serialize, Deserialize)]
struct About {
    format: String,
    version: u32,
    program: String,
    study: String,
    files: Vec<String>,
    operations: u64,
}

/// A folder that this program alone works in.
#[derive(Debug)]
pub(crate) struct Folder {
    path: PathBuf,
    /// Locked as long as it is open.
    _about: File,
    lines: File,
    /// What was written, in order.
    pub(crate) rows: Vec<Row>,
    /// Whole operations among them.
    pub(crate) done: u64,
}

pub(crate) fn io_at(path: &Path) -> impl Fn(io::Error) -> FolderError {
    move |source| FolderError::Io {
        path: path.to_owned(),
        source,
    }
}

impl Folder {
    /// Opens the folder of a study, which is made where it is not there. What a kill left of an operation's lines is cut off.
    pub(crate) fn open(path: &Path, plan: &Plan) -> Result<Self, FolderError> {
        fs::create_dir_all(path).map_err(io_at(path))?;
        let about = locked(path, plan)?;
        let place = path.join(LINES);
        let mut lines = OpenOptions::new()
            .read(true)
            .create(true)
            .append(true)
            .open(&place)
            .map_err(io_at(&place))?;
        let (rows, done, bytes) = whole(&place, BufReader::new(&lines), plan)?;
        if bytes == 0 {
            lines.set_len(0).map_err(io_at(&place))?;
            lines
                .write_all(format!("{HEADER}\n").as_bytes())
                .map_err(io_at(&place))?;
        } else {
            lines.set_len(bytes).map_err(io_at(&place))?;
        }
        Ok(Self {
            path: path.to_owned(),
            _about: about,
            lines,
            rows,
            done,
        })
    }

    /// A file of the folder.
    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Appends the lines of the next operation in one go.
    pub(crate) fn append(&mut self, rows: Vec<Row>) -> Result<(), FolderError> {
        let text: String = rows.iter().map(Row::line).collect();
        self.lines
            .write_all(text.as_bytes())
            .map_err(io_at(&self.path.join(LINES)))?;
        self.rows.extend(rows);
        self.done += 1;
        Ok(())
    }
}

/// `study.json`, written where the folder is empty, held against the plan where it is not, and locked.
pub(crate) fn locked(folder: &Path, plan: &Plan) -> Result<File, FolderError> {
    let path = folder.join(STUDY);
    if !path.exists() {
        let mut inside = fs::read_dir(folder).map_err(io_at(folder))?;
        // What a kill left of the file that is written here is no other's.
        let is_ours = |entry: &fs::DirEntry| entry.file_name().to_string_lossy().starts_with(BESIDE);
        if inside.any(|entry| !entry.is_ok_and(|entry| is_ours(&entry))) {
            return Err(FolderError::Foreign(folder.to_owned()));
        }
        let about = About {
            format: FORMAT.to_owned(),
            version: VERSION,
            program: program().map_err(io_at(&path))?,
            study: plan.hash.clone(),
            files: plan.files.clone(),
            operations: plan.operations(),
        };
        let text = serde_json::to_string_pretty(&about)
            .map_err(io::Error::other)
            .map_err(io_at(&path))?;
        let beside = tempfile::Builder::new()
            .prefix(BESIDE)
            .tempfile_in(folder)
            .map_err(io_at(&path))?;
        fs::write(beside.path(), text + "\n").map_err(io_at(&path))?;
        match beside.persist_noclobber(&path) {
            Ok(_) => {}
            // Another began at the same moment: whose study it is, and who works here, is seen below.
            Err(error) if error.error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(io_at(&path)(error.error)),
        }
    }
    let file = File::open(&path).map_err(io_at(&path))?;
    match file.try_lock() {
        Ok(()) => {}
        Err(fs::TryLockError::WouldBlock) => return Err(FolderError::Busy(folder.to_owned())),
        Err(fs::TryLockError::Error(source)) => return Err(io_at(&path)(source)),
    }
    held(&path, plan)?;
    Ok(file)
}

/// This program: its version, and the first digits of the hash of its file. Lines of another build may mean something else.
fn program() -> io::Result<String> {
    let mut hash = blake3::Hasher::new();
    io::copy(&mut File::open(std::env::current_exe()?)?, &mut hash)?;
    Ok(format!(
        "{} {}",
        env!("CARGO_PKG_VERSION"),
        &hash.finalize().to_hex()[..16]
    ))
}

/// Refuses another version, another program, and another study.
fn held(path: &Path, plan: &Plan) -> Result<(), FolderError> {
    let other = |found: String| FolderError::Version {
        path: path.to_owned(),
        found,
    };
    let text = scene::file::read_text(path, 1 << 16).map_err(|error| other(error.to_string()))?;
    let value: serde_json::Value = serde_json::from_str(&text).map_err(|error| other(error.to_string()))?;
    if value["format"] != FORMAT || value["version"] != VERSION {
        let found = format!("format {}, version {}", value["format"], value["version"]);
        return Err(other(found.chars().take(120).collect()));
    }
    let about: About = serde_json::from_value(value).map_err(|error| other(error.to_string()))?;
    let expected = program().map_err(io_at(path))?;
    if about.program != expected {
        return Err(FolderError::Program {
            path: path.to_owned(),
            found: about.program.chars().take(40).collect(),
            expected,
        });
    }
    match about.study == plan.hash {
        true => Ok(()),
        false => Err(FolderError::Other {
            path: path.to_owned(),
            found: about.study.chars().take(16).collect(),
            expected: plan.hash.chars().take(16).collect(),
        }),
    }
}

/// The lines of whole operations, how many operations these are, and where they end in the file, bytes. Line by line: how many there may be
/// is the plan's.
fn whole(path: &Path, mut file: impl BufRead, plan: &Plan) -> Result<(Vec<Row>, u64, u64), FolderError> {
    let wrong = |line: usize, why: String| FolderError::Line {
        path: path.to_owned(),
        line,
        why,
    };
    let mut next = |at: usize| match line(&mut file) {
        Ok(found) => Ok(found),
        Err(error) if error.kind() == io::ErrorKind::InvalidData => Err(wrong(at, error.to_string())),
        Err(error) => Err(io_at(path)(error)),
    };
    let Some(header) = next(1)? else {
        return Ok((Vec::new(), 0, 0));
    };
    if header.trim_end() != HEADER {
        return Err(wrong(1, "other columns than this program writes".to_owned()));
    }
    let (mut rows, mut open, mut bytes) = (Vec::new(), Vec::new(), header.len() as u64);
    let (mut done, mut open_bytes, mut at) = (0_u64, 0_u64, 2);
    // Names of the stratum's targets, made once for all its operations.
    let mut named: (&str, Vec<String>) = ("", Vec::new());
    while let Some(line) = next(at)? {
        let row = Row::read(line.trim_end_matches('\n')).map_err(|why| wrong(at, why))?;
        let expected = plan.operation(done);
        let is_next = expected.filter(|(stratum, number)| stratum.name == row.stratum && *number == row.number);
        let Some((stratum, _)) = is_next else {
            let found = format!("operation {} of {:?} does not come next", row.number, row.stratum);
            return Err(wrong(at, found));
        };
        if named.0 != stratum.name {
            let names = stratum.targets().into_iter().map(|target| target.name);
            named = (&stratum.name, names.collect());
        }
        if named.1.get(open.len()) != Some(&row.target) {
            return Err(wrong(at, format!("target {:?} does not come next", row.target)));
        }
        open.push(row);
        open_bytes += line.len() as u64;
        at += 1;
        if named.1.len() == open.len() {
            rows.append(&mut open);
            (bytes, open_bytes, done) = (bytes + open_bytes, 0, done + 1);
        }
    }
    Ok((rows, done, bytes))
}

/// The next line with its end; `None` at the end of the file, and before what a kill or a power cut has left of a line.
///
/// # Errors
/// The system's; [`io::ErrorKind::InvalidData`] for what no study has written.
fn line(file: &mut impl BufRead) -> io::Result<Option<String>> {
    let mut bytes = Vec::new();
    file.take(MOST_LINE as u64).read_until(b'\n', &mut bytes)?;
    // A file system may leave zeros where data did not arrive.
    let text = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    let ends_in_zeros = text < bytes.len() && bytes[text..].iter().all(|byte| *byte == 0);
    let is_torn = bytes.len() < MOST_LINE || ends_in_zeros;
    match (bytes.last(), is_torn) {
        (Some(b'\n'), _) => {}
        (_, true) => return Ok(None),
        _ => {
            let why = format!("it is longer than {MOST_LINE} bytes");
            return Err(io::Error::new(io::ErrorKind::InvalidData, why));
        }
    }
    let text = String::from_utf8(bytes).map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))?;
    Ok(Some(text))
}

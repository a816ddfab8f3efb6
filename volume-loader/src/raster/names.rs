//! Names of voxel files in a header: one, a pattern of numbered ones, or a list; all inside the header's folder.

use std::path::{Component, Path, PathBuf};

use geometry::MAX_DIM;

use super::quote::quote;

/// The widest number in a file's name, digits.
const MAX_WIDTH: usize = 20;

/// Why the voxels' files cannot be named.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NamesError {
    /// The name leads out of the header's folder.
    #[error(
        "the voxels' file {found:?} is not inside the header's folder; put it there and name it without / or .. in front"
    )]
    Outside {
        /// The name.
        found: String,
    },
    /// There is no name.
    #[error("the voxels' file has an empty name")]
    Empty,
    /// A pattern of numbered files is not one.
    #[error(
        "the voxels' files are {found:?}, expected a pattern such as slice%03d.raw with a first number, a last number and \
         a step that leads from one to the other"
    )]
    Pattern {
        /// The text.
        found: String,
    },
    /// More files than a volume has slices.
    #[error("{found} voxel files are named; at most {MAX_DIM} are accepted")]
    TooMany {
        /// How many.
        found: u64,
    },
    /// The number of files does not match the slices.
    #[error("{found} voxel files are named for {slices} slices, expected {expected}")]
    Count {
        /// How many are named.
        found: u64,
        /// Slices of the volume.
        slices: i64,
        /// What would do.
        expected: &'static str,
    },
    /// Files that each hold less than a slice.
    #[error("each voxel file holds {found} dimensions, expected a slice or a slab of slices")]
    Rows {
        /// The dimensions told.
        found: String,
    },
}

/// Names as the header tells them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct FileList {
    /// In the order of slices.
    pub names: Vec<String>,
    /// Dimensions per file, where that is told.
    pub dimensions: Option<i64>,
    /// One name, not a list of one.
    pub single: bool,
}

impl FileList {
    /// One name, or a pattern with first, last, step and perhaps the dimensions per file.
    ///
    /// # Errors
    /// [`NamesError::Pattern`], [`NamesError::TooMany`], [`NamesError::Empty`].
    pub(crate) fn parse(text: &str) -> Result<Self, NamesError> {
        if text.is_empty() {
            return Err(NamesError::Empty);
        }
        if text.contains('%') {
            return pattern(text);
        }
        Ok(Self {
            names: vec![text.to_owned()],
            dimensions: None,
            single: true,
        })
    }

    /// How many slices of `slices` each file holds, where the volume has `dimension` dimensions.
    ///
    /// # Errors
    /// [`NamesError::Count`], [`NamesError::Rows`].
    pub(crate) fn slices_per_file(&self, slices: i64, dimension: i64) -> Result<u32, NamesError> {
        let found = self.names.len() as u64;
        let wrong = |expected| NamesError::Count {
            found,
            slices,
            expected,
        };
        let count = i64::try_from(found).unwrap_or(i64::MAX).max(1);
        let per_file = u32::try_from(slices / count).unwrap_or(0);
        if self.single {
            return Ok(u32::try_from(slices).unwrap_or(0));
        }
        match self.dimensions.unwrap_or(dimension - 1) {
            slab if slab == dimension && slices % count == 0 && per_file > 0 => Ok(per_file),
            slab if slab == dimension => Err(wrong("a number that divides them")),
            slice if slice == dimension - 1 && count == slices => Ok(1),
            slice if slice == dimension - 1 => Err(wrong("one for each")),
            rows => Err(NamesError::Rows {
                found: rows.to_string(),
            }),
        }
    }

    /// Where the files are, for a header at `header`.
    ///
    /// # Errors
    /// [`NamesError::Outside`], [`NamesError::Empty`].
    pub(crate) fn paths(&self, header: &Path) -> Result<Vec<PathBuf>, NamesError> {
        self.names.iter().map(|name| inside(header, name)).collect()
    }
}

fn inside(header: &Path, name: &str) -> Result<PathBuf, NamesError> {
    let outside = |part: Component<'_>| !matches!(part, Component::Normal(_) | Component::CurDir);
    if Path::new(name).components().any(outside) {
        return Err(NamesError::Outside { found: quote(name) });
    }
    if Path::new(name).file_name().is_none() {
        return Err(NamesError::Empty);
    }
    Ok(header.with_file_name(name))
}

/// `name%03d.raw first last step [dimensions]`.
fn pattern(text: &str) -> Result<FileList, NamesError> {
    let refused = || NamesError::Pattern { found: quote(text) };
    let mut words = text.split_whitespace();
    let format = words.next().and_then(Format::parse).ok_or_else(refused)?;
    let numbers: Vec<i64> = words
        .take(5)
        .map(|word| word.parse().ok())
        .collect::<Option<_>>()
        .ok_or_else(refused)?;
    let (first, last, step, dimensions) = match numbers[..] {
        [first, last, step] => (first, last, step, None),
        [first, last, step, dimensions] => (first, last, step, Some(dimensions)),
        _ => return Err(refused()),
    };
    let span = last.checked_sub(first).ok_or_else(refused)?;
    let steps = span.checked_div(step).filter(|&s| s >= 0).ok_or_else(refused)?;
    let count = steps.unsigned_abs().saturating_add(1);
    let wrong_way = span != 0 && span.signum() != step.signum();
    if first < 0 || last < 0 || wrong_way {
        return Err(refused());
    }
    if count > MAX_DIM {
        return Err(NamesError::TooMany { found: count });
    }
    // Neither overflows: all lie between first and last.
    let names = (0..=steps).map(|i| format.name(first + i * step)).collect();
    Ok(FileList {
        names,
        dimensions,
        single: false,
    })
}

/// What stands around a number in a file's name, and how the number is written.
struct Format {
    before: String,
    after: String,
    width: usize,
    zeros: bool,
}

impl Format {
    fn parse(text: &str) -> Option<Self> {
        let (before, rest) = text.split_once('%')?;
        let letter = rest.find(|c: char| !c.is_ascii_digit())?;
        let (digits, rest) = rest.split_at(letter);
        let after = rest.strip_prefix(['d', 'i', 'u'])?;
        let width = if digits.is_empty() { 0 } else { digits.parse().ok()? };
        let plain = !after.contains('%') && width <= MAX_WIDTH;
        plain.then(|| Self {
            before: before.to_owned(),
            after: after.to_owned(),
            width,
            zeros: digits.starts_with('0'),
        })
    }

    fn name(&self, number: i64) -> String {
        let Self {
            before, after, width, ..
        } = self;
        if self.zeros {
            format!("{before}{number:0width$}{after}")
        } else {
            format!("{before}{number:width$}{after}")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_are_written_out() {
        let names = |text| FileList::parse(text).unwrap().names;
        assert_eq!(
            names("a%03d.raw 8 11 1"),
            ["a008.raw", "a009.raw", "a010.raw", "a011.raw"]
        );
        assert_eq!(names("%d 3 1 -1 2"), ["3", "2", "1"]);
        assert_eq!(names("x%i.gz 1 8 3"), ["x1.gz", "x4.gz", "x7.gz"]);
        assert_eq!(FileList::parse("a%d 1 2 1 2").unwrap().dimensions, Some(2));
        let spaces = FileList::parse("two words.raw").unwrap();
        assert!(spaces.single && spaces.names == ["two words.raw"]);
    }

    #[test]
    fn bad_patterns_are_refused() {
        for text in [
            "a%03d.raw",
            "a%03d.raw 1 4",
            "a%03d.raw 1 4 0",
            "a%03d.raw 1 4 -1",
            "a%03d.raw 1 4 x",
            "a%s.raw 1 4 1",
            "a%d%d.raw 1 4 1",
            "a%999d.raw 1 4 1",
            "a% 1 4 1",
            "a%d 1 2 3 4 5",
            "a%d -1 2 1",
            "a%d -9223372036854775808 9223372036854775807 1",
            "a%d 5 9223372036854775807 -9223372036854775808",
        ] {
            let error = FileList::parse(text).unwrap_err();
            assert!(matches!(error, NamesError::Pattern { .. }), "{text}: {error}");
        }
        let many = FileList::parse("a%d 1 9223372036854775807 1").unwrap_err();
        assert!(matches!(many, NamesError::TooMany { .. }), "{many}");
        assert_eq!(FileList::parse("").unwrap_err(), NamesError::Empty);
    }

    #[test]
    fn names_stay_inside_the_folder() {
        let path = |name: &str| FileList::parse(name).and_then(|list| list.paths(Path::new("/ct/a.nhdr")));
        assert_eq!(path("./a.raw").unwrap(), [Path::new("/ct/./a.raw")]);
        assert_eq!(path("sub/a.raw").unwrap(), [Path::new("/ct/sub/a.raw")]);
        for name in ["/etc/passwd", "../a.raw", "sub/../../a.raw"] {
            assert!(matches!(path(name), Err(NamesError::Outside { .. })), "{name}");
        }
        assert_eq!(path("."), Err(NamesError::Empty));
    }

    #[test]
    fn files_share_the_slices_evenly() {
        let share = |text: &str, slices| FileList::parse(text).unwrap().slices_per_file(slices, 3);
        assert_eq!(share("a.raw", 7), Ok(7));
        assert_eq!(share("a%d 1 7 1", 7), Ok(1));
        assert_eq!(share("a%d 1 3 1 3", 9), Ok(3));
        assert!(matches!(share("a%d 1 6 1", 7), Err(NamesError::Count { .. })));
        assert!(matches!(share("a%d 1 3 1 3", 7), Err(NamesError::Count { .. })));
        assert!(matches!(share("a%d 1 3 1 3", 0), Err(NamesError::Count { .. })));
        assert!(matches!(share("a%d 1 7 1 1", 7), Err(NamesError::Rows { .. })));
        assert!(matches!(share("a%d 1 7 1", -7), Err(NamesError::Count { .. })));
    }
}

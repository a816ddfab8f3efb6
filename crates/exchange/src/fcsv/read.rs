//! From the bytes of a file to points.

use std::str;

use super::row::columns;
use super::{COLUMNS, FcsvError, Fiducials, MAX_BYTES, MAX_POINTS};
use crate::named::named_in;
use crate::points::{largest, position};
use crate::units::{About, about, letters, unit_of, units_in};
use crate::{ControlPoint, LeftOut, LengthUnit, NamedAxes, NamedUnit, PatientAxes, Said, quoted, unmarked};

/// Columns of a point, and of one of Slicer 5.
const LENGTHS: [usize; 2] = [14, 16];

/// What the first lines say.
#[derive(Default)]
struct Head {
    version: Option<String>,
    axes: Option<PatientAxes>,
    /// Axes that are named in other comments.
    named: Vec<NamedAxes>,
    /// Units that are.
    units: Vec<NamedUnit>,
    columns: bool,
}

/// A line of a point, taken apart.
struct Row {
    line: usize,
    text: Vec<String>,
    components: [f64; 3],
}

/// Reads a file. `said` holds where the file does not say the same itself; its unit is mm.
///
/// # Errors
/// Each variant of [`FcsvError`] but the last. Nothing is taken of a file of which a line is refused.
pub fn read(bytes: &[u8], said: Said) -> Result<Fiducials, FcsvError> {
    if bytes.len() > MAX_BYTES {
        return Err(FcsvError::TooLong { bytes: bytes.len() });
    }
    let mut head = Head::default();
    let mut rows = Vec::new();
    let mut file = Fiducials::default();
    for (line, number) in unmarked(bytes).split(|byte| *byte == b'\n').zip(1..) {
        let text = str::from_utf8(line).map_err(|_| FcsvError::NotText { line: number })?;
        let text = without_returns(text).ok_or(FcsvError::LineEnd { line: number })?;
        match text.strip_prefix('#') {
            Some(comment) => head.take(number, comment)?,
            None if text.trim().is_empty() => {}
            None => match Row::of(number, &text)?.placed()? {
                Ok(row) => rows.push(row),
                Err(left) => file.left_out.push(left),
            },
        }
        if rows.len() > MAX_POINTS {
            return Err(FcsvError::TooMany { line: number });
        }
    }
    head.known_version()?;
    // Slicer goes by the places: a file that does not say its columns may be of others.
    if !head.columns {
        return Err(FcsvError::NoColumns);
    }
    let axes = said.axes_beside(head.axes, &head.named)?;
    said.unit_beside(None, &head.units)?;
    if rows.is_empty() {
        return Ok(file);
    }
    let most = largest(rows.iter().map(|row| &row.components));
    // The format has no word for its unit; Slicer's is mm.
    let scale = said.scale(None, [("the largest coordinate", most); 2])?;
    let points = rows.iter().map(|row| row.point(axes, scale));
    file.points = points.collect::<Result<_, _>>()?;
    Ok(file)
}

/// A line without carriage returns, which are at its end, and of Slicer 5 before a comma too; `None` where one stands elsewhere: then lines
/// end otherwise than is read here, and points would be lost among comments.
fn without_returns(line: &str) -> Option<String> {
    let line = line.trim_end_matches('\r');
    let is_comment = line.starts_with('#');
    let is_good = |(place, _): (usize, &str)| !is_comment && line[place + 1..].starts_with([',', '\r']);
    line.match_indices('\r').all(is_good).then(|| line.replace('\r', ""))
}

/// What a comment with a key, `Units = m`, says of units or axes and in no word that is read.
fn is_refused(comment: &str) -> Option<About> {
    let (key, value) = comment.split_once(['=', ':'])?;
    let is_read = |about: &About| match about {
        About::Unit => unit_of(value.trim()) == Some(LengthUnit::Millimetre),
        // Held against the axes that are taken.
        About::Axes => named_in(value).iter().any(|named| named.axes.is_some()),
    };
    about(key).filter(|about| !is_read(about))
}

impl Head {
    fn take(&mut self, line: usize, comment: &str) -> Result<(), FcsvError> {
        let halves = comment.split_once('=').map(|(key, value)| (letters(key), value.trim()));
        let (key, value) = halves.unwrap_or_default();
        let refused = |key, found, expected| {
            let found = quoted(found);
            Err(FcsvError::Head {
                line,
                key,
                found,
                expected,
            })
        };
        match key.as_str() {
            "markupsfiducialfileversion" if self.version.is_some() => refused("the version", value, "it once"),
            "markupsfiducialfileversion" => {
                self.version = Some(value.to_owned());
                Ok(())
            }
            "coordinatesystem" => match (PatientAxes::of_word(value), self.axes) {
                (Some(axes), None) => {
                    self.axes = Some(axes);
                    Ok(())
                }
                (Some(_), Some(_)) => refused("CoordinateSystem", value, "it once"),
                (None, _) => refused("CoordinateSystem", value, "0 or RAS, 1 or LPS"),
            },
            "columns" if self.columns => refused("columns", value, "them once"),
            // Slicer goes by the places and not by the names: another order would be read otherwise there than here.
            "columns" if value != COLUMNS => refused("columns", value, COLUMNS),
            "columns" => {
                self.columns = true;
                Ok(())
            }
            // What says the axes in a way that is not read must not be overruled.
            _ if letters(comment).contains("coordinatesystem") => {
                refused("a comment", comment, "# CoordinateSystem = 0, 1, RAS or LPS")
            }
            _ if is_refused(comment) == Some(About::Unit) => {
                refused("a comment", comment, "mm, which the format is in")
            }
            _ if is_refused(comment) == Some(About::Axes) => {
                refused("a comment", comment, "# CoordinateSystem = 0, 1, RAS or LPS")
            }
            // A name that begins with the sign of a comment makes a point one, and it would be lost.
            _ if columns(comment).is_some_and(|columns| LENGTHS.contains(&columns.len())) => {
                refused("a comment", comment, "no columns of a point behind #")
            }
            _ => {
                // Each once, however many comments there are.
                let axes = named_in(comment).into_iter();
                self.named
                    .extend(axes.filter(|axes| !self.named.contains(axes)).collect::<Vec<_>>());
                let units = units_in(comment).into_iter();
                self.units
                    .extend(units.filter(|unit| !self.units.contains(unit)).collect::<Vec<_>>());
                Ok(())
            }
        }
    }

    fn known_version(&self) -> Result<(), FcsvError> {
        let found = self.version.as_deref().unwrap_or("none");
        let major = found.split('.').next().and_then(|major| major.parse::<u32>().ok());
        match major {
            Some(4 | 5) => Ok(()),
            _ => Err(FcsvError::Version { found: quoted(found) }),
        }
    }
}

impl Row {
    fn of(line: usize, text: &str) -> Result<Self, FcsvError> {
        let text = columns(text).ok_or(FcsvError::Quote { line })?;
        let found = text.len();
        let has_numbers = text
            .iter()
            .skip(LENGTHS[0])
            .all(|extra| extra.trim().parse::<i64>().is_ok());
        if !LENGTHS.contains(&found) || !has_numbers {
            return Err(FcsvError::Columns { line, found });
        }
        Ok(Self {
            line,
            text,
            components: [0.0; 3],
        })
    }

    fn text(&self, place: usize) -> &str {
        self.text.get(place).map_or("", |text| text.trim())
    }

    fn bad(&self, place: usize, expected: &'static str) -> FcsvError {
        FcsvError::Value {
            line: self.line,
            column: COLUMNS.split(',').nth(place).unwrap_or("positionStatus"),
            found: quoted(self.text(place)),
            expected,
        }
    }

    /// With its components, or that it has none: Slicer 5 says so in the column after the last with a name.
    fn placed(mut self) -> Result<Result<Self, LeftOut>, FcsvError> {
        let status = match self.text(LENGTHS[0]) {
            "" | "2" => None,
            "0" => Some("undefined"),
            "1" => Some("preview"),
            "3" => Some("missing"),
            _ => return Err(self.bad(LENGTHS[0], "0 to 3")),
        };
        if let Some(status) = status {
            let label = self.text(11).to_owned();
            let status = status.to_owned();
            return Ok(Err(LeftOut { label, status }));
        }
        self.components = [self.number(1)?, self.number(2)?, self.number(3)?];
        // Passed over, but numbers: else the columns are not those that the head says.
        for place in 4..8 {
            self.number(place)?;
        }
        Ok(Ok(self))
    }

    fn number(&self, place: usize) -> Result<f64, FcsvError> {
        let number = self.text(place).parse::<f64>().ok().filter(|number| number.is_finite());
        number.ok_or_else(|| self.bad(place, "a finite number"))
    }

    fn flag(&self, place: usize) -> Result<bool, FcsvError> {
        match self.text(place) {
            "0" => Ok(false),
            "1" => Ok(true),
            _ => Err(self.bad(place, "0 or 1")),
        }
    }

    fn point(&self, axes: PatientAxes, scale: f64) -> Result<ControlPoint, FcsvError> {
        let finite = || self.bad(1, "a finite number");
        Ok(ControlPoint {
            id: self.text(0).to_owned(),
            label: self.text(11).to_owned(),
            description: self.text(12).to_owned(),
            associated_node: self.text(13).to_owned(),
            position: position(axes, scale, self.components).ok_or_else(finite)?,
            selected: self.flag(9)?,
            locked: self.flag(10)?,
            visible: self.flag(8)?,
        })
    }
}

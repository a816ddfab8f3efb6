//! From the bytes of a file to points.

use std::str;

use geometry::rotation::Rotation;

use super::row::columns;
use super::{COLUMNS, FcsvError, Fiducials, MAX_BYTES, MAX_POINTS};
use crate::points::{largest, orientation, position};
use crate::{ControlPoint, LeftOut, PatientAxes, Said, quoted};

/// Columns of a point, and of one of Slicer 5.
const LENGTHS: [usize; 2] = [14, 16];
/// How far from 1 the norm of a point's quaternion may be: three decimals.
const UNIT_TOLERANCE: f64 = 2e-3;

/// What the first lines say.
#[derive(Default)]
struct Head {
    version: Option<String>,
    axes: Option<PatientAxes>,
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
    for (line, number) in bytes.split(|byte| *byte == b'\n').zip(1..) {
        let text = str::from_utf8(line).map_err(|_| FcsvError::NotText { line: number })?;
        // A byte order mark is before the first line, and carriage returns are before the line's end, of Slicer 5
        // within it too.
        let text = text.trim_start_matches('\u{feff}').replace('\r', "");
        match text.strip_prefix('#') {
            Some(comment) => head.take(number, comment.trim())?,
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
    let axes = said.axes(head.axes)?;
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

impl Head {
    fn take(&mut self, line: usize, comment: &str) -> Result<(), FcsvError> {
        let Some((key, value)) = comment.split_once('=').map(|(key, value)| (key.trim(), value.trim())) else {
            return Ok(());
        };
        let refused = |key, expected| {
            let found = quoted(value);
            Err(FcsvError::Head {
                line,
                key,
                found,
                expected,
            })
        };
        match key {
            "Markups fiducial file version" if self.version.is_some() => refused("the version", "it once"),
            "Markups fiducial file version" => {
                self.version = Some(value.to_owned());
                Ok(())
            }
            "CoordinateSystem" => match (PatientAxes::of_word(value), self.axes) {
                (Some(axes), None) => {
                    self.axes = Some(axes);
                    Ok(())
                }
                (Some(_), Some(_)) => refused("CoordinateSystem", "it once"),
                (None, _) => refused("CoordinateSystem", "0 or RAS, 1 or LPS"),
            },
            // Slicer goes by the places and not by the names: another order would be read otherwise there than here.
            "columns" if value != COLUMNS => refused("columns", COLUMNS),
            "columns" => {
                self.columns = true;
                Ok(())
            }
            _ => Ok(()),
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
            orientation: self.orientation()?,
            selected: self.flag(9)?,
            locked: self.flag(10)?,
            visible: self.flag(8)?,
        })
    }

    /// `None` of the two patterns that writers put where they have nothing to say: all zeros, and `0,0,0,1`.
    fn orientation(&self) -> Result<Option<Rotation>, FcsvError> {
        let q = [self.number(4)?, self.number(5)?, self.number(6)?, self.number(7)?];
        if q[..3] == [0.0; 3] && (q[3] == 0.0 || q[3] == 1.0) {
            return Ok(None);
        }
        let bad = || self.bad(4, "ow, ox, oy, oz of norm 1, or 0,0,0,1 for none");
        let norm = q.iter().map(|c| c * c).sum::<f64>().sqrt();
        if (norm - 1.0).abs() > UNIT_TOLERANCE {
            return Err(bad());
        }
        let turn = Rotation::from_quaternion(q).map_err(|_| bad())?;
        // To RAS whatever the file's axes are.
        let rows = turn.matrix().rows();
        orientation(PatientAxes::Ras, rows).map(Some).map_err(|_| bad())
    }
}

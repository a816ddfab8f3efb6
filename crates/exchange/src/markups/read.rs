//! From the bytes of a file to markups.

use serde::Deserialize;
use serde_json::Value;

use super::rest::{PASSED_OVER, Rest, Taken, is_mm};
use super::{MAX_BYTES, MAX_POINTS, MAX_VALUES, Markup, MarkupKind, Markups, MarkupsError};
use crate::points::{largest, position};
use crate::{ControlPoint, LeftOut, LengthUnit, PatientAxes, Said, quoted, unmarked};

/// What every schema's address has before its version.
const SCHEMA: &str = "markups-schema-v1.0.";
/// The last number of the versions that are read.
const LATEST: u32 = 4;
/// Keys of a file, of a markup and of a point that are read.
const FILE: [&str; 2] = ["@schema", "markups"];
const MARKUP: [&str; 5] = ["type", "name", "coordinateSystem", "coordinateUnits", "controlPoints"];
const POINT: [&str; 9] = [
    "id",
    "label",
    "description",
    "associatedNodeID",
    "position",
    "selected",
    "locked",
    "visibility",
    "positionStatus",
];
/// Most keys that are named as left out.
const MOST_NAMED: usize = 32;

#[derive(Deserialize)]
#[serde(expecting = "an object with @schema and markups")]
struct RawFile {
    #[serde(rename = "@schema")]
    schema: String,
    markups: Vec<RawMarkup>,
    #[serde(flatten)]
    rest: Rest,
}

/// Written out, and not as a map, so that a key that is there twice is an error.
#[derive(Deserialize)]
#[serde(expecting = "an object with the keys of a markup")]
struct RawMarkup {
    #[serde(rename = "type")]
    kind: String,
    #[serde(default)]
    name: Option<String>,
    #[serde(default, rename = "coordinateSystem")]
    axes: Option<Value>,
    #[serde(default, rename = "coordinateUnits")]
    unit: Option<Value>,
    #[serde(default, rename = "controlPoints")]
    points: Vec<RawPoint>,
    #[serde(flatten)]
    rest: Rest,
}

#[derive(Deserialize)]
#[serde(expecting = "an object with the keys of a control point")]
struct RawPoint {
    #[serde(default)]
    id: Option<String>,
    #[serde(default)]
    label: Option<String>,
    #[serde(default)]
    description: Option<String>,
    #[serde(default, rename = "associatedNodeID")]
    associated_node: Option<String>,
    #[serde(default)]
    position: Value,
    #[serde(default)]
    selected: Option<bool>,
    #[serde(default)]
    locked: Option<bool>,
    #[serde(default, rename = "visibility")]
    visible: Option<bool>,
    #[serde(default, rename = "positionStatus")]
    status: Option<String>,
    #[serde(flatten)]
    rest: Rest,
}

/// Reads a file. `said` holds for each markup of it that does not say the same itself.
///
/// # Errors
/// Each variant of [`MarkupsError`]. Nothing is taken of a file of which a part is refused.
pub fn read(bytes: &[u8], said: Said) -> Result<Markups, MarkupsError> {
    if bytes.len() > MAX_BYTES {
        return Err(MarkupsError::TooLong { bytes: bytes.len() });
    }
    // Before anything is held: of three bytes a value of 32 can be made.
    let values = bytes.iter().filter(|byte| b",[{".contains(byte)).count();
    if values > MAX_VALUES {
        return Err(MarkupsError::TooManyValues { found: values });
    }
    let raw: RawFile = serde_json::from_slice(unmarked(bytes))?;
    known_schema(&raw.schema)?;
    let found = raw.markups.iter().map(|markup| markup.points.len()).sum();
    if found > MAX_POINTS {
        return Err(MarkupsError::TooMany { found });
    }
    let mut file = Markups::default();
    file.leave_out("the file", &raw.rest, &FILE)?;
    for (markup, number) in raw.markups.into_iter().zip(1..) {
        file.leave_out(&format!("markup {number}"), &markup.rest, &MARKUP)?;
        for (point, place) in markup.points.iter().zip(1..) {
            file.leave_out(&format!("point {place} of markup {number}"), &point.rest, &POINT)?;
        }
        let taken = markup.taken(number, said)?;
        raw.rest.agree("the file", taken)?;
        markup.rest.agree(&format!("markup {number}"), taken)?;
        for (point, place) in markup.points.iter().zip(1..) {
            point.rest.agree(&format!("point {place} of markup {number}"), taken)?;
        }
        file.markups.push(markup.checked(number, said, taken.axes)?);
    }
    Ok(file)
}

impl Markups {
    /// Names what is left out; a key that is one of the schema's but for its letters is refused, as it says what is read elsewhere.
    fn leave_out(&mut self, place: &str, rest: &Rest, known: &[&'static str]) -> Result<(), MarkupsError> {
        for key in rest.keys() {
            let mut all = known.iter().chain(&PASSED_OVER);
            if let Some(known) = all.find(|known| known.eq_ignore_ascii_case(key)) {
                let (place, found) = (place.to_owned(), quoted(key));
                return Err(MarkupsError::Key { place, found, known });
            }
            let name = quoted(key);
            if self.left_out_keys.len() < MOST_NAMED && !self.left_out_keys.contains(&name) {
                self.left_out_keys.push(name);
            }
        }
        Ok(())
    }
}

fn known_schema(found: &str) -> Result<(), MarkupsError> {
    // Slicer itself compares without regard to case.
    let lower = found.to_ascii_lowercase();
    let version = lower.split_once(SCHEMA).and_then(|(_, rest)| rest.split_once(".json"));
    let known = version.and_then(|(number, _)| number.parse::<u32>().ok());
    match known.is_some_and(|number| number <= LATEST) {
        true => Ok(()),
        false => Err(MarkupsError::Schema { found: quoted(found) }),
    }
}

impl RawMarkup {
    /// Its axes and its unit.
    fn taken(&self, markup: usize, said: Said) -> Result<Taken, MarkupsError> {
        let stated = stated_axes(markup, self.axes.as_ref())?;
        let axes = said.axes(stated);
        let unit = stated_unit(markup, self.unit.as_ref())?;
        Ok(Taken {
            axes: axes.map_err(|why| MarkupsError::Unsettled { markup, why })?,
            unit: said.unit.or(unit).unwrap_or(LengthUnit::Millimetre),
        })
    }

    fn checked(self, markup: usize, said: Said, axes: PatientAxes) -> Result<Markup, MarkupsError> {
        let kind = MarkupKind::ALL.into_iter().find(|kind| kind.name() == self.kind);
        let found = || quoted(&self.kind);
        let kind = kind.ok_or_else(|| MarkupsError::Kind { markup, found: found() })?;
        let unit = stated_unit(markup, self.unit.as_ref())?;
        let unsettled = |why| MarkupsError::Unsettled { markup, why };
        let mut placed = Vec::new();
        let mut left_out = Vec::new();
        for (point, number) in self.points.iter().zip(1..) {
            match point.placed([markup, number])? {
                Ok(components) => placed.push((point, number, components)),
                Err(left) => left_out.push(left),
            }
        }
        let mut scale = 1.0;
        if !placed.is_empty() {
            let most = largest(placed.iter().map(|(_, _, components)| components));
            let sizes = [("the largest coordinate", most); 2];
            scale = said.scale(unit, sizes).map_err(unsettled)?;
        }
        let point = |(point, number, components): &(&RawPoint, usize, [f64; 3])| {
            point.checked([markup, *number], (axes, scale), *components)
        };
        let points = placed.iter().map(point).collect::<Result<Vec<_>, _>>()?;
        Ok(Markup {
            kind,
            name: self.name.unwrap_or_default(),
            points,
            left_out,
        })
    }
}

fn stated_axes(markup: usize, found: Option<&Value>) -> Result<Option<PatientAxes>, MarkupsError> {
    let Some(found) = found else { return Ok(None) };
    // The number stands for the word in files of before the schema's first version.
    let word = found.as_str().map_or_else(|| found.to_string(), str::to_owned);
    let found = || quoted(&found.to_string());
    let axes = PatientAxes::of_word(&word).ok_or_else(|| MarkupsError::Axes { markup, found: found() })?;
    Ok(Some(axes))
}

/// A unit as its code, or as code, coding scheme and meaning.
fn stated_unit(markup: usize, found: Option<&Value>) -> Result<Option<LengthUnit>, MarkupsError> {
    let Some(found) = found else { return Ok(None) };
    match is_mm(found) {
        true => Ok(Some(LengthUnit::Millimetre)),
        false => {
            let found = quoted(&found.to_string());
            Err(MarkupsError::Unit { markup, found })
        }
    }
}

impl RawPoint {
    fn bad(&self, [markup, point]: [usize; 2], key: &'static str, found: &str, expected: &str) -> MarkupsError {
        MarkupsError::Point {
            markup,
            point,
            label: quoted(self.label.as_deref().unwrap_or_default()),
            key,
            found: quoted(found),
            expected: expected.to_owned(),
        }
    }

    /// Its components in the file's own axes and unit, or that it has none.
    fn placed(&self, at: [usize; 2]) -> Result<Result<[f64; 3], LeftOut>, MarkupsError> {
        let status = self.status.as_deref().unwrap_or("defined");
        match status {
            "defined" => {
                let expected = "three numbers, or a positionStatus that says there are none";
                let components = numbers(&self.position);
                components
                    .map(Ok)
                    .ok_or_else(|| self.bad(at, "position", &self.position.to_string(), expected))
            }
            "undefined" | "preview" | "missing" => Ok(Err(LeftOut {
                label: self.label.clone().unwrap_or_default(),
                status: status.to_owned(),
            })),
            other => Err(self.bad(at, "positionStatus", other, "defined, undefined, preview or missing")),
        }
    }

    fn checked(
        &self,
        at: [usize; 2],
        (axes, scale): (PatientAxes, f64),
        components: [f64; 3],
    ) -> Result<ControlPoint, MarkupsError> {
        let not_finite = || self.bad(at, "position", &format!("{components:?}"), "finite numbers");
        let text = |text: &Option<String>| text.clone().unwrap_or_default();
        Ok(ControlPoint {
            id: text(&self.id),
            label: text(&self.label),
            description: text(&self.description),
            associated_node: text(&self.associated_node),
            position: position(axes, scale, components).ok_or_else(not_finite)?,
            selected: self.selected.unwrap_or(true),
            locked: self.locked.unwrap_or(false),
            visible: self.visible.unwrap_or(true),
        })
    }
}

/// So many numbers and nothing else.
fn numbers<const N: usize>(value: &Value) -> Option<[f64; N]> {
    let numbers: Option<Vec<f64>> = value.as_array()?.iter().map(Value::as_f64).collect();
    numbers?.try_into().ok()
}
